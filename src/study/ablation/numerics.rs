//! What keeps elements in shape and shocks smooth, left out.
//! Never here: materials.

use super::super::settings::{control, control_hourglass, deforms};
use super::{Ablation, one_way};
use crate::model::{Hourglass, Model};

pub(super) const LIST: &[Ablation] = &[
    Ablation {
        name: "bulk viscosity",
        instead: "0, 0",
        ways: |model| usize::from(deforms(model) && model.steps.iter().any(|s| s.bulk_viscosity != [0.0; 2])),
        edit: |model, _| model.steps.iter_mut().for_each(|s| s.bulk_viscosity = [0.0; 2]),
        way: one_way,
    },
    Ablation {
        name: "hourglass control",
        instead: "none",
        ways: |model| usize::from(deforms(model) && has_quadrilaterals(model)),
        edit: |model, _| control_hourglass(model, Hourglass::Viscous, 0.0),
        way: one_way,
    },
    Ablation {
        name: "subzonal pressures",
        instead: "one pressure an element",
        ways: |model| usize::from(deforms(model) && has_subzones(model)),
        edit: |model, _| control(model, |controls| controls.subzonal = Some(false)),
        way: one_way,
    },
    Ablation {
        name: "mass scaling",
        instead: "the mass of the material",
        ways: |model| usize::from(model.steps.iter().any(|s| !s.mass_scalings.is_empty())),
        edit: |model, _| model.steps.iter_mut().for_each(|s| s.mass_scalings.clear()),
        way: one_way,
    },
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
