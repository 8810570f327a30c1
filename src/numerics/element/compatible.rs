//! Compatible energy update for materials with an equation of state: the work of an element's forces on its corners is
//! taken from its internal energy, exact to rounding (Caramana, Burton, Shashkov and Whalen 1998, J. Comput. Phys. 146,
//! 227). Stress work is computed at mid-increment, but hourglass control and viscosity are known at its end; the
//! difference is added here.
#![allow(clippy::needless_range_loop)] // Compilers vectorize loops over lanes in this form.

use super::workspace::{CornerNodes, TaskWorkspace};
use crate::kernel::lanes::{BlockCornerForces, LANES, Lanes};
use crate::state::nodes::{Node, NodeAccelerations};

/// Sums before the increment of a block, and the energy that its elements lose to the forces at the start of the
/// increment.
pub(super) struct EnergyCorrection {
    sums: [Lanes; 3],
    lost: Lanes,
}

impl EnergyCorrection {
    /// Begins the correction, while corner forces are those of the start of the increment. Where an increment dt
    /// follows dt', central differences gain m a² (dt'² - dt²)/8 relative to the trapezoidal work; this energy is
    /// charged to the elements whose forces accelerate the node.
    #[inline(always)]
    pub(super) fn begin(
        scratch: &TaskWorkspace,
        corners: &BlockCornerForces,
        of: &[[u32; LANES]; 4],
        (nodes, dt): (&CornerNodes, f64),
        before: NodeAccelerations<'_>,
    ) -> EnergyCorrection {
        let share = 0.5 * before.half * (dt - before.half);
        let half = 0.5 * dt;
        let mut lost = [0.0; LANES];
        for i in 0..4 {
            for l in 0..LANES {
                let Node { v_r, v_z, .. } = nodes.0[i][l];
                let [a_r, a_z] = before.accelerations.get(of[i][l] as usize).copied().unwrap_or_default();
                let [f_r, f_z] = [corners[i][0][l], corners[i][1][l]];
                lost[l] += f_r * (half * v_r - share * a_r) + f_z * (half * v_z - share * a_z);
            }
        }
        EnergyCorrection { sums: [scratch.stress.internal, scratch.sums.viscous, scratch.sums.artificial], lost }
    }

    /// Completes the correction with the corner forces of the end of the increment: adds the missing work to the
    /// internal energy, and counts it and the hourglass work as heat. Equation (7.10).
    #[inline(always)]
    pub(super) fn apply(&self, scratch: &mut TaskWorkspace, corners: &BlockCornerForces, nodes: &CornerNodes, dt: f64) {
        let half = 0.5 * dt;
        let mut lost = self.lost;
        for i in 0..4 {
            for l in 0..LANES {
                let Node { v_r, v_z, .. } = nodes.0[i][l];
                let [f_r, f_z] = [corners[i][0][l], corners[i][1][l]];
                lost[l] += half * (f_r * v_r + f_z * v_z);
            }
        }
        let [internal, viscous, artificial] = &self.sums;
        for l in 0..LANES {
            let controls = scratch.sums.artificial[l] - artificial[l];
            let booked = (scratch.stress.internal[l] - internal[l]) + (scratch.sums.viscous[l] - viscous[l]) + controls;
            let missing = if scratch.weight[l] > 0.0 { -lost[l] - booked } else { 0.0 };
            scratch.stress.internal[l] += missing;
            scratch.stress.heat[l] += missing + controls;
        }
    }
}
