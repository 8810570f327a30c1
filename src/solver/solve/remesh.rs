//! New meshes of bodies in the time loop. A plan belongs to one mesh; the run continues with the plan of the model with
//! the new mesh, from the state that is transferred to it at the current instant.

use std::time::Instant as Stopwatch;

use super::body_forces::BodyForces;
use super::energy::EnergyBalance;
use super::increment::IncrementController;
use super::masses::MassMonitor;
use super::mesh_patch::{can_have_patch, starts};
use super::mesh_quality::{RemeshMonitor, has_folded};
use super::new_mesh_state::{ReplacedMesh, copy_unchanged_elements, take_over};
use super::observe::RunOutput;
use super::position::RunPosition;
use super::restart::begin_step;
use super::routines::UserSession;
use super::run::SolverRun;
use super::run_state::RunState;
use super::timing::TimeSums;
use super::watch::RunReport;
use crate::constraint::contact::ContactConstraint;
use crate::constraint::of_kind_mut;
use crate::element::elements::Elements;
use crate::kernel::lanes::InlineMap;
use crate::kernel::quad;
use crate::kernel::shape::middle;
use crate::model::Model;
use crate::model::remesh::{ModelBody, movable_nodes_of_histories, required_nodes, revised};
use crate::plan::{self, CompiledModel, FirstMesh, Plan, RemeshPlan, State};
use crate::remesh::interpolation::{TracerPoint, places_in_triangles};
use crate::remesh::mesher::{OutlineRules, new_mesh};
use crate::remesh::outline::boundary_edges;
use crate::remesh::patch::new_patch;
use crate::remesh::sheets::thin_elements;
use crate::remesh::{BodyMesh, INSIDE, MeshRevision};
use crate::state::Instant;
use crate::state::dofs::Dofs;
use crate::state::halt::{HaltDetails, HaltReason};
use crate::user::Routines;
use crate::variables::Variable;

/// Fraction of the largest density of a body below which a failed element consists of fragments.
const EXPANDED: f64 = 0.5;

/// The part of a run that does not depend on its mesh.
struct RunHistory {
    now: Instant,
    previous_instant: Instant,
    last_increment: f64,
    balance: EnergyBalance,
    masses: MassMonitor,
    user: UserSession,
    report: RunReport,
    remesh: RemeshMonitor,
    seconds: TimeSums,
}

impl RunHistory {
    fn take(run: &mut SolverRun<'_>) -> RunHistory {
        let SolverRun { current, user, report, remesh, timing, .. } = run;
        RunHistory {
            now: current.now,
            previous_instant: current.previous_instant,
            last_increment: current.last_increment,
            balance: current.balance.clone(),
            masses: std::mem::take(&mut current.masses),
            user: std::mem::take(user),
            report: std::mem::take(report),
            remesh: std::mem::take(remesh),
            seconds: timing.take_sums(&current.plan.ledger),
        }
    }

    fn give_to(self, run: &mut SolverRun<'_>) {
        let current = &mut run.current;
        (current.now, current.previous_instant) = (self.now, self.previous_instant);
        current.last_increment = self.last_increment;
        (current.balance, current.masses) = (self.balance, self.masses);
        (run.user, run.report, run.remesh) = (self.user, self.report, self.remesh);
        run.timing.add(&self.seconds, &current.plan.ledger);
    }
}

/// A run between two plans.
pub(super) struct DetachedRun {
    state: State,
    body_forces: BodyForces,
    history: RunHistory,
}

impl DetachedRun {
    fn detach(mut run: SolverRun<'_>) -> DetachedRun {
        let history = RunHistory::take(&mut run);
        DetachedRun { state: run.current.state, body_forces: run.current.body_forces, history }
    }

    #[cfg(test)]
    pub(super) fn state(&self) -> &State {
        &self.state
    }

