//! The text of a deck with its listed mesh: lines of the deck without the cards of its mesh, and with changed words.

use std::collections::HashSet;

use super::ListedMesh;
use super::edits::EditPlace;
use super::listing::quoted;
use crate::deck::lines::{DeckLine, LineRole, in_reading_order};
use crate::deck::{Card, Deck, MeshScaling, Span, Word};
use crate::model::names::upper;
use crate::model::refinement::pass::defines_mesh;

/// A text in place of bytes of a file.
struct TextChange {
    start: u32,
    end: u32,
    text: String,
}

/// State of writing a deck.
pub struct DeckWriter<'a> {
    deck: &'a Deck,
    mesh: ListedMesh,
    /// Upper-case names of the instances.
    instances: Vec<String>,
    has_assembly: bool,
    /// Scopes whose mesh has been written.
    listed: HashSet<String>,
    text: String,
}

impl<'a> DeckWriter<'a> {
    pub fn new(deck: &'a Deck, mesh: ListedMesh) -> DeckWriter<'a> {
        let instances = deck.cards.iter().filter(|card| card.keyword.name == "INSTANCE");
        DeckWriter {
            deck,
            mesh,
            instances: instances.filter_map(|card| card.value("NAME")).map(|name| upper(&name.text)).collect(),
            has_assembly: deck.cards.iter().any(|card| card.keyword.name == "END ASSEMBLY"),
            listed: HashSet::new(),
            text: String::new(),
        }
    }

    /// Returns the text.
    pub fn write(mut self) -> String {
        let lines = in_reading_order(self.deck);
        let (mut index, mut scope) = (0, String::new());
        while let Some(line) = lines.get(index) {
            let card = self.first_of(line);
            match card.map_or("", |card| card.keyword.name) {
                "PART" => {
                    index = self.part(&lines, index);
                    continue;
                }
                "INSTANCE" => scope = name_of(card, "NAME"),
                "END ASSEMBLY" | "STEP" => self.end_of_model(),
                _ => {}
            }
            self.line(line, &scope);
            if card.is_some_and(|card| card.keyword.name == "END INSTANCE") {
                scope.clear();
            }
            index += 1;
        }
        self.end_of_model();
        self.text
    }

    /// Returns the card whose keyword line begins on a line.
    fn first_of(&self, line: &DeckLine) -> Option<&'a Card> {
        let card = &self.deck.cards[line.card?];
        let begins = (line.span.start..line.span.end).contains(&card.span.start) && line.span.file == card.span.file;
        (line.role == LineRole::Keyword && begins).then_some(card)
    }

    /// Writes a part once for each of its instances, with the coordinates of the assembly; returns the line after it.
    fn part(&mut self, lines: &[DeckLine], at: usize) -> usize {
        let is_end = |line: &DeckLine| self.first_of(line).is_some_and(|card| card.keyword.name == "END PART");
        let end = lines[at..].iter().position(is_end).map_or(lines.len(), |length| at + length + 1);
        let part = name_of(self.first_of(&lines[at]), "NAME");
        let is_of_part = |card: &&Card| card.keyword.name == "INSTANCE" && name_of(Some(card), "PART") == part;
        for instance in self.deck.cards.iter().filter(is_of_part) {
            let scope = name_of(Some(instance), "NAME");
            lines[at..end].iter().for_each(|line| self.line(line, &scope));
        }
        end
    }

    fn line(&mut self, line: &DeckLine, scope: &str) {
        let card = line.card.map(|card| &self.deck.cards[card]);
        match (line.role, card) {
            (LineRole::Keyword | LineRole::Data, Some(card)) if defines_mesh(card) => {
                if !scope.is_empty() || !self.has_assembly {
                    self.list(scope);
                }
            }
            (LineRole::Data, Some(card)) if card.keyword.name == "INSTANCE" => {}
            (LineRole::Other, Some(card)) if defines_mesh(card) && self.source(line.span).trim().is_empty() => {}
            (LineRole::Keyword, Some(Card { lines, .. }))
                if !lines.is_empty() && lines.iter().all(|line| self.is_removed(line.span, scope)) => {}
            (LineRole::Data, _) if self.is_removed(line.span, scope) => {}
            _ => {
                let changed = self.changed(line, scope);
                self.text.push_str(&changed);
                self.text.push('\n');
            }
        }
    }

