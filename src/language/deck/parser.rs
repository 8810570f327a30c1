//! Parser: builds the syntax tree of a deck, with its included files. Errors become diagnostics; parsing always
//! continues.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::diagnostic::{Diagnostic, Diagnostics};
use super::keywords::{
    self, InputRule, InputUsage, Keyword, KeywordTier, NameLookup, nearest_keyword, nearest_parameter,
};
use super::lexer::{self, LineFields, LineIterator, LineKind, LineRange};
use super::parameters::Parameters;
use super::rows::is_listing;
use super::source::{self, SourceFile, Span};
use super::syntax::{Card, DataLine, Deck, ListingRow, Parameter, Word};
use super::{OpenTexts, files, untrusted};

/// Maximum depth of nested includes.
const DEEPEST: usize = 32;
/// Maximum number of files of a deck.
const MOST_FILES: usize = 2000;
/// Maximum size of all files of a deck together, bytes.
const MOST_BYTES: u64 = 2 << 30;

/// Destination of the data lines that follow.
#[derive(Clone, Copy, PartialEq)]
enum DataDestination {
    /// None: there was no keyword line yet.
    Start,
    /// None: the keyword is unknown, and its data lines are skipped.
    Unknown,
    /// The parameter definitions of `*PARAMETER`.
    Parameters,
    /// The last card of the deck.
    Card,
}

/// State of the parser for one deck.
pub struct Parser<'a> {
    /// Texts that replace the contents of files on disk.
    open_texts: &'a OpenTexts<'a>,
    deck: Deck,
    diagnostics: Diagnostics,
    parameters: Parameters,
    block: DataDestination,
    chain: Vec<PathBuf>,
    bytes: u64,
    /// Whether a comment line of another program has been reported.
    has_foreign_comment: bool,
    /// Number of unknown words for which a similar one was searched.
    searches: usize,
}

/// Number of unknown words for which a similar one is searched: each search compares all names, and only the first messages
/// are read.
const SEARCHES: usize = 50;

/// Returns the beginning of a word, for a message.
fn beginning(word: &str) -> String {
    const SHOWN: usize = 80;
    match word.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &word[..end]),
        None => word.to_owned(),
    }
}

/// Returns the program whose input file a text is, from its first line that is no comment; `None` for a deck.
fn other_program(text: &str) -> Option<&'static str> {
    let mut lines = text.lines().map(str::trim_start).filter(|line| !line.is_empty());
    let first = lines.find(|line| line.starts_with("#RADIOSS") || !line.starts_with(['$', '#']))?;
    let is_dyna = first.get(..8).is_some_and(|word| word.eq_ignore_ascii_case("*KEYWORD"));
    let is_radioss = first.starts_with("#RADIOSS") || first.starts_with("/BEGIN");
    if is_dyna { Some("LS-DYNA") } else { is_radioss.then_some("OpenRadioss") }
}

impl<'a> Parser<'a> {
    /// Creates a parser with overrides (name, expression) of parameters, and texts that replace the contents of
    /// included files.
    pub fn new(overrides: &[(String, String)], open_texts: &'a OpenTexts<'a>) -> Self {
        Parser {
            open_texts,
            deck: Deck::default(),
            diagnostics: Diagnostics::default(),
            parameters: Parameters::new(overrides),
            block: DataDestination::Start,
            chain: Vec::new(),
            bytes: 0,
            has_foreign_comment: false,
            searches: 0,
        }
    }

