//! Inlay hints: masses and stable time increments of sections, members of sets, and totals of amplitudes.

use serde_json::{Value, json};

use super::FeatureContext;
use super::facts::short;
use crate::deck::Card;
use crate::deck::name_kinds::NameKind;
use crate::overview::PartOverview;
use crate::text::{TextPosition, TextRange};

/// Explanation of the stable time increment.
const STABLE: &str = "Smallest stable time increment of single elements of this section at the start. A run uses the smallest \
                      one of all sections times its scale factor. The estimate of the whole model can make it longer, and \
                      contact, loads or damping can make it shorter.";

/// Returns the hints in a range.
pub fn inlay_hints(context: &FeatureContext<'_>, range: TextRange) -> Vec<Value> {
    let lines = range.start.line..=range.end.line;
    let cards = context.cards().filter(|(line, _)| lines.contains(line));
    cards.filter_map(|(line, card)| Some(hint(context, line, &label(context, card)?))).collect()
}

fn hint(context: &FeatureContext<'_>, line: u32, label: &str) -> Value {
    let character = context.encoding.width(context.text.line(line).trim_end());
    let mut hint = json!({ "position": TextPosition { line, character }, "label": label, "paddingLeft": true });
    if label.contains("stable") {
        hint["tooltip"] = STABLE.into();
    }
    hint
}

fn section_label(part: &PartOverview, has_estimate: bool) -> String {
    let relation = if has_estimate { "\u{2265}" } else { "about" };
    // VS Code shows 43 characters of a line.
    let stable = part.stable_increment.map(|length| format!(", stable dt {relation} {}", short(length)));
    format!("mass {}{}", short(part.mass), stable.unwrap_or_default())
}

/// Returns the part of a section. Sections of the same material have one name, and are in the order of the deck; a part
/// with several instances has one for each.
fn part_of_section<'a>(
    context: &FeatureContext<'_>,
    card: &Card,
    parts: &'a [PartOverview],
) -> Option<&'a PartOverview> {
    let material = |card: &Card| card.value("MATERIAL").map(|word| word.text.trim().to_uppercase());
    let name = material(card)?;
    let alike = |other: &&Card| other.keyword.name == card.keyword.name && material(other).as_ref() == Some(&name);
    let cards: Vec<&Card> = context.root.outline.deck.cards.iter().filter(alike).collect();
    let is_shell = card.keyword.name == "SHELL SECTION";
    let belongs = |part: &&PartOverview| {
        !part.rigid && part.name.eq_ignore_ascii_case(&name) && part.elements.contains_key("SAX1") == is_shell
    };
    let parts: Vec<&PartOverview> = parts.iter().filter(belongs).collect();
    let index = cards.iter().position(|other| other.span == card.span)?;
    parts.get(index).copied().filter(|_| parts.len() == cards.len())
}

fn label(context: &FeatureContext<'_>, card: &Card) -> Option<String> {
    let facts = context.root.facts?;
    let upper = |name: &str| card.value(name).map(|word| word.text.trim().to_uppercase());
    match card.keyword.name {
        "SOLID SECTION" | "SHELL SECTION" => {
            part_of_section(context, card, &facts.parts).map(|part| section_label(part, facts.has_estimate))
        }
        "AMPLITUDE" => facts.description(NameKind::Amplitude, &upper("NAME")?).map(str::to_owned),
        "NSET" => facts.description(NameKind::NodeSet, &upper("NSET")?).map(str::to_owned),
        "ELSET" => facts.description(NameKind::ElementSet, &upper("ELSET")?).map(str::to_owned),
        _ => None,
    }
}
