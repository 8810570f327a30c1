//! Motion of the nodes of an adaptive mesh domain: smoothing inside, and sliding along its boundary.

use super::held_places::HeldPlaces;
use super::topology::{BoundaryNode, DomainTopology};
use crate::kernel::chunks::ChunkLoops;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::kernel::quad;
use crate::kernel::shape::{corner_shape, is_triangle, twice_area};
use crate::state::archive::Persist;

/// Weights of the smoothing methods; they sum to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothingWeights {
    /// Mean of the centres of the elements around a node, weighted by their areas.
    pub volumetric: f64,
    /// Mean of the adjacent nodes.
    pub laplacian: f64,
    /// Solution of the equations of an equipotential mesh (Winslow 1966), for nodes with four elements; mean of the
    /// adjacent nodes elsewhere.
    pub equipotential: f64,
}

/// Weights by which each place follows from its neighbours in the mesh at the start (SMOOTHING OBJECTIVE=GRADED).
#[derive(Clone, Debug, Memory)]
pub struct MeshGrading {
    /// Weights of the adjacent nodes of each node, one list after another.
    adjacent: Vec<f64>,
    /// Share of the length before each node in the length of the two edges of the boundary at it.
    before: Vec<f64>,
}

impl MeshGrading {
    /// Finds the weights nearest to equal ones that reproduce the places at the start. Equation (18.3).
    pub fn new(domain: &DomainTopology, places: &[[f64; 2]]) -> MeshGrading {
        let mut adjacent = Vec::new();
        for (node, place) in places.iter().enumerate() {
            let mean = mean_of_adjacent(domain, places, node);
            let list = domain.adjacent.list(node);
            let apart = |n: &u32| [0, 1].inline_map(|i: usize| places[*n as usize][i] - mean[i]);
            let (mut rr, mut zz, mut rz) = (0.0, 0.0, 0.0);
            for [r, z] in list.iter().map(apart) {
                (rr, zz, rz) = (rr + r * r, zz + z * z, rz + r * z);
            }
            let determinant = rr * zz - rz * rz;
            let off = [place[0] - mean[0], place[1] - mean[1]];
            let slope = if determinant > 0.0 {
                [zz * off[0] - rz * off[1], rr * off[1] - rz * off[0]].inline_map(|x| x / determinant)
            } else {
                [0.0; 2]
            };
            let equal = 1.0 / list.len() as f64;
            adjacent.extend(list.iter().map(apart).map(|[r, z]| equal + slope[0] * r + slope[1] * z));
        }
        let mut shares_before = vec![0.5; places.len()];
        for BoundaryNode { node, before: a, after: b, .. } in &domain.boundary {
            let length = |n: u32| {
                let ([r, z], [s, w]) = (places[n as usize], places[*node as usize]);
                libm::hypot(r - s, z - w)
            };
            let (first, second) = (length(*a), length(*b));
            shares_before[*node as usize] = first / (first + second);
        }
        MeshGrading { adjacent, before: shares_before }
    }

    fn place(&self, domain: &DomainTopology, places: &[[f64; 2]], node: usize) -> [f64; 2] {
        let weights = &self.adjacent[domain.adjacent.range(node)];
        let parts = domain.adjacent.list(node).iter().zip(weights);
        parts.fold([0.0; 2], |[r, z], (n, w)| [r + w * places[*n as usize][0], z + w * places[*n as usize][1]])
    }
}

/// Possible motions of a node of the domain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NodeMobility {
    /// The node moves with the material.
    #[default]
    Fixed,
    /// It moves along the boundary, unless the boundary has a corner there.
    Boundary,
    /// It moves freely inside the domain.
    Inside,
}

/// Contact of a node of the boundary.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BoundaryContact {
    /// Contact presses on the node.
    Pressed,
    /// Distance from the opposite surface; infinite if unknown.
    Apart(f64),
}

/// Surfaces of other bodies around a domain; nodes are given by their index in the solver.
pub trait Surroundings {
    /// Returns the contact of a node of the boundary.
    fn contact(&self, node: usize) -> BoundaryContact;
    /// Returns whether the new place of a node is corrected afterwards so that its gaps to other surfaces continue.
    fn keeps_gaps(&self, node: usize) -> bool;
    /// Returns the closest place on the curved surface that presses on a node; `None` if the surface deforms.
    fn place_on_surface(&self, node: usize, place: [f64; 2]) -> Option<[f64; 2]>;
}

