//! Digest of a run: a hash over the bits of its final state in a fixed order, independent of the build.

use sha2::{Digest as _, Sha256};

use super::run_state::RunState;
use crate::element::group::ElementGroup;
use crate::variables::{Variable, VariableComponent};

/// Hash of floating-point numbers by their bit patterns.
struct BitHasher(Sha256);

impl BitHasher {
    fn add(&mut self, values: &[f64]) {
        values.iter().for_each(|v| self.0.update(v.to_bits().to_le_bytes()));
    }

    /// Adds an optional value; a missing value differs from zero.
    fn add_if(&mut self, value: Option<f64>) {
        self.0.update([u8::from(value.is_some())]);
        self.add(value.as_slice());
    }

    fn element(&mut self, group: &dyn ElementGroup, e: usize) {
        for part in Variable::Stress.parts().chain(Variable::Mass.parts()) {
            self.add(group.value(e, part).as_slice());
        }
        for variable in [Variable::PlasticStrain, Variable::Temperature, Variable::SpecificEnergy, Variable::Status] {
            self.add_if(group.value(e, variable.into()));
        }
        let state = |component| VariableComponent { variable: Variable::State, component };
        let mut state_variables = (0..).map_while(|i| group.value(e, state(i)));
        state_variables.by_ref().for_each(|value| self.add(&[value]));
    }
}

/// Returns the SHA-256 digest, in hexadecimal, of time, increment, motion of bodies and nodes, element states and
/// energies.
pub(super) fn digest(run: &RunState<'_>) -> String {
    let mut bits = BitHasher(Sha256::new());
    bits.0.update(run.now.increment.to_le_bytes());
    bits.add(&[run.now.step_time, run.now.total_time]);
    for body in &run.state.dofs.bodies {
        bits.add(&[body.displacement, body.velocity, body.acceleration]);
        body.numbers_in_space(&mut |numbers| bits.add(numbers));
    }
    run.state.dofs.nodes.as_slice().iter().for_each(|n| bits.add(&n.as_array()));
    run.state.dofs.nodes.acceleration.iter().for_each(|a| bits.add(a));
    for group in &run.state.elements.groups {
        (0..group.len()).for_each(|e| bits.element(&**group, e));
    }
    if let Some(heat) = run.state.heat() {
        bits.add(heat.temperatures());
        let energies = heat.energies();
        bits.add(&[energies.external, energies.internal, energies.inelastic]);
    }
    let e = run.balance.energy();
    bits.add(&[e.kinetic, e.work, e.friction, e.cavity, e.internal, e.strain, e.plastic, e.viscous, e.contact]);
    bits.add(&[e.artificial, e.total, e.initial, run.balance.drift_over_largest()]);
    bits.add(e.penalty.as_slice());
    bits.add(e.damage.as_slice());
    let digit = |value: u8| char::from(b"0123456789abcdef"[usize::from(value)]);
    bits.0.finalize().iter().flat_map(|byte| [digit(byte >> 4), digit(byte & 15)]).collect()
}
