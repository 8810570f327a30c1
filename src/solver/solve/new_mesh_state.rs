//! State of a run at the first instant of a new mesh, taken from the run with the old mesh: the motion of bodies, element
//! variables, masses, temperatures, deleted elements, and the memory of constraints.

use rustc_hash::{FxHashMap, FxHashSet};

use super::run_state::RunState;
use crate::constraint::contact::ContactConstraint;
use crate::constraint::equation::EquationConstraint;
use crate::constraint::{PreviousPlace, of_kind_mut, prescribed_motions};
use crate::element::elements::Elements;
use crate::element::group::ArrivedElements;
use crate::element::mass_scaling::ArrivedScaling;
use crate::element::user_field::NodalFieldInput;
use crate::heat::ThermalState;
use crate::kernel::lanes::{InlineMap, PACK, Pack};
use crate::kernel::quad;
use crate::kernel::shape::share_between;
use crate::load::SceneChange;
use crate::material::PointValue;
use crate::model::Model;
use crate::model::remesh::{ModelBody, single_nodes};
use crate::plan::{Plan, RemeshPlan, RemeshedBody, State};
use crate::remesh::balanced_parts::balanced_parts;
use crate::remesh::overlap::common_parts;
use crate::remesh::transfer::{BodyMotion, MeshTransfer};
use crate::remesh::{BodyMesh, INSIDE, MeshRevision};
use crate::state::Instant;
use crate::state::archive::{Persist, StateArchive};
use crate::state::magnitude::AmplitudeClock;
use crate::state::nodes::{Node, Nodes};

/// A body with its old mesh, of the elements that are neither deleted nor left out, and its new one.
#[derive(Clone, Copy)]
pub(super) struct ReplacedMesh<'a> {
    pub(super) body: usize,
    /// Bodies with their old meshes.
    pub(super) old_plan: &'a RemeshPlan,
    pub(super) old: &'a BodyMesh,
    /// Elements of the old mesh, as indices in the body.
    pub(super) living: &'a [usize],
    pub(super) revision: &'a MeshRevision,
}

/// Takes the state of the run with the old mesh.
pub(super) fn take_over(run: &mut RunState<'_>, old: &mut RunState<'_>, mesh: ReplacedMesh<'_>) {
    run.body_forces.values.clone_from(&old.body_forces.values);
    let now = run.now;
    let (Some(remesh), old_remesh) = (&run.plan.remesh, mesh.old_plan) else { return };
    // The groups of all bodies in the new plan carry their variables, also those that still have the mesh of the deck.
    for body in &old_remesh.bodies {
        if let Some(transfer) = old.state.elements.groups[body.group].transfer() {
            transfer.prepare();
        }
    }
    let mut change = MeshChange {
        plan: run.plan,
        state: &mut run.state,
        body: &remesh.bodies[mesh.body],
        old_plan: old.plan,
        old: &mut old.state,
        old_body: &old_remesh.bodies[mesh.body],
        mesh,
    };
    change.take_over_bodies();
    change.take_over_amplitudes();
    let places = change.take_over_nodes(&old_remesh.model);
    change.take_over_groups();
    change.give_fields(now);
    change.state.dofs.energies = change.old.dofs.energies;
    change.move_body(places);
    change.state.elements.wake();
}

/// The state on a new mesh of a body, and the state on the old mesh from which it is taken.
struct MeshChange<'a> {
    plan: &'a Plan,
    state: &'a mut State,
    body: &'a RemeshedBody,
    old_plan: &'a Plan,
    old: &'a mut State,
    old_body: &'a RemeshedBody,
    mesh: ReplacedMesh<'a>,
}

/// Transfer between the meshes of a body, without mass scaling.
struct BodyTransfer<'a> {
    living: LivingElements,
    transfer: MeshTransfer<'a>,
    /// Corner masses of the old and of the new elements.
    old_masses: Vec<[f64; 4]>,
    masses: Vec<[f64; 4]>,
    /// Volumes of the material in the old elements.
    volumes: Vec<f64>,
}

