//! The highest frequency of what deforms, from which the stable increment follows: the global estimate that
//! ABAQUS/Explicit uses by default (Analysis User's Guide, "Explicit dynamic analysis", "Stable time increment estimator").
//! It lies below what single elements allow, most of all where elements are square.
//!
//! The eigenvalue comes from Lanczos' method on the assembled operator, made safe by the error to expect of a random start.
//! Until the next estimate it grows with the largest strain increment anywhere, so that it stays a bound; once the body has
//! deformed too far it is dropped for the bound by elements, and estimated anew when that is likely to pay.
//! Never here: the loop over increments, the bound by elements.

use crate::kernel::lanes::InlineMap;
use nalgebra::SMatrix;
use sprs::CsMatI;

use super::group::{ElementGroup, Stiffness};
use crate::kernel::topology::ElementNodes;
use crate::state::EffectId;
use crate::state::archive::persist_struct;
use crate::state::nodes::Nodes;

/// Steps of Lanczos' method.
const STEPS: usize = 40;
/// Increments that an estimate costs, roughly: each step reads the operator once.
const COST: f64 = 50.0;
/// Growth of the bound, relative, at which it is dropped.
pub(super) const WORN: f64 = 0.1;
/// Most and least increments between two estimates of which the first did not pay.
const PAUSE: [u64; 2] = [100, 20_000];

/// A symmetric sparse matrix by rows, of a square of entries for each pair of nodes: `[rr, rz, zr, zz]`.
type Operator = CsMatI<[f64; 4], u32>;

/// The estimate, and what it is made from.
#[derive(Clone, Debug)]
pub struct HighestFrequency {
    pub id: EffectId,
    /// M^-1/2 K M^-1/2.
    operator: Operator,
    /// One over the root of the mass of each degree of freedom; 0 where motion is given.
    roots: Vec<[f64; 2]>,
    vectors: [Vec<[f64; 2]>; 3],
    pub(super) standing: Standing,
}

/// Where an estimate stands between increments.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Standing {
    /// Frequency found last; 0 if none holds.
    pub found: f64,
    /// How far what deforms may have raised it since, relative.
    pub grown: f64,
    /// What of it was allowed for the pass behind.
    pub foreseen: f64,
    /// Increments since it was found, and for how long no other is wanted.
    pub age: u64,
    pub pause: u64,
    /// Rate by elements when it was found, and by how much it lay below, relative.
    pub by_elements: f64,
    pub gain: f64,
    pub count: u64,
    /// Whether the bound takes all that it may grow by at once, so that the increment stays what it is until it is worn out.
    pub holds: bool,
}

impl HighestFrequency {
    /// For a body; `None` where some of it is not linear elastic for small strains.
    pub fn new(groups: &[Box<dyn ElementGroup>], nodes: &Nodes) -> Option<HighestFrequency> {
        if groups.iter().any(|g| !g.is_empty() && g.stiffness(0, nodes.as_slice()).is_none()) {
            return None;
        }
        let zeros = || vec![[0.0; 2]; nodes.len()];
        let (operator, roots) = (pattern(groups, nodes.len()), zeros());
        Some(HighestFrequency {
            id: 0,
            operator,
            roots,
            vectors: [zeros(), zeros(), zeros()],
            standing: Standing::default(),
        })
    }

    /// Names and bytes of its arrays.
    pub fn arrays(&self) -> Vec<(&'static str, usize)> {
        let operator = self.operator.nnz() * 36 + self.operator.indptr().len() * 4;
        vec![("sparse operator", operator), ("Lanczos vectors", 4 * size_of_val(&*self.roots))]
    }

