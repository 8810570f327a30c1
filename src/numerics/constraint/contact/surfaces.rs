//! The surfaces of a contact: points, curves and analytical surfaces, their places, and the parts that are near another
//! surface.

use super::active_pairs::ActivePairs;
use super::analytical::AnalyticalSurface;
use super::curve::{FacetCurve, PointCarrier, SurfacePoint};
use super::near::NearParts;
use super::pairs::ContactPair;
use super::search::ContactSearch;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::kernel::topology::ElementNodes;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;

/// Surfaces in contact and their current places.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(fixed: curves; derived: points, active, curves_of_points, numbers, slacks, slack, points_of_nodes, points_on_bodies, analyticals, places, active_points, near, listed, selected, close_slack, on_new_faces, alike)]
#[memory(flat: analyticals)]
pub(super) struct ContactSurfaces {
    pub(super) points: Vec<SurfacePoint>,
    pub(super) curves: Vec<FacetCurve>,
    pub(super) analyticals: Vec<AnalyticalSurface>,
    pub(super) active: ActivePairs,
    /// Points and their curves, ascending.
    curves_of_points: Vec<[u32; 2]>,
    /// Number among the pairs of all steps and index of each pair, ascending.
    numbers: Vec<[u32; 2]>,
    /// Displacements of a point after which candidates are searched again: generally, if no surfaces are within reach, and
    /// since the last search.
    slacks: [f64; 2],
    slack: f64,
    /// Nodes and their points, ascending by node.
    points_of_nodes: Vec<(usize, u32)>,
    /// Bodies, bits of the places and points on bodies, ascending.
    points_on_bodies: Vec<([u64; 3], u32)>,
    pub(super) places: Vec<[f64; 2]>,
    /// Points that may be in contact: those of exposed facets and those without elements.
    pub(super) active_points: Vec<u32>,
    pub(super) near: NearParts,
    /// Positions of the points when candidate lists were built; empty if there are none.
    pub(super) listed: Vec<[f64; 2]>,
    /// Positions of the points when close candidates were selected; empty if there are none.
    selected: Vec<[f64; 2]>,
    /// Displacement of a point after which close candidates are selected again.
    close_slack: f64,
    /// Whether each point belongs to a facet that element deletion has exposed; empty if there are none.
    on_new_faces: Vec<bool>,
    /// For each point the first one with the same motion; empty if no points move alike.
    pub(super) alike: Vec<u32>,
    /// Whether elements have been deleted since the previous increment.
    pub(super) uncovered: bool,
}

/// Identifies the carrier of a point.
pub(super) type PointIdentity = (usize, Option<[u64; 2]>);

impl ContactSurfaces {
    pub(super) fn new(
        points: Vec<SurfacePoint>,
        curves: Vec<FacetCurve>,
        analyticals: Vec<AnalyticalSurface>,
    ) -> ContactSurfaces {
        let mut surfaces = ContactSurfaces {
            places: vec![[0.0; 2]; points.len()],
            listed: Vec::with_capacity(points.len()),
            selected: Vec::with_capacity(points.len()),
            active_points: Vec::with_capacity(2 * points.len() + analyticals.len()),
            on_new_faces: Vec::with_capacity(points.len()),
            points,
            curves,
            analyticals,
            ..ContactSurfaces::default()
        };
        for (point, number) in surfaces.points.iter().zip(0..) {
            match point.carrier {
                PointCarrier::Node(node) => surfaces.points_of_nodes.push((node, number)),
                PointCarrier::Body(body, place) => surfaces.points_on_bodies.push((bits_of(body, place), number)),
            }
        }
        surfaces.points_of_nodes.sort_unstable();
        surfaces.points_on_bodies.sort_unstable();
        for (curve, number) in surfaces.curves.iter().zip(0..) {
            surfaces.curves_of_points.extend(curve.points.iter().map(|&point| [point, number]));
        }
        surfaces.curves_of_points.sort_unstable();
        surfaces.list_points();
        surfaces
    }

    /// Returns the own curve of a pair and the other one, which is the same in self-contact.
    pub(super) fn sides(&self, pair: &ContactPair) -> (&FacetCurve, &FacetCurve) {
        let secondary = &self.curves[pair.secondary];
        (secondary, pair.other.map_or(secondary, |other| &self.curves[other]))
    }

