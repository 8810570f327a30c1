//! The structure that `docs/architecture.md` describes: imports point downwards, import cycles within a folder are
//! small, and files, tests and equations that the documentation names exist.
//!
//! Imports are read from the paths in `src/`, in `use` lines and elsewhere; unit tests are left out.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use crate::common::project;

/// Folders of `src` by layer, top first, with their crate. A folder may import from lower layers and from folders to its
/// right. A crate without folders is listed as one folder with its own name. Cargo keeps the crates apart: `numerics`
/// does not depend on decks and models.
pub const LAYERS: &[(&str, &[&str])] = &[
    ("analysis", &["command"]),
    ("analysis", &["view"]),
    ("analysis", &["report", "study"]),
    ("analysis", &["explain"]),
    ("editor", &["server"]),
    ("editor", &["features"]),
    ("editor", &["outline", "protocol"]),
    ("editor", &["text"]),
    ("solver", &["job", "overview"]),
    ("solver", &["solve"]),
    ("solver", &["plan"]),
    ("language", &["generate", "model"]),
    ("language", &["deck"]),
    ("results", &["results"]),
    ("host", &["host"]),
    ("diagnostics", &["diagnostics"]),
    ("numerics", &["resistance"]),
    ("numerics", &["adaptive", "heat", "constraint", "load", "element", "material"]),
    ("numerics", &["mesh", "remesh", "routines", "variables"]),
    ("numerics", &["state", "names", "probability", "codes"]),
    ("numerics", &["kernel"]),
    ("numerics", &["platform"]),
];

/// Largest number of files in an import cycle.
const LARGEST_CYCLE: usize = 3;

/// Segments of a path from the root of the crate.
pub type ModulePath = Vec<String>;

/// A module's file, the paths it names, and the names it re-exports.
pub struct ModuleSource {
    file: String,
    named: Vec<ModulePath>,
    exported: BTreeMap<String, ModulePath>,
}

/// All modules. A path begins with the crate.
pub struct SourceTree(BTreeMap<ModulePath, ModuleSource>);

impl SourceTree {
    pub fn read() -> SourceTree {
        let mut files = Vec::new();
        let crates: BTreeSet<&str> = LAYERS.iter().map(|layer| layer.0).collect();
        crates.iter().for_each(|name| collect(&project("src").join(name), &mut vec![(*name).to_owned()], &mut files));
        let modules: BTreeSet<ModulePath> = files.iter().map(|f| f.0.clone()).collect();
        let read = |(module, file): (ModulePath, String)| {
            let text = strip_comments(&fs::read_to_string(project(&file)).expect("a source"));
            let mut source = ModuleSource { file, named: Vec::new(), exported: BTreeMap::new() };
            source.record_paths(&text, &module, &modules);
            (module, source)
        };
        SourceTree(files.into_iter().map(read).collect())
    }

    /// Returns the module that defines what a path names, and the name in it; `None` outside the project.
    fn definition(&self, path: &ModulePath) -> Option<(ModulePath, Option<String>)> {
        let mut path = path.clone();
        for _ in 0..8 {
            let depth = (1..=path.len()).rev().find(|&n| self.0.contains_key(&path[..n]))?;
            let (module, rest) = path.split_at(depth);
            match rest.first().and_then(|name| self.0[module].exported.get(name)) {
                Some(origin) if origin != &path => path = [origin, &rest[1..]].concat(),
                _ => return Some((module.to_vec(), rest.first().cloned())),
            }
        }
        None
    }

    /// Returns the imports from module to module with the imported name.
    pub fn imports(&self) -> Vec<(&ModulePath, ModulePath, Option<String>)> {
        let of = |(module, source): (&'_ ModulePath, &ModuleSource)| -> Vec<(ModulePath, Option<String>)> {
            source.named.iter().filter_map(|path| self.definition(path)).filter(|(to, _)| to != module).collect()
        };
        self.0.iter().flat_map(|(m, s)| of((m, s)).into_iter().map(move |(to, name)| (m, to, name))).collect()
    }
}

