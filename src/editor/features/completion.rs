//! Completion: keywords, parameters, values and names.

use serde_json::{Value, json};

use super::FeatureContext;
use super::context::{CardContext, CardPart, card_context};
use super::facts::short;
use super::letter_case::{prefers_lower, title_case};
use crate::deck::keywords::{InputRule, InputUsage, Keyword, KeywordTier, keywords};
use crate::deck::manual::{explain_rule, explain_support};
use crate::deck::name_kinds::{NameKind, field_name_kind, parameter_name_usage};
use crate::outline::NameUse;
use crate::text::{TextPosition, TextRange};
use crate::variables::{Variable, VariableComponent, VariablePlace, manual::explain_variable};

/// Kinds of completions, as the protocol numbers them.
#[derive(Clone, Copy)]
enum ItemKind {
    Keyword = 14,
    Property = 10,
    EnumMember = 20,
    Reference = 18,
    Variable = 6,
}

/// Returns the list of completions at a position. A client with `has_range_default` receives the replaced range once.
pub fn completion_list(context: &FeatureContext<'_>, position: TextPosition, has_range_default: bool) -> Value {
    let mut items = completions(context, position);
    let mut list = json!({ "isIncomplete": false });
    if has_range_default && let Some(range) = items.first().map(|item| item["textEdit"]["range"].clone()) {
        list["itemDefaults"] = json!({ "editRange": range });
        for item in items.iter_mut().filter_map(Value::as_object_mut) {
            let text = item.shift_remove("textEdit").map(|mut edit| edit["newText"].take());
            if let Some(text) = text.filter(|text| Some(text) != item.get("label")) {
                item.insert("textEditText".into(), text);
            }
        }
    }
    list["items"] = items.into();
    list
}

fn completions(context: &FeatureContext<'_>, position: TextPosition) -> Vec<Value> {
    let line = context.text.line(position.line);
    let byte = context.encoding.byte(line, position.character);
    if line[..byte].trim() == "*" || line.trim() == "*" {
        return keyword_items(context, position, to_cursor(line, byte, position, context));
    }
    if let Some(at) = line[..byte].rfind('<').filter(|at| !line[*at..byte].contains(['>', ',', ' '])) {
        let start = context.encoding.width(&line[..at + 1]);
        let range = TextRange::on_line(position.line, start, position.character);
        return parameter_reference_items(context, range, line[byte..].starts_with('>'));
    }
    let card = card_context(context.text, position, context.encoding);
    match &card.part {
        CardPart::Keyword(range) => keyword_items(context, position, *range),
        CardPart::ParameterName(range) => parameter_items(&card, *range, prefers_lower(line)),
        CardPart::ParameterValue(index, range) => value_items(context, &card, *index, *range),
        CardPart::Field { rule: Some(rule), range } => field_items(context, &card, rule, *range),
        CardPart::Field { rule: None, .. } | CardPart::Comment => Vec::new(),
    }
}

/// Returns the range from the first character of a line to the cursor.
fn to_cursor(line: &str, byte: usize, position: TextPosition, context: &FeatureContext<'_>) -> TextRange {
    let start = line[..byte].find('*').unwrap_or(byte);
    TextRange::on_line(position.line, context.encoding.width(&line[..start]), position.character)
}

fn item(label: &str, kind: ItemKind, range: TextRange, new_text: &str, detail: &str, rank: u8) -> Value {
    let mut item = json!({
        "label": label,
        "kind": kind as u8,
        "detail": detail,
        "sortText": format!("{rank}{label}"),
        "textEdit": { "range": range, "newText": new_text },
    });
    // Clients filter by the label without regard to case.
    if !label.eq_ignore_ascii_case(new_text) {
        item["filterText"] = new_text.into();
    }
    item
}

fn keyword_items(context: &FeatureContext<'_>, position: TextPosition, range: TextRange) -> Vec<Value> {
    // The style of the line, or of the keyword before it.
    let line = context.text.line(position.line);
    let style = if line.chars().any(char::is_alphabetic) {
        line
    } else {
        let previous_keyword = position.line.checked_sub(1).and_then(|line| context.text.keyword_line_at(line));
        previous_keyword.map_or("", |line| context.text.line(line))
    };
    let lower = prefers_lower(style);
    let rank = |keyword: &Keyword| match keyword.tier {
        KeywordTier::Used => 0,
        KeywordTier::Inert(_) | KeywordTier::OutputOnly | KeywordTier::UnsupportedInert => 1,
        KeywordTier::UnsupportedPhysics => 2,
    };
    let keyword_item = |keyword: &'static Keyword| {
        let name = format!("*{}", keyword.name);
        let written = if lower { title_case(&name) } else { name.clone() };
        item(&name, ItemKind::Keyword, range, &written, keyword.summary, rank(keyword))
    };
    keywords().map(keyword_item).collect()
}

/// Adds the documentation to the completion of a keyword, of which the client shows the summary already.
pub fn resolved_item(mut item: Value) -> Value {
    let name = item["label"].as_str().and_then(|label| label.strip_prefix('*')).unwrap_or_default();
    if let Some(keyword) = keywords().find(|keyword| keyword.name == name) {
        item["documentation"] = explain_support(keyword).into();
    }
    item
}

