//! Field variables that are prescribed at nodes over time (`*FIELD`), as elements are given them.
//! Never here: what depends on them.

use std::sync::Arc;

use super::group::ElementGroup;
use crate::kernel::topology::ElementNodes;
use crate::state::EffectId;
use crate::state::magnitude::{Clock, Magnitude};

/// A field variable at some nodes in a step.
#[derive(Clone, Debug)]
pub struct Prescribed {
    /// The variable, counted from 0.
    pub variable: usize,
    pub nodes: Vec<usize>,
    /// Value over time.
    pub magnitude: Magnitude,
}

/// Fields of all steps. They follow from the clock alone: no state of the run holds them.
#[derive(Clone)]
pub struct PredefinedFields {
    pub id: EffectId,
    /// Of each variable the values of nodes at the start.
    start: Arc<Vec<Vec<f64>>>,
    /// Of each step; one list serves all steps that go on with it.
    steps: Arc<Vec<Arc<[Prescribed]>>>,
    /// Groups that hold fields, with the boundaries of their elements.
    groups: Arc<Vec<(usize, Vec<ElementNodes>)>>,
    /// Of one variable: values of nodes, and of the elements of a group.
    nodal: Vec<f64>,
    means: Vec<f64>,
}

impl PredefinedFields {
    /// Values of nodes at the start by variable, and what each step prescribes.
    pub fn new(
        id: EffectId,
        start: Vec<Vec<f64>>,
        steps: Vec<Arc<[Prescribed]>>,
        groups: &[Box<dyn ElementGroup>],
    ) -> Self {
        let holding = groups.iter().enumerate().filter(|(_, g)| g.properties().fields > 0);
        let boundaries = |g: &dyn ElementGroup| (0..g.len()).map(|e| g.boundary(e)).collect::<Vec<_>>();
        let groups: Vec<_> = holding.map(|(i, g)| (i, boundaries(&**g))).collect();
        PredefinedFields {
            id,
            nodal: vec![0.0; start.first().map_or(0, Vec::len)],
            means: Vec::with_capacity(groups.iter().map(|g| g.1.len()).max().unwrap_or(0)),
            start: Arc::new(start),
            steps: Arc::new(steps),
            groups: Arc::new(groups),
        }
    }

    /// Gives elements the fields of this instant: the means of their nodes.
    pub(super) fn give(&mut self, groups: &mut [Box<dyn ElementGroup>], clock: &Clock<'_>) {
        let Some(step) = (clock.now.step as usize).checked_sub(1).and_then(|s| self.steps.get(s)) else { return };
        for (variable, start) in self.start.iter().enumerate() {
            self.nodal.copy_from_slice(start);
            for field in step.iter().filter(|f| f.variable == variable) {
                let value = field.magnitude.at(clock);
                field.nodes.iter().for_each(|&n| self.nodal[n] = value);
            }
            for (group, boundaries) in self.groups.iter() {
                let group = &mut groups[*group];
                if variable < group.properties().fields
                    && let Some(fields) = group.extensions().fields()
                {
                    self.means.clear();
                    self.means.extend(boundaries.iter().map(|nodes| mean(nodes, &self.nodal)));
                    fields.set_fields(variable, &self.means);
                }
            }
        }
    }

    pub fn bytes(&self) -> usize {
        let PredefinedFields { id: _, start, steps, groups, nodal, means } = self;
        let numbers = start.iter().map(Vec::capacity).sum::<usize>() + nodal.capacity() + means.capacity();
        let corners: usize = groups.iter().map(|g| size_of_val(&*g.1)).sum();
        let of = |f: &Prescribed| size_of_val(f) + size_of_val(&*f.nodes) + f.magnitude.bytes();
        let lists = steps.iter().enumerate().filter(|(i, list)| *i == 0 || !Arc::ptr_eq(list, &steps[i - 1]));
        size_of::<f64>() * numbers + corners + lists.flat_map(|list| list.1.iter()).map(of).sum::<usize>()
    }
}

/// The value in the middle of an element: the mean of the nodes of its boundary, each counted once.
pub fn mean(boundary: &[u32], nodal: &[f64]) -> f64 {
    let at = |i: usize| nodal[boundary[i] as usize];
    match boundary {
        [_, _, c, d] if c == d => ((at(0) + at(1)) + at(2)) / 3.0,
        [_, _, _, _] => 0.25 * ((at(0) + at(1)) + (at(2) + at(3))),
        _ => (0..boundary.len()).map(at).sum::<f64>() / boundary.len() as f64,
    }
}
