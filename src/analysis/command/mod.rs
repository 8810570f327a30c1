//! The commands of the program, one file per command, and the functions that they share.
// Help texts are printed as they are: `<deck name>` is no HTML.
#![allow(rustdoc::invalid_html_tags)]

pub mod chart;
pub mod check;
pub mod explain;
pub mod fragments;
pub mod identify;
pub mod info;
pub mod limit;
pub mod line;
pub mod lsp;
mod map;
pub mod material;
pub mod mesh;
mod mesh_rectangle;
mod mesh_refine;
pub mod new;
pub mod options;
mod outcome;
mod progress;
pub mod report;
pub mod resistance;
pub mod run;
pub mod scatter;
mod search;
pub mod sensitivity;
pub mod shell;
mod slurm;
pub mod study;
pub mod sweep;
pub mod threads;
mod uncertainty;
pub mod view;
mod watchdog;
pub mod words;

use std::error::Error;
use std::path::{Path, PathBuf};

use crate::deck::{self, Deck, Diagnostic, Diagnostics, Sources, untrusted};
use crate::job::JobError;
use crate::model::{self, DeckUnits, MaterialDefinition, Model};
use crate::output::drawing::Drawing;
use crate::output::{self, JobFiles};
use crate::plan::unit_warning;
use crate::report::QuantityLabels;
use crate::study::StudyError;
use crate::study::chart::Chart;
use crate::study::grid::SettingForm;
use crate::study::table::TextTable;
use crate::user::Routines;
use crate::user::compile::{Compiled, compile};
use clap::Args;
use words::print_err;

/// Commit of the source with its date (from `build.rs`); empty if it is not known.
const COMMIT: &str = env!("REVOLVE_COMMIT");

/// Exit status of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CommandStatus(pub u8);

impl CommandStatus {
    /// The command completed without errors.
    const SUCCESS: CommandStatus = CommandStatus(0);
    /// A run halted or some runs gave no result.
    const HALTED: CommandStatus = CommandStatus(1);
    /// The deck or the arguments are invalid.
    const REFUSED: CommandStatus = CommandStatus(2);
    /// The verdict of a run is worse than required.
    const DOUBTFUL: CommandStatus = CommandStatus(3);

    /// Returns the status of a command whose runs all completed, or did not.
    fn of(is_complete: bool) -> CommandStatus {
        if is_complete { CommandStatus::SUCCESS } else { CommandStatus::HALTED }
    }
}

/// Error of a command whose diagnostics have already been printed.
#[derive(Debug, thiserror::Error)]
#[error("invalid input")]
pub struct AlreadyPrinted;

/// Options for files of user subroutines.
#[derive(Args)]
pub struct UserFiles {
    /// User subroutines (VDLOAD, VUAMP, VDISP, VUMAT, VUANISOHYPER_INV, VUHARD, VUSDFLD, VUFIELD, VFRICTION, VUCHARLENGTH, VEXTERNALDB): a Fortran or C
    /// file or a shared library; can be repeated.
    #[arg(short = 'u', long = "user", value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// Compile the user subroutines with array bounds checks (slower).
    #[arg(long, requires = "files")]
    check_user: bool,
}

