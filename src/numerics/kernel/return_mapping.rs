//! Return mapping of all lanes of a block, for every flow stress that depends on plastic strain, rate and temperature.
//!
//! Halley's method in the plastic strain increment. If the yield stress is steeper than 3 G: Newton's method in the
//! logarithm of the increment. There, trial - 3 G dp - yield stress is concave for the laws of Johnson and Cook and of
//! Cowper and Symonds, and iterates that start above the root remain above it, also at the onset of flow, where the
//! slope with respect to dp is unbounded.
//!
//! The first iteration expands the static yield stress about the strain before the increment, where its value is needed in
//! any case.
//!
//! Each lane iterates until its own residual converges, independently of the other lanes. A lane that has not converged
//! after some iterations uses the bracketed secants of [`plastic_increment`].
#![allow(clippy::needless_range_loop)] // Compilers vectorize loops over lanes in this form.

use super::hardening::{
    FlowStress, JohnsonCook, LinearTable, RateFactor, StaticYield, TableOverTemperature, plastic_increment,
};
use super::lanes::{LANES, Lanes};
use super::transcendental::{ln, power};

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
/// Smallest ratio of successive plastic strain increments in an iteration.
const LEAST: f64 = 0.02;

/// Returns the increments of equivalent plastic strain of the first `count` lanes; zero for elastic lanes.
#[inline(always)]
pub fn plastic_increments(law: &FlowStress, trial: TrialState<'_>, count: usize) -> Lanes {
    let TrialState { stress, strain, temperature, rate, shear3, dt } = trial;
    let softening = law.softening(temperature);
    let base = law.static_yield(strain, temperature, &softening);
    let at_rest = law.at_rest(&base[0], temperature);
    let mut flows = false;
    for l in 0..count {
        flows |= stress[l] > at_rest[l];
    }
    if !flows {
        return ZERO;
    }
    let per_dt = if dt > 0.0 { 1.0 / dt } else { 0.0 };
    let (mut increment, mut highest, mut open) = (ZERO, ZERO, [false; LANES]);
    for l in 0..LANES {
        // Upper bound if the yield stress does not decrease.
        open[l] = l < count && stress[l] > at_rest[l];
        highest[l] = if open[l] { (stress[l] - at_rest[l]) / shear3 } else { 0.0 };
        let warm = rate[l] * dt;
        increment[l] = if warm > 0.0 && warm < highest[l] { warm } else { highest[l] };
    }
    let mut rates = ZERO;
    (0..LANES).for_each(|l| rates[l] = increment[l] * per_dt);
    let expanded = expand(&base, strain, &increment);
    let [yields, slope, bend] = law.at_rate(expanded, &rates, temperature, per_dt);
    for l in 0..LANES {
        let residual = stress[l] - shear3 * increment[l] - yields[l];
        let [next, _] = improve(residual, [slope[l], bend[l]], increment[l], (shear3, highest[l]));
        increment[l] = if open[l] { next } else { increment[l] };
    }
    for _ in 0..ROUNDS {
        let mut tried = ZERO;
        for l in 0..LANES {
            tried[l] = strain[l] + increment[l];
            rates[l] = increment[l] * per_dt;
        }
        let [yields, slope, bend] = law.lanes(&tried, &rates, temperature, &softening, per_dt);
        let mut left = false;
        for l in 0..LANES {
            let residual = stress[l] - shear3 * increment[l] - yields[l];
            let enough = residual.abs() <= ENOUGH * stress[l];
            open[l] &= !enough;
            let dp = increment[l];
            let [next, newton] = improve(residual, [slope[l], bend[l]], dp, (shear3, highest[l]));
            increment[l] = if open[l] { next } else { dp };
            let change = newton.abs();
            let cubic = CUBIC * shear3 * (change * change) * change > ENOUGH * stress[l] * (dp * dp);
            let quadratic = change > SHORT * dp;
            open[l] &= if slope[l] > shear3 || bend[l] == 0.0 { quadratic } else { cubic };
            left |= open[l];
        }
        if !left {
            return increment;
        }
    }
    for l in (0..LANES).filter(|l| open[*l]) {
        increment[l] = plastic_increment(law, stress[l], strain[l], temperature[l], shear3, dt);
    }
    increment
}

/// Returns an improved plastic strain increment and the change by Newton's method. `slope` and `bend` are derivatives of
/// the yield stress at the increment `dp`.
#[inline(always)]
fn improve(residual: f64, [slope, bend]: [f64; 2], dp: f64, (shear3, highest): (f64, f64)) -> [f64; 2] {
    let per = shear3 + slope;
    let newton = residual / per;
    let bends = 2.0 * per * per + residual * bend;
    let halley = 2.0 * residual * per / (if bends > per * per { bends } else { per * per });
    // From above the root: 1/(1 - x) is not below exp(x).
    let steep = residual < 0.0 && slope > shear3;
    let next = if steep { dp * dp / (dp - newton) } else { dp + halley };
    let next = if next > LEAST * dp { next } else { LEAST * dp };
    [if next < highest { next } else { highest }, newton]
}

