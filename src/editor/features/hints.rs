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

fn section_label(part: &PartOverview) -> String {
    let stable = part.stable_increment.map(|length| format!(", stable increment about {}", short(length)));
    format!("mass {}{}", short(part.mass), stable.unwrap_or_default())
}

fn label(context: &FeatureContext<'_>, card: &Card) -> Option<String> {
    let facts = context.root.facts?;
    let upper = |name: &str| card.value(name).map(|word| word.text.trim().to_uppercase());
    match card.keyword.name {
        "SOLID SECTION" | "SHELL SECTION" => {
            let material = upper("MATERIAL")?;
            // Sections of the same material have one name.
            let mut parts = facts.parts.iter().filter(|part| !part.rigid && part.name.eq_ignore_ascii_case(&material));
            let (first, second) = (parts.next()?, parts.next());
            second.is_none().then(|| section_label(first))
        }
        "AMPLITUDE" => facts.description(NameKind::Amplitude, &upper("NAME")?).map(str::to_owned),
        "NSET" => facts.description(NameKind::NodeSet, &upper("NSET")?).map(str::to_owned),
        "ELSET" => facts.description(NameKind::ElementSet, &upper("ELSET")?).map(str::to_owned),
        _ => None,
    }
}
