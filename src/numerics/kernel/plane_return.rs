//! Return mapping in plane stress for all lanes of a block, for every flow stress that depends on plastic strain, rate and
//! temperature. Equations: [`super::plane_stress`].
//!
//! Newton's method in the unknown x. If the yield stress increases more steeply than the trial stress decreases, Newton's
//! method in the logarithm of x, as in [`super::return_mapping`]. Each lane iterates independently of the other lanes. A
//! lane that has not converged after some iterations uses bracketed secants ([`PlaneElastic`]).
#![allow(clippy::needless_range_loop)] // Compilers vectorize loops over lanes in this form.

use super::hardening::FlowStress;
use super::lanes::{InlineMap, LANES, Lanes};
use super::plane_stress::PlaneElastic;

/// Elastic trial state of the lanes.
#[derive(Clone, Copy, Debug)]
pub struct PlaneTrial<'a> {
    /// Elastic trial stress along meridian and hoop.
    pub stress: &'a [Lanes; 2],
    /// Equivalent plastic strain before the increment.
    pub strain: &'a Lanes,
    /// Temperature before the increment.
    pub temperature: &'a Lanes,
    /// Length of the increment.
    pub dt: f64,
}

/// Results of the lanes, as in [`super::plane_stress::PlaneReturn`].
#[derive(Clone, Copy, Debug)]
pub struct PlaneReturns {
    pub stress: [Lanes; 2],
    pub flow: Lanes,
    pub plastic: [Lanes; 2],
}

const ZERO: Lanes = [0.0; LANES];
const ROUNDS: usize = 8;
/// Converged residual, relative to the trial stress.
const ENOUGH: f64 = 1e-12;
/// Relative change of the unknown below which an iteration is the last; the error is of second order.
const SHORT: f64 = 1e-7;
/// Smallest ratio of successive values of the unknown.
const LEAST: f64 = 0.02;

/// Yield condition of the lanes as a function of the unknown x.
struct PlaneYield<'a> {
    law: &'a FlowStress,
    trial: PlaneTrial<'a>,
    softening: Lanes,
    /// Squares of p and of sqrt(3) d of the trial stress.
    squares: [Lanes; 2],
    /// Coefficients of x in the denominators of p and d.
    rates: [f64; 2],
    per_dt: f64,
}

/// Residual of the yield condition and its parts.
struct YieldResidual {
    value: Lanes,
    /// Derivatives of the von Mises stress and of the yield stress with respect to x.
    slopes: [Lanes; 2],
}

impl PlaneYield<'_> {
    /// Returns the von Mises stress and its derivative with respect to x. Equation (8.4).
    #[inline(always)]
    fn mises(&self, x: &Lanes) -> [Lanes; 2] {
        let ([a, b], [p, d]) = (self.rates, &self.squares);
        let (mut mises, mut slope) = (ZERO, ZERO);
        for l in 0..LANES {
            let (u, v) = (1.0 / (1.0 + a * x[l]), 1.0 / (1.0 + b * x[l]));
            let (p, d) = (p[l] * u * u, d[l] * v * v);
            mises[l] = 0.5 * (p + d).sqrt();
            slope[l] = -0.25 * (p * u * a + d * v * b) / mises[l];
        }
        [mises, slope]
    }

    #[inline(always)]
    fn residual(&self, x: &Lanes) -> YieldResidual {
        let [mises, slope] = self.mises(x);
        let (mut strain, mut rate, mut growth) = (ZERO, ZERO, ZERO);
        for l in 0..LANES {
            let flow = 2.0 / 3.0 * x[l] * mises[l];
            strain[l] = self.trial.strain[l] + flow;
            rate[l] = flow * self.per_dt;
            growth[l] = 2.0 / 3.0 * (mises[l] + x[l] * slope[l]);
        }
        let [yields, steep, _] = self.law.lanes(&strain, &rate, self.trial.temperature, &self.softening, self.per_dt);
        let (mut value, mut hardening) = (ZERO, ZERO);
        for l in 0..LANES {
            value[l] = mises[l] - yields[l];
            hardening[l] = steep[l] * growth[l];
        }
        YieldResidual { value, slopes: [slope, hardening] }
    }
}

impl PlaneElastic {
    /// Returns the trial stresses of the first `count` lanes to the yield stress at the resulting plastic strains and
    /// rates.
    #[inline(always)]
    pub fn returned_lanes(&self, law: &FlowStress, trial: PlaneTrial<'_>, count: usize) -> PlaneReturns {
        let [s, h] = trial.stress;
        let mut squares = [ZERO; 2];
        for l in 0..LANES {
            squares[0][l] = (s[l] + h[l]) * (s[l] + h[l]);
            squares[1][l] = 3.0 * (s[l] - h[l]) * (s[l] - h[l]);
        }
        let rates = self.scaling_rates();
        let softening = law.softening(trial.temperature);
        let per_dt = if trial.dt > 0.0 { 1.0 / trial.dt } else { 0.0 };
        let yields = PlaneYield { law, trial, softening, squares, rates, per_dt };
        let x = self.unknowns(&yields, count);
        let mut returned = PlaneReturns { stress: *trial.stress, flow: ZERO, plastic: [ZERO; 2] };
        for l in 0..LANES {
            let flowed = self.flowed([s[l], h[l]], x[l]);
            let flows = x[l] > 0.0 || x[l].is_nan();
            for axis in 0..2 {
                returned.stress[axis][l] = if flows { flowed.stress[axis] } else { trial.stress[axis][l] };
                returned.plastic[axis][l] = if flows { flowed.plastic[axis] } else { 0.0 };
            }
            returned.flow[l] = if flows { flowed.flow } else { 0.0 };
        }
        returned
    }

