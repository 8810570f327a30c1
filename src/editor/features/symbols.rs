//! Symbols of a file: parts, instances, materials, steps and other named cards, nested as in the deck.

use serde_json::{Value, json};

use super::FeatureContext;
use crate::deck::Card;
use crate::deck::name_kinds::parameter_name_usage;
use crate::text::{TextPosition, TextRange};

/// A card that is shown.
struct CardSymbol {
    name: String,
    detail: String,
    kind: u8,
    line: u32,
    end: u32,
    selection: TextRange,
    children: Vec<CardSymbol>,
    /// Keyword that ends the symbol; `None` for a card whose subordinate cards follow.
    closing: Option<&'static str>,
    keyword: &'static str,
}

/// Blocks that a keyword ends.
const BLOCKS: &[(&str, &str)] =
    &[("PART", "END PART"), ("ASSEMBLY", "END ASSEMBLY"), ("INSTANCE", "END INSTANCE"), ("STEP", "END STEP")];

/// Kinds of symbols, as the protocol numbers them.
fn symbol_kind(keyword: &str) -> u8 {
    match keyword {
        "PART" => 5,
        "ASSEMBLY" => 4,
        "INSTANCE" => 19,
        "MATERIAL" | "SURFACE INTERACTION" => 23,
        "STEP" => 24,
        "NSET" | "ELSET" | "NODE" | "ELEMENT" => 18,
        "SURFACE" | "RIGID SURFACE" => 11,
        "AMPLITUDE" | "TIME POINTS" => 12,
        _ => 20,
    }
}

/// Returns the symbols of a file as the protocol has them.
pub fn document_symbols(context: &FeatureContext<'_>) -> Vec<Value> {
    let mut open: Vec<CardSymbol> = Vec::new();
    let mut closed: Vec<CardSymbol> = Vec::new();
    let mut last = 0;
    for (line, card) in context.cards() {
        last = line;
        let name = card.keyword.name;
        while open.last().is_some_and(|symbol| symbol.closing.is_none() && !is_below(card, symbol)) {
            close(&mut open, &mut closed, line.saturating_sub(1));
        }
        if open.iter().any(|symbol| symbol.closing == Some(name)) {
            while open.last().is_some_and(|symbol| symbol.closing != Some(name)) {
                close(&mut open, &mut closed, line.saturating_sub(1));
            }
            close(&mut open, &mut closed, line);
            continue;
        }
        let in_block = open.last().is_some_and(|symbol| symbol.keyword == "STEP" || symbol.closing.is_none());
        if let Some(symbol) = symbol(context, line, card, in_block) {
            open.push(symbol);
        }
    }
    while !open.is_empty() {
        let end = context.text.next_keyword_line(last).saturating_sub(1).max(last);
        close(&mut open, &mut closed, end);
    }
    closed.into_iter().map(|symbol| symbol.value(context)).collect()
}

fn is_below(card: &Card, symbol: &CardSymbol) -> bool {
    card.keyword.place.is_below(symbol.keyword)
}

/// Moves the last open symbol to its parent.
fn close(open: &mut Vec<CardSymbol>, done: &mut Vec<CardSymbol>, end: u32) {
    let Some(mut symbol) = open.pop() else { return };
    symbol.end = end.max(symbol.line);
    match open.last_mut() {
        Some(parent) => parent.children.push(symbol),
        None => done.push(symbol),
    }
}

/// Returns the symbol of a card; `None` if it neither defines a name nor belongs to a step or material.
fn symbol(context: &FeatureContext<'_>, line: u32, card: &Card, in_block: bool) -> Option<CardSymbol> {
    let keyword = card.keyword;
    let closing = BLOCKS.iter().find(|(begin, _)| *begin == keyword.name).map(|(_, end)| *end);
    let defined = card.parameters.iter().find_map(|parameter| {
        let usage = parameter_name_usage(keyword, keyword.rule(parameter.name)?)?;
        usage.defines.then_some(parameter.value.as_ref()?)
    });
    let named = defined.or_else(|| card.value("NAME").filter(|_| closing.is_some()));
    if named.is_none() && closing.is_none() && !in_block {
        return None;
    }
    let (_, selection) = context.root.outline.locate(named.map_or(card.span, |word| word.span), context.encoding)?;
    let (name, detail) = match named.map(|word| word.text.trim()).filter(|text| !text.is_empty()) {
        Some(text) => (text.to_owned(), format!("*{}", keyword.name)),
        None => (format!("*{}", keyword.name), keyword.summary.to_owned()),
    };
    let selection = if selection.start.line == line { selection } else { TextRange::on_line(line, 0, 0) };
    Some(CardSymbol {
        name,
        detail,
        kind: symbol_kind(keyword.name),
        line,
        end: line,
        selection,
        children: Vec::new(),
        closing,
        keyword: keyword.name,
    })
}

impl CardSymbol {
    fn value(self, context: &FeatureContext<'_>) -> Value {
        let end = context.encoding.width(context.text.line(self.end));
        let range = TextRange {
            start: TextPosition { line: self.line, character: 0 },
            end: TextPosition { line: self.end, character: end },
        };
        let children: Vec<Value> = self.children.into_iter().map(|child| child.value(context)).collect();
        json!({
            "name": self.name,
            "detail": self.detail,
            "kind": self.kind,
            "range": range,
            "selectionRange": self.selection,
            "children": children,
        })
    }
}
