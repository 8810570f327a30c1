//! The meeting point: model in, effects out, with the ledger that says which and why. The one place that decides.
//! Never here: time stepping.

mod bodies;
pub mod codes;
mod connectors;
mod equations;
pub mod ledger;
mod loads;
mod mass_scaling;
mod node_loads;
mod outputs;
mod solid;
mod solid_material;
mod ties;
mod user;
mod user_material;
mod walls;

use std::rc::Rc;

use indexmap::IndexMap;

use crate::constraint::equation::System;
use crate::constraint::motion::Motion;
use crate::constraint::node_user_motion::NodeMotions;
use crate::constraint::wall::Wall;
use crate::deck::{Deck, Diagnostic, Diagnostics, Span};
use crate::element::body::{Given, NodeForce, Solid};
use crate::element::mass_scaling::Scaling;
use crate::kernel::amplitude::Track;
use crate::load::Asking;
use crate::load::Force;
use crate::model::{EnergyLimit, IncrementControl, LoadVelocity, Mesh, Model};
use crate::state::EffectId;
use crate::user::{Routines, SharedEvents};
pub use bodies::Body;
use ledger::{Ledger, Unused};
pub use outputs::{COMPONENTS, Column, ElementVariable, FieldVariable, Outputs, Quantity, Schedule};
pub use solid::SolidPlaces;

/// What is to be run: every effect the deck asks for, and nothing else.
pub struct Plan {
    /// What exists and why.
    pub ledger: Ledger,
    /// Nodes and elements, for frames.
    pub mesh: Mesh,
    /// Rigid bodies.
    pub bodies: Vec<Body>,
    /// What deforms, if anything does.
    pub solid: Option<Solid>,
    /// Where its nodes and elements are in the mesh.
    pub places: SolidPlaces,
    /// Steps in order.
    pub steps: Vec<StepPlan>,
    /// Names of the history columns, the same in every step.
    pub columns: Vec<Column>,
    /// Variables shown on nodes in frames.
    pub fields: Vec<FieldVariable>,
    /// User amplitudes: asked once an increment, whatever the step.
    pub asking: Vec<Box<dyn Asking>>,
    /// The user's routine that is told how the analysis goes.
    pub events: Option<SharedEvents>,
    /// Whether there are routines of the user, whose own memory no state of the run holds.
    pub asks_user: bool,
}

/// One step.
pub struct StepPlan {
    /// Name.
    pub name: String,
    /// Length, time.
    pub duration: f64,
    /// How the increment is chosen.
    pub control: IncrementControl,
    /// Factor on an automatic increment.
    pub scale_factor: f64,
    /// What velocity loads are shown.
    pub load_velocity: LoadVelocity,
    /// Forces; those that resist come last.
    pub forces: Vec<Box<dyn Force>>,
    /// Prescribed motions.
    pub motions: Vec<Motion>,
    /// Forces on nodes of what deforms.
    pub node_forces: Vec<Box<dyn NodeForce>>,
    /// Motions that are given on nodes of what deforms.
    pub given: Vec<Given>,
    /// Planes that nodes cannot pass.
    pub walls: Vec<Wall>,
    /// Linear equations between degrees of freedom.
    pub equations: Vec<System>,
    /// Limits on energies; `None` without any.
    pub energy_limit: Option<EnergyLimit>,
    /// Mass scaling; `None` before a step asks for it.
    pub scaling: Option<Scaling>,
    /// User motions: asked once an increment.
    pub asking: Vec<Box<dyn Asking>>,
    /// User motions of nodes of what deforms.
    pub node_asking: Vec<NodeMotions>,
    /// When to write.
    pub outputs: Outputs,
}

/// What compilation carries along.
struct Compiler<'a> {
    deck: &'a Deck,
    model: &'a Model,
    routines: &'a Routines,
    diagnostics: Diagnostics,
    ledger: Ledger,
    causes: IndexMap<(Span, &'static str), EffectId>,
    bodies: Vec<Body>,
    /// Body of each node that moves with one.
    body_of_node: IndexMap<usize, usize>,
    /// Body of each element that belongs to one.
    body_of_element: IndexMap<usize, usize>,
    /// Where what deforms is in the mesh.
    places: SolidPlaces,
    /// Values of user amplitudes, by the amplitude's index.
    tracks: IndexMap<usize, Rc<Track>>,
    /// What is asked once an increment in every step.
    asking: Vec<Box<dyn Asking>>,
}

/// Decides which effects a model brings to life. `routines` serve what the deck leaves to the user.
pub fn compile(deck: &Deck, model: &Model, routines: &Routines) -> (Plan, Diagnostics) {
    let mut compiler = Compiler {
        deck,
        model,
        routines,
        places: SolidPlaces::default(),
        tracks: IndexMap::new(),
        asking: Vec::new(),
        diagnostics: Diagnostics::default(),
        ledger: Ledger::default(),
        causes: IndexMap::new(),
        bodies: Vec::new(),
        body_of_node: IndexMap::new(),
        body_of_element: IndexMap::new(),
    };
    compiler.bodies();
    let mut solid = compiler.solids();
    compiler.connect(solid.as_mut());
    compiler.finish_bodies();
    let (columns, fields) = compiler.variables(solid.as_mut());
    let steps: Vec<StepPlan> = (0..model.steps.len()).map(|i| compiler.step(i, solid.as_ref())).collect();
    if let Some(solid) = solid.as_mut() {
        if model.steps.iter().any(|s| !s.mass_scalings.is_empty()) {
            solid.remember_masses();
        }
        compiler.highest_frequency(solid);
    }
    compiler.check_complete(solid.is_some());
    compiler.list_inert();
    compiler.events_row();
    let Compiler { ledger, bodies, places, mut diagnostics, asking, .. } = compiler;
    // Notes on a plan that cannot run would only bury what is wrong with it.
    if diagnostics.has_errors() {
        diagnostics.keep_errors();
    }
    let events = routines.events.clone();
    let mesh = model.mesh.clone();
    (
        Plan { ledger, mesh, bodies, solid, places, steps, columns, fields, asking, events, asks_user: routines.any() },
        diagnostics,
    )
}

