//! Limit of the time increment by the relative volume change of elements.

use super::constants::CHANGE;
use super::elements::Elements;
use crate::kernel::lanes::InlineMap;
use crate::kernel::quad;
use crate::state::nodes::Nodes;

/// Number of increments at the start of an analysis in which accelerations also limit the time increment. Rates are
/// zero before the first increment, and suddenly released loads change them most.
pub const STARTING: u64 = 100;

impl Elements {
    /// Limits the time increment by the rate of volume change of elements and by the accelerations at this instant:
    /// over the increment dt the rate is g + a (dt0 + dt)/2, where dt0 is the previous increment.
    pub fn guard_start(&mut self, nodes: &Nodes) {
        let half = 0.5 * nodes.previous_dt;
        for group in 0..self.groups.len() {
            // Shells limit the increment by their own rates.
            if !self.groups[group].is_solid() {
                continue;
            }
            for element in 0..self.groups[group].len() {
                if moves_along_z(&self.groups[group].nodes(element), nodes) || self.groups[group].is_deleted(element) {
                    continue;
                }
                let (mut volume, mut growing) = (0.0, [0.0; 2]);
                for cell in self.groups[group].cells(element) {
                    let corners = cell.inline_map(|n| n as usize);
                    let at = corners.inline_map(|n| nodes[n]);
                    let g = quad::gradient(at.inline_map(|n| n.r), at.inline_map(|n| n.z));
                    let growth = |of: &dyn Fn(usize) -> [f64; 2]| {
                        let part = |i: usize| (g.r[i] + g.hoop[i]) * of(i)[0] + g.z[i] * of(i)[1];
                        (part(0) + part(1)) + (part(2) + part(3))
                    };
                    volume += g.volume;
                    growing[0] += growth(&|i| [at[i].v_r, at[i].v_z]);
                    growing[1] += growth(&|i| nodes.acceleration[corners[i]]);
                }
                let [rate, acceleration] = growing.inline_map(|growth| growth / volume);
                let first = (rate + half * acceleration).abs();
                let root = (first * first + 2.0 * CHANGE * acceleration.abs()).sqrt();
                self.raise_limit(group, element, (first + root) / (2.0 * CHANGE));
            }
        }
    }
}

/// Returns whether nodes have equal velocities along z only, and no acceleration: the volume between them does not change.
fn moves_along_z(of_element: &[u32], nodes: &Nodes) -> bool {
    let v_z = nodes[of_element[0] as usize].v_z;
    let moves = |n: usize| nodes[n].v_z == v_z && nodes[n].v_r == 0.0 && nodes.acceleration[n] == [0.0; 2];
    of_element.iter().all(|n| moves(*n as usize))
}
