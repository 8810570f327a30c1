//! Largest eigenvalue of the operator M^-1/2 K M^-1/2 of all elements by Lanczos' method from a random start vector, on
//! all threads of the pool. Sums are those of chunks of fixed size, so that results do not depend on the number of threads.

use nalgebra::SMatrix;
use pulp::Arch;
use sprs::CsMatI;

use super::group::{ElementGroup, ElementStiffness};
use crate::kernel::chunks::{ChunkLoops, chunks_of};
use crate::kernel::lanes::InlineMap;
use crate::kernel::topology::ElementNodes;
use crate::state::nodes::Nodes;

/// Number of Lanczos steps.
const STEPS: usize = 40;
/// Largest relative error of an eigenvalue by single precision of the operator. Each entry is a sum of at most eight
/// rounded numbers.
const ROUNDING: f64 = 1e-6;

/// Pairs of nodes with common elements: the rows and columns of a sparse matrix without its values.
type NodePairs = CsMatI<(), u32>;

/// The operator as blocks for pairs of nodes.
#[derive(Clone, Debug)]
pub(super) struct SparseOperator {
    pairs: NodePairs,
    /// The block `[rr, zr, rz, zz]` of each pair of nodes. Single precision is more accurate than the estimate. Empty
    /// before the first step, so that a copy of the initial state needs no memory.
    values: Vec<[f32; 4]>,
}

impl SparseOperator {
    /// Creates the operator without values from the pairs of nodes that share an element.
    pub(super) fn of(groups: &[Box<dyn ElementGroup>], count: usize) -> SparseOperator {
        SparseOperator { pairs: pattern(groups, count), values: Vec::new() }
    }

    /// Returns the number of bytes during a run.
    pub(super) fn bytes(&self) -> usize {
        self.pairs.nnz() * (size_of::<[f32; 4]>() + 4) + self.pairs.indptr().len() * 4
    }

    /// Allocates the values.
    pub(super) fn allocate(&mut self) {
        self.values.resize(self.pairs.nnz(), [0.0; 4]);
    }

    /// Sums the stiffness of all elements. `roots` are the inverse square roots of the masses.
    pub(super) fn assemble(&mut self, groups: &[Box<dyn ElementGroup>], nodes: &Nodes, roots: &[[f64; 2]]) {
        self.allocate();
        self.values.fill([0.0; 4]);
        for group in groups {
            for e in 0..group.len() {
                let Some(matrix) = group.stiffness(e, nodes.as_slice()) else { continue };
                self.add(&group.nodes(e), &matrix, roots);
            }
        }
    }

    fn add(&mut self, nodes: &ElementNodes, ElementStiffness(matrix): &ElementStiffness, roots: &[[f64; 2]]) {
        let roots = nodes.map(|n| roots[n as usize]);
        for (a, &row) in nodes.iter().enumerate() {
            let of_row = self.pairs.indptr().outer_inds_sz(row as usize);
            for (b, column) in nodes.iter().enumerate() {
                let slot = of_row.start + self.pairs.indices()[of_row.clone()].partition_point(|c| c < column);
                for (i, entry) in self.values[slot].iter_mut().enumerate() {
                    let (along, across) = (i % 2, i / 2);
                    *entry += (matrix[2 * a + along][2 * b + across] * (roots[a][along] * roots[b][across])) as f32;
                }
            }
        }
    }

