//! A deck against the keyword table: what its cards say beyond what is read, and what is said twice.
//! Never here: what a card means.

use std::collections::{HashMap, HashSet};

use super::check_values::{check_lines, check_parameter, check_required_parameters, check_value};
use super::names::upper;
use super::types::Inert;
use crate::deck::keywords::{Place, Rule, Shape, Tier, Times, Usage};
use crate::deck::names::fold;
use crate::deck::number::parse_number;
use crate::deck::{Card, DataLine, Deck, Diagnostic, Diagnostics, Sources, Span, Word};

/// Changes only output that is not written here.
const OUTPUT_ONLY: &str = "it changes only files that another program would write";
/// Known, and no result depends on it.
const NO_EFFECT: &str = "no result depends on it";

/// Checks every card of a deck; what is inert comes back, once for each kind, with the number of cards, and the cards on which
/// an error tells of a parameter or a data line.
pub(super) fn check(deck: &Deck, diagnostics: &mut Diagnostics) -> (Vec<Inert>, HashSet<Span>) {
    let sources = &deck.sources;
    let mut checker = Checker {
        sources,
        diagnostics,
        inert: Vec::new(),
        blocks: Blocks::default(),
        of_values: Diagnostics::default(),
        given: HashMap::new(),
    };
    let mut faulty = HashSet::new();
    for card in &deck.cards {
        checker.blocks.pass(card);
        let before = checker.diagnostics.error_count();
        if card.keyword.tier == Tier::Used {
            checker.place(card);
            checker.times(card);
            let told = checker.diagnostics.error_count();
            checker.parameters(card);
            // What the data lines hold follows from the parameters.
            if checker.diagnostics.error_count() == told {
                checker.data(card);
            }
            check_required_parameters(card, checker.diagnostics);
        }
        match card.keyword.tier {
            Tier::Inert(why) => checker.inert(card.keyword.name.into(), card.span, why),
            Tier::OutputOnly => checker.inert(card.keyword.name.into(), card.span, OUTPUT_ONLY),
            Tier::UnsupportedInert => checker.inert(card.keyword.name.into(), card.span, NO_EFFECT),
            Tier::Used | Tier::UnsupportedPhysics => {}
        }
        if checker.diagnostics.error_count() > before {
            faulty.insert(card.span);
        }
    }
    let inert = checker.inert.into_iter().map(|(inert, count)| inert.counted(count));
    (inert.collect(), faulty)
}

impl Inert {
    fn counted(mut self, count: usize) -> Inert {
        if count > 1 {
            self.why += &format!(" ({count} cards)");
        }
        self
    }
}

/// Which blocks are open: how a card's place is told from another's.
#[derive(Default)]
struct Blocks {
    /// Cards that others stand below, by keyword, and how many of them there were.
    parent: Option<(&'static str, usize)>,
    parents: usize,
    /// Steps begun so far; 0 before the first.
    step: usize,
    /// Whether one is open.
    in_step: bool,
    /// Part or instance whose names these are.
    scope: String,
}

impl Blocks {
    fn pass(&mut self, card: &Card) {
        let name = card.keyword.name;
        let kin = |(parent, _)| card.keyword.place == Place::Below(parent);
        if matches!(name, "MATERIAL" | "SURFACE INTERACTION") {
            self.parents += 1;
            self.parent = Some((name, self.parents));
        } else if !self.parent.is_some_and(kin) && card.keyword.tier == Tier::Used {
            self.parent = None;
        }
        match name {
            "STEP" => (self.step, self.in_step) = (self.step + 1, true),
            "END STEP" => self.in_step = false,
            "PART" | "INSTANCE" => self.scope = format!("{name} {}", card.value("NAME").map_or("", |w| &w.text)),
            "END PART" | "END INSTANCE" => self.scope.clear(),
            _ => {}
        }
    }

