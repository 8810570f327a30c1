//! The house as `docs/architecture.md` draws it: arrows between rooms run downwards, files of a room form no large circle,
//! and what the documentation names is there.
//!
//! Source: the paths in `src/`, in `use` lines and elsewhere; tests within the sources are left out.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use crate::common::project;

/// Rooms from top to bottom. A room may use those of lower floors and those further right on its own.
const FLOORS: &[&[&str]] = &[
    &["command"],
    &["report", "study"],
    &["job", "explain", "overview", "generate"],
    &["solve"],
    &["plan"],
    &["heat", "constraint", "load", "element", "material"],
    &["user", "mesh"],
    &["model", "output"],
    &["variables", "state"],
    &["resistance"],
    &["deck"],
    &["kernel"],
];

/// Below `plan` numbers and words know nothing of each other,
const WORDS: &[&str] = &["model", "deck"];
/// but for what both may use: arithmetic, the table of output variables, the expansion of cavities,
const SHARED: &[&str] = &["kernel", "variables", "resistance"];
/// and how faults are told.
const TELLING: &[&str] =
    &["Code", "Diagnostic", "Diagnostics", "Severity", "Sources", "Span", "nearest", "files", "printable"];

/// Files that may use each other in a circle.
const CIRCLE: usize = 3;

/// Rooms that still use one above them, and rooms that still hold a larger circle. What is mended leaves the list.
const UPWARD: &[(&str, &str)] = &[];
const TANGLED: &[&str] = &[];

/// Segments of a path from the root of the crate.
type Module = Vec<String>;

/// A module's file, what it names, and what it lends a name to.
struct Source {
    file: String,
    named: Vec<Module>,
    lent: BTreeMap<String, Module>,
}

/// All modules but the roots.
struct House(BTreeMap<Module, Source>);

impl House {
    fn read() -> House {
        let mut files = Vec::new();
        collect(&project("src"), &mut Vec::new(), &mut files);
        let modules: BTreeSet<Module> = files.iter().map(|f| f.0.clone()).collect();
        let read = |(module, file): (Module, String)| {
            let text = plain(&fs::read_to_string(project(&file)).expect("a source"));
            let mut source = Source { file, named: Vec::new(), lent: BTreeMap::new() };
            source.take(&text, &module, &modules);
            (module, source)
        };
        House(files.into_iter().map(read).collect())
    }

    /// The module that holds what a path names, and the name in it; `None` outside the crate.
    fn holder(&self, path: &Module) -> Option<(Module, Option<String>)> {
        let mut path = path.clone();
        for _ in 0..8 {
            let depth = (1..=path.len()).rev().find(|&n| self.0.contains_key(&path[..n]))?;
            let (module, rest) = path.split_at(depth);
            match rest.first().and_then(|name| self.0[module].lent.get(name)) {
                Some(lender) if lender != &path => path = [lender, &rest[1..]].concat(),
                _ => return Some((module.to_vec(), rest.first().cloned())),
            }
        }
        None
    }

    /// Arrows from file to file with the name that is used.
    fn arrows(&self) -> Vec<(&Module, Module, Option<String>)> {
        let of = |(module, source): (&'_ Module, &Source)| -> Vec<(Module, Option<String>)> {
            source.named.iter().filter_map(|path| self.holder(path)).filter(|(to, _)| to != module).collect()
        };
        self.0.iter().flat_map(|(m, s)| of((m, s)).into_iter().map(move |(to, name)| (m, to, name))).collect()
    }
}

impl Source {
    /// Notes every path that a text names.
    fn take(&mut self, text: &str, module: &Module, modules: &BTreeSet<Module>) {
        let mut rest = text;
        let mut code = String::new();
        while let Some((before, statement, after)) = next_use(rest) {
            code += before;
            let lends = before.trim_end().ends_with("pub") || before.trim_end().ends_with(')');
            for (path, name) in branches(statement) {
                let Some(path) = absolute(&path, module, modules) else { continue };
                if lends {
                    self.lent.insert(name, path);
                } else {
                    self.named.push(path);
                }
            }
            rest = after;
        }
        code += rest;
        let is_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
        let words = code.split(|c| !is_path(c)).map(|w| w.trim_matches(':'));
        for word in words.filter(|w| ["crate::", "super::", "revolve::"].iter().any(|head| w.starts_with(head))) {
            self.named.extend(absolute(word, module, modules));
        }
    }
}