/// Expands the static yield stress at a strain by an increment, as far as the increment is small compared with the strain.
#[inline(always)]
fn expand([value, slope, bend]: &CurveLanes, strain: &Lanes, increment: &Lanes) -> CurveLanes {
    let [mut expanded, mut steep, mut bends] = [ZERO; 3];
    for l in 0..LANES {
        let dp = if increment[l] < 0.5 * strain[l] { increment[l] } else { 0.0 };
        expanded[l] = value[l] + (slope[l] + 0.5 * bend[l] * dp) * dp;
        steep[l] = if dp > 0.0 { slope[l] + bend[l] * dp } else { 0.0 };
        bends[l] = if dp > 0.0 { bend[l] } else { 0.0 };
    }
    [expanded, steep, bends]
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

    /// Returns the yield stress and its derivatives with respect to strain; the rate increases by `per_dt` per unit of
    /// strain.
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
        let mut theta = ZERO;
        let mut warm = false;
        for l in 0..LANES {
            let t = (temperature[l] - self.transition) / (self.melt - self.transition);
            theta[l] = if t >= 1.0 { 1.0 } else { t };
            warm |= t > 0.0;
        }
        if !warm {
            return [1.0; LANES];
        }
        let power = power(&theta, &[self.m; LANES]);
        let mut left = ZERO;
        for l in 0..LANES {
            left[l] = 1.0 - power[l];
        }
        left
    }

    #[inline(always)]
    fn lanes(&self, strain: &Lanes, softening: &Lanes) -> CurveLanes {
        let power = power(strain, &[self.n; LANES]);
        let [mut value, mut slope, mut bend] = [ZERO; 3];
        for l in 0..LANES {
            let hardened = self.b * power[l];
            let per = if strain[l] > 0.0 { 1.0 / strain[l] } else { 0.0 };
            value[l] = (self.a + hardened) * softening[l];
            slope[l] = self.n * hardened * per * softening[l];
            bend[l] = (self.n - 1.0) * slope[l] * per;
        }
        [value, slope, bend]
    }
}

impl RateFactor {
    /// Returns the rate factor and its derivatives with respect to the rate.
    #[inline(always)]
    fn lanes(&self, rate: &Lanes, temperature: &Lanes) -> CurveLanes {
        let [mut value, mut slope, mut bend] = [[1.0; LANES], ZERO, ZERO];
        match self {
            RateFactor::JohnsonCook { c, reference } => {
                let mut ratio = ZERO;
                for l in 0..LANES {
                    ratio[l] = rate[l] / reference;
                    ratio[l] = if ratio[l] > 1.0 { ratio[l] } else { 1.0 };
                }
                let log = ln(&ratio);
                for l in 0..LANES {
                    value[l] = 1.0 + c * log[l];
                    let per = if ratio[l] > 1.0 { 1.0 / rate[l] } else { 0.0 };
                    slope[l] = c * per;
                    bend[l] = -slope[l] * per;
                }
            }
            RateFactor::PowerLaw { d, n } => {
                let ([d, ..], [n, ..]) = (d.lanes(temperature), n.lanes(temperature));
                let (mut ratio, mut inverse) = (ZERO, ZERO);
                for l in 0..LANES {
                    ratio[l] = rate[l] / d[l];
                    inverse[l] = 1.0 / n[l];
                }
                let power = power(&ratio, &inverse);
                for l in 0..LANES {
                    value[l] = 1.0 + power[l];
                    let per = if rate[l] > 0.0 { 1.0 / rate[l] } else { 0.0 };
                    slope[l] = inverse[l] * power[l] * per;
                    bend[l] = (inverse[l] - 1.0) * slope[l] * per;
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
                        let rest: Lanes = std::array::from_fn(|l| law.at(strain, 0.0, temperature[l]));
                        let stress = std::array::from_fn(|l| (rest[l] + 1e-3) * (1.0 + past) * f64::from(l != 2));
                        let rate = std::array::from_fn(|l| [0.0, 1.0, 1e3, 1e9][(l + i) % 4]);
                        let trial = TrialState {
                            stress: &stress,
                            strain: &strains,
                            temperature: &temperature,
                            rate: &rate,
                            shear3: 240_000.0,
                            dt,
                        };
                        let found = plastic_increments(&law, trial, LANES);
                        assert_eq!(found[2], 0.0);
                        for l in (0..LANES).filter(|l| *l != 2) {
                            let per_dt = if dt > 0.0 { found[l] / dt } else { 0.0 };
                            let yields = law.at(strain + found[l], per_dt, temperature[l]);
                            let off = ((stress[l] - 240_000.0 * found[l] - yields) / stress[l]).abs();
                            assert!(found[l] > 0.0 || stress[l] <= rest[l] * (1.0 + 1e-13), "{law:?} {trial:?}");
                            assert!(off < 1e-10, "{off:e} {law:?} {trial:?} {found:?}");
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