/// Smoothing of a domain.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(
    fixed: deferred;
    derived: weights, grading, corner_cosine, mobility, slides_at_ends, now, target, shares, parts, corners, handed,
        is_spread, boundary_of, contact, keeps_gaps, is_deleted, halted
)]
#[memory(uncounted: handed)]
pub(super) struct MeshSmoothing {
    pub weights: SmoothingWeights,
    /// Grading of the mesh; `None` if elements become equal.
    grading: Option<MeshGrading>,
    /// Cosine of the angle between the edges of the boundary from which on a node is at a corner.
    pub corner_cosine: f64,
    /// Motions that the domain allows.
    mobility: Vec<NodeMobility>,
    /// Nodes that slide also at the ends of prescribed motions of the material.
    slides_at_ends: Vec<bool>,
    /// Motions in the current change of the mesh.
    now: Vec<NodeMobility>,
    /// New positions of a sweep.
    target: Vec<[f64; 2]>,
    /// Displacements of nodes inside the domain that are deferred to later changes of the mesh.
    deferred: Vec<[f64; 2]>,
    /// Squared displacements over the shortest edges.
    shares: Vec<f64>,
    /// Centre of each element times its area, and its area.
    parts: Vec<[f64; 3]>,
    /// Nodes at corners of the boundary at the start, by their position in the list of the boundary.
    corners: Vec<u32>,
    /// Nodes of corners that a sweep has moved to the edge of contact, with the node that was there before; both move together.
    handed: Vec<[u32; 2]>,
    /// Nodes of free sides that have been spread from a corner on.
    is_spread: Vec<bool>,
    /// Position in the list of the boundary of each node; [`INSIDE`] for others.
    boundary_of: Vec<u32>,
    /// Contact of each node; used on the boundary only.
    contact: Vec<BoundaryContact>,
    /// Nodes of the boundary whose new places are corrected afterwards.
    keeps_gaps: Vec<bool>,
    /// Nodes of deleted elements.
    is_deleted: Vec<bool>,
    /// Nodes whose motion is taken back.
    halted: Vec<bool>,
}

/// Part of the displacement to the middle between its neighbours by which a sweep moves a node that keeps gaps.
const PART: f64 = 0.3;
/// Most nodes that come into contact between two changes of the mesh.
const FOLDED: usize = 16;
/// Largest gap over the length of the edge, at which a node beyond a corner has come into contact.
const TOUCH: f64 = 0.02;
/// Largest gap between two nodes in contact over the length of the last edge of the surface; such gaps are closed.
const POCKET: f64 = 0.05;
/// Most nodes of a free side that are spread from a corner on.
const WINDOW: usize = 32;
/// Share of the differences from equal distances that a sweep removes.
const SPREAD: f64 = 0.3;
/// As [`FLAT`], for elements at a corner of the boundary that a sweep has moved.
const FLAT_CORNER: f64 = 0.02;
/// Marks a node that is not in the list of the boundary.
const INSIDE: u32 = u32::MAX;
/// Smallest area of a corner triangle over the mean of the element, below which a sweep may not reduce it.
const FLAT: f64 = 0.3;
/// Reduction of this ratio that is accepted below [`FLAT`]: elements with a flat corner on a straight boundary improve
/// otherwise.
const WORSE: f64 = 1e-3;
/// Number of times that the motions at bad elements are taken back in a sweep; then the whole sweep is.
const RETRIES: usize = 20;
/// Smallest displacement of a node on the boundary over the shortest edge at it; shorter ones are deferred.
const SMALL: f64 = 0.01;
/// Displacement of a node inside the domain over the shortest edge at it, at which the mesh changes inside.
const LONG: f64 = 0.1;
/// Smallest displacement of the other nodes inside the domain that then move, too.
const SHORT: f64 = 0.03;

impl MeshSmoothing {
    pub fn new(
        (domain, places): (&DomainTopology, &[[f64; 2]]),
        weights: SmoothingWeights,
        grading: Option<MeshGrading>,
        corner_cosine: f64,
        (mobility, slides_at_ends): (Vec<NodeMobility>, Vec<bool>),
    ) -> MeshSmoothing {
        let count = mobility.len();
        let mut boundary_of = vec![INSIDE; count];
        let mut corners = Vec::new();
        for (i, node) in domain.boundary.iter().enumerate() {
            boundary_of[node.node as usize] = i as u32;
            let ends = [node.before, node.node, node.after].inline_map(|n: u32| places[n as usize]);
            if node.is_open == [false; 2] && turn_cosine(ends) <= corner_cosine {
                corners.push(i as u32);
            }
        }
        MeshSmoothing {
            weights,
            grading,
            corner_cosine,
            now: mobility.clone(),
            mobility,
            slides_at_ends,
            target: vec![[0.0; 2]; count],
            deferred: vec![[0.0; 2]; count],
            shares: vec![0.0; count],
            parts: vec![[0.0; 3]; domain.corners.len()],
            is_spread: vec![false; count],
            halted: vec![false; count],
            handed: Vec::with_capacity(FOLDED * corners.len()),
            corners,
            boundary_of,
            contact: vec![BoundaryContact::Apart(f64::INFINITY); count],
            keeps_gaps: vec![false; count],
            is_deleted: vec![false; count],
        }
    }

    /// Takes the deferred displacements of a previous step if the domain has the same nodes.
    pub fn continue_from(&mut self, previous: &MeshSmoothing) {
        if self.deferred.len() == previous.deferred.len() {
            self.deferred.copy_from_slice(&previous.deferred);
        }
    }

