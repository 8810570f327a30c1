//! Field variables prescribed at nodes over time (`*FIELD`), and their transfer to elements.

use crate::kernel::lists::Memory;
use std::sync::Arc;

use super::group::{ElementGroup, NodalVariable};
use crate::kernel::topology::ElementNodes;
use crate::state::EffectId;
use crate::state::magnitude::{AmplitudeClock, Magnitude};

/// Prescribed value of a field variable at some nodes in a step.
#[derive(Clone, Debug)]
pub struct NodalFieldValue {
    /// Index of the field variable, from 0.
    pub variable: usize,
    pub nodes: Vec<usize>,
    /// Value over time.
    pub magnitude: Magnitude,
}

/// Predefined fields of all steps. They depend on the time only and are not part of the saved state.
#[derive(Clone)]
pub struct PredefinedFields {
    pub id: EffectId,
    /// Initial nodal values of each variable.
    start: Arc<Vec<Vec<f64>>>,
    /// Prescribed values of each step; steps that continue a list share it.
    steps: Arc<Vec<Arc<[NodalFieldValue]>>>,
    /// Groups with field variables, and the boundaries of their elements.
    groups: Arc<Vec<(usize, Vec<ElementNodes>)>>,
    /// Values of one variable: at the nodes, and for the elements of a group.
    nodal: Vec<f64>,
    means: Vec<f64>,
}

impl PredefinedFields {
    /// Creates the fields from the initial nodal values by variable and the prescribed values of each step.
    pub fn new(
        id: EffectId,
        start: Vec<Vec<f64>>,
        steps: Vec<Arc<[NodalFieldValue]>>,
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

    /// Sets the field variables of elements at this instant to the means of their nodes.
    pub(super) fn give(&mut self, groups: &mut [Box<dyn ElementGroup>], clock: &AmplitudeClock<'_>) {
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
                    && let Some(solid) = group.as_solid()
                {
                    self.means.clear();
                    self.means.extend(boundaries.iter().map(|nodes| mean(nodes, &self.nodal)));
                    solid.set_means(NodalVariable::Field(variable), &self.means);
                }
            }
        }
    }

    pub fn bytes(&self) -> usize {
        let PredefinedFields { id: _, start, steps, groups, nodal, means } = self;
        let numbers = start.iter().map(Vec::capacity).sum::<usize>() + nodal.capacity() + means.capacity();
        let corners: usize = groups.iter().map(|g| size_of_val(&*g.1)).sum();
        let bytes_of = |f: &NodalFieldValue| size_of_val(f) + size_of_val(&*f.nodes) + f.magnitude.bytes();
        let lists = steps.iter().enumerate().filter(|(i, list)| *i == 0 || !Arc::ptr_eq(list, &steps[i - 1]));
        size_of::<f64>() * numbers + corners + lists.flat_map(|list| list.1.iter()).map(bytes_of).sum::<usize>()
    }
}

/// Returns the value at the centre of an element: the mean over the nodes of its boundary, coincident nodes counted
/// once.
pub fn mean(boundary: &[u32], nodal: &[f64]) -> f64 {
    let value_at = |i: usize| nodal[boundary[i] as usize];
    match boundary {
        [_, _, c, d] if c == d => ((value_at(0) + value_at(1)) + value_at(2)) / 3.0,
        [_, _, _, _] => 0.25 * ((value_at(0) + value_at(1)) + (value_at(2) + value_at(3))),
        _ => (0..boundary.len()).map(value_at).sum::<f64>() / boundary.len() as f64,
    }
}
