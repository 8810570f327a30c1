//! Linear equations between degrees of freedom of nodes, sum of c u = 0, kept exactly.
//! Never here: deck words, rigid bodies.
//!
//! Equations that share degrees of freedom are solved together: with C the coefficients and M the masses, of which those
//! of given motions count as infinite, the multipliers follow from (C M^-1 C^T) lambda = C a, and a -= M^-1 C^T lambda
//! (Lagrange multipliers; Belytschko, Liu and Moran, Nonlinear Finite Elements, 6.2). Velocities are then held to the same
//! equations, which takes in motions that are given and change within the increment.

use std::collections::HashSet;

use super::Constraint;
use super::dependence::sources;
use crate::state::EffectId;
use crate::state::archive::{Archive, Persist};
use crate::state::dofs::{Dof, Dofs};
use crate::state::magnitude::Clock;

/// One equation: node, axis (0 along r, 1 along z) and coefficient of each term.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Equation {
    /// Terms.
    pub terms: Vec<(usize, usize, f64)>,
}

#[derive(Clone, Copy, Debug)]
struct Freedom {
    node: usize,
    axis: usize,
    /// One over the mass; 0 where the motion is given.
    softness: f64,
    /// Force of the equations on it.
    pull: f64,
    /// What the equations change, before it is applied.
    change: f64,
}

/// Equations that share degrees of freedom, factorised.
#[derive(Clone, Debug)]
pub struct System {
    freedoms: Vec<Freedom>,
    /// Terms of each equation: index of the freedom, coefficient.
    rows: Vec<Vec<(usize, f64)>>,
    /// Lower triangle of the Cholesky factor, row by row, full rows.
    factor: Vec<f64>,
    lambda: Vec<f64>,
}

/// An equation that cannot be kept beside others.
#[derive(Clone, Debug, PartialEq)]
pub struct Dependent {
    /// Its index.
    pub equation: usize,
    /// Those that it follows from; none where nothing could move to keep it.
    pub follows_from: Vec<usize>,
}

impl System {
    /// All systems of some equations.
    ///
    /// # Errors
    /// An equation that follows from others, or has nothing that could move to keep it.
    pub fn all(
        equations: &[Equation],
        mass: &[f64],
        given: &HashSet<(usize, usize)>,
    ) -> Result<Vec<System>, Dependent> {
        let mut taken = vec![false; equations.len()];
        let mut systems = Vec::new();
        for first in 0..equations.len() {
            if std::mem::replace(&mut taken[first], true) {
                continue;
            }
            let mut members = vec![first];
            let mut at = 0;
            while at < members.len() {
                let own = &equations[members[at]];
                let shares = |e: &Equation| e.terms.iter().any(|t| own.terms.iter().any(|o| (o.0, o.1) == (t.0, t.1)));
                for (other, equation) in equations.iter().enumerate() {
                    if !taken[other] && shares(equation) {
                        taken[other] = true;
                        members.push(other);
                    }
                }
                at += 1;
            }
            systems.push(System::new(equations, &members, mass, given)?);
        }
        Ok(systems)
    }

    fn new(
        all: &[Equation],
        members: &[usize],
        mass: &[f64],
        given: &HashSet<(usize, usize)>,
    ) -> Result<System, Dependent> {
        let n = members.len();
        let mut system =
            System { freedoms: Vec::new(), rows: Vec::new(), factor: vec![0.0; n * n], lambda: vec![0.0; n] };
        for &member in members {
            let row = all[member].terms.iter().map(|&(node, axis, c)| (system.freedom(node, axis, mass, given), c));
            let row = row.collect();
            system.rows.push(row);
        }
        for i in 0..n {
            for j in 0..=i {
                system.factor[i * n + j] = system.product(i, j);
            }
        }
        match factorise(&mut system.factor, n) {
            Ok(()) => Ok(system),
            Err(row) => {
                let before: Vec<Vec<f64>> = (0..row).map(|i| system.weighted(i)).collect();
                let follows_from = sources(&before, &system.weighted(row)).into_iter().map(|i| members[i]).collect();
                Err(Dependent { equation: members[row], follows_from })
            }
        }
    }

