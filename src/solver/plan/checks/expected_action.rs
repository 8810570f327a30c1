//! What a run is expected to do: contact pairs close, and plastic materials are loaded. Its end is compared with both (R328, R329).

use crate::model::{Model, PlasticityModel};
use crate::plan::Scene;

/// Returns the names of all contact pairs of two surfaces.
pub fn names_of_pairs(model: &Model) -> Vec<String> {
    let pairs = model.steps.iter().flat_map(|step| &step.surface_contacts).filter(|pair| !pair.is_self_contact());
    let mut names: Vec<String> =
        pairs.map(|pair| pair.sides.each_ref().map(|side| format!("`{}`", side.name)).join(" and ")).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// Returns the element groups of plastic materials with their initial yield stress.
pub fn yield_stresses(scene: Scene<'_>) -> Vec<(usize, f64)> {
    let mut groups = Vec::new();
    for (id, elements) in scene.model.material_regions() {
        let plastic = scene.model.materials.get(id.index()).and_then(|material| material.plastic.as_ref());
        let Some(stress) = plastic.and_then(PlasticityModel::initial_yield_stress).filter(|stress| *stress > 0.0)
        else {
            continue;
        };
        for place in elements.iter().filter_map(|e| scene.places.elements.get(e)) {
            if groups.last() != Some(&(place.0, stress)) {
                groups.push((place.0, stress));
            }
        }
    }
    groups
}
