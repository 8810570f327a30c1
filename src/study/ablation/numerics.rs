//! What keeps elements in shape and shocks smooth, left out.

use super::super::settings::{control, control_hourglass, deforms};
use super::Ablation;
use crate::model::{Hourglass, Model};

pub(super) const LIST: &[Ablation] = &[
    Ablation::new(
        "bulk viscosity",
        "0, 0",
        |model| deforms(model) && model.steps.iter().any(|s| s.bulk_viscosity != [0.0; 2]),
        |model| model.steps.iter_mut().for_each(|s| s.bulk_viscosity = [0.0; 2]),
    ),
    Ablation::new(
        "hourglass control",
        "none",
        |model| deforms(model) && has_quadrilaterals(model),
        |model| control_hourglass(model, Hourglass::Viscous, 0.0),
    ),
    Ablation::new(
        "subzonal pressures",
        "one pressure an element",
        |model| deforms(model) && has_subzones(model),
        |model| control(model, |controls| controls.subzonal = Some(false)),
    ),
    Ablation::new(
        "mass scaling",
        "the mass of the material",
        |model| model.steps.iter().any(|s| !s.mass_scalings.is_empty()),
        |model| model.steps.iter_mut().for_each(|s| s.mass_scalings.clear()),
    ),
];

/// Quarters push back where there is an equation of state and no shear modulus, unless controls say no.
fn has_subzones(model: &Model) -> bool {
    model.sections.iter().any(|section| {
        let material = &model.materials[section.material];
        let fluid = material.eos.is_some() && material.shear_modulus.is_none_or(|shear| shear == 0.0);
        fluid && section.controls.subzonal != Some(false)
    })
}

/// Triangles have no pattern that hourglass control could find.
fn has_quadrilaterals(model: &Model) -> bool {
    model.sections.iter().flat_map(|s| &s.elements).any(|e| model.mesh.elements[*e].nodes.len() == 4)
}
