//! Reads the results of `limit`, `identify`, `scatter`, `sensitivity` and `fragments`: the table (`<job>_limit.csv`) and the pictures.

use std::path::Path;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::data::{ReportPicture, ReportSearch, ReportTable};
use super::read::{in_file, verified_text};
use crate::output::sums::Checksums;
use crate::study::table::digits;

/// File name parts of the commands with the titles of their sections.
pub const KINDS: [(&str, &str); 5] = [
    ("limit", "Limit"),
    ("identify", "Identification"),
    ("scatter", "Scatter"),
    ("sensitivity", "Sensitivities"),
    ("fragments", "Fragments"),
];
/// Significant digits of numbers on the page.
const DIGITS: usize = 7;
/// Largest number of numbered pictures of a command.
const PICTURES: usize = 8;
/// Background of a picture, which is omitted so that pictures have the background of the page.
const GROUND: &str = "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n";

/// Reads the results of a command for a job in a folder.
pub fn read(folder: &Path, name: &str, kind: (&str, &'static str), sums: &Checksums) -> Result<ReportSearch, String> {
    let path = folder.join(format!("{name}_{}.csv", kind.0));
    let table = in_file(&path, table(name, &verified_text(&path, sums)?))?;
    let numbered = (2..=PICTURES).map(|i| format!("_{i}"));
    let endings = std::iter::once(String::new()).chain(numbered).chain(["_scatter", "_corner"].map(str::to_owned));
    let mut pictures = Vec::new();
    for ending in endings {
        let picture = folder.join(format!("{name}_{}{ending}.svg", kind.0));
        // A picture of an earlier command is not in the list of checksums of the table.
        if picture.is_file() && sums.has(&picture) == sums.has(&path) {
            pictures.push(self::picture(&picture, sums)?);
        }
    }
    Ok(ReportSearch { title: kind.1, table, pictures })
}

/// Reads the table from the text of its CSV file, with rounded numbers.
fn table(name: &str, text: &str) -> Result<ReportTable, String> {
    let mut table = ReportTable::parse(name, text)?.limited();
    table.rows.iter_mut().flatten().for_each(|text| *text = cell(std::mem::take(text)));
    Ok(table)
}

/// Rounds a number for the page.
fn cell(text: String) -> String {
    text.parse().map_or(text, |value| digits(value, DIGITS))
}

/// Reads an SVG picture without its background as an address that contains the picture.
fn picture(path: &Path, sums: &Checksums) -> Result<ReportPicture, String> {
    let svg = verified_text(path, sums)?.replacen(GROUND, "", 1);
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    Ok(ReportPicture { name, source: format!("data:image/svg+xml;base64,{}", STANDARD.encode(svg)) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_rounded_and_words_are_not() {
        let parsed = table("job", "what,value,to\n\"V50, limit\",417.33245849609375,-\n").expect("a table");
        assert_eq!(parsed.rows, [["V50, limit", "417.3325", "-"]]);
        assert!(table("job", "a,b\n1\n").is_err_and(|e| e.contains("row 1 has 1 fields")));
    }
}