impl UserFiles {
    /// Compiles the files; returns `None` without files.
    pub fn compiled(&self, quiet: bool) -> Result<Option<Compiled>, AlreadyPrinted> {
        if self.files.is_empty() {
            return Ok(None);
        }
        if untrusted::is_restricted() {
            print_err!("error: --user: user subroutines are not run with --untrusted or {}", untrusted::VARIABLE);
            return Err(AlreadyPrinted);
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

    /// Compiles and loads the user subroutines into this process or, if `isolated`, into a separate process. Returns
    /// them with the hash that identifies them.
    pub fn routines(&self, quiet: bool, isolated: bool) -> Result<(Routines, String), Box<dyn Error>> {
        let Some(compiled) = self.compiled(quiet)? else { return Ok((Routines::none(), String::new())) };
        let opened = if isolated { compiled.open_isolated() } else { compiled.open() };
        Ok((opened?, compiled.identity()))
    }
}

/// Splits `--set NAME=VALUE` into name and value; several values and distributions are errors.
pub fn pairs(settings: &[String]) -> Result<Vec<(String, String)>, String> {
    let pair = |s: &String| {
        let (name, value) =
            s.split_once('=').ok_or_else(|| format!("--set {s}: expected NAME=VALUE, for example V=821"))?;
        match SettingForm::of(value) {
            SettingForm::Value => Ok((name.trim().to_owned(), value.trim().to_owned())),
            form => Err(format!("--set {s}: expected one value; {}", form.accepted_by())),
        }
    };
    settings.iter().map(pair).collect()
}

fn print_findings(found: &Diagnostics, sources: &Sources) {
    if found.is_empty() {
        return;
    }
    if words::is_coloured() {
        words::write_styled_error(found.render_styled(sources).trim_end());
    } else {
        print_err!("{}", found.render(sources).trim_end());
    }
}

/// Prints a warning for each material whose density and modulus belong to different unit systems (P119).
fn print_unit_warnings<'a>(
    materials: impl IntoIterator<Item = &'a MaterialDefinition>,
    units: Option<&DeckUnits>,
    sources: &Sources,
) {
    let warnings: Diagnostics = materials.into_iter().filter_map(|m| unit_warning(m, units)).collect();
    print_findings(&warnings, sources);
}

/// Prints the error of a command: a diagnostic with its code and help, or one line.
fn print_error(error: &(dyn Error + 'static)) {
    let finding = error
        .downcast_ref::<Diagnostic>()
        .or_else(|| error.downcast_ref::<Box<Diagnostic>>().map(|finding| &**finding))
        .or_else(|| match error.downcast_ref::<JobError>()? {
            JobError::Checkpoint(finding) => Some(&**finding),
            JobError::Folder(_) => None,
        });
    match finding {
        Some(finding) => print_findings(&Diagnostics::from_iter([finding.clone()]), &Sources::default()),
        None if error.is::<AlreadyPrinted>() => {}
        None => print_err!("error: {error}"),
    }
}

/// Returns the free disk space at the place of a folder that may not exist yet, in bytes.
fn free_space(folder: &Path) -> Option<u64> {
    let mut places = folder.ancestors().map(|place| if place.as_os_str().is_empty() { Path::new(".") } else { place });
    crate::platform::free_space(places.find(|place| place.is_dir())?)
}

/// Prints the diagnostics of a deck; `quiet` suppresses them if none is an error.
///
/// # Errors
/// If the diagnostics contain an error.
fn accept(diagnostics: &Diagnostics, sources: &Sources, quiet: bool) -> Result<(), AlreadyPrinted> {
    let errors = diagnostics.has_errors();
    if errors || !quiet {
        print_findings(diagnostics, sources);
    }
    if errors { Err(AlreadyPrinted) } else { Ok(()) }
}

/// Reads a deck and builds its model.
///
/// # Errors
/// If the deck has errors, which are printed.
fn read_model(path: &Path, settings: &[(String, String)]) -> Result<(Deck, Model), AlreadyPrinted> {
    let (deck, mut diagnostics) = deck::read(path, settings);
    let (model, findings) = model::build(&deck);
    diagnostics.append(findings);
    accept(&diagnostics, &deck.sources, true)?;
    Ok((deck, model))
}

/// Prints a table with aligned columns.
fn print_table(table: &TextTable) {
    words::write(format_args!("{}", table.terminal()), false);
}

/// File name suffix and contents of a result file.
type ResultFile = (String, Vec<u8>);

/// Writes a table, other files and charts (given with their file name suffix, drawn with labels) and a list of checksums.
/// Charts without points are omitted.
fn write_results(
    job: &JobFiles,
    name: &str,
    table: &TextTable,
    others: Vec<ResultFile>,
    charts: &[(String, Chart)],
    labels: &QuantityLabels,
) -> Result<(), Box<dyn Error>> {
    let mut files = vec![(format!("_{name}.csv"), table.csv().into_bytes())];
    files.extend(others);
    for (ending, chart) in charts.iter().filter(|(_, chart)| !chart.is_empty()) {
        let drawing = labels.applied(chart.clone()).drawing()?;
        let (svg, png) = (drawing.svg(), drawing.png()?);
        files.extend([(format!("_{name}{ending}.svg"), svg.into_bytes()), (format!("_{name}{ending}.png"), png)]);
    }
    Ok(output::write_with_sums(job, &files, &format!("_{name}.sfv"))?)
}

/// File format of a picture.
#[derive(Clone, Copy, PartialEq, Eq)]
enum PictureFormat {
    Svg,
    Png,
}

impl PictureFormat {
    /// Returns the format for a file name extension.
    fn of(path: &Path) -> Result<PictureFormat, String> {
        match path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).as_deref() {
            Some("svg") => Ok(PictureFormat::Svg),
            Some("png") => Ok(PictureFormat::Png),
            _ => Err(format!("{}: the file name of a picture must end in .png or .svg", path.display())),
        }
    }

    /// Encodes a drawing in this format.
    fn bytes(self, drawing: &Drawing) -> Result<Vec<u8>, String> {
        if self == PictureFormat::Svg { Ok(drawing.svg().into_bytes()) } else { drawing.png() }
    }
}

/// Returns the exit status of a command that only prints: failure if standard output could not be written.
fn output_status() -> CommandStatus {
    CommandStatus::of(words::output_succeeded())
}

/// Formats the parameters of a run, for example `V = 600, n = 20`.
fn settings_text<'a>(settings: impl Iterator<Item = (&'a str, &'a String)>) -> String {
    let each: Vec<String> = settings.map(|(name, value)| format!("{name} = {value}")).collect();
    each.join(", ")
}

/// Prints the warnings of runs with the parameters of each run.
fn print_run_warnings(runs: &[(String, &[String])]) {
    const SHOWN: usize = 12;
    let with_warnings: Vec<_> = runs.iter().filter(|(_, warnings)| !warnings.is_empty()).collect();
    for (given, warnings) in with_warnings.iter().take(SHOWN) {
        warnings.iter().for_each(|warning| print_err!("warning: {given}: {warning}"));
    }
    if with_warnings.len() > SHOWN {
        print_err!("warning: {} more runs have warnings", with_warnings.len() - SHOWN);
    }
}

/// Prints the number of runs or settings (`what`) without a result and the error of the first one. Returns the exit
/// status.
fn report_failures(failed: usize, total: usize, what: &str, first: Option<&StudyError>) -> CommandStatus {
    if let Some(reason) = first {
        print_err!("{failed} of {total} {what} gave no result; the first:\n{reason}");
    }
    CommandStatus::of(first.is_none())
}
