//! Names of a deck: where they are defined and where they are used.

use std::collections::{HashMap, HashSet};

use crate::deck::lexer::{LineIterator, LineKind, kind};
use crate::deck::name_kinds::{NameKind, field_name_kind, parameter_name_usage};
use crate::deck::{Card, Deck, ParameterReference, Span, Word, next_reference};

/// A place at which a deck defines or uses a name.
#[derive(Clone, Debug, PartialEq)]
pub struct NameUse {
    pub kind: NameKind,
    /// Part in which the name is valid; empty for the assembly and for names of the whole deck.
    pub scope: String,
    /// The name in upper case, without its instance; that of a parameter as written.
    pub name: String,
    /// The name as written, without its instance.
    pub span: Span,
    pub defines: bool,
}

/// All places of names, in the order of the deck.
#[derive(Debug, Default)]
pub struct NameTable {
    uses: Vec<NameUse>,
}

impl NameTable {
    /// Finds the names of a deck.
    pub fn of(deck: &Deck) -> NameTable {
        let mut finder = NameFinder { deck, parts: parts_of_instances(deck), scope: String::new(), uses: Vec::new() };
        for card in &deck.cards {
            finder.enter_or_leave_part(card);
            finder.card(card);
        }
        finder.parameter_definitions();
        finder.parameter_references();
        NameTable { uses: finder.uses }
    }

    /// Iterates over all places.
    pub fn iter(&self) -> impl Iterator<Item = &NameUse> {
        self.uses.iter()
    }

    /// Iterates over all places of the name that a place has.
    pub fn same_as<'n>(&'n self, one: &'n NameUse) -> impl Iterator<Item = &'n NameUse> {
        self.uses.iter().filter(|u| u.kind == one.kind && u.scope == one.scope && u.name == one.name)
    }

    /// Returns the names of a kind that the deck defines, as first written, with the number of the card.
    pub fn defined(&self, kind: NameKind) -> Vec<&NameUse> {
        let mut definitions: Vec<&NameUse> = Vec::new();
        for one in self.uses.iter().filter(|u| u.kind == kind && u.defines) {
            if !definitions.iter().any(|f| f.name == one.name && f.scope == one.scope) {
                definitions.push(one);
            }
        }
        definitions
    }
}

/// Returns the part of each instance, in upper case.
fn parts_of_instances(deck: &Deck) -> HashMap<String, String> {
    let instances = deck.cards.iter().filter(|card| card.keyword.name == "INSTANCE");
    let upper = |word: &Word| word.text.trim().to_uppercase();
    instances.filter_map(|card| Some((upper(card.value("NAME")?), upper(card.value("PART")?)))).collect()
}

struct NameFinder<'a> {
    deck: &'a Deck,
    parts: HashMap<String, String>,
    scope: String,
    uses: Vec<NameUse>,
}

