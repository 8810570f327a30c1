//! By what nodes and elements are found in frames: the deck's numbers, materials, sets.
//! Never here: files.

use crate::kernel::lists::heap_bytes;
use crate::model::{Mesh, Model, Set};
use crate::output::Label;

/// Sets beyond these are left out of frames.
const SETS: usize = 32;

/// Materials of elements, and the sets that people have named.
#[derive(Clone, Debug, Default)]
pub struct Labels {
    /// Of each element of the mesh, the place of its material in the deck, from 1; 0 without any.
    materials: Vec<i32>,
    node_sets: Vec<(String, Vec<u32>)>,
    element_sets: Vec<(String, Vec<u32>)>,
}

impl Labels {
    pub(super) fn of(model: &Model) -> Labels {
        let mut materials = vec![0; model.mesh.elements.len()];
        for (material, elements) in model.made_of() {
            elements.iter().for_each(|&e| materials[e] = material.index() as i32 + 1);
        }
        Labels { materials, node_sets: named(&model.node_sets), element_sets: named(&model.element_sets) }
    }

    pub(super) fn bytes(&self) -> usize {
        let sets = |list: &Vec<(String, Vec<u32>)>| {
            let of = |(name, members): &(String, Vec<u32>)| name.capacity() + heap_bytes(members);
            heap_bytes(list) + list.iter().map(of).sum::<usize>()
        };
        heap_bytes(&self.materials) + sets(&self.node_sets) + sets(&self.element_sets)
    }

    /// Labels of these nodes and elements of the mesh, which are the points and cells of a frame.
    pub fn of_frame(&self, mesh: &Mesh, nodes: &[usize], elements: &[usize]) -> (Vec<Label>, Vec<Label>) {
        let label = |name: &str, values: Vec<i32>| Label { name: name.into(), values };
        let mut points = vec![label("NODE", nodes.iter().map(|&n| number(&mesh.node_names[n], n)).collect())];
        let of = |kind: &str, (name, members): &(String, Vec<u32>), count: usize, items: &[usize]| {
            label(&format!("{kind} {name}"), marks(members, count, items))
        };
        points.extend(self.node_sets.iter().map(|set| of("NSET", set, mesh.points.len(), nodes)));
        let numbers = elements.iter().map(|&e| number(&mesh.elements[e].name, e)).collect();
        let materials = elements.iter().map(|&e| self.materials[e]).collect();
        let mut cells = vec![label("ELEMENT", numbers), label("MATERIAL", materials)];
        cells.extend(self.element_sets.iter().map(|set| of("ELSET", set, mesh.elements.len(), elements)));
        (points, cells)
    }
}

/// Sets by name, without those that CAE writes for itself.
fn named(sets: &indexmap::IndexMap<String, Set>) -> Vec<(String, Vec<u32>)> {
    let own = |name: &str| name.rsplit('.').next().is_some_and(|last| last.starts_with('_'));
    let named = sets.iter().filter(|(name, _)| !own(name)).take(SETS);
    named.map(|(name, set)| (name.clone(), set.members.iter().map(|&m| m as u32).collect())).collect()
}

/// The deck's number; of a name that is none the place, from 1.
fn number(name: &str, place: usize) -> i32 {
    name.rsplit('.').next().and_then(|last| last.parse().ok()).unwrap_or(place as i32 + 1)
}

/// 1 for members of a set, 0 for others.
fn marks(members: &[u32], count: usize, items: &[usize]) -> Vec<i32> {
    let mut of_all = vec![0; count];
    members.iter().for_each(|&member| of_all[member as usize] = 1);
    items.iter().map(|&item| of_all[item]).collect()
}
