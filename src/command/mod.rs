//! The commands, one file each: arguments, printing, exit status. Here: what several share.

pub mod chart;
pub mod check;
pub mod explain;
pub mod identify;
pub mod limit;
pub mod line;
pub mod mesh;
pub mod new;
mod outcome;
mod progress;
pub mod report;
pub mod resistance;
pub mod run;
pub mod scatter;
mod search;
pub mod shell;
pub mod study;
pub mod sweep;
pub mod threads;
pub mod words;

use std::error::Error;
use std::path::{Path, PathBuf};

use crate::deck::{Diagnostic, Diagnostics, Sources};
use crate::job::{self, Prepared, Refusal};
use crate::output::drawing::Drawing;
use crate::output::lock::FolderLock;
use crate::output::{self, Job};
use crate::study::chart::Chart;
use crate::study::table::Table;
use crate::user::Routines;
use crate::user::compile::{Compiled, compile};
use clap::Args;
use words::tell;

/// How a command ended, as the exit status of a process has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Status(pub u8);

impl Status {
    /// All went well.
    const SUCCESS: Status = Status(0);
}

impl From<u8> for Status {
    fn from(number: u8) -> Status {
        Status(number)
    }
}

/// Deck or arguments refused.
pub const REFUSED: u8 = 2;
/// Halted during the run, state saved.
pub const HALTED: u8 = 1;

/// A command was refused, and the reasons are printed already.
#[derive(Debug, thiserror::Error)]
#[error("refused")]
pub struct AlreadyPrinted;

/// Files with the user's routines.
#[derive(Args)]
pub struct UserFiles {
    /// File with user subroutines (vdload, vuamp, vdisp, vumat, vuhard, vusdfld, vucharlength, vexternaldb): Fortran, C or a shared library; may be given
    /// several times.
    #[arg(short = 'u', long = "user", value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Build them with bounds checks: slower, and an index out of bounds is told.
    #[arg(long, requires = "files")]
    check_user: bool,
}

impl UserFiles {
    /// Compiles them, if there are any.
    pub fn compiled(&self, quiet: bool) -> Result<Option<Compiled>, AlreadyPrinted> {
        if self.files.is_empty() {
            return Ok(None);
        }
        let compiled = compile(&self.files, self.check_user).map_err(|faults| {
            print_findings(&faults, &Sources::default());
            AlreadyPrinted
        })?;
        if !quiet {
            print_findings(&compiled.notes, &Sources::default());
        }
        Ok(Some(compiled))
    }

    /// Compiles and opens them in this process, or in one of their own; with the hash that identifies them.
    pub fn routines(&self, quiet: bool, isolated: bool) -> Result<(Routines, String), Box<dyn Error>> {
        let Some(compiled) = self.compiled(quiet)? else { return Ok((Routines::none(), String::new())) };
        let opened = if isolated { compiled.open_isolated() } else { compiled.open() };
        Ok((opened?, compiled.identity()))
    }
}

/// `--set NAME=VALUE` taken apart.
pub fn pairs(settings: &[String]) -> Result<Vec<(String, String)>, String> {
    let pair = |s: &String| {
        let (name, value) = s.split_once('=').ok_or_else(|| format!("--set {s}: NAME=VALUE is the form"))?;
        Ok((name.trim().to_owned(), value.trim().to_owned()))
    };
    settings.iter().map(pair).collect()
}

fn print_findings(found: &Diagnostics, sources: &Sources) {
    if found.is_empty() {
        return;
    }
    if words::is_coloured() {
        words::tell_styled(found.render_styled(sources).trim_end());
    } else {
        tell!("{}", found.render(sources).trim_end());
    }
}

fn print_finding(finding: Diagnostic) {
    let mut findings = Diagnostics::default();
    findings.push(finding);
    print_findings(&findings, &Sources::default());
}

