//! Continuation of contact in a step with other pairs, laws or prescribed motions. Results are matched by the number of
//! the pair and by the carriers of the points.

use crate::kernel::lanes::InlineMap;
use std::collections::HashMap;

use super::curve::{PointCarrier, SurfacePoint};
use super::{ContactConstraint, ContactPair};

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
        (self.half, self.output_share) = (previous.half, previous.output_share);
        self.bodies.clone_from(&previous.bodies);
        let known: HashMap<_, _> = previous.dofs.iter().map(|d| d.0).zip(&previous.impulses).collect();
        for ((dof, _), impulse) in self.dofs.iter().zip(&mut self.impulses) {
            *impulse = known.get(dof).map_or([0.0; 2], |found| **found);
        }
        for at in 0..self.curves.len().min(previous.curves.len()) {
            if self.facet_owners(at).eq(previous.facet_owners(at)) {
                self.curves[at].take_over(&previous.curves[at]);
            }
        }
        self.list_points();
        for at in 0..self.pairs.len() {
            let (number, first) = (self.pairs[at].number, self.pairs[at].first);
            if let Some(pair) = previous.pairs.iter().find(|p| (p.number, p.first) == (number, first)) {
                self.pairs[at].absorbed = pair.absorbed;
                self.pairs[at].largest_release = pair.largest_release;
                let known: HashMap<_, _> = previous.key_owners(pair).into_iter().collect();
                for (owner, key) in self.key_owners(&self.pairs[at]) {
                    known.get(&owner).into_iter().for_each(|&other| self.take_over_key(key, previous, other));
                }
            }
        }
        if let (Some(exchange), Some(before)) = (&mut self.contact_heat, &previous.contact_heat) {
            let known: HashMap<_, _> = previous.points.iter().map(identity).zip(before.exchange_bounds()).collect();
            for (point, most) in self.points.iter().zip(exchange.exchange_bounds_mut()) {
                *most = known.get(&identity(point)).map_or(0.0, |found| **found);
            }
        }
        self.take_over_cohesion(previous);
    }

    fn take_over_key(&mut self, key: usize, previous: &ContactConstraint, other: usize) {
        self.pressures[key] = previous.pressures[other];
        self.stored_energy.take_over(key, &previous.stored_energy, other);
        self.slip_damping.take_over(key, &previous.slip_damping, other);
        self.shown.take_over(key, &previous.shown, other);
        let fit = previous.gap_offsets.get(other).copied().unwrap_or(0.0);
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

    /// Returns the keys of a pair with the points that own them: the own curve first, then the other curve, or the own
    /// curve again.
    fn key_owners(&self, pair: &ContactPair) -> Vec<((bool, PointIdentity), usize)> {
        let own = &self.curves[pair.own].own;
        let others = pair.other.map_or(own, |other| &self.curves[other].own);
        let keys = pair.first_key as usize..(pair.first_key + self.keys_of(pair)) as usize;
        let points = own.iter().map(|p| (true, p)).chain(others.iter().map(|p| (false, p)));
        let owner = |(is_own, point): (bool, &u32)| (is_own, identity(&self.points[*point as usize]));
        points.map(owner).zip(keys).collect()
    }
}
