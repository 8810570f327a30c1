//! Monitor for overlaps of bodies, with or without contact between them. It issues warnings and changes no result.

use super::contact::curve::PointCarrier;
use super::{Constraint, StoredConstraint};
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::{Memory, sorted_pair};
use crate::kernel::sorted_boxes::{BoundingBox, SortedBoxes, is_within_body};
use crate::state::EffectId;
use crate::state::archive::{Persist, StateArchive};
use crate::state::dofs::Dofs;
use crate::state::magnitude::AmplitudeClock;

/// Increments between checks. The number is odd so that timed increments contain their share of checks. The cost
/// depends on the number of surface points: in the worst case, thin bodies around each other, well below 1 % of the run
/// time.
const EVERY: u64 = 401;
/// Penetration depth that is tolerated, as a fraction of the face length: chords of curved surfaces that slide on each
/// other overlap slightly.
const FIT: f64 = 0.05;

/// Boundary of a body: points and faces.
#[derive(Clone, Debug, Default, Memory)]
#[memory(uncounted: name)]
pub struct BodyOutline {
    /// Name of the body in warnings.
    pub name: String,
    /// Points of the boundary, each on a node or on a rigid body.
    pub points: Vec<PointCarrier>,
    /// Faces, as indices of two points, that enclose the body; empty if the surface changes or is not closed.
    pub faces: Vec<[u32; 2]>,
    /// Whether the body deforms.
    pub deforms: bool,
    /// Whether the body consists of solid elements, not of rigid lines.
    pub is_solid: bool,
}

impl BodyOutline {
    /// Returns whether this body and another one are checked for overlap: one deforms, one is solid, and one has faces.
    fn is_checked_against(&self, other: &BodyOutline) -> bool {
        (self.deforms || other.deforms)
            && (self.is_solid || other.is_solid)
            && !(self.faces.is_empty() && other.faces.is_empty())
    }
}

/// Contact pairs and ties of bodies.
#[derive(Clone, Debug, Default, Memory)]
pub struct ContactsOfBodies {
    /// Contact pairs of each body, by the side of the pair on which the body is, in ascending order.
    pub pairs: [Vec<Vec<u32>>; 2],
    /// Pairs of tied bodies, each and all in ascending order.
    pub tied: Vec<[u32; 2]>,
}

impl ContactsOfBodies {
    /// Returns whether a contact pair has faces of both bodies, one on each side.
    pub fn connect(&self, [a, b]: [usize; 2]) -> bool {
        let common = |a: &[u32], b: &[u32]| a.iter().any(|pair| b.binary_search(pair).is_ok());
        let [first, second] = &self.pairs;
        common(&first[a], &second[b]) || common(&first[b], &second[a])
    }

    /// Returns whether two bodies are tied to each other.
    pub fn are_tied(&self, bodies: [usize; 2]) -> bool {
        self.tied.binary_search(&sorted_pair(bodies.inline_map(|body| body as u32))).is_ok()
    }
}

/// Check for overlaps of bodies at fixed intervals.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(
    derived: id, outlines, contacts, places, boxes, sorted_boxes, near, order;
    then: OverlapMonitor::check_bodies
)]
#[memory(inside: outlines, places)]
pub struct OverlapMonitor {
    id: EffectId,
    outlines: Vec<BodyOutline>,
    contacts: ContactsOfBodies,
    /// Pairs of bodies whose overlap has been reported, or existed at the start, in ascending order.
    reported: Vec<[u32; 2]>,
    /// Current coordinates of the points of each body.
    places: Vec<Vec<[f64; 2]>>,
    /// Lower and upper corner of the bounding box of each body.
    boxes: Vec<BoundingBox>,
    sorted_boxes: SortedBoxes,
    /// Bodies near another body.
    near: Vec<u32>,
    /// Faces sorted by their lower ends.
    order: Vec<(f64, u32)>,
    /// Whether the first step has begun.
    has_begun: bool,
    /// Overlaps that were found: the two bodies, total time, coordinates, depth and length of the nearest face.
    found: Vec<([u32; 2], [f64; 5])>,
}

