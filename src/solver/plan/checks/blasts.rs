//! Checks of blast waves: a surface that faces away from its charge.

use super::finding::warn_about;
use crate::model::{ElementSide, LoadKind, Model};
use crate::plan::Report;

/// Warns of a blast on a surface all of whose faces face away from the charge. A wave reaches it through the body only.
pub fn check_blasts(model: &Model, report: &mut Report) {
    for load in model.steps.iter().flat_map(|step| &step.loads) {
        let LoadKind::Blast { sides, height, .. } = &load.kind else { continue };
        if sides.faces.is_empty() || !sides.free_face_elements.is_empty() {
            continue;
        }
        if sides.faces.iter().all(|&face| faces_away(model, face, [0.0, *height])) {
            let message = format!("all faces of `{}` face away from the charge at z = {height:e}", sides.name);
            let help =
                "check the coordinates of the source node, and the sides of the surface (SPOS or SNEG for shells)";
            return warn_about("P154", message, (load.span, "this surface"), help, report);
        }
    }
}

/// Returns whether the outward normal of a face points away from a place.
fn faces_away(model: &Model, (element, side): (usize, ElementSide), place: [f64; 2]) -> bool {
    let Some(nodes) = model.mesh.side_nodes(element, side) else { return false };
    let [a, b] = nodes.map(|n| model.mesh.points[n]);
    // Nodes of solids are counter-clockwise, so that the outside is to the right; SPOS is to the left.
    let sign = if side == ElementSide::Positive { -1.0 } else { 1.0 };
    let normal = [sign * (b[1] - a[1]), -sign * (b[0] - a[0])];
    let way = [0, 1].map(|i| place[i] - 0.5 * (a[i] + b[i]));
    normal[0] * way[0] + normal[1] * way[1] < 0.0
}
