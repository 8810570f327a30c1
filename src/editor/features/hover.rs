//! Documentation of the word at a position.

use super::FeatureContext;
use super::context::{CardPart, card_context};
use super::facts::short;
use crate::deck::keywords::InputRule;
use crate::deck::manual::{explain_keyword_briefly, explain_rule};
use crate::outline::NameUse;
use crate::text::{TextPosition, TextRange};

/// Returns the documentation of a position as Markdown, and the range of its word.
pub fn hover(context: &FeatureContext<'_>, position: TextPosition) -> Option<(String, TextRange)> {
    let card = card_context(context.text, position, context.encoding);
    let keyword = card.keyword;
    let (text, range) = match card.part {
        CardPart::Keyword(range) => {
            let keyword = keyword?;
            let full =
                (context.explain)(&format!("*{}", keyword.name)).unwrap_or_else(|| explain_keyword_briefly(keyword));
            (as_block(&full), range)
        }
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
            let variable = rule.name.ends_with("variable").then(|| (context.explain)(&word)).flatten();
            (variable.map_or(text.clone(), |about| format!("{text}\n\n{}", as_block(&about))), range)
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

fn as_block(text: &str) -> String {
    format!("```text\n{}\n```", text.trim_end())
}

fn rule_text(keyword: &str, rule: &InputRule) -> String {
    // Text in angle brackets must not be read as HTML.
    format!("**\\*{keyword}**: {}", explain_rule(rule).replace('<', "\\<").replace('*', "\\*"))
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
    let place = defined.and_then(|u| outline.locate(u.span, context.encoding)).map(|(path, range)| {
        let file = path.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned());
        format!("defined in {file}, line {}", range.start.line + 1)
    });
    let parts: Vec<&str> = [about.as_deref(), place.as_deref()].into_iter().flatten().collect();
    let text = if parts.is_empty() { "not defined in this deck".to_owned() } else { parts.join("; ") };
    Some(format!("**{}** ({}): {text}", one.name.replace('*', "\\*"), one.kind.words()))
}