    /// Reads the contact of the nodes of the boundary.
    pub fn read_contact(&mut self, domain: &DomainTopology, surroundings: &dyn Surroundings) {
        for BoundaryNode { node, .. } in &domain.boundary {
            let (position, node) = (*node as usize, domain.nodes[*node as usize] as usize);
            (self.contact[position], self.keeps_gaps[position]) =
                (surroundings.contact(node), surroundings.keeps_gaps(node));
        }
    }

    /// Returns whether the place of a node on the boundary may be corrected.
    pub fn is_on_free_boundary(&self, node: usize) -> bool {
        self.mobility[node] == NodeMobility::Boundary && !self.is_deleted[node]
    }

    /// Returns whether a node may move in the current change of the mesh.
    pub fn slides(&self, node: usize) -> bool {
        self.now[node] != NodeMobility::Fixed
    }

    /// Returns whether a node belongs to a deleted element.
    pub fn is_deleted(&self, node: usize) -> bool {
        self.is_deleted[node]
    }

    /// Fixes nodes of deleted elements, nodes at the ends of regions with prescribed motions along r or z, and nodes whose
    /// place is prescribed.
    pub fn restrict(
        &mut self,
        domain: &DomainTopology,
        (prescribed, held_places): (&[[bool; 2]], &HeldPlaces),
        deleted: impl Fn(u32) -> bool,
    ) {
        self.now.copy_from_slice(&self.mobility);
        self.is_deleted.fill(false);
        for (now, _) in self.now.iter_mut().zip(prescribed).filter(|n| *n.1 == [true; 2]) {
            *now = NodeMobility::Fixed;
        }
        let prescribed_of = |n: u32| prescribed[n as usize];
        for BoundaryNode { node, before, after, .. } in &domain.boundary {
            let alike =
                (0..2).all(|i| !prescribed_of(*node)[i] || (prescribed_of(*before)[i] && prescribed_of(*after)[i]));
            if !alike && !self.slides_at_ends[*node as usize] {
                self.now[*node as usize] = NodeMobility::Fixed;
            }
            let on_surface = domain.boundary_at(*node).is_some_and(|b| b.is_open != [true; 2]);
            if held_places.is_held(*node as usize) && on_surface {
                self.now[*node as usize] = NodeMobility::Fixed;
            }
        }
        for (element, corners) in domain.elements.iter().zip(&domain.corners) {
            if deleted(*element) {
                for n in corners {
                    (self.now[*n as usize], self.is_deleted[*n as usize]) = (NodeMobility::Fixed, true);
                }
            }
        }
    }

    /// Moves the nodes once; motions that are prescribed along r or z keep this coordinate.
    pub fn sweep(
        &mut self,
        loops: ChunkLoops,
        domain: &DomainTopology,
        held_places: &HeldPlaces,
        surroundings: &dyn Surroundings,
        places: &mut [[f64; 2]],
    ) {
        self.smooth_inside(loops, domain, places);
        held_places.restore(places, &mut self.target);
        self.hand_over_corners(domain);
        for node in &domain.boundary {
            let n = node.node as usize;
            if self.now[n] == NodeMobility::Boundary && !self.is_spread[n] {
                let ends = [node.before, node.node, node.after].inline_map(|n: u32| self.target[n as usize]);
                let part = if self.keeps_gaps[n] { PART } else { 1.0 };
                let step = part * self.step_along_boundary(domain, places, n, ends);
                let slid_place = keep(held_places.kept[n], ends, slide(ends, step, self.corner_cosine));
                let on_surface = |slid_place| surroundings.place_on_surface(domain.nodes[n] as usize, slid_place);
                self.target[n] = self.keep_contact(node, slid_place, &on_surface).unwrap_or(ends[1]);
            }
        }
        self.take_back(domain, places);
        places.copy_from_slice(&self.target);
    }

    /// Returns the distance by which a node moves along the chord of its neighbours on the boundary: to the share of the
    /// length that is before it. On the axis the mesh continues as its mirror image, so that volume smoothing is that of a
    /// node inside. Equal distances there would tilt the rows of flat elements until they fold.
    fn step_along_boundary(
        &self,
        domain: &DomainTopology,
        places: &[[f64; 2]],
        node: usize,
        [before, own, after]: [[f64; 2]; 3],
    ) -> f64 {
        let [first, second] = [length(vector(before, own)), length(vector(own, after))];
        let share = self.grading.as_ref().map_or(0.5, |grading| grading.before[node]);
        let step = share * second - (1.0 - share) * first;
        let weight = if self.grading.is_none() { self.weights.volumetric } else { 0.0 };
        let is_axial = [before, own, after].iter().all(|place| place[0] == 0.0);
        if !is_axial || weight == 0.0 || !step.is_finite() {
            return step;
        }
        let upwards = mean_of_elements(domain, (places, &self.parts), node)[1] - own[1];
        let mirrored = if after[1] > before[1] { upwards } else { -upwards };
        weight * mirrored.clamp(-0.5 * first, 0.5 * second) + (1.0 - weight) * step
    }

