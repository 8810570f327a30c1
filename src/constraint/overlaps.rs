//! Bodies between which nothing acts: whether they come to lie in each other. It is told, and changes nothing.
//! Never here: contact; how bodies lie at the start.

use super::contact::curve::Carrier;
use super::{Constraint, ConstraintUpkeep, StoredConstraint};
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::MemoryUse;
use crate::state::EffectId;
use crate::state::archive::{Archive, persist_struct};
use crate::state::dofs::Dofs;
use crate::state::magnitude::Clock;

/// Increments from one look to the next, odd so that those that are timed have their share of looks. What a look costs goes with the
/// outside of the bodies alone: in the worst case, thin bodies one around the other, well below a hundredth of the run.
const EVERY: u64 = 401;
/// Part of a face by which a point may lie behind it: chords of curved surfaces that slide on each other.
const FIT: f64 = 0.1;

/// The outside of a body.
#[derive(Clone, Debug)]
pub struct Outline {
    pub name: String,
    pub points: Vec<Carrier>,
    /// Faces between them that enclose the body; none where what encloses it changes, or nothing does.
    pub faces: Vec<[u32; 2]>,
}

/// Two bodies between which nothing acts.
#[derive(Clone, Debug)]
struct BodyPair {
    bodies: [usize; 2],
    /// Whether their overlap has been reported.
    is_settled: bool,
}

/// A look at bodies now and then.
#[derive(Clone, Debug)]
pub struct Overlaps {
    id: EffectId,
    outlines: Vec<Outline>,
    /// Bodies between which nothing acts.
    pairs: Vec<BodyPair>,
    /// Places of the points of each.
    places: Vec<Vec<[f64; 2]>>,
    /// Lower and upper corner of each.
    boxes: Vec<[[f64; 2]; 2]>,
    /// Faces by their lower ends.
    order: Vec<(f64, u32)>,
    /// What was found: the pair, total time and place.
    found: Vec<(u32, [f64; 3])>,
}

impl Overlaps {
    /// Looks at these bodies, two by two.
    pub fn new(id: EffectId, outlines: Vec<Outline>, pairs: Vec<[usize; 2]>) -> Overlaps {
        let faces = outlines.iter().map(|o| o.faces.len()).max().unwrap_or(0);
        Overlaps {
            id,
            places: outlines.iter().map(|o| vec![[0.0; 2]; o.points.len()]).collect(),
            boxes: vec![[[0.0; 2]; 2]; outlines.len()],
            order: Vec::with_capacity(faces),
            found: Vec::with_capacity(pairs.len()),
            pairs: pairs.into_iter().map(|bodies| BodyPair { bodies, is_settled: false }).collect(),
            outlines,
        }
    }

    /// Pairs that lie in each other now and have not been settled are, with a place of each.
    fn look(&mut self, dofs: &Dofs, mut tell: impl FnMut(u32, [f64; 2])) {
        let Overlaps { outlines, places, boxes, .. } = self;
        for ((outline, places), corners) in outlines.iter().zip(places).zip(boxes) {
            *corners = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
            for (place, point) in places.iter_mut().zip(&outline.points) {
                *place = match *point {
                    Carrier::Node(n) => dofs.nodes[n].place(),
                    Carrier::Body(b, [r, z]) => [r, z + dofs.bodies[b].displacement],
                };
                for i in [0, 1] {
                    (corners[0][i], corners[1][i]) = (corners[0][i].min(place[i]), corners[1][i].max(place[i]));
                }
            }
        }
        for at in 0..self.pairs.len() {
            let BodyPair { bodies: [a, b], is_settled } = self.pairs[at];
            let meets =
                (0..2).all(|i| self.boxes[a][0][i] < self.boxes[b][1][i] && self.boxes[b][0][i] < self.boxes[a][1][i]);
            if is_settled || !meets {
                continue;
            }
            if let Some(place) = self.inside(a, b).or_else(|| self.inside(b, a)) {
                self.pairs[at].is_settled = true;
                tell(at as u32, place);
            }
        }
    }

