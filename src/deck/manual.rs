//! The keyword manual, made from the keyword table.
//! Never here: the table.

use std::fmt::Write as _;

use super::keywords::{KEYWORDS, Keyword, Lookup, Tier, find_keyword};

/// The text of `docs/keywords.md`.
pub fn keyword_manual() -> String {
    let mut text = String::from(
        "# Keywords\n\nMade from the keyword table by `revolve explain keywords`; a test keeps it true. Names may be \
         abbreviated, case and blanks do not matter.\n",
    );
    for (tier, title) in TITLES {
        let _ = write!(text, "\n## {title}\n\n");
        for keyword in KEYWORDS.iter().filter(|k| k.tier == *tier) {
            if *tier == Tier::Used {
                text += &entry(keyword);
            } else {
                let _ = writeln!(text, "- `*{}`", keyword.name);
            }
        }
    }
    text
}

const TITLES: &[(Tier, &str)] = &[
    (Tier::Used, "Used"),
    (Tier::Parsed, "Read, used as capabilities arrive"),
    (Tier::OutputOnly, "Accepted; they concern other programs' output"),
    (Tier::UnsupportedPhysics, "Known, not supported: an error"),
    (Tier::UnsupportedInert, "Known, not supported: a note"),
];

/// What `revolve explain KEYWORD` says.
pub fn explain_keyword(word: &str) -> Option<String> {
    match find_keyword(word.trim_start_matches('*')) {
        Lookup::Found(keyword) => Some(entry(keyword)),
        _ => None,
    }
}

fn entry(keyword: &Keyword) -> String {
    let extension = if keyword.extension { " (extension: not in ABAQUS)" } else { "" };
    let mut text = format!("### *{}{extension}\n\n{}\n\n", keyword.name, keyword.summary);
    for parameter in keyword.parameters {
        let _ = writeln!(text, "- `{}`: {}", parameter.name, parameter.help);
    }
    for line in keyword.data {
        let _ = writeln!(text, "- data: {line}");
    }
    text + "\n"
}
