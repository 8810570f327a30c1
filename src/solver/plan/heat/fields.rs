//! Field variables of the plan: initial nodal values, `*FIELD` of each step, and material tables over field variables.

use std::sync::Arc;

use crate::element::predefined::{NodalFieldValue, PredefinedFields, mean};
use crate::material::PointValue;
use crate::model::{InitialKind, MaterialDefinition, Model};
use crate::plan::loads::magnitude;
use crate::plan::queries::{dependencies, given_fields};
use crate::plan::solids::user_material::materials_present;
use crate::plan::state::SolidState;
use crate::plan::{Report, Scene, SolidPlaces};

/// Returns the number of field variables that a material reads: all with user subroutines, else those of its tables.
fn fields_read(material: &MaterialDefinition) -> usize {
    let user = &material.user;
    let calls_routines = user.material.is_some() || user.fields.is_some() || material.has_user_hardening();
    if calls_routines { usize::MAX } else { dependencies(material) }
}

/// Returns the initial nodal values of each field variable, 0 by default.
fn fields_at_start(model: &Model, places: &SolidPlaces, nodes: usize) -> Vec<Vec<f64>> {
    let mut values = vec![vec![0.0; nodes]; given_fields(model)];
    for condition in &model.initial_conditions {
        if let InitialKind::Field(variable, value) = condition.kind {
            let places = condition.members.iter().filter_map(|n| places.nodes.get(n));
            places.for_each(|&place| values[variable][place] = value);
        }
    }
    values
}

pub fn start_fields(model: &Model, places: &SolidPlaces, state: &mut SolidState) {
    if !model.initial_conditions.iter().any(|c| matches!(c.kind, InitialKind::Field(..))) {
        return;
    }
    let values = fields_at_start(model, places, state.dofs.nodes.len());
    for group in state.elements.groups.iter_mut().filter(|g| g.properties().fields > 0) {
        for e in 0..group.len() {
            let boundary = group.boundary(e);
            for (variable, nodal) in values.iter().enumerate() {
                group.set(e, PointValue::Field(variable, mean(&boundary, nodal)));
            }
        }
    }
}

/// Creates the values of `*FIELD`; `None` if no material depends on field variables.
pub fn plan(scene: Scene, state: &SolidState, report: &mut Report) -> Option<Box<PredefinedFields>> {
    let model = scene.model;
    let cards = || model.steps.iter().flat_map(|s| &s.fields);
    let groups = &state.elements.groups;
    let most_read = materials_present(scene).map(fields_read).max().unwrap_or(0);
    if most_read == 0 {
        for field in cards() {
            let what = format!("*FIELD, VARIABLE={}", field.variable + 1);
            report.add_unused_card(field.span, what, "no material depends on field variables");
        }
        for condition in model.initial_conditions.iter().filter(|c| matches!(c.kind, InitialKind::Field(..))) {
            let what = "*INITIAL CONDITIONS, TYPE=FIELD";
            report.add_unused_card(condition.span, what, "no material depends on field variables");
        }
        return None;
    }
    note_unused_variables(scene.model, most_read, report);
    let mut id = None;
    let mut steps: Vec<Arc<[NodalFieldValue]>> = Vec::new();
    for (index, step) in model.steps.iter().enumerate() {
        if index > 0 && model.steps[index - 1].fields == step.fields {
            steps.extend(steps.last().cloned());
            continue;
        }
        let mut list = Vec::new();
        for field in &step.fields {
            let nodes: Vec<usize> = field.nodes.iter().filter_map(|n| scene.places.nodes.get(n).copied()).collect();
            let detail = format!("variable {} on {}: {}", field.variable + 1, field.set, field.value);
            let row = report.ledger_row(field.span, "predefined fields", nodes.len(), "nodes", detail);
            id = id.or(Some(row));
            let magnitude = magnitude(scene, field.value, field.amplitude, report);
            list.push(NodalFieldValue { variable: field.variable, nodes, magnitude });
        }
        steps.push(list.into());
    }
    let start = fields_at_start(scene.model, scene.places, state.dofs.nodes.len());
    Some(Box::new(PredefinedFields::new(id?, start, steps, groups)))
}

/// Lists field variables from number `most` on, from 0, as unused.
fn note_unused_variables(model: &Model, most: usize, report: &mut Report) {
    let why = |variable: usize| format!("no material depends on field variable {}", variable + 1);
    for field in model.steps.iter().flat_map(|s| &s.fields).filter(|field| field.variable >= most) {
        let what = format!("*FIELD, VARIABLE={}", field.variable + 1);
        report.add_unused_card(field.span, what, why(field.variable));
    }
    for condition in &model.initial_conditions {
        if let InitialKind::Field(variable, _) = condition.kind
            && variable >= most
        {
            report.add_unused_card(condition.span, "*INITIAL CONDITIONS, TYPE=FIELD", why(variable));
        }
    }
}
