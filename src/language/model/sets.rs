//! `*NSET` and `*ELSET`. A set that is defined again is extended.

use super::budget::BudgetedItem;
use super::context::Context;
use super::families::{MeshReader, PartReader};
use super::names::{qualified, upper};
use super::refinement::pass::ReadPass;
use super::types::MemberSet;
use crate::deck::rows::words;
use crate::deck::{Card, DataLine, Diagnostic, Span};

pub fn read_nset(context: &mut Context<'_>, parts: &mut PartReader<'_>, mesh: &mut MeshReader, card: &Card) {
    let Some(name) = context.required(card, "NSET") else { return };
    let outer = enter_instance(context, parts, card);
    let mut members = members(context, card, true);
    if let Some(elements) = card.value("ELSET") {
        let elements = context.element_members(elements).unwrap_or_default();
        members.extend(elements.iter().flat_map(|&element| &context.model.mesh.elements[element].nodes));
        if context.scaling.pass == ReadPass::Mesh {
            context.scaling.regions.push((qualified(&outer, &name.text), elements));
        }
    }
    context.scope = outer;
    if card.has("UNSORTED") || mesh.unsorted.contains_key(&qualified(&context.scope, &name.text)) {
        mesh.unsorted.entry(qualified(&context.scope, &name.text)).or_default().extend(&members);
    }
    add_node_set(context, &name.text, members, card.span);
}

pub fn read_elset(context: &mut Context<'_>, parts: &mut PartReader<'_>, card: &Card) {
    let Some(name) = context.required(card, "ELSET") else { return };
    let outer = enter_instance(context, parts, card);
    let members = members(context, card, false);
    context.scope = outer;
    add_element_set(context, &name.text, members, card.span);
}

/// Enters the scope of `INSTANCE=` and returns the previous scope.
fn enter_instance(context: &mut Context<'_>, parts: &mut PartReader<'_>, card: &Card) -> String {
    if let Some(word) = card.value("INSTANCE").filter(|word| !parts.instances.contains(&upper(&word.text))) {
        let word = word.clone();
        context.unknown("M115", "instance", &word, |_| parts.instances.iter().cloned().collect());
    }
    let inner = card.value("INSTANCE").map_or_else(|| context.scope.clone(), |w| upper(&w.text));
    std::mem::replace(&mut context.scope, inner)
}

fn members(context: &mut Context<'_>, card: &Card, nodes: bool) -> Vec<usize> {
    let mut members = Vec::new();
    let sources = &context.deck.sources;
    let mut name = String::new();
    for row in &card.rows {
        if card.has("GENERATE") {
            generated(context, &row.line(sources), nodes, &mut members);
            continue;
        }
        let count_before = members.len();
        if row.text(sources).is_some_and(|text| labels(context, text, nodes, &mut name, &mut members)) {
            continue;
        }
        members.truncate(count_before);
        for word in row.line(sources).fields.iter().filter(|w| !w.text.is_empty()) {
            let listed = if nodes { context.node_members(word) } else { context.element_members(word) };
            members.extend(listed.unwrap_or_default());
        }
    }
    members
}

/// Adds the labels of a line to a set; `false` if the line also has set names. `name` is a buffer.
fn labels(context: &Context<'_>, text: &str, nodes: bool, name: &mut String, members: &mut Vec<usize>) -> bool {
    let (labels, sets) = match nodes {
        true => (&context.nodes, &context.model.node_sets),
        false => (&context.elements, &context.model.element_sets),
    };
    let Some(scope) = labels.scope(&context.scope) else { return false };
    let is_set = |word: &str, name: &mut String| {
        name.clear();
        name.extend([&context.scope, ".", word]);
        sets.contains_key(word) || !context.scope.is_empty() && sets.contains_key(name)
    };
    words(text).all(|word| {
        let member = word.parse().ok().and_then(|label| scope.find(label)).filter(|_| !is_set(word, name));
        members.extend(member);
        member.is_some()
    })
}

fn generated(context: &mut Context<'_>, line: &DataLine, nodes: bool, members: &mut Vec<usize>) {
    let (Some(first), Some(last)) =
        (context.integer(line, 0, "the first label"), context.integer(line, 1, "the last label"))
    else {
        return;
    };
    let step = line.field(2).map_or(Some(1), |w| w.integer(&mut context.diagnostics));
    let Some(step) = step.filter(|s| *s > 0) else {
        return context.out_of_range(line.span, "the increment must be a positive integer");
    };
    let count = (i128::from(last) - i128::from(first)) / i128::from(step) + 1;
    if !context.fits_budget(BudgetedItem::Members, count.max(0).unsigned_abs(), line.span) {
        return;
    }
    let labels = if nodes { &context.nodes } else { &context.elements };
    let count_before = members.len();
    let lost = context.missing.everything || if nodes { context.missing.nodes } else { context.missing.elements };
    members.extend((0..count.max(0)).filter_map(|i| labels.find(&context.scope, first + step * i as i64)));
    if lost {
        return;
    }
    let missing = count.max(0) - (members.len() - count_before) as i128;
    if members.len() == count_before {
        let message = format!("no label from {first} to {last} in increments of {step} is defined");
        context.error("M110", message, line.span, "empty range");
    } else if missing > 0 || (last - first) % step != 0 {
        let what = if nodes { "nodes" } else { "elements" };
        let message = match missing {
            0 => format!("{last} is not reached from {first} in increments of {step}"),
            _ => {
                format!(
                    "{missing} of the {count} {what} from {first} to {last} in increments of {step} are not defined"
                )
            }
        };
        let diagnostic = Diagnostic::warning("M166", message).at(line.span, "the set has the other members");
        context.diagnostics.push(diagnostic.help("give existing first and last labels"));
    }
}

pub fn add_node_set(context: &mut Context<'_>, name: &str, members: Vec<usize>, span: Span) {
    let name = qualified(&context.scope, name);
    unite(context.model.node_sets.entry(name).or_insert_with(|| MemberSet { members: Vec::new(), span }), members);
}

/// Adds nodes to the set that a parameter of a card names.
pub fn collect_nodes(context: &mut Context<'_>, card: &Card, parameter: &str, nodes: Vec<usize>) {
    if let Some(name) = card.value(parameter) {
        add_node_set(context, &name.text, nodes, card.span);
    }
}

/// Adds elements to the set that a parameter of a card names.
pub fn collect_elements(context: &mut Context<'_>, card: &Card, parameter: &str, elements: Vec<usize>) {
    if let Some(name) = card.value(parameter) {
        add_element_set(context, &name.text, elements, card.span);
    }
}

pub fn add_element_set(context: &mut Context<'_>, name: &str, members: Vec<usize>, span: Span) {
    let name = qualified(&context.scope, name);
    unite(context.model.element_sets.entry(name).or_insert_with(|| MemberSet { members: Vec::new(), span }), members);
}

/// Adds members; cards that extend a set in ascending order cost no sorting of the members before.
fn unite(set: &mut MemberSet, members: Vec<usize>) {
    let last = set.members.last().copied();
    let continues =
        members.is_sorted_by(|a, b| a < b) && last.is_none_or(|last| members.first().is_none_or(|m| *m > last));
    set.members.extend(members);
    if !continues {
        set.members.sort_unstable();
        set.members.dedup();
    }
}