    /// Returns the number of keys of a pair. Each own point has one, and a second one if it may be in a re-entrant corner of
    /// an analytical surface. Points of a second curve have one if they may be in contact alone.
    pub(super) fn keys_of(&self, pair: &ContactPair) -> u32 {
        let own_points = self.curves[pair.secondary].points.len() as u32;
        let others = pair.other.map(|other| &self.curves[other]).filter(|curve| curve.has_single_points());
        let single_points = others.map_or(0, |curve| curve.points.len() as u32);
        own_points + single_points + if self.has_two_keys(pair) { own_points } else { 0 }
    }

    /// Returns whether each own point of a pair has two keys: in a re-entrant corner of an analytical surface it is in
    /// contact with two segments.
    pub(super) fn has_two_keys(&self, pair: &ContactPair) -> bool {
        pair.analytical.is_some_and(|surface| self.analyticals[surface].has_corners())
    }

    /// Returns the identity of the carrier of a point.
    pub(super) fn identity(&self, point: u32) -> PointIdentity {
        match self.points[point as usize].carrier {
            PointCarrier::Node(node) => (node, None),
            PointCarrier::Body(body, place) => (body, Some(place.inline_map(f64::to_bits))),
        }
    }

    /// Returns the carriers of the points of each facet of a curve.
    pub(super) fn facet_owners(&self, curve: usize) -> impl Iterator<Item = [PointIdentity; 2]> {
        self.curves[curve].facets.iter().map(|facet| facet.inline_map(|point| self.identity(point)))
    }

    /// Returns the point of a carrier; `None` if it belongs to no contact surface.
    pub(super) fn point_on(&self, carrier: PointCarrier) -> Option<u32> {
        let (of_nodes, on_bodies) = (&self.points_of_nodes, &self.points_on_bodies);
        match carrier {
            PointCarrier::Node(node) => {
                of_nodes.binary_search_by_key(&node, |known| known.0).ok().map(|i| of_nodes[i].1)
            }
            PointCarrier::Body(body, place) => {
                let bits = bits_of(body, place);
                let from = on_bodies.partition_point(|known| known.0 < bits);
                on_bodies.get(from).filter(|known| known.0 == bits).map(|known| known.1)
            }
        }
    }

    /// Iterates over the pairs in which a point carries pressures, ascending: the active ones, and the first pair of each
    /// of its curves.
    pub(super) fn own_pairs(&self, point: u32) -> impl Iterator<Item = usize> {
        let from = self.curves_of_points.partition_point(|known| known[0] < point);
        let curves = self.curves_of_points[from..].iter().take_while(move |known| known[0] == point);
        self.active.pairs_of_curves(curves.map(|known| known[1]))
    }

    /// Returns the points of an element's nodes; `None` if one has no contact.
    fn points_of_element(&self, boundary: &ElementNodes) -> Option<ElementNodes> {
        let mut points = *boundary;
        for point in points.iter_mut() {
            *point = self.point_on(PointCarrier::Node(*point as usize))?;
        }
        Some(points)
    }

    /// Removes the facets of deleted elements, given by their corner nodes, and exposes those of their neighbours.
    pub(super) fn remove_elements(&mut self, deleted: &[ElementNodes]) {
        let mut curves = std::mem::take(&mut self.curves);
        for curve in &mut curves {
            if curve.remove_elements(deleted.iter().filter_map(|boundary| self.points_of_element(boundary))) {
                curve.list();
                self.uncovered = true;
            }
        }
        self.curves = curves;
    }

    /// Returns the rigid body of a curve; `None` for a curve of a deformable body.
    pub(super) fn body_of_curve(&self, curve: usize) -> Option<usize> {
        self.curves[curve].points.iter().find_map(|&point| self.body_of_point(point))
    }

    pub(super) fn body_of_point(&self, point: u32) -> Option<usize> {
        match self.points[point as usize].carrier {
            PointCarrier::Body(body, _) => Some(body),
            PointCarrier::Node(_) => None,
        }
    }

