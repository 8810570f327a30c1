//! Systems of equations that share degrees of freedom: factorisation and solution.

use std::collections::HashMap;

use super::bonds::DependentEquation;
use crate::kernel::lists::Memory;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::nodes::Nodes;

/// Unknown of the equations: a degree of freedom, or several with equal motion.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(derived: members, axis, inverse_mass, change, value)]
pub(super) struct EquationUnknown {
    /// Nodes with equal motion. The motion is computed at the first node and copied to the others; a node with a
    /// prescribed motion is always the first.
    pub members: Vec<usize>,
    /// 0 along r, 1 along z.
    pub axis: usize,
    /// One over the mass of all members; 0 if the motion is prescribed.
    pub inverse_mass: f64,
    /// Force that satisfies the equations, on all members together.
    pub constraint_force: f64,
    /// Part of `constraint_force` that is not from the equations: loads of members of a prescribed group, less their inertia.
    pub member_force: f64,
    /// Impulse of the equations, before it is applied.
    pub change: f64,
    /// Value before the equations are applied.
    pub value: f64,
    /// For a prescribed motion, the inertial force of the other members from the change of velocity over the previous
    /// increment. It acts on the reaction one increment late.
    pub inertia: f64,
}

impl EquationUnknown {
    pub fn is_shared(&self) -> bool {
        self.members.len() > 1
    }

    /// Returns the force on a member: mass times acceleration, or the load on a node without mass.
    pub fn force(&self, member: usize, dofs: &Dofs) -> f64 {
        let mass = dofs.nodes.mass[member];
        if mass > 0.0 { mass * dofs.nodes.acceleration[member][self.axis] } else { load(dofs, member, self.axis) }
    }
}

pub(super) fn load(dofs: &Dofs, node: usize, axis: usize) -> f64 {
    dofs.nodes.forces[0].get(node).map_or(0.0, |f| f[axis])
}

/// Row of a lower triangular matrix, from its first nonzero column.
#[derive(Clone, Debug, Default, Memory)]
struct FactorRow {
    first: usize,
    values: Vec<f64>,
}

impl FactorRow {
    fn at(&self, column: usize) -> f64 {
        self.values[column - self.first]
    }
}

/// Factorised equations that share degrees of freedom.
#[derive(Clone, Debug, Default, Persist, Memory)]
// The factor follows from the masses; multipliers are solved for in each increment.
#[persist(fixed: unknowns; derived: rows, spare, factor, last, lambda)]
pub struct EquationSystem {
    pub(super) unknowns: Vec<EquationUnknown>,
    /// Terms of each equation: index of the unknown, coefficient.
    rows: Vec<Vec<(usize, f64)>>,
    /// Whether an equation is dropped, instead of an error, if it depends linearly on others.
    spare: Vec<bool>,
    /// Lower triangle of the Cholesky factor of C M^-1 C^T.
    factor: Vec<FactorRow>,
    /// Last row with an entry in each column.
    last: Vec<usize>,
    lambda: Vec<f64>,
}

impl EquationSystem {
    /// Creates a system of one unknown without equations, for nodes with equal motion.
    pub(super) fn without_equations(unknown: EquationUnknown) -> EquationSystem {
        EquationSystem { unknowns: vec![unknown], ..EquationSystem::default() }
    }

    /// Factorises the equations. `members` are the indices of the equations for messages; `spare` marks those that are
    /// dropped if they depend on previous ones.
    pub(super) fn new(
        unknowns: Vec<EquationUnknown>,
        rows: Vec<Vec<(usize, f64)>>,
        members: &[usize],
        spare: Vec<bool>,
    ) -> Result<EquationSystem, DependentEquation> {
        let n = rows.len();
        let mut system =
            EquationSystem { unknowns, rows, spare, factor: Vec::new(), last: (0..n).collect(), lambda: vec![0.0; n] };
        for row in system.matrix() {
            system.factor.push(row);
        }
        for i in 0..n {
            if !system.eliminate(i) {
                let follows_from = system.sources(i).into_iter().map(|i| members[i]).collect();
                return Err(DependentEquation { equation: members[i], follows_from });
            }
        }
        for (i, row) in system.factor.iter().enumerate() {
            system.last[row.first..=i].iter_mut().for_each(|last| *last = i);
        }
        Ok(system)
    }