    /// Completes the last card and returns the deck with the diagnostics of all its files.
    pub fn finish(mut self) -> (Deck, Diagnostics) {
        self.parameters.check_overrides(&mut self.diagnostics);
        self.deck.parameters = self.parameters.numbers();
        self.deck.mesh_curves = self.parameters.mesh_curves(&mut self.diagnostics);
        if let Some(((name, value), scaling)) = self.parameters.mesh_scaling(&mut self.diagnostics) {
            self.deck.mesh_scaling = Some(scaling);
            self.deck.parameters.push((name.into(), value));
        }
        if self.deck.cards.is_empty() && !self.diagnostics.has_errors() {
            let name = self.deck.sources.files().first().map_or("the deck", |f| f.name.as_str());
            let what = Diagnostic::error("D009", format!("{name} is empty: it has no keyword line"));
            self.diagnostics.push(what.help("check the file name; a deck has keyword lines such as *NODE and *STEP"));
        }
        self.deck.definitions = self.parameters.definitions();
        super::findings::tier_findings(&self.deck, &mut self.diagnostics);
        (self.deck, self.diagnostics)
    }

    /// Parses the main file, or standard input if the path is `-`.
    pub fn main_file(&mut self, path: &Path) {
        let standard = path == Path::new(files::STANDARD_INPUT);
        match if standard { files::read_standard_input(MOST_BYTES) } else { files::read(path) } {
            Ok(bytes) => self.text(path, source::decode(bytes), None),
            Err(e) => {
                let what = Diagnostic::error("D001", format!("cannot read {}: {e}", path.display()));
                self.diagnostics.push(what.help("give the path of an existing deck file"));
            }
        }
    }

    /// Parses the text of a file.
    pub fn text(&mut self, path: &Path, text: String, included_at: Option<Span>) {
        self.bytes += text.len() as u64;
        let name = path.display().to_string();
        let empty = SourceFile { name: name.clone(), path: path.to_owned(), text: String::new(), included_at };
        let file = Arc::make_mut(&mut self.deck.sources).add(empty);
        if self.bytes > MOST_BYTES {
            return self.refuse_file(
                "D006",
                format!("{name}: the deck is larger than {MOST_BYTES} bytes"),
                included_at,
            );
        }
        if text.contains('\0') {
            return self.refuse_file("D005", format!("{name} is not a text file"), included_at);
        }
        if let Some(program) = other_program(&text).filter(|_| included_at.is_none()) {
            let message = format!("{name} is an input file of {program}; decks have the syntax of ABAQUS/Explicit");
            return self.refuse_file("D010", message, included_at);
        }
        self.chain.push(path.canonicalize().unwrap_or_else(|_| path.to_owned()));
        self.lines(file, &text);
        self.chain.pop();
        Arc::make_mut(&mut self.deck.sources).fill(file, text);
    }

    fn refuse_file(&mut self, code: &'static str, message: String, at: Option<Span>) {
        self.deck.unread.files = true;
        let what = Diagnostic::error(code, message);
        self.diagnostics.push(match at {
            Some(span) => what.at(span, "included here"),
            None => what,
        });
    }

    fn lines(&mut self, file: u32, text: &str) {
        let mut lines = LineIterator::new(text);
        while let Some(line) = lines.next() {
            match lexer::kind(&text[line.clone()]) {
                LineKind::Blank | LineKind::Comment => {}
                LineKind::Data => self.data_line(file, text, line),
                LineKind::Keyword => self.keyword_line(file, text, line, &mut lines),
            }
        }
    }

    fn data_line(&mut self, file: u32, text: &str, line: LineRange) {
        let trimmed = lexer::trim(text, line.clone());
        let span = lexer::span(file, trimmed.clone());
        // Titles are free text, and `#` begins a comment of *PARAMETER.
        let is_free = matches!(self.block, DataDestination::Parameters)
            || self.deck.cards.last().is_some_and(|card| card.keyword.name == "HEADING");
        if text[trimmed.clone()].starts_with(['$', '#']) && !is_free {
            return self.foreign_comment(span);
        }
        match self.block {
            DataDestination::Unknown => {}
            DataDestination::Start => {
                self.block = DataDestination::Unknown;
                let what = Diagnostic::error("D107", "a data line precedes the first keyword line");
                self.diagnostics.push(
                    what.at(span, "belongs to no keyword").help("a keyword line begins with `*`, a comment with `**`"),
                );
            }
            DataDestination::Parameters => self.parameters.define_all(&text[trimmed], span, &mut self.diagnostics),
            DataDestination::Card => self.card_line(file, text, line, span),
        }
    }

