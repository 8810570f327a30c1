//! Equations that share degrees of freedom, factorised: what one of them changes, all of them know.
//! Never here: where equations come from, time.

use std::collections::HashMap;

use super::bonds::Dependent;
use super::dependence::sources;
use crate::kernel::lists::heap_bytes;
use crate::state::archive::persist_struct;
use crate::state::dofs::Dofs;

/// One unknown of the equations: a degree of freedom, or several that move alike.
#[derive(Clone, Debug, Default)]
pub(super) struct Freedom {
    /// Nodes; the first leads: where the motion is given it is the one whose motion is.
    pub members: Vec<usize>,
    /// 0 along r, 1 along z.
    pub axis: usize,
    /// One over the mass of all members; 0 where the motion is given.
    pub softness: f64,
    /// Force of the equations on it.
    pub pull: f64,
    /// What the equations change, before it is applied.
    pub change: f64,
    /// What it has before the equations.
    pub value: f64,
    /// Of a given motion: the force that its change over the increment behind took, which shows one increment late.
    pub inertia: f64,
}

impl Freedom {
    pub fn is_shared(&self) -> bool {
        self.members.len() > 1
    }

    /// Force on a member beside constraints: what its mass makes of it, or the load where it has none.
    pub fn force(&self, member: usize, dofs: &Dofs) -> f64 {
        let mass = dofs.nodes.mass[member];
        if mass > 0.0 { mass * dofs.nodes.acceleration[member][self.axis] } else { load(dofs, member, self.axis) }
    }
}

pub(super) fn load(dofs: &Dofs, node: usize, axis: usize) -> f64 {
    dofs.nodes.forces[0].get(node).map_or(0.0, |f| f[axis])
}

/// A row of a lower triangle from its first column that is not zero.
#[derive(Clone, Debug, Default)]
struct Row {
    first: usize,
    values: Vec<f64>,
}

impl Row {
    fn at(&self, column: usize) -> f64 {
        self.values[column - self.first]
    }
}

/// Equations that share degrees of freedom, factorised.
#[derive(Clone, Debug, Default)]
pub struct System {
    pub(super) freedoms: Vec<Freedom>,
    /// Terms of each equation: index of the freedom, coefficient.
    rows: Vec<Vec<(usize, f64)>>,
    /// Which equations follow from others and may be left to them.
    spare: Vec<bool>,
    /// Lower triangle of the Cholesky factor of C M^-1 C^T.
    factor: Vec<Row>,
    /// The last row that has something in a column.
    last: Vec<usize>,
    lambda: Vec<f64>,
}

impl System {
    /// A freedom that no equation concerns: what moves alike.
    pub(super) fn alone(freedom: Freedom) -> System {
        System { freedoms: vec![freedom], ..System::default() }
    }

    /// Factorises rows over freedoms; `members` are the numbers of the equations, for messages, `spare` tells which may be left
    /// out where they follow from those before.
    pub(super) fn new(
        freedoms: Vec<Freedom>,
        rows: Vec<Vec<(usize, f64)>>,
        members: &[usize],
        spare: Vec<bool>,
    ) -> Result<System, Dependent> {
        let n = rows.len();
        let mut system =
            System { freedoms, rows, spare, factor: Vec::new(), last: (0..n).collect(), lambda: vec![0.0; n] };
        for row in system.matrix() {
            system.factor.push(row);
        }
        for i in 0..n {
            if !system.eliminate(i) {
                let before: Vec<Vec<f64>> = (0..i).map(|i| system.weighted(i)).collect();
                let follows_from = sources(&before, &system.weighted(i)).into_iter().map(|i| members[i]).collect();
                return Err(Dependent { equation: members[i], follows_from });
            }
        }
        for (i, row) in system.factor.iter().enumerate() {
            system.last[row.first..=i].iter_mut().for_each(|last| *last = i);
        }
        Ok(system)
    }

    /// The lower triangle of C M^-1 C^T, each row from its first column that two equations share.
    fn matrix(&self) -> Vec<Row> {
        let mut first_of: HashMap<usize, usize> = HashMap::new();
        let mut matrix = Vec::with_capacity(self.rows.len());
        for (i, row) in self.rows.iter().enumerate() {
            let soft = row.iter().filter(|t| self.freedoms[t.0].softness > 0.0);
            let first = soft.map(|t| *first_of.entry(t.0).or_insert(i)).min().unwrap_or(i);
            matrix.push(Row { first, values: (first..=i).map(|j| self.product(i, j)).collect() });
        }
        matrix
    }

