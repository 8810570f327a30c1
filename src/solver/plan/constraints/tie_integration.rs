//! Integration of `*TIE` over the common surface. The displacements of both surfaces are equal in the weighted means
//! `∫ ψ_i (u_1 - u_2) 2πr ds = 0`.
//!
//! The weights ψ_i are the dual functions of the hat functions of the surface with more nodes on the common surface, so
//! that each of its nodes follows nodes of the other surface (mortar method with dual multipliers; Wohlmuth 2000, SIAM J.
//! Numer. Anal. 38, 989). Facets are divided where the opposite facet changes, and the integrals are exact.

use std::collections::{HashMap, HashSet};

use indexmap::IndexMap;

use crate::model::{Model, SurfaceTie};
use crate::plan::constraints::surface_ties::{AttachedNode, Facet, MasterSurface, facets_of, length};
use crate::plan::constraints::tie_equations::{NextNode, TiedNode};

/// A part of a slave facet and the part of the master facet that is opposite: ranges of the coordinates from 0 to 1 on
/// both.
#[derive(Clone, Copy, Debug)]
struct Piece {
    facets: [usize; 2],
    ranges: [[f64; 2]; 2],
}

/// A Gauss point of the common surface: facet and coordinate on the slave and on the master surface, and its area per
/// radian.
#[derive(Clone, Copy, Debug)]
struct GaussPoint {
    facets: [usize; 2],
    coordinates: [f64; 2],
    area: f64,
}

/// The two surfaces of a tie. Side 0 is the slave surface, side 1 the master surface.
pub struct TiedPair<'a> {
    model: &'a Model,
    tie: &'a SurfaceTie,
    facets: [Vec<Facet>; 2],
    master: MasterSurface<'a>,
    /// Slave nodes within the tolerance.
    attached: HashSet<usize>,
    /// Nodes of both surfaces.
    shared: HashSet<usize>,
    /// Nodes of the master surface that belong to one of its facets only.
    ends: HashSet<usize>,
}

/// Part of a master facet that must be opposite the slave surface, so that the nodes of the facet can be dependent.
const COVERED: f64 = 0.95;
/// Weights and lengths that are smaller, relative to 1, are rounding errors.
const ROUNDING: f64 = 1e-10;
/// Coordinate of the two Gauss points on the interval from -1 to 1.
const GAUSS: f64 = 0.577_350_269_189_625_8;

