//! Checks the cards of a deck against the keyword table: place, multiplicity, parameters and data lines.

use std::collections::{HashMap, HashSet};

use super::check_values::{check_lines, check_parameter, check_required_parameters, check_value};
use super::mates::check_mates;
use super::names::upper;
use super::types::IgnoredCard;
use crate::deck::keywords::{CardMultiplicity, CardPlace, DataShape, InputRule, InputUsage, KeywordTier, parent_names};
use crate::deck::names::fold;
use crate::deck::number::parse_number;
use crate::deck::{Card, DataLine, Deck, Diagnostic, Diagnostics, Sources, Span, Word};

/// Reason for ignoring cards that only change files which Revolve does not write.
const OUTPUT_ONLY: &str = "it only affects files that Revolve does not write";
/// Reason for ignoring known cards without effect on results.
const NO_EFFECT: &str = "it has no effect on the results";

/// Checks all cards of a deck. Returns the ignored input, once per kind and with the number of cards, and the cards
/// with errors in parameters or data lines.
pub(super) fn check(deck: &Deck, diagnostics: &mut Diagnostics) -> (Vec<IgnoredCard>, HashSet<Span>) {
    let sources = &deck.sources;
    let mut checker = CardChecker {
        sources,
        diagnostics,
        inert: Vec::new(),
        blocks: OpenBlocks::default(),
        of_values: Diagnostics::default(),
        has_stray_card: false,
        given: HashMap::new(),
    };
    let mut faulty = HashSet::new();
    let last_step = deck.cards.iter().rposition(|card| card.keyword.name == "END STEP");
    for (at, card) in deck.cards.iter().enumerate() {
        checker.blocks.pass(card);
        if last_step.is_some_and(|last| at > last) {
            checker.after_last_step(card);
        }
        let errors_before = checker.diagnostics.error_count();
        let mut is_stray = false;
        if card.keyword.tier == KeywordTier::Used {
            is_stray = checker.place(card);
            checker.times(card);
            let error_count = checker.diagnostics.error_count();
            checker.parameters(card);
            // The parameters determine the layout of the data lines.
            if checker.diagnostics.error_count() == error_count {
                checker.data(card);
            }
            check_required_parameters(card, checker.diagnostics);
            check_mates(card, checker.diagnostics);
        }
        match card.keyword.tier {
            KeywordTier::Inert(why) => checker.inert(card.keyword.name.into(), card.span, why),
            KeywordTier::OutputOnly => checker.inert(card.keyword.name.into(), card.span, OUTPUT_ONLY),
            KeywordTier::UnsupportedInert => checker.inert(card.keyword.name.into(), card.span, NO_EFFECT),
            KeywordTier::Used | KeywordTier::UnsupportedPhysics => {}
        }
        if is_stray || checker.diagnostics.error_count() > errors_before {
            faulty.insert(card.span);
        }
    }
    let inert = checker.inert.into_iter().map(|(mut inert, count)| {
        if count > 1 {
            inert.why += &format!(" ({count} cards)");
        }
        inert
    });
    (inert.collect(), faulty)
}