impl MeshChange<'_> {
    /// Takes the motion of rigid bodies.
    fn take_over_bodies(&mut self) {
        for (body, previous) in self.state.dofs.bodies.iter_mut().zip(&self.old.dofs.bodies) {
            body.clone_from(previous);
            body.contact = 0.0;
        }
    }

    fn take_over_amplitudes(&mut self) {
        self.state.user_amplitudes.clone_from(&self.old.user_amplitudes);
        let pairs = self.state.amplitude_routines.iter_mut().zip(&mut self.old.amplitude_routines);
        pairs.for_each(|(amplitude, previous)| copy_state(previous, amplitude));
    }

    /// Sets prescribed temperatures and field variables of elements at this instant.
    fn give_fields(&mut self, now: Instant) {
        let State { elements, user_amplitudes, dofs, .. } = &mut *self.state;
        let input = NodalFieldInput { dofs, increment: 0.0, routine: None };
        // Only a user subroutine can fail. Bodies with new meshes have none for their fields.
        let given = elements.give_fields(&AmplitudeClock { now, user_amplitudes }, input);
        debug_assert!(given.is_ok(), "no subroutine is called");
    }

    /// Takes the state of other element groups, and of adaptive domains.
    fn take_over_groups(&mut self) {
        let replaced = self.body.group;
        let State { elements, adaptive, .. } = &mut *self.state;
        for (index, (group, previous)) in elements.groups.iter_mut().zip(&mut self.old.elements.groups).enumerate() {
            if index != replaced {
                copy_state(&mut **previous, &mut **group);
            } else if let (Some(user), Some(previous)) = (group.user(), previous.user()) {
                let (constants, previous) = (user.constants(), previous.constants());
                (constants.bulk, constants.shear) = (previous.bulk, previous.shear);
            }
        }
        for (domain, previous) in adaptive.iter_mut().zip(&mut self.old.adaptive) {
            if replaced == domain.group() { domain.follow(previous) } else { copy_state(previous, domain) }
        }
    }

    /// Takes places, velocities at this instant and masses of the nodes of other bodies. Returns the old place of each node
    /// that has one.
    fn take_over_nodes(&mut self, old_model: &Model) -> Vec<Option<PreviousPlace>> {
        let mut places = vec![None; self.state.dofs.nodes.len()];
        let removed = ModelBody::new(old_model, self.mesh.body).nodes;
        let remaining = (0..old_model.mesh.points.len()).filter(|node| removed.binary_search(node).is_err());
        for (node, old_node) in remaining.enumerate() {
            let (current, previous) = (&self.plan.places, &self.old_plan.places);
            let pairs = [
                (current.nodes.get(&node), previous.nodes.get(&old_node)),
                (current.rotations.get(&node), previous.rotations.get(&old_node)),
            ];
            for pair in pairs {
                if let (Some(&n), Some(&from)) = pair {
                    places[n] = Some(PreviousPlace::at(from));
                    copy_node((&mut self.state.dofs.nodes, n), (&self.old.dofs.nodes, from));
                }
            }
        }
        places
    }

    /// Moves the body to its new mesh. `places` are the old places of the nodes of other bodies.
    fn move_body(&mut self, mut places: Vec<Option<PreviousPlace>>) {
        let ReplacedMesh { old: old_mesh, living, revision, .. } = self.mesh;
        let living = LivingElements::new(self.old_body, living);
        let (scaled, factors) = (living.masses(self.old), living.factors(self.old));
        let Elements { groups, mass_scaling, .. } = &mut self.old.elements;
        mass_scaling.remove_from(groups, self.old_body.group);
        let old_masses = living.masses(self.old);
        let volumes = living.material_volumes(self.old, old_mesh);
        let unchanged = &revision.origins[..revision.unchanged];
        let parts = common_parts(old_mesh, &revision.mesh, unchanged);
        let parts = balanced_parts(parts, &volumes, (&revision.mesh, unchanged.len()));
        let transfer = MeshTransfer::new([old_mesh, &revision.mesh], parts, &old_masses);
        let mut masses = transfer.masses();
        masses.iter_mut().zip(unchanged).for_each(|(masses, e)| *masses = old_masses[*e as usize]);
        let moved = BodyTransfer { living, transfer, old_masses, masses, volumes };
        self.move_element_variables(&moved);
        self.move_temperatures(&moved, &places);
        let (transfer, masses) = if factors.is_empty() {
            (moved.transfer, moved.masses)
        } else {
            let masses = self.move_scaling(&moved, &factors);
            (moved.transfer.with_masses(&scaled), masses)
        };
        self.move_velocities(&transfer, scaled, masses);
        self.state.elements.follow_new_mesh(&self.old.elements, &self.state.dofs.nodes);
        self.follow_deletions(&places);
        for (i, n) in self.body.nodes.iter().enumerate().filter(|(i, _)| revision.parents[*i][0] != INSIDE) {
            let parents = revision.parents[i];
            let ends = parents.inline_map(|parent| old_mesh.points[parent as usize]);
            let share = share_between(ends, revision.mesh.points[i]);
            let nodes = parents.inline_map(|parent| self.old_body.nodes[parent as usize]);
            places[*n] = Some(PreviousPlace { nodes, share });
        }
        self.continue_constraints(&places);
    }

    /// Moves the variables of the elements of the body, with their masses without scaling.
    fn move_element_variables(&mut self, moved: &BodyTransfer<'_>) {
        let BodyTransfer { living, transfer, masses, volumes, .. } = moved;
        let variables: Vec<Vec<Pack>> = living.variables(self.old).iter().map(|list| transfer.values(list)).collect();
        // In the order of the group.
        let (count, after) = (self.body.elements.len(), transfer.new_mesh());
        let mut sorted = vec![vec![Pack::default(); count]; variables.len()];
        let (mut of_group, mut corners) = (vec![[0.0; 4]; count], vec![[0; 4]; count]);
        for (i, e) in self.body.elements.iter().enumerate() {
            let e = *e as usize;
            sorted.iter_mut().zip(&variables).for_each(|(list, variables)| list[e] = variables[i]);
            (of_group[e], corners[e]) = (masses[i], after.quads[i]);
        }
        let group = &mut self.state.elements.groups[self.body.group];
        if let Some(into) = group.transfer() {
            let arrived = ArrivedElements { masses: &of_group, corners: &corners, places: &after.points };
            let in_order: Vec<u32> = (0..count as u32).collect();
            into.write((&in_order, &vec![true; count]), &sorted, arrived);
            for (i, volume) in transfer.content(volumes).iter().enumerate().skip(self.mesh.revision.unchanged) {
                let ratio = volume / quad::volume(after.corners(&after.quads[i]));
                group.set(self.body.elements[i] as usize, PointValue::VolumeRatio(ratio));
            }
        }
        let bodies = [(&mut *self.old, self.old_body), (&mut *self.state, self.body)];
        copy_unchanged_elements(bodies, self.mesh.revision);
    }

    /// Moves temperatures and thermal strains. The heat that the nodes contain is conserved.
    fn move_temperatures(&mut self, moved: &BodyTransfer<'_>, places: &[Option<PreviousPlace>]) {
        let BodyTransfer { living, transfer, old_masses, masses, .. } = moved;
        let (group, nodes, old_body) = (self.body.group, &self.body.nodes, self.old_body);
        let (Some(thermal), Some(old_thermal)) = (&mut self.state.thermal, &mut self.old.thermal) else { return };
        let ThermalState { heat: old_heat, expansion: old_expansion } = &mut **old_thermal;
        if let (Some(heat), Some(old_heat)) = (&mut thermal.heat, &*old_heat) {
            heat.follow_new_mesh(old_heat, |n| places[n].and_then(|place| place.node()));
            let elements = &*self.state.elements.groups[group];
            heat.take_masses(group, |e| elements.masses(e));
            if heat.conducts(group) {
                let of_nodes = BodyMotion { masses: old_masses.clone(), velocities: Vec::new() };
                let node_masses = of_nodes.node_masses(transfer.old_mesh());
                let content = |(n, mass): (&usize, f64)| {
                    let heat = old_heat.content_at(*n, old_heat.temperatures()[*n]);
                    [if mass > 0.0 { heat / mass } else { 0.0 }, 0.0]
                };
                let velocities = old_body.nodes.iter().zip(node_masses).map(content).collect();
                let motion = BodyMotion { velocities, ..of_nodes };
                let per_mass = transfer.velocities(&motion, (masses, 0), &vec![[false; 2]; nodes.len()]);
                let arrived = BodyMotion { masses: masses.clone(), velocities: Vec::new() };
                let node_masses = arrived.node_masses(transfer.new_mesh());
                for ((n, mass), [content, _]) in nodes.iter().zip(node_masses).zip(per_mass) {
                    heat.set_content(*n, mass * content);
                }
            }
        }
        let (Some(expansion), Some(old_expansion)) = (&mut thermal.expansion, old_expansion) else { return };
        expansion.follow_new_mesh(old_expansion, group);
        // Strains that are still to be applied.
        old_expansion.add_current(-1.0, old_body.group, old_heat.as_ref(), &mut self.old.elements);
        let (Some(strains), Some(old_strains)) = (expansion.of_group(group), old_expansion.of_group(old_body.group))
        else {
            return;
        };
        let single = |e: &u32| Pack([old_strains[*e as usize]; PACK]);
        let moved_strains = transfer.values(&living.elements.iter().map(single).collect::<Vec<Pack>>());
        let elements = self.body.elements.iter().zip(moved_strains);
        elements.for_each(|(e, strain)| strains[*e as usize] = strain.0[0]);
        expansion.add_current(1.0, group, thermal.heat.as_ref(), &mut self.state.elements);
    }

    /// Moves the factors of mass scaling as means over the common parts, so that the scaled mass is conserved. Returns the
    /// scaled masses of the elements.
    fn move_scaling(&mut self, moved: &BodyTransfer<'_>, old_factors: &[[f64; 2]]) -> Vec<[f64; 4]> {
        let factors = moved.transfer.means(old_factors);
        let mut arrived = ArrivedScaling {
            masses: vec![[0.0; 4]; factors.len()],
            factors: vec![[1.0; 2]; factors.len()],
            points: self.point_masses(),
        };
        for (i, e) in self.body.elements.iter().enumerate() {
            (arrived.masses[*e as usize], arrived.factors[*e as usize]) = (moved.masses[i], factors[i]);
        }
        let State { elements, scaling, .. } = &mut *self.state;
        let Elements { groups, mass_scaling, .. } = elements;
        mass_scaling.follow_new_mesh(groups, &self.old.elements.mass_scaling, self.body.group, &arrived);
        if let (Some(scaling), Some(previous)) = (scaling, &self.old.scaling) {
            copy_state(&mut previous.clone(), scaling);
        }
        let pairs = moved.masses.iter().zip(&factors);
        pairs.map(|(masses, [_, all])| masses.inline_map(|mass| all * mass)).collect()
    }

    /// Moves the velocities, and sets the masses of the nodes. The masses are those of the old and of the new elements.
    fn move_velocities(&mut self, transfer: &MeshTransfer<'_>, old_masses: Vec<[f64; 4]>, masses: Vec<[f64; 4]>) {
        let velocities = self.old_body.nodes.iter().map(|n| self.old.dofs.nodes.velocity_now(*n)).collect();
        let motion = BodyMotion { masses: old_masses, velocities };
        let prescribed: FxHashSet<(usize, usize)> = prescribed_motions(&self.state.constraints).collect();
        let is_prescribed = |n: &usize| [0, 1].inline_map(|axis| prescribed.contains(&(*n, axis)));
        let fixed: Vec<[bool; 2]> = self.body.nodes.iter().map(is_prescribed).collect();
        let revision = self.mesh.revision;
        let velocities = transfer.velocities(&motion, (&masses, revision.unchanged), &fixed);
        let arrived = BodyMotion { masses, velocities };
        let (after, mass) = (transfer.new_mesh(), arrived.node_masses(transfer.new_mesh()));
        let attached = self.attached_masses();
        let nodes = &mut self.state.dofs.nodes;
        for (i, n) in self.body.nodes.iter().enumerate() {
            let ([r, z], [v_r, v_z]) = (after.points[i], arrived.velocities[i]);
            nodes[*n] = Node { r, z, v_r, v_z };
            (nodes.mass[*n], nodes.inverse_mass[*n]) = (mass[i], 1.0 / mass[i]);
        }
        let unchanged = self.copy_unchanged_nodes();
        let body = self.body;
        for (i, n) in body.nodes.iter().enumerate().filter(|(_, n)| !unchanged.contains(n)) {
            attached.get(n).into_iter().for_each(|mass| self.add_mass(i, *mass));
        }
    }

    /// Copies the motion and the masses of nodes whose elements have not changed. Returns these nodes.
    fn copy_unchanged_nodes(&mut self) -> FxHashSet<usize> {
        let revision = self.mesh.revision;
        let (unchanged, renewed) = revision.mesh.quads.split_at(revision.unchanged);
        let mut nodes: FxHashSet<u32> = unchanged.iter().flatten().copied().collect();
        renewed.iter().flatten().for_each(|n| _ = nodes.remove(n));
        let (of_new, of_old) = (&mut self.state.dofs.nodes, &self.old.dofs.nodes);
        let copy = |i: u32| {
            let n = self.body.nodes[i as usize];
            let from = self.old_body.nodes[revision.parents[i as usize][0] as usize];
            copy_node((of_new, n), (of_old, from));
            n
        };
        nodes.into_iter().map(copy).collect()
    }

    /// Returns the nodes of the body with point masses.
    fn point_masses(&self) -> Vec<(usize, f64)> {
        let Some(remesh) = &self.plan.remesh else { return Vec::new() };
        let masses = remesh.model.discrete.masses.iter();
        let of_node = masses.map(|point| (self.plan.places.nodes.get(&point.node), point.mass));
        let is_of_body = |n: &usize| self.body.nodes.contains(n);
        of_node.filter_map(|(n, mass)| Some((*n.filter(|n| is_of_body(n))?, mass))).collect()
    }

    /// Returns the masses at nodes of the body that its elements do not contain: point masses, and those of elements of other bodies.
    fn attached_masses(&self) -> FxHashMap<usize, f64> {
        let mut masses = FxHashMap::default();
        self.point_masses().into_iter().for_each(|(n, mass)| *masses.entry(n).or_insert(0.0) += mass);
        let shared = self.plan.remesh.iter().flat_map(|remesh| &remesh.model.remeshings[self.mesh.body].shared);
        let shared: FxHashSet<usize> =
            shared.filter_map(|(node, _)| self.plan.places.nodes.get(node)).copied().collect();
        if shared.is_empty() {
            return masses;
        }
        let groups = self.state.elements.groups.iter().enumerate().filter(|(index, _)| *index != self.body.group);
        for (group, element) in groups.flat_map(|(_, group)| (0..group.len()).map(move |element| (group, element))) {
            let corners = group.nodes(element).into_iter().zip(group.masses(element));
            for (n, mass) in corners.filter(|(n, _)| shared.contains(&(*n as usize))) {
                *masses.entry(n as usize).or_insert(0.0) += mass;
            }
        }
        masses
    }

    /// Adds a mass that new elements do not contain to a node of the body. Its momentum is that on the old mesh.
    fn add_mass(&mut self, node: usize, added: f64) {
        let [parent, _] = self.mesh.revision.parents[node];
        if parent == INSIDE {
            return;
        }
        let velocity = self.old.dofs.nodes.velocity_now(self.old_body.nodes[parent as usize]);
        let (n, nodes) = (self.body.nodes[node], &mut self.state.dofs.nodes);
        let (of_elements, mass) = (nodes.mass[n], nodes.mass[n] + added);
        let node = &mut nodes[n];
        node.v_r = (of_elements * node.v_r + added * velocity[0]) / mass;
        node.v_z = (of_elements * node.v_z + added * velocity[1]) / mass;
        (nodes.mass[n], nodes.inverse_mass[n]) = (mass, 1.0 / mass);
    }

    /// Takes which elements of other bodies are deleted, and informs loads and contact about the deleted elements again.
    fn follow_deletions(&mut self, places: &[Option<PreviousPlace>]) {
        if self.old.elements.deletions.count() == 0 {
            return;
        }
        let moved = places.iter().enumerate().filter_map(|(n, place)| Some((place.as_ref()?.node()? as u32, n as u32)));
        let new_nodes: FxHashMap<u32, u32> = moved.collect();
        let State { elements, loads, constraints, .. } = &mut *self.state;
        elements.follow_deletions(&self.old.elements, self.body.group, |n| new_nodes.get(&n).copied());
        let deleted = elements.deletions.boundaries();
        loads.iter_mut().for_each(|load| load.scene_changed(&SceneChange::DeletedElements(deleted)));
        of_kind_mut::<ContactConstraint>(constraints).for_each(|contact| contact.remove_elements(deleted));
    }

    /// Continues the constraints from all previous ones of the same kind and degrees of freedom. Their order says nothing: a
    /// condition whose nodes have all been deleted is not in the new plan.
    fn continue_constraints(&mut self, places: &[Option<PreviousPlace>]) {
        let State { constraints, loads, dofs, .. } = &mut *self.state;
        for follower in constraints.iter_mut() {
            for previous in &self.old.constraints {
                follower.follow_new_mesh(&**previous, &|node| places[node], dofs);
            }
        }
        if self.plan.remesh.as_ref().is_some_and(|remesh| has_equations(&remesh.model, self.mesh.body)) {
            of_kind_mut::<EquationConstraint>(constraints).for_each(|equations| equations.project_velocities(dofs));
        }
        for load in loads.iter_mut() {
            self.old.loads.iter().for_each(|previous| load.follow_new_mesh(&**previous, [dofs, &self.old.dofs]));
        }
        let masses = SceneChange::Masses(dofs);
        loads.iter_mut().for_each(|load| load.scene_changed(&masses));
    }
}

