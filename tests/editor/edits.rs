//! Random edits with a fixed seed: the server answers each request, and at the end it has the text of the client.

use revolve::job;
use revolve::user::Routines;
use serde_json::{Value, json};

use crate::client::{EditorClient, place};
use crate::common::faulty_decks::BAR;
use crate::common::random::RandomSequence;

const DECK: &str = "untitled:deck";

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

/// Returns the text after an edit of UTF-16 positions, and the edit as the client sends it.
fn random_edit(text: &str, random: &mut RandomSequence) -> (String, Value) {
    let ends: Vec<usize> = text.char_indices().map(|(at, _)| at).chain([text.len()]).collect();
    // A position between the two characters of a line break cannot be written.
    let inside = |at: &usize| at.checked_sub(1).is_some_and(|before| text.get(before..at + 1) == Some("\r\n"));
    let ends: Vec<usize> = ends.into_iter().filter(|at| !inside(at)).collect();
    let first = random.count(0, ends.len() - 1);
    let last = (first + random.count(0, 11)).min(ends.len() - 1);
    let piece = random.one_of(PIECES);
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

#[test]
fn random_edits_keep_the_text_and_every_request_is_answered() {
    let mut random = RandomSequence(20_261_126);
    for round in 0..30 {
        let mut text = if round % 2 == 0 { BAR.to_owned() } else { BAR.replace('\n', "\r\n") };
        let mut client = EditorClient::start(&["utf-16"], json!({ "mode": "revolve" }));
        client.open(DECK, &text);
        for version in 2..30 {
            let (new, edit) = random_edit(&text, &mut random);
            text = new;
            client.change(DECK, version, json!([edit]));
            let place = [random.count(0, 59) as u32, random.count(0, 19) as u32];
            for method in ["hover", "completion", "definition", "prepareRename"] {
                client.ask(method, DECK, place);
            }
            let methods = ["documentSymbol", "foldingRange", "semanticTokens/full", "formatting"];
            client.ask_file(random.one_of(&methods), DECK);
        }
        let wanted = sorted_codes(&text);
        client.wait_for(DECK, |found| {
            let mut codes: Vec<(String, u64)> = found.iter().map(|d| (place(d).0, place(d).1[0])).collect();
            codes.sort();
            codes.dedup();
            codes == wanted
        });
        assert!(client.finish().is_ok());
    }
}