    /// Begins a step: with other motions given the highest frequency is another.
    pub(super) fn begin(&mut self, groups: &[Box<dyn ElementGroup>], nodes: &Nodes, held: &Held<'_>) {
        // Without damping the highest modes grow where the increment follows the motion, the sooner the nearer it is to what
        // they allow.
        let holds = groups.iter().any(|g| !g.is_empty() && !g.properties().damped);
        self.standing = Standing { count: self.standing.count, holds, ..Standing::default() };
        for (roots, mass) in self.roots.iter_mut().zip(&nodes.mass) {
            *roots = [1.0 / mass.sqrt(); 2];
        }
        // Nodes that a rigid body moves have no mass of their own here. Together they have at least that of their elements
        // and no more stiffness than each alone.
        let own = if held.carried.is_empty() { Vec::new() } else { masses_of_elements(groups, nodes.len()) };
        for &n in held.carried {
            self.roots[n] = [0.0, 1.0 / own[n].sqrt()];
        }
        for &(node, axis) in held.prescribed {
            self.roots[node][axis] = 0.0;
        }
        self.roots.as_flattened_mut().iter_mut().filter(|r| !r.is_finite()).for_each(|r| *r = 0.0);
    }

    /// Puts the stiffness of all elements into the operator.
    fn assemble(&mut self, groups: &[Box<dyn ElementGroup>], nodes: &Nodes) {
        self.operator.data_mut().fill([0.0; 4]);
        for group in groups {
            for e in 0..group.len() {
                let Some(matrix) = group.stiffness(e, nodes.as_slice()) else { continue };
                self.add(&group.nodes(e), &matrix);
            }
        }
    }

    fn add(&mut self, nodes: &ElementNodes, Stiffness(matrix): &Stiffness) {
        let roots = nodes.map(|n| self.roots[n as usize]);
        for (a, &row) in nodes.iter().enumerate() {
            let starts = self.operator.indptr();
            let [begin, end] = [row, row + 1].inline_map(|r| starts.raw_storage()[r as usize] as usize);
            for (b, column) in nodes.iter().enumerate() {
                let at = begin + self.operator.indices()[begin..end].partition_point(|c| c < column);
                for (i, entry) in self.operator.data_mut()[at].iter_mut().enumerate() {
                    let (along, across) = (i / 2, i % 2);
                    *entry += matrix[2 * a + along][2 * b + across] * roots[a][along] * roots[b][across];
                }
            }
        }
    }

    /// Highest frequency, angle over time, not below the true one.
    fn find(&mut self) -> f64 {
        let (diagonal, beside, taken) = self.lanczos();
        let mut small = SMatrix::<f64, STEPS, STEPS>::zeros();
        for i in 0..taken {
            small[(i, i)] = diagonal[i];
            if i + 1 < taken {
                small[(i, i + 1)] = beside[i];
                small[(i + 1, i)] = beside[i];
            }
        }
        let largest = small.symmetric_eigenvalues().max();
        (largest / (1.0 - missing(2 * self.roots.len(), taken))).sqrt()
    }

    /// The tridiagonal matrix of Lanczos' method from a start without pattern, and its size.
    fn lanczos(&mut self) -> ([f64; STEPS], [f64; STEPS], usize) {
        let (mut diagonal, mut beside) = ([0.0; STEPS], [0.0; STEPS]);
        let [before, now, next] = &mut self.vectors;
        before.fill([0.0; 2]);
        scatter(now);
        let length = dot(now, now).sqrt();
        scale(now, 1.0 / length);
        let mut last = 0.0;
        for step in 0..STEPS {
            multiply(&self.operator, now, next);
            subtract(next, last, before);
            diagonal[step] = dot(next, now);
            subtract(next, diagonal[step], now);
            last = dot(next, next).sqrt();
            beside[step] = last;
            // All of the space is spanned.
            if last <= 1e-12 * diagonal[0] {
                return (diagonal, beside, step + 1);
            }
            scale(next, 1.0 / last);
            std::mem::swap(before, now);
            std::mem::swap(now, next);
        }
        (diagonal, beside, STEPS)
    }
}

