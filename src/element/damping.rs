//! Mass proportional damping of what deforms: at each node the force -alpha m v (ABAQUS Analysis User's Guide, "Material
//! damping"), with the velocity of the middle of the increment behind, as ABAQUS/Explicit takes it.
//! Never here: bulk viscosity, dashpots.

use super::group::ElementGroup;
use crate::state::archive::persist_struct;
use crate::state::dofs::Dofs;

/// Damping of all nodes whose elements have some.
#[derive(Clone, Debug)]
pub struct Damping {
    /// Factor of each group of elements, 1/time.
    factors: Vec<f64>,
    /// What bounds the increment: half the largest factor, raised for what bulk viscosity damps.
    half: f64,
    /// Factor times mass at each node.
    coefficients: Vec<f64>,
    /// Forces at the instant before.
    forces: Vec<[f64; 2]>,
    /// Whether central differences started at that instant.
    started: bool,
}

impl Damping {
    /// Factors by group, and the linear bulk viscosity, which damps the highest mode too.
    pub fn new(factors: Vec<f64>, bulk_viscosity: f64, groups: &[Box<dyn ElementGroup>], nodes: usize) -> Self {
        let half = 0.5 * factors.iter().copied().fold(0.0, f64::max) * (1.0 + bulk_viscosity);
        let (coefficients, forces) = (vec![0.0; nodes], vec![[0.0; 2]; nodes]);
        let mut damping = Damping { factors, half, coefficients, forces, started: false };
        damping.weigh(groups);
        damping
    }

    /// Takes the masses of elements as they are.
    pub(super) fn weigh(&mut self, groups: &[Box<dyn ElementGroup>]) {
        self.coefficients.fill(0.0);
        for (group, factor) in groups.iter().zip(&self.factors).filter(|g| *g.1 > 0.0) {
            for e in 0..group.len() {
                for (n, mass) in group.nodes(e).into_iter().zip(group.masses(e)) {
                    self.coefficients[n as usize] += factor * mass;
                }
            }
        }
    }

    /// One over the stable increment, given that without damping: with the fraction xi = alpha/2 omega of critical damping in
    /// the highest mode it is 2/omega (sqrt(1 + xi^2) - xi) ("Explicit dynamic analysis"). The fraction of bulk viscosity,
    /// which is in what is given, adds to it.
    pub(super) fn rate(&self, without: f64) -> f64 {
        0.5 * ((4.0 * without * without + self.half * self.half).sqrt() + self.half)
    }

    /// Adds the forces to those on nodes. Their work over the increment behind, by the trapezoid that books the forces on nodes,
    /// is dissipated and not of the outside.
    pub(super) fn add_forces(&mut self, dofs: &mut Dofs) {
        let dt = dofs.nodes.unbooked();
        // Where central differences start, the outside is booked a part of the impulse less (`book_start`).
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
        self.started = dofs.nodes.behind == 0.0;
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&*self.factors) + size_of_val(&*self.coefficients) + size_of_val(&*self.forces)
    }
}

persist_struct!(Damping { coefficients: fixed, forces: fixed, started } derived { factors, half });
