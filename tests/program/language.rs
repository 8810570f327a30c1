//! The language of the project: banned idioms, names of types and variables, tuples in signatures, length of sentences
//! and paragraphs in the manual.
//!
//! Source: the Markdown pages and the Rust sources. Code spans, formulas and link targets are not prose and are left
//! out.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use super::tidy::texts;
use crate::common::project;

/// Banned idioms, one per line, and what to write instead. `a|b` are alternatives for one word, `a*` is any word that
/// starts so.
const IDIOMS: &str = "
tell|tells|told|telling: report, warn, print, state
behind: after, previous; next to (in space only)
beside: next to, in addition to
what deforms|resists|moves|pushes|follows|flows|fails|acts|lies|stands|keeps|comes|holds|asks|needs|takes: a noun (deformable elements)
what has|goes|carries|reads|falls|bears|meets|shows|was|of: a noun (deformable elements)
what is left|gone: a noun (the remaining elements, the deleted elements)
of it|them|these|those: name the thing
of its|their own: separate, individual
come|comes|came|coming to lie|stand: becomes
lie|lies|lay|lying: is, is located
stand|stands|stood: is, are listed
reckon*: compute
bare: exposed
books|booked|booking: energy balance, account for
asks|asked|asking for|of|by: request
heed*: use, take into account
mend|mends|mended: fix
by lot: at random
afresh|anew: again
thrice: three times
lest: so that ... not
whence|hence: therefore, from where
thereof|whereof|therein|wherein|whither|hereby|forthwith: name the thing
are|is no more: is deleted, no longer exists
nothing of: no ...
bear|bears|bore|borne: resist, carry load
room|rooms|house|door: memory, work array, module, interface
wish|wishes: request
wanted by: requested by
whatever becomes: regardless of
";

/// Most idioms per 1 000 words of each kind of text.
const IDIOMS_PER_1000_WORDS: f64 = 1.0;
/// Largest share of type names of one word.
const ONE_WORD_NAMES: f64 = 0.30;
/// Most definitions of one type name in `src`.
const SAME_NAME: usize = 2;
/// Most words of a paragraph of the manual, and of 95 % of its sentences.
const PARAGRAPH_WORDS: usize = 120;
const SENTENCE_WORDS: usize = 30;

/// Words that do not say what a variable is.
const VAGUE_NAMES: &str = "own at before found all place given kept rest most held wanted cause asked look good left plain \
    applied one done to of by here there behind told shown took goes comes stands bears";
/// Largest share of variables with such a name.
const VAGUE_VARIABLES: f64 = 0.02;
/// Most files that a failure lists.
const MOST_LISTED: usize = 40;
/// Most values of a tuple in the signature of a function; more values are the fields of a struct.
const TUPLE_VALUES: usize = 2;

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
enum TextKind {
    Manual,
    DocComment,
    Comment,
    StringLiteral,
}

/// Consecutive lines of one kind, with the number of the first.
struct TextBlock {
    kind: TextKind,
    line: usize,
    text: String,
}

/// A Rust source, split into its code (comments and the contents of literals removed) and its texts.
#[derive(Default)]
struct RustSource {
    code: String,
    blocks: Vec<TextBlock>,
}

impl RustSource {
    fn read(mut rest: &str) -> RustSource {
        let mut source = RustSource::default();
        let mut line = 1;
        while let Some(c) = rest.chars().next() {
            let length = match c {
                '/' if rest.starts_with("//") => source.comment(rest, line),
                '"' => source.string(rest, line),
                '\'' => char_literal(rest),
                _ => 1,
            };
            if length == 1 {
                source.code.push(c);
            }
            let (read, next) = rest.split_at(if length == 1 { c.len_utf8() } else { length });
            line += read.matches('\n').count();
            rest = next;
        }
        source
    }

    /// Adds the comment at the start of a text; returns its length.
    fn comment(&mut self, text: &str, line: usize) -> usize {
        let comment = text.split('\n').next().unwrap_or_default();
        let is_doc = comment.starts_with("//!") || comment.starts_with("///");
        let (kind, words) =
            if is_doc { (TextKind::DocComment, &comment[3..]) } else { (TextKind::Comment, &comment[2..]) };
        match self.blocks.last_mut() {
            Some(b) if b.kind == kind && b.line + b.text.matches('\n').count() + 1 == line => {
                b.text.push('\n');
                b.text.push_str(words);
            }
            _ => self.blocks.push(TextBlock { kind, line, text: words.to_owned() }),
        }
        comment.len()
    }