    /// What sets the place of a card apart from others of its kind.
    fn place(&self, card: &Card) -> String {
        match card.keyword.place {
            Place::Anywhere => self.scope.clone(),
            Place::Step | Place::EachStep => self.step.to_string(),
            Place::Below(_) => self.parent.map_or(0, |p| p.1).to_string(),
        }
    }
}

struct Checker<'d> {
    sources: &'d Sources,
    diagnostics: &'d mut Diagnostics,
    inert: Vec<(Inert, usize)>,
    blocks: Blocks,
    /// Findings on values of the card that is being checked.
    of_values: Diagnostics,
    /// Where a card was given first, by keyword, place and name.
    given: HashMap<(&'static str, String, String), Span>,
}

impl Checker<'_> {
    fn place(&mut self, card: &Card) {
        let name = card.keyword.name;
        match card.keyword.place {
            Place::Below(parent) if self.blocks.parent.is_none() => {
                let message = format!("*{name} belongs below a *{parent}");
                let finding = Diagnostic::error("M105", message).at(card.span, format!("no *{parent} is open here"));
                let help = format!("move it below its *{parent}, before any other kind of card");
                self.diagnostics.push(finding.help(help));
            }
            Place::Step if !self.blocks.in_step => {
                let message = format!("*{name} belongs into a *STEP");
                self.diagnostics.push(Diagnostic::error("M105", message).at(card.span, "no step is open"));
            }
            _ => {}
        }
    }

    fn times(&mut self, card: &Card) {
        let name = match card.keyword.times {
            Times::Any => return,
            Times::Once => String::new(),
            Times::Unique(parameter) => match card.value(parameter) {
                Some(word) => upper(&word.text),
                None => return,
            },
        };
        let key = (card.keyword.name, self.blocks.place(card), name.clone());
        let Some(first) = self.given.insert(key.clone(), card.span) else { return };
        self.given.insert(key, first);
        let message = match (card.keyword.times, card.keyword.place) {
            (Times::Unique(_), _) => format!("*{} {name} is defined twice", card.keyword.name),
            (_, Place::Step | Place::EachStep) => format!("*{} is given twice in the step", card.keyword.name),
            (_, Place::Below(parent)) => format!("*{} is given twice below its *{parent}", card.keyword.name),
            _ => format!("*{} is given twice", card.keyword.name),
        };
        let finding = Diagnostic::error("M160", message).at(card.span, "again here").at(first, "first here");
        self.diagnostics.push(finding.help("remove one of them"));
    }

    fn parameters(&mut self, card: &Card) {
        for parameter in &card.parameters {
            let Some(rule) = card.keyword.rule(parameter.name) else { continue };
            let (name, keyword) = (parameter.name, card.keyword.name);
            match rule.usage {
                Usage::Read => check_parameter(card, rule, parameter, self.diagnostics),
                Usage::Refused(why) => {
                    let message = format!("{name} on *{keyword} is not supported");
                    self.refuse(parameter.span, message, why);
                }
                Usage::Only(values, why) => {
                    if let Some(word) = parameter.value.as_ref().filter(|w| !is_one_of(w, values)) {
                        self.refuse(word.span, format!("{name}={} on *{keyword} is not supported", word.text), why);
                    }
                }
                Usage::Inert(note) => self.inert(format!("{keyword}, {name}"), parameter.span, note),
            }
        }
    }

    fn refuse(&mut self, span: Span, message: String, why: &str) {
        self.diagnostics.push(Diagnostic::error("M104", message).at(span, "not supported").help(why));
    }

    /// Notes what is inert, once for each kind.
    fn inert(&mut self, keyword: String, span: Span, why: &str) {
        match self.inert.iter_mut().find(|(inert, _)| inert.keyword == keyword) {
            Some((_, count)) => *count += 1,
            None => self.inert.push((Inert { keyword, span, why: why.into() }, 1)),
        }
    }

