//! Return of an effective trial stress to the yield surface of concrete damaged plasticity.

use super::concrete_tables::{ConcreteStrength, ConcreteTable};
use super::law::TrialStress;
use super::root::bracketed_root;
use crate::kernel::lanes::InlineMap;

/// Returns the share of tension r of principal stresses, between 0 and 1; 0 without stress (Lee and Fenves 1998).
/// Equation (20.16).
pub fn tension_share(principal: [f64; 3]) -> f64 {
    let [positive, sum] =
        [|s: f64| s.max(0.0), f64::abs].inline_map(|of| of(principal[0]) + of(principal[1]) + of(principal[2]));
    if sum > 0.0 { positive / sum } else { 0.0 }
}

/// Returns the principal stresses, ascending, without the branches of a sort.
#[inline]
pub fn principal([rr, zz, hoop, rz]: [f64; 4]) -> [f64; 3] {
    let (centre, radius) = (0.5 * (rr + zz), (0.25 * (rr - zz) * (rr - zz) + rz * rz).sqrt());
    let (low, high) = (centre - radius, centre + radius);
    [low.min(hoop), low.max(high.min(hoop)), high.max(hoop)]
}

/// Secants before the root is bracketed, and most steps to a bracket.
const SECANTS: usize = 8;
const MOST_STEPS: usize = 200;

/// Constants of the yield surface in the space of effective stress.
#[derive(Clone, Copy, Debug)]
pub struct ConcreteSurface {
    /// A = (f - 1)/(2 f - 1), from the biaxial strength ratio f.
    pressure: f64,
    /// C = 3 (1 - Kc)/(2 Kc - 1), from the ratio Kc of the deviators on the tensile and the compressive meridian.
    meridian: f64,
    /// 1/(1 - A).
    scale: f64,
}

impl ConcreteSurface {
    /// Returns the constants for the strength in equibiaxial over that in uniaxial compression, fb0/fc0, and Kc.
    /// Equation (20.14).
    pub fn new(biaxial_ratio: f64, meridian_ratio: f64) -> ConcreteSurface {
        let pressure = (biaxial_ratio - 1.0) / (2.0 * biaxial_ratio - 1.0);
        let meridian = 3.0 * (1.0 - meridian_ratio) / (2.0 * meridian_ratio - 1.0);
        ConcreteSurface { pressure, meridian, scale: 1.0 / (1.0 - pressure) }
    }

    /// Returns `(q - 3 A p + B <s> - C <-s>)/(1 - A) - sc` with `B = sc/st (1 - A) - (1 + A)`, from pressure p, von Mises
    /// stress q, largest principal stress s, and strengths sc and st (Lubliner and others 1989). Equation (20.14).
    #[inline]
    pub fn value(self, [pressure, mises, largest]: [f64; 3], [compression, tension]: [f64; 2]) -> f64 {
        let ConcreteSurface { pressure: a, meridian: c, scale } = self;
        let factor = if largest > 0.0 { -1.0 - a } else { c };
        let tensile = if largest > 0.0 { compression * largest / tension } else { 0.0 };
        (mises - 3.0 * a * pressure + factor * largest) * scale + tensile - compression
    }
}

/// State on the path of the return.
#[derive(Clone, Copy, Debug)]
pub struct ConcreteState {
    /// Pressure of the effective stress.
    pub pressure: f64,
    /// Share of the deviator of the trial that remains.
    pub share: f64,
    /// Principal effective stresses, ascending.
    pub principal: [f64; 3],
    /// Increments of the equivalent plastic strains: compression, tension.
    pub strains: [f64; 2],
}