    /// Adds the string literal at the start of a text; returns its length. A literal of several lines is data, not a
    /// message.
    fn string(&mut self, text: &str, line: usize) -> usize {
        let hashes = self.code.len() - self.code.trim_end_matches('#').len();
        let is_raw = self.code.trim_end_matches('#').ends_with('r');
        let end = if is_raw { format!("\"{}", "#".repeat(hashes)) } else { "\"".into() };
        let content = if is_raw { text[1..].find(&end).map(|at| at + 1) } else { end_of_escaped_string(text) };
        let content = content.unwrap_or(text.len());
        let words = text[1..content].replace("\\\n", "\\n");
        if words.contains(' ') && !words.contains('\n') {
            let text = words.replace("\\n", "\n").replace("\\\"", "\"");
            self.blocks.push(TextBlock { kind: TextKind::StringLiteral, line, text });
        }
        (content + end.len()).min(text.len())
    }
}

/// Returns the place of the quote that closes the string literal at the start of a text.
fn end_of_escaped_string(text: &str) -> Option<usize> {
    let mut escaped = false;
    for (i, c) in text.char_indices().skip(1) {
        match c {
            '"' if !escaped => return Some(i),
            _ => escaped = c == '\\' && !escaped,
        }
    }
    None
}

/// Returns the length of the character literal at the start of a text; 1 for a lifetime.
fn char_literal(text: &str) -> usize {
    let mut chars = text.char_indices().skip(1);
    match chars.next() {
        Some((_, '\\')) => text[3..].find('\'').map_or(1, |at| at + 4),
        Some(_) => chars.next().filter(|&(_, c)| c == '\'').map_or(1, |(at, _)| at + 1),
        None => 1,
    }
}

/// Returns a page in which lines of code are empty, so that line numbers stay.
fn without_code_blocks(page: &str) -> String {
    let mut fence = false;
    let mut lines = Vec::new();
    for line in page.lines() {
        let is_fence = line.trim_start().starts_with("```");
        fence ^= is_fence;
        lines.push(if fence || is_fence || line.starts_with("    ") { "" } else { line });
    }
    lines.join("\n")
}

/// Returns a line in which each code span, formula, placeholder and link target is one `~`.
fn prose(line: &str) -> String {
    let (mut out, mut rest) = (String::new(), line);
    while let Some(at) = rest.find(['`', '$', '{', ']']) {
        out.push_str(&rest[..at]);
        rest = &rest[at..];
        let (open, close) = match &rest[..1] {
            "{" => (1, "}"),
            "]" if rest.starts_with("](") => (2, ")"),
            _ if rest.starts_with("$$") => (2, "$$"),
            same => (1, if same == "]" { "\n" } else { same }),
        };
        let end = rest[open..].find(close).map(|end| open + end + close.len());
        out.push(if end.is_some() { '~' } else { ' ' });
        rest = &rest[end.unwrap_or(1)..];
    }
    out + rest
}

/// Returns the words of a text in lower case, each with its line; an empty word where punctuation ends a phrase.
fn words(block: &TextBlock) -> Vec<(usize, String)> {
    let mut words = Vec::new();
    for (line, text) in (block.line..).zip(block.text.split('\n')) {
        let text = prose(text);
        for piece in text.split_whitespace() {
            let mut parts = piece.split(|c: char| !c.is_alphabetic() && !['\'', '-'].contains(&c)).peekable();
            while let Some(part) = parts.next() {
                let word = part.trim_matches(['\'', '-']).to_lowercase();
                if !word.is_empty() || parts.peek().is_some() {
                    words.push((line, word));
                }
            }
            if piece.ends_with(|c: char| !c.is_alphabetic()) {
                words.push((line, String::new()));
            }
        }
    }
    words
}

/// An idiom as the alternatives of each of its words, and what to write instead.
struct BannedPhrase {
    words: Vec<Vec<&'static str>>,
    instead: &'static str,
}

impl BannedPhrase {
    fn all() -> Vec<BannedPhrase> {
        let entries = IDIOMS.lines().filter_map(|line| line.split_once(": "));
        let split = |phrase: &'static str| phrase.split(' ').map(|word| word.split('|').collect()).collect();
        entries.map(|(phrase, instead)| BannedPhrase { words: split(phrase), instead }).collect()
    }

    fn matches(&self, words: &[(usize, String)]) -> bool {
        let is_any = |(allowed, (_, word)): (&Vec<&str>, &(usize, String))| {
            allowed.iter().any(|a| a.strip_suffix('*').map_or(a == word, |start| word.starts_with(start)))
        };
        words.len() >= self.words.len() && self.words.iter().zip(words).all(is_any)
    }
}

