//! Deleted elements of a block, which are masked in its loops.
//! Never here: criteria of failure, or of deletion from outside.
#![allow(clippy::needless_range_loop)] // Loops over lanes are written as in the other phases.

use super::block::{ElementBlock, Nodes, Workspace};
use super::eroded::{Eroded, height};
use crate::kernel::lanes::{Corners, LANES};
use crate::kernel::real::Real;
use crate::material::Material;

impl<T: Real> Workspace<T> {
    /// In place of an element that is gone puts one at rest, whose answers weigh nothing.
    #[inline(always)]
    fn mask_lane(&mut self, nodes: &mut Nodes<T>, l: usize, height: f64) {
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
    /// Before an increment: in place of elements that were deleted from outside one of their volume at rest, whose answers weigh
    /// nothing.
    #[inline(never)]
    pub(super) fn mask_eroded(&mut self, eroded: &Eroded, nodes: &mut Nodes<T>, scratch: &mut Workspace<T>) {
        for l in (0..LANES).filter(|l| eroded.has(*l)) {
            scratch.mask_lane(nodes, l, eroded.height(l));
            self.stress.iter_mut().for_each(|s| s[l] = T::ZERO);
        }
    }

    /// After the increment: neither stress nor forces of such elements. Stress that answers to the whole deformation stayed.
    #[inline(never)]
    pub(super) fn clear_eroded(&mut self, eroded: &Eroded, corners: &mut Corners<T>) {
        for l in (0..LANES).filter(|l| eroded.has(*l)) {
            self.stress.iter_mut().for_each(|s| s[l] = T::ZERO);
            corners.clear(l);
        }
    }

    /// Before an increment: the stress of the undamaged material, and in place of a deleted element one of its volume at
    /// rest, whose answers weigh nothing.
    #[inline(always)]
    pub(super) fn mask_deleted<M: Material<T, State = S>>(
        &mut self,
        material: &M,
        nodes: &mut Nodes<T>,
        scratch: &mut Workspace<T>,
    ) {
        for l in 0..LANES {
            let share = material.share(&self.state, l);
            // A lane behind the last element repeats one that may be gone.
            if share > 0.0 && l < scratch.strain.count {
                let share = T::of(share);
                self.stress.iter_mut().for_each(|s| s[l] = s[l] / share);
                continue;
            }
            scratch.mask_lane(nodes, l, height(material.initial_volume(&self.state, l)));
            self.stress.iter_mut().for_each(|s| s[l] = T::ZERO);
        }
    }

    /// Takes the forces of deleted elements away.
    #[inline(always)]
    pub(super) fn clear_deleted<M: Material<T, State = S>>(&self, material: &M, corners: &mut Corners<T>) {
        for l in 0..LANES {
            if material.share(&self.state, l) == 0.0 {
                corners.clear(l);
            }
        }
    }
}
