//! Parts of a material's law left out.
//! Never here: what controls elements (`numerics`).

use super::{Ablation, one_way};
use crate::model::{DamageEvolution, Material, Model, StrainAtFailure};

pub(super) const LIST: &[Ablation] = &[
    Ablation {
        name: "rate dependence",
        instead: "static yield stress",
        ways: |model| usize::from(any(model, |m| m.rate.is_some())),
        edit: |model, _| no_rate(model),
        way: one_way,
    },
    Ablation {
        name: "heating by plastic work",
        instead: "temperatures stay",
        ways: |model| usize::from(heats(model)),
        edit: |model, _| model.steps.iter_mut().for_each(|s| s.adiabatic = false),
        way: one_way,
    },
    Ablation {
        name: "failure",
        instead: "no damage, no deletion, no cutoff",
        ways: |model| usize::from(any(model, fails)),
        edit: |model, _| {
            for material in &mut model.materials {
                material.failures.clear();
                material.tensile_failure = None;
            }
        },
        way: one_way,
    },
    Ablation {
        name: "plasticity",
        instead: "elastic, without failure",
        ways: |model| usize::from(any(model, |m| m.plastic.is_some())),
        edit: |model, _| {
            for material in &mut model.materials {
                (material.plastic, material.rate) = (None, None);
                material.failures.clear();
            }
        },
        way: one_way,
    },
];

/// Materials that something which deforms is made of.
fn any(model: &Model, which: impl Fn(&Material) -> bool) -> bool {
    super::super::settings::deforms(model) && model.sections.iter().any(|s| which(&model.materials[s.material]))
}

fn fails(material: &Material) -> bool {
    material.tensile_failure.is_some() || material.failures.iter().any(|f| f.evolution != DamageEvolution::Absent)
}

fn heats(model: &Model) -> bool {
    let hot = |m: &Material| m.plastic.is_some() && m.inelastic_heat_fraction.is_some() && m.specific_heat.is_some();
    model.steps.iter().any(|s| s.adiabatic) && any(model, hot)
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
