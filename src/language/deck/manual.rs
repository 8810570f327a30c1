//! Keyword manual, list of ABAQUS keywords and `revolve explain`, generated from the keyword table.

use super::keywords::{
    CardMultiplicity, CardPlace, ConditionalShape, DataShape, InputRule, InputUsage, Keyword, KeywordTier, NameLookup,
    find_keyword, keywords, parent_names,
};
use super::names::fold;
use super::ways;

/// Returns the text of `docs/keywords.md`.
pub fn keyword_manual() -> String {
    let mut text = String::from(HEAD);
    text += &chapter("Supported", "Keywords of ABAQUS that are supported.", |k| {
        k.tier == KeywordTier::Used && !k.extension
    });
    text += &chapter("Extensions", "Keywords that ABAQUS does not have.", |k| k.extension);
    text += &table("Ignored", "Accepted and listed in the ledger; they cannot change a result here.", |k| {
        matches!(k.tier, KeywordTier::Inert(_))
    });
    text += &table(
        "Output of ABAQUS",
        "Accepted and listed in the ledger; they change only output files of ABAQUS.",
        |k| k.tier == KeywordTier::OutputOnly,
    );
    text += &table("Unsupported", "These keywords are errors, because ignoring them would change the result.", |k| {
        k.tier == KeywordTier::UnsupportedPhysics
    });
    text +=
        &table("Unsupported without effect", "Ignored and listed in the ledger; they do not affect the result.", |k| {
            k.tier == KeywordTier::UnsupportedInert
        });
    // Text in angle brackets must not be read as HTML.
    text.replace('<', "\\<")
}

const HEAD: &str = "# Keywords\n\nGenerated from the keyword table; do not edit by hand (`REVOLVE_BLESS=1 cargo test --test deck` updates it).\n\
Case and blanks are ignored; unambiguous abbreviations are accepted. An empty field has its default.\n\
*Ignored* input has no effect and is listed in the ledger; *unsupported* input is an error with its reason.\n";

fn chapter(title: &str, about: &str, belongs: fn(&Keyword) -> bool) -> String {
    let entries: String = keywords().filter(|k| belongs(k)).map(entry).collect();
    format!("\n## {title}\n\n{about}\n{entries}")
}

fn entry(keyword: &'static Keyword) -> String {
    let head = format!("\n### *{}\n\n{}.{}\n", keyword.name, keyword.summary, standing_place(keyword));
    head + &parameters_and_data(keyword)
}

/// Lists the parameters and data lines of a keyword as Markdown.
fn parameters_and_data(keyword: &'static Keyword) -> String {
    let mut text = String::new();
    if !keyword.parameters.is_empty() {
        text += "\n";
    }
    for rule in keyword.parameters {
        text += &format!("- `{}`{}\n", rule.name, about(rule));
    }
    let lines: Vec<_> = keyword.data.iter().flat_map(data_lines).collect();
    if !lines.is_empty() {
        text += "\nData lines:\n\n";
    }
    for (line, words) in lines {
        text += &format!("- {line}\n");
        words.iter().for_each(|word| text += &format!("  - {word}\n"));
    }
    text
}

/// Describes how often the card may be given, and where.
fn standing_place(keyword: &Keyword) -> String {
    let position = match keyword.place {
        CardPlace::Anywhere => String::new(),
        CardPlace::Step => " within a step".into(),
        CardPlace::EachStep => " within a step, or before the first step".into(),
        CardPlace::Below(parents) => format!(" after its {}", parent_names(parents)),
    };
    match (keyword.times, position.as_str()) {
        (CardMultiplicity::Any, "") => String::new(),
        (CardMultiplicity::Any, position) => format!(" Allowed{position}."),
        (CardMultiplicity::Once, position) => format!(" Allowed once{position}."),
        (CardMultiplicity::Unique(name), position) => format!(" Allowed once for each {name}{position}."),
    }
}

/// Describes the support, allowed values and default of a parameter or field; follows its name.
fn about(rule: &InputRule) -> String {
    let mark = mark(rule.extension);
    match rule.usage {
        InputUsage::Read => {
            let allowed = rule.value.allowed();
            let default = rule.value.default_text().map(|text| format!("default {text}")).unwrap_or_default();
            let parts = [rule.help, allowed.as_str(), default.as_str()].into_iter().filter(|part| !part.is_empty());
            let text = parts.collect::<Vec<_>>().join("; ");
            if text.is_empty() { mark.into() } else { format!("{mark}: {text}") }
        }
        InputUsage::Only(values, why) => {
            format!("{mark}: only {}; other values are unsupported: {why}", values.join(" or "))
        }
        InputUsage::Inert(note) => format!("{mark}: ignored: {note}"),
        InputUsage::Refused(why) => format!("{mark}: unsupported: {why}"),
    }
}

