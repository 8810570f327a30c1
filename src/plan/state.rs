//! The state: all that changes over an analysis, and what a checkpoint holds of it.
//! Never here: the clock, the energy balance and the increment control of a run (`solve`).

use super::changes::{Changes, ListChange};
use crate::constraint::Constraint;
use crate::constraint::user_motion::UserMotion;
use crate::element::elements::Elements;
use crate::element::mass_scaling::Scaling;
use crate::heat::Thermal;
use crate::kernel::amplitude::SampledAmplitude;
use crate::load::user_amplitude::UserAmplitude;
use crate::load::{Load, Penetration};
use crate::state::archive::persist_struct;
use crate::state::dofs::Dofs;

/// Degrees of freedom, elements and the effects in force, at the start of a plan, during a run and at its end.
#[derive(Clone, Default)]
pub struct State {
    /// Degrees of freedom.
    pub dofs: Dofs,
    /// Elements.
    pub elements: Elements,
    /// Temperatures of nodes and thermal strains; `None` where temperatures change nothing.
    pub thermal: Option<Box<Thermal>>,
    /// Loads in force; those that resist motion come last.
    pub loads: Vec<Box<dyn Load>>,
    /// Constraints in force: prescribed motions, equations, contact, ties.
    pub constraints: Vec<Box<dyn Constraint>>,
    /// Mass scaling in force; `None` before a step requests it.
    pub scaling: Option<Scaling>,
    /// User motions in force, called once an increment.
    #[allow(clippy::vec_box)] // The list is changed as those of loads and constraints are.
    pub user_motions: Vec<Box<UserMotion>>,
    /// User amplitudes, called once an increment in every step.
    pub amplitude_routines: Vec<UserAmplitude>,
    /// Functions of time that the user amplitudes give.
    pub user_amplitudes: Vec<SampledAmplitude>,
    /// Outcomes of bodies in resistances that are no longer in force.
    pub ended_penetrations: Vec<Penetration>,
}

impl State {
    /// Puts in force what the first step adds.
    pub(super) fn begin_with(&mut self, first: Changes) {
        let Changes { loads, constraints, user_motions, scaling } = first;
        self.loads = loads.map_or_else(Vec::new, ListChange::into_first);
        self.constraints = constraints.map_or_else(Vec::new, ListChange::into_first);
        self.user_motions = user_motions.map_or_else(Vec::new, ListChange::into_first);
        self.scaling = scaling.flatten();
    }
}

persist_struct!(State {
    dofs,
    loads: each,
    constraints: each,
    scaling: present,
    user_amplitudes: fixed,
    amplitude_routines: fixed,
    user_motions: each,
    elements,
    thermal: present,
    ended_penetrations,
});
