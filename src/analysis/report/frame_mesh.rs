//! Mesh of a frame: corners and labels of its cells. It is compared with later frames, whose bodies may have new meshes.

use super::frames::FrameData;
use crate::variables::Variable;

/// Corner that a cell does not have.
pub const NO_CORNER: u32 = u32::MAX;

/// Corners and labels of the cells of a frame.
#[derive(Debug, Default)]
pub struct FrameMesh {
    /// Number of points.
    pub points: usize,
    /// Node number of each point in the deck; 0 without one.
    pub nodes: Vec<i32>,
    /// Points at the corners of each cell; lines have two, triangles three, cells that are a point none.
    pub corners: Vec<[u32; 4]>,
    /// Element number of each cell in the deck; 0 without one.
    pub elements: Vec<i32>,
    /// Material number of each cell, counted from 1; 0 without one.
    pub materials: Vec<i32>,
}

impl FrameMesh {
    pub fn of(frame: &FrameData) -> FrameMesh {
        let labels = |list: &[i32], count: usize| (0..count).map(|i| list.get(i).copied().unwrap_or(0)).collect();
        FrameMesh {
            points: frame.points.len(),
            nodes: labels(&frame.nodes, frame.points.len()),
            corners: frame.cells.iter().map(|cell| corners(cell)).collect(),
            elements: labels(&frame.elements, frame.cells.len()),
            materials: labels(&frame.materials, frame.cells.len()),
        }
    }

    /// Completes a frame of this mesh from which the cells of deleted elements, and points, are missing. Returns whether
    /// the frame has this mesh.
    pub fn complete(&self, frame: &mut FrameData) -> bool {
        if self.is_mesh_of(frame) {
            return true;
        }
        let Some((points, cells)) = self.places_of(frame) else { return false };
        // Missing points have the coordinates of the first point.
        let anywhere = frame.points.first().copied().unwrap_or_default();
        frame.points = scattered(&frame.points, &points, self.points, anywhere);
        frame.nodes.clone_from(&self.nodes);
        frame.cells.iter_mut().flatten().for_each(|point| *point = points[*point]);
        frame.cells = scattered(&frame.cells, &cells, self.corners.len(), Vec::new());
        frame.deleted = scattered(&vec![false; cells.len()], &cells, self.corners.len(), true);
        (frame.elements, frame.materials) = (self.elements.clone(), self.materials.clone());
        for scalar in &mut frame.scalars {
            let (places, count) = if scalar.on_cells { (&cells, self.corners.len()) } else { (&points, self.points) };
            let missing = if scalar.name == Variable::Status.name() { 0.0 } else { f64::NAN };
            scalar.values = scattered(&scalar.values, places, count, missing);
        }
        true
    }

    /// Returns the places of the points and of the cells of a frame in this mesh, if it contains all points and cells in this order.
    fn places_of(&self, frame: &FrameData) -> Option<(Vec<usize>, Vec<usize>)> {
        let points = places(&frame.nodes, &self.nodes)?;
        let place_of = |point: &usize| points.get(*point).copied();
        let cells_of_mesh = frame.cells.iter().map(|cell| cell.iter().map(place_of).collect::<Option<Vec<usize>>>());
        let frame_corners: Vec<[u32; 4]> = cells_of_mesh.map(|cell| Some(corners(&cell?))).collect::<Option<_>>()?;
        let cells = places(&frame_corners, &self.corners)?;
        let same_element = |(place, element): (&usize, &i32)| self.elements[*place] == *element;
        let same_elements = cells.iter().zip(&frame.elements).all(same_element);
        (points.len() == frame.points.len() && frame.elements.len() == cells.len() && same_elements)
            .then_some((points, cells))
    }

    /// Returns whether a frame has this mesh. The cells of its deleted elements, collapsed to a point, are ignored.
    pub fn is_mesh_of(&self, frame: &FrameData) -> bool {
        let is_deleted = |cell: usize| frame.deleted.get(cell).copied().unwrap_or(false);
        let same_element = |cell: usize| self.elements[cell] == frame.elements.get(cell).copied().unwrap_or(0);
        let same_cell = |cell: usize| is_deleted(cell) || self.corners[cell] == corners(&frame.cells[cell]);
        self.points == frame.points.len()
            && self.corners.len() == frame.cells.len()
            && (0..self.corners.len()).all(|cell| same_element(cell) && same_cell(cell))
    }

    /// Returns the points at the corners of a cell.
    pub fn corners_of(&self, cell: usize) -> impl Iterator<Item = usize> {
        self.corners[cell].into_iter().filter(|&point| point != NO_CORNER).map(|point| point as usize)
    }

    /// Returns whether a cell is a line: a facet of a rigid body, or a shell.
    pub fn is_line(&self, cell: usize) -> bool {
        self.corners_of(cell).count() == 2
    }