fn multiply(operator: &Operator, vector: &[[f64; 2]], product: &mut [[f64; 2]]) {
    for (row, out) in operator.outer_iterator().zip(product) {
        let mut sum = [0.0; 2];
        for (column, [rr, rz, zr, zz]) in row.iter() {
            let [r, z] = vector[column];
            sum = [sum[0] + (rr * r + rz * z), sum[1] + (zr * r + zz * z)];
        }
        *out = sum;
    }
}

fn scale(list: &mut [[f64; 2]], factor: f64) {
    list.as_flattened_mut().iter_mut().for_each(|x| *x *= factor);
}

fn subtract(list: &mut [[f64; 2]], factor: f64, other: &[[f64; 2]]) {
    list.as_flattened_mut().iter_mut().zip(other.as_flattened()).for_each(|(x, o)| *x -= factor * o);
}

/// The part of the largest eigenvalue that so many steps are expected to miss at most: Kuczynski and Wozniakowski 1992 (SIAM
/// J. Matrix Anal. Appl. 13, 1094), theorem 3.2, for random starts.
fn missing(size: usize, steps: usize) -> f64 {
    if steps < STEPS {
        return 1e-12;
    }
    let one_less = (steps - 1) as f64;
    let ratio = libm::log(size as f64 * one_less * one_less) / one_less;
    0.103 * ratio * ratio
}

