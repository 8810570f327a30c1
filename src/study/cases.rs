//! Parts of a sweep: which of its cases a process runs, what it leaves for the others, and how parts become the whole again.

use std::fs;
use std::ops::Range;
use std::path::PathBuf;

use super::StudyError;
use super::grid::Grid;
use super::quantity::Quantity;
use super::sweep::Results;
use crate::deck::files;
use crate::output::{Job, csv, whole};

/// What tells a task of an array its number: Slurm, HyperQueue, PBS, Grid Engine, LSF.
const TASKS: [&str; 5] = ["SLURM_ARRAY_TASK_ID", "HQ_TASK_ID", "PBS_ARRAY_INDEX", "SGE_TASK_ID", "LSB_JOBINDEX"];
const PART: &str = "_cases_";
const HEAD: &str = "# revolve sweep ";

/// Some cases of a sweep, as they are asked for; they are counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaseRange {
    /// From one case to another, both of them in it.
    Span(usize, usize),
    /// One of so many parts of about the same size.
    Part(usize, usize),
}

impl CaseRange {
    /// From `A-B`, `A`, `K/N` (part K of N), and `task` or `task/N`, where the number is that of the task of an array.
    pub fn parse(text: &str) -> Result<CaseRange, String> {
        CaseRange::told(text, &|name| std::env::var(name).ok())
    }

    /// The same where `variable` tells what stands in the environment.
    fn told(text: &str, variable: &dyn Fn(&str) -> Option<String>) -> Result<CaseRange, String> {
        let wrong = || format!("--cases {text}: A-B, A, K/N, task or task/N is the form, counted from 1");
        let number = |t: &str| match t.trim() {
            "task" => task(variable).ok_or_else(|| {
                format!(
                    "--cases {text}: no task of an array here, for none of {} is a number from 1 on",
                    TASKS.join(", ")
                )
            }),
            t => t.parse::<usize>().ok().filter(|n| *n > 0).ok_or_else(wrong),
        };
        if let Some((part, parts)) = text.split_once('/') {
            let (part, parts) = (number(part)?, number(parts)?);
            return if part <= parts { Ok(CaseRange::Part(part, parts)) } else { Err(wrong()) };
        }
        let (first, last) = text.split_once('-').map_or((text, text), |ends| ends);
        let (first, last) = (number(first)?, number(last)?);
        if first <= last { Ok(CaseRange::Span(first, last)) } else { Err(wrong()) }
    }

    /// Indices of these cases among so many.
    pub fn of(self, count: usize) -> Result<Range<usize>, StudyError> {
        let range = match self {
            CaseRange::Span(first, last) => first - 1..last,
            CaseRange::Part(part, parts) => {
                let begin = |part: usize| (part as u128 * count as u128 / parts as u128) as usize;
                begin(part - 1)..begin(part)
            }
        };
        if range.end > count {
            return Err(StudyError::Setting(format!(
                "--cases: the sweep has {count} cases, none is number {}",
                range.end
            )));
        }
        Ok(range)
    }
}

/// Number of the task of an array in which this process runs.
fn task(variable: &dyn Fn(&str) -> Option<String>) -> Option<usize> {
    TASKS.iter().find_map(|name| variable(name)?.trim().parse().ok()).filter(|task| *task > 0)
}

/// The list of cases: their numbers and the values of their parameters.
pub fn list(grid: &Grid, range: Range<usize>) -> String {
    let mut text = header(grid, &[]);
    for index in range {
        let values = grid.combination(index).into_iter().map(|pair| pair.1);
        text += &csv::line(std::iter::once((index + 1).to_string()).chain(values));
    }
    text
}

fn header(grid: &Grid, more: &[&str]) -> String {
    csv::line(std::iter::once("case").chain(grid.names()).chain(more.iter().copied()))
}

/// A part of a sweep as it is written.
pub struct SweepPart<'a> {
    /// What makes the sweep the one it is.
    pub sweep: &'a str,
    pub grid: &'a Grid,
    /// What is asked of each case.
    pub quantities: &'a [Quantity],
}

