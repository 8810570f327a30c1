//! Curves of facets that may meet others: their points, what carries them, how facets follow each other, their shape now, and
//! what of them comes and goes as elements are deleted.
//! Never here: which facets meet, what acts where they do.

use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::MemoryUse;
use crate::kernel::lists::sorted_unique;
use crate::kernel::topology::ElementNodes;
use crate::state::archive::{Archive, Persist, persist_struct};

/// What carries a point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Carrier {
    /// A node of what deforms.
    Node(usize),
    /// A rigid body, from this place at the start.
    Body(usize, [f64; 2]),
}

/// A point of contact surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    pub carrier: Carrier,
    /// Whether it moves freely along r and z: no condition prescribes it.
    pub free: [bool; 2],
}

/// What follows a facet at one of its ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Beyond {
    /// Another facet of the curve.
    Facet(u32),
    /// The axis of symmetry: the surface goes on there as its own image.
    Axis,
    /// Nothing: the surface ends.
    Nothing,
}

/// Facets one after the other, each with the body to the left of the way along it.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// The two points of each, as indices into those of the contact.
    pub facets: Vec<[u32; 2]>,
    /// What lies beyond the first and the second.
    pub beyond: Vec<[Beyond; 2]>,
    /// How far in front of its facets the surface lies: half the thickness of shells.
    pub lift: Vec<f64>,
    /// How far behind a facet something is still in contact with it: half of what the body is thick there.
    pub depth: Vec<f64>,
    /// Whether each lies bare. Where elements can be deleted, faces between two of them are facets from the start, one for each
    /// side, which become bare when the element in front goes.
    pub there: Vec<bool>,
    /// Whether the element behind each is still there.
    behind: Vec<bool>,
    /// The points, each once, with the facets around each and which of their ends it is.
    pub own: Vec<u32>,
    around: Vec<Vec<(u32, u8)>>,
    /// Those facets that lie bare, as they follow each other.
    pub bare: Vec<u32>,
    /// Indices among the own points of those that bare facets have, in the same order, and of those that no element has, or none any
    /// more.
    pub bare_own: Vec<u32>,
    /// See there; none where they meet nothing any more.
    pub orphans: Vec<u32>,
    drops_orphans: bool,
    /// Indices among the own points of tips: where the curve ends in a point on the axis.
    tips: Vec<u32>,
    /// Shapes at the start of the increment, of facets that lie bare.
    pub shapes: Vec<Shape>,
    /// What has been put in order so far.
    ordered: Vec<bool>,
}

/// A facet at an instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shape {
    pub from: [f64; 2],
    /// From the first point to the second.
    pub along: [f64; 2],
    pub normal: [f64; 2],
    pub length: f64,
}

impl Shape {
    #[inline]
    pub fn new(from: [f64; 2], to: [f64; 2]) -> Shape {
        let along = [to[0] - from[0], to[1] - from[1]];
        let length = (along[0] * along[0] + along[1] * along[1]).sqrt();
        Shape { from, along, normal: [along[1] / length, -along[0] / length], length }
    }

    /// Whether a place lies on its outer side.
    #[inline]
    pub fn in_front(&self, place: [f64; 2]) -> bool {
        (place[0] - self.from[0]) * self.normal[0] + (place[1] - self.from[1]) * self.normal[1] > 0.0
    }

    /// The lower and the upper corner of its box.
    #[inline]
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        let to = [self.from[0] + self.along[0], self.from[1] + self.along[1]];
        [[self.from[0].min(to[0]), self.from[1].min(to[1])], [self.from[0].max(to[0]), self.from[1].max(to[1])]]
    }
}

/// The sine of the angle to the plane across the axis above which a point there is a tip.
const SHARP: f64 = 0.29;

impl Curve {
    /// A curve of facets between points at `places`, which lie on the axis where r is zero. Those of the facets from `bare` on are
    /// hidden at the start.
    pub fn new(facets: Vec<[u32; 2]>, depth: Vec<f64>, bare: usize, places: &[[f64; 2]]) -> Curve {
        let own: Vec<u32> = sorted_unique(facets.iter().flatten().copied());
        let mut around = vec![Vec::new(); own.len()];
        for (k, facet) in facets.iter().enumerate() {
            for (end, point) in facet.iter().enumerate() {
                if let Ok(at) = own.binary_search(point) {
                    around[at].push((k as u32, end as u8));
                }
            }
        }
        let count = facets.len();
        let mut curve = Curve {
            beyond: vec![[Beyond::Nothing; 2]; count],
            lift: vec![0.0; count],
            depth,
            there: (0..count).map(|k| k < bare).collect(),
            behind: vec![true; count],
            bare: Vec::with_capacity(count),
            bare_own: Vec::with_capacity(own.len()),
            orphans: Vec::with_capacity(if bare < count { own.len() } else { 0 }),
            tips: Vec::new(),
            drops_orphans: false,
            own,
            around,
            shapes: vec![Shape::default(); count],
            ordered: Vec::with_capacity(2 * count),
            facets,
        };
        curve.list();
        curve.join(places);
        curve.find_tips(places);
        curve
    }

