//! New elements in a part of a body: its worst elements and some rings around them are meshed again, and all others keep
//! their nodes. The part has the nodes of its edges to the other elements.

use rustc_hash::FxHashMap;

use super::improvement::quality;
use super::mesher::{OutlineRules, new_mesh};
use super::outline::{BoundaryEdge, boundary_edges, loops};
use super::{BodyMesh, INSIDE, MeshRevision, RevisedSide};
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::sorted_unique;
use crate::kernel::shape::{distance, elements_around};

/// Quality below which an element is meshed again; that of squares at the axis is 0.75.
const POOR: f64 = 0.5;
/// Rings of elements around the poor ones, tried one after the other up to the first good mesh.
const RINGS: [usize; 3] = [2, 3, 4];
/// Shortest and longest edge between the patch and the other elements, in units of the wanted edge.
const EDGES: [f64; 2] = [0.5, 2.0];
/// Cosine of the largest change of direction between two such edges, 110 degrees.
const SHARPEST: f64 = -0.342;
/// Largest fraction of the elements of a body in a patch. Above it, the whole body has a new mesh.
const LARGEST: f64 = 0.6;
/// Quality of the worst new element from which on a patch is good.
const SUFFICIENT: f64 = 0.35;
/// Smallest number of connected elements outside a patch; fewer are included.
const FEWEST: usize = 12;
/// Largest number of rounds in which a patch grows.
const ROUNDS: usize = 20;

/// Meshes the poor elements of a body again, with rings of elements around them. Returns `None` if no element is poor, if the
/// patch is a large part of the body, or if no valid mesh is found.
pub fn new_patch(old: &BodyMesh, rules: &OutlineRules<'_>) -> Option<MeshRevision> {
    let adjacency = Adjacency::new(old);
    for rings in RINGS {
        let chosen = adjacency.select(rings)?;
        let Some(revision) = Patch::new(old, &chosen).and_then(|patch| patch.meshed(old, rules)) else { continue };
        let mesh = &revision.mesh;
        let new = mesh.quads.iter().zip(&mesh.sizes).skip(revision.unchanged);
        let worst = new.map(|(quad, wanted)| quality(quad, &mesh.points, *wanted)).fold(f64::INFINITY, f64::min);
        if worst > SUFFICIENT {
            return Some(revision);
        }
    }
    None
}

/// Elements at the sides and nodes of a mesh.
struct Adjacency<'a> {
    mesh: &'a BodyMesh,
    around: Vec<Vec<u32>>,
    /// Element on the left of each directed side.
    of_side: FxHashMap<[u32; 2], u32>,
}

/// A side between the patch, on its left, and another element.
#[derive(Clone, Copy)]
struct RimSide {
    ends: [u32; 2],
    outside: u32,
}

/// Returns the directed sides of an element.
fn sides(quad: &[u32; 4]) -> impl Iterator<Item = [u32; 2]> + '_ {
    (0..4).map(|i| [quad[i], quad[(i + 1) % 4]]).filter(|[a, b]| a != b)
}