fn parameter_items(card: &CardContext, range: TextRange, lower: bool) -> Vec<Value> {
    let Some(keyword) = card.keyword else { return Vec::new() };
    let is_given = |rule: &InputRule| {
        let others = card.parameters.iter().filter(|p| p.name_range != range);
        others.filter_map(|p| p.rule).any(|given| given.name == rule.name)
    };
    let supported = |rule: &&InputRule| !matches!(rule.usage, InputUsage::Refused(_)) && !is_given(rule);
    let parameter_item = |rule: &'static InputRule| {
        let name = if lower { rule.name.to_lowercase() } else { rule.name.to_owned() };
        let written = if rule.value.bare.is_some() { name } else { name + "=" };
        let rank = if rule.usage == InputUsage::Read { u8::from(!rule.value.required) } else { 2 };
        item(rule.name, ItemKind::Property, range, &written, &explain_rule(rule), rank)
    };
    keyword.parameters.iter().filter(supported).map(parameter_item).collect()
}

fn value_items(context: &FeatureContext<'_>, card: &CardContext, index: usize, range: TextRange) -> Vec<Value> {
    let parameter = card.parameters.get(index).and_then(|p| p.rule);
    let (Some(keyword), Some(rule)) = (card.keyword, parameter) else { return Vec::new() };
    let usage = parameter_name_usage(keyword, rule);
    let names = usage.map_or_else(Vec::new, |usage| name_items(context, usage.kind, range));
    let words = rule.value.words().into_iter().flatten().copied();
    let only = match rule.usage {
        InputUsage::Only(values, _) => values,
        _ => &[],
    };
    // Values that select the layout of the data lines, such as element types.
    let layouts = keyword
        .data
        .iter()
        .filter_map(|data| data.when)
        .filter(|(name, _)| *name == rule.name && rule.value.words().is_none());
    let layouts = layouts.flat_map(|(_, values)| values.iter().copied());
    let words = words.chain(only.iter().copied()).chain(layouts);
    words.map(|word| item(word, ItemKind::EnumMember, range, word, rule.help, 0)).chain(names).collect()
}

fn field_items(
    context: &FeatureContext<'_>,
    card: &CardContext,
    rule: &'static InputRule,
    range: TextRange,
) -> Vec<Value> {
    let names = field_name_kind(rule).map_or_else(Vec::new, |kind| name_items(context, kind, range));
    let words = rule.value.words().into_iter().flatten();
    let words = words.map(|word| item(word, ItemKind::EnumMember, range, word, rule.help, 0));
    let variables = variable_places(card.keyword.map_or("", |k| k.name), rule).iter().flat_map(|place| {
        let placed_variables = Variable::ALL.iter().filter(move |variable| variable.place() == *place);
        placed_variables.flat_map(move |variable| {
            variable_words(*variable).into_iter().map(move |word| variable_item(&word, range))
        })
    });
    names.into_iter().chain(words).chain(variables).collect()
}

/// Returns the name of a variable and those of its components, as far as they can be requested.
fn variable_words(variable: Variable) -> Vec<String> {
    let mut words = vec![variable.name().to_owned()];
    let labels = variable.parts().map(|part| part.label());
    words.extend(labels.filter(|label| label != variable.name() && VariableComponent::parse(label).is_some()));
    words
}

fn variable_item(name: &str, range: TextRange) -> Value {
    let about = explain_variable(name).unwrap_or_default();
    item(name, ItemKind::Variable, range, name, about.lines().next().unwrap_or_default(), 0)
}

/// Returns the places of the variables that a field requests.
fn variable_places(keyword: &str, rule: &InputRule) -> &'static [VariablePlace] {
    match (keyword, rule.name) {
        ("NODE OUTPUT", _) => &[VariablePlace::Node],
        ("ELEMENT OUTPUT", _) => &[VariablePlace::Point, VariablePlace::Element],
        ("CONTACT OUTPUT", _) => &[VariablePlace::Pair],
        ("INCREMENTATION OUTPUT", _) => &[VariablePlace::Increment],
        ("INTEGRATED OUTPUT", _) => &[VariablePlace::Section],
        ("ENERGY OUTPUT", _) => &[VariablePlace::Energy, VariablePlace::Part],
        _ => &[],
    }
}

/// Returns the parameters of the deck, with the closing bracket unless it is written.
fn parameter_reference_items(context: &FeatureContext<'_>, range: TextRange, is_closed: bool) -> Vec<Value> {
    let reference_item = |one: &NameUse| {
        let written = if is_closed { one.name.clone() } else { format!("{}>", one.name) };
        let value = context.parameter_value(one).map(|value| format!(": {}", short(value)));
        let detail = format!("parameter{}", value.unwrap_or_default());
        item(&one.name, ItemKind::Variable, range, &written, &detail, 0)
    };
    context.root.outline.names.defined(NameKind::Parameter).into_iter().map(reference_item).collect()
}

fn name_items(context: &FeatureContext<'_>, kind: NameKind, range: TextRange) -> Vec<Value> {
    let outline = &context.root.outline;
    let scope = context.scope_at(range.start.line);
    let item_of = |one: &NameUse| {
        let name = outline.deck.sources.text(one.span).trim();
        let name = if name.contains(',') { format!("\"{name}\"") } else { name.to_owned() };
        let qualified = match context.instance_of(&one.scope) {
            Some(instance) if scope.is_empty() && kind.is_scoped() => format!("{instance}.{name}"),
            _ => name,
        };
        let about = context.root.facts.and_then(|facts| facts.description(kind, &one.name));
        let detail = format!("{}{}", kind.words(), about.map_or(String::new(), |text| format!(": {text}")));
        item(&qualified, ItemKind::Reference, range, &qualified, &detail, 0)
    };
    let visible = |one: &&NameUse| scope.is_empty() || one.scope == scope || !kind.is_scoped();
    outline.names.defined(kind).into_iter().filter(visible).map(item_of).collect()
}
