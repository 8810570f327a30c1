//! The commands `revolve info`, which prints what produced a result, and `revolve rerun`, which produces it again.

use std::error::Error;
use std::io;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::Deserialize;

use super::line::{ProgramArguments, ProgramCommand};
use super::options::OutputOptions;
use super::words::{self, print_err, print_out};
use super::{CommandStatus, outcome};
use crate::deck::digest::sha256;
use crate::deck::files;
use crate::job::{InputFile, InputKind, Provenance, RunVerdict, read_copies};
use crate::output::columns::aligned_table;
use crate::output::{INPUT, write_whole};
use clap::Parser as _;

/// Show what produced a result: program, command, machine and input with hashes.
#[derive(Args)]
pub struct InfoCommand {
    /// Result folder, or a file in it, for example a frame.
    results: PathBuf,
    #[command(flatten)]
    output: OutputOptions,
}

/// Repeat a run from its result folder alone, and compare the digests. The exit status is 1 if they differ.
#[derive(Args)]
pub struct RerunCommand {
    /// Result folder, or a file in it.
    results: PathBuf,
    /// Folder for the input and the new results (default: <job>_rerun in the result folder).
    #[arg(short, long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

/// The parts of `<job>.json` that the commands use.
#[derive(Clone, Debug, Deserialize)]
struct RecordedRun {
    status: String,
    reason: Option<String>,
    digest: String,
    version: String,
    provenance: Provenance,
    #[serde(flatten)]
    verdict: RunVerdict,
}

/// A run in a result folder.
struct FoundRun {
    folder: PathBuf,
    job: String,
    run: RecordedRun,
}

/// Returns the runs in a folder, or the one to which a file belongs.
///
/// # Errors
/// If there is none with a record of what produced it.
fn find_runs(results: &Path) -> Result<Vec<FoundRun>, String> {
    let is_folder = results.is_dir();
    let folder = if is_folder { results } else { results.parent().unwrap_or(Path::new("")) };
    let listed = std::fs::read_dir(if folder.as_os_str().is_empty() { Path::new(".") } else { folder });
    let listed = listed.map_err(|error| format!("cannot read {}: {error}", folder.display()))?;
    let mut names: Vec<String> = listed
        .filter_map(|entry| Some(entry.ok()?.file_name().to_string_lossy().strip_suffix(".json")?.to_owned()))
        .collect();
    names.sort();
    if !is_folder {
        let file = last_part(&results.to_string_lossy());
        let longest = names.iter().filter(|name| file.starts_with(name.as_str())).max_by_key(|name| name.len());
        names = longest.cloned().into_iter().collect();
    }
    let read = |job: String| {
        let bytes = files::read(&folder.join(format!("{job}.json"))).ok()?;
        Some(FoundRun { folder: folder.to_owned(), run: serde_json::from_slice(&bytes).ok()?, job })
    };
    let runs: Vec<FoundRun> = names.into_iter().filter_map(read).collect();
    if runs.is_empty() {
        let place = results.display();
        return Err(format!("{place} has no summary (<job>.json) of `revolve run` that states what produced it"));
    }
    Ok(runs)
}

impl InfoCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        for FoundRun { job, run, .. } in find_runs(&self.results)? {
            let origin = &run.provenance;
            if self.output.json {
                self.output.print_json(origin)?;
                continue;
            }
            let commit = origin.commit.as_ref().map_or(String::new(), |commit| format!(", commit {commit}"));
            let machine = origin.processor.as_deref().unwrap_or(&origin.target);
            print_out!("{job}: {}, digest {}", run.status, run.digest);
            outcome::print_verdict(&run.verdict);
            print_out!("program  revolve {}{commit}, {}", run.version, origin.target);
            print_out!("command  revolve {}", origin.command.join(" "));
            print_out!("time     {} to {}", origin.started, origin.ended);
            print_out!("machine  {machine}, {} threads", origin.threads);
            let rows: Vec<Vec<String>> = origin.input.iter().map(row).collect();
            words::write(format_args!("{}", aligned_table(&["input", "file", "bytes", "sha256"], &rows, false)), false);
            for name in changed_files(origin) {
                print_out!("stale: {name} has changed since the run, so the results belong to its former contents");
            }
        }
        Ok(CommandStatus::SUCCESS)
    }
}

/// Returns the files of the deck that exist and no longer have the contents that the run has read.
fn changed_files(origin: &Provenance) -> Vec<String> {
    let Some(deck) = origin.deck.as_ref().map(Path::new) else { return Vec::new() };
    let folder = deck.parent().unwrap_or(Path::new(""));
    let changed = |file: &&InputFile| {
        let place = if file.kind == InputKind::Deck { deck.to_owned() } else { folder.join(&file.file) };
        files::read(&place).is_ok_and(|contents| sha256(&contents) != file.sha256)
    };
    let of_deck = origin.input.iter().filter(|file| file.kind != InputKind::User);
    of_deck.filter(changed).map(|file| file.file.clone()).collect()
}