    /// Numbers the keys of the pairs and lists the active ones. Returns the number of keys.
    pub(super) fn list_pairs(&mut self, pairs: &mut [ContactPair]) -> u32 {
        let mut keys = 0;
        for pair in pairs.iter_mut() {
            pair.first_key = keys;
            keys += self.keys_of(pair);
            pair.end_key = keys;
            let secondary = &self.curves[pair.secondary];
            if let Some(surface) = pair.analytical {
                self.analyticals[surface].lift = (0..secondary.points.len()).map(|i| secondary.lift_of(i)).collect();
            } else {
                pair.search.lift = secondary.highest() + self.sides(pair).1.highest();
            }
        }
        let searched = || pairs.iter().filter(|pair| pair.analytical.is_none()).map(|pair| &pair.search);
        let least = |slacks: &mut dyn Iterator<Item = f64>| slacks.fold(f64::INFINITY, f64::min);
        self.slacks =
            [least(&mut searched().map(ContactSearch::slack)), least(&mut searched().map(ContactSearch::quiet_slack))];
        self.close_slack = least(&mut searched().map(ContactSearch::close_slack));
        self.active = ActivePairs::new(pairs, &self.curves);
        self.numbers = (0..).zip(pairs.iter()).map(|(index, pair)| [pair.number as u32, index]).collect();
        self.numbers.sort_unstable();
        keys
    }

    /// Returns the number of pairs.
    pub(super) fn pair_count(&self) -> usize {
        self.numbers.len()
    }

    /// Returns the index of the first pair with a number among the pairs of all steps.
    pub(super) fn first_of_number(&self, number: usize) -> Option<usize> {
        let from = self.numbers.partition_point(|known| (known[0] as usize) < number);
        self.numbers.get(from).filter(|known| known[0] as usize == number).map(|known| known[1] as usize)
    }

    /// Allocates the lists of near parts; `dofs` is the number of degrees of freedom.
    pub(super) fn reserve_near(&mut self, dofs: usize) {
        let facets = self.curves.iter().map(|curve| curve.facets.len()).sum();
        self.near.reserve(facets, self.points.len(), dofs);
    }

    /// Returns the position of a point at the start of the increment.
    #[inline]
    pub(super) fn place_of(&self, point: u32, dofs: &Dofs, dt: f64) -> [f64; 2] {
        match self.points[point as usize].carrier {
            PointCarrier::Node(n) => {
                let node = &dofs.nodes[n];
                [node.r - dt * node.v_r, node.z - dt * node.v_z]
            }
            PointCarrier::Body(b, [r, z]) => [r, z + dofs.bodies[b].before.displacement],
        }
    }

    /// Lists the points of exposed facets and those without elements. Candidates must then be searched again.
    pub(super) fn list_points(&mut self) {
        self.active_points.clear();
        self.active_points.extend(self.analyticals.iter().map(|surface| surface.point));
        for curve in &self.curves {
            let points = curve.exposed_points.iter().chain(&curve.orphans).map(|&i| curve.points[i as usize]);
            self.active_points.extend(points);
        }
        self.active_points.sort_unstable();
        self.active_points.dedup();
        self.listed.clear();
        self.mark_new_faces();
    }

    /// Marks the points of facets that element deletion has exposed.
    fn mark_new_faces(&mut self) {
        self.on_new_faces.clear();
        for point in self.curves.iter().flat_map(|curve| curve.newly_exposed().flatten()) {
            if self.on_new_faces.is_empty() {
                self.on_new_faces.resize(self.points.len(), false);
            }
            self.on_new_faces[*point as usize] = true;
        }
    }

    /// Returns whether a point belongs to a facet that element deletion has exposed.
    #[inline]
    pub(super) fn is_on_new_face(&self, point: u32) -> bool {
        self.on_new_faces.get(point as usize).copied().unwrap_or(false)
    }

    /// Finds the neighbours of exposed facets at the current places.
    pub(super) fn find_neighbors(&mut self) {
        self.curves.iter_mut().for_each(|curve| curve.find_neighbors(&self.places));
    }

    /// Returns whether a point has moved too far since candidates were searched.
    pub(super) fn has_moved_far(&self, dofs: &Dofs, dt: f64) -> bool {
        let slack = self.slack;
        let is_far = |place: [f64; 2], point: u32| is_farther(place, self.listed[point as usize], slack);
        self.near.points.iter().any(|&point| is_far(self.places[point as usize], point))
            || self.near.others.iter().any(|&point| is_far(self.place_of(point, dofs, dt), point))
    }

