//! Extended Drucker-Prager plasticity (ABAQUS Analysis User's Guide, "Extended Drucker-Prager models").

use super::law::{ReturnPoint, StressReturn, TrialStress, determinant};
use super::root::{bracketed_root, nearby_root};
use crate::kernel::hardening::{LinearTable, RateFactor, power};
use crate::kernel::lanes::InlineMap;
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::stress::mises;
use crate::variables::{Variable, VariableComponent};

/// Shape of the yield surface in the plane of pressure p and von Mises stress q. Equation (20.4).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DruckerPragerShape {
    /// t - p tan(beta) = d, where t is q in triaxial compression and q/K in triaxial tension.
    Linear {
        /// Friction: tan(beta).
        friction: f64,
        /// K, ratio of the flow stresses in triaxial tension and compression.
        ratio: f64,
    },
    /// sqrt(l0² + q²) - p tan(beta) = d.
    Hyperbolic {
        /// Friction: tan(beta).
        friction: f64,
        /// Distance l0 between the apex of the asymptote and the surface, as a stress.
        apex: f64,
    },
    /// a q^b - p = pt.
    Exponent {
        /// Factor a.
        factor: f64,
        /// Exponent b.
        exponent: f64,
    },
}

/// Test that gives the yield stresses of the hardening table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum YieldTest {
    /// Uniaxial compression.
    Compression,
    /// Uniaxial tension.
    Tension,
    /// Pure shear.
    Shear,
}

impl YieldTest {
    /// All tests, in the order of the values of TYPE.
    pub const ALL: [YieldTest; 3] = [YieldTest::Compression, YieldTest::Tension, YieldTest::Shear];

    /// Returns the invariants of the test for a stress.
    fn invariants(self, stress: f64) -> Invariants {
        match self {
            YieldTest::Compression => Invariants { pressure: stress / 3.0, mises: stress, third: -1.0 },
            YieldTest::Tension => Invariants { pressure: -stress / 3.0, mises: stress, third: 1.0 },
            YieldTest::Shear => Invariants { pressure: 0.0, mises: 3.0_f64.sqrt() * stress, third: 0.0 },
        }
    }
}

/// Invariants of a stress.
#[derive(Clone, Copy)]
struct Invariants {
    pressure: f64,
    mises: f64,
    /// 27/2 det(s)/q³: -1 in triaxial compression, 1 in triaxial tension.
    third: f64,
}

impl Invariants {
    /// Returns the invariants that a shape of the yield surface needs.
    fn of(pressure: f64, deviator: [f64; 4], shape: DruckerPragerShape) -> Invariants {
        let mises = mises(deviator);
        let is_round = !matches!(shape, DruckerPragerShape::Linear { ratio, .. } if ratio < 1.0);
        let third = if is_round || mises == 0.0 { 0.0 } else { 13.5 * determinant(deviator) / (mises * mises * mises) };
        Invariants { pressure, mises, third }
    }

    /// Returns the measure t of the deviator. Equation (20.5).
    fn measure(self, ratio: f64) -> f64 {
        if ratio == 1.0 {
            return self.mises;
        }
        0.5 * self.mises * ((1.0 + 1.0 / ratio) - (1.0 - 1.0 / ratio) * self.third)
    }
}

impl DruckerPragerShape {
    /// Returns the part of the yield function that depends on the stress; it equals [`Self::strength`] on the surface.
    /// Equation (20.4).
    fn measure(self, stress: Invariants) -> f64 {
        let Invariants { pressure, mises, .. } = stress;
        match self {
            DruckerPragerShape::Linear { friction, ratio } => stress.measure(ratio) - pressure * friction,
            DruckerPragerShape::Hyperbolic { friction, apex } => {
                (apex * apex + mises * mises).sqrt() - pressure * friction
            }
            DruckerPragerShape::Exponent { factor, exponent } => factor * power(mises, exponent) - pressure,
        }
    }