/// Describes the data lines of a layout: the fields of each line, and notes on single fields.
fn data_lines(data: &'static ConditionalShape) -> Vec<(String, Vec<String>)> {
    let when = match data.when {
        None => String::new(),
        Some((name, [])) => format!("With {name}: "),
        Some((name, values)) => format!("With {name}={}: ", values.join(" or ")),
    };
    let line = |rules: &[&InputRule], behind: String| {
        let names: Vec<&str> = rules.iter().map(|r| r.name).collect();
        let words = rules.iter().filter(|r| !about(r).is_empty()).map(|r| format!("{}{}", r.name, about(r)));
        (format!("{when}{}{behind}", names.join(", ")), words.collect())
    };
    let rules = data.shape.rules();
    match &data.shape {
        DataShape::Nothing => Vec::new(),
        DataShape::Text(_) => vec![line(&rules, String::new())],
        DataShape::List(_) => vec![line(&rules, "; any number of values, on any number of lines".into())],
        DataShape::Stream(_) => vec![line(&rules, "; repeated in this order, on any number of lines".into())],
        DataShape::Wrapped(count, _) => {
            vec![line(&rules, format!("; {count} values, which may continue on further lines"))]
        }
        DataShape::Lines(lines, repeats) => {
            let last = lines.len() - 1;
            let again = |i| if *repeats && i == last { "; any number of such lines" } else { "" };
            let row = |(i, rules): (usize, &&[InputRule])| line(&rules.iter().collect::<Vec<_>>(), again(i).into());
            lines.iter().enumerate().map(row).collect()
        }
    }
}

fn table(title: &str, about: &str, belongs: fn(&Keyword) -> bool) -> String {
    let why = |k: &Keyword| if let KeywordTier::Inert(why) = k.tier { format!(": {why}") } else { String::new() };
    let line = |k: &Keyword| format!("- `*{}`: {}{}\n", k.name, k.summary, why(k));
    let lines: String = keywords().filter(|k| belongs(k)).map(line).collect();
    format!("\n## {title}\n\n{about}\n\n{lines}")
}

fn mark(extension: bool) -> &'static str {
    if extension { " (extension)" } else { "" }
}

/// Returns the text of `docs/abaqus.md`: the keywords of ABAQUS and their support.
pub fn abaqus_page() -> String {
    let mut rows: Vec<[String; 3]> = keywords().filter(|k| !k.extension).map(abaqus_row).collect();
    rows.sort();
    let count = |what: &str| rows.iter().filter(|r| r[1] == what).count();
    let sums: Vec<String> =
        ["supported", "partial", "ignored", "unsupported"].map(|w| format!("{} {w}", count(w))).to_vec();
    let lines: String = rows.iter().map(|[name, done, why]| format!("| `*{name}` | {done} | {why} |\n")).collect();
    format!(
        "{ABAQUS_HEAD}\n{} keywords: {}.\n\n| keyword | support | unsupported parameters, reason, alternative |\n|---|---|---|\n{lines}",
        rows.len(),
        sums.join(", ")
    )
}

const ABAQUS_HEAD: &str = "# Keywords of ABAQUS\n\nGenerated from the keyword table; do not edit by hand (`REVOLVE_BLESS=1 cargo test --test deck` updates it).\n\
*supported*: with all options of an axisymmetric explicit analysis. *partial*: the options listed are unsupported and give an error.\n\
*ignored*: accepted and listed in the ledger, because it cannot change a result here. *unsupported*: an error, because ignoring it would change the result.\n\
Keywords that are not in this list are unknown to Revolve. [keywords.md](keywords.md) describes the parameters and data lines.\n";

