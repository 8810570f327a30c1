//! Documentation, completion, navigation, outline and formatting.

use std::fs;

use revolve::job;
use revolve::user::Routines;
use serde_json::{Value, json};

use crate::client::{EditorClient, uri};
use crate::common::faulty_decks::{BAR, changed};
use crate::common::project;

const DECK: &str = "untitled:deck";

/// Starts a session with a deck, and waits for its first check.
fn session(text: &str) -> EditorClient {
    let mut client = EditorClient::start(&["utf-16"], Value::Null);
    client.open(DECK, text);
    client
}

/// Returns the position of the first character of a piece of the bar deck.
fn place_of(text: &str, piece: &str) -> [u32; 2] {
    let at = text.find(piece).expect("a piece");
    let start = text[..at].rfind('\n').map_or(0, |at| at + 1);
    [text[..at].matches('\n').count() as u32, (at - start) as u32]
}

fn after([line, character]: [u32; 2], columns: u32) -> [u32; 2] {
    [line, character + columns]
}

fn labels(answer: &Value) -> Vec<String> {
    let items = answer["items"].as_array().expect("items");
    items.iter().map(|item| item["label"].as_str().expect("a label").to_owned()).collect()
}

#[test]
fn hovers_explain_keywords_parameters_fields_and_names() {
    let mut client = session(BAR);
    let mut hover = |piece: &str, columns: u32| {
        let answer = client.ask("hover", DECK, after(place_of(BAR, piece), columns));
        answer["contents"]["value"].as_str().unwrap_or_default().to_owned()
    };
    let keyword = hover("*Plastic", 3);
    assert!(keyword.contains("*PLASTIC") && keyword.contains("\n- `HARDENING`: "), "{keyword}");
    assert!(keyword.lines().all(|line| !line.starts_with(' ') || line.trim_start().starts_with("- ")), "{keyword}");
    assert!(hover("material=METAL", 2).contains("MATERIAL"));
    assert!(hover(" 100., 0.3", 2).contains("Young"), "{}", hover(" 100., 0.3", 2));
    assert!(hover(" FOOT, 2, 2", 2).contains("node set"), "{}", hover(" FOOT, 2, 2", 2));
    assert!(hover("\n U2\n", 0).is_empty() || !hover("PEEQ", 1).is_empty());
    assert!(hover("PEEQ", 1).contains("plastic strain"), "{}", hover("PEEQ", 1));
    assert!(!hover(" 100., 0.3", 10).is_empty() && hover(" 100., 0.3", 11).is_empty(), "after the end of the line");
    assert!(hover("*Plastic", 9).is_empty());
    assert!(client.finish().is_ok());
}

#[test]
fn hovers_describe_names_after_the_check() {
    let mut client = session(BAR);
    client.wait_for(DECK, |_| true);
    // The check of this small deck ends soon; its result is used from then on.
    let mut text = String::new();
    while !text.contains("2 nodes") {
        let answer = client.ask("hover", DECK, after(place_of(BAR, " FOOT, 2, 2"), 2));
        text = answer["contents"]["value"].as_str().unwrap_or_default().to_owned();
        std::thread::yield_now();
    }
    assert!(text.contains("r from 0 to 1") && text.contains("line 5"), "{text}");
    let range = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } });
    let hints = client.request("textDocument/inlayHint", json!({ "textDocument": { "uri": DECK }, "range": range }));
    let hints = hints.expect("hints").to_string();
    // The volume of the cylinder is 2 pi.
    assert!(hints.contains("mass 6.283"), "{hints}");
    assert!(client.finish().is_ok());
}

/// Two sections of one material have separate hints.
#[test]
fn hints_of_sections_of_one_material_are_separate() {
    let text = changed(
        "*Solid Section, elset=BAR, material=METAL => *Elset, elset=LOWER\\n 1,\\n*Solid Section, elset=LOWER, material=METAL\\n*Solid Section, elset=UPPER, material=METAL",
    );
    let mut client = session(&text);
    let range = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } });
    loop {
        let params = json!({ "textDocument": { "uri": DECK }, "range": range });
        let hints = client.request("textDocument/inlayHint", params).expect("hints").to_string();
        if hints.contains("mass") {
            // Half of the cylinder each.
            assert_eq!(hints.matches("mass 3.142").count(), 2, "{hints}");
            break;
        }
        std::thread::yield_now();
    }
    assert!(client.finish().is_ok());
}

