//! Checkpoint file `<job>.checkpoint`: the state of a run, and the data that identify its job. It is written
//! atomically, with a checksum.
//!
//! Contents: magic bytes and format number, SHA-256 of the rest, version of the program, [`JobIdentity`], current
//! instant, data of the job, state of the run. The last two are preceded by their length.

use std::io;
use std::path::Path;

use sha2::{Digest as _, Sha256};

use super::write_durable;
pub use revolve_diagnostics::digest::hash;
use revolve_diagnostics::digest::hexadecimal;
use revolve_diagnostics::{Diagnostic, files};
use revolve_numerics::state::Instant;
use revolve_numerics::state::archive::{Persist, StateArchive, persist_fields};

/// Suffix of the file.
pub const CHECKPOINT: &str = ".checkpoint";
/// The last byte is the number of the format.
const MAGIC: [u8; 8] = *b"REVOLVE\x0b";
const SUM: usize = 32;

/// Identity of the job that a state belongs to. Each part is a hexadecimal hash, or the data itself.
#[derive(Clone, Debug, Default, PartialEq, Persist)]
pub struct JobIdentity {
    /// Text of the deck and of the files that it includes.
    pub deck: String,
    /// Values of `*PARAMETER`, `--set` included.
    pub parameters: String,
    /// Nodes and elements, which may come from mesh files.
    pub mesh: String,
    /// User subroutines; empty without any.
    pub user: String,
}

/// Contents of a checkpoint file.
#[derive(Clone, Debug, Default, PartialEq, Persist)]
#[persist(blob: shown, state)]
pub struct Checkpoint {
    /// Version of the program that wrote it.
    pub version: String,
    /// Hashes of the deck, mesh and subroutines; they must match those of the run that continues.
    pub identity: JobIdentity,
    /// Step, time and increment of the saved state.
    pub now: Instant,
    /// Output of the job so far.
    pub shown: Vec<u8>,
    /// State of the solver, in the format of the state archive.
    pub state: Vec<u8>,
}

/// Returns the hexadecimal SHA-256 of coordinates and node lists of elements.
pub fn hash_mesh<'a>(points: &[[f64; 2]], elements: impl IntoIterator<Item = &'a [usize]>) -> String {
    let mut hash = Sha256::new();
    hash.update((points.len() as u64).to_le_bytes());
    points.iter().flatten().for_each(|x| hash.update(x.to_le_bytes()));
    for nodes in elements {
        hash.update((nodes.len() as u64).to_le_bytes());
        nodes.iter().for_each(|node| hash.update((*node as u64).to_le_bytes()));
    }
    hexadecimal(hash)
}

impl Checkpoint {
    /// Writes the file with the given state, without copying the state, and waits until the file is on the disk. The field
    /// `state` is not used.
    ///
    /// # Errors
    /// If it cannot be written; the message contains the path.
    pub fn write(&mut self, path: &Path, state: &[u8]) -> io::Result<()> {
        let mut head = Vec::new();
        let mut archive = StateArchive::writer(&mut head);
        let Checkpoint { version, identity, now, shown, state: _ } = self;
        persist_fields!(&mut archive; version, identity, now);
        archive.blob(shown);
        state.len().persist(&mut archive);
        let mut hash = Sha256::new();
        hash.update(&head);
        hash.update(state);
        write_durable(path, &[&MAGIC, &hash.finalize(), &head, state])
    }

    /// Reads a file; `None` if it does not exist.
    ///
    /// # Errors
    /// K001 if it is damaged, K002 if another version wrote it.
    pub fn read(path: &Path) -> Result<Option<Checkpoint>, Diagnostic> {
        let damaged = |why: &str| {
            let message = format!("the checkpoint {} is damaged: {why}", path.display());
            Diagnostic::error("K001", message).help("run without --resume to start from the beginning")
        };
        let bytes = match files::read(path) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(damaged(&e.to_string())),
        };
        let Some((magic, rest)) = bytes.split_first_chunk::<8>() else { return Err(damaged("it is incomplete")) };
        if magic[..7] != MAGIC[..7] {
            return Err(damaged("it is not a checkpoint file"));
        }
        if magic != &MAGIC {
            return Err(other_version(path, &format!("its format is {}, this program uses {}", magic[7], MAGIC[7])));
        }
        let Some((sum, body)) = rest.split_at_checked(SUM) else { return Err(damaged("it is incomplete")) };
        if Sha256::digest(body)[..] != *sum {
            return Err(damaged("its checksum does not match its content"));
        }
        let mut checkpoint = Checkpoint::default();
        let mut archive = StateArchive::reader(body);
        checkpoint.persist(&mut archive);
        archive.finish().map_err(|why| damaged(&why.reason))?;
        if checkpoint.version != env!("CARGO_PKG_VERSION") {
            let versions =
                format!("its version is {}, this program is {}", checkpoint.version, env!("CARGO_PKG_VERSION"));
            return Err(other_version(path, &versions));
        }
        Ok(Some(checkpoint))
    }

    /// Checks that the state belongs to this job.
    ///
    /// # Errors
    /// K003 to K005, with the part that differs.
    pub fn accept(&self, identity: &JobIdentity) -> Result<(), Diagnostic> {
        let JobIdentity { deck, parameters, mesh, user } = &self.identity;
        let refused = |code, what: String| {
            Err(Diagnostic::error(code, what)
                .help("run without --resume to start from the beginning, or restore the input of the checkpoint"))
        };
        if *parameters != identity.parameters {
            let what = differences(parameters, &identity.parameters);
            return refused("K004", format!("the checkpoint belongs to a run with different parameters: {what}"));
        }
        if *deck != identity.deck {
            return refused(
                "K003",
                "the checkpoint belongs to a different deck: its text, or that of an included file, has changed".into(),
            );
        }
        if *mesh != identity.mesh {
            return refused(
                "K003",
                "the checkpoint belongs to a different mesh: nodes or elements have changed".into(),
            );
        }
        if *user != identity.user {
            let why = match (user.is_empty(), identity.user.is_empty()) {
                (false, true) => "it was run with --user files, this run has none",
                (true, false) => "it was run without --user files",
                _ => "the sources, compiler or its flags have changed",
            };
            return refused("K005", format!("the checkpoint belongs to a run with different user subroutines: {why}"));
        }
        Ok(())
    }
}