/// Returns all texts of the project by file.
fn blocks() -> Vec<(String, TextBlock)> {
    let mut all = Vec::new();
    for (path, page) in pages() {
        all.push((path, TextBlock { kind: TextKind::Manual, line: 1, text: without_code_blocks(&page) }));
    }
    for folder in ["src", "tests", "examples"] {
        for (path, text) in texts(folder, ".rs") {
            all.extend(RustSource::read(&text).blocks.into_iter().map(|block| (path.clone(), block)));
        }
    }
    all
}

/// Returns the pages of the manual.
fn pages() -> BTreeMap<String, String> {
    let mut pages = texts("docs", ".md");
    pages.insert("README.md".into(), fs::read_to_string(project("README.md")).expect("a page"));
    pages
}

/// Checks the number of idioms in the texts of one kind.
fn check_idioms(kind: TextKind) {
    let idioms = BannedPhrase::all();
    let (mut count, mut found) = (0, Vec::new());
    for (path, block) in blocks().into_iter().filter(|(_, block)| block.kind == kind) {
        let words = words(&block);
        count += words.iter().filter(|(_, word)| !word.is_empty()).count();
        for (i, (line, _)) in words.iter().enumerate() {
            for idiom in idioms.iter().filter(|idiom| idiom.matches(&words[i..])) {
                let phrase: Vec<_> = words[i..][..idiom.words.len()].iter().map(|(_, word)| word.as_str()).collect();
                found.push(format!("{path}:{line}: \"{}\": write {}", phrase.join(" "), idiom.instead));
            }
        }
    }
    let rate = 1000.0 * found.len() as f64 / count as f64;
    println!("{kind:?}: {count} words, {rate:.2} idioms per 1 000");
    assert!(count > 1000, "{count} words");
    assert!(
        rate <= IDIOMS_PER_1000_WORDS,
        "{rate:.2} idioms per 1 000 words, at most {IDIOMS_PER_1000_WORDS} are allowed:\n{}",
        found.join("\n")
    );
}

#[test]
fn manual_has_few_idioms() {
    check_idioms(TextKind::Manual);
}

#[test]
fn doc_comments_have_few_idioms() {
    check_idioms(TextKind::DocComment);
}

#[test]
fn comments_have_few_idioms() {
    check_idioms(TextKind::Comment);
}

#[test]
fn strings_have_few_idioms() {
    check_idioms(TextKind::StringLiteral);
}

/// Returns the name that a line of code defines. Indented `type` lines are associated types.
fn defined_type(line: &str) -> Option<&str> {
    let item = line.trim_start();
    let item = item.strip_prefix("pub").map_or(item, |rest| rest.split_once(' ').map_or("", |(_, item)| item));
    let (keyword, rest) = item.split_once(' ')?;
    let is_item = ["struct", "enum", "trait", "union"].contains(&keyword) || line == item && keyword == "type";
    let is_item = is_item || keyword == "type" && line.starts_with("pub");
    let name = rest.split(|c: char| !c.is_alphanumeric() && c != '_').next()?;
    (is_item && name.starts_with(char::is_uppercase)).then_some(name)
}

/// Returns the number of capitals that start a word.
fn name_words(name: &str) -> usize {
    name.chars().filter(char::is_ascii_uppercase).count()
}

#[test]
fn type_names_are_noun_phrases_and_searchable() {
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (path, text) in texts("src", ".rs") {
        for name in RustSource::read(&text).code.lines().filter_map(defined_type) {
            places.entry(name.to_owned()).or_default().push(path.clone());
        }
    }
    assert!(places.len() > 100, "{} types", places.len());
    let repeated: Vec<_> = places.iter().filter(|(_, files)| files.len() > SAME_NAME).collect();
    assert!(repeated.is_empty(), "type names with more than {SAME_NAME} definitions: {repeated:#?}");
    let short: Vec<_> = places.keys().filter(|name| name_words(name) < 2).collect();
    let share = short.len() as f64 / places.len() as f64;
    println!("{} type names, {:.0} % of one word", places.len(), 100.0 * share);
    assert!(share <= ONE_WORD_NAMES, "{:.0} % of the type names are one word: {short:?}", 100.0 * share);
}

/// Returns the names that the `let` statements of a code bind, alone or in a tuple.
fn variables(code: &str) -> Vec<&str> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    let starts = code.match_indices("let ").filter(|(at, _)| !code[..*at].ends_with(is_part));
    let patterns = starts.filter_map(|(at, head)| {
        let pattern = code[at + head.len()..].trim_start();
        let pattern = pattern.strip_prefix("mut ").unwrap_or(pattern);
        let end = if pattern.starts_with('(') { pattern.find(')')? } else { pattern.find(|c| !is_part(c))? };
        Some(&pattern[..end]).filter(|pattern| !pattern.contains(['=', ';']))
    });
    let is_name = |name: &&str| name.starts_with(|c: char| c.is_lowercase() || c == '_') && *name != "_";
    let words = patterns.flat_map(|pattern| pattern.split(|c| !is_part(c)));
    words.filter(is_name).filter(|name| !["mut", "ref"].contains(name)).collect()
}