fn abaqus_row(keyword: &Keyword) -> [String; 3] {
    let (support, why) = match keyword.tier {
        KeywordTier::Used => match refusals(keyword) {
            refused if refused.is_empty() => ("supported", String::new()),
            refused => ("partial", format!("without {}", refused.join(", "))),
        },
        KeywordTier::Inert(why) => ("ignored", why.into()),
        KeywordTier::OutputOnly => ("ignored", format!("{}: changes only output files of ABAQUS", keyword.summary)),
        KeywordTier::UnsupportedInert => ("ignored", format!("{}: does not affect the result", keyword.summary)),
        KeywordTier::UnsupportedPhysics => match ways::alternative(keyword.name) {
            "" => ("unsupported", keyword.summary.into()),
            way => ("unsupported", format!("{}; {way}", keyword.summary)),
        },
    };
    [keyword.name.into(), support.into(), why]
}

/// Returns the unsupported parameters and fields of a keyword. Those of other kinds of analyses, whose reason begins
/// with `applies only to`, are left out.
fn refusals(keyword: &Keyword) -> Vec<String> {
    let is_missed = |why: &str| !why.starts_with("applies only to ") && !why.contains("axisymmetric");
    let parameters = keyword
        .parameters
        .iter()
        .filter(|rule| matches!(rule.usage, InputUsage::Refused(why) | InputUsage::Only(_, why) if is_missed(why)));
    // Fields with one allowed value are left out: decks leave them empty.
    let fields = keyword.data.iter().flat_map(|d| d.shape.rules());
    let fields = fields.filter(|rule| matches!(rule.usage, InputUsage::Refused(why) if is_missed(why)));
    let mut names: Vec<String> = parameters.chain(fields).map(worded).collect();
    names.dedup();
    names
}

fn worded(rule: &InputRule) -> String {
    match rule.usage {
        InputUsage::Only(values, _) => format!("{} other than {}", rule.name, values.join(" or ")),
        _ => rule.name.into(),
    }
}

/// Returns the text of `revolve explain KEYWORD`; `None` if the keyword is unknown or ambiguous. The star is optional,
/// and abbreviations are accepted.
pub fn explain_keyword(name: &str) -> Option<String> {
    match find_keyword(name.trim().trim_start_matches('*')) {
        NameLookup::Found(keyword) => Some(explain(keyword)),
        _ => None,
    }
}

/// Describes a parameter or field in one line, without its name: its meaning, allowed values and default.
pub fn explain_rule(rule: &InputRule) -> String {
    about(rule).trim_start_matches([':', ' ']).to_owned()
}

/// Describes the support of a keyword, and where it is allowed.
pub fn explain_support(keyword: &Keyword) -> String {
    format!("{}.{}", standing(keyword.tier), standing_place(keyword))
}

/// Returns the text of `revolve explain KEYWORD` as Markdown with lists of parameters and data lines.
pub fn explain_keyword_as_markdown(keyword: &'static Keyword) -> String {
    let (name, mark, summary) = (keyword.name, mark(keyword.extension), keyword.summary);
    let head = format!("**\\*{name}**{mark}: {summary}.\n\n{}\n", explain_support(keyword));
    // Text in angle brackets must not be read as HTML.
    (head + &parameters_and_data(keyword)).replace('<', "\\<")
}

/// Iterates over the names of all keywords.
pub fn keyword_names() -> impl Iterator<Item = &'static str> {
    keywords().map(|keyword| keyword.name)
}

/// Returns whether a word, with or without its star, is the full name of a keyword.
pub fn is_keyword(name: &str) -> bool {
    let folded = fold(name.trim().trim_start_matches('*'));
    keywords().any(|k| fold(k.name) == folded)
}

fn explain(keyword: &'static Keyword) -> String {
    let width = keyword.parameters.iter().map(|r| r.name.len()).max().unwrap_or(0);
    let head = format!("*{}{}: {}.", keyword.name, mark(keyword.extension), keyword.summary);
    let mut text = format!("{head}\n{}\n", explain_support(keyword));
    for rule in keyword.parameters {
        text += &format!("  {:width$} {}\n", rule.name, about(rule).trim_start_matches(':'));
    }
    for (line, words) in keyword.data.iter().flat_map(data_lines) {
        text += &format!("  data: {line}\n");
        words.iter().for_each(|word| text += &format!("    {word}\n"));
    }
    text
}

fn standing(tier: KeywordTier) -> String {
    match tier {
        KeywordTier::Used => "Supported".into(),
        KeywordTier::Inert(why) => format!("Ignored: {why}"),
        KeywordTier::OutputOnly => "Ignored: changes only output files of ABAQUS".into(),
        KeywordTier::UnsupportedPhysics => "Unsupported: an error".into(),
        KeywordTier::UnsupportedInert => "Unsupported and ignored: does not affect the result".into(),
    }
}
