//! Masking of deleted elements in the loops of a block.
#![allow(clippy::needless_range_loop)] // Loops over lanes have the same form as in the other phases.

use super::block::{CornerNodes, ElementBlock, TaskWorkspace};
use super::eroded::{ErodedLanes, height};
use crate::kernel::lanes::{BlockCornerForces, LANES};
use crate::kernel::real::Real;
use crate::material::Material;

impl<T: Real> TaskWorkspace<T> {
    /// Replaces a deleted element by a ring at rest with weight 0.
    #[inline(always)]
    fn mask_lane(&mut self, nodes: &mut CornerNodes<T>, l: usize, height: f64) {
        nodes.mask(l, height, self.length);
        if let Some(hourglass) = self.task.hourglass.get_mut(self.at) {
            hourglass.iter_mut().for_each(|h| h[l] = T::ZERO);
        }
        if let Some(assumed) = self.task.enhanced.get_mut(self.at) {
            assumed.clear(l);
        }
        self.weight[l] = T::ZERO;
    }
}

impl<S: Clone, T: Real> ElementBlock<S, T> {
    /// Replaces elements deleted by `*EROSION` by rings of the same volume at rest, with weight 0. Called before an
    /// increment.
    #[inline(never)]
    pub(super) fn mask_eroded(
        &mut self,
        eroded: &ErodedLanes,
        nodes: &mut CornerNodes<T>,
        scratch: &mut TaskWorkspace<T>,
    ) {
        for l in (0..LANES).filter(|l| eroded.has(*l)) {
            scratch.mask_lane(nodes, l, eroded.height(l));
            self.stress.iter_mut().for_each(|s| s[l] = T::ZERO);
        }
    }

    /// Clears the stress and forces of elements deleted by `*EROSION`. Called after an increment, because materials
    /// that compute the stress from the total deformation have set it again.
    #[inline(never)]
    pub(super) fn clear_eroded(&mut self, eroded: &ErodedLanes, corners: &mut BlockCornerForces<T>) {
        for l in (0..LANES).filter(|l| eroded.has(*l)) {
            self.stress.iter_mut().for_each(|s| s[l] = T::ZERO);
            corners.clear(l);
        }
    }

    /// Restores the stress of the undamaged material, and replaces elements deleted by their material by rings of the
    /// same volume at rest, with weight 0. Called before an increment.
    #[inline(always)]
    pub(super) fn mask_deleted<M: Material<T, State = S>>(
        &mut self,
        material: &M,
        nodes: &mut CornerNodes<T>,
        scratch: &mut TaskWorkspace<T>,
    ) {
        for l in 0..LANES {
            let share = material.share(&self.state, l);
            // Lanes after the last element repeat it; the element may be deleted.
            if share > 0.0 && l < scratch.strain.count {
                let share = T::of(share);
                self.stress.iter_mut().for_each(|s| s[l] = s[l] / share);
                continue;
            }
            scratch.mask_lane(nodes, l, height(material.initial_volume(&self.state, l)));
            self.stress.iter_mut().for_each(|s| s[l] = T::ZERO);
        }
    }

    /// Clears the forces of elements deleted by their material.
    #[inline(always)]
    pub(super) fn clear_deleted<M: Material<T, State = S>>(&self, material: &M, corners: &mut BlockCornerForces<T>) {
        for l in 0..LANES {
            if material.share(&self.state, l) == 0.0 {
                corners.clear(l);
            }
        }
    }
}
