//! Ablations of numerical stabilisation: bulk viscosity, hourglass control, subzonal pressures, mass scaling.

use super::super::settings::{control, control_hourglass, deforms};
use super::EffectRemoval;
use crate::kernel::bulk_viscosity::BulkViscosity;
use crate::model::{HourglassMethod, Model};

pub(super) const LIST: &[EffectRemoval] = &[
    EffectRemoval::new(
        "bulk viscosity",
        "0, 0",
        |model| deforms(model) && model.steps.iter().any(|s| !s.bulk_viscosity.is_none()),
        |model| model.steps.iter_mut().for_each(|s| s.bulk_viscosity = BulkViscosity::NONE),
    ),
    EffectRemoval::new(
        "hourglass control",
        "none",
        |model| deforms(model) && has_quadrilaterals(model),
        |model| control_hourglass(model, HourglassMethod::Viscous, 0.0),
    ),
    EffectRemoval::new(
        "subzonal pressures",
        "one pressure per element",
        |model| deforms(model) && has_subzones(model),
        |model| control(model, |controls| controls.subzonal = Some(false)),
    ),
    EffectRemoval::new(
        "mass scaling",
        "physical mass",
        |model| model.steps.iter().any(|s| !s.mass_scalings.is_empty()),
        |model| model.steps.iter_mut().for_each(|s| s.mass_scalings.clear()),
    ),
];

/// Returns whether elements have subzonal pressures: equation of state, no shear modulus, not switched off by section
/// controls.
fn has_subzones(model: &Model) -> bool {
    model.sections.iter().any(|section| {
        let material = &model.materials[section.material];
        let fluid = material.eos.is_some() && material.shear_modulus.is_none_or(|shear| shear == 0.0);
        fluid && section.controls.subzonal != Some(false)
    })
}

/// Returns whether the model has quadrilaterals; triangles have no hourglass modes.
fn has_quadrilaterals(model: &Model) -> bool {
    model.sections.iter().flat_map(|s| &s.elements).any(|e| model.mesh.elements[*e].nodes.len() == 4)
}
