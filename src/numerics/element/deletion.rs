//! Masking of deleted elements in the loops of a block.
#![allow(clippy::needless_range_loop)] // Loops over lanes have the same form as in the other phases.

use super::eroded::{ErodedLanes, height};
use super::workspace::{CornerNodes, TaskWorkspace};
use crate::kernel::lanes::{BlockCornerForces, LANES, Lanes, column, put_column};
use crate::kernel::stress::undamaged;
use crate::material::Material;
use crate::mesh::corner_forces::clear_lane;

/// Replaces a deleted element by a ring at rest with weight 0.
#[inline(always)]
fn mask_lane(scratch: &mut TaskWorkspace, stress: &mut [Lanes; 4], nodes: &mut CornerNodes, l: usize, height: f64) {
    nodes.mask(l, height);
    scratch.task.controls[scratch.at].hourglass.iter_mut().for_each(|list| list[l] = 0.0);
    if let Some(assumed) = scratch.task.enhanced.get_mut(scratch.at) {
        assumed.clear(l);
    }
    scratch.weight[l] = 0.0;
    stress.iter_mut().for_each(|s| s[l] = 0.0);
}

/// Replaces elements deleted by `*EROSION` by rings of the same volume at rest, with weight 0. Called before an
/// increment.
#[inline(never)]
pub(super) fn mask_eroded(stress: &mut [Lanes; 4], nodes: &mut CornerNodes, scratch: &mut TaskWorkspace) {
    let eroded = scratch.task.eroded[scratch.at];
    for l in (0..LANES).filter(|l| eroded.has(*l)) {
        mask_lane(scratch, stress, nodes, l, eroded.height(l));
    }
}

/// Clears the stress and forces of elements deleted by `*EROSION`. Called after an increment, because materials
/// that compute the stress from the total deformation have set it again.
#[inline(never)]
pub(super) fn clear_eroded(stress: &mut [Lanes; 4], eroded: &ErodedLanes, corners: &mut BlockCornerForces) {
    for l in (0..LANES).filter(|l| eroded.has(*l)) {
        stress.iter_mut().for_each(|s| s[l] = 0.0);
        clear_lane(corners, l);
    }
}

/// Restores the stress of the undamaged material, and replaces elements deleted by their material by rings of the
/// same volume at rest, with weight 0. Called before an increment.
#[inline(always)]
pub(super) fn mask_deleted<M: Material>(
    (material, state): (&M, &M::State),
    stress: &mut [Lanes; 4],
    nodes: &mut CornerNodes,
    scratch: &mut TaskWorkspace,
) {
    for l in 0..LANES {
        let share = material.share(state, l);
        // Lanes after the last element repeat it; the element may be deleted.
        if share > 0.0 && l < scratch.strain.count {
            let shares = [share, material.mean_share(state, l)];
            let undamaged_stress = undamaged(column(stress, l), shares);
            put_column(stress, l, undamaged_stress);
            continue;
        }
        mask_lane(scratch, stress, nodes, l, height(material.initial_volume(state, l)));
    }
}

/// Clears the forces of elements deleted by their material.
#[inline(always)]
pub(super) fn clear_deleted<M: Material>(material: &M, state: &M::State, corners: &mut BlockCornerForces) {
    for l in 0..LANES {
        if material.share(state, l) == 0.0 {
            clear_lane(corners, l);
        }
    }
}