    /// Coefficients of a row in units of the root of the mass, over the freedoms of the system.
    fn weighted(&self, row: usize) -> Vec<f64> {
        let mut weighted = vec![0.0; self.freedoms.len()];
        for &(f, c) in &self.rows[row] {
            weighted[f] += c * self.freedoms[f].softness.sqrt();
        }
        weighted
    }

    fn freedom(&mut self, node: usize, axis: usize, mass: &[f64], given: &HashSet<(usize, usize)>) -> usize {
        if let Some(known) = self.freedoms.iter().position(|f| (f.node, f.axis) == (node, axis)) {
            return known;
        }
        let is_given = given.contains(&(node, axis));
        let softness = if is_given { 0.0 } else { 1.0 / mass[node] };
        self.freedoms.push(Freedom { node, axis, softness, pull: 0.0, change: 0.0 });
        self.freedoms.len() - 1
    }

    fn bytes(&self) -> usize {
        let rows: usize = self.rows.iter().map(|r| size_of_val(r) + size_of::<(usize, f64)>() * r.capacity()).sum();
        rows + size_of::<Freedom>() * self.freedoms.capacity() + 8 * (self.factor.capacity() + self.lambda.capacity())
    }

    /// An entry of C M^-1 C^T.
    fn product(&self, i: usize, j: usize) -> f64 {
        let other = |f: usize| self.rows[j].iter().filter(|t| t.0 == f).map(|t| t.1).sum::<f64>();
        self.rows[i].iter().map(|&(f, c)| c * self.freedoms[f].softness * other(f)).sum()
    }

    /// What must be taken from each freedom so that `value` satisfies the equations, as an impulse a mass.
    fn solve(&mut self, value: impl Fn(usize, usize) -> f64) {
        let n = self.rows.len();
        for i in 0..n {
            let residual: f64 =
                self.rows[i].iter().map(|&(f, c)| c * value(self.freedoms[f].node, self.freedoms[f].axis)).sum();
            let done: f64 = (0..i).map(|j| self.factor[i * n + j] * self.lambda[j]).sum();
            self.lambda[i] = (residual - done) / self.factor[i * n + i];
        }
        for i in (0..n).rev() {
            let done: f64 = (i + 1..n).map(|j| self.factor[j * n + i] * self.lambda[j]).sum();
            self.lambda[i] = (self.lambda[i] - done) / self.factor[i * n + i];
        }
        self.freedoms.iter_mut().for_each(|f| f.change = 0.0);
        for (row, lambda) in self.rows.iter().zip(&self.lambda) {
            for &(f, c) in row {
                self.freedoms[f].change -= c * lambda;
            }
        }
    }
}

/// Cholesky's factor in place of the lower triangle of a matrix of `n` rows.
fn factorise(matrix: &mut [f64], n: usize) -> Result<(), usize> {
    for i in 0..n {
        let diagonal = matrix[i * n + i];
        for j in 0..=i {
            let sum: f64 = (0..j).map(|k| matrix[i * n + k] * matrix[j * n + k]).sum();
            let rest = matrix[i * n + j] - sum;
            if i == j {
                // What rounding leaves of a row that depends on others.
                if rest.is_nan() || rest <= 1e-10 * diagonal {
                    return Err(i);
                }
                matrix[i * n + i] = rest.sqrt();
            } else {
                matrix[i * n + j] = rest / matrix[j * n + j];
            }
        }
    }
    Ok(())
}

/// The equations of a step.
#[derive(Clone, Debug)]
pub struct Equations {
    id: EffectId,
    systems: Vec<System>,
}

impl Equations {
    /// Equations in independent systems.
    pub fn new(id: EffectId, systems: Vec<System>) -> Self {
        Equations { id, systems }
    }

