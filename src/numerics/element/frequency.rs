//! Highest frequency of all deformable elements, which determines the stable time increment: the global estimator that
//! ABAQUS/Explicit uses by default (Analysis User's Guide, "Explicit dynamic analysis", "Stable time increment
//! estimator"). It is below the bound of single elements, most of all for square elements.
//!
//! The eigenvalue is computed by Lanczos' method on the assembled operator, and increased by the expected error of a
//! random start vector. Until the next estimate it is increased with the largest strain increment of any element, so
//! that it remains a bound. After too much deformation it is replaced by the bound of single elements, and computed
//! again when the gain is likely to exceed its cost.

use nalgebra::SMatrix;
use sprs::CsMatI;

use super::group::{ElementGroup, ElementStiffness};
use crate::kernel::topology::ElementNodes;
use crate::state::EffectId;
use crate::state::archive::persist_struct;
use crate::state::nodes::Nodes;

/// Number of Lanczos steps.
const STEPS: usize = 40;
/// Approximate run time of an estimate in increments: each step reads the operator once.
const COST: f64 = 50.0;
/// Relative growth of the bound at which an estimate is discarded.
pub(super) const WORN: f64 = 0.1;
/// Smallest and largest pause, in increments, after an estimate that did not pay.
const PAUSE: [u64; 2] = [100, 20_000];

/// Pairs of nodes with common elements: the rows and columns of a sparse matrix without its values.
type NodePairs = CsMatI<(), u32>;

/// Estimator of the highest frequency: operator, vectors and current estimate.
#[derive(Clone, Debug)]
pub struct HighestFrequency {
    pub id: EffectId,
    /// Rows and columns of the operator M^-1/2 K M^-1/2.
    pairs: NodePairs,
    /// Values of the operator: a block `[rr, rz, zr, zz]` for each pair of nodes. Empty before the first step that uses
    /// the estimate, as are the vectors.
    values: Vec<[f64; 4]>,
    /// Inverse square root of the mass of each degree of freedom; 0 for prescribed motion.
    roots: Vec<[f64; 2]>,
    vectors: [Vec<[f64; 2]>; 2],
    pub(super) state: EstimateState,
}

/// State of the estimate between increments.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct EstimateState {
    /// Last estimated frequency, radians per time; 0 if none is valid.
    pub found: f64,
    /// Relative growth of the bound since the estimate.
    pub growth: f64,
    /// Relative growth that was assumed in advance for the last pass.
    pub predicted_growth: f64,
    /// Increments since the estimate, and pause before the next one.
    pub age: u64,
    pub pause: u64,
    /// Rate of single elements at the time of the estimate, and the relative gain over it.
    pub by_elements: f64,
    pub gain: f64,
    pub count: u64,
    /// Whether the bound includes its whole allowed growth from the start, so that the time increment is constant until
    /// the estimate is discarded.
    pub holds: bool,
}

impl HighestFrequency {
    /// Creates the estimator of a model; `None` if any element is not linear elastic at small strain.
    pub fn new(groups: &[Box<dyn ElementGroup>], nodes: &Nodes) -> Option<HighestFrequency> {
        if groups.iter().any(|g| !g.is_empty() && g.stiffness(0, nodes.as_slice()).is_none()) {
            return None;
        }
        Some(HighestFrequency {
            id: 0,
            pairs: pattern(groups, nodes.len()),
            values: Vec::new(),
            roots: vec![[0.0; 2]; nodes.len()],
            vectors: Default::default(),
            state: EstimateState::default(),
        })
    }

    /// Returns names and bytes of the arrays during a run.
    pub fn arrays(&self) -> Vec<(&'static str, usize)> {
        let operator = self.pairs.nnz() * 36 + self.pairs.indptr().len() * 4;
        vec![("sparse operator", operator), ("Lanczos vectors", 3 * size_of_val(&*self.roots))]
    }

