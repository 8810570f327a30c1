//! Parts, instances and the assembly. The cards of a part are read again for each instance, with its placement and
//! scope.

use super::budget::BudgetedItem;
use super::builder::ModelBuilder;
use super::context::Context;
use super::families::PartReader;
use super::names::upper;
use super::placement::read_placement;
use crate::deck::Card;

pub fn read_block<'a>(builder: &mut ModelBuilder<'a>, card: &'a Card) {
    let (context, parts) = (&mut builder.context, &mut builder.parts);
    match card.keyword.name {
        "PART" => begin_part(context, parts, card),
        "INSTANCE" => begin_instance(builder, card),
        "ASSEMBLY" => parts.open("ASSEMBLY", card),
        "END PART" => {
            parts.recording = None;
            parts.close(context, "PART", card);
        }
        "END INSTANCE" => {
            builder.mesh.placement = None;
            context.scope.clear();
            parts.close(context, "INSTANCE", card);
        }
        _ => parts.close(context, "ASSEMBLY", card),
    }
}

fn begin_part(context: &mut Context<'_>, parts: &mut PartReader<'_>, card: &Card) {
    parts.open("PART", card);
    if let Some(name) = context.required(card, "NAME") {
        let name = upper(&name.text);
        parts.cards.insert(name.clone(), Vec::new());
        parts.recording = Some(name);
    }
}

fn begin_instance<'a>(builder: &mut ModelBuilder<'a>, card: &'a Card) {
    let (context, parts) = (&mut builder.context, &mut builder.parts);
    parts.open("INSTANCE", card);
    let Some(name) = context.required(card, "NAME") else { return };
    parts.instances.insert(upper(&name.text));
    let Some(part) = card.value("PART") else { return };
    let Some(cards) = parts.cards.get(&upper(&part.text)).cloned() else {
        let mut names: Vec<String> = parts.cards.keys().cloned().collect();
        names.sort();
        return context.unknown("M115", "part", part, |_| names.clone());
    };
    let lines = cards.iter().map(|inner| inner.line_count() as u128).sum();
    if !context.fits_budget(BudgetedItem::Elements, lines, card.span) {
        return;
    }
    context.scope = upper(&name.text);
    builder.mesh.placement = read_placement(context, card);
    for inner in super::order::ordered(&cards, &context.deck.sources) {
        builder.read_card(inner);
    }
    builder.context.scope = upper(&name.text);
}
