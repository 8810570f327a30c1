//! The tutorials: every file and every command of a page works as printed, in the order of the page.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::common::project;
use crate::extending::copy_folder;
use crate::manual::compare_picture;
use crate::python::environment;
use crate::vtk::python;

/// Splits a command line into words as a shell does.
fn words(line: &str) -> Vec<String> {
    let (mut words, mut word, mut quoted) = (Vec::new(), String::new(), false);
    for letter in line.chars() {
        match letter {
            '"' => quoted = !quoted,
            ' ' if !quoted => words.extend((!word.is_empty()).then(|| std::mem::take(&mut word))),
            letter => word.push(letter),
        }
    }
    words.extend((!word.is_empty()).then_some(word));
    words
}

#[test]
fn every_command_of_the_tutorial_works() {
    let page = fs::read_to_string(project("docs/tutorial.md")).expect("a page");
    let fortran = Command::new("gfortran").arg("--version").output().is_ok();
    assert!(fortran || std::env::var_os("CI").is_none(), "in CI gfortran must be installed");
    let folder = tempfile::tempdir().expect("a folder");
    for (name, begin) in [("bar.inp", "    *Heading"), ("peak.py", "    from vtkmodules")] {
        assert!(page.contains(&format!("`{name}`")), "{name}");
        fs::write(folder.path().join(name), block(&page, begin)).expect("a file");
    }
    let commands: Vec<&str> = page.lines().filter_map(|line| line.strip_prefix("    revolve ")).collect();
    assert!(commands.len() >= 14, "{commands:?}");
    let mut printed = String::new();
    for command in commands {
        if command.contains("--user") && !fortran {
            println!("left out: {command} (no gfortran)");
            continue;
        }
        let output = Command::new(env!("CARGO_BIN_EXE_revolve"))
            .args(words(command))
            .current_dir(folder.path())
            .output()
            .expect("the program runs");
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "revolve {command}: {message}");
        printed += &String::from_utf8_lossy(&output.stdout);
    }
    let length = |name: &str| -> f64 {
        let line = printed.lines().find_map(|line| line.strip_prefix(&format!("{name} = ")));
        line.and_then(|text| text.parse().ok()).unwrap_or_else(|| panic!("{name}: {printed}"))
    };
    let there = |path: &str| folder.path().join(path).is_file();
    for path in ["out/taylor_copper/taylor_copper.pvd", "out/taylor_copper/taylor_copper.sta", "bar.svg"] {
        assert!(there(path), "{path}");
    }
    assert!(there("out/taylor_copper/report.html") && there("out/study/taylor_copper_study.png"));
    assert!(there("out/bar/report.html") && there("length.png") && there("energy.png"));
    // OpenRadioss gives 21.43 mm on this mesh.
    let copper = length("1000*(0.0324+final(U2@TIP))");
    assert!((copper - 21.43).abs() < 0.05, "{copper}");
    // Johnson and Cook's bar of this copper is a third shorter, and its foot more than half as wide again.
    let (long, wide) = (length("1000*final(COOR2@TIP)"), length("2000*final(COOR1@CORNER)"));
    assert!((15.0..18.5).contains(&long) && (11.5..15.5).contains(&wide), "{long} {wide}");
    let Some(python) = python() else { return };
    assert!(page.contains("\n    python peak.py\n"));
    let output = Command::new(python).arg("peak.py").current_dir(folder.path()).output().expect("python runs");
    let printed = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let largest = |name: &str| -> f64 {
        let line = printed.lines().find_map(|line| line.strip_prefix(&format!("{name} at most ")));
        line.and_then(|text| text.parse().ok()).unwrap_or_else(|| panic!("{name}: {printed}"))
    };
    assert!(largest("PEEQ") > 0.5 && largest("TEMP") > 298.0 + 50.0, "{printed}");
}

/// Returns the files that a page gives: a line that begins with "File `NAME`" and ends with a colon, then an indented
/// block.
fn files(page: &str) -> Vec<(String, String)> {
    let given = page.split("\nFile `").skip(1).map(|rest| {
        let (name, rest) = rest.split_once('`').expect("a name");
        let (_, text) = rest.split_once(":\n\n").expect("a file");
        (name.to_owned(), block(text, "    "))
    });
    given.collect()
}

