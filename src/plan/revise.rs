//! A plan for other numbers of its model: what follows from names, places and shapes stays, what follows from masses, velocities
//! at the start, materials of targets and loads is made anew. Scenes of rigid bodies alone: what deforms takes longer to run than to plan.
//! Never here: which numbers those are (`model/revise.rs`).

use std::collections::HashSet;
use std::rc::Rc;

use indexmap::IndexMap;

use super::steps::InForce;
use super::{Compiler, Plan, State, bodies::Body, links, surface_ties};
use crate::constraint::tie::Tie;
use crate::deck::{Diagnostics, Span};
use crate::model::Model;
use crate::state::{BodyState, EffectId};
use crate::user::Routines;

/// What compilation found out by names and places.
pub struct Reviser {
    causes: IndexMap<(Span, &'static str), EffectId>,
    bodies: Vec<Body>,
    body_of_node: IndexMap<usize, usize>,
    body_of_element: IndexMap<usize, usize>,
    ties: Vec<Tie>,
    pair_names: Vec<String>,
    called: Vec<&'static str>,
    /// Cards of the ledger that came to nothing.
    unused: usize,
}

/// The same as [`super::compile`], with what a plan for other numbers takes; `None` where such a plan is to be compiled as the first
/// was: where anything deforms, warms up or meets, or a routine of the user tells a function of time.
pub fn compile(model: &Model, routines: &Routines) -> (Plan, State, Diagnostics, Option<Reviser>) {
    let mut reviser = None;
    let (plan, state, diagnostics) = super::compile_with(model, routines, &mut |compiler, state| {
        reviser = Reviser::of(compiler, state);
    });
    (plan, state, diagnostics, reviser)
}

impl Reviser {
    fn of(compiler: &Compiler<'_>, state: &State) -> Option<Reviser> {
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
        rigid.then(|| Reviser {
            causes: compiler.causes.clone(),
            bodies: compiler.bodies.clone(),
            body_of_node: compiler.body_of_node.clone(),
            body_of_element: compiler.body_of_element.clone(),
            ties: compiler.ties.clone(),
            pair_names: compiler.pair_names.clone(),
            called: compiler.called.clone(),
            unused: compiler.ledger.unused.len(),
        })
    }

    /// Gives a plan and the state at its start what a model says whose numbers have changed; `false` where the model has errors. Details
    /// in the ledger stay those of the first model.
    pub fn revise(&mut self, model: &Model, routines: &Routines, plan: &mut Plan, state: &mut State) -> bool {
        let mut compiler = Compiler {
            model,
            routines,
            diagnostics: Diagnostics::default(),
            ledger: std::mem::take(&mut plan.ledger),
            causes: std::mem::take(&mut self.causes),
            bodies: std::mem::take(&mut self.bodies),
            body_of_node: std::mem::take(&mut self.body_of_node),
            body_of_element: std::mem::take(&mut self.body_of_element),
            places: std::mem::take(&mut plan.places),
            amplitudes: Vec::new(),
            tellers: IndexMap::new(),
            user_amplitude_count: 0,
            ties: std::mem::take(&mut self.ties),
            sections: Vec::new(),
            sets: Vec::new(),
            expressions: Vec::new(),
            surface_ties: Vec::<surface_ties::TiedNode>::new(),
            kept: links::Kept::default(),
            idle: HashSet::new(),
            pairs: vec![Rc::default(); model.steps.len()],
            in_force: InForce::default(),
            pair_names: std::mem::take(&mut self.pair_names),
            called: std::mem::take(&mut self.called),
        };
        compiler.weigh_bodies();
        for (index, step) in plan.steps.iter_mut().enumerate() {
            compiler.reload(index, step, state);
        }
        let sound = !compiler.diagnostics.has_errors();
        state.dofs.bodies.clear();
        state.dofs.bodies.extend(compiler.bodies_at_start());
        plan.bodies.clone_from(&compiler.bodies);
        compiler.ledger.unused.truncate(self.unused);
        plan.ledger = compiler.ledger;
        plan.places = compiler.places;
        self.causes = compiler.causes;
        self.bodies = compiler.bodies;
        self.body_of_node = compiler.body_of_node;
        self.body_of_element = compiler.body_of_element;
        self.ties = compiler.ties;
        self.pair_names = compiler.pair_names;
        self.called = compiler.called;
        self.called.clear();
        sound
    }
}
