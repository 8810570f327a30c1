//! The deck language: diagnostics of invalid decks, valid decks, and random input.

use std::fs;
use std::path::{Path, PathBuf};

use proptest::prelude::*;
use revolve::deck::{self, Deck, Diagnostics};

/// Asserts that every span of a deck and its diagnostics is inside its file and on character boundaries.
fn assert_spans(deck: &Deck, diagnostics: &Diagnostics) {
    let words = deck.cards.iter().flat_map(|c| c.data(&deck.sources)).flat_map(|l| l.into_owned().fields);
    let values = deck.cards.iter().flat_map(|c| c.parameters.iter().filter_map(|p| p.value.clone()));
    let mut spans: Vec<_> = words.chain(values).map(|w| w.span).collect();
    spans.extend(deck.cards.iter().flat_map(|c| c.parameters.iter().map(|p| p.span).chain([c.span])));
    spans.extend(deck.cards.iter().flat_map(|c| c.data(&deck.sources).map(|l| l.span)));
    spans.extend(diagnostics.iter().flat_map(|d| d.labels.iter().map(|l| l.span)));
    for span in spans {
        let file = deck.sources.file(span).expect("file of a span");
        assert!(file.text.get(span.start as usize..span.end as usize).is_some(), "{span:?}");
    }
}

fn read(text: &str) -> (Deck, Diagnostics) {
    let (deck, diagnostics) = deck::read_text("test.inp", text, &[]);
    assert_spans(&deck, &diagnostics);
    (deck, diagnostics)
}

fn fields(deck: &Deck, card: usize) -> Vec<Vec<String>> {
    deck.cards[card].data(&deck.sources).map(|l| l.fields.iter().map(|w| w.text.clone()).collect()).collect()
}

fn codes(diagnostics: &Diagnostics) -> Vec<&str> {
    diagnostics.iter().map(|d| d.code).collect()
}

/// Returns the decks in a folder, sorted by name.
fn decks_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path());
    let mut decks: Vec<_> = entries.filter(|p| p.extension().is_some_and(|e| e == "inp")).collect();
    decks.sort();
    decks
}

#[test]
fn invalid_decks_give_pinned_messages() {
    let decks = decks_in(Path::new("tests/decks/bad"));
    assert!(decks.len() >= 15);
    for path in decks {
        let (deck, mut diagnostics) = deck::read(&path, &[]);
        read_all_numbers(&deck, &mut diagnostics);
        assert_spans(&deck, &diagnostics);
        assert!(diagnostics.has_errors(), "{}", path.display());
        let name = path.file_stem().expect("name").to_string_lossy().into_owned();
        insta::assert_snapshot!(name, diagnostics.render(&deck.sources));
    }
}

/// Reads every field of `*NODE` as a number and labels as integers, as the model does.
fn read_all_numbers(deck: &Deck, diagnostics: &mut Diagnostics) {
    for line in deck.cards.iter().filter(|c| c.keyword.name == "NODE").flat_map(|c| c.data(&deck.sources)) {
        line.fields[0].integer(diagnostics);
        for word in &line.fields[1..] {
            word.number(diagnostics);
        }
    }
}

#[test]
fn valid_deck_with_all_features_is_read() {
    let (deck, diagnostics) = deck::read(Path::new("tests/decks/good/everything.inp"), &[]);
    assert_spans(&deck, &diagnostics);
    assert!(diagnostics.is_empty(), "{}", diagnostics.render(&deck.sources));
    let names: Vec<_> = deck.cards.iter().map(|c| c.keyword.name).collect();
    assert_eq!(names, ["HEADING", "NODE", "MATERIAL", "DENSITY", "ELEMENT OUTPUT", "NSET"]);
    let node = &deck.cards[1];
    assert!(node.has("NSET") && node.has("INTERNAL"));
    assert_eq!(fields(&deck, 1), [vec!["1", "0.", "0."], vec!["2", "1.", "4"], vec!["9", "2", "1.57d0"]]);
    assert_eq!(deck.sources.text(node.rows[1].line(&deck.sources).fields[2].span), "<n>");
    assert_eq!(deck.cards[2].value("NAME").map(|w| w.text.as_str()), Some("PLATE"));
    assert_eq!(fields(&deck, 4), [vec!["S", "E"]]);
    assert_eq!(fields(&deck, 5), [vec!["1", "4"]]);
    assert_eq!(deck.parameters, [("n".to_owned(), 4.0), ("r".to_owned(), 2.0)]);
}

