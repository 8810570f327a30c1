//! Highest frequency of all deformable elements, which determines the stable time increment: the global estimator that
//! ABAQUS/Explicit uses by default (Analysis User's Guide, "Explicit dynamic analysis", "Stable time increment
//! estimator"). It is below the bound of single elements, most of all for square elements.
//!
//! The eigenvalue is computed by Lanczos' method ([`super::lanczos`]), and increased by the expected error. Until the next
//! estimate it is increased with the largest strain increment of any element, so that it remains a bound. After too much
//! deformation it is replaced by the bound of single elements, and computed again when the gain is likely to exceed its
//! cost.

use pulp::Arch;
use rayon::prelude::*;

use super::group::ElementGroup;
use super::lanczos::{LanczosVectors, SparseOperator};
use crate::kernel::chunks::CHUNK;
use crate::kernel::lanes::InlineMap as _;
use crate::platform::PortableMath as _;
use crate::state::EffectId;
use crate::state::archive::Persist;
use crate::state::nodes::{Node, Nodes};

/// Approximate run time of an estimate in increments: each step reads the operator once.
const COST: f64 = 50.0;
/// Relative growth of the bound at which an estimate is discarded.
pub(super) const WORN: f64 = 0.1;
/// Smallest and largest pause, in increments, after an estimate that did not pay.
const PAUSE: [u64; 2] = [100, 20_000];

/// Estimator of the highest frequency: operator, vectors and current estimate.
#[derive(Clone, Debug, Persist)]
// The operator is recomputed with each estimate.
#[persist(fixed: roots; derived: id, operator, vectors)]
pub struct HighestFrequency {
    pub id: EffectId,
    operator: SparseOperator,
    /// Inverse square root of the mass of each degree of freedom; 0 for prescribed motion.
    roots: Vec<[f64; 2]>,
    vectors: LanczosVectors,
    pub(super) state: EstimateState,
}

/// State of the estimate between increments.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
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
    /// Whether the step has begun without an estimate, and has none so far.
    pub waits: bool,
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
            operator: SparseOperator::of(groups, nodes.len()),
            roots: vec![[0.0; 2]; nodes.len()],
            vectors: LanczosVectors::default(),
            state: EstimateState::default(),
        })
    }

    /// Returns names and bytes of the arrays during a run.
    pub fn arrays(&self) -> Vec<(&'static str, usize)> {
        let vectors = LanczosVectors::bytes(self.roots.len()) + size_of_val(&*self.roots);
        vec![("sparse operator", self.operator.bytes()), ("Lanczos vectors", vectors)]
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
        let masses = if held.carried.is_empty() { Vec::new() } else { masses_of_elements(groups, nodes.len()) };
        for &n in held.carried {
            self.roots[n] = [0.0, 1.0 / masses[n].sqrt()];
        }
        for &(node, axis) in held.prescribed {
            self.roots[node][axis] = 0.0;
        }
        self.roots.as_flattened_mut().iter_mut().filter(|r| !r.is_finite()).for_each(|r| *r = 0.0);
    }
}

impl HighestFrequency {
    /// Allocates the memory of a later estimate.
    pub(super) fn allocate(&mut self) {
        self.operator.allocate();
        self.vectors.allocate(self.roots.len());
    }

    /// Returns whether an estimate would be discarded before it pays, because the initial velocities deform elements fast. The
    /// time increment would fall to that of single elements while the accelerations of an impact are largest, which adds
    /// energy: m a² (dt'² - dt²)/8 at each node.
    pub(super) fn wears_at_once(&self, groups: &[Box<dyn ElementGroup>], nodes: &Nodes) -> bool {
        let strain_rate = groups.iter().map(|group| self.strain_rate(&**group, nodes)).fold(0.0, f64::max);
        !self.state.holds && COST * strain_rate > WORN * rate_by_elements(groups, nodes)
    }

