//! Checks single values of cards against the keyword table: kind, range, presence, order of rows.

use crate::deck::keywords::{DataShape, InputRule};
use crate::deck::value::{FLAG, ValueKind};
use crate::deck::{Card, Diagnostic, Diagnostics, Parameter, Word};

/// Reports an invalid value.
pub(super) fn check_value(card: &Card, rule: &InputRule, word: &Word, diagnostics: &mut Diagnostics) {
    let (value, keyword, name) = (rule.value, card.keyword.name, rule.name);
    let number = match value.kind {
        ValueKind::Text => return,
        ValueKind::Number => word.number(diagnostics),
        ValueKind::Integer => word.integer(diagnostics).map(|number| number as f64),
        ValueKind::Word(_) | ValueKind::Variant(_) => {
            if value.number(&word.text).is_none() && !crate::deck::is_unresolved(&word.text) {
                diagnostics.push(unknown_word(card, rule, word));
            }
            return;
        }
    };
    let Some(number) = number.filter(|number| !value.allows(*number)) else { return };
    let message = format!("{name} of *{keyword} must be {}, found {number}", value.allowed());
    let diagnostic = Diagnostic::error("M103", message).at(word.span, "here");
    diagnostics.push(if rule.help.is_empty() { diagnostic } else { diagnostic.help(rule.help) });
}

fn unknown_word(card: &Card, rule: &InputRule, word: &Word) -> Diagnostic {
    let (allowed, keyword, name) = (rule.value.allowed(), card.keyword.name, rule.name);
    if let ValueKind::Variant(_) = rule.value.kind {
        let message = format!("{name}={} on *{keyword} is not supported", word.text);
        return Diagnostic::error("M104", message).at(word.span, "not supported").help(format!("supported: {allowed}"));
    }
    if rule.value == FLAG {
        let message = format!("{name} of *{keyword} has no value, found {}", word.text);
        let help = format!("write {name} alone, or {name}=YES or {name}=NO");
        return Diagnostic::error("M103", message).at(word.span, "here").help(help);
    }
    Diagnostic::error("M103", format!("{name} of *{keyword} must be {allowed}, found {}", word.text))
        .at(word.span, "here")
}

/// Reports a missing or invalid value of a parameter.
pub(super) fn check_parameter(card: &Card, rule: &InputRule, parameter: &Parameter, diagnostics: &mut Diagnostics) {
    match &parameter.value {
        Some(word) => check_value(card, rule, word, diagnostics),
        None if rule.value.bare.is_some() || rule.value.required => {}
        None => {
            let allowed = rule.value.allowed();
            let which = if allowed.is_empty() { String::new() } else { format!(": {allowed}") };
            let message = format!("{} of *{} requires a value{which}", rule.name, card.keyword.name);
            diagnostics.push(Diagnostic::error("M103", message).at(parameter.span, "no value"));
        }
    }
}

pub(super) fn check_required_parameters(card: &Card, diagnostics: &mut Diagnostics) {
    for rule in card.keyword.parameters.iter().filter(|rule| rule.value.required) {
        if card.value(rule.name).is_none() && !card.faulty {
            let message = format!("*{} requires {}=", card.keyword.name, rule.name);
            let diagnostic = Diagnostic::error("M101", message).at(card.span, format!("{}= is missing", rule.name));
            diagnostics.push(diagnostic);
        }
    }
}

/// Reports missing data lines and fields, and rows that do not ascend.
pub(super) fn check_lines(card: &Card, diagnostics: &mut Diagnostics) {
    if card.lines.is_empty() && card.needs_line() {
        let message = format!("*{} requires a data line", card.keyword.name);
        diagnostics.push(Diagnostic::error("M107", message).at(card.span, "data line missing"));
        return;
    }
    let DataShape::Lines(rows, repeats) = card.shape() else { return };
    for (i, line) in card.lines.iter().enumerate() {
        let Some(rules) = rows.get(if *repeats { i.min(rows.len() - 1) } else { i }) else { return };
        for (k, rule) in rules.iter().enumerate().filter(|(k, rule)| rule.value.required && line.field(*k).is_none()) {
            let diagnostic = Diagnostic::error("M102", format!("{} is missing", rule.name));
            diagnostics.push(diagnostic.at(line.span, format!("field {} should be {}", k + 1, rule.name)));
        }
    }
    if *repeats && card.lines.len() > 1 {
        let last = rows.last().into_iter().flat_map(|rules| rules.iter().enumerate());
        last.filter(|(_, rule)| rule.value.ascends).for_each(|(k, rule)| check_order(card, rule, k, diagnostics));
    }
}

/// Reports the first row at which a column of a table does not ascend.
fn check_order(card: &Card, rule: &InputRule, column: usize, diagnostics: &mut Diagnostics) {
    let numbers = card.lines.iter().map(|line| line.field(column).and_then(|word| rule.value.number(&word.text)));
    let numbers: Vec<Option<f64>> = numbers.collect();
    let ascends = |pair: &[Option<f64>]| matches!(pair, [Some(a), Some(b)] if a < b);
    let Some(at) = numbers.windows(2).position(|pair| !ascends(pair)) else { return };
    let words = |number: Option<f64>| number.map_or("nothing".into(), |number| format!("{number}"));
    let (previous, next) = (words(numbers[at]), words(numbers[at + 1]));
    let (name, keyword) = (rule.name, card.keyword.name);
    let message = format!("{name} of *{keyword} must increase from row to row, found {next} after {previous}");
    diagnostics.push(Diagnostic::error("M103", message).at(card.lines[at + 1].span, "this row"));
}