impl TiedPair<'_> {
    pub fn new<'a>(model: &'a Model, tie: &'a SurfaceTie, attached: &[AttachedNode]) -> TiedPair<'a> {
        let master = MasterSurface::new(model, tie);
        let facets = [facets_of(model, &tie.slave_faces), master.facets.clone()];
        let shared = attached.iter().filter(|a| a.is_shared).map(|a| a.node).collect();
        let mut ends = HashSet::new();
        for node in facets[1].iter().flat_map(|f| f.nodes) {
            if !ends.remove(&node) {
                ends.insert(node);
            }
        }
        TiedPair { model, tie, facets, master, attached: attached.iter().map(|a| a.node).collect(), shared, ends }
    }

    /// Returns the nodes of both surfaces.
    pub fn nodes(&self) -> impl Iterator<Item = usize> {
        self.tie.slaves.iter().copied().chain(self.facets[1].iter().flat_map(|f| f.nodes))
    }

    /// Returns the equations; `None` if the surfaces have no common part.
    pub fn equations(&self, taken: &HashSet<usize>) -> Option<Vec<TiedNode>> {
        let points = self.gauss_points();
        let candidates = [0, 1].map(|side| self.dependent_nodes(side, &points, taken));
        let side = self.dependent_side(&candidates);
        let rows = self.weights(side, &candidates[side], &points);
        (!rows.is_empty()).then(|| self.tied_nodes(side, rows))
    }

    /// Chooses the surface whose nodes are dependent: that of cohesive elements, whose nodes may have no mass, or else that
    /// with more nodes on the common surface.
    fn dependent_side(&self, candidates: &[HashSet<usize>; 2]) -> usize {
        let is_cohesive = |f: &Facet| self.model.mesh.elements[f.element].kind.is_cohesive();
        match [0, 1].map(|side: usize| self.facets[side].iter().all(is_cohesive)) {
            [true, false] => 0,
            [false, true] => 1,
            _ => usize::from(candidates[1].len() > candidates[0].len()),
        }
    }

    fn places(&self, side: usize, facet: usize) -> [[f64; 2]; 2] {
        self.facets[side][facet].nodes.map(|n| self.model.mesh.points[n])
    }

    /// Returns the Gauss points of all pieces, two for each piece.
    fn gauss_points(&self) -> Vec<GaussPoint> {
        let mut points = Vec::new();
        for (slave, facet) in self.facets[0].iter().enumerate() {
            let ([a, b], length) = (self.places(0, slave), length(self.model, facet));
            for Piece { facets, ranges } in self.pieces(slave) {
                let [from, to] = ranges[0];
                for part in [0.5 - 0.5 * GAUSS, 0.5 + 0.5 * GAUSS] {
                    let coordinates = ranges.map(|[from, to]| from + part * (to - from));
                    let r = a[0] + coordinates[0] * (b[0] - a[0]);
                    points.push(GaussPoint { facets, coordinates, area: 0.5 * (to - from) * length * r });
                }
            }
        }
        points
    }

    /// Divides a slave facet into pieces with one nearest master facet each. A facet with an untied node is tied where it is
    /// opposite the master surface within the tolerance.
    fn pieces(&self, slave: usize) -> Vec<Piece> {
        let is_whole = self.facets[0][slave].nodes.iter().all(|n| self.attached.contains(n));
        if !is_whole && self.tie.chosen.is_some() {
            return Vec::new();
        }
        let tolerance = self.master.tolerance(self.tie);
        let facing = self.facing_facets(slave, if is_whole { None } else { Some(tolerance) });
        let piece = |range: &[f64]| {
            let (from, end) = (range[0], range[1]);
            let middle = 0.5 * (from + end);
            let nearest = facing.iter().min_by(|f, g| f.distance(middle).total_cmp(&g.distance(middle)))?;
            let is_tied = is_whole || nearest.distance(middle) <= tolerance && self.is_opposite(nearest, middle);
            let opposite = [from, end].map(|s| nearest.along(s).clamp(0.0, 1.0));
            is_tied.then_some(Piece { facets: [slave, nearest.facet], ranges: [[from, end], opposite] })
        };
        let is_long = |range: &&[f64]| range[1] - range[0] > ROUNDING;
        self.cuts(&facing).windows(2).filter(is_long).filter_map(piece).collect()
    }

    /// Returns the master facets that are nearest to any point of a slave facet, or all within `margin`.
    fn facing_facets(&self, slave: usize, margin: Option<f64>) -> Vec<FacingFacet> {
        let (slave_places, facet) = (self.places(0, slave), self.facets[0][slave]);
        let margin = margin.unwrap_or_else(|| {
            let distance = |&n: &usize| self.master.nearest(n).map_or(0.0, |nearest| nearest.1);
            0.5 * (facet.nodes.iter().map(distance).sum::<f64>() + length(self.model, &facet))
        });
        let near = self.master.near(slave_places, margin * (1.0 + ROUNDING));
        near.into_iter().map(|facet| FacingFacet::new(facet, slave_places, self.places(1, facet))).collect()
    }

    /// Returns the coordinates on a slave facet at which the nearest master facet changes, with 0 and 1, in ascending order.
    fn cuts(&self, facing: &[FacingFacet]) -> Vec<f64> {
        let mut cuts = Vec::new();
        for (i, f) in facing.iter().enumerate() {
            cuts.extend([-f.along[0] / f.along[1], (1.0 - f.along[0]) / f.along[1]]);
            let ends = self.facets[1][f.facet].nodes;
            let is_neighbor = |g: &&FacingFacet| self.facets[1][g.facet].nodes.iter().any(|n| ends.contains(n));
            for g in facing[i + 1..].iter().filter(is_neighbor) {
                // Equal distances from both lines, on equal and on opposite sides of the two lines.
                for sign in [1.0, -1.0] {
                    cuts.push((sign * g.apart[0] - f.apart[0]) / (f.apart[1] - sign * g.apart[1]));
                }
            }
        }
        cuts.retain(|s| *s > 0.0 && *s < 1.0);
        cuts.extend([0.0, 1.0]);
        cuts.sort_unstable_by(f64::total_cmp);
        cuts
    }

    /// Returns whether the point of a master facet that is nearest to a point of a slave facet is not an end of the master
    /// surface.
    fn is_opposite(&self, facing: &FacingFacet, s: f64) -> bool {
        let [first, last] = self.facets[1][facing.facet].nodes.map(|n| self.ends.contains(&n));
        let along = facing.along(s);
        (along > 0.0 || !first) && (along < 1.0 || !last)
    }

    /// Returns the nodes of a side that can be dependent: slave nodes within the tolerance, or master nodes of facets that
    /// are opposite the slave surface.
    fn dependent_nodes(&self, side: usize, points: &[GaussPoint], taken: &HashSet<usize>) -> HashSet<usize> {
        let mut covered: HashMap<usize, f64> = HashMap::new();
        for piece in points.chunks_exact(2) {
            let width = (piece[1].coordinates[side] - piece[0].coordinates[side]).abs() / GAUSS;
            *covered.entry(piece[0].facets[side]).or_default() += width;
        }
        let facets = covered.iter().filter(|c| side == 0 || *c.1 >= COVERED).map(|c| *c.0);
        let can_depend = |n: &usize| !self.shared.contains(n) && !taken.contains(n);
        let is_attached = |n: &usize| side == 1 || self.attached.contains(n);
        let nodes = facets.flat_map(|facet| self.facets[side][facet].nodes);
        nodes.filter(|n| can_depend(n) && is_attached(n)).collect()
    }

    /// Integrates the products of the weights of dependent nodes and the hat functions of both sides. Equation (11.4).
    fn weights(&self, side: usize, dependent: &HashSet<usize>, points: &[GaussPoint]) -> IndexMap<usize, WeightRow> {
        let mut masses: IndexMap<usize, [f64; 3]> = IndexMap::new();
        for point in points {
            let [first, second] = hats(point.coordinates[side]);
            let mass = masses.entry(point.facets[side]).or_default();
            let products = [first * first, first * second, second * second];
            mass.iter_mut().zip(products).for_each(|(mass, product)| *mass += product * point.area);
        }
        let nodes_of = |side: usize, point: &GaussPoint| self.facets[side][point.facets[side]].nodes;
        let mut rows: IndexMap<usize, WeightRow> = IndexMap::new();
        for point in points {
            let (own_nodes, others) = (nodes_of(side, point), nodes_of(1 - side, point));
            let has_row = own_nodes.map(|n| dependent.contains(&n));
            let hats = point.coordinates.map(hats);
            let weights = dual(masses[&point.facets[side]], has_row, hats[side]);
            for end in [0, 1].into_iter().filter(|&end| has_row[end]) {
                let row = rows.entry(own_nodes[end]).or_insert_with(|| WeightRow::new(point.facets[1 - side]));
                let weight = weights[end] * point.area;
                row.area += weight * hats[side][end];
                row.add(own_nodes[1 - end], -weight * hats[side][1 - end]);
                others.iter().zip(hats[1 - side]).for_each(|(&n, hat)| row.add(n, weight * hat));
                row.add_facet(point.facets[side]);
            }
        }
        rows.retain(|_, row| row.area > 0.0);
        rows
    }

    /// Converts rows to tied nodes, in the order along the surface, which keeps the band of the equations narrow.
    fn tied_nodes(&self, side: usize, rows: IndexMap<usize, WeightRow>) -> Vec<TiedNode> {
        let position = |n: usize| self.model.mesh.points[n];
        let extent = [0, 1].map(|axis: usize| {
            let [low, high] = rows.keys().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &n| {
                [low.min(position(n)[axis]), high.max(position(n)[axis])]
            });
            high - low
        });
        let axis = usize::from(extent[1] > extent[0]);
        let next = |node: usize, row: &WeightRow| {
            let [facet] = row.facets[..] else { return None };
            let other = self.facets[side][facet].nodes.into_iter().find(|n| *n != node)?;
            Some(NextNode { node: other, area: row.area / rows.get(&other)?.area })
        };
        let tied = |(&node, row): (&usize, &WeightRow)| TiedNode {
            node,
            element: self.facets[1 - side][row.opposite].element,
            shares: row.shares(),
            next: next(node, row),
        };
        let mut tied: Vec<TiedNode> = rows.iter().map(tied).collect();
        tied.sort_by(|a, b| position(a.node)[axis].total_cmp(&position(b.node)[axis]).then(a.node.cmp(&b.node)));
        tied
    }
}