/// Open blocks, which define the place of a card.
#[derive(Default)]
struct OpenBlocks {
    /// The last `*MATERIAL` or `*SURFACE INTERACTION`, with its running number, and the number of these cards so far.
    parent: Option<(&'static str, usize)>,
    parents: usize,
    /// Number of steps so far; 0 before the first.
    step: usize,
    /// Whether a `*STEP` has been read without its `*END STEP`.
    in_step: bool,
    /// Open part or instance.
    scope: String,
}

impl OpenBlocks {
    fn pass(&mut self, card: &Card) {
        let name = card.keyword.name;
        let kin = |(parent, _)| card.keyword.place.is_below(parent);
        if matches!(name, "MATERIAL" | "SURFACE INTERACTION" | "INCIDENT WAVE INTERACTION PROPERTY") {
            self.parents += 1;
            self.parent = Some((name, self.parents));
        } else if !self.parent.is_some_and(kin) && card.keyword.tier == KeywordTier::Used {
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

    /// Returns the place of a card; a keyword may occur once per place.
    fn place(&self, card: &Card) -> String {
        match card.keyword.place {
            CardPlace::Anywhere => self.scope.clone(),
            CardPlace::Step | CardPlace::EachStep => self.step.to_string(),
            CardPlace::Below(_) => self.parent.map_or(0, |p| p.1).to_string(),
        }
    }
}

struct CardChecker<'d> {
    sources: &'d Sources,
    diagnostics: &'d mut Diagnostics,
    inert: Vec<(IgnoredCard, usize)>,
    blocks: OpenBlocks,
    /// Diagnostics on the values of the current card.
    of_values: Diagnostics,
    /// Whether a card outside a step has been reported; the cause is one missing `*STEP`.
    has_stray_card: bool,
    /// First position of a card, by keyword, place and name.
    given: HashMap<(&'static str, String, String), Span>,
}

impl CardChecker<'_> {
    /// Reports a card out of its place, outside of steps only the first one. Returns whether it is out of its place.
    fn place(&mut self, card: &Card) -> bool {
        let name = card.keyword.name;
        match card.keyword.place {
            CardPlace::Below(parents) if self.blocks.parent.is_none() => {
                let parents = parent_names(parents);
                let message = format!("*{name} must follow a {parents}");
                let diagnostic = Diagnostic::error("M105", message).at(card.span, format!("no {parents} is open here"));
                let help = format!("move it below its {parents}, before any other kind of card");
                self.diagnostics.push(diagnostic.help(help));
            }
            CardPlace::Step if !self.blocks.in_step => {
                if std::mem::replace(&mut self.has_stray_card, true) {
                    return true;
                }
                let message = format!("*{name} must be inside a *STEP");
                let diagnostic = Diagnostic::error("M105", message).at(card.span, "no step is open");
                self.diagnostics.push(diagnostic.help("add *STEP before the procedure, such as *DYNAMIC"));
            }
            _ => return false,
        }
        true
    }

    /// Reports a condition after the last step, which would apply to no step.
    fn after_last_step(&mut self, card: &Card) {
        let applies_to_steps = card.keyword.place == CardPlace::EachStep
            || matches!(card.keyword.name, "BOUNDARY" | "CONTACT" | "CONTACT PAIR" | "RESTART");
        if applies_to_steps && !self.blocks.in_step {
            let message = format!("*{} follows the last step, so that it has no effect", card.keyword.name);
            let diagnostic = Diagnostic::error("M105", message).at(card.span, "no step follows");
            self.diagnostics
                .push(diagnostic.help("move it before the *END STEP, or before the first step for all steps"));
        }
    }

    fn times(&mut self, card: &Card) {
        let name = match card.keyword.times {
            CardMultiplicity::Any => return,
            CardMultiplicity::Once => String::new(),
            CardMultiplicity::Unique(parameter) => match card.value(parameter) {
                Some(word) => upper(&word.text),
                None => return,
            },
        };
        let key = (card.keyword.name, self.blocks.place(card), name.clone());
        let Some(first) = self.given.insert(key.clone(), card.span) else { return };
        self.given.insert(key, first);
        let message = match (card.keyword.times, card.keyword.place) {
            (CardMultiplicity::Unique(_), _) => format!("*{} {name} is defined twice", card.keyword.name),
            (_, CardPlace::Step | CardPlace::EachStep) => {
                format!("*{} is defined twice in the step", card.keyword.name)
            }
            (_, CardPlace::Below(parents)) => {
                format!("*{} is defined twice for one {}", card.keyword.name, parent_names(parents))
            }
            _ => format!("*{} is defined twice", card.keyword.name),
        };
        let diagnostic =
            Diagnostic::error("M160", message).at(card.span, "second definition").at(first, "first definition");
        self.diagnostics.push(diagnostic.help("remove one definition"));
    }

    fn parameters(&mut self, card: &Card) {
        let errors_before = self.diagnostics.error_count();
        let rules = card.parameters.iter().filter_map(|p| Some((p, card.keyword.rule(p.name)?)));
        let (read, others): (Vec<_>, Vec<_>) = rules.partition(|(_, rule)| rule.usage == InputUsage::Read);
        read.iter().for_each(|(parameter, rule)| check_parameter(card, rule, parameter, self.diagnostics));
        let has_error = self.diagnostics.error_count() > errors_before;
        for (parameter, rule) in others {
            let (name, keyword) = (parameter.name, card.keyword.name);
            match rule.usage {
                // After an unsupported value, parameters of this value are consequential.
                InputUsage::Refused(why) if has_error && why.starts_with("applies only to") => {}
                InputUsage::Read => {}
                InputUsage::Refused(why) => {
                    let message = format!("{name} on *{keyword} is not supported");
                    self.refuse(parameter.span, message, why);
                }
                InputUsage::Only(values, why) => {
                    if let Some(word) = parameter.value.as_ref().filter(|w| !is_one_of(w, values)) {
                        self.refuse(word.span, format!("{name}={} on *{keyword} is not supported", word.text), why);
                    } else if parameter.value.is_none() && !values.contains(&"YES") {
                        let message =
                            format!("{name} of *{keyword} requires a value; supported: {}", values.join(" or "));
                        self.diagnostics.push(Diagnostic::error("M103", message).at(parameter.span, "no value"));
                    }
                }
                InputUsage::Inert(note) => self.inert(format!("{keyword}, {name}"), parameter.span, note),
            }
        }
    }

    fn refuse(&mut self, span: Span, message: String, why: &str) {
        self.diagnostics.push(Diagnostic::error("M104", message).at(span, "not supported").help(why));
    }

    /// Records ignored input, once per kind.
    fn inert(&mut self, keyword: String, span: Span, why: &str) {
        match self.inert.iter_mut().find(|(inert, _)| inert.keyword == keyword) {
            Some((_, count)) => *count += 1,
            None => self.inert.push((IgnoredCard { keyword, span, why: why.into() }, 1)),
        }
    }

    fn data(&mut self, card: &Card) {
        let shape = card.shape();
        if let DataShape::Text(rule) = shape {
            if let (InputUsage::Inert(note), Some(line)) = (rule.usage, card.lines.first()) {
                self.inert(format!("{}, {}", card.keyword.name, rule.name), line.span, note);
            }
            return;
        }
        let error_count = self.diagnostics.error_count();
        let mut faults = DataFaults::default();
        let mut values_before = 0;
        for (i, line) in card.lines.iter().enumerate() {
            self.line(card, shape, LinePlace { index: i, values_before }, line, &mut faults);
            values_before = shape.values_after(values_before, line.fields.len());
        }
        for (i, row) in card.rows.iter().enumerate() {
            let count = row.field_count(self.sources);
            let read = |k| shape.field(i, k, values_before).is_some_and(|rule| rule.usage == InputUsage::Read);
            if !(0..count).all(read) {
                let line = row.line(self.sources);
                self.line(card, shape, LinePlace { index: i, values_before }, &line, &mut faults);
            }
            values_before = shape.values_after(values_before, count);
        }
        faults.report(card, self.diagnostics);
        let of_values = std::mem::take(&mut self.of_values);
        // After a surplus value, errors in other values are consequential.
        if self.diagnostics.error_count() == error_count {
            self.diagnostics.append(of_values);
        }
        if self.diagnostics.error_count() == error_count {
            check_lines(card, self.diagnostics);
        }
    }

    fn line(
        &mut self,
        card: &Card,
        shape: &'static DataShape,
        LinePlace { index, values_before }: LinePlace,
        line: &DataLine,
        faults: &mut DataFaults,
    ) {
        for (k, word) in line.fields.iter().enumerate().filter(|(_, w)| !w.text.is_empty()) {
            let Some(rule) = shape.field(index, k, values_before) else {
                let surplus_line = shape.field(index, 0, values_before).is_none();
                let comma = decimal_comma(line, k);
                faults.note(if surplus_line { DataFault::Line } else { DataFault::Value(comma) }, word, line);
                return;
            };
            // The temperature of a single row has no effect.
            let idle = rule.name == "temperature" && card.line_count() == 1;
            match rule.usage {
                InputUsage::Read => {
                    check_value(card, rule, word, &mut self.of_values);
                    if let Some(meant) = decimal_comma(line, k).filter(|_| idle) {
                        faults.note(DataFault::Comma(rule, meant), word, line);
                    }
                }
                InputUsage::Refused(why) => faults.note(DataFault::Refused(rule, why), word, line),
                InputUsage::Only(values, why) => {
                    if !is_one_of(word, values) {
                        faults.note(DataFault::Refused(rule, why), word, line);
                    }
                }
                InputUsage::Inert(note) => {
                    self.inert(format!("{}, {}", card.keyword.name, rule.name), word.span, note);
                    if let Some(meant) = decimal_comma(line, k) {
                        faults.note(DataFault::Comma(rule, meant), word, line);
                    }
                }
            }
        }
    }
}

/// Place of a data line in its card: index, and number of values on the lines before it ([`DataShape::field`]).
#[derive(Clone, Copy)]
struct LinePlace {
    index: usize,
    values_before: usize,
}

/// Fault of a value on a data line.
enum DataFault {
    /// The card allows no such line.
    Line,
    /// The card allows no such value; the number that a decimal comma would mean.
    Value(Option<String>),
    /// The value is unsupported.
    Refused(&'static InputRule, &'static str),
    /// The value is ignored, and looks like the decimals of the previous number.
    Comma(&'static InputRule, String),
}

impl DataFault {
    fn same_kind(&self, other: &DataFault) -> bool {
        match (self, other) {
            (DataFault::Refused(a, _), DataFault::Refused(b, _)) => a.name == b.name,
            (a, b) => std::mem::discriminant(a) == std::mem::discriminant(b),
        }
    }
}

/// First fault of a kind on a card.
struct FirstFault {
    fault: DataFault,
    word: Word,
    /// Source position of the data line.
    line: Span,
    /// Number of lines with this kind of fault.
    count: usize,
}

/// Faults of one card, one of each kind.
#[derive(Default)]
struct DataFaults(Vec<FirstFault>);

impl DataFaults {
    fn note(&mut self, fault: DataFault, word: &Word, line: &DataLine) {
        match self.0.iter_mut().find(|first| first.fault.same_kind(&fault)) {
            Some(first) => first.count += 1,
            None => self.0.push(FirstFault { fault, word: word.clone(), line: line.span, count: 1 }),
        }
    }