#[test]
fn overrides_replace_definitions() {
    let text = "*Parameter\na = 2\nb = 3*a\nm = 'X'\n*Nset, nset=<m>\n<b>\n";
    let set = |pairs: &[(&str, &str)]| {
        let pairs: Vec<_> = pairs.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect();
        deck::read_text("test.inp", text, &pairs)
    };
    let (deck, diagnostics) = set(&[("a", "1+4"), ("m", "AL6061-T6")]);
    assert!(diagnostics.is_empty(), "{}", diagnostics.render(&deck.sources));
    assert_eq!(fields(&deck, 0), [["15"]]);
    assert_eq!(deck.cards[0].value("NSET").map(|w| w.text.as_str()), Some("AL6061-T6"));
    assert_eq!(codes(&set(&[("A", "1")]).1), ["D403"]);
    assert_eq!(codes(&set(&[("a", "1+")]).1), ["D407"]);
}

#[test]
fn keyword_line_variants_are_read() {
    let (deck, diagnostics) = read(
        "*MATERIAL, NAME=\"a, b=c\",\n210e9, 0.3\n*Output,FIELD,VAR=PRE, TIMEINT=1e-3,\n\n\n op=NEW\n*Nset,nset=\"q\"",
    );
    assert!(diagnostics.is_empty(), "{}", diagnostics.render(&deck.sources));
    assert_eq!(deck.cards[0].value("NAME").map(|w| (w.text.as_str(), w.quoted)), Some(("a, b=c", true)));
    assert_eq!(fields(&deck, 0), [["210e9", "0.3"]]);
    assert_eq!(
        deck.cards[1].parameters.iter().map(|p| p.name).collect::<Vec<_>>(),
        ["FIELD", "VARIABLE", "TIME INTERVAL", "OP"]
    );
}

#[test]
fn stray_commas_keep_data() {
    for text in
        ["*Node Output,\nU, V\n", "*Elset, elset=A,\n1, 2\n", "*Parameter,\nnset = 4\n*Node\n", "*Heading,\ninput=3\n"]
    {
        let (deck, diagnostics) = read(text);
        assert!(diagnostics.is_empty(), "{text}: {}", diagnostics.render(&deck.sources));
    }
}

#[test]
fn empty_data_line_does_not_continue_a_record() {
    let (deck, _) = read("*Solid Section, elset=A, material=B,\n,\n");
    assert_eq!(fields(&deck, 0), [[""]]);
}

#[test]
fn data_line_variants_are_read() {
    let (deck, _) = read(
        "*Dynamic, Explicit\n, 8e-05\n*Solid Section, elset=A, material=B\n,\n*Amplitude, name=A\n0., 0.,\t1.,1.,\n\n** x\n2., 1.",
    );
    assert_eq!(fields(&deck, 0), [["", "8e-05"]]);
    assert_eq!(fields(&deck, 1), [[""]]);
    assert_eq!(fields(&deck, 2), [vec!["0.", "0.", "1.", "1."], vec!["2.", "1."]]);
    assert!(deck.cards[0].lines[0].field(0).is_none());
}

#[test]
fn include_depth_is_limited() {
    let folder = tempfile::tempdir().expect("folder");
    for i in 0..50 {
        let text = format!("*Include, input=f{}.inc\n", i + 1);
        fs::write(folder.path().join(format!("f{i}.inc")), text).expect("file");
    }
    let (_, diagnostics) = deck::read(&folder.path().join("f0.inc"), &[]);
    assert_eq!(codes(&diagnostics), ["D004"]);
}

#[test]
fn number_of_includes_is_limited() {
    let folder = tempfile::tempdir().expect("folder");
    for i in 0..31 {
        let text = format!("*Include, input=f{0}.inc\n*Include, input=f{0}.inc\n", i + 1);
        fs::write(folder.path().join(format!("f{i}.inc")), text).expect("file");
    }
    fs::write(folder.path().join("f31.inc"), "** end\n").expect("file");
    let (_, diagnostics) = deck::read(&folder.path().join("f0.inc"), &[]);
    assert!(diagnostics.iter().all(|d| d.code == "D004") && diagnostics.has_errors());
}

#[test]
fn includes_must_be_regular_files() {
    for name in ["/dev/zero", "/", ""] {
        let (_, diagnostics) = deck::read_text("test.inp", &format!("*Include, input=\"{name}\"\n"), &[]);
        assert_eq!(codes(&diagnostics), ["D002"], "{name}");
    }
}

#[test]
fn encodings() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("deck.inp");
    let utf16: Vec<u8> = "\u{FEFF}*Node\r\n1, 0., 1.".encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [&b"\xEF\xBB\xBF*Node\r\n1, 0., 1."[..], b"** \xFC\n*NODE\r1,0.,1.,", &utf16] {
        fs::write(&path, bytes).expect("file");
        let (deck, diagnostics) = deck::read(&path, &[]);
        assert!(diagnostics.is_empty(), "{}", diagnostics.render(&deck.sources));
        assert_eq!(fields(&deck, 0), [["1", "0.", "1."]]);
    }
    fs::write(&path, b"\0\0\0").expect("file");
    assert_eq!(codes(&deck::read(&path, &[]).1), ["D005"]);
    assert_eq!(codes(&deck::read(folder.path(), &[]).1), ["D001"]);
}

