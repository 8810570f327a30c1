//! Contact curves: facets, their points and carriers, their order and current shape, and facets that element deletion
//! removes or exposes.

use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::kernel::lists::sorted_unique;
use crate::kernel::shape::distance;
use crate::kernel::sorted_boxes::{BoundingBox, NO_BOX, bounding_box, box_around};
use crate::kernel::topology::ElementNodes;
use crate::state::archive::{Persist, StateArchive};

/// Carrier of a point of a contact surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointCarrier {
    /// A node of a deformable body.
    Node(usize),
    /// A rigid body, with the initial coordinates of the point.
    Body(usize, [f64; 2]),
}

/// A point of a contact surface, with its carrier and the directions in which it is free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    pub carrier: PointCarrier,
    /// Whether the motion of the point along r and z is free, that is, not prescribed.
    pub free: [bool; 2],
}

/// Reason why a point is in contact by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PointKind {
    /// It has no elements, or no elements any more.
    Free,
    /// It is on the axis, at the sharp end of the curve.
    Tip,
    /// It is a convex corner of the outline.
    Corner,
}

/// Neighbour of a facet at one of its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FacetNeighbor {
    /// Another facet of the curve.
    Facet(u32),
    /// The axis of symmetry: the surface continues as its mirror image.
    Axis,
    /// The surface ends.
    Nothing,
}

/// Connected facets; the body is to the left of each.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(
    fixed: is_exposed, has_element, neighbors, depth;
    derived: facets, lift, exposed_at_start, is_side_of_line, points, around, exposed, exposed_points, orphans, drops_orphans, tips,
        corners, kinks, shapes, ordered;
    then: FacetCurve::list_again
)]
pub struct FacetCurve {
    /// The two points of each facet, as indices of contact points.
    pub facets: Vec<[u32; 2]>,
    /// Neighbours at the first and at the second point of each facet.
    pub neighbors: Vec<[FacetNeighbor; 2]>,
    /// Distance of the contact surface from each facet: half the thickness of shells.
    pub lift: Vec<f64>,
    /// Largest overlap at which a point is in contact with the facet, at its first point, middle and second point: half
    /// the thickness of the body there.
    pub depth: Vec<[f64; 3]>,
    /// Whether the curve is one side of a line without thickness whose other side is in contact, too.
    pub is_side_of_line: bool,
    /// Whether each facet is exposed. If elements can be deleted, faces between two elements are facets from the start,
    /// one for each side. They become exposed when the element in front of them is deleted.
    pub is_exposed: Vec<bool>,
    /// Number of facets that are exposed at the start; the following ones are between two elements.
    exposed_at_start: usize,
    /// Whether the element of each facet exists.
    has_element: Vec<bool>,
    /// Points of the facets, each once.
    pub points: Vec<u32>,
    /// Facets around each point, and which end of the facet the point is.
    around: Vec<Vec<(u32, u8)>>,
    /// Exposed facets, in the order in which they are connected.
    pub exposed: Vec<u32>,
    /// Indices in `points` of the points of exposed facets, in the same order.
    pub exposed_points: Vec<u32>,
    /// Indices in `points` of points that have no element, or no element any more; empty if they have no contact.
    pub orphans: Vec<u32>,
    /// Whether points without elements are excluded from contact.
    pub drops_orphans: bool,
    /// Indices in `points` of tips: points on the axis at which the curve ends in a sharp angle.
    tips: Vec<u32>,
    /// Indices in `points` of convex corners: points at which the outline of the body turns sharply.
    corners: Vec<u32>,
    /// Indices in `points` of kinks: points at which the outline turns outwards by much more than at the points next to
    /// them, but less than at a corner.
    pub kinks: Vec<u32>,
    /// Shape of each exposed facet at the start of the increment; that of facets far from other surfaces at the last
    /// search.
    pub shapes: Vec<FacetShape>,
    /// Work array: items that have been sorted.
    ordered: Vec<bool>,
}

/// Returns the displacement between two places along the way to `end`, as a fraction of the way.
fn share_of_way([from, to]: [[f64; 2]; 2], end: [f64; 2]) -> f64 {
    let [by, way] = [to, end].inline_map(|to: [f64; 2]| [to[0] - from[0], to[1] - from[1]]);
    (by[0] * way[0] + by[1] * way[1]) / (way[0] * way[0] + way[1] * way[1])
}

