//! Contact of surfaces on adaptive meshes. When nodes slide along a surface, the new places are corrected so that the gaps
//! of both surfaces continue, and the values of the keys follow their places on the surface: pressures, slip, the memory
//! of friction, clearances and stored energies.

use super::curve::PointCarrier;
use super::mesh_continuation::{KeyPlace, MeshContinuation};
use super::pairs::ContactPair;
use super::sweeps::ContactRow;
use super::system::ContactSystem;
use crate::constraint::MeshMotion;
use crate::kernel::lanes::InlineMap;
use crate::state::dofs::Dofs;

/// Number of times that gaps at the new places are measured and corrected.
const PASSES: usize = 2;
/// Sweeps over the rows in each correction.
const SWEEPS: usize = 20;
/// Largest gap of a closed row, as a fraction of the facet length of the pairs.
const CLOSED: f64 = 0.05;
/// Longest correction of a place, as a fraction of the facet length of the pairs.
const LONGEST: f64 = 0.2;

impl MeshContinuation {
    /// Allocates for a contact whose gaps or stored energies follow changes of meshes; `None` for others.
    pub(super) fn of_contact(contact: &ContactSystem) -> Option<Box<MeshContinuation>> {
        let ContactSystem { surfaces, dofs, keys, .. } = contact;
        let follows = !keys.stored_energy.stored.is_empty() || contact.mesh_pairs().next().is_some();
        follows.then(|| Box::new(MeshContinuation::new(keys.count(), surfaces.points.len(), dofs.count())))
    }

    /// Corrects new places of nodes of adaptive meshes, and moves the values of the keys to them. It follows
    /// [`ContactSystem::begin_mesh_motion`].
    pub(super) fn follow(&mut self, contact: &mut ContactSystem, dofs: &Dofs, mesh: &mut dyn MeshMotion) {
        if contact.mesh_pairs().next().is_some() && moves_near(contact, dofs, mesh) {
            contact.measure(0.0);
            self.begin(contact);
            for pass in 0..PASSES {
                contact.surfaces.read_places(|node| mesh.place(node), dofs);
                contact.search();
                contact.measure(0.0);
                if pass == 0 {
                    self.find_shares(contact);
                }
                self.correct(contact, mesh);
            }
            contact.keys.carry(self);
            self.carry_energies(contact);
            contact.surfaces.listed.clear();
        }
        self.carry_energies_on_analyticals(contact, mesh, dofs);
    }

    /// Takes places, gaps and areas at the start.
    fn begin(&mut self, contact: &ContactSystem) {
        self.starts.copy_from_slice(&contact.surfaces.places);
        self.gaps.fill(f64::NAN);
        self.areas.fill(0.0);
        for row in contact.measured.rows.rows.iter().filter(|row| row.closest_point.is_none()) {
            self.gaps[row.key as usize] = row.gap / row.area;
            self.areas[row.key as usize] = row.area;
        }
    }

    /// Finds the new places of the keys between those at the start.
    fn find_shares(&mut self, contact: &ContactSystem) {
        self.shares.clear();
        for pair in contact.mesh_pairs().filter(|pair| pair.is_active) {
            let points = contact.surfaces.curves[pair.secondary].exposed_points.iter();
            self.shares.extend(points.filter_map(|index| key_share(contact, pair, *index, &self.starts)));
        }
        self.shares.sort_unstable_by_key(|place| place.keys[0]);
    }

    /// Corrects new places by the smallest displacements of both surfaces that keep the gaps of rows under pressure and
    /// cause no overlap elsewhere: sweeps over the rows (Kaczmarz 1937). Equation (18.8).
    fn correct(&mut self, contact: &ContactSystem, mesh: &mut dyn MeshMotion) {
        self.shifts.fill(0.0);
        self.is_free.fill(false);
        for (node, dofs) in near_nodes(contact) {
            for (dof, free) in dofs.into_iter().zip(mesh.is_free(node)) {
                self.is_free[dof as usize] = free;
            }
        }
        let longest = contact.mesh_pairs().map(|pair| pair.search.length).fold(f64::INFINITY, f64::min);
        let (mut shifts, is_free) = (std::mem::take(&mut self.shifts), std::mem::take(&mut self.is_free));
        for _ in 0..SWEEPS {
            for row in contact.measured.rows.rows.iter().filter(|row| row.closest_point.is_none()) {
                let terms = contact.measured.rows.terms_of(row);
                let gap = row.gap + terms.iter().map(|t| t.normal * shifts[t.dof as usize]).sum::<f64>();
                let (target, is_closed) = self.target(contact, row, longest);
                let off = target * row.area - gap;
                let free = || terms.iter().filter(|t| is_free[t.dof as usize]);
                let size: f64 = free().map(|t| t.normal * t.normal).sum();
                if size > 0.0 && (off > 0.0 || is_closed) {
                    free().for_each(|t| shifts[t.dof as usize] += off / size * t.normal);
                }
            }
        }
        let longest = LONGEST * longest;
        for (node, dofs) in near_nodes(contact) {
            let shift = dofs.inline_map(|dof| shifts[dof as usize]);
            if shift != [0.0; 2] {
                let length = libm::hypot(shift[0], shift[1]);
                let part = if length > longest { longest / length } else { 1.0 };
                mesh.shift(node, shift.inline_map(|x| part * x));
            }
        }
        (self.shifts, self.is_free) = (shifts, is_free);
    }