    /// Returns the lower triangle of C M^-1 C^T; each row starts at its first nonzero column.
    fn matrix(&self) -> Vec<FactorRow> {
        let mut first_of: HashMap<usize, usize> = HashMap::new();
        let mut matrix = Vec::with_capacity(self.rows.len());
        for (i, row) in self.rows.iter().enumerate() {
            let soft = row.iter().filter(|t| self.unknowns[t.0].inverse_mass > 0.0);
            let first = soft.map(|t| *first_of.entry(t.0).or_insert(i)).min().unwrap_or(i);
            matrix.push(FactorRow { first, values: (first..=i).map(|j| self.product(i, j)).collect() });
        }
        matrix
    }

    /// Returns one entry of C M^-1 C^T.
    fn product(&self, i: usize, j: usize) -> f64 {
        let other = |f: usize| self.rows[j].iter().filter(|t| t.0 == f).map(|t| t.1).sum::<f64>();
        self.rows[i].iter().map(|&(f, c)| c * self.unknowns[f].inverse_mass * other(f)).sum()
    }

    /// Replaces a row of the matrix with the row of its Cholesky factor; previous rows are complete. Returns `false` if
    /// the row depends on previous rows.
    fn eliminate(&mut self, i: usize) -> bool {
        let mut row = std::mem::take(&mut self.factor[i]);
        let diagonal = row.at(i);
        for j in row.first..i {
            let known = &self.factor[j];
            let sum: f64 = (row.first.max(known.first)..j).map(|k| row.at(k) * known.at(k)).sum();
            let entry = j - row.first;
            row.values[entry] = (row.values[entry] - sum) / known.at(j);
        }
        let sum: f64 = (row.first..i).map(|k| row.at(k) * row.at(k)).sum();
        let remainder = diagonal - sum;
        // The remainder of a dependent row is rounding error.
        if remainder.is_nan() || remainder <= 1e-10 * diagonal {
            if !self.spare[i] {
                self.factor[i] = row;
                return false;
            }
            row = FactorRow { first: i, values: vec![1.0] };
            self.rows[i].clear();
        } else if let Some(last) = row.values.last_mut() {
            *last = remainder.sqrt();
        }
        self.factor[i] = row;
        true
    }

    /// Returns the previous rows whose linear combination is a row that [`EquationSystem::eliminate`] found dependent.
    /// With the factor L of the previous rows and the eliminated row l, the coefficients x solve L^T x = l.
    fn sources(&self, row: usize) -> Vec<usize> {
        let (first, values) = (self.factor[row].first, &self.factor[row].values);
        let mut parts = vec![0.0; row];
        parts[first..].copy_from_slice(&values[..row - first]);
        for j in (0..row).rev() {
            let known = &self.factor[j];
            parts[j] /= known.at(j);
            for k in known.first..j {
                parts[k] -= known.at(k) * parts[j];
            }
        }
        let largest = parts.iter().fold(0.0, |largest: f64, part| largest.max(part.abs()));
        (0..row).filter(|&i| parts[i].abs() > 1e-8 * largest).collect()
    }

    /// Computes the impulse on each unknown that makes `value` satisfy the equations, and stores it in `change`. The
    /// value of a shared unknown is the mass-weighted mean of its members; `forced` adds the forces on members without
    /// mass. Equation (11.2).
    pub(super) fn solve(&mut self, dofs: &Dofs, value: impl Fn(usize, usize) -> f64, forced: bool) {
        for f in &mut self.unknowns {
            f.value = value(f.members[0], f.axis);
            if f.is_shared() && f.inverse_mass > 0.0 {
                let force_of = |&n: &usize| match dofs.nodes.mass[n] {
                    mass if mass > 0.0 => mass * value(n, f.axis),
                    _ if forced => load(dofs, n, f.axis),
                    _ => 0.0,
                };
                f.value = f.inverse_mass * f.members.iter().map(force_of).sum::<f64>();
            }
        }
        self.multiply();
    }