    /// Begins a step: the highest frequency depends on its prescribed motions.
    pub(super) fn begin(&mut self, groups: &[Box<dyn ElementGroup>], nodes: &Nodes, held: &ConstrainedNodes<'_>) {
        // Without damping the highest modes grow if the increment varies with the motion, the more so the closer it is
        // to their stability limit.
        let holds = groups.iter().any(|g| !g.is_empty() && !g.properties().damped);
        self.state = EstimateState { count: self.state.count, holds, ..EstimateState::default() };
        for (roots, mass) in self.roots.iter_mut().zip(&nodes.mass) {
            *roots = [1.0 / mass.sqrt(); 2];
        }
        // Nodes of rigid bodies have no mass of their own here. A rigid body has at least the mass of the elements at
        // its nodes, and not more stiffness than the separate nodes.
        let own = if held.carried.is_empty() { Vec::new() } else { masses_of_elements(groups, nodes.len()) };
        for &n in held.carried {
            self.roots[n] = [0.0, 1.0 / own[n].sqrt()];
        }
        for &(node, axis) in held.prescribed {
            self.roots[node][axis] = 0.0;
        }
        self.roots.as_flattened_mut().iter_mut().filter(|r| !r.is_finite()).for_each(|r| *r = 0.0);
    }

    /// Allocates values and vectors, unless that has been done.
    fn allocate(&mut self) {
        self.values.resize(self.pairs.nnz(), [0.0; 4]);
        self.vectors.iter_mut().for_each(|vector| vector.resize(self.roots.len(), [0.0; 2]));
    }

    /// Assembles the stiffness of all elements into the operator.
    fn assemble(&mut self, groups: &[Box<dyn ElementGroup>], nodes: &Nodes) {
        self.values.fill([0.0; 4]);
        for group in groups {
            for e in 0..group.len() {
                let Some(matrix) = group.stiffness(e, nodes.as_slice()) else { continue };
                self.add(&group.nodes(e), &matrix);
            }
        }
    }

    fn add(&mut self, nodes: &ElementNodes, ElementStiffness(matrix): &ElementStiffness) {
        let roots = nodes.map(|n| self.roots[n as usize]);
        for (a, &row) in nodes.iter().enumerate() {
            let of_row = self.pairs.indptr().outer_inds_sz(row as usize);
            for (b, column) in nodes.iter().enumerate() {
                let at = of_row.start + self.pairs.indices()[of_row.clone()].partition_point(|c| c < column);
                for (i, entry) in self.values[at].iter_mut().enumerate() {
                    let (along, across) = (i / 2, i % 2);
                    *entry += matrix[2 * a + along][2 * b + across] * roots[a][along] * roots[b][across];
                }
            }
        }
    }

    /// Returns the highest frequency, radians per time, increased by the expected error.
    fn find(&mut self) -> f64 {
        let (diagonal, off_diagonal, taken) = self.lanczos();
        let mut small = SMatrix::<f64, STEPS, STEPS>::zeros();
        for i in 0..taken {
            small[(i, i)] = diagonal[i];
            if i + 1 < taken {
                small[(i, i + 1)] = off_diagonal[i];
                small[(i + 1, i)] = off_diagonal[i];
            }
        }
        let largest = small.symmetric_eigenvalues().max();
        (largest / (1.0 - missing(2 * self.roots.len(), taken))).sqrt()
    }

    /// Returns the tridiagonal matrix of Lanczos' method from a random start vector, and its size.
    fn lanczos(&mut self) -> ([f64; STEPS], [f64; STEPS], usize) {
        let (mut diagonal, mut off_diagonal) = ([0.0; STEPS], [0.0; STEPS]);
        let [before, now] = &mut self.vectors;
        before.fill([0.0; 2]);
        scatter(now);
        let length = dot(now, now).sqrt();
        scale(now, 1.0 / length);
        let mut last = 0.0;
        for step in 0..STEPS {
            multiply(&self.pairs, &self.values, now, (last, before));
            let next = &mut *before;
            diagonal[step] = dot(next, now);
            subtract(next, diagonal[step], now);
            last = dot(next, next).sqrt();
            off_diagonal[step] = last;
            // The Krylov space is invariant.
            if last <= 1e-12 * diagonal[0] {
                return (diagonal, off_diagonal, step + 1);
            }
            scale(next, 1.0 / last);
            std::mem::swap(before, now);
        }
        (diagonal, off_diagonal, STEPS)
    }
}

