//! `docs/stability.md` names every case with what breaks and by what it is judged; figures are written by running all:
//! `cargo test --release --test gauntlet -- --ignored write_the_page`.

use std::fmt::Write as _;

use crate::common::project;

const BEGIN: &str = "<!-- written by `write_the_page`: from here -->\n";
const END: &str = "<!-- to here -->\n";

fn page() -> String {
    std::fs::read_to_string(project("docs/stability.md")).expect("the page")
}

/// The part of the page that is written.
fn written(page: &str) -> &str {
    let begin = page.find(BEGIN).expect("where it begins") + BEGIN.len();
    &page[begin..page.find(END).expect("where it ends")]
}

fn begins(case: &crate::Case) -> String {
    format!("| `{}` | {} | {} |", case.name, case.breaks, case.criterion)
}

#[test]
fn the_page_names_every_case_and_no_other() {
    let page = page();
    let rows: Vec<&str> = written(&page).lines().filter(|l| l.starts_with("| `")).collect();
    let cases: Vec<_> = crate::all().collect();
    assert_eq!(rows.len(), cases.len(), "write the page again");
    for (row, case) in rows.iter().zip(cases) {
        assert!(row.starts_with(&begins(case)), "not as the case says: {row}");
    }
}

#[test]
#[ignore = "writes docs/stability.md"]
fn write_the_page() {
    let mut text = String::new();
    let mut theme = "";
    for case in crate::all() {
        if case.theme != theme {
            theme = case.theme;
            write!(
                text,
                "\n## {theme}\n\n| case | what breaks a naive code | criterion | reached |\n|---|---|---|---|\n"
            )
            .expect("text");
        }
        let verdict = (case.run)();
        assert!(verdict.holds, "{}: {}", case.name, verdict.figure);
        writeln!(text, "{} {} |", begins(case), verdict.figure).expect("text");
    }
    let page = page();
    let (begin, end) = (page.find(BEGIN).expect("begin") + BEGIN.len(), page.find(END).expect("end"));
    std::fs::write(project("docs/stability.md"), format!("{}{text}\n{}", &page[..begin], &page[end..]))
        .expect("written");
}

/// Every case in single precision beside double: what stands in `docs/accuracy.md`. Alone in its process, for all cases share
/// the precision: `cargo test --release --test gauntlet -- --ignored in_single_precision --show-output`.
#[test]
#[ignore = "runs all cases twice"]
fn in_single_precision_too() {
    let mut lost = Vec::new();
    println!("| case | double | single |\n|---|---|---|");
    for case in crate::all() {
        let double = (case.run)();
        crate::scene::in_single(true);
        let single = std::panic::catch_unwind(case.run);
        crate::scene::in_single(false);
        let (figure, holds) = single.map_or(("no answer".into(), false), |verdict| (verdict.figure, verdict.holds));
        let mark = if holds { "" } else { " (**not met**)" };
        println!("| `{}` | {} | {figure}{mark} |", case.name, double.figure);
        if !holds {
            lost.push(case.name);
        }
    }
    println!("not met: {lost:?}");
    assert_eq!(lost, NOT_IN_SINGLE, "docs/accuracy.md names them");
}

/// Cases whose criteria ask for more digits than single precision has.
const NOT_IN_SINGLE: &[&str] = &["a_million_increments_of_free_vibration", "three_systems_of_units"];
