//! What produced a result: program, command, machine and input, and copies of all files that were read.

use std::collections::HashMap;
use std::io::{self, Read as _};
use std::path::{Component, Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use serde::{Deserialize, Serialize};

use super::PreparedJob;
use crate::deck::digest::sha256;
use crate::deck::{files, source};
use crate::output::sums::sum;
use crate::output::{INPUT, JobFiles, write_whole};
use crate::platform::processor_name;

/// Largest file that is copied, bytes; of larger ones only the hash is stored.
const LARGEST_COPY: u64 = 64 << 20;

/// Use of a file that a run has read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum InputKind {
    /// The deck.
    Deck,
    /// File that the deck includes, or data lines of a card.
    Include,
    /// Mesh file.
    Mesh,
    /// User subroutines.
    User,
}

/// A file that a run has read.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InputFile {
    /// Path as given, or relative to the folder of the deck.
    pub file: String,
    /// What the file is used for.
    pub kind: InputKind,
    /// SHA-256 of the contents.
    pub sha256: String,
    /// Size, bytes.
    pub bytes: u64,
    /// Name of the copy in `<job>.input.tar`; `None` for files above 64 MiB.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub copy: Option<String>,
    /// Contents until the copy is written.
    #[serde(skip)]
    contents: Vec<u8>,
}

/// What produced a result, part of `<job>.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Provenance {
    /// Commit of the source, its date, and `modified` for changed sources; `None` if it is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub commit: Option<String>,
    /// Operating system and architecture for which the program was built.
    pub target: String,
    /// Words of the command line after the name of the program; empty for runs from Rust and Python.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub command: Vec<String>,
    /// Absolute path of the deck; `None` for standard input and texts.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deck: Option<String>,
    /// Instant at which the run began, UTC.
    pub started: String,
    /// Instant at which the summary was written, UTC.
    pub ended: String,
    /// Name of the processor, if the operating system states it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub processor: Option<String>,
    /// Number of threads.
    pub threads: usize,
    /// The deck, then the files that it reads and those of user subroutines.
    pub input: Vec<InputFile>,
}

/// A file that a run reads.
struct ReadFile<'a> {
    kind: InputKind,
    path: &'a Path,
    /// The text that has been read; empty for files that are not part of the deck.
    text: &'a str,
}

impl Provenance {
    /// Returns what is known before a run, from texts that have not been released. `command` are the words of the command
    /// line, `user` the files of user subroutines.
    pub fn of(prepared: &PreparedJob, command: Vec<String>, user: &[PathBuf]) -> Provenance {
        let sources = prepared.deck.sources.files();
        let kinds = std::iter::once(InputKind::Deck).chain(std::iter::repeat(InputKind::Include));
        let texts = kinds.zip(sources).map(|(kind, file)| ReadFile { kind, path: &file.path, text: &file.text });
        let meshes = prepared.mesh_files.iter().map(|path| ReadFile { kind: InputKind::Mesh, path, text: "" });
        let all = texts.chain(meshes).chain(user.iter().map(|path| ReadFile { kind: InputKind::User, path, text: "" }));
        let folder = sources.first().and_then(|deck| deck.path.parent()).unwrap_or(Path::new(""));
        Provenance {
            commit: option_env!("REVOLVE_COMMIT").map(str::to_owned),
            target: format!("{}-{}", std::env::consts::OS, std::env::consts::ARCH),
            command,
            deck: deck_path(sources.first().map(|file| &*file.path)),
            started: now(),
            ended: String::new(),
            processor: processor_name(),
            threads: rayon::current_num_threads(),
            input: all.enumerate().map(|(at, file)| InputFile::of(&file, folder, at)).collect(),
        }
    }

    /// Writes the archive with the copies of the input to the folder of a job. Returns its checksum.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(super) fn write_copies(&mut self, job: &JobFiles) -> io::Result<u32> {
        let mut archive = tar::Builder::new(Vec::new());
        for file in &mut self.input {
            let contents = std::mem::take(&mut file.contents);
            let Some(name) = &file.copy else { continue };
            let mut header = tar::Header::new_gnu();
            header.set_size(contents.len() as u64);
            header.set_mode(0o644);
            archive.append_data(&mut header, name, &contents[..])?;
        }
        let bytes = archive.into_inner()?;
        write_whole(&job.path(INPUT), &bytes)?;
        Ok(sum(&bytes))
    }

    /// Sets the instant of the end.
    pub(super) fn end(&mut self) {
        self.ended = now();
    }
}

