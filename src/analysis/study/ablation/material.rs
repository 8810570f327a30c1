//! Ablations of parts of the material laws.

use super::EffectRemoval;
use crate::model::{DamageEvolution, MaterialDefinition, Model, StrainAtFailure};

pub(super) const LIST: &[EffectRemoval] = &[
    EffectRemoval::new("rate dependence", "static yield stress", |model| any(model, |m| m.rate.is_some()), no_rate),
    EffectRemoval::new("heating by plastic work", "constant temperature", heats, no_heat_of_work),
    EffectRemoval::new("heat conduction", "conductivity 0", conducts, |model| {
        let rows = model.materials.iter_mut().filter_map(|m| m.thermal.conductivity.as_mut()).flat_map(|c| &mut c.0);
        rows.for_each(|row| row[0] = NO_CONDUCTION);
    }),
    EffectRemoval::new(
        "thermal expansion",
        "coefficient 0",
        |model| any(model, |m| m.thermal.expansion.is_some()),
        |model| model.materials.iter_mut().for_each(|m| m.thermal.expansion = None),
    ),
    EffectRemoval::new(
        "failure",
        "no damage, no element deletion, no tension cutoff",
        |model| any(model, fails),
        |model| {
            for material in &mut model.materials {
                material.failures.clear();
                (material.tensile_failure, material.failed) = (None, None);
            }
        },
    ),
    EffectRemoval::new(
        "erosion",
        "no *EROSION",
        |model| !model.erosions.is_empty() && super::super::settings::deforms(model),
        |model| model.erosions.clear(),
    ),
    EffectRemoval::new(
        "plasticity",
        "elastic, without failure",
        |model| any(model, |m| m.plastic.is_some()),
        |model| {
            for material in &mut model.materials {
                (material.plastic, material.rate) = (None, None);
                material.failures.clear();
            }
        },
    ),
];

/// Negligible conductivity; a conductivity must be above zero.
const NO_CONDUCTION: f64 = 1e-100;

/// Returns whether a material of a deformable element has the property `which`.
fn any(model: &Model, which: impl Fn(&MaterialDefinition) -> bool) -> bool {
    super::super::settings::deforms(model) && model.layer_regions().any(|(m, _)| which(&model.materials[m]))
}

fn fails(material: &MaterialDefinition) -> bool {
    material.tensile_failure.is_some() || material.failures.iter().any(|f| f.evolution != DamageEvolution::Absent)
}

fn heats(model: &Model) -> bool {
    let hot = |m: &MaterialDefinition| {
        m.plastic.is_some() && m.thermal.inelastic_heat_fraction.is_some() && m.thermal.specific_heat.is_some()
    };
    model.steps.iter().any(|s| s.adiabatic || s.coupled) && any(model, hot)
}

/// Removes the heat of plastic work; steps with heat conduction still solve for temperatures.
fn no_heat_of_work(model: &mut Model) {
    model.steps.iter_mut().for_each(|s| s.adiabatic = false);
    if model.steps.iter().any(|s| s.coupled) {
        model.materials.iter_mut().for_each(|m| m.thermal.inelastic_heat_fraction = None);
    }
}

fn conducts(model: &Model) -> bool {
    let conductor = |m: &MaterialDefinition| {
        m.thermal.conductivity.as_ref().is_some_and(|c| c.0.iter().any(|row| row[0] > NO_CONDUCTION))
    };
    model.steps.iter().any(|s| s.coupled) && any(model, conductor)
}

/// Removes rate dependence. A Johnson-Cook failure criterion keeps its rate term if it has its own reference rate;
/// otherwise the term is removed.
fn no_rate(model: &mut Model) {
    for material in &mut model.materials {
        material.rate = None;
        for failure in &mut material.failures {
            if let StrainAtFailure::JohnsonCook(d, None) = &mut failure.strain {
                d[3] = 0.0;
            }
        }
    }
}
