//! Adapter from a material law in Rust (`revolve::user::MaterialLaw`) to a material.

use std::sync::Arc;

use super::increment::{StrainIncrement, StressUpdate};
use super::{BlockStart, Material, PlasticFlow, PointValue};
use crate::kernel::lanes::{LANES, Lanes, column, inline_from_fn};
use crate::kernel::stress::mises;
use crate::material::carried::CarriedState;
use crate::routines::law::{MaterialLaw, MaterialPoint};
use crate::state::archive::Persist;
use crate::variables::{Variable, VariableComponent};

/// A material law in Rust with the constants of the deck.
pub struct PointLaw {
    pub law: Arc<dyn MaterialLaw>,
    pub constants: Vec<f64>,
    pub variables: usize,
    /// Index of the state variable that deletes an element when it becomes zero.
    pub delete: Option<usize>,
}

/// State variables of a block.
#[derive(Clone, Debug, Persist)]
#[persist(fixed: variables; derived: volume, total_time)]
pub struct PointState {
    /// State variables, point by point.
    variables: Vec<f64>,
    deleted: [bool; LANES],
    /// Initial volumes.
    volume: Lanes,
    total_time: f64,
}

impl Material for PointLaw {
    type State = PointState;
    const FLOW: PlasticFlow = PlasticFlow::Unknown;
    const FAILS: bool = true;

    fn initial_state(&self, start: &BlockStart) -> PointState {
        let mut variables = vec![0.0; LANES * self.variables];
        if let Some(delete) = self.delete {
            variables.iter_mut().skip(delete).step_by(self.variables).for_each(|variable| *variable = 1.0);
        }
        PointState { variables, deleted: [false; LANES], volume: start.volume, total_time: 0.0 }
    }

    fn begin(&self, state: &mut PointState, total_time: f64) {
        state.total_time = total_time;
    }

    /// Calls the law for each point of a block; an increment of zero length changes nothing.
    fn update(
        &self,
        state: &mut PointState,
        stress: &mut [Lanes; 4],
        strain: &StrainIncrement,
        update: &mut StressUpdate,
    ) {
        if strain.dt == 0.0 {
            return;
        }
        for l in 0..strain.count {
            if state.deleted[l] {
                continue;
            }
            let (increment, carried) = (column(&strain.strain, l), column(&strain.carried, l));
            let variables = &mut state.variables[l * self.variables..(l + 1) * self.variables];
            let mut point = MaterialPoint {
                constants: &self.constants,
                strain: increment,
                stress: carried,
                state: variables,
                dissipated: 0.0,
                dt: strain.dt,
                total_time: state.total_time,
            };
            self.law.update(&mut point);
            let MaterialPoint { stress: new, dissipated, .. } = point;
            let double = |i: usize| increment[i] * (carried[i] + new[i]);
            let volume = strain.volume[l];
            update.internal[l] += 0.5 * volume * ((double(0) + double(1)) + (double(2) + 2.0 * double(3)));
            update.dissipated[l] += volume * dissipated;
            // A ratio within rounding of 1 is set to 1.
            let ratio = mises(new) / update.trial[l];
            update.returned[l] = if ratio < 1.0 - 1e-12 { ratio } else { 1.0 };
            if self.delete.is_some_and(|delete| variables[delete] == 0.0) {
                state.deleted[l] = true;
                update.deleted += 1;
            }
            for (list, new) in stress.iter_mut().zip(new) {
                list[l] = if state.deleted[l] { 0.0 } else { new };
            }
        }
    }

    fn share(&self, state: &PointState, lane: usize) -> f64 {
        if state.deleted[lane] { 0.0 } else { 1.0 }
    }

    fn can_delete(&self) -> bool {
        self.delete.is_some()
    }

    fn initial_volume(&self, state: &PointState, lane: usize) -> f64 {
        state.volume[lane]
    }

    fn value(&self, state: &PointState, lane: usize, part: VariableComponent) -> Option<f64> {
        match part.variable {
            Variable::State if part.component < self.variables => {
                Some(state.variables[lane * self.variables + part.component])
            }
            Variable::Status => self.delete.map(|_| self.share(state, lane)),
            _ => None,
        }
    }

    fn bytes(&self, state: &PointState) -> usize {
        size_of_val(&*state.variables)
    }

    fn set(&self, state: &mut PointState, lane: usize, value: PointValue) -> bool {
        match value {
            PointValue::StateVariable(variable, value) if variable < self.variables => {
                state.variables[lane * self.variables + variable] = value;
                true
            }
            _ => false,
        }
    }
}

impl CarriedState for PointState {
    /// Moves the state variables, which are stored point by point.
    fn carry(&mut self, visit: &mut dyn FnMut(&mut Lanes)) {
        let PointState { variables, deleted: _, volume: _, total_time: _ } = self;
        let count = variables.len() / LANES;
        for variable in 0..count {
            let mut lanes: Lanes = inline_from_fn(|l| variables[l * count + variable]);
            visit(&mut lanes);
            for (l, value) in lanes.into_iter().enumerate() {
                variables[l * count + variable] = value;
            }
        }
    }
}
