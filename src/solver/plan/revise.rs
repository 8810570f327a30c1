//! Revision of a plan for other numbers of its model: topology and names are kept; masses, initial velocities, target
//! materials and loads are updated. Only for models of rigid bodies, where compilation takes longer than the run. See
//! also `model/revise.rs`.

use std::collections::HashSet;
use std::rc::Rc;

use indexmap::{IndexMap, IndexSet};

use super::steps::ActiveEffects;
use super::{Compiler, Plan, State, bodies::PlannedRigidBody, links};
use crate::constraint::tie::TiedNodes;
use crate::deck::{Diagnostics, Span};
use crate::mesh::surface::SurfaceGeometry;
use crate::model::Model;
use crate::model::revise::RevisableNumber;
use crate::state::{BodyState, EffectId};
use crate::user::Routines;

/// Results of compilation that do not depend on the numbers of the model.
pub struct PlanReviser {
    causes: IndexMap<(Span, &'static str), EffectId>,
    bodies: Vec<PlannedRigidBody>,
    body_of_node: IndexMap<usize, usize>,
    body_of_element: IndexMap<usize, usize>,
    rigid_surfaces: IndexMap<Span, SurfaceGeometry>,
    ties: Vec<TiedNodes>,
    pair_names: IndexSet<String>,
    called: Vec<&'static str>,
    /// Number of cards without effect in the ledger.
    unused: usize,
    /// Whether masses and loads depend on the revised numbers.
    masses: bool,
    loads: bool,
}

/// Compiles a model as [`super::compile`] does, and returns the data to revise the plan for other values of `numbers`;
/// `None` if the plan must be compiled for each set of values, because the model has deformable bodies, temperatures,
/// contact, constraints or user amplitudes.
pub fn compile(
    model: &Model,
    routines: &Routines,
    numbers: &[RevisableNumber],
) -> (Plan, State, Diagnostics, Option<PlanReviser>) {
    let mut reviser = None;
    let (plan, state, diagnostics) = super::compile_with(model, routines, &mut |compiler, state| {
        reviser = PlanReviser::of(compiler, state, numbers);
    });
    (plan, state, diagnostics, reviser)
}

impl PlanReviser {
    fn of(compiler: &Compiler<'_>, state: &State, numbers: &[RevisableNumber]) -> Option<PlanReviser> {
        let model = compiler.model;
        let rigid = state.elements.is_empty()
            && state.thermal.is_none()
            && model.discrete.connectors.is_empty()
            && model.constraints.equations.is_empty()
            && model.constraints.links.is_empty()
            && model.constraints.ties.is_empty()
            && model.attitudes.is_empty()
            && !state.dofs.bodies.iter().any(BodyState::is_spatial)
            && compiler.pairs.iter().all(|pairs| pairs.is_empty())
            && compiler.user_amplitude_count == 0
            && compiler.amplitudes.is_empty();
        rigid.then(|| PlanReviser {
            causes: compiler.ledger_rows.clone(),
            bodies: compiler.bodies.clone(),
            body_of_node: compiler.body_of_node.clone(),
            body_of_element: compiler.body_of_element.clone(),
            rigid_surfaces: compiler.rigid_surfaces.clone(),
            ties: compiler.ties.clone(),
            pair_names: compiler.pair_names.clone(),
            called: compiler.called_routines.clone(),
            unused: compiler.ledger.unused.len(),
            masses: numbers.iter().any(RevisableNumber::changes_masses),
            loads: numbers.iter().any(RevisableNumber::changes_loads),
        })
    }

    /// Updates a plan and its initial state from a model with other numbers. Returns `false` if there are errors.
    /// Details in the ledger remain those of the first model.
    pub fn revise(&mut self, model: &Model, routines: &Routines, plan: &mut Plan, state: &mut State) -> bool {
        let mut compiler = Compiler {
            model,
            routines,
            diagnostics: Diagnostics::default(),
            ledger: std::mem::take(&mut plan.ledger),
            ledger_rows: std::mem::take(&mut self.causes),
            bodies: std::mem::take(&mut self.bodies),
            body_of_node: std::mem::take(&mut self.body_of_node),
            body_of_element: std::mem::take(&mut self.body_of_element),
            places: std::mem::take(&mut plan.places),
            rigid_surfaces: std::mem::take(&mut self.rigid_surfaces),
            amplitudes: Vec::new(),
            user_amplitude_index: IndexMap::new(),
            user_amplitude_count: 0,
            ties: std::mem::take(&mut self.ties),
            sections: Vec::new(),
            sets: IndexSet::new(),
            model_variables: Vec::new(),
            expressions: Vec::new(),
            surface_ties: Vec::new(),
            links: links::LinkSet::default(),
            unresisted_dofs: HashSet::new(),
            pairs: vec![Rc::default(); model.steps.len()],
            in_force: ActiveEffects::default(),
            pair_names: std::mem::take(&mut self.pair_names),
            fronts: Vec::new(),
            called_routines: std::mem::take(&mut self.called),
        };
        if self.masses {
            compiler.update_body_masses();
        }
        compiler.update_initial_velocities();
        if self.loads {
            for (index, step) in plan.steps.iter_mut().enumerate() {
                compiler.replan_loads(index, step, state);
            }
        }
        let sound = !compiler.diagnostics.has_errors();
        state.dofs.bodies.clear();
        state.dofs.bodies.extend(compiler.bodies_at_start());
        plan.bodies.clone_from(&compiler.bodies);
        compiler.ledger.unused.truncate(self.unused);
        plan.ledger = compiler.ledger;
        plan.places = compiler.places;
        self.causes = compiler.ledger_rows;
        self.bodies = compiler.bodies;
        self.body_of_node = compiler.body_of_node;
        self.body_of_element = compiler.body_of_element;
        self.rigid_surfaces = compiler.rigid_surfaces;
        self.ties = compiler.ties;
        self.pair_names = compiler.pair_names;
        self.called = compiler.called_routines;
        self.called.clear();
        sound
    }
}