    /// Writes the mesh of a scope, once.
    fn list(&mut self, scope: &str) {
        if !self.listed.insert(scope.to_owned()) {
            return;
        }
        let cards = self.mesh.cards(scope, &self.instances);
        if cards.is_empty() {
            return;
        }
        let what = match self.deck.mesh_scaling {
            Some(_) if self.deck.refined_elements.is_some() => ", edges of some elements divided".to_owned(),
            Some(MeshScaling::Refine(factor)) if factor > 1 => format!(", each edge divided into {factor} parts"),
            Some(MeshScaling::Coarsen(factor)) => format!(", {factor} by {factor} elements merged"),
            _ => String::new(),
        };
        self.text.push_str(&format!("** Listed mesh{what}; *PARAMETER values do not change it\n{cards}"));
    }

    /// Writes the mesh that is in no instance, if that is not done yet, and constraints of new nodes.
    fn end_of_model(&mut self) {
        self.list("");
        self.text.push_str(&std::mem::take(&mut self.mesh.edits.tail));
    }

    fn source(&self, span: Span) -> &'a str {
        self.deck.sources.text(span)
    }

    /// Returns whether a line refers only to nodes that a coarsened mesh does not have.
    fn is_removed(&self, line: Span, scope: &str) -> bool {
        let is_here = |start: u32| (line.start..line.end).contains(&start);
        self.mesh
            .edits
            .removed
            .iter()
            .any(|place| place.scope == scope && place.file == line.file && is_here(place.start))
    }

    /// Returns the text of a line with its changes.
    fn changed(&self, line: &DeckLine, scope: &str) -> String {
        let Span { file, start, end } = line.span;
        let mut changes = self.changes_of_keyword(line, scope);
        let [first, last] = [start, end].map(|start| EditPlace { scope: scope.to_owned(), file, start });
        let replaced = self.mesh.edits.replaced.range(&first..&last);
        let replaced = replaced.filter(|(_, edit)| self.mesh.applies(&edit.condition));
        changes.extend(replaced.map(|(place, edit)| TextChange {
            start: place.start,
            end: edit.end,
            text: edit.text.clone(),
        }));
        let added = self.mesh.edits.added.range(first..=last);
        changes.extend(added.map(|(place, text)| TextChange {
            start: place.start,
            end: place.start,
            text: text.clone(),
        }));
        let inside = |span: Span| span.file == file && (start..=end).contains(&span.start);
        let definitions = self.deck.definitions.iter().filter(|d| line.role == LineRole::Other && inside(d.span));
        changes.extend(
            definitions.filter_map(|d| {
                Some(TextChange { start: d.span.start, end: d.span.end, text: d.replacement.clone()? })
            }),
        );
        changes.sort_by_key(|change| (change.start, change.end));
        let (mut text, mut position) = (String::new(), start);
        for change in changes {
            text.push_str(self.source(Span { file, start: position, end: change.start }));
            text.push_str(&change.text);
            position = change.end;
        }
        text.push_str(self.source(Span { file, start: position, end }));
        text
    }

    /// Returns the changes of a keyword line: names of parts, and included data.
    fn changes_of_keyword(&self, line: &DeckLine, scope: &str) -> Vec<TextChange> {
        let Some(card) = line.card.filter(|_| line.role == LineRole::Keyword).map(|card| &self.deck.cards[card]) else {
            return Vec::new();
        };
        let is_here =
            |span: Span| span.file == line.span.file && (line.span.start..line.span.end).contains(&span.start);
        let replaced = |word: &Word| TextChange { start: word.span.start, end: word.span.end, text: quoted(scope) };
        let name = match card.keyword.name {
            "PART" => card.value("NAME"),
            "INSTANCE" => card.value("PART"),
            _ => None,
        };
        let mut changes: Vec<TextChange> = name.filter(|word| is_here(word.span)).map(replaced).into_iter().collect();
        if let Some(input) = card.parameter("INPUT").filter(|input| is_here(input.span)) {
            let text_before = self.source(Span { end: input.span.start, ..line.span });
            let start = text_before.rfind(',').map_or(input.span.start, |at| line.span.start + at as u32);
            let end = card.value("INPUT").map_or(input.span.end, |word| word.span.end);
            changes.push(TextChange { start, end, text: String::new() });
        }
        changes
    }
}

fn name_of(card: Option<&Card>, parameter: &str) -> String {
    card.and_then(|card| card.value(parameter)).map_or_else(String::new, |word| upper(&word.text))
}