    /// Points without facets, ascending.
    pub fn of_points(points: Vec<u32>) -> Curve {
        let mut curve = Curve::new(Vec::new(), Vec::new(), 0, &[]);
        (curve.around, curve.own) = (vec![Vec::new(); points.len()], points);
        curve.list();
        curve
    }

    /// Tips are points on the axis from which the surface rises behind them. The hats of what they meet see them late: they meet
    /// by themselves, too.
    fn find_tips(&mut self, places: &[[f64; 2]]) {
        for &k in &self.bare {
            for end in [0, 1] {
                let point = self.facets[k as usize][end];
                if self.beyond[k as usize][end] != Beyond::Axis {
                    continue;
                }
                let [a, b] = self.facets[k as usize].inline_map(|p| places[p as usize]);
                let shape = Shape::new(a, b);
                let rises = if end == 0 { shape.along[1] } else { -shape.along[1] } / shape.length;
                if rises.abs() > SHARP
                    && rises * shape.normal[1] < 0.0
                    && let Ok(at) = self.own.binary_search(&point)
                {
                    self.tips.push(at as u32);
                }
            }
        }
    }

    /// Whether some of its points may meet what they meet by themselves.
    pub fn has_loose_points(&self) -> bool {
        self.bare.len() < self.facets.len() || !self.tips.is_empty()
    }

