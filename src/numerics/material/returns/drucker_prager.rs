//! Extended Drucker-Prager plasticity (ABAQUS Analysis User's Guide, "Extended Drucker-Prager models").

use super::lane_roots::{LaneStarts, any, lane_roots};
use super::law::{ReturnPoint, StressReturn, TrialStress, contraction, determinant};
use super::points::ReturnedPoints;
use super::root::{Start, nearby_root, nearby_state};
use crate::kernel::hardening::{LinearTable, RateFactor, TableLine, TableLines};
use crate::kernel::lanes::{InlineMap, LANES, Lanes, column, put_column};
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::stress::mises;
use crate::kernel::transcendental::power_of;
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
    #[inline(always)] // Into the return of each point.
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
    #[inline(always)] // Into the return of each point.
    fn of(pressure: f64, deviator: [f64; 4], shape: DruckerPragerShape) -> Invariants {
        let mises = mises(deviator);
        let third =
            if shape.is_round() || mises == 0.0 { 0.0 } else { 13.5 * determinant(deviator) / (mises * mises * mises) };
        Invariants { pressure, mises, third }
    }

    /// Returns the measure t of the deviator. Equation (20.5).
    #[inline(always)] // Into the return of each point.
    fn measure(self, ratio: f64) -> f64 {
        if ratio == 1.0 {
            return self.mises;
        }
        0.5 * self.mises * ((1.0 + 1.0 / ratio) - (1.0 - 1.0 / ratio) * self.third)
    }
}

impl DruckerPragerShape {
    /// Returns whether the surface does not depend on the third invariant.
    #[inline(always)] // Into the return of each point.
    fn is_round(self) -> bool {
        !matches!(self, DruckerPragerShape::Linear { ratio, .. } if ratio < 1.0)
    }

    /// Returns the part of the yield function that depends on the stress; it equals [`Self::strength`] on the surface.
    /// Equation (20.4).
    #[inline(always)] // Into the return of each point.
    fn measure(self, stress: Invariants) -> f64 {
        let Invariants { pressure, mises, .. } = stress;
        match self {
            DruckerPragerShape::Linear { friction, ratio } => stress.measure(ratio) - pressure * friction,
            DruckerPragerShape::Hyperbolic { friction, apex } => {
                (apex * apex + mises * mises).sqrt() - pressure * friction
            }
            DruckerPragerShape::Exponent { factor, exponent } => factor * power_of(mises, exponent) - pressure,
        }
    }

    /// Returns the derivatives of [`Self::measure`] by the von Mises stress and, negative, by the pressure, of the forms without
    /// third invariant.
    #[inline(always)] // Into the return of each point.
    fn slopes(self, mises: f64) -> [f64; 2] {
        match self {
            DruckerPragerShape::Linear { friction, .. } => [1.0, friction],
            DruckerPragerShape::Hyperbolic { friction, apex } => {
                [mises / (apex * apex + mises * mises).sqrt(), friction]
            }
            DruckerPragerShape::Exponent { factor, exponent } => {
                [factor * exponent * power_of(mises, exponent - 1.0), 1.0]
            }
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
    /// Increment of the equivalent plastic strain.
    hardening: f64,
    /// Measure of the stress.
    measure: f64,
}

/// Constants of all returns of a law.
#[derive(Clone, Copy)]
struct ReturnConstants<'a> {
    law: &'a DruckerPrager,
    /// That of the law; the compiler knows its kind in loops over lanes.
    shape: DruckerPragerShape,
    /// Invariants of the test with a stress of 1.
    test: Invariants,
    /// Rate factor at rest.
    at_rest: f64,
    /// Rounding of the potential of the other forms than the linear one.
    rounding: f64,
}

/// Trial stress of an increment, with what is constant on its path of return.
#[derive(Clone, Copy)]
struct ReturnIncrement<'a> {
    of: ReturnConstants<'a>,
    trial: TrialStress,
    strain_before: f64,
    /// Hardening near that strain, and the strength there without flow.
    hardening: TableLine<'a>,
    strength_before: f64,
    /// Inverse of the length of the increment.
    per_dt: f64,
    /// Direction of the deviatoric flow, and equivalent plastic strain per plastic multiplier, of the linear form.
    direction: [f64; 4],
    per_multiplier: f64,
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