/// Copies the state of the elements of a body that the new mesh has from the old one.
pub(super) fn copy_unchanged_elements(
    [(old, old_body), (state, body)]: [(&mut State, &RemeshedBody); 2],
    revision: &MeshRevision,
) {
    let (from, to) = (old.elements.groups[old_body.group].transfer(), state.elements.groups[body.group].transfer());
    let (Some(from), Some(to)) = (from, to) else { return };
    let unchanged = &revision.origins[..revision.unchanged];
    let old_elements: Vec<u32> = unchanged.iter().map(|e| old_body.elements[*e as usize]).collect();
    let mut values = Vec::new();
    from.visit_elements(&old_elements, &mut |value| values.push(*value));
    let mut values = values.into_iter();
    to.visit_elements(&body.elements[..unchanged.len()], &mut |value| *value = values.next().unwrap_or_default());
}

/// Returns whether nodes of a body may take part in equations.
fn has_equations(model: &Model, body: usize) -> bool {
    let body = ModelBody::new(model, body);
    !model.constraints.ties.is_empty() || single_nodes(model).any(|node| body.position(node).is_some())
}

/// Elements of the old mesh of a body, as indices in their group.
struct LivingElements {
    group: usize,
    elements: Vec<u32>,
}

impl LivingElements {
    fn new(body: &RemeshedBody, living: &[usize]) -> LivingElements {
        let elements = living.iter().map(|i| body.elements[*i]).collect();
        LivingElements { group: body.group, elements }
    }

