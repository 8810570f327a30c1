//! Temperatures and field variables prescribed at nodes over time (`*TEMPERATURE`, `*FIELD`), and their transfer to
//! elements.

use crate::kernel::lists::Memory;
use std::sync::Arc;

use super::group::{ElementGroup, NodalVariable};
use super::user_field::{NodalFieldInput, UserFieldArrays, UserNodalField};
use crate::kernel::topology::ElementNodes;
use crate::state::EffectId;
use crate::state::halt::HaltReason;
use crate::state::magnitude::{AmplitudeClock, Magnitude};

/// Prescribed value of a variable at some nodes in a step.
#[derive(Clone, Debug)]
pub struct NodalFieldValue {
    pub variable: NodalVariable,
    pub nodes: Vec<usize>,
    /// Value over time.
    pub magnitude: Magnitude,
}

/// Elements of a group that take the means of their nodes.
#[derive(Clone)]
pub struct FieldGroup {
    pub group: usize,
    /// Boundaries of all elements of the group.
    pub boundaries: Vec<ElementNodes>,
}

/// A variable with prescribed values, and its groups.
#[derive(Clone)]
pub struct PredefinedField {
    pub variable: NodalVariable,
    /// Initial values at the nodes.
    pub start: Vec<f64>,
    pub groups: Vec<FieldGroup>,
}

/// Current values of a variable: at the nodes, and at the elements of each group.
#[derive(Clone)]
struct FieldValues {
    nodal: Vec<f64>,
    means: Vec<Vec<f64>>,
}

/// Prescribed values of a step.
#[derive(Clone, Debug, Default)]
pub struct StepFields {
    /// Values over time.
    pub given: Vec<NodalFieldValue>,
    /// Values of a user subroutine, which replace those over time.
    pub user: Vec<UserNodalField>,
}

/// Predefined fields of all steps. They depend on the time, and on the nodes by a user subroutine; elements have saved
/// values, so that the fields are not part of the saved state.
#[derive(Clone)]
pub struct PredefinedFields {
    pub id: EffectId,
    list: Arc<Vec<PredefinedField>>,
    /// Prescribed values of each step; steps that continue a list share it.
    steps: Arc<Vec<Arc<StepFields>>>,
    values: Vec<FieldValues>,
    arrays: UserFieldArrays,
}

impl PredefinedFields {
    /// Creates the fields from their initial values and the prescribed values of each step.
    pub fn new(id: EffectId, list: Vec<PredefinedField>, steps: Vec<Arc<StepFields>>) -> Self {
        let start = |field: &PredefinedField| {
            let means = |group: &FieldGroup| group.boundaries.iter().map(|nodes| mean(nodes, &field.start)).collect();
            FieldValues { nodal: field.start.clone(), means: field.groups.iter().map(means).collect() }
        };
        let values = list.iter().map(start).collect();
        let together = steps.iter().flat_map(|step| &step.user).map(|field| field.variables[1]);
        let arrays = UserFieldArrays::new(together.max().unwrap_or(0));
        PredefinedFields { id, list: Arc::new(list), steps: Arc::new(steps), values, arrays }
    }

    /// Sets the variables of elements at this instant to the means of their nodes.
    ///
    /// # Errors
    /// If the user subroutine fails; the run halts.
    pub(super) fn give(
        &mut self,
        groups: &mut [Box<dyn ElementGroup>],
        clock: &AmplitudeClock<'_>,
        mut input: NodalFieldInput<'_>,
    ) -> Result<(), HaltReason> {
        let Some(step) = (clock.now.step as usize).checked_sub(1).and_then(|s| self.steps.get(s)) else {
            return Ok(());
        };
        for (field, FieldValues { nodal, .. }) in self.list.iter().zip(&mut self.values) {
            nodal.copy_from_slice(&field.start);
            for given in step.given.iter().filter(|given| given.variable == field.variable) {
                let value = given.magnitude.at(clock);
                given.nodes.iter().for_each(|&n| nodal[n] = value);
            }
        }
        // Field variables are first in the list, in their order.
        let (list, values) = (&self.list, &mut self.values);
        for field in &step.user {
            let initial = |variable: usize, node: usize| list[variable].start[node];
            let set = |variable: usize, node: usize, value: f64| values[variable].nodal[node] = value;
            self.arrays.call(field, &clock.now, &mut input, initial, set)?;
        }
        for (field, FieldValues { nodal, means }) in self.list.iter().zip(&mut self.values) {
            for (FieldGroup { group, boundaries }, means) in field.groups.iter().zip(means) {
                means.iter_mut().zip(boundaries).for_each(|(value, nodes)| *value = mean(nodes, nodal));
                if let Some(solid) = groups[*group].as_solid() {
                    solid.set_means(field.variable, means);
                }
            }
        }
        Ok(())
    }

    fn temperatures(&self) -> Option<(&PredefinedField, &FieldValues)> {
        self.list.iter().zip(&self.values).find(|field| field.0.variable == NodalVariable::Temperature)
    }

    /// Returns whether `*TEMPERATURE` prescribes temperatures.
    pub fn prescribes_temperatures(&self) -> bool {
        self.temperatures().is_some()
    }

    /// Returns the prescribed temperatures last given to the elements of a group; `None` if it has none.
    pub fn temperatures_of(&self, group: usize) -> Option<&[f64]> {
        let (field, values) = self.temperatures()?;
        let index = field.groups.iter().position(|of_group| of_group.group == group)?;
        Some(&values.means[index])
    }

    /// Returns the temperature of a node; `None` if no temperatures are prescribed.
    pub fn temperature(&self, node: usize) -> Option<f64> {
        Some(self.temperatures()?.1.nodal[node])
    }

    pub fn bytes(&self) -> usize {
        let PredefinedFields { id: _, list, steps, values, arrays } = self;
        let numbers =
            |values: &FieldValues| values.nodal.capacity() + values.means.iter().map(Vec::capacity).sum::<usize>();
        let numbers =
            list.iter().map(|field| field.start.capacity()).sum::<usize>() + values.iter().map(numbers).sum::<usize>();
        let corners: usize = list.iter().flat_map(|f| &f.groups).map(|g| size_of_val(&*g.boundaries)).sum();
        let bytes_of = |f: &NodalFieldValue| size_of_val(f) + size_of_val(&*f.nodes) + f.magnitude.bytes();
        let lists = steps.iter().enumerate().filter(|(i, list)| *i == 0 || !Arc::ptr_eq(list, &steps[i - 1]));
        let bytes_of_user = |f: &UserNodalField| size_of_val(f) + size_of_val(&*f.nodes) + size_of_val(&*f.numbers);
        let of_step = |step: &StepFields| {
            step.given.iter().map(bytes_of).sum::<usize>() + step.user.iter().map(bytes_of_user).sum::<usize>()
        };
        let steps: usize = lists.map(|list| of_step(list.1)).sum();
        size_of::<f64>() * numbers + corners + steps + arrays.bytes()
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
