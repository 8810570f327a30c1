//! The one keyword table: parser, model, `explain` and the keyword manual all read it. Here is the look-up; its types stand in
//! `rule.rs`, the rows in `table/`.
//! Never here: what a card does.

use super::names;
pub use super::rule::{Data, Keyword, Place, Rule, Shape, Tier, Times, Usage};
use super::table;

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
