//! The keyword manual, written from the keyword table.
//! Never here: anything the table does not say.

use super::keywords::{Data, Keyword, Lookup, Place, Rule, Shape, Tier, Times, Usage, find_keyword, keywords};
use super::names::fold;
use super::ways;

/// The text of `docs/keywords.md`.
pub fn keyword_manual() -> String {
    let mut text = String::from(HEAD);
    text += &chapter("Used", "Read and obeyed.", |k| k.tier == Tier::Used && !k.extension);
    text += &chapter("Extensions", "Not in ABAQUS: ours.", |k| k.extension);
    text += &table("Inert", "Read and told in the ledger: they can change no result here.", |k| {
        matches!(k.tier, Tier::Inert(_))
    });
    text += &table("Output of another program", "Accepted and told in the ledger: they change no result.", |k| {
        k.tier == Tier::OutputOnly
    });
    text += &table("Unsupported", "Known and refused: without them the answer would be another.", |k| {
        k.tier == Tier::UnsupportedPhysics
    });
    text += &table(
        "Unsupported without effect",
        "Known, ignored and told in the ledger: no result depends on them.",
        |k| k.tier == Tier::UnsupportedInert,
    );
    // What stands in angle brackets is no HTML.
    text.replace('<', "\\<")
}

const HEAD: &str = "# Keywords\n\nWritten from the keyword table; do not edit by hand (`REVOLVE_BLESS=1 cargo test --test deck` writes it anew).\n\
Case and blanks do not count, unambiguous abbreviations are understood. An empty field means its default.\n\
What is *inert* changes nothing and is told in the ledger; what is *refused* is an error with its reason.\n";

fn chapter(title: &str, about: &str, belongs: fn(&Keyword) -> bool) -> String {
    let entries: String = keywords().filter(|k| belongs(k)).map(entry).collect();
    format!("\n## {title}\n\n{about}\n{entries}")
}

fn entry(keyword: &'static Keyword) -> String {
    let mut text = format!("\n### *{}\n\n{}.{}\n", keyword.name, keyword.summary, standing_place(keyword));
    if !keyword.parameters.is_empty() {
        text += "\n";
    }
    for rule in keyword.parameters {
        text += &format!("- `{}`{}\n", rule.name, about(rule));
    }
    let lines: Vec<_> = keyword.data.iter().flat_map(data_lines).collect();
    if !lines.is_empty() {
        text += "\nData lines:\n";
    }
    for (line, words) in lines {
        text += &format!("- {line}\n");
        words.iter().for_each(|word| text += &format!("  - {word}\n"));
    }
    text
}

/// How often the card may be given and where it stands.
fn standing_place(keyword: &Keyword) -> String {
    let place = match keyword.place {
        Place::Anywhere => String::new(),
        Place::Step => " in a step".into(),
        Place::EachStep => " in a step, or before the first".into(),
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
        Usage::Read => {
            let allowed = rule.value.allowed();
            let default = rule.value.default_text().map(|text| format!("default {text}")).unwrap_or_default();
            let parts = [rule.help, allowed.as_str(), default.as_str()].into_iter().filter(|part| !part.is_empty());
            let text = parts.collect::<Vec<_>>().join("; ");
            if text.is_empty() { mark.into() } else { format!("{mark}: {text}") }
        }
        Usage::Only(values, why) => format!("{mark}: only {}; other values are refused: {why}", values.join(" or ")),
        Usage::Inert(note) => format!("{mark}: inert: {note}"),
        Usage::Refused(why) => format!("{mark}: refused: {why}"),
    }
}

