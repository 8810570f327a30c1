//! Modified Drucker-Prager/cap plasticity (ABAQUS Analysis User's Guide, "Modified Drucker-Prager/Cap model"), with the
//! von Mises stress q as the measure of the deviator (K = 1).

use super::law::{ReturnPoint, StressReturn};
use super::root::{Start, nearby_state};
use crate::kernel::hardening::{LinearTable, TableLine};
use crate::kernel::moduli::ElasticModuli;
use crate::variables::{Variable, VariableComponent};

/// Soil or powder that shears along a line of failure and compacts along an elliptical cap.
#[derive(Clone, Debug)]
pub struct CapPlasticity {
    /// Cohesion d: von Mises stress of the failure surface without pressure, stress.
    pub cohesion: f64,
    /// Friction: tan(beta).
    pub friction: f64,
    /// Eccentricity R of the cap: its half axis along the pressure over that along q, without transition.
    pub eccentricity: f64,
    /// Size alpha of the transition between failure surface and cap; zero without transition.
    pub transition: f64,
    /// Plastic volume compaction at the start; the first abscissa of the table if this is zero or below it.
    pub compaction: f64,
    /// Hydrostatic yield pressure pb over plastic volume compaction, increasing.
    pub hardening: LinearTable,
    /// Elastic moduli.
    pub moduli: ElasticModuli,
}

/// Part of the yield surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Surface {
    Failure,
    Cap,
    Transition,
}

/// Point of the yield surface at a pressure.
#[derive(Clone, Copy)]
struct CapPoint {
    surface: Surface,
    /// Von Mises stress.
    mises: f64,
    /// Slope of the flow potential by pressure over that by von Mises stress, times `mises`: finite everywhere.
    slope: f64,
}

/// Constants of the yield surface.
#[derive(Clone, Copy)]
struct CapShape {
    tangent: f64,
    cohesion: f64,
    eccentricity: f64,
    /// Pressure pa at the top of the cap for the hydrostatic yield pressure pb: first part plus second part times pb.
    /// Equation (20.11).
    centre: [f64; 2],
    alpha: f64,
    /// Length of the arc of the transition along the pressure over its radius.
    arc: f64,
    /// Height of the centre of the arc over that of the failure line.
    rise: f64,
    /// m/R, and (m tan(beta))².
    ratio: f64,
    flow: f64,
}

impl CapShape {
    /// Returns the point of the yield surface at a pressure and a yield pressure pb. Equation (20.11). Equation (20.12).
    /// The region below the arc of the transition is elastic: the lower half of that circle is no part of the surface.
    fn at(&self, pressure: f64, yield_pressure: f64) -> CapPoint {
        let centre = self.centre[0] + self.centre[1] * yield_pressure;
        let height = self.cohesion + centre * self.tangent; // c
        let distance = pressure - centre;
        if distance > 0.0 {
            let axis = self.eccentricity * height;
            let mises = self.ratio * (axis * axis - distance * distance).max(0.0).sqrt();
            return CapPoint { surface: Surface::Cap, mises, slope: self.ratio * self.ratio * distance };
        }
        let slope = self.flow * distance;
        if distance <= -self.arc * height {
            let mises = (self.cohesion + pressure * self.tangent).max(0.0);
            return CapPoint { surface: Surface::Failure, mises, slope };
        }
        let radius = self.alpha * height;
        let rise = (radius * radius - distance * distance).max(0.0).sqrt();
        CapPoint { surface: Surface::Transition, mises: self.rise * height + rise, slope }
    }
}

/// States: equivalent plastic strain; that of each surface; plastic volume compaction since the start.
const STRAIN: usize = 0;
const SURFACES: usize = 1;
const COMPACTION: usize = 4;

impl CapPlasticity {
    /// Returns the pressure of the tip of the failure surface, where q is zero.
    fn apex(&self) -> f64 {
        if self.friction > 0.0 { -self.cohesion / self.friction } else { f64::NEG_INFINITY }
    }

    /// Returns the constants of the yield surface.
    fn shape(&self) -> CapShape {
        let (tangent, alpha) = (self.friction, self.transition);
        let secant = (1.0 + tangent * tangent).sqrt(); // 1/cos(beta)
        let shape = 1.0 + alpha - alpha * secant; // m
        let per_height = 1.0 / (1.0 + self.eccentricity * tangent);
        CapShape {
            tangent,
            cohesion: self.cohesion,
            eccentricity: self.eccentricity,
            centre: [-self.eccentricity * self.cohesion * per_height, per_height],
            alpha,
            arc: alpha * tangent / secant,
            rise: 1.0 - alpha * secant,
            ratio: shape / self.eccentricity,
            flow: (shape * tangent) * (shape * tangent),
        }
    }

