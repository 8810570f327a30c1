//! Diagnostics: those of `revolve check` with the same codes and ranges, also in included files; levels for decks of
//! other analyses; quick fixes.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use revolve::job::{self, PreparedJob};
use revolve::user::Routines;
use serde_json::{Value, json};

use crate::client::{EditorClient, place, uri};
use crate::common::faulty_decks::{BAR, DOUBTFUL, TRIFLES, WRONG, changed};
use crate::common::project;

/// Code, and first and last line and column.
type DiagnosticPlace = (String, [u64; 4]);

/// Returns the places of the diagnostics of `check` by path; the columns count UTF-16 units.
fn checked(prepared: &PreparedJob) -> BTreeMap<PathBuf, Vec<DiagnosticPlace>> {
    let sources = &prepared.deck.sources;
    let mut found: BTreeMap<PathBuf, Vec<DiagnosticPlace>> = BTreeMap::new();
    for diagnostic in prepared.diagnostics.iter() {
        let label = diagnostic.labels.first().filter(|label| sources.file(label.span).is_some());
        let file = label.and_then(|label| sources.file(label.span)).unwrap_or(&sources.files()[0]);
        let units = |text: &str| text.encode_utf16().count() as u64;
        let range = label.map_or([0; 4], |label| {
            let position = |byte: u32| {
                let before = &file.text[..byte as usize];
                let start = before.rfind('\n').map_or(0, |at| at + 1);
                [before.matches('\n').count() as u64, units(&before[start..])]
            };
            let ([a, b], [c, d]) = (position(label.span.start), position(label.span.end));
            [a, b, c, d]
        });
        found.entry(file.path.clone()).or_default().push((diagnostic.code.to_owned(), range));
    }
    found.values_mut().for_each(|list| {
        list.sort();
        list.dedup();
    });
    found
}

/// Opens a deck and compares the diagnostics of all its files with those of `check`.
fn assert_like_check(client: &mut EditorClient, path: &Path, text: &str) {
    fs::write(path, text).expect("written");
    assert_file_like_check(client, path);
}

fn assert_file_like_check(client: &mut EditorClient, path: &Path) {
    let wanted = checked(&job::prepare(path, &[], &Routines::none()));
    let bytes = fs::read(path).expect("a deck");
    client.open(&uri(path), &revolve::deck::source::decode(bytes));
    for (file, list) in &wanted {
        let file = file.canonicalize().unwrap_or(file.clone());
        let sorted = |found: &[Value]| {
            let mut places: Vec<DiagnosticPlace> = found.iter().map(place).collect();
            places.sort();
            places.dedup();
            places
        };
        client.wait_for(&uri(&file), |found| sorted(found) == *list);
    }
    let document = json!({ "textDocument": { "uri": uri(path) } });
    client.notify("textDocument/didClose", document);
}

#[test]
fn snapshot_decks_have_the_diagnostics_of_check() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path().canonicalize().expect("a folder");
    let mut client = EditorClient::start(&["utf-16"], json!({ "mode": "revolve" }));
    let wrong = WRONG.iter().map(|(name, change, _)| (*name, *change));
    let all = wrong.chain(DOUBTFUL.iter().copied()).chain(TRIFLES.iter().copied());
    let mut count = 0;
    for (name, change) in all {
        assert_like_check(&mut client, &folder.join(format!("{}.inp", name.replace('/', "_"))), &changed(change));
        count += 1;
    }
    assert!(count > 70, "{count}");
    for entry in fs::read_dir(project("tests/decks/bad")).expect("decks") {
        let path = entry.expect("a deck").path();
        if path.is_file() {
            assert_file_like_check(&mut client, &path);
        }
    }
    assert_like_check(&mut client, &folder.join("bar.inp"), BAR);
    assert!(client.finish().is_ok());
}

#[test]
fn open_texts_replace_included_files_on_disk() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path().canonicalize().expect("a folder");
    let (main, part) = (folder.join("main.inp"), folder.join("steel.inc"));
    let law = "*Material, name=METAL\n*Density\n 1.,\n*Elastic\n 100., 0.3\n*Plastic\n 0.5, 0.\n 2., 1.\n";
    fs::write(&part, law).expect("written");
    let text = BAR.replace(law, "*Include, input=steel.inc\n");
    fs::write(&main, &text).expect("written");
    let mut client = EditorClient::start(&["utf-16"], json!({ "mode": "revolve" }));
    client.open(&uri(&main), &text);
    client.wait_for(&uri(&main), <[Value]>::is_empty);
    // The text of the included file is wrong in the editor, not on disk.
    client.open(&uri(&part), &law.replace("*Elastic", "** \u{e4}\n*Elastc"));
    let found = client.wait_for(&uri(&part), |found| !found.is_empty());
    assert_eq!(place(&found[0]), ("D101".into(), [4, 0, 4, 7]));
    assert!(found[0]["message"].as_str().is_some_and(|text| text.contains("`revolve explain D101`")));
    // The file does not become a deck by itself when it is edited.
    client.change(&uri(&part), 2, json!([{ "text": law }]));
    client.wait_for(&uri(&part), <[Value]>::is_empty);
    // Alone it belongs to the deck that includes it.
    client.notify("textDocument/didClose", json!({ "textDocument": { "uri": uri(&main) } }));
    client.change(&uri(&part), 3, json!([{ "text": law.replace("100., 0.3", "100., 0.7") }]));
    let found = client.wait_for(&uri(&part), |found| !found.is_empty());
    assert_eq!(place(&found[0]).1[0], 4);
    assert!(client.finish().is_ok());
}

