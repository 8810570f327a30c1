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
use super::run::SolverRun;
use super::timing::TimeSums;
use super::watch::RunMonitor;
use crate::element::group::ArrivedElements;
use crate::kernel::lanes::{InlineMap, PACK, Pack};
use crate::model::Model;
use crate::model::remesh::{ModelBody, revised};
use crate::plan::{self, Plan, RemeshedBody, State};
use crate::remesh::mesher::{new_mesh, sharpest};
use crate::remesh::overlap::common_parts;
use crate::remesh::transfer::{BodyMotion, MeshTransfer, interpolated};
use crate::remesh::{BodyMesh, MeshRevision};
use crate::state::Instant;
use crate::state::archive::{Persist, StateArchive};
use crate::state::halt::HaltReason;
use crate::user::Routines;

/// An angle at which a new mesh begins, times this factor, is the limit if it is smaller than that of the deck.
const WORSE: f64 = 0.5;
/// Checks without a new mesh after one could not be made, in units of the interval of checks.
const PAUSE: u64 = 5;

/// A run between two plans.
pub(super) struct DetachedRun {
    state: State,
    now: Instant,
    previous_instant: Instant,
    last_increment: f64,
    velocity_extrapolation: f64,
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
    compiled(&model, revisions).ok()
}

/// Plans a model with new meshes. No user subroutine is called in such a model; those of the first plan are in use until
/// its run ends.
fn compiled(model: &Model, revisions: &[MeshRevision]) -> Result<(Box<Plan>, State), String> {
    let (mut plan, mut state, diagnostics) = plan::compile(model, &Routines::none());
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
        let failed = |reason: String| HaltReason { code: "R210", reason };
        let model = revised(&remesh.model, &revision);
        self.remesh.revisions.push(revision);
        let (plan, state) = compiled(&model, &self.remesh.revisions)
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
        next.take_over(self, &old, body);
        next.begin_nodes(true)?;
        next.evaluate_new_mesh(self)?;
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
        let old = BodyMesh { points, quads: planned.quads.clone(), sizes };
        let mut new = new_mesh(&old, &of_model.kept(model), body)?;
        let moved: Vec<[f64; 2]> = planned.nodes.iter().map(|n| self.state.dofs.nodes.displacement(*n)).collect();
        new.displacements = interpolated(&old, &moved, &new.mesh.points);
        Some((old, new))
    }

    /// Takes the state of the run with the old mesh.
    fn take_over(&mut self, old: &mut SolverRun<'_>, mesh: &BodyMesh, body: usize) {
        let now = old.now;
        (self.now, self.previous_instant, self.last_increment) = (now, old.previous_instant, old.last_increment);
        self.balance = old.balance.clone();
        self.watch = std::mem::take(&mut old.watch);
        self.outcome = std::mem::take(&mut old.outcome);
        self.remesh = std::mem::take(&mut old.remesh);
        self.timing.add(&old.timing.sums());
        self.body_forces.values.clone_from(&old.body_forces.values);
        self.take_over_bodies(old);
        let known = self.take_over_nodes(old, body);
        let node = |n: usize| known.get(n).copied().flatten();
        for (constraint, previous) in self.state.constraints.iter_mut().zip(&old.state.constraints) {
            if let Some(follower) = constraint.upkeep() {
                follower.follow_new_mesh(&**previous, &node);
            }
        }
        for (group, (own, previous)) in
            self.state.elements.groups.iter_mut().zip(&mut old.state.elements.groups).enumerate()
        {
            if self.plan.remesh.as_ref().is_some_and(|remesh| remesh.bodies[body].group != group) {
                copy_state(&mut **previous, &mut **own);
            }
        }
        for (own, previous) in self.state.adaptive.iter_mut().zip(&mut old.state.adaptive) {
            if self.plan.remesh.as_ref().is_some_and(|remesh| remesh.bodies[body].group != own.group()) {
                copy_state(previous, own);
            } else {
                own.follow(previous);
            }
        }
        self.state.dofs.energies = old.state.dofs.energies;
        let Some(revision) = self.remesh.revisions.pop() else { return };
        self.move_body(old, (mesh, &revision), body);
        self.state.elements.wake();
        let limit = self.plan.remesh.as_ref().map_or(0.0, |remesh| remesh.bodies[body].angle);
        let angle = sharpest(&revision.mesh.quads, |n| revision.mesh.points[n as usize]);
        let quality = &mut self.remesh.bodies[body];
        (quality.limit, quality.increment) = (limit.min(WORSE * angle), 0.0);
        quality.count += 1;
        self.remesh.revisions.push(revision);
    }

    /// Takes the motion of rigid bodies, with the velocity at this instant.
    fn take_over_bodies(&mut self, old: &SolverRun<'_>) {
        let half = 0.5 * old.state.dofs.nodes.previous_dt;
        for (own, previous) in self.state.dofs.bodies.iter_mut().zip(&old.state.dofs.bodies) {
            own.clone_from(previous);
            if !own.prescribed {
                own.velocity += half * own.contact;
            }
            own.contact = 0.0;
        }
    }

    /// Takes places, velocities at this instant and masses of the nodes of other bodies. Returns the old solver node of
    /// each node that has one.
    fn take_over_nodes(&mut self, old: &SolverRun<'_>, body: usize) -> Vec<Option<usize>> {
        let mut known = vec![None; self.state.dofs.nodes.len()];
        let Some(remesh) = &old.plan.remesh else { return known };
        let removed = ModelBody::new(&remesh.model, body).nodes;
        let kept = (0..remesh.model.mesh.points.len()).filter(|node| removed.binary_search(node).is_err());
        for (new, before) in kept.enumerate() {
            let (own, previous) = (&self.plan.places, &old.plan.places);
            let pairs = [
                (own.nodes.get(&new), previous.nodes.get(&before)),
                (own.rotations.get(&new), previous.rotations.get(&before)),
            ];
            for (own, previous) in pairs {
                if let (Some(&n), Some(&from)) = (own, previous) {
                    known[n] = Some(from);
                    let (nodes, previous) = (&mut self.state.dofs.nodes, &old.state.dofs.nodes);
                    let [v_r, v_z] = previous.velocity_now(from);
                    nodes[n] = previous[from];
                    (nodes[n].v_r, nodes[n].v_z) = (v_r, v_z);
                    (nodes.mass[n], nodes.inverse_mass[n]) = (previous.mass[from], previous.inverse_mass[from]);
                }
            }
        }
        known
    }

    /// Moves masses, velocities and element variables of a body to its new mesh.
    fn move_body(&mut self, old: &mut SolverRun<'_>, (before, revision): (&BodyMesh, &MeshRevision), body: usize) {
        let (Some(own), Some(previous)) = (&self.plan.remesh, &old.plan.remesh) else { return };
        let (own, previous, after) = (&own.bodies[body], &previous.bodies[body], &revision.mesh);
        let group = &mut old.state.elements.groups[previous.group];
        let masses = previous.elements.iter().map(|e| {
            let masses = group.masses(*e as usize);
            [0, 1, 2, 3].inline_map(|corner: usize| masses[corner])
        });
        let velocities = previous.nodes.iter().map(|n| old.state.dofs.nodes.velocity_now(*n)).collect();
        let motion = BodyMotion { masses: masses.collect(), velocities };
        let transfer = MeshTransfer::new([before, after], common_parts(before, after), &motion.masses);
        let mut held = vec![[false; 2]; own.nodes.len()];
        let forces = self.state.constraints.iter().filter_map(|constraint| constraint.view().forces);
        let prescribed: std::collections::HashSet<(usize, usize)> = forces.flat_map(|f| f.prescribed()).collect();
        for (held, n) in held.iter_mut().zip(&own.nodes) {
            *held = [0, 1].inline_map(|axis| prescribed.contains(&(*n, axis)));
        }
        let masses = transfer.masses();
        let velocities = transfer.velocities(&motion, &masses, &held);
        let arrived = BodyMotion { masses, velocities };
        let mass = arrived.node_masses(after);
        let nodes = &mut self.state.dofs.nodes;
        for (i, n) in own.nodes.iter().enumerate() {
            let ([r, z], [v_r, v_z]) = (after.points[i], arrived.velocities[i]);
            nodes[*n] = crate::state::nodes::Node { r, z, v_r, v_z };
            (nodes.mass[*n], nodes.inverse_mass[*n]) = (mass[i], 1.0 / mass[i]);
        }
        let Some(from) = group.extensions().transfer() else { return };
        let packs = from.variables().div_ceil(PACK);
        let count = previous.elements.len();
        let mut values = vec![vec![Pack::default(); count]; packs];
        let in_order: Vec<u32> = (0..count as u32).collect();
        from.read((&in_order, &vec![true; count]), &mut values);
        let moved: Vec<Vec<Pack>> = values
            .iter()
            .map(|list| transfer.values(&previous.elements.iter().map(|e| list[*e as usize]).collect::<Vec<Pack>>()))
            .collect();
        // In the order of the group.
        let count = own.elements.len();
        let mut sorted = vec![vec![Pack::default(); count]; packs];
        let (mut masses, mut corners) = (vec![[0.0; 4]; count], vec![[0; 4]; count]);
        for (i, e) in own.elements.iter().enumerate() {
            let e = *e as usize;
            sorted.iter_mut().zip(&moved).for_each(|(list, moved)| list[e] = moved[i]);
            (masses[e], corners[e]) = (arrived.masses[i], after.quads[i]);
        }
        if let Some(into) = self.state.elements.groups[own.group].extensions().transfer() {
            let arrived = ArrivedElements { masses: &masses, corners: &corners, places: &after.points };
            let in_order: Vec<u32> = (0..count as u32).collect();
            into.write((&in_order, &vec![true; count]), &sorted, arrived);
        }
    }

    /// Evaluates the forces of the new mesh at the instant at which the old one was left. The loss of kinetic energy is that
    /// of the transfer.
    fn evaluate_new_mesh(&mut self, old: &SolverRun<'_>) -> Result<(), HaltReason> {
        let kinetic = |run: &SolverRun<'_>| {
            run.state.dofs.energies.kinetic + run.state.dofs.bodies.iter().map(|body| body.kinetic()).sum::<f64>()
        };
        let before = kinetic(old);
        self.show_own_velocity();
        self.evaluate_forces()?;
        self.accelerate()?;
        self.balance.take_forces(&self.body_forces.values);
        self.complete = true;
        self.state.dofs.energies.advection += before - kinetic(self);
        Ok(())
    }

    fn detach(self) -> DetachedRun {
        DetachedRun {
            state: self.state,
            now: self.now,
            previous_instant: self.previous_instant,
            last_increment: self.last_increment,
            velocity_extrapolation: self.velocity_extrapolation,
            body_forces: self.body_forces,
            balance: self.balance,
            watch: self.watch,
            remesh: self.remesh,
            seconds: self.timing.sums(),
            outcome: self.outcome,
        }
    }
}

/// Copies the state of an object to another one of the same plan.
fn copy_state<T: Persist + ?Sized>(from: &mut T, to: &mut T) {
    let mut bytes = Vec::new();
    from.persist(&mut StateArchive::writer(&mut bytes));
    to.persist(&mut StateArchive::reader(&bytes));
}
