//! Labels of nodes and elements in frames: numbers of the deck, materials and sets.

use crate::kernel::lists::Memory;
use crate::model::{MemberSet, Mesh, Model};
use crate::output::EntityLabels;

/// Maximum number of node sets, and of element sets, in frames.
const SETS: usize = 32;

/// Materials of elements and user-defined sets, for frames.
#[derive(Clone, Debug, Default, Memory)]
pub struct FrameLabels {
    /// Material number of each mesh element, counted from 1 in the order of the deck; 0 without material.
    materials: Vec<i32>,
    material_names: Vec<String>,
    node_sets: Vec<(String, Vec<u32>)>,
    element_sets: Vec<(String, Vec<u32>)>,
}

impl FrameLabels {
    pub(crate) fn of(model: &Model) -> FrameLabels {
        let mut materials = vec![0; model.mesh.elements.len()];
        for (material, elements) in model.material_regions() {
            elements.iter().for_each(|&e| materials[e] = material.index() as i32 + 1);
        }
        let material_names = model.materials.iter().map(|material| material.name.clone()).collect();
        FrameLabels {
            materials,
            material_names,
            node_sets: named(&model.node_sets),
            element_sets: named(&model.element_sets),
        }
    }

    /// Returns the name of the material of a mesh element; empty without one.
    pub fn material_name(&self, element: usize) -> &str {
        let index = self.materials[element] as usize;
        index.checked_sub(1).and_then(|m| self.material_names.get(m)).map_or("", String::as_str)
    }

    /// Returns the names of the materials in the order of their numbers in frames.
    pub fn material_names(&self) -> &[String] {
        &self.material_names
    }

    /// Returns the labels of the points and cells of a frame, given their mesh nodes and elements.
    pub fn of_frame(&self, mesh: &Mesh, nodes: &[u32], elements: &[u32]) -> (Vec<EntityLabels>, Vec<EntityLabels>) {
        let label = |name: &str, values: Vec<i32>| EntityLabels { name: name.into(), values };
        let of_node = |n: usize| number(&mesh.node_names[n], n);
        let mut points = vec![label("NODE", nodes.iter().map(|&n| of_node(n as usize)).collect())];
        let set_labels = |kind: &str, (name, members): &(String, Vec<u32>), count: usize, items: &[u32]| {
            label(&format!("{kind}_{name}"), marks(members, count, items))
        };
        points.extend(self.node_sets.iter().map(|set| set_labels("NSET", set, mesh.points.len(), nodes)));
        let of_element = |e: usize| number(&mesh.elements[e].name, e);
        let numbers = elements.iter().map(|&e| of_element(e as usize)).collect();
        let materials = elements.iter().map(|&e| self.materials[e as usize]).collect();
        let mut cells = vec![label("ELEMENT", numbers), label("MATERIAL", materials)];
        cells.extend(self.element_sets.iter().map(|set| set_labels("ELSET", set, mesh.elements.len(), elements)));
        (points, cells)
    }
}

/// Returns the sets by name, without the internal sets of ABAQUS/CAE.
fn named(sets: &indexmap::IndexMap<String, MemberSet>) -> Vec<(String, Vec<u32>)> {
    let is_internal = |name: &str| name.rsplit('.').next().is_some_and(|last| last.starts_with('_'));
    let named = sets.iter().filter(|(name, _)| !is_internal(name)).take(SETS);
    named.map(|(name, set)| (name.clone(), set.members.iter().map(|&m| m as u32).collect())).collect()
}

/// Returns the number in the deck; for a name without number the index counted from 1.
fn number(name: &str, place: usize) -> i32 {
    name.rsplit('.').next().and_then(|last| last.parse().ok()).unwrap_or(place as i32 + 1)
}

/// Returns 1 for members of a set and 0 for other items.
fn marks(members: &[u32], count: usize, items: &[u32]) -> Vec<i32> {
    let mut of_all = vec![false; count];
    members.iter().for_each(|&member| of_all[member as usize] = true);
    items.iter().map(|&item| i32::from(of_all[item as usize])).collect()
}
