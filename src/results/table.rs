//! Tables of text for the terminal and CSV files, and formatting of numbers.

use crate::columns::aligned_table;
use crate::csv;

/// Table of formatted cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TextTable {
    /// Column names.
    pub header: Vec<String>,
    /// Cells by row; each row has as many cells as the header.
    pub rows: Vec<Vec<String>>,
}

impl TextTable {
    /// Formats the table for the terminal, with aligned columns and numbers to the right.
    pub fn terminal(&self) -> String {
        aligned_table(&self.header, &self.rows, true)
    }

    /// Formats the table for the terminal; of more than 30 rows only the first ten and the last ten, and the number of
    /// rows between them.
    pub fn terminal_excerpt(&self) -> String {
        const MOST: usize = 30;
        const AT_EACH_END: usize = 10;
        if self.rows.len() <= MOST {
            return self.terminal();
        }
        let left_out = self.rows.len() - 2 * AT_EACH_END;
        let (first, last) = (&self.rows[..AT_EACH_END], &self.rows[AT_EACH_END + left_out..]);
        let text = aligned_table(&self.header, &[first, last].concat(), true);
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        lines.insert(1 + AT_EACH_END, format!(" … {left_out} more rows"));
        lines.join("\n") + "\n"
    }

    /// Formats the table as CSV; fields with commas or quotes are quoted.
    pub fn csv(&self) -> String {
        std::iter::once(&self.header).chain(&self.rows).map(csv::line).collect()
    }
}

/// Formats a cell with `few` digits or with all digits; empty without a value.
pub fn cell(value: Option<f64>, few: usize, all_digits: bool) -> String {
    match value {
        Some(value) if all_digits => format!("{value:?}"),
        Some(value) => digits(value, few),
        None => String::new(),
    }
}

/// Formats a number with seven significant digits and without an exponent.
pub fn number(value: f64) -> String {
    rounded(value, 7).to_string()
}

/// Rounds to `count` significant digits.
pub fn rounded(value: f64, count: usize) -> f64 {
    format!("{value:.*e}", count.saturating_sub(1)).parse().unwrap_or(value)
}

/// Formats a time in seconds with three digits and its unit.
pub fn duration(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s < 1e-3 => (1e6 * s, "us"),
        s if s < 1.0 => (1e3 * s, "ms"),
        s => (s, "s"),
    };
    format!("{} {unit}", short(value))
}

/// Formats a number with three significant digits.
pub fn short(value: f64) -> String {
    digits(value, 3)
}

/// Formats a number with `count` significant digits in the shortest form.
pub fn digits(value: f64, count: usize) -> String {
    let number = rounded(value, count);
    let size = number.abs();
    if size != 0.0 && !(1e-4..1e7).contains(&size) { format!("{number:e}") } else { format!("{number}") }
}

#[cfg(test)]
mod tests {
    use super::TextTable;

    #[test]
    fn excerpt_of_a_long_table_has_both_ends() {
        let table = |count: usize| TextTable {
            header: vec!["V".into()],
            rows: (1..=count).map(|row| vec![row.to_string()]).collect(),
        };
        assert_eq!(table(30).terminal_excerpt(), table(30).terminal());
        let lines: Vec<String> = table(981).terminal_excerpt().lines().map(str::to_owned).collect();
        assert_eq!(lines.len(), 22);
        assert_eq!(
            [&*lines[0], &*lines[10], &*lines[11], &*lines[12], &*lines[21]],
            ["   V", "  10", " … 961 more rows", " 972", " 981"]
        );
    }
}