    /// Points that meet the other surface by themselves, as indices among the own ones: orphans, then tips whose facet is there.
    pub fn loose(&self) -> impl Iterator<Item = u32> + '_ {
        let there = |i: &&u32| self.around[**i as usize].iter().any(|f| self.there[f.0 as usize]);
        self.orphans.iter().chain(self.tips.iter().filter(there)).copied()
    }

    /// Lets points that no element has any more meet nothing.
    pub fn drop_orphans(&mut self) {
        self.drops_orphans = true;
    }

    /// The same of shells, whose surface lies in front of the facets.
    pub fn lifted(mut self, lift: Vec<f64>) -> Curve {
        self.lift = lift;
        self
    }

    /// The largest lift of its facets.
    pub fn highest(&self) -> f64 {
        self.lift.iter().copied().fold(0.0, f64::max)
    }

    /// Goes on with what a curve of the same facets has of them by now.
    pub fn take_over(&mut self, previous: &Curve) {
        self.there.clone_from(&previous.there);
        self.behind.clone_from(&previous.behind);
        self.beyond.clone_from(&previous.beyond);
        self.list();
        self.order();
    }

    pub fn list(&mut self) {
        let Curve { there, behind, own, around, bare, bare_own, orphans, drops_orphans, .. } = self;
        bare.clear();
        bare.extend((0..there.len() as u32).filter(|k| there[*k as usize]));
        bare_own.clear();
        bare_own.extend((0..own.len() as u32).filter(|i| around[*i as usize].iter().any(|f| there[f.0 as usize])));
        orphans.clear();
        let left = |i: &u32| around[*i as usize].iter().all(|f| !behind[f.0 as usize]);
        if !*drops_orphans && (behind.is_empty() || behind.contains(&false)) {
            orphans.extend((0..own.len() as u32).filter(left));
        }
    }

    fn facet(&self, from: u32, to: u32) -> Option<usize> {
        let at = self.own.binary_search(&from).ok()?;
        let found = self.around[at].iter().find(|(k, end)| *end == 0 && self.facets[*k as usize][1] == to);
        found.map(|f| f.0 as usize)
    }

    /// Elements with these boundaries, counter-clockwise, are deleted: their facets go, those of elements beside them are exposed.
    /// Returns whether anything of the curve has changed.
    pub fn release(&mut self, deleted: impl Iterator<Item = ElementNodes> + Clone) -> bool {
        let edges = || deleted.clone().flat_map(ElementNodes::sides);
        let mut changed = false;
        for [a, b] in edges() {
            if let Some(k) = self.facet(a, b) {
                changed |= self.behind[k];
                (self.there[k], self.behind[k]) = (false, false);
            }
        }
        for [a, b] in edges() {
            if let Some(k) = self.facet(b, a).filter(|k| self.behind[*k] && changed) {
                self.there[k] = true;
            }
        }
        changed
    }

    /// Puts bare facets and their points in the order in which they follow each other, so that what meets is near in number.
    fn order(&mut self) {
        let Curve { facets, beyond, own, bare, bare_own, ordered, there, .. } = self;
        ordered.clear();
        ordered.resize(facets.len(), false);
        bare.clear();
        let begins = |k: &usize| !matches!(beyond[*k][0], Beyond::Facet(_));
        let all = || (0..facets.len()).filter(|k| there[*k]);
        for first in all().filter(begins).chain(all()) {
            let mut next = Some(first);
            while let Some(k) = next.filter(|k| !std::mem::replace(&mut ordered[*k], true)) {
                bare.push(k as u32);
                next = match beyond[k][1] {
                    Beyond::Facet(j) => Some(j as usize),
                    _ => None,
                };
            }
        }
        ordered.clear();
        ordered.resize(own.len(), false);
        bare_own.clear();
        for point in bare.iter().flat_map(|k| facets[*k as usize]) {
            if let Ok(at) = own.binary_search(&point)
                && !std::mem::replace(&mut ordered[at], true)
            {
                bare_own.push(at as u32);
            }
        }
    }

    /// Finds what lies beyond each end: of several facets that go on from a point the one that turns least from the way.
    pub fn join(&mut self, places: &[[f64; 2]]) {
        let way = |facet: [u32; 2]| {
            let [a, b] = facet.inline_map(|p| places[p as usize]);
            Shape::new(a, b)
        };
        for at in 0..self.bare.len() {
            let k = self.bare[at] as usize;
            for end in [0, 1] {
                let point = self.facets[k][end];
                let here = way(self.facets[k]);
                let others =
                    self.around(point).filter(|&(j, e)| e as usize != end && self.there[j as usize] && j as usize != k);
                let turn = |j: u32| {
                    let next = way(self.facets[j as usize]);
                    -(here.normal[0] * next.normal[0] + here.normal[1] * next.normal[1])
                };
                let next = others.map(|(j, _)| (turn(j), j)).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
                self.beyond[k][end] = match next {
                    Some((_, j)) => Beyond::Facet(j),
                    None if places[point as usize][0] == 0.0 => Beyond::Axis,
                    None => Beyond::Nothing,
                };
            }
        }
        self.order();
    }

    /// The facets around a point, and which of their ends it is.
    pub fn around(&self, point: u32) -> impl Iterator<Item = (u32, u8)> + '_ {
        let at = self.own.binary_search(&point);
        at.into_iter().flat_map(|at| self.around[at].iter().copied())
    }

    /// The facets around the point of an index among the curve's own.
    #[inline]
    pub fn around_own(&self, index: usize) -> &[(u32, u8)] {
        &self.around[index]
    }

    /// Takes the shapes of facets between points at these places.
    pub fn shape(&mut self, places: &[[f64; 2]]) {
        for &k in &self.bare {
            let [a, b] = self.facets[k as usize].inline_map(|p| places[p as usize]);
            self.shapes[k as usize] = Shape::new(a, b);
        }
    }

    /// Area of the hat function of the point of an index among the curve's own, over the surface of revolution.
    pub fn area(&self, index: usize, places: &[[f64; 2]]) -> f64 {
        let own = self.around[index].iter().filter(|f| self.there[f.0 as usize]);
        let of = |&(k, end): &(u32, u8)| {
            let radii = self.facets[k as usize].inline_map(|p| places[p as usize][0]);
            let (here, there) = (radii[end as usize], radii[1 - end as usize]);
            std::f64::consts::TAU * self.shapes[k as usize].length * (2.0 * here + there) / 6.0
        };
        own.map(of).sum()
    }

    /// How far in front of the point of an index among the curve's own the surface lies, in the mean of all facets there ever are.
    pub fn lift_of(&self, index: usize) -> f64 {
        let around = &self.around[index];
        let sum: f64 = around.iter().map(|f| self.lift[f.0 as usize]).sum();
        sum / around.len().max(1) as f64
    }

    /// Memory of the arrays.
    pub fn memory(&self) -> MemoryUse {
        let of_facets = MemoryUse::of(&self.facets)
            + MemoryUse::of(&self.beyond)
            + MemoryUse::of(&self.lift)
            + MemoryUse::of(&self.depth)
            + MemoryUse::of(&self.there)
            + MemoryUse::of(&self.behind)
            + MemoryUse::of(&self.bare)
            + MemoryUse::of(&self.shapes)
            + MemoryUse::of(&self.ordered);
        let of_points = MemoryUse::of(&self.own) + MemoryUse::of(&self.bare_own) + MemoryUse::of(&self.orphans);
        let around = MemoryUse::of(&self.around) + self.around.iter().map(MemoryUse::of).sum();
        of_facets + of_points + around + MemoryUse::of(&self.tips)
    }
}

impl Persist for Beyond {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let mut code = match *self {
            Beyond::Facet(k) => k,
            Beyond::Axis => u32::MAX,
            Beyond::Nothing => u32::MAX - 1,
        };
        code.persist(archive);
        *self = match code {
            u32::MAX => Beyond::Axis,
            code if code == u32::MAX - 1 => Beyond::Nothing,
            k => Beyond::Facet(k),
        };
    }
}

persist_struct!(Curve { there: fixed, behind: fixed, beyond: fixed } derived {
    facets, lift, depth, own, around, bare, bare_own, orphans, drops_orphans, tips, shapes, ordered
} then Curve::list_again);

impl Curve {
    /// What lies bare follows from what has been read.
    fn list_again(&mut self, archive: &mut Archive<'_>) {
        if archive.reads() {
            self.list();
            self.order();
        }
    }
}
