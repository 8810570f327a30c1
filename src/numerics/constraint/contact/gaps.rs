//! Gaps between a facet and the opposite surface, weighted with the hat functions of the facet's two points. Their
//! derivatives by the positions of the points of both surfaces are computed, too. The signed distance of the opposite
//! surface is integrated over the surface of revolution at fixed material points of the facet. Each piece with the same
//! nearest facet has two Gauss points.
//!
//! The derivative of the distance at a fixed material point is also the rate of the gap on inclined facets, unlike
//! other usual measures. The same weights on both sides make the axial forces cancel to rounding (segment-to-segment
//! contact after Puso and Laursen 2004, Comput. Methods Appl. Mech. Engrg. 193, 601; pieces after Zavarise and De
//! Lorenzis 2009, Int. J. Numer. Meth. Engng 79, 379).

use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::kernel::sorted_boxes::are_apart;

use super::curve::{FacetCurve, FacetNeighbor, FacetShape};
use super::sweeps::{most_rows, reserve_total};

/// Derivatives of the weighted gaps of a facet's two points by the position of one point.
#[derive(Clone, Copy, Debug)]
pub struct GapDerivative {
    /// The point, of either surface.
    pub point: u32,
    /// Derivatives of the two gaps by r and z of the point.
    pub of: [[f64; 2]; 2],
}

/// Derivatives of the covered areas of a facet's two points by the position of one point, at a corner at which the opposite
/// surface ends.
#[derive(Clone, Copy, Debug)]
pub struct CoverDerivative {
    /// The point, of either surface.
    pub point: u32,
    /// Derivatives of the two areas by r and z of the point.
    pub of: [[f64; 2]; 2],
    /// Overlap at the corner.
    pub overlap: f64,
}

/// Weighted gaps of one facet.
#[derive(Clone, Copy, Debug, Default)]
pub struct FacetGap {
    /// Range of the derivatives of the gaps in [`GapIntegrator::shares`].
    pub shares: [u32; 2],
    /// Range of the derivatives of the areas in [`GapIntegrator::edges`].
    pub edges: [u32; 2],
    /// Area of the surface of revolution that is opposite another facet, weighted with the hat function of each point.
    pub area: [f64; 2],
    /// Integral of gap times hat function, for each point.
    pub gap: [f64; 2],
    /// Whether a part of the facet has pressure in soft contact. The area and the gaps are then without the open parts.
    pub is_closed: bool,
}

impl FacetGap {
    /// Returns the mean of the gap over the hat function of a point.
    pub fn mean_gap(&self, end: usize) -> f64 {
        self.gap[end] / self.area[end]
    }
}

/// A point whose gap does not belong to facets.
#[derive(Clone, Copy, Debug)]
pub struct SinglePoint {
    pub point: u32,
    pub place: [f64; 2],
    /// Normals of the facets at a corner: only opposite facets that face one of these normals are considered.
    pub normals: Option<[[f64; 2]; 2]>,
    /// Half the thickness of its body, if the opposite curve is a side of a line; otherwise infinite.
    pub half_thickness: f64,
}

/// An opposite facet, as linear functions of the coordinate `s` from 0 to 1 on the own facet.
#[derive(Clone, Copy, Debug)]
struct FacingFacet {
    facet: u32,
    shape: FacetShape,
    /// Distance of the contact surface from the facet.
    lift: f64,
    /// Projection onto the opposite facet, as a fraction of its length, at s = 0, and its derivative by s.
    along: [f64; 2],
    /// Signed distance from the line of the opposite facet at s = 0, and its derivative by s.
    distance: [f64; 2],
}

impl FacingFacet {
    #[inline]
    fn new(facet: u32, own: &FacetShape, curve: &FacetCurve) -> FacingFacet {
        let other = &curve.shapes[facet as usize];
        let d = [own.from[0] - other.from[0], own.from[1] - other.from[1]];
        let inverse = 1.0 / (other.length * other.length);
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        FacingFacet {
            facet,
            shape: *other,
            lift: curve.lift[facet as usize],
            along: [dot(d, other.along) * inverse, dot(own.along, other.along) * inverse],
            distance: [dot(d, other.normal), dot(own.along, other.normal)],
        }
    }

    #[inline]
    fn at(&self, s: f64) -> f64 {
        self.along[0] + self.along[1] * s
    }

