//! Monitor for overlaps of bodies, with or without contact between them. It issues warnings and changes no result.

use super::contact::curve::PointCarrier;
use super::{Constraint, ConstraintUpkeep, StoredConstraint};
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::MemoryUse;
use crate::state::EffectId;
use crate::state::archive::{StateArchive, persist_struct};
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
#[derive(Clone, Debug)]
pub struct BodyOutline {
    /// Name of the body in warnings.
    pub name: String,
    /// Points of the boundary, each on a node or on a rigid body.
    pub points: Vec<PointCarrier>,
    /// Faces, as indices of two points, that enclose the body; empty if the surface changes or is not closed.
    pub faces: Vec<[u32; 2]>,
}

/// Two bodies that should not overlap.
#[derive(Clone, Debug)]
struct BodyPair {
    bodies: [usize; 2],
    /// Whether contact is defined between the two bodies.
    in_contact: bool,
    /// Whether the overlap has been reported, or existed at the start.
    is_reported: bool,
}

/// Check for overlaps of pairs of bodies at fixed intervals.
#[derive(Clone, Debug)]
pub struct OverlapMonitor {
    id: EffectId,
    outlines: Vec<BodyOutline>,
    /// Pairs of bodies that are checked.
    pairs: Vec<BodyPair>,
    /// Current coordinates of the points of each body.
    places: Vec<Vec<[f64; 2]>>,
    /// Lower and upper corner of the bounding box of each body.
    boxes: Vec<[[f64; 2]; 2]>,
    /// Faces sorted by their lower ends.
    order: Vec<(f64, u32)>,
    /// Whether the first step has begun.
    has_begun: bool,
    /// Overlaps that were found: index of the pair, total time, coordinates, depth and length of the nearest face.
    found: Vec<(u32, [f64; 5])>,
}

impl OverlapMonitor {
    /// Monitors these pairs of bodies, each with whether contact is defined between them.
    pub fn new(id: EffectId, outlines: Vec<BodyOutline>, pairs: Vec<([usize; 2], bool)>) -> OverlapMonitor {
        let faces = outlines.iter().map(|o| o.faces.len()).max().unwrap_or(0);
        OverlapMonitor {
            id,
            places: outlines.iter().map(|o| vec![[0.0; 2]; o.points.len()]).collect(),
            boxes: vec![[[0.0; 2]; 2]; outlines.len()],
            order: Vec::with_capacity(faces),
            has_begun: false,
            found: Vec::with_capacity(pairs.len()),
            pairs: pairs
                .into_iter()
                .map(|(bodies, in_contact)| BodyPair { bodies, in_contact, is_reported: false })
                .collect(),
            outlines,
        }
    }

    /// Calls `report` for each pair that overlaps and has not been reported yet, and marks the pair as reported. The
    /// values are the coordinates of a point, its depth, and the length of the nearest face.
    fn find_overlaps(&mut self, dofs: &Dofs, mut report: impl FnMut(u32, [f64; 4])) {
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
        for at in 0..self.pairs.len() {
            let BodyPair { bodies: [a, b], is_reported: is_settled, .. } = self.pairs[at];
            let meets =
                (0..2).all(|i| self.boxes[a][0][i] < self.boxes[b][1][i] && self.boxes[b][0][i] < self.boxes[a][1][i]);
            if is_settled || !meets {
                continue;
            }
            if let Some(found) = self.inside(a, b).or_else(|| self.inside(b, a)) {
                self.pairs[at].is_reported = true;
                report(at as u32, found);
            }
        }
    }

    /// Returns a point of one body that is inside another one, deeper than the tolerance, with its depth and the length
    /// of the nearest face.
    fn inside(&mut self, of: usize, within: usize) -> Option<[f64; 4]> {
        let OverlapMonitor { outlines, places, boxes, order, .. } = self;
        let ([low, high], at) = (boxes[within], &places[within]);
        let faces = &outlines[within].faces;
        let ends = |face: u32| faces[face as usize].inline_map(|p| at[p as usize]);
        let mut points = places[of].iter().filter(|p| (0..2).all(|i| low[i] < p[i] && p[i] < high[i])).peekable();
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
    let at = ((d[0] * t[0] + d[1] * t[1]) / square).clamp(0.0, 1.0);
    (libm::hypot(d[0] - at * t[0], d[1] - at * t[1]), square.sqrt())
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
            let (mut found, time) = (std::mem::take(&mut self.found), clock.now.total_time + dt);
            self.find_overlaps(dofs, |pair, [r, z, depth, length]| found.push((pair, [time, r, z, depth, length])));
            self.found = found;
        }
    }

    fn upkeep(&mut self) -> Option<&mut dyn ConstraintUpkeep> {
        Some(self)
    }
}

impl ConstraintUpkeep for OverlapMonitor {
    fn overlaps(&mut self, dofs: &Dofs, clock: &AmplitudeClock<'_>) -> Vec<String> {
        let (mut found, time) = (std::mem::take(&mut self.found), clock.now.total_time);
        self.find_overlaps(dofs, |pair, [r, z, depth, length]| found.push((pair, [time, r, z, depth, length])));
        let warnings = found.iter().map(|&(pair, [time, r, z, depth, length])| {
            let BodyPair { bodies, in_contact, .. } = self.pairs[pair as usize];
            let [a, b] = bodies.inline_map(|body| &self.outlines[body].name);
            let cause = match in_contact {
                true => {
                    "although contact is defined between them: use smaller facets there, a stiffer pressure-overclosure \
                     relationship, or smaller increments"
                }
                false => {
                    "and no contact is defined between them: define it (*CONTACT PAIR, or general contact with *CONTACT)"
                }
            };
            format!(
                "{a} and {b} overlap by {depth:.2e} ({:.0} % of a face) at time {time:.4e} near (r = {r:.4e}, z = {z:.4e}), {cause}",
                100.0 * depth / length
            )
        });
        let warnings = warnings.collect();
        found.clear();
        self.found = found;
        warnings
    }
}

impl StoredConstraint for OverlapMonitor {
    fn memory(&self) -> MemoryUse {
        let of_outline = |o: &BodyOutline| MemoryUse::of(&o.points) + MemoryUse::of(&o.faces);
        self.outlines.iter().map(of_outline).sum::<MemoryUse>()
            + self.places.iter().map(MemoryUse::of).sum()
            + MemoryUse::of(&self.boxes)
            + MemoryUse::of(&self.order)
            + MemoryUse::of(&self.found)
            + MemoryUse::of(&self.pairs)
    }
}

persist_struct!(OverlapMonitor { pairs: fixed, has_begun, found } derived { id, outlines, places, boxes, order } then OverlapMonitor::check_found);

persist_struct!(BodyPair { is_reported } derived { bodies, in_contact });

impl OverlapMonitor {
    fn check_found(&mut self, archive: &mut StateArchive<'_>) {
        if self.found.len() > self.pairs.len() || self.found.iter().any(|f| f.0 as usize >= self.pairs.len()) {
            archive.reject(|| "it contains overlaps of bodies that are not in the deck".into());
            self.found.clear();
        }
    }
}
