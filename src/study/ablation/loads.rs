//! Loads, contact and friction left out.
//! Never here: the target.

use super::{Ablation, one_way};
use crate::model::{ConnectorLaw, Friction, Load, LoadKind, Model, Step};

pub(super) const LIST: &[Ablation] = &[
    Ablation {
        name: "friction",
        instead: "coefficient 0 on all surfaces",
        ways: |model| usize::from(has_friction(model)),
        edit: |model, _| no_friction(model),
        way: one_way,
    },
    Ablation {
        name: "contact",
        instead: "none: all passes through all",
        ways: |model| usize::from(model.steps.iter().any(Step::has_contact)),
        edit: |model, _| no_contact(model),
        way: one_way,
    },
    Ablation {
        name: "gravity",
        instead: "none",
        ways: |model| usize::from(has(model, is_gravity)),
        edit: |model, _| without(model, is_gravity),
        way: one_way,
    },
    Ablation {
        name: "concentrated force",
        instead: "none",
        ways: |model| usize::from(has(model, is_concentrated)),
        edit: |model, _| without(model, is_concentrated),
        way: one_way,
    },
    Ablation {
        name: "pressure",
        instead: "none",
        ways: |model| usize::from(has(model, is_pressure)),
        edit: |model, _| without(model, is_pressure),
        way: one_way,
    },
    Ablation {
        name: "user load",
        instead: "none",
        ways: |model| usize::from(has(model, is_user)),
        edit: |model, _| without(model, is_user),
        way: one_way,
    },
    Ablation {
        name: "dashpots",
        instead: "coefficient 0",
        ways: |model| {
            usize::from(model.discrete.connectors.iter().any(|c| matches!(c.law, ConnectorLaw::Dashpot(v) if v != 0.0)))
        },
        edit: |model, _| no_dashpots(model),
        way: one_way,
    },
];

fn has_friction(model: &Model) -> bool {
    let of_load = |l: &Load| matches!(l.kind, LoadKind::Cavity { friction, .. } if friction > 0.0);
    model.steps.iter().any(|s| s.loads.iter().any(of_load) || s.frictions().any(Friction::is_there))
}

fn no_friction(model: &mut Model) {
    for step in &mut model.steps {
        for load in &mut step.loads {
            if let LoadKind::Cavity { friction, .. } = &mut load.kind {
                *friction = 0.0;
            }
        }
        step.frictions_mut().for_each(|friction| *friction = Friction::default());
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
    matches!(load.kind, LoadKind::Pressure(_)) && load.magnitude != 0.0
}

fn is_user(load: &Load) -> bool {
    matches!(load.kind, LoadKind::User { .. } | LoadKind::UserBody { .. })
}

fn has(model: &Model, which: fn(&Load) -> bool) -> bool {
    model.steps.iter().any(|s| s.loads.iter().any(which))
}

fn without(model: &mut Model, which: fn(&Load) -> bool) {
    model.steps.iter_mut().for_each(|s| s.loads.retain(|l| !which(l)));
}

fn no_dashpots(model: &mut Model) {
    for connector in &mut model.discrete.connectors {
        if let ConnectorLaw::Dashpot(coefficient) = &mut connector.law {
            *coefficient = 0.0;
        }
    }
}
