//! Semantic tokens: keywords, parameters, values, names and comments. Long tables of numbers have none.

use super::FeatureContext;
use super::context::KeywordLine;
use crate::deck::keywords::{InputRule, KeywordTier};
use crate::deck::lexer::{LineKind, kind, split};
use crate::deck::name_kinds::{field_name_kind, parameter_name_usage};
use crate::text::TextRange;

/// Types of tokens, in the order of their numbers.
pub const TOKEN_TYPES: &[&str] = &["keyword", "property", "enumMember", "variable", "comment", "string"];
/// Properties of tokens, in the order of their bits.
pub const TOKEN_MODIFIERS: &[&str] = &["definition", "deprecated"];

const KEYWORD: u32 = 0;
const PROPERTY: u32 = 1;
const ENUM_MEMBER: u32 = 2;
const VARIABLE: u32 = 3;
const COMMENT: u32 = 4;
const STRING: u32 = 5;
const DEFINITION: u32 = 1;
/// Marks keywords that are unsupported.
const DEPRECATED: u32 = 2;

/// A token on one line.
struct SemanticToken {
    range: TextRange,
    kind: u32,
    modifiers: u32,
}

impl SemanticToken {
    fn new(range: TextRange, kind: u32) -> SemanticToken {
        SemanticToken { range, kind, modifiers: 0 }
    }
}

/// Returns the tokens of the lines from `first` to before `last`, as the protocol encodes them.
pub fn semantic_tokens(context: &FeatureContext<'_>, first: u32, last: u32) -> Vec<u32> {
    let mut tokens = Vec::new();
    for (start, block) in context.text.blocks() {
        let end = start + block.line_count() as u32;
        if end <= first || start >= last || block.is_numeric() {
            continue;
        }
        add_tokens(context, start.max(first), end.min(last), &mut tokens);
    }
    encoded(tokens)
}

fn add_tokens(context: &FeatureContext<'_>, first: u32, last: u32, tokens: &mut Vec<SemanticToken>) {
    let (buffer, encoding) = (context.text, context.encoding);
    let mut head = buffer.keyword_line_at(first).map(|line| KeywordLine::read(buffer, line, encoding));
    let (mut row, mut values_before) = (0, 0);
    for line in first..last {
        let text = buffer.line(line);
        match kind(text) {
            LineKind::Blank => {}
            LineKind::Comment => {
                let range = TextRange::on_line(line, 0, encoding.width(text));
                tokens.push(SemanticToken::new(range, COMMENT));
            }
            LineKind::Keyword => {
                let read = KeywordLine::read(buffer, line, encoding);
                keyword_tokens(&read, tokens);
                head = Some(read);
                (row, values_before) = (0, 0);
            }
            LineKind::Data => {
                let Some(head) = head.as_ref().filter(|head| line >= head.end) else { continue };
                let fields = split(text, 0..text.len());
                let shape = head.shape();
                for (column, bytes) in fields.ranges.iter().enumerate().filter(|(_, bytes)| !bytes.is_empty()) {
                    let Some(rule) = shape.field(row, column, values_before) else { continue };
                    if let Some(kind) = field_type(rule, &text[bytes.clone()]) {
                        let range = super::context::range(text, line, bytes.clone(), encoding);
                        tokens.push(SemanticToken::new(range, kind));
                    }
                }
                values_before = shape.values_after(values_before, fields.ranges.len());
                row += 1;
            }
        }
    }
}

/// Returns the type of a field; `None` for numbers and free text.
fn field_type(rule: &InputRule, text: &str) -> Option<u32> {
    if text.trim().parse::<f64>().is_ok() {
        return None;
    }
    if field_name_kind(rule).is_some() {
        return Some(VARIABLE);
    }
    (rule.value.words().is_some() || rule.name.ends_with("variable")).then_some(ENUM_MEMBER)
}

fn keyword_tokens(head: &KeywordLine, tokens: &mut Vec<SemanticToken>) {
    let unsupported = head.keyword.is_some_and(|keyword| keyword.tier == KeywordTier::UnsupportedPhysics);
    let modifiers = if unsupported { DEPRECATED } else { 0 };
    tokens.push(SemanticToken { range: head.range, kind: KEYWORD, modifiers });
    for parameter in &head.parameters {
        tokens.push(SemanticToken::new(parameter.name_range, PROPERTY));
        let Some((text, range)) = parameter.value.as_ref().filter(|(text, _)| !text.is_empty()) else { continue };
        let usage = head.keyword.zip(parameter.rule).and_then(|(keyword, rule)| parameter_name_usage(keyword, rule));
        let (kind, modifiers) = match (usage, parameter.rule) {
            (Some(usage), _) => (VARIABLE, if usage.defines { DEFINITION } else { 0 }),
            (None, Some(rule)) if rule.value.words().is_some() => (ENUM_MEMBER, 0),
            _ if text.parse::<f64>().is_ok() => continue,
            _ => (STRING, 0),
        };
        tokens.push(SemanticToken { range: *range, kind, modifiers });
    }
}

/// Encodes tokens by their distance from the previous one.
fn encoded(mut tokens: Vec<SemanticToken>) -> Vec<u32> {
    tokens.sort_by_key(|token| token.range.start);
    tokens.dedup_by_key(|token| token.range.start);
    let (mut line, mut column) = (0, 0);
    let mut numbers = Vec::with_capacity(5 * tokens.len());
    for SemanticToken { range, kind, modifiers } in tokens.into_iter().filter(|t| t.range.end > t.range.start) {
        let start = range.start;
        let step = if start.line == line { start.character - column } else { start.character };
        numbers.extend([start.line - line, step, range.end.character - start.character, kind, modifiers]);
        (line, column) = (start.line, start.character);
    }
    numbers
}