impl Compiler<'_> {
    /// The ledger row of an effect that a span asked for; made at the first asking, so that a load that stays in force
    /// over several steps has one row.
    fn cause(
        &mut self,
        span: Span,
        effect: &'static str,
        count: usize,
        unit: &'static str,
        detail: String,
    ) -> EffectId {
        if let Some(&cause) = self.causes.get(&(span, effect)) {
            return cause;
        }
        let asked_by = self.deck.sources.describe(span);
        let cause = self.ledger.add(effect, count, unit, asked_by, detail);
        self.causes.insert((span, effect), cause);
        cause
    }

    /// Notes a card that brings nothing to life.
    fn unused(&mut self, span: Span, what: impl Into<String>, why: impl Into<String>) {
        let unused = Unused { what: what.into(), asked_by: self.deck.sources.describe(span), why: why.into() };
        if !self.ledger.unused.contains(&unused) {
            self.ledger.unused.push(unused);
        }
    }

    fn step(&mut self, index: usize, solid: Option<&Solid>) -> StepPlan {
        let step = &self.model.steps[index];
        let (mut forces, mut node_forces) = (Vec::new(), Vec::new());
        for load in &step.loads {
            if !self.matters(load) {
                continue;
            }
            if let Some(solid) = solid {
                node_forces.extend(self.node_force(load, solid));
            }
            if solid.is_none() || self.acts_on_rigid(load) {
                forces.extend(self.load(load, step));
            }
        }
        let mut node_asking = Vec::new();
        let given = if solid.is_some() { self.given(step, &mut node_asking) } else { Vec::new() };
        let walls = self.walls(step, solid, &given);
        let equations = self.equations(step, solid, &given);
        let scaling = self.mass_scaling(index, solid);
        let energy_limit = self.energy_limit(step);
        forces.sort_by_key(|f| f.resists());
        let mut asking = Vec::new();
        let motions = self.motions(step, &mut asking);
        self.increment_rows(step, &forces);
        for force in &forces {
            self.ledger.effects[force.cause()].arrays = owned(force.arrays());
        }
        StepPlan {
            name: step.name.clone(),
            duration: step.duration,
            control: step.increment,
            scale_factor: step.scale_factor,
            load_velocity: step.load_velocity,
            forces,
            motions,
            node_forces,
            given,
            walls,
            equations,
            energy_limit,
            scaling,
            asking,
            node_asking,
            outputs: self.outputs(step),
        }
    }

    fn energy_limit(&mut self, step: &crate::model::Step) -> Option<EnergyLimit> {
        let limit = step.energy_limit?;
        let part = |name: &str, value: Option<f64>| value.map(|v| format!("{name} {v:e}"));
        let parts: Vec<String> =
            [part("error", limit.error), part("artificial", limit.artificial)].into_iter().flatten().collect();
        let detail = format!("{}, {}", parts.join(", "), if limit.halts { "halt" } else { "warn" });
        self.cause(limit.span, "energy limit", 1, "step", detail);
        Some(limit)
    }

    fn increment_rows(&mut self, step: &crate::model::Step, forces: &[Box<dyn Force>]) {
        let mut detail = match step.increment {
            IncrementControl::Automatic { .. } if !self.places.elements.is_empty() => {
                format!("stable increment times {}", step.scale_factor)
            }
            IncrementControl::Fixed(dt) => format!("fixed increment {dt:e} (direct user control)"),
            IncrementControl::Automatic { accuracy, .. } => {
                format!("nothing limits the increment: error estimate, accuracy {accuracy:e}")
            }
        };
        if let IncrementControl::Automatic { largest, .. } = step.increment
            && largest.is_finite()
        {
            detail += &format!(", at most {largest:e}");
        }
        self.cause(step.span, "central difference", 1, "step", detail);
        if forces.iter().any(|f| f.reads_velocity()) {
            let scheme = match step.load_velocity {
                LoadVelocity::Predicted => "second-order estimate at the increment's own time",
                LoadVelocity::Lagged => "mid-increment velocity behind (LAGGED)",
            };
            self.cause(step.span, "load velocity", 1, "step", scheme.into());
        }
    }

    fn check_complete(&mut self, deforms: bool) {
        if self.diagnostics.has_errors() {
            return;
        }
        if self.model.rigid_bodies.is_empty() && !deforms || self.model.steps.is_empty() {
            let missing = if self.model.steps.is_empty() { "step with *DYNAMIC, EXPLICIT" } else { "body that moves" };
            let mut finding = Diagnostic::error("P006", format!("nothing to simulate: the deck has no {missing}"));
            if let Some(card) = self.deck.cards.last() {
                finding = finding.at(card.span, "the deck ends after this card");
            }
            self.diagnostics.push(
                finding.help("a run needs a *RIGID BODY or a *SOLID SECTION, and a *STEP with *DYNAMIC, EXPLICIT"),
            );
        }
    }

    fn list_inert(&mut self) {
        for inert in &self.model.inert {
            self.unused(inert.span, format!("*{}", inert.keyword), inert.why.clone());
        }
    }
}

fn owned(arrays: Vec<(&'static str, usize)>) -> Vec<(String, usize)> {
    arrays.into_iter().map(|(name, bytes)| (name.to_owned(), bytes)).collect()
}