    /// Reports the first line that looks like a comment of another program. All such lines are skipped.
    fn foreign_comment(&mut self, span: Span) {
        if !std::mem::replace(&mut self.has_foreign_comment, true) {
            let what = Diagnostic::error("D109", "this line begins with the comment sign of another program");
            self.diagnostics.push(what.at(span, "here").help("begin comments with `**`"));
        }
    }

    fn card_line(&mut self, file: u32, text: &str, line: LineRange, span: Span) {
        let Some(card) = self.deck.cards.last_mut() else { return };
        let (keyword, listing) = (card.keyword, is_listing(card.keyword.name));
        let is_plain = !text[span.start as usize..span.end as usize].contains(['<', '"']);
        if listing && is_plain {
            return card.rows.push(ListingRow::Text(span));
        }
        let count_before = self.diagnostics.len();
        let whole = || Word { text: text[lexer::trim(text, line.clone())].to_owned(), span, quoted: false };
        let fields = if keyword.name == "HEADING" {
            vec![whole()]
        } else if keyword.name == "OUTPUT EXPRESSION" {
            vec![self.parameters.substitute(whole(), &mut self.diagnostics)]
        } else {
            let fields = lexer::split(text, line.clone());
            self.check_quotes(file, &line, &fields);
            fields.ranges.into_iter().map(|r| self.word(file, text, r)).collect()
        };
        let unknown = fields.iter().any(|word| self.parameters.lacks_value(&word.text));
        if let Some(card) = self.deck.cards.last_mut() {
            let line = DataLine { fields, span };
            if listing {
                card.rows.push(ListingRow::Line(Box::new(line)))
            } else {
                card.lines.push(line)
            }
            card.faulty |= unknown || self.diagnostics.len() > count_before;
        }
    }

    fn word(&mut self, file: u32, text: &str, range: LineRange) -> Word {
        self.parameters.substitute(lexer::word(text, file, range), &mut self.diagnostics)
    }

    fn check_quotes(&mut self, file: u32, line: &LineRange, fields: &LineFields) {
        if let Some(at) = fields.unclosed {
            let what = Diagnostic::error("D108", "a quote is not closed");
            let span = lexer::span(file, at..line.end);
            self.diagnostics.push(what.at(span, "opened here").help("close it on the same line with `\"`"));
        }
    }

    fn keyword_line(&mut self, file: u32, text: &str, line: LineRange, lines: &mut LineIterator<'_>) {
        let mut fields = lexer::split(text, line.clone());
        self.check_quotes(file, &line, &fields);
        let star = fields.ranges.first().cloned().unwrap_or(lexer::trim(text, line));
        let span = lexer::span(file, star.clone());
        let Some(keyword) = self.keyword(&text[star.start + 1..star.end], span) else {
            self.block = DataDestination::Unknown;
            self.unread_names(file, text, fields.ranges.into_iter().skip(1));
            return;
        };
        let count_before = self.diagnostics.len();
        while fields.trailing_comma {
            let Some((next, after_line)) = lines.peek_significant() else { break };
            let more = lexer::split(text, next.clone());
            if !continues(text, &next, &more, keyword) {
                break;
            }
            self.check_quotes(file, &next, &more);
            fields.trailing_comma = more.trailing_comma;
            fields.ranges.extend(more.ranges);
            *lines = after_line;
        }
        if keyword.tier == KeywordTier::UnsupportedPhysics {
            self.unread_names(file, text, fields.ranges.iter().skip(1).cloned());
        }
        let parameters = self.card_parameters(file, text, keyword, fields.ranges.into_iter().skip(1));
        let unknown =
            parameters.iter().filter_map(|p| p.value.as_ref()).any(|word| self.parameters.lacks_value(&word.text));
        let faulty = unknown || self.diagnostics.len() > count_before;
        self.card(Card { keyword, span, parameters, lines: Vec::new(), rows: Vec::new(), faulty });
    }

