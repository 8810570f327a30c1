//! New meshes of bodies in the time loop. A plan belongs to one mesh; the run continues with the plan of the model with
//! the new mesh, from the state that is transferred to it at the current instant.

use super::body_forces::BodyForces;
use super::energy::EnergyBalance;
use super::increment::IncrementController;
use super::mesh_quality::RemeshMonitor;
use super::observe::RunOutput;
use super::outcome::Outcome;
use super::position::RunPosition;
use super::restart::begin_step;
use super::routines::UserSession;
use super::run::SolverRun;
use super::timing::TimeSums;
use super::watch::RunMonitor;
use crate::kernel::lanes::InlineMap;
use crate::model::Model;
use crate::model::remesh::{ModelBody, nodes_of_histories, revised};
use crate::plan::{self, Plan, RemeshedBody, State};
use crate::remesh::mesher::{OutlineRules, new_mesh, sharpest};
use crate::remesh::transfer::interpolated;
use crate::remesh::{BodyMesh, MeshRevision};
use crate::state::Instant;
use crate::state::halt::{HaltDetails, HaltReason};
use crate::user::Routines;
use crate::variables::Variable;

/// Checks without a new mesh after one could not be made, in units of the interval of checks.
const PAUSE: u64 = 5;

/// A run between two plans.
pub(super) struct DetachedRun {
    state: State,
    now: Instant,
    previous_instant: Instant,
    last_increment: f64,
    velocity_extrapolation: f64,
    user: UserSession,
    body_forces: BodyForces,
    balance: EnergyBalance,
    watch: RunMonitor,
    remesh: RemeshMonitor,
    seconds: TimeSums,
    outcome: Outcome,
}

impl DetachedRun {
    /// Continues the run with its plan.
    pub(super) fn attach<'a>(self, plan: &'a Plan, position: Option<&'a RunPosition>) -> SolverRun<'a> {
        let mut run = SolverRun::new(plan, self.state, position);
        run.timing.add(&self.seconds);
        SolverRun {
            step: &plan.steps[self.now.step as usize - 1],
            now: self.now,
            previous_instant: self.previous_instant,
            last_increment: self.last_increment,
            velocity_extrapolation: self.velocity_extrapolation,
            user: self.user,
            body_forces: self.body_forces,
            balance: self.balance,
            watch: self.watch,
            remesh: self.remesh,
            outcome: self.outcome,
            complete: true,
            ..run
        }
    }
}

/// The plan of a new mesh, and the run that continues with it.
pub(super) struct NextMesh {
    pub(super) plan: Box<Plan>,
    pub(super) run: DetachedRun,
}

/// Returns the plan and the state at the start of a model after several new meshes; `None` if a mesh does not belong to
/// the model.
pub(super) fn plan_of_revisions(plan: &Plan, revisions: &[MeshRevision]) -> Option<(Box<Plan>, State)> {
    let mut model: Model = plan.remesh.as_ref()?.model.clone();
    for revision in revisions {
        let known = revision.body < model.remeshings.len();
        let elements = model.remeshings.get(revision.body).map_or(0, |card| card.elements.len());
        if !known || revision.origins.iter().any(|origin| *origin as usize >= elements) {
            return None;
        }
        model = revised(&model, revision);
    }
    compiled(&model, revisions, &plan.routines).ok()
}

/// Plans a model with new meshes.
fn compiled(model: &Model, revisions: &[MeshRevision], routines: &Routines) -> Result<(Box<Plan>, State), String> {
    let (mut plan, mut state, diagnostics) = plan::compile(model, routines);
    match diagnostics.iter().find(|finding| finding.severity == crate::deck::Severity::Error) {
        Some(error) => Err(format!("{}: {}", error.code, error.message)),
        None => {
            place_starts(&mut plan, &mut state, revisions);
            Ok((Box::new(plan), state))
        }
    }
}