impl NameFinder<'_> {
    fn enter_or_leave_part(&mut self, card: &Card) {
        match card.keyword.name {
            "PART" => self.scope = card.value("NAME").map_or(String::new(), |word| word.text.trim().to_uppercase()),
            "END PART" => self.scope.clear(),
            _ => {}
        }
    }

    fn card(&mut self, card: &Card) {
        for parameter in &card.parameters {
            let usage = card.keyword.rule(parameter.name).and_then(|rule| parameter_name_usage(card.keyword, rule));
            if let (Some(usage), Some(word)) = (usage, &parameter.value) {
                self.word(usage.kind, usage.defines, word);
            }
        }
        let shape = card.shape();
        if !shape.rules().iter().any(|rule| field_name_kind(rule).is_some()) {
            return;
        }
        let mut values_before = 0;
        for (row, line) in card.data(&self.deck.sources).enumerate() {
            for (column, word) in line.fields.iter().enumerate().filter(|(_, word)| !word.text.is_empty()) {
                if let Some(kind) = shape.field(row, column, values_before).and_then(field_name_kind) {
                    self.word(kind, false, word);
                }
            }
            values_before = shape.values_after(values_before, line.fields.len());
        }
    }

    /// Adds the definitions of parameters, and the parameters in their expressions.
    fn parameter_definitions(&mut self) {
        let known: HashSet<&str> = self.deck.definitions.iter().map(|d| d.name.as_str()).collect();
        for definition in &self.deck.definitions {
            let Some(file) = self.deck.sources.file(definition.span) else { continue };
            let end = definition.span.start as usize;
            let Some(before) = file.text.get(..end) else { continue };
            // The statement begins after the previous line or semicolon.
            let begin = before.rfind(['\n', ';']).map_or(0, |at| at + 1);
            if let Some(at) = before[begin..].find(definition.name.as_str()) {
                self.parameter(&definition.name, definition.span.file, begin + at, true);
            }
            let is_letter = |c: char| c.is_alphanumeric() || c == '_';
            let text = self.deck.sources.text(definition.span);
            let in_quotes = text.starts_with(['"', '\'']);
            for word in text.split(|c| !is_letter(c)).filter(|word| known.contains(word) && !in_quotes) {
                let offset = word.as_ptr() as usize - text.as_ptr() as usize;
                self.parameter(word, definition.span.file, end + offset, false);
            }
        }
    }

    /// Adds each `<name>` outside of comments.
    fn parameter_references(&mut self) {
        for (index, file) in self.deck.sources.files().iter().enumerate() {
            let lines = LineIterator::new(&file.text).filter(|line| file.text[line.clone()].contains('<'));
            for line in lines.filter(|line| kind(&file.text[line.clone()]) != LineKind::Comment) {
                let mut remaining = &file.text[line];
                while let Some(ParameterReference { name, after, .. }) = next_reference(remaining) {
                    self.parameter(name, index as u32, name.as_ptr() as usize - file.text.as_ptr() as usize, false);
                    remaining = after;
                }
            }
        }
    }

    fn parameter(&mut self, name: &str, file: u32, start: usize, defines: bool) {
        let span = Span { file, start: start as u32, end: (start + name.len()) as u32 };
        let (kind, name) = (NameKind::Parameter, name.to_owned());
        self.uses.push(NameUse { kind, scope: String::new(), name, span, defines });
    }

    /// Adds a name, unless the word is a number or contains a parameter.
    fn word(&mut self, kind: NameKind, defines: bool, word: &Word) {
        let written = self.deck.sources.text(word.span);
        if word.text.trim().parse::<i64>().is_ok() || written.contains('<') {
            return;
        }
        let quote = u32::from(written.starts_with('"'));
        let inner = Span {
            start: word.span.start + quote,
            end: word.span.end - quote.min(word.span.end - word.span.start),
            ..word.span
        };
        let text = self.deck.sources.text(inner);
        let (scope, name, span) = match text.rsplit_once('.') {
            Some((instance, name)) if kind.is_scoped() && !defines => {
                let part = self.parts.get(&instance.trim().to_uppercase()).cloned();
                let skipped = (instance.len() + 1) as u32;
                if name.trim().parse::<i64>().is_ok() {
                    return;
                }
                let span = Span { start: inner.start + skipped, ..inner };
                (part.unwrap_or_else(|| instance.trim().to_uppercase()), name, span)
            }
            _ if kind.is_scoped() => (self.scope.clone(), text, inner),
            _ => (String::new(), text, inner),
        };
        self.uses.push(NameUse { kind, scope, name: name.trim().to_uppercase(), span, defines });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_in_parameters_and_fields_with_their_scope() {
        let text = "*Part, name=P\n*Node, nset=A\n1, 0., 0.\n*End Part\n*Assembly, name=Q\n*Instance, name=I, part=P\n\
                    *End Instance\n*Nset, nset=A, instance=I\n 1,\n*End Assembly\n*Boundary\n I.A, 1\n A, 2\n\"A\", 2\n 5, 1\n";
        let (deck, _) = crate::deck::read_text("a.inp", text, &[]);
        let table = NameTable::of(&deck);
        let sets = table.iter().filter(|u| u.kind == NameKind::NodeSet);
        let set_uses: Vec<(&str, &str, bool)> =
            sets.map(|u| (u.scope.as_str(), deck.sources.text(u.span), u.defines)).collect();
        assert_eq!(
            set_uses,
            [("P", "A", true), ("", "A", true), ("P", "A", false), ("", "A", false), ("", "A", false)]
        );
        let text = "*Parameter\nab = 2.; b = 3*ab # ab\n** <ab>\n*Node\n 1, <ab>, <b>\n";
        let (parametric, _) = crate::deck::read_text("a.inp", text, &[]);
        let places: Vec<(String, u32, bool)> =
            NameTable::of(&parametric).iter().map(|u| (u.name.clone(), u.span.start, u.defines)).collect();
        let offset_of = |piece: &str| text.find(piece).expect("a piece") as u32;
        let (first, second) = (offset_of("ab = 2"), offset_of("b = 3"));
        let uses = [
            (first, true),
            (second, true),
            (offset_of("ab # "), false),
            (offset_of("ab>, <b"), false),
            (text.len() as u32 - 3, false),
        ];
        assert_eq!(places.iter().map(|p| (p.1, p.2)).collect::<Vec<_>>(), uses);
        assert_eq!(table.defined(NameKind::Part).len(), 1);
        assert_eq!(table.defined(NameKind::NodeSet).len(), 2);
    }
}
