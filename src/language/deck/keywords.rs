//! Search of the keyword table, which the parser, the model, `explain` and the keyword manual share. Its types are in
//! `rule.rs`, its rows in `table/`.

use super::names;
pub use super::rule::{
    CardMultiplicity, CardPlace, ConditionalShape, DataShape, InputRule, InputUsage, Keyword, KeywordTier, parent_names,
};
use super::table;

/// Result of the search for a name.
#[derive(Debug)]
pub enum NameLookup<T: 'static> {
    /// The name, or an unambiguous abbreviation, was found.
    Found(&'static T),
    /// The text is an abbreviation of several names.
    Ambiguous(Vec<&'static T>),
    /// No name was found.
    Unknown,
}

/// Length from which a text is no name.
const LONGEST: usize = 256;

/// Iterates over all keywords, in the order of the manual.
pub fn keywords() -> impl Iterator<Item = &'static Keyword> + Clone {
    table::ALL.iter().flat_map(|part| part.iter())
}

/// Searches for a keyword, given without its star. Case and blanks are ignored; unambiguous abbreviations are accepted.
pub fn find_keyword(text: &str) -> NameLookup<Keyword> {
    find(text, keywords(), |k| k.name)
}

/// Searches for a parameter of a keyword, by the same rules as [`find_keyword`].
pub fn find_parameter(keyword: &Keyword, text: &str) -> NameLookup<InputRule> {
    find(text, keyword.parameters.iter(), |p| p.name)
}

/// Returns the name of the keyword that is most similar to a text.
pub fn nearest_keyword(text: &str) -> Option<&'static str> {
    names::nearest(text, keywords().map(|keyword| keyword.name))
}

/// Returns the name of the parameter of a keyword that is most similar to a text.
pub fn nearest_parameter(keyword: &Keyword, text: &str) -> Option<&'static str> {
    names::nearest(text, keyword.parameters.iter().map(|parameter| parameter.name))
}

/// Returns whether the text is the full name of a parameter, ignoring case and blanks.
pub fn is_parameter(keyword: &Keyword, text: &str) -> bool {
    let folded = names::fold(text);
    keyword.parameters.iter().any(|p| same(&folded, p.name))
}

fn find<T>(text: &str, table: impl Iterator<Item = &'static T> + Clone, name: fn(&T) -> &'static str) -> NameLookup<T> {
    if text.len() > LONGEST {
        return NameLookup::Unknown;
    }
    let folded = names::fold(text);
    if let Some(row) = table.clone().find(|row| same(&folded, name(row))) {
        return NameLookup::Found(row);
    }
    let begun: Vec<&T> = table.clone().filter(|row| !folded.is_empty() && begins(&folded, name(row))).collect();
    match begun.as_slice() {
        [] => NameLookup::Unknown,
        [row] => NameLookup::Found(row),
        _ => NameLookup::Ambiguous(begun),
    }
}

/// Returns whether a folded text equals a name without its blanks.
fn same(folded: &str, name: &str) -> bool {
    folded.bytes().eq(name.bytes().filter(|b| *b != b' '))
}

/// Returns whether a name without its blanks begins with a folded text.
fn begins(folded: &str, name: &str) -> bool {
    let mut letters = name.bytes().filter(|b| *b != b' ');
    folded.bytes().all(|b| letters.next() == Some(b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keyword(text: &str) -> &'static str {
        match find_keyword(text) {
            NameLookup::Found(k) => k.name,
            NameLookup::Ambiguous(_) => "ambiguous",
            NameLookup::Unknown => nearest_keyword(text).unwrap_or("unknown"),
        }
    }

    fn parameter(card: &str, text: &str) -> &'static str {
        let NameLookup::Found(k) = find_keyword(card) else { return "no such keyword" };
        match find_parameter(k, text) {
            NameLookup::Found(p) => p.name,
            NameLookup::Ambiguous(_) => "ambiguous",
            NameLookup::Unknown => nearest_parameter(k, text).unwrap_or("unknown"),
        }
    }

    #[test]
    fn keywords_are_found_in_any_case_and_abbreviated() {
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
    fn parameters_are_found_in_any_case_and_abbreviated() {
        assert_eq!(parameter("OUTPUT", "freq"), "FREQUENCY");
        assert_eq!(parameter("OUTPUT", "VAR"), "VARIABLE");
        assert_eq!(parameter("OUTPUT", "TIMEMARKS"), "TIME MARKS");
        assert_eq!(parameter("OUTPUT", "TIMEINT"), "TIME INTERVAL");
        assert_eq!(parameter("OUTPUT", "TIME"), "ambiguous");
        assert_eq!(parameter("NSET", "GEN"), "GENERATE");
        assert_eq!(parameter("SECTION CONTROLS", "HOUR GLASS"), "HOURGLASS");
    }

    #[test]
    fn names_in_the_table_are_unique_and_upper_case() {
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
