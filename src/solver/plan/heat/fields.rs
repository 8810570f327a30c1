//! Predefined fields of the plan: initial nodal values, and `*FIELD` and `*TEMPERATURE` of each step.

use std::collections::{BTreeSet, HashSet};
use std::sync::Arc;

use crate::deck::{Diagnostic, Span};
use crate::element::group::NodalVariable;
use crate::element::predefined::{FieldGroup, NodalFieldValue, PredefinedField, PredefinedFields, StepFields, mean};
use crate::element::user_field::UserNodalField;
use crate::material::PointValue;
use crate::model::{InitialKind, MaterialDefinition, Model, PredefinedVariable, PrescribedField, ShellSection, Step};
use crate::plan::heat::initial_temperatures;
use crate::plan::loads::magnitude;
use crate::plan::queries::{dependencies, given_fields, number_of_node};
use crate::plan::solids::user_material::materials_present;
use crate::plan::state::SolidState;
use crate::plan::{Report, Scene, SolidPlaces};
use crate::state::EffectId;
use crate::variables::Variable;

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

/// Creates the values of `*FIELD` and `*TEMPERATURE`; `None` if no material depends on them.
pub fn plan(scene: Scene, state: &SolidState, report: &mut Report) -> Option<Box<PredefinedFields>> {
    let most_read = materials_present(scene).map(fields_read).max().unwrap_or(0);
    note_unused_variables(scene.model, most_read, report);
    note_unset_variables(scene, report);
    let warmed = warmed_groups(scene, state, report);
    let is_read = |variable: PredefinedVariable| match variable {
        PredefinedVariable::Temperature => !warmed.is_empty(),
        PredefinedVariable::Field(variable) => variable < most_read,
    };
    let mut id = None;
    let mut steps: Vec<Arc<StepFields>> = Vec::new();
    for (index, step) in scene.model.steps.iter().enumerate() {
        // User fields have the duration of their step.
        let continues = |previous: &Step| {
            let has_user = step.fields.iter().any(|field| field.user.is_some());
            previous.fields == step.fields && (!has_user || previous.duration == step.duration)
        };
        if index > 0 && continues(&scene.model.steps[index - 1]) {
            steps.extend(steps.last().cloned());
            continue;
        }
        let mut list = StepFields::default();
        for field in step.fields.iter().filter(|field| is_read(field.variable)) {
            let nodes: Vec<usize> = field.nodes.iter().filter_map(|n| scene.places.nodes.get(n).copied()).collect();
            if let Some(count) = field.user {
                let row = user_field_row(field, count, nodes.len(), report)?;
                id = id.or(Some(row));
                let PredefinedVariable::Field(variable) = field.variable else { continue };
                let (set, numbers) = (field.set.to_uppercase(), node_numbers(scene, &field.nodes));
                let variables = [variable, count];
                list.user.push(UserNodalField { set, variables, nodes, numbers, duration: step.duration });
                continue;
            }
            let (name, variable) = match field.variable {
                PredefinedVariable::Temperature => ("temperature".into(), NodalVariable::Temperature),
                PredefinedVariable::Field(at) => (format!("variable {}", at + 1), NodalVariable::Field(at)),
            };
            let detail = format!("{name} on {}: {}", field.set, field.value);
            let row = report.ledger_row(field.span, "predefined fields", nodes.len(), "nodes", detail);
            id = id.or(Some(row));
            let magnitude = magnitude(scene, field.value, field.amplitude, report);
            list.given.push(NodalFieldValue { variable, nodes, magnitude });
        }
        steps.push(Arc::new(list));
    }
    Some(Box::new(PredefinedFields::new(id?, fields_of_groups(scene, state, warmed), steps)))
}

/// Returns the ledger row of a field of a user subroutine; `None` if the subroutine is missing, which is an error.
fn user_field_row(field: &PrescribedField, count: usize, nodes: usize, report: &mut Report) -> Option<EffectId> {
    report.require_routine(field.span, "field", "*FIELD, USER calls vufield", "vufield")?;
    let PredefinedVariable::Field(first) = field.variable else { return None };
    let variables = match count {
        1 => format!("variable {}", first + 1),
        _ => format!("variables {} to {}", first + 1, first + count),
    };
    let detail = format!("{variables} on {} by vufield", field.set);
    Some(report.ledger_row(field.span, "predefined fields", nodes, "nodes", detail))
}

