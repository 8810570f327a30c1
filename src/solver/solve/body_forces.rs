//! Generalised forces on rigid bodies: which effect gives each force, and the values in the current increment.

use crate::constraint::of_kind;
use crate::constraint::tie::TiedNodes;
use crate::load::{EnergyAccount, GeneralizedForce, VelocityUse};
use crate::plan::State;
use crate::state::archive::Persist;
use crate::state::{BodyState, EffectId};

/// Generalised forces on rigid bodies: first those of tied nodes, then those of each load.
#[derive(Default, Persist)]
// The list of forces follows from the effects in force.
#[persist(fixed: values; derived: slots, order_by_body, loads, tied, first_resistance)]
pub(super) struct BodyForces {
    pub values: Vec<f64>,
    /// Body, coordinate and energy account of each force.
    pub slots: Vec<GeneralizedForce>,
    /// The forces in order of their bodies: coordinate and index of each.
    pub order_by_body: Vec<(u32, usize)>,
    /// Ledger row of each load, and the index after its last force.
    pub loads: Vec<(EffectId, usize)>,
    /// Number of forces of tied nodes, which come first.
    pub tied: usize,
    /// Index of the first load that resists motion; such loads come last.
    pub first_resistance: usize,
}

impl BodyForces {
    /// Lists the forces of the effects in force, and marks bodies whose loads read or resist their velocity.
    pub fn begin(&mut self, state: &mut State) {
        self.slots.clear();
        self.loads.clear();
        let ties = of_kind::<TiedNodes>(&state.constraints);
        self.slots.extend(ties.map(|tie| GeneralizedForce::along_z(tie.body, EnergyAccount::Tie)));
        self.tied = self.slots.len();
        for load in &state.loads {
            self.slots.extend(load.targets().bodies);
            self.loads.push((load.effect(), self.slots.len()));
        }
        self.first_resistance = state.loads.iter().filter(|l| l.velocity_use() != VelocityUse::Resists).count();
        self.values = vec![0.0; self.slots.len()];
        self.order_by_body = self.slots.iter().enumerate().map(|(i, slot)| (slot.coordinate, i)).collect();
        self.order_by_body.sort_by_key(|&(_, i)| self.slots[i].body);
        self.mark_bodies(state);
    }

    fn mark_bodies(&self, state: &mut State) {
        for (b, body) in state.dofs.bodies.iter_mut().enumerate() {
            // Constraints set these again when they begin.
            (body.reads_velocity, body.prescribed, body.contact) = (false, false, 0.0);
            body.tied = !state.elements.is_empty() && self.slots[..self.tied].iter().any(|s| s.body == b);
            body.slots = self.slots.iter().filter(|s| s.body == b).count() as u32;
            body.set_resisted(false);
        }
        for load in state.loads.iter().filter(|load| load.velocity_use() != VelocityUse::None) {
            for force in load.targets().bodies {
                let body = &mut state.dofs.bodies[force.body];
                body.reads_velocity = true;
                if load.velocity_use() == VelocityUse::Resists {
                    body.set_resisted(true);
                }
            }
        }
    }

    /// Sets resistances on a body at rest to zero: they balance the other forces and do no work.
    pub fn arrest(&mut self, body: usize) {
        for (slot, force) in self.slots.iter().zip(&mut self.values) {
            if slot.body == body && matches!(slot.account, EnergyAccount::Friction | EnergyAccount::Cavity) {
                *force = 0.0;
            }
        }
    }

    /// Returns the index of the first force of a load.
    #[inline]
    pub fn start_of(&self, load: usize) -> usize {
        load.checked_sub(1).map_or(self.tied, |previous| self.loads[previous].1)
    }

    /// Sets the direction in which the other forces would start a body at rest; a resistance acts against it.
    pub fn turn_resting_bodies(&self, bodies: &mut [BodyState]) {
        let other_forces = &self.slots[..self.start_of(self.first_resistance)];
        for (b, body) in bodies.iter_mut().enumerate().filter(|(_, body)| body.direction == 0.0) {
            let on_body = other_forces.iter().zip(&self.values).filter(|(s, _)| s.body == b);
            body.probe(on_body.map(|(s, &force)| (s.coordinate, force)));
        }
    }
}
