//! Yield and isotropic hardening of von Mises plasticity.

use crate::kernel::hardening::FlowStress;
use crate::kernel::heating::PlasticHeating;
use crate::kernel::lanes::LANES;
use crate::kernel::lanes::Lanes;
use crate::kernel::return_mapping::{TrialState, plastic_increments};
use crate::material::PointValue;
use crate::material::carried::{CarriedState, carried_state};
use crate::state::archive::Persist;

/// Hardening law of von Mises plasticity. Materials without yield use [`ElasticOnly`], which has no state.
pub trait HardeningLaw: Send + Sync + 'static {
    /// State variables of a block of elements.
    type State: Clone + Send + Sync + Persist + CarriedState;

    /// Whether the material can yield.
    const PLASTIC: bool;

    /// Whether the law has a back stress.
    const BACKSTRESS: bool = false;

    /// Whether plastic work can heat the material.
    const HEATS: bool = false;

    /// Returns the state of a block that has never yielded.
    fn fresh(&self) -> Self::State;

    /// Computes the equivalent plastic strain increments of a block from the elastic trial.
    fn flow(&self, state: &mut Self::State, flow: &mut FlowUpdate<'_>);

    /// Returns the back stress: rr, zz, hoop, rz.
    fn back_stress(&self, _state: &Self::State) -> [Lanes; 4] {
        [[0.0; LANES]; 4]
    }

    /// Updates the back stress with the plastic strain, from the rotated previous back stress, the trial stress
    /// relative to it, its von Mises stress, the plastic strain increments, and the factors on the stress of a damaged
    /// material, if it can be damaged.
    fn update_back_stress(
        &self,
        _state: &mut Self::State,
        _carried: &[Lanes; 4],
        _relative: &[Lanes; 4],
        _trial: &Lanes,
        _flow: &Lanes,
        _remaining: Option<&Lanes>,
    ) {
    }

    /// Returns the equivalent plastic strain of a lane.
    fn plastic_strain(&self, state: &Self::State, lane: usize) -> f64;

    /// Returns the temperature of a lane, if the law computes it.
    fn temperature(&self, _state: &Self::State, _lane: usize) -> Option<f64> {
        None
    }

    /// Sets a value of a lane: a temperature, or the equivalent plastic strain if only this variable determines the
    /// hardening. Returns whether the law uses it.
    fn set(&self, _state: &mut Self::State, _lane: usize, _value: PointValue) -> bool {
        false
    }
}

/// Inputs and results of a hardening law for one block.
pub struct FlowUpdate<'a> {
    /// Von Mises stress of the elastic trial.
    pub trial: &'a Lanes,
    /// Part of the previous stress along the plastic flow; only for laws with [`HardeningLaw::HEATS`].
    pub previous: &'a Lanes,
    /// Three shear moduli.
    pub shear3: f64,
    /// Length of the increment; 0 at the start.
    pub dt: f64,
    /// Lanes that hold elements.
    pub count: usize,
    /// Factors on the stress of a damaged material before the increment: the plastic work that heats is that of the
    /// remaining stress. `None` if the material cannot be damaged.
    pub remaining: Option<&'a Lanes>,
    /// Result: equivalent plastic strain increments, zero in lanes that hold no element. It contains numbers of another
    /// block on entry.
    pub increment: &'a mut Lanes,
}

/// Returns the factor on the stress of a lane; 1 for a material that cannot be damaged.
pub(super) fn share_of(remaining: Option<&Lanes>, lane: usize) -> f64 {
    remaining.map_or(1.0, |remaining| remaining[lane])
}

/// No yield.
#[derive(Clone, Copy, Debug)]
pub struct ElasticOnly;

impl HardeningLaw for ElasticOnly {
    type State = ();
    const PLASTIC: bool = false;

    fn fresh(&self) {}

    #[inline(always)]
    fn flow(&self, (): &mut (), _flow: &mut FlowUpdate<'_>) {}

    fn plastic_strain(&self, (): &(), _lane: usize) -> f64 {
        0.0
    }
}

/// Yield stress as the minimum of several lines over the plastic strain: perfect plasticity, linear hardening, and
/// every table with descending slopes.
#[derive(Clone, Debug)]
pub struct PiecewiseLinearHardening {
    lines: Vec<HardeningLine>,
}

#[derive(Clone, Copy, Debug)]
struct HardeningLine {
    /// Yield stress of the line at zero plastic strain.
    start: f64,
    slope: f64,
    /// 1 / (3 G + slope).
    per: f64,
}

impl PiecewiseLinearHardening {
    /// Returns the law for a table of yield stress and plastic strain, constant after its last row; `None` if its
    /// slopes do not descend or are negative.
    pub fn new(rows: &[[f64; 2]], shear: f64) -> Option<PiecewiseLinearHardening> {
        let last = rows.last()?;
        let line = |start, slope| HardeningLine { start, slope, per: 1.0 / (3.0 * shear + slope) };
        let between = rows.windows(2).map(|w| {
            let slope = (w[1][0] - w[0][0]) / (w[1][1] - w[0][1]);
            line(w[0][0] - slope * w[0][1], slope)
        });
        let mut lines: Vec<HardeningLine> = between.collect();
        // Collinear rows form one line.
        lines.dedup_by(|b, a| (b.slope - a.slope).abs() <= 1e-9 * a.slope.abs());
        lines.push(line(last[0], 0.0));
        lines.windows(2).all(|w| w[1].slope <= w[0].slope).then_some(PiecewiseLinearHardening { lines })
    }
}

impl HardeningLaw for PiecewiseLinearHardening {
    type State = Lanes;
    const PLASTIC: bool = true;

