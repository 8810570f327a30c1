//! Totals of element deletion: mass and energy of deleted elements, and of the free nodes that remain as point masses.

use serde::Serialize;

use super::group::ElementGroup;
use super::values::internal_energy;
use crate::state::archive::Persist;
use crate::state::nodes::Nodes;
use crate::variables::Variable;

/// Mass and energies of the deleted elements and free nodes at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct DeletionTotals {
    /// Mass of deleted elements, without mass scaling.
    #[serde(rename = "EROMASS")]
    pub mass: f64,
    /// Internal energy of deleted elements; part of ALLIE.
    #[serde(rename = "EROIE")]
    pub internal: f64,
    /// Mass of free nodes, whose elements are all deleted.
    #[serde(rename = "EROPMASS")]
    pub points: f64,
    /// Kinetic energy of free nodes; part of ALLKE.
    #[serde(rename = "EROPKE")]
    pub kinetic: f64,
    /// Momentum of free nodes along z.
    #[serde(rename = "EROPMOM")]
    pub momentum: f64,
}

/// Deletion so far.
#[derive(Clone, Debug, Persist)]
#[persist(fixed: around; fixed_lists: counted)]
pub struct DeletionRecord {
    /// For each group, whether each element has been counted; empty if elements of the group cannot be deleted.
    counted: Vec<Vec<bool>>,
    /// Number of active elements at each node.
    around: Vec<u32>,
    /// Free nodes, whose elements are all deleted.
    points: Vec<u32>,
    mass: f64,
    internal: f64,
    /// Number of deleted elements at the last count.
    seen: usize,
}

impl DeletionRecord {
    pub(super) fn new(groups: &[Box<dyn ElementGroup>], nodes: usize) -> DeletionRecord {
        let mut around = vec![0; nodes];
        for group in groups {
            (0..group.len()).flat_map(|e| group.boundary(e)).for_each(|n| around[n as usize] += 1);
        }
        let fragile = |group: &dyn ElementGroup| if group.properties().deletable { group.len() } else { 0 };
        let mut removed = DeletionRecord {
            counted: groups.iter().map(|g| vec![false; fragile(&**g)]).collect(),
            around,
            points: Vec::new(),
            mass: 0.0,
            internal: 0.0,
            seen: 0,
        };
        removed.make_room();
        removed
    }

    /// Reserves memory for all nodes, so that nothing allocates inside an increment.
    pub(super) fn make_room(&mut self) {
        self.points.reserve_exact(self.around.len() - self.points.len());
    }

    /// Adds the work on a deleted element while its forces are removed.
    pub(super) fn add(&mut self, work: f64) {
        self.internal += work;
    }

    /// Takes the deletions of a model in which a group had another mesh; `node` returns the node that one of that model has
    /// become. `seen` elements are deleted in this model.
    pub(super) fn follow_new_mesh(
        &mut self,
        previous: &DeletionRecord,
        (group, seen): (usize, usize),
        node: impl Fn(u32) -> Option<u32>,
    ) {
        for (g, (own, before)) in self.counted.iter_mut().zip(&previous.counted).enumerate() {
            if g != group {
                own.clone_from(before);
            }
        }
        for (n, around) in previous.around.iter().enumerate() {
            node(n as u32).into_iter().for_each(|own| self.around[own as usize] = *around);
        }
        self.points.clear();
        self.points.extend(previous.points.iter().filter_map(|n| node(*n)));
        (self.mass, self.internal, self.seen) = (previous.mass, previous.internal, seen);
    }

    /// Adds the elements deleted since the last call; `factor` returns the factor of mass scaling on an element.
    pub(super) fn count(
        &mut self,
        groups: &[Box<dyn ElementGroup>],
        factor: impl Fn(usize, usize) -> f64,
        deleted: usize,
    ) {
        if std::mem::replace(&mut self.seen, deleted) == deleted {
            return;
        }
        for (g, (group, counted)) in groups.iter().zip(&mut self.counted).enumerate() {
            for (element, counted) in counted.iter_mut().enumerate() {
                if *counted || !group.is_deleted(element) {
                    continue;
                }
                *counted = true;
                let value = |variable: Variable| group.value(element, variable.into()).unwrap_or(0.0);
                self.mass += value(Variable::Mass) / factor(g, element);
                self.internal += internal_energy(&**group, element);
                for n in group.boundary(element) {
                    self.around[n as usize] -= 1;
                    if self.around[n as usize] == 0 {
                        self.points.push(n);
                    }
                }
            }
        }
    }

    /// Returns the current totals, with velocities at the current instant as in the total energies.
    pub fn totals(&self, nodes: &Nodes) -> DeletionTotals {
        let mut totals = DeletionTotals { mass: self.mass, internal: self.internal, ..DeletionTotals::default() };
        for &n in &self.points {
            let (node, [a_r, a_z]) = (nodes[n as usize], nodes.acceleration[n as usize]);
            let (mass, dt) = (nodes.mass[n as usize], nodes.previous_dt);
            let twice = node.v_r * (node.v_r + dt * a_r) + node.v_z * (node.v_z + dt * a_z);
            totals.points += mass;
            totals.kinetic += 0.5 * mass * twice;
            totals.momentum += mass * (node.v_z + 0.5 * dt * a_z);
        }
        totals
    }

    pub fn bytes(&self) -> usize {
        let counted: usize = self.counted.iter().map(|c| size_of_val(c) + c.capacity()).sum();
        size_of_val(self) + counted + size_of::<u32>() * (self.around.capacity() + self.points.capacity())
    }
}
