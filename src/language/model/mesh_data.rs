//! Meshes of files, independent of the format: cells of any dimension and named groups, and the elements, sets and
//! surfaces of the r-z plane that follow from them.
//!
//! One rule holds for all formats. Faces become elements, counter-clockwise; a cell that is listed more than once (once
//! per group in Gmsh's MSH 2.2) is one element. Groups of faces become element sets and node sets; groups of edges
//! become node sets and surfaces; groups of points become node sets. Lines that are no edge of a face are rigid
//! elements.

use std::collections::HashMap;

use indexmap::{IndexMap, IndexSet};

/// A cell of a file.
#[derive(Clone, Debug)]
pub(super) struct MeshCell {
    pub label: i64,
    pub dimension: usize,
    /// Point indices: corners before midside points.
    pub points: Vec<usize>,
}

/// A mesh as a file lists it.
#[derive(Debug, Default)]
pub(super) struct ListedMesh {
    /// Coordinates and labels of the points.
    pub points: Vec<[f64; 3]>,
    pub point_labels: Vec<i64>,
    pub cells: Vec<MeshCell>,
    /// Names of groups, with indices of cells or points.
    pub cell_groups: IndexMap<String, Vec<usize>>,
    pub point_groups: IndexMap<String, Vec<usize>>,
    /// Surfaces: cell, and face counted from 0.
    pub surfaces: IndexMap<String, Vec<(usize, usize)>>,
    /// Cards or arrays that are not read.
    pub unread: Vec<String>,
    /// Sets with members that are not defined, and the number of undefined members.
    pub undefined_members: IndexMap<String, usize>,
    /// Whether the file is a complete model: each cell is an element, and all node sets are listed.
    pub is_complete: bool,
}

/// Elements, sets and surfaces in the r-z plane; members of sets are indices.
#[derive(Debug, Default)]
pub(super) struct PlaneMesh {
    pub points: Vec<[f64; 3]>,
    pub point_labels: Vec<i64>,
    pub elements: Vec<MeshCell>,
    pub node_sets: IndexMap<String, Vec<usize>>,
    /// Nodes of the cells of each group, unless the file has a node set of this name.
    pub nodes_of_groups: IndexMap<String, Vec<usize>>,
    pub element_sets: IndexMap<String, Vec<usize>>,
    /// Surfaces: element, and face counted from 0.
    pub surfaces: IndexMap<String, Vec<(usize, usize)>>,
    pub unread: Vec<String>,
    pub undefined_members: IndexMap<String, usize>,
    /// Number of cells that repeat another one.
    pub repeated_cells: usize,
}

/// Largest number of points of a cell.
const MOST_POINTS: usize = 6;

/// Part of the reason if a program has written each face apart.
pub(super) const NO_COMMON_POINTS: &str = "have no common points";

/// Rounding errors of coordinates, as a fraction of the largest one.
const ROUNDING: f64 = 1e-12;

/// Returns whether a point is in the half-plane of the model.
pub fn is_in_half_plane(&[x, y, z]: &[f64; 3]) -> bool {
    z == 0.0 && x >= 0.0 && x.is_finite() && y.is_finite()
}

/// Faces of the elements by the two corners of each.
struct EdgeMap(HashMap<[usize; 2], EdgeOwner>);

#[derive(Clone, Copy, Debug, PartialEq)]
enum EdgeOwner {
    /// Cell, and face counted from 0.
    One(usize, usize),
    Several,
}

impl EdgeMap {
    fn new(cells: &[MeshCell], is_used: impl Fn(usize) -> bool) -> EdgeMap {
        let mut owners = HashMap::new();
        let faces = cells.iter().enumerate().filter(|(index, cell)| cell.dimension == 2 && is_used(*index));
        for (index, cell) in faces {
            let corners = cell.corners();
            for face in 0..corners.len() {
                let edge = sorted([corners[face], corners[(face + 1) % corners.len()]]);
                let owner = EdgeOwner::One(index, face);
                owners.entry(edge).and_modify(|known| *known = EdgeOwner::Several).or_insert(owner);
            }
        }
        EdgeMap(owners)
    }

    /// Returns the owner of a line, if it is an edge of a face. The middle point of a line of second order may be anywhere in
    /// its list: Gmsh writes it second in .inp files and third in .msh files.
    fn owner(&self, line: &MeshCell) -> Option<EdgeOwner> {
        let ends = [[0, 1], [0, 2], [1, 2]].into_iter().filter(|_| line.dimension == 1);
        let points = ends.filter_map(|[a, b]| Some(sorted([*line.points.get(a)?, *line.points.get(b)?])));
        points.filter_map(|edge| self.0.get(&edge).copied()).next()
    }
}