    /// Returns the corner masses.
    fn masses(&self, state: &State) -> Vec<[f64; 4]> {
        let group = &state.elements.groups[self.group];
        let masses = self.elements.iter().map(|e| group.masses(*e as usize));
        masses.map(|masses| [0, 1, 2, 3].inline_map(|corner: usize| masses[corner])).collect()
    }

    /// Returns the factors of mass scaling; empty without it.
    fn factors(&self, state: &State) -> Vec<[f64; 2]> {
        self.elements.iter().filter_map(|e| state.elements.mass_scaling.factors_of(self.group, *e as usize)).collect()
    }

    /// Returns the volumes of the material; those of the elements if no pressure follows from the density.
    fn material_volumes(&self, state: &mut State, mesh: &BodyMesh) -> Vec<f64> {
        let from = state.elements.groups[self.group].transfer();
        let ratio = |e: u32| from.as_ref().and_then(|from| from.volume_ratio(e)).unwrap_or(1.0);
        let elements = self.elements.iter().zip(&mesh.quads);
        elements.map(|(e, quad)| ratio(*e) * quad::volume(mesh.corners(quad))).collect()
    }

    /// Returns the carried variables in packs.
    fn variables(&self, state: &mut State) -> Vec<Vec<Pack>> {
        let group = &mut state.elements.groups[self.group];
        let count = group.len();
        let Some(from) = group.transfer() else { return Vec::new() };
        let mut values = vec![vec![Pack::default(); count]; from.variables().div_ceil(PACK)];
        let in_order: Vec<u32> = (0..count as u32).collect();
        from.read((&in_order, &vec![true; count]), &mut values);
        values.iter().map(|list| self.elements.iter().map(|e| list[*e as usize]).collect()).collect()
    }
}

/// Copies place, velocity at this instant and mass of a node.
fn copy_node((nodes, n): (&mut Nodes, usize), (previous, from): (&Nodes, usize)) {
    let [v_r, v_z] = previous.velocity_now(from);
    nodes[n] = Node { v_r, v_z, ..previous[from] };
    (nodes.mass[n], nodes.inverse_mass[n]) = (previous.mass[from], previous.inverse_mass[from]);
}

/// Copies the state of an object to another one of the same plan.
fn copy_state<T: Persist + ?Sized>(from: &mut T, to: &mut T) {
    let mut bytes = Vec::new();
    from.persist(&mut StateArchive::writer(&mut bytes));
    to.persist(&mut StateArchive::reader(&bytes));
}