impl Adjacency<'_> {
    fn new(mesh: &BodyMesh) -> Adjacency<'_> {
        let of_side = (0..).zip(&mesh.quads).flat_map(|(e, quad)| sides(quad).map(move |side| (side, e))).collect();
        Adjacency { mesh, around: elements_around(&mesh.quads, mesh.points.len()), of_side }
    }

    /// Returns whether each element is in the patch of the poor elements and a number of rings.
    fn select(&self, rings: usize) -> Option<Vec<bool>> {
        let mesh = self.mesh;
        let is_poor = |(quad, size): (&[u32; 4], &f64)| quality(quad, &mesh.points, *size) < POOR;
        let mut chosen: Vec<bool> = mesh.quads.iter().zip(&mesh.sizes).map(is_poor).collect();
        for _ in 0..rings {
            let ring: Vec<u32> = self.chosen_elements(&chosen).flat_map(|e| self.neighbours(e)).collect();
            ring.into_iter().for_each(|e| chosen[e as usize] = true);
        }
        for _ in 0..ROUNDS {
            if chosen.iter().filter(|is_in| **is_in).count() as f64 > LARGEST * chosen.len() as f64 {
                return None;
            }
            let mut added = self.small_rests(&chosen);
            let rim = self.rim(&chosen);
            added.extend(self.beside_unsuitable_sides(&rim));
            added.extend(self.at_sharp_nodes(&rim));
            if added.is_empty() {
                added = self.beside_odd_runs(&chosen)?;
            }
            if added.is_empty() {
                return chosen.contains(&true).then_some(chosen);
            }
            added.into_iter().for_each(|e| chosen[e as usize] = true);
        }
        None
    }

    fn chosen_elements<'b>(&self, chosen: &'b [bool]) -> impl Iterator<Item = u32> + 'b {
        (0..).zip(chosen).filter(|(_, is_in)| **is_in).map(|(e, _)| e)
    }

    /// Returns the elements with a common node.
    fn neighbours(&self, e: u32) -> impl Iterator<Item = u32> + '_ {
        self.mesh.quads[e as usize].into_iter().flat_map(|n| self.around[n as usize].iter().copied())
    }

    /// Returns the sides between the patch and other elements, in the order of their nodes.
    fn rim(&self, chosen: &[bool]) -> Vec<RimSide> {
        let of_element = |e: u32| {
            sides(&self.mesh.quads[e as usize]).filter_map(|ends| {
                let outside = *self.of_side.get(&[ends[1], ends[0]])?;
                (!chosen[outside as usize]).then_some(RimSide { ends, outside })
            })
        };
        let mut rim: Vec<RimSide> = self.chosen_elements(chosen).flat_map(of_element).collect();
        rim.sort_unstable_by_key(|side| side.ends);
        rim
    }

    /// Returns the elements of small connected parts outside the patch.
    fn small_rests(&self, chosen: &[bool]) -> Vec<u32> {
        let (mut is_seen, mut small) = (chosen.to_vec(), Vec::new());
        for first in 0..chosen.len() {
            if std::mem::replace(&mut is_seen[first], true) {
                continue;
            }
            let (mut part, mut next) = (vec![first as u32], 0);
            while next < part.len() {
                for [a, b] in sides(&self.mesh.quads[part[next] as usize]) {
                    let Some(&other) = self.of_side.get(&[b, a]) else { continue };
                    if !std::mem::replace(&mut is_seen[other as usize], true) {
                        part.push(other);
                    }
                }
                next += 1;
            }
            if part.len() < FEWEST {
                small.extend(part);
            }
        }
        small
    }

    /// Returns the other elements at sides of the rim that are too short or too long for new elements.
    fn beside_unsuitable_sides(&self, rim: &[RimSide]) -> Vec<u32> {
        let is_unsuitable = |side: &&RimSide| {
            let [a, b] = side.ends.inline_map(|n| self.mesh.points[n as usize]);
            let ratio = distance(a, b) / self.mesh.sizes[side.outside as usize];
            !(EDGES[0]..=EDGES[1]).contains(&ratio)
        };
        rim.iter().filter(is_unsuitable).map(|side| side.outside).collect()
    }

    /// Returns the other elements at nodes where the rim touches itself, or turns sharply.
    fn at_sharp_nodes(&self, rim: &[RimSide]) -> Vec<u32> {
        let mut added = Vec::new();
        for (i, side) in rim.iter().enumerate() {
            let node = side.ends[1];
            let first = rim.partition_point(|other| other.ends[0] < node);
            let next = rim[first..].iter().take_while(|other| other.ends[0] == node);
            let touches = i > 0 && rim[i - 1].ends[0] == side.ends[0];
            let [a, b] = side.ends.inline_map(|n| self.mesh.points[n as usize]);
            let is_sharp = next.clone().count() > 1
                || next.clone().any(|other| {
                    let c = self.mesh.points[other.ends[1] as usize];
                    let product = (b[0] - a[0]) * (c[0] - b[0]) + (b[1] - a[1]) * (c[1] - b[1]);
                    product < SHARPEST * distance(a, b) * distance(b, c)
                });
            if is_sharp || touches {
                let node = if touches { side.ends[0] } else { node };
                added.extend(self.around[node as usize].iter().filter(|e| rim.iter().any(|side| side.outside == **e)));
            }
        }
        added
    }

    /// Returns an element at each run of the rim between two nodes of the outline that has an odd number of sides, so that
    /// the run gets one more. `None` if there is none.
    fn beside_odd_runs(&self, chosen: &[bool]) -> Option<Vec<u32>> {
        let rim = self.rim(chosen);
        let mut added = Vec::new();
        let begins = |side: &&RimSide| !rim.iter().any(|other| other.ends[1] == side.ends[0]);
        for first in rim.iter().filter(begins) {
            let (mut last, mut count) = (first, 1);
            while let Some(next) = rim.iter().find(|side| side.ends[0] == last.ends[1]) {
                (last, count) = (next, count + 1);
            }
            if count % 2 == 1 {
                let on_outline = |e: u32, node: u32| {
                    let is_open = |[a, b]: [u32; 2]| (a == node || b == node) && !self.of_side.contains_key(&[b, a]);
                    sides(&self.mesh.quads[e as usize]).any(is_open)
                };
                let pairs = [(last.outside, last.ends[1]), (first.outside, first.ends[0])];
                added.push(pairs.into_iter().find(|(e, node)| on_outline(*e, *node))?.0);
            }
        }
        Some(added)
    }
}