    /// Returns the constants of returns; `shape` is that of the law.
    #[inline(always)] // Into the return of each point.
    fn constants(&self, shape: DruckerPragerShape) -> ReturnConstants<'_> {
        let at_rest = self.rate.as_ref().map_or(1.0, |factor| factor.at(0.0, 0.0));
        ReturnConstants { law: self, shape, test: self.test.invariants(1.0), at_rest, rounding: self.rounding() }
    }
}

/// Root on the path of return: where it starts, and what it does not reach.
struct ReturnWay {
    start: Start,
    limit: f64,
}

/// Methods with `LINE` use the line of the table alone, also beyond its end, as loops over lanes need.
impl<'a> ReturnIncrement<'a> {
    #[inline(always)] // Into the return of each point.
    fn new(
        of: ReturnConstants<'a>,
        trial: TrialStress,
        strain_before: f64,
        hardening: TableLine<'a>,
    ) -> ReturnIncrement<'a> {
        let (direction, per_multiplier, per_dt) = ([0.0; 4], 0.0, 0.0);
        let (size, Invariants { pressure, mises, third }) = (hardening.value * of.at_rest, of.test);
        let strength_before = of.shape.measure(Invariants { pressure: size * pressure, mises: size * mises, third });
        ReturnIncrement { of, trial, strain_before, hardening, strength_before, per_dt, direction, per_multiplier }
    }

    /// Returns the value of the yield function at the trial, and the size of the stress.
    #[inline(always)] // Into the return of each point.
    fn first(&self) -> [f64; 2] {
        let TrialStress { pressure, deviator, mises } = self.trial;
        let stress = if self.of.shape.is_round() {
            Invariants { pressure, mises, third: 0.0 }
        } else {
            Invariants::of(pressure, deviator, self.of.shape)
        };
        [self.of.shape.measure(stress) - self.strength_before, self.strength_before.abs() + pressure.abs() + mises]
    }

    /// Sets the flow of the linear form for a stress outside the yield surface.
    #[inline(always)] // Into the return of each point.
    fn set_flow(&mut self) {
        let DruckerPragerShape::Linear { ratio, .. } = self.of.shape else { return };
        self.per_multiplier = self.strain_per_multiplier(ratio);
        let (s, q) = (self.trial.deviator, self.trial.mises);
        if self.of.shape.is_round() {
            self.direction = s.inline_map(|part| 1.5 / q * part);
            return;
        }
        let (sum, difference) = (0.5 * (1.0 + 1.0 / ratio), 0.5 * (1.0 - 1.0 / ratio));
        // Derivatives of q and of 27/2 det(s)/q² by the deviator.
        let of_third = 13.5 * determinant(s) / (q * q * q);
        let squared = [s[0] * s[0] + s[3] * s[3], s[1] * s[1] + s[3] * s[3], s[2] * s[2], s[3] * (s[0] + s[1])];
        let part = |i: usize| {
            let cofactor = 13.5 * (squared[i] - if i < 3 { 2.0 / 9.0 * q * q } else { 0.0 }) / (q * q);
            (sum + 2.0 * difference * of_third) * 1.5 * s[i] / q - difference * cofactor
        };
        self.direction = [0, 1, 2, 3].inline_map(part);
    }

    /// Returns the equivalent plastic strain per plastic multiplier of the linear form: the strain of the test along its
    /// stress. Equation (20.9).
    #[inline(always)] // Into the return of each point.
    fn strain_per_multiplier(&self, ratio: f64) -> f64 {
        let unit = self.of.test;
        let deviatoric = if unit.third == 0.0 { 0.5 * (1.0 + 1.0 / ratio) } else { unit.measure(ratio) };
        deviatoric - unit.pressure * self.of.law.dilatancy
    }

    /// Returns the deviator of the linear form after flow with a plastic multiplier.
    #[inline(always)] // Into the return of each point.
    fn linear_deviator(&self, multiplier: f64) -> [f64; 4] {
        let step = 2.0 * self.of.law.moduli.shear * multiplier;
        [0, 1, 2, 3].inline_map(|i| self.trial.deviator[i] - step * self.direction[i])
    }

    /// Returns the state at an argument of the path: of the linear form the plastic multiplier, of the other forms the von
    /// Mises stress. Equation (20.8).
    #[inline(always)] // Into the return of each point.
    fn state<const LINE: bool>(&self, argument: f64) -> PathState {
        let (ReturnConstants { law, shape, .. }, trial) = (self.of, self.trial);
        if let DruckerPragerShape::Linear { .. } = shape {
            let multiplier = argument;
            let pressure = trial.pressure + law.moduli.bulk * law.dilatancy * multiplier;
            let stress = if shape.is_round() {
                Invariants { pressure, mises: trial.mises - 3.0 * law.moduli.shear * multiplier, third: 0.0 }
            } else {
                Invariants::of(pressure, self.linear_deviator(multiplier), shape)
            };
            return PathState { pressure, hardening: multiplier * self.per_multiplier, measure: shape.measure(stress) };
        }
        let mises = argument;
        let potential = self.potential(mises);
        // The derivative of the potential by the von Mises stress is the von Mises stress over the potential.
        let multiplier = (trial.mises - mises) * potential / (3.0 * law.moduli.shear * mises);
        let pressure = trial.pressure + law.moduli.bulk * multiplier * law.dilatancy;
        let work = multiplier * (mises * mises / potential - pressure * law.dilatancy);
        let measure = shape.measure(Invariants { pressure, mises, third: 0.0 });
        PathState { pressure, hardening: self.strain_of_work::<LINE>(work), measure }
    }

    /// Returns the deviator at an argument of the path.
    #[inline(always)] // Into the return of each point.
    fn deviator(&self, argument: f64) -> [f64; 4] {
        if let DruckerPragerShape::Linear { .. } = self.of.shape {
            return self.linear_deviator(argument);
        }
        let share = argument / self.trial.mises;
        self.trial.deviator.inline_map(|part| share * part)
    }

    /// Returns sqrt(l0² + q²), the flow potential without the pressure, of the smooth forms.
    #[inline(always)] // Into the return of each point.
    fn potential(&self, mises: f64) -> f64 {
        (self.of.rounding * self.of.rounding + mises * mises).sqrt()
    }

    /// Returns the increment of the equivalent plastic strain for a plastic work. Equation (20.9).
    #[inline(always)] // Into the return of each point.
    fn strain_of_work<const LINE: bool>(&self, work: f64) -> f64 {
        // Work over the yield stress in the middle of the increment.
        let work = if work > 0.0 { work } else { 0.0 };
        let estimate = work / self.hardening.value;
        work / self.hardening.value_at::<LINE>(self.strain_before + 0.5 * estimate)
    }

    /// Returns the yield function at a state.
    #[inline(always)] // Into the return of each point.
    fn outside<const LINE: bool>(&self, state: PathState) -> f64 {
        state.measure - self.strength::<LINE>(state.hardening)
    }

    /// Returns the strength after a hardening increment.
    #[inline(always)] // Into the return of each point.
    fn strength<const LINE: bool>(&self, hardening: f64) -> f64 {
        let yield_stress = self.hardening.value_at::<LINE>(self.strain_before + hardening);
        let factor = match &self.of.law.rate {
            Some(rate) if !LINE => rate.at(hardening * self.per_dt, 0.0),
            _ => 1.0,
        };
        let (size, Invariants { pressure, mises, third }) = (factor * yield_stress, self.of.test);
        self.of.shape.measure(Invariants { pressure: size * pressure, mises: size * mises, third })
    }

    /// Returns where the root on the path starts, from the value of the yield function at the trial.
    #[inline(always)] // Into the return of each point.
    fn way(&self, first: f64) -> ReturnWay {
        let (ReturnConstants { law, shape, .. }, trial) = (self.of, self.trial);
        let ElasticModuli { bulk, shear } = law.moduli;
        if let DruckerPragerShape::Linear { friction, .. } = shape {
            let unit = shape.measure(self.of.test);
            let along = if shape.is_round() { 1.5 } else { contraction(self.direction, self.direction) };
            let slope = 2.0 * shear * along
                + bulk * law.dilatancy * friction
                + unit * self.hardening.slope * self.per_multiplier;
            // The measure decreases linearly to zero.
            let measure = first + self.strength_before + trial.pressure * friction;
            let limit = trial.mises * trial.mises / (3.0 * shear * measure);
            let guess = if slope > 0.0 { first / slope } else { f64::NAN };
            return ReturnWay { start: Start { start: 0.0, first, guess }, limit };
        }
        let q = trial.mises;
        let [by_mises, by_pressure] = shape.slopes(q);
        let potential = self.potential(q);
        // Derivatives of the plastic multiplier and of the hardening strain by the falling von Mises stress.
        let multiplier = potential / (3.0 * shear * q);
        let strain = multiplier * (q * q / potential - trial.pressure * law.dilatancy) / self.hardening.value;
        let strain = if strain > 0.0 { strain } else { 0.0 };
        let perfect = by_mises + by_pressure * bulk * law.dilatancy * multiplier;
        let slope = perfect + self.slope_of_strength() * strain;
        let slope = if slope > 0.1 * perfect { slope } else { 0.1 * perfect };
        // The smooth potential reaches all pressures before the von Mises stress vanishes.
        ReturnWay { start: Start { start: q, first, guess: q - first / slope }, limit: 1e-12 * q }
    }

    /// Returns the end of the return along the deviator, from the value of the yield function at the trial; `None` if that
    /// ends at the apex only.
    fn end(&self, first: f64, size: f64) -> Option<(PathState, [f64; 4])> {
        let ReturnWay { start, limit } = self.way(first);
        let outside = |argument: f64| {
            let state = self.state::<false>(argument);
            (self.outside::<false>(state), state)
        };
        let (argument, state) = nearby_state(start, limit, ACCURACY * size, outside)?;
        Some((state, self.deviator(argument)))
    }

    /// Returns the slope of the strength over the equivalent plastic strain, from that over the yield stress.
    #[inline(always)] // Into the return of each point.
    fn slope_of_strength(&self) -> f64 {
        let (test, yield_stress) = (self.of.test, self.hardening.value);
        let [by_mises, by_pressure] = self.of.shape.slopes(test.mises * yield_stress);
        (by_mises * test.mises - by_pressure * test.pressure) * self.hardening.slope
    }

    /// Returns the state at the apex: the pressure alone returns. Equation (20.10).
    fn at_apex(&self) -> PathState {
        let (ReturnConstants { law, .. }, trial) = (self.of, self.trial);
        let per_pressure = if law.dilatancy > 0.0 { 1.0 / (law.moduli.bulk * law.dilatancy) } else { 0.0 };
        let state = |pressure: f64| {
            let multiplier = (pressure - trial.pressure) * per_pressure;
            let hardening = match law.shape {
                DruckerPragerShape::Linear { .. } => multiplier * self.per_multiplier,
                _ => self.strain_of_work::<false>(-multiplier * pressure * law.dilatancy),
            };
            PathState { pressure, hardening, measure: 0.0 }
        };
        let outside = |pressure: f64| law.apex_pressure(self.strength::<false>(state(pressure).hardening)) - pressure;
        let first = outside(trial.pressure).max(0.0);
        let start = Start { start: trial.pressure, first, guess: trial.pressure + first };
        let size = self.strength_before.abs() + trial.pressure.abs();
        // Softening moves the apex further.
        state(nearby_root(start, f64::INFINITY, ACCURACY * size, outside).unwrap_or(trial.pressure))
    }
}