    /// Returns the mean gap that a row has to keep, that of its place at the start, and whether the row is closed. Other rows
    /// keep a gap of at most zero.
    fn target(&self, contact: &ContactSystem, row: &ContactRow, length: f64) -> (f64, bool) {
        let gap = self.at_new_place(row.key, |key| self.gaps[key]);
        let is_pressed = contact.keys.pressures[row.key as usize][0] > 0.0;
        if gap.is_nan() {
            (0.0, is_pressed)
        } else if is_pressed || gap < CLOSED * length {
            (gap, true)
        } else {
            (gap.min(0.0), false)
        }
    }

    /// Moves stored energies to the new places: energies per area are interpolated, and the sum of a pair is kept.
    fn carry_energies(&mut self, contact: &mut ContactSystem) {
        let ContactSystem { surfaces, pairs, keys, measured, .. } = contact;
        let energies = keys.stored_energy.stored_mut();
        if energies.is_empty() {
            return;
        }
        let per_area = |energies: &[f64], key: usize| {
            let (energy, area) = (energies[key], self.areas[key]);
            if energy > 0.0 && area > 0.0 { energy / area } else { 0.0 }
        };
        self.stored.fill(0.0);
        for row in measured.rows.rows.iter().filter(|row| row.closest_point.is_none()) {
            let density = self.at_new_place(row.key, |key| per_area(energies, key));
            self.stored[row.key as usize] = density * row.area;
        }
        let active = surfaces.active.list.iter().map(|index| &pairs[*index as usize]);
        for pair in active.filter(|pair| pair.analytical.is_none()) {
            let keys = pair.keys();
            replace_energies(&mut energies[keys.clone()], &self.stored[keys]);
        }
    }

    /// Moves stored energies of soft contact with analytical surfaces to the new places of their keys: energies per area are
    /// interpolated, and the sum of a pair is kept.
    fn carry_energies_on_analyticals(&mut self, contact: &mut ContactSystem, mesh: &dyn MeshMotion, dofs: &Dofs) {
        if contact.keys.stored_energy.stored.is_empty() {
            return;
        }
        for index in (0..contact.pairs.len()).filter(|index| contact.pairs[*index].analytical.is_some()) {
            if self.find_energies(contact, index, mesh, dofs) {
                let pair = &contact.pairs[index];
                let first = pair.first_key as usize;
                let keys = first..first + contact.surfaces.curves[pair.secondary].points.len();
                replace_energies(&mut contact.keys.stored_energy.stored_mut()[keys.clone()], &self.stored[keys]);
            }
        }
    }

    /// Finds the energies at the new places of the keys of a pair with an analytical surface. Returns whether a point has
    /// moved.
    fn find_energies(&mut self, contact: &ContactSystem, index: usize, mesh: &dyn MeshMotion, dofs: &Dofs) -> bool {
        let (pair, surfaces) = (&contact.pairs[index], &contact.surfaces);
        let (secondary, energies) = (&surfaces.curves[pair.secondary], &contact.keys.stored_energy.stored);
        let start_of = |point: u32| surfaces.place_of(point, dofs, 0.0);
        let place_of = |point: u32| match surfaces.points[point as usize].carrier {
            PointCarrier::Node(node) => mesh.place(node).unwrap_or_else(|| start_of(point)),
            PointCarrier::Body(..) => start_of(point),
        };
        if secondary.points.iter().all(|point| place_of(*point) == start_of(*point)) {
            return false;
        }
        let density = |index: usize| {
            let (energy, area) = (energies[pair.first_key as usize + index], secondary.area_at(index, start_of));
            if energy > 0.0 && area > 0.0 { energy / area } else { 0.0 }
        };
        for (index, point) in secondary.points.iter().enumerate() {
            let mut value = density(index);
            if let Some((next, share)) = secondary.next_point(index, place_of(*point), start_of)
                && let Ok(next) = secondary.points.binary_search(&next)
            {
                value += share * (density(next) - value);
            }
            self.stored[pair.first_key as usize + index] = value * secondary.area_at(index, place_of);
        }
        true
    }
}

/// Replaces stored energies by others in proportion, so that their sum does not change. Energies that are not known yet
/// remain. Equation (18.12).
fn replace_energies(energies: &mut [f64], others: &[f64]) {
    let sum = |list: &[f64]| list.iter().filter(|energy| !energy.is_nan()).sum::<f64>();
    let sums = [sum(energies), sum(others)];
    let part = if sums[1] > 0.0 { sums[0] / sums[1] } else { 0.0 };
    for (energy, other) in energies.iter_mut().zip(others).filter(|(energy, _)| !energy.is_nan()) {
        *energy = part * other;
    }
}

/// Returns the nodes near another surface, with their degrees of freedom.
fn near_nodes(contact: &ContactSystem) -> impl Iterator<Item = (usize, [u32; 2])> {
    contact.surfaces.near.points.iter().filter_map(|point| match contact.surfaces.points[*point as usize].carrier {
        PointCarrier::Node(node) => Some((node, contact.dofs.of_points[*point as usize])),
        PointCarrier::Body(..) => None,
    })
}

/// Returns the new place of the key of an own point; `None` if it does not move along the surface.
fn key_share(contact: &ContactSystem, pair: &ContactPair, index: u32, starts: &[[f64; 2]]) -> Option<KeyPlace> {
    let secondary = &contact.surfaces.curves[pair.secondary];
    let new_place = contact.surfaces.places[secondary.points[index as usize] as usize];
    let (next, share) = secondary.next_point(index as usize, new_place, |point| starts[point as usize])?;
    Some(KeyPlace { keys: [pair.first_key + index, pair.key_of(secondary, next)], share })
}

/// Returns whether a node near another surface moves.
fn moves_near(contact: &ContactSystem, dofs: &Dofs, mesh: &dyn MeshMotion) -> bool {
    near_nodes(contact).any(|(node, _)| mesh.place(node).is_some_and(|place| place != dofs.nodes[node].place()))
}