#[test]
fn variables_say_what_they_are() {
    let vague: BTreeSet<&str> = VAGUE_NAMES.split_whitespace().collect();
    let (mut count, mut files) = (0, Vec::new());
    for (path, text) in texts("src", ".rs") {
        let source = RustSource::read(&text);
        let names = variables(&source.code);
        count += names.len();
        let names: Vec<_> = names.into_iter().filter(|name| vague.contains(name)).map(str::to_owned).collect();
        files.push((names.len(), path, names.join(" ")));
    }
    files.sort_by_key(|file| std::cmp::Reverse(file.0));
    files.truncate(files.partition_point(|file| file.0 > 0));
    let share = files.iter().map(|file| file.0).sum::<usize>() as f64 / count as f64;
    println!("{count} variables, {:.2} % with a vague name", 100.0 * share);
    assert!(count > 1000, "{count} variables");
    assert!(
        share <= VAGUE_VARIABLES,
        "{:.2} % of the variables have a name that does not say what they are, at most {:.0} % are allowed: {:#?}",
        100.0 * share,
        100.0 * VAGUE_VARIABLES,
        &files[..files.len().min(MOST_LISTED)]
    );
}

/// Returns the signatures of the functions of a code: name, parameters and return type.
fn signatures(code: &str) -> Vec<&str> {
    let starts = code.match_indices("fn ").filter(|(at, _)| code[..*at].ends_with([' ', '\n']) || *at == 0);
    let signature = |(at, head): (usize, &str)| {
        let rest = &code[at + head.len()..];
        let mut depth = 0;
        let end = rest.find(|c| {
            depth += i32::from(['(', '['].contains(&c)) - i32::from([')', ']'].contains(&c));
            depth == 0 && ['{', ';'].contains(&c)
        });
        &rest[..end.unwrap_or(rest.len())]
    };
    starts.map(signature).collect()
}

/// Returns the number of values of the largest tuple in the parameters and the return type of a signature. Parentheses
/// after a word hold parameters.
fn largest_tuple(signature: &str) -> usize {
    let (mut largest, mut open) = (0, Vec::new());
    for (i, c) in signature.char_indices() {
        match c {
            '(' | '[' | '<' | '{' => {
                let is_tuple = c == '(' && !signature[..i].ends_with(|c: char| c.is_alphanumeric() || "_>".contains(c));
                open.push((is_tuple, 1));
            }
            ')' | ']' | '}' => _ = open.pop(),
            '>' if !signature[..i].ends_with('-') => _ = open.pop(),
            ',' => {
                if let Some((is_tuple, values)) = open.last_mut() {
                    *values += 1;
                    let has_value = !signature[i + 1..].trim_start().starts_with(')');
                    largest = if *is_tuple && has_value { largest.max(*values) } else { largest };
                }
            }
            _ => {}
        }
    }
    largest
}

#[test]
fn signatures_have_small_tuples() {
    let mut large = BTreeSet::new();
    for (path, text) in texts("src", ".rs") {
        let text = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
        for signature in signatures(&RustSource::read(text).code) {
            if largest_tuple(signature) > TUPLE_VALUES {
                large.insert(format!("{path}: {}", signature.split_whitespace().collect::<Vec<_>>().join(" ")));
            }
        }
    }
    assert!(
        large.is_empty(),
        "signatures with tuples of more than {TUPLE_VALUES} values, which must be structs: {large:#?}"
    );
}

/// Returns the paragraphs and list items of a page, each with its first line. Tables, headings and formulas are left
/// out.
fn paragraphs(page: &str) -> Vec<(usize, String)> {
    let mut paragraphs: Vec<(usize, String)> = Vec::new();
    let (mut formula, mut continues) = (false, false);
    for (line, text) in (1..).zip(without_code_blocks(page).lines()) {
        let text = text.trim();
        let is_formula = formula || text.starts_with("$$");
        formula ^= text.matches("$$").count() % 2 == 1;
        if is_formula || text.is_empty() || text.starts_with(['|', '#', '<', '!']) {
            continues = false;
            continue;
        }
        let item = text.trim_start_matches(|c: char| c.is_ascii_digit());
        let is_item = ["- ", "* "].iter().any(|mark| text.starts_with(mark)) || item != text && item.starts_with(". ");
        let text = if is_item { item.split_once(' ').map_or("", |(_, text)| text) } else { text };
        match paragraphs.last_mut() {
            Some((_, last)) if continues && !is_item => *last += &format!(" {text}"),
            _ => paragraphs.push((line, text.to_owned())),
        }
        continues = true;
    }
    paragraphs
}