    /// Returns the size of the arrays in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..])
            + size_of_val(&self.corners[..])
            + size_of_val(&self.elements[..])
            + size_of_val(&self.materials[..])
    }
}

/// Returns the place of each item in a list that has the items in the same order, and others between them.
fn places<T: PartialEq>(items: &[T], list: &[T]) -> Option<Vec<usize>> {
    let mut next = 0;
    let place_of = |item: &T| {
        let place = next + list[next..].iter().position(|other| other == item)?;
        next = place + 1;
        Some(place)
    };
    items.iter().map(place_of).collect()
}

/// Returns a list of `count` values with `values` at `places`, and `missing` elsewhere.
fn scattered<T: Clone>(values: &[T], places: &[usize], count: usize, missing: T) -> Vec<T> {
    let mut list = vec![missing; count];
    places.iter().zip(values).for_each(|(place, value)| list[*place] = value.clone());
    list
}

/// Returns the corners of a cell whose points are listed along its boundary; every second point of six is a midpoint.
pub fn corners(cell: &[usize]) -> [u32; 4] {
    let step = if cell.len() == 6 { 2 } else { 1 };
    let listed = if cell.len() < 2 { &[] } else { cell };
    let mut corners = [NO_CORNER; 4];
    corners.iter_mut().zip(listed.iter().step_by(step)).for_each(|(corner, point)| *corner = *point as u32);
    corners
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::frames::ScalarField;

    fn frame(cells: &[&[usize]], elements: &[i32], deleted: &[bool]) -> FrameData {
        FrameData {
            points: vec![[0.0; 2]; 6],
            cells: cells.iter().map(|cell| cell.to_vec()).collect(),
            elements: elements.to_vec(),
            deleted: deleted.to_vec(),
            ..FrameData::default()
        }
    }

    #[test]
    fn new_meshes_differ_and_deleted_cells_are_ignored() {
        let cells: [&[usize]; 2] = [&[0, 1, 2, 3], &[1, 4, 2]];
        let mesh = FrameMesh::of(&frame(&cells, &[7, 8], &[]));
        assert!(mesh.is_mesh_of(&frame(&cells, &[7, 8], &[])));
        let collapsed: [&[usize]; 2] = [&[0; 4], &[1, 4, 2]];
        assert!(mesh.is_mesh_of(&frame(&collapsed, &[7, 8], &[true, false])));
        assert!(!mesh.is_mesh_of(&frame(&collapsed, &[7, 8], &[])));
        assert!(!mesh.is_mesh_of(&frame(&cells, &[7, 9], &[])), "a new mesh with the same corners");
        assert!(!mesh.is_mesh_of(&frame(&cells[..1], &[7], &[])));
        // The mesh of a frame without the cell does not serve a frame that has it.
        let late = FrameMesh::of(&frame(&collapsed, &[7, 8], &[true, false]));
        assert!(!late.is_mesh_of(&frame(&cells, &[7, 8], &[])));
    }

    /// The cell of a deleted element and its own points are not in the frame.
    #[test]
    fn frames_without_deleted_elements_are_completed() {
        let whole = FrameData {
            points: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [2.0, 0.5]],
            nodes: vec![1, 2, 3, 4, 5],
            ..frame(&[&[1, 4, 2], &[0, 1, 2, 3]], &[7, 8], &[])
        };
        let mesh = FrameMesh::of(&whole);
        let scalars = vec![ScalarField { name: "P".into(), on_cells: true, values: vec![3.0], array: "P".into() }];
        let mut late = FrameData {
            points: whole.points[..4].iter().map(|[r, z]| [*r, z + 5.0]).collect(),
            nodes: vec![1, 2, 3, 4],
            scalars,
            ..frame(&[&[0, 1, 2, 3]], &[8], &[])
        };
        assert!(mesh.complete(&mut late));
        assert_eq!((&late.points[1], late.points.len()), (&[1.0, 5.0], 5));
        assert_eq!(late.deleted, [true, false]);
        assert_eq!((late.cells[1].clone(), late.elements), (vec![0, 1, 2, 3], vec![7, 8]));
        assert!(late.scalars[0].values[0].is_nan() && late.scalars[0].values[1] == 3.0);
        let mut other = FrameData { nodes: vec![1, 2, 3, 9], ..frame(&[&[0, 1, 2, 3]], &[8], &[]) };
        assert!(!mesh.complete(&mut other));
    }

    #[test]
    fn six_node_triangles_and_points_have_their_corners() {
        let cells: [&[usize]; 3] = [&[0, 1, 2, 3, 4, 5], &[3], &[2, 5]];
        let mesh = FrameMesh::of(&frame(&cells, &[1, 2, 3], &[]));
        assert_eq!(mesh.corners[0], [0, 2, 4, NO_CORNER]);
        assert_eq!(mesh.corners_of(1).count(), 0);
        assert!(mesh.is_line(2) && !mesh.is_line(0));
    }
}
