//! Division of a mesh into patches with similar numbers of elements.

use crate::kernel::lists::sorted_unique;
use crate::model::{Mesh, Model};
use crate::plan::pieces;

/// Smallest number of elements of a patch, except for bodies with fewer.
pub const LEAST_ELEMENTS: usize = 4;
/// Distance of a cut from the median at which the widest gap between rows of elements is searched, relative to the smaller
/// part.
const SEARCH: f64 = 0.3;

/// Divides the elements that have edges into about `count` patches: connected bodies first, then at the widest gap near the
/// median along the longer direction. Rigid bodies and bodies of six-node triangles are one patch each.
pub fn patches(model: &Model, count: usize) -> Vec<Vec<usize>> {
    let mesh = &model.mesh;
    let with_edges: Vec<usize> = (0..mesh.elements.len()).filter(|&e| !mesh.elements[e].kind.is_discrete()).collect();
    let bodies = pieces(mesh, &with_edges);
    let is_whole = |body: &[usize]| {
        let is_rigid = |e: &usize| model.rigid_bodies.iter().any(|rigid| rigid.elements.contains(e));
        is_rigid(&body[0]) || mesh.elements[body[0]].nodes.len() == 6
    };
    let (whole, divisible): (Vec<_>, Vec<_>) = bodies.into_iter().partition(|body| is_whole(body));
    let total: usize = divisible.iter().map(Vec::len).sum();
    let remaining = count.saturating_sub(whole.len()).max(1);
    let mut patches = Vec::new();
    if divisible.len() > remaining {
        split(mesh, divisible.concat(), remaining, &mut patches);
    } else {
        for body in divisible {
            let share = (remaining * body.len() + total / 2) / total.max(1);
            let parts = share.clamp(1, (body.len() / LEAST_ELEMENTS).max(1));
            split(mesh, body, parts, &mut patches);
        }
    }
    patches.extend(whole);
    patches.into_iter().map(sorted_unique).collect()
}

/// Divides elements into `parts` patches.
fn split(mesh: &Mesh, mut elements: Vec<usize>, parts: usize, patches: &mut Vec<Vec<usize>>) {
    if parts < 2 || elements.len() < 2 {
        patches.push(elements);
        return;
    }
    let [low, high] = super::bounds(mesh, &elements);
    let along = usize::from(high[1] - low[1] >= high[0] - low[0]);
    let centre = |element: usize| {
        let nodes = &mesh.elements[element].nodes;
        [along, 1 - along].map(|i| nodes.iter().map(|&n| mesh.points[n][i]).sum::<f64>() / nodes.len() as f64)
    };
    elements.sort_by(|&a, &b| {
        let [a, b] = [centre(a), centre(b)];
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
    });
    let first_parts = parts / 2;
    let median = elements.len() * first_parts / parts;
    let reach = (SEARCH * median as f64) as usize;
    let gap = |at: usize| centre(elements[at])[0] - centre(elements[at - 1])[0];
    let tolerance = 1e-6 * (high[along] - low[along]);
    let mut cut = median.max(1);
    for at in (median.saturating_sub(reach).max(1)..=median + reach).filter(|&at| at < elements.len()) {
        let is_nearer = gap(at) > gap(cut) - tolerance && at.abs_diff(median) < cut.abs_diff(median);
        if gap(at) > gap(cut) + tolerance || is_nearer {
            cut = at;
        }
    }
    let second = elements.split_off(cut);
    split(mesh, elements, first_parts, patches);
    split(mesh, second, parts - first_parts, patches);
}