/// Returns the stable time increment that the hint of a section shows after a word.
fn hinted_increment(text: &str, relation: &str) -> f64 {
    let begin = format!("stable dt {relation} ");
    let mut client = session(text);
    let range = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } });
    loop {
        let params = json!({ "textDocument": { "uri": DECK }, "range": range });
        let hints = client.request("textDocument/inlayHint", params).expect("hints");
        let labels = hints.as_array().expect("hints").iter().filter_map(|hint| hint["label"].as_str());
        if let Some(length) = labels.filter_map(|label| label.split_once(&begin)).next() {
            assert!(client.finish().is_ok());
            return length.1.parse().expect("a number");
        }
        std::thread::yield_now();
    }
}

/// Element by element the first increment is that of the hint; the estimate of the whole model makes it longer.
#[test]
fn hint_of_a_section_is_the_first_increment_of_the_run() {
    let by_elements = changed("*Dynamic, Explicit => *Dynamic, Explicit, element by element");
    let first = |text: &str| {
        let prepared = job::prepare_text("bar.inp", text, &[], &Routines::none());
        let (outcome, _) = job::run_in_memory(&prepared);
        outcome.steps[0].limits.named(&prepared.plan).increment[0]
    };
    let hinted = hinted_increment(&by_elements, "about");
    assert!((hinted / first(&by_elements) - 1.0).abs() < 1e-3, "{hinted} {}", first(&by_elements));
    assert_eq!(hinted_increment(BAR, "\u{2265}"), hinted);
    assert!(first(BAR) >= 0.999 * hinted);
}

#[test]
fn completion_offers_keywords_parameters_values_and_names() {
    let text = format!(
        "{BAR}*El\n*Solid Section, elset=BAR, \n*Solid Section, elset=, material=\n*Node Output\n ,\n*Boundary\n ,\n*Amplitude, name=A, time=\n"
    );
    let mut client = session(&text);
    // Columns after the end of the line count from the start of the next one.
    let mut complete = |piece: &str, columns: u32| {
        let [line, start] = place_of(&text, piece);
        let place = match piece.find('\n').filter(|end| *end < columns as usize) {
            Some(end) => [line + 1, columns - end as u32 - 1],
            None => [line, start + columns],
        };
        labels(&client.ask("completion", DECK, place))
    };
    let has = |list: Vec<String>, name: &str| assert!(list.iter().any(|label| label == name), "{name}: {list:?}");
    has(complete("*El\n", 3), "*ELASTIC");
    has(complete("11, 0., <length>", 9), "length");
    has(complete("type=CAX4R", 5), "CAX3");
    has(complete("*Solid Section, elset=BAR, \n", 27), "MATERIAL");
    assert!(!complete("*Solid Section, elset=BAR, \n", 27).contains(&"ELSET".to_owned()));
    has(complete("*Solid Section, elset=, material=", 22), "BAR");
    has(complete("*Solid Section, elset=, material=", 33), "METAL");
    has(complete("*Node Output\n ,", 14), "V");
    has(complete("*Node Output\n ,", 14), "U2");
    has(complete("*Boundary\n ,\n", 11), "FOOT");
    has(complete("*Amplitude, name=A, time=", 25), "TOTAL TIME");
    let answer = client.ask("completion", DECK, after(place_of(&text, "*El\n"), 3));
    assert_same_without_ranges(&text, &answer);
    let item = answer["items"].as_array().and_then(|items| items.iter().find(|item| item["label"] == "*ELASTIC"));
    let resolved = client.request("completionItem/resolve", item.expect("an item").clone()).expect("resolved");
    let (detail, about) = (&resolved["detail"], resolved["documentation"].as_str().expect("a text"));
    assert!(about.contains("Supported"), "{resolved}");
    assert!(detail.as_str().is_some_and(|text| !text.is_empty() && !about.contains(text)), "{resolved}");
    assert!(client.finish().is_ok());
}