/// Files below a folder as modules.
fn collect(folder: &Path, above: &mut Module, files: &mut Vec<(Module, String)>) {
    for entry in fs::read_dir(folder).expect("a folder").map(|e| e.expect("a file").path()) {
        let name = entry.file_stem().expect("a name").to_string_lossy().into_owned();
        above.push(name.clone());
        if entry.is_dir() {
            // What has a manifest of its own is another crate: it sees public modules alone.
            if !entry.join("Cargo.toml").exists() {
                collect(&entry, above, files);
            }
        } else if entry.extension().is_some_and(|e| e == "rs") {
            let module = &above[..above.len() - usize::from(name == "mod")];
            let file = entry.strip_prefix(project("")).expect("of the project").to_string_lossy().into_owned();
            if !["lib", "main"].contains(&module[0].as_str()) {
                files.push((module.to_vec(), file));
            }
        }
        above.pop();
    }
}

/// A text without comments, and without the tests at its end.
fn plain(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    text.lines().map(|l| l.split("//").next().unwrap_or_default().to_owned() + "\n").collect()
}

/// What stands before the next `use`, its tree, and what follows.
fn next_use(text: &str) -> Option<(&str, &str, &str)> {
    let at = text.match_indices("use ").map(|(i, _)| i);
    let start = at.into_iter().find(|&i| i == 0 || text[..i].ends_with([' ', '\n']))?;
    let end = start + text[start..].find(';')?;
    Some((&text[..start], &text[start + 4..end], &text[end + 1..]))
}

/// Each path of a tree of `use`, and the name that it brings.
fn branches(tree: &str) -> Vec<(String, String)> {
    let tree = tree.trim();
    if let Some((head, list)) = tree.split_once('{') {
        let list = list.trim_end().strip_suffix('}').unwrap_or(list);
        let each = split_list(list).into_iter().flat_map(branches);
        return each.map(|(path, name)| (head.trim().to_owned() + path.trim_end_matches("::self"), name)).collect();
    }
    let (path, name) = tree.split_once(" as ").unwrap_or((tree, tree.rsplit("::").next().unwrap_or(tree)));
    let path = if path == "self" { "" } else { path };
    if tree.is_empty() { Vec::new() } else { vec![(path.trim().to_owned(), name.trim().to_owned())] }
}

/// Parts between commas that are in no braces.
fn split_list(list: &str) -> Vec<&str> {
    let (mut depth, mut start, mut parts) = (0, 0, Vec::new());
    for (i, c) in list.char_indices() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(&list[start..i]);
                start = i + 1;
            }
            _ => {}
        }
    }
    parts.push(&list[start..]);
    parts
}

/// A path from the root of the crate, if it leads there.
fn absolute(path: &str, module: &Module, modules: &BTreeSet<Module>) -> Option<Module> {
    let mut words = path.split("::").filter(|w| !w.is_empty()).map(str::to_owned).peekable();
    let mut base = module.clone();
    match words.peek()?.as_str() {
        "crate" | "revolve" => base.clear(),
        "super" | "self" => {}
        child if modules.contains(&[&module[..], &[child.to_owned()]].concat()) => {}
        _ => return None,
    }
    for word in words {
        match word.as_str() {
            "crate" | "revolve" | "self" => {}
            "super" => {
                base.pop()?;
            }
            _ => base.push(word),
        }
    }
    Some(base)
}

/// Floor and place of a room.
fn place(room: &str) -> (usize, usize) {
    let at = FLOORS.iter().enumerate().find_map(|(f, rooms)| Some((f, rooms.iter().position(|r| *r == room)?)));
    at.unwrap_or_else(|| panic!("the room `{room}` is on no floor"))
}

/// Whether an arrow from room to room is as drawn.
fn allowed(from: &str, to: &str, name: Option<&str>) -> bool {
    let below_plan = place(from) > place("plan");
    let crosses = WORDS.contains(&from) != WORDS.contains(&to) && !SHARED.contains(&to);
    let telling = to == "deck" && name.is_some_and(|n| TELLING.contains(&n));
    place(from) < place(to) && (!below_plan || !crosses || telling)
}