/// Geometry of a facet at an instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct FacetShape {
    pub from: [f64; 2],
    /// Vector from the first point to the second.
    pub along: [f64; 2],
    pub normal: [f64; 2],
    pub length: f64,
}

impl FacetShape {
    #[inline]
    pub fn new(from: [f64; 2], to: [f64; 2]) -> FacetShape {
        let along = [to[0] - from[0], to[1] - from[1]];
        let length = (along[0] * along[0] + along[1] * along[1]).sqrt();
        FacetShape { from, along, normal: [along[1] / length, -along[0] / length], length }
    }

    /// Returns whether a point is on the outer side.
    #[inline]
    pub fn in_front(&self, place: [f64; 2]) -> bool {
        (place[0] - self.from[0]) * self.normal[0] + (place[1] - self.from[1]) * self.normal[1] > 0.0
    }

    /// Returns whether a point does not penetrate the facet by more than `depth` while its distances from both ends change
    /// by at most `motion`, or projects beyond an end.
    pub fn stays_in_front_or_beside(&self, place: [f64; 2], depth: f64, motion: f64) -> bool {
        let (sine, unit) = (motion / self.length, self.along.inline_map(|part| part / self.length));
        if sine >= 1.0 {
            return false;
        }
        let cosine = (1.0 - sine * sine).sqrt();
        let way = [place[0] - self.from[0], place[1] - self.from[1]];
        let (along, height) = (way[0] * unit[0] + way[1] * unit[1], way[0] * self.normal[0] + way[1] * self.normal[1]);
        // The nearer end is the origin; the facet extends to negative values.
        let beyond = if along > 0.5 * self.length { along - self.length } else { -along };
        let is_beside = beyond * cosine - height.abs() * sine > motion;
        is_beside || height.min(height * cosine) - beyond.abs() * sine - motion > -depth
    }

    /// Returns the lower and the upper corner of the bounding box.
    #[inline]
    pub fn bounds(&self) -> BoundingBox {
        bounding_box([self.from, [self.from[0] + self.along[0], self.from[1] + self.along[1]]])
    }
}

/// Change of direction between a facet and the next one.
struct FacetTurn {
    next: u32,
    /// Sine of the angle, positive at a convex point.
    sine: f64,
    /// Whether the direction changes by more than a right angle.
    turns_back: bool,
}

/// Sine of the angle to the plane normal to the axis above which a point on the axis is a tip. A convex point with a
/// larger sine of the change of direction is a corner.
const SHARP: f64 = 0.29;
/// Ratio of the change of direction at a kink to those at the points next to it. On a mesh of a curved surface,
/// neighbouring changes of direction are about equal.
const KINK: f64 = 4.0;
/// Smallest sine of the change of direction at a kink.
const LEAST_KINK: f64 = 1e-6;

impl FacetCurve {
    /// Returns the largest overlap at the coordinate `part` of a facet, from 0 to 1.
    #[inline]
    pub fn depth_at(&self, facet: usize, part: f64) -> f64 {
        let [first, middle, second] = self.depth[facet];
        let (end, share) = if part < 0.5 { (first, 1.0 - 2.0 * part) } else { (second, 2.0 * part - 1.0) };
        middle + share * (end - middle)
    }

    /// Creates a curve of facets between points with the coordinates `places`; a point with r = 0 is on the axis. The
    /// facets from index `bare` on are not exposed at the start.
    pub fn new(facets: Vec<[u32; 2]>, depth: Vec<[f64; 3]>, bare: usize, places: &[[f64; 2]]) -> FacetCurve {
        let points: Vec<u32> = sorted_unique(facets.iter().flatten().copied());
        let mut around = vec![Vec::new(); points.len()];
        for (k, facet) in facets.iter().enumerate() {
            for (end, point) in facet.iter().enumerate() {
                if let Ok(at) = points.binary_search(point) {
                    around[at].push((k as u32, end as u8));
                }
            }
        }
        let count = facets.len();
        let mut curve = FacetCurve {
            neighbors: vec![[FacetNeighbor::Nothing; 2]; count],
            lift: vec![0.0; count],
            depth,
            is_side_of_line: false,
            is_exposed: (0..count).map(|k| k < bare).collect(),
            exposed_at_start: bare,
            has_element: vec![true; count],
            exposed: Vec::with_capacity(count),
            exposed_points: Vec::with_capacity(points.len()),
            orphans: Vec::with_capacity(if bare < count { points.len() } else { 0 }),
            tips: Vec::new(),
            corners: Vec::new(),
            kinks: Vec::new(),
            drops_orphans: false,
            points,
            around,
            shapes: vec![FacetShape::default(); count],
            ordered: Vec::with_capacity(2 * count),
            facets,
        };
        curve.list();
        curve.find_neighbors(places);
        curve.find_tips(places);
        curve.find_corners(places);
        curve.find_kinks(places);
        curve
    }

