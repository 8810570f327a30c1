//! Limit of the time increment by the relative volume change of elements.

use rayon::prelude::*;

use super::constants::CHANGE;
use super::group::ElementGroup;
use super::stable_limit::StableLimit;
use crate::kernel::chunks::{CHUNK, chunks_of};
use crate::kernel::lanes::InlineMap;
use crate::kernel::quad;
use crate::state::nodes::Nodes;

/// Number of increments at the start of an analysis in which accelerations also limit the time increment. Rates are
/// zero before the first increment, and suddenly released loads change them most.
pub const STARTING: u64 = 100;

/// Limits the time increment by the rate of volume change of elements and by the accelerations at this instant:
/// over the increment dt the rate is g + a (dt0 + dt)/2, where dt0 is the previous increment.
pub fn guard_start(groups: &[Box<dyn ElementGroup>], limit: &mut StableLimit, nodes: &Nodes) {
    // Shells limit the increment by their own rates.
    for (group, elements) in groups.iter().enumerate().filter(|(_, elements)| elements.is_solid()) {
        let (elements, least) = (&**elements, limit.totals.rate);
        let of_chunk = |chunk: usize| {
            let mut largest = (0, least);
            for element in chunk * CHUNK..elements.len().min((chunk + 1) * CHUNK) {
                if let Some(rate) = larger_rate(elements, element, nodes, largest.1) {
                    largest = (element, rate);
                }
            }
            largest
        };
        let chunks = (0..chunks_of(elements.len())).into_par_iter();
        // The first of equal rates, for any number of threads.
        let (element, rate) =
            chunks.map(of_chunk).reduce(|| (0, least), |before, after| if after.1 > before.1 { after } else { before });
        limit.raise(group, element, rate);
    }
}

/// Returns the rate by which an element limits the increment, if it is larger than `most`.
fn larger_rate(group: &dyn ElementGroup, element: usize, nodes: &Nodes, most: f64) -> Option<f64> {
    if moves_along_z(&group.nodes(element), nodes) {
        return None;
    }
    let (mut volume, mut growing) = (0.0, [0.0; 2]);
    for cell in group.cells(element) {
        let corners = cell.inline_map(|n| n as usize);
        let corner_nodes = corners.inline_map(|n| nodes[n]);
        let g = quad::gradient(corner_nodes.inline_map(|n| n.r), corner_nodes.inline_map(|n| n.z));
        let growth = |of: &dyn Fn(usize) -> [f64; 2]| {
            let part = |i: usize| (g.r[i] + g.hoop[i]) * of(i)[0] + g.z[i] * of(i)[1];
            (part(0) + part(1)) + (part(2) + part(3))
        };
        volume += g.volume;
        growing[0] += growth(&|i| [corner_nodes[i].v_r, corner_nodes[i].v_z]);
        growing[1] += growth(&|i| nodes.acceleration[corners[i]]);
    }
    let half = 0.5 * nodes.previous_dt;
    // Whether the rate below is smaller than `most`, without divisions and roots, and with a margin for rounding.
    let first = (growing[0] + half * growing[1]).abs();
    if growing[1].abs() < 2.0 * most * ((1.0 - 1e-9) * CHANGE * most * volume - first) {
        return None;
    }
    let [rate, acceleration] = growing.inline_map(|growth| growth / volume);
    let first = (rate + half * acceleration).abs();
    let root = (first * first + 2.0 * CHANGE * acceleration.abs()).sqrt();
    let rate = (first + root) / (2.0 * CHANGE);
    (rate > most && !group.is_deleted(element)).then_some(rate)
}

/// Returns whether nodes have equal velocities along z only, and no acceleration: the volume between them does not change.
fn moves_along_z(of_element: &[u32], nodes: &Nodes) -> bool {
    let v_z = nodes[of_element[0] as usize].v_z;
    let moves = |n: usize| nodes[n].v_z == v_z && nodes[n].v_r == 0.0 && nodes.acceleration[n] == [0.0; 2];
    of_element.iter().all(|n| moves(*n as usize))
}
