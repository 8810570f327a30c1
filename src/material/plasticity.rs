//! Yield and isotropic hardening of von Mises plasticity.
//! Never here: loops over elements.

use crate::kernel::hardening::FlowStress;
use crate::kernel::heating::Heating;
use crate::kernel::lanes::LANES;
use crate::kernel::lanes::Lanes;
use crate::kernel::return_mapping::{TrialState, plastic_increments};
use crate::state::archive::{Persist, persist_struct};

/// How the yield stress of von Mises plasticity develops. An absent one is a type without state.
pub trait Hardening: Send + Sync + 'static {
    /// What a block of elements keeps.
    type State: Clone + Send + Sync + Persist;

    /// Whether anything flows at all.
    const PLASTIC: bool;

    /// Whether the yield surface moves.
    const BACKSTRESS: bool = false;

    /// State of a block that has never yielded.
    fn fresh(&self) -> Self::State;

    /// Equivalent plastic strain increments, given the elastic trial's von Mises stress and three shear moduli.
    fn flow(&self, state: &mut Self::State, flow: &mut Flow<'_>);

    /// Back stress: rr, zz, hoop, rz.
    fn back_stress(&self, _state: &Self::State) -> [Lanes; 4] {
        [[0.0; LANES]; 4]
    }

    /// Moves the back stress, which the rotation has carried along, with the plastic strain: given the trial stress
    /// relative to it, its von Mises stress, and the plastic strain increments.
    fn follow(
        &self,
        _state: &mut Self::State,
        _carried: &[Lanes; 4],
        _relative: &[Lanes; 4],
        _trial: &Lanes,
        _flow: &Lanes,
    ) {
    }

    /// Equivalent plastic strain of a lane.
    fn plastic_strain(&self, state: &Self::State, lane: usize) -> f64;

    /// Sets the equivalent plastic strain of a lane at the start; whether it says all of the hardening.
    fn harden(&self, _state: &mut Self::State, _lane: usize, _strain: f64) -> bool {
        false
    }

    /// Temperature of a lane, where it is followed.
    fn temperature(&self, _state: &Self::State, _lane: usize) -> Option<f64> {
        None
    }

    /// Sets the temperature at the start.
    fn heat(&self, _state: &mut Self::State, _lane: usize, _temperature: f64) {}
}

/// One block's question to its hardening law.
pub struct Flow<'a> {
    /// Von Mises stress of the elastic trial.
    pub trial: &'a Lanes,
    /// Three shear moduli.
    pub shear3: f64,
    /// Length of the increment.
    pub dt: f64,
    /// Lanes that hold elements.
    pub count: usize,
    /// Answer: increments of the equivalent plastic strain.
    pub increment: &'a mut Lanes,
}

/// Nothing flows.
#[derive(Clone, Copy, Debug)]
pub struct Elastic;

impl Hardening for Elastic {
    type State = ();
    const PLASTIC: bool = false;

    fn fresh(&self) {}

    #[inline(always)]
    fn flow(&self, (): &mut (), _flow: &mut Flow<'_>) {}

    fn plastic_strain(&self, (): &(), _lane: usize) -> f64 {
        0.0
    }
}

/// Yield stress that is the least of some lines over plastic strain: perfect plasticity, linear hardening, and every table
/// whose slopes fall.
#[derive(Clone, Debug)]
pub struct PiecewiseLinearHardening {
    lines: Vec<Line>,
}

#[derive(Clone, Copy, Debug)]
struct Line {
    /// Yield stress at no plastic strain.
    start: f64,
    slope: f64,
    /// 1 / (3 G + slope).
    per: f64,
}

impl PiecewiseLinearHardening {
    /// The lines of a table of yield stress and plastic strain, constant behind its last row; `None` if its slopes do not
    /// fall, or fall below zero.
    pub fn new(rows: &[[f64; 2]], shear: f64) -> Option<PiecewiseLinearHardening> {
        let last = rows.last()?;
        let line = |start, slope| Line { start, slope, per: 1.0 / (3.0 * shear + slope) };
        let between = rows.windows(2).map(|w| {
            let slope = (w[1][0] - w[0][0]) / (w[1][1] - w[0][1]);
            line(w[0][0] - slope * w[0][1], slope)
        });
        let mut lines: Vec<Line> = between.collect();
        // Rows on one line are one line.
        lines.dedup_by(|b, a| (b.slope - a.slope).abs() <= 1e-9 * a.slope.abs());
        lines.push(line(last[0], 0.0));
        lines.windows(2).all(|w| w[1].slope <= w[0].slope).then_some(PiecewiseLinearHardening { lines })
    }
}

impl Hardening for PiecewiseLinearHardening {
    type State = Lanes;
    const PLASTIC: bool = true;

