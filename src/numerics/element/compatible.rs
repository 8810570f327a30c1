//! Compatible energy update for materials with an equation of state: the work of an element's forces on its corners is
//! taken from its internal energy, exact to rounding (Caramana, Burton, Shashkov and Whalen 1998, J. Comput. Phys. 146,
//! 227). Stress work is computed at mid-increment, but hourglass control and viscosity are known at its end; the
//! difference is added here.
#![allow(clippy::needless_range_loop)] // Compilers vectorize loops over lanes in this form.

use super::block::{CornerNodes, TaskWorkspace};
use crate::kernel::lanes::{BlockCornerForces, LANES, Lanes};
use crate::state::nodes::{Node, NodeAccelerations};

/// Sums before the increment of a block, and the energy that its elements lose to the forces at the start of the
/// increment.
pub(super) struct EnergyCorrection {
    sums: [Lanes; 3],
    lost: Lanes,
}

impl TaskWorkspace {
    /// Begins the correction, while corner forces are those of the start of the increment. Where an increment dt
    /// follows dt', central differences gain m a² (dt'² - dt²)/8 relative to the trapezoidal work; this energy is
    /// charged to the elements whose forces accelerate the node.
    #[inline(always)]
    pub(super) fn begin_energy_correction(
        &self,
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
        EnergyCorrection { sums: [self.stress.internal, self.sums.viscous, self.sums.artificial], lost }
    }

    /// Completes the correction with the corner forces of the end of the increment: adds the missing work to the
    /// internal energy, and counts it and the hourglass work as heat. Equation (7.10).
    #[inline(always)]
    pub(super) fn apply_energy_correction(
        &mut self,
        owed: &EnergyCorrection,
        corners: &BlockCornerForces,
        nodes: &CornerNodes,
        dt: f64,
    ) {
        let half = 0.5 * dt;
        let mut lost = owed.lost;
        for i in 0..4 {
            for l in 0..LANES {
                let Node { v_r, v_z, .. } = nodes.0[i][l];
                let [f_r, f_z] = [corners[i][0][l], corners[i][1][l]];
                lost[l] += half * (f_r * v_r + f_z * v_z);
            }
        }
        let [internal, viscous, artificial] = &owed.sums;
        for l in 0..LANES {
            let controls = self.sums.artificial[l] - artificial[l];
            let booked = (self.stress.internal[l] - internal[l]) + (self.sums.viscous[l] - viscous[l]) + controls;
            let missing = if self.weight[l] > 0.0 { -lost[l] - booked } else { 0.0 };
            self.stress.internal[l] += missing;
            self.stress.heat[l] += missing + controls;
        }
    }
}
