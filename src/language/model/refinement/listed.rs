//! Conditions that are listed node by node. New nodes between listed nodes get the interpolated value.

use crate::model::context::Context;
use crate::model::families::StepReader;
use std::hash::Hash;

use indexmap::IndexMap;

use super::mesh::RefinedMesh;
use crate::deck::{Diagnostic, Span, Word};
use crate::kernel::lists::sorted_unique;
use crate::model::types::{BoundaryCondition, InitialCondition, InitialKind, PredefinedVariable, PrescribedField};

/// Nodes of the deck with their values, in the order of the deck.
type NodeValues = IndexMap<usize, f64>;

/// Returns whether the region of a condition is a node label, `12` or `INSTANCE.12`.
fn is_label(region: &str) -> bool {
    region.trim().rsplit('.').next().is_some_and(|label| label.parse::<i64>().is_ok())
}

/// Returns the values of new nodes between nodes with values: each value with its nodes, ascending.
fn between(context: &Context<'_>, listed: &NodeValues) -> Vec<(f64, Vec<usize>)> {
    let Some(refined) = &context.scaling.refined else { return Vec::new() };
    let nodes: Vec<usize> = listed.keys().copied().collect();
    let mut nodes_by_value: IndexMap<u64, Vec<usize>> = IndexMap::new();
    for node in refined.selection(&nodes).nodes(refined) {
        let weights = refined.weights(node).map(|(n, weight)| (listed.get(&n).copied().unwrap_or(0.0), weight));
        let first = weights[0].0;
        let value = first + weights.iter().map(|(value, weight)| weight * (value - first)).sum::<f64>();
        nodes_by_value.entry(value.to_bits()).or_default().push(node);
    }
    nodes_by_value.into_iter().map(|(bits, nodes)| (f64::from_bits(bits), sorted_unique(nodes))).collect()
}

/// A condition at a single node. Conditions with the same key belong together.
struct ListedValue<K> {
    key: K,
    node: usize,
    value: f64,
}

/// Returns conditions for new nodes from conditions at single nodes.
fn completed<C: Clone, K: Hash + Eq>(
    context: &Context<'_>,
    conditions: &[C],
    of: impl Fn(&C) -> Option<ListedValue<K>>,
    with: impl Fn(&mut C, Vec<usize>, f64),
) -> Vec<C> {
    let mut groups: IndexMap<K, (&C, NodeValues)> = IndexMap::new();
    for condition in conditions {
        let Some(ListedValue { key, node, value }) = of(condition) else { continue };
        groups.entry(key).or_insert((condition, NodeValues::new())).1.insert(node, value);
    }
    let mut made = Vec::new();
    for (like, listed) in groups.into_values().filter(|(_, listed)| listed.len() > 1) {
        for (value, nodes) in between(context, &listed) {
            let mut condition = like.clone();
            with(&mut condition, nodes, value);
            made.push(condition);
        }
    }
    made
}

/// Completes the boundary conditions of a card, which are those from index `from` on.
pub fn complete_boundaries(context: &mut Context<'_>, steps: &mut StepReader, from: usize) {
    if context.scaling.refined.is_none() {
        return;
    }
    let listed_value = |b: &BoundaryCondition| {
        let node = is_label(&b.set).then(|| b.nodes[0])?;
        Some(ListedValue { key: (b.dof, b.kind, b.user, b.amplitude), node, value: b.value })
    };
    let with = |b: &mut BoundaryCondition, nodes, value| (b.nodes, b.value) = (nodes, value);
    let listed = steps.state().boundaries[from..].to_vec();
    let made = completed(context, &listed, listed_value, with);
    for b in &made {
        context.add_node_line(
            listed[listed.len() - 1].span,
            &b.nodes,
            &format!(" {}, {}, {:?}", b.dof, b.dof, b.value),
        );
    }
    steps.state().boundaries.extend(made);
}

/// Completes the prescribed fields of a step, given by nodes and by sets.
pub fn complete_fields(context: &mut Context<'_>, fields: &mut Vec<PrescribedField>) {
    let Some(refined) = &context.scaling.refined else { return };
    match fields_between(refined, fields) {
        Ok(single) => {
            let made = merged_by_value(single);
            for field in &made {
                context.add_node_line(field.span, &field.nodes, &format!(" {:?}", field.value));
            }
            fields.extend(made);
        }
        Err(finding) => context.diagnostics.push(*finding),
    }
}

