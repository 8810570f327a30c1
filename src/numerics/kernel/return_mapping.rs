//! Return mapping of all lanes of a block, for every flow stress that depends on plastic strain, rate and temperature.
//!
//! Halley's method in the plastic strain increment. If the yield stress is steeper than 3 G: Newton's method in the
//! logarithm of the increment. There, trial - 3 G dp - yield stress is concave for the laws of Johnson and Cook and of
//! Cowper and Symonds, and iterates that start above the root remain above it, also at the onset of flow, where the
//! slope with respect to dp is unbounded.
//!
//! The static yield stress of Johnson and Cook at the end of a small increment is a series about the strain before the
//! increment, where its value is needed in any case; it takes a fifth of the time of a power.
//!
//! Each lane iterates until its own residual converges, independently of the other lanes. A lane that has not converged
//! after some iterations uses the bracketed secants of [`plastic_increment`].
#![allow(clippy::needless_range_loop)] // Compilers vectorize loops over lanes in this form.

use super::hardening::{
    FlowStress, JohnsonCook, LinearTable, RateFactor, StaticYield, TableOverTemperature, plastic_increment,
};
use super::lanes::{LANES, Lanes};
use super::transcendental::{ln_of, power_of};

/// Elastic trial state of the lanes.
#[derive(Clone, Copy, Debug)]
pub struct TrialState<'a> {
    /// Von Mises stress of the elastic trial.
    pub stress: &'a Lanes,
    /// Equivalent plastic strain before the increment.
    pub strain: &'a Lanes,
    /// Temperature before the increment.
    pub temperature: &'a Lanes,
    /// Rate of equivalent plastic strain in the previous increment: start value of the iteration.
    pub rate: &'a Lanes,
    pub shear3: f64,
    /// Length of the increment.
    pub dt: f64,
}

/// Value, first and second derivative.
type CurveLanes = [Lanes; 3];

const ZERO: Lanes = [0.0; LANES];
/// Whether a property holds for each lane: 1 or 0, so that loops over lanes stay in vector registers.
type Flags = [u64; LANES];
/// Index of each lane.
const INDEX: Flags = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
const ROUNDS: usize = 8;
/// Converged residual, relative to the trial stress.
const ENOUGH: f64 = 1e-11;
/// Relative change of the plastic strain increment below which an iteration is the last with Newton's method (also
/// Halley's method on a linear law), whose error is of second order.
const SHORT: f64 = 1e-7;
/// Bound of the relative error after an iteration of Halley's method over the cube of the relative change. It is at most
/// 0.12 for yield stresses that are linear in the logarithm of the rate. If the rate crosses the Johnson-Cook reference
/// rate in the last iteration, the error is a fraction c of the change.
const CUBIC: f64 = 0.25;
/// Largest ratio of increment and strain for the series of the static yield stress. Its error is then below 1e-14 of the
/// part that hardens.
const SMALL: f64 = 1.0 / 64.0;
/// Smallest ratio of successive plastic strain increments in an iteration.
const LEAST: f64 = 0.02;

/// Returns the increments of equivalent plastic strain of the first `count` lanes; zero for elastic lanes. Equation
/// (6.2).
#[inline(always)]
pub fn plastic_increments(law: &FlowStress, trial: TrialState<'_>, count: usize) -> Lanes {
    let TrialState { stress, strain, temperature, rate, shear3, dt } = trial;
    let softening = law.softening(temperature);
    let base = law.static_yield(strain, temperature, &softening);
    let at_rest = law.at_rest(&base[0], temperature);
    let per_dt = if dt > 0.0 { 1.0 / dt } else { 0.0 };
    let (mut increment, mut highest, mut open) = (ZERO, ZERO, [0; LANES]);
    for l in 0..LANES {
        // Upper bound if the yield stress does not decrease.
        let above = if stress[l] > at_rest[l] { stress[l] - at_rest[l] } else { 0.0 };
        let above = if INDEX[l] < count as u64 { above } else { 0.0 };
        open[l] = u64::from(above > 0.0);
        highest[l] = above / shear3;
        let warm = rate[l] * dt;
        let warm = if warm < highest[l] { warm } else { highest[l] };
        increment[l] = if warm > 0.0 { warm } else { highest[l] };
    }
    if !any(&open) {
        return ZERO;
    }
    for _ in 0..ROUNDS {
        let curve = law.after(&base, (strain, &increment), temperature, &softening, per_dt);
        iterate(&curve, (stress, shear3), &highest, &mut increment, &mut open);
        if !any(&open) {
            return increment;
        }
    }
    for l in (0..LANES).filter(|l| open[*l] == 1) {
        increment[l] = plastic_increment(law, stress[l], strain[l], temperature[l], shear3, dt);
    }
    increment
}