    /// Returns the unknown x of each lane; 0 for elastic lanes.
    #[inline(always)]
    fn unknowns(&self, yields: &PlaneYield<'_>, count: usize) -> Lanes {
        let trial = yields.trial;
        let [static_yield, ..] = yields.law.static_yield(trial.strain, trial.temperature, &yields.softening);
        let at_rest = yields.law.at_rest(&static_yield, trial.temperature);
        let [stress, slope] = yields.mises(&ZERO);
        let (mut x, mut open, mut flows) = (ZERO, [false; LANES], false);
        for l in 0..LANES {
            open[l] = l < count && stress[l] > at_rest[l];
            // The root without hardening, if the trial stress is near the yield stress.
            x[l] = if open[l] { (stress[l] - at_rest[l]) / -slope[l] } else { 0.0 };
            flows |= open[l];
        }
        if !flows {
            return ZERO;
        }
        for _ in 0..ROUNDS {
            let YieldResidual { value, slopes: [falls, rises] } = yields.residual(&x);
            let mut is_open = false;
            for l in 0..LANES {
                open[l] &= value[l].abs() > ENOUGH * stress[l] || value[l].is_nan();
                let change = value[l] / (rises[l] - falls[l]);
                let is_steep = value[l] < 0.0 && rises[l] > -falls[l];
                let next = if is_steep { x[l] * x[l] / (x[l] - change) } else { x[l] + change };
                let next = if next > LEAST * x[l] { next } else { LEAST * x[l] };
                x[l] = if open[l] { next } else { x[l] };
                open[l] &= change.abs() > SHORT * x[l] || change.is_nan();
                is_open |= open[l];
            }
            if !is_open {
                return x;
            }
        }
        for l in (0..LANES).filter(|l| open[*l]) {
            let stress = trial.stress.inline_map(|list| list[l]);
            x[l] = self.unknown(yields.law, stress, [trial.strain[l], trial.temperature[l]], trial.dt).unwrap_or(0.0);
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::{LANES, Lanes, PlaneTrial};
    use crate::kernel::hardening::YieldStress;
    use crate::kernel::plane_stress::{PlaneElastic, mises};
    use crate::kernel::return_mapping::tests::laws;

    const STEEL: PlaneElastic = PlaneElastic { young: 200e3, ratio: 0.3 };

    /// Lanes return to the yield surface for every law, from trial stresses just above it to far outside, at the onset
    /// of flow and far into it, for any increment length, as the bracketed secants do; elastic lanes are unchanged.
    #[test]
    fn lanes_return_to_the_yield_surface() {
        let mut worst: f64 = 0.0;
        for law in laws() {
            for past in [1e-9, 1e-4, 0.01, 0.3, 3.0] {
                for (dt, strain) in [(1e-9, 0.0), (1e-7, 1e-12), (1e-3, 1e-3), (1.0, 0.02), (0.0, 0.5)] {
                    let temperature: Lanes = std::array::from_fn(|l| [20.0, 0.0, 100.0, 450.0, 640.0][l % 5]);
                    let strains = [strain; LANES];
                    let direction = |l: usize| (0.4 * l as f64).sin_cos();
                    let stress: [Lanes; 2] = std::array::from_fn(|axis| {
                        std::array::from_fn(|l| {
                            let ((sin, cos), rest) = (direction(l), law.at(strain, 0.0, temperature[l]));
                            let size = (rest + 1e-3) * (1.0 + past) / mises([sin, cos]);
                            size * [sin, cos][axis] * if l == 2 { 0.5 / (1.0 + past) } else { 1.0 }
                        })
                    });
                    let trial = PlaneTrial { stress: &stress, strain: &strains, temperature: &temperature, dt };
                    let returned = STEEL.returned_lanes(&law, trial, LANES);
                    assert_eq!(returned.flow[2], 0.0);
                    for l in (0..LANES).filter(|l| *l != 2) {
                        let stress_of_lane = stress.map(|list| list[l]);
                        let alone = STEEL.returned(&law, stress_of_lane, [strain, temperature[l]], dt);
                        let per_dt = if dt > 0.0 { returned.flow[l] / dt } else { 0.0 };
                        let off = mises(returned.stress.map(|list| list[l]))
                            - law.at(strain + returned.flow[l], per_dt, temperature[l]);
                        let off = off.abs() / mises(stress_of_lane);
                        assert!(off < 1e-10, "{off:e} {law:?} {past} {dt} {strain} {l}");
                        let apart = (0..2).map(|i| (returned.stress[i][l] - alone.stress[i]).abs()).fold(0.0, f64::max);
                        assert!(apart < 1e-9 * mises(stress_of_lane), "{apart:e} {law:?} {past} {dt} {strain} {l}");
                        worst = worst.max(off);
                    }
                }
            }
        }
        println!("off by {worst:e} of the trial stress at most");
    }

    /// The result of a lane is independent of the other lanes.
    #[test]
    fn lanes_are_independent() {
        for law in laws() {
            let stress: [Lanes; 2] =
                std::array::from_fn(|axis| std::array::from_fn(|l| 300.0 + 100.0 * (l * (axis + 1)) as f64));
            let (strain, temperature) = ([0.01; LANES], [100.0; LANES]);
            let trial = PlaneTrial { stress: &stress, strain: &strain, temperature: &temperature, dt: 1e-7 };
            let together = STEEL.returned_lanes(&law, trial, LANES);
            for l in 0..LANES {
                let same = stress.map(|list| [list[l]; LANES]);
                let alone = STEEL.returned_lanes(&law, PlaneTrial { stress: &same, ..trial }, 1);
                assert_eq!(alone.flow[0].to_bits(), together.flow[l].to_bits());
            }
        }
    }
}
