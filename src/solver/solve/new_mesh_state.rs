//! State of a run at the first instant of a new mesh, taken from the run with the old mesh: the motion of bodies, element
//! variables, masses, temperatures, deleted elements, and the memory of constraints.

use std::collections::{HashMap, HashSet};

use super::run::SolverRun;
use crate::constraint::contact::ContactConstraint;
use crate::constraint::{PreviousPlace, of_kind_mut, prescribed_motions};
use crate::element::group::ArrivedElements;
use crate::element::mass_scaling::ArrivedScaling;
use crate::heat::ThermalState;
use crate::kernel::lanes::{InlineMap, PACK, Pack};
use crate::kernel::quad;
use crate::kernel::shape::share_between;
use crate::load::SceneChange;
use crate::model::remesh::ModelBody;
use crate::plan::{RemeshedBody, State};
use crate::remesh::balanced_parts::balanced_parts;
use crate::remesh::mesher::sharpest;
use crate::remesh::overlap::common_parts;
use crate::remesh::transfer::{BodyMotion, MeshTransfer};
use crate::remesh::{BodyMesh, INSIDE, MeshRevision};
use crate::state::archive::{Persist, StateArchive};
use crate::state::nodes::Node;

/// An angle at which a new mesh begins, times this factor, is the limit if it is smaller than that of the deck.
const WORSE: f64 = 0.5;

/// A body with its old mesh, of the elements that are not deleted, and its new one.
#[derive(Clone, Copy)]
struct ReplacedMesh<'a> {
    body: usize,
    before: &'a BodyMesh,
    revision: &'a MeshRevision,
}