#[inline(always)]
fn any(flags: &Flags) -> bool {
    flags.iter().fold(0, |any, flag| any | flag) != 0
}

/// Improves the plastic strain increments of open lanes by one iteration, and closes converged ones. `curve` has the yield
/// stresses and their derivatives at the increments.
#[inline(always)]
fn iterate(
    [yields, slope, bend]: &CurveLanes,
    (stress, shear3): (&Lanes, f64),
    highest: &Lanes,
    increment: &mut Lanes,
    open: &mut Flags,
) {
    let (mut residuals, mut previous, mut steep) = (ZERO, *increment, [0; LANES]);
    for l in 0..LANES {
        let dp = increment[l];
        let residual = stress[l] - shear3 * dp - yields[l];
        let enough = u64::from(residual.abs() <= ENOUGH * stress[l]);
        let remains = open[l] & (1 - enough);
        let per = shear3 + slope[l];
        let bends = 2.0 * per * per + residual * bend[l];
        let halley = 2.0 * residual * per / (if bends > per * per { bends } else { per * per });
        let next = limited(dp + halley, dp, highest[l]);
        increment[l] = if remains == 1 { next } else { dp };
        let change = halley.abs();
        let cubic = CUBIC * shear3 * (change * change) * change > ENOUGH * stress[l] * (dp * dp);
        let goes_on = if bend[l] == 0.0 { change > SHORT * dp } else { cubic };
        open[l] = remains & u64::from(goes_on);
        steep[l] = remains & u64::from(slope[l] > shear3);
        residuals[l] = residual;
    }
    if any(&steep) {
        for l in 0..LANES {
            let dp = previous[l];
            let newton = residuals[l] / (shear3 + slope[l]);
            // From above the root: 1/(1 - x) is not below exp(x).
            let next = if residuals[l] < 0.0 { dp * dp / (dp - newton) } else { increment[l] };
            let next = limited(next, dp, highest[l]);
            previous[l] = if steep[l] == 1 { next } else { increment[l] };
            let goes_on = u64::from(newton.abs() > SHORT * dp);
            open[l] = if steep[l] == 1 { goes_on } else { open[l] };
        }
        *increment = previous;
    }
}

/// Limits the next plastic strain increment after `dp`.
#[inline(always)]
fn limited(next: f64, dp: f64, highest: f64) -> f64 {
    let next = if next > LEAST * dp { next } else { LEAST * dp };
    if next < highest { next } else { highest }
}

impl FlowStress {
    /// Returns the temperature factor of a Johnson-Cook yield stress; 1 for tables.
    #[inline(always)]
    pub(super) fn softening(&self, temperature: &Lanes) -> Lanes {
        match &self.base {
            StaticYield::JohnsonCook(law) => law.softening(temperature),
            StaticYield::Tables(_) => [1.0; LANES],
        }
    }

    /// Returns the yield stress at zero rate from the static one.
    #[inline(always)]
    pub(super) fn at_rest(&self, static_yield: &Lanes, temperature: &Lanes) -> Lanes {
        let mut value = *static_yield;
        if let Some(RateFactor::Ratio(tables)) = &self.factor {
            let [ratio, ..] = tables.lanes(&ZERO, temperature);
            (0..LANES).for_each(|l| value[l] *= ratio[l]);
        }
        value
    }

    /// Returns the static yield stress and its derivatives with respect to strain.
    #[inline(always)]
    pub(super) fn static_yield(&self, strain: &Lanes, temperature: &Lanes, softening: &Lanes) -> CurveLanes {
        match &self.base {
            StaticYield::JohnsonCook(law) => law.lanes(strain, softening),
            StaticYield::Tables(tables) => tables.lanes(strain, temperature),
        }
    }

    /// Returns the yield stress and its derivatives with respect to strain at the end of increments of strain; `base` is
    /// the static yield stress before them. The rate increases by `per_dt` per unit of strain.
    #[inline(always)]
    fn after(
        &self,
        base: &CurveLanes,
        (strain, increment): (&Lanes, &Lanes),
        temperature: &Lanes,
        softening: &Lanes,
        per_dt: f64,
    ) -> CurveLanes {
        let (mut tried, mut rates) = (ZERO, ZERO);
        for l in 0..LANES {
            tried[l] = strain[l] + increment[l];
            rates[l] = increment[l] * per_dt;
        }
        let at_end = match &self.base {
            StaticYield::JohnsonCook(law) => law.after(base, (strain, increment), &tried, softening),
            StaticYield::Tables(tables) => tables.lanes(&tried, temperature),
        };
        self.at_rate(at_end, &rates, temperature, per_dt)
    }

