//! Return of an effective trial stress to the yield surface of concrete damaged plasticity.

use super::concrete_tables::{ConcreteLine, ConcreteStrength};
use super::law::TrialStress;
use super::root::{Start, nearby_state};
use crate::kernel::lanes::InlineMap;
use crate::kernel::stress::principal;

/// Returns the share of tension r of principal stresses, between 0 and 1; 0 without stress (Lee and Fenves 1998).
/// Equation (20.16).
#[inline(always)] // Into the return of each point.
pub fn tension_share(principal: [f64; 3]) -> f64 {
    if principal[2] <= 0.0 {
        return 0.0;
    }
    let [low, middle, high] = principal.inline_map(|s| if s > 0.0 { s } else { 0.0 });
    let positive = low + middle + high;
    // The sum of absolute values.
    let sum = 2.0 * positive - (principal[0] + principal[1] + principal[2]);
    positive / sum
}

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
    #[inline(always)] // Into the return of each point.
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

/// Constants of the returns of a law.
#[derive(Clone, Copy, Debug)]
pub struct ConcreteConstants {
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
}

/// Path of the return of a trial stress. The flow potential sqrt(l0² + q²) - p tan(psi) depends on pressure and von Mises
/// stress alone, so that the deviator keeps its direction.
pub struct ConcretePath<'a> {
    /// Tables of compression and tension around the equivalent plastic strains at the start of the increment.
    pub tables: [ConcreteLine<'a>; 2],
    /// Constants of the law.
    pub of: ConcreteConstants,
    /// Trial of the effective stress.
    pub trial: TrialStress,
    /// Principal values of the deviator of the trial, ascending, stress.
    pub deviator: [f64; 3],
    /// Equivalent plastic strains at the start of the increment: compression, tension.
    pub start: [f64; 2],
    /// Effective strengths at these strains without flow: compression, tension.
    pub start_strengths: [f64; 2],
    /// One over the length of the increment; 0 if that has no length.
    pub per_dt: f64,
    /// Share of tension where the plastic flow begins; NaN if it is that of the end.
    pub first_share: f64,
}