    /// Replaces rows of a vector, from `first` on, by `factor` times the product minus the vector times `share`. Returns the
    /// scalar product of the new rows with those of `vector`.
    #[inline(always)]
    fn multiply(&self, first: usize, vector: &[[f64; 2]], [factor, share]: [f64; 2], rows: &mut [[f64; 2]]) -> f64 {
        let (starts, columns) = (self.pairs.indptr(), self.pairs.indices());
        let mut parts = [0.0; 2];
        for (row, out) in (first..).zip(rows) {
            let range = starts.outer_inds_sz(row);
            let mut sums = [0.0_f64; 4];
            for (column, block) in columns[range.clone()].iter().zip(&self.values[range]) {
                let ([r, z], [rr, zr, rz, zz]) = (vector[*column as usize], block.inline_map(f64::from));
                let [a, b, c, d] = sums;
                sums = [a + rr * r, b + zr * r, c + rz * z, d + zz * z];
            }
            for (axis, part) in parts.iter_mut().enumerate() {
                out[axis] = factor * (sums[axis] + sums[axis + 2]) - share * out[axis];
                *part += out[axis] * vector[row][axis];
            }
        }
        parts[0] + parts[1]
    }

    /// Iterates over `[row, column]` and blocks.
    #[cfg(test)]
    pub(super) fn blocks(&self) -> impl Iterator<Item = ([usize; 2], &[f32; 4])> {
        let of_row = |row| self.pairs.indptr().outer_inds_sz(row).map(move |at| (row, at));
        let pairs = (0..self.pairs.rows()).flat_map(of_row);
        pairs.map(|(row, at)| ([row, self.pairs.indices()[at] as usize], &self.values[at]))
    }
}

/// Returns the pairs of nodes that share an element.
fn pattern(groups: &[Box<dyn ElementGroup>], count: usize) -> NodePairs {
    // Elements at each node in one list, and the start of each node's range in it.
    let corners = || groups.iter().flat_map(|group| (0..group.len()).map(|e| group.nodes(e)));
    let mut ends = vec![0_u32; count + 1];
    corners().flatten().for_each(|n| ends[n as usize + 1] += 1);
    (0..count).for_each(|n| ends[n + 1] += ends[n]);
    let mut at_node = vec![[0_u32; 2]; ends[count] as usize];
    let mut next = ends.clone();
    for (g, group) in groups.iter().enumerate() {
        for e in 0..group.len() {
            for n in group.nodes(e) {
                at_node[next[n as usize] as usize] = [g as u32, e as u32];
                next[n as usize] += 1;
            }
        }
    }
    drop(next);
    let (mut starts, mut columns, mut list) = (vec![0_u32], Vec::new(), Vec::new());
    for n in 0..count {
        list.clear();
        for [g, e] in &at_node[ends[n] as usize..ends[n + 1] as usize] {
            list.extend(groups[*g as usize].nodes(*e as usize));
        }
        list.sort_unstable();
        list.dedup();
        columns.extend_from_slice(&list);
        starts.push(columns.len() as u32);
    }
    columns.shrink_to_fit();
    let no_values = vec![(); columns.len()];
    NodePairs::new((count, count), starts, columns, no_values)
}

/// Work arrays of Lanczos' method; empty before the first step.
#[derive(Clone, Debug, Default)]
pub(super) struct LanczosVectors {
    /// The last two vectors.
    before: Vec<[f64; 2]>,
    now: Vec<[f64; 2]>,
    /// Sums of chunks.
    parts: Vec<f64>,
}

impl LanczosVectors {
    /// Returns the number of bytes for this number of nodes.
    pub(super) fn bytes(nodes: usize) -> usize {
        2 * nodes * size_of::<[f64; 2]>() + chunks_of(nodes) * size_of::<f64>()
    }

    /// Allocates the vectors for this number of nodes.
    pub(super) fn allocate(&mut self, nodes: usize) {
        self.before.resize(nodes, [0.0; 2]);
        self.now.resize(nodes, [0.0; 2]);
        self.parts.resize(chunks_of(nodes), 0.0);
    }

