//! Questions about the model that several passes ask.

use crate::model::{
    BoundaryCondition, InitialCondition, InitialKind, MaterialDefinition, Model, PlasticityModel, PredefinedVariable,
};

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

/// Distances by which nodes are moved or gaps changed at the start.
pub struct AdjustedNodes {
    /// Number of nodes.
    pub count: usize,
    /// The largest distances with the names of the nodes.
    pub text: String,
}

/// Lists the ten largest distances of mesh nodes; `None` if there are none except for rounding errors of coordinates.
pub fn largest_distances(model: &Model, mut distances: Vec<(usize, f64)>) -> Option<AdjustedNodes> {
    const LISTED: usize = 10;
    const ROUNDING: f64 = 1e-12;
    let extent = model.mesh.points.iter().flatten().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    distances.retain(|(_, distance)| distance.abs() > ROUNDING * extent);
    distances.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    let name = |node: usize| &model.mesh.node_names[node];
    let listed = distances.iter().take(LISTED).map(|&(node, distance)| format!("node {} {distance:.3e}", name(node)));
    let more = if distances.len() > LISTED { ", …" } else { "" };
    let text = listed.collect::<Vec<_>>().join(", ") + more;
    (!distances.is_empty()).then_some(AdjustedNodes { count: distances.len(), text })
}

pub fn given_fields(model: &Model) -> usize {
    let start = model.initial_conditions.iter().filter_map(|c| match c.kind {
        InitialKind::Field(variable, _) => Some(variable + 1),
        _ => None,
    });
    let prescribed = model.steps.iter().flat_map(|s| &s.fields).filter_map(|f| match f.variable {
        PredefinedVariable::Field(variable) => Some(variable + f.user.unwrap_or(1)),
        PredefinedVariable::Temperature => None,
    });
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

/// Returns the number in the deck of a mesh node; without a number, its position in the mesh, from 1.
pub fn number_of_node(model: &Model, node: usize) -> i32 {
    model.mesh.node_names[node].parse().unwrap_or(node as i32 + 1)
}