    #[cfg(test)]
    pub(super) fn monitor(&self) -> &RemeshMonitor {
        &self.history.remesh
    }

    /// Continues the run with its plan.
    pub(super) fn attach<'a>(self, plan: &'a Plan, position: Option<&'a RunPosition>) -> SolverRun<'a> {
        let mut run = SolverRun::new(plan, self.state, position);
        run.current.use_step(&plan.steps[self.history.now.step as usize - 1]);
        run.current.body_forces = self.body_forces;
        run.current.complete = true;
        self.history.give_to(&mut run);
        run
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
    let mut model = match &plan.remesh {
        Some(remesh) => remesh.model.clone(),
        None => plan.automatic_meshes.as_ref()?.model(),
    };
    for revision in revisions {
        let elements = model.remeshings.get(revision.body)?.elements.len();
        if revision.origins.iter().any(|origin| *origin as usize >= elements) {
            return None;
        }
        model = revised(&model, revision);
    }
    compiled(&model, revisions, &plan.routines).ok()
}

/// Plans a model with new meshes.
fn compiled(model: &Model, revisions: &[MeshRevision], routines: &Routines) -> Result<(Box<Plan>, State), String> {
    let CompiledModel { mut plan, mut state, diagnostics } = plan::compile(model, routines);
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
        for (i, start) in last.starts.iter().enumerate() {
            state.dofs.nodes.start[body.nodes[i]] = *start;
            plan.mesh.points[of_model.nodes[i]] = *start;
        }
    }
}

/// Remeshes a body and continues with the plan of the new mesh; `None` if no valid mesh is found.
///
/// # Errors
/// If the model with the new mesh cannot be planned or evaluated.
pub(super) fn next_mesh(
    run: &mut SolverRun<'_>,
    body: usize,
    observing: &mut RunOutput,
) -> Result<Option<NextMesh>, HaltReason> {
    let began = Stopwatch::now();
    let (old_plan, old_increment) = (run.current.plan, run.current.state.elements.stable_increment());
    let waiting = old_plan.automatic_meshes.as_ref();
    let trigger = waiting.and_then(|waiting| waiting.triggers().nth(body)).map(|(_, trigger)| trigger);
    let first = waiting.map(|waiting| waiting.remesh_plan(&old_plan.places));
    let Some(remesh) = first.as_ref().or(old_plan.remesh.as_deref()) else { return Ok(None) };
    let planned = &remesh.bodies[body];
    let is_folded = matches!(trigger, Some(FirstMesh::Squashed(_))) && has_folded(&run.current, planned.group);
    let Some(BodyRevision { old: old_mesh, living, left_out, revision }) =
        body_revision(&run.current, &run.remesh, body, remesh)
    else {
        pause(run, body, remesh);
        return Ok(None);
    };
    let model = revised(&remesh.model, &revision);
    run.remesh.revisions.push(revision.clone());
    let (plan, state) = match continuation(&model, run) {
        Ok(continuation) => continuation,
        Err(_) if planned.automatic => {
            run.remesh.revisions.pop();
            pause(run, body, remesh);
            return Ok(None);
        }
        Err(reason) => return Err(HaltReason::NewMesh(HaltDetails::new(reason))),
    };
    run.name_limiting_element();
    let mut next = SolverRun::new(&plan, state, None);
    next.current.state.elements.use_arch(run.current.state.elements.arch());
    let mut output = RunOutput::new(&plan);
    let mut begun: Option<IncrementController> = None;
    for index in 0..run.current.now.step as usize {
        begin_step(&mut next, index, &mut output, &mut begun);
    }
    observing.add_completion(&run.current);
    leave_out(run, (body, remesh), &left_out);
    let kinetic = complete_velocities(&mut run.current.state);
    RunHistory::take(run).give_to(&mut next);
    let mesh = ReplacedMesh { body, old_plan: remesh, old: &old_mesh, living: &living, revision: &revision };
    take_over(&mut next.current, &mut run.current, mesh);
    let lost_energy = match evaluate_new_mesh(&mut next, kinetic) {
        Ok(lost_energy) => lost_energy,
        Err(halt) => {
            RunHistory::take(&mut next).give_to(run);
            return Err(halt);
        }
    };
    // The evaluation divides stresses into mean and deviator, whose sum may differ in the last bit.
    if let Some(new_plan) = &plan.remesh {
        let bodies = [(&mut run.current.state, planned), (&mut next.current.state, &new_plan.bodies[body])];
        copy_unchanged_elements(bodies, &revision);
    }
    let increments = [old_increment, next.current.state.elements.stable_increment()];
    let quality = &mut next.remesh.bodies[body];
    quality.begin_mesh(planned, &revision, increments);
    quality.lost_energy += lost_energy;
    if planned.automatic && quality.is_first() {
        let counts = [old_mesh.quads.len(), revision.mesh.quads.len()].inline_map(|count| count - revision.unchanged);
        warn_of_first_mesh(&mut next, (body, remesh), (trigger, is_folded), counts, increments);
    }
    let row = plan.remesh.as_ref().and_then(|remesh| remesh.bodies[body].id);
    next.timing.add_whole(row, began.elapsed().as_secs_f64());
    output.follow(std::mem::replace(observing, RunOutput::new(&plan)), &next.current.now);
    *observing = output;
    let run = DetachedRun::detach(next);
    Ok(Some(NextMesh { plan, run }))
}