    /// Searches candidates of all pairs from the shapes of all exposed facets. `dofs_of` are the degrees of freedom of each
    /// point.
    pub(super) fn search(&mut self, pairs: &mut [ContactPair], dofs_of: &[[u32; 2]]) {
        let ContactSurfaces { curves, active, places, listed, selected, alike, .. } = self;
        selected.clear();
        curves.iter_mut().for_each(|curve| curve.shape(places));
        listed.clear();
        listed.extend_from_slice(places);
        active.update(pairs, curves, places);
        for &index in &active.list {
            let pair = &mut pairs[index as usize];
            if active.are_apart(pair) {
                pair.search.clear();
            } else if pair.analytical.is_none() {
                pair.search.build(&curves[pair.secondary], pair.other.map(|other| &curves[other]), (places, alike));
            }
        }
        self.slack = self.slacks[0];
        if self.is_quiet(pairs) {
            self.slack = self.slacks[1];
            for &index in &self.active.list {
                let pair = &mut pairs[index as usize];
                if !pair.is_cohesive {
                    pair.search.clear();
                }
            }
        }
        let ActivePairs { list, near, .. } = &mut self.active;
        near.clear();
        near.extend(list.iter().copied().filter(|index| pairs[*index as usize].end_search()));
        self.list_near(pairs, dofs_of);
    }

    /// Selects the close candidates of all near pairs again if a near point has moved too far since the last selection.
    pub(super) fn select_close(&mut self, pairs: &mut [ContactPair]) {
        let ContactSurfaces { curves, active, places, near, selected, close_slack, .. } = self;
        let is_far = |point: &u32| is_farther(places[*point as usize], selected[*point as usize], *close_slack);
        if !selected.is_empty() && !near.points.iter().any(is_far) {
            return;
        }
        selected.clear();
        selected.extend_from_slice(places);
        active.near.iter().for_each(|index| pairs[*index as usize].select_close(curves, *close_slack));
    }

    /// Returns whether no surfaces of pairs without bonds are within reach before the next search, in which case they need
    /// not be measured.
    fn is_quiet(&self, pairs: &[ContactPair]) -> bool {
        let ContactSurfaces { curves, active, places, slacks, .. } = self;
        active.list.iter().map(|index| &pairs[*index as usize]).all(|pair| {
            let other = pair.other.map(|other| &curves[other]);
            pair.analytical.is_some()
                || pair.is_cohesive
                || active.are_apart(pair)
                || pair.search.is_out_of_reach(&curves[pair.secondary], other, places, slacks[1])
        })
    }

    /// Lists what is near another surface, or belongs to a pair whose bonds act at any distance.
    fn list_near(&mut self, pairs: &[ContactPair], dofs_of: &[[u32; 2]]) {
        let ContactSurfaces { curves, analyticals, active, active_points, near, .. } = self;
        near.begin();
        for pair in active.list.iter().map(|index| &pairs[*index as usize]) {
            let (secondary, other) = (&curves[pair.secondary], pair.other.map(|other| &curves[other]));
            if let Some(surface) = pair.analytical {
                near.mark_point(analyticals[surface].point);
            }
            if pair.analytical.is_some() || pair.is_cohesive {
                [Some(secondary), other].into_iter().flatten().for_each(|curve| near.mark_curve(curve));
            } else {
                near.mark_candidates(secondary, other, &pair.search);
            }
        }
        near.list(curves, active_points, dofs_of);
    }

    /// Updates the shapes of near facets.
    pub(super) fn shape_near(&mut self) {
        for &[curve, k] in &self.near.facets {
            self.curves[curve as usize].shape_one(k, &self.places);
        }
    }

    /// Reads the places of all points that `new` gives for nodes, and the present places of all other points.
    pub(super) fn read_places(&mut self, new: impl Fn(usize) -> Option<[f64; 2]>, dofs: &Dofs) {
        for &point in &self.active_points {
            let moved = match self.points[point as usize].carrier {
                PointCarrier::Node(node) => new(node),
                PointCarrier::Body(..) => None,
            };
            self.places[point as usize] = moved.unwrap_or_else(|| self.place_of(point, dofs, 0.0));
        }
    }
}

/// Returns whether a place is farther from another one than a distance.
#[inline]
fn is_farther(place: [f64; 2], from: [f64; 2], distance: f64) -> bool {
    let d = [place[0] - from[0], place[1] - from[1]];
    d[0] * d[0] + d[1] * d[1] > distance * distance
}

/// Returns a body and the bits of a place on it, for comparisons; -0 and 0 are the same.
fn bits_of(body: usize, [r, z]: [f64; 2]) -> [u64; 3] {
    [body as u64, (r + 0.0).to_bits(), (z + 0.0).to_bits()]
}