/// Path of the return of a trial stress. The flow potential sqrt(l0² + q²) - p tan(psi) depends on pressure and von Mises
/// stress alone, so that the deviator keeps its direction.
pub struct ConcretePath<'a> {
    /// Tables of compression and tension.
    pub tables: [&'a ConcreteTable; 2],
    /// Bulk modulus without damage, stress.
    pub bulk: f64,
    /// One over the shear modulus without damage.
    pub per_shear: f64,
    /// Yield surface.
    pub surface: ConcreteSurface,
    /// Tangent of the dilation angle psi.
    pub dilatancy: f64,
    /// Rounding l0 of the potential, stress.
    pub rounding: f64,
    /// Trial of the effective stress.
    pub trial: TrialStress,
    /// Principal values of the deviator of the trial, ascending, stress.
    pub deviator: [f64; 3],
    /// Equivalent plastic strains at the start of the increment: compression, tension.
    pub start: [f64; 2],
    /// Effective strengths at these strains without flow: compression, tension.
    pub start_strengths: [f64; 2],
    /// Factors from the abscissae of the tables to strains.
    pub scales: [f64; 2],
    /// One over the length of the increment; 0 if that has no length.
    pub per_dt: f64,
    /// Share of tension where the plastic flow begins; `None` if it is that of the end.
    pub first_share: Option<f64>,
}

impl ConcretePath<'_> {
    /// Returns the state after the flow 3 G dl/sqrt(l0² + q²) = q_trial/q - 1 with the plastic multiplier dl.
    /// Equations (20.15), (20.16).
    #[inline]
    pub fn state(&self, flow: f64) -> ConcreteState {
        let half = 0.5 * self.per_shear;
        let share = 1.0 / (1.0 + flow);
        let mises = share * self.trial.mises;
        let rounded = (self.rounding * self.rounding + mises * mises).sqrt();
        let dilation = self.dilatancy * flow * rounded * (self.per_shear / 3.0);
        let pressure = self.trial.pressure + self.bulk * dilation;
        let principal = self.deviator.inline_map(|value| share * value - pressure);
        // Mean of both ends of the plastic flow: the share of tension may vary quickly.
        let last_share = tension_share(principal);
        let tension = 0.5 * (last_share + self.first_share.unwrap_or(last_share));
        let strain = |deviator: f64| half * flow * share * deviator + dilation / 3.0;
        let [smallest, _, largest] = self.deviator.inline_map(strain);
        let strains = [(-(1.0 - tension) * smallest).max(0.0), (tension * largest).max(0.0)];
        ConcreteState { pressure, share, principal, strains }
    }

    /// Returns strength and damage in compression (0) or tension (1). The rate is that of the increment up to the state.
    #[inline]
    pub fn strength(&self, state: &ConcreteState, side: usize) -> ConcreteStrength {
        let change = state.strains[side];
        self.tables[side].strength(self.start[side] + change, change * self.per_dt, self.scales[side])
    }

    /// Returns the yield function at a state.
    pub fn outside(&self, state: &ConcreteState) -> f64 {
        let strengths = [0, 1].inline_map(|side| {
            let changes = state.strains[side] > 0.0;
            if changes { self.strength(state, side).effective } else { self.start_strengths[side] }
        });
        self.surface.value([state.pressure, state.share * self.trial.mises, state.principal[2]], strengths)
    }

    /// Sets the share of tension at the start of the plastic flow, from the effective stress at the start of the increment
    /// and the value of the yield function at the trial.
    pub fn start_flow(&mut self, stress: [f64; 4], outside: f64) {
        let from = TrialStress::of(stress);
        let values = principal(stress);
        let elastic = self.deviator.inline_map(|value| value - self.trial.pressure);
        if tension_share(values) == tension_share(elastic) {
            return;
        }
        // Secant of the yield function along the elastic path.
        let inside = self.surface.value([from.pressure, from.mises, values[2]], self.start_strengths).min(0.0);
        let part = inside / (inside - outside);
        let mean = from.pressure + part * (self.trial.pressure - from.pressure);
        let contact = [0, 1, 2, 3].inline_map(|i| {
            let deviator = from.deviator[i] + part * (self.trial.deviator[i] - from.deviator[i]);
            if i < 3 { deviator - mean } else { deviator }
        });
        self.first_share = Some(tension_share(principal(contact)));
    }

    /// Returns the flow of perfect plasticity from the slope of the yield function at the trial.
    fn first_flow(&self, first: f64) -> f64 {
        let ConcreteSurface { pressure: a, meridian: c, scale } = self.surface;
        let mises = self.trial.mises;
        let rounded = (self.rounding * self.rounding + mises * mises).sqrt();
        let rise = self.bulk * self.dilatancy * rounded * (self.per_shear / 3.0);
        let fall = self.deviator[2] + rise;
        let tensile = self.deviator[2] > self.trial.pressure;
        let [factor, steep] =
            if tensile { [-1.0 - a, self.start_strengths[0] / self.start_strengths[1]] } else { [c, 0.0] };
        let slope = (mises + 3.0 * a * rise + factor * fall) * scale + steep * fall;
        if slope > 0.0 { first / slope } else { 1e-3 }
    }

    /// Returns the state on the yield surface, from the value of the yield function at the trial.
    pub fn end(&self, first: f64) -> ConcreteState {
        let outside = |flow: f64| self.outside(&self.state(flow));
        let size = self.tables[0].first() + self.trial.pressure.abs() + self.trial.mises;
        let tolerance = 1e-10 * size;
        // Last point, and bounds of the flow: the yield function becomes negative under a large pressure, which the flow
        // increases.
        let (mut last, mut last_value) = (0.0, first);
        let (mut positive, mut other) = (0.0, f64::INFINITY);
        let mut flow = self.first_flow(first);
        for iteration in 0..MOST_STEPS {
            let value = outside(flow);
            if value.abs() <= tolerance {
                return self.state(flow);
            }
            (positive, other) = if value > 0.0 { (flow, other) } else { (positive, flow) };
            let bracketed = other.is_finite();
            if bracketed && iteration >= SECANTS {
                break;
            }
            let secant = flow - value * (flow - last) / (value - last_value);
            (last, last_value) = (flow, value);
            let within = iteration < SECANTS && secant > positive && secant < other.min(100.0 * flow);
            let split = if bracketed { 0.5 * (positive + other) } else { 4.0 * flow };
            flow = if within { secant } else { split };
        }
        // Without a bound the trial is not finite, and neither is the result.
        self.state(if other.is_finite() { bracketed_root(positive, other, tolerance, outside) } else { f64::NAN })
    }
}