/// Plans a model with a new mesh that has the columns of the histories of a run.
fn continuation(model: &Model, run: &SolverRun<'_>) -> Result<(Box<Plan>, State), String> {
    let old_plan = run.current.plan;
    let (plan, state) = compiled(model, &run.remesh.revisions, &old_plan.routines)
        .map_err(|error| format!("the model with a new mesh cannot be planned: {error}"))?;
    if plan.column_names() != old_plan.column_names() {
        return Err("the new mesh does not have all nodes and elements of the histories".into());
    }
    Ok((plan, state))
}

/// Keeps the mesh of a body for some time after no new one could be made. The first time is reported.
fn pause(run: &mut SolverRun<'_>, body: usize, remesh: &RemeshPlan) {
    run.remesh.bodies[body].pause(run.current.now.increment, remesh.bodies[body].frequency);
    if !std::mem::replace(&mut run.remesh.reported, true) {
        let (set, time) = (&remesh.model.remeshings[body].set, run.current.now.total_time);
        let reason = if remesh.bodies[body].automatic {
            format!("plastic flow has squashed elements of the body of material {set}, but")
        } else {
            format!("`{set}`:")
        };
        let text = format!("{reason} no valid new mesh was found at time {time:.4e}; the body keeps its mesh for now");
        run.report.outcome.warn("R317", text);
    }
}

/// Reports that a body that no card names has a new mesh: the trigger, and whether a corner has turned over; the numbers of
/// replaced and of new elements; the stable time increments before and after it.
fn warn_of_first_mesh(
    run: &mut SolverRun<'_>,
    (body, remesh): (usize, &RemeshPlan),
    (trigger, is_folded): (Option<FirstMesh>, bool),
    [replaced, renewed]: [usize; 2],
    [old, new]: [f64; 2],
) {
    let (material, all) = (&remesh.model.remeshings[body].set, remesh.bodies[body].quads.len());
    let change = if replaced < all {
        format!("{replaced} of its {all} elements are replaced by {renewed} new ones")
    } else {
        "the body has a new mesh".into()
    };
    let cause = match trigger {
        Some(FirstMesh::Sharp(limit)) => {
            let angle = limit.to_degrees();
            format!(
                "smoothing has not kept the angles of the adaptive mesh of material {material} above {angle:.0} degrees, and"
            )
        }
        _ if is_folded => {
            format!("plastic flow has turned over a corner of an element of the body of material {material}, and")
        }
        _ => format!("plastic flow has squashed elements of the body of material {material} until"),
    };
    let text = format!(
        "{cause} the stable time increment fell to {old:.3e}: at time {:.4e} {change}, and the stable time increment is {new:.3e}. The mesh is \
         repaired from now on whenever it collapses; *REMESH has options for new meshes, and *REMESH, AUTOMATIC=NO keeps the mesh",
        run.current.now.total_time
    );
    run.report.outcome.warn("R319", text);
}