impl OverlapMonitor {
    /// Monitors these bodies.
    pub fn new(id: EffectId, outlines: Vec<BodyOutline>, contacts: ContactsOfBodies) -> OverlapMonitor {
        let faces = outlines.iter().map(|o| o.faces.len()).max().unwrap_or(0);
        OverlapMonitor {
            id,
            places: outlines.iter().map(|o| vec![[0.0; 2]; o.points.len()]).collect(),
            boxes: vec![[[0.0; 2]; 2]; outlines.len()],
            sorted_boxes: SortedBoxes::with_capacity(outlines.len()),
            near: Vec::with_capacity(outlines.len()),
            order: Vec::with_capacity(faces),
            has_begun: false,
            found: Vec::with_capacity(outlines.len()),
            reported: Vec::with_capacity(outlines.len()),
            contacts,
            outlines,
        }
    }

    /// Returns the number of pairs of bodies that are checked.
    pub fn count_pairs(outlines: &[BodyOutline]) -> usize {
        // Bodies of one kind are checked against the same others.
        let mut kinds: Vec<(&BodyOutline, usize)> = Vec::new();
        let is_alike = |a: &BodyOutline, b: &BodyOutline| {
            (a.deforms, a.is_solid, a.faces.is_empty()) == (b.deforms, b.is_solid, b.faces.is_empty())
        };
        for outline in outlines {
            match kinds.iter_mut().find(|kind| is_alike(kind.0, outline)) {
                Some(kind) => kind.1 += 1,
                None => kinds.push((outline, 1)),
            }
        }
        let checked = |a: &BodyOutline| kinds.iter().filter(|b| a.is_checked_against(b.0)).map(|b| b.1).sum::<usize>();
        let with_itself = |a: &BodyOutline| usize::from(a.is_checked_against(a));
        kinds.iter().map(|(kind, count)| count * (checked(kind) - with_itself(kind))).sum::<usize>() / 2
    }

    /// Calls `report` for each pair that overlaps and has not been reported yet, and marks the pair as reported. The
    /// values are the coordinates of a point, its depth, and the length of the nearest face.
    fn find_overlaps(&mut self, dofs: &Dofs, mut report: impl FnMut([u32; 2], [f64; 4])) {
        self.update_boxes(dofs);
        let mut near = std::mem::take(&mut self.near);
        for a in 0..self.outlines.len() {
            near.clear();
            self.sorted_boxes.near(self.boxes[a], 0.0, |b| near.extend((b as usize > a).then_some(b)));
            near.sort_unstable();
            for &b in &near {
                let (pair, b) = ([a as u32, b], b as usize);
                if !self.outlines[a].is_checked_against(&self.outlines[b]) {
                    continue;
                }
                let Err(place) = self.reported.binary_search(&pair) else { continue };
                if let Some(found) = self.inside(a, b).or_else(|| self.inside(b, a)) {
                    self.reported.insert(place, pair);
                    report(pair, found);
                }
            }
        }
        self.near = near;
    }

    /// Records the overlaps that have not been reported yet, at a total time.
    fn record_overlaps(&mut self, dofs: &Dofs, time: f64) {
        let mut overlaps = std::mem::take(&mut self.found);
        self.find_overlaps(dofs, |pair, [r, z, depth, length]| overlaps.push((pair, [time, r, z, depth, length])));
        self.found = overlaps;
    }

    /// Updates the places of all points and the boxes of all bodies.
    fn update_boxes(&mut self, dofs: &Dofs) {
        let OverlapMonitor { outlines, places, boxes, .. } = self;
        for ((outline, places), corners) in outlines.iter().zip(places).zip(boxes) {
            *corners = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
            for (place, point) in places.iter_mut().zip(&outline.points) {
                *place = match *point {
                    PointCarrier::Node(n) => dofs.nodes[n].place(),
                    PointCarrier::Body(b, [r, z]) => [r, z + dofs.bodies[b].displacement],
                };
                for i in [0, 1] {
                    (corners[0][i], corners[1][i]) = (corners[0][i].min(place[i]), corners[1][i].max(place[i]));
                }
            }
        }
        self.sorted_boxes.sort(self.boxes.iter().copied().zip(0..));
    }