    /// A point of one body within another, further behind its faces than what fits.
    fn inside(&mut self, of: usize, within: usize) -> Option<[f64; 2]> {
        let Overlaps { outlines, places, boxes, order, .. } = self;
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
        points.copied().find(|p| {
            let from = order.partition_point(|o| o.0 < p[1] - 2.0 * longest);
            let near = order[from..].iter().take_while(|o| o.0 <= p[1] + longest);
            // The even-odd rule along r.
            let crosses = |face: u32| {
                let [a, b] = ends(face);
                (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
            };
            let deep = |face: u32| {
                let (distance, length) = distance(*p, ends(face));
                distance > FIT * length
            };
            near.clone().filter(|o| crosses(o.1)).count() % 2 == 1 && near.clone().all(|o| deep(o.1))
        })
    }
}

/// Distance of a point from an edge, and the length of that.
pub fn distance(p: [f64; 2], [a, b]: [[f64; 2]; 2]) -> (f64, f64) {
    let (t, d) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let square = t[0] * t[0] + t[1] * t[1];
    let at = ((d[0] * t[0] + d[1] * t[1]) / square).clamp(0.0, 1.0);
    (libm::hypot(d[0] - at * t[0], d[1] - at * t[1]), square.sqrt())
}

impl Constraint for Overlaps {
    fn effect(&self) -> EffectId {
        self.id
    }

    /// What lies in each other when the step begins has been told, or is meant.
    fn begin(&mut self, dofs: &mut Dofs) {
        self.look(dofs, |_, _| {});
    }

    fn motion(&mut self, dofs: &mut Dofs, clock: &Clock<'_>, dt: f64) {
        if clock.now.increment.is_multiple_of(EVERY) {
            let (mut found, time) = (std::mem::take(&mut self.found), clock.now.total_time + dt);
            self.look(dofs, |pair, [r, z]| found.push((pair, [time, r, z])));
            self.found = found;
        }
    }

    fn upkeep(&mut self) -> Option<&mut dyn ConstraintUpkeep> {
        Some(self)
    }
}

impl ConstraintUpkeep for Overlaps {
    fn warnings(&mut self, dofs: &Dofs, clock: &Clock<'_>) -> Vec<String> {
        let (mut found, time) = (std::mem::take(&mut self.found), clock.now.total_time);
        self.look(dofs, |pair, [r, z]| found.push((pair, [time, r, z])));
        let warnings = found.iter().map(|&(pair, [time, r, z])| {
            let [a, b] = self.pairs[pair as usize].bodies.inline_map(|body| &self.outlines[body].name);
            format!(
                "{a} and {b} lie in each other, noticed at time {time:.4e} near (r = {r:.4e}, z = {z:.4e}), and nothing acts between \
                 them: let them meet (*CONTACT PAIR, or *CONTACT with all that is outside)"
            )
        });
        let warnings = warnings.collect();
        found.clear();
        self.found = found;
        warnings
    }
}

impl StoredConstraint for Overlaps {
    fn memory(&self) -> MemoryUse {
        let of_outline = |o: &Outline| MemoryUse::of(&o.points) + MemoryUse::of(&o.faces);
        self.outlines.iter().map(of_outline).sum::<MemoryUse>()
            + self.places.iter().map(MemoryUse::of).sum()
            + MemoryUse::of(&self.boxes)
            + MemoryUse::of(&self.order)
            + MemoryUse::of(&self.found)
            + MemoryUse::of(&self.pairs)
    }
}

persist_struct!(Overlaps { pairs: fixed, found } derived { id, outlines, places, boxes, order } then Overlaps::check_found);

persist_struct!(BodyPair { is_settled } derived { bodies });

impl Overlaps {
    fn check_found(&mut self, archive: &mut Archive<'_>) {
        if self.found.len() > self.pairs.len() || self.found.iter().any(|f| f.0 as usize >= self.pairs.len()) {
            archive.refuse(|| "pairs of bodies overlap that the deck does not have".into());
            self.found.clear();
        }
    }
}
