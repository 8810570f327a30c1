//! Structured meshes of quadrilaterals, and lists as writers of decks break them into lines.

/// A rectangular mesh in the r-z plane. Nodes and elements are numbered from 1, along r first.
pub struct Grid {
    /// Coordinates of the columns of nodes.
    pub r: Vec<f64>,
    /// Coordinates of the rows of nodes.
    pub z: Vec<f64>,
}

/// A side of a grid.
#[derive(Clone, Copy)]
pub enum Side {
    Bottom,
    Outer,
    Top,
    Inner,
}

impl Grid {
    /// Returns a mesh of `columns` by `rows` equal elements between corners (r, z).
    pub fn uniform(from: [f64; 2], to: [f64; 2], columns: usize, rows: usize) -> Grid {
        let line = |a: f64, b: f64, n: usize| (0..=n).map(|i| a + (b - a) * i as f64 / n as f64).collect();
        Grid { r: line(from[0], to[0], columns), z: line(from[1], to[1], rows) }
    }

    /// Returns the number of elements along r.
    pub fn columns(&self) -> usize {
        self.r.len() - 1
    }

    /// Returns the number of elements along z.
    pub fn rows(&self) -> usize {
        self.z.len() - 1
    }

    /// Returns the number of nodes.
    pub fn nodes(&self) -> usize {
        self.r.len() * self.z.len()
    }

    /// Returns the number of elements.
    pub fn elements(&self) -> usize {
        self.columns() * self.rows()
    }

    /// Returns the coordinates of all nodes.
    pub fn points(&self) -> Vec<[f64; 2]> {
        self.z.iter().flat_map(|&z| self.r.iter().map(move |&r| [r, z])).collect()
    }

    /// Returns the number of the node in a column and a row, both from 0.
    pub fn node(&self, column: usize, row: usize) -> usize {
        row * self.r.len() + column + 1
    }

    /// Returns the four nodes of each element, counter-clockwise from the lower inner one.
    pub fn quads(&self) -> Vec<[usize; 4]> {
        let quad = |i, j| [self.node(i, j), self.node(i + 1, j), self.node(i + 1, j + 1), self.node(i, j + 1)];
        (0..self.rows()).flat_map(|j| (0..self.columns()).map(move |i| quad(i, j))).collect()
    }

    /// Returns the nodes on a side.
    pub fn side_nodes(&self, side: Side) -> Vec<usize> {
        let (columns, rows) = (self.columns(), self.rows());
        match side {
            Side::Bottom => (0..=columns).map(|i| self.node(i, 0)).collect(),
            Side::Outer => (0..=rows).map(|j| self.node(columns, j)).collect(),
            Side::Top => (0..=columns).map(|i| self.node(i, rows)).collect(),
            Side::Inner => (0..=rows).map(|j| self.node(0, j)).collect(),
        }
    }

    /// Returns the elements on a side.
    pub fn side_elements(&self, side: Side) -> Vec<usize> {
        let (columns, rows) = (self.columns(), self.rows());
        match side {
            Side::Bottom => (1..=columns).collect(),
            Side::Outer => (0..rows).map(|j| (j + 1) * columns).collect(),
            Side::Top => (1..=columns).map(|i| (rows - 1) * columns + i).collect(),
            Side::Inner => (0..rows).map(|j| j * columns + 1).collect(),
        }
    }
}

impl Side {
    /// Returns the label of the face of elements on this side.
    pub fn face(self) -> &'static str {
        match self {
            Side::Bottom => "S1",
            Side::Outer => "S2",
            Side::Top => "S3",
            Side::Inner => "S4",
        }
    }
}

/// Returns a list of numbers in lines of `per_line` values, each of at least `width` characters.
pub fn list(numbers: &[usize], per_line: usize, width: usize) -> String {
    let line = |chunk: &[usize]| chunk.iter().map(|n| format!("{n:>width$}")).collect::<Vec<_>>().join(",");
    numbers.chunks(per_line).map(|chunk| line(chunk) + "\n").collect()
}

/// Returns coordinates that begin at `first` intervals of `size` and then grow by a factor up to `end`.
pub fn graded(first: usize, size: f64, factor: f64, end: f64) -> Vec<f64> {
    let mut points: Vec<f64> = (0..=first).map(|i| i as f64 * size).collect();
    let mut step = size;
    loop {
        step *= factor;
        let next = points[points.len() - 1] + step;
        if next + 0.5 * step * factor >= end {
            points.push(end);
            return points;
        }
        points.push(next);
    }
}