    fn data(&mut self, card: &Card) {
        let shape = card.shape();
        if let Shape::Text(rule) = shape {
            if let (Usage::Inert(note), Some(line)) = (rule.usage, card.lines.first()) {
                self.inert(format!("{}, {}", card.keyword.name, rule.name), line.span, note);
            }
            return;
        }
        let told = self.diagnostics.error_count();
        let mut faults = Faults::default();
        let mut before = 0;
        let behind = |before: usize, fields: usize| match shape {
            Shape::Wrapped(count, _) if before + fields >= *count => 0,
            _ => before + fields,
        };
        for (i, line) in card.lines.iter().enumerate() {
            self.line(card, shape, (i, line, before), &mut faults);
            before = behind(before, line.fields.len());
        }
        for (i, row) in card.rows.iter().enumerate() {
            let count = row.field_count(self.sources);
            let read = |k| shape.field(i, k, before).is_some_and(|rule| rule.usage == Usage::Read);
            if !(0..count).all(read) {
                self.line(card, shape, (i, &row.line(self.sources), before), &mut faults);
            }
            before = behind(before, count);
        }
        faults.tell(card, self.diagnostics);
        let of_values = std::mem::take(&mut self.of_values);
        // Where a value is one too many, others are not what was meant.
        if self.diagnostics.error_count() == told {
            self.diagnostics.append(of_values);
        }
        if self.diagnostics.error_count() == told {
            check_lines(card, self.diagnostics);
        }
    }

    fn line(
        &mut self,
        card: &Card,
        shape: &'static Shape,
        (i, line, before): (usize, &DataLine, usize),
        faults: &mut Faults,
    ) {
        for (k, word) in line.fields.iter().enumerate().filter(|(_, w)| !w.text.is_empty()) {
            let Some(rule) = shape.field(i, k, before) else {
                let surplus_line = shape.field(i, 0, before).is_none();
                let comma = decimal_comma(line, k);
                faults.note(if surplus_line { Fault::Line } else { Fault::Value(comma) }, word, line);
                return;
            };
            // A temperature on the only row decides nothing.
            let idle = rule.name == "temperature" && card.line_count() == 1;
            match rule.usage {
                Usage::Read => {
                    check_value(card, rule, word, &mut self.of_values);
                    if let Some(meant) = decimal_comma(line, k).filter(|_| idle) {
                        faults.note(Fault::Comma(rule, meant), word, line);
                    }
                }
                Usage::Refused(why) => faults.note(Fault::Refused(rule, why), word, line),
                Usage::Only(values, why) => {
                    if !is_one_of(word, values) {
                        faults.note(Fault::Refused(rule, why), word, line);
                    }
                }
                Usage::Inert(note) => {
                    self.inert(format!("{}, {}", card.keyword.name, rule.name), word.span, note);
                    if let Some(meant) = decimal_comma(line, k) {
                        faults.note(Fault::Comma(rule, meant), word, line);
                    }
                }
            }
        }
    }
}

/// What is wrong with a value on a data line.
enum Fault {
    /// The card takes no such line.
    Line,
    /// The card takes no such value; what a decimal comma would mean.
    Value(Option<String>),
    /// The rule refuses it.
    Refused(&'static Rule, &'static str),
    /// It is inert, and looks like the decimals of the number before it.
    Comma(&'static Rule, String),
}

impl Fault {
    fn same_kind(&self, other: &Fault) -> bool {
        match (self, other) {
            (Fault::Refused(a, _), Fault::Refused(b, _)) => a.name == b.name,
            (a, b) => std::mem::discriminant(a) == std::mem::discriminant(b),
        }
    }
}

/// Faults of one card: the first of each kind, and how many lines have it.
#[derive(Default)]
struct Faults {
    list: Vec<(Fault, Span, String, Span, usize)>,
}

impl Faults {
    fn note(&mut self, fault: Fault, word: &Word, line: &DataLine) {
        match self.list.iter_mut().find(|f| f.0.same_kind(&fault)) {
            Some(known) => known.4 += 1,
            None => self.list.push((fault, word.span, word.text.clone(), line.span, 1)),
        }
    }