fn row(file: &InputFile) -> Vec<String> {
    let kind = format!("{:?}", file.kind).to_lowercase();
    vec![kind, file.file.clone(), file.bytes.to_string(), file.sha256.clone()]
}

/// Returns the name of a file without its folders.
fn last_part(path: &str) -> String {
    Path::new(path).file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned())
}

/// Files of a run that have been put in place again.
struct RestoredInput {
    deck: PathBuf,
    user: Vec<PathBuf>,
}

impl FoundRun {
    /// Writes the copies of the input below a folder, with the relative places that the deck expects.
    ///
    /// # Errors
    /// If a file has no copy and is not where it was, or does not have the hash of the run.
    fn restore(&self, folder: &Path) -> Result<RestoredInput, Box<dyn Error>> {
        let upward =
            |file: &InputFile| Path::new(&file.file).components().filter(|part| part.as_os_str() == "..").count();
        let input = &self.run.provenance.input;
        let depth = input.iter().map(upward).max().unwrap_or(0);
        let base = (0..depth).fold(folder.to_owned(), |base, level| base.join(format!("level{level}")));
        let cannot = |path: &Path, error: io::Error| format!("cannot write {}: {error}", path.display());
        std::fs::create_dir_all(&base).map_err(|error| cannot(&base, error))?;
        let copies = read_copies(&self.folder.join(format!("{}{INPUT}", self.job)))?;
        let mut restored = RestoredInput { deck: PathBuf::new(), user: Vec::new() };
        for (at, file) in input.iter().enumerate() {
            let is_user = file.kind == InputKind::User;
            let place = match is_user {
                true => folder.join("user").join(format!("{at}_{}", last_part(&file.file))),
                false => base.join(&file.file),
            };
            // A deck names other files by paths; joined to a folder, an absolute path remains what it is.
            let is_elsewhere = !is_user && Path::new(&file.file).is_absolute();
            let copy = file.copy.as_ref().and_then(|name| copies.get(name)).filter(|_| !is_elsewhere);
            let contents = match copy {
                Some(copy) => copy.clone(),
                None => {
                    files::read(Path::new(&file.file)).map_err(|error| format!("cannot read {}: {error}", file.file))?
                }
            };
            if sha256(&contents) != file.sha256 {
                return Err(format!("{} is not the file that the run has read", file.file).into());
            }
            if !is_elsewhere {
                let parent = place.parent().unwrap_or(folder);
                std::fs::create_dir_all(parent).map_err(|error| cannot(parent, error))?;
                write_whole(&place, &contents).map_err(|error| error.to_string())?;
            }
            match file.kind {
                InputKind::Deck => restored.deck = place,
                InputKind::User => restored.user.push(place),
                InputKind::Include | InputKind::Mesh => {}
            }
        }
        Ok(restored)
    }

    /// Repeats the run and returns it.
    fn repeat(&self, out: &Path) -> Result<RecordedRun, Box<dyn Error>> {
        let restored = self.restore(&out.join("input"))?;
        let words = self.run.provenance.command.clone();
        if words.is_empty() {
            return Err("the run has no command line: it was started from Python or Rust".into());
        }
        let line = std::iter::once("revolve").chain(words.iter().map(String::as_str));
        let ProgramCommand::Run(command) = ProgramArguments::try_parse_from(line)?.command else {
            return Err("only runs of `revolve run` can be repeated".into());
        };
        command.moved(words, (restored.deck, out.to_owned()), restored.user).execute()?;
        let run = find_runs(out)?.into_iter().next().ok_or("the run has no summary")?;
        Ok(run.run)
    }
}

impl RerunCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let runs = find_runs(&self.results)?;
        let [found] = &runs[..] else {
            let names: Vec<String> = runs.iter().map(|run| format!("{}.json", run.job)).collect();
            return Err(format!("several runs are in the folder; name one: {}", names.join(", ")).into());
        };
        if found.run.reason.as_ref().is_some_and(|reason| reason.starts_with("R207")) {
            return Err("the run was interrupted (R207); continue it with `revolve run --resume`".into());
        }
        let out = self.out.unwrap_or_else(|| found.folder.join(format!("{}_rerun", found.job)));
        let place = |path: &Path| path.canonicalize().ok();
        if place(&out).is_some() && place(&out) == place(&found.folder) {
            return Err("the results would be replaced; choose another folder with --out".into());
        }
        let repeated = found.repeat(&out)?;
        let is_same = repeated.digest == found.run.digest;
        print_out!("rerun: the digest is {}", if is_same { "that of the run" } else { "another one" });
        // After a file that could not be written, the new folder is incomplete.
        let ends_alike = repeated.status == found.run.status;
        if !ends_alike {
            print_err!("rerun: the run is {}, the new one {}", found.run.status, repeated.status);
        }
        Ok(CommandStatus::of(is_same && ends_alike))
    }
}
