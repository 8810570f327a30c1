//! Contents of a VTK file, and the mesh that it lists: sets are the arrays `NSET_name` and `ELSET_name`, nonzero on
//! members; labels are `NODE_LABEL` and `ELEMENT_LABEL`, or `NODE` and `ELEMENT` in frames of results.

use std::collections::HashSet;

use super::mesh_data::{ListedMesh, MeshCell};

/// Array that marks hidden cells (`vtkDataSetAttributes`).
pub const BLANKING: &str = "vtkGhostType";

/// The reason for files without lists of cells, for example structured grids.
pub(super) const NOT_A_MESH: &str = "it must be an unstructured grid or poly data";

/// Points, cells and arrays of a VTK file.
#[derive(Debug, Default)]
pub struct VtkMesh {
    /// Coordinates of the points.
    pub points: Vec<[f64; 3]>,
    /// Point indices of each cell: corners, then midside points.
    pub cells: Vec<Vec<usize>>,
    /// VTK number of the type of each cell; empty for poly data.
    pub types: Vec<u8>,
    /// Name and values of each array with one value per point.
    pub point_arrays: Vec<(String, Vec<f64>)>,
    /// Name and values of each array with one value per cell.
    pub cell_arrays: Vec<(String, Vec<f64>)>,
}

const NODE_LABELS: [&str; 2] = ["NODE_LABEL", "NODE"];
const ELEMENT_LABELS: [&str; 2] = ["ELEMENT_LABEL", "ELEMENT"];

/// Returns whether an array defines a set, labels, or hidden cells.
pub(super) fn is_mesh_array(name: &str) -> bool {
    let is_label = NODE_LABELS.contains(&name) || ELEMENT_LABELS.contains(&name);
    is_label || name == BLANKING || set_name(name, "NSET").or(set_name(name, "ELSET")).is_some()
}

/// Returns the name of the set of an array: `ELSET_name`, or `ELSET name`.
fn set_name<'a>(array: &'a str, kind: &str) -> Option<&'a str> {
    array.strip_prefix(kind)?.strip_prefix(['_', ' '])
}

impl VtkMesh {
    /// Returns the mesh with the sets and labels of the arrays, without hidden cells. A file with element labels is a
    /// complete model.
    pub(super) fn into_listed(self) -> ListedMesh {
        let array = |arrays: &[(String, Vec<f64>)], names: [&str; 2]| {
            names.iter().find_map(|name| arrays.iter().find(|array| array.0 == *name).map(|array| array.1.clone()))
        };
        let (node_labels, element_labels) =
            (array(&self.point_arrays, NODE_LABELS), array(&self.cell_arrays, ELEMENT_LABELS));
        let is_hidden = array(&self.cell_arrays, [BLANKING; 2]).unwrap_or_default();
        let is_complete = element_labels.is_some();
        let unread = self.point_arrays.iter().chain(&self.cell_arrays).map(|array| &array.0);
        let mut listed = ListedMesh {
            unread: unread.filter(|name| !is_mesh_array(name)).cloned().collect(),
            is_complete,
            point_labels: unique_labels(node_labels, self.points.len()),
            points: self.points,
            ..ListedMesh::default()
        };
        for (array, values) in &self.point_arrays {
            if let Some(name) = set_name(array, "NSET") {
                listed.add_points(name, members(values));
            }
        }
        let visible: Vec<usize> =
            (0..self.cells.len()).filter(|&cell| is_hidden.get(cell).is_none_or(|value| *value == 0.0)).collect();
        for (array, values) in &self.cell_arrays {
            if let Some(name) = set_name(array, "ELSET") {
                listed.add_cells(name, (0..visible.len()).filter(|&index| values[visible[index]] != 0.0));
            }
        }
        let labels = unique_labels(element_labels, self.cells.len());
        let mut cells = self.cells;
        listed.cells = visible
            .iter()
            .map(|&cell| {
                let points = std::mem::take(&mut cells[cell]);
                MeshCell { label: labels[cell], dimension: dimension(self.types.get(cell), points.len()), points }
            })
            .collect();
        listed
    }
}

/// Returns the dimension of a cell of a type: vertices, lines, faces. Cells of poly data have only a number of points.
fn dimension(kind: Option<&u8>, points: usize) -> usize {
    match kind {
        Some(1) => 0,
        Some(3 | 21) => 1,
        Some(_) => 2,
        None => (points.saturating_sub(1)).min(2),
    }
}

fn members(values: &[f64]) -> impl Iterator<Item = usize> {
    values.iter().enumerate().filter(|(_, value)| **value != 0.0).map(|(index, _)| index)
}

/// Returns labels from the values of an array; labels that are not positive, or that repeat another one, are replaced by
/// new ones.
fn unique_labels(values: Option<Vec<f64>>, count: usize) -> Vec<i64> {
    let Some(values) = values else { return (1..=count as i64).collect() };
    let mut labels: Vec<i64> = values.iter().map(|value| *value as i64).collect();
    let mut next = labels.iter().copied().max().unwrap_or(0).max(0);
    let mut known = HashSet::with_capacity(labels.len());
    for label in &mut labels {
        if *label <= 0 || !known.insert(*label) {
            next = next.saturating_add(1);
            *label = next;
        }
    }
    labels
}