    /// Computes the changes that satisfy the equations for scalar unknowns without loads, such as nodal temperatures
    /// with heat capacities as masses.
    pub fn balance(&mut self, value: impl Fn(usize) -> f64) {
        self.unknowns.iter_mut().for_each(|f| f.value = value(f.members[0]));
        self.multiply();
    }

    /// Returns node and change of each unknown after [`EquationSystem::balance`].
    pub fn changes(&self) -> impl Iterator<Item = (usize, f64)> {
        self.unknowns.iter().map(|f| (f.members[0], f.change))
    }

    /// Updates the masses and factorises again without allocation, if a mass has changed.
    pub fn update_masses(&mut self, mass: impl Fn(usize) -> f64) {
        let mut has_changed = false;
        for f in self.unknowns.iter_mut().filter(|f| f.inverse_mass > 0.0) {
            let inverse = 1.0 / f.members.iter().map(|&n| mass(n)).sum::<f64>();
            has_changed |= inverse != f.inverse_mass;
            f.inverse_mass = inverse;
        }
        if !has_changed {
            return;
        }
        for i in 0..self.rows.len() {
            if self.rows[i].is_empty() {
                continue;
            }
            let mut row = std::mem::take(&mut self.factor[i]);
            let first = row.first;
            row.values.iter_mut().enumerate().for_each(|(at, value)| *value = self.product(i, first + at));
            self.factor[i] = row;
            // Independent rows stay independent for any masses.
            self.eliminate(i);
        }
    }

    /// Solves for the multipliers of the equations and for the impulse on each unknown. Equation (11.1).
    fn multiply(&mut self) {
        let n = self.rows.len();
        for i in 0..n {
            let residual: f64 = self.rows[i].iter().map(|&(f, c)| c * self.unknowns[f].value).sum();
            let row = &self.factor[i];
            let known_part: f64 = (row.first..i).map(|j| row.at(j) * self.lambda[j]).sum();
            self.lambda[i] = (residual - known_part) / row.at(i);
        }
        for i in (0..n).rev() {
            let below = (i + 1..=self.last[i]).filter(|&j| self.factor[j].first <= i);
            let known_part: f64 = below.map(|j| self.factor[j].at(i) * self.lambda[j]).sum();
            self.lambda[i] = (self.lambda[i] - known_part) / self.factor[i].at(i);
        }
        self.unknowns.iter_mut().for_each(|f| f.change = 0.0);
        for (row, lambda) in self.rows.iter().zip(&self.lambda) {
            for &(f, c) in row {
                self.unknowns[f].change -= c * lambda;
            }
        }
    }

    /// Adds the changes to accelerations; members of shared unknowns get the common acceleration.
    pub(super) fn accelerate(&mut self, dofs: &mut Dofs) {
        for f in &mut self.unknowns {
            (f.constraint_force, f.member_force) = (f.change, 0.0);
            if !f.is_shared() {
                dofs.nodes.acceleration[f.members[0]][f.axis] += f.change * f.inverse_mass;
                continue;
            }
            let new = f.value + f.change * f.inverse_mass;
            let half_previous = 0.5 * dofs.nodes.previous_dt;
            for (i, &n) in f.members.iter().enumerate() {
                let (force, mass) = (f.force(n, dofs), dofs.nodes.mass[n]);
                if mass == 0.0 {
                    // The pass over nodes added no kinetic energy of this force, because the node has no mass.
                    dofs.energies.kinetic += half_previous * *dofs.nodes[n].velocity(f.axis) * force;
                }
                if f.inverse_mass == 0.0 && (i > 0 || mass == 0.0) {
                    f.constraint_force += force - mass * new;
                    f.member_force += force - mass * new;
                }
                dofs.nodes.acceleration[n][f.axis] = new;
            }
        }
    }