    /// Keeps corners at the edge of contact. Where a free side folds onto a straight surface, its first nodes come into
    /// contact: the node of the corner takes the place of the last such node, and they move to the first edge of the
    /// free side. The boundary does not change.
    fn hand_over_corners(&mut self, domain: &DomainTopology) {
        self.handed.clear();
        self.is_spread.fill(false);
        for at in 0..self.corners.len() {
            let BoundaryNode { node, before, after, .. } = domain.boundary[self.corners[at] as usize];
            for (first, opposite) in [(after, before), (before, after)] {
                if let Some(found) = self.folded_nodes(domain, [opposite, node, first]) {
                    self.hand_over(node, found);
                }
                if self.grading.is_none() && self.presses_flatly(domain, node, first) {
                    self.spread_free_side(domain, [opposite, node, first]);
                }
            }
        }
    }

    /// Moves the node of a corner to the last of the folded nodes, and these to the first edge of the free side.
    fn hand_over(&mut self, node: u32, (folded, free): ([u32; FOLDED], u32)) {
        let count = folded.iter().take_while(|n| **n != INSIDE).count();
        let [edge, end] = [folded[count - 1], free].inline_map(|n: u32| self.target[n as usize]);
        self.target[node as usize] = edge;
        for (i, folded) in folded[..count].iter().enumerate() {
            let share = (i + 1) as f64 / (count + 1) as f64;
            self.target[*folded as usize] = [0, 1].inline_map(|k: usize| edge[k] + share * (end[k] - edge[k]));
            self.contact[*folded as usize] = BoundaryContact::Apart(0.0);
            self.handed.push([node, *folded]);
        }
    }

    /// Moves the nodes of the free side beyond a corner, from `first` on, along its edges towards equal distances, and then
    /// across it until the volume is the same as before. `opposite` and `node` are on the surface that presses up to the
    /// corner.
    fn spread_free_side(&mut self, domain: &DomainTopology, [opposite, node, first]: [u32; 3]) {
        let Some(side) = self.free_side(domain, [node, first]) else { return };
        let FreeSide { nodes, places, count } = side;
        let mut lengths = [0.0; WINDOW + 1];
        for i in 1..=count {
            lengths[i] = lengths[i - 1] + length(vector(places[i - 1], places[i]));
        }
        let (mut edge, mut spread) = (0, places);
        for i in 1..count {
            let distance_along = lengths[i] + SPREAD * (lengths[count] * i as f64 / count as f64 - lengths[i]);
            while edge + 1 < count && lengths[edge + 1] < distance_along {
                edge += 1;
            }
            let share = (distance_along - lengths[edge]) / (lengths[edge + 1] - lengths[edge]);
            let [from, to] = [places[edge], places[edge + 1]];
            spread[i] = [0, 1].inline_map(|k: usize| from[k] + share * (to[k] - from[k]));
        }
        let line = [self.target[opposite as usize], places[0]];
        let forward = domain.boundary[self.boundary_of[node as usize] as usize].after == first;
        keep_volume(&places[..=count], &mut spread[..=count], line, if forward { 1.0 } else { -1.0 });
        for i in 1..count {
            self.target[nodes[i] as usize] = spread[i];
            self.is_spread[nodes[i] as usize] = true;
        }
    }

    /// Returns the nodes of a free side from a corner to the first node that does not slide freely; `None` if there is no node
    /// between.
    fn free_side(&self, domain: &DomainTopology, [node, first]: [u32; 2]) -> Option<FreeSide> {
        let mut side = FreeSide { nodes: [INSIDE; WINDOW + 1], places: [[0.0; 2]; WINDOW + 1], count: 0 };
        (side.nodes[0], side.places[0]) = (node, self.target[node as usize]);
        let mut next = Some(first);
        while let Some(n) = next.filter(|_| side.count < WINDOW) {
            side.count += 1;
            let FreeSide { nodes, places, count } = &mut side;
            (nodes[*count], places[*count]) = (n, self.target[n as usize]);
            let last = [places[*count - 1], places[*count]];
            next = self.next_on_boundary(domain, [nodes[*count - 1], n]).filter(|beyond| {
                let slides = self.now[n as usize] == NodeMobility::Boundary;
                let free = self.contact[n as usize] != BoundaryContact::Pressed;
                slides && free && turn_cosine([last[0], last[1], self.target[*beyond as usize]]) > self.corner_cosine
            });
        }
        (side.count > 1).then_some(side)
    }

    /// Returns the neighbour of `node` on the boundary that is not `last`.
    fn next_on_boundary(&self, domain: &DomainTopology, [last, node]: [u32; 2]) -> Option<u32> {
        let ends = domain.boundary.get(self.boundary_of[node as usize] as usize)?;
        Some(if ends.before == last { ends.after } else { ends.before })
    }