#[test]
fn no_arrow_runs_upward() {
    let house = House::read();
    let (mut rooms, mut wrong) = (BTreeSet::new(), BTreeSet::new());
    for (from, to, name) in house.arrows() {
        let pair = (from[0].as_str(), to[0].as_str());
        // A whole file is known by its name.
        let name = name.or_else(|| to.last().cloned());
        if pair.0 != pair.1 && !allowed(pair.0, pair.1, name.as_deref()) {
            rooms.insert((from[0].clone(), to[0].clone()));
            wrong.insert(format!("{} uses {} {}", house.0[from].file, house.0[&to].file, name.unwrap_or_default()));
        }
    }
    let known: BTreeSet<_> = UPWARD.iter().map(|(a, b)| ((*a).to_owned(), (*b).to_owned())).collect();
    assert_eq!(rooms, known, "{wrong:#?}");
}

#[test]
fn no_room_holds_a_large_circle() {
    let house = House::read();
    let mut next: BTreeMap<&Module, BTreeSet<Module>> = BTreeMap::new();
    for (from, to, _) in house.arrows().into_iter().filter(|(from, to, _)| from[0] == to[0]) {
        next.entry(from).or_default().insert(to);
    }
    let reached = |start: &Module| {
        let (mut seen, mut open) = (BTreeSet::new(), vec![start]);
        while let Some(module) = open.pop() {
            for to in next.get(module).into_iter().flatten() {
                if seen.insert(to) {
                    open.push(to);
                }
            }
        }
        seen
    };
    let all: BTreeMap<&Module, BTreeSet<&Module>> = house.0.keys().map(|m| (m, reached(m))).collect();
    let circle = |m: &Module| -> BTreeSet<&str> {
        all[m].iter().filter(|to| all[*to].contains(m)).map(|to| house.0[*to].file.as_str()).collect()
    };
    let large: BTreeMap<&Module, _> = house.0.keys().map(|m| (m, circle(m))).filter(|c| c.1.len() > CIRCLE).collect();
    let rooms: BTreeSet<&str> = large.keys().map(|m| m[0].as_str()).collect();
    let known: BTreeSet<&str> = TANGLED.iter().copied().collect();
    let circles: BTreeSet<_> = large.values().collect();
    assert_eq!(rooms, known, "{circles:#?}");
}

/// Texts of all files below a folder whose names end so, by path from the project.
fn texts(folder: &str, end: &str) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(project(folder)).expect("a folder").map(|e| e.expect("a file")) {
        let path = format!("{folder}/{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            found.extend(texts(&path, end));
        } else if path.ends_with(end) {
            found.insert(path.clone(), fs::read_to_string(project(&path)).expect("a text"));
        }
    }
    found
}

/// What stands between backticks.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter(|l| !l.starts_with("```")).flat_map(|l| l.split('`').skip(1).step_by(2))
}

#[test]
fn files_and_tests_that_the_documentation_names_are_there() {
    let sources: BTreeMap<String, String> =
        ["src", "tests", "examples"].iter().flat_map(|folder| texts(folder, ".rs")).collect();
    let is_file = |name: &str| {
        project(name).exists() || sources.keys().any(|path| format!("/{path}").ends_with(&format!("/{name}")))
    };
    let is_test = |name: &str| {
        let function = name.strip_suffix('…').map_or(format!("fn {name}("), |start| format!("fn {start}"));
        sources.values().any(|text| text.contains(&function))
    };
    let mut absent = BTreeSet::new();
    for (page, text) in texts("docs", ".md") {
        for words in quoted(&text) {
            let (file, name) = words.split_once(": ").unwrap_or((words, ""));
            if !file.ends_with(".rs") || file.contains(['*', '<', ' ']) {
                continue;
            }
            if !is_file(file) || !name.is_empty() && !is_test(name) {
                absent.insert(format!("{page}: {words}"));
            }
        }
    }
    let rows = fs::read_to_string(project("docs/verification.md")).expect("a page");
    let cells = rows.lines().filter_map(|l| l.strip_suffix('|')?.rsplit('|').next());
    for name in cells.flat_map(quoted).filter(|n| n.contains('_') && !n.contains(['.', ' ', '/'])) {
        if !is_test(name) {
            absent.insert(format!("docs/verification.md: {name}"));
        }
    }
    assert!(absent.is_empty(), "{absent:#?}");
}