    /// Returns a point of one body that is inside another one, deeper than the tolerance, with its depth and the length
    /// of the nearest face.
    fn inside(&mut self, of: usize, within: usize) -> Option<[f64; 4]> {
        let OverlapMonitor { outlines, places, boxes, order, .. } = self;
        let face_points = &places[within];
        let faces = &outlines[within].faces;
        let ends = |face: u32| faces[face as usize].inline_map(|p| face_points[p as usize]);
        let mut points = places[of].iter().filter(|p| is_within_body(boxes[within], **p)).peekable();
        if faces.is_empty() || points.peek().is_none() {
            return None;
        }
        order.clear();
        let mut longest: f64 = 0.0;
        for face in 0..faces.len() as u32 {
            let [a, b] = ends(face);
            order.push((a[1].min(b[1]), face));
            longest = longest.max(libm::hypot(b[0] - a[0], b[1] - a[1]));
        }
        order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        points.find_map(|p| {
            let from = order.partition_point(|o| o.0 < p[1] - 2.0 * longest);
            let near = order[from..].iter().take_while(|o| o.0 <= p[1] + longest);
            // Even-odd rule along r.
            let crosses = |face: u32| {
                let [a, b] = ends(face);
                (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
            };
            if near.clone().filter(|o| crosses(o.1)).count() % 2 == 0 {
                return None;
            }
            let depths = near.map(|o| distance(*p, ends(o.1)));
            let (depth, length) = depths.min_by(|a, b| a.0.total_cmp(&b.0))?;
            (depth > FIT * length).then_some([p[0], p[1], depth, length])
        })
    }
}

/// Returns the distance of a point from an edge, and the length of the edge.
pub fn distance(p: [f64; 2], [a, b]: [[f64; 2]; 2]) -> (f64, f64) {
    let (t, d) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let square = t[0] * t[0] + t[1] * t[1];
    let along = ((d[0] * t[0] + d[1] * t[1]) / square).clamp(0.0, 1.0);
    (libm::hypot(d[0] - along * t[0], d[1] - along * t[1]), square.sqrt())
}

impl Constraint for OverlapMonitor {
    fn effect(&self) -> EffectId {
        self.id
    }

    /// Marks overlaps that exist now as reported: an overlap at the start of the analysis has been reported before the
    /// run, or is intended.
    fn begin(&mut self, dofs: &mut Dofs) {
        if !std::mem::replace(&mut self.has_begun, true) {
            self.find_overlaps(dofs, |_, _| {});
        }
    }

    fn motion(&mut self, dofs: &mut Dofs, clock: &AmplitudeClock<'_>, dt: f64) {
        if clock.now.increment.is_multiple_of(EVERY) {
            self.record_overlaps(dofs, clock.now.total_time + dt);
        }
    }
}

impl OverlapMonitor {
    /// Returns the messages of overlaps of bodies that it has found.
    pub fn overlaps(&mut self, dofs: &Dofs, clock: &AmplitudeClock<'_>) -> Vec<String> {
        self.record_overlaps(dofs, clock.now.total_time);
        let warnings = self.found.iter().map(|&(pair, [time, r, z, depth, length])| {
            let bodies = pair.inline_map(|body| body as usize);
            let [a, b] = bodies.inline_map(|body| &self.outlines[body].name);
            let advice = match [self.contacts.are_tied(bodies), self.contacts.connect(bodies)] {
                [true, _] => {
                    "although they are tied: TYPE=SURFACE TO SURFACE of *TIE, the default, and smaller facets reduce the \
                     overlap at the tie"
                }
                [false, true] => {
                    "although contact is defined between them: use smaller facets there, a stiffer pressure-overclosure \
                     relationship, or smaller increments"
                }
                [false, false] => {
                    "and no contact is defined between them: define it (*CONTACT PAIR, or general contact with *CONTACT)"
                }
            };
            format!(
                "{a} and {b} overlap by {depth:.2e} ({:.0} % of a face) at time {time:.4e} near (r = {r:.4e}, z = {z:.4e}), {advice}",
                100.0 * depth / length
            )
        });
        let warnings = warnings.collect();
        self.found.clear();
        warnings
    }

    fn check_bodies(&mut self, archive: &mut StateArchive<'_>) {
        let is_unknown = |body: &u32| *body as usize >= self.outlines.len();
        let pairs = self.found.iter().map(|found| &found.0).chain(&self.reported);
        if pairs.flatten().any(is_unknown) || !self.reported.is_sorted() {
            archive.reject(|| "it contains overlaps of bodies that are not in the deck".into());
            self.found.clear();
            self.reported.clear();
        }
    }
}

impl StoredConstraint for OverlapMonitor {}