    /// Returns whether a node is in contact, or nearly so in comparison with the edge from a neighbour.
    fn touches(&self, [neighbour, node]: [u32; 2]) -> bool {
        let [from, to] = [neighbour, node].inline_map(|n: u32| self.target[n as usize]);
        match self.contact[node as usize] {
            BoundaryContact::Pressed => true,
            BoundaryContact::Apart(gap) => gap < TOUCH * length(vector(from, to)),
        }
    }

    /// Returns the nodes beyond a corner up to the last one that a straight surface presses on, then [`INSIDE`], and the
    /// first free node.
    fn folded_nodes(&self, domain: &DomainTopology, [opposite, node, first]: [u32; 3]) -> Option<([u32; FOLDED], u32)> {
        let slides = |n: u32| self.now[n as usize] == NodeMobility::Boundary;
        if !(self.touches([node, opposite]) && self.touches([opposite, node]) && slides(node)) {
            return None;
        }
        let line = [opposite, node].inline_map(|n: u32| self.target[n as usize]);
        let near = POCKET * length(vector(line[0], line[1]));
        let (mut folded, mut contact_end) = ([INSIDE; FOLDED], None);
        let [mut last, mut next] = [node, first];
        for (at, place) in folded.iter_mut().enumerate() {
            let gap = match self.contact[next as usize] {
                BoundaryContact::Pressed => 0.0,
                BoundaryContact::Apart(gap) => gap,
            };
            let off =
                twice_area([line[0], line[1], self.target[next as usize]]).abs() / length(vector(line[0], line[1]));
            if !(gap < near && off < near && slides(next)) {
                break;
            }
            *place = next;
            let beyond = self.next_on_boundary(domain, [last, next])?;
            if self.touches([last, next]) {
                contact_end = Some((at + 1, beyond));
            }
            (last, next) = (next, beyond);
        }
        let (count, free) = contact_end?;
        folded[count..].fill(INSIDE);
        Some((folded, free))
    }

    /// Returns the new place of a node that slides along the boundary and keeps its contact: along a surface under pressure,
    /// or away from surfaces that press and from those that the node could reach; otherwise `None`.
    fn keep_contact(
        &self,
        node: &BoundaryNode,
        place: [f64; 2],
        on_surface: &dyn Fn([f64; 2]) -> Option<[f64; 2]>,
    ) -> Option<[f64; 2]> {
        let list = [node.before, node.node, node.after];
        let ends = list.inline_map(|n: u32| self.target[n as usize]);
        let pressed = list.inline_map(|n: u32| self.contact[n as usize] == BoundaryContact::Pressed);
        match (pressed, self.contact[node.node as usize]) {
            ([true, true, true], _) if is_straight(ends) => Some(place),
            _ if self.keeps_gaps[node.node as usize] => Some(place),
            ([true, true, true], _) if place != ends[1] => on_surface(place),
            ([false, false, false], BoundaryContact::Apart(gap)) if gap > length(vector(ends[1], place)) => Some(place),
            _ => None,
        }
    }

    /// Returns whether a straight surface presses on the boundary from a node on, away from its neighbour `beside`.
    fn presses_flatly(&self, domain: &DomainTopology, node: u32, beside: u32) -> bool {
        let pressed = |n: &u32| self.contact[*n as usize] == BoundaryContact::Pressed;
        let Some(second) = self.next_on_boundary(domain, [beside, node]).filter(pressed) else { return false };
        let Some(third) = self.next_on_boundary(domain, [node, second]).filter(pressed) else { return false };
        is_straight([node, second, third].inline_map(|n: u32| self.target[n as usize]))
    }

    /// Finds new places of the nodes inside the domain; other nodes keep theirs.
    fn smooth_inside(&mut self, loops: ChunkLoops, domain: &DomainTopology, places: &[[f64; 2]]) {
        let MeshSmoothing { weights, grading, now, parts, target, .. } = self;
        if grading.is_none() && weights.volumetric != 0.0 {
            loops.each(parts, |start, list| {
                for (part, corners) in list.iter_mut().zip(&domain.corners[start..]) {
                    *part = centre_and_area(corners.inline_map(|n| places[n as usize]), is_triangle(corners));
                }
            });
        }
        let parts = &*parts;
        loops.each(target, |start, list| {
            for (at, place) in list.iter_mut().enumerate() {
                let n = start + at;
                *place = match (now[n], &*grading) {
                    (NodeMobility::Inside, Some(grading)) => grading.place(domain, places, n),
                    (NodeMobility::Inside, None) => weights.smoothed(domain, (places, parts), n),
                    _ => places[n],
                };
            }
        });
    }

    /// Adds the deferred displacements of nodes inside the domain to their places.
    pub fn add_deferred(&self, places: &mut [[f64; 2]]) {
        for ((place, by), now) in places.iter_mut().zip(&self.deferred).zip(&self.now) {
            if *now == NodeMobility::Inside {
                *place = [place[0] + by[0], place[1] + by[1]];
            }
        }
    }

