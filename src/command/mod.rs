//! The commands, one file each: arguments, printing, exit status. Here: what several share.
//! Never here: physics, files of results (`output`), anything a test would call without a command line.

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
pub mod signals;
pub mod study;
pub mod sweep;
pub mod threads;
pub mod words;

use std::error::Error;
use std::path::{Path, PathBuf};

use crate::deck::{Diagnostic, Diagnostics, Sources};
use crate::job::{self, Prepared, Refusal};
use crate::output::Job;
use crate::output::lock::Lock;
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

/// The process in which the user's routines run.
#[derive(Clone, Copy)]
pub enum Home {
    /// That of the run.
    Here,
    /// One of their own.
    Own,
}

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
    /// Compiles them, if there are any; `None` if they were refused (told).
    pub fn compiled(&self, quiet: bool) -> Option<Option<Compiled>> {
        if self.files.is_empty() {
            return Some(None);
        }
        match compile(&self.files, self.check_user) {
            Ok(compiled) => {
                if !quiet {
                    print_findings(&compiled.notes, &Sources::default());
                }
                Some(Some(compiled))
            }
            Err(faults) => {
                print_findings(&faults, &Sources::default());
                None
            }
        }
    }

    /// Compiles and opens them.
    pub fn routines(&self, quiet: bool) -> Option<Routines> {
        self.opened(quiet, Home::Here).map(|opened| opened.0)
    }

    /// The same, and what tells them from others; `None` if they were refused (told).
    pub fn opened(&self, quiet: bool, home: Home) -> Option<(Routines, String)> {
        let Some(compiled) = self.compiled(quiet)? else { return Some((Routines::none(), String::new())) };
        let opened = match home {
            Home::Here => compiled.open(),
            Home::Own => compiled.open_isolated(),
        };
        match opened {
            Ok(routines) => Some((routines, compiled.identity())),
            Err(fault) => {
                print_finding(fault);
                None
            }
        }
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

fn refused(finding: Diagnostic) -> Status {
    print_finding(finding);
    Status::from(REFUSED)
}

/// The job of a deck with its folder, which no other job has as long as the lock is held; `None` if refused (told).
pub fn folder_of(deck: &Path, out: Option<PathBuf>) -> Result<Option<(Job, Lock)>, Box<dyn Error>> {
    let taken = job::default_job(deck, out).map_err(Refusal::Checkpoint).and_then(|job| {
        let lock = job::take(&job)?;
        Ok((job, lock))
    });
    match taken {
        Ok(taken) => Ok(Some(taken)),
        Err(Refusal::Folder(error)) => Err(error.into()),
        Err(Refusal::Checkpoint(finding)) => {
            print_finding(*finding);
            Ok(None)
        }
    }
}

/// Prints findings; whether the deck may run.
pub fn accepted(prepared: &Prepared, quiet: bool) -> bool {
    let errors = prepared.diagnostics.has_errors();
    if errors || !quiet {
        print_findings(&prepared.diagnostics, &prepared.deck.sources);
    }
    !errors
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
