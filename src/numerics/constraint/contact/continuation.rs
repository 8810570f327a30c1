//! Continuation of contact in a step with other pairs, laws or prescribed motions, and on new meshes of bodies. Results are
//! matched by the number of the pair and by the carriers of the points.

use crate::kernel::lanes::InlineMap;
use std::collections::HashMap;

use super::mesh_continuation::KeyPlace;
use super::surfaces::{ContactSurfaces, PointIdentity};
use super::system::ContactSystem;
use super::{ContactConstraint, ContactPair};
use crate::constraint::{NodeRelation, PreviousPlace};
use crate::state::dofs::Dofs;

impl ContactConstraint {
    /// Takes pressures, slip, impulses, clearances and heat exchange bounds from the previous contact.
    pub(super) fn take_over(&mut self, previous: &ContactConstraint) {
        self.impact = previous.impact;
        self.system.dofs.take_over(&previous.system.dofs);
        let nodes = |node| Some(PreviousPlace::at(node));
        self.system.take_over(&previous.system, &nodes);
        self.take_over_heat(previous, &nodes);
        if let (Some(cohesion), Some(previous_cohesion)) = (&mut self.cohesion, &previous.cohesion) {
            self.system.dofs.pass_values(&mut cohesion.impulses, &previous.system.dofs, &previous_cohesion.impulses);
            cohesion.take_over(&self.system, previous_cohesion, (&previous.system, &nodes));
        }
        for stations in &mut self.stations {
            let same = previous.stations.iter().find(|known| known.pair.number == stations.pair.number);
            same.into_iter().for_each(|known| stations.take_over(known));
        }
    }

    /// Takes the values of the previous contact at the places of the points on the previous surfaces.
    pub(super) fn move_to_new_mesh(&mut self, previous: &ContactConstraint, nodes: &NodeRelation<'_>, dofs: &Dofs) {
        (self.system.dofs.half, self.impact) = (previous.system.dofs.half, previous.impact);
        // Initial clearances are those of the start.
        self.system.keys.gap_offsets.fill(0.0);
        let places = self.system.take_over(&previous.system, nodes);
        self.take_over_heat(previous, nodes);
        if let (Some(cohesion), Some(previous_cohesion)) = (&mut self.cohesion, &previous.cohesion) {
            cohesion.take_over(&self.system, previous_cohesion, (&previous.system, nodes));
            cohesion.squared_frequency = previous_cohesion.squared_frequency;
        }
        self.system.take_over_energies(&previous.system, places, dofs);
    }

    /// Takes the bounds of heat exchange of the points that a previous contact has, too.
    fn take_over_heat(&mut self, previous: &ContactConstraint, nodes: &NodeRelation<'_>) {
        let (Some(exchange), Some(previous_exchange)) = (&mut self.heat, &previous.heat) else { return };
        let [surfaces, previous_surfaces] = [&self.system.surfaces, &previous.system.surfaces];
        let points = (0..previous_surfaces.points.len() as u32).map(|point| previous_surfaces.identity(point));
        let known: HashMap<_, _> = points.zip(&previous_exchange.most).collect();
        for (point, most) in (0..surfaces.points.len() as u32).zip(&mut exchange.most) {
            let ends = previous_ends(surfaces.identity(point), nodes).into_iter().flat_map(|found| found.0);
            *most = ends.filter_map(|end| known.get(&end)).fold(0.0, |most, bound| bound.max(most));
        }
    }
}

impl ContactSystem {
    /// Takes the values of the pairs that continue, and of curves with the same facets. Returns the places of their keys
    /// among the previous ones.
    fn take_over(&mut self, previous: &ContactSystem, nodes: &NodeRelation<'_>) -> Vec<(u32, KeyPlace)> {
        let ends_of = |point: PointIdentity| previous_ends(point, nodes);
        let same =
            |point: PointIdentity| ends_of(point).filter(|(ends, _)| ends[0] == ends[1]).map(|(ends, _)| ends[0]);
        for index in 0..self.surfaces.curves.len().min(previous.surfaces.curves.len()) {
            let facets = self.surfaces.facet_owners(index).map(|facet| facet.inline_map(same));
            if facets.eq(previous.surfaces.facet_owners(index).map(|facet| facet.inline_map(Some))) {
                self.surfaces.curves[index].take_over(&previous.surfaces.curves[index]);
            }
        }
        self.surfaces.list_points();
        let mut places = Vec::new();
        let continued = self.active_pairs_of(previous);
        let indices = continued.iter().map(|continued| continued.0);
        self.surfaces.active.activate(indices, &mut self.pairs, &self.surfaces.curves);
        for (index, previous_index) in continued {
            let (pair, previous_pair) = (&mut self.pairs[index], &previous.pairs[previous_index]);
            let known: HashMap<_, _> = key_owners(&previous.surfaces, previous_pair).collect();
            for ((is_own, point), key) in key_owners(&self.surfaces, pair) {
                let Some((ends, share)) = ends_of(point) else { continue };
                let keys = ends.inline_map(|end| known.get(&(is_own, end)).copied());
                // Single points have forces, which do not vary along the surface.
                let is_mixed = ends[0] == ends[1] || is_own || previous_pair.analytical.is_some();
                places.extend(match keys {
                    [Some(a), Some(b)] if is_mixed => Some((key, KeyPlace { keys: [a, b], share })),
                    [Some(a), None] | [None, Some(a)] if is_mixed => Some((key, KeyPlace { keys: [a; 2], share: 0.0 })),
                    _ => None,
                });
            }
            pair.absorbed = previous_pair.absorbed;
            pair.largest_release = previous_pair.largest_release;
        }
        places.iter().for_each(|(key, place)| self.keys.take_over(*key as usize, &previous.keys, *place));
        places
    }

