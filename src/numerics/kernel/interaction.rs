//! Interaction of contact surfaces: pressure-overclosure relation, friction, heat exchange.

use std::sync::Arc;

/// Pressure over overclosure (ABAQUS Analysis User's Guide, "Contact pressure-overclosure relationships").
#[derive(Clone, Debug, Default, PartialEq)]
pub enum PressureOverclosure {
    /// No overclosure at any pressure.
    #[default]
    Hard,
    /// Pressure per length of overclosure.
    Linear(f64),
    /// Pressure per length of overclosure of a penalty spring; the overclosure is taken at mid-increment.
    Spring(f64),
    /// Pressure p0 at zero gap, and gap c at which pressure begins: p = p0/(e - 1) ((h/c + 1)(exp(h/c + 1) - 1)) for
    /// overclosures h above -c.
    Exponential([f64; 2]),
    /// Rows of pressure and overclosure, ascending; the last slope continues.
    Table(Vec<[f64; 2]>),
}

/// Exponent above which the exponential relationship continues along its tangent, so that trial values of an iteration
/// are finite.
const LARGEST_EXPONENT: f64 = 100.0;
/// Number of bisections for the overclosure of an energy.
const BISECTIONS: usize = 52;

impl PressureOverclosure {
    /// Returns the fraction t of the next increment at whose end the overclosure is evaluated, from the overclosure at its
    /// start. With t = 1, no slope limits the increment and oscillations are damped most. t = 1/2 is the smallest value
    /// that is stable for any slope s: x(n+1) - 2 x(n) + x(n-1) = -s ((1 - t) x(n) + t x(n+1)) has no growing root if
    /// (1 - 2 t) s <= 4. While a spring is closed, its work with t = 1/2 is the change of its energy; where it closes, it
    /// would be less. Equation (10.8).
    pub fn evaluation_point(&self, at_start: f64) -> f64 {
        if matches!(self, PressureOverclosure::Spring(_)) && at_start >= 0.0 { 0.5 } else { 1.0 }
    }

    /// Returns the gap at which pressure begins.
    pub fn onset_gap(&self) -> f64 {
        match self {
            PressureOverclosure::Hard | PressureOverclosure::Linear(_) | PressureOverclosure::Spring(_) => 0.0,
            PressureOverclosure::Exponential([_, gap]) => *gap,
            PressureOverclosure::Table(rows) => rows.first().map_or(0.0, |row| -row[1]),
        }
    }

    /// Returns a linearization at an overclosure, as value and slope: the tangent, or, where the pressure is zero, the
    /// initial line extended to negative pressures. The slope is zero only for hard contact and incomplete tables.
    pub fn linearized(&self, overlap: f64) -> [f64; 2] {
        let tangent = self.pressure(overlap);
        if tangent[1] > 0.0 {
            return tangent;
        }
        let slope = match self {
            PressureOverclosure::Hard => return tangent,
            PressureOverclosure::Linear(stiffness) | PressureOverclosure::Spring(stiffness) => *stiffness,
            PressureOverclosure::Exponential([at_zero, gap]) => at_zero / gap,
            PressureOverclosure::Table(rows) => match rows[..] {
                [first, second, ..] => (second[0] - first[0]) / (second[1] - first[1]),
                _ => return tangent,
            },
        };
        [slope * (overlap + self.onset_gap()), slope]
    }

    /// Returns the energy per area at an overclosure: the integral of the pressure over the overclosure. Equation
    /// (10.11).
    pub fn energy(&self, overlap: f64) -> f64 {
        match self {
            PressureOverclosure::Hard => 0.0,
            PressureOverclosure::Linear(stiffness) | PressureOverclosure::Spring(stiffness) => {
                0.5 * stiffness * overlap.max(0.0) * overlap.max(0.0)
            }
            PressureOverclosure::Exponential([at_zero, gap]) => {
                let x = (overlap / gap + 1.0).max(0.0);
                let factor = at_zero * gap / (std::f64::consts::E - 1.0);
                factor * ((x - 1.0) * libm::exp(x) + 1.0 - 0.5 * x * x)
            }
            PressureOverclosure::Table(rows) => {
                let ends = rows.windows(2).enumerate().map(|(at, row)| (at + 2 == rows.len(), row[0][1], row[1][1]));
                let parts = ends.map(|(is_last, from, to)| {
                    let until = if is_last { overlap } else { to.min(overlap) };
                    let pressures = self.pressure(from)[0] + self.pressure(until)[0];
                    0.5 * pressures * (until - from).max(0.0)
                });
                parts.sum()
            }
        }
    }

    /// Returns the change of a weighted gap, per area, if the area of a point with the mean overclosure `mean` grows at an
    /// edge with the overclosure `at_edge`. With the pressure of the mean, this change does the work `W(at_edge)` per area.
    /// Equation (10.12).
    pub fn change_by_cover(&self, mean: f64, at_edge: f64) -> f64 {
        let ([pressure, _], whole) = (self.pressure(mean), at_edge + self.onset_gap());
        if pressure > 0.0 { -(self.energy(at_edge) / pressure).min(whole) } else { -whole }
    }

