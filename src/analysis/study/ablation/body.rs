//! Ablation that replaces a deformable body by a rigid body.

use super::EffectRemoval;
use crate::kernel::lists::sorted_unique;
use crate::kernel::quad;
use crate::model::{InitialCondition, InitialKind, LoadKind, Model, PointMass, RigidBody};

pub(super) const LIST: &[EffectRemoval] = &[EffectRemoval::new(
    "deformation of the body",
    "rigid body of the same mass and velocity along z",
    |model| velocity(model).is_some(),
    make_rigid,
)];

/// Returns the initial velocity of the body if it can be made rigid: one initial velocity along z, loads only from
/// targets or user subroutines, no boundary conditions along z, no contact.
fn velocity(model: &Model) -> Option<f64> {
    let driven = |kind: &LoadKind| matches!(kind, LoadKind::Cavity { .. } | LoadKind::User { .. });
    let loaded = model.steps.iter().any(|s| s.loads.iter().any(|l| driven(&l.kind)));
    let is_constrained = model.steps.iter().any(|s| s.has_contact() || s.boundaries.iter().any(|b| b.dof == 2));
    let joined = !model.rigid_bodies.is_empty()
        || !model.discrete.connectors.is_empty()
        || !model.constraints.equations.is_empty();
    if !loaded || is_constrained || joined || model.sections.is_empty() || !model.shell_sections.is_empty() {
        return None;
    }
    let mut speed = None;
    let nodes = body_nodes(model);
    for condition in &model.initial_conditions {
        let InitialKind::Velocity(2, value) = condition.kind else { continue };
        let whole = nodes.iter().all(|n| condition.members.binary_search(n).is_ok());
        if !whole || speed.is_some_and(|s| s != value) {
            return None;
        }
        speed = Some(value);
    }
    speed
}

fn body_nodes(model: &Model) -> Vec<usize> {
    let elements = model.sections.iter().flat_map(|s| &s.elements);
    let nodes: Vec<usize> = sorted_unique(elements.flat_map(|&e| model.mesh.elements[e].nodes.iter().copied()));
    nodes
}

fn make_rigid(model: &mut Model) {
    let (Some(speed), Some(&reference)) = (velocity(model), body_nodes(model).first()) else { return };
    let mut mass: f64 = model.discrete.masses.drain(..).map(|p| p.mass).sum();
    for section in &model.sections {
        let density = model.materials[section.material].density.unwrap_or(0.0);
        let volume = |&e: &usize| model.mesh.initial_cells(e).map(quad::volume).sum::<f64>();
        mass += section.elements.iter().map(volume).sum::<f64>() * density;
    }
    let span = model.sections[0].span;
    let elements = model.sections.iter().flat_map(|s| s.elements.clone()).collect();
    let name = "(STUDY)".to_owned();
    model.sections.clear();
    model.discrete.masses.push(PointMass { node: reference, mass, span });
    model.rigid_bodies.push(RigidBody {
        name,
        reference,
        elements,
        nodes: Vec::new(),
        thickness: 0.0,
        density: 0.0,
        span,
    });
    let kind = InitialKind::Velocity(2, speed);
    model.initial_conditions = vec![InitialCondition { kind, members: vec![reference], span }];
}
