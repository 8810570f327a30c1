//! Rayleigh damping of deformable bodies (ABAQUS Analysis User's Guide 26.1.1, "Material damping"): the force -α m v at
//! each node, and in elements the stress β C d of the elastic moduli C and the strain rate d. As in ABAQUS/Explicit, the
//! velocity is that of the middle of the previous increment.

use super::group::ElementGroup;
use crate::kernel::lanes::InlineMap;
use crate::kernel::lists::Memory;
use crate::kernel::quad::{UNIT, gradient};
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::nodes::Nodes;

/// Damping factors of an element group.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayleighFactors {
    /// Factor α of the mass, 1/time.
    pub mass: f64,
    /// Factor β of the stiffness, time.
    pub stiffness: f64,
    /// Elastic bulk and shear modulus.
    pub moduli: [f64; 2],
}

/// A quadrilateral with stiffness proportional damping.
#[derive(Clone, Copy, Debug)]
struct DampedCell {
    /// Element group and element.
    place: (usize, usize),
    nodes: [u32; 4],
    /// β times the moduli of the volumetric and of twice the shear strain.
    viscosities: [f64; 2],
}

/// Damping forces of all nodes of elements with Rayleigh damping.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(fixed: coefficients, forces; derived: factors, half, most, cells, stresses)]
pub struct RayleighDamping {
    /// Factors of each element group.
    factors: Vec<RayleighFactors>,
    /// Half the largest factor α, increased by linear bulk viscosity, and the largest factor β; they limit the time
    /// increment.
    half: f64,
    most: f64,
    /// Quadrilaterals with stiffness proportional damping, and the sums of their forces at nodes.
    cells: Vec<DampedCell>,
    stresses: Vec<[f64; 2]>,
    /// Sum of factor times mass at each node.
    coefficients: Vec<f64>,
    /// Forces at the previous instant.
    forces: Vec<[f64; 2]>,
    /// Whether central differences started at that instant.
    started: bool,
}

impl DampedCell {
    /// Returns the force on each corner.
    fn forces(&self, nodes: &Nodes) -> [[f64; 2]; 4] {
        let corners = self.nodes.inline_map(|n| &nodes[n as usize]);
        let g = gradient(corners.inline_map(|n| n.r), corners.inline_map(|n| n.z));
        if g.volume <= 0.0 {
            return [[0.0; 2]; 4];
        }
        // Strain rates times the volume: rr, zz, hoop, rz.
        let mut rates = [0.0; 4];
        for (i, node) in corners.into_iter().enumerate() {
            rates[0] += g.r[i] * node.v_r;
            rates[1] += g.z[i] * node.v_z;
            rates[2] += g.hoop[i] * node.v_r;
            rates[3] += 0.5 * (g.z[i] * node.v_r + g.r[i] * node.v_z);
        }
        let [volumetric, twice] = self.viscosities.inline_map(|v| v * UNIT / g.volume);
        let mean = volumetric * (rates[0] + rates[1] + rates[2]);
        let [rr, zz, hoop] = [0, 1, 2].inline_map(|i: usize| mean + twice * rates[i]);
        let rz = twice * rates[3];
        [0, 1, 2, 3]
            .inline_map(|i: usize| [-(rr * g.r[i] + rz * g.z[i] + hoop * g.hoop[i]), -(zz * g.z[i] + rz * g.r[i])])
    }
}