    /// Returns the overclosure of an energy per area that is at most that of the overclosure `most`.
    pub fn overlap_of_energy(&self, energy: f64, most: f64) -> f64 {
        if let PressureOverclosure::Linear(stiffness) | PressureOverclosure::Spring(stiffness) = self {
            return (2.0 * energy / stiffness).sqrt().min(most);
        }
        let (mut low, mut high) = (-self.onset_gap(), most);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if self.energy(middle) > energy {
                high = middle;
            } else {
                low = middle;
            }
        }
        low
    }

    /// Returns the pressure at an overclosure, and its derivative.
    pub fn pressure(&self, overlap: f64) -> [f64; 2] {
        match self {
            PressureOverclosure::Hard => [0.0, 0.0],
            PressureOverclosure::Linear(stiffness) | PressureOverclosure::Spring(stiffness) if overlap > 0.0 => {
                [stiffness * overlap, *stiffness]
            }
            PressureOverclosure::Linear(_) | PressureOverclosure::Spring(_) => [0.0, 0.0],
            PressureOverclosure::Exponential([at_zero, gap]) => {
                let x = overlap / gap + 1.0;
                if x <= 0.0 {
                    return [0.0, 0.0];
                }
                let (factor, within) = (at_zero / (std::f64::consts::E - 1.0), x.min(LARGEST_EXPONENT));
                let grown = libm::exp(within);
                let slope = factor * (grown - 1.0 + within * grown) / gap;
                [factor * within * (grown - 1.0) + slope * gap * (x - within), slope]
            }
            PressureOverclosure::Table(rows) => tabulated(rows, overlap),
        }
    }
}

fn tabulated(rows: &[[f64; 2]], overlap: f64) -> [f64; 2] {
    let [Some(first), Some(_)] = [rows.first(), rows.get(1)] else { return [0.0, 0.0] };
    if overlap <= first[1] {
        return [0.0, 0.0];
    }
    let next = rows.partition_point(|row| row[1] < overlap).clamp(1, rows.len() - 1);
    let ([p, h], [q, k]) = (rows[next - 1], rows[next]);
    let slope = (q - p) / (k - h);
    [p + slope * (overlap - h), slope]
}

/// Coulomb friction, with a coefficient that may decay with the slip rate (ABAQUS Analysis User's Guide, "Frictional
/// behavior").
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoulombFriction {
    /// Static coefficient, and the only coefficient if there is no decay.
    pub at_rest: f64,
    /// Kinetic coefficient, at high slip rates.
    pub sliding: f64,
    /// Decay constant, time per length.
    pub decay: f64,
    /// Largest shear stress (`TAUMAX`).
    pub largest: f64,
    /// Share of a quick change of the slip rate that damping removes at a point in an increment; 0 without damping.
    pub damping: f64,
}

/// Default damping of frictional flutter. It keeps the friction force of tubes on 2x50 to 4x200 elements within 0.5 % up
/// to a coefficient of 0.2.
pub const SLIP_DAMPING: f64 = 0.5;

impl Default for CoulombFriction {
    fn default() -> Self {
        CoulombFriction::of(0.0)
    }
}

impl CoulombFriction {
    /// Creates friction with a constant coefficient.
    pub fn of(coefficient: f64) -> CoulombFriction {
        CoulombFriction {
            at_rest: coefficient,
            sliding: coefficient,
            decay: 0.0,
            largest: f64::INFINITY,
            damping: SLIP_DAMPING,
        }
    }

    /// Returns whether there is friction.
    pub fn is_active(&self) -> bool {
        self.at_rest > 0.0 || self.sliding > 0.0
    }

    /// Returns whether slip is damped; bodies that cannot slip need no damping.
    pub fn damps(&self) -> bool {
        self.is_active() && self.at_rest.is_finite() && self.damping > 0.0
    }

    /// Returns the coefficient at a slip rate. Equation (10.5).
    pub fn coefficient(&self, rate: f64) -> f64 {
        if self.decay == 0.0 {
            return self.at_rest;
        }
        self.sliding + (self.at_rest - self.sliding) * libm::exp(-self.decay * rate)
    }
}

/// Friction by a user subroutine.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionRoutine {
    /// Name of the surface interaction, upper case.
    pub interaction: String,
    /// Constants that the subroutine receives.
    pub properties: Vec<f64>,
    /// Number of state variables of a point.
    pub variables: usize,
}

/// Damping of soft contact while the surfaces overlap (ABAQUS Analysis User's Guide, "Contact damping").
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ContactDamping {
    /// Pressure per closing velocity.
    Coefficient(f64),
    /// Fraction of the critical damping of the masses in contact on the contact stiffness.
    CriticalFraction(f64),
}

