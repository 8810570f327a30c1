//! Revision of a plan for other numbers of its model: topology and names are kept; masses, initial velocities, target
//! materials and loads are updated. Only for models of rigid bodies, where compilation takes longer than the run. See
//! also `model/revise.rs`.

use crate::model::Model;
use crate::model::revise::RevisableNumber;
use crate::plan::report::LedgerRows;
use crate::plan::{Bodies, Compilation, Plan, Report, Scene, Shared, State, bodies, steps};
use crate::state::BodyState;
use crate::user::Routines;

/// Results of compilation that do not depend on the numbers of the model.
pub struct PlanReviser {
    /// Rigid bodies without their list, which is in the plan.
    bodies: Bodies,
    shared: Shared,
    ledger_rows: LedgerRows,
    /// Number of cards without effect in the ledger.
    unused: usize,
    /// Whether masses and loads depend on the revised numbers.
    masses: bool,
    loads: bool,
}

/// A plan and its initial state, with the data to revise them.
pub struct RevisablePlan {
    /// The plan.
    pub plan: Plan,
    /// Its initial state.
    pub state: State,
    /// `None` if the plan must be compiled for each set of values, because the model has deformable bodies, temperatures,
    /// contact, constraints or user amplitudes.
    pub reviser: Option<PlanReviser>,
}

/// Compiles a model as [`super::compile`] does, for revisions of the plan with other values of `numbers`.
pub fn compile(model: &Model, routines: &Routines, numbers: &[RevisableNumber]) -> RevisablePlan {
    let Compilation { plan, state, diagnostics, bodies, shared, ledger_rows, has_contact } =
        super::compile_with_products(model, None, routines);
    let is_revisable = !diagnostics.has_errors()
        && state.dofs.nodes.is_empty()
        && state.thermal.is_none()
        && model.constraints.equations.is_empty()
        && model.constraints.links.is_empty()
        && model.constraints.ties.is_empty()
        && model.attitudes.is_empty()
        && !state.dofs.bodies.iter().any(BodyState::is_spatial)
        && !has_contact
        && state.user_amplitudes.is_empty()
        && state.amplitude_routines.is_empty();
    let reviser = is_revisable.then(|| PlanReviser {
        bodies,
        shared,
        ledger_rows,
        unused: plan.ledger.unused.len(),
        masses: numbers.iter().any(RevisableNumber::changes_masses),
        loads: numbers.iter().any(RevisableNumber::changes_loads),
    });
    RevisablePlan { plan, state, reviser }
}

impl PlanReviser {
    /// Returns whether the revised numbers change masses or loads.
    pub fn changes_forces(&self) -> bool {
        self.masses || self.loads
    }

    /// Updates a plan and its initial state from a model with other numbers. Returns `false` if there are errors.
    /// Details in the ledger remain those of the first model.
    pub fn revise(&mut self, model: &Model, routines: &Routines, plan: &mut Plan, state: &mut State) -> bool {
        let PlanReviser { bodies, shared, ledger_rows, .. } = self;
        let mut report = Report::new(model, routines);
        std::mem::swap(&mut report.ledger, &mut plan.ledger);
        std::mem::swap(&mut report.ledger_rows, ledger_rows);
        std::mem::swap(&mut report.shared, shared);
        bodies.list = std::mem::take(&mut plan.bodies);
        if self.masses {
            bodies::update_masses(model, bodies, &mut report);
        }
        let scene = Scene { model, bodies, places: &plan.places };
        let velocities = bodies::initial_velocities(scene, &mut report);
        if self.loads {
            steps::replan_loads(scene, &mut plan.steps, state, &mut report);
        }
        let is_valid = !report.diagnostics.has_errors();
        state.dofs.bodies = bodies::rigid_bodies_3d::initial_states(scene, &velocities, &mut report);
        plan.bodies = bodies.take_list(&velocities);
        report.ledger.unused.truncate(self.unused);
        plan.ledger = report.ledger;
        (*ledger_rows, *shared) = (report.ledger_rows, report.shared);
        is_valid
    }
}
