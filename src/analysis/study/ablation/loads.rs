//! Ablations of loads, contact and friction.

use super::EffectRemoval;
use crate::model::{ConnectorLaw, CoulombFriction, Load, LoadKind, Model, Step};

pub(super) const LIST: &[EffectRemoval] = &[
    EffectRemoval::new("friction", "coefficient 0 on all surfaces", has_friction, no_friction),
    EffectRemoval::new(
        "contact",
        "none: bodies penetrate each other",
        |model| model.steps.iter().any(Step::has_contact),
        no_contact,
    ),
    EffectRemoval::new("gravity", "none", |model| has(model, is_gravity), |model| remove(model, is_gravity)),
    EffectRemoval::new(
        "concentrated force",
        "none",
        |model| has(model, is_concentrated),
        |model| remove(model, is_concentrated),
    ),
    EffectRemoval::new("pressure", "none", |model| has(model, is_pressure), |model| remove(model, is_pressure)),
    EffectRemoval::new("user load", "none", |model| has(model, is_user), |model| remove(model, is_user)),
    EffectRemoval::new(
        "dashpots",
        "coefficient 0",
        |model| model.discrete.connectors.iter().any(|c| matches!(c.law, ConnectorLaw::Dashpot(v) if v != 0.0)),
        no_dashpots,
    ),
];

fn has_friction(model: &Model) -> bool {
    let of_load = |l: &Load| matches!(l.kind, LoadKind::Cavity { friction, .. } if friction > 0.0);
    model.steps.iter().any(|s| s.loads.iter().any(of_load) || s.frictions().any(CoulombFriction::is_active))
}

fn no_friction(model: &mut Model) {
    for step in &mut model.steps {
        for load in &mut step.loads {
            if let LoadKind::Cavity { friction, .. } = &mut load.kind {
                *friction = 0.0;
            }
        }
        step.contact_laws_mut().for_each(|law| *law = law.without_friction());
    }
}

fn no_contact(model: &mut Model) {
    for step in &mut model.steps {
        step.surface_contacts.clear();
        step.general_contact = None;
    }
}

fn is_gravity(load: &Load) -> bool {
    matches!(load.kind, LoadKind::Gravity { .. }) && load.magnitude != 0.0
}

fn is_concentrated(load: &Load) -> bool {
    matches!(load.kind, LoadKind::Concentrated { .. }) && load.magnitude != 0.0
}

fn is_pressure(load: &Load) -> bool {
    matches!(
        load.kind,
        LoadKind::Pressure(_) | LoadKind::Traction { .. } | LoadKind::Body { .. } | LoadKind::Blast { .. }
    ) && load.magnitude != 0.0
}

fn is_user(load: &Load) -> bool {
    load.kind.is_user()
}

fn has(model: &Model, kind: fn(&Load) -> bool) -> bool {
    model.steps.iter().any(|s| s.loads.iter().any(kind))
}

fn remove(model: &mut Model, kind: fn(&Load) -> bool) {
    model.steps.iter_mut().for_each(|s| s.loads.retain(|l| !kind(l)));
}

fn no_dashpots(model: &mut Model) {
    for connector in &mut model.discrete.connectors {
        if let ConnectorLaw::Dashpot(coefficient) = &mut connector.law {
            *coefficient = 0.0;
        }
    }
}