/// Sets the places at the start of the nodes of new meshes, from which displacements are measured.
fn place_starts(plan: &mut Plan, state: &mut State, revisions: &[MeshRevision]) {
    let Some(remesh) = &plan.remesh else { return };
    for (index, body) in remesh.bodies.iter().enumerate() {
        let Some(last) = revisions.iter().rev().find(|revision| revision.body == index) else { continue };
        let of_model = ModelBody::new(&remesh.model, index);
        for (i, u) in last.displacements.iter().enumerate() {
            let start = [0, 1].inline_map(|k: usize| last.mesh.points[i][k] - u[k]);
            state.dofs.nodes.start[body.nodes[i]] = start;
            plan.mesh.points[of_model.nodes[i]] = start;
        }
    }
}

impl SolverRun<'_> {
    /// Returns a body whose mesh is to be replaced at this instant.
    #[inline]
    pub(super) fn body_to_mesh(&mut self) -> Option<usize> {
        let plan = self.plan.remesh.as_ref()?;
        (0..plan.bodies.len()).find(|body| self.is_distorted(&plan.bodies[*body], *body))
    }

    fn is_distorted(&mut self, body: &RemeshedBody, index: usize) -> bool {
        let quality = &mut self.remesh.bodies[index];
        if self.now.increment < quality.next {
            return false;
        }
        quality.next = self.now.increment + body.frequency;
        let (nodes, elements) = (&self.state.dofs.nodes, &self.state.elements);
        let stable = elements.stable_increment();
        if quality.increment == 0.0 {
            quality.increment = stable;
        }
        let is_short = elements.limiting().0 == body.group && stable < body.increment * quality.increment;
        is_short || sharpest(&body.quads, |n| nodes[body.nodes[n as usize]].place()) < quality.limit
    }

    /// Remeshes a body and continues with the plan of the new mesh; `None` if no valid mesh is found.
    ///
    /// # Errors
    /// If the model with the new mesh cannot be planned or evaluated.
    pub(super) fn next_mesh(&mut self, body: usize, observing: &mut RunOutput) -> Result<Option<NextMesh>, HaltReason> {
        let Some(remesh) = &self.plan.remesh else { return Ok(None) };
        let Some((old, revision)) = self.revision(body, &remesh.model) else {
            let quality = &mut self.remesh.bodies[body];
            quality.next = self.now.increment + PAUSE * remesh.bodies[body].frequency;
            if !std::mem::replace(&mut self.remesh.reported, true) {
                let (set, time) = (&remesh.model.remeshings[body].set, self.now.total_time);
                let text = format!("no valid mesh was found for `{set}` at time {time:.4e}; it keeps its mesh for now");
                self.outcome.warn("R317", text);
            }
            return Ok(None);
        };
        let failed = |reason: String| HaltReason::NewMesh(HaltDetails::new(reason));
        let model = revised(&remesh.model, &revision);
        self.remesh.revisions.push(revision);
        let (plan, state) = compiled(&model, &self.remesh.revisions, &self.plan.routines)
            .map_err(|error| failed(format!("the model with a new mesh cannot be planned: {error}")))?;
        if plan.column_names() != self.plan.column_names() {
            return Err(failed("the new mesh does not have all nodes and elements of the histories".into()));
        }
        self.name_limiting_element();
        let mut next = SolverRun::new(&plan, state, None);
        next.state.elements.use_arch(self.state.elements.arch());
        let mut output = RunOutput::new(&plan);
        let mut begun: Option<IncrementController> = None;
        for index in 0..self.now.step as usize {
            begin_step(&mut next, index, &mut output, &mut begun);
        }
        observing.add_completion(self);
        let kinetic = self.complete_velocities();
        next.take_over(self, &old, body);
        next.begin_nodes(true)?;
        next.evaluate_new_mesh(kinetic)?;
        output.follow(std::mem::replace(observing, RunOutput::new(&plan)), &next.now);
        *observing = output;
        let run = next.detach();
        Ok(Some(NextMesh { plan, run }))
    }

    /// Returns the mesh of a body at this instant, and the one that replaces it.
    fn revision(&self, body: usize, model: &Model) -> Option<(BodyMesh, MeshRevision)> {
        let planned = &self.plan.remesh.as_ref()?.bodies[body];
        let of_model = ModelBody::new(model, body);
        let last = self.remesh.revisions.iter().rev().find(|revision| revision.body == body);
        let sizes = match (model.remeshings[body].size, last) {
            (Some(size), _) => vec![size; planned.quads.len()],
            (None, Some(last)) => last.mesh.sizes.clone(),
            (None, None) => of_model.sizes(&model.mesh),
        };
        let points = planned.nodes.iter().map(|n| self.state.dofs.nodes[*n].place()).collect();
        let group = &self.state.elements.groups[planned.group];
        let is_there = |i: &usize| !group.is_deleted(planned.elements[*i] as usize);
        let living: Vec<usize> = (0..planned.quads.len()).filter(is_there).collect();
        let mut used = vec![false; planned.nodes.len()];
        living.iter().flat_map(|i| planned.quads[*i]).for_each(|n| used[n as usize] = true);
        let is_lost = |node: usize| of_model.nodes.binary_search(&node).is_ok_and(|at| !used[at]);
        if nodes_of_histories(model).any(is_lost) {
            return None;
        }
        let (quads, sizes) = living.iter().map(|i| (planned.quads[*i], sizes[*i])).unzip();
        let old = BodyMesh { points, quads, sizes };
        let strain = |i: usize| {
            let element = planned.elements[living[i]] as usize;
            group.value(element, Variable::PlasticStrain.into()).unwrap_or(0.0)
        };
        let limited = model.remeshings[body].limits.apply(&old, strain);
        let place = |ends: [u32; 2], share| {
            let nodes = ends.inline_map(|n| planned.nodes[n as usize]);
            self.contacts().find_map(|contact| contact.place_between(nodes, share, &self.state.dofs))
        };
        let rules = OutlineRules { kept: &of_model.kept(model), place: &place };
        let mut new = new_mesh(&old, &rules, limited)?;
        new.body = body;
        new.origins.iter_mut().for_each(|origin| *origin = living[*origin as usize] as u32);
        new.sides.iter_mut().for_each(|side| side.old.0 = living[side.old.0 as usize] as u32);
        let moved: Vec<[f64; 2]> = planned.nodes.iter().map(|n| self.state.dofs.nodes.displacement(*n)).collect();
        new.displacements = interpolated(&old, &moved, &new.mesh.points);
        Some((old, new))
    }

    fn kinetic(&self) -> f64 {
        let dofs = &self.state.dofs;
        dofs.energies.kinetic + dofs.bodies.iter().map(|body| body.kinetic()).sum::<f64>()
    }

    /// Completes the velocities at this instant with the impulses of constraints. Returns the kinetic energy.
    fn complete_velocities(&mut self) -> f64 {
        let before = self.kinetic();
        let State { constraints, dofs, .. } = &mut self.state;
        let followers = constraints.iter_mut().filter_map(|constraint| constraint.upkeep());
        followers.fold(before, |kinetic, follower| kinetic + follower.complete_velocities(dofs))
    }

    /// Evaluates the forces of the new mesh at the instant at which the old one was left. `before` is the kinetic energy on
    /// the old mesh; its loss is that of the transfer.
    fn evaluate_new_mesh(&mut self, before: f64) -> Result<(), HaltReason> {
        self.show_own_velocity();
        self.evaluate_accelerations()?;
        self.balance.take_forces(&self.body_forces.values);
        self.complete = true;
        self.state.dofs.energies.advection += before - self.kinetic();
        Ok(())
    }

    fn detach(self) -> DetachedRun {
        DetachedRun {
            state: self.state,
            now: self.now,
            previous_instant: self.previous_instant,
            last_increment: self.last_increment,
            velocity_extrapolation: self.velocity_extrapolation,
            user: self.user,
            body_forces: self.body_forces,
            balance: self.balance,
            watch: self.watch,
            remesh: self.remesh,
            seconds: self.timing.sums(),
            outcome: self.outcome,
        }
    }
}