    /// Defers short displacements to later changes of the mesh: nodes inside the domain move when one displacement inside
    /// is long, nodes on the boundary when their own displacement is not short.
    pub fn defer_short(
        &mut self,
        domain: &DomainTopology,
        held_places: &HeldPlaces,
        start: &[[f64; 2]],
        end: &mut [[f64; 2]],
    ) {
        let (mut longest, mut spread) = (0.0, 0.0);
        for (n, by) in self.deferred.iter_mut().enumerate() {
            *by = vector(start[n], end[n]);
            let square = by[0] * by[0] + by[1] * by[1];
            let share = if square > 0.0 { square / shortest_edge(domain, start, n) } else { 0.0 };
            self.shares[n] = if held_places.is_held(n) { f64::INFINITY } else { share };
            if held_places.is_held(n) {
                continue;
            }
            if self.now[n] == NodeMobility::Inside && share > longest {
                longest = share;
            }
            if self.is_spread[n] && share > spread {
                spread = share;
            }
        }
        let least = if longest > LONG * LONG { SHORT * SHORT } else { f64::INFINITY };
        for (n, by) in self.deferred.iter_mut().enumerate() {
            // Nodes of a free side keep its volume together.
            let share = if self.is_spread[n] { spread } else { self.shares[n] };
            if share < if self.now[n] == NodeMobility::Inside { least } else { SMALL * SMALL } {
                end[n] = start[n];
            } else {
                *by = [0.0; 2];
            }
        }
    }

    /// Takes back motions that flatten the corner of an element.
    fn take_back(&mut self, domain: &DomainTopology, places: &[[f64; 2]]) {
        for _ in 0..RETRIES {
            self.halted.fill(false);
            let mut any = false;
            for corners in &domain.corners {
                if corners.iter().all(|n| self.target[*n as usize] == places[*n as usize]) {
                    continue;
                }
                let new = corner_shape(corners, &self.target);
                let is_handed = |n: &u32| self.handed.iter().any(|pair| pair.contains(n));
                let flat = if corners.iter().any(is_handed) { FLAT_CORNER } else { FLAT };
                if new < flat && new < corner_shape(corners, places) - WORSE {
                    any = true;
                    corners.iter().for_each(|n| self.halted[*n as usize] = true);
                }
            }
            if !any {
                return;
            }
            self.halt_handed();
            for ((target, place), _) in self.target.iter_mut().zip(places).zip(&self.halted).filter(|n| *n.1) {
                *target = *place;
            }
        }
        self.target.copy_from_slice(places);
    }

    /// Halts nodes that have been handed over together; all of a corner share its node.
    fn halt_handed(&mut self) {
        for [corner, folded] in self.handed.iter().chain(self.handed.iter().rev()).map(|p| p.inline_map(|n| n as usize))
        {
            let halted = self.halted[corner] || self.halted[folded];
            (self.halted[corner], self.halted[folded]) = (halted, halted);
        }
    }

    /// Takes back the new places of elements that contact has corrected until a corner is flat or has turned over: their nodes
    /// follow the material in this change, except those whose place is prescribed.
    pub fn take_back_corrected(
        &mut self,
        domain: &DomainTopology,
        held_places: &HeldPlaces,
        start: &[[f64; 2]],
        end: &mut [[f64; 2]],
    ) {
        for attempt in 0..=RETRIES {
            self.halted.fill(attempt == RETRIES);
            for corners in &domain.corners {
                let moves = corners.iter().any(|n| end[*n as usize] != start[*n as usize]);
                let new = if moves { corner_shape(corners, end) } else { 1.0 };
                if new < FLAT_CORNER && new < corner_shape(corners, start) {
                    corners.iter().for_each(|n| self.halted[*n as usize] = true);
                }
            }
            if !self.halted.contains(&true) {
                return;
            }
            self.halt_handed();
            for (n, end) in end.iter_mut().enumerate().filter(|(n, _)| self.halted[*n] && !held_places.is_held(*n)) {
                *end = start[n];
            }
        }
    }
}

impl SmoothingWeights {
    /// Equation (18.1).
    fn smoothed(&self, domain: &DomainTopology, (places, parts): (&[[f64; 2]], &[[f64; 3]]), node: usize) -> [f64; 2] {
        let SmoothingWeights { volumetric, laplacian, equipotential } = *self;
        let mut smoothed = [0.0; 2];
        let mut add = |weight: f64, part: [f64; 2]| {
            for (sum, x) in smoothed.iter_mut().zip(part) {
                *sum += weight * x;
            }
        };
        if volumetric != 0.0 {
            add(volumetric, mean_of_elements(domain, (places, parts), node));
        }
        if laplacian != 0.0 {
            add(laplacian, mean_of_adjacent(domain, places, node));
        }
        if equipotential != 0.0 {
            add(equipotential, equipotential_place(domain, places, node));
        }
        smoothed
    }
}

/// Returns the centre of an element times its area, and its area.
fn centre_and_area(at: [[f64; 2]; 4], is_triangle: bool) -> [f64; 3] {
    let area = quad::section(at.inline_map(|c| c[0]), at.inline_map(|c| c[1])).max(0.0);
    let middle = |i: usize| {
        let three = at[0][i] + at[1][i] + at[2][i];
        if is_triangle { three / 3.0 } else { 0.25 * ((at[0][i] + at[1][i]) + (at[2][i] + at[3][i])) }
    };
    let along = |i: usize| area * middle(i);
    [along(0), along(1), area]
}

