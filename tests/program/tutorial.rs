//! The tutorial as a stranger reads it: every command as printed works, in the order of the page; and the pages are all bound.

use std::fs;
use std::process::Command;

use crate::common::project;

/// The words of a command line as a shell takes them apart.
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
    let commands: Vec<&str> = page.lines().filter_map(|line| line.strip_prefix("    revolve ")).collect();
    assert!(commands.len() >= 9, "{commands:?}");
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
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "revolve {command}: {told}");
        printed += &String::from_utf8_lossy(&output.stdout);
    }
    let there = |path: &str| folder.path().join(path).is_file();
    for path in ["out/taylor_copper/taylor_copper.pvd", "out/taylor_copper/taylor_copper.sta", "bar.svg"] {
        assert!(there(path), "{path}");
    }
    assert!(there("out/taylor_copper/report.html") && there("out/study/taylor_copper_study.png"));
    // OpenRadioss has 21.43 mm on this mesh.
    let length = printed.lines().find_map(|line| line.strip_prefix("1000*(0.0324+final(U2@TIP)) = "));
    let length: f64 = length.and_then(|text| text.parse().ok()).expect("a length");
    assert!((length - 21.43).abs() < 0.05, "{length}");
}

/// Each page stands in the table of contents, and what it links to is there.
#[test]
fn the_book_holds_every_page() {
    let summary = fs::read_to_string(project("docs/SUMMARY.md")).expect("a page");
    let mut pages = 0;
    for entry in fs::read_dir(project("docs")).expect("pages") {
        let name = entry.expect("an entry").file_name().to_string_lossy().into_owned();
        if name.ends_with(".md") && name != "SUMMARY.md" {
            assert!(summary.contains(&format!("({name})")), "{name} is not in docs/SUMMARY.md");
            pages += 1;
        }
    }
    assert!(pages >= 14, "{pages}");
    for link in summary.split("](").skip(1).filter_map(|rest| rest.split(')').next()) {
        assert!(project("docs").join(link).is_file(), "{link}");
    }
}