impl ModuleSource {
    /// Records every path that a text names.
    fn record_paths(&mut self, text: &str, module: &ModulePath, modules: &BTreeSet<ModulePath>) {
        // Other files of a crate name the imports of its root by `crate::`.
        let is_root = module.len() == 1;
        let mut rest = text;
        let mut code = String::new();
        while let Some((before, statement, after)) = next_use(rest) {
            code += before;
            let exports = is_root || before.trim_end().ends_with("pub") || before.trim_end().ends_with(')');
            for (path, name) in branches(statement) {
                let Some(path) = absolute(&path, module, modules) else { continue };
                if exports {
                    self.exported.insert(name, path);
                } else {
                    self.named.push(path);
                }
            }
            rest = after;
        }
        code += rest;
        let is_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
        let words = code.split(|c| !is_path(c)).map(|w| w.trim_matches(':'));
        for word in words.filter(|w| ["crate::", "super::", "revolve_"].iter().any(|head| w.starts_with(head))) {
            self.named.extend(absolute(word, module, modules));
        }
    }
}

/// Collects the files below a folder as modules.
fn collect(folder: &Path, above: &mut ModulePath, files: &mut Vec<(ModulePath, String)>) {
    for entry in fs::read_dir(folder).expect("a folder").map(|e| e.expect("a file").path()) {
        let name = entry.file_stem().expect("a name").to_string_lossy().into_owned();
        if above.len() == 1 && name == "build" {
            continue;
        }
        above.push(name.clone());
        if entry.is_dir() {
            collect(&entry, above, files);
        } else if entry.extension().is_some_and(|e| e == "rs") {
            let is_root = above.len() == 2 && name == "lib";
            let module = &above[..above.len() - usize::from(name == "mod" || is_root)];
            let file = entry.strip_prefix(project("")).expect("of the project").to_string_lossy().into_owned();
            files.push((module.to_vec(), file));
        }
        above.pop();
    }
}

/// Returns a text without comments and unit tests.
fn strip_comments(text: &str) -> String {
    let text = text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
    text.lines().map(|l| l.split("//").next().unwrap_or_default().to_owned() + "\n").collect()
}

/// Returns the text before the next `use`, its tree, and the text after it.
fn next_use(text: &str) -> Option<(&str, &str, &str)> {
    let at = text.match_indices("use ").map(|(i, _)| i);
    let start = at.into_iter().find(|&i| i == 0 || text[..i].ends_with([' ', '\n']))?;
    let end = start + text[start..].find(';')?;
    Some((&text[..start], &text[start + 4..end], &text[end + 1..]))
}

/// Returns each path of a `use` tree and the name it imports.
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

/// Splits a list at commas outside braces.
fn split_list(list: &str) -> Vec<&str> {
    let mut depth = 0;
    list.split(|c| {
        depth += i32::from(c == '{') - i32::from(c == '}');
        c == ',' && depth == 0
    })
    .collect()
}

/// Returns the crate of the project that a word names in a module.
fn named_crate<'n>(word: &'n str, module: &'n ModulePath) -> Option<&'n str> {
    if word == "crate" {
        return Some(&module[0]);
    }
    word.strip_prefix("revolve_").filter(|name| LAYERS.iter().any(|layer| layer.0 == *name))
}

/// Returns a path that begins with its crate; `None` for crates of others.
fn absolute(path: &str, module: &ModulePath, modules: &BTreeSet<ModulePath>) -> Option<ModulePath> {
    let mut words = path.split("::").filter(|w| !w.is_empty()).map(str::to_owned).peekable();
    let mut base = module.clone();
    let first = words.peek()?.clone();
    match first.as_str() {
        word if named_crate(word, module).is_some() => {
            base = named_crate(word, module).map(str::to_owned).into_iter().collect();
            words.next();
        }
        "super" | "self" => {}
        child if modules.contains(&[&module[..], &[child.to_owned()]].concat()) => {}
        _ => return None,
    }
    for word in words {
        match word.as_str() {
            "self" => {}
            "super" => {
                base.pop()?;
            }
            _ => base.push(word),
        }
    }
    Some(base)
}

/// Returns the folder of a module, or the crate if it has no folders; `None` for the root of a crate with folders.
pub fn folder(module: &ModulePath) -> Option<&str> {
    let name = module[0].as_str();
    let is_flat = LAYERS.iter().any(|(of, folders)| *of == name && folders.contains(&name));
    if is_flat { Some(name) } else { module.get(1).map(String::as_str) }
}