/// Prints why a command failed: a finding with its code and help, else one line.
fn print_error(error: &(dyn Error + 'static)) {
    let finding = error
        .downcast_ref::<Diagnostic>()
        .or_else(|| error.downcast_ref::<Box<Diagnostic>>().map(|finding| &**finding))
        .or_else(|| match error.downcast_ref::<Refusal>()? {
            Refusal::Checkpoint(finding) => Some(&**finding),
            Refusal::Folder(_) => None,
        });
    match finding {
        Some(finding) => print_finding(finding.clone()),
        None if error.is::<AlreadyPrinted>() => {}
        None => tell!("error: {error}"),
    }
}

/// The job of a deck with its folder, which is locked against other jobs.
pub fn lock_job(deck: &Path, out: Option<PathBuf>) -> Result<(Job, FolderLock), Refusal> {
    let job = job::default_job(deck, out).map_err(Refusal::Checkpoint)?;
    let lock = job::take(&job)?;
    Ok((job, lock))
}

/// Prints the findings of a deck; an error if it may not run.
pub fn accept(prepared: &Prepared, quiet: bool) -> Result<(), AlreadyPrinted> {
    let errors = prepared.diagnostics.has_errors();
    if errors || !quiet {
        print_findings(&prepared.diagnostics, &prepared.deck.sources);
    }
    if errors { Err(AlreadyPrinted) } else { Ok(()) }
}

/// Prints a table with its columns lined up.
fn print_table(table: &Table) {
    words::write(format_args!("{}", table.terminal()), false);
}

/// Ending and bytes of a file.
type File = (String, Vec<u8>);

/// Writes a table, other files and charts (by the ending of their name) with their checksums; charts without points are left out.
fn write_results(
    job: &Job,
    name: &str,
    table: &Table,
    others: Vec<File>,
    charts: &[(String, Chart)],
) -> Result<(), Box<dyn Error>> {
    let mut files = vec![(format!("_{name}.csv"), table.csv().into_bytes())];
    files.extend(others);
    for (ending, chart) in charts.iter().filter(|(_, chart)| !chart.is_empty()) {
        let drawing = chart.drawing()?;
        let (svg, png) = (drawing.svg(), drawing.png()?);
        files.extend([(format!("_{name}{ending}.svg"), svg.into_bytes()), (format!("_{name}{ending}.png"), png)]);
    }
    Ok(output::write_with_sums(job, &files, &format!("_{name}.sfv"))?)
}

/// A chart or a drawing in the format that the ending of a file's name asks for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum PictureFormat {
    Svg,
    Png,
}

impl PictureFormat {
    /// The format of a file by the ending of its name.
    fn of(path: &Path) -> Result<PictureFormat, String> {
        match path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).as_deref() {
            Some("svg") => Ok(PictureFormat::Svg),
            Some("png") => Ok(PictureFormat::Png),
            _ => Err(format!("{}: the name of a picture ends in .png or .svg", path.display())),
        }
    }

    /// The bytes of the file.
    fn bytes(self, drawing: &Drawing) -> Result<Vec<u8>, String> {
        if self == PictureFormat::Svg { Ok(drawing.svg().into_bytes()) } else { drawing.png() }
    }
}

/// The exit status of what is only shown.
fn shown() -> Status {
    if words::arrived() { Status::SUCCESS } else { Status::from(HALTED) }
}

/// What a run was given: `V = 600, n = 20`.
fn given<'a>(settings: impl Iterator<Item = (&'a str, &'a String)>) -> String {
    let each: Vec<String> = settings.map(|(name, value)| format!("{name} = {value}")).collect();
    each.join(", ")
}

/// Tells of runs whose values are not what they seem, each with what it ran with.
fn tell_doubts(runs: &[(String, &[String])]) {
    const SHOWN: usize = 12;
    let doubtful: Vec<_> = runs.iter().filter(|(_, doubts)| !doubts.is_empty()).collect();
    for (given, doubts) in doubtful.iter().take(SHOWN) {
        doubts.iter().for_each(|doubt| tell!("warning: {given}: {doubt}"));
    }
    if doubtful.len() > SHOWN {
        tell!("warning: … and so of {} more runs", doubtful.len() - SHOWN);
    }
}