    fn fresh(&self) -> Lanes {
        [0.0; LANES]
    }

    /// Radial return: the trial stress less 3 G dp is the least of the lines at p + dp, so dp is the largest that a line
    /// asks for.
    #[inline(always)]
    fn flow(&self, strain: &mut Lanes, flow: &mut Flow<'_>) {
        let mut increment = [0.0; LANES];
        for line in &self.lines {
            for l in 0..LANES {
                let asked = (flow.trial[l] - (line.start + line.slope * strain[l])) * line.per;
                increment[l] = if asked > increment[l] { asked } else { increment[l] };
            }
        }
        for l in 0..LANES {
            strain[l] += increment[l];
        }
        *flow.increment = increment;
    }

    fn plastic_strain(&self, strain: &Lanes, lane: usize) -> f64 {
        strain[lane]
    }

    fn harden(&self, strain: &mut Lanes, lane: usize, start: f64) -> bool {
        strain[lane] = start;
        true
    }
}

/// Any yield stress over plastic strain, rate and temperature; plastic work may heat.
pub struct RateDependentHardening {
    /// The yield stress.
    pub law: FlowStress,
    /// Rise of temperature by plastic work.
    pub heating: Heating,
}

/// What a block keeps under a general law.
#[derive(Clone, Debug)]
pub struct PlasticState {
    strain: Lanes,
    temperature: Lanes,
    /// Rate of the plastic strain where it last grew.
    rate: Lanes,
}

impl Hardening for RateDependentHardening {
    type State = PlasticState;
    const PLASTIC: bool = true;

    fn fresh(&self) -> PlasticState {
        PlasticState { strain: [0.0; LANES], temperature: [0.0; LANES], rate: [0.0; LANES] }
    }

    #[inline(always)]
    fn flow(&self, state: &mut PlasticState, flow: &mut Flow<'_>) {
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
                let left = flow.trial[l] - flow.shear3 * increment[l];
                temperature[l] += self.heating.rise(temperature[l], [left, increment[l]]);
            }
        }
        *flow.increment = increment;
    }

    fn plastic_strain(&self, state: &PlasticState, lane: usize) -> f64 {
        state.strain[lane]
    }

    fn harden(&self, state: &mut PlasticState, lane: usize, start: f64) -> bool {
        state.strain[lane] = start;
        true
    }

    fn temperature(&self, state: &PlasticState, lane: usize) -> Option<f64> {
        Some(state.temperature[lane])
    }

    fn heat(&self, state: &mut PlasticState, lane: usize, temperature: f64) {
        state.temperature[lane] = temperature;
    }
}

persist_struct!(PlasticState { strain, temperature, rate });

#[cfg(test)]
mod tests {
    use super::{Flow, Hardening, LANES, PiecewiseLinearHardening};
    use crate::kernel::hardening::{Table, plastic_increment};

    #[test]
    fn lines_return_as_the_table_does() {
        let rows = [[400.0, 0.0], [450.0, 0.1], [500.0, 0.2], [540.0, 0.4]];
        let (shear, table) = (45.0, Table { rows: rows.to_vec() });
        let lines = PiecewiseLinearHardening::new(&rows, shear).expect("slopes fall");
        assert_eq!(lines.lines.len(), 3, "two rows are on one line");
        for (trial, strain) in [(399.0, 0.0), (401.0, 0.0), (460.0, 0.0), (700.0, 0.15), (900.0, 0.39), (600.0, 0.9)] {
            let mut state = [strain; LANES];
            let mut increment = [0.0; LANES];
            let flow = &mut Flow {
                trial: &[trial; LANES],
                shear3: 3.0 * shear,
                dt: 1.0,
                count: LANES,
                increment: &mut increment,
            };
            lines.flow(&mut state, flow);
            let expected = plastic_increment(&table, trial, strain, 0.0, 3.0 * shear, 1.0);
            assert!((increment[0] - expected).abs() < 1e-10, "{trial} {strain}: {} {expected}", increment[0]);
        }
        assert!(PiecewiseLinearHardening::new(&[[400.0, 0.0], [410.0, 0.1], [500.0, 0.2]], shear).is_none());
    }
}