impl SweepPart<'_> {
    /// The job under which some cases are written, beside those of other parts.
    pub fn job(job: &Job, cases: &Range<usize>) -> Job {
        Job { folder: job.folder.clone(), name: format!("{}{PART}{:08}-{:08}", job.name, cases.start + 1, cases.end) }
    }

    /// Text of the part: all digits, so that nothing is lost on the way.
    pub fn text(&self, cases: &Range<usize>, results: &Results) -> String {
        let mut text = format!("{HEAD}{}\n", self.sweep);
        let quantities: Vec<&str> = self.quantities.iter().map(|q| q.text.as_str()).collect();
        text += &header(self.grid, &[&quantities[..], &["doubts", "reason"]].concat());
        let rows = results.parameters.iter().zip(&results.values).zip(&results.doubts).zip(cases.clone());
        for (((parameters, values), doubts), index) in rows {
            let mut row: Vec<String> = vec![(index + 1).to_string()];
            row.extend(parameters.iter().cloned());
            match values {
                Ok(values) => row.extend(values.iter().map(|v| format!("{v:e}"))),
                Err(_) => row.extend(vec![String::new(); self.quantities.len()]),
            }
            row.extend([json(doubts), json(&values.as_ref().err().map(ToString::to_string))]);
            text += &csv::line(row);
        }
        text
    }

    /// Writes the part, whole or not at all.
    pub fn write(&self, job: &Job, cases: &Range<usize>, results: &Results) -> Result<PathBuf, StudyError> {
        let path = SweepPart::job(job, cases).path(".csv");
        let written = whole::write_durable(&path, self.text(cases, results).as_bytes());
        written.map_err(|e| StudyError::Setting(e.to_string()))?;
        Ok(path)
    }

    /// All parts of the sweep that are in the job's folder. Cases that several parts have are taken once.
    pub fn gather(&self, job: &Job) -> Result<Results, StudyError> {
        let count = self.grid.count();
        let mut rows: Vec<Option<GatheredCase>> = (0..count).map(|_| None).collect();
        for path in parts_of(job)? {
            let named = |message: String| StudyError::Setting(format!("{}: {message}", path.display()));
            let text = files::read_text(&path).map_err(|e| named(e.to_string()))?;
            for (index, row) in self.rows(&text).map_err(named)? {
                rows[index] = Some(row);
            }
        }
        let missing = missing(&rows);
        if !missing.is_empty() {
            return Err(StudyError::Setting(format!("{} are missing: run each by --cases", missing.join(", "))));
        }
        let mut results = Results::default();
        for (index, row) in rows.into_iter().flatten().enumerate() {
            results.parameters.push(self.grid.combination(index).into_iter().map(|pair| pair.1).collect());
            results.values.push(row.values);
            results.doubts.push(row.doubts);
        }
        Ok(results)
    }

    /// Indices and rows of a part.
    fn rows(&self, text: &str) -> Result<Vec<(usize, GatheredCase)>, String> {
        let mut lines = text.lines().enumerate();
        let head = lines.next().map_or("", |l| l.1);
        if head.strip_prefix(HEAD) != Some(self.sweep) {
            return Err(
                "it is of another sweep: another deck, other values, quantities, routines or another version; \
                        take it away or gather in the folder of its own"
                    .into(),
            );
        }
        if !text.ends_with('\n') {
            return Err("it is cut off".into());
        }
        lines
            .skip(1)
            .map(|(at, line)| self.row(line).ok_or_else(|| format!("line {} cannot be read", at + 1)))
            .collect()
    }

    fn row(&self, line: &str) -> Option<(usize, GatheredCase)> {
        let fields = csv::fields(line);
        let (named, asked) = (self.grid.names().len(), self.quantities.len());
        let [case, rest @ ..] = &fields[..] else { return None };
        if rest.len() != named + asked + 2 {
            return None;
        }
        let index = case.parse::<usize>().ok()?.checked_sub(1).filter(|index| *index < self.grid.count())?;
        let reason: Option<String> = serde_json::from_str(&rest[named + asked + 1]).ok()?;
        let values = match reason {
            Some(reason) => Err(StudyError::Reported(reason)),
            None => Ok(rest[named..named + asked].iter().map(|v| v.parse().ok()).collect::<Option<Vec<f64>>>()?),
        };
        Some((index, GatheredCase { values, doubts: serde_json::from_str(&rest[named + asked]).ok()? }))
    }
}

/// What a part says of a case.
struct GatheredCase {
    values: Result<Vec<f64>, StudyError>,
    doubts: Vec<String>,
}

fn json<T: serde::Serialize>(words: &T) -> String {
    serde_json::to_string(words).unwrap_or_default()
}