/// A master facet, as linear functions of the coordinate `s` from 0 to 1 on a slave facet.
#[derive(Clone, Copy, Debug)]
struct FacingFacet {
    facet: usize,
    length: f64,
    /// Projection onto the master facet, as a fraction of its length, at s = 0, and its derivative by s.
    along: [f64; 2],
    /// Signed distance from the line of the master facet at s = 0, and its derivative by s.
    apart: [f64; 2],
}

impl FacingFacet {
    fn new(facet: usize, [a, b]: [[f64; 2]; 2], [c, d]: [[f64; 2]; 2]) -> FacingFacet {
        let difference = |p: [f64; 2], q: [f64; 2]| [q[0] - p[0], q[1] - p[1]];
        let (start, slave_line, line) = (difference(c, a), difference(a, b), difference(c, d));
        let length = libm::hypot(line[0], line[1]);
        let along = |v: [f64; 2]| (v[0] * line[0] + v[1] * line[1]) / (length * length);
        let apart = |v: [f64; 2]| (v[1] * line[0] - v[0] * line[1]) / length;
        FacingFacet {
            facet,
            length,
            along: [along(start), along(slave_line)],
            apart: [apart(start), apart(slave_line)],
        }
    }

    fn along(&self, s: f64) -> f64 {
        self.along[0] + self.along[1] * s
    }

