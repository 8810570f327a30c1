//! Contact of surfaces on adaptive meshes. When nodes slide along a surface, the new places are corrected so that the gaps
//! of both surfaces continue, and the values of the keys follow their places on the surface: pressures, slip, the memory
//! of friction, clearances and stored energies.

use super::curve::PointCarrier;
use super::mesh_continuation::{KeyPlace, MeshContinuation};
use super::sweeps::ContactRow;
use super::{ContactConstraint, ContactPair};
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
    /// Takes places, gaps and areas at the start.
    fn begin(&mut self, contact: &ContactConstraint) {
        self.starts.copy_from_slice(&contact.surfaces.places);
        self.gaps.fill(f64::NAN);
        self.areas.fill(0.0);
        for row in contact.measured.rows.rows.iter().filter(|row| row.closest_point.is_none()) {
            self.gaps[row.key as usize] = row.gap / row.area;
            self.areas[row.key as usize] = row.area;
        }
    }

    /// Finds the new places of the keys between those at the start.
    fn find_shares(&mut self, contact: &ContactConstraint) {
        self.shares.clear();
        for pair in mesh_pairs(contact).filter(|pair| pair.is_active) {
            let points = contact.surfaces.curves[pair.secondary].exposed_points.iter();
            self.shares.extend(points.filter_map(|index| key_share(contact, pair, *index, &self.starts)));
        }
        self.shares.sort_unstable_by_key(|place| place.keys[0]);
    }

    /// Corrects new places by the smallest displacements of both surfaces that keep the gaps of rows under pressure and
    /// cause no overlap elsewhere: sweeps over the rows (Kaczmarz 1937). Equation (18.8).
    fn correct(&mut self, contact: &ContactConstraint, mesh: &mut dyn MeshMotion) {
        self.shifts.fill(0.0);
        self.is_free.fill(false);
        for (node, dofs) in near_nodes(contact) {
            for (dof, free) in dofs.into_iter().zip(mesh.is_free(node)) {
                self.is_free[dof as usize] = free;
            }
        }
        let longest = mesh_pairs(contact).map(|pair| pair.search.length).fold(f64::INFINITY, f64::min);
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
    fn target(&self, contact: &ContactConstraint, row: &ContactRow, length: f64) -> (f64, bool) {
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
    fn carry_energies(&mut self, contact: &mut ContactConstraint) {
        let ContactConstraint { surfaces, pairs, keys, measured, .. } = contact;
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
    fn carry_energies_on_analyticals(&mut self, contact: &mut ContactConstraint, mesh: &dyn MeshMotion, dofs: &Dofs) {
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
    fn find_energies(&mut self, contact: &ContactConstraint, index: usize, mesh: &dyn MeshMotion, dofs: &Dofs) -> bool {
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

/// Returns the pairs of two surfaces with facets.
fn mesh_pairs(contact: &ContactConstraint) -> impl Iterator<Item = &ContactPair> {
    contact.pairs.iter().filter(|pair| pair.analytical.is_none())
}

/// Returns the nodes near another surface, with their degrees of freedom.
fn near_nodes(contact: &ContactConstraint) -> impl Iterator<Item = (usize, [u32; 2])> {
    contact.surfaces.near.points.iter().filter_map(|point| match contact.surfaces.points[*point as usize].carrier {
        PointCarrier::Node(node) => Some((node, contact.dofs.of_points[*point as usize])),
        PointCarrier::Body(..) => None,
    })
}

/// Returns the new place of the key of an own point; `None` if it does not move along the surface.
fn key_share(contact: &ContactConstraint, pair: &ContactPair, index: u32, starts: &[[f64; 2]]) -> Option<KeyPlace> {
    let secondary = &contact.surfaces.curves[pair.secondary];
    let new_place = contact.surfaces.places[secondary.points[index as usize] as usize];
    let (next, share) = secondary.next_point(index as usize, new_place, |point| starts[point as usize])?;
    Some(KeyPlace { keys: [pair.first_key + index, pair.key_of(secondary, next)], share })
}

impl ContactConstraint {
    /// Allocates for changes of adaptive meshes.
    pub fn reserve_mesh_motion(&mut self) {
        let stores_energy = !self.keys.stored_energy.stored.is_empty();
        if self.mesh.is_none() && (stores_energy || mesh_pairs(self).next().is_some()) {
            let new = MeshContinuation::new(self.keys.count(), self.surfaces.points.len(), self.dofs.count());
            self.mesh = Some(Box::new(new));
        }
    }

    /// Returns whether the contact corrects the new place of a point whose mesh moves ([`Self::follow_meshes`]), after
    /// [`Self::begin_mesh_motion`]: another surface with facets is near, no analytical one presses, and no bond acts.
    pub fn keeps_gaps(&self, carrier: PointCarrier) -> bool {
        let Some(point) = self.surfaces.point_on(carrier) else { return false };
        let mut keeps = false;
        for index in self.surfaces.active.list.iter().map(|index| *index as usize) {
            let pair = &self.pairs[index];
            let index_in = |curve: usize| self.surfaces.curves[curve].points.binary_search(&point).ok();
            let own_index = index_in(pair.secondary);
            let is_pressed = |index: usize| self.keys.pressures[pair.first_key as usize + index][0] > 0.0;
            if pair.analytical.is_some() && own_index.is_some_and(is_pressed) {
                return false;
            }
            if pair.analytical.is_none() && own_index.or_else(|| index_in(pair.other?)).is_some() {
                if self.is_cohesive(index) {
                    return false;
                }
                keeps = self.surfaces.near.has(point);
            }
        }
        keeps
    }

    /// Finds the surfaces that are near each other before adaptive meshes change, at the start of an increment of which only
    /// the motion of bodies has been made. The lists of earlier
    /// increments are not used, for they depend on when they were built.
    pub fn begin_mesh_motion(&mut self, dofs: &Dofs) {
        if mesh_pairs(self).next().is_none() {
            return;
        }
        if self.surfaces.uncovered {
            self.surfaces.list_points();
        }
        self.surfaces.read_places(|_| None, dofs);
        self.follow_deletions();
        self.search();
    }

    /// Corrects new places of nodes of adaptive meshes, and moves the values of the keys to them. It follows
    /// [`Self::begin_mesh_motion`].
    pub fn follow_meshes(&mut self, dofs: &Dofs, mesh: &mut dyn MeshMotion) {
        self.reserve_mesh_motion();
        let Some(mut work) = self.mesh.take() else { return };
        if mesh_pairs(self).next().is_some() && self.moves_near(dofs, mesh) {
            self.measure(0.0);
            work.begin(self);
            for pass in 0..PASSES {
                self.surfaces.read_places(|node| mesh.place(node), dofs);
                self.search();
                self.measure(0.0);
                if pass == 0 {
                    work.find_shares(self);
                }
                work.correct(self, mesh);
            }
            self.keys.carry(&mut work);
            work.carry_energies(self);
            self.surfaces.listed.clear();
        }
        work.carry_energies_on_analyticals(self, mesh, dofs);
        self.mesh = Some(work);
    }

    /// Returns whether a node near another surface moves.
    fn moves_near(&self, dofs: &Dofs, mesh: &dyn MeshMotion) -> bool {
        near_nodes(self).any(|(node, _)| mesh.place(node).is_some_and(|place| place != dofs.nodes[node].place()))
    }
}
