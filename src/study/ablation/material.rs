//! Parts of a material's law left out.

use super::Ablation;
use crate::model::{DamageEvolution, Material, Model, StrainAtFailure};

pub(super) const LIST: &[Ablation] = &[
    Ablation::new("rate dependence", "static yield stress", |model| any(model, |m| m.rate.is_some()), no_rate),
    Ablation::new("heating by plastic work", "temperatures stay", heats, no_heat_of_work),
    Ablation::new("heat conduction", "heat stays where it is given", conducts, |model| {
        let rows = model.materials.iter_mut().filter_map(|m| m.thermal.conductivity.as_mut()).flat_map(|c| &mut c.0);
        rows.for_each(|row| row[0] = NO_CONDUCTION);
    }),
    Ablation::new(
        "thermal expansion",
        "coefficient 0",
        |model| any(model, |m| m.thermal.expansion.is_some()),
        |model| model.materials.iter_mut().for_each(|m| m.thermal.expansion = None),
    ),
    Ablation::new(
        "failure",
        "no damage, no deletion, no cutoff",
        |model| any(model, fails),
        |model| {
            for material in &mut model.materials {
                material.failures.clear();
                material.tensile_failure = None;
            }
        },
    ),
    Ablation::new(
        "erosion",
        "no *EROSION",
        |model| !model.erosions.is_empty() && super::super::settings::deforms(model),
        |model| model.erosions.clear(),
    ),
    Ablation::new(
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

/// A conductivity, which must be above zero, by which nothing flows over any time.
const NO_CONDUCTION: f64 = 1e-100;

/// Materials that something which deforms is made of.
fn any(model: &Model, which: impl Fn(&Material) -> bool) -> bool {
    super::super::settings::deforms(model) && model.made_of().any(|(m, _)| which(&model.materials[m]))
}

fn fails(material: &Material) -> bool {
    material.tensile_failure.is_some() || material.failures.iter().any(|f| f.evolution != DamageEvolution::Absent)
}

fn heats(model: &Model) -> bool {
    let hot = |m: &Material| {
        m.plastic.is_some() && m.thermal.inelastic_heat_fraction.is_some() && m.thermal.specific_heat.is_some()
    };
    model.steps.iter().any(|s| s.adiabatic || s.coupled) && any(model, hot)
}

/// Where temperatures are solved for they go on to be, without what plastic work adds.
fn no_heat_of_work(model: &mut Model) {
    model.steps.iter_mut().for_each(|s| s.adiabatic = false);
    if model.steps.iter().any(|s| s.coupled) {
        model.materials.iter_mut().for_each(|m| m.thermal.inelastic_heat_fraction = None);
    }
}

fn conducts(model: &Model) -> bool {
    let conductor =
        |m: &Material| m.thermal.conductivity.as_ref().is_some_and(|c| c.0.iter().any(|row| row[0] > NO_CONDUCTION));
    model.steps.iter().any(|s| s.coupled) && any(model, conductor)
}

/// A criterion of failure that reads the rate keeps its own reference rate where it has one, and loses the term else.
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
