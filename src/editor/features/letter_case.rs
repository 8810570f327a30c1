//! Upper and lower case of words that the server writes: as in their line. Decks are read without regard to case.

use super::FeatureContext;
use crate::protocol::TextEdit;

/// Returns whether a line has more lower-case than upper-case letters.
pub fn prefers_lower(line: &str) -> bool {
    let count = |is: fn(&char) -> bool| line.chars().filter(is).count();
    count(|c| c.is_ascii_lowercase()) > count(|c| c.is_ascii_uppercase())
}

/// Writes the first letter of each word in upper case and the others in lower case.
pub fn title_case(text: &str) -> String {
    let mut begins = true;
    let letter = |c: char| {
        let written = if begins { c.to_ascii_uppercase() } else { c.to_ascii_lowercase() };
        begins = !c.is_alphanumeric();
        written
    };
    text.chars().map(letter).collect()
}

/// Writes the correction of a diagnostic in the case of its line, and names as they are defined.
pub fn correction_as_in_line(context: &FeatureContext<'_>, code: &str, edit: &TextEdit) -> TextEdit {
    let line = context.text.line(edit.range.start.line);
    let bytes = [edit.range.start, edit.range.end].map(|place| context.encoding.byte(line, place.character));
    let replaced = line.get(bytes[0]..bytes[1]).unwrap_or_default();
    let outline = context.root.outline;
    let is_keyword = edit.new_text.starts_with('*') && !edit.new_text.starts_with("**");
    let name = edit.new_text.to_uppercase();
    let defined = || outline.names.iter().find(|one| one.defines && one.name == name);
    let new_text = match code {
        "D103" if prefers_lower(line) => edit.new_text.to_lowercase(),
        "M120" if !replaced.contains(char::is_uppercase) => edit.new_text.to_lowercase(),
        _ if is_keyword && prefers_lower(line) => title_case(&edit.new_text),
        // The check compares names in upper case. Names of parameters are case-sensitive and have codes of the syntax.
        _ if code.starts_with('M') => {
            defined().map_or(edit.new_text.clone(), |one| outline.deck.sources.text(one.span).trim().to_owned())
        }
        _ => edit.new_text.clone(),
    };
    TextEdit { range: edit.range, new_text }
}