impl InputFile {
    /// Reads a file, number `at` of the input. A deck from standard input, or one that has changed since, has its text only.
    fn of(&ReadFile { kind, path, text }: &ReadFile<'_>, folder: &Path, at: usize) -> InputFile {
        let is_read = |bytes: &Vec<u8>| text.is_empty() || source::decode(bytes.clone()) == text;
        let contents = files::read(path).ok().filter(is_read).unwrap_or_else(|| text.as_bytes().to_vec());
        let inside = path.strip_prefix(folder).unwrap_or(path);
        let is_inside = inside.components().all(|part| matches!(part, Component::Normal(_)));
        let name = path.file_name().map_or("deck".into(), |name| name.to_string_lossy());
        let file = inside.to_string_lossy().replace('\\', "/");
        let copy = if is_inside { file.clone() } else { format!("outside/{at}/{name}") };
        let bytes = contents.len() as u64;
        let is_copied = bytes <= LARGEST_COPY;
        InputFile {
            file,
            kind,
            sha256: sha256(&contents),
            bytes,
            copy: is_copied.then_some(copy),
            contents: if is_copied { contents } else { Vec::new() },
        }
    }
}

/// Returns the origin of the results in one line, for files of results: program, deck with its SHA-256, and units. It does
/// not depend on the machine, nor on the instant of the run.
pub(super) fn origin(prepared: &PreparedJob, provenance: Option<&Provenance>) -> String {
    let mut parts = vec![format!("revolve {}", env!("CARGO_PKG_VERSION"))];
    if let Some(provenance) = provenance {
        parts.extend(provenance.commit.iter().map(|commit| format!("commit {commit}")));
        parts.extend(provenance.input.first().map(|deck| format!("deck {}, SHA-256 {}", deck.file, deck.sha256)));
    }
    parts.extend(prepared.units.as_ref().map(|units| format!("units {}", units.words())));
    parts.join("; ")
}

/// Returns the absolute path of a deck that is a file.
fn deck_path(path: Option<&Path>) -> Option<String> {
    let path = path.filter(|path| path.is_file())?;
    Some(std::path::absolute(path).ok()?.to_string_lossy().into_owned())
}

/// Returns the current instant as text.
fn now() -> String {
    utc(SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default().as_secs())
}

/// Returns an instant as text: `2026-11-29T20:15:00Z`. Dates follow from days since 1 March of year 0, in cycles of 400 years.
fn utc(seconds: u64) -> String {
    let (days, of_day) = (seconds / 86_400 + 719_468, seconds % 86_400);
    let (cycle, of_cycle) = (days / 146_097, days % 146_097);
    let year = (of_cycle - of_cycle / 1_460 + of_cycle / 36_524 - of_cycle / 146_096) / 365;
    let of_year = of_cycle - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    let [hour, minute, second] = [of_day / 3600, of_day / 60 % 60, of_day % 60];
    format!("{:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}Z", 400 * cycle + year + next)
}

/// Returns the contents of the copies in the archive of a job, by name.
///
/// # Errors
/// If the archive cannot be read.
pub fn read_copies(archive: &Path) -> io::Result<HashMap<String, Vec<u8>>> {
    let bytes = files::read(archive)?;
    let mut copies = HashMap::new();
    for entry in tar::Archive::new(&bytes[..]).entries()? {
        let mut entry = entry?;
        let name = entry.path()?.to_string_lossy().into_owned();
        let mut contents = Vec::new();
        entry.read_to_end(&mut contents)?;
        copies.insert(name, contents);
    }
    Ok(copies)
}

#[cfg(test)]
mod tests {
    use super::utc;

    /// From `date -u -d @N`.
    #[test]
    fn instants_are_dates() {
        let dates = [0, 951_782_400, 1_709_251_199, 4_107_542_399, 1_795_983_300].map(utc);
        let known = ["1970-01-01T00:00:00Z", "2000-02-29T00:00:00Z", "2024-02-29T23:59:59Z", "2100-02-28T23:59:59Z"];
        assert_eq!(dates[..4], known);
        assert_eq!(dates[4], "2026-11-29T20:15:00Z");
    }
}