fn sorted([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

impl MeshCell {
    /// Returns the corners: a face of six points has three midside points.
    fn corners(&self) -> &[usize] {
        &self.points[..corner_count(self.points.len())]
    }

    /// Reverses the order around the boundary; the first corner stays.
    fn reverse(&mut self) {
        let corner_count = corner_count(self.points.len());
        let (corners, middles) = self.points.split_at_mut(corner_count);
        corners[1..].reverse();
        middles.reverse();
    }

    fn area(&self, points: &[[f64; 3]]) -> f64 {
        let corners = self.corners();
        let pair = |i: usize| (points[corners[i]], points[corners[(i + 1) % corners.len()]]);
        (0..corners.len()).map(pair).map(|(p, q)| 0.5 * (p[0] * q[1] - q[0] * p[1])).sum()
    }
}

fn corner_count(points: usize) -> usize {
    if points == 6 { 3 } else { points }
}

impl ListedMesh {
    /// Adds cells to a group.
    pub fn add_cells(&mut self, group: &str, cells: impl IntoIterator<Item = usize>) {
        self.cell_groups.entry(group_name(group)).or_default().extend(cells);
    }

    /// Adds points to a group.
    pub fn add_points(&mut self, group: &str, points: impl IntoIterator<Item = usize>) {
        self.point_groups.entry(group_name(group)).or_default().extend(points);
    }

    /// Returns elements, sets and surfaces.
    ///
    /// # Errors
    /// The reason if there are no cells, or cells that are no elements of the r-z plane.
    pub fn in_plane(mut self) -> Result<PlaneMesh, String> {
        self.check_cells()?;
        self.forget_unused_points();
        self.check_connections()?;
        let representatives = self.representatives();
        let repeated_cells = representatives.iter().enumerate().filter(|(index, first)| index != *first).count();
        let has_groups_of_edges = !self.is_complete && self.cells.iter().any(|cell| cell.dimension == 1);
        let is_needed = |index| has_groups_of_edges && representatives[index] == index;
        let edges = EdgeMap::new(&self.cells, is_needed);
        let indices = self.element_indices(&representatives, &edges);
        let element = |cell: usize| indices[representatives[cell]];
        let mut mesh = PlaneMesh {
            unread: std::mem::take(&mut self.unread),
            undefined_members: std::mem::take(&mut self.undefined_members),
            repeated_cells,
            ..PlaneMesh::default()
        };
        self.sets_of_cell_groups(&edges, &element, &mut mesh);
        for (name, faces) in std::mem::take(&mut self.surfaces) {
            let faces = faces.into_iter().filter_map(|(cell, face)| Some((element(cell)?, face)));
            mesh.surfaces.entry(group_name(&name)).or_default().extend(faces);
        }
        let is_element = indices.iter().map(Option::is_some);
        mesh.elements =
            self.cells.into_iter().zip(is_element).filter(|(_, is_element)| *is_element).map(|c| c.0).collect();
        (mesh.points, mesh.point_labels) = (self.points, self.point_labels);
        mesh.turn_clockwise_elements();
        Ok(mesh)
    }

    /// Removes points outside the half-plane that no cell and no group has, such as centres of arcs; rounding errors of
    /// coordinates at its boundary become zero.
    fn forget_unused_points(&mut self) {
        let size = self.points.iter().flatten().filter(|x| x.is_finite()).fold(0.0_f64, |size, x| size.max(x.abs()));
        for [x, _, z] in &mut self.points {
            if z.abs() <= ROUNDING * size {
                *z = 0.0;
            }
            if *x < 0.0 && *x >= -ROUNDING * size {
                *x = 0.0;
            }
        }
        let mut is_used = vec![false; self.points.len()];
        let of_cells = self.cells.iter().flat_map(|cell| &cell.points);
        of_cells.chain(self.point_groups.values().flatten()).for_each(|&point| is_used[point] = true);
        let is_kept = |point: usize| is_used[point] || is_in_half_plane(&self.points[point]);
        let kept: Vec<usize> = (0..self.points.len()).filter(|&point| is_kept(point)).collect();
        if kept.len() == self.points.len() {
            return;
        }
        let mut new_indices = vec![usize::MAX; self.points.len()];
        kept.iter().enumerate().for_each(|(new, &old)| new_indices[old] = new);
        self.points = kept.iter().map(|&point| self.points[point]).collect();
        self.point_labels = kept.iter().map(|&point| self.point_labels[point]).collect();
        self.cells.iter_mut().flat_map(|cell| &mut cell.points).for_each(|point| *point = new_indices[*point]);
        for members in self.point_groups.values_mut() {
            *members = members.iter().map(|point| new_indices[*point]).collect();
        }
    }

    fn check_cells(&self) -> Result<(), String> {
        let highest = self.cells.iter().map(|c| c.dimension).max().ok_or("it has no elements")?;
        if highest > 2 {
            return Err("it has three-dimensional elements; mesh the r-z half plane instead".into());
        }
        let higher_order =
            self.cells.iter().find(|cell| cell.dimension == 2 && ![3, 4, 6].contains(&cell.points.len()));
        if let Some(cell) = higher_order {
            return Err(format!(
                "element {} has {} nodes; faces have 3, 4 or 6 nodes: write quadrilaterals of first order",
                cell.label,
                cell.points.len()
            ));
        }
        Ok(())
    }

    /// Programs that write discontinuous fields give each cell separate points: such cells would move apart as separate
    /// bodies.
    fn check_connections(&self) -> Result<(), String> {
        let faces = || self.cells.iter().filter(|cell| cell.dimension == 2);
        let mut users = vec![0_usize; self.points.len()];
        faces().flat_map(|cell| &cell.points).for_each(|&point| users[point] += 1);
        let used: Vec<usize> = (0..users.len()).filter(|&point| users[point] > 0).collect();
        if self.is_complete || used.iter().any(|&point| users[point] > 1) {
            return Ok(());
        }
        let bits = |point: &usize| self.points[*point].map(|x| (x + 0.0).to_bits());
        let mut points_at_place: HashMap<[u64; 3], usize> = HashMap::with_capacity(used.len());
        used.iter().map(bits).for_each(|place| *points_at_place.entry(place).or_default() += 1);
        let coincident: usize = points_at_place.values().filter(|count| **count > 1).sum();
        if 2 * coincident <= used.len() {
            return Ok(());
        }
        Err(format!(
            "its {} faces {NO_COMMON_POINTS}, but {coincident} of their {} points are at the place of another one: they would be \
             separate bodies",
            faces().count(),
            used.len()
        ))
    }

    /// Returns for each cell the first one with the same points.
    fn representatives(&self) -> Vec<usize> {
        if self.is_complete {
            return (0..self.cells.len()).collect();
        }
        let mut first_cells: HashMap<[usize; MOST_POINTS], usize> = HashMap::with_capacity(self.cells.len());
        let first_of = |(index, cell): (usize, &MeshCell)| {
            let mut points = [usize::MAX; MOST_POINTS];
            points[..cell.points.len()].copy_from_slice(&cell.points);
            points.sort_unstable();
            *first_cells.entry(points).or_insert(index)
        };
        self.cells.iter().enumerate().map(first_of).collect()
    }

    /// Returns the element index of each cell; `None` for cells that only belong to groups, and for repeated cells.
    fn element_indices(&self, representatives: &[usize], edges: &EdgeMap) -> Vec<Option<usize>> {
        let highest = self.cells.iter().map(|cell| cell.dimension).max().unwrap_or(0);
        let mut is_in_group = vec![false; self.cells.len()];
        self.cell_groups.values().flatten().for_each(|&cell| is_in_group[representatives[cell]] = true);
        let is_element = |index: usize, cell: &MeshCell| match cell.dimension {
            _ if self.is_complete || cell.dimension == highest => true,
            1 => edges.owner(cell).is_none() && is_in_group[index],
            _ => false,
        };
        let mut count = 0;
        let mut index_of = |(index, cell)| {
            (representatives[index] == index && is_element(index, cell)).then(|| {
                count += 1;
                count - 1
            })
        };
        self.cells.iter().enumerate().map(&mut index_of).collect()
    }

    fn sets_of_cell_groups(&mut self, edges: &EdgeMap, element: &dyn Fn(usize) -> Option<usize>, mesh: &mut PlaneMesh) {
        mesh.node_sets = std::mem::take(&mut self.point_groups);
        for (name, cells) in std::mem::take(&mut self.cell_groups) {
            if !self.is_complete && !mesh.node_sets.contains_key(&name) {
                let points: IndexSet<usize> = cells.iter().flat_map(|&c| &self.cells[c].points).copied().collect();
                mesh.nodes_of_groups.insert(name.clone(), points.into_iter().collect());
            }
            let members: IndexSet<usize> = cells.iter().filter_map(|&cell| element(cell)).collect();
            if !members.is_empty() {
                mesh.element_sets.insert(name.clone(), members.into_iter().collect());
            }
            let boundary = cells.iter().filter(|cell| element(**cell).is_none());
            let faces: IndexSet<(usize, usize)> = boundary
                .filter_map(|&cell| match edges.owner(&self.cells[cell])? {
                    EdgeOwner::One(owner, face) => Some((element(owner)?, face)),
                    EdgeOwner::Several => None,
                })
                .collect();
            if !faces.is_empty() {
                mesh.surfaces.insert(name, faces.into_iter().collect());
            }
        }
    }
}

impl PlaneMesh {
    /// Reverses faces that are clockwise; faces of surfaces follow.
    fn turn_clockwise_elements(&mut self) {
        let points = &self.points;
        let turned: Vec<bool> =
            self.elements.iter().map(|element| element.dimension == 2 && element.area(points) < 0.0).collect();
        for (element, _) in self.elements.iter_mut().zip(&turned).filter(|(_, turned)| **turned) {
            element.reverse();
        }
        for (element, face) in self.surfaces.values_mut().flatten().filter(|(element, _)| turned[*element]) {
            let count = corner_count(self.elements[*element].points.len());
            *face = count.saturating_sub(1 + *face);
        }
    }
}

/// Returns the name of a group in capitals. Names that Salome fills with underscores up to 80 characters lose these.
fn group_name(name: &str) -> String {
    let is_filled = name.chars().count() == 80;
    if is_filled { name.trim_end_matches('_') } else { name }.trim_end().to_uppercase()
}

/// A mesh whose cells and groups refer to labels, as Gmsh and ABAQUS write it.
#[derive(Debug, Default)]
pub(super) struct LabelledMesh {
    pub listed: ListedMesh,
    points_by_label: HashMap<i64, usize>,
    cells_by_label: HashMap<i64, usize>,
    largest_label: i64,
    /// Point labels of each cell.
    cell_points: Vec<Vec<i64>>,
}

impl LabelledMesh {
    /// Adds a point; a later definition of a label replaces the earlier one.
    pub fn add_point(&mut self, label: i64, point: [f64; 3]) -> usize {
        if let Some(&known) = self.points_by_label.get(&label) {
            self.listed.points[known] = point;
            return known;
        }
        self.largest_label = self.largest_label.max(label);
        self.points_by_label.insert(label, self.listed.points.len());
        self.listed.point_labels.push(label);
        self.listed.points.push(point);
        self.listed.points.len() - 1
    }

    /// Adds a cell of points with the given labels.
    pub fn add_cell(&mut self, label: i64, dimension: usize, points: Vec<i64>) -> usize {
        let index = self.listed.cells.len();
        self.largest_label = self.largest_label.max(label);
        self.cells_by_label.insert(label, index);
        self.listed.cells.push(MeshCell { label, dimension, points: Vec::new() });
        self.cell_points.push(points);
        index
    }

    /// Returns the index of the point with a label.
    pub fn point(&self, label: i64) -> Option<usize> {
        self.points_by_label.get(&label).copied()
    }

    /// Returns the index of the last cell with a label.
    pub fn cell(&self, label: i64) -> Option<usize> {
        self.cells_by_label.get(&label).copied()
    }

    /// Returns the largest label of a point or cell; 0 if there are none.
    pub fn largest_label(&self) -> i64 {
        self.largest_label
    }

    /// Returns elements, sets and surfaces.
    ///
    /// # Errors
    /// The reason if a cell refers to an undefined point, or those of [`ListedMesh::in_plane`].
    pub fn in_plane(mut self) -> Result<PlaneMesh, String> {
        for (cell, labels) in self.listed.cells.iter_mut().zip(&self.cell_points) {
            let points: Option<Vec<usize>> = labels.iter().map(|n| self.points_by_label.get(n).copied()).collect();
            cell.points = points.ok_or_else(|| format!("element {} refers to an undefined node", cell.label))?;
        }
        self.listed.in_plane()
    }
}