    /// Returns the yield stress and its derivatives with respect to strain.
    #[inline(always)]
    pub(super) fn lanes(
        &self,
        strain: &Lanes,
        rate: &Lanes,
        temperature: &Lanes,
        softening: &Lanes,
        per_dt: f64,
    ) -> CurveLanes {
        self.at_rate(self.static_yield(strain, temperature, softening), rate, temperature, per_dt)
    }

    /// Multiplies a static yield stress by the rate factor; the rate increases by `per_dt` per unit of strain.
    #[inline(always)]
    fn at_rate(&self, static_yield: CurveLanes, rate: &Lanes, temperature: &Lanes, per_dt: f64) -> CurveLanes {
        let [mut value, mut slope, mut bend] = static_yield;
        if let Some(factor) = &self.factor {
            let [times, grows, bends] = factor.lanes(rate, temperature);
            for l in 0..LANES {
                let (grows, bends) = (grows[l] * per_dt, bends[l] * per_dt * per_dt);
                bend[l] = bend[l] * times[l] + 2.0 * slope[l] * grows + value[l] * bends;
                slope[l] = slope[l] * times[l] + value[l] * grows;
                value[l] *= times[l];
            }
        }
        [value, slope, bend]
    }
}

impl JohnsonCook {
    #[inline(always)]
    fn softening(&self, temperature: &Lanes) -> Lanes {
        let per = 1.0 / (self.melt - self.transition);
        let (mut theta, mut warm) = (ZERO, 0);
        for l in 0..LANES {
            let t = (temperature[l] - self.transition) * per;
            theta[l] = if t < 1.0 { t } else { 1.0 };
            warm |= u64::from(t > 0.0);
        }
        let mut factors = [1.0; LANES];
        if warm != 0 {
            for l in 0..LANES {
                factors[l] = 1.0 - power_of(theta[l], self.m);
            }
        }
        factors
    }

    /// Equation (6.5).
    #[inline(always)]
    fn lanes(&self, strain: &Lanes, softening: &Lanes) -> CurveLanes {
        let [mut value, mut slope, mut bend] = [ZERO; 3];
        for l in 0..LANES {
            let hardened = self.b * power_of(strain[l], self.n);
            let per = if strain[l] > 0.0 { 1.0 / strain[l] } else { 0.0 };
            value[l] = (self.a + hardened) * softening[l];
            slope[l] = self.n * hardened * per * softening[l];
            bend[l] = (self.n - 1.0) * slope[l] * per;
        }
        [value, slope, bend]
    }

    /// Returns the yield stress after increments of strain, from that before them: the binomial series for small
    /// increments, otherwise the power of the strain at the end.
    #[inline(always)]
    fn after(
        &self,
        [value, slope, bend]: &CurveLanes,
        (strain, increment): (&Lanes, &Lanes),
        end: &Lanes,
        softening: &Lanes,
    ) -> CurveLanes {
        let n = self.n;
        // Coefficients of ((1 + x)^n - 1)/(n x).
        let c1 = (n - 1.0) * (1.0 / 2.0);
        let c2 = c1 * (n - 2.0) * (1.0 / 3.0);
        let c3 = c2 * (n - 3.0) * (1.0 / 4.0);
        let c4 = c3 * (n - 4.0) * (1.0 / 5.0);
        let c5 = c4 * (n - 5.0) * (1.0 / 6.0);
        let mut curve = [ZERO; 3];
        let mut large = [0; LANES];
        for l in 0..LANES {
            let dp = increment[l];
            large[l] = u64::from(dp > SMALL * strain[l]);
            let x = if strain[l] > 0.0 { dp / strain[l] } else { 0.0 };
            let series = 1.0 + x * (c1 + x * (c2 + x * (c3 + x * (c4 + x * c5))));
            curve[0][l] = value[l] + slope[l] * dp * series;
            curve[1][l] = slope[l] * (1.0 + x * (2.0 * c1 + x * (3.0 * c2)));
            curve[2][l] = bend[l] * (1.0 + x * (n - 2.0));
        }
        if any(&large) {
            let exact = self.lanes(end, softening);
            for l in 0..LANES {
                for (list, exact) in curve.iter_mut().zip(&exact) {
                    list[l] = if large[l] == 1 { exact[l] } else { list[l] };
                }
            }
        }
        curve
    }
}