/// Files with parts of a job's sweep, in the order of their names.
fn parts_of(job: &Job) -> Result<Vec<PathBuf>, StudyError> {
    let cannot = |e: std::io::Error| StudyError::Setting(format!("{}: {e}", job.folder.display()));
    let begin = format!("{}{PART}", job.name);
    let mut paths = Vec::new();
    for entry in fs::read_dir(&job.folder).map_err(cannot)? {
        let path = entry.map_err(cannot)?.path();
        let is_part = |name: &str| name.starts_with(&begin) && name.ends_with(".csv");
        if path.file_name().and_then(|name| name.to_str()).is_some_and(is_part) {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}

/// Cases that no part has, as `--cases` takes them; the first few spans of them.
fn missing(rows: &[Option<GatheredCase>]) -> Vec<String> {
    const MOST: usize = 10;
    let mut spans: Vec<String> = Vec::new();
    let mut index = 0;
    for same in rows.chunk_by(|a, b| a.is_none() == b.is_none()) {
        if same[0].is_none() {
            spans.push(if same.len() == 1 {
                format!("{}", index + 1)
            } else {
                format!("{}-{}", index + 1, index + same.len())
            });
        }
        index += same.len();
    }
    if spans.len() > MOST {
        let more = spans.len() - MOST;
        spans.truncate(MOST);
        spans.push(format!("and {more} spans more"));
    }
    if let Some(first) = spans.first_mut() {
        *first = format!("cases {first}");
    }
    spans
}

#[cfg(test)]
mod tests {
    use super::{CaseRange, SweepPart};
    use crate::output::Job;
    use crate::study::StudyError;
    use crate::study::grid::Grid;
    use crate::study::quantity::Quantity;
    use crate::study::sweep::Results;

    #[test]
    fn cases_are_read() {
        let in_task_7 = |name: &str| (name == "HQ_TASK_ID").then(|| "7".to_owned());
        let read = |text: &str| CaseRange::told(text, &in_task_7);
        assert_eq!(read("3-5").map(|c| c.of(9)), Ok(Ok(2..5)));
        assert_eq!(read("task").map(|c| c.of(9)), Ok(Ok(6..7)));
        assert_eq!(read("task/8").map(|c| c.of(9)), Ok(Ok(6..7)));
        assert!(read("10").is_ok_and(|c| c.of(9).is_err()));
        for wrong in ["", "0", "5-3", "3/2", "0/2", "a-b", "1-", "-1", "task/6", "1-2-3"] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
        assert!(CaseRange::told("task", &|_| None).is_err_and(|e| e.contains("SLURM_ARRAY_TASK_ID")));
    }

    #[test]
    fn parts_cover_every_case_once() {
        for (count, parts) in [(1, 1), (10, 3), (3, 10), (1000, 64), (10_000_000_000, 7)] {
            let ranges = (1..=parts).map(|part| CaseRange::Part(part, parts).of(count).expect("a part"));
            let ends: Vec<_> = ranges.collect();
            assert!(ends[0].start == 0 && ends[parts - 1].end == count);
            assert!(ends.windows(2).all(|two| two[0].end == two[1].start));
        }
    }

    #[test]
    fn what_is_written_is_gathered_to_the_last_bit() {
        let folder = tempfile::tempdir().expect("a folder");
        let job = Job { folder: folder.path().to_owned(), name: "a".into() };
        let grid = Grid::parse(&["V=1,2,3".into()]).expect("a grid");
        let quantities = [Quantity::parse("final(U2@REF)").expect("a quantity")];
        let part = SweepPart { sweep: "this", grid: &grid, quantities: &quantities };
        let whole = Results {
            parameters: ["1", "2", "3"].map(|v| vec![v.to_owned()]).to_vec(),
            values: vec![
                Ok(vec![0.1 + 0.2]),
                Err(StudyError::Reported("it, \"it\"\nhalted".into())),
                Ok(vec![-1e-300]),
            ],
            doubts: vec![vec!["a, b".into()], Vec::new(), Vec::new()],
        };
        let some = |from: usize, to: usize| Results {
            parameters: whole.parameters[from..to].to_vec(),
            values: whole.values[from..to].to_vec(),
            doubts: whole.doubts[from..to].to_vec(),
        };
        part.write(&job, &(0..1), &some(0, 1)).expect("written");
        part.write(&job, &(1..2), &some(1, 2)).expect("written");
        let missing = part.gather(&job).expect_err("one is missing").to_string();
        assert!(missing.starts_with("cases 3 are missing"), "{missing}");
        // One case once more.
        let last = part.write(&job, &(1..3), &some(1, 3)).expect("written");
        assert_eq!(part.gather(&job), Ok(whole));
        let other = SweepPart { sweep: "that", ..part };
        assert!(other.gather(&job).is_err_and(|e| e.to_string().contains("another sweep")));
        let text = std::fs::read_to_string(&last).expect("a part");
        std::fs::write(&last, &text[..text.len() - 5]).expect("cut off");
        assert!(SweepPart { sweep: "this", ..other }.gather(&job).is_err_and(|e| e.to_string().contains("cut off")));
    }
}
