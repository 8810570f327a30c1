//! Field variables that a user subroutine sets at nodes (`*FIELD, USER`).

use crate::routines::{LoadFailure, NODAL_COMPONENTS, NodalFieldCall, UserNodalFields};
use crate::state::Instant;
use crate::state::dofs::{Dof, Dofs};
use crate::state::halt::HaltReason;

/// Largest number of nodes of one call.
const MOST_NODES: usize = 128;

/// Values that a user subroutine sets at nodes in a step.
#[derive(Clone, Debug)]
pub struct UserNodalField {
    /// Node set, upper case.
    pub set: String,
    /// First variable, from 0, and number of variables that are set together.
    pub variables: [usize; 2],
    /// Solver nodes, and their numbers in the deck.
    pub nodes: Vec<usize>,
    pub numbers: Vec<i32>,
    /// Duration of the step.
    pub duration: f64,
}

/// Subroutine and state of the nodes for a call.
pub struct NodalFieldInput<'a> {
    pub dofs: &'a Dofs,
    /// Length of the last increment.
    pub increment: f64,
    /// The subroutine; `None` keeps the initial values.
    pub routine: Option<&'a mut (dyn UserNodalFields + 'static)>,
}

/// Work arrays of the calls.
#[derive(Clone, Default)]
pub struct UserFieldArrays {
    coordinates: Vec<f64>,
    motion: [Vec<f64>; 3],
    values: Vec<f64>,
}

impl UserFieldArrays {
    /// Creates the arrays for calls of at most this number of variables; empty for none.
    pub fn new(variables: usize) -> Self {
        if variables == 0 {
            return UserFieldArrays::default();
        }
        let of_nodes = || vec![0.0; NODAL_COMPONENTS * MOST_NODES];
        UserFieldArrays {
            coordinates: vec![0.0; 3 * MOST_NODES],
            motion: [of_nodes(), of_nodes(), of_nodes()],
            values: vec![0.0; variables * MOST_NODES],
        }
    }

    pub fn bytes(&self) -> usize {
        let numbers = self.coordinates.len() + self.motion.iter().map(Vec::len).sum::<usize>() + self.values.len();
        size_of::<f64>() * numbers
    }

    /// Calls the subroutine for all nodes of a field; `initial` returns the initial value of a variable at a node, and `set`
    /// takes the new value.
    ///
    /// # Errors
    /// If the subroutine fails, or returns a value that is not finite.
    pub fn call(
        &mut self,
        field: &UserNodalField,
        now: &Instant,
        input: &mut NodalFieldInput<'_>,
        initial: impl Fn(usize, usize) -> f64,
        mut set: impl FnMut(usize, usize, f64),
    ) -> Result<(), HaltReason> {
        let Some(routine) = input.routine.as_deref_mut() else { return Ok(()) };
        let [first, count] = field.variables;
        for (nodes, numbers) in field.nodes.chunks(MOST_NODES).zip(field.numbers.chunks(MOST_NODES)) {
            self.gather(nodes, input.dofs);
            let values = &mut self.values[..count * nodes.len()];
            for (at, value) in values.iter_mut().enumerate() {
                *value = initial(first + at / nodes.len(), nodes[at % nodes.len()]);
            }
            let [u, v, a] = &self.motion;
            let components = NODAL_COMPONENTS * nodes.len();
            let call = NodalFieldCall {
                set: &field.set,
                now: *now,
                lengths: [input.increment, field.duration],
                variables: [first + 1, count],
                nodes: numbers,
                coordinates: &self.coordinates[..3 * nodes.len()],
                motion: [&u[..components], &v[..components], &a[..components]],
            };
            let invalid = |at: usize, value: f64| {
                let variable = first + 1 + at / nodes.len();
                LoadFailure::new(format!("it set variable {variable} of node {} to {value}", numbers[at % nodes.len()]))
            };
            let answer = routine.nodal_fields(&call, values).and_then(|()| {
                let wrong = values.iter().position(|value| !value.is_finite());
                wrong.map_or(Ok(()), |at| Err(invalid(at, values[at])))
            });
            answer.map_err(|failure| failure.halt(&format!("vufield of `{}`", field.set), now))?;
            for (at, value) in values.iter().enumerate() {
                set(first + at / nodes.len(), nodes[at % nodes.len()], *value);
            }
        }
        Ok(())
    }

    /// Copies coordinates and motion of nodes to the arrays.
    fn gather(&mut self, nodes: &[usize], dofs: &Dofs) {
        let quantities: [fn(&Dofs, Dof) -> f64; 3] = [Dofs::displacement, Dofs::velocity, Dofs::acceleration];
        for (index, &node) in nodes.iter().enumerate() {
            self.coordinates[3 * index..3 * index + 2].copy_from_slice(&dofs.nodes[node].place());
            for (list, quantity) in self.motion.iter_mut().zip(quantities) {
                for axis in 0..2 {
                    list[NODAL_COMPONENTS * index + axis] = quantity(dofs, Dof::Node(node, axis));
                }
            }
        }
    }
}
