//! Questions about the model that several passes ask.

use crate::model::{BoundaryCondition, InitialCondition, InitialKind, MaterialDefinition, Model, PlasticityModel};

/// Returns the reference nodes of rigid bodies whose temperature the deck gives.
pub fn heated_references(model: &Model) -> Vec<usize> {
    if !model.solves_for_temperatures() {
        return Vec::new();
    }
    let starts = |c: &InitialCondition, n: &usize| c.kind.temperature().is_some() && c.members.binary_search(n).is_ok();
    let holds = |b: &BoundaryCondition, n: &usize| b.is_thermal() && b.nodes.contains(n);
    let is_heated = |n: &usize| {
        model.initial_conditions.iter().any(|c| starts(c, n))
            || model.steps.iter().any(|step| step.boundaries.iter().any(|b| holds(b, n)))
    };
    model.rigid_bodies.iter().map(|body| body.reference).filter(is_heated).collect()
}

pub fn given_fields(model: &Model) -> usize {
    let start = model.initial_conditions.iter().filter_map(|c| match c.kind {
        InitialKind::Field(variable, _) => Some(variable + 1),
        _ => None,
    });
    let prescribed = model.steps.iter().flat_map(|s| &s.fields).map(|f| f.variable + 1);
    start.chain(prescribed).max().unwrap_or(0)
}

/// Returns the number of field variables of a material: those of the deck or of its tables, and at least one with
/// `*USER DEFINED FIELD`.
pub fn field_variables(model: &Model, material: &MaterialDefinition) -> usize {
    given_fields(model).max(dependencies(material)).max(usize::from(material.user.fields.is_some()))
}

/// Returns the number of field variables on which the tables of a material depend.
pub fn dependencies(material: &MaterialDefinition) -> usize {
    // The first three columns are two moduli, or yield stress and plastic strain, and the temperature.
    let dependencies_of = |rows: &[Vec<f64>]| rows.first().map_or(0, |row| row.len().saturating_sub(3));
    let plastic =
        if let Some(PlasticityModel::OverFields(rows)) = &material.plastic { dependencies_of(rows) } else { 0 };
    plastic.max(dependencies_of(&material.elastic_table))
}