/// Returns the numbers in the deck of the mesh nodes that are solver nodes.
fn node_numbers(scene: Scene, nodes: &[usize]) -> Vec<i32> {
    let numbered = nodes.iter().filter(|n| scene.places.nodes.contains_key(n));
    numbered.map(|&n| number_of_node(scene.model, n)).collect()
}

/// Returns the temperature and the field variables with the groups of elements that have them.
fn fields_of_groups(scene: Scene, state: &SolidState, warmed: BTreeSet<usize>) -> Vec<PredefinedField> {
    let groups = &state.elements.groups;
    let with_boundaries = |group: usize| {
        let boundaries = (0..groups[group].len()).map(|e| groups[group].boundary(e)).collect();
        FieldGroup { group, boundaries }
    };
    let start = fields_at_start(scene.model, scene.places, state.dofs.nodes.len());
    let of_variable = |(variable, start): (usize, Vec<f64>)| {
        let holding = (0..groups.len()).filter(|&group| variable < groups[group].properties().fields);
        PredefinedField {
            variable: NodalVariable::Field(variable),
            start,
            groups: holding.map(with_boundaries).collect(),
        }
    };
    let temperature = (!warmed.is_empty()).then(|| PredefinedField {
        variable: NodalVariable::Temperature,
        start: initial_temperatures(scene, state),
        groups: warmed.into_iter().map(with_boundaries).collect(),
    });
    start.into_iter().enumerate().map(of_variable).chain(temperature).collect()
}

/// Returns whether all prescribed temperatures and field variables, and those at the start, have the same value at the given
/// nodes (ascending): a mesh may then move through the material.
pub fn has_uniform_fields(model: &Model, nodes: &[usize]) -> bool {
    let mut of_routine = model.steps.iter().flat_map(|step| &step.fields).filter(|field| field.user.is_some());
    if of_routine.any(|field| nodes.iter().any(|node| field.nodes.binary_search(node).is_ok())) {
        return false;
    }
    let prescribed = model.steps.iter().flat_map(|step| &step.fields).map(|field| &field.nodes);
    let is_of_nodes = |kind: &InitialKind| matches!(kind, InitialKind::Temperature(_) | InitialKind::Field(..));
    let at_start = model.initial_conditions.iter().filter(|c| is_of_nodes(&c.kind)).map(|c| &c.members);
    prescribed.chain(at_start).all(|list| {
        let members: HashSet<usize> = list.iter().copied().collect();
        let count = nodes.iter().filter(|node| members.contains(node)).count();
        count == 0 || count == nodes.len()
    })
}

/// Returns whether `*TEMPERATURE` prescribes the temperature of a node of elements.
pub fn has_prescribed_temperature(model: &Model, elements: &[usize]) -> bool {
    let prescribed = model.steps.iter().flat_map(|step| &step.fields);
    let mut lists = prescribed.filter(|f| f.variable == PredefinedVariable::Temperature).map(|f| &f.nodes);
    lists.any(|list| {
        let mut nodes = elements.iter().flat_map(|e| &model.mesh.elements[*e].nodes);
        nodes.any(|n| list.binary_search(n).is_ok())
    })
}

/// Refuses prescribed temperatures of shells that would expand.
fn refuse_warm_shells(model: &Model, at: Span, report: &mut Report) {
    let expands = |section: &&ShellSection| {
        section.layers.iter().any(|layer| model.materials[layer.material].thermal.expansion.is_some())
    };
    let mut expanding = model.shell_sections.iter().filter(expands);
    if let Some(section) = expanding.find(|section| has_prescribed_temperature(model, &section.elements)) {
        let message = "*TEMPERATURE is not supported for shells with *EXPANSION: they have no thermal strain";
        let finding = Diagnostic::error("P074", message).at(at, "here").at(section.span, "these shells");
        report.push(finding.help("model the thickness with CAX4R, or remove the temperature of the shells"));
    }
}

