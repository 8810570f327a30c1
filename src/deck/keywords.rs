//! The one keyword table: parser, model, `explain` and the keyword manual all read it. Here are its types and the look-up;
//! the rows stand in `table/`.
//! Never here: what a card does.

use super::names;
use super::table;

/// What is done with a keyword.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tier {
    /// Read and obeyed.
    Used,
    /// Read and checked; it cannot change a result here, and the ledger says why.
    Inert(&'static str),
    /// Changes only output files of another program: accepted, one summary note.
    OutputOnly,
    /// Known and not supported; ignoring it would change the physics: an error.
    UnsupportedPhysics,
    /// Known and not supported; ignoring it changes no result: a note.
    UnsupportedInert,
}

/// What is done with a parameter or a field of a data line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Usage {
    /// It is obeyed: another value gives another result, or is told to be wrong.
    Read,
    /// These values say what is done anyway; every other is an error, for this reason.
    Only(&'static [&'static str], &'static str),
    /// It changes nothing here; the ledger says so with this note.
    Inert(&'static str),
    /// It is an error, for this reason.
    Refused(&'static str),
}

/// A parameter that a keyword line may carry, or a field of its data lines.
#[derive(Debug)]
pub struct Rule {
    /// Canonical name; of parameters upper case with single blanks.
    pub name: &'static str,
    /// What is done with it.
    pub usage: Usage,
    /// One line for the manual; empty where the name says it, or the usage does.
    pub help: &'static str,
    /// Not in ABAQUS: ours.
    pub extension: bool,
}

/// What the data lines of a card hold.
#[derive(Debug)]
pub enum Shape {
    /// Nothing: the card has no data lines.
    Nothing,
    /// Lines of free text.
    Text(Rule),
    /// Any number of values on any number of lines.
    List(Rule),
    /// Values that repeat in this order over any number of lines; the reader of the card counts them.
    Stream(&'static [Rule]),
    /// Records of so many values, each of which begins on a line of its own and goes on on the next where it is full; the
    /// last rule stands for all values behind it.
    Wrapped(usize, &'static [Rule]),
    /// These lines in this order; `true`: the last of them repeats.
    Lines(&'static [&'static [Rule]], bool),
}

/// A shape, and when the data lines have it.
#[derive(Debug)]
pub struct Data {
    /// The parameter and the value that it must have (empty: any); `None`: in every other case.
    pub when: Option<(&'static str, &'static str)>,
    /// The shape.
    pub shape: Shape,
}

/// How often a card may be given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Times {
    /// Any number of times.
    Any,
    /// Once in its place.
    Once,
    /// Once for each value of this parameter.
    Unique(&'static str),
}

/// Where a card stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Anywhere.
    Anywhere,
    /// In a step.
    Step,
    /// Below a card of this kind, with none between but its kin.
    Below(&'static str),
}

/// One keyword.
#[derive(Debug)]
pub struct Keyword {
    /// Canonical name, upper case, single blanks, no star.
    pub name: &'static str,
    /// What is done with it.
    pub tier: Tier,
    /// Not in ABAQUS: ours.
    pub extension: bool,
    /// One line for the manual.
    pub summary: &'static str,
    /// How often it may be given.
    pub times: Times,
    /// Where it stands.
    pub place: Place,
    /// The parameters it may carry.
    pub parameters: &'static [Rule],
    /// What its data lines hold: the first entry that applies.
    pub data: &'static [Data],
}

impl Keyword {
    /// The rule of a parameter by its canonical name.
    pub fn rule(&self, name: &str) -> Option<&'static Rule> {
        self.parameters.iter().find(|r| r.name == name)
    }

    /// What the data lines hold where `value` gives the text of a parameter (`Some(None)` for one without value).
    pub fn shape<'v>(&self, value: impl Fn(&str) -> Option<Option<&'v str>>) -> &'static Shape {
        let applies = |data: &&Data| match data.when {
            None => true,
            Some((name, wanted)) => value(name)
                .is_some_and(|v| wanted.is_empty() || v.is_some_and(|v| names::fold(v) == names::fold(wanted))),
        };
        self.data.iter().find(applies).map_or(&Shape::Nothing, |data| &data.shape)
    }
}