    /// Returns the largest eigenvalue, increased by the expected error.
    pub(super) fn largest_eigenvalue(&mut self, operator: &SparseOperator, arch: Arch) -> f64 {
        let count = operator.pairs.rows();
        self.allocate(count);
        let TridiagonalMatrix { diagonal, off_diagonal, size } = self.tridiagonal(operator, arch);
        let mut small = SMatrix::<f64, STEPS, STEPS>::zeros();
        for i in 0..size {
            small[(i, i)] = diagonal[i];
            if i + 1 < size {
                small[(i, i + 1)] = off_diagonal[i];
                small[(i + 1, i)] = off_diagonal[i];
            }
        }
        small.symmetric_eigenvalues().max() / (1.0 - missing(2 * count, size))
    }

    /// Returns the matrix of Lanczos' method from a random start vector. The vectors are stored without their norms.
    fn tridiagonal(&mut self, operator: &SparseOperator, arch: Arch) -> TridiagonalMatrix {
        let (mut diagonal, mut off_diagonal) = ([0.0; STEPS], [0.0; STEPS]);
        let LanczosVectors { before, now, parts } = self;
        let loops = ChunkLoops::new(arch);
        before.fill([0.0; 2]);
        scatter(now);
        let (mut norm, mut norm_before) = (square_of(now).sqrt(), 1.0);
        for step in 0..STEPS {
            let factors = [1.0 / norm, norm / norm_before];
            let product = loops.sum(
                before,
                parts,
                #[inline(always)]
                |first, rows| operator.multiply(first, now, factors, rows),
            );
            diagonal[step] = product / norm;
            let share = diagonal[step] / norm;
            let square = loops.sum(
                before,
                parts,
                #[inline(always)]
                |first, rows| subtract(rows, share, &now[first..]),
            );
            std::mem::swap(before, now);
            (norm_before, norm) = (norm, square.sqrt());
            off_diagonal[step] = norm;
            // The Krylov space is invariant.
            if norm <= 1e-12 * diagonal[0] {
                return TridiagonalMatrix { diagonal, off_diagonal, size: step + 1 };
            }
        }
        TridiagonalMatrix { diagonal, off_diagonal, size: STEPS }
    }
}

/// Symmetric tridiagonal matrix with at most [`STEPS`] rows.
struct TridiagonalMatrix {
    diagonal: [f64; STEPS],
    off_diagonal: [f64; STEPS],
    /// Number of rows.
    size: usize,
}

/// Subtracts a multiple of another vector. Returns the square of the result.
#[inline(always)]
fn subtract(rows: &mut [[f64; 2]], share: f64, other: &[[f64; 2]]) -> f64 {
    rows.as_flattened_mut().iter_mut().zip(other.as_flattened()).for_each(|(x, o)| *x -= share * o);
    square_of(rows)
}

/// Returns the sum of squares, by four partial sums in fixed order.
#[inline(always)]
fn square_of(rows: &[[f64; 2]]) -> f64 {
    let (quads, remainder) = rows.as_flattened().as_chunks::<4>();
    let mut sums = [0.0; 4];
    for four in quads {
        sums.iter_mut().zip(four).for_each(|(sum, x)| *sum += x * x);
    }
    let remainder: f64 = remainder.iter().map(|x| x * x).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + remainder
}
/// Returns the expected relative error of the largest eigenvalue after `steps` steps from a random start vector (an
/// upper bound): Kuczynski and Wozniakowski 1992 (SIAM J. Matrix Anal. Appl. 13, 1094), theorem 3.2. Equation (4.8).
fn missing(size: usize, steps: usize) -> f64 {
    if steps < STEPS {
        return ROUNDING;
    }
    let one_less = (steps - 1) as f64;
    let ratio = libm::log(size as f64 * one_less * one_less) / one_less;
    0.103 * ratio * ratio
}

/// Fills a list with reproducible pseudo-random numbers between -1 and 1 (linear congruential generator: Knuth, The Art
/// of Computer Programming 2, 3.3.4).
fn scatter(list: &mut [[f64; 2]]) {
    let mut state = 1_u64;
    for x in list.as_flattened_mut() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        *x = (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0;
    }
}