/// A part of a body, with its own numbering of nodes.
struct Patch {
    /// Elements and nodes of the body.
    elements: Vec<u32>,
    nodes: Vec<u32>,
    mesh: BodyMesh,
    /// Edges between the patch and the other elements, in ascending order.
    rim: Vec<[u32; 2]>,
}

impl Patch {
    /// Returns the patch of chosen elements; `None` if its boundary touches itself in a node.
    fn new(old: &BodyMesh, chosen: &[bool]) -> Option<Patch> {
        let elements: Vec<u32> = (0..).zip(chosen).filter(|(_, is_in)| **is_in).map(|(e, _)| e).collect();
        let corners = elements.iter().flat_map(|e| old.quads[*e as usize]);
        let nodes = sorted_unique(corners);
        let number_in_patch = |n: u32| nodes.partition_point(|other| *other < n) as u32;
        let mesh = BodyMesh {
            points: nodes.iter().map(|n| old.points[*n as usize]).collect(),
            quads: elements.iter().map(|e| old.quads[*e as usize].inline_map(number_in_patch)).collect(),
            sizes: elements.iter().map(|e| old.sizes[*e as usize]).collect(),
        };
        let outline: Vec<[u32; 2]> = boundary_edges(&old.quads).iter().map(|edge| edge.ends).collect();
        let is_inside =
            |edge: &BoundaryEdge| outline.binary_search(&edge.ends.inline_map(|n| nodes[n as usize])).is_err();
        let boundary = loops(&mesh)?;
        let mut rim: Vec<[u32; 2]> = boundary.iter().flatten().filter(|edge| is_inside(edge)).map(|e| e.ends).collect();
        rim.sort_unstable();
        Some(Patch { elements, nodes, mesh, rim })
    }