/// Returns whether a line of a page is the beginning of a printed line. Numbers have the digits of the page; those of a run
/// may have more, by which they are rounded.
fn is_printed(quoted: &str, printed: &str) -> bool {
    let equals = |(quoted, printed): (&str, &str)| {
        let rounded = |number: f64| {
            let decimals = quoted.split_once('.').map_or(0, |(_, decimals)| decimals.len());
            format!("{number:.decimals$}")
        };
        let is_plain = quoted.parse::<f64>().is_ok() && !quoted.contains('e');
        quoted == printed || is_plain && printed.parse().is_ok_and(|number| rounded(number) == quoted)
    };
    printed.lines().any(|line| {
        let [mut quoted, mut printed] =
            [quoted, line].map(|line| line.split([' ', ',']).filter(|word| !word.is_empty()));
        quoted.all(|word| printed.next().is_some_and(|other| equals((word, other))))
    })
}

/// Returns the program that a command line of a page starts; `None` for lines that are no command.
fn program(line: &str, python: Option<&Path>) -> Option<Command> {
    let words = words(line);
    let mut command = match words.first()?.as_str() {
        "revolve" => Command::new(env!("CARGO_BIN_EXE_revolve")),
        "python" => Command::new(python?),
        _ => return None,
    };
    command.args(&words[1..]);
    Some(command)
}

/// Runs every page of `docs/tutorials` at the top of a copy of the decks; lines in blocks marked `text` are printed, digit by
/// digit, and pictures are those that the commands draw.
#[test]
fn tutorials_run_as_written() {
    let fortran = Command::new("gfortran").arg("--version").output().is_ok();
    let entries = fs::read_dir(project("docs/tutorials")).expect("tutorials").map(|e| e.expect("a page").path());
    let mut pages: Vec<_> = entries.filter(|path| path.extension().is_some_and(|end| end == "md")).collect();
    pages.sort();
    assert!(pages.len() >= 9, "{pages:?}");
    let mut old = Vec::new();
    for path in pages {
        let page = fs::read_to_string(&path).expect("a page");
        let needs_python = page.contains("\n    python ");
        let python = if needs_python { environment() } else { None };
        if page.contains(" --user ") && !fortran || needs_python && python.is_none() {
            println!("left out: {} (no gfortran, or no Python package)", path.display());
            continue;
        }
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["input", "docs/tutorials"] {
            copy_folder(&project(name), &folder.path().join(name));
        }
        for (name, text) in files(&page) {
            fs::write(folder.path().join(name), text).expect("a file");
        }
        let mut printed = String::new();
        for line in page.lines().filter_map(|line| line.strip_prefix("    ")) {
            let Some(mut command) = program(line, python) else { continue };
            let output = command.current_dir(folder.path()).output().expect("the program runs");
            let message = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.success(), "{}: {line}: {message}", path.display());
            printed += &String::from_utf8_lossy(&output.stdout);
        }
        let blocks = page.split("```text\n").skip(1).filter_map(|rest| Some(rest.split_once("```")?.0));
        let others = blocks.flat_map(str::lines).filter(|line| !is_printed(line, &printed));
        old.extend(others.map(|line| format!("{}: `{line}` is not printed", path.display())));
        let shown = page.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target);
        let is_drawn = |name: &&str| name.ends_with(".png") && !name.contains('/') && !name.starts_with("editor-");
        for name in shown.filter(is_drawn) {
            let written = [folder.path().join(name), folder.path().join("out/sweep").join(name)];
            let drawn = written.iter().find(|path| path.is_file()).unwrap_or_else(|| panic!("{name} is not drawn"));
            old.extend(compare_picture(drawn, &format!("tutorials/{name}")));
        }
    }
    assert!(old.is_empty(), "{old:#?}");
}

/// Returns the indented block of a page that begins with some words.
fn block(page: &str, begin: &str) -> String {
    let lines = page.lines().skip_while(|line| !line.starts_with(begin));
    let lines = lines.take_while(|line| line.starts_with("    "));
    lines.filter_map(|line| line.strip_prefix("    ")).flat_map(|line| [line, "\n"]).collect()
}