/// Returns the interpolated values of new nodes between nodes with values.
///
/// # Errors
/// If new nodes are between nodes whose values have different amplitudes.
fn fields_between(refined: &RefinedMesh, fields: &[PrescribedField]) -> Result<Vec<PrescribedField>, Box<Diagnostic>> {
    let mut variables: IndexMap<PredefinedVariable, IndexMap<usize, &PrescribedField>> = IndexMap::new();
    for field in fields {
        let values = variables.entry(field.variable).or_default();
        values.extend(field.nodes.iter().map(|node| (*node, field)));
    }
    let mut made: Vec<PrescribedField> = Vec::new();
    for given in variables.values() {
        let nodes: Vec<usize> = given.keys().copied().collect();
        for node in refined.selection(&nodes).nodes(refined).into_iter().filter(|node| !given.contains_key(node)) {
            let parents = refined.weights(node).map(|(parent, weight)| (given[&parent], weight));
            let like = parents[0].0;
            if let Some((other, _)) = parents.iter().find(|(parent, _)| parent.amplitude != like.amplitude) {
                let message = "new nodes of the refined mesh are between nodes whose values have different amplitudes";
                let finding =
                    Diagnostic::error("M190", message).at(like.span, "this value").at(other.span, "and this one");
                return Err(Box::new(finding.help("give one amplitude, or sets whose elements share no nodes")));
            }
            let change: f64 = parents.iter().map(|(parent, weight)| weight * (parent.value - like.value)).sum();
            made.push(PrescribedField { nodes: vec![node], value: like.value + change, ..like.clone() });
        }
    }
    Ok(made)
}

/// Returns fields of single nodes with one entry for all nodes that have the same value.
fn merged_by_value(single: Vec<PrescribedField>) -> Vec<PrescribedField> {
    let mut merged: IndexMap<(PredefinedVariable, Span, u64), PrescribedField> = IndexMap::new();
    for field in single {
        let key = (field.variable, field.span, field.value.to_bits());
        match merged.get_mut(&key) {
            Some(same) => same.nodes.extend(field.nodes),
            None => drop(merged.insert(key, field)),
        }
    }
    let sorted =
        |field: PrescribedField| PrescribedField { nodes: sorted_unique(field.nodes.iter().copied()), ..field };
    merged.into_values().map(sorted).collect()
}

/// Completes the initial conditions of a card at nodes.
pub fn complete_initial_conditions(context: &mut Context<'_>, from: usize) {
    if context.scaling.refined.is_none() {
        return;
    }
    let sources = context.deck.sources.clone();
    let listed_value = |c: &InitialCondition| {
        let (key, value) = match c.kind {
            InitialKind::Velocity(dof, value) => ((0, usize::from(dof)), value),
            InitialKind::Temperature(value) => ((1, 0), value),
            InitialKind::Field(variable, value) => ((2, variable), value),
            _ => return None,
        };
        let region = sources.text(c.span).split(',').next().unwrap_or_default();
        is_label(region).then(|| ListedValue { key, node: c.members[0], value })
    };
    let with = |c: &mut InitialCondition, nodes, value: f64| {
        c.members = nodes;
        match &mut c.kind {
            InitialKind::Velocity(_, given) | InitialKind::Temperature(given) | InitialKind::Field(_, given) => {
                *given = value;
            }
            _ => {}
        }
    };
    let made = completed(context, &context.model.initial_conditions[from..], listed_value, with);
    let last = context.model.initial_conditions.last().map_or(Span::default(), |c| c.span);
    for condition in &made {
        let values = match condition.kind {
            InitialKind::Velocity(dof, value) => format!(" {dof}, {value:?}"),
            InitialKind::Temperature(value) | InitialKind::Field(_, value) => format!(" {value:?}"),
            _ => continue,
        };
        context.add_node_line(last, &condition.members, &values);
    }
    context.model.initial_conditions.extend(made);
}

/// Returns the new nodes between the nodes that lines list by labels.
pub fn between_labels<'w>(context: &mut Context<'_>, words: impl Iterator<Item = &'w Word>) -> Vec<usize> {
    let labels = words.filter(|word| is_label(&word.text));
    let listed: Vec<usize> = labels.filter_map(|word| context.nodes.resolve(&context.scope, word)).collect();
    context.scaling.refined.as_ref().map_or_else(Vec::new, |refined| refined.selection(&listed).nodes(refined))
}