    /// Corrects velocities by the equations, and positions with them over the increment `dt`. An impulse acts over the
    /// time `half`. The work on free unknowns is that of prescribed motions, because the constraint forces together do
    /// no work.
    pub(super) fn hold_velocities(&mut self, dofs: &mut Dofs, dt: f64, half: f64) {
        let nodes = &dofs.nodes;
        self.solve(dofs, |node, axis| *nodes[node].clone().velocity(axis), false);
        for f in &mut self.unknowns {
            if f.is_shared() {
                f.hold_members(dofs, dt, half);
            } else if f.inverse_mass > 0.0 {
                let change = f.change * f.inverse_mass;
                change_velocity(&mut dofs.nodes, (f.members[0], f.axis), change, dt, half);
                f.add_work(dofs, half, half * f.constraint_force + f.change);
            }
        }
    }

    /// Returns the force of the equations on a node of an unknown.
    pub(super) fn constraint_force(&self, unknown: usize, node: usize) -> f64 {
        let f = &self.unknowns[unknown];
        if f.members[0] == node { f.constraint_force + f.inertia } else { 0.0 }
    }

    /// Returns the impulse on a node of an unknown by which the equations corrected velocities in the previous increment.
    pub(super) fn velocity_impulse(&self, unknown: usize, node: usize) -> f64 {
        let f = &self.unknowns[unknown];
        if f.members[0] == node { f.change } else { 0.0 }
    }

    /// Iterates over node and axis of each member of the unknowns, with the index of the unknown.
    pub(super) fn members(&self) -> impl Iterator<Item = ((usize, usize), u32)> {
        let of_unknown = |(index, f): (u32, &EquationUnknown)| {
            let axis = f.axis;
            f.members.clone().into_iter().map(move |node| ((node, axis), index))
        };
        (0..).zip(&self.unknowns).flat_map(of_unknown)
    }
}

impl EquationUnknown {
    fn hold_members(&mut self, dofs: &mut Dofs, dt: f64, half: f64) {
        let new = self.value + self.change * self.inverse_mass;
        let is_prescribed = self.inverse_mass == 0.0;
        let mut impulse = 0.0;
        for &n in &self.members[usize::from(is_prescribed)..] {
            let change = new - *dofs.nodes[n].velocity(self.axis);
            impulse += dofs.nodes.mass[n] * change;
            change_velocity(&mut dofs.nodes, (n, self.axis), change, dt, half);
        }
        if is_prescribed {
            // The prescribed motion accelerates the members and takes the loads of members without mass. The work of the
            // equations is that on free unknowns.
            self.add_work(dofs, half, impulse - half * self.member_force);
            self.inertia = if half > 0.0 { -impulse / half } else { 0.0 };
        } else {
            self.add_work(dofs, half, half * self.constraint_force + self.change);
        }
    }

    fn add_work(&self, dofs: &mut Dofs, half: f64, impulse: f64) {
        if half > 0.0 {
            let n = self.members[0];
            let new = *dofs.nodes[n].velocity(self.axis);
            let old = new - half * dofs.nodes.acceleration[n][self.axis];
            dofs.energies.external += 0.5 * (old + new) * impulse;
        }
    }
}

/// Changes the velocity of a degree of freedom (node, axis), its position over the increment `dt`, and its acceleration over
/// the time `half`, accordingly.
#[inline]
pub(super) fn change_velocity(nodes: &mut Nodes, (n, axis): (usize, usize), change: f64, dt: f64, half: f64) {
    let node = &mut nodes[n];
    *node.velocity(axis) += change;
    *node.coordinate(axis) += dt * change;
    if half > 0.0 {
        nodes.acceleration[n][axis] += change / half;
    }
}