    /// Returns the measure of a test with a yield stress. For the linear form it is the cohesion d.
    pub fn strength(self, test: YieldTest, yield_stress: f64) -> f64 {
        self.measure(test.invariants(yield_stress))
    }
}

/// Material with a yield stress that increases with pressure.
#[derive(Clone, Debug)]
pub struct DruckerPrager {
    /// Shape of the yield surface.
    pub shape: DruckerPragerShape,
    /// Tangent of the dilation angle psi.
    pub dilatancy: f64,
    /// Eccentricity of the hyperbolic flow potential; not used by the linear form.
    pub eccentricity: f64,
    /// Yield stress of the test over its plastic strain.
    pub hardening: LinearTable,
    /// Test that gives the table.
    pub test: YieldTest,
    /// Rate factor on the yield stress.
    pub rate: Option<RateFactor>,
    /// Elastic moduli.
    pub moduli: ElasticModuli,
}

/// State on the path of the return.
#[derive(Clone, Copy)]
struct PathState {
    pressure: f64,
    deviator: [f64; 4],
    /// Equivalent plastic strain.
    strain: f64,
    /// Yield function.
    outside: f64,
}

/// Trial stress of an increment, with what is constant on its path of return.
struct ReturnIncrement<'a> {
    law: &'a DruckerPrager,
    trial: TrialStress,
    strain_before: f64,
    dt: f64,
    /// Direction of the deviatoric flow of the linear form, and the plastic multiplier at the end of the path.
    direction: [f64; 4],
    longest: f64,
}

/// Only state: equivalent plastic strain.
const STRAIN: usize = 0;

impl DruckerPrager {
    /// Returns the distance l0 of a hyperbolic surface with a strength in hydrostatic tension, from the first yield stress
    /// of its table; `None` if no surface has both strengths. Equation (20.7).
    pub fn apex(friction: f64, tension: f64, test: YieldTest, yield_stress: f64) -> Option<f64> {
        // sqrt(l0² + q²) - p tan(beta) = l0 + pt tan(beta) with p and q of the test.
        let Invariants { pressure, mises, .. } = test.invariants(yield_stress);
        let sum = (tension + pressure) * friction;
        let apex = (mises * mises - sum * sum) / (2.0 * sum);
        (apex >= 0.0 && apex.is_finite()).then_some(apex)
    }

    /// Returns the measure of the test at an equivalent plastic strain and its rate. Equation (20.6).
    pub fn strength(&self, strain: f64, rate: f64) -> f64 {
        let factor = self.rate.as_ref().map_or(1.0, |factor| factor.at(rate, 0.0));
        self.shape.strength(self.test, factor * self.hardening.value(strain))
    }

    /// Returns the pressure of the apex, where the deviator is zero. Equation (20.10).
    fn apex_pressure(&self, strength: f64) -> f64 {
        match self.shape {
            DruckerPragerShape::Linear { friction, .. } => -strength / friction,
            DruckerPragerShape::Hyperbolic { friction, apex } => (apex - strength) / friction,
            DruckerPragerShape::Exponent { .. } => -strength,
        }
    }

    /// Returns the rounding of the flow potential at its apex: zero for the linear form.
    fn rounding(&self) -> f64 {
        match self.shape {
            DruckerPragerShape::Linear { .. } => 0.0,
            _ => self.eccentricity * self.hardening.value(0.0) * self.dilatancy,
        }
    }

    /// Returns the increment of the equivalent plastic strain for a plastic multiplier. Equation (20.9).
    fn hardening_strain(&self, before: f64, stress: Invariants, multiplier: f64) -> f64 {
        if let DruckerPragerShape::Linear { ratio, .. } = self.shape {
            // The strain of the test along its stress.
            let unit = self.test.invariants(1.0);
            let deviatoric = if unit.third == 0.0 { 0.5 * (1.0 + 1.0 / ratio) } else { unit.measure(ratio) };
            return multiplier * (deviatoric - unit.pressure * self.dilatancy);
        }
        let Invariants { pressure, mises, .. } = stress;
        let rounding = self.rounding();
        let potential = (rounding * rounding + mises * mises).sqrt();
        let along = if potential > 0.0 { mises * mises / potential } else { 0.0 };
        let work = (multiplier * (along - pressure * self.dilatancy)).max(0.0);
        // Work over the yield stress in the middle of the increment.
        let estimate = work / self.hardening.value(before);
        work / self.hardening.value(before + 0.5 * estimate)
    }
}