    fn tell(self, card: &Card, diagnostics: &mut Diagnostics) {
        for (fault, span, text, line, count) in self.list {
            let mut finding = finding(card, &fault, span, &text, line);
            if count > 1 {
                finding.message += &format!(" (so on {count} lines)");
            }
            diagnostics.push(finding);
        }
    }
}

fn finding(card: &Card, fault: &Fault, span: Span, text: &str, line: Span) -> Diagnostic {
    let keyword = card.keyword.name;
    let table = matches!(card.shape(), Shape::Lines(_, true)) && card.line_count() == 1;
    let rows = if table { "a table takes one row a line; " } else { "" };
    let explain = format!("{rows}`revolve explain {keyword}` lists what a line holds");
    match fault {
        Fault::Line if card.keyword.data.is_empty() => {
            Diagnostic::error("M162", format!("*{keyword} takes no data lines")).at(line, "nothing reads this")
        }
        Fault::Line => {
            let finding = Diagnostic::error("M162", format!("*{keyword} takes no further data line"));
            finding.at(line, "nothing reads this").help(explain)
        }
        Fault::Value(meant) => {
            let finding = Diagnostic::error("M161", format!("`{text}` is one value too many for a line of *{keyword}"));
            finding.at(span, "nothing reads this").help(match meant {
                Some(meant) => format!("is it a decimal comma? write {meant}"),
                None => explain,
            })
        }
        Fault::Refused(rule, why) => {
            let message = format!("{} ({text}) on a line of *{keyword} is not supported", rule.name);
            Diagnostic::error("M104", message).at(span, "not supported").help(*why)
        }
        Fault::Comma(rule, meant) => {
            let message = format!("`{text}` is taken as the {} of *{keyword}, which changes nothing", rule.name);
            let finding = Diagnostic::warning("M163", message).at(span, "close behind a comma");
            finding.help(format!("is it a decimal comma? write {meant}"))
        }
    }
}

/// Whether a word is one of these values: as a number where both are, otherwise case and blanks aside.
fn is_one_of(word: &Word, values: &[&str]) -> bool {
    let number = parse_number(&word.text).ok();
    values.iter().any(|v| match (number, parse_number(v).ok()) {
        (Some(a), Some(b)) => a == b,
        _ => fold(&word.text) == fold(v),
    })
}

/// The number that a value and the one before it would be with a point in place of the comma: whole digits close around it.
fn decimal_comma(line: &DataLine, index: usize) -> Option<String> {
    let (before, word) = (line.fields.get(index.checked_sub(1)?)?, &line.fields[index]);
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let close = before.span.file == word.span.file && before.span.end + 1 == word.span.start;
    let whole = before.text.strip_prefix(['-', '+']).unwrap_or(&before.text);
    let decimals = word.text.split(['e', 'E', 'd', 'D']).next().unwrap_or("");
    let fits = close && digits(whole) && digits(decimals) && parse_number(&word.text).is_ok();
    fits.then(|| format!("{}.{}", before.text, word.text))
}

#[cfg(test)]
mod tests {
    use crate::deck::read_text;

    fn codes(text: &str) -> Vec<String> {
        let (deck, mut diagnostics) = read_text("test.inp", text, &[]);
        super::check(&deck, &mut diagnostics);
        diagnostics.iter().map(|d| format!("{} {}", d.code, d.help.clone().unwrap_or_default())).collect()
    }

    #[test]
    fn a_decimal_comma_is_suspected() {
        let found = codes("*Material, name=A\n*Density\n7850,5\n*Elastic\n210,5, 0,3\n");
        assert!(found[0].starts_with("M163") && found[0].ends_with("write 7850.5"), "{found:?}");
        assert!(found[1].starts_with("M161") && found[1].ends_with("write 0.3"), "{found:?}");
        assert!(codes("*Material, name=A\n*Density\n7850., 20.\n").is_empty());
    }

    #[test]
    fn what_is_given_twice_is_told() {
        let twice = "*Material, name=A\n*Density\n1.,\n*Density\n2.,\n*Material, name=a\n*Density\n1.,\n";
        assert_eq!(codes(twice).iter().filter(|c| c.starts_with("M160")).count(), 2);
        assert!(codes("*Density\n1.,\n")[0].starts_with("M105"));
    }
}