    /// Records the values on an unsupported or unknown keyword line, which may define names.
    fn unread_names(&mut self, file: u32, text: &str, ranges: impl Iterator<Item = LineRange>) {
        self.deck.unread.cards += 1;
        for range in ranges {
            if let Some(at) = lexer::equals_sign(text, range.clone()) {
                let value = lexer::word(text, file, lexer::trim(text, at + 1..range.end));
                self.deck.unread.names.push(value.text.trim().to_uppercase());
            }
        }
    }

    fn card(&mut self, card: Card) {
        match card.keyword.name {
            "INCLUDE" => self.include_card(&card),
            "PARAMETER" => {
                self.block = DataDestination::Parameters;
                self.refuse_parameters(&card, "D405");
            }
            name => {
                self.block = DataDestination::Card;
                let input = card.value("INPUT").filter(|_| name != "MESH").cloned();
                self.deck.cards.push(card);
                if let Some(file) = input {
                    self.include(&file);
                }
            }
        }
    }

    /// Returns the result of a search for a similar word; `None` after many searches.
    fn suggestion(&mut self, search: impl FnOnce() -> Option<&'static str>) -> Option<&'static str> {
        self.searches += 1;
        if self.searches > SEARCHES { None } else { search() }
    }

    fn keyword(&mut self, text: &str, span: Span) -> Option<&'static Keyword> {
        let name = text.trim();
        let finding = match keywords::find_keyword(text) {
            NameLookup::Found(keyword) => return Some(keyword),
            NameLookup::Ambiguous(all) => {
                let names: Vec<String> = all.iter().take(8).map(|k| format!("*{}", k.name)).collect();
                let what = Diagnostic::error("D102", format!("*{name} is an abbreviation of several keywords"));
                what.at(span, "ambiguous").help(format!("write one of {}", names.join(", ")))
            }
            NameLookup::Unknown if name.is_empty() => Diagnostic::error("D101", "the keyword line has no keyword")
                .at(span, "nothing after the star")
                .help("comments begin with `**`"),
            NameLookup::Unknown => {
                let what = Diagnostic::error("D101", format!("unknown keyword *{}", beginning(name)));
                what.at(span, "not in the keyword table").help(match self.suggestion(|| nearest_keyword(name)) {
                    _ if text.starts_with(char::is_whitespace) => "if this is a comment, begin it with `**`".into(),
                    Some(like) => format!("did you mean *{like}?"),
                    None => "docs/abaqus.md lists the keywords of ABAQUS/Explicit and their support".to_owned(),
                })
            }
        };
        self.diagnostics.push(finding);
        None
    }

    fn card_parameters(
        &mut self,
        file: u32,
        text: &str,
        keyword: &'static Keyword,
        ranges: impl Iterator<Item = LineRange>,
    ) -> Vec<Parameter> {
        let mut parameters: Vec<Parameter> = Vec::new();
        for range in ranges.filter(|r| !r.is_empty()) {
            let Some(parameter) = self.parameter(file, text, keyword, range) else { continue };
            match parameters.iter().find(|p| p.name == parameter.name) {
                Some(first) => self.diagnostics.push(given_twice(keyword, &parameter, first)),
                None => parameters.push(parameter),
            }
        }
        parameters
    }