    fn fresh(&self) -> Lanes {
        [0.0; LANES]
    }

    /// Computes the plastic increment by radial return: the trial stress minus 3 G dp equals the minimum of the lines
    /// at p + dp, so dp is the maximum over the lines. Equation (6.4).
    #[inline(always)]
    fn flow(&self, strain: &mut Lanes, flow: &mut FlowUpdate<'_>) {
        let (initial, mut increment, mut sum) = (*strain, [0.0; LANES], *strain);
        for line in &self.lines {
            for l in 0..LANES {
                let dp = (flow.trial[l] - (line.start + line.slope * initial[l])) * line.per;
                increment[l] = if dp > increment[l] { dp } else { increment[l] };
                // The sum of the largest increment, since rounding is monotonic; its own loop would not be vectorized.
                let upper = initial[l] + dp;
                sum[l] = if upper > sum[l] { upper } else { sum[l] };
            }
        }
        (*strain, *flow.increment) = (sum, increment);
    }

    fn plastic_strain(&self, strain: &Lanes, lane: usize) -> f64 {
        strain[lane]
    }

    fn set(&self, strain: &mut Lanes, lane: usize, value: PointValue) -> bool {
        let PointValue::PlasticStrain(start) = value else { return false };
        strain[lane] = start;
        true
    }
}

/// Hardening law with a yield stress over plastic strain, rate and temperature, and optional heating by plastic work.
pub struct RateDependentHardening {
    /// Yield stress as a function of plastic strain, rate and temperature.
    pub law: FlowStress,
    /// Temperature rise by plastic work.
    pub heating: PlasticHeating,
}

/// State variables of a block.
#[derive(Clone, Debug, Persist)]
pub struct PlasticState {
    strain: Lanes,
    temperature: Lanes,
    /// Plastic strain rate of the last increment with plastic flow.
    rate: Lanes,
}

impl HardeningLaw for RateDependentHardening {
    type State = PlasticState;
    const PLASTIC: bool = true;
    const HEATS: bool = true;

    fn fresh(&self) -> PlasticState {
        PlasticState { strain: [0.0; LANES], temperature: [0.0; LANES], rate: [0.0; LANES] }
    }

    #[inline(always)]
    fn flow(&self, state: &mut PlasticState, flow: &mut FlowUpdate<'_>) {
        let PlasticState { strain, temperature, rate } = state;
        let trial = TrialState { stress: flow.trial, strain, temperature, rate, shear3: flow.shear3, dt: flow.dt };
        let increment = plastic_increments(&self.law, trial, flow.count);
        let per_dt = if flow.dt > 0.0 { 1.0 / flow.dt } else { 0.0 };
        for l in 0..LANES {
            strain[l] += increment[l];
            rate[l] = if increment[l] > 0.0 { increment[l] * per_dt } else { rate[l] };
        }
        if !self.heating.is_none() {
            for l in 0..flow.count {
                if increment[l] > 0.0 {
                    let returned = flow.trial[l] - flow.shear3 * increment[l];
                    let mean = share_of(flow.remaining, l) * (0.5 * (flow.previous[l] + returned));
                    temperature[l] += self.heating.rise(temperature[l], [mean, increment[l]]);
                }
            }
        }
        *flow.increment = increment;
    }

    fn plastic_strain(&self, state: &PlasticState, lane: usize) -> f64 {
        state.strain[lane]
    }

    fn temperature(&self, state: &PlasticState, lane: usize) -> Option<f64> {
        Some(state.temperature[lane])
    }

    fn set(&self, state: &mut PlasticState, lane: usize, value: PointValue) -> bool {
        match value {
            PointValue::PlasticStrain(strain) => state.strain[lane] = strain,
            PointValue::Temperature(value) | PointValue::NodalTemperature(value) => state.temperature[lane] = value,
            _ => return false,
        }
        true
    }
}

carried_state!(PlasticState { strain, temperature, rate });

#[cfg(test)]
mod tests {
    use super::{FlowUpdate, HardeningLaw, LANES, PiecewiseLinearHardening};
    use crate::kernel::hardening::{LinearTable, plastic_increment};

    #[test]
    fn lines_give_the_same_increments_as_the_table() {
        let rows = [[400.0, 0.0], [450.0, 0.1], [500.0, 0.2], [540.0, 0.4]];
        let (shear, table) = (45.0, LinearTable { rows: rows.to_vec() });
        let lines = PiecewiseLinearHardening::new(&rows, shear).expect("slopes fall");
        assert_eq!(lines.lines.len(), 3, "two rows are collinear");
        for (trial, strain) in [(399.0, 0.0), (401.0, 0.0), (460.0, 0.0), (700.0, 0.15), (900.0, 0.39), (600.0, 0.9)] {
            let mut state = [strain; LANES];
            let mut increment = [0.0; LANES];
            let flow = &mut FlowUpdate {
                trial: &[trial; LANES],
                previous: &[0.0; LANES],
                shear3: 3.0 * shear,
                dt: 1.0,
                count: LANES,
                remaining: None,
                increment: &mut increment,
            };
            lines.flow(&mut state, flow);
            let expected = plastic_increment(&table, trial, strain, 0.0, 3.0 * shear, 1.0);
            assert!((increment[0] - expected).abs() < 1e-10, "{trial} {strain}: {} {expected}", increment[0]);
        }
        assert!(PiecewiseLinearHardening::new(&[[400.0, 0.0], [410.0, 0.1], [500.0, 0.2]], shear).is_none());
    }
}
