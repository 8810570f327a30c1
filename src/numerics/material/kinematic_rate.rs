//! Linear kinematic hardening with a yield stress that depends on rate and temperature, and a slope that depends on
//! temperature.

use crate::kernel::hardening::{FlowStress, LinearTable, plastic_increment};
use crate::kernel::heating::PlasticHeating;
use crate::kernel::lanes::LANES;
use crate::kernel::lanes::Lanes;
use crate::material::PointValue;
use crate::material::carried::carried_state;
use crate::material::plasticity::{FlowUpdate, HardeningLaw, share_of};
use crate::state::archive::Persist;

/// Linear kinematic hardening with rate and temperature dependence (ABAQUS Analysis User's Guide, "Models for metals
/// subjected to cyclic loading"). The back stress grows by 2/3 C times the plastic strain; if C changes with
/// temperature, the back stress changes in proportion.
pub struct RateKinematicHardening {
    /// Radius of the yield surface as a function of rate and temperature.
    pub size: FlowStress,
    /// C, slope of the stress over the plastic strain, as a function of temperature.
    pub slope: LinearTable,
    /// Temperature rise by plastic work.
    pub heating: PlasticHeating,
}

/// State variables of a block.
#[derive(Clone, Debug, Persist)]
pub struct RateBackStress {
    strain: Lanes,
    temperature: Lanes,
    /// C at the temperature before the increment.
    slope: Lanes,
    /// Back stress: rr, zz, hoop, rz; its trace is zero.
    back: [Lanes; 4],
}

impl HardeningLaw for RateKinematicHardening {
    type State = RateBackStress;
    const PLASTIC: bool = true;
    const BACKSTRESS: bool = true;
    const HEATS: bool = true;

    fn fresh(&self) -> RateBackStress {
        let zero = [0.0; LANES];
        RateBackStress { strain: zero, temperature: zero, slope: zero, back: [zero; 4] }
    }

    /// Computes the plastic increment by radial return: the trial stress relative to the back stress minus (3 G + C) dp
    /// equals the yield stress at the rate dp/dt.
    fn flow(&self, state: &mut RateBackStress, flow: &mut FlowUpdate<'_>) {
        *flow.increment = [0.0; LANES];
        for l in 0..flow.count {
            let temperature = state.temperature[l];
            let slope = self.slope.value(temperature);
            let trial = flow.trial[l];
            let dp = plastic_increment(&self.size, trial, state.strain[l], temperature, flow.shear3 + slope, flow.dt);
            flow.increment[l] = dp;
            state.strain[l] += dp;
            state.slope[l] = slope;
            if dp > 0.0 {
                let mean = share_of(flow.remaining, l) * (0.5 * (flow.previous[l] + (trial - flow.shear3 * dp)));
                state.temperature[l] += self.heating.rise(temperature, [mean, dp]);
            }
        }
    }

    fn back_stress(&self, state: &RateBackStress) -> [Lanes; 4] {
        state.back
    }

    /// Adds the increment of the back stress, along the plastic strain increment. The plastic strain increment is 3/2
    /// dp times the direction of the relative stress. The work against the back stress also heats the material: this is
    /// the part of the new stress; the previous stress includes its back stress. Equation (6.8).
    fn update_back_stress(
        &self,
        state: &mut RateBackStress,
        carried: &[Lanes; 4],
        relative: &[Lanes; 4],
        trial: &Lanes,
        flow: &Lanes,
        remaining: Option<&Lanes>,
    ) {
        for l in 0..LANES {
            let per = if flow[l] > 0.0 { flow[l] / trial[l] } else { 0.0 };
            let part = |i: usize| carried[i][l] * relative[i][l];
            let along = (part(0) + part(1)) + (part(2) + 2.0 * part(3));
            state.temperature[l] +=
                self.heating.rise(state.temperature[l], [0.75 * share_of(remaining, l), per, along]);
            let previous_slope = state.slope[l];
            let now = if !self.heating.is_none() { self.slope.value(state.temperature[l]) } else { previous_slope };
            let ratio = if previous_slope > 0.0 { now / previous_slope } else { 1.0 };
            for i in 0..4 {
                state.back[i][l] = ratio * (carried[i][l] + previous_slope * per * relative[i][l]);
            }
        }
    }

    fn plastic_strain(&self, state: &RateBackStress, lane: usize) -> f64 {
        state.strain[lane]
    }

    fn temperature(&self, state: &RateBackStress, lane: usize) -> Option<f64> {
        Some(state.temperature[lane])
    }

    fn set(&self, state: &mut RateBackStress, lane: usize, value: PointValue) -> bool {
        let (PointValue::Temperature(temperature) | PointValue::NodalTemperature(temperature)) = value else {
            return false;
        };
        state.temperature[lane] = temperature;
        true
    }
}

carried_state!(RateBackStress { strain, temperature, slope, back });