/// The data lines of one shape: for each its fields, and what is to be said of single ones.
fn data_lines(data: &'static Data) -> Vec<(String, Vec<String>)> {
    let when = match data.when {
        None => String::new(),
        Some((name, "")) => format!("With {name}: "),
        Some((name, value)) => format!("With {name}={value}: "),
    };
    let line = |rules: &[&Rule], behind: String| {
        let names: Vec<&str> = rules.iter().map(|r| r.name).collect();
        let words = rules.iter().filter(|r| !about(r).is_empty()).map(|r| format!("{}{}", r.name, about(r)));
        (format!("{when}{}{behind}", names.join(", ")), words.collect())
    };
    let rules = data.shape.rules();
    match &data.shape {
        Shape::Nothing => Vec::new(),
        Shape::Text(_) => vec![line(&rules, String::new())],
        Shape::List(_) => vec![line(&rules, "; any number of them, on any number of lines".into())],
        Shape::Stream(_) => vec![line(&rules, "; in turn, on any number of lines".into())],
        Shape::Wrapped(count, _) => vec![line(&rules, format!("; {count} values, if need be on several lines"))],
        Shape::Lines(lines, repeats) => {
            let last = lines.len() - 1;
            let again = |i| if *repeats && i == last { "; any number of such lines" } else { "" };
            let row = |(i, rules): (usize, &&[Rule])| line(&rules.iter().collect::<Vec<_>>(), again(i).into());
            lines.iter().enumerate().map(row).collect()
        }
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

/// The text of `docs/abaqus.md`: every keyword of ABAQUS that is known by name, and what is done with it.
pub fn abaqus_page() -> String {
    let mut rows: Vec<[String; 3]> = keywords().filter(|k| !k.extension).map(abaqus_row).collect();
    rows.sort();
    let count = |what: &str| rows.iter().filter(|r| r[1] == what).count();
    let sums: Vec<String> = ["done", "partly", "inert", "not"].map(|w| format!("{} {w}", count(w))).to_vec();
    let lines: String = rows.iter().map(|[name, done, why]| format!("| `*{name}` | {done} | {why} |\n")).collect();
    format!(
        "{ABAQUS_HEAD}\n{} keywords: {}.\n\n| keyword | | why, and what there is instead |\n|---|---|---|\n{lines}",
        rows.len(),
        sums.join(", ")
    )
}

const ABAQUS_HEAD: &str = "# Keywords of ABAQUS\n\nWritten from the keyword table; do not edit by hand (`REVOLVE_BLESS=1 cargo test --test deck` writes it anew).\n\
*done*: read and obeyed with all that an axisymmetric explicit deck can say. *partly*: obeyed; what is named is refused with its reason.\n\
*inert*: accepted and told in the ledger, for it can change no result here. *not*: refused, for the answer would be another without it.\n\
A keyword that is not in this list is not known to Revolve. What each takes stands in [keywords.md](keywords.md).\n";

fn abaqus_row(keyword: &Keyword) -> [String; 3] {
    let (done, why) = match keyword.tier {
        Tier::Used => match refusals(keyword) {
            refused if refused.is_empty() => ("done", String::new()),
            refused => ("partly", format!("not {}", refused.join(", "))),
        },
        Tier::Inert(why) => ("inert", why.into()),
        Tier::OutputOnly => ("inert", format!("{}: changes only files of another program", keyword.summary)),
        Tier::UnsupportedInert => ("inert", format!("{}: no result depends on it", keyword.summary)),
        Tier::UnsupportedPhysics => match ways::named(keyword.name) {
            "" => ("not", keyword.summary.into()),
            way => ("not", format!("{}; {way}", keyword.summary)),
        },
    };
    [keyword.name.into(), done.into(), why]
}

/// Parameters and fields that a keyword has in an explicit analysis of solids and that are refused here. What belongs to other
/// analyses, as its reason says (`of implicit analyses`), is not missed.
fn refusals(keyword: &Keyword) -> Vec<String> {
    let is_missed = |why: &str| !why.starts_with("of ") && !why.contains("axisymmetric");
    let parameters = keyword
        .parameters
        .iter()
        .filter(|rule| matches!(rule.usage, Usage::Refused(why) | Usage::Only(_, why) if is_missed(why)));
    // A field that takes one value only is empty in other analyses as well.
    let fields = keyword.data.iter().flat_map(|d| d.shape.rules());
    let fields = fields.filter(|rule| matches!(rule.usage, Usage::Refused(why) if is_missed(why)));
    let mut names: Vec<String> = parameters.chain(fields).map(worded).collect();
    names.dedup();
    names
}

fn worded(rule: &Rule) -> String {
    match rule.usage {
        Usage::Only(values, _) => format!("{} other than {}", rule.name, values.join(" or ")),
        _ => rule.name.into(),
    }
}

/// What `revolve explain` says of a keyword, with or without its star, abbreviated or not.
pub fn explain_keyword(name: &str) -> Option<String> {
    match find_keyword(name.trim().trim_start_matches('*')) {
        Lookup::Found(keyword) => Some(explain(keyword)),
        _ => None,
    }
}

/// Names of all keywords.
pub fn keyword_names() -> impl Iterator<Item = &'static str> {
    keywords().map(|keyword| keyword.name)
}

/// Whether a word, with or without its star, is the whole name of a keyword.
pub fn is_keyword(name: &str) -> bool {
    let wanted = fold(name.trim().trim_start_matches('*'));
    keywords().any(|k| fold(k.name) == wanted)
}

fn explain(keyword: &'static Keyword) -> String {
    let width = keyword.parameters.iter().map(|r| r.name.len()).max().unwrap_or(0);
    let (place, standing) = (standing_place(keyword), standing(keyword.tier));
    let mut text = format!("*{}{}: {}.\n{standing}.{place}\n", keyword.name, mark(keyword.extension), keyword.summary);
    for rule in keyword.parameters {
        text += &format!("  {:width$} {}\n", rule.name, about(rule).trim_start_matches(':'));
    }
    for (line, words) in keyword.data.iter().flat_map(data_lines) {
        text += &format!("  data: {line}\n");
        words.iter().for_each(|word| text += &format!("    {word}\n"));
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