/// Paths of the lanes of a block.
struct LanePaths<'a> {
    strains: Lanes,
    lines: TableLines<'a>,
    directions: [Lanes; 4],
    per_multiplier: Lanes,
}

impl<'a> LanePaths<'a> {
    #[inline(always)] // Into the update of a block, compiled for the instruction set of the machine.
    fn increment(&self, of: ReturnConstants<'a>, points: &ReturnedPoints, l: usize) -> ReturnIncrement<'a> {
        let mut increment = ReturnIncrement::new(of, points.trial(l), self.strains[l], self.lines.of(l));
        increment.direction = column(&self.directions, l);
        increment.per_multiplier = self.per_multiplier[l];
        increment
    }
}

impl DruckerPrager {
    /// Returns the points of a block to the yield surface, with a law without rate. Leaves to [`StressReturn::update`] what
    /// ends at the apex or beyond the line of the table.
    #[inline(always)] // Into the update of a block, compiled for the instruction set of the machine.
    pub(super) fn return_lanes(&self, states: &mut [Lanes], points: &mut ReturnedPoints) {
        let strains = &mut states[STRAIN];
        match self.shape {
            _ if self.rate.is_some() => (),
            // Each call is compiled for one form, so that its loops have no branch.
            DruckerPragerShape::Linear { friction, ratio: 1.0 } => {
                self.return_shape(DruckerPragerShape::Linear { friction, ratio: 1.0 }, strains, points);
            }
            DruckerPragerShape::Linear { friction, ratio } => {
                self.return_shape(DruckerPragerShape::Linear { friction, ratio }, strains, points);
            }
            DruckerPragerShape::Hyperbolic { friction, apex } => {
                self.return_shape(DruckerPragerShape::Hyperbolic { friction, apex }, strains, points);
            }
            DruckerPragerShape::Exponent { factor, exponent } => {
                self.return_shape(DruckerPragerShape::Exponent { factor, exponent }, strains, points);
            }
        }
    }