impl RateFactor {
    /// Returns the rate factor and its derivatives with respect to the rate.
    #[inline(always)]
    fn lanes(&self, rate: &Lanes, temperature: &Lanes) -> CurveLanes {
        let [mut value, mut slope, mut bend] = [[1.0; LANES], ZERO, ZERO];
        match self {
            RateFactor::JohnsonCook { c, reference } => {
                let per_reference = 1.0 / reference;
                for l in 0..LANES {
                    let ratio = rate[l] * per_reference;
                    let above = ratio > 1.0;
                    value[l] = 1.0 + c * ln_of(if above { ratio } else { 1.0 });
                    let per = if above { 1.0 / rate[l] } else { 0.0 };
                    slope[l] = c * per;
                    bend[l] = -slope[l] * per;
                }
            }
            RateFactor::PowerLaw { d, n } => {
                let ([d, ..], [n, ..]) = (d.lanes(temperature), n.lanes(temperature));
                for l in 0..LANES {
                    let inverse = 1.0 / n[l];
                    let power = power_of(rate[l] / d[l], inverse);
                    value[l] = 1.0 + power;
                    let per = if rate[l] > 0.0 { 1.0 / rate[l] } else { 0.0 };
                    slope[l] = inverse * power * per;
                    bend[l] = (inverse - 1.0) * slope[l] * per;
                }
            }
            RateFactor::Ratio(tables) => return tables.lanes(rate, temperature),
        }
        [value, slope, bend]
    }
}

impl TableOverTemperature {
    /// Returns values and slopes: interpolation between the tables around each temperature.
    #[inline(always)]
    fn lanes(&self, at: &Lanes, temperature: &Lanes) -> CurveLanes {
        let Some((first, rest)) = self.tables.split_first() else { return [ZERO; 3] };
        let [mut value, mut slope, straight] = first.1.lanes(at);
        let mut below = first.0;
        for (above, table) in rest {
            let [over, steeper, _] = table.lanes(at);
            let per = 1.0 / (above - below);
            for l in 0..LANES {
                // Weight 0 for temperatures below this interval, 1 above it.
                let share = (temperature[l] - below) * per;
                let share = if share > 0.0 { share } else { 0.0 };
                let share = if share < 1.0 { share } else { 1.0 };
                value[l] += share * (over[l] - value[l]);
                slope[l] += share * (steeper[l] - slope[l]);
            }
            below = *above;
        }
        [value, slope, straight]
    }
}