/// Returns the number of words of each sentence of a paragraph; a code span or formula is one word.
fn sentence_lengths(paragraph: &str) -> Vec<usize> {
    let text = prose(paragraph);
    let mut lengths = vec![0];
    for word in text.split_whitespace() {
        if word.contains(|c: char| c.is_alphanumeric() || c == '~') {
            *lengths.last_mut().expect("a sentence") += 1;
        }
        let abbreviations = ["e.g.", "i.e.", "al.", "Eq.", "eq.", "Fig.", "p.", "pp.", "vol.", "vs."];
        if word.trim_end_matches([')', '*', '"']).ends_with(['.', '!', '?'])
            && !abbreviations.contains(&word.trim_start_matches('('))
        {
            lengths.push(0);
        }
    }
    lengths.retain(|&words| words > 0);
    lengths
}

#[test]
fn paragraphs_of_the_manual_are_short() {
    let mut long = BTreeSet::new();
    for (path, page) in pages() {
        for (line, text) in paragraphs(&page) {
            let words = text.split_whitespace().count();
            if words > PARAGRAPH_WORDS {
                long.insert(format!("{path}:{line}: a paragraph of {words} words"));
            }
        }
    }
    assert!(
        long.is_empty(),
        "at most {PARAGRAPH_WORDS} words are allowed; split the paragraph, or use a list: {long:#?}"
    );
}

#[test]
fn sentences_of_the_manual_are_short() {
    let mut sentences = Vec::new();
    for (path, page) in pages() {
        for (line, text) in paragraphs(&page) {
            sentences.extend(sentence_lengths(&text).into_iter().map(|words| (words, format!("{path}:{line}"))));
        }
    }
    sentences.sort();
    let most = sentences[sentences.len() * 95 / 100].0;
    println!("{} sentences, 95 % with at most {most} words", sentences.len());
    let long: Vec<_> = sentences.iter().rev().take_while(|(words, _)| *words > SENTENCE_WORDS).collect();
    assert!(
        most <= SENTENCE_WORDS,
        "95 % of the sentences may have at most {SENTENCE_WORDS} words, not {most}: {long:#?}"
    );
}

#[test]
fn texts_of_a_source_are_found() {
    let source =
        "//! Head\n//! told\nfn f<'a>(c: char) { if c == '\"' { g(\"is told `told` \\\" behind\") } } // stands\n";
    let source =
        source.to_owned() + "#[doc(hidden)]\npub(crate) struct OnePair;\nconst DECK: &str = r#\"told \"\nme\"#;\n";
    let source = RustSource::read(&source);
    let found: Vec<_> = source.blocks.iter().map(|b| (b.kind, b.line, b.text.as_str())).collect();
    let expected = [
        (TextKind::DocComment, 1, " Head\n told"),
        (TextKind::StringLiteral, 3, "is told `told` \" behind"),
        (TextKind::Comment, 3, " stands"),
    ];
    assert_eq!(found, expected);
    assert_eq!(source.code.lines().filter_map(defined_type).collect::<Vec<_>>(), ["OnePair"]);
    assert_eq!(name_words("OnePair"), 2);
    let idioms = BannedPhrase::all();
    let matched = |text: &str| {
        let words = words(&TextBlock { kind: TextKind::Manual, line: 1, text: text.into() });
        (0..words.len()).map(|i| idioms.iter().filter(|idiom| idiom.matches(&words[i..])).count()).sum::<usize>()
    };
    assert_eq!(matched("It is told; reckoned by the parts of\nit, `told` [here](told.md), $told$, stand-alone"), 3);
    assert_eq!(matched("a list of. It has a name"), 0);
    assert_eq!(variables("let mut a: T = b; outlet c; let (d, e) = f; if let Some(g) = h {}"), ["a", "d", "e"]);
    let code = "fn a<T: F<(B, C)>>(x: (A, [B; 2]), y: &G<A, B, C>) -> (A, B) { fn b(f: impl Fn(A, B, C)) -> Option<(A, B, C)>;";
    assert_eq!(signatures(code).into_iter().map(largest_tuple).collect::<Vec<_>>(), [2, 3]);
    assert_eq!(sentence_lengths("A sentence. Another, see `a b. c` (e.g. here)."), [2, 5]);
}