    #[inline]
    fn apart(&self, s: f64) -> f64 {
        self.distance[0] + self.distance[1] * s
    }

    /// Returns whether a position projects onto the facet.
    #[inline]
    fn covers(&self, s: f64) -> bool {
        let along = self.at(s);
        along > -AT_END && along < 1.0 + AT_END
    }
}

/// The nearest part of the opposite surface: a facet, or the corner at one of its ends.
struct NearestFacet {
    facing: FacingFacet,
    corner: Option<usize>,
}

/// Distance of a position from the nearest part of the opposite surface.
struct FacetDistance {
    /// Signed distance.
    gap: f64,
    normal: [f64; 2],
    /// Coordinate on the opposite facet, from 0 to 1.
    part: f64,
}

impl NearestFacet {
    /// Returns the distance of a position at the coordinate `s`; `length` is that of the own facet.
    #[inline]
    fn distance(&self, place: [f64; 2], s: f64, length: f64) -> FacetDistance {
        let (apart, opposite) = (self.facing.apart(s), &self.facing.shape);
        let Some(end) = self.corner else {
            return FacetDistance { gap: apart, normal: opposite.normal, part: self.facing.at(s) };
        };
        let (gap, normal) = corner(place, opposite, end, apart, length);
        FacetDistance { gap, normal, part: end as f64 }
    }
}

/// Gap integration: work arrays and the derivatives of an increment.
#[derive(Clone, Debug, Default, Memory)]
pub struct GapIntegrator {
    /// Derivatives for all facets, in their order.
    pub shares: Vec<GapDerivative>,
    /// Derivatives of areas by the motion of corners along facets, for soft contact.
    pub edges: Vec<CoverDerivative>,
    facing: Vec<FacingFacet>,
    cuts: Vec<f64>,
}

/// Facets are opposite if the cosine between their normals is less than this.
const FACING: f64 = -0.1;
/// Rounding error of projections onto a facet, as a fraction of its length.
const AT_END: f64 = 1e-9;
/// Smallest piece of a facet that is integrated by itself, as a fraction of the facet. A shorter one is part of the next.
const SHORTEST: f64 = 1e-9;
/// Distance from a corner, as a fraction of the facet length, below which the normal of the opposite facet is used.
const AT_CORNER: f64 = 1e-9;
/// Distance of a corner from an edge of the own surface, as a fraction of the facet, at which both edges coincide: a
/// motion of the corner does not change the covered area.
const COINCIDENT: f64 = 1e-3;
/// Gap beyond that at which pressure begins, as a fraction of the facet, up to which a part belongs to the closed ones: a
/// flat facet closes as a whole.
const NEARLY_CLOSED: f64 = 1e-6;
/// Numbers of opposite facets and of cuts of a facet that memory is reserved for.
const MOST_FACING: usize = 64;
const MOST_CUTS: usize = 256;
/// Coordinate of the two Gauss points on the interval from -1 to 1.
const GAUSS: f64 = 0.577_350_269_189_625_8;

impl GapIntegrator {
    pub fn new(facets: usize) -> GapIntegrator {
        GapIntegrator {
            shares: Vec::with_capacity(16 * facets),
            edges: Vec::new(),
            facing: Vec::with_capacity(MOST_FACING),
            cuts: Vec::with_capacity(MOST_CUTS),
        }
    }

    /// Allocates the derivatives of this number of keys, and work arrays. Copies of the arrays have no reserve.
    pub fn reserve(&mut self, keys: usize) {
        reserve_total(&mut self.shares, 16 * most_rows(keys));
        reserve_total(&mut self.facing, MOST_FACING);
        reserve_total(&mut self.cuts, MOST_CUTS);
    }

    /// Allocates the derivatives of soft contact by the motion of corners, for this number of keys.
    pub fn reserve_edges(&mut self, keys: usize) {
        reserve_total(&mut self.edges, 8 * most_rows(keys));
    }

    /// Clears the derivatives of the previous increment.
    pub fn clear(&mut self) {
        self.shares.clear();
        self.edges.clear();
    }

