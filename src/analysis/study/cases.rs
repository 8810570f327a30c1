//! Parts of a sweep that separate processes run: selection of cases, part files, and gathering of the parts.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::ops::Range;
use std::path::PathBuf;

use super::StudyError;
use super::grid::CaseGrid;
use super::log::{AppendedFile, complete_lines};
use super::quantity::Quantity;
use super::sweep::{CaseResult, SweepResults};
use crate::deck::files;
use crate::output::{JobFiles, csv, whole};

/// Environment variables with the index of a task in an array: Slurm, HyperQueue, PBS, Grid Engine, LSF.
const TASKS: [&str; 5] = ["SLURM_ARRAY_TASK_ID", "HQ_TASK_ID", "PBS_ARRAY_INDEX", "SGE_TASK_ID", "LSB_JOBINDEX"];
const PART: &str = "_cases_";
/// Ending of the list of finished cases of a running or interrupted sweep.
pub const LOG: &str = "_cases_log.csv";
const HEAD: &str = "# revolve sweep ";

/// Selection of cases of a sweep; cases are numbered from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaseRange {
    /// First and last case, both included.
    Span(usize, usize),
    /// Part number and number of parts of about equal size.
    Part(usize, usize),
}

impl CaseRange {
    /// Parses `A-B`, `A`, `K/N` (part K of N), `task` or `task/N`, where `task` is the index of the task in a scheduler
    /// array.
    pub fn parse(text: &str) -> Result<CaseRange, String> {
        CaseRange::parse_with(text, &|name| std::env::var(name).ok())
    }

    /// Parses like [`CaseRange::parse`], but reads environment variables with `variable`.
    fn parse_with(text: &str, variable: &dyn Fn(&str) -> Option<String>) -> Result<CaseRange, String> {
        let wrong = || format!("--cases {text}: expected A-B, A, K/N, task or task/N, counted from 1");
        let number = |t: &str| {
            match t.trim() {
            "task" => task(variable).ok_or_else(|| {
                format!(
                    "--cases {text}: this process is not a task of a scheduler array: none of {} is a number above zero",
                    TASKS.join(", ")
                )
            }),
            t => t.parse::<usize>().ok().filter(|n| *n > 0).ok_or_else(wrong),
        }
        };
        if let Some((part, parts)) = text.split_once('/') {
            let (part, parts) = (number(part)?, number(parts)?);
            return if part <= parts { Ok(CaseRange::Part(part, parts)) } else { Err(wrong()) };
        }
        let (first, last) = text.split_once('-').map_or((text, text), |ends| ends);
        let (first, last) = (number(first)?, number(last)?);
        if first <= last { Ok(CaseRange::Span(first, last)) } else { Err(wrong()) }
    }

    /// Returns the indices, from 0, of these cases in a sweep of `count` cases.
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
                "--cases: case {} does not exist; the sweep has {count} cases",
                range.end
            )));
        }
        Ok(range)
    }
}

/// Returns the index of the scheduler array task that runs this process.
fn task(variable: &dyn Fn(&str) -> Option<String>) -> Option<usize> {
    TASKS.iter().find_map(|name| variable(name)?.trim().parse().ok()).filter(|task| *task > 0)
}

/// Formats case numbers and parameter values as CSV.
pub fn list(grid: &CaseGrid, range: Range<usize>) -> String {
    let mut text = header(grid, &[]);
    for index in range {
        let values = grid.combination(index).into_iter().map(|pair| pair.1);
        text += &csv::line(std::iter::once((index + 1).to_string()).chain(values));
    }
    text
}

fn header(grid: &CaseGrid, more: &[&str]) -> String {
    csv::line(std::iter::once("case").chain(grid.names()).chain(more.iter().copied()))
}

/// Reader and writer of the part files of a sweep.
pub struct SweepPart<'a> {
    /// Hash that identifies the sweep.
    pub sweep: &'a str,
    pub grid: &'a CaseGrid,
    /// Quantities evaluated for each case.
    pub quantities: &'a [Quantity],
}