/// Numbers without pattern, always the same, between -1 and 1 (a linear congruence: Knuth, The Art of Computer Programming
/// 2, 3.3.4).
fn scatter(list: &mut [[f64; 2]]) {
    let mut state = 1_u64;
    for x in list.as_flattened_mut() {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        *x = (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0;
    }
}

/// In fixed order, four sums side by side.
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

/// Zeros where two nodes share an element.
fn pattern(groups: &[Box<dyn ElementGroup>], count: usize) -> Operator {
    // Elements at each node, one behind the other: places in a list, and where each node's begin.
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
    let zeros = vec![[0.0; 4]; columns.len()];
    Operator::new((count, count), starts, columns, zeros)
}

impl Standing {
    /// The bound for the pass to come: what has been found, what has deformed since, what the pass may add.
    pub(super) fn cap(&mut self, deformed: f64) -> f64 {
        self.foreseen = 2.0 * deformed;
        let (mut grown, mut foreseen) = (self.grown, self.foreseen);
        if self.holds && grown + foreseen < WORN {
            (grown, foreseen) = (WORN, 0.0);
        }
        if self.found == 0.0 { f64::INFINITY } else { self.found * (1.0 + grown + foreseen) }
    }

    /// Takes in the pass behind, which deformed by so much; whether the estimate is worn out. Returns by how much the
    /// rate of the pass was too small, relative.
    pub(super) fn follow(&mut self, deformed: f64) -> f64 {
        self.age += 1;
        // The square makes it no less than the exponential.
        self.grown += (deformed + deformed * deformed) * (1.0 + self.grown);
        let held = self.holds && self.grown < WORN;
        if held { 0.0 } else { (deformed - self.foreseen).max(0.0) }
    }

    /// Whether another estimate takes the place of this worn one at once: no increment in between jumps.
    pub(super) fn goes_on(&self) -> bool {
        self.holds && self.age as f64 > COST
    }

    /// No estimate holds any more; the next one is made when it is likely to pay.
    pub(super) fn drop(&mut self) {
        // The gain shrinks while the bound grows towards that by elements.
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

/// One over the increment that single elements allow.
fn rate_by_elements(groups: &[Box<dyn ElementGroup>], nodes: &Nodes) -> f64 {
    let alive = |group: &dyn ElementGroup, e: &usize| !group.is_deleted(*e);
    let of_group = |group: &dyn ElementGroup| {
        let elements = (0..group.len()).filter(|e| alive(group, e));
        let rate = |e| group.stable_rate(e, None, nodes.as_slice()).unwrap_or(0.0);
        elements.map(rate).fold(0.0, f64::max)
    };
    groups.iter().map(|group| of_group(&**group)).fold(0.0, f64::max)
}

/// What constraints hold of the nodes.
pub struct Held<'a> {
    /// Node and axis of motions that are prescribed.
    pub prescribed: &'a [(usize, usize)],
    /// Nodes that rigid bodies carry.
    pub carried: &'a [usize],
}

impl HighestFrequency {
    /// A new estimate on the present nodes.
    pub(super) fn renew(&mut self, groups: &[Box<dyn ElementGroup>], nodes: &Nodes) {
        self.assemble(groups, nodes);
        let found = self.find();
        let standing = &mut self.standing;
        standing.count += 1;
        (standing.age, standing.grown, standing.by_elements) = (0, 0.0, rate_by_elements(groups, nodes));
        standing.found = if found.is_finite() { found } else { 0.0 };
    }
}

// The operator is made anew with each estimate.
persist_struct!(HighestFrequency { roots: fixed, standing } derived { id, operator, vectors });

persist_struct!(Standing { found, grown, foreseen, age, pause, by_elements, gain, count, holds });

#[cfg(test)]
mod tests {
    use faer::{Mat, Side};

    use super::Held;
    use super::HighestFrequency;
    use crate::element::constants::{Constants, HourglassControl};
    use crate::element::elements::Elements;
    use crate::element::group::Quads;
    use crate::kernel::quad;
    use crate::material::plasticity::Elastic;
    use crate::material::volumetric::Linear;
    use crate::material::von_mises::VonMises;
    use crate::mesh::gather::Gather;
    use crate::state::nodes::Node;
    use crate::state::nodes::Nodes;

    const CONSTANTS: Constants = Constants {
        bulk: 3.0,
        shear: 1.0,
        hourglass: HourglassControl { stiffness: 0.005, viscosity: 0.0, relaxes: true, enhanced: 0.0 },
        bulk_viscosity: [0.0, 0.0],
    };

    /// A ring of squares, its nodes moved about by a fraction of the side.
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
        let quads = Quads::new(VonMises::new(Elastic, Linear), CONSTANTS, 1.0, &elements, &nodes);
        let gather = Gather::new(count, &[(1, elements.iter().map(|e| (*e).into()).collect())]);
        (Elements::new(vec![Box::new(quads)], vec![0], gather, count), Nodes::new(nodes, mass))
    }

    fn estimate(elements: &Elements, nodes: &Nodes) -> (HighestFrequency, f64) {
        let mut frequency = HighestFrequency::new(&elements.groups, nodes).expect("linear elements");
        frequency.begin(&elements.groups, nodes, &Held { prescribed: &[], carried: &[] });
        frequency.assemble(&elements.groups, nodes);
        let found = frequency.find();
        (frequency, found)
    }

    /// Dense eigenvalues (faer) of the same operator: the estimate is no lower, and at most 2 % above, which is what the
    /// bound for random starts adds.
    #[test]
    fn the_estimate_is_the_largest_eigenvalue_and_never_below_it() {
        for (columns, rows, wobble) in [(1, 1, 0.0), (3, 5, 0.3), (12, 12, 0.0), (12, 12, 0.4), (2, 60, 0.2)] {
            let (elements, nodes) = body(columns, rows, wobble);
            let (frequency, found) = estimate(&elements, &nodes);
            let size = 2 * nodes.len();
            let mut dense = Mat::<f64>::zeros(size, size);
            for (row, list) in frequency.operator.outer_iterator().enumerate() {
                for (column, square) in list.iter() {
                    for (i, value) in square.iter().enumerate() {
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
            // Moving as one along z needs no force.
            let along_z =
                |row: usize| (0..size / 2).map(|n| dense[(row, 2 * n + 1)] / frequency.roots[n][1]).sum::<f64>();
            let rigid = (0..size).map(|row| along_z(row).abs()).fold(0.0, f64::max);
            assert!(rigid < 1e-10, "{rigid}");
        }
    }
}