impl Shape {
    /// The rule of a field, by the index of its line and its own; `None` for a value that the card does not take.
    /// `before` counts the values on the lines above, of streams and records that go on over lines.
    pub fn field(&'static self, line: usize, index: usize, before: usize) -> Option<&'static Rule> {
        match self {
            Shape::Nothing => None,
            Shape::Text(rule) | Shape::List(rule) => Some(rule),
            Shape::Stream(rules) => rules.get((before + index) % rules.len()),
            Shape::Wrapped(count, rules) => {
                let at = before % count + index;
                (at < *count).then(|| &rules[at.min(rules.len() - 1)])
            }
            Shape::Lines(lines, repeats) => {
                let row = if *repeats { line.min(lines.len() - 1) } else { line };
                lines.get(row)?.get(index)
            }
        }
    }

    /// All rules of its fields.
    pub fn rules(&self) -> Vec<&Rule> {
        match self {
            Shape::Nothing => Vec::new(),
            Shape::Text(rule) | Shape::List(rule) => vec![rule],
            Shape::Stream(rules) | Shape::Wrapped(_, rules) => rules.iter().collect(),
            Shape::Lines(lines, _) => lines.iter().flat_map(|l| l.iter()).collect(),
        }
    }
}

/// What looking a name up came to.
#[derive(Debug)]
pub enum Lookup<T: 'static> {
    /// Exactly this one.
    Found(&'static T),
    /// An abbreviation of several.
    Ambiguous(Vec<&'static T>),
    /// None; the one most like it, if any is.
    Unknown {
        /// The most similar name.
        nearest: Option<&'static T>,
    },
}

/// Every keyword that is known, in the order of the manual.
pub fn keywords() -> impl Iterator<Item = &'static Keyword> + Clone {
    table::ALL.iter().flat_map(|part| part.iter())
}

/// The keyword a text (without its star) means: case and blanks aside, abbreviated if that leaves no doubt.
pub fn find_keyword(text: &str) -> Lookup<Keyword> {
    find(text, keywords(), |k| k.name)
}

/// The parameter of a keyword that a text means, by the same rules.
pub fn find_parameter(keyword: &Keyword, text: &str) -> Lookup<Rule> {
    find(text, keyword.parameters.iter(), |p| p.name)
}

/// Whether the text is a parameter's full name, case and blanks aside.
pub fn is_parameter(keyword: &Keyword, text: &str) -> bool {
    let wanted = names::fold(text);
    keyword.parameters.iter().any(|p| same(&wanted, p.name))
}

fn find<T>(text: &str, table: impl Iterator<Item = &'static T> + Clone, name: fn(&T) -> &'static str) -> Lookup<T> {
    let wanted = names::fold(text);
    if let Some(row) = table.clone().find(|row| same(&wanted, name(row))) {
        return Lookup::Found(row);
    }
    let begun: Vec<&T> = table.clone().filter(|row| !wanted.is_empty() && begins(&wanted, name(row))).collect();
    match begun.as_slice() {
        [] => {
            let nearest = names::nearest(&wanted, table.clone().map(name));
            Lookup::Unknown { nearest: nearest.and_then(|n| table.clone().find(|row| name(row) == n)) }
        }
        [row] => Lookup::Found(row),
        _ => Lookup::Ambiguous(begun),
    }
}

/// Whether a folded text is the whole name.
fn same(folded: &str, name: &str) -> bool {
    folded.bytes().eq(name.bytes().filter(|b| *b != b' '))
}

/// Whether a folded text is the beginning of the name.
fn begins(folded: &str, name: &str) -> bool {
    let mut letters = name.bytes().filter(|b| *b != b' ');
    folded.bytes().all(|b| letters.next() == Some(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keyword(text: &str) -> &'static str {
        match find_keyword(text) {
            Lookup::Found(k) => k.name,
            Lookup::Ambiguous(_) => "ambiguous",
            Lookup::Unknown { nearest } => nearest.map_or("unknown", |k| k.name),
        }
    }

    fn parameter(card: &str, text: &str) -> &'static str {
        let Lookup::Found(k) = find_keyword(card) else { return "no such keyword" };
        match find_parameter(k, text) {
            Lookup::Found(p) => p.name,
            Lookup::Ambiguous(_) => "ambiguous",
            Lookup::Unknown { nearest } => nearest.map_or("unknown", |p| p.name),
        }
    }

    #[test]
    fn keywords_as_written() {
        assert_eq!(keyword("RIGIDBODY"), "RIGID BODY");
        assert_eq!(keyword("section Control"), "SECTION CONTROLS");
        assert_eq!(keyword("Node"), "NODE");
        assert_eq!(keyword("N"), "ambiguous");
        assert_eq!(keyword("Elastc"), "ELASTIC");
        assert_eq!(keyword("  end  step"), "END STEP");
        assert_eq!(keyword("Zzz"), "unknown");
        assert_eq!(keyword(""), "unknown");
    }

    #[test]
    fn parameters_as_written() {
        assert_eq!(parameter("OUTPUT", "freq"), "FREQUENCY");
        assert_eq!(parameter("OUTPUT", "VAR"), "VARIABLE");
        assert_eq!(parameter("OUTPUT", "TIMEMARKS"), "TIME MARKS");
        assert_eq!(parameter("OUTPUT", "TIMEINT"), "TIME INTERVAL");
        assert_eq!(parameter("OUTPUT", "TIME"), "ambiguous");
        assert_eq!(parameter("NSET", "GEN"), "GENERATE");
        assert_eq!(parameter("SECTION CONTROLS", "HOUR GLASS"), "HOURGLASS");
    }

    #[test]
    fn table_is_tidy() {
        for (i, keyword) in keywords().enumerate() {
            assert_eq!(keyword.name, keyword.name.to_ascii_uppercase());
            assert!(!keyword.summary.is_empty(), "{}", keyword.name);
            assert!(keywords().take(i).all(|k| names::fold(k.name) != names::fold(keyword.name)), "{}", keyword.name);
            for (j, rule) in keyword.parameters.iter().enumerate() {
                assert!(keyword.parameters[..j].iter().all(|r| r.name != rule.name), "{} {}", keyword.name, rule.name);
            }
        }
    }
}
