//! The parts of surfaces that are near another surface: facets that are candidates of a search or have candidates, the
//! facets next to them, and their points. Only these parts are read and measured in an increment. All other points are
//! compared with their positions at the last search only.

use crate::kernel::lists::Memory;

use super::curve::FacetCurve;
use super::search::ContactSearch;
use super::sweeps::NONE;

/// Parts of all curves of a contact that are near another surface.
#[derive(Clone, Debug, Default, Memory)]
pub(super) struct NearParts {
    /// Curve and index of each near facet.
    pub(super) facets: Vec<[u32; 2]>,
    /// Points of the near facets and single points with candidates, ascending.
    pub(super) points: Vec<u32>,
    /// All other points of the contact, ascending.
    pub(super) others: Vec<u32>,
    /// Degrees of freedom of the near points, ascending.
    pub(super) dofs: Vec<u32>,
    is_near: Vec<bool>,
    /// Work array: points of facets that are candidates or have candidates.
    is_candidate: Vec<bool>,
}

impl NearParts {
    /// Allocates for this number of facets, points and degrees of freedom.
    pub(super) fn reserve(&mut self, facets: usize, points: usize, dofs: usize) {
        super::sweeps::reserve_total(&mut self.facets, facets);
        super::sweeps::reserve_total(&mut self.points, points);
        super::sweeps::reserve_total(&mut self.others, points);
        super::sweeps::reserve_total(&mut self.dofs, dofs);
        self.is_near.resize(points, false);
        self.is_candidate.resize(points, false);
    }

    /// Returns whether a point is near another surface.
    #[inline]
    pub(super) fn has(&self, point: u32) -> bool {
        self.is_near[point as usize]
    }

    /// Begins to mark points after a search.
    pub(super) fn begin(&mut self) {
        self.is_candidate.fill(false);
    }

    pub(super) fn mark_point(&mut self, point: u32) {
        self.is_candidate[point as usize] = true;
    }

    /// Marks all points of a curve.
    pub(super) fn mark_curve(&mut self, curve: &FacetCurve) {
        let points = curve.exposed_points.iter().chain(&curve.orphans);
        points.for_each(|index| self.is_candidate[curve.points[*index as usize] as usize] = true);
    }

    /// Lists the near parts from the marked points. `all` are the points of exposed facets and those without elements.
    pub(super) fn list(&mut self, curves: &[FacetCurve], all: &[u32], dofs_of: &[[u32; 2]]) {
        self.is_near.clone_from(&self.is_candidate);
        self.facets.clear();
        for (curve, at) in curves.iter().zip(0..) {
            for &k in &curve.exposed {
                let points = curve.facets[k as usize];
                if points.iter().any(|p| self.is_candidate[*p as usize]) {
                    self.facets.push([at, k]);
                    points.iter().for_each(|p| self.is_near[*p as usize] = true);
                }
            }
        }
        self.points.clear();
        self.others.clear();
        self.dofs.clear();
        for &point in all {
            let list = if self.is_near[point as usize] { &mut self.points } else { &mut self.others };
            list.push(point);
        }
        let dofs = self.points.iter().flat_map(|p| dofs_of[*p as usize]).filter(|dof| *dof != NONE);
        self.dofs.extend(dofs);
        self.dofs.sort_unstable();
        self.dofs.dedup();
    }

    /// Marks the candidates of a search between two curves, or of self-contact, and the points that have candidates.
    pub(super) fn mark_candidates(&mut self, own: &FacetCurve, opposite: Option<&FacetCurve>, search: &ContactSearch) {
        let (other, is_candidate) = (opposite.unwrap_or(own), &mut self.is_candidate);
        let mut mark = |curve: &FacetCurve, facets: &[u32]| {
            for &k in facets {
                curve.facets[k as usize].iter().for_each(|p| is_candidate[*p as usize] = true);
            }
        };
        for (at, &k) in own.exposed.iter().enumerate() {
            let candidates = search.facets.of(at);
            if !candidates.is_empty() {
                mark(own, &[k]);
                mark(other, candidates);
            }
        }
        (0..own.orphans.len()).for_each(|at| mark(other, search.orphans.of(at)));
        let singles = opposite.map_or(0, |curve| curve.single_points().count());
        (0..singles).for_each(|at| mark(own, search.others.of(at)));
        let of_own = own.orphans.iter().enumerate().filter(|(at, _)| !search.orphans.of(*at).is_empty());
        of_own.for_each(|(_, index)| is_candidate[own.points[*index as usize] as usize] = true);
        if opposite.is_some() {
            let of_other = other.single_points().enumerate().filter(|(at, _)| !search.others.of(*at).is_empty());
            of_other.for_each(|(_, (index, _))| is_candidate[other.points[index as usize] as usize] = true);
        }
    }
}
