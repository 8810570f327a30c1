//! The pages `docs/add-*.md` ("How do I add ...") followed to the letter: their edits are applied to a copy of the
//! sources, which must then compile. A page that leaves out a file, or names a line that no longer exists, fails here.
//!
//! An edit is a line of the page and the code block after it: "Create `FILE`:", "In `FILE`, after `LINE`:", "In `FILE`,
//! before `LINE`:" or "In `FILE`, in place of `LINE`:", where `LINE` occurs in exactly one line of the file.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

use crate::common::project;

#[derive(Debug)]
enum EditPlace {
    NewFile,
    After(String),
    Before(String),
    InPlaceOf(String),
}

#[derive(Debug)]
struct PageEdit {
    file: String,
    place: EditPlace,
    code: String,
}

/// Returns the texts between backticks.
fn quoted(line: &str) -> Vec<&str> {
    line.split('`').skip(1).step_by(2).collect()
}

/// Returns the edit that a line announces; `None` for other lines.
fn announced(line: &str, code: String) -> Option<PageEdit> {
    let words = quoted(line);
    let (file, place) = match words[..] {
        [file] if line.starts_with("Create ") => (file, EditPlace::NewFile),
        [file, anchor] if line.contains("`, after `") => (file, EditPlace::After(anchor.to_owned())),
        [file, anchor] if line.contains("`, before `") => (file, EditPlace::Before(anchor.to_owned())),
        [file, anchor] if line.contains("`, in place of `") => (file, EditPlace::InPlaceOf(anchor.to_owned())),
        _ => return None,
    };
    Some(PageEdit { file: file.to_owned(), place, code })
}

/// Returns the edits of a page in their order.
fn edits(page: &str) -> Vec<PageEdit> {
    let mut found = Vec::new();
    let mut lines = page.lines();
    let mut last = "";
    while let Some(line) = lines.next() {
        if line.starts_with("```rust") {
            let code: String = lines.by_ref().take_while(|l| *l != "```").map(|l| l.to_owned() + "\n").collect();
            let edit =
                announced(last, code).unwrap_or_else(|| panic!("the code block after `{last}` belongs to no edit"));
            found.push(edit);
        } else if !line.trim().is_empty() {
            last = line;
        }
    }
    found
}

fn apply(edit: &PageEdit, root: &Path) {
    let path = root.join(&edit.file);
    let anchor = match &edit.place {
        EditPlace::NewFile => {
            assert!(!path.exists(), "{} exists already", edit.file);
            return fs::write(path, &edit.code).expect("a new file");
        }
        EditPlace::After(anchor) | EditPlace::Before(anchor) | EditPlace::InPlaceOf(anchor) => anchor.as_str(),
    };
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", edit.file));
    let count = text.lines().filter(|line| line.contains(anchor)).count();
    assert_eq!(count, 1, "{}: lines with `{anchor}`", edit.file);
    let mut edited = String::new();
    for line in text.lines().map(|line| line.to_owned() + "\n") {
        match &edit.place {
            _ if !line.contains(anchor) => edited += &line,
            EditPlace::After(_) => edited.extend([line.as_str(), edit.code.as_str()]),
            EditPlace::Before(_) => edited.extend([edit.code.as_str(), line.as_str()]),
            _ => edited += &edit.code,
        }
    }
    fs::write(path, edited).expect("an edited file");
}

/// Copies a file with its time, so that Cargo takes it for the file whose library it has built: another time would build the
/// macros again, and with them the wheel.
fn copy_file(from: &Path, to: &Path) {
    fs::copy(from, to).expect("a copy");
    let modified = fs::metadata(from).and_then(|file| file.modified()).expect("a time");
    fs::File::options().write(true).open(to).and_then(|file| file.set_modified(modified)).expect("the same time");
}

/// Copies a folder with all its contents.
pub fn copy_folder(from: &Path, to: &Path) {
    fs::create_dir_all(to).expect("a folder");
    for entry in fs::read_dir(from).expect("a folder").map(|e| e.expect("an entry")) {
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy_folder(&entry.path(), &target);
        } else {
            copy_file(&entry.path(), &target);
        }
    }
}

/// Returns the table of files of a page: first cells that name a source file.
fn listed_files(page: &str) -> BTreeSet<String> {
    let rows = page.lines().filter_map(|l| l.strip_prefix("| `")?.split_once('`'));
    rows.map(|(file, _)| file.to_owned()).filter(|file| file.starts_with("src/")).collect()
}

#[test]
fn extension_pages_can_be_followed() {
    let folder = tempfile::tempdir().expect("a folder");
    let root = folder.path();
    for name in ["Cargo.toml", "Cargo.lock", "build.rs", "README.md"] {
        copy_file(&project(name), &root.join(name));
    }
    for name in ["src", "input", "tests/benches"] {
        copy_folder(&project(name), &root.join(name));
    }
    let mut pages: Vec<_> = fs::read_dir(project("docs")).expect("pages").map(|e| e.expect("a page").path()).collect();
    pages.retain(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("add-")));
    pages.sort();
    assert!(pages.len() >= 4, "{pages:?}");
    for path in pages {
        let page = fs::read_to_string(&path).expect("a page");
        let edits = edits(&page);
        let edited: BTreeSet<String> = edits.iter().map(|e| e.file.clone()).collect();
        assert_eq!(listed_files(&page), edited, "the files that {} lists and edits", path.display());
        assert!(!edits.is_empty(), "{} has no edit", path.display());
        edits.iter().for_each(|edit| apply(edit, root));
    }
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    // The pages edit no part of the features; without them the check of the lints (all.sh) has checked all other libraries.
    let output = Command::new(cargo)
        .args(["check", "--lib", "--release", "--no-default-features", "--locked", "--offline", "--quiet"])
        .env("CARGO_TARGET_DIR", project("target"))
        .current_dir(root)
        .output()
        .expect("cargo runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
