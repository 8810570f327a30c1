//! Random edits: the server answers each request, and has the text of the client. Diagnostics are those of a check of
//! this text, and syntax, symbols and folding those of a file that is opened with it.

use std::fs;
use std::time::{Duration, Instant, SystemTime};

use revolve::job;
use revolve::user::Routines;
use serde_json::{Value, json};

use crate::client::{EditorClient, place};
use crate::common::faulty_decks::BAR;
use crate::common::project;
use crate::common::random::RandomSequence;

const DECK: &str = "untitled:deck";
/// A second file with the text of the deck.
const COPY: &str = "untitled:copy";

/// Pieces that edits insert.
const PIECES: &[&str] = &[
    "*Elastic\n",
    "*",
    "**",
    ",",
    "=",
    "\"",
    "\n",
    "\r\n",
    " 1., 2.\n",
    "\u{e4}",
    "\u{1f600}",
    "<length>",
    "*Step\n",
    "*End Step\r\n",
    "*Node, nset=A\n 99, 0., 0.\n",
    "",
    "",
    "*Include, input=none.inc\n",
    "$ x\n",
    "*Nset, nset=BAR,\n",
];

/// Returns the text after an edit of UTF-16 positions, and the edit as the client sends it. At most `most` characters
/// are replaced.
fn random_edit(text: &str, piece: &str, most: usize, random: &mut RandomSequence) -> (String, Value) {
    let ends: Vec<usize> = text.char_indices().map(|(at, _)| at).chain([text.len()]).collect();
    // A position between the two characters of a line break cannot be written.
    let inside = |at: &usize| at.checked_sub(1).is_some_and(|before| text.get(before..at + 1) == Some("\r\n"));
    let ends: Vec<usize> = ends.into_iter().filter(|at| !inside(at)).collect();
    let first = random.count(0, ends.len() - 1);
    let last = (first + random.count(0, most)).min(ends.len() - 1);
    let position = |at: usize| {
        let before = &text[..at];
        let start = before.rfind(['\n', '\r']).map_or(0, |at| at + 1);
        let breaks = before.replace("\r\n", "\n").matches(['\n', '\r']).count();
        json!({ "line": breaks, "character": before[start..].encode_utf16().count() })
    };
    let (start, end) = (ends[first], ends[last]);
    let edit = json!({ "range": { "start": position(start), "end": position(end) }, "text": piece });
    (format!("{}{piece}{}", &text[..start], &text[end..]), edit)
}

fn sorted_codes(text: &str) -> Vec<(String, u64)> {
    let prepared = job::prepare_text(DECK, text, &[], &Routines::none());
    let sources = &prepared.deck.sources;
    let line = |d: &revolve::deck::Diagnostic| {
        d.labels.first().map_or(0, |label| sources.line_column(label.span).0 as u64 - 1)
    };
    let mut codes: Vec<(String, u64)> = prepared.diagnostics.iter().map(|d| (d.code.to_owned(), line(d))).collect();
    codes.sort();
    codes.dedup();
    codes
}

/// Waits until the diagnostics are those of a check of the text.
fn wait_for_check(client: &mut EditorClient, text: &str) {
    let wanted = sorted_codes(text);
    client.wait_for(DECK, |found| {
        let failed = |d: &Value| d["message"].as_str().is_some_and(|text| text.contains("failed inside the program"));
        assert!(!found.iter().any(failed), "{text}");
        let mut codes: Vec<(String, u64)> = found.iter().map(|d| (place(d).0, place(d).1[0])).collect();
        codes.sort();
        codes.dedup();
        codes == wanted
    });
}

/// Asks about random places of the deck.
fn ask(client: &mut EditorClient, lines: usize, random: &mut RandomSequence) -> usize {
    let place = [random.count(0, lines) as u32, random.count(0, 29) as u32];
    for method in ["hover", "completion", "definition", "prepareRename"] {
        client.ask(method, DECK, place);
    }
    let methods = ["documentSymbol", "foldingRange", "semanticTokens/full", "formatting"];
    client.ask_file(random.one_of(&methods), DECK);
    let range = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": lines, "character": 0 } });
    let params = json!({ "textDocument": { "uri": DECK }, "range": range, "context": { "diagnostics": [] } });
    for method in ["inlayHint", "codeAction"] {
        client.request(&format!("textDocument/{method}"), params.clone()).expect("an answer");
    }
    7
}