#[cfg(test)]
mod tests {
    use super::{ConcreteSurface, principal, tension_share};
    use crate::kernel::stress;

    /// Uniaxial, equibiaxial and confined compression, and uniaxial tension, for strengths 30 and 2.6.
    #[test]
    fn surface_contains_the_closed_forms() {
        let surface = ConcreteSurface::new(1.16, 0.667);
        let [a, c] = [0.16 / 1.32, 3.0 * 0.333 / 0.334];
        let confined = 30.0 + 5.0 * (1.0 + (3.0 * a + c) / (1.0 - a));
        for stress in [[0.0, -30.0, 0.0], [-34.8, 0.0, -34.8], [-5.0, -confined, -5.0], [0.0, 2.6, 0.0]] {
            let stress = [stress[0], stress[1], stress[2], 0.0];
            let values = [stress::pressure(stress), stress::mises(stress), principal(stress)[2]];
            assert!(surface.value(values, [30.0, 2.6]).abs() < 1e-12, "{stress:?}");
        }
    }

    #[test]
    fn principal_stresses_ascend_and_give_the_share_of_tension() {
        for stress in [[3.0, -5.0, 1.0, 2.0], [1.0, 2.0, 9.0, 0.5], [1.0, 2.0, -9.0, 0.0], [0.0; 4]] {
            assert_eq!(principal(stress), stress::principal(stress));
        }
        assert_eq!([[-2.0, 0.0, 2.0], [1.0, 2.0, 3.0], [0.0; 3]].map(tension_share), [0.5, 1.0, 0.0]);
    }
}