    fn distance(&self, s: f64) -> f64 {
        let (along, apart) = (self.along(s), self.apart[0] + self.apart[1] * s);
        libm::hypot(apart, (along - along.clamp(0.0, 1.0)) * self.length)
    }
}

/// Integrals of the weight of a dependent node.
#[derive(Clone, Debug)]
struct WeightRow {
    /// Integral with the node's hat function.
    area: f64,
    /// Integrals with the hat functions of the nodes that it follows.
    terms: Vec<(usize, f64)>,
    /// Facets of the node on the common surface.
    facets: Vec<usize>,
    /// A facet of the other side.
    opposite: usize,
}

impl WeightRow {
    fn new(opposite: usize) -> WeightRow {
        WeightRow { area: 0.0, terms: Vec::new(), facets: Vec::new(), opposite }
    }

    fn add(&mut self, node: usize, value: f64) {
        match self.terms.iter_mut().find(|t| t.0 == node) {
            Some(term) => term.1 += value,
            None => self.terms.push((node, value)),
        }
    }

    fn add_facet(&mut self, facet: usize) {
        if !self.facets.contains(&facet) {
            self.facets.push(facet);
        }
    }

    /// Returns the weights of the nodes that the node follows, without those that are rounding errors. Equation (11.6).
    fn shares(&self) -> Vec<(usize, f64)> {
        let terms = || self.terms.iter().filter(|t| t.1.abs() > ROUNDING * self.area);
        let sum: f64 = terms().map(|t| t.1).sum();
        terms().map(|t| (t.0, t.1 / sum)).collect()
    }
}

fn hats(s: f64) -> [f64; 2] {
    [1.0 - s, s]
}

/// Returns the weights of a facet's nodes at a point with the hat functions `hats`. The weights are the dual functions for
/// the facet's `mass` (integrals of products of hat functions). If one node only has a weight, it is 1. Equation
/// (11.5).
fn dual([a, b, c]: [f64; 3], has_row: [bool; 2], hats: [f64; 2]) -> [f64; 2] {
    if has_row != [true; 2] {
        return [1.0; 2];
    }
    let determinant = a * c - b * b;
    if determinant <= ROUNDING * a * c {
        return hats;
    }
    let inverse = [[c, -b], [-b, a]].map(|row| row.map(|value| value / determinant));
    let areas = [a + b, b + c];
    [0, 1].map(|i: usize| areas[i] * (inverse[i][0] * hats[0] + inverse[i][1] * hats[1]))
}
