//! Curves of facets that may meet others: their points, what carries them, how facets follow each other, their shape now.
//! Never here: which facets meet, what acts where they do.

use crate::state::archive::{Archive, Persist};

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
    /// What carries it.
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
    /// How far behind a facet something is still in contact with it: half of what the body is thick there.
    pub depth: Vec<f64>,
    /// Whether each is still there.
    pub there: Vec<bool>,
    /// The points, each once, with the facets around each and which of their ends it is.
    pub own: Vec<u32>,
    around: Vec<Vec<(u32, u8)>>,
    /// Shapes at the start of the increment.
    pub shapes: Vec<Shape>,
}

/// A facet at an instant.
#[derive(Clone, Copy, Debug, Default)]
pub struct Shape {
    /// Its first point.
    pub from: [f64; 2],
    /// From the first point to the second.
    pub along: [f64; 2],
    /// Outward unit normal.
    pub normal: [f64; 2],
    /// Length.
    pub length: f64,
}

impl Shape {
    /// The facet between two places.
    #[inline]
    pub fn new(from: [f64; 2], to: [f64; 2]) -> Shape {
        let along = [to[0] - from[0], to[1] - from[1]];
        let length = (along[0] * along[0] + along[1] * along[1]).sqrt();
        Shape { from, along, normal: [along[1] / length, -along[0] / length], length }
    }

    /// The lower and the upper corner of its box.
    #[inline]
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        let to = [self.from[0] + self.along[0], self.from[1] + self.along[1]];
        [[self.from[0].min(to[0]), self.from[1].min(to[1])], [self.from[0].max(to[0]), self.from[1].max(to[1])]]
    }
}

impl Curve {
    /// A curve of facets between points at `places`, which lie on the axis where r is zero.
    pub fn new(facets: Vec<[u32; 2]>, depth: Vec<f64>, places: &[[f64; 2]]) -> Curve {
        let mut own: Vec<u32> = facets.iter().flatten().copied().collect();
        own.sort_unstable();
        own.dedup();
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
            depth,
            there: vec![true; count],
            own,
            around,
            shapes: vec![Shape::default(); count],
            facets,
        };
        curve.join(places);
        curve
    }

    /// Finds what lies beyond each end: of several facets that go on from a point the one that turns least from the way.
    fn join(&mut self, places: &[[f64; 2]]) {
        let way = |facet: [u32; 2]| {
            let [a, b] = facet.map(|p| places[p as usize]);
            Shape::new(a, b)
        };
        for k in 0..self.facets.len() {
            for end in [0, 1] {
                let point = self.facets[k][end];
                let here = way(self.facets[k]);
                let others = self.around(point).filter(|&(j, e)| e as usize != end && self.there[j as usize] && j as usize != k);
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
        for (shape, facet) in self.shapes.iter_mut().zip(&self.facets) {
            let [a, b] = facet.map(|p| places[p as usize]);
            *shape = Shape::new(a, b);
        }
    }

    /// Bytes of the arrays.
    pub fn bytes(&self) -> usize {
        let each = size_of::<[u32; 2]>() + size_of::<[Beyond; 2]>() + size_of::<f64>() + 1 + size_of::<Shape>();
        let of_point = size_of::<u32>() + size_of::<Vec<(u32, u8)>>() + 2 * size_of::<(u32, u8)>();
        each * self.facets.capacity() + of_point * self.own.capacity()
    }
}

impl Persist for Curve {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Curve { facets: _, beyond: _, depth: _, there, own: _, around: _, shapes: _ } = self;
        there.as_mut_slice().persist(archive);
    }
}