impl SweepPart<'_> {
    /// Returns the job whose name the file of a part has.
    pub fn job(job: &JobFiles, cases: &Range<usize>) -> JobFiles {
        JobFiles {
            folder: job.folder.clone(),
            name: format!("{}{PART}{:08}-{:08}", job.name, cases.start + 1, cases.end),
        }
    }

    /// Formats the text of a part; numbers have all digits, so that reading them back is exact.
    pub fn text(&self, cases: &Range<usize>, results: &SweepResults) -> String {
        let mut text = self.head();
        for ((values, doubts), index) in results.values.iter().zip(&results.warnings).zip(cases.clone()) {
            text += &self.line(index, values.as_deref(), doubts);
        }
        text
    }

    fn head(&self) -> String {
        let quantities: Vec<&str> = self.quantities.iter().map(|q| q.text.as_str()).collect();
        let names = header(self.grid, &[&quantities[..], &["doubts", "reason"]].concat());
        format!("{HEAD}{}\n{names}", self.sweep)
    }

    /// Formats the row of a case.
    fn line(&self, index: usize, values: Result<&[f64], &StudyError>, doubts: &[String]) -> String {
        let mut row: Vec<String> = vec![(index + 1).to_string()];
        row.extend(self.grid.combination(index).into_iter().map(|pair| pair.1));
        match values {
            Ok(values) => row.extend(values.iter().map(|v| format!("{v:e}"))),
            Err(_) => row.extend(vec![String::new(); self.quantities.len()]),
        }
        row.extend([json(&doubts), json(&values.err().map(ToString::to_string))]);
        csv::line(row)
    }

    /// Begins the list of finished cases, with those of an interrupted sweep.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn begin_log(&self, job: &JobFiles, known: &BTreeMap<usize, CaseResult>) -> Result<SweepLog<'_>, StudyError> {
        let lines = known.iter().map(|(index, case)| self.line(*index, case.values.as_deref(), &case.warnings));
        let text = self.head() + &lines.collect::<String>();
        Ok(SweepLog { part: self, file: AppendedFile::begin(job.path(LOG), &text)? })
    }

    /// Reads the finished cases of an interrupted sweep; empty if there are none. A last line that is not complete is
    /// dropped.
    ///
    /// # Errors
    /// If the file belongs to a different sweep or is damaged.
    pub fn finished(&self, job: &JobFiles) -> Result<BTreeMap<usize, CaseResult>, StudyError> {
        let path = job.path(LOG);
        let wrong = |message: String| StudyError::Setting(format!("{}: {message}", path.display()));
        let Some(text) = complete_lines(&path)? else { return Ok(BTreeMap::new()) };
        Ok(self.rows(&text).map_err(wrong)?.into_iter().collect())
    }

    /// Writes the part file atomically.
    pub fn write(&self, job: &JobFiles, cases: &Range<usize>, results: &SweepResults) -> Result<PathBuf, StudyError> {
        let path = SweepPart::job(job, cases).path(".csv");
        let written = whole::write_durable(&path, &[self.text(cases, results).as_bytes()]);
        written.map_err(|e| StudyError::Setting(e.to_string()))?;
        Ok(path)
    }

    /// Reads all parts of the sweep in the job's folder. If several parts contain a case, the last one read is used.
    pub fn gather(&self, job: &JobFiles) -> Result<SweepResults, StudyError> {
        let count = self.grid.count();
        let mut rows: Vec<Option<CaseResult>> = (0..count).map(|_| None).collect();
        for path in parts_of(job)? {
            let named = |message: String| StudyError::Setting(format!("{}: {message}", path.display()));
            let text = files::read_text(&path).map_err(|e| named(e.to_string()))?;
            for (index, row) in self.rows(&text).map_err(named)? {
                rows[index] = Some(row);
            }
        }
        let missing = missing(&rows);
        if !missing.is_empty() {
            return Err(StudyError::Setting(format!("{} are missing: run them with --cases", missing.join(", "))));
        }
        let mut results = SweepResults::default();
        for (index, row) in rows.into_iter().flatten().enumerate() {
            results.push(self.grid, index, row);
        }
        Ok(results)
    }

    /// Reads the case indices and rows of a part.
    fn rows(&self, text: &str) -> Result<Vec<(usize, CaseResult)>, String> {
        let mut lines = text.lines().enumerate();
        let head = lines.next().map_or("", |l| l.1);
        if head.strip_prefix(HEAD) != Some(self.sweep) {
            return Err(
                "the part belongs to a different sweep (deck, values, quantities, user subroutines or program version differ); \
                        remove the file or gather in the folder of that sweep"
                    .into(),
            );
        }
        if !text.ends_with('\n') {
            return Err("the file is truncated".into());
        }
        lines
            .skip(1)
            .map(|(at, line)| self.row(line).ok_or_else(|| format!("line {} cannot be read", at + 1)))
            .collect()
    }

    fn row(&self, line: &str) -> Option<(usize, CaseResult)> {
        let fields = csv::fields(line);
        let (named, quantity_count) = (self.grid.names().len(), self.quantities.len());
        let [case, rest @ ..] = &fields[..] else { return None };
        if rest.len() != named + quantity_count + 2 {
            return None;
        }
        let index = case.parse::<usize>().ok()?.checked_sub(1).filter(|index| *index < self.grid.count())?;
        let reason: Option<String> = serde_json::from_str(&rest[named + quantity_count + 1]).ok()?;
        let values = match reason {
            Some(reason) => Err(StudyError::Reported(reason)),
            None => {
                Ok(rest[named..named + quantity_count].iter().map(|v| v.parse().ok()).collect::<Option<Vec<f64>>>()?)
            }
        };
        Some((index, CaseResult { values, warnings: serde_json::from_str(&rest[named + quantity_count]).ok()? }))
    }
}