/// A client that takes the replaced range once for all items receives the same texts.
fn assert_same_without_ranges(text: &str, answer: &Value) {
    let mut client = EditorClient::connect();
    let list = json!({ "completion": { "completionList": { "itemDefaults": ["editRange"] } } });
    client.request("initialize", json!({ "capabilities": { "textDocument": list } })).expect("initialised");
    client.open(DECK, text);
    let short = client.ask("completion", DECK, after(place_of(text, "*El\n"), 3));
    let items = |list: &Value| list["items"].as_array().expect("items").clone();
    assert_eq!(short["itemDefaults"]["editRange"], items(answer)[0]["textEdit"]["range"]);
    for (short, long) in items(&short).iter().zip(&items(answer)) {
        let written = if short["textEditText"].is_null() { &short["label"] } else { &short["textEditText"] };
        assert!(short["textEdit"].is_null() && *written == long["textEdit"]["newText"], "{short} {long}");
    }
    assert_eq!(items(&short).len(), items(answer).len());
    assert!(client.finish().is_ok());
}

#[test]
fn names_are_found_and_renamed_across_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path().canonicalize().expect("a folder");
    let (main, part) = (folder.join("main.inp"), folder.join("law.inc"));
    let law = "*Material, name=METAL\n*Density\n 1.,\n*Elastic\n 100., 0.3\n*Plastic\n 0.5, 0.\n 2., 1.\n";
    fs::write(&part, law).expect("written");
    let text = BAR.replace(law, "*Include, input=law.inc\n");
    fs::write(&main, &text).expect("written");
    let mut client = EditorClient::start(&["utf-16"], Value::Null);
    client.open(&uri(&main), &text);
    let metal = after(place_of(&text, "material=METAL"), 10);
    let defined = client.ask("definition", &uri(&main), metal);
    let start = json!({ "line": 0, "character": 16 });
    assert_eq!((&defined[0]["uri"], &defined[0]["range"]["start"]), (&json!(uri(&part)), &start));
    assert_eq!(client.ask("references", &uri(&main), metal).as_array().map(Vec::len), Some(2));
    // A set is defined and used in one file.
    let foot = after(place_of(&text, " FOOT, 2, 2"), 1);
    assert_eq!(client.ask("references", &uri(&main), foot).as_array().map(Vec::len), Some(3));
    assert_eq!(client.ask("documentHighlight", &uri(&main), foot).as_array().map(Vec::len), Some(3));
    assert_eq!(client.ask("prepareRename", &uri(&main), foot)["placeholder"], "FOOT");
    let position = json!({ "line": metal[0], "character": metal[1] });
    let rename = |name: &str| json!({ "textDocument": { "uri": uri(&main) }, "position": position, "newName": name });
    let edits = client.request("textDocument/rename", rename("IRON")).expect("edits");
    assert_eq!(edits["changes"][&uri(&part)][0]["newText"], "IRON");
    assert_eq!(edits["changes"][&uri(&main)].as_array().map(Vec::len), Some(1));
    // Parameters are found in definitions, expressions and fields.
    let length = after(place_of(&text, "<length>"), 2);
    let hover = client.ask("hover", &uri(&main), length);
    assert!(hover["contents"]["value"].as_str().is_some_and(|text| text.contains("value 2")), "{hover}");
    assert_eq!(client.ask("references", &uri(&main), length).as_array().map(Vec::len), Some(3));
    let place = json!({ "line": length[0], "character": length[1] });
    let params = json!({ "textDocument": { "uri": uri(&main) }, "position": place, "newName": "1a" });
    assert!(client.request("textDocument/rename", params).is_err());
    // The name of an included file leads to the file.
    let file = client.ask("definition", &uri(&main), after(place_of(&text, "input=law.inc"), 8));
    assert_eq!(file[0]["uri"], uri(&part));
    assert_eq!(client.ask_file("documentLink", &uri(&main))[0]["target"], uri(&part));
    for wrong in ["", "a,b", "12", "*A"] {
        assert!(client.request("textDocument/rename", rename(wrong)).is_err(), "{wrong}");
    }
    assert!(client.finish().is_ok());
}