impl ConcretePath<'_> {
    /// Returns the state after the flow 3 G dl/sqrt(l0² + q²) = q_trial/q - 1 with the plastic multiplier dl.
    /// Equations (20.15), (20.16).
    #[inline(always)] // Into the return of each point.
    pub fn state(&self, flow: f64) -> ConcreteState {
        let half = 0.5 * self.of.per_shear;
        let share = 1.0 / (1.0 + flow);
        let mises = share * self.trial.mises;
        let rounded = (self.of.rounding * self.of.rounding + mises * mises).sqrt();
        let dilation = self.of.dilatancy * flow * rounded * (self.of.per_shear / 3.0);
        let pressure = self.trial.pressure + self.of.bulk * dilation;
        let principal = self.deviator.inline_map(|value| share * value - pressure);
        // Mean of both ends of the plastic flow: the share of tension may vary quickly.
        let last_share = tension_share(principal);
        let first_share = if self.first_share >= 0.0 { self.first_share } else { last_share };
        let tension = 0.5 * (last_share + first_share);
        let strain = |deviator: f64| half * flow * share * deviator + dilation / 3.0;
        let [smallest, _, largest] = self.deviator.inline_map(strain);
        let strains = [-(1.0 - tension) * smallest, tension * largest].inline_map(|x| if x > 0.0 { x } else { 0.0 });
        ConcreteState { pressure, share, principal, strains }
    }

    /// Returns strength and damage in compression (0) or tension (1). The rate is that of the increment up to the state.
    #[inline(always)] // Into the return of each point.
    pub fn strength<const LINE: bool>(&self, state: &ConcreteState, side: usize) -> ConcreteStrength {
        let change = state.strains[side];
        self.tables[side].at::<LINE>(self.start[side] + change, change * self.per_dt)
    }

    /// Returns the yield function at a state.
    #[inline(always)] // Into the return of each point.
    pub fn outside<const LINE: bool>(&self, state: &ConcreteState) -> f64 {
        let strengths = [0, 1].inline_map(|side| {
            let change = state.strains[side];
            if change > 0.0 {
                self.tables[side].effective_at::<LINE>(self.start[side] + change, change * self.per_dt)
            } else {
                self.start_strengths[side]
            }
        });
        self.of.surface.value([state.pressure, state.share * self.trial.mises, state.principal[2]], strengths)
    }

    /// Returns whether the share of tension at the trial is that of the effective stress at the start of the increment.
    #[inline(always)] // Into the return of each point.
    pub fn has_one_share(&self, stress: [f64; 4]) -> bool {
        let elastic = self.deviator.inline_map(|value| value - self.trial.pressure);
        tension_share(principal(stress)) == tension_share(elastic)
    }

    /// Returns the share of tension at the start of the plastic flow, from the effective stress at the start of the increment
    /// and the value of the yield function at the trial.
    #[inline(always)] // Into the return of each point.
    pub fn share_at_contact(&self, stress: [f64; 4], outside: f64) -> f64 {
        let (from, values) = (TrialStress::of(stress), principal(stress));
        // Secant of the yield function along the elastic path.
        let inside = self.of.surface.value([from.pressure, from.mises, values[2]], self.start_strengths);
        let inside = if inside < 0.0 { inside } else { 0.0 };
        let part = inside / (inside - outside);
        let mean = from.pressure + part * (self.trial.pressure - from.pressure);
        let contact = [0, 1, 2, 3].inline_map(|i| {
            let deviator = from.deviator[i] + part * (self.trial.deviator[i] - from.deviator[i]);
            if i < 3 { deviator - mean } else { deviator }
        });
        tension_share(principal(contact))
    }

    /// Returns the flow at which the tangent of the yield function at the trial is zero.
    #[inline(always)] // Into the return of each point.
    pub fn first_flow(&self, first: f64) -> f64 {
        let ConcreteSurface { pressure: a, meridian: c, scale } = self.of.surface;
        let mises = self.trial.mises;
        let rounded = (self.of.rounding * self.of.rounding + mises * mises).sqrt();
        let dilation = self.of.dilatancy * rounded * (self.of.per_shear / 3.0);
        let rise = self.of.bulk * dilation;
        let fall = self.deviator[2] + rise;
        let largest = self.deviator[2] - self.trial.pressure;
        let [factor, steep] =
            if largest > 0.0 { [-1.0 - a, self.start_strengths[0] / self.start_strengths[1]] } else { [c, 0.0] };
        // Rates of the equivalent plastic strains over the flow, and hardening.
        let share = tension_share(self.deviator.inline_map(|value| value - self.trial.pressure));
        let strain = |deviator: f64| 0.5 * self.of.per_shear * deviator + dilation / 3.0;
        let [compression, tension] =
            [-(1.0 - share) * strain(self.deviator[0]), share * strain(self.deviator[2])].inline_map(|x| x.max(0.0));
        let [harder, tougher] = [self.tables[0].slope(), self.tables[1].slope()];
        let ratio = if largest > 0.0 { largest / self.start_strengths[1] } else { 0.0 };
        let hardening = (1.0 - ratio) * harder * compression + ratio * steep * tougher * tension;
        let perfect = (mises + 3.0 * a * rise + factor * fall) * scale + steep * fall;
        let slope = perfect + hardening;
        let slope = if slope > 0.1 * perfect { slope } else { perfect };
        if slope > 0.0 { first / slope } else { 1e-3 }
    }

    /// Returns values of the yield function that are zero.
    #[inline(always)] // Into the return of each point.
    pub fn tolerance(&self) -> f64 {
        1e-10 * (self.start_strengths[0] + self.trial.pressure.abs() + self.trial.mises)
    }

    /// Returns the state on the yield surface, from the value of the yield function at the trial. The function becomes
    /// negative under a large pressure, which the flow increases.
    pub fn end(&self, first: f64) -> ConcreteState {
        let start = Start { start: 0.0, first, guess: self.first_flow(first) };
        let outside = |flow: f64| {
            let state = self.state(flow);
            (self.outside::<false>(&state), state)
        };
        // Without a root the trial is not finite, and neither is the result.
        nearby_state(start, f64::INFINITY, self.tolerance(), outside)
            .map_or_else(|| self.state(f64::NAN), |(_, state)| state)
    }
}

#[cfg(test)]
mod tests {
    use super::{ConcreteSurface, tension_share};
    use crate::kernel::stress::{self, principal};

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
    fn principal_stresses_give_the_share_of_tension() {
        assert_eq!([[-2.0, 0.0, 2.0], [1.0, 2.0, 3.0], [0.0; 3]].map(tension_share), [0.5, 1.0, 0.0]);
    }
}