    #[inline(always)] // Likewise.
    fn return_shape(&self, shape: DruckerPragerShape, strains: &mut Lanes, points: &mut ReturnedPoints) {
        let of = ReturnConstants { at_rest: 1.0, ..self.constants(shape) };
        let zero = [0.0; LANES];
        let mut starts =
            LaneStarts { start: zero, first: zero, guess: zero, limit: zero, tolerance: zero, open: [0; LANES] };
        let (lines, directions) = (self.hardening.lines(strains), [zero; 4]);
        let mut paths = LanePaths { strains: *strains, lines, directions, per_multiplier: zero };
        let mut apices = [0; LANES];
        for l in 0..LANES {
            let mut increment = paths.increment(of, points, l);
            let [first, size] = increment.first();
            increment.set_flow();
            put_column(&mut paths.directions, l, increment.direction);
            paths.per_multiplier[l] = increment.per_multiplier;
            let ReturnWay { start, limit } = increment.way(first);
            (starts.start[l], starts.first[l], starts.guess[l]) = (start.start, first, start.guess);
            (starts.limit[l], starts.tolerance[l]) = (limit, ACCURACY * size);
            let is_outside = points.open[l] & u64::from(first > 2.0 * ACCURACY * size);
            apices[l] = is_outside & u64::from(points.mises[l] <= 1e-12 * size);
            starts.open[l] = is_outside & (1 - apices[l]);
        }
        if any(&starts.open) {
            self.return_open_lanes(of, &starts, &mut paths, points);
            *strains = paths.strains;
        } else {
            points.stay_elastic();
        }
        for l in 0..LANES {
            points.open[l] |= apices[l];
        }
    }