/// A body at the instant of a new mesh.
struct BodyRevision {
    /// Its mesh without deleted elements and thin sheets.
    old: BodyMesh,
    /// Elements of this mesh, and elements of thin sheets, as indices in the body.
    living: Vec<usize>,
    left_out: Vec<usize>,
    revision: MeshRevision,
}

/// Adds the elements of thin sheets of a body, which its new mesh does not have, to its account: their elastic energy counts as
/// dissipated. The first time is reported.
fn leave_out(run: &mut SolverRun<'_>, (body, remesh): (usize, &RemeshPlan), left_out: &[usize]) {
    let (planned, quality) = (&remesh.bodies[body], &mut run.remesh.bodies[body]);
    let Some(&first) = left_out.first() else { return };
    let State { elements, dofs, .. } = &mut run.current.state;
    let group = &elements.groups[planned.group];
    let was_reported = quality.removed_mass > 0.0;
    for element in left_out.iter().map(|i| planned.elements[*i] as usize) {
        quality.removed_mass += mass_of(elements, planned.group, element);
        dofs.energies.plastic += group.value(element, Variable::ElementStrainEnergy.into()).unwrap_or(0.0).max(0.0);
    }
    if !was_reported {
        let [r, z] = middle(planned.quads[first].inline_map(|n| dofs.nodes[planned.nodes[n as usize]].place()));
        let text = format!(
            "`{}`: sheets of the body that are thinner than {} of the edges of new elements, and failed elements of less than half \
             the density, are left out of new meshes, first near \
             (r = {r:.4e}, z = {z:.4e}) at time {:.4e}; the summary has their mass",
            remesh.model.remeshings[body].set, remesh.model.remeshings[body].thickness, run.current.now.total_time
        );
        run.report.outcome.warn("R321", text);
    }
}