    fn parameter(&mut self, file: u32, text: &str, keyword: &'static Keyword, range: LineRange) -> Option<Parameter> {
        let equals = lexer::equals_sign(text, range.clone());
        let name = lexer::trim(text, range.start..equals.unwrap_or(range.end));
        let span = lexer::span(file, name.clone());
        let rule = self.rule(keyword, &text[name], span)?;
        let value = equals.map(|at| lexer::trim(text, at + 1..range.end));
        if value.as_ref().is_some_and(|r| r.is_empty()) && keyword.tier == KeywordTier::Used {
            let what = Diagnostic::error("D105", format!("*{}: {} has no value", keyword.name, rule.name));
            self.diagnostics.push(what.at(span, "nothing after the equals sign"));
        }
        let value = value.filter(|r| !r.is_empty()).map(|r| self.word(file, text, r));
        Some(Parameter { name: rule.name, span, value })
    }

    fn rule(&mut self, keyword: &'static Keyword, text: &str, span: Span) -> Option<&'static InputRule> {
        let strict = keyword.tier == KeywordTier::Used;
        let finding = match keywords::find_parameter(keyword, text) {
            NameLookup::Found(rule) => return Some(rule),
            NameLookup::Ambiguous(all) if strict => {
                let names: Vec<&str> = all.iter().map(|r| r.name).collect();
                let what = Diagnostic::error(
                    "D104",
                    format!("*{}: {text} is an abbreviation of several parameters", keyword.name),
                );
                what.at(span, "ambiguous").help(format!("write one of {}", names.join(", ")))
            }
            NameLookup::Unknown if strict => {
                let nearest = self.suggestion(|| nearest_parameter(keyword, text));
                unknown_parameter(keyword, text, span, nearest)
            }
            _ => return None,
        };
        self.diagnostics.push(finding);
        None
    }

    fn include_card(&mut self, card: &Card) {
        self.refuse_parameters(card, "D002");
        match card.value("INPUT") {
            Some(file) => self.include(file),
            None => {
                let what = Diagnostic::error("D007", "*INCLUDE has no file name");
                self.diagnostics.push(what.at(card.span, "INPUT is missing").help("write *INCLUDE, INPUT=file"));
            }
        }
    }

    /// Reports unsupported parameters of `*INCLUDE` and `*PARAMETER`, which are not checked by the model.
    fn refuse_parameters(&mut self, card: &Card, code: &'static str) {
        for parameter in &card.parameters {
            if let Some(InputUsage::Refused(why)) = card.keyword.rule(parameter.name).map(|r| r.usage) {
                let message = format!("{} on *{} is not supported", parameter.name, card.keyword.name);
                self.diagnostics.push(Diagnostic::error(code, message).at(parameter.span, "not supported").help(why));
            }
        }
    }

    fn include(&mut self, file: &Word) {
        if super::parameters::is_unresolved(&file.text) {
            return;
        }
        let path = self.include_path(file);
        let finding = match self.refusal(&path, file) {
            Some(finding) => finding,
            None => match self.included_text(&path) {
                Ok(text) => return self.text(&path, text, Some(file.span)),
                Err(e) => unreadable(&path, file, &e),
            },
        };
        self.deck.unread.files = true;
        self.diagnostics.push(finding);
    }

    /// Returns the text of an included file: that of the caller, or that on disk.
    fn included_text(&self, path: &Path) -> std::io::Result<String> {
        match (self.open_texts)(path) {
            Some(text) => Ok(source::normalise(text)),
            None => {
                let deck = Span { file: 0, ..Span::default() };
                files::read_below(self.deck.sources.folder(deck), path).map(source::decode)
            }
        }
    }

    /// Returns the path of an included file. If the path as written does not exist, for example because the deck comes
    /// from another computer (`C:\work\mat.inc`), a file of the same name in the folder of the deck is used, with a
    /// note.
    fn include_path(&mut self, file: &Word) -> PathBuf {
        let folder = self.deck.sources.folder(file.span);
        let path = folder.join(file.text.replace('\\', "/"));
        let last = file.text.rsplit(['/', '\\']).next().unwrap_or("").trim();
        let beside = folder.join(last);
        if path.exists() || last.is_empty() || last.len() == file.text.len() || !beside.is_file() {
            return path;
        }
        let what = Diagnostic::note("D008", format!("{} is read in place of {}", beside.display(), file.text));
        self.diagnostics
            .push(what.at(file.span, "no such file; a file of the same name in the folder of the deck is read"));
        beside
    }

    /// Returns the reason why a file must not be opened.
    fn refusal(&self, path: &Path, file: &Word) -> Option<Diagnostic> {
        let what = |code, message: String, label: &str| Some(Diagnostic::error(code, message).at(file.span, label));
        let path_text = path.display();
        let deck = Span { file: 0, ..Span::default() };
        if untrusted::forbids(self.deck.sources.folder(deck), path) {
            let message = format!("{} is not in the folder of the deck", file.text);
            let diagnostic = what("D011", message, "not read with --untrusted")?;
            return Some(diagnostic.help("copy the file into the folder of the deck or a folder below it"));
        }
        if path.canonicalize().is_ok_and(|p| self.chain.contains(&p)) {
            return what("D003", format!("{path_text} includes itself"), "this file is already being read");
        }
        if self.chain.len() > DEEPEST {
            return what("D004", format!("includes are nested deeper than {DEEPEST}"), "exceeds the limit");
        }
        if self.deck.sources.files().len() >= MOST_FILES {
            return what("D004", format!("more than {MOST_FILES} files are included"), "exceeds the limit");
        }
        let metadata = std::fs::metadata(path).ok()?;
        if !metadata.is_file() {
            return what("D002", format!("{path_text} is not a file"), "not a file");
        }
        let size = metadata.len();
        if self.bytes.saturating_add(size) > MOST_BYTES {
            return what("D006", format!("the deck is larger than {MOST_BYTES} bytes"), "this file exceeds the limit");
        }
        None
    }
}

/// Returns whether a line continues the parameters of a keyword line that ends with a comma.
fn continues(text: &str, line: &LineRange, fields: &LineFields, keyword: &Keyword) -> bool {
    if lexer::kind(&text[line.clone()]) != LineKind::Data {
        return false;
    }
    let free_text = matches!(keyword.name, "HEADING" | "PARAMETER");
    let is_parameter = |range: &LineRange| match lexer::equals_sign(text, range.clone()) {
        Some(at) => !free_text && text[range.start..at].starts_with(|c: char| c.is_alphabetic()),
        None => keywords::is_parameter(keyword, &text[range.clone()]),
    };
    let mut written = fields.ranges.iter().filter(|r| !r.is_empty()).peekable();
    written.peek().is_some() && written.all(is_parameter)
}

fn given_twice(keyword: &Keyword, second: &Parameter, first: &Parameter) -> Diagnostic {
    let what = Diagnostic::error("D106", format!("*{}: {} is given twice", keyword.name, second.name));
    what.at(second.span, "again here").at(first.span, "first here")
}

fn unknown_parameter(keyword: &Keyword, text: &str, span: Span, nearest: Option<&str>) -> Diagnostic {
    let message = format!("*{} has no parameter {}", keyword.name, beginning(text));
    let what = Diagnostic::error("D103", message);
    let known: Vec<&str> = keyword.parameters.iter().map(|r| r.name).take(12).collect();
    what.at(span, "unknown parameter").help(match nearest {
        Some(like) => format!("did you mean {like}?"),
        None if known.is_empty() => format!("*{} has no parameters", keyword.name),
        None => format!("its parameters are {}", known.join(", ")),
    })
}

fn unreadable(path: &Path, file: &Word, e: &std::io::Error) -> Diagnostic {
    let reason = if e.kind() == std::io::ErrorKind::NotFound { "no such file".to_owned() } else { e.to_string() };
    let what = Diagnostic::error("D002", format!("cannot read {}", path.display()));
    what.at(file.span, reason).help("the path is relative to the folder of the including file")
}