impl ContactDamping {
    /// Returns the given value.
    pub fn value(self) -> f64 {
        match self {
            ContactDamping::Coefficient(value) | ContactDamping::CriticalFraction(value) => value,
        }
    }

    /// Returns the pressure per closing velocity for a contact stiffness and a mass, each per area.
    pub fn coefficient(self, stiffness: f64, mass: f64) -> f64 {
        match self {
            ContactDamping::Coefficient(coefficient) => coefficient,
            ContactDamping::CriticalFraction(fraction) => 2.0 * fraction * (stiffness * mass).sqrt(),
        }
    }
}

/// Mechanical and thermal interaction of two surfaces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InteractionLaw {
    /// Normal behaviour.
    pub overclosure: PressureOverclosure,
    /// Damping of the normal motion in soft contact.
    pub damping: Option<ContactDamping>,
    /// Tangential behaviour.
    pub friction: CoulombFriction,
    /// User subroutine that sets the friction coefficient of each point in each increment; `friction` is then without a limit.
    pub friction_routine: Option<Arc<FrictionRoutine>>,
    /// Thermal behaviour.
    pub heat: GapHeat,
}

impl InteractionLaw {
    /// Returns whether surfaces in contact overlap.
    pub fn is_soft(&self) -> bool {
        self.overclosure != PressureOverclosure::Hard
    }

    /// Returns the law without friction.
    pub fn without_friction(&self) -> InteractionLaw {
        InteractionLaw { friction: CoulombFriction::default(), friction_routine: None, ..self.clone() }
    }
}

/// Heat exchange between contact surfaces (ABAQUS Analysis User's Guide, "Thermal contact properties").
#[derive(Clone, Debug, PartialEq)]
pub struct GapHeat {
    /// Rows of conductance (heat per time, area and temperature) and clearance, ascending; zero beyond the last row.
    pub over_clearance: Vec<[f64; 2]>,
    /// Rows of conductance and contact pressure, ascending; constant beyond the last row.
    pub over_pressure: Vec<[f64; 2]>,
    /// Fraction of the frictional work that becomes heat.
    pub fraction: f64,
    /// Fraction of this heat that enters the first surface.
    pub to_first: f64,
}

impl Default for GapHeat {
    fn default() -> Self {
        GapHeat { over_clearance: Vec::new(), over_pressure: Vec::new(), fraction: 1.0, to_first: 0.5 }
    }
}

impl GapHeat {
    /// Returns the conductance at a clearance and a contact pressure.
    pub fn conductance(&self, gap: f64, pressure: f64) -> f64 {
        if pressure > 0.0 && !self.over_pressure.is_empty() {
            return between(&self.over_pressure, pressure);
        }
        match self.over_clearance.last() {
            Some(last) if gap <= last[1] => between(&self.over_clearance, gap),
            _ => 0.0,
        }
    }

    /// Returns the largest possible conductance.
    pub fn largest_conductance(&self) -> f64 {
        self.over_clearance.iter().chain(&self.over_pressure).map(|row| row[0]).fold(0.0, f64::max)
    }
}

/// Interpolates rows of a value and its ascending argument; constant beyond the ends.
fn between(rows: &[[f64; 2]], at: f64) -> f64 {
    let next = rows.partition_point(|row| row[1] < at);
    match (next.checked_sub(1).map(|i| rows[i]), rows.get(next)) {
        (Some([k, x]), Some([l, y])) => k + (l - k) * (at - x) / (y - x),
        (Some([k, _]), None) => k,
        (None, first) => first.map_or(0.0, |row| row[0]),
    }
}

#[cfg(test)]
mod tests {
    use super::GapHeat;

    /// Linear between rows, constant before the first; beyond the last row zero over the clearance and constant over
    /// the pressure, which applies to closed gaps.
    #[test]
    fn conductance_follows_its_rows() {
        let over_clearance = vec![[4.0, 0.0], [2.0, 0.1], [1.0, 0.3]];
        let open = GapHeat { over_clearance, ..GapHeat::default() };
        for (gap, expected) in [(-1.0, 4.0), (0.0, 4.0), (0.05, 3.0), (0.1, 2.0), (0.2, 1.5), (0.3, 1.0), (0.31, 0.0)] {
            assert!((open.conductance(gap, 0.0) - expected).abs() < 1e-15, "{gap}");
            assert_eq!(open.conductance(gap, 5.0), open.conductance(gap, 0.0));
        }
        let both = GapHeat { over_pressure: vec![[5.0, 0.0], [9.0, 2.0]], ..open };
        assert_eq!([0.0, 1.0, 9.0].map(|p| both.conductance(0.0, p)), [4.0, 7.0, 9.0]);
        assert_eq!(both.largest_conductance(), 9.0);
    }
}
