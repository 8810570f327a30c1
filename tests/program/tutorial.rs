//! The tutorial as a stranger reads it: every file and every command as printed works, in the order of the page.

use std::fs;
use std::process::Command;

use crate::common::project;
use crate::vtk::python;

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
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "revolve {command}: {told}");
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
    // OpenRadioss has 21.43 mm on this mesh.
    let copper = length("1000*(0.0324+final(U2@TIP))");
    assert!((copper - 21.43).abs() < 0.05, "{copper}");
    // Johnson and Cook's own bar of this copper: shorter by a third, its foot wider by half and more.
    let (long, wide) = (length("1000*final(COOR2@TIP)"), length("2000*final(COOR1@CORNER)"));
    assert!((15.0..18.5).contains(&long) && (11.5..15.5).contains(&wide), "{long} {wide}");
    let Some(python) = python() else { return };
    assert!(page.contains("\n    python peak.py\n"));
    let output = Command::new(python).arg("peak.py").current_dir(folder.path()).output().expect("python runs");
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let largest = |name: &str| -> f64 {
        let line = told.lines().find_map(|line| line.strip_prefix(&format!("{name} at most ")));
        line.and_then(|text| text.parse().ok()).unwrap_or_else(|| panic!("{name}: {told}"))
    };
    assert!(largest("PEEQ") > 0.5 && largest("TEMP") > 298.0 + 50.0, "{told}");
}

/// The indented block that begins with some words, as the reader copies it.
fn block(page: &str, begin: &str) -> String {
    let lines = page.lines().skip_while(|line| !line.starts_with(begin));
    let lines = lines.take_while(|line| line.starts_with("    "));
    lines.filter_map(|line| line.strip_prefix("    ")).flat_map(|line| [line, "\n"]).collect()
}