    fn report(self, card: &Card, diagnostics: &mut Diagnostics) {
        for first in self.0 {
            let mut diagnostic = diagnostic(card, &first);
            if first.count > 1 {
                diagnostic.message += &format!(" (on {} lines)", first.count);
            }
            diagnostics.push(diagnostic);
        }
    }
}

fn diagnostic(card: &Card, FirstFault { fault, word: Word { text, span, .. }, line, .. }: &FirstFault) -> Diagnostic {
    let keyword = card.keyword.name;
    let table = matches!(card.shape(), DataShape::Lines(_, true)) && card.line_count() == 1;
    let rows = if table { "a table has one row per line; " } else { "" };
    let explain = format!("{rows}`revolve explain {keyword}` lists the values of a data line");
    match fault {
        DataFault::Line if card.keyword.data.is_empty() => {
            Diagnostic::error("M162", format!("*{keyword} has no data lines")).at(*line, "unexpected data line")
        }
        DataFault::Line => {
            let diagnostic = Diagnostic::error("M162", format!("*{keyword} has no further data line"));
            diagnostic.at(*line, "unexpected data line").help(explain)
        }
        DataFault::Value(meant) => {
            let diagnostic =
                Diagnostic::error("M161", format!("too many values on a data line of *{keyword}: `{text}`"));
            diagnostic.at(*span, "unexpected value").help(match meant {
                Some(meant) => format!("if this is a decimal comma, write {meant}"),
                None => explain,
            })
        }
        DataFault::Refused(rule, why) => {
            let message = format!("{} ({text}) on a line of *{keyword} is not supported", rule.name);
            Diagnostic::error("M104", message).at(*span, "not supported").help(*why)
        }
        DataFault::Comma(rule, meant) => {
            let message = format!("`{text}` is read as the {} of *{keyword}, which has no effect", rule.name);
            let diagnostic = Diagnostic::warning("M163", message).at(*span, "directly after a comma");
            diagnostic.help(format!("if this is a decimal comma, write {meant}"))
        }
    }
}

/// Returns whether a word is one of these values; numbers are compared by value, other words without case and blanks.
fn is_one_of(word: &Word, values: &[&str]) -> bool {
    let number = parse_number(&word.text).ok();
    values.iter().any(|v| match (number, parse_number(v).ok()) {
        (Some(a), Some(b)) => a == b,
        _ => fold(&word.text) == fold(v),
    })
}

/// Returns the number that two fields would form with a decimal point in place of the comma, if both are digits next to
/// it.
fn decimal_comma(line: &DataLine, index: usize) -> Option<String> {
    let (previous, word) = (line.fields.get(index.checked_sub(1)?)?, &line.fields[index]);
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let close = previous.span.file == word.span.file && previous.span.end + 1 == word.span.start;
    let whole = previous.text.strip_prefix(['-', '+']).unwrap_or(&previous.text);
    let decimals = word.text.split(['e', 'E', 'd', 'D']).next().unwrap_or("");
    let fits = close && digits(whole) && digits(decimals) && parse_number(&word.text).is_ok();
    fits.then(|| format!("{}.{}", previous.text, word.text))
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
        let reported = codes("*Material, name=A\n*Density\n7850,5\n*Elastic\n210,5, 0,3\n");
        assert!(reported[0].starts_with("M163") && reported[0].ends_with("write 7850.5"), "{reported:?}");
        assert!(reported[1].starts_with("M161") && reported[1].ends_with("write 0.3"), "{reported:?}");
        assert!(codes("*Material, name=A\n*Density\n7850., 20.\n").is_empty());
    }

    #[test]
    fn duplicate_cards_are_reported() {
        let twice = "*Material, name=A\n*Density\n1.,\n*Density\n2.,\n*Material, name=a\n*Density\n1.,\n";
        assert_eq!(codes(twice).iter().filter(|c| c.starts_with("M160")).count(), 2);
        assert!(codes("*Density\n1.,\n")[0].starts_with("M105"));
    }
}