/// Returns the layer of a folder and its place there.
fn place(folder: &str) -> (usize, usize) {
    let in_layer =
        |(layer, (_, folders)): (usize, &(_, &[&str]))| Some((layer, folders.iter().position(|f| *f == folder)?));
    LAYERS.iter().enumerate().find_map(in_layer).unwrap_or_else(|| panic!("`{folder}` is in no layer"))
}

#[test]
fn imports_point_downwards() {
    let tree = SourceTree::read();
    let mut wrong = BTreeSet::new();
    for (from, to, name) in tree.imports() {
        let (Some(user), Some(used)) = (folder(from), folder(&to)) else { continue };
        if user != used && place(user) >= place(used) {
            wrong.insert(format!("{} imports {} {}", tree.0[from].file, tree.0[&to].file, name.unwrap_or_default()));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn import_cycles_are_small() {
    let tree = SourceTree::read();
    let mut next: BTreeMap<&ModulePath, BTreeSet<ModulePath>> = BTreeMap::new();
    for (from, to, _) in tree.imports().into_iter().filter(|(from, to, _)| folder(from) == folder(to)) {
        next.entry(from).or_default().insert(to);
    }
    let reached = |start: &ModulePath| {
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
    let all: BTreeMap<&ModulePath, BTreeSet<&ModulePath>> = tree.0.keys().map(|m| (m, reached(m))).collect();
    let cycle = |m: &ModulePath| -> BTreeSet<&str> {
        all[m].iter().filter(|to| all[*to].contains(m)).map(|to| tree.0[*to].file.as_str()).collect()
    };
    let large: BTreeSet<_> = tree.0.keys().map(cycle).filter(|files| files.len() > LARGEST_CYCLE).collect();
    assert!(large.is_empty(), "{large:#?}");
}

/// Largest number of files with `impl` blocks of one type.
const MOST_IMPL_FILES: usize = 3;

/// Returns the name of the type of an `impl` block, from its first line.
fn implementor(line: &str) -> Option<&str> {
    let head = line.strip_prefix("impl")?;
    let head = head.split_once(" for ").map_or(head, |(_, implementor)| implementor);
    let head = if head.starts_with('<') { head.split_once("> ")?.1 } else { head };
    head.trim_start_matches(['&', ' ']).split(['<', ' ', '{']).next()?.rsplit("::").next()
}

/// Returns the name of the type that a line declares.
fn declared(line: &str) -> Option<&str> {
    let (head, rest) = ["struct ", "enum ", "union "].iter().find_map(|word| line.split_once(word))?;
    let is_visibility = head.is_empty() || head == "pub " || head.starts_with("pub(") && head.ends_with(") ");
    is_visibility.then(|| rest.split(|c: char| !c.is_alphanumeric() && c != '_').next())?
}

/// The `impl` blocks of a type, those of traits included, are in few files of the crate that declares it: a type with more
/// does several things that change separately. Types of one name in several crates are different types. Types of other
/// crates, such as `Vec` and `f64`, are not counted: methods that a trait adds to them belong to the trait. Small types count
/// as large ones.
#[test]
fn types_have_impl_blocks_in_few_files() {
    let sources = texts("src", ".rs");
    let crate_of = |path: &str| path.split('/').nth(1).unwrap_or_default().to_owned();
    let of_lines = |(path, text): (&String, &String), name: fn(&str) -> Option<&str>| -> Vec<(String, String)> {
        text.lines().filter_map(name).map(|name| (crate_of(path), name.to_owned())).collect()
    };
    let types: BTreeSet<(String, String)> = sources.iter().flat_map(|source| of_lines(source, declared)).collect();
    let mut files: BTreeMap<(String, String), BTreeSet<&String>> = BTreeMap::new();
    for source in &sources {
        for key in of_lines(source, implementor).into_iter().filter(|key| types.contains(key)) {
            files.entry(key).or_default().insert(source.0);
        }
    }
    assert!(files.len() > 1000, "{} types", files.len());
    files.retain(|_, files| files.len() > MOST_IMPL_FILES);
    assert!(files.is_empty(), "{files:#?}");
}

/// Folders that may use the motion of rigid bodies in space. Others use what is common to all bodies, and the motion of
/// points.
const IN_SPACE: &[&str] = &["constraint", "load", "plan", "state"];

#[test]
fn four_folders_know_how_bodies_move_in_space() {
    let knows = |text: &str| text.contains("RigidBody3d") || text.contains("spatial") || text.contains("Wrench");
    let sources = texts("src", ".rs").into_iter().filter(|(_, text)| knows(text));
    let folders: BTreeSet<String> = sources.filter_map(|(path, _)| Some(path.split('/').nth(2)?.to_owned())).collect();
    assert_eq!(folders, IN_SPACE.iter().map(|name| (*name).to_owned()).collect());
}

/// Names that belong to a platform.
const OF_PLATFORMS: &[&str] = &[
    "std::os::",
    "libc::",
    "libloading",
    "signal_hook",
    "cfg(unix",
    "cfg(windows",
    "(unix",
    "(windows",
    "target_os",
    "\"/proc",
];
const PLATFORM: &[&str] = &["src/numerics/platform/", "src/host/native/"];

/// Other platforms compile because nothing else names an operating system; the release workflow compiles for them.
#[test]
fn two_folders_know_the_operating_system() {
    let mut wrong = BTreeSet::new();
    for (path, text) in texts("src", ".rs") {
        let text = strip_comments(&text);
        let named = OF_PLATFORMS.iter().filter(|name| text.contains(**name));
        if PLATFORM.iter().any(|folder| path.starts_with(folder)) {
            continue;
        }
        wrong.extend(named.map(|name| format!("{path} names {name}")));
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn crates_other_than_host_forbid_unsafe_code() {
    let mut wrong = BTreeSet::new();
    for (path, text) in texts("src", ".rs") {
        let is_root = path.ends_with("/lib.rs") || path == "src/main.rs";
        let is_of_host = path.starts_with("src/host/");
        if is_root && !is_of_host && !text.contains("\n#![forbid(unsafe_code)]\n") {
            wrong.insert(format!("{path} has no `#![forbid(unsafe_code)]`"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// The central traits, with the most methods that each may have.
const TRAITS: &[(&str, &str, usize)] = &[
    ("src/numerics/load/mod.rs", "pub trait Load:", 8),
    ("src/numerics/constraint/mod.rs", "pub trait Constraint:", 9),
    ("src/numerics/element/group.rs", "pub trait ElementGroup:", 20),
];

#[test]
fn central_traits_have_few_methods() {
    for &(file, name, most) in TRAITS {
        let text = fs::read_to_string(project(file)).expect("a source");
        let body = text.split(name).nth(1).unwrap_or_else(|| panic!("{file} has no `{name}`"));
        let body = body.split("\n}\n").next().unwrap_or_default();
        let methods = body.lines().filter(|line| line.starts_with("    fn ")).count();
        assert!((1..=most).contains(&methods), "`{name}` has {methods} methods, at most {most} are allowed");
    }
}

/// Returns the texts of all files below a folder with a file name ending, by path from the project.
pub fn texts(folder: &str, end: &str) -> BTreeMap<String, String> {
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

/// Returns the words between backticks.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.lines().filter(|l| !l.starts_with("```")).flat_map(|l| l.split('`').skip(1).step_by(2))
}

#[test]
fn files_and_tests_named_in_the_documentation_exist() {
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
            let is_created = text.contains(&format!("Create `{file}`:"));
            if !is_created && !is_file(file) || !name.is_empty() && !is_test(name) {
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

/// A function of the project: its file and its name.
type FunctionPlace = (String, String);

/// A comment of a source. The comment of a function has its name.
struct SourceComment {
    function: Option<String>,
    text: String,
}

impl SourceComment {
    /// Returns all comments of a source, each as one line.
    fn all(source: &str) -> Vec<SourceComment> {
        let (mut comments, mut text) = (Vec::new(), String::new());
        for line in source.lines().map(str::trim) {
            if let Some(words) = line.strip_prefix("//") {
                text += words.trim_start_matches(['/', '!']);
            } else if !line.starts_with("#[") {
                let function = line.split("fn ").nth(1).and_then(|rest| rest.split(['(', '<']).next());
                let text = std::mem::take(&mut text);
                comments.push(SourceComment { function: function.map(str::to_owned), text });
            }
        }
        comments
    }

    /// Returns the numbers in parentheses that follow `Equation` or `Equations`, separated by commas.
    fn equations(&self) -> impl Iterator<Item = String> {
        let lists = ["Equation (", "Equations ("].iter().flat_map(|head| self.text.split(head).skip(1));
        lists.flat_map(|list| {
            let list = list.split_once(").").map_or(list, |(list, _)| list);
            list.split("), (").map(str::to_owned)
        })
    }
}

/// Returns the functions that the line `Function: ...` after each numbered equation of a page names.
fn equations_of(page: &str) -> BTreeMap<String, BTreeSet<FunctionPlace>> {
    let mut equations: BTreeMap<String, BTreeSet<FunctionPlace>> = BTreeMap::new();
    for part in page.split("\\tag{").skip(1) {
        let (number, rest) = part.split_once('}').expect("the number of an equation");
        let line = rest.lines().skip(1).find(|line| !line.is_empty()).unwrap_or_default().trim_start();
        let functions = if line.starts_with("Function: ") || line.starts_with("Functions: ") { line } else { "" };
        let place = |link: &str| {
            let (name, file) = link.split_once("`](../../")?;
            let name = name.rsplit("::").next().unwrap_or(name);
            Some((file.split(')').next()?.to_owned(), name.to_owned()))
        };
        let functions = functions.split("[`").skip(1).filter_map(place).collect();
        assert!(equations.insert(number.to_owned(), functions).is_none(), "equation ({number}) occurs twice");
    }
    equations
}

/// Returns the numbers in parentheses to which a page refers: `(4.7)`, `(10.5a)`.
fn equations_referred_to(page: &str) -> impl Iterator<Item = &str> {
    let inside = page.split('(').skip(1).filter_map(|rest| rest.split_once(')').map(|(inside, _)| inside));
    inside.filter(|number| {
        let parts = number.split_once('.').map(|(chapter, rest)| (chapter, rest.trim_end_matches(['a', 'b'])));
        parts.is_some_and(|parts| [parts.0, parts.1].iter().all(|part| part.parse::<u8>().is_ok_and(|n| n > 0)))
    })
}

#[test]
fn equations_and_functions_name_each_other() {
    let mut equations = BTreeMap::new();
    for (page, text) in texts("docs/theory", ".md") {
        for (number, functions) in equations_of(&text) {
            let is_new = equations.insert(number.clone(), functions).is_none();
            assert!(is_new, "{page}: equation ({number}) occurs twice");
        }
    }
    assert!(equations.len() > 150, "{} equations", equations.len());
    let mut named: BTreeMap<String, BTreeSet<FunctionPlace>> = BTreeMap::new();
    let mut wrong = BTreeSet::new();
    for (page, text) in texts("docs/theory", ".md") {
        let unknown = equations_referred_to(&text).filter(|number| !equations.contains_key(*number));
        wrong.extend(unknown.map(|number| format!("{page}: ({number}) is unknown")));
    }
    for (path, text) in ["src", "tests"].iter().flat_map(|folder| texts(folder, ".rs")) {
        for comment in SourceComment::all(&text) {
            for number in comment.equations() {
                match &comment.function {
                    Some(name) => _ = named.entry(number).or_default().insert((path.clone(), name.clone())),
                    None if !equations.contains_key(&number) => {
                        _ = wrong.insert(format!("{path}: ({number}) is unknown"))
                    }
                    None => {}
                }
            }
        }
    }
    for number in equations.keys().chain(named.keys()) {
        let [by_page, by_sources] = [&equations, &named].map(|map| map.get(number).cloned().unwrap_or_default());
        if by_page.is_empty() {
            wrong.insert(format!("equation ({number}) has no line `Function: ...` in docs/theory"));
        }
        let absent = by_page.difference(&by_sources);
        wrong.extend(
            absent.map(|(file, name)| format!("{file}: the comment of `{name}` has no `Equation ({number}).`")),
        );
        let unnamed = by_sources.difference(&by_page);
        wrong.extend(unnamed.map(|(file, name)| format!("equation ({number}) does not name `{name}` of {file}")));
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}
