//! Memory of each effect, for the ledger. Effects of the first step are in the state, effects of later steps in the
//! plan.

use crate::kernel::lists::{Memory, heap_bytes};
use crate::plan::changes::ListChange;
use crate::plan::ledger::Ledger;
use crate::plan::{Plan, State};
use crate::state::EffectId;
use crate::state::rigid_body_3d::RigidBody3d;

/// Adds the sizes of all arrays of plan and state to the ledger rows of their effects.
pub fn record_bytes(plan: &mut Plan, state: &State) {
    let ledger = &mut plan.ledger;
    let changes = || plan.steps.iter().map(|step| &step.changes);
    let loads =
        || state.loads.iter().map(|load| &**load).chain(changes().flat_map(|c| &c.loads).flat_map(ListChange::added));
    for load in loads() {
        load.arrays().into_iter().for_each(|(name, bytes)| add(ledger, load.effect(), name, bytes));
    }
    let added = changes().flat_map(|c| &c.constraints).flat_map(ListChange::added);
    for constraint in state.constraints.iter().map(|constraint| &**constraint).chain(added) {
        let memory = constraint.memory();
        add(ledger, constraint.effect(), "constraint", memory.used);
        ledger.effects[constraint.effect()].reserved += memory.reserved;
    }
    for scaling in changes().flat_map(|c| &c.scaling).chain([&state.scaling]).flatten() {
        let row = ledger.effects.iter().position(|row| row.effect == "mass scaling");
        row.into_iter().for_each(|row| add(ledger, row, "requests", scaling.bytes()));
    }
    for domain in changes().flat_map(|c| &c.adaptive).chain([&state.adaptive]).flatten() {
        add(ledger, domain.id, "domain", domain.bytes());
    }
    for body in plan.remesh.iter().flat_map(|remesh| &remesh.bodies) {
        body.id.into_iter().for_each(|id| add(ledger, id, "body", body.bytes()));
    }
    for amplitude in &state.amplitude_routines {
        add(ledger, amplitude.id, "routine", amplitude.bytes());
    }
    elements(ledger, state, plan.rows.gather);
    if let Some(thermal) = &state.thermal {
        for (effect, bytes) in ["heat conduction", "thermal expansion"].into_iter().zip(thermal.bytes()) {
            let row = ledger.effects.iter().position(|row| row.effect == effect);
            row.into_iter().for_each(|row| add(ledger, row, "temperatures", bytes));
        }
    }
    let pushed = state.elements.has_links() || loads().any(|load| load.targets().nodes);
    if let Some(row) = plan.rows.gather.filter(|_| pushed) {
        add(ledger, row, "forces", state.dofs.nodes.bytes_of_forces());
    }
    if let Some(row) = plan.rows.integration {
        add(ledger, row, "rigid bodies", heap_bytes(&state.dofs.bodies));
        let spatial = state.dofs.bodies.iter().filter(|body| body.is_spatial()).count();
        add(ledger, row, "bodies in space", size_of::<RigidBody3d>() * spatial);
        add(ledger, row, "steps", plan.steps.iter().map(|step| size_of_val(step) + step.changes.bytes()).sum());
    }
    if let Some(row) = plan.rows.output {
        let bodies = plan.bodies.iter().map(crate::plan::PlannedRigidBody::bytes).sum();
        let columns = plan.columns.iter().map(|c| size_of_val(c) + c.name.capacity()).sum();
        let fields = plan.fields.iter().map(|f| size_of_val(f) + f.bytes()).sum();
        for (name, bytes) in [
            ("mesh", plan.mesh.bytes()),
            ("places", plan.places.bytes()),
            ("labels", plan.labels.bytes()),
            ("bodies", bodies),
            ("columns", columns),
            ("sets", plan.sets.iter().map(|set| size_of_val(set) + size_of_val(&set[..])).sum()),
            ("fields", fields),
        ] {
            add(ledger, row, name, bytes);
        }
    }
}

fn elements(ledger: &mut Ledger, state: &State, gather: Option<EffectId>) {
    let elements = &state.elements;
    for (group, &id) in elements.groups.iter().zip(&elements.ids) {
        add(ledger, id, "element state", group.bytes());
    }
    if let Some(frequency) = &elements.frequency {
        frequency.arrays().into_iter().for_each(|(name, bytes)| add(ledger, frequency.id, name, bytes));
    }
    // Springs and dashpots share one array, and so do both kinds of damping.
    let springs = ledger.effects.iter().any(|row| row.effect == "springs");
    let connectors = if springs { "springs" } else { "dashpots" };
    let of_mass = ledger.effects.iter().any(|row| row.effect == "mass proportional damping");
    let damping = if of_mass { "mass proportional damping" } else { "stiffness proportional damping" };
    let named = [
        ("area weighting", "rings", elements.assembly.rings.as_ref().map_or(0, |r| r.bytes())),
        ("averaged pressure", "triangles", elements.averagings.iter().flatten().map(|a| a.memory().used).sum()),
        (connectors, "connectors", elements.connectors.as_ref().map_or(0, |c| c.bytes())),
        ("cohesive elements", "bounds", elements.interfaces.as_ref().map_or(0, |i| i.bytes())),
        (damping, "coefficients and forces", elements.damping.as_ref().map_or(0, |d| d.bytes())),
        ("characteristic length", "elements", elements.lengths.iter().map(|l| l.bytes()).sum()),
        ("predefined fields", "values", elements.fields.as_ref().map_or(0, |f| f.bytes())),
        ("distortion control", "elements", elements.distortion.as_ref().map_or(0, |d| d.bytes())),
        ("mass scaling", "masses", elements.mass_scaling.bytes()),
        ("erosion", "elements", elements.bytes_of_erosion()),
        ("record of deleted elements", "elements and nodes", elements.deletions.bytes_of_record()),
    ];
    for (effect, name, bytes) in named {
        let row = ledger.effects.iter().position(|row| row.effect == effect);
        row.into_iter().for_each(|row| add(ledger, row, name, bytes));
    }
    if let Some(row) = gather {
        state.dofs.nodes.arrays().into_iter().for_each(|(name, bytes)| add(ledger, row, name, bytes));
        add(ledger, row, "gather", elements.bytes_of_gather());
    }
}

fn add(ledger: &mut Ledger, row: EffectId, name: &str, bytes: usize) {
    if bytes == 0 {
        return;
    }
    let arrays = &mut ledger.effects[row].arrays;
    match arrays.iter_mut().find(|a| a.0 == name) {
        Some(array) => array.1 += bytes,
        None => arrays.push((name.to_owned(), bytes)),
    }
}
