//! Connected parts of a mesh.

use rustc_hash::FxHashMap;

use crate::kernel::disjoint_sets::DisjointSets;
use crate::model::{ElementSide, Mesh, Model};
use crate::plan::Scene;

/// Splits elements into parts that are connected by common nodes, in the order of their first elements.
pub fn pieces(mesh: &Mesh, elements: &[usize]) -> Vec<Vec<usize>> {
    let mut sets = DisjointSets::new(mesh.points.len());
    for &e in elements {
        let nodes = &mesh.elements[e].nodes;
        nodes[1..].iter().for_each(|&n| sets.unite(nodes[0], n));
    }
    let mut by_root: FxHashMap<usize, usize> = FxHashMap::default();
    let mut pieces: Vec<Vec<usize>> = Vec::new();
    for &e in elements {
        let key = sets.representative(mesh.elements[e].nodes[0]);
        let piece = *by_root.entry(key).or_insert_with(|| {
            pieces.push(Vec::new());
            pieces.len() - 1
        });
        pieces[piece].push(e);
    }
    pieces
}

/// Returns the elements of each connected part that can be in contact, ascending.
pub fn parts_in_contact(scene: Scene) -> Vec<Vec<usize>> {
    let mesh = &scene.model.mesh;
    let known = |e: &usize| scene.places.elements.contains_key(e) || scene.bodies.of_element.contains_key(e);
    let elements: Vec<usize> =
        (0..mesh.elements.len()).filter(|e| !mesh.elements[*e].kind.is_discrete()).filter(known).collect();
    pieces(mesh, &elements)
}

/// Returns the index of the part to which each element of the mesh belongs.
pub fn part_of_elements<'a>(mesh: &Mesh, parts: impl Iterator<Item = &'a [usize]>) -> Vec<Option<u32>> {
    let mut part_of = vec![None; mesh.elements.len()];
    for (part, index) in parts.zip(0..) {
        part.iter().for_each(|&e| part_of[e] = Some(index));
    }
    part_of
}

/// Returns the exterior faces of the mesh that belong to each part.
pub fn exterior_faces_of<'a>(
    mesh: &Mesh,
    parts: impl Iterator<Item = &'a [usize]> + Clone,
) -> Vec<Vec<(usize, ElementSide)>> {
    let part_of = part_of_elements(mesh, parts.clone());
    let mut faces = vec![Vec::new(); parts.count()];
    for face in mesh.exterior_faces() {
        part_of[face.0].into_iter().for_each(|part| faces[part as usize].push(face));
    }
    faces
}

/// Element sets that contain the first element of a part, from the smallest to the largest, by that element.
pub struct SetsOfParts<'a>(FxHashMap<usize, Vec<(&'a str, &'a [usize])>>);

impl<'a> SetsOfParts<'a> {
    pub fn new<'p>(model: &'a Model, parts: impl Iterator<Item = &'p [usize]>) -> SetsOfParts<'a> {
        let mut by_first: FxHashMap<usize, Vec<(&str, &[usize])>> = parts.map(|part| (part[0], Vec::new())).collect();
        for (name, set) in &model.element_sets {
            for member in &set.members {
                by_first.entry(*member).and_modify(|sets| sets.push((name, &set.members)));
            }
        }
        by_first.values_mut().for_each(|sets| sets.sort_by_key(|set| set.1.len()));
        SetsOfParts(by_first)
    }

    /// Returns the name of the smallest element set that contains a part; the first one of equally large sets.
    pub fn smallest_around(&self, part: &[usize]) -> Option<&'a str> {
        let holds = |members: &[usize]| part.iter().all(|e| members.binary_search(e).is_ok());
        self.0.get(part.first()?)?.iter().find(|set| holds(set.1)).map(|set| set.0)
    }
}