impl ReturnIncrement<'_> {
    fn new(law: &DruckerPrager, trial: TrialStress, strain_before: f64, dt: f64) -> ReturnIncrement<'_> {
        let mut increment = ReturnIncrement { law, trial, strain_before, dt, direction: [0.0; 4], longest: 0.0 };
        if let (DruckerPragerShape::Linear { ratio, .. }, true) = (law.shape, trial.mises > 0.0) {
            let (s, q) = (trial.deviator, trial.mises);
            let (sum, difference) = (0.5 * (1.0 + 1.0 / ratio), 0.5 * (1.0 - 1.0 / ratio));
            // Derivatives of q and of 27/2 det(s)/q² by the deviator.
            let of_third = 13.5 * determinant(s) / (q * q * q);
            let squared = [s[0] * s[0] + s[3] * s[3], s[1] * s[1] + s[3] * s[3], s[2] * s[2], s[3] * (s[0] + s[1])];
            let part = |i: usize| {
                let cofactor = 13.5 * (squared[i] - if i < 3 { 2.0 / 9.0 * q * q } else { 0.0 }) / (q * q);
                (sum + 2.0 * difference * of_third) * 1.5 * s[i] / q - difference * cofactor
            };
            increment.direction = [0, 1, 2, 3].inline_map(part);
            let measure = Invariants::of(trial.pressure, s, law.shape).measure(ratio);
            increment.longest = q * q / (3.0 * law.moduli.shear * measure);
        }
        increment
    }

    /// Returns the state at a share of the path that is left: 1 for the trial. Equation (20.8).
    fn along(&self, share: f64) -> PathState {
        let ReturnIncrement { law, trial, direction, .. } = self;
        let ElasticModuli { bulk, shear } = law.moduli;
        let (multiplier, deviator) = if let DruckerPragerShape::Linear { .. } = law.shape {
            let multiplier = (1.0 - share) * self.longest;
            (multiplier, [0, 1, 2, 3].inline_map(|i| trial.deviator[i] - 2.0 * shear * multiplier * direction[i]))
        } else {
            let (mises, rounding) = (trial.mises * share, law.rounding());
            // The derivative of the potential by the von Mises stress.
            let slope = if rounding > 0.0 { mises / (rounding * rounding + mises * mises).sqrt() } else { 1.0 };
            let multiplier = (trial.mises - mises) / (3.0 * shear * slope);
            (multiplier, trial.deviator.inline_map(|part| share * part))
        };
        self.state(trial.pressure + bulk * multiplier * law.dilatancy, deviator, multiplier)
    }

    fn state(&self, pressure: f64, deviator: [f64; 4], multiplier: f64) -> PathState {
        let stress = Invariants::of(pressure, deviator, self.law.shape);
        let hardening = self.law.hardening_strain(self.strain_before, stress, multiplier);
        let strain = self.strain_before + hardening;
        let outside = self.law.shape.measure(stress) - self.law.strength(strain, self.rate(hardening));
        PathState { pressure, deviator, strain, outside }
    }

    fn rate(&self, hardening: f64) -> f64 {
        if self.dt > 0.0 { hardening / self.dt } else { 0.0 }
    }

    /// Returns the state at the apex: the pressure alone returns. Equation (20.10).
    fn at_apex(&self) -> PathState {
        let ReturnIncrement { law, trial, .. } = self;
        let state = |pressure: f64| {
            let slope = law.moduli.bulk * law.dilatancy;
            let multiplier = if slope > 0.0 { (pressure - trial.pressure) / slope } else { 0.0 };
            self.state(pressure, [0.0; 4], multiplier)
        };
        let outside = |pressure: f64| {
            let strain = state(pressure).strain;
            law.apex_pressure(law.strength(strain, self.rate(strain - self.strain_before))) - pressure
        };
        let distance = outside(trial.pressure).max(0.0);
        let mut end = trial.pressure + distance;
        // Softening moves the apex further.
        for _ in 0..60 {
            if outside(end) <= 0.0 {
                break;
            }
            end += distance;
        }
        let size = 1e-13 * law.strength(self.strain_before, 0.0).abs();
        state(bracketed_root(trial.pressure, end, size, outside))
    }
}