#[test]
fn unsupported_physics_are_hints_unless_the_deck_is_for_revolve() {
    let text = BAR.replace("*Plastic\n 0.5, 0.\n 2., 1.\n", "*Creep, law=TIME\n 1., 2., 3.\n*Plastik\n 1., 0.\n");
    for (mode, of_creep, of_typo) in [("auto", 4, 2), ("revolve", 1, 1), ("abaqus", 4, 2)] {
        let mut client = EditorClient::start(&["utf-16"], json!({ "mode": mode }));
        client.open("untitled:deck", &text);
        let found = client.wait_for("untitled:deck", |found| found.len() > 1);
        let level = |code: &str| found.iter().find(|d| d["code"] == code).map(|d| d["severity"].as_u64());
        assert_eq!(level("D201"), Some(Some(of_creep)), "{mode}");
        assert_eq!(level("D101"), Some(Some(of_typo)), "{mode}");
        assert!(client.finish().is_ok());
    }
    let mut client = EditorClient::start(&["utf-16"], Value::Null);
    client.open("untitled:deck", &changed("material=METAL => material=METALL"));
    let found = client.wait_for("untitled:deck", |found| !found.is_empty());
    assert_eq!(found[0]["severity"], 1);
    assert!(client.finish().is_ok());
}

/// Replaces a range of a text of ASCII letters.
fn with_edit(text: &str, edit: &Value) -> String {
    let offset = |place: &Value| {
        let line = place["line"].as_u64().expect("a line") as usize;
        let start: usize = text.split_inclusive('\n').take(line).map(str::len).sum();
        start + place["character"].as_u64().expect("a column") as usize
    };
    let (start, end) = (offset(&edit["range"]["start"]), offset(&edit["range"]["end"]));
    format!("{}{}{}", &text[..start], edit["newText"].as_str().expect("a text"), &text[end..])
}

/// Returns the first quick fix of the first diagnostic of a deck, and the code of the diagnostic.
fn first_fix(client: &mut EditorClient, text: &str) -> (Value, Value) {
    client.open("untitled:deck", text);
    let found = client.wait_for("untitled:deck", |found| !found.is_empty());
    let params = json!({
        "textDocument": { "uri": "untitled:deck" },
        "range": found[0]["range"],
        "context": { "diagnostics": [] },
    });
    let actions = client.request("textDocument/codeAction", params).expect("actions");
    (actions[0]["edit"]["changes"]["untitled:deck"][0].clone(), found[0]["code"].clone())
}

#[test]
fn quick_fixes_follow_the_case_of_their_line() {
    let cases = [
        ("*Elastic => *Elastc", "*Elastic"),
        ("*Elastic => *ELASTC", "*ELASTIC"),
        ("BAR, material=METAL => BAR, materail=METAL", "material"),
        ("*Solid Section, elset=BAR, material=METAL => *SOLID SECTION, ELSET=BAR, MATERAIL=METAL", "MATERIAL"),
        ("*Dynamic, Explicit => *Dynamic", "*Dynamic, Explicit"),
        ("name=METAL => name=Metal;; material=METAL => material=Metall", "Metal"),
        ("type=CAX4R => type=cax4s", "cax4r"),
        ("type=CAX4R => type=CAX4S", "CAX4R"),
    ];
    for (change, written) in cases {
        let mut client = EditorClient::start(&["utf-16"], json!({ "mode": "revolve" }));
        let (edit, _) = first_fix(&mut client, &changed(change));
        assert_eq!(edit["newText"], written, "{change}");
        assert!(client.finish().is_ok());
    }
}

#[test]
fn quick_fixes_remove_their_diagnostics() {
    let changes = [
        "*Elastic => *Elastc",
        "BAR, material=METAL => BAR, materail=METAL",
        "material=METAL => material=METALL",
        "11, 0., <length> => 11, 0., <lenght>",
        "1.,\\n*Elastic => 1,5\\n*Elastic",
        "100., 0.3 => 100. 0.3",
        "1.,\\n*Elastic => 1O.,\\n*Elastic",
        "*Parameter\\n => * units: m, kg\\n*Parameter\\n",
        "*Plastic => $ yield stress\\n*Plastic",
        " 1, 0., 0. => 1.0, 0., 0.",
        "*Dynamic, Explicit => *Dynamic",
    ];
    for change in changes {
        let text = changed(change);
        let mut client = EditorClient::start(&["utf-16"], json!({ "mode": "revolve" }));
        let (edit, code) = first_fix(&mut client, &text);
        assert!(edit.is_object(), "{change}: {code}");
        client.change("untitled:deck", 2, json!([{ "text": with_edit(&text, &edit) }]));
        client.wait_for("untitled:deck", |found| found.iter().all(|d| d["code"] != code));
        assert!(client.finish().is_ok());
    }
}
