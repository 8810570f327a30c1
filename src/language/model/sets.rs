//! `*NSET` and `*ELSET`. A set that is defined again is extended.

use indexmap::IndexMap;

use super::budget::BudgetedItem;
use super::context::Context;
use super::families::{MeshReader, PartReader};
use super::names::{SetKind, qualified, upper};
use super::refinement::pass::ReadPass;
use super::types::{MemberSet, Model};
use crate::deck::rows::words;
use crate::deck::{Card, DataLine, Span};

pub fn read_nset(context: &mut Context<'_>, parts: &mut PartReader<'_>, mesh: &mut MeshReader, card: &Card) {
    let Some(name) = context.required(card, "NSET") else { return };
    let outer = enter_instance(context, parts, card);
    let mut members = members(context, card, SetKind::Nodes);
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
    let key = qualified(&context.scope, &name.text);
    if mesh.derived_node_sets.remove(&key) {
        context.model.node_sets.shift_remove(&key);
    }
    add_set(context, SetKind::Nodes, &name.text, members, card.span);
}

pub fn read_elset(context: &mut Context<'_>, parts: &mut PartReader<'_>, card: &Card) {
    let Some(name) = context.required(card, "ELSET") else { return };
    let outer = enter_instance(context, parts, card);
    let members = members(context, card, SetKind::Elements);
    context.scope = outer;
    add_set(context, SetKind::Elements, &name.text, members, card.span);
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

fn members(context: &mut Context<'_>, card: &Card, kind: SetKind) -> Vec<usize> {
    let mut members = Vec::new();
    let sources = &context.deck.sources;
    let mut name = String::new();
    for row in &card.rows {
        if card.has("GENERATE") {
            generated(context, &row.line(sources), kind, &mut members);
            continue;
        }
        let count_before = members.len();
        if row.text(sources).is_some_and(|text| labels(context, text, kind, &mut name, &mut members)) {
            continue;
        }
        members.truncate(count_before);
        for word in row.line(sources).fields.iter().filter(|w| !w.text.is_empty()) {
            members.extend(context.members(kind, word).unwrap_or_default());
        }
    }
    members
}

/// Adds the labels of a line to a set; `false` if the line also has set names. `name` is a buffer.
fn labels(context: &Context<'_>, text: &str, kind: SetKind, name: &mut String, members: &mut Vec<usize>) -> bool {
    let sets = sets_of(&context.model, kind);
    let Some(scope) = context.labels(kind).scope(&context.scope) else { return false };
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

fn generated(context: &mut Context<'_>, line: &DataLine, kind: SetKind, members: &mut Vec<usize>) {
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
    let count_before = members.len();
    let labels = context.labels(kind);
    members.extend((0..count.max(0)).filter_map(|i| labels.find(&context.scope, first + step * i as i64)));
    let (what, is_lost) = match kind {
        SetKind::Nodes => ("nodes", context.missing.nodes),
        SetKind::Elements => ("elements", context.missing.elements),
    };
    if is_lost || context.missing.everything {
        return;
    }
    let missing = count.max(0) - (members.len() - count_before) as i128;
    if members.len() == count_before {
        let message = format!("no label from {first} to {last} in increments of {step} is defined");
        context.error("M110", message, line.span, "empty range");
    } else if missing > 0 || (last - first) % step != 0 {
        let message = match missing {
            0 => format!("{last} is not reached from {first} in increments of {step}"),
            _ => format!(
                "{missing} of the {count} {what} from {first} to {last} in increments of {step} are not defined"
            ),
        };
        let help = "give existing first and last labels";
        context.warning("M166", message, line.span, "the set has the other members", help);
    }
}

/// Adds members to the set that a parameter of a card names.
pub fn collect(context: &mut Context<'_>, kind: SetKind, card: &Card, parameter: &str, members: Vec<usize>) {
    if let Some(name) = card.value(parameter) {
        add_set(context, kind, &name.text, members, card.span);
    }
}

/// Adds members to a set of the current scope.
pub fn add_set(context: &mut Context<'_>, kind: SetKind, name: &str, members: Vec<usize>, span: Span) {
    let name = qualified(&context.scope, name);
    let sets = sets_mut(&mut context.model, kind);
    unite(sets.entry(name).or_insert_with(|| MemberSet { members: Vec::new(), span }), members);
}

/// Returns the sets of a kind.
pub fn sets_of(model: &Model, kind: SetKind) -> &IndexMap<String, MemberSet> {
    match kind {
        SetKind::Nodes => &model.node_sets,
        SetKind::Elements => &model.element_sets,
    }
}

/// Returns the sets of a kind for changes.
pub fn sets_mut(model: &mut Model, kind: SetKind) -> &mut IndexMap<String, MemberSet> {
    match kind {
        SetKind::Nodes => &mut model.node_sets,
        SetKind::Elements => &mut model.element_sets,
    }
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