impl RayleighDamping {
    /// Creates the damping from the factors of the groups and the coefficient of linear bulk viscosity, which also
    /// damps the highest mode.
    pub fn new(
        factors: Vec<RayleighFactors>,
        bulk_viscosity: f64,
        groups: &[Box<dyn ElementGroup>],
        nodes: usize,
    ) -> Self {
        let half = 0.5 * factors.iter().map(|f| f.mass).fold(0.0, f64::max) * (1.0 + bulk_viscosity);
        let largest_stiffness = factors.iter().map(|f| f.stiffness).fold(0.0, f64::max);
        let mut cells = Vec::new();
        for (at, (group, own)) in groups.iter().zip(&factors).enumerate().filter(|g| g.1.1.stiffness > 0.0) {
            let [bulk, shear] = own.moduli;
            let viscosities = [bulk - 2.0 / 3.0 * shear, 2.0 * shear].inline_map(|modulus| own.stiffness * modulus);
            let cells_of =
                |e: usize| group.cells(e).map(move |nodes| DampedCell { place: (at, e), nodes, viscosities });
            cells.extend((0..group.len()).flat_map(cells_of));
        }
        let stresses = vec![[0.0; 2]; if cells.is_empty() { 0 } else { nodes }];
        let (coefficients, forces, started) = (vec![0.0; nodes], vec![[0.0; 2]; nodes], false);
        let mut damping =
            RayleighDamping { factors, half, most: largest_stiffness, cells, stresses, coefficients, forces, started };
        damping.update_masses(groups);
        damping
    }

    /// Recomputes the coefficients from the current masses of elements.
    pub(super) fn update_masses(&mut self, groups: &[Box<dyn ElementGroup>]) {
        self.coefficients.fill(0.0);
        for (group, factors) in groups.iter().zip(&self.factors).filter(|g| g.1.mass > 0.0) {
            for e in 0..group.len() {
                for (n, mass) in group.nodes(e).into_iter().zip(group.masses(e)) {
                    self.coefficients[n as usize] += factors.mass * mass;
                }
            }
        }
    }

    /// Returns one over the stable time increment, given its value without this damping. With the fraction
    /// ξ = α/(2ω) + βω/2 of critical damping in the highest mode the increment is 2/ω (sqrt(1 + ξ²) - ξ) ("Explicit
    /// dynamic analysis"). The fraction of bulk viscosity, already included in the input, adds to ξ.
    pub(super) fn rate(&self, without: f64) -> f64 {
        let half = self.half + 2.0 * self.most * without * without;
        0.5 * ((4.0 * without * without + half * half).sqrt() + half)
    }

    /// Sums the nodal forces of stiffness proportional damping of all elements that are not deleted.
    fn sum_stresses(&mut self, nodes: &Nodes, alive: impl Fn((usize, usize)) -> bool) {
        self.stresses.fill([0.0; 2]);
        for cell in self.cells.iter().filter(|cell| alive(cell.place)) {
            for (&n, force) in cell.nodes.iter().zip(cell.forces(nodes)) {
                let sum = &mut self.stresses[n as usize];
                *sum = [sum[0] + force[0], sum[1] + force[1]];
            }
        }
    }

    /// Adds the damping forces to the nodal forces. Their work over the previous increment is computed by the
    /// trapezoidal rule, as for all nodal forces; it is dissipated and therefore subtracted from the external work.
    pub(super) fn add_forces(&mut self, dofs: &mut Dofs, alive: impl Fn((usize, usize)) -> bool) {
        self.sum_stresses(&dofs.nodes, alive);
        let dt = dofs.nodes.unaccounted_dt();
        // At the start of central differences, the external work omits a part of the impulse (`correct_first_work`).
        let start = if self.started && dt > 0.0 { 0.125 * dt * dt } else { 0.0 };
        let mut work = 0.0;
        for (n, (coefficient, before)) in self.coefficients.iter().zip(&mut self.forces).enumerate() {
            let node = &dofs.nodes[n];
            let stress = self.stresses.get(n).copied().unwrap_or_default();
            let force = [stress[0] - coefficient * node.v_r, stress[1] - coefficient * node.v_z];
            work += 0.5 * dt * ((force[0] + before[0]) * node.v_r + (force[1] + before[1]) * node.v_z);
            let a = dofs.nodes.acceleration[n];
            work -= start * (before[0] * a[0] + before[1] * a[1]);
            dofs.nodes.forces[0][n][0] += force[0];
            dofs.nodes.forces[0][n][1] += force[1];
            *before = force;
        }
        dofs.energies.external -= work;
        dofs.energies.viscous -= work;
        self.started = dofs.nodes.previous_dt == 0.0;
    }
}