/// Compares answers about the edited text with those about a file that is opened with the text of the client.
fn assert_same_text(client: &mut EditorClient, text: &str) {
    client.open(COPY, text);
    for method in ["semanticTokens/full", "foldingRange", "documentSymbol", "formatting"] {
        assert_eq!(client.ask_file(method, DECK), client.ask_file(method, COPY), "{method}: {text}");
    }
    client.notify("textDocument/didClose", json!({ "textDocument": { "uri": COPY } }));
}

#[test]
fn random_edits_keep_the_text_and_every_request_is_answered() {
    let mut random = RandomSequence(20_261_126);
    for round in 0..30 {
        let mut text = if round % 2 == 0 { BAR.to_owned() } else { BAR.replace('\n', "\r\n") };
        let mut client = EditorClient::start(&["utf-16"], json!({ "mode": "revolve" }));
        client.open(DECK, &text);
        for version in 2..30 {
            let piece = random.one_of(PIECES);
            let (new, edit) = random_edit(&text, piece, 11, &mut random);
            text = new;
            client.change(DECK, version, json!([edit]));
            ask(&mut client, 59, &mut random);
        }
        wait_for_check(&mut client, &text);
        assert_same_text(&mut client, &text);
        assert!(client.finish().is_ok());
    }
}

/// Decks of the project that are short enough to be checked many times.
fn short_decks() -> Vec<String> {
    let mut decks = vec![BAR.to_owned(), BAR.replace('\n', "\r\n")];
    for folder in ["input", "tests/decks/bad", "tests/decks/good"] {
        for entry in fs::read_dir(project(folder)).expect("decks") {
            let path = entry.expect("a deck").path();
            if path.extension().is_some_and(|end| end == "inp") {
                decks.extend(fs::read_to_string(path).ok().filter(|text| text.len() < 6000));
            }
        }
    }
    decks
}

/// Returns some lines of a deck.
fn random_lines(decks: &[String], random: &mut RandomSequence) -> String {
    let lines: Vec<&str> = decks[random.count(0, decks.len() - 1)].split_inclusive('\n').collect();
    let first = random.count(0, lines.len() - 1);
    lines[first..(first + random.count(1, 6)).min(lines.len())].concat()
}

/// Edits a deck for one session: typing, removed and pasted lines, several edits in a message, and whole texts. Returns
/// the numbers of edits and requests.
fn edit_session(decks: &[String], random: &mut RandomSequence) -> [usize; 2] {
    let mut text = decks[random.count(0, decks.len() - 1)].clone();
    let mode = random.one_of(&["revolve", "auto", "abaqus"]);
    let mut client = EditorClient::start(&["utf-16"], json!({ "mode": mode }));
    client.open(DECK, &text);
    let (mut edits, mut requests) = (0, 0);
    for version in 2..40 {
        let mut changes = Vec::new();
        for _ in 0..random.count(1, 3) {
            if random.count(0, 60) == 0 {
                text.clone_from(&decks[random.count(0, decks.len() - 1)]);
                changes.push(json!({ "text": text }));
                continue;
            }
            let pasted = random_lines(decks, random);
            let piece = if random.count(0, 3) == 0 { pasted.as_str() } else { random.one_of(PIECES) };
            let most = random.one_of(&[0, 1, 11, 200]);
            let (new, edit) = random_edit(&text, piece, most, random);
            text = new;
            changes.push(edit);
        }
        edits += changes.len();
        client.change(DECK, version, changes.into());
        if random.count(0, 2) == 0 {
            requests += ask(&mut client, text.matches('\n').count() + 2, random);
        }
        if version % 10 == 0 {
            wait_for_check(&mut client, &text);
            assert_same_text(&mut client, &text);
            requests += 8;
        }
    }
    assert!(client.finish().is_ok());
    [edits, requests]
}

/// Random edits of the decks of the project, for the minutes of `REVOLVE_MINUTES` (30).
#[test]
#[ignore = "takes half an hour"]
fn edits_for_minutes() {
    let minutes = std::env::var("REVOLVE_MINUTES").map_or(30.0, |text| text.parse().expect("minutes"));
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).expect("a time");
    let seed = std::env::var("REVOLVE_SEED").map_or(now.as_millis() as u64, |text| text.parse().expect("a seed"));
    println!("REVOLVE_SEED={seed}");
    let (decks, mut random, begin) = (short_decks(), RandomSequence(seed), Instant::now());
    let (mut sessions, mut edits, mut requests) = (0, 0, 0);
    while begin.elapsed() < Duration::from_secs_f64(60.0 * minutes) {
        let done = edit_session(&decks, &mut random);
        (sessions, edits, requests) = (sessions + 1, edits + done[0], requests + done[1]);
    }
    println!("{} decks, {sessions} sessions, {edits} edits, {requests} requests", decks.len());
    assert!(sessions > 0);
}