    /// Holds velocities to the equations, and takes places along over the increment `dt`. An impulse acts over the time
    /// `half`; the work on freedoms that move on their own comes from motions that are prescribed, as the sum over all is zero.
    fn hold_velocities(&mut self, dofs: &mut Dofs, dt: f64, half: f64) {
        let (nodes, energies) = (&mut dofs.nodes, &mut dofs.energies);
        for system in &mut self.systems {
            system.solve(|node, axis| *nodes[node].clone().velocity(axis));
            for f in &mut system.freedoms {
                if f.softness == 0.0 {
                    continue;
                }
                let change = f.change * f.softness;
                let node = &mut nodes[f.node];
                *node.velocity(f.axis) += change;
                *node.coordinate(f.axis) += dt * change;
                if half > 0.0 {
                    let new = *node.velocity(f.axis);
                    let acceleration = &mut nodes.acceleration[f.node][f.axis];
                    *acceleration += change / half;
                    let old = new - half * *acceleration;
                    energies.external += 0.5 * (old + new) * (half * f.pull + f.change);
                }
            }
        }
    }
}

impl Constraint for Equations {
    fn id(&self) -> EffectId {
        self.id
    }

    fn begin(&mut self, dofs: &mut Dofs) {
        if dofs.nodes.behind == 0.0 {
            self.hold_velocities(dofs, 0.0, 0.0);
        }
    }

    /// The kinetic energy needs no correction: on velocities that satisfy the equations their forces do no work.
    fn accelerations(&mut self, dofs: &mut Dofs, _clock: &Clock<'_>) {
        let acceleration = &mut dofs.nodes.acceleration;
        for system in &mut self.systems {
            system.solve(|node, axis| acceleration[node][axis]);
            for f in &mut system.freedoms {
                acceleration[f.node][f.axis] += f.change * f.softness;
                f.pull = f.change;
            }
        }
    }

    fn motion(&mut self, dofs: &mut Dofs, _clock: &Clock<'_>, dt: f64) {
        let half = dofs.nodes.half;
        self.hold_velocities(dofs, dt, half);
    }

    fn pull(&self, dof: Dof) -> f64 {
        let own = |f: &&Freedom| Dof::Node(f.node, f.axis) == dof;
        self.systems.iter().flat_map(|s| &s.freedoms).find(own).map_or(0.0, |f| f.pull)
    }

    fn moves_nodes(&self) -> bool {
        true
    }

    fn bytes(&self) -> usize {
        size_of::<System>() * self.systems.capacity() + self.systems.iter().map(System::bytes).sum::<usize>()
    }

    fn copy(&self) -> Box<dyn Constraint> {
        Box::new(self.clone())
    }
}

impl Persist for Freedom {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Freedom { node: _, axis: _, softness: _, pull, change: _ } = self;
        pull.persist(archive);
    }
}

impl Persist for Equations {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Equations { id: _, systems } = self;
        systems.as_mut_slice().persist(archive);
    }
}

impl Persist for System {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        // The factor follows from masses at the start of the step; the multipliers are solved for anew.
        let System { freedoms, rows: _, factor: _, lambda: _ } = self;
        freedoms.as_mut_slice().persist(archive);
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::{Dependent, Equation, System};

    #[test]
    fn equations_that_repeat_are_found() {
        let equation = |a: f64, b: f64| Equation { terms: vec![(0, 1, a), (1, 1, b)] };
        let mass = [1.0, 2.0];
        assert_eq!(System::all(&[equation(1.0, -1.0)], &mass, &HashSet::new()).map(|s| s.len()), Ok(1));
        assert_eq!(
            System::all(&[equation(1.0, -1.0), equation(2.0, -2.0)], &mass, &HashSet::new()).map(|s| s.len()),
            Err(Dependent { equation: 1, follows_from: vec![0] })
        );
    }

    #[test]
    fn a_chain_is_solved_together() {
        let equal = |a: usize, b: usize| Equation { terms: vec![(a, 1, 1.0), (b, 1, -1.0)] };
        let mut systems =
            System::all(&[equal(0, 1), equal(1, 2)], &[1.0, 2.0, 3.0], &HashSet::new()).expect("one system");
        assert_eq!(systems.len(), 1);
        let values = [6.0, 0.0, 0.0];
        systems[0].solve(|n, _| values[n]);
        // All move with the mean by mass, 1.
        for f in &systems[0].freedoms {
            assert!((values[f.node] + f.change * f.softness - 1.0).abs() < 1e-14);
        }
    }
}