    /// Takes the stored energies of keys with these places on previous surfaces: energies per area are interpolated, and the
    /// sum of each pair is kept.
    fn take_over_energies(&mut self, previous: &ContactSystem, places: Vec<(u32, KeyPlace)>, dofs: &Dofs) {
        if self.keys.stored_energy.stored.is_empty() {
            return;
        }
        let surfaces = &mut self.surfaces;
        for point in 0..surfaces.points.len() {
            surfaces.places[point] = surfaces.place_of(point as u32, dofs, 0.0);
        }
        surfaces.curves.iter_mut().for_each(|curve| curve.shape(&surfaces.places));
        let (areas, previous_areas) = (self.areas_of_keys(), previous.areas_of_keys());
        let stored = &previous.keys.stored_energy.stored;
        let density = |key: usize| if stored[key] > 0.0 { stored[key] / previous_areas[key] } else { 0.0 };
        let continued = self.active_pairs_of(previous);
        let energies = self.keys.stored_energy.stored_mut();
        for (key, place) in places {
            energies[key as usize] = place.value(density) * areas[key as usize];
        }
        for (index, previous_index) in continued {
            let (pair, previous_pair) = (&self.pairs[index], &previous.pairs[previous_index]);
            let sum = |energies: &[f64]| energies.iter().filter(|energy| !energy.is_nan()).sum::<f64>();
            let energies = &mut energies[pair.keys()];
            let sums = [sum(&stored[previous_pair.keys()]), sum(energies)];
            let part = if sums[1] > 0.0 { sums[0] / sums[1] } else { 0.0 };
            energies.iter_mut().for_each(|energy| *energy *= part);
        }
    }

    /// Returns the indices of the pairs that continue active pairs of a previous contact, and those of the latter.
    fn active_pairs_of(&self, previous: &ContactSystem) -> Vec<(usize, usize)> {
        let active = previous.surfaces.active.list.iter().map(|index| *index as usize);
        // If the previous contact has several pairs of this kind, the first one continues.
        let known: HashMap<_, _> = active.map(|index| (previous.pairs[index].identity(), index)).rev().collect();
        let continued = |(index, pair): (usize, &ContactPair)| Some((index, *known.get(&pair.identity())?));
        self.pairs.iter().enumerate().filter_map(continued).collect()
    }

    /// Returns the areas of the hat functions of all keys; 1 for single points.
    fn areas_of_keys(&self) -> Vec<f64> {
        let mut areas = vec![1.0; self.keys.count()];
        for pair in &self.pairs {
            let secondary = &self.surfaces.curves[pair.secondary];
            let keys = areas[pair.first_key as usize..].iter_mut();
            keys.zip(0..secondary.points.len())
                .for_each(|(area, index)| *area = secondary.area(index, &self.surfaces.places));
        }
        areas
    }
}

/// Returns the points of a previous contact between which a point is, and its distance from the first as a fraction of that
/// between both; `None` if it is new.
pub(super) fn previous_ends(
    (carrier, on_body): PointIdentity,
    nodes: &NodeRelation<'_>,
) -> Option<([PointIdentity; 2], f64)> {
    match on_body {
        Some(_) => Some(([(carrier, on_body); 2], 0.0)),
        None => nodes(carrier).map(|place| (place.nodes.inline_map(|node| (node, None)), place.share)),
    }
}

/// Returns the keys of a pair with the points that own them: the own curve first (`true`), then the other curve, or the own
/// curve again.
fn key_owners<'s>(
    surfaces: &'s ContactSurfaces,
    pair: &ContactPair,
) -> impl Iterator<Item = ((bool, PointIdentity), u32)> + use<'s> {
    let (secondary, other) = surfaces.sides(pair);
    let points = secondary.points.iter().map(|point| (true, point)).chain(other.points.iter().map(|p| (false, p)));
    let keys = pair.first_key..pair.end_key;
    points.map(|(is_own, point)| (is_own, surfaces.identity(*point))).zip(keys)
}