    /// An entry of C M^-1 C^T.
    fn product(&self, i: usize, j: usize) -> f64 {
        let other = |f: usize| self.rows[j].iter().filter(|t| t.0 == f).map(|t| t.1).sum::<f64>();
        self.rows[i].iter().map(|&(f, c)| c * self.freedoms[f].softness * other(f)).sum()
    }

    /// Turns a row of the matrix into one of its Cholesky factor, given those before. Returns whether the row can be kept.
    fn eliminate(&mut self, i: usize) -> bool {
        let mut row = std::mem::take(&mut self.factor[i]);
        let diagonal = row.at(i);
        for j in row.first..i {
            let known = &self.factor[j];
            let sum: f64 = (row.first.max(known.first)..j).map(|k| row.at(k) * known.at(k)).sum();
            let at = j - row.first;
            row.values[at] = (row.values[at] - sum) / known.at(j);
        }
        let sum: f64 = (row.first..i).map(|k| row.at(k) * row.at(k)).sum();
        let rest = diagonal - sum;
        // What rounding leaves of a row that depends on others.
        if rest.is_nan() || rest <= 1e-10 * diagonal {
            if !self.spare[i] {
                return false;
            }
            row = Row { first: i, values: vec![1.0] };
            self.rows[i].clear();
        } else if let Some(last) = row.values.last_mut() {
            *last = rest.sqrt();
        }
        self.factor[i] = row;
        true
    }

    /// Coefficients of a row in units of the root of the mass, over the freedoms of the system.
    fn weighted(&self, row: usize) -> Vec<f64> {
        let mut weighted = vec![0.0; self.freedoms.len()];
        for &(f, c) in &self.rows[row] {
            weighted[f] += c * self.freedoms[f].softness.sqrt();
        }
        weighted
    }

    /// What must be taken from each freedom so that `value` satisfies the equations, as an impulse: in its `change`. A shared
    /// freedom has the mean of its members by mass, to which forces on members without mass add where `forced` says so.
    pub(super) fn solve(&mut self, dofs: &Dofs, value: impl Fn(usize, usize) -> f64, forced: bool) {
        for f in &mut self.freedoms {
            f.value = value(f.members[0], f.axis);
            if f.is_shared() && f.softness > 0.0 {
                let own = |&n: &usize| match dofs.nodes.mass[n] {
                    mass if mass > 0.0 => mass * value(n, f.axis),
                    _ if forced => load(dofs, n, f.axis),
                    _ => 0.0,
                };
                f.value = f.softness * f.members.iter().map(own).sum::<f64>();
            }
        }
        self.multiply();
    }

    /// The same for freedoms that are one number a node each, without forces of their own: temperatures with capacities for
    /// masses.
    pub fn balance(&mut self, value: impl Fn(usize) -> f64) {
        self.freedoms.iter_mut().for_each(|f| f.value = value(f.members[0]));
        self.multiply();
    }

    /// What [`System::balance`] gives each node.
    pub fn changes(&self) -> impl Iterator<Item = (usize, f64)> {
        self.freedoms.iter().map(|f| (f.members[0], f.change))
    }

    /// Takes on other masses, and factorises anew in the room there is.
    pub fn weigh(&mut self, mass: impl Fn(usize) -> f64) {
        let free = self.freedoms.iter_mut().filter(|f| f.softness > 0.0);
        free.for_each(|f| f.softness = 1.0 / mass(f.members[0]));
        for i in 0..self.rows.len() {
            if self.rows[i].is_empty() {
                continue;
            }
            let mut row = std::mem::take(&mut self.factor[i]);
            let first = row.first;
            row.values.iter_mut().enumerate().for_each(|(at, value)| *value = self.product(i, first + at));
            self.factor[i] = row;
            // What was independent stays so whatever the masses are.
            self.eliminate(i);
        }
    }

    /// The multipliers of the equations for the values of freedoms, and the impulse that each takes from them.
    fn multiply(&mut self) {
        let n = self.rows.len();
        for i in 0..n {
            let residual: f64 = self.rows[i].iter().map(|&(f, c)| c * self.freedoms[f].value).sum();
            let row = &self.factor[i];
            let done: f64 = (row.first..i).map(|j| row.at(j) * self.lambda[j]).sum();
            self.lambda[i] = (residual - done) / row.at(i);
        }
        for i in (0..n).rev() {
            let below = (i + 1..=self.last[i]).filter(|&j| self.factor[j].first <= i);
            let done: f64 = below.map(|j| self.factor[j].at(i) * self.lambda[j]).sum();
            self.lambda[i] = (self.lambda[i] - done) / self.factor[i].at(i);
        }
        self.freedoms.iter_mut().for_each(|f| f.change = 0.0);
        for (row, lambda) in self.rows.iter().zip(&self.lambda) {
            for &(f, c) in row {
                self.freedoms[f].change -= c * lambda;
            }
        }
    }

