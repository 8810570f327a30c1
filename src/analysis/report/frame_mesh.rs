//! Mesh of a frame: corners and labels of its cells. It is compared with later frames, whose bodies may have new meshes.

use super::frames::FrameData;

/// Corner that a cell does not have.
pub const NO_CORNER: u32 = u32::MAX;

/// Corners and labels of the cells of a frame.
#[derive(Debug, Default)]
pub struct FrameMesh {
    /// Number of points.
    pub points: usize,
    /// Points at the corners of each cell; lines have two, triangles three, cells that are a point none.
    pub corners: Vec<[u32; 4]>,
    /// Element number of each cell in the deck; 0 without one.
    pub elements: Vec<i32>,
    /// Material number of each cell, counted from 1; 0 without one.
    pub materials: Vec<i32>,
}

impl FrameMesh {
    pub fn of(frame: &FrameData) -> FrameMesh {
        let labels =
            |list: &[i32]| (0..frame.cells.len()).map(|cell| list.get(cell).copied().unwrap_or(0)).collect::<Vec<_>>();
        FrameMesh {
            points: frame.points.len(),
            corners: frame.cells.iter().map(|cell| corners(cell)).collect(),
            elements: labels(&frame.elements),
            materials: labels(&frame.materials),
        }
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
        size_of_val(&self.corners[..]) + size_of_val(&self.elements[..]) + size_of_val(&self.materials[..])
    }
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

    #[test]
    fn six_node_triangles_and_points_have_their_corners() {
        let cells: [&[usize]; 3] = [&[0, 1, 2, 3, 4, 5], &[3], &[2, 5]];
        let mesh = FrameMesh::of(&frame(&cells, &[1, 2, 3], &[]));
        assert_eq!(mesh.corners[0], [0, 2, 4, NO_CORNER]);
        assert_eq!(mesh.corners_of(1).count(), 0);
        assert!(mesh.is_line(2) && !mesh.is_line(0));
    }
}