/// List of the finished cases of a running sweep.
pub struct SweepLog<'a> {
    part: &'a SweepPart<'a>,
    file: AppendedFile,
}

impl SweepLog<'_> {
    /// Adds a case.
    pub fn add(&self, index: usize, case: &CaseResult) {
        self.file.add(&self.part.line(index, case.values.as_deref(), &case.warnings));
    }

    /// Writes the remaining lines. Returns a warning if a line could not be written.
    pub fn finish(self) -> Option<String> {
        self.file.finish()
    }
}

/// Returns the table of a list of finished cases without failed ones, and the numbers of all cases and of failed ones.
pub fn finished_table(text: &str) -> Option<(String, [usize; 2])> {
    let mut lines = text[..text.rfind('\n')?].lines().skip(1).map(csv::fields);
    let inner = |fields: &[String]| Some(fields.get(1..fields.len().checked_sub(2)?)?.to_vec());
    let mut table = csv::line(inner(&lines.next()?)?);
    let [mut count, mut failed] = [0; 2];
    for fields in lines {
        count += 1;
        if fields.last().is_some_and(|reason| reason == "null") {
            table += &csv::line(inner(&fields)?);
        } else {
            failed += 1;
        }
    }
    Some((table, [count, failed]))
}

fn json<T: serde::Serialize>(words: &T) -> String {
    serde_json::to_string(words).unwrap_or_default()
}