    /// Gives members of shared freedoms the acceleration of all, and others what the equations change.
    pub(super) fn accelerate(&mut self, dofs: &mut Dofs) {
        for f in &mut self.freedoms {
            f.pull = f.change;
            if !f.is_shared() {
                dofs.nodes.acceleration[f.members[0]][f.axis] += f.change * f.softness;
                continue;
            }
            let new = f.value + f.change * f.softness;
            let behind = 0.5 * dofs.nodes.behind;
            for (i, &n) in f.members.iter().enumerate() {
                let (force, mass) = (f.force(n, dofs), dofs.nodes.mass[n]);
                if mass == 0.0 {
                    // The pass over nodes took no kinetic energy of this force, as it found no mass.
                    dofs.energies.kinetic += behind * *dofs.nodes[n].velocity(f.axis) * force;
                }
                if f.softness == 0.0 && (i > 0 || mass == 0.0) {
                    f.pull += force - mass * new;
                }
                dofs.nodes.acceleration[n][f.axis] = new;
            }
        }
    }

    /// Holds velocities to the equations, and takes places along over the increment `dt`. An impulse acts over the time
    /// `half`; the work on freedoms that move on their own comes from motions that are prescribed, as the sum over all is zero.
    pub(super) fn hold_velocities(&mut self, dofs: &mut Dofs, dt: f64, half: f64) {
        let nodes = &dofs.nodes;
        self.solve(dofs, |node, axis| *nodes[node].clone().velocity(axis), false);
        for f in &mut self.freedoms {
            if f.is_shared() {
                f.hold_members(dofs, dt, half);
            } else if f.softness > 0.0 {
                let change = f.change * f.softness;
                shift(dofs, f.members[0], f.axis, change, dt, half);
                f.book(dofs, half, half * f.pull + f.change);
            }
        }
    }

    /// The force of the equations on a degree of freedom.
    pub(super) fn constraint_force(&self, node: usize, axis: usize) -> Option<f64> {
        let f = self.freedoms.iter().find(|f| f.axis == axis && f.members.contains(&node))?;
        Some(if f.members[0] == node { f.pull + f.inertia } else { 0.0 })
    }

    pub fn bytes(&self) -> usize {
        let rows: usize = self.rows.iter().map(|r| size_of_val(r) + heap_bytes(r)).sum();
        let factor: usize = self.factor.iter().map(|r| size_of_val(r) + 8 * r.values.capacity()).sum();
        let members: usize = self.freedoms.iter().map(|f| heap_bytes(&f.members)).sum();
        let own = heap_bytes(&self.freedoms) + self.spare.capacity();
        rows + factor + members + own + 8 * (self.lambda.capacity() + self.last.capacity())
    }
}

impl Freedom {
    fn hold_members(&mut self, dofs: &mut Dofs, dt: f64, half: f64) {
        let new = self.value + self.change * self.softness;
        let given = self.softness == 0.0;
        let mut impulse = 0.0;
        for &n in &self.members[usize::from(given)..] {
            let change = new - *dofs.nodes[n].velocity(self.axis);
            impulse += dofs.nodes.mass[n] * change;
            shift(dofs, n, self.axis, change, dt, half);
        }
        if given {
            // What is prescribed pulls the members along, and takes the loads of those that have no mass.
            self.book(dofs, half, impulse - half * (self.pull - self.change));
            self.inertia = if half > 0.0 { -impulse / half } else { 0.0 };
        } else {
            self.book(dofs, half, half * self.pull + self.change);
        }
    }

    fn book(&self, dofs: &mut Dofs, half: f64, impulse: f64) {
        if half > 0.0 {
            let n = self.members[0];
            let new = *dofs.nodes[n].velocity(self.axis);
            let old = new - half * dofs.nodes.acceleration[n][self.axis];
            dofs.energies.external += 0.5 * (old + new) * impulse;
        }
    }
}

/// Changes the velocity of a node, and its place along with it.
pub(super) fn shift(dofs: &mut Dofs, node: usize, axis: usize, change: f64, dt: f64, half: f64) {
    let n = &mut dofs.nodes[node];
    *n.velocity(axis) += change;
    *n.coordinate(axis) += dt * change;
    if half > 0.0 {
        dofs.nodes.acceleration[node][axis] += change / half;
    }
}

persist_struct!(Freedom { pull, inertia } derived { members, axis, softness, change, value });

// The factor follows from masses at the start of the step; the multipliers are solved for anew.
persist_struct!(System { freedoms: fixed } derived { rows, spare, factor, last, lambda });
