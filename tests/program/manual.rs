//! The manual: every page is in the table of contents, links and anchors resolve, questions of a new user are answered
//! within two clicks and in a short section, pictures are small and made by the commands next to them, and the book
//! builds.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;
use std::process::Command;

use crate::browser::{HeadlessBrowser, PageView};
use crate::common::project;

/// Largest picture, bytes.
const PICTURE: u64 = 150_000;

fn page(path: &str) -> String {
    fs::read_to_string(project(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// Returns all pages by path from the project, the front page first.
fn pages() -> Vec<String> {
    let mut found = vec!["README.md".to_owned()];
    let mut folders = vec!["docs".to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(project(&folder)).expect("a folder").map(|e| e.expect("an entry")) {
            let path = format!("{folder}/{}", entry.file_name().to_string_lossy());
            if entry.path().is_dir() {
                folders.push(path);
            } else if path.ends_with(".md") {
                found.push(path);
            }
        }
    }
    found
}

/// Returns the lines that are not code.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut fenced = false;
    text.lines().filter(move |line| {
        let fence = line.starts_with("```");
        fenced ^= fence;
        !fence && !fenced && !line.starts_with("    ")
    })
}

/// Returns the targets of links and pictures of a page: path from the project and anchor, without external addresses.
fn links(path: &str) -> Vec<(String, String)> {
    let text = page(path);
    let folder = Path::new(path).parent().expect("a folder");
    let targets = prose(&text).flat_map(|line| {
        let plain: String = line.split('`').step_by(2).collect();
        let ends = |mark: &str, end: char| -> Vec<String> {
            plain.split(mark).skip(1).filter_map(|rest| Some(rest.split_once(end)?.0.to_owned())).collect()
        };
        [ends("](", ')'), ends("src=\"", '"')].concat()
    });
    let resolved = targets.filter(|t| !t.contains("://") && !t.starts_with("mailto:")).map(|target| {
        let (file, anchor) = target.split_once('#').unwrap_or((&target, ""));
        let file = if file.is_empty() { path.to_owned() } else { plain(&folder.join(file)) };
        (file, anchor.to_owned())
    });
    resolved.collect()
}

/// Returns a path without `..`.
fn plain(path: &Path) -> String {
    let mut parts: Vec<String> = Vec::new();
    for part in path.components().map(|p| p.as_os_str().to_string_lossy().into_owned()) {
        if part == ".." {
            parts.pop();
        } else {
            parts.push(part);
        }
    }
    parts.join("/")
}

/// Returns the headings of a page by their anchors, as GitHub and mdBook make them.
fn headings(path: &str) -> BTreeMap<String, String> {
    let text = page(path);
    let titles = prose(&text).filter(|l| l.starts_with('#')).map(|l| l.trim_start_matches('#').trim().to_owned());
    let anchor = |title: &str| {
        let kept =
            title.to_lowercase().chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect::<String>();
        kept.replace(' ', "-")
    };
    titles.map(|title| (anchor(&title), title)).collect()
}

/// Every page is in the table of contents, and every entry exists.
#[test]
fn the_book_holds_every_page() {
    let listed: BTreeSet<String> = links("docs/SUMMARY.md").into_iter().map(|l| l.0).collect();
    let pages: BTreeSet<String> =
        pages().into_iter().filter(|p| p.starts_with("docs/") && !p.ends_with("SUMMARY.md")).collect();
    assert!(pages.len() >= 18, "{pages:?}");
    assert_eq!(listed, pages);
}

#[test]
fn links_and_anchors_resolve() {
    let mut wrong = Vec::new();
    let mut count = 0;
    for path in pages() {
        for (file, anchor) in links(&path) {
            count += 1;
            let there = project(&file).exists();
            let anchored = anchor.is_empty() || there && headings(&file).contains_key(&anchor);
            if !there || !anchored {
                wrong.push(format!("{path}: {file}#{anchor}"));
            }
        }
    }
    assert!(wrong.is_empty() && count > 60, "{count} {wrong:#?}");
}

/// Questions of a new user: the page, the start of the heading that answers it, and a word of the answer.
const QUESTIONS: &[(&str, &str, &str, &str)] = &[
    ("How do I install it?", "docs/installing.md", "Ways to install", "cargo install"),
    ("How do I run a first model?", "docs/tutorials/first-shot.md", "Write and check the deck", "revolve new"),
    ("How do I correct a deck in an editor?", "docs/tutorials/editor.md", "Apply the quick fix", "Ctrl+."),
    ("Does my ABAQUS file run?", "docs/tutorials/abaqus-cae.md", "Which models can run", "CAX4R"),
    ("Can I use my VDLOAD or VUMAT?", "docs/user-subroutines.md", "From an ABAQUS/Explicit job", "--user"),
    ("Which units are used?", "docs/running.md", "Units", "*UNITS"),
    ("What does a message mean?", "docs/running.md", "Help in the program", "revolve explain"),
    ("Which mesh files are read?", "docs/running.md", "Meshes", ".msh"),
    ("How do I mesh a projectile?", "docs/running.md", "Projectiles", "revolve mesh"),
    ("How do I enter my own material?", "docs/tutorials/own-material.md", "Enter the curve", "*Plastic"),
    ("How do I define a target?", "docs/tutorials/own-material.md", "Derive the resistance", "revolve resistance"),
    ("How do I delete elements?", "docs/tutorials/contact-erosion.md", "Write and run the deck", "*SHEAR FAILURE"),
    ("How do I write my own load?", "docs/tutorials/user-subroutine.md", "Write your own VDLOAD", "subroutine vdload"),
    ("How many threads are used?", "docs/running.md", "Threads", "--threads"),
    ("Which files are written?", "docs/running.md", "Results", ".pvd"),
    ("How do I request output?", "docs/running.md", "Output requests", "*Node Output"),
    ("What force acts on a wall?", "docs/running.md", "Forces on walls and bodies", "SOF"),
    ("How do I show the body in 3-D?", "docs/paraview.md", "The body of revolution", "Rotational Extrusion"),
    ("How do I continue an interrupted run?", "docs/restart.md", "Checkpoints", "--resume"),
    ("What does the exit status mean?", "docs/restart.md", "Exit status", "SIGTERM"),
    ("How do I call it from Python?", "docs/python.md", "Run a deck", "rv.Deck"),
    ("How accurate is my result?", "docs/tutorial.md", "Estimate the error", "revolve study"),
    ("How do I find a ballistic limit?", "docs/tutorials/ballistic-limit.md", "Limit velocity", "revolve limit"),
    ("How do I fit a parameter?", "docs/tutorials/taylor-bar.md", "Fit a constant", "revolve identify"),
    ("How do I run a sweep on a cluster?", "docs/tutorials/cluster-sweep.md", "Run the parts", "sbatch"),
    ("How do I cite it?", "docs/running.md", "Citing", "CITATION.cff"),
    ("How do I apply a pressure that follows a curve?", "docs/keywords.md", "*DSLOAD", "Amplitude of the values"),
    ("How do I apply a blast?", "docs/keywords.md", "*INCIDENT WAVE INTERACTION", "CONWEP"),
    ("How do I give an initial velocity?", "docs/keywords.md", "*INITIAL CONDITIONS", "VELOCITY"),
    ("How do I define contact?", "docs/keywords.md", "*CONTACT PAIR", "first surface, second surface"),
    ("How do I define friction?", "docs/keywords.md", "*FRICTION", "coefficient"),
    ("How do I bond two bodies?", "docs/keywords.md", "*TIE", "surface"),
    ("How do I define a rigid tool?", "docs/keywords.md", "*RIGID BODY", "ANALYTICAL SURFACE"),
    ("How do I scale masses?", "docs/keywords.md", "*FIXED MASS SCALING", "Target stable time increment"),
    ("How do I fix the time increment?", "docs/keywords.md", "*DYNAMIC", "DIRECT USER CONTROL"),
    ("How do I choose hourglass control?", "docs/keywords.md", "*SECTION CONTROLS", "HOURGLASS"),
    ("How do I model spall?", "docs/keywords.md", "*TENSILE FAILURE", "spall"),
    ("How do I end a run at a condition?", "docs/user-subroutines.md", "Utility routines", "xplb_exit"),
    ("How do I include heating?", "docs/tutorials/own-material.md", "Add rate, temperature", "ADIABATIC"),
    ("How do I aim a projectile at an angle?", "docs/oblique.md", "Cards", "*ATTITUDE"),
    ("How long will it take?", "docs/tutorials/first-shot.md", "Write and check the deck", "expected run time"),
    ("May I trust the result?", "docs/verdict.md", "When a run is", "--uncertainty"),
    ("How do I run a table of cases?", "docs/running.md", "Sweeps of measured shots", "--samples"),
    ("How do I compare with a measured curve?", "docs/tutorials/abaqus-cae.md", "Compare with ABAQUS", "--compare"),
    ("Can ABAQUS/Viewer open the results?", "docs/paraview.md", "Programs that open the results", ".odb"),
    ("How do I refine the mesh of any deck?", "docs/tutorials/contact-erosion.md", "How much does", "--mesh-refine"),
];

/// Most words of a section that answers a question. A card has a line for each of its parameters, in which one searches.
const SECTION_WORDS: usize = 250;

#[test]
fn questions_of_a_new_user_are_answered_within_two_clicks() {
    assert!(QUESTIONS.len() >= 20);
    let first: BTreeSet<(String, String)> = links("README.md").into_iter().collect();
    let pages = first.iter().filter(|l| l.0.ends_with(".md"));
    let reached: BTreeSet<(String, String)> = pages.flat_map(|l| links(&l.0)).chain(first.clone()).collect();
    for &(question, file, heading, word) in QUESTIONS {
        let heads = headings(file);
        let (anchor, title) =
            heads.iter().find(|h| h.1.starts_with(heading)).unwrap_or_else(|| panic!("{question} {file}: {heading}"));
        assert!(reached.contains(&(file.to_owned(), anchor.clone())), "{question} {file}#{anchor} is not reached");
        let text = page(file);
        let (_, rest) = text.split_once(&format!("# {title}\n")).expect("a section");
        let is_card = heading.starts_with('*');
        let section = rest.split(if is_card { "\n### " } else { "\n## " }).next().expect("its end");
        assert!(section.contains(word), "{question} {file}, {heading}: `{word}` is missing");
        let words = section.split_whitespace().count();
        assert!(is_card || words < SECTION_WORDS, "{question} {file}, {heading}: {words} words");
    }
}

/// The first command is on the first screen of the front page, and a picture precedes it.
#[test]
fn front_page_reaches_the_first_run_on_its_first_screen() {
    let text = page("README.md");
    let (before, _) = text.split_once("\n    cargo run").expect("a command");
    assert!(before.len() < 2000 && before.lines().count() < 25, "{} characters", before.len());
    assert!(before.contains("docs/gallery/"), "a picture of a result");
}

#[test]
fn pictures_of_the_gallery_are_small_and_made_by_the_commands_next_to_them() {
    let text = page("docs/gallery.md");
    let commands: Vec<&str> = text.lines().filter_map(|l| l.strip_prefix("    ")).collect();
    let shown: BTreeSet<String> = links("docs/gallery.md").into_iter().map(|l| l.0).collect();
    let mut there = BTreeSet::new();
    for entry in fs::read_dir(project("docs/gallery")).expect("pictures").map(|e| e.expect("an entry")) {
        let name = format!("docs/gallery/{}", entry.file_name().to_string_lossy());
        if name.ends_with(".png") {
            let size = entry.metadata().expect("a file").len();
            assert!((5_000..PICTURE).contains(&size), "{name}: {size} bytes");
            assert!(commands.iter().any(|c| c.ends_with(&name)), "{name} is not made by any command");
            there.insert(name);
        }
    }
    assert_eq!(shown, there);
    for deck in commands.iter().flat_map(|c| c.split(' ')).filter(|w| w.ends_with(".inp")) {
        assert!(project(deck).is_file(), "{deck}");
    }
}

/// Pictures whose content depends on the machine: they show run times.
const OF_THE_MACHINE: &[&str] = &["gallery/price.png"];

/// Pages whose pictures are drawn within seconds. The tutorials' are compared when their commands are run.
const DRAWN: &[&str] = &["gallery.md", "adaptive-meshes.md"];

/// Compares a drawn picture with the stored one of a path in `docs`. Returns a message if they differ visibly in a share of
/// their pixels.
pub fn compare_picture(drawn: &Path, stored: &str) -> Option<String> {
    let [drawn, old] = [drawn, &project("docs").join(stored)]
        .map(|path| tiny_skia::Pixmap::load_png(path).unwrap_or_else(|e| panic!("{}: {e}", path.display())));
    let size = |picture: &tiny_skia::Pixmap| [picture.width(), picture.height()];
    let differs = |(a, b): &(&[u8], &[u8])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 32);
    let pixels = || drawn.data().chunks(4).zip(old.data().chunks(4));
    let differing = pixels().filter(differs).count() as f64 / pixels().count() as f64;
    println!("{stored}: {differing:.5}");
    let is_old = size(&drawn) != size(&old) || differing > 1e-3 && !OF_THE_MACHINE.contains(&stored);
    is_old.then(|| {
        format!("{stored}: {differing:.4} of the pixels differ: run docs/pictures.sh, and look at the picture")
    })
}

/// Pictures of pages that take seconds are drawn again and compared with the stored ones.
#[test]
fn pictures_are_those_of_this_version() {
    let folder = tempfile::tempdir().expect("a folder");
    let script = Command::new("bash")
        .arg(project("docs/pictures.sh"))
        .arg(folder.path())
        .args(DRAWN)
        .env("REVOLVE", env!("CARGO_BIN_EXE_revolve"))
        .output()
        .expect("bash");
    assert!(script.status.success(), "{}", String::from_utf8_lossy(&script.stderr));
    let shown = |page: &&str| links(&format!("docs/{page}")).into_iter().filter(|link| link.0.ends_with(".png"));
    let old: Vec<String> = DRAWN
        .iter()
        .flat_map(shown)
        .filter_map(|(path, _)| {
            let stored = path.strip_prefix("docs/").expect("a picture of docs").to_owned();
            compare_picture(&folder.path().join(&stored), &stored)
        })
        .collect();
    assert!(old.is_empty(), "{old:#?}");
}

#[test]
fn every_example_is_listed() {
    let text = page("docs/examples.md");
    for (folder, endings) in [("input", &["inp", "f", "f90"][..]), ("examples", &["rs", "py"])] {
        for entry in fs::read_dir(project(folder)).expect("a folder").map(|e| e.expect("an entry")) {
            let name = entry.file_name().to_string_lossy().into_owned();
            let named = endings.iter().any(|e| name.ends_with(&format!(".{e}")));
            assert!(!named || text.contains(&name), "{folder}/{name} is not in docs/examples.md");
        }
    }
}

/// Numbers of the validation page are those that the program computes, for the families that run within seconds;
/// `docs/validation/make.sh --check` checks all.
#[test]
fn validation_page_has_the_computed_numbers() {
    let python = std::env::var("REVOLVE_PYTHON").unwrap_or_else(|_| "python3".into());
    if !Command::new(&python).arg("--version").output().is_ok_and(|o| o.status.success()) {
        assert!(std::env::var_os("CI").is_none(), "in CI Python must be installed");
        println!("left out: the validation page (no Python)");
        return;
    }
    let mut script = Command::new(python);
    script.arg(project("docs/validation/make.py")).args(["--check", "--only=rods,plates"]);
    let output = script.env("REVOLVE", env!("CARGO_BIN_EXE_revolve")).output().expect("Python runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    println!("{text}");
    assert!(output.status.success(), "{text}");
}

/// The book of mdBook has every page, a search that finds words, and readable light and dark themes.
#[test]
fn the_book_builds_and_can_be_searched_and_read() {
    let program = std::env::var("REVOLVE_MDBOOK").unwrap_or_else(|_| "mdbook".into());
    let found = Command::new(&program).arg("--version").output().is_ok_and(|o| o.status.success());
    assert!(found || std::env::var_os("CI").is_none(), "in CI mdbook must be installed");
    if !found {
        println!("left out: the book (no mdbook)");
        return;
    }
    let python = std::env::var("REVOLVE_PYTHON").unwrap_or_else(|_| "python3".into());
    let converts = Command::new(&python).args(["-c", "import latex2mathml"]).output().is_ok_and(|o| o.status.success());
    assert!(converts || std::env::var_os("CI").is_none(), "in CI the Python package latex2mathml must be installed");
    if !converts {
        println!("left out: the book (no latex2mathml in {python})");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let output = Command::new(program).args(["build", "-d"]).arg(folder.path()).arg(project("docs")).output();
    let output = output.expect("mdbook runs");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && !message.contains("WARN") && !message.contains("ERROR"), "{message}");
    for path in pages().iter().filter_map(|p| p.strip_prefix("docs/")).filter(|p| *p != "SUMMARY.md") {
        let index = path.strip_suffix("README.md").map(|folder| format!("{folder}index.html"));
        let name = index.unwrap_or_else(|| path.replace(".md", ".html"));
        assert!(folder.path().join(&name).is_file(), "{name}");
        if path.starts_with("theory/") {
            let built = fs::read_to_string(folder.path().join(&name)).expect("a page");
            assert!(built.contains("<math") && !built.contains("$$") && !built.contains("\\tag"), "{name}: equations");
        }
    }
    let Some(mut browser) = HeadlessBrowser::start() else { return };
    for dark in [false, true] {
        browser.open(&folder.path().join("tutorial.html"), "?search=Johnson", PageView { width: 420, dark });
        let found = browser.value(
            "(async () => { for (let i = 0; i < 200; i++) { const n = document.querySelectorAll('#mdbook-searchresults li, #searchresults li').length; \
             if (n) return n; await new Promise(r => setTimeout(r, 50)); } return 0; })()",
        );
        assert!(found.as_u64() >= Some(2), "{found}");
        assert!(browser.errors.is_empty(), "{:?}", browser.errors);
        let light = browser.value("getComputedStyle(document.documentElement).backgroundColor.match(/\\d+/g)[0] > 128");
        assert_eq!(light, !dark);
        assert_eq!(browser.value("document.documentElement.scrollWidth <= innerWidth"), true);
    }
}