/// Returns the groups of elements with prescribed temperatures that depend on them, and reports those without effect.
fn warmed_groups(scene: Scene, state: &SolidState, report: &mut Report) -> BTreeSet<usize> {
    let model = scene.model;
    let cards = model.steps.iter().flat_map(|s| &s.fields).filter(|f| f.variable == PredefinedVariable::Temperature);
    let mut spans: Vec<Span> = cards.map(|field| field.span).collect();
    spans.dedup();
    let Some(first) = spans.first() else { return BTreeSet::new() };
    let solved = if model.solves_for_temperatures() {
        Some(("*DYNAMIC TEMPERATURE-DISPLACEMENT", "prescribe temperatures by *BOUNDARY on degree of freedom 11"))
    } else {
        model.is_adiabatic().then_some(("ADIABATIC", "remove ADIABATIC from *DYNAMIC, or *TEMPERATURE"))
    };
    if let Some((procedure, help)) = solved {
        let message = format!("*TEMPERATURE prescribes temperatures that a step with {procedure} computes");
        report.push(Diagnostic::error("P074", message).at(*first, "here").help(help));
        return BTreeSet::new();
    }
    let mut warmed = BTreeSet::new();
    for section in &model.sections {
        let material = &model.materials[section.material];
        let (expands, follows_energy) = (material.thermal.expansion.is_some(), material.eos.is_some());
        if follows_energy || !has_prescribed_temperature(model, &section.elements) {
            continue;
        }
        for (group, e) in section.elements.iter().filter_map(|e| scene.places.elements.get(e)) {
            let elements = &state.elements.groups[*group];
            let depends = expands || elements.value(*e, Variable::Temperature.into()).is_some();
            warmed.extend((depends && elements.is_solid()).then_some(*group));
        }
    }
    refuse_warm_shells(model, *first, report);
    if warmed.is_empty() {
        let has_eos = model.sections.iter().any(|section| {
            model.materials[section.material].eos.is_some() && has_prescribed_temperature(model, &section.elements)
        });
        let why = match has_eos {
            true => "the temperature of a material with *EOS follows from its energy",
            false => "no solid element with these nodes depends on the temperature",
        };
        spans.into_iter().for_each(|span| report.add_unused_card(span, "*TEMPERATURE", why));
    }
    warmed
}

/// Lists tables over field variables that no card sets, and field variables of user subroutines that no table depends on.
fn note_unset_variables(scene: Scene, report: &mut Report) {
    let given = given_fields(scene.model);
    for material in materials_present(scene) {
        let (depends, user) = (dependencies(material), &material.user);
        if depends > given && user.fields.is_none() {
            let why = format!("no card sets field variable {}: it is 0", given + 1);
            report.add_unused_card(material.span, format!("DEPENDENCIES of {}", material.name), why);
        }
        if let Some((_, span)) = &user.fields
            && depends == 0
            && user.material.is_none()
            && user.state.count == 0
            && !material.has_user_hardening()
        {
            let why = "no property of the material depends on field variables";
            report.add_unused_card(*span, "*USER DEFINED FIELD", why);
        }
    }
}

/// Lists field variables from number `most` on, from 0, as unused.
fn note_unused_variables(model: &Model, most: usize, report: &mut Report) {
    let why = |variable: usize| format!("no material depends on field variable {}", variable + 1);
    for field in model.steps.iter().flat_map(|s| &s.fields) {
        if let PredefinedVariable::Field(variable) = field.variable
            && variable >= most
        {
            report.add_unused_card(field.span, format!("*FIELD, VARIABLE={}", variable + 1), why(variable));
        }
    }
    for condition in &model.initial_conditions {
        if let InitialKind::Field(variable, _) = condition.kind
            && variable >= most
        {
            report.add_unused_card(condition.span, "*INITIAL CONDITIONS, TYPE=FIELD", why(variable));
        }
    }
}
