//! Contents of mesh files, independent of the format: points, cells, labels and sets.

use std::collections::HashMap;

use indexmap::IndexMap;

/// Points, cells and arrays of a mesh file.
#[derive(Debug, Default)]
pub struct MeshFile {
    /// Coordinates of the points.
    pub points: Vec<[f64; 3]>,
    /// Point indices of each cell.
    pub cells: Vec<Vec<usize>>,
    /// Name and values of each array with one value per point.
    pub point_arrays: Vec<(String, Vec<f64>)>,
    /// Name and values of each array with one value per cell.
    pub cell_arrays: Vec<(String, Vec<f64>)>,
    /// Keywords of cards that were not read.
    pub unread: Vec<String>,
}

/// A mesh with labels and named groups, as written by mesh generators.
#[derive(Debug, Default)]
pub(super) struct MeshGroups {
    labels: Vec<i64>,
    points: Vec<[f64; 3]>,
    /// Point index by label; a later definition of a label replaces the earlier one.
    by_label: HashMap<i64, usize>,
    cells: Vec<LabelledCell>,
    /// Labels of the cells in each set.
    cell_sets: IndexMap<String, Vec<i64>>,
    node_sets: IndexMap<String, Vec<i64>>,
    /// Keywords of cards that were not read.
    pub(super) unread: Vec<String>,
}

/// A cell by labels, with its dimension.
#[derive(Debug)]
struct LabelledCell {
    label: i64,
    dimension: usize,
    nodes: Vec<i64>,
}

impl MeshGroups {
    pub(super) fn node(&mut self, label: i64, point: [f64; 3]) {
        if let Some(&known) = self.by_label.get(&label) {
            self.points[known] = point;
            return;
        }
        self.by_label.insert(label, self.points.len());
        self.labels.push(label);
        self.points.push(point);
    }

    pub(super) fn cell(&mut self, label: i64, dimension: usize, nodes: Vec<i64>, sets: &[String]) {
        self.cells.push(LabelledCell { label, dimension, nodes });
        sets.iter().for_each(|set| self.add_cells(set, &[label]));
    }

    pub(super) fn add_cells(&mut self, set: &str, labels: &[i64]) {
        self.cell_sets.entry(set.to_uppercase()).or_default().extend(labels);
    }

    pub(super) fn add_nodes(&mut self, set: &str, labels: &[i64]) {
        self.node_sets.entry(set.to_uppercase()).or_default().extend(labels);
    }

    /// Returns the mesh. Cells of the highest dimension are its elements. Sets of other cells become node sets. With
    /// `all`, sets of elements also become node sets, and clockwise cells are reversed.
    pub(super) fn finish(mut self, all: bool) -> Result<MeshFile, String> {
        let highest = self.cells.iter().map(|c| c.dimension).max().ok_or("it has no elements")?;
        if highest > 2 {
            return Err("it has three-dimensional elements; mesh the r-z half plane instead".into());
        }
        let by_label: HashMap<i64, &LabelledCell> = self.cells.iter().map(|cell| (cell.label, cell)).collect();
        let mut element_sets: Vec<(String, Vec<i64>)> = Vec::new();
        for (name, labels) in std::mem::take(&mut self.cell_sets) {
            let is_element = |l: &&i64| by_label.get(l).is_some_and(|c| c.dimension == highest);
            let elements: Vec<i64> = labels.iter().filter(is_element).copied().collect();
            if all || elements.len() < labels.len() {
                let nodes = labels.iter().filter_map(|l| by_label.get(l)).flat_map(|c| &c.nodes).copied();
                self.node_sets.entry(name.clone()).or_default().extend(nodes);
            }
            if !elements.is_empty() {
                element_sets.push((name, elements));
            }
        }
        let (mut cells, mut labels) = (Vec::new(), Vec::new());
        for LabelledCell { label, dimension, nodes } in self.cells.iter().filter(|c| c.dimension == highest) {
            let indices: Option<Vec<usize>> = nodes.iter().map(|n| self.by_label.get(n).copied()).collect();
            let mut cell = indices.ok_or_else(|| format!("element {label} refers to an undefined node"))?;
            // Corner nodes precede midside nodes.
            let corners = if cell.len() == 6 { 3 } else { cell.len() };
            if all && *dimension == 2 && area(&self.points, &cell[..corners]) < 0.0 {
                let (corners, middles) = cell.split_at_mut(corners);
                corners[1..].reverse();
                middles.reverse();
            }
            cells.push(cell);
            labels.push(*label);
        }
        let mark = |labels: &[i64], members: &[i64]| {
            let members: std::collections::HashSet<i64> = members.iter().copied().collect();
            labels.iter().map(|l| f64::from(u8::from(members.contains(l)))).collect::<Vec<f64>>()
        };
        let numbers = |labels: &[i64]| labels.iter().map(|l| *l as f64).collect::<Vec<f64>>();
        let mut point_arrays = vec![("NODE_LABEL".to_owned(), numbers(&self.labels))];
        point_arrays.extend(self.node_sets.iter().map(|(n, m)| (format!("NSET_{n}"), mark(&self.labels, m))));
        let mut cell_arrays = vec![("ELEMENT_LABEL".to_owned(), numbers(&labels))];
        cell_arrays.extend(element_sets.iter().map(|(n, m)| (format!("ELSET_{n}"), mark(&labels, m))));
        Ok(MeshFile { points: self.points, cells, point_arrays, cell_arrays, unread: self.unread })
    }
}

fn area(points: &[[f64; 3]], cell: &[usize]) -> f64 {
    let pair = |i: usize| (points[cell[i]], points[cell[(i + 1) % cell.len()]]);
    (0..cell.len()).map(pair).map(|(p, q)| 0.5 * (p[0] * q[1] - q[0] * p[1])).sum()
}

/// Returns whether an array defines a set or labels.
pub(super) fn is_recognized_array(name: &str) -> bool {
    name.starts_with("NSET_") || name.starts_with("ELSET_") || name.ends_with("_LABEL")
}