/// Returns the part files of a job's sweep, sorted by name.
fn parts_of(job: &JobFiles) -> Result<Vec<PathBuf>, StudyError> {
    let cannot = |e: io::Error| StudyError::Setting(format!("{}: {e}", job.folder.display()));
    let begin = format!("{}{PART}", job.name);
    let mut paths = Vec::new();
    for entry in fs::read_dir(&job.folder).map_err(cannot)? {
        let path = entry.map_err(cannot)?.path();
        let is_part = |name: &str| name.starts_with(&begin) && name.ends_with(".csv") && !name.ends_with(LOG);
        if path.file_name().and_then(|name| name.to_str()).is_some_and(is_part) {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}

/// Returns the ranges of missing cases in the form of `--cases`, at most `MOST` ranges.
fn missing(rows: &[Option<CaseResult>]) -> Vec<String> {
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
        spans.push(format!("and {more} more ranges"));
    }
    if let Some(first) = spans.first_mut() {
        *first = format!("cases {first}");
    }
    spans
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::{CaseRange, SweepPart, finished_table};
    use crate::output::JobFiles;
    use crate::study::StudyError;
    use crate::study::grid::CaseGrid;
    use crate::study::quantity::Quantity;
    use crate::study::sweep::{CaseResult, SweepResults};

    #[test]
    fn case_ranges_are_parsed() {
        let in_task_7 = |name: &str| (name == "HQ_TASK_ID").then(|| "7".to_owned());
        let read = |text: &str| CaseRange::parse_with(text, &in_task_7);
        assert_eq!(read("3-5").map(|c| c.of(9)), Ok(Ok(2..5)));
        assert_eq!(read("task").map(|c| c.of(9)), Ok(Ok(6..7)));
        assert_eq!(read("task/8").map(|c| c.of(9)), Ok(Ok(6..7)));
        assert!(read("10").is_ok_and(|c| c.of(9).is_err()));
        for wrong in ["", "0", "5-3", "3/2", "0/2", "a-b", "1-", "-1", "task/6", "1-2-3"] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
        assert!(CaseRange::parse_with("task", &|_| None).is_err_and(|e| e.contains("SLURM_ARRAY_TASK_ID")));
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
    fn finished_cases_of_an_interrupted_sweep_are_read_back() {
        let folder = tempfile::tempdir().expect("a folder");
        let job = JobFiles { folder: folder.path().to_owned(), name: "a".into() };
        let grid = CaseGrid::parse(&["V=1,2,3".into()]).expect("a grid");
        let quantities = [Quantity::parse("final(U2@REF)").expect("a quantity")];
        let part = SweepPart { sweep: "this", grid: &grid, quantities: &quantities };
        assert_eq!(part.finished(&job), Ok(BTreeMap::new()));
        let case = |value: f64| CaseResult { values: Ok(vec![value]), warnings: Vec::new() };
        let failed = CaseResult { values: Err(StudyError::Reported("halted".into())), warnings: vec!["a, b".into()] };
        let log = part.begin_log(&job, &BTreeMap::from([(2, case(0.1 + 0.2))])).expect("a list");
        log.add(0, &failed);
        assert_eq!(log.finish(), None);
        let path = job.path(super::LOG);
        let text = std::fs::read_to_string(&path).expect("a list");
        // A process that was killed while it wrote a line.
        std::fs::write(&path, text.clone() + "2,2,1e").expect("a list");
        assert_eq!(part.finished(&job), Ok(BTreeMap::from([(2, case(0.1 + 0.2)), (0, failed)])));
        let (table, numbers) = finished_table(&text).expect("a table");
        assert_eq!((table.as_str(), numbers), ("V,final(U2@REF)\n3,3.0000000000000004e-1\n", [2, 1]));
        assert!(SweepPart { sweep: "that", ..part }.finished(&job).is_err());
    }

    #[test]
    fn gathered_parts_are_bit_identical() {
        let folder = tempfile::tempdir().expect("a folder");
        let job = JobFiles { folder: folder.path().to_owned(), name: "a".into() };
        let grid = CaseGrid::parse(&["V=1,2,3".into()]).expect("a grid");
        let quantities = [Quantity::parse("final(U2@REF)").expect("a quantity")];
        let part = SweepPart { sweep: "this", grid: &grid, quantities: &quantities };
        let whole = SweepResults {
            parameters: ["1", "2", "3"].map(|v| vec![v.to_owned()]).to_vec(),
            values: vec![
                Ok(vec![0.1 + 0.2]),
                Err(StudyError::Reported("it, \"it\"\nhalted".into())),
                Ok(vec![-1e-300]),
            ],
            warnings: vec![vec!["a, b".into()], Vec::new(), Vec::new()],
        };
        let some = |from: usize, to: usize| SweepResults {
            parameters: whole.parameters[from..to].to_vec(),
            values: whole.values[from..to].to_vec(),
            warnings: whole.warnings[from..to].to_vec(),
        };
        part.write(&job, &(0..1), &some(0, 1)).expect("written");
        part.write(&job, &(1..2), &some(1, 2)).expect("written");
        let missing = part.gather(&job).expect_err("one is missing").to_string();
        assert!(missing.starts_with("cases 3 are missing"), "{missing}");
        // Case 2 again.
        let last = part.write(&job, &(1..3), &some(1, 3)).expect("written");
        assert_eq!(part.gather(&job), Ok(whole));
        let other = SweepPart { sweep: "that", ..part };
        assert!(other.gather(&job).is_err_and(|e| e.to_string().contains("different sweep")));
        let text = std::fs::read_to_string(&last).expect("a part");
        std::fs::write(&last, &text[..text.len() - 5]).expect("cut off");
        assert!(SweepPart { sweep: "this", ..other }.gather(&job).is_err_and(|e| e.to_string().contains("truncated")));
    }
}