fn mean_of_elements(domain: &DomainTopology, (places, parts): (&[[f64; 2]], &[[f64; 3]]), node: usize) -> [f64; 2] {
    let mut sum = [0.0; 3];
    for e in domain.around.list(node) {
        let part = parts[*e as usize];
        sum = [sum[0] + part[0], sum[1] + part[1], sum[2] + part[2]];
    }
    if sum[2] > 0.0 { [sum[0] / sum[2], sum[1] / sum[2]] } else { places[node] }
}

fn mean_of_adjacent(domain: &DomainTopology, places: &[[f64; 2]], node: usize) -> [f64; 2] {
    let list = domain.adjacent.list(node);
    let sum = list.iter().fold([0.0; 2], |[r, z], n| [r + places[*n as usize][0], z + places[*n as usize][1]]);
    sum.inline_map(|x| x / list.len() as f64)
}

/// Returns the place of a node with four elements in an equipotential mesh: alpha x_ξξ - 2 beta x_ξη + gamma x_ηη = 0
/// with differences of the eight nodes around it. Equation (18.2).
fn equipotential_place(domain: &DomainTopology, places: &[[f64; 2]], node: usize) -> [f64; 2] {
    let Some(ring) = ring(domain, node) else { return mean_of_adjacent(domain, places, node) };
    let ring_places = ring.inline_map(|n| places[n as usize]);
    let half = |a: [f64; 2], b: [f64; 2]| [0, 1].inline_map(|i: usize| 0.5 * (a[i] - b[i]));
    let (xi, eta) = (half(ring_places[0], ring_places[4]), half(ring_places[2], ring_places[6]));
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let (alpha, beta, gamma) = (dot(eta, eta), dot(xi, eta), dot(xi, xi));
    let sum = 2.0 * (alpha + gamma);
    if sum <= 0.0 {
        return places[node];
    }
    [0, 1].inline_map(|i: usize| {
        let mixed = 0.25 * (ring_places[1][i] - ring_places[3][i] + ring_places[5][i] - ring_places[7][i]);
        (alpha * (ring_places[0][i] + ring_places[4][i]) - 2.0 * beta * mixed
            + gamma * (ring_places[2][i] + ring_places[6][i]))
            / sum
    })
}

/// Returns the eight nodes around a node with four elements, counter-clockwise from an adjacent one.
fn ring(domain: &DomainTopology, node: usize) -> Option<[u32; 8]> {
    let elements: [u32; 4] = domain.around.list(node).try_into().ok()?;
    if elements.iter().any(|e| is_triangle(&domain.corners[*e as usize])) {
        return None;
    }
    let corner = |e: u32| {
        let corners = domain.corners[e as usize];
        let own_corner = corners.iter().position(|n| *n as usize == node)?;
        Some([1, 2, 3].inline_map(|i: usize| corners[(own_corner + i) % 4]))
    };
    let mut ring = [0; 8];
    let mut next = corner(elements[0])?[0];
    for side in 0..4 {
        let [first, opposite, last] = elements.iter().filter_map(|e| corner(*e)).find(|c| c[0] == next)?;
        (ring[2 * side], ring[2 * side + 1], next) = (first, opposite, last);
    }
    (next == ring[0]).then_some(ring)
}

/// Returns the new place of a node between two others on the boundary. It moves by `step` along the chord of its
/// neighbours, then across the chord until the volume of the ring between the three is the same as before.
fn slide([before, own, after]: [[f64; 2]; 3], step: f64, corner_cosine: f64) -> [f64; 2] {
    let chord = vector(before, after);
    let l = length(chord);
    if !(turn_cosine([before, own, after]) > corner_cosine && l > 0.0) {
        return own;
    }
    let along = chord.inline_map(|x| x / l);
    let moved = [own[0] + step * along[0], own[1] + step * along[1]];
    let ring = |own: [f64; 2]| 0.5 * twice_area([before, own, after]) * (before[0] + own[0] + after[0]);
    let across = [along[1], -along[0]];
    let (volume_before, now) = (ring(own), ring(moved));
    // dV/dx of the ring: half the chord times the sum of radii, plus the area times the radial part of x.
    let slope = 0.5 * l * (before[0] + moved[0] + after[0]) + 0.5 * twice_area([before, moved, after]) * across[0];
    if slope.abs() <= 1e-3 * l * l {
        return moved;
    }
    let lift = (volume_before - now) / slope;
    [moved[0] + lift * across[0], moved[1] + lift * across[1]]
}

/// Returns the squared length of the shortest edge at a node.
fn shortest_edge(domain: &DomainTopology, places: &[[f64; 2]], node: usize) -> f64 {
    let square = |[r, z]: [f64; 2]| r * r + z * z;
    let edges = domain.adjacent.list(node).iter().map(|n| square(vector(places[node], places[*n as usize])));
    edges.fold(f64::INFINITY, f64::min)
}