impl SolverRun<'_> {
    /// Takes the state of the run with the old mesh.
    pub(super) fn take_over(&mut self, old: &mut SolverRun<'_>, mesh: &BodyMesh, body: usize) {
        let now = old.now;
        (self.now, self.previous_instant, self.last_increment) = (now, old.previous_instant, old.last_increment);
        self.balance = old.balance.clone();
        self.user = std::mem::take(&mut old.user);
        self.watch = std::mem::take(&mut old.watch);
        self.outcome = std::mem::take(&mut old.outcome);
        self.remesh = std::mem::take(&mut old.remesh);
        self.timing.add(&old.timing.sums());
        self.body_forces.values.clone_from(&old.body_forces.values);
        self.take_over_bodies(old);
        self.take_over_amplitudes(old);
        let places = self.take_over_nodes(old, body);
        self.take_over_groups(old, body);
        self.state.dofs.energies = old.state.dofs.energies;
        let Some(revision) = self.remesh.revisions.pop() else { return };
        self.move_body(old, ReplacedMesh { body, before: mesh, revision: &revision }, places);
        self.state.elements.wake();
        let limit = self.plan.remesh.as_ref().map_or(0.0, |remesh| remesh.bodies[body].angle);
        let angle = sharpest(&revision.mesh.quads, |n| revision.mesh.points[n as usize]);
        let quality = &mut self.remesh.bodies[body];
        (quality.limit, quality.increment) = (limit.min(WORSE * angle), 0.0);
        quality.count += 1;
        self.remesh.revisions.push(revision);
    }

    /// Takes the motion of rigid bodies.
    fn take_over_bodies(&mut self, old: &SolverRun<'_>) {
        for (own, previous) in self.state.dofs.bodies.iter_mut().zip(&old.state.dofs.bodies) {
            own.clone_from(previous);
            own.contact = 0.0;
        }
    }

    fn take_over_amplitudes(&mut self, old: &mut SolverRun<'_>) {
        self.state.user_amplitudes.clone_from(&old.state.user_amplitudes);
        let pairs = self.state.amplitude_routines.iter_mut().zip(&mut old.state.amplitude_routines);
        pairs.for_each(|(own, previous)| copy_state(previous, own));
    }

    /// Takes the state of other element groups, and of adaptive domains.
    fn take_over_groups(&mut self, old: &mut SolverRun<'_>, body: usize) {
        let group = self.plan.remesh.as_ref().map_or(usize::MAX, |remesh| remesh.bodies[body].group);
        let State { elements, adaptive, .. } = &mut self.state;
        for (index, (own, previous)) in elements.groups.iter_mut().zip(&mut old.state.elements.groups).enumerate() {
            if index != group {
                copy_state(&mut **previous, &mut **own);
            } else if let (Some(own), Some(previous)) = (own.extensions().user(), previous.extensions().user()) {
                own.set_moduli(previous.moduli());
            }
        }
        for (own, previous) in adaptive.iter_mut().zip(&mut old.state.adaptive) {
            if group == own.group() { own.follow(previous) } else { copy_state(previous, own) }
        }
    }

    /// Takes places, velocities at this instant and masses of the nodes of other bodies. Returns the old place of each
    /// node that has one.
    fn take_over_nodes(&mut self, old: &SolverRun<'_>, body: usize) -> Vec<Option<PreviousPlace>> {
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
                    known[n] = Some(PreviousPlace::at(from));
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

    /// Moves a body to its new mesh. `places` are the old places of the nodes of other bodies.
    fn move_body(&mut self, old: &mut SolverRun<'_>, mesh: ReplacedMesh<'_>, mut places: Vec<Option<PreviousPlace>>) {
        let (Some(own), Some(previous)) = (&self.plan.remesh, &old.plan.remesh) else { return };
        let (own, previous) = (&own.bodies[mesh.body], &previous.bodies[mesh.body]);
        let living = LivingElements::new(previous, &old.state);
        let (scaled, factors) = (living.masses(&old.state), living.factors(&old.state));
        old.state.elements.remove_scaling(previous.group);
        let plain = living.masses(&old.state);
        let meshes = [mesh.before, &mesh.revision.mesh];
        let volumes = living.material_volumes(&mut old.state, mesh.before);
        let parts = balanced_parts(common_parts(meshes[0], meshes[1]), &volumes, meshes[1]);
        let transfer = MeshTransfer::new(meshes, parts, &plain);
        let masses = transfer.masses();
        self.move_element_variables(&mut old.state, (own, &living), (&transfer, &masses, &volumes));
        self.move_temperatures(&mut old.state, (own, previous, &living), (&transfer, &plain, &masses), &places);
        let (transfer, masses) = if factors.is_empty() {
            (transfer, masses)
        } else {
            let masses = self.move_scaling(&old.state, own, (&transfer, &masses), &factors);
            (transfer.with_masses(&scaled), masses)
        };
        self.move_velocities(&old.state, (own, previous), (&transfer, scaled, masses));
        self.follow_deletions(old, own, &places);
        for (i, n) in own.nodes.iter().enumerate().filter(|(i, _)| mesh.revision.parents[*i][0] != INSIDE) {
            let parents = mesh.revision.parents[i];
            let ends = parents.inline_map(|parent| mesh.before.points[parent as usize]);
            let share = share_between(ends, mesh.revision.mesh.points[i]);
            places[*n] =
                Some(PreviousPlace { nodes: parents.inline_map(|parent| previous.nodes[parent as usize]), share });
        }
        self.continue_constraints(old, &places);
    }

    /// Moves the variables of the elements of a body, with their masses without scaling.
    fn move_element_variables(
        &mut self,
        old: &mut State,
        (own, living): (&RemeshedBody, &LivingElements),
        (transfer, masses, volumes): (&MeshTransfer<'_>, &[[f64; 4]], &[f64]),
    ) {
        let moved: Vec<Vec<Pack>> = living.variables(old).iter().map(|list| transfer.values(list)).collect();
        // In the order of the group.
        let (count, after) = (own.elements.len(), transfer.new_mesh());
        let mut sorted = vec![vec![Pack::default(); count]; moved.len()];
        let (mut of_group, mut corners) = (vec![[0.0; 4]; count], vec![[0; 4]; count]);
        for (i, e) in own.elements.iter().enumerate() {
            let e = *e as usize;
            sorted.iter_mut().zip(&moved).for_each(|(list, moved)| list[e] = moved[i]);
            (of_group[e], corners[e]) = (masses[i], after.quads[i]);
        }
        if let Some(into) = self.state.elements.groups[own.group].extensions().transfer() {
            let arrived = ArrivedElements { masses: &of_group, corners: &corners, places: &after.points };
            let in_order: Vec<u32> = (0..count as u32).collect();
            into.write((&in_order, &vec![true; count]), &sorted, arrived);
            for (i, volume) in transfer.content(volumes).iter().enumerate() {
                into.set_volume_ratio(own.elements[i], volume / quad::volume(after.corners(&after.quads[i])));
            }
        }
    }

    /// Moves temperatures and thermal strains. The heat that the nodes contain is conserved.
    fn move_temperatures(
        &mut self,
        old: &mut State,
        (own, previous, living): (&RemeshedBody, &RemeshedBody, &LivingElements),
        (transfer, plain, masses): (&MeshTransfer<'_>, &[[f64; 4]], &[[f64; 4]]),
        places: &[Option<PreviousPlace>],
    ) {
        let (Some(thermal), Some(before)) = (&mut self.state.thermal, &mut old.thermal) else { return };
        let ThermalState { heat: heat_before, expansion: expansion_before } = &mut **before;
        if let (Some(heat), Some(before)) = (&mut thermal.heat, &*heat_before) {
            heat.follow_new_mesh(before, |n| places[n].and_then(|place| place.node()));
            heat.take_masses(own.group, &*self.state.elements.groups[own.group]);
            if heat.conducts(own.group) {
                let of_nodes = BodyMotion { masses: plain.to_vec(), velocities: Vec::new() };
                let node_masses = of_nodes.node_masses(transfer.old_mesh());
                let content = |(n, mass): (&usize, f64)| {
                    let heat = before.content_at(*n, before.temperatures()[*n]);
                    [if mass > 0.0 { heat / mass } else { 0.0 }, 0.0]
                };
                let velocities = previous.nodes.iter().zip(node_masses).map(content).collect();
                let motion = BodyMotion { velocities, ..of_nodes };
                let per_mass = transfer.velocities(&motion, masses, &vec![[false; 2]; own.nodes.len()]);
                let arrived = BodyMotion { masses: masses.to_vec(), velocities: Vec::new() };
                let node_masses = arrived.node_masses(transfer.new_mesh());
                for ((n, mass), [content, _]) in own.nodes.iter().zip(node_masses).zip(per_mass) {
                    heat.set_content(*n, mass * content);
                }
            }
        }
        let (Some(expansion), Some(before)) = (&mut thermal.expansion, expansion_before) else { return };
        expansion.follow_new_mesh(before, own.group);
        // Strains that are still to be applied.
        before.add_current(-1.0, previous.group, heat_before.as_ref(), &mut old.elements);
        let (Some(strains), Some(before)) = (expansion.of_group(own.group), before.of_group(previous.group)) else {
            return;
        };
        let single = |e: &u32| Pack([before[*e as usize]; PACK]);
        let moved = transfer.values(&living.elements.iter().map(single).collect::<Vec<Pack>>());
        own.elements.iter().zip(moved).for_each(|(e, strain)| strains[*e as usize] = strain.0[0]);
        expansion.add_current(1.0, own.group, thermal.heat.as_ref(), &mut self.state.elements);
    }

    /// Moves the factors of mass scaling as means over the common parts, so that the scaled mass is conserved. Returns the
    /// scaled masses of the elements.
    fn move_scaling(
        &mut self,
        old: &State,
        own: &RemeshedBody,
        (transfer, masses): (&MeshTransfer<'_>, &[[f64; 4]]),
        factors: &[[f64; 2]],
    ) -> Vec<[f64; 4]> {
        let moved = transfer.means(factors);
        let mut arrived = ArrivedScaling { masses: vec![[0.0; 4]; moved.len()], factors: vec![[1.0; 2]; moved.len()] };
        for (i, e) in own.elements.iter().enumerate() {
            (arrived.masses[*e as usize], arrived.factors[*e as usize]) = (masses[i], moved[i]);
        }
        let State { elements, scaling, .. } = &mut self.state;
        elements.follow_scaling(&old.elements, own.group, &arrived);
        if let (Some(own), Some(before)) = (scaling, &old.scaling) {
            copy_state(&mut before.clone(), own);
        }
        masses.iter().zip(&moved).map(|(masses, [_, all])| masses.inline_map(|mass| all * mass)).collect()
    }

    /// Moves the velocities, and sets the masses of the nodes.
    fn move_velocities(
        &mut self,
        old: &State,
        (own, previous): (&RemeshedBody, &RemeshedBody),
        (transfer, before, masses): (&MeshTransfer<'_>, Vec<[f64; 4]>, Vec<[f64; 4]>),
    ) {
        let velocities = previous.nodes.iter().map(|n| old.dofs.nodes.velocity_now(*n)).collect();
        let motion = BodyMotion { masses: before, velocities };
        let mut held = vec![[false; 2]; own.nodes.len()];
        let prescribed: HashSet<(usize, usize)> = prescribed_motions(&self.state.constraints).collect();
        for (held, n) in held.iter_mut().zip(&own.nodes) {
            *held = [0, 1].inline_map(|axis| prescribed.contains(&(*n, axis)));
        }
        let velocities = transfer.velocities(&motion, &masses, &held);
        let arrived = BodyMotion { masses, velocities };
        let (after, mass) = (transfer.new_mesh(), arrived.node_masses(transfer.new_mesh()));
        let nodes = &mut self.state.dofs.nodes;
        for (i, n) in own.nodes.iter().enumerate() {
            let ([r, z], [v_r, v_z]) = (after.points[i], arrived.velocities[i]);
            nodes[*n] = Node { r, z, v_r, v_z };
            (nodes.mass[*n], nodes.inverse_mass[*n]) = (mass[i], 1.0 / mass[i]);
        }
    }

    /// Takes which elements of other bodies are deleted, and informs loads and contact about the deleted elements again.
    fn follow_deletions(&mut self, old: &SolverRun<'_>, own: &RemeshedBody, places: &[Option<PreviousPlace>]) {
        if old.state.elements.deleted() == 0 {
            return;
        }
        let moved = places.iter().enumerate().filter_map(|(n, place)| Some((place.as_ref()?.node()? as u32, n as u32)));
        let known: HashMap<u32, u32> = moved.collect();
        let State { elements, loads, constraints, .. } = &mut self.state;
        elements.follow_deletions(&old.state.elements, own.group, |n| known.get(&n).copied());
        let deleted = elements.deleted_boundaries();
        loads.iter_mut().for_each(|load| load.scene_changed(&SceneChange::DeletedElements(deleted)));
        of_kind_mut::<ContactConstraint>(constraints).for_each(|contact| contact.remove_elements(deleted));
    }

    /// Continues the constraints from all previous ones of the same kind and degrees of freedom. Their order says nothing: a
    /// condition whose nodes have all been deleted is not in the new plan.
    fn continue_constraints(&mut self, old: &SolverRun<'_>, places: &[Option<PreviousPlace>]) {
        let State { constraints, loads, dofs, .. } = &mut self.state;
        for follower in constraints.iter_mut() {
            for previous in &old.state.constraints {
                follower.follow_new_mesh(&**previous, &|node| places[node], dofs);
            }
        }
        let masses = SceneChange::Masses(dofs);
        loads.iter_mut().for_each(|load| load.scene_changed(&masses));
    }
}

/// Elements of the old mesh of a body that are not deleted, as indices in their group.
struct LivingElements {
    group: usize,
    elements: Vec<u32>,
}

impl LivingElements {
    fn new(body: &RemeshedBody, state: &State) -> LivingElements {
        let group = &state.elements.groups[body.group];
        let elements = body.elements.iter().copied().filter(|e| !group.is_deleted(*e as usize)).collect();
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
        self.elements.iter().filter_map(|e| state.elements.scaling_of(self.group, *e as usize)).collect()
    }

    /// Returns the volumes of the material; those of the elements if no pressure follows from the density.
    fn material_volumes(&self, state: &mut State, mesh: &BodyMesh) -> Vec<f64> {
        let from = state.elements.groups[self.group].extensions().transfer();
        let ratio = |e: u32| from.as_ref().and_then(|from| from.volume_ratio(e)).unwrap_or(1.0);
        let elements = self.elements.iter().zip(&mesh.quads);
        elements.map(|(e, quad)| ratio(*e) * quad::volume(mesh.corners(quad))).collect()
    }

    /// Returns the carried variables in packs.
    fn variables(&self, state: &mut State) -> Vec<Vec<Pack>> {
        let group = &mut state.elements.groups[self.group];
        let count = group.len();
        let Some(from) = group.extensions().transfer() else { return Vec::new() };
        let mut values = vec![vec![Pack::default(); count]; from.variables().div_ceil(PACK)];
        let in_order: Vec<u32> = (0..count as u32).collect();
        from.read((&in_order, &vec![true; count]), &mut values);
        values.iter().map(|list| self.elements.iter().map(|e| list[*e as usize]).collect()).collect()
    }
}

/// Copies the state of an object to another one of the same plan.
fn copy_state<T: Persist + ?Sized>(from: &mut T, to: &mut T) {
    let mut bytes = Vec::new();
    from.persist(&mut StateArchive::writer(&mut bytes));
    to.persist(&mut StateArchive::reader(&bytes));
}
