//! The parts of surfaces that are near another surface: facets that are candidates of a search or have candidates, the
//! facets next to them, and their points. Only these parts are read and measured in an increment. All other points are
//! compared with their positions at the last search only.

use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::MemoryUse;

use super::analytical::AnalyticalSurface;
use super::curve::FacetCurve;
use super::{ContactConstraint, ContactPair};

/// Parts of all curves of a contact that are near another surface.
#[derive(Clone, Debug, Default)]
pub(super) struct NearParts {
    /// Curve and index of each near facet.
    pub(super) facets: Vec<[u32; 2]>,
    /// Points of these facets and single points with candidates, ascending.
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

    /// Lists the near parts after a search.
    pub(super) fn list(&mut self, contact: &ContactConstraint) {
        let ContactConstraint { pairs, curves, analyticals, active_points: all, dofs_of, .. } = contact;
        self.is_candidate.fill(false);
        for (index, pair) in pairs.iter().enumerate() {
            self.mark_candidates(pair, curves, analyticals);
            if contact.is_cohesive(index) {
                self.mark_curves(pair, curves);
            }
        }
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
        let dofs = self.points.iter().flat_map(|p| dofs_of[*p as usize]).filter(|dof| *dof != super::NONE);
        self.dofs.extend(dofs);
        self.dofs.sort_unstable();
        self.dofs.dedup();
    }

    /// Marks both curves of a pair whose bonds act at any distance.
    fn mark_curves(&mut self, pair: &ContactPair, curves: &[FacetCurve]) {
        for curve in [Some(pair.own), pair.other].into_iter().flatten().map(|index| &curves[index]) {
            let points = curve.exposed_points.iter().chain(&curve.orphans);
            points.for_each(|index| self.is_candidate[curve.own[*index as usize] as usize] = true);
        }
    }

    fn mark_candidates(&mut self, pair: &ContactPair, curves: &[FacetCurve], analyticals: &[AnalyticalSurface]) {
        let own = &curves[pair.own];
        let is_candidate = &mut self.is_candidate;
        if let Some(surface) = pair.analytical {
            is_candidate[analyticals[surface].point as usize] = true;
            let points = own.exposed_points.iter().chain(&own.orphans);
            points.for_each(|index| is_candidate[own.own[*index as usize] as usize] = true);
            return;
        }
        let other = pair.other.map_or(own, |o| &curves[o]);
        let mut mark = |curve: &FacetCurve, facets: &[u32]| {
            for &k in facets {
                curve.facets[k as usize].iter().for_each(|p| is_candidate[*p as usize] = true);
            }
        };
        for (at, &k) in own.exposed.iter().enumerate() {
            let candidates = pair.search.facets.of(at);
            if !candidates.is_empty() {
                mark(own, &[k]);
                mark(other, candidates);
            }
        }
        (0..own.orphans.len()).for_each(|at| mark(other, pair.search.orphans.of(at)));
        let singles = pair.other.map_or(0, |o| curves[o].single_points().count());
        (0..singles).for_each(|at| mark(own, pair.search.others.of(at)));
        let of_own = own.orphans.iter().enumerate().filter(|(at, _)| !pair.search.orphans.of(*at).is_empty());
        of_own.for_each(|(_, index)| is_candidate[own.own[*index as usize] as usize] = true);
        if pair.other.is_some() {
            let of_other = other.single_points().enumerate().filter(|(at, _)| !pair.search.others.of(*at).is_empty());
            of_other.for_each(|(_, (index, _))| is_candidate[other.own[index as usize] as usize] = true);
        }
    }

    pub(super) fn memory(&self) -> MemoryUse {
        MemoryUse::of(&self.facets)
            + [&self.points, &self.others, &self.dofs].inline_map(MemoryUse::of).into_iter().sum()
            + MemoryUse::of(&self.is_near)
            + MemoryUse::of(&self.is_candidate)
    }
}