    /// Returns the pressure p = `factor` pb + `offset` at which the compaction is that of the elastic path, exactly.
    fn pressure_of(
        &self,
        trial: f64,
        (compaction_before, line): (f64, TableLine<'_>),
        factor: f64,
        offset: f64,
    ) -> f64 {
        let bulk = self.moduli.bulk;
        // On the line of the table around the compaction before, if the end is there.
        let near = (factor * (line.value + line.slope * trial / bulk) + offset) / (1.0 + factor * line.slope / bulk);
        if line.holds_at(compaction_before + (trial - near) / bulk) {
            return near;
        }
        let surface = |row: [f64; 2]| factor * row[0] + offset;
        // How far the elastic path is above the surface when the compaction is that of a row.
        let excess = |row: [f64; 2]| trial - bulk * (row[1] - compaction_before) - surface(row);
        let rows = &self.hardening.rows;
        let next = rows.partition_point(|&row| excess(row) > 0.0);
        match (next.checked_sub(1).map(|i| rows[i]), rows.get(next)) {
            (Some(low), Some(&high)) => {
                let [above, below] = [excess(low), excess(high)];
                surface(low) + (surface(high) - surface(low)) * above / (above - below)
            }
            (Some(row), None) | (None, Some(&row)) => surface(row),
            (None, None) => trial,
        }
    }
}

impl StressReturn for CapPlasticity {
    fn describe(&self) -> String {
        "Drucker-Prager with cap".to_owned()
    }

    fn moduli(&self) -> ElasticModuli {
        self.moduli
    }

    fn initial_state(&self) -> Vec<f64> {
        vec![0.0; COMPACTION + 1]
    }

    /// Components 0 to 2 of [`Variable::CapStrain`] are the equivalent plastic strains of failure surface, cap and
    /// transition, component 3 is the plastic volume strain since the start, positive in compaction.
    fn output(&self, part: VariableComponent) -> Option<usize> {
        match part.variable {
            Variable::PlasticStrain => Some(STRAIN),
            Variable::CapStrain if part.component < 4 => Some(SURFACES + part.component),
            _ => None,
        }
    }

    /// Equation (20.13).
    fn update(&self, point: &mut ReturnPoint<'_>) {
        let ElasticModuli { bulk, shear } = self.moduli;
        let trial = point.trial;
        let first = self.hardening.rows.first().map_or(0.0, |row| row[1]);
        let initial = if self.compaction == 0.0 { first } else { self.compaction.max(first) };
        let compaction_before = initial + point.state[COMPACTION];
        let hardening = self.hardening.line(compaction_before);
        let (shape, yield_before) = (self.shape(), hardening.value);
        let at_trial = shape.at(trial.pressure, yield_before);
        let inside = trial.mises <= at_trial.mises * (1.0 + 1e-12)
            && trial.pressure <= yield_before * (1.0 + 1e-12)
            && trial.pressure >= self.apex();
        // A NaN is not returned, so that the run halts.
        if inside || trial.mises.is_nan() {
            return point.stay_elastic();
        }
        // The plastic dilation follows from the pressure at the end; so do the yield surface and the flow there.
        let per_bulk = 1.0 / bulk;
        let surface = |pressure: f64| {
            shape.at(pressure, hardening.at(compaction_before + (trial.pressure - pressure) * per_bulk))
        };
        let mismatch = |pressure: f64| {
            let end = surface(pressure);
            let CapPoint { mises, slope, .. } = end;
            (3.0 * shear * (trial.pressure - pressure) * mises - bulk * (trial.mises - mises) * slope, end)
        };
        let centre = self.pressure_of(trial.pressure, (compaction_before, hardening), shape.centre[1], shape.centre[0]);
        let size = trial.mises + trial.pressure.abs() + yield_before;
        let tolerance = 1e-9 * (bulk + shear) * size * size;
        // Positive mismatch: flow to lower pressure is too weak. No flow changes the volume at the centre of the cap.
        let compacts = trial.pressure > centre;
        let start = if compacts {
            self.pressure_of(trial.pressure, (compaction_before, hardening), 1.0, 0.0).min(trial.pressure)
        } else {
            trial.pressure.max(self.apex())
        };
        let sign = if compacts { -1.0 } else { 1.0 };
        // The linear flow rule at the trial.
        let ratio = bulk * at_trial.slope / (3.0 * shear * at_trial.mises);
        let rise = if at_trial.surface == Surface::Failure { self.friction } else { -at_trial.slope / at_trial.mises };
        let guess = trial.pressure - ratio * (trial.mises - at_trial.mises) / (1.0 - rise * ratio);
        let first = if start == trial.pressure {
            bulk * (at_trial.mises - trial.mises) * at_trial.slope
        } else {
            mismatch(start).0
        };
        let start = Start { start, first: sign * first, guess };
        let outside = |pressure: f64| {
            let (value, end) = mismatch(pressure);
            (sign * value, end)
        };
        let (pressure, end) =
            nearby_state(start, centre, tolerance, outside).unwrap_or_else(|| (centre, surface(centre)));
        let mises = end.mises.min(trial.mises);
        let strain = (trial.mises - mises) / (3.0 * shear);
        point.state[STRAIN] += strain;
        point.state[SURFACES + end.surface as usize] += strain;
        point.state[COMPACTION] += (trial.pressure - pressure) / bulk;
        point.return_to(pressure, mises, (pressure - trial.pressure) / bulk);
    }
}

#[cfg(test)]
mod tests {
    use super::super::law::TrialStress;
    use super::*;