    /// Computes the gaps of facet `k` of one curve to the `candidates` of another one within the distance `reach`. Soft
    /// contact has pressure below the gap `onset`, which is `None` for hard contact. Where a part of the facet has
    /// pressure, the other parts are left out, and the derivatives by the motion of the corners at which the opposite
    /// surface ends are added.
    pub fn facet_gap(
        &mut self,
        (own, k): (&FacetCurve, usize),
        other: &FacetCurve,
        candidates: &[u32],
        reach: f64,
        onset: Option<f64>,
    ) -> FacetGap {
        let (begin, first_edge) = (self.shares.len() as u32, self.edges.len() as u32);
        let onset = onset.map(|onset| onset + NEARLY_CLOSED * own.shapes[k].length);
        let mut seen = FacetGap { shares: [begin; 2], edges: [first_edge; 2], ..FacetGap::default() };
        self.find_facing(own, k, other, candidates, reach);
        if self.facing.is_empty() {
            return seen;
        }
        self.cut(other, onset.map(|onset| onset + own.lift[k]));
        let mut previous: Option<Option<FacingFacet>> = None;
        let mut from = 0.0;
        for piece in 1..self.cuts.len() {
            let end = self.cuts[piece];
            if end - from <= SHORTEST {
                continue;
            }
            let current = self.piece([from, end], (own, k), (other, onset), reach, &mut seen);
            match (previous, current) {
                (Some(Some(ends)), None) if onset.is_some() => self.edge((own, k), other, ends, [from, 1.0]),
                (Some(None), Some(begins)) if onset.is_some() => self.edge((own, k), other, begins, [from, -1.0]),
                _ => {}
            }
            (previous, from) = (Some(current), end);
        }
        seen.shares[1] = self.shares.len() as u32;
        seen.edges[1] = self.edges.len() as u32;
        seen
    }

    #[inline]
    pub fn shares_of(&self, seen: &FacetGap) -> &[GapDerivative] {
        &self.shares[seen.shares[0] as usize..seen.shares[1] as usize]
    }

    #[inline]
    pub fn edges_of(&self, seen: &FacetGap) -> &[CoverDerivative] {
        &self.edges[seen.edges[0] as usize..seen.edges[1] as usize]
    }

    /// Computes the gap of a single point, with a unit area. Returns the gap and the facet; `None` if no facet is near.
    pub fn point_gap(
        &mut self,
        SinglePoint { point, place, normals, half_thickness }: SinglePoint,
        other: &FacetCurve,
        candidates: &[u32],
        reach: f64,
    ) -> Option<(FacetGap, u32)> {
        let begin = self.shares.len() as u32;
        self.facing.clear();
        let point_shape = FacetShape { from: place, ..FacetShape::default() };
        let faces =
            |j: u32| normals.is_none_or(|all| all.iter().any(|n| cosine(n, &other.shapes[j as usize]) < FACING));
        let (mut nearest, mut least) = (None, f64::INFINITY);
        for &j in candidates.iter().filter(|j| faces(**j)) {
            let square = squared_distance(place, &other.shapes[j as usize]);
            if square < least {
                (nearest, least) = (Some(j), square);
            }
        }
        self.facing.extend(nearest.map(|j| FacingFacet::new(j, &point_shape, other)));
        let nearest = self.nearest(&point_shape, 0.0, other, [&|_| false, &|_| false])?;
        if normals.is_some() && nearest.corner.is_some() {
            return None;
        }
        let j = nearest.facing.facet as usize;
        let FacetDistance { gap, normal, part } = nearest.distance(place, 0.0, nearest.facing.shape.length);
        let gap = gap - other.lift[j];
        if gap >= reach || gap <= -other.depth_at(j, part).min(half_thickness) {
            return None;
        }
        let ends = other.facets[j];
        for (point, share) in [(point, 1.0), (ends[0], part - 1.0), (ends[1], -part)] {
            if share != 0.0 {
                self.shares.push(GapDerivative { point, of: [[share * normal[0], share * normal[1]], [0.0; 2]] });
            }
        }
        let (shares, edges) = ([begin, self.shares.len() as u32], [0; 2]);
        let seen = FacetGap { shares, edges, area: [1.0, 0.0], gap: [gap, 0.0], ..FacetGap::default() };
        Some((seen, j as u32))
    }

