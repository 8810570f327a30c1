//! The keyword manual, written from the keyword table.
//! Never here: anything the table does not say.

use super::keywords::{Data, Keyword, Lookup, Place, Rule, Shape, Tier, Times, Usage, find_keyword, keywords};
use super::names::fold;

/// The text of `docs/keywords.md`.
pub fn keyword_manual() -> String {
    let mut text = String::from(HEAD);
    text += &chapter("Used", "Read and obeyed.", |k| k.tier == Tier::Used && !k.extension);
    text += &chapter("Extensions", "Not in ABAQUS: ours.", |k| k.extension);
    text += &table("Inert", "Read and told in the ledger: they can change no result here.", |k| {
        matches!(k.tier, Tier::Inert(_))
    });
    text += &table("Output of another program", "Accepted with one note: they change no result.", |k| {
        k.tier == Tier::OutputOnly
    });
    text += &table("Unsupported", "Known and refused: without them the answer would be another.", |k| {
        k.tier == Tier::UnsupportedPhysics
    });
    text += &table("Unsupported without effect", "Known and ignored with a note: no result depends on them.", |k| {
        k.tier == Tier::UnsupportedInert
    });
    text
}

const HEAD: &str = "# Keywords\n\nWritten from the keyword table; do not edit by hand (`REVOLVE_BLESS=1 cargo test --test deck` writes it anew).\n\
Case and blanks do not count, unambiguous abbreviations are understood. An empty field means its default.\n\
What is *inert* changes nothing and is told in the ledger; what is *refused* is an error with its reason.\n";

fn chapter(title: &str, about: &str, belongs: fn(&Keyword) -> bool) -> String {
    let entries: String = keywords().filter(|k| belongs(k)).map(entry).collect();
    format!("\n## {title}\n\n{about}\n{entries}")
}

fn entry(keyword: &Keyword) -> String {
    let mut text = format!("\n### *{}\n\n{}.{}\n", keyword.name, keyword.summary, standing_place(keyword));
    if !keyword.parameters.is_empty() {
        text += "\n";
    }
    for rule in keyword.parameters {
        text += &format!("- `{}`{}\n", rule.name, about(rule));
    }
    let lines: Vec<String> = keyword.data.iter().flat_map(data_lines).collect();
    if !lines.is_empty() {
        text += "\nData lines:\n";
    }
    lines.iter().for_each(|line| text += &format!("- {line}\n"));
    text
}

/// How often the card may be given and where it stands.
fn standing_place(keyword: &Keyword) -> String {
    let place = match keyword.place {
        Place::Anywhere => String::new(),
        Place::Step => " in a step".into(),
        Place::Below(parent) => format!(" below its *{parent}"),
    };
    match (keyword.times, place.as_str()) {
        (Times::Any, "") => String::new(),
        (Times::Any, place) => format!(" Stands{place}."),
        (Times::Once, place) => format!(" Given once{place}."),
        (Times::Unique(name), place) => format!(" Given once for each {name}{place}."),
    }
}

/// What is done with a parameter or a field, to stand behind its name.
fn about(rule: &Rule) -> String {
    let mark = mark(rule.extension);
    match rule.usage {
        Usage::Read if rule.help.is_empty() => mark.into(),
        Usage::Read => format!("{mark}: {}", rule.help),
        Usage::Only(values, why) => format!("{mark}: only {}; other values are refused: {why}", values.join(" or ")),
        Usage::Inert(note) => format!("{mark}: inert: {note}"),
        Usage::Refused(why) => format!("{mark}: refused: {why}"),
    }
}

/// The data lines of one shape, a text for each.
fn data_lines(data: &Data) -> Vec<String> {
    let when = match data.when {
        None => String::new(),
        Some((name, "")) => format!("With {name}: "),
        Some((name, value)) => format!("With {name}={value}: "),
    };
    let row = |rules: &[Rule]| rules.iter().map(field).collect::<Vec<_>>().join(", ");
    match &data.shape {
        Shape::Nothing => Vec::new(),
        Shape::Text(rule) => vec![format!("{when}{}", field(rule))],
        Shape::List(rule) => vec![format!("{when}{}; any number of them, on any number of lines", field(rule))],
        Shape::Stream(rules) => vec![format!("{when}{}; in turn, on any number of lines", row(rules))],
        Shape::Wrapped(count, rules) => {
            vec![format!("{when}{}; {count} values, if need be on several lines", row(rules))]
        }
        Shape::Lines(lines, repeats) => {
            let last = lines.len() - 1;
            let again = |i: usize| if *repeats && i == last { "; any number of such lines" } else { "" };
            lines.iter().enumerate().map(|(i, line)| format!("{when}{}{}", row(line), again(i))).collect()
        }
    }
}

fn field(rule: &Rule) -> String {
    let about = about(rule);
    match about.strip_prefix(": ") {
        Some(about) => format!("{} ({about})", rule.name),
        None => rule.name.into(),
    }
}

fn table(title: &str, about: &str, belongs: fn(&Keyword) -> bool) -> String {
    let why = |k: &Keyword| if let Tier::Inert(why) = k.tier { format!(": {why}") } else { String::new() };
    let line = |k: &Keyword| format!("- `*{}`: {}{}\n", k.name, k.summary, why(k));
    let lines: String = keywords().filter(|k| belongs(k)).map(line).collect();
    format!("\n## {title}\n\n{about}\n\n{lines}")
}

fn mark(extension: bool) -> &'static str {
    if extension { " (extension)" } else { "" }
}

/// What `revolve explain` says of a keyword, with or without its star, abbreviated or not.
pub fn explain_keyword(name: &str) -> Option<String> {
    match find_keyword(name.trim().trim_start_matches('*')) {
        Lookup::Found(keyword) => Some(explain(keyword)),
        _ => None,
    }
}

/// Whether a word, with or without its star, is the whole name of a keyword.
pub fn is_keyword(name: &str) -> bool {
    let wanted = fold(name.trim().trim_start_matches('*'));
    keywords().any(|k| fold(k.name) == wanted)
}

fn explain(keyword: &Keyword) -> String {
    let width = keyword.parameters.iter().map(|r| r.name.len()).max().unwrap_or(0);
    let (place, standing) = (standing_place(keyword), standing(keyword.tier));
    let mut text = format!("*{}{}: {}.\n{standing}.{place}\n", keyword.name, mark(keyword.extension), keyword.summary);
    for rule in keyword.parameters {
        text += &format!("  {:width$} {}\n", rule.name, about(rule).trim_start_matches(':'));
    }
    for line in keyword.data.iter().flat_map(data_lines) {
        text += &format!("  data: {line}\n");
    }
    text
}

fn standing(tier: Tier) -> String {
    match tier {
        Tier::Used => "Supported".into(),
        Tier::Inert(why) => format!("Accepted without effect: {why}"),
        Tier::OutputOnly => "Accepted and ignored: changes only output of another program".into(),
        Tier::UnsupportedPhysics => "Not supported: a deck with it is refused".into(),
        Tier::UnsupportedInert => "Not supported; ignored, for no result depends on it".into(),
    }
}