    fn soil() -> CapPlasticity {
        let hardening = LinearTable { rows: vec![[0.4, 0.0], [3.0, 0.02], [20.0, 0.06], [90.0, 0.12]] };
        let moduli = ElasticModuli::from_young(700.0, 0.25);
        CapPlasticity {
            cohesion: 0.2,
            friction: 0.9,
            eccentricity: 0.5,
            transition: 0.04,
            compaction: 0.0,
            hardening,
            moduli,
        }
    }

    /// Applies a strain increment; returns the stress.
    fn strained(law: &CapPlasticity, state: &mut [f64], carried: [f64; 4], strain: [f64; 4]) -> [f64; 4] {
        let mut point = ReturnPoint::new(strain, carried, state, law.moduli);
        law.update(&mut point);
        point.stress
    }

    /// Hydrostatic compaction follows p = pb(ev), ev = -ln J - p/K; unloading to zero pressure is elastic.
    #[test]
    fn hydrostatic_pressure_is_the_table() {
        let law = soil();
        for steps in [1, 7, 300] {
            let (mut state, mut stress) = (law.initial_state(), [0.0; 4]);
            let step = -0.03 / f64::from(steps);
            for _ in 0..steps {
                stress = strained(&law, &mut state, stress, [step, step, step, 0.0]);
            }
            let (pressure, compaction) = (-stress[0], state[COMPACTION]);
            assert!((pressure / law.hardening.value(compaction) - 1.0).abs() < 1e-12, "{pressure}");
            assert!((0.09 - pressure / law.moduli.bulk - compaction).abs() < 1e-13);
            let back = pressure / (3.0 * law.moduli.bulk) / f64::from(steps);
            for _ in 0..steps {
                stress = strained(&law, &mut state, stress, [back, back, back, 0.0]);
            }
            assert!(stress[0].abs() < 1e-12 * pressure && state[COMPACTION] == compaction);
        }
    }

    /// Any increment ends on the yield surface or inside, with flow away from it.
    #[test]
    fn large_increments_end_on_the_surface() {
        let law = soil();
        for [volume, shear] in [[-0.3, 0.1], [-0.05, 0.3], [0.4, 0.2], [0.3, 0.0], [0.0, 2.0], [-3.0, 5.0]] {
            let mut state = law.initial_state();
            state[COMPACTION] = 0.05;
            let stress = strained(&law, &mut state, [-4.0, -5.0, -4.0, 0.0], [volume, volume, volume, shear]);
            let end = TrialStress::of(stress);
            let limit = law.shape().at(end.pressure, law.hardening.value(state[COMPACTION])).mises;
            assert!((end.mises - limit).abs() < 1e-9 * (1.0 + limit), "{volume} {shear}: {} {limit}", end.mises);
            assert!(end.pressure >= law.apex() && state[STRAIN] >= 0.0);
        }
    }
}