/// Returns the first few parameters that differ.
fn differences(there: &str, here: &str) -> String {
    let [there, here]: [Vec<&str>; 2] = [there, here].map(|list| list.split(", ").filter(|p| !p.is_empty()).collect());
    let only = |list: &[&str], other: &[&str]| {
        let different: Vec<_> = list.iter().filter(|p| !other.contains(p)).copied().collect();
        let more = if different.len() > 4 { ", …" } else { "" };
        if different.is_empty() { "nothing".into() } else { different[..different.len().min(4)].join(", ") + more }
    };
    format!("{} in the checkpoint, {} in this run", only(&there, &here), only(&here, &there))
}

fn other_version(path: &Path, versions: &str) -> Diagnostic {
    let message =
        format!("the checkpoint {} was written by a different version of the program: {versions}", path.display());
    Diagnostic::error("K002", message)
        .help("continue with that version, or run without --resume to start from the beginning")
}

#[cfg(test)]
mod tests {
    use super::{Checkpoint, JobIdentity};

    #[test]
    fn truncated_and_modified_files_are_detected() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.checkpoint");
        assert_eq!(Checkpoint::read(&path).expect("nothing is there"), None);
        let identity = JobIdentity { deck: "d".into(), parameters: "V = 600".into(), ..JobIdentity::default() };
        let version = env!("CARGO_PKG_VERSION").to_owned();
        let mut checkpoint = Checkpoint { version, identity, state: vec![1, 2, 3], ..Checkpoint::default() };
        checkpoint.write(&path, &[1, 2, 3]).expect("written");
        assert_eq!(Checkpoint::read(&path).expect("whole"), Some(checkpoint.clone()));
        let bytes = std::fs::read(&path).expect("bytes");
        for at in 0..bytes.len() {
            std::fs::write(&path, &bytes[..at]).expect("cut");
            assert_eq!(Checkpoint::read(&path).expect_err("cut").code, "K001", "{at}");
            let mut flipped = bytes.clone();
            flipped[at] ^= 1;
            std::fs::write(&path, &flipped).expect("flipped");
            let expected = if at == 7 { "K002" } else { "K001" };
            assert_eq!(Checkpoint::read(&path).expect_err("flipped").code, expected, "{at}");
        }
        checkpoint.version = "0.0.0".into();
        checkpoint.write(&path, &[]).expect("written");
        assert_eq!(Checkpoint::read(&path).expect_err("old").code, "K002");
    }

    #[test]
    fn differences_from_the_checkpoint_are_named() {
        let identity = JobIdentity { deck: "d".into(), parameters: "V = 600".into(), ..JobIdentity::default() };
        let checkpoint = Checkpoint { identity: identity.clone(), ..Checkpoint::default() };
        assert!(checkpoint.accept(&identity).is_ok());
        let code = |other: JobIdentity| checkpoint.accept(&other).expect_err("another").code;
        assert_eq!(code(JobIdentity { deck: "e".into(), ..identity.clone() }), "K003");
        assert_eq!(code(JobIdentity { mesh: "m".into(), ..identity.clone() }), "K003");
        assert_eq!(code(JobIdentity { parameters: "V = 700".into(), ..identity.clone() }), "K004");
        assert_eq!(
            super::differences("a = 1.0, b = 2.0", "a = 1.0, b = 3.0"),
            "b = 2.0 in the checkpoint, b = 3.0 in this run"
        );
        assert_eq!(super::differences("", "b = 3.0"), "nothing in the checkpoint, b = 3.0 in this run");
        assert_eq!(code(JobIdentity { user: "u".into(), ..identity.clone() }), "K005");
    }
}