    /// Selects the candidates that are opposite and near at present.
    fn find_facing(&mut self, own: &FacetCurve, k: usize, other: &FacetCurve, candidates: &[u32], reach: f64) {
        self.facing.clear();
        let shape = &own.shapes[k];
        let [low, high] = shape.bounds();
        let near_enough = |j: u32| reach + own.lift[k] + other.lift[j as usize];
        for &j in candidates {
            let near = &other.shapes[j as usize];
            if cosine(&shape.normal, near) < FACING && !are_apart([low, high], near.bounds(), near_enough(j)) {
                self.facing.push(FacingFacet::new(j, shape, other));
            }
        }
    }

    /// Finds the coordinates at which the nearest facet changes: at facet ends, and between neighbours at equal
    /// distance from both lines. In soft contact, also those at which the distance is that of the beginning of pressure
    /// from the opposite contact surface.
    fn cut(&mut self, other: &FacetCurve, begins: Option<f64>) {
        let (cuts, facing) = (&mut self.cuts, &self.facing);
        cuts.clear();
        cuts.extend([0.0, 1.0]);
        let mut add = |s: f64| {
            if s > 0.0 && s < 1.0 {
                cuts.push(s);
            }
        };
        for f in facing {
            let inverse = 1.0 / f.along[1];
            add(-f.along[0] * inverse);
            add((1.0 - f.along[0]) * inverse);
            if let Some(begins) = begins {
                add((begins + f.lift - f.distance[0]) / f.distance[1]);
            }
            let neighbors = other.neighbors[f.facet as usize];
            let [before, after] = neighbors.inline_map(|beyond| match beyond {
                FacetNeighbor::Facet(next) => facing.iter().find(|g| g.facet == next),
                _ => None,
            });
            // Beyond the ends of the facet, the sign of the distance changes in its plane. Where a neighbour is
            // opposite, it is nearer.
            let crossing = -f.distance[0] / f.distance[1];
            let along = f.at(crossing);
            let beyond = if along < 0.0 { before } else { after };
            if !(0.0..=1.0).contains(&along) && !beyond.is_some_and(|g| g.covers(crossing)) {
                add(crossing);
            }
            if let Some(g) = after {
                let s = (g.distance[0] - f.distance[0]) / (f.distance[1] - g.distance[1]);
                if f.covers(s) && g.covers(s) {
                    add(s);
                }
            }
        }
        cuts.sort_unstable_by(f64::total_cmp);
    }

    /// Leaves out the gap of one of a facet's points.
    pub fn leave_out(&mut self, seen: &mut FacetGap, end: usize) {
        (seen.area[end], seen.gap[end]) = (0.0, 0.0);
        for share in &mut self.shares[seen.shares[0] as usize..seen.shares[1] as usize] {
            share.of[end] = [0.0; 2];
        }
    }

    /// Adds the derivatives of the covered area by the motion of a corner of the opposite surface at the coordinate `s` of
    /// the own facet; the covered part is before it (`side` 1) or after it (-1). A corner that moves by dl over the facet
    /// covers 2 pi r dl more.
    fn edge(&mut self, (own, k): (&FacetCurve, usize), other: &FacetCurve, facing: FacingFacet, [s, side]: [f64; 2]) {
        let (shape, opposite) = (own.shapes[k], other.shapes[facing.facet as usize]);
        let overlap = own.lift[k] + other.lift[facing.facet as usize] - facing.apart(s);
        let along = facing.at(s);
        let end = usize::from(along > 0.5);
        let coincides = [s, 1.0 - s].iter().zip(0..2).any(|(apart, end)| *apart < COINCIDENT && own.turns_at(k, end));
        if overlap <= 0.0 || (along - end as f64).abs() > AT_CORNER || coincides {
            return;
        }
        let r = shape.from[0] + s * shape.along[0];
        let inverse = side * shape.length / (facing.along[1] * opposite.length * opposite.length);
        let along = [0, 1].inline_map(|i| opposite.along[i] * (std::f64::consts::TAU * r * inverse));
        let ([a, b], corner) = (own.facets[k], other.facets[facing.facet as usize][end]);
        for (point, share) in [(a, s - 1.0), (b, -s), (corner, 1.0)] {
            let derivatives = [1.0 - s, s].inline_map(|hat| [hat * share * along[0], hat * share * along[1]]);
            self.edges.push(CoverDerivative { point, of: derivatives, overlap });
        }
    }