#[test]
fn outline_lists_materials_and_steps_with_their_cards() {
    let mut client = session(BAR);
    let symbols = client.ask_file("documentSymbol", DECK);
    let list = symbols.as_array().expect("symbols");
    let named = |name: &str| list.iter().find(|symbol| symbol["name"] == name).unwrap_or_else(|| panic!("{symbols:#}"));
    let children = |name: &str| named(name)["children"].as_array().map(Vec::len);
    assert_eq!(children("METAL"), Some(3));
    assert_eq!(children("Impact"), Some(7));
    assert_eq!(named("FOOT")["detail"], "*NODE");
    for symbol in list {
        let (range, selection) = (&symbol["range"], &symbol["selectionRange"]);
        let line = |value: &Value, end: &str| value[end]["line"].as_u64();
        assert!(line(range, "start") <= line(selection, "start") && line(selection, "end") <= line(range, "end"));
    }
    let folds = client.ask_file("foldingRange", DECK);
    assert!(folds.as_array().is_some_and(|all| all.len() > 15), "{folds}");
    let tokens = client.ask_file("semanticTokens/full", DECK);
    let numbers = tokens["data"].as_array().expect("numbers").len();
    assert!(numbers > 300 && numbers.is_multiple_of(5), "{numbers}");
    assert!(client.finish().is_ok());
}

/// Applies the edits of whole lines to a text.
fn formatted(text: &str, edits: &Value) -> String {
    let mut lines: Vec<String> = text.split('\n').map(str::to_owned).collect();
    for edit in edits.as_array().expect("edits") {
        let line = edit["range"]["start"]["line"].as_u64().expect("a line") as usize;
        assert!(edit["range"]["end"]["line"] == edit["range"]["start"]["line"]);
        let break_character = if lines[line].ends_with('\r') { "\r" } else { "" };
        lines[line] = edit["newText"].as_str().expect("a text").to_owned() + break_character;
    }
    lines.join("\n")
}

/// Returns the cards of a deck without the places of their words.
fn cards(text: &str) -> Vec<String> {
    let (deck, _) = revolve::deck::read_text("a.inp", text, &[]);
    let words =
        |line: &revolve::deck::DataLine| -> Vec<String> { line.fields.iter().map(|word| word.text.clone()).collect() };
    let card = |card: &revolve::deck::Card| {
        let lines: Vec<Vec<String>> = card.data(&deck.sources).map(|line| words(&line)).collect();
        let parameters: Vec<_> = card.parameters.iter().map(|p| (p.name, p.value.as_ref().map(|w| &w.text))).collect();
        format!("{} {parameters:?} {lines:?}", card.keyword.name)
    };
    deck.cards.iter().map(card).collect()
}

#[test]
fn formatting_keeps_the_cards_and_results_of_all_decks() {
    let mut decks = vec![BAR.to_owned(), BAR.replace('\n', "\r\n")];
    for folder in ["input", "tests/decks/bad", "tests/decks/good"] {
        for entry in fs::read_dir(project(folder)).expect("decks") {
            let path = entry.expect("a deck").path();
            if path.extension().is_some_and(|end| end == "inp") {
                decks.extend(fs::read_to_string(path));
            }
        }
    }
    assert!(decks.len() > 20, "{}", decks.len());
    let mut changed = 0;
    for text in decks {
        let mut client = session(&text);
        let edits = client.ask_file("formatting", DECK);
        let new = formatted(&text, &edits);
        assert_eq!(cards(&new), cards(&text));
        assert_eq!(new.lines().count(), text.lines().count());
        changed += usize::from(new != text);
        client.change(DECK, 2, json!([{ "text": new }]));
        assert_eq!(client.ask_file("formatting", DECK), json!([]), "formatting is final");
        assert!(client.finish().is_ok());
    }
    assert!(changed > 10, "{changed}");
    let model = |text: &str| {
        let prepared = job::prepare_text("bar.inp", text, &[], &Routines::none());
        format!("{:?}", job::run_in_memory(&prepared).1.0)
    };
    let mut client = session(BAR);
    let edits = client.ask_file("formatting", DECK);
    assert_eq!(model(&formatted(BAR, &edits)), model(BAR));
    assert!(client.finish().is_ok());
}
