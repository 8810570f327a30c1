//! Continuation of contact in a step with other pairs, laws or prescribed motions, and on new meshes of bodies. Results are
//! matched by the number of the pair and by the carriers of the points.

use crate::kernel::lanes::InlineMap;
use std::collections::HashMap;

use super::curve::{PointCarrier, SurfacePoint};
use super::mesh_continuation::KeyPlace;
use super::{ContactConstraint, ContactPair};
use crate::constraint::{NodeRelation, PreviousPlace};
use crate::state::dofs::Dofs;

/// Identifies the carrier of a point.
pub(super) type PointIdentity = (usize, Option<[u64; 2]>);

/// Returns the identity of the carrier of a point.
pub(super) fn identity(point: &SurfacePoint) -> PointIdentity {
    match point.carrier {
        PointCarrier::Node(node) => (node, None),
        PointCarrier::Body(body, place) => (body, Some(place.inline_map(f64::to_bits))),
    }
}

impl ContactConstraint {
    /// Takes pressures, slip, impulses, clearances and heat exchange bounds from the previous contact.
    pub(super) fn take_over(&mut self, previous: &ContactConstraint) {
        (self.half, self.output_share, self.impact) = (previous.half, previous.output_share, previous.impact);
        self.bodies.clone_from(&previous.bodies);
        let known: HashMap<_, _> = previous.dofs.iter().map(|d| d.0).zip(&previous.impulses).collect();
        for ((dof, _), impulse) in self.dofs.iter().zip(&mut self.impulses) {
            *impulse = known.get(dof).map_or([0.0; 2], |found| **found);
        }
        self.take_over_pairs(previous, &|node| Some(PreviousPlace::at(node)));
        self.take_over_cohesion(previous);
    }

    /// Takes the values of the previous contact at the places of the points on the previous surfaces. Stored energies per
    /// area are interpolated, and the sum of each pair is kept.
    pub(super) fn move_to_new_mesh(&mut self, previous: &ContactConstraint, nodes: &NodeRelation<'_>, dofs: &Dofs) {
        (self.half, self.impact) = (previous.half, previous.impact);
        let places = self.take_over_pairs(previous, nodes);
        if self.stored_energy.values_mut().is_empty() {
            return;
        }
        let all: Vec<u32> = (0..self.points.len() as u32).collect();
        all.iter().for_each(|point| self.places[*point as usize] = self.place_of(*point, dofs, 0.0));
        self.curves.iter_mut().for_each(|curve| curve.shape(&self.places));
        let (areas, before) = (self.areas_of_keys(), previous.areas_of_keys());
        let stored = previous.stored_energy.values();
        let density = |key: usize| if stored[key] > 0.0 { stored[key] / before[key] } else { 0.0 };
        for (key, place) in places {
            self.stored_energy.values_mut()[key] = place.value(density) * areas[key];
        }
        for at in 0..self.pairs.len() {
            let (own, keys) = (&self.pairs[at], self.keys_in(&self.pairs[at]));
            let Some(pair) = previous.pairs.iter().find(|pair| own.continues(pair)) else { continue };
            let sum = |energies: &[f64]| energies.iter().filter(|energy| !energy.is_nan()).sum::<f64>();
            let own = &mut self.stored_energy.values_mut()[keys];
            let (kept, spread) = (sum(&stored[previous.keys_in(pair)]), sum(own));
            let part = if spread > 0.0 { kept / spread } else { 0.0 };
            own.iter_mut().for_each(|energy| *energy *= part);
        }
    }