    /// Returns the mesh of the body with new elements in the patch.
    fn meshed(&self, old: &BodyMesh, rules: &OutlineRules<'_>) -> Option<MeshRevision> {
        let mut kept_nodes: Vec<bool> = self.nodes.iter().map(|n| rules.kept[*n as usize]).collect();
        self.rim.iter().flatten().for_each(|n| kept_nodes[*n as usize] = true);
        let in_patch = |n: u32| self.nodes.binary_search(&n).ok().map(|at| at as u32);
        let of_body = rules.fixed.iter().filter_map(|[a, b]| Some([in_patch(*a)?, in_patch(*b)?]));
        let fixed = sorted_unique(of_body.chain(self.rim.iter().copied()));
        let place_between = |ends: [u32; 2], share| (rules.place)(ends.inline_map(|n| self.nodes[n as usize]), share);
        let new =
            new_mesh(&self.mesh, &OutlineRules { kept: &kept_nodes, fixed: &fixed, place: &place_between }, None)?;
        self.joined(old, &new)
    }

    /// Joins a new mesh of the patch to the other elements of the body; `None` if it does not have all edges of the rim.
    fn joined(&self, old: &BodyMesh, new: &MeshRevision) -> Option<MeshRevision> {
        let in_patch = |e: &u32| self.elements.binary_search(e).is_ok();
        let others: Vec<u32> = (0..old.quads.len() as u32).filter(|e| !in_patch(e)).collect();
        let old_corners = others.iter().flat_map(|e| old.quads[*e as usize]);
        let other_nodes = sorted_unique(old_corners);
        let of_other = |n: u32| other_nodes.binary_search(&n).ok().map(|at| at as u32);
        let mut joined = MeshRevision { unchanged: others.len(), origins: others.clone(), ..MeshRevision::default() };
        joined.parents = other_nodes.iter().map(|n| [*n; 2]).collect();
        let mesh = &mut joined.mesh;
        mesh.points = other_nodes.iter().map(|n| old.points[*n as usize]).collect();
        let number = |(point, parents): (&[f64; 2], &[u32; 2])| {
            let of_body = parents.inline_map(|n| if n == INSIDE { n } else { self.nodes[n as usize] });
            let on_rim = if of_body[0] == of_body[1] { of_other(of_body[0]) } else { None };
            on_rim.unwrap_or_else(|| {
                mesh.points.push(*point);
                joined.parents.push(of_body);
                mesh.points.len() as u32 - 1
            })
        };
        let numbers: Vec<u32> = new.mesh.points.iter().zip(&new.parents).map(number).collect();
        for (point, n) in new.mesh.points.iter().zip(&numbers) {
            if (*n as usize) < other_nodes.len() && mesh.points[*n as usize] != *point {
                return None;
            }
        }
        let renumbered = |quad: &[u32; 4]| quad.inline_map(|n| numbers[n as usize]);
        let of_others = others.iter().map(|e| old.quads[*e as usize].inline_map(|n| of_other(n).unwrap_or_default()));
        mesh.quads = of_others.chain(new.mesh.quads.iter().map(renumbered)).collect();
        mesh.sizes = others.iter().map(|e| old.sizes[*e as usize]).chain(new.mesh.sizes.iter().copied()).collect();
        joined.origins.extend(new.origins.iter().map(|origin| self.elements[*origin as usize]));
        if !self.fits(&joined.mesh, old) {
            return None;
        }
        self.relate_sides(old, new, &mut joined);
        Some(joined)
    }

    /// Returns whether a joined mesh has as many outlines as the old one, so that all edges of the rim are inside.
    fn fits(&self, joined: &BodyMesh, old: &BodyMesh) -> bool {
        let count = |mesh: &BodyMesh| loops(mesh).map(|loops| loops.len());
        count(joined).is_some_and(|loops| Some(loops) == count(old))
    }