    /// Integrates over a piece of the facet with one nearest facet. Returns this facet if the piece is opposite it.
    /// Equation (10.1).
    fn piece(
        &mut self,
        [from, to]: [f64; 2],
        (own, k): (&FacetCurve, usize),
        (other, onset): (&FacetCurve, Option<f64>),
        reach: f64,
        seen: &mut FacetGap,
    ) -> Option<FacingFacet> {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let shape = own.shapes[k];
        // In self-contact, a facet next to the own one is not opposite: the point is within the corner between both.
        let is_self = std::ptr::eq(own, other);
        let joins = |next: u32| is_self && own.facets[k].iter().any(|p| other.facets[next as usize].contains(p));
        let ends_at =
            |next: u32| onset.is_none() && !is_self && cosine(&shape.normal, &other.shapes[next as usize]) >= FACING;
        let nearest = self.nearest(&shape, middle, other, [&joins, &ends_at])?;
        let (j, opposite) = (nearest.facing.facet as usize, nearest.facing.shape);
        let deepest = deepest_overlap((own, k), (other, j));
        let (own_lift, other_lift) = (own.lift[k], nearest.facing.lift);
        if let Some(onset) = onset {
            let position = [0, 1].inline_map(|i: usize| shape.from[i] + middle * shape.along[i]);
            let gap = nearest.distance(position, middle, shape.length).gap - own_lift - other_lift;
            if !self.begin_part(gap < onset, seen) {
                return Some(nearest.facing);
            }
        }
        let mut shares = [[[0.0; 2]; 2]; 4];
        let mut any = false;
        for s in [middle - half * GAUSS, middle + half * GAUSS] {
            let position = [shape.from[0] + s * shape.along[0], shape.from[1] + s * shape.along[1]];
            let FacetDistance { gap, normal, part } = nearest.distance(position, s, shape.length);
            let gap = gap - own_lift - other_lift;
            if gap >= reach || (gap <= 0.0 && gap <= -other.depth_at(j, part).min(deepest)) {
                continue;
            }
            any = true;
            let r = 0.5 * (position[0] + opposite.from[0] + part * opposite.along[0]);
            let weight = std::f64::consts::TAU * r * half * shape.length;
            let (hats, weighted) = ([1.0 - s, s], normal.inline_map(|n| weight * n));
            let factors = [hats[0], hats[1], part - 1.0, -part];
            for (share, factor) in shares.iter_mut().zip(factors) {
                for (sum, hat) in share.iter_mut().zip(hats) {
                    let factor = hat * factor;
                    sum[0] += factor * weighted[0];
                    sum[1] += factor * weighted[1];
                }
            }
            for (l, hat) in hats.into_iter().enumerate() {
                seen.area[l] += hat * weight;
                seen.gap[l] += hat * weight * gap;
            }
        }
        if any {
            let ([a, b], [c, d]) = (own.facets[k], other.facets[j]);
            self.add(seen, a, shares[0]);
            self.add(seen, b, shares[1]);
            self.add(seen, c, shares[2]);
            self.add(seen, d, shares[3]);
        }
        any.then_some(nearest.facing)
    }

    /// Leaves out the open parts of a facet before its first part with pressure. Returns whether this part counts.
    fn begin_part(&mut self, is_closed: bool, seen: &mut FacetGap) -> bool {
        if is_closed && !seen.is_closed {
            self.shares.truncate(seen.shares[0] as usize);
            (seen.area, seen.gap, seen.is_closed) = ([0.0; 2], [0.0; 2], true);
        }
        is_closed || !seen.is_closed
    }