    /// Takes the values of the pairs that continue, and of curves with the same facets. Returns the places of their keys
    /// among the previous ones.
    fn take_over_pairs(&mut self, previous: &ContactConstraint, nodes: &NodeRelation<'_>) -> Vec<(usize, KeyPlace)> {
        let place = |(carrier, on_body): PointIdentity| match on_body {
            Some(_) => Some(([(carrier, on_body); 2], 0.0)),
            None => nodes(carrier).map(|place| (place.nodes.inline_map(|node| (node, None)), place.share)),
        };
        let same = |point: PointIdentity| place(point).filter(|found| found.0[0] == found.0[1]).map(|found| found.0[0]);
        for at in 0..self.curves.len().min(previous.curves.len()) {
            let own = self.facet_owners(at).map(|facet| facet.inline_map(same));
            if own.eq(previous.facet_owners(at).map(|facet| facet.inline_map(Some))) {
                self.curves[at].take_over(&previous.curves[at]);
            }
        }
        self.list_points();
        let mut places = Vec::new();
        for at in 0..self.pairs.len() {
            let own = &self.pairs[at];
            let Some(pair) = previous.pairs.iter().find(|pair| own.continues(pair)) else { continue };
            let known: HashMap<_, _> = previous.key_owners(pair).into_iter().collect();
            for ((is_own, point), key) in self.key_owners(own) {
                let Some((ends, share)) = place(point) else { continue };
                let keys = ends.inline_map(|end| known.get(&(is_own, end)).copied());
                // Single points have forces, which do not vary along the surface.
                let is_mixed = ends[0] == ends[1] || is_own || pair.analytical.is_some();
                places.extend(match keys {
                    [Some(a), Some(b)] if is_mixed => Some((key, KeyPlace { keys: [a, b], share })),
                    [Some(a), None] | [None, Some(a)] if is_mixed => Some((key, KeyPlace { keys: [a; 2], share: 0.0 })),
                    _ => None,
                });
            }
            self.pairs[at].absorbed = pair.absorbed;
            self.pairs[at].largest_release = pair.largest_release;
        }
        places.iter().for_each(|(key, place)| self.take_over_key(*key, previous, *place));
        if let (Some(exchange), Some(before)) = (&mut self.contact_heat, &previous.contact_heat) {
            let known: HashMap<_, _> = previous.points.iter().map(identity).zip(before.exchange_bounds()).collect();
            for (point, most) in self.points.iter().zip(exchange.exchange_bounds_mut()) {
                let ends = place(identity(point)).into_iter().flat_map(|found| found.0);
                *most = ends.filter_map(|end| known.get(&end)).fold(0.0, |most, bound| bound.max(most));
            }
        }
        places
    }

    fn take_over_key(&mut self, key: usize, previous: &ContactConstraint, place: KeyPlace) {
        self.pressures[key] = [0, 1].inline_map(|part: usize| place.value(|other| previous.pressures[other][part]));
        self.stored_energy.take_over(key, &previous.stored_energy, place);
        self.slip_damping.take_over(key, &previous.slip_damping, place);
        self.shown.take_over(key, &previous.shown, place);
        let fit = place.value(|other| previous.gap_offsets.get(other).copied().unwrap_or(0.0));
        if fit != 0.0 && self.gap_offsets.is_empty() {
            self.gap_offsets = vec![0.0; self.pressures.len()];
        }
        if let Some(own) = self.gap_offsets.get_mut(key) {
            *own = fit;
        }
    }

    /// Returns the carriers of the points of each facet of a curve.
    pub(super) fn facet_owners(&self, curve: usize) -> impl Iterator<Item = [PointIdentity; 2]> {
        self.curves[curve].facets.iter().map(|facet| facet.inline_map(|point| identity(&self.points[point as usize])))
    }

    fn keys_in(&self, pair: &ContactPair) -> std::ops::Range<usize> {
        pair.first_key as usize..(pair.first_key + self.keys_of(pair)) as usize
    }

    /// Returns the areas of the hat functions of all keys; 1 for single points.
    fn areas_of_keys(&self) -> Vec<f64> {
        let mut areas = vec![1.0; self.pressures.len()];
        for pair in &self.pairs {
            let own = &self.curves[pair.own];
            let keys = areas[pair.first_key as usize..].iter_mut();
            keys.zip(0..own.own.len()).for_each(|(area, index)| *area = own.area(index, &self.places));
        }
        areas
    }

    /// Returns the keys of a pair with the points that own them: the own curve first, then the other curve, or the own
    /// curve again.
    fn key_owners(&self, pair: &ContactPair) -> Vec<((bool, PointIdentity), usize)> {
        let own = &self.curves[pair.own].own;
        let others = pair.other.map_or(own, |other| &self.curves[other].own);
        let keys = self.keys_in(pair);
        let points = own.iter().map(|p| (true, p)).chain(others.iter().map(|p| (false, p)));
        let owner = |(is_own, point): (bool, &u32)| (is_own, identity(&self.points[*point as usize]));
        points.map(owner).zip(keys).collect()
    }
}
