//! The energy of what has an equation of state: what the forces of an element do on its corners comes from its own energy, to
//! rounding (Caramana, Burton, Shashkov and Whalen 1998, J. Comput. Phys. 146, 227). Work of the stress is taken in the middle
//! of an increment, hourglass control and viscosity are known at its end: what is missing follows here.
//! Never here: pressures, forces.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use super::block::{Nodes, Workspace};
use crate::kernel::lanes::{Corners, LANES, Lanes};
use crate::state::nodes::Accelerated;

/// Sums before a block's increment, and the energy that its elements lose to the forces of the increment's begin.
pub(super) struct EnergyCorrection {
    sums: [Lanes; 3],
    lost: Lanes,
}

impl Workspace {
    /// Before the increment, while corner forces are those of its begin. Central differences gain m a^2 (dt'^2 - dt^2)/8 on
    /// the work by the trapezoid where dt follows dt'; the elements whose forces accelerate the node pay for it.
    #[inline(always)]
    pub(super) fn owe(
        &self,
        corners: &Corners,
        of: &[[u32; LANES]; 4],
        (nodes, dt): (&Nodes, f64),
        before: Accelerated<'_>,
    ) -> EnergyCorrection {
        let share = 0.5 * before.half * (dt - before.half);
        let half = 0.5 * dt;
        let mut lost = [0.0; LANES];
        for i in 0..4 {
            for l in 0..LANES {
                let [_, _, v_r, v_z] = nodes.0[i][l];
                let [a_r, a_z] = before.accelerations.get(of[i][l] as usize).copied().unwrap_or_default();
                let [f_r, f_z] = corners.0[i][l];
                lost[l] += f_r * (half * v_r - share * a_r) + f_z * (half * v_z - share * a_z);
            }
        }
        EnergyCorrection { sums: [self.stress.internal, self.sums.viscous, self.sums.artificial], lost }
    }

    /// After the increment, with the corner forces of its end: books what is missing of the work, and counts it and the work of
    /// hourglass control as heat.
    #[inline(always)]
    pub(super) fn pay(&mut self, owed: &EnergyCorrection, corners: &Corners, nodes: &Nodes, dt: f64) {
        let half = 0.5 * dt;
        let mut lost = owed.lost;
        for i in 0..4 {
            for l in 0..LANES {
                let [_, _, v_r, v_z] = nodes.0[i][l];
                let [f_r, f_z] = corners.0[i][l];
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
