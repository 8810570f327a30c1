//! Masking of deleted elements in the loops of a block.
#![allow(clippy::needless_range_loop)] // Loops over lanes have the same form as in the other phases.

use super::block::{CornerNodes, ElementBlock, TaskWorkspace};
use super::eroded::height;
use crate::kernel::lanes::{BlockCornerForces, LANES, column, put_column};
use crate::kernel::stress::undamaged;
use crate::material::Material;
use crate::mesh::corner_forces::clear_lane;

impl TaskWorkspace {
    /// Replaces a deleted element by a ring at rest with weight 0.
    #[inline(always)]
    fn mask_lane(&mut self, nodes: &mut CornerNodes, l: usize, height: f64) {
        nodes.mask(l, height);
        self.task.controls[self.at].hourglass.iter_mut().for_each(|list| list[l] = 0.0);
        if let Some(assumed) = self.task.enhanced.get_mut(self.at) {
            assumed.clear(l);
        }
        self.weight[l] = 0.0;
    }
}

impl<S: Clone> ElementBlock<S> {
    /// Replaces elements deleted by `*EROSION` by rings of the same volume at rest, with weight 0. Called before an
    /// increment.
    #[inline(never)]
    pub(super) fn mask_eroded(&mut self, nodes: &mut CornerNodes, scratch: &mut TaskWorkspace) {
        let eroded = scratch.task.eroded[scratch.at];
        for l in (0..LANES).filter(|l| eroded.has(*l)) {
            scratch.mask_lane(nodes, l, eroded.height(l));
            self.stress.iter_mut().for_each(|s| s[l] = 0.0);
        }
    }

    /// Clears the stress and forces of elements deleted by `*EROSION`. Called after an increment, because materials
    /// that compute the stress from the total deformation have set it again.
    #[inline(never)]
    pub(super) fn clear_eroded(&mut self, scratch: &TaskWorkspace, corners: &mut BlockCornerForces) {
        let eroded = &scratch.task.eroded[scratch.at];
        for l in (0..LANES).filter(|l| eroded.has(*l)) {
            self.stress.iter_mut().for_each(|s| s[l] = 0.0);
            clear_lane(corners, l);
        }
    }

    /// Restores the stress of the undamaged material, and replaces elements deleted by their material by rings of the
    /// same volume at rest, with weight 0. Called before an increment.
    #[inline(always)]
    pub(super) fn mask_deleted<M: Material<State = S>>(
        &mut self,
        material: &M,
        nodes: &mut CornerNodes,
        scratch: &mut TaskWorkspace,
    ) {
        for l in 0..LANES {
            let share = material.share(&self.state, l);
            // Lanes after the last element repeat it; the element may be deleted.
            if share > 0.0 && l < scratch.strain.count {
                let shares = [share, material.mean_share(&self.state, l)];
                let stress = undamaged(column(&self.stress, l), shares);
                put_column(&mut self.stress, l, stress);
                continue;
            }
            scratch.mask_lane(nodes, l, height(material.initial_volume(&self.state, l)));
            self.stress.iter_mut().for_each(|s| s[l] = 0.0);
        }
    }

    /// Clears the forces of elements deleted by their material.
    #[inline(always)]
    pub(super) fn clear_deleted<M: Material<State = S>>(&self, material: &M, corners: &mut BlockCornerForces) {
        for l in 0..LANES {
            if material.share(&self.state, l) == 0.0 {
                clear_lane(corners, l);
            }
        }
    }
}
