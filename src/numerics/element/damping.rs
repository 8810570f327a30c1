//! Mass proportional damping of deformable bodies: the force -α m v at each node (ABAQUS Analysis User's Guide,
//! "Material damping"). As in ABAQUS/Explicit, v is the velocity at the middle of the previous increment.

use super::group::ElementGroup;
use crate::state::archive::persist_struct;
use crate::state::dofs::Dofs;

/// Damping forces of all nodes of elements with mass proportional damping.
#[derive(Clone, Debug)]
pub struct MassDamping {
    /// Factor α of each element group, 1/time.
    factors: Vec<f64>,
    /// Half the largest factor, increased by linear bulk viscosity; limits the time increment.
    half: f64,
    /// Sum of factor times mass at each node.
    coefficients: Vec<f64>,
    /// Forces at the previous instant.
    forces: Vec<[f64; 2]>,
    /// Whether central differences started at that instant.
    started: bool,
}

impl MassDamping {
    /// Creates the damping from the factors of the groups and the coefficient of linear bulk viscosity, which also
    /// damps the highest mode.
    pub fn new(factors: Vec<f64>, bulk_viscosity: f64, groups: &[Box<dyn ElementGroup>], nodes: usize) -> Self {
        let half = 0.5 * factors.iter().copied().fold(0.0, f64::max) * (1.0 + bulk_viscosity);
        let (coefficients, forces) = (vec![0.0; nodes], vec![[0.0; 2]; nodes]);
        let mut damping = MassDamping { factors, half, coefficients, forces, started: false };
        damping.update_masses(groups);
        damping
    }

    /// Recomputes the coefficients from the current masses of elements.
    pub(super) fn update_masses(&mut self, groups: &[Box<dyn ElementGroup>]) {
        self.coefficients.fill(0.0);
        for (group, factor) in groups.iter().zip(&self.factors).filter(|g| *g.1 > 0.0) {
            for e in 0..group.len() {
                for (n, mass) in group.nodes(e).into_iter().zip(group.masses(e)) {
                    self.coefficients[n as usize] += factor * mass;
                }
            }
        }
    }

    /// Returns one over the stable time increment, given its value without this damping. With the fraction ξ = α/(2ω)
    /// of critical damping in the highest mode the increment is 2/ω (sqrt(1 + ξ²) - ξ) ("Explicit dynamic analysis").
    /// The fraction of bulk viscosity, already included in the input, adds to ξ.
    pub(super) fn rate(&self, without: f64) -> f64 {
        0.5 * ((4.0 * without * without + self.half * self.half).sqrt() + self.half)
    }

    /// Adds the damping forces to the nodal forces. Their work over the previous increment is computed by the
    /// trapezoidal rule, as for all nodal forces; it is dissipated and therefore subtracted from the external work.
    pub(super) fn add_forces(&mut self, dofs: &mut Dofs) {
        let dt = dofs.nodes.unaccounted_dt();
        // At the start of central differences, the external work omits a part of the impulse (`correct_first_work`).
        let start = if self.started && dt > 0.0 { 0.125 * dt * dt } else { 0.0 };
        let mut work = 0.0;
        for (n, (coefficient, before)) in self.coefficients.iter().zip(&mut self.forces).enumerate() {
            let node = &dofs.nodes[n];
            let force = [-coefficient * node.v_r, -coefficient * node.v_z];
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

    pub fn bytes(&self) -> usize {
        size_of_val(&*self.factors) + size_of_val(&*self.coefficients) + size_of_val(&*self.forces)
    }
}

persist_struct!(MassDamping { coefficients: fixed, forces: fixed, started } derived { factors, half });