impl StressReturn for DruckerPrager {
    fn describe(&self) -> String {
        let form = match self.shape {
            DruckerPragerShape::Linear { .. } => "linear",
            DruckerPragerShape::Hyperbolic { .. } => "hyperbolic",
            DruckerPragerShape::Exponent { .. } => "exponent form",
        };
        format!("Drucker-Prager, {form}")
    }

    fn moduli(&self) -> ElasticModuli {
        self.moduli
    }

    fn initial_state(&self) -> Vec<f64> {
        vec![0.0]
    }

    fn hardening_state(&self) -> Option<usize> {
        Some(STRAIN)
    }

    fn output(&self, part: VariableComponent) -> Option<usize> {
        (part.variable == Variable::PlasticStrain).then_some(STRAIN)
    }

    fn update(&self, point: &mut ReturnPoint<'_>) {
        let trial = TrialStress::of(point.elastic(point.carried, self.moduli));
        let strength = self.strength(point.state[STRAIN], 0.0);
        let first = self.shape.measure(Invariants::of(trial.pressure, trial.deviator, self.shape)) - strength;
        let size = strength.abs() + trial.pressure.abs() + trial.mises;
        // A NaN is not returned, so that the run halts.
        if first.is_nan() || first <= 1e-14 * size {
            return point.return_to(&trial, trial.pressure, trial.mises, 0.0);
        }
        // The smooth potential reaches all pressures before the von Mises stress vanishes, the linear one does not.
        let smallest = if self.rounding() > 0.0 { 1e-12 } else { 0.0 };
        let increment = ReturnIncrement::new(self, trial, point.state[STRAIN], point.dt);
        let share = if trial.mises <= 1e-12 * size {
            None
        } else {
            nearby_root(1.0, first, smallest, 1e-13 * size, |share| increment.along(share).outside)
        };
        let PathState { pressure, deviator, strain, .. } =
            share.map_or_else(|| increment.at_apex(), |share| increment.along(share));
        point.state[STRAIN] = strain;
        point.return_to_deviator(&trial, pressure, deviator, (pressure - trial.pressure) / self.moduli.bulk);
    }
}

#[cfg(test)]
mod tests {
    use super::{DruckerPrager, DruckerPragerShape, Invariants, ReturnIncrement, YieldTest};
    use crate::kernel::hardening::LinearTable;
    use crate::kernel::moduli::ElasticModuli;
    use crate::material::returns::law::{ReturnPoint, StressReturn, TrialStress};

    fn law(shape: DruckerPragerShape) -> DruckerPrager {
        DruckerPrager {
            shape,
            dilatancy: 0.2,
            eccentricity: 0.1,
            hardening: LinearTable { rows: vec![[1.0, 0.0]] },
            test: YieldTest::Compression,
            rate: None,
            moduli: ElasticModuli { bulk: 150.0, shear: 70.0 },
        }
    }

