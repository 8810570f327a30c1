//! The state of an analysis, and the list of its fields that a checkpoint contains. Total time, energy balance and
//! increment control are in `solve`.

use crate::adaptive::AdaptiveDomain;
use crate::constraint::Constraint;
use crate::constraint::user_motion::UserMotion;
use crate::element::elements::Elements;
use crate::element::mass_scaling::StepMassScaling;
use crate::heat::ThermalState;
use crate::heat::field::TemperatureField;
use crate::kernel::amplitude::SampledAmplitude;
use crate::load::user_amplitude::SubroutineAmplitude;
use crate::load::{Load, PenetrationRecord};
use crate::plan::StepChanges;
use crate::plan::changes::ListChange;
use crate::state::BodyState;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;

/// Everything that changes during a run: degrees of freedom, elements and active effects.
#[derive(Clone, Default, Persist)]
#[persist(
    fixed: adaptive, user_amplitudes, amplitude_routines;
    each: loads, constraints, user_motions;
    present: scaling, thermal
)]
pub struct State {
    /// Nodes and rigid bodies.
    pub dofs: Dofs,
    /// Element groups and their state.
    pub elements: Elements,
    /// Nodal temperatures and thermal strains; `None` if temperatures have no effect.
    pub thermal: Option<Box<ThermalState>>,
    /// Active loads; those that resist motion are last.
    pub loads: Vec<Box<dyn Load>>,
    /// Active constraints: prescribed motions, equations, contact, ties.
    pub constraints: Vec<Box<dyn Constraint>>,
    /// Active mass scaling; `None` before a step requests it.
    pub scaling: Option<StepMassScaling>,
    /// Domains of adaptive meshes in force.
    pub adaptive: Vec<AdaptiveDomain>,
    /// Active user motions (VDISP), called once per increment.
    #[allow(clippy::vec_box)] // The list is changed in the same way as the boxed loads and constraints.
    pub user_motions: Vec<Box<UserMotion>>,
    /// User amplitudes (VUAMP), called once per increment in every step.
    pub amplitude_routines: Vec<SubroutineAmplitude>,
    /// Values of user amplitudes and user motions.
    pub user_amplitudes: Vec<SampledAmplitude>,
    /// Penetration results of resistance loads that are no longer active.
    pub ended_penetrations: Vec<PenetrationRecord>,
}

/// Nodes and elements of the deformable bodies, before temperatures, rigid bodies and effects are known.
#[derive(Default)]
pub struct SolidState {
    pub dofs: Dofs,
    pub elements: Elements,
}

impl State {
    /// Creates the state without effects.
    pub(crate) fn new(solids: SolidState, bodies: Vec<BodyState>, thermal: Option<Box<ThermalState>>) -> State {
        let SolidState { dofs, elements } = solids;
        State { dofs: Dofs { bodies, ..dofs }, elements, thermal, ..State::default() }
    }

    /// Returns the nodal temperatures, if they are solved for.
    pub(crate) fn heat(&self) -> Option<&TemperatureField> {
        self.thermal.as_ref()?.heat.as_ref()
    }

    pub(crate) fn heat_mut(&mut self) -> Option<&mut TemperatureField> {
        self.thermal.as_mut()?.heat.as_mut()
    }

    /// Returns whether the elements of a group conduct heat.
    pub(crate) fn conducts_heat(&self, group: usize) -> bool {
        self.heat().is_some_and(|heat| heat.conducts(group))
    }

    /// Activates the effects of the first step.
    pub(crate) fn begin_with(&mut self, first: StepChanges) {
        let StepChanges { loads, constraints, user_motions, scaling, adaptive } = first;
        self.loads = loads.map_or_else(Vec::new, ListChange::into_first);
        self.constraints = constraints.map_or_else(Vec::new, ListChange::into_first);
        self.user_motions = user_motions.map_or_else(Vec::new, ListChange::into_first);
        self.scaling = scaling.flatten();
        self.adaptive = adaptive.unwrap_or_default();
    }
}
