//! The status file of a job as JSON: last line, warnings, whether the job has ended, and the stable time increment with
//! its limiting element over time.

use serde_json::{Value, json};

/// Begin of the line that a job appends at its end.
const END: &str = "THE ANALYSIS HAS ";

/// Contents of a status file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JobStatus {
    /// Last line: increment, step, step time, total time, wall-clock time, increment length, limiting element.
    pub last: Value,
    pub warnings: Vec<String>,
    /// `completed` or `halted`; empty while the job runs, or if it was killed.
    pub ended: String,
    /// Step by step: times, increments, and what limits them, in the form of a summary.
    pub limits: Value,
}

impl JobStatus {
    /// Parses the text of a status file. Lines that are not known are ignored.
    pub fn parse(text: &str) -> JobStatus {
        let mut status = JobStatus::default();
        let (mut step, mut steps): (String, Vec<LimitRows>) = (String::new(), Vec::new());
        for line in text.lines() {
            if let Some(name) = line.strip_prefix("STEP ") {
                step = name.split_once("  ").map_or(name, |(_, name)| name).trim().to_owned();
                steps.push(LimitRows::default());
            } else if let Some(end) = line.strip_prefix(END) {
                status.ended = end.trim().to_lowercase();
            } else if let Some(warning) = line.strip_prefix("***WARNING: ") {
                status.warnings.push(warning.to_owned());
            } else if let (Some(row), Some(rows)) = (StatusRow::parse(line), steps.last_mut()) {
                status.last = row.json(&step);
                rows.push(&row);
            }
        }
        status.limits = steps.iter().map(LimitRows::json).collect();
        status
    }
}

/// Line of the table.
struct StatusRow<'a> {
    increment: u64,
    step_time: f64,
    time: f64,
    wall: &'a str,
    stable: f64,
    element: String,
}

impl StatusRow<'_> {
    /// Parses a line: increment, step time, total time, wall-clock time, stable increment, element, two energies. The
    /// element is empty if none limits the increment.
    fn parse(line: &str) -> Option<StatusRow<'_>> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [increment, step_time, time, wall, stable, element @ .., _, _] = &words[..] else { return None };
        Some(StatusRow {
            increment: increment.parse().ok()?,
            step_time: step_time.parse().ok()?,
            time: time.parse().ok()?,
            wall,
            stable: stable.parse().ok()?,
            element: element.join(" "),
        })
    }

    fn json(&self, step: &str) -> Value {
        json!({
            "step": step, "increment": self.increment, "step_time": self.step_time, "time": self.time, "wall": self.wall,
            "stable": self.stable, "element": self.element,
        })
    }
}

/// Rows of a step as lists, and names of limiting elements.
#[derive(Default)]
struct LimitRows {
    time: Vec<f64>,
    increment: Vec<f64>,
    by: Vec<usize>,
    names: Vec<String>,
}

impl LimitRows {
    fn push(&mut self, row: &StatusRow<'_>) {
        // At the start of a step there is no increment yet.
        if row.stable <= 0.0 {
            return;
        }
        let name = if row.element.is_empty() { "no element".to_owned() } else { format!("element {}", row.element) };
        let position = self.names.iter().position(|known| *known == name).unwrap_or_else(|| {
            self.names.push(name);
            self.names.len() - 1
        });
        self.time.push(row.time);
        self.increment.push(row.stable);
        self.by.push(position);
    }

    fn json(&self) -> Value {
        json!({"time": self.time, "increment": self.increment, "by": self.by, "names": self.names})
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn status_file_gives_the_last_line_warnings_and_limits() {
        let text = "Revolve 0.1.0: rod starts\n\nSTEP 1  Step-1\n\n              STEP     TOTAL\nINCREMENT     TIME\n\
            \x20       0  0.00E+00  0.00E+00  00:00:00  0.00E+00               1.00E+03  1.00E+03\n\
            \x20         frame rod_0000.vtu\n***WARNING: R301: slow\n\
            \x20      12  1.00E-06  1.00E-06  00:00:01  8.00E-08          Rod.7  9.00E+02  1.00E+03\n";
        let status = JobStatus::parse(text);
        assert_eq!((status.last["increment"].as_u64(), status.last["step"].as_str()), (Some(12), Some("Step-1")));
        assert_eq!((status.last["element"].as_str(), status.last["wall"].as_str()), (Some("Rod.7"), Some("00:00:01")));
        assert_eq!((status.warnings, status.ended.as_str()), (vec!["R301: slow".to_owned()], ""));
        assert_eq!(
            status.limits[0],
            json!({"time": [1e-6], "increment": [8e-8], "by": [0], "names": ["element Rod.7"]})
        );
        assert_eq!(JobStatus::parse(&format!("{text}THE ANALYSIS HAS HALTED\n")).ended, "halted");
        assert_eq!(JobStatus::parse("\0 \u{fffd} STEP"), JobStatus { limits: json!([]), ..JobStatus::default() });
    }
}
