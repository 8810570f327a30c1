//! Properties of a model that limit the order of convergence or amplify small perturbations.

use super::settings::deforms;
use crate::model::{LoadKind, MaterialDefinition, Model};

/// Returns whether results can change by more than the size of a small perturbation: with contact, failure, element
/// deletion or new meshes.
pub fn is_sensitive(model: &Model) -> bool {
    has_contact(model) || has_failure(model) || has_new_meshes(model)
}

/// Returns the properties of a model that can limit the order of convergence, as words.
pub fn limits_of_order(model: &Model) -> Vec<&'static str> {
    let concentrated = |kind: &LoadKind| matches!(kind, LoadKind::Concentrated { .. });
    let deforms = deforms(model);
    let point_loads = deforms && model.steps.iter().flat_map(|s| &s.loads).any(|l| concentrated(&l.kind));
    let viscosity = deforms && model.steps.iter().any(|s| s.bulk_viscosity.linear > 0.0);
    let candidates = [
        (has_contact(model), "contact (first touch)"),
        (has_failure(model), "failure or element deletion"),
        (has_new_meshes(model), "new meshes (*REMESH)"),
        (point_loads, "concentrated forces"),
        (viscosity, "linear bulk viscosity at discontinuities (order 0.5)"),
    ];
    candidates.into_iter().filter(|cause| cause.0).map(|cause| cause.1).collect()
}

fn has_contact(model: &Model) -> bool {
    model.steps.iter().any(|step| step.has_contact())
}

fn has_new_meshes(model: &Model) -> bool {
    !model.remeshings.is_empty()
}

fn has_failure(model: &Model) -> bool {
    let fails = |m: &MaterialDefinition| !m.failures.is_empty() || m.tensile_failure.is_some();
    !model.erosions.is_empty() || model.materials.iter().any(fails)
}