/// Returns the mesh of a body at this instant, and the one that replaces it. `monitor` has the previous new meshes.
fn body_revision(
    run: &RunState<'_>,
    monitor: &RemeshMonitor,
    body: usize,
    remesh: &RemeshPlan,
) -> Option<BodyRevision> {
    let (planned, model, nodes) = (&remesh.bodies[body], &remesh.model, &run.state.dofs.nodes);
    let of_model = ModelBody::new(model, body);
    let last = monitor.revisions.iter().rev().find(|revision| revision.body == body);
    let sizes = match (model.remeshings[body].size, last) {
        (Some(size), _) => vec![size; planned.quads.len()],
        (None, Some(last)) => last.mesh.sizes.clone(),
        (None, None) => of_model.sizes(&model.mesh),
    };
    let points: Vec<[f64; 2]> = planned.nodes.iter().map(|n| nodes[*n].place()).collect();
    let group = &run.state.elements.groups[planned.group];
    let is_living = |i: &usize| !group.is_deleted(planned.elements[*i] as usize);
    let living: Vec<usize> = (0..planned.quads.len()).filter(is_living).collect();
    let of_living = |living: &[usize]| {
        let (quads, sizes) = living.iter().map(|i| (planned.quads[*i], sizes[*i])).unzip();
        BodyMesh { points: Vec::clone(&points), quads, sizes }
    };
    let shared = of_model.shared_nodes(model);
    let (mut kept, old) = (of_model.kept(model), of_living(&living));
    shared.iter().for_each(|n| kept[*n as usize] = true);
    let loose = loose_elements(&run.state.elements, planned.group, &old, |i| planned.elements[living[i]] as usize);
    let (living, left_out, old) =
        match thin_elements(&old, model.remeshings[body].thickness, |i| loose[i], |n| kept[n as usize]) {
            Some(thin) => {
                let with = |is_thin: bool| {
                    let pairs = living.iter().zip(&thin).filter(|(_, thin)| **thin == is_thin);
                    pairs.map(|(i, _)| *i).collect::<Vec<usize>>()
                };
                let rest = with(false);
                let old = of_living(&rest);
                (rest, with(true), old)
            }
            None => (living, Vec::new(), old),
        };
    let mut used = vec![false; planned.nodes.len()];
    living.iter().flat_map(|i| planned.quads[*i]).for_each(|n| used[n as usize] = true);
    let is_lost = |node: usize| of_model.nodes.binary_search(&node).is_ok_and(|index| !used[index]);
    if required_nodes(model).any(is_lost) || shared.iter().any(|n| !used[*n as usize]) {
        return None;
    }
    let strain = |i: usize| {
        let element = planned.elements[living[i]] as usize;
        group.value(element, Variable::PlasticStrain.into()).unwrap_or(0.0)
    };
    let limited = model.remeshings[body].limits.apply(&old, strain);
    let place_between = |ends: [u32; 2], share| {
        let ends = ends.inline_map(|n| planned.nodes[n as usize]);
        run.contacts().find_map(|contact| contact.system.place_between(ends, share, &run.state.dofs))
    };
    let rules = OutlineRules { kept: &kept, fixed: &edges_between(&old, &shared), place: &place_between };
    let allows_patch = monitor.bodies[body].allows_patch() && can_have_patch(run, planned, &living);
    let patch = if allows_patch { new_patch(&old, &rules) } else { None };
    let mut new = match patch {
        Some(patch) => patch,
        None => new_mesh(&old, &rules, limited)?,
    };
    new.body = body;
    new.origins.iter_mut().for_each(|origin| *origin = living[*origin as usize] as u32);
    new.sides.iter_mut().for_each(|side| side.old.0 = living[side.old.0 as usize] as u32);
    new.starts = starts(run, planned, (&old, &new));
    new.tracers = tracers(run, model, (&of_model, &old), &new);
    new.places = if model.constraints.ties.is_empty() { Vec::new() } else { node_places(run, model) };
    Some(BodyRevision { old, living, left_out, revision: new })
}

/// Returns the edges of the boundary of a body between nodes of a list, which is in ascending order; the edges are, too.
fn edges_between(mesh: &BodyMesh, nodes: &[u32]) -> Vec<[u32; 2]> {
    if nodes.is_empty() {
        return Vec::new();
    }
    let edges = boundary_edges(&mesh.quads).into_iter().map(|edge| edge.ends);
    edges.filter(|ends| ends.iter().all(|n| nodes.binary_search(n).is_ok())).collect()
}

/// Returns the places of all nodes of the model.
fn node_places(run: &RunState<'_>, model: &Model) -> Vec<[f64; 2]> {
    let place = |(node, start): (usize, &[f64; 2])| {
        run.plan.places.nodes.get(&node).map_or(*start, |n| run.state.dofs.nodes[*n].place())
    };
    model.mesh.points.iter().enumerate().map(place).collect()
}

/// Returns the mass of an element without mass scaling.
fn mass_of(elements: &Elements, group: usize, element: usize) -> f64 {
    elements.groups[group].masses(element).into_iter().sum::<f64>()
        * elements.mass_scaling.unscaled_shares(group, element)[0]
}

