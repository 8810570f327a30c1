//! Books of what deletion took away: deleted elements, and the nodes that no element has any more, which fly on as points.
//! Never here: what is deleted when, what points hit.

use serde::Serialize;

use super::elements::Elements;
use super::group::ElementGroup;
use crate::state::archive::persist_struct;
use crate::state::nodes::Nodes;
use crate::variables::Variable;

/// What the books say at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Books {
    /// Mass of the elements that were deleted.
    #[serde(rename = "EROMASS")]
    pub mass: f64,
    /// Energy that they had taken up: part of ALLIE.
    #[serde(rename = "EROIE")]
    pub internal: f64,
    /// Mass of nodes that no element has any more.
    #[serde(rename = "EROPMASS")]
    pub points: f64,
    /// Their kinetic energy: part of ALLKE.
    #[serde(rename = "EROPKE")]
    pub kinetic: f64,
    /// Their momentum along z.
    #[serde(rename = "EROPMOM")]
    pub momentum: f64,
}

/// What was deleted so far.
#[derive(Clone, Debug)]
pub struct Removed {
    /// Of each group, the elements that are counted; empty where none can be deleted.
    counted: Vec<Vec<bool>>,
    /// How many corners of elements lie at each node.
    around: Vec<u32>,
    /// Nodes that no element has any more.
    points: Vec<u32>,
    mass: f64,
    internal: f64,
    /// Deletions when elements were counted last.
    seen: usize,
}

impl Removed {
    fn new(groups: &[Box<dyn ElementGroup>], nodes: usize) -> Removed {
        let mut around = vec![0; nodes];
        for group in groups {
            (0..group.len()).flat_map(|e| group.boundary(e)).for_each(|n| around[n as usize] += 1);
        }
        let fragile = |group: &dyn ElementGroup| if group.properties().deletable { group.len() } else { 0 };
        let mut removed = Removed {
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

    /// Room for all points: nothing allocates inside an increment.
    pub(super) fn make_room(&mut self) {
        self.points.reserve_exact(self.around.len() - self.points.len());
    }

    /// Adds what a deleted element takes up while its forces end.
    pub(super) fn add(&mut self, work: f64) {
        self.internal += work;
    }

    /// Counts what was deleted since it was called last.
    fn count(&mut self, groups: &[Box<dyn ElementGroup>], gone: usize) {
        if std::mem::replace(&mut self.seen, gone) == gone {
            return;
        }
        for (group, counted) in groups.iter().zip(&mut self.counted) {
            for (element, counted) in counted.iter_mut().enumerate() {
                if *counted || !group.is_deleted(element) {
                    continue;
                }
                *counted = true;
                let value = |variable: Variable| group.value(element, variable.into()).unwrap_or(0.0);
                self.mass += value(Variable::Mass);
                self.internal += value(Variable::ElementStrainEnergy) + value(Variable::ElementPlasticEnergy);
                for n in group.boundary(element) {
                    self.around[n as usize] -= 1;
                    if self.around[n as usize] == 0 {
                        self.points.push(n);
                    }
                }
            }
        }
    }

    /// The books now. Velocities are those at the instant's own time, as in the energies of all.
    pub fn books(&self, nodes: &Nodes) -> Books {
        let mut books = Books { mass: self.mass, internal: self.internal, ..Books::default() };
        for &n in &self.points {
            let (node, [a_r, a_z]) = (nodes[n as usize], nodes.acceleration[n as usize]);
            let (mass, behind) = (nodes.mass[n as usize], nodes.behind);
            let twice = node.v_r * (node.v_r + behind * a_r) + node.v_z * (node.v_z + behind * a_z);
            books.points += mass;
            books.kinetic += 0.5 * mass * twice;
            books.momentum += mass * (node.v_z + 0.5 * behind * a_z);
        }
        books
    }

    pub fn bytes(&self) -> usize {
        let counted: usize = self.counted.iter().map(|c| size_of_val(c) + c.capacity()).sum();
        size_of_val(self) + counted + size_of::<u32>() * (self.around.capacity() + self.points.capacity())
    }
}

impl Elements {
    /// Keeps books of deletions from now on, of so many nodes; strains and energies of elements are followed for them.
    pub fn count_deletions(&mut self, nodes: usize) {
        self.removed = Some(Box::new(Removed::new(&self.groups, nodes)));
        let deletable = self.groups.iter_mut().filter(|g| g.properties().deletable);
        deletable.for_each(|g| g.extensions().settings().follow());
    }

    /// Counts what the pass behind deleted.
    pub(super) fn count_removed(&mut self) {
        if let Some(removed) = &mut self.removed {
            removed.count(&self.groups, self.deleted.0.len());
        }
    }
}

persist_struct!(Removed { counted: fixed_lists, around: fixed, points, mass, internal, seen });
