//! Documentation of the word at a position.

use super::FeatureContext;
use super::context::{CardPart, card_context};
use super::facts::short;
use crate::deck::keywords::InputRule;
use crate::deck::manual::{explain_keyword_as_markdown, explain_rule};
use crate::outline::NameUse;
use crate::text::{TextPosition, TextRange};
use crate::variables::manual::explain_variable;

/// Returns the documentation of a position as Markdown, and the range of its word; `None` after the end of a line.
pub fn hover(context: &FeatureContext<'_>, position: TextPosition) -> Option<(String, TextRange)> {
    if position.character > context.encoding.width(context.text.line(position.line).trim_end()) {
        return None;
    }
    let card = card_context(context.text, position, context.encoding);
    let keyword = card.keyword;
    let (text, range) = match card.part {
        CardPart::Keyword(range) => (explain_keyword_as_markdown(keyword?), range),
        CardPart::ParameterName(range) => {
            let parameter = card.parameters.iter().find(|p| p.name_range == range)?;
            (rule_text(keyword?.name, parameter.rule?), range)
        }
        CardPart::ParameterValue(index, range) => {
            let rule = card.parameters.get(index)?.rule?;
            (with_name(context, position, rule_text(keyword?.name, rule)), range)
        }
        CardPart::Field { rule, range } => {
            let rule = rule?;
            let text = with_name(context, position, rule_text(keyword?.name, rule));
            let word = word_at(context, range);
            let variable = rule.name.ends_with("variable").then(|| explain_variable(&word)).flatten();
            (variable.map_or(text.clone(), |about| format!("{text}\n\n{}", as_markdown(&about))), range)
        }
        CardPart::Comment => return None,
    };
    Some((text, range))
}

fn word_at(context: &FeatureContext<'_>, range: TextRange) -> String {
    let line = context.text.line(range.start.line);
    let bytes = |column| context.encoding.byte(line, column);
    line[bytes(range.start.character)..bytes(range.end.character)].trim_matches('"').to_owned()
}

/// Writes paragraphs, and lines that are indented as a list.
fn as_markdown(text: &str) -> String {
    let line = |line: &str| line.strip_prefix("  ").map_or(format!("\n{line}\n"), |item| format!("- {item}\n"));
    escaped(&text.lines().map(line).collect::<String>())
}

/// Marks characters that Markdown would read as HTML or emphasis.
fn escaped(text: &str) -> String {
    text.replace('<', "\\<").replace('*', "\\*")
}

fn rule_text(keyword: &str, rule: &InputRule) -> String {
    format!("**\\*{keyword}**, `{}`: {}", rule.name, escaped(&explain_rule(rule)))
}

/// Adds the description of the name at a position.
fn with_name(context: &FeatureContext<'_>, position: TextPosition, text: String) -> String {
    match context.name_at(position).and_then(|one| name_text(context, one)) {
        Some(about) => format!("{about}\n\n{text}"),
        None => text,
    }
}

fn name_text(context: &FeatureContext<'_>, one: &NameUse) -> Option<String> {
    let outline = &context.root.outline;
    let defined = outline.names.same_as(one).find(|u| u.defines);
    let value = context.parameter_value(one).map(|value| format!("value {}", short(value)));
    let about = context.root.facts.and_then(|facts| facts.description(one.kind, &one.name)).map(str::to_owned);
    let about = value.or(about);
    let definition_place = defined.and_then(|u| outline.locate(u.span, context.encoding)).map(|(path, range)| {
        let file = path.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned());
        format!("defined in {file}, line {}", range.start.line + 1)
    });
    let parts: Vec<&str> = [about.as_deref(), definition_place.as_deref()].into_iter().flatten().collect();
    let text = if parts.is_empty() { "not defined in this deck".to_owned() } else { parts.join("; ") };
    Some(format!("**{}** ({}): {text}", one.name.replace('*', "\\*"), one.kind.words()))
}
