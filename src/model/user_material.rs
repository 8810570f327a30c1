//! What materials leave to the user: `*USER MATERIAL`, `*PLASTIC, HARDENING=USER`, `*USER DEFINED FIELD`, `*DEPVAR`, and its values
//! at the start.
//! Never here: the routine.

use super::builder::Builder;
use super::types::{InitialCondition, InitialKind, Plastic, StateVariables};
use crate::deck::read::FromValue;
use crate::deck::{Card, DataLine};

/// Constants on a full line.
const ROW: usize = 8;

impl Builder<'_> {
    /// `*USER MATERIAL, CONSTANTS=n`.
    pub(super) fn user_material(&mut self, card: &Card) {
        if self.required(card, "CONSTANTS").is_some() {
            self.last_material().user.material = self.constants(card, "CONSTANTS");
        }
    }

    /// `*PLASTIC, HARDENING=USER, PROPERTIES=n`.
    pub(super) fn user_hardening(&mut self, card: &Card) {
        self.last_material().plastic = self.constants(card, "PROPERTIES").map(Plastic::User);
    }

    /// `*USER DEFINED FIELD, PROPERTIES=n`.
    pub(super) fn user_fields(&mut self, card: &Card) {
        self.last_material().user.fields = self.constants(card, "PROPERTIES").map(|constants| (constants, card.span));
    }

    /// `*CHARACTERISTIC LENGTH`: the root of the area, or what the routine of the user gives.
    pub(super) fn characteristic_length(&mut self, card: &Card) {
        if card.read("DEFINITION") {
            self.last_material().user.lengths = self.constants(card, "PROPERTIES").map(|list| (list, card.span));
        }
    }

    /// As many constants as a parameter says, none without it: eight a line, and an empty field is zero; a line that ends
    /// earlier is filled with zeros where another follows.
    fn constants(&mut self, card: &Card, parameter: &str) -> Option<Vec<f64>> {
        let wanted: usize = card.read(parameter);
        let mut constants = Vec::new();
        for (row, line) in card.lines.iter().enumerate() {
            constants.resize(ROW * row, 0.0);
            let filled = line.fields.iter().rposition(|w| !w.text.is_empty()).map_or(0, |last| last + 1);
            // Empty fields at the end are zeros as far as constants are wanted.
            let empty = line.fields.len().min(wanted.saturating_sub(ROW * row));
            if filled > ROW {
                let message = format!("a line holds {ROW} constants at most, not {filled}");
                return self.refuse_value(line.span, message);
            }
            for i in 0..filled.max(empty) {
                constants.push(self.number_or(line, i, 0.0)?);
            }
        }
        if wanted == constants.len() {
            return Some(constants);
        }
        let wanted = card.value(parameter).map_or(String::new(), |word| format!("{parameter}={}, but ", word.text));
        let rows =
            if card.lines.len() > 1 { format!(" (each line but the last counts as {ROW})") } else { String::new() };
        self.refuse_value(card.span, format!("{wanted}{} constants follow{rows}", constants.len()))
    }

    /// `*DEPVAR`: number of variables; further lines name them: number, name, description.
    pub(super) fn state_variables(&mut self, card: &Card) {
        let calls = |c: &&Card| {
            let name = c.keyword.name;
            let hardening = name == "PLASTIC" && c.value("HARDENING").is_some_and(|w| w.is("USER"));
            hardening || matches!(name, "USER MATERIAL" | "USER DEFINED FIELD")
        };
        if !self.deck.cards.iter().any(|c| calls(&c)) {
            return self.inert(card, "it serves routines of the user, and this deck asks none at points".into());
        }
        let count = usize::from_value(card.given_field(0, 0));
        let delete = card.read::<Option<usize>>("DELETE");
        if let Some((number, word)) = delete.zip(card.value("DELETE")).filter(|(number, _)| *number > count) {
            self.out_of_range(word.span, format!("DELETE={number} is none of the {count} state variables"));
        }
        let delete = delete.filter(|number| *number <= count).map(|number| number - 1);
        self.last_material().user.state = StateVariables { count, delete };
        let names = card.lines[1..].iter().filter_map(|line| self.state_name(line, count)).collect();
        self.last_material().user.state_names = names;
    }

    /// A state variable, counted from 0, and its name.
    fn state_name(&mut self, line: &DataLine, count: usize) -> Option<(usize, String)> {
        let number = self.integer(line, 0, "the number of a state variable")?;
        let Some(variable) = usize::try_from(number).ok().filter(|n| (1..=count).contains(n)) else {
            return self.refuse_value(line.span, format!("there is no state variable {number}: there are {count}"));
        };
        line.field(1).map(|name| (variable - 1, name.text.trim_matches('"').to_owned()))
    }

    /// `*INITIAL CONDITIONS, TYPE=SOLUTION`: state variables of elements, seven behind the set and eight on each line that
    /// follows. A line that begins with a name begins another set; one that begins with a number goes on where variables are
    /// missing.
    pub(super) fn initial_state(&mut self, card: &Card) {
        let most = self.deck.cards.iter().filter(|c| c.keyword.name == "DEPVAR");
        let counts = most.filter_map(|c| c.lines.first()?.field(0)?.text.parse::<usize>().ok());
        let most = counts.max().unwrap_or(0);
        let mut lines = card.lines.iter().peekable();
        while let Some(line) = lines.next() {
            let Some(set) = line.field(0) else { continue };
            let mut values = Vec::new();
            let mut read = |builder: &mut Self, line: &DataLine, from: usize, to: usize| {
                for i in from..to {
                    values.push(builder.number_or(line, i, 0.0)?);
                }
                Some(values.len())
            };
            let Some(mut count) = read(self, line, 1, if most > ROW - 1 { ROW } else { line.fields.len() }) else {
                continue;
            };
            while let Some(next) = lines.next_if(|next| count < most && goes_on(next)) {
                match read(self, next, 0, ROW) {
                    Some(more) => count = more,
                    None => return,
                }
            }
            if let Some(members) = self.element_members(set) {
                let kind = InitialKind::State(values);
                self.model.initial_conditions.push(InitialCondition { kind, members, span: line.span });
            }
        }
    }
}

/// Whether a line holds numbers alone, as one that goes on does.
fn goes_on(line: &DataLine) -> bool {
    line.fields.iter().all(|w| w.text.is_empty() || crate::deck::number::parse_number(&w.text).is_ok())
}