    /// Returns the nearest part of the opposite surface. Returns `None` beyond the free end of a surface, and around a
    /// corner if the next facet is not opposite: the point is inside the plane of the facet and in front of the next one,
    /// or the next facet joins the own one, or the surface `ends_at` it.
    fn nearest(
        &self,
        shape: &FacetShape,
        s: f64,
        other: &FacetCurve,
        [joins, ends_at]: [&dyn Fn(u32) -> bool; 2],
    ) -> Option<NearestFacet> {
        let position = [shape.from[0] + s * shape.along[0], shape.from[1] + s * shape.along[1]];
        let (mut best, mut least) = (None, f64::INFINITY);
        for f in &self.facing {
            let (along, opposite) = (f.at(s), &f.shape);
            let part = along.clamp(0.0, 1.0);
            let d = [0, 1].inline_map(|i| position[i] - opposite.from[i] - part * opposite.along[i]);
            let square = d[0] * d[0] + d[1] * d[1];
            if square < least {
                (best, least) = (Some(f), square);
            }
        }
        let facing = *best?;
        let along = facing.at(s);
        let end = usize::from(along > 1.0);
        let corner = (!(0.0..=1.0).contains(&along)).then_some(end);
        let passes = corner.is_some()
            && match other.neighbors[facing.facet as usize][end] {
                FacetNeighbor::Nothing => true,
                FacetNeighbor::Facet(next) => {
                    let is_inside = facing.apart(s) < 0.0;
                    is_inside && joins(next)
                        || (is_inside || ends_at(next)) && other.shapes[next as usize].in_front(position)
                }
                FacetNeighbor::Axis => false,
            };
        (!passes).then_some(NearestFacet { facing, corner })
    }

    /// Adds derivatives of a piece to a point.
    fn add(&mut self, seen: &FacetGap, point: u32, of: [[f64; 2]; 2]) {
        if of == [[0.0; 2]; 2] {
            return;
        }
        match self.shares[seen.shares[0] as usize..].iter_mut().find(|c| c.point == point) {
            Some(known) => {
                for (sum, more) in known.of.iter_mut().zip(of) {
                    sum[0] += more[0];
                    sum[1] += more[1];
                }
            }
            None => self.shares.push(GapDerivative { point, of }),
        }
    }
}

/// Returns the squared distance of a place from a facet.
#[inline]
fn squared_distance(place: [f64; 2], facet: &FacetShape) -> f64 {
    let d = [place[0] - facet.from[0], place[1] - facet.from[1]];
    let part = (d[0] * facet.along[0] + d[1] * facet.along[1]) * (1.0 / (facet.length * facet.length));
    let part = part.clamp(0.0, 1.0);
    let d = [0, 1].inline_map(|i| place[i] - facet.from[i] - part * facet.along[i]);
    d[0] * d[0] + d[1] * d[1]
}

/// Returns the largest overlap of two facets if one is a side of a line without thickness: half the thickness of the
/// other body. A larger overlap is that of a body on the other side of the line.
fn deepest_overlap((own, k): (&FacetCurve, usize), (other, j): (&FacetCurve, usize)) -> f64 {
    if other.is_side_of_line {
        own.half_thickness(k)
    } else if own.is_side_of_line {
        other.half_thickness(j)
    } else {
        f64::INFINITY
    }
}

/// Returns the cosine between a normal and that of a facet.
fn cosine(normal: &[f64; 2], facet: &FacetShape) -> f64 {
    normal[0] * facet.normal[0] + normal[1] * facet.normal[1]
}

/// Returns the signed distance from a corner at one end of a facet and its gradient; `apart` is the distance from the
/// facet's line and gives the sign.
fn corner(place: [f64; 2], opposite: &FacetShape, end: usize, apart: f64, length: f64) -> (f64, [f64; 2]) {
    let q = [opposite.from[0] + end as f64 * opposite.along[0], opposite.from[1] + end as f64 * opposite.along[1]];
    let d = [place[0] - q[0], place[1] - q[1]];
    let distance = (d[0] * d[0] + d[1] * d[1]).sqrt();
    let sign = if apart >= 0.0 { 1.0 } else { -1.0 };
    if distance < AT_CORNER * length {
        return (sign * distance, opposite.normal);
    }
    (sign * distance, [sign * d[0] / distance, sign * d[1] / distance])
}

#[cfg(test)]
mod tests {
    use super::{FacetGap, GapIntegrator};
    use crate::constraint::contact::curve::FacetCurve;

    fn curve(places: &[[f64; 2]], first: u32) -> FacetCurve {
        let facets = (0..places.len() as u32 - 1).map(|i| [first + i, first + i + 1]).collect::<Vec<_>>();
        let (depth, zeros) = (vec![[1.0; 3]; facets.len()], vec![[-1.0, 0.0]; first as usize]);
        let all_places: Vec<[f64; 2]> = zeros.into_iter().chain(places.iter().copied()).collect();
        let bare = facets.len();
        let mut curve = FacetCurve::new(facets, depth, bare, &all_places);
        curve.shape(&all_places);
        curve
    }