/// Nodes of the boundary from a corner on.
struct FreeSide {
    nodes: [u32; WINDOW + 1],
    places: [[f64; 2]; WINDOW + 1],
    /// Index of the last node.
    count: usize,
}

/// Shape of a part of the boundary at an inner node.
struct CornerShape {
    /// Unit vector outwards.
    normal: [f64; 2],
    /// Share of the node in the shift.
    weight: f64,
    /// Increase of the volume with the shift.
    gain: f64,
}

/// Moves the inner nodes of a part of the boundary outwards until its ring volume is that of `before`; those near a line,
/// from which the part starts, by less. `sign` is 1 if the domain is on the left of the part, otherwise -1.
fn keep_volume(before: &[[f64; 2]], after: &mut [[f64; 2]], line: [[f64; 2]; 2], sign: f64) {
    let volume = |list: &[[f64; 2]]| -> f64 {
        list.windows(2).map(|p| (p[0][0] + p[1][0]) * (p[0][0] * p[1][1] - p[1][0] * p[0][1])).sum()
    };
    let (lost, last) = (sign * (volume(before) - volume(after)), after.len() - 1);
    let shape = |list: &[[f64; 2]], i: usize| {
        let [a, b, c] = [list[i - 1], list[i], list[i + 1]];
        let (chord, off) = (vector(a, c), twice_area([line[0], line[1], b]).abs() / length(vector(line[0], line[1])));
        let (l, weight) = (length(chord), (2.0 * off / length(chord)).min(1.0));
        let normal = [sign * chord[1] / l, -sign * chord[0] / l];
        CornerShape { normal, weight, gain: weight * l * (a[0] + b[0] + c[0]) }
    };
    let gain: f64 = (1..last).map(|i| shape(after, i).gain).sum();
    if gain <= 0.0 {
        return;
    }
    let mut from = after[0];
    for i in 1..last {
        let CornerShape { normal: [r, z], weight, .. } = shape(&[from, after[i], after[i + 1]], 1);
        from = after[i];
        let shift = weight * lost / gain;
        after[i] = [after[i][0] + shift * r, after[i][1] + shift * z];
    }
}

fn vector(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [b[0] - a[0], b[1] - a[1]]
}

fn length(v: [f64; 2]) -> f64 {
    libm::hypot(v[0], v[1])
}

/// Returns the cosine of the angle by which the boundary turns at a node.
pub(super) fn turn_cosine([before, own, after]: [[f64; 2]; 3]) -> f64 {
    let (first, second) = (vector(before, own), vector(own, after));
    (first[0] * second[0] + first[1] * second[1]) / (length(first) * length(second))
}

/// Returns whether three nodes of the boundary are on a line, but for rounding.
fn is_straight([before, own, after]: [[f64; 2]; 3]) -> bool {
    let chord = [after[0] - before[0], after[1] - before[1]];
    twice_area([before, own, after]).abs() <= 1e-9 * (chord[0] * chord[0] + chord[1] * chord[1])
}

/// Returns the new place of a node whose motion is prescribed along r or z: it moves only if its neighbours have the
/// same coordinate there.
fn keep(prescribed: [bool; 2], [before, own, after]: [[f64; 2]; 3], place: [f64; 2]) -> [f64; 2] {
    let reach = libm::hypot(after[0] - before[0], after[1] - before[1]);
    let mut new_place = place;
    for i in 0..2 {
        if prescribed[i] {
            let apart = (before[i] - own[i]).abs().max((after[i] - own[i]).abs());
            if apart > 1e-6 * reach {
                return own;
            }
            new_place[i] = own[i];
        }
    }
    new_place
}

#[cfg(test)]
mod tests {
    use super::slide;

    /// The ring volume of the polygon is kept to second order of the small correction, and straight boundaries stay
    /// straight to rounding.
    #[test]
    fn sliding_keeps_lines_and_volumes() {
        let line = slide([[1.0, 2.0], [1.2, 2.0], [2.0, 2.0]], 0.3, 0.8);
        assert!((line[0] - 1.5).abs() < 1e-14 && line[1] == 2.0, "{line:?}");
        let axis = slide([[0.0, 2.0], [0.0, 2.2], [0.0, 4.0]], 0.8, 0.8);
        assert!(axis[0] == 0.0 && (axis[1] - 3.0).abs() < 1e-14, "{axis:?}");
        let [a, b, c] = [[1.0, 0.0], [1.3, 0.05], [2.0, 0.0]];
        let volume = |b: [f64; 2]| {
            let cross = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            cross * (a[0] + b[0] + c[0])
        };
        let moved = slide([a, b, c], 0.2, 0.8);
        assert!((volume(moved) / volume(b) - 1.0).abs() < 1e-3, "{moved:?}");
        assert_eq!(slide([a, [1.3, 0.9], c], 0.2, 0.8), [1.3, 0.9]);
    }
}