    /// Returns the largest rate of strain along a side of an element, with prescribed degrees of freedom at rest.
    fn strain_rate(&self, group: &dyn ElementGroup, nodes: &Nodes) -> f64 {
        let of_side = |a: u32, b: u32| {
            let [from, to] = [a, b].inline_map(|n| (&nodes.as_slice()[n as usize], self.roots[n as usize]));
            let velocity = |(node, roots): (&Node, [f64; 2])| {
                let free = |velocity: f64, root: f64| if root > 0.0 { velocity } else { 0.0 };
                [free(node.v_r, roots[0]), free(node.v_z, roots[1])]
            };
            let ([u_r, u_z], [v_r, v_z]) = (velocity(from), velocity(to));
            (v_r - u_r).portable_hypot(v_z - u_z) / (to.0.r - from.0.r).portable_hypot(to.0.z - from.0.z)
        };
        let of_element = |e: usize| {
            let corners = group.nodes(e);
            let next = corners.into_iter().cycle().skip(1);
            corners.into_iter().zip(next).map(|(a, b)| of_side(a, b)).fold(0.0, f64::max)
        };
        let elements = (0..group.len()).into_par_iter().with_min_len(CHUNK).filter(|e| !group.is_deleted(*e));
        elements.map(of_element).reduce(|| 0.0, f64::max)
    }
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
        let is_held = self.holds && self.growth < WORN;
        if is_held { 0.0 } else { (deformed - self.predicted_growth).max(0.0) }
    }

    /// Returns whether a new estimate replaces this one immediately, so that the time increment does not jump.
    pub(super) fn renews_at_once(&self) -> bool {
        self.holds && self.age as f64 > COST
    }

    /// Waits for the first pause, as after an estimate that did not pay.
    pub(super) fn wait(&mut self) {
        (self.pause, self.waits) = (PAUSE[0], true);
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
    let of_group = |group: &dyn ElementGroup| {
        let elements = (0..group.len()).into_par_iter().with_min_len(CHUNK).filter(|e| !group.is_deleted(*e));
        let rate = |e| group.stable_rate(e, None, nodes.as_slice()).unwrap_or(0.0);
        elements.map(rate).reduce(|| 0.0, f64::max)
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
    pub(super) fn update_estimate(&mut self, groups: &[Box<dyn ElementGroup>], nodes: &Nodes, arch: Arch) {
        let frequency = self.find(groups, nodes, arch);
        let standing = &mut self.state;
        standing.count += 1;
        standing.waits = false;
        (standing.age, standing.growth, standing.by_elements) = (0, 0.0, rate_by_elements(groups, nodes));
        standing.found = if frequency.is_finite() { frequency } else { 0.0 };
    }

    /// Returns the highest frequency, radians per time, increased by the expected error.
    fn find(&mut self, groups: &[Box<dyn ElementGroup>], nodes: &Nodes, arch: Arch) -> f64 {
        self.operator.assemble(groups, nodes, &self.roots);
        self.vectors.largest_eigenvalue(&self.operator, arch).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use faer::{Mat, Side};

    use super::ConstrainedNodes;
    use super::HighestFrequency;
    use crate::element::constants::{ElementConstants, HourglassControl};
    use crate::element::elements::Elements;
    use crate::element::quad::QuadGroup;
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
        let node_at = |n: usize| {
            let noise = |i: usize| wobble * (((i * 7919) % 101) as f64 / 101.0 - 0.5);
            [1.0 + (n % (columns + 1)) as f64 + noise(n), (n / (columns + 1)) as f64 + noise(n + 3)]
        };
        let count = (columns + 1) * (rows + 1);
        let nodes: Vec<Node> =
            (0..count).map(|n| Node { r: node_at(n)[0], z: node_at(n)[1], ..Node::default() }).collect();
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
        let gather = NodalAssembly::new(count, &[(1, elements.iter().map(|e| (*e).into()))]);
        (Elements::new(vec![Box::new(quads)], vec![0], gather, count), Nodes::new(nodes, mass))
    }

    fn estimate(elements: &Elements, nodes: &Nodes) -> (HighestFrequency, f64) {
        let mut frequency = HighestFrequency::new(&elements.groups, nodes).expect("linear elements");
        frequency.begin(&elements.groups, nodes, &ConstrainedNodes { prescribed: &[], carried: &[] });
        let estimate = frequency.find(&elements.groups, nodes, elements.arch());
        (frequency, estimate)
    }

    /// Comparison with dense eigenvalues (faer) of the same operator: the estimate is not lower and at most 2 % higher,
    /// the margin for random starts.
    #[test]
    fn estimate_bounds_the_largest_eigenvalue_closely() {
        for (columns, rows, wobble) in [(1, 1, 0.0), (3, 5, 0.3), (12, 12, 0.0), (12, 12, 0.4), (2, 60, 0.2)] {
            let (elements, nodes) = body(columns, rows, wobble);
            let (frequency, estimated) = estimate(&elements, &nodes);
            let size = 2 * nodes.len();
            let mut dense = Mat::<f64>::zeros(size, size);
            for ([row, column], block) in frequency.operator.blocks() {
                for (i, value) in block.iter().enumerate() {
                    dense[(2 * row + i % 2, 2 * column + i / 2)] = f64::from(*value);
                }
            }
            for row in 0..size {
                for column in 0..row {
                    assert!((dense[(row, column)] - dense[(column, row)]).abs() < 1e-12);
                }
            }
            let eigenvalues = dense.self_adjoint_eigenvalues(Side::Lower).expect("eigenvalues");
            let exact = eigenvalues[size - 1].sqrt();
            let ratio = estimated / exact;
            println!("{columns} x {rows}: estimate over dense {ratio:.5}");
            assert!((1.0 - 1e-9..1.02).contains(&ratio), "{columns} x {rows}: {ratio}");
            // A translation along z causes no force. Blocks are sums of four numbers of single precision.
            let along_z =
                |row: usize| (0..size / 2).map(|n| dense[(row, 2 * n + 1)] / frequency.roots[n][1]).sum::<f64>();
            let rigid = (0..size).map(|row| along_z(row).abs()).fold(0.0, f64::max);
            assert!(rigid < 1e-5, "{rigid}");
        }
    }
}