    /// Forces on both surfaces cancel on inclined facets of unequal length. Over a flat surface the derivative of the
    /// gap by the axial position is one.
    #[test]
    fn shares_of_both_surfaces_cancel() {
        let secondary_places = [[1.0, 0.9], [2.0, 1.1]];
        let other = [[2.3, 0.2], [1.4, 0.3], [0.7, 0.1]];
        let flat = [[2.3, 0.5], [1.4, 0.5], [0.7, 0.5]];
        for below in [other, flat] {
            let (a, b) = (curve(&secondary_places, 0), curve(&below, 2));
            let mut gaps = GapIntegrator::new(4);
            let seen: FacetGap = gaps.facet_gap((&a, 0), &b, &[0, 1], 10.0, None);
            let sum = |i: usize| {
                let of_secondary: f64 =
                    gaps.shares.iter().filter(|c| c.point < 2).map(|c| c.of[0][i] + c.of[1][i]).sum();
                let other: f64 = gaps.shares.iter().filter(|c| c.point >= 2).map(|c| c.of[0][i] + c.of[1][i]).sum();
                (of_secondary, other)
            };
            for i in [0, 1] {
                let (of_secondary, other) = sum(i);
                assert!((of_secondary + other).abs() < 1e-14, "{of_secondary} {other}");
            }
            assert!(seen.area.iter().all(|a| *a > 0.0));
        }
        let (a, b) = (curve(&secondary_places, 0), curve(&flat, 2));
        let mut gaps = GapIntegrator::new(4);
        let seen = gaps.facet_gap((&a, 0), &b, &[0, 1], 10.0, None);
        let rise: f64 = gaps.shares.iter().filter(|c| c.point < 2).map(|c| c.of[0][1] + c.of[1][1]).sum();
        assert!((rise / (seen.area[0] + seen.area[1]) - 1.0).abs() < 1e-14);
    }

    /// A point beyond the free end of a surface has no gap. Beyond a corner after which the surface turns away it has
    /// the distance from the corner in soft contact, and no gap in hard contact.
    #[test]
    fn free_ends_have_no_gap_and_corners_do() {
        let secondary = curve(&[[2.5, 0.1], [3.0, 0.1]], 0);
        let mut gaps = GapIntegrator::new(4);
        let ending = curve(&[[2.0, 0.0], [0.0, 0.0]], 2);
        assert_eq!(gaps.facet_gap((&secondary, 0), &ending, &[0], 10.0, None).area, [0.0; 2]);
        let around = curve(&[[2.0, -1.0], [2.0, 0.0], [0.0, 0.0]], 2);
        let seen = gaps.facet_gap((&secondary, 0), &around, &[0, 1], 10.0, Some(0.0));
        assert!(seen.gap[0] / seen.area[0] > 0.5 && seen.gap[1] / seen.area[1] > 0.5, "{seen:?}");
        assert_eq!(gaps.facet_gap((&secondary, 0), &around, &[0, 1], 10.0, None).area, [0.0; 2]);
        let beside = curve(&[[2.5, -0.1], [3.0, -0.1]], 0);
        assert_eq!(gaps.facet_gap((&beside, 0), &around, &[1], 10.0, None).area, [0.0; 2]);
        let within = curve(&[[1.0, -0.1], [1.5, -0.1]], 0);
        let seen = gaps.facet_gap((&within, 0), &around, &[1], 10.0, None);
        assert!(seen.gap.iter().zip(seen.area).all(|(gap, area)| area > 0.0 && *gap < 0.0), "{seen:?}");
    }

    /// At an acute corner, a facet is on the inner side of the plane of the facet after the next one. In self-contact this is no
    /// overlap; a facet of another surface in the same place overlaps.
    #[test]
    fn facet_after_the_next_one_is_not_opposite_in_self_contact() {
        let body = curve(&[[1.0, 1.0], [1.0, 0.5], [1.0, 0.0], [2.0, 0.25]], 0);
        let mut gaps = GapIntegrator::new(4);
        assert_eq!(gaps.facet_gap((&body, 2), &body, &[0], 10.0, None).area, [0.0; 2]);
        let seen = gaps.facet_gap((&body.clone(), 2), &body, &[0], 10.0, None);
        assert!(seen.area[0] > 0.0 && seen.gap[0] < 0.0, "{seen:?}");
    }
}