    /// Creates a curve of points without facets, in ascending order.
    pub fn of_points(points: Vec<u32>) -> FacetCurve {
        let mut curve = FacetCurve::new(Vec::new(), Vec::new(), 0, &[]);
        (curve.around, curve.points) = (vec![Vec::new(); points.len()], points);
        curve.list();
        curve
    }

    /// Finds tips: points on the axis from which the surface slopes backwards. The weighted gap detects them late, so
    /// they also have point contact.
    fn find_tips(&mut self, places: &[[f64; 2]]) {
        for &k in &self.exposed {
            for end in [0, 1] {
                let point = self.facets[k as usize][end];
                if self.neighbors[k as usize][end] != FacetNeighbor::Axis {
                    continue;
                }
                let [a, b] = self.facets[k as usize].inline_map(|p| places[p as usize]);
                let shape = FacetShape::new(a, b);
                let rises = if end == 0 { shape.along[1] } else { -shape.along[1] } / shape.length;
                if rises.abs() > SHARP
                    && rises * shape.normal[1] < 0.0
                    && let Ok(at) = self.points.binary_search(&point)
                {
                    self.tips.push(at as u32);
                }
            }
        }
    }

    /// Returns the change of direction after a facet; `None` without a next one.
    fn turn_after(&self, facet: u32, places: &[[f64; 2]]) -> Option<FacetTurn> {
        let FacetNeighbor::Facet(next) = self.neighbors[facet as usize][1] else { return None };
        let [a, b] = [facet, next].inline_map(|k| {
            let [from, to] = self.facets[k as usize].inline_map(|p| places[p as usize]);
            FacetShape::new(from, to)
        });
        let sine = (a.along[0] * b.along[1] - a.along[1] * b.along[0]) / (a.length * b.length);
        Some(FacetTurn { next, sine, turns_back: a.along[0] * b.along[0] + a.along[1] * b.along[1] < 0.0 })
    }

    /// Finds convex corners. The weighted gap of an opposite facet that a corner slides onto begins with an overlap, so
    /// a corner has point contact.
    fn find_corners(&mut self, places: &[[f64; 2]]) {
        for &k in &self.exposed {
            let Some(FacetTurn { next, sine, turns_back }) = self.turn_after(k, places) else { continue };
            if sine > SHARP || (turns_back && sine > 0.0) {
                self.corners.extend(self.points.binary_search(&self.facets[next as usize][0]).map(|at| at as u32));
            }
        }
    }

    /// Finds kinks, for example the ends of a chamfer with a small angle.
    fn find_kinks(&mut self, places: &[[f64; 2]]) {
        let turn_after = |k: u32| self.turn_after(k, places).map_or(0.0, |turn| turn.sine);
        // The change of direction at a corner says nothing about the curvature of the surface next to it.
        let curved = |turn: f64| if turn.abs() > SHARP { 0.0 } else { turn.abs() };
        let mut kinks = Vec::new();
        for &k in &self.exposed {
            let [before, after] = self.neighbors[k as usize];
            let FacetNeighbor::Facet(next) = after else { continue };
            let turn = turn_after(k);
            let around = [
                if let FacetNeighbor::Facet(previous) = before { turn_after(previous) } else { 0.0 },
                turn_after(next),
            ];
            let smooth = around.into_iter().fold(LEAST_KINK, |most, turn| most.max(KINK * curved(turn)));
            if turn > smooth && turn <= SHARP {
                kinks.extend(self.points.binary_search(&self.facets[next as usize][0]).map(|at| at as u32));
            }
        }
        self.kinks = kinks;
    }

    /// Returns whether some of its points may be in contact by themselves.
    pub fn has_single_points(&self) -> bool {
        self.exposed.len() < self.facets.len() || !self.tips.is_empty() || !self.corners.is_empty()
    }