/// Returns which elements of a mesh have failed, stay, and have expanded: cracks have separated them into fragments. `element`
/// returns the index in the group.
fn loose_elements(elements: &Elements, group: usize, mesh: &BodyMesh, element: impl Fn(usize) -> usize) -> Vec<bool> {
    let density =
        |(i, quad): (usize, &[u32; 4])| mass_of(elements, group, element(i)) / quad::volume(mesh.corners(quad));
    let densities: Vec<f64> = mesh.quads.iter().enumerate().map(density).collect();
    let whole = densities.iter().copied().fold(0.0, f64::max);
    let is_loose = |i: usize| densities[i] < EXPANDED * whole && elements.groups[group].has_failed(element(i));
    (0..densities.len()).map(is_loose).collect()
}

/// A material point of a history at the instant of a new mesh.
struct HistoryPoint {
    /// Node of the model.
    node: usize,
    start: [f64; 2],
    /// Place in the mesh, and that which histories show.
    place: [f64; 2],
    shown: [f64; 2],
}

/// Returns the points of histories in a new mesh: those between nodes of the old mesh, and its nodes that the new one does
/// not have.
fn tracers(
    run: &RunState<'_>,
    model: &Model,
    (body, old): (&ModelBody, &BodyMesh),
    new: &MeshRevision,
) -> Vec<TracerPoint> {
    let nodes = &run.state.dofs.nodes;
    let mut remains = vec![false; old.points.len()];
    new.parents.iter().filter(|[a, b]| a == b && *a != INSIDE).for_each(|parents| remains[parents[0] as usize] = true);
    let history_point = |node: usize| {
        let known = TracerPoint::index_in(&model.output.tracers, node);
        if let Some(index) = known.filter(|index| body.position(model.output.tracers[*index].between[0]).is_some()) {
            let point = &run.plan.tracers[index];
            let place = [0, 1].inline_map(|axis: usize| point.value(|node| nodes[node].place()[axis]));
            let shown = [0, 1].inline_map(|axis: usize| place[axis] + point.offset[axis]);
            return Some(HistoryPoint { node, start: point.start, place, shown });
        }
        let index = body.position(node).filter(|index| !remains[*index as usize])?;
        let (place, start) = (old.points[index as usize], nodes.start[run.plan.places.nodes[&node]]);
        Some(HistoryPoint { node, start, place, shown: place })
    };
    let points: Vec<HistoryPoint> = movable_nodes_of_histories(model).into_iter().filter_map(history_point).collect();
    let places: Vec<[f64; 2]> = points.iter().map(|point| point.place).collect();
    let found = places_in_triangles(&new.mesh, &places);
    let pairs = points.iter().zip(found);
    pairs.map(|(point, at)| TracerPoint::new(point.node, point.start, point.shown, (at, &new.mesh.points))).collect()
}

fn kinetic_energy(dofs: &Dofs) -> f64 {
    dofs.energies.kinetic + dofs.bodies.iter().map(|body| body.kinetic()).sum::<f64>()
}

/// Completes the velocities at this instant with the impulses of constraints. Returns the kinetic energy.
fn complete_velocities(state: &mut State) -> f64 {
    let State { constraints, dofs, .. } = state;
    let contacts = of_kind_mut::<ContactConstraint>(constraints);
    contacts.fold(kinetic_energy(dofs), |kinetic, contact| kinetic + contact.complete_velocities(dofs))
}

/// Evaluates the forces of the new mesh at the instant at which the old one was left. `old_kinetic` is the kinetic energy
/// on the old mesh. Returns its loss, which is that of the transfer.
fn evaluate_new_mesh(run: &mut SolverRun<'_>, old_kinetic: f64) -> Result<f64, HaltReason> {
    run.begin_nodes(true)?;
    run.current.show_own_velocity();
    run.evaluate_accelerations()?;
    let RunState { balance, body_forces, state: State { dofs, .. }, complete, .. } = &mut run.current;
    balance.take_forces(&body_forces.values);
    *complete = true;
    let loss = old_kinetic - kinetic_energy(dofs);
    dofs.energies.advection += loss;
    Ok(loss)
}
