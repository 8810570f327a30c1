//! Faces of bodies that ties join node by node: they are inside a body, and general contact leaves them out.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::kernel::lists::sorted_pair;
use crate::plan::{Links, Scene};

/// Identifies the motion of a node along r and z: sets of nodes with equal motion. Nodes on the axis do not move along r.
type NodeMotion = [usize; 2];

const NONE: usize = usize::MAX;

/// Returns the exterior faces, as ascending pairs of mesh nodes, whose ends have the same motion as the ends of another exterior
/// face.
pub fn tied_faces(scene: Scene, links: &Links) -> FxHashSet<[usize; 2]> {
    let mesh = &scene.model.mesh;
    if links.merged.is_empty() || scene.model.constraints.ties.is_empty() {
        return FxHashSet::default();
    }
    let mut faces: FxHashMap<[NodeMotion; 2], Vec<[usize; 2]>> = FxHashMap::default();
    for (element, side) in mesh.exterior_faces() {
        let Some(ends) = mesh.side_nodes(element, side) else { continue };
        let [Some(first), Some(second)] = ends.map(|node| motion_of(scene, links, node)) else { continue };
        // The faces of a surface that moves as a rigid body are exterior.
        if first != second {
            faces.entry(sorted_pair([first, second])).or_default().push(sorted_pair(ends));
        }
    }
    faces.into_values().filter(|alike| alike.len() > 1).flatten().collect()
}

/// Returns the motion of a node that has the motion of others along both axes.
fn motion_of(scene: Scene, links: &Links, node: usize) -> Option<NodeMotion> {
    let place = scene.places.free_node(node)?;
    let set = |axis: usize| links.group.get(&(place, axis)).copied();
    let along_r = if scene.model.mesh.points[node][0] == 0.0 { NONE } else { set(0)? };
    Some([along_r, set(1)?])
}