    /// Strains a point along z in increments with a constant lateral stress; returns the axial stress.
    fn axial_stress(law: &DruckerPrager, lateral: f64, strain: f64) -> f64 {
        let (mut state, mut stress) = ([0.0], [lateral, lateral, lateral, 0.0]);
        let mut radial = 0.0;
        for _ in 0..400 {
            // The lateral strain increment that keeps the lateral stress, by secants.
            let respond = |radial: f64, state: &mut [f64]| {
                let strain = [radial, strain / 400.0, radial, 0.0];
                let mut point = ReturnPoint::new(strain, stress, state, law.moduli);
                law.update(&mut point);
                point.stress
            };
            for _ in 0..60 {
                let [here, next] =
                    [radial, radial + 1e-7].map(|radial| respond(radial, &mut state.clone())[0] - lateral);
                radial -= here * 1e-7 / (next - here);
            }
            stress = respond(radial, &mut state);
        }
        stress[1]
    }

    /// Triaxial compression and extension at a cell pressure: q = (p3 tan(beta) + d)/(1 - tan(beta)/3) and, with the ratio K,
    /// q/K - p tan(beta) = d.
    #[test]
    fn triaxial_strength_depends_on_pressure() {
        let (friction, cell) = (0.9, 2.0);
        for ratio in [1.0, 0.8] {
            let law = law(DruckerPragerShape::Linear { friction, ratio });
            let cohesion = 1.0 - friction / 3.0;
            let compressed = (cell * friction + cohesion) / (1.0 - friction / 3.0);
            let found = -axial_stress(&law, -cell, -0.2) - cell;
            assert!((found / compressed - 1.0).abs() < 1e-9, "{found} {compressed}");
            // The mean pressure is the cell pressure less a third of q.
            let extended = (cell * friction + cohesion) / (1.0 / ratio + friction / 3.0);
            let found = axial_stress(&law, -cell, 0.2) + cell;
            assert!((found / extended - 1.0).abs() < 1e-9, "{found} {extended}");
        }
    }

    /// The direction of the deviatoric flow is the derivative of the measure t by the deviator.
    #[test]
    fn flow_is_normal_to_the_measure() {
        let ratio = 0.8;
        let law = law(DruckerPragerShape::Linear { friction: 0.9, ratio });
        let trial = TrialStress::of([1.0, -2.0, 0.4, 0.7]);
        let increment = ReturnIncrement::new(&law, trial, 0.0, 1.0);
        let measure = |deviator: [f64; 4]| Invariants::of(0.0, deviator, law.shape).measure(ratio);
        for i in 0..4 {
            let difference = |step: f64| {
                let mut deviator = trial.deviator;
                deviator[i] += step;
                measure(deviator)
            };
            let slope = (difference(1e-6) - difference(-1e-6)) / 2e-6;
            // The shear component counts twice, and the direction has no mean.
            let normal = if i < 3 { slope } else { 0.5 * slope };
            let mean = (0..3).map(|k| {
                let mut deviator = trial.deviator;
                deviator[k] += 1e-6;
                (measure(deviator) - measure(trial.deviator)) / 3e-6
            });
            let normal = if i < 3 { normal - mean.sum::<f64>() } else { normal };
            assert!((increment.direction[i] - normal).abs() < 1e-5, "{i}: {} {normal}", increment.direction[i]);
        }
    }

    /// Hydrostatic tension ends at the apex.
    #[test]
    fn tension_is_limited_by_the_apex() {
        for shape in [
            DruckerPragerShape::Linear { friction: 0.9, ratio: 1.0 },
            DruckerPragerShape::Hyperbolic { friction: 0.9, apex: 0.2 },
            DruckerPragerShape::Exponent { factor: 0.5, exponent: 2.0 },
        ] {
            let law = law(shape);
            let mut state = [0.0];
            let mut point = ReturnPoint::new([0.01, 0.01, 0.01, 0.0], [0.0; 4], &mut state, law.moduli);
            law.update(&mut point);
            let apex = law.apex_pressure(law.strength(0.0, 0.0));
            assert!((TrialStress::of(point.stress).pressure / apex - 1.0).abs() < 1e-9, "{shape:?} {:?}", point.stress);
        }
    }
}