    /// Returns the points that are in contact by themselves, as indices in `points`: points without elements, then tips and
    /// corners with an exposed facet.
    pub fn single_points(&self) -> impl Iterator<Item = (u32, PointKind)> + '_ {
        let is_exposed = |i: &u32| self.around[*i as usize].iter().any(|f| self.is_exposed[f.0 as usize]);
        let tips = self.tips.iter().copied().filter(is_exposed).map(|i| (i, PointKind::Tip));
        let corners = self.corners.iter().copied().filter(is_exposed).map(|i| (i, PointKind::Corner));
        self.orphans.iter().map(|&i| (i, PointKind::Free)).chain(tips).chain(corners)
    }

    /// Returns half the thickness of the body at a facet.
    pub fn half_thickness(&self, facet: usize) -> f64 {
        let (lift, [_, middle, _]) = (self.lift[facet], self.depth[facet]);
        if lift > 0.0 { lift } else { middle }
    }

    /// Returns the smallest half thickness of the body at the exposed facets around an own point; infinite without such
    /// facets.
    pub fn half_thickness_around(&self, index: usize) -> f64 {
        let exposed = self.exposed_around(index);
        exposed.fold(f64::INFINITY, |least, f| least.min(self.half_thickness(f.0 as usize)))
    }

    /// Returns the largest distance of the surface from its facets.
    pub fn highest(&self) -> f64 {
        self.lift.iter().copied().fold(0.0, f64::max)
    }

    /// Takes the exposed facets of a previous curve with the same facets, and the thickness of its body.
    pub fn take_over(&mut self, previous: &FacetCurve) {
        self.depth.clone_from(&previous.depth);
        self.is_exposed.clone_from(&previous.is_exposed);
        self.has_element.clone_from(&previous.has_element);
        self.neighbors.clone_from(&previous.neighbors);
        self.list();
        self.order();
    }

    pub fn list(&mut self) {
        let FacetCurve {
            is_exposed, has_element, points, around, exposed, exposed_points, orphans, drops_orphans, ..
        } = self;
        exposed.clear();
        exposed.extend((0..is_exposed.len() as u32).filter(|k| is_exposed[*k as usize]));
        exposed_points.clear();
        let has_exposed_facet = |i: &u32| around[*i as usize].iter().any(|f| is_exposed[f.0 as usize]);
        exposed_points.extend((0..points.len() as u32).filter(has_exposed_facet));
        orphans.clear();
        let is_orphan = |i: &u32| around[*i as usize].iter().all(|f| !has_element[f.0 as usize]);
        if !*drops_orphans && (has_element.is_empty() || has_element.contains(&false)) {
            orphans.extend((0..points.len() as u32).filter(is_orphan));
        }
    }

    /// Returns the facets that element deletion has exposed.
    pub fn newly_exposed(&self) -> impl Iterator<Item = &[u32; 2]> {
        let new = self.exposed.iter().filter(|k| **k as usize >= self.exposed_at_start);
        new.map(|k| &self.facets[*k as usize])
    }

    /// Returns whether a point without elements has lost them; the points of node-based surfaces never have any.
    pub fn loses_elements(&self) -> bool {
        !self.facets.is_empty()
    }

    fn facet(&self, from: u32, to: u32) -> Option<usize> {
        let index = self.points.binary_search(&from).ok()?;
        let known = self.around[index].iter().find(|(k, end)| *end == 0 && self.facets[*k as usize][1] == to);
        known.map(|f| f.0 as usize)
    }

    /// Removes the facets of deleted elements and exposes those of their neighbours. `deleted` are the corner nodes of
    /// the elements, counter-clockwise. Returns whether the curve has changed.
    pub fn remove_elements(&mut self, deleted: impl Iterator<Item = ElementNodes> + Clone) -> bool {
        let edges = || deleted.clone().flat_map(ElementNodes::sides);
        let mut changed = false;
        for [a, b] in edges() {
            if let Some(k) = self.facet(a, b) {
                changed |= self.has_element[k];
                (self.is_exposed[k], self.has_element[k]) = (false, false);
            }
        }
        for [a, b] in edges() {
            if let Some(k) = self.facet(b, a).filter(|k| self.has_element[*k] && changed) {
                self.is_exposed[k] = true;
            }
        }
        changed
    }

    /// Sorts exposed facets and their points in the order in which they are connected, so that contact rows form a
    /// narrow band.
    fn order(&mut self) {
        let FacetCurve { facets, neighbors, points, exposed, exposed_points, ordered, is_exposed, .. } = self;
        ordered.clear();
        ordered.resize(facets.len(), false);
        exposed.clear();
        let begins = |k: &usize| !matches!(neighbors[*k][0], FacetNeighbor::Facet(_));
        let exposed_facets = || (0..facets.len()).filter(|k| is_exposed[*k]);
        for first in exposed_facets().filter(begins).chain(exposed_facets()) {
            let mut next = Some(first);
            while let Some(k) = next.filter(|k| !std::mem::replace(&mut ordered[*k], true)) {
                exposed.push(k as u32);
                next = match neighbors[k][1] {
                    FacetNeighbor::Facet(j) => Some(j as usize),
                    _ => None,
                };
            }
        }
        ordered.clear();
        ordered.resize(points.len(), false);
        exposed_points.clear();
        for point in exposed.iter().flat_map(|k| facets[*k as usize]) {
            if let Ok(index) = points.binary_search(&point)
                && !std::mem::replace(&mut ordered[index], true)
            {
                exposed_points.push(index as u32);
            }
        }
    }

    /// Finds the neighbours of each exposed facet. Of several facets at a point it takes the one with the smallest
    /// change of direction.
    pub fn find_neighbors(&mut self, places: &[[f64; 2]]) {
        let shape_of = |facet: [u32; 2]| {
            let [a, b] = facet.inline_map(|p| places[p as usize]);
            FacetShape::new(a, b)
        };
        for at in 0..self.exposed.len() {
            let k = self.exposed[at] as usize;
            for end in [0, 1] {
                let point = self.facets[k][end];
                let shape = shape_of(self.facets[k]);
                let others = self
                    .around(point)
                    .filter(|&(j, e)| e as usize != end && self.is_exposed[j as usize] && j as usize != k);
                let turn = |j: u32| {
                    let next = shape_of(self.facets[j as usize]);
                    -(shape.normal[0] * next.normal[0] + shape.normal[1] * next.normal[1])
                };
                let next = others.map(|(j, _)| (turn(j), j)).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                self.neighbors[k][end] = match next {
                    Some((_, j)) => FacetNeighbor::Facet(j),
                    None if places[point as usize][0] == 0.0 => FacetNeighbor::Axis,
                    None => FacetNeighbor::Nothing,
                };
            }
        }
        self.order();
    }

    /// Returns the facets around a point, and which end of the facet the point is.
    pub fn around(&self, point: u32) -> impl Iterator<Item = (u32, u8)> + '_ {
        let index = self.points.binary_search(&point);
        index.into_iter().flat_map(|index| self.around[index].iter().copied())
    }

    /// Returns the facets around the point at an index of `points`, as [`FacetCurve::around`] does for a point.
    #[inline]
    pub fn around_own(&self, index: usize) -> &[(u32, u8)] {
        &self.around[index]
    }

    /// Returns the exposed facets around the point at an index of `points`, and which end of the facet the point is.
    #[inline]
    pub fn exposed_around(&self, index: usize) -> impl Iterator<Item = &(u32, u8)> {
        self.around[index].iter().filter(|f| self.is_exposed[f.0 as usize])
    }

    /// Returns the area of the hat function of a point on the exposed facets, of the surface of revolution.
    pub fn hat_area(&self, index: usize) -> f64 {
        let exposed = self.exposed_around(index);
        let areas = exposed.map(|&(facet, end)| {
            let FacetShape { from, along, length, .. } = self.shapes[facet as usize];
            let far = if end == 0 { 1.0 } else { 2.0 };
            std::f64::consts::PI * length * (from[0] + along[0] * far / 3.0)
        });
        areas.sum()
    }

    /// Returns whether the surface ends or turns sharply at an end of a facet.
    pub fn turns_at(&self, facet: usize, end: usize) -> bool {
        let FacetNeighbor::Facet(next) = self.neighbors[facet][end] else { return true };
        let [a, b] = [facet, next as usize].inline_map(|k| self.shapes[k].normal);
        (a[0] * b[1] - a[1] * b[0]).abs() > SHARP || a[0] * b[0] + a[1] * b[1] < 0.0
    }

    /// Returns the normals of two exposed facets at an own point; `None` if there are fewer.
    pub fn normals_around(&self, index: usize) -> Option<[[f64; 2]; 2]> {
        let mut exposed = self.exposed_around(index);
        let mut next = || exposed.next().map(|f| self.shapes[f.0 as usize].normal);
        Some([next()?, next()?])
    }

    /// Updates the shapes of exposed facets from the coordinates of the points.
    pub fn shape(&mut self, places: &[[f64; 2]]) {
        for at in 0..self.exposed.len() {
            self.shape_one(self.exposed[at], places);
        }
    }

    /// Returns the box of the exposed facets and of all points that may be in contact.
    pub fn bounds(&self, places: &[[f64; 2]]) -> BoundingBox {
        let facets = self.exposed.iter().map(|&k| self.shapes[k as usize].bounds());
        let points = self.exposed_points.iter().chain(&self.orphans);
        let places = points.map(|&index| [places[self.points[index as usize] as usize]; 2]);
        facets.chain(places).fold(NO_BOX, box_around)
    }

    /// Updates the shape of one facet.
    #[inline]
    pub fn shape_one(&mut self, facet: u32, places: &[[f64; 2]]) {
        let [a, b] = self.facets[facet as usize].inline_map(|p| places[p as usize]);
        self.shapes[facet as usize] = FacetShape::new(a, b);
    }

    /// Returns the integral of the hat function of an own point over the surface of revolution.
    pub fn area(&self, index: usize, places: &[[f64; 2]]) -> f64 {
        let exposed_facets = self.exposed_around(index);
        let area_of = |&(k, end): &(u32, u8)| {
            let radii = self.facets[k as usize].inline_map(|p| places[p as usize][0]);
            let (radius, far_radius) = (radii[end as usize], radii[1 - end as usize]);
            std::f64::consts::TAU * self.shapes[k as usize].length * (2.0 * radius + far_radius) / 6.0
        };
        exposed_facets.map(area_of).sum()
    }

    /// Returns the area of an own point on the exposed facets between the places that `place_of` gives for points.
    pub fn area_at(&self, index: usize, place_of: impl Fn(u32) -> [f64; 2]) -> f64 {
        let exposed = self.exposed_around(index);
        let areas = exposed.map(|&(k, end)| {
            let ends = self.facets[k as usize].inline_map(&place_of);
            let (radius, far_radius) = (ends[end as usize][0], ends[1 - end as usize][0]);
            std::f64::consts::TAU * distance(ends[0], ends[1]) * (2.0 * radius + far_radius) / 6.0
        });
        areas.sum()
    }

    /// Returns the point next to an own point on the side to which it has moved, and the displacement along the facet between
    /// both as a fraction of its length; `None` if it has not moved along the curve. `start_of` gives the places before.
    pub fn next_point(&self, index: usize, place: [f64; 2], start_of: impl Fn(u32) -> [f64; 2]) -> Option<(u32, f64)> {
        let from = start_of(self.points[index]);
        if from == place {
            return None;
        }
        let mut next: Option<(u32, f64)> = None;
        for &(facet, end) in self.exposed_around(index) {
            let beyond = self.facets[facet as usize][1 - end as usize];
            let share = share_of_way([from, place], start_of(beyond));
            if share > next.map_or(0.0, |next| next.1) {
                next = Some((beyond, share.min(1.0)));
            }
        }
        next
    }

    /// Returns the mean distance of the surface from an own point, over all of its facets.
    pub fn lift_of(&self, index: usize) -> f64 {
        let around = &self.around[index];
        let sum: f64 = around.iter().map(|f| self.lift[f.0 as usize]).sum();
        sum / around.len().max(1) as f64
    }
}

impl Persist for FacetNeighbor {
    fn persist(&mut self, archive: &mut StateArchive<'_>) {
        let mut code = match *self {
            FacetNeighbor::Facet(k) => k,
            FacetNeighbor::Axis => u32::MAX,
            FacetNeighbor::Nothing => u32::MAX - 1,
        };
        code.persist(archive);
        *self = match code {
            u32::MAX => FacetNeighbor::Axis,
            code if code == u32::MAX - 1 => FacetNeighbor::Nothing,
            k => FacetNeighbor::Facet(k),
        };
    }
}

impl FacetCurve {
    /// Rebuilds the lists of exposed facets after reading.
    fn list_again(&mut self, archive: &mut StateArchive<'_>) {
        if archive.reads() {
            let exists =
                |next: &FacetNeighbor| !matches!(next, FacetNeighbor::Facet(k) if *k as usize >= self.facets.len());
            if !self.neighbors.iter().flatten().all(exists) {
                archive.reject(|| "a contact facet has a neighbour that does not exist".to_owned());
                return;
            }
            self.list();
            self.order();
        }
    }
}