    /// Relates the sides on the outline of the body to those of the old mesh.
    fn relate_sides(&self, old: &BodyMesh, new: &MeshRevision, joined: &mut MeshRevision) {
        let others = &joined.origins[..joined.unchanged];
        let of_other = |edge: BoundaryEdge| {
            let (e, side) = edge.side;
            let new = others.binary_search(&e).ok()? as u32;
            Some(RevisedSide { new: (new, side), old: edge.side })
        };
        joined.sides = boundary_edges(&old.quads).into_iter().filter_map(of_other).collect();
        let rim_sides: Vec<(u32, u8)> = boundary_edges(&self.mesh.quads)
            .iter()
            .filter(|edge| self.rim.binary_search(&edge.ends).is_ok())
            .map(|edge| edge.side)
            .collect();
        for side in new.sides.iter().filter(|side| !rim_sides.contains(&side.old)) {
            let (e, of_old) = side.old;
            let new = (side.new.0 + joined.unchanged as u32, side.new.1);
            joined.sides.push(RevisedSide { new, old: (self.elements[e as usize], of_old) });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::new_patch;
    use crate::kernel::shape::{corner_shape, quad_area};
    use crate::remesh::mesher::OutlineRules;
    use crate::remesh::outline::loops;
    use crate::remesh::{BodyMesh, INSIDE, MeshRevision};

    /// Returns a block of `n` by `m` squares of the size 1, whose rows below `flat` have a tenth of the height.
    fn block(n: u32, m: u32, flat: u32) -> BodyMesh {
        let height = |j: u32| 0.1 * f64::from(j.min(flat)) + f64::from(j.saturating_sub(flat));
        let points = (0..=m).flat_map(|j| (0..=n).map(move |i| (i, j)));
        let quad = |(i, j): (u32, u32)| [0, 1, n + 2, n + 1].map(|k| i + j * (n + 1) + k);
        let quads: Vec<[u32; 4]> = (0..m).flat_map(|j| (0..n).map(move |i| (i, j))).map(quad).collect();
        let points = points.map(|(i, j)| [f64::from(i), height(j)]).collect();
        BodyMesh { points, sizes: vec![1.0; quads.len()], quads }
    }

    fn patched(mesh: &BodyMesh) -> Option<MeshRevision> {
        new_patch(mesh, &OutlineRules { kept: &vec![false; mesh.points.len()], fixed: &[], place: &|_, _| None })
    }

    /// Blocks with an even and an odd number of elements along the edge of the patch: the other elements are the same, the
    /// patch fills the rest without a gap, and its elements are valid.
    #[test]
    fn a_patch_joins_the_other_elements() {
        for n in [5, 6, 9] {
            let old = block(n, 20, 5);
            let new = patched(&old).expect("a patch");
            let MeshRevision { mesh, parents, origins, unchanged, .. } = &new;
            println!(
                "{n}: {unchanged} of {} elements unchanged, {} new",
                old.quads.len(),
                mesh.quads.len() - unchanged
            );
            assert!(*unchanged >= 8 * n as usize && mesh.quads.len() > *unchanged);
            for (quad, origin) in mesh.quads[..*unchanged].iter().zip(origins) {
                assert_eq!(quad.map(|i| parents[i as usize]), old.quads[*origin as usize].map(|i| [i; 2]));
                assert_eq!(mesh.corners(quad), old.corners(&old.quads[*origin as usize]));
            }
            assert!(mesh.quads.iter().all(|quad| corner_shape(quad, &mesh.points) > 0.05));
            let area = |mesh: &BodyMesh| mesh.quads.iter().map(|quad| quad_area(mesh.corners(quad))).sum::<f64>();
            assert!((area(mesh) / area(&old) - 1.0).abs() < 1e-12);
            // One outline, with a side of the old one for each of its edges.
            let outline = loops(mesh).expect("an outline");
            assert_eq!((outline.len(), outline[0].len()), (1, new.sides.len()));
            assert!(outline[0].iter().all(|edge| parents[edge.ends[0] as usize][0] != INSIDE));
        }
    }

    #[test]
    fn sound_bodies_and_bodies_of_poor_elements_have_no_patch() {
        assert!(patched(&block(6, 20, 0)).is_none());
        assert!(patched(&block(6, 20, 15)).is_none());
    }
}