impl LinearTable {
    /// Returns values and slopes; each row overwrites the lanes at and above its abscissa.
    #[inline(always)]
    fn lanes(&self, at: &Lanes) -> CurveLanes {
        let Some(last) = self.rows.last() else { return [ZERO; 3] };
        let (mut value, mut slope) = ([self.rows[0][0]; LANES], ZERO);
        for row in self.rows.windows(2) {
            let steep = (row[1][0] - row[0][0]) / (row[1][1] - row[0][1]);
            for l in 0..LANES {
                let above = at[l] >= row[0][1];
                value[l] = if above { row[0][0] + steep * (at[l] - row[0][1]) } else { value[l] };
                slope[l] = if above { steep } else { slope[l] };
            }
        }
        for l in 0..LANES {
            let above = at[l] >= last[1];
            value[l] = if above { last[0] } else { value[l] };
            slope[l] = if above { 0.0 } else { slope[l] };
        }
        [value, slope, ZERO]
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::kernel::hardening::YieldStress;

    fn table(rows: &[[f64; 2]], factor: f64) -> LinearTable {
        LinearTable { rows: rows.iter().map(|r| [r[0] * factor, r[1]]).collect() }
    }

    /// Returns every law with every rate factor, in MPa, at 20 to 900 degrees.
    pub fn laws() -> Vec<FlowStress> {
        let rows = [[400.0, 0.0], [480.0, 0.02], [520.0, 0.1], [600.0, 0.4]];
        let over = |a: f64, b: f64| LinearTable { rows: vec![[a, 20.0], [b, 600.0]] };
        let tables = vec![(20.0, table(&rows, 1.0)), (300.0, table(&rows, 0.7)), (800.0, table(&rows, 0.2))];
        let steel = JohnsonCook { a: 806.0, b: 614.0, n: 0.168, m: 1.1, melt: 1540.0, transition: 20.0 };
        let copper = JohnsonCook { a: 90.0, b: 292.0, n: 0.31, m: 1.09, melt: 1083.0, transition: 20.0 };
        let soft = JohnsonCook { a: 1.0, b: 400.0, n: 0.05, m: 0.5, melt: 700.0, transition: 20.0 };
        let bases = [
            StaticYield::Tables(TableOverTemperature { tables: tables[..1].to_vec() }),
            StaticYield::Tables(TableOverTemperature { tables }),
            StaticYield::JohnsonCook(steel),
            StaticYield::JohnsonCook(copper),
            StaticYield::JohnsonCook(soft),
        ];
        let ratios = TableOverTemperature {
            tables: vec![(20.0, LinearTable { rows: vec![[1.0, 0.0], [1.2, 100.0], [1.9, 1e6]] })],
        };
        let factors = [
            None,
            Some(RateFactor::JohnsonCook { c: 0.0089, reference: 1.0 }),
            Some(RateFactor::JohnsonCook { c: 0.3, reference: 1e-3 }),
            Some(RateFactor::PowerLaw { d: over(40.0, 80.0), n: over(5.0, 3.0) }),
            Some(RateFactor::Ratio(ratios)),
        ];
        let with = |base: &StaticYield| factors.clone().map(|factor| FlowStress { base: base.clone(), factor });
        bases.iter().flat_map(with).collect()
    }

    /// Lanes return to the yield surface: for trial stresses from just above it to a thousand times the yield stress,
    /// at the onset of flow and far into it, for any increment length and start rate; elastic lanes are unchanged.
    #[test]
    fn lanes_return_to_the_yield_surface() {
        let (mut worst, mut tried): (f64, u32) = (0.0, 0);
        for law in laws() {
            for (i, past) in [1e-9, 1e-4, 0.01, 0.3, 3.0, 1000.0].into_iter().enumerate() {
                for dt in [1e-9, 1e-7, 1e-3, 1.0, 0.0] {
                    for strain in [0.0, 1e-12, 1e-3, 0.02, 0.5] {
                        let temperatures = [20.0, 0.0, 21.0, 100.0, 300.0, 450.0, 640.0, 900.0];
                        let temperature = std::array::from_fn(|l| temperatures[l % 8]);
                        let strains = [strain; LANES];
                        let static_yield: Lanes = std::array::from_fn(|l| law.at(strain, 0.0, temperature[l]));
                        let stress =
                            std::array::from_fn(|l| (static_yield[l] + 1e-3) * (1.0 + past) * f64::from(l != 2));
                        let rate = std::array::from_fn(|l| [0.0, 1.0, 1e3, 1e9][(l + i) % 4]);
                        let trial = TrialState {
                            stress: &stress,
                            strain: &strains,
                            temperature: &temperature,
                            rate: &rate,
                            shear3: 240_000.0,
                            dt,
                        };
                        let increments = plastic_increments(&law, trial, LANES);
                        assert_eq!(increments[2], 0.0);
                        for l in (0..LANES).filter(|l| *l != 2) {
                            let per_dt = if dt > 0.0 { increments[l] / dt } else { 0.0 };
                            let yields = law.at(strain + increments[l], per_dt, temperature[l]);
                            let off = ((stress[l] - 240_000.0 * increments[l] - yields) / stress[l]).abs();
                            assert!(
                                increments[l] > 0.0 || stress[l] <= static_yield[l] * (1.0 + 1e-13),
                                "{law:?} {trial:?}"
                            );
                            assert!(off < 1e-10, "{off:e} {law:?} {trial:?} {increments:?}");
                            worst = worst.max(off);
                            tried += 1;
                        }
                    }
                }
            }
        }
        println!("{tried} returns, off by {worst:e} of the trial stress at most");
    }

    /// The result of a lane is independent of the other lanes.
    #[test]
    fn lanes_are_independent() {
        for law in laws() {
            let stress: Lanes = std::array::from_fn(|l| 300.0 + 100.0 * l as f64);
            let (strain, temperature, rate) = ([0.01; LANES], [100.0; LANES], [1e3; LANES]);
            let (shear3, dt) = (240_000.0, 1e-7);
            let trial =
                TrialState { stress: &stress, strain: &strain, temperature: &temperature, rate: &rate, shear3, dt };
            let together = plastic_increments(&law, trial, LANES);
            for l in 0..LANES {
                let same = [stress[l]; LANES];
                let alone = plastic_increments(&law, TrialState { stress: &same, ..trial }, 1);
                assert_eq!(alone[0].to_bits(), together[l].to_bits());
            }
        }
    }
}