#[test]
fn large_decks_are_read_in_bounded_time() {
    let mut text = String::from("*Node\n");
    for i in 0..200_000 {
        text += &format!("{i}, 0.1, 1.o\n");
    }
    let (deck, mut diagnostics) = read(&text);
    read_all_numbers(&deck, &mut diagnostics);
    assert_eq!(diagnostics.error_count(), 200_000);
    assert!(diagnostics.render(&deck.sources).contains("and 199980 more errors"));
}

#[test]
fn keyword_page_matches_the_table() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/keywords.md");
    let manual = deck::manual::keyword_manual();
    if std::env::var_os("REVOLVE_BLESS").is_some() {
        fs::write(&path, &manual).expect("manual written");
    }
    let written = fs::read_to_string(&path).unwrap_or_default();
    assert!(written == manual, "docs/keywords.md is out of date: run again with REVOLVE_BLESS=1");
}

#[test]
fn abaqus_page_matches_the_table() {
    let path = Path::new("docs/abaqus.md");
    let page = deck::manual::abaqus_page();
    if std::env::var_os("REVOLVE_BLESS").is_some() {
        fs::write(path, &page).expect("write the page");
    }
    assert!(fs::read_to_string(path).unwrap_or_default() == page, "docs/abaqus.md is stale: REVOLVE_BLESS=1");
    for name in ["`*CONTACT PAIR` | partial", "`*STATIC` | unsupported", "`*PREPRINT` | ignored", "`*DENSITY` | "] {
        assert!(page.contains(name), "{name}");
    }
}

#[test]
fn keywords_are_explained() {
    let text = deck::manual::explain_keyword("*rigidbody").expect("known");
    assert!(text.contains("REF NODE") && text.contains("Supported"));
    let text = deck::manual::explain_keyword("dsload").expect("known");
    assert!(text.contains("TARGET") && text.contains("(extension)") && !text.contains('+'));
    assert!(deck::manual::explain_keyword("nonsense").is_none());
    assert!(deck::find_code("d101").is_some());
}

/// Returns random pieces of decks.
fn piece() -> impl Strategy<Value = String> {
    let known = [
        "*NODE",
        "*PARAMETER\n",
        "*HEADING",
        "*INCLUDE, INPUT=",
        ",",
        "=",
        "\n",
        "\"",
        "<a>",
        "<",
        ">",
        "a = 1/0\n",
        "**",
        "a=2**9**9\n",
    ];
    let more = [
        "*RESTART, READ",
        "*STATIC",
        "*OUTPUT, TIME=",
        "1.o",
        "é",
        "\t",
        "\r\n",
        "'",
        "#",
        "(",
        "\u{a0}",
        "*",
        "\\",
        "test.inp",
        "GENERATE",
    ];
    prop_oneof![
        prop::sample::select([&known[..], &more[..]].concat()).prop_map(str::to_owned),
        "\\PC{0,6}",
        "[ -~]{0,8}"
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn random_text_never_panics(pieces in prop::collection::vec(piece(), 0..40), set in "[ -~]{0,10}") {
        let overrides = [("a".to_owned(), set)];
        let (deck, mut diagnostics) = deck::read_text("no_such_folder/test.inp", &pieces.concat(), &overrides);
        read_all_numbers(&deck, &mut diagnostics);
        assert_spans(&deck, &diagnostics);
        diagnostics.render(&deck.sources);
        diagnostics.render_styled(&deck.sources);
    }

    #[test]
    fn random_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let (deck, diagnostics) = read(&deck::source::decode(bytes));
        diagnostics.render(&deck.sources);
    }

    #[test]
    fn damaged_decks_never_panic(at in 0.0..1.0f64, cut in 0usize..40, pieces in prop::collection::vec(piece(), 0..3), which in 0usize..2) {
        let path = ["tests/decks/good/everything.inp", "tests/decks/bad/parameter_errors.inp"][which];
        let text = fs::read_to_string(path).expect("deck");
        let letters: Vec<char> = text.chars().collect();
        let start = (at * letters.len() as f64) as usize;
        let end = (start + cut).min(letters.len());
        let damaged: String = letters[..start].iter().copied().chain(pieces.concat().chars()).chain(letters[end..].iter().copied()).collect();
        let (deck, diagnostics) = deck::read_text(path, &damaged, &[]);
        assert_spans(&deck, &diagnostics);
        diagnostics.render(&deck.sources);
    }

    #[test]
    fn invalid_spans_never_panic(start in 0u32..40, end in 0u32..40, file in 0u32..3) {
        let (deck, _) = deck::read_text("test.inp", "*Node\n1, é, \u{1F600}\n\n2,,", &[]);
        let mut diagnostics = Diagnostics::default();
        let span = deck::Span { file, start, end };
        diagnostics.push(deck::Diagnostic::error("D101", "test").at(span, "here").at(deck::Span::default(), "there"));
        diagnostics.render(&deck.sources);
        deck.sources.describe(span);
    }
}