    /// Returns the lanes with a root.
    #[inline(always)] // Likewise.
    fn return_open_lanes(
        &self,
        of: ReturnConstants<'_>,
        starts: &LaneStarts,
        paths: &mut LanePaths<'_>,
        points: &mut ReturnedPoints,
    ) {
        let [mut pressures, mut hardenings] = [[0.0; LANES]; 2];
        let (arguments, failed) = lane_roots(
            starts,
            #[inline(always)]
            |arguments| {
                let mut values = [0.0; LANES];
                for l in 0..LANES {
                    let increment = paths.increment(of, points, l);
                    let state = increment.state::<true>(arguments[l]);
                    (pressures[l], hardenings[l]) = (state.pressure, state.hardening);
                    values[l] = increment.outside::<true>(state);
                }
                values
            },
        );
        for l in 0..LANES {
            let increment = paths.increment(of, points, l);
            let strain = increment.strain_before + hardenings[l];
            let is_returned = starts.open[l] & (1 - failed[l]) & u64::from(increment.hardening.holds_at(strain));
            let (TrialStress { pressure, deviator, .. }, end) = (increment.trial, increment.deviator(arguments[l]));
            let end = [0, 1, 2, 3].inline_map(|i| if is_returned == 1 { end[i] } else { deviator[i] });
            let mean = if is_returned == 1 { pressures[l] } else { pressure };
            points.return_to_deviator(l, mean, end, (mean - pressure) / self.moduli.bulk);
            points.open[l] = starts.open[l] & (1 - is_returned);
            paths.strains[l] = if is_returned == 1 { strain } else { increment.strain_before };
        }
    }
}

/// Values of the yield function that are zero, over the size of the trial stress.
const ACCURACY: f64 = 1e-12;

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
        let trial = point.trial;
        let strain_before = point.state[STRAIN];
        let (of, hardening) = (self.constants(self.shape), self.hardening.line(strain_before));
        let mut increment = ReturnIncrement::new(of, trial, strain_before, hardening);
        increment.per_dt = if point.dt > 0.0 { 1.0 / point.dt } else { 0.0 };
        let [first, size] = increment.first();
        // A NaN is not returned, so that the run halts.
        if first.is_nan() || first <= 2.0 * ACCURACY * size {
            return point.stay_elastic();
        }
        increment.set_flow();
        let returned = if trial.mises <= 1e-12 * size { None } else { increment.end(first, size) };
        let (PathState { pressure, hardening, .. }, deviator) =
            returned.unwrap_or_else(|| (increment.at_apex(), [0.0; 4]));
        point.state[STRAIN] += hardening;
        point.return_to_deviator(pressure, deviator, (pressure - trial.pressure) / self.moduli.bulk);
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
        let mut increment = ReturnIncrement::new(law.constants(law.shape), trial, 0.0, law.hardening.line(0.0));
        increment.set_flow();
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