/// Replaces a vector by the product of the operator and `vector`, minus `factor` times the replaced one.
fn multiply(pairs: &NodePairs, values: &[[f64; 4]], vector: &[[f64; 2]], (factor, replaced): (f64, &mut [[f64; 2]])) {
    let mut rest = values;
    for (row, out) in pairs.outer_iterator().zip(replaced) {
        let mut sum = [0.0; 2];
        let (blocks, later) = rest.split_at(row.nnz());
        rest = later;
        for (column, [rr, rz, zr, zz]) in row.indices().iter().zip(blocks) {
            let [r, z] = vector[*column as usize];
            sum = [sum[0] + (rr * r + rz * z), sum[1] + (zr * r + zz * z)];
        }
        *out = [sum[0] - factor * out[0], sum[1] - factor * out[1]];
    }
}

fn scale(list: &mut [[f64; 2]], factor: f64) {
    list.as_flattened_mut().iter_mut().for_each(|x| *x *= factor);
}

fn subtract(list: &mut [[f64; 2]], factor: f64, other: &[[f64; 2]]) {
    list.as_flattened_mut().iter_mut().zip(other.as_flattened()).for_each(|(x, o)| *x -= factor * o);
}

/// Returns the expected relative error of the largest eigenvalue after `steps` steps from a random start vector (an
/// upper bound): Kuczynski and Wozniakowski 1992 (SIAM J. Matrix Anal. Appl. 13, 1094), theorem 3.2.
fn missing(size: usize, steps: usize) -> f64 {
    if steps < STEPS {
        return 1e-12;
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

/// Returns the scalar product, by four partial sums in fixed order.
fn dot(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    let (quads_a, rest_a) = a.as_flattened().as_chunks::<4>();
    let (quads_b, rest_b) = b.as_flattened().as_chunks::<4>();
    let mut sums = [0.0; 4];
    for (x, y) in quads_a.iter().zip(quads_b) {
        for (sum, (x, y)) in sums.iter_mut().zip(x.iter().zip(y)) {
            *sum += x * y;
        }
    }
    let rest: f64 = rest_a.iter().zip(rest_b).map(|(x, y)| x * y).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
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
    let no_values = vec![(); columns.len()];
    NodePairs::new((count, count), starts, columns, no_values)
}

impl EstimateState {
    /// Returns the frequency bound for the next pass: the last estimate, increased by the growth since that estimate
    /// and by the growth assumed for the pass.
    pub(super) fn cap(&mut self, deformed: f64) -> f64 {
        self.predicted_growth = 2.0 * deformed;
        let (mut grown, mut foreseen) = (self.growth, self.predicted_growth);
        if self.holds && grown + foreseen < WORN {
            (grown, foreseen) = (WORN, 0.0);
        }
        if self.found == 0.0 { f64::INFINITY } else { self.found * (1.0 + grown + foreseen) }
    }

    /// Includes the deformation of the last pass in the growth. Returns the relative amount by which the rate of that
    /// pass was too small.
    pub(super) fn follow(&mut self, deformed: f64) -> f64 {
        self.age += 1;
        // The quadratic term makes it at least the exponential.
        self.growth += (deformed + deformed * deformed) * (1.0 + self.growth);
        let held = self.holds && self.growth < WORN;
        if held { 0.0 } else { (deformed - self.predicted_growth).max(0.0) }
    }

    /// Returns whether a new estimate replaces this one immediately, so that the time increment does not jump.
    pub(super) fn renews_at_once(&self) -> bool {
        self.holds && self.age as f64 > COST
    }

    /// Discards the estimate and sets the pause before the next one.
    pub(super) fn discard(&mut self) {
        // The gain decreases while the bound grows towards that of single elements.
        let shrunk = if self.gain > WORN { self.gain - 0.5 * WORN } else { 0.5 * self.gain * self.gain / WORN };
        let paid = self.age as f64 * shrunk > COST;
        self.pause = if paid { 0 } else { (2 * self.pause).clamp(PAUSE[0], PAUSE[1]) };
        self.found = 0.0;
        self.age = 0;
    }
}

fn masses_of_elements(groups: &[Box<dyn ElementGroup>], nodes: usize) -> Vec<f64> {
    let mut masses = vec![0.0; nodes];
    for group in groups {
        for e in 0..group.len() {
            for (n, mass) in group.nodes(e).into_iter().zip(group.masses(e)) {
                masses[n as usize] += mass;
            }
        }
    }
    masses
}

/// Returns one over the stable time increment of single elements.
fn rate_by_elements(groups: &[Box<dyn ElementGroup>], nodes: &Nodes) -> f64 {
    let alive = |group: &dyn ElementGroup, e: &usize| !group.is_deleted(*e);
    let of_group = |group: &dyn ElementGroup| {
        let elements = (0..group.len()).filter(|e| alive(group, e));
        let rate = |e| group.stable_rate(e, None, nodes.as_slice()).unwrap_or(0.0);
        elements.map(rate).fold(0.0, f64::max)
    };
    groups.iter().map(|group| of_group(&**group)).fold(0.0, f64::max)
}

/// Nodes whose motion is not free; they do not take part in the highest mode.
pub struct ConstrainedNodes<'a> {
    /// Node and axis of prescribed motions.
    pub prescribed: &'a [(usize, usize)],
    /// Nodes of rigid bodies.
    pub carried: &'a [usize],
}

impl HighestFrequency {
    /// Computes a new estimate for the current positions.
    pub(super) fn update_estimate(&mut self, groups: &[Box<dyn ElementGroup>], nodes: &Nodes) {
        // A run that continues from a checkpoint has not begun a step.
        self.allocate();
        self.assemble(groups, nodes);
        let found = self.find();
        let standing = &mut self.state;
        standing.count += 1;
        (standing.age, standing.growth, standing.by_elements) = (0, 0.0, rate_by_elements(groups, nodes));
        standing.found = if found.is_finite() { found } else { 0.0 };
    }
}

// The operator is recomputed with each estimate.
persist_struct!(HighestFrequency { roots: fixed, state } derived { id, pairs, values, vectors });

persist_struct!(EstimateState { found, growth, predicted_growth, age, pause, by_elements, gain, count, holds });

#[cfg(test)]
mod tests {
    use faer::{Mat, Side};

    use super::ConstrainedNodes;
    use super::HighestFrequency;
    use crate::element::constants::{ElementConstants, HourglassControl};
    use crate::element::elements::Elements;
    use crate::element::group::QuadGroup;
    use crate::kernel::bulk_viscosity::BulkViscosity;
    use crate::kernel::quad;
    use crate::material::plasticity::ElasticOnly;
    use crate::material::volumetric::ConstantBulkModulus;
    use crate::material::von_mises::VonMises;
    use crate::mesh::gather::NodalAssembly;
    use crate::state::nodes::Node;
    use crate::state::nodes::Nodes;

    const CONSTANTS: ElementConstants = ElementConstants {
        bulk: 3.0,
        shear: 1.0,
        hourglass: HourglassControl { stiffness: 0.005, viscosity: 0.0, relaxes: true, enhanced: 0.0 },
        bulk_viscosity: BulkViscosity::NONE,
        shear_viscosity: 0.0,
        by_area: false,
    };

    /// Returns a ring of squares whose nodes are displaced by a fraction of the side.
    fn body(columns: usize, rows: usize, wobble: f64) -> (Elements, Nodes) {
        let at = |n: usize| {
            let noise = |i: usize| wobble * (((i * 7919) % 101) as f64 / 101.0 - 0.5);
            [1.0 + (n % (columns + 1)) as f64 + noise(n), (n / (columns + 1)) as f64 + noise(n + 3)]
        };
        let count = (columns + 1) * (rows + 1);
        let nodes: Vec<Node> = (0..count).map(|n| Node { r: at(n)[0], z: at(n)[1], ..Node::default() }).collect();
        let elements: Vec<[u32; 4]> = (0..columns * rows)
            .map(|e| (e / columns * (columns + 1) + e % columns) as u32)
            .map(|n| [n, n + 1, n + columns as u32 + 2, n + columns as u32 + 1])
            .collect();
        let mut mass = vec![0.0; count];
        for corners in &elements {
            let places = corners.map(|n| nodes[n as usize].place());
            for (n, m) in corners.iter().zip(quad::corner_masses(places, 1.0)) {
                mass[*n as usize] += m;
            }
        }
        let quads = QuadGroup::new(VonMises::new(ElasticOnly, ConstantBulkModulus), CONSTANTS, 1.0, &elements, &nodes);
        let gather = NodalAssembly::new(count, &[(1, elements.iter().map(|e| (*e).into()).collect())]);
        (Elements::new(vec![Box::new(quads)], vec![0], gather, count), Nodes::new(nodes, mass))
    }

    fn estimate(elements: &Elements, nodes: &Nodes) -> (HighestFrequency, f64) {
        let mut frequency = HighestFrequency::new(&elements.groups, nodes).expect("linear elements");
        frequency.begin(&elements.groups, nodes, &ConstrainedNodes { prescribed: &[], carried: &[] });
        frequency.allocate();
        frequency.assemble(&elements.groups, nodes);
        let found = frequency.find();
        (frequency, found)
    }

    /// Comparison with dense eigenvalues (faer) of the same operator: the estimate is not lower and at most 2 % higher,
    /// the margin for random starts.
    #[test]
    fn estimate_bounds_the_largest_eigenvalue_closely() {
        for (columns, rows, wobble) in [(1, 1, 0.0), (3, 5, 0.3), (12, 12, 0.0), (12, 12, 0.4), (2, 60, 0.2)] {
            let (elements, nodes) = body(columns, rows, wobble);
            let (frequency, found) = estimate(&elements, &nodes);
            let size = 2 * nodes.len();
            let mut dense = Mat::<f64>::zeros(size, size);
            let mut values = frequency.values.iter();
            for (row, list) in frequency.pairs.outer_iterator().enumerate() {
                for (column, _) in list.iter() {
                    for (i, value) in values.next().expect("a value for each pair").iter().enumerate() {
                        dense[(2 * row + i / 2, 2 * column + i % 2)] = *value;
                    }
                }
            }
            for row in 0..size {
                for column in 0..row {
                    assert!((dense[(row, column)] - dense[(column, row)]).abs() < 1e-12);
                }
            }
            let eigenvalues = dense.self_adjoint_eigenvalues(Side::Lower).expect("eigenvalues");
            let exact = eigenvalues[size - 1].sqrt();
            let ratio = found / exact;
            println!("{columns} x {rows}: estimate over dense {ratio:.5}");
            assert!((1.0 - 1e-9..1.02).contains(&ratio), "{columns} x {rows}: {ratio}");
            // A translation along z causes no force.
            let along_z =
                |row: usize| (0..size / 2).map(|n| dense[(row, 2 * n + 1)] / frequency.roots[n][1]).sum::<f64>();
            let rigid = (0..size).map(|row| along_z(row).abs()).fold(0.0, f64::max);
            assert!(rigid < 1e-10, "{rigid}");
        }
    }
}
