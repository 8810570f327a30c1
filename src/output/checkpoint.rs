//! `<job>.checkpoint`: the state of a run with all that tells whether it is the right one. Whole or not at all, with a
//! checksum. Never here: what the state consists of.
//!
//! Magic and format number, SHA-256 of all that follows, the program's version, whose state it is ([`Identity`]), where the
//! clock stands, then the job's own part and the state of the run, each with its length.

use std::io;
use std::path::Path;

use hmac_sha256::Hash;

use super::write_durable;
use crate::deck::{Diagnostic, files};
use crate::state::Instant;
use crate::state::archive::{Archive, Persist, persist_fields, persist_struct};

/// Ending of the file.
pub const CHECKPOINT: &str = ".checkpoint";
/// The last byte counts the layouts that there have been.
const MAGIC: [u8; 8] = *b"REVOLVE\x06";
const SUM: usize = 32;

/// Whose state it is. Each part is a hash in hexadecimal, or the thing itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Identity {
    /// Texts of the deck and what it includes.
    pub deck: String,
    /// `*PARAMETER` values in force, `--set` included.
    pub parameters: String,
    /// Nodes and elements, which may come from mesh files.
    pub mesh: String,
    /// The user's routines; empty without any.
    pub user: String,
    /// Precision that was asked for.
    pub precision: String,
}

/// What a file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Checkpoint {
    /// The program that wrote it.
    pub version: String,
    /// Whose state it is.
    pub identity: Identity,
    /// Where the clock stands.
    pub now: Instant,
    /// Of the job: what has been shown.
    pub shown: Vec<u8>,
    /// Of the run.
    pub state: Vec<u8>,
}

/// SHA-256 of pieces, each with its length, in hexadecimal.
pub fn hash<'a>(pieces: impl IntoIterator<Item = &'a [u8]>) -> String {
    let mut hash = Hash::new();
    for piece in pieces {
        hash.update((piece.len() as u64).to_le_bytes());
        hash.update(piece);
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

persist_struct!(Identity { deck, parameters, mesh, user, precision });

impl Persist for Checkpoint {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Checkpoint { version, identity, now, shown, state } = self;
        persist_fields!(archive; version, identity, now);
        archive.blob(shown);
        archive.blob(state);
    }
}

impl Checkpoint {
    /// Writes the file and waits until the disk has it.
    ///
    /// # Errors
    /// With the path in the message.
    pub fn write(&mut self, path: &Path) -> io::Result<()> {
        let mut bytes = Vec::with_capacity(self.state.len() + self.shown.len() + 1024);
        bytes.extend(MAGIC);
        bytes.extend([0; SUM]);
        self.persist(&mut Archive::writer(&mut bytes));
        let sum = Hash::hash(&bytes[MAGIC.len() + SUM..]);
        bytes[MAGIC.len()..MAGIC.len() + SUM].copy_from_slice(&sum);
        write_durable(path, &bytes)
    }

    /// Reads a file; `None` if there is none.
    ///
    /// # Errors
    /// K001 if it is damaged, K002 if another version has written it.
    pub fn read(path: &Path) -> Result<Option<Checkpoint>, Diagnostic> {
        let damaged = |why: &str| {
            let message = format!("the checkpoint {} is damaged: {why}", path.display());
            Diagnostic::error("K001", message).help("run without --resume to start anew")
        };
        let bytes = match files::read(path) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(damaged(&e.to_string())),
        };
        let Some((magic, rest)) = bytes.split_first_chunk::<8>() else { return Err(damaged("it ends too early")) };
        if magic[..7] != MAGIC[..7] {
            return Err(damaged("it does not begin as checkpoints do"));
        }
        if magic != &MAGIC {
            return Err(other_version(path, &format!("layout {}, this program has {}", magic[7], MAGIC[7])));
        }
        let Some((sum, body)) = rest.split_at_checked(SUM) else { return Err(damaged("it ends too early")) };
        if Hash::hash(body)[..] != *sum {
            return Err(damaged("its checksum is not that of its content"));
        }
        let mut checkpoint = Checkpoint::default();
        let mut archive = Archive::reader(body);
        checkpoint.persist(&mut archive);
        archive.finish().map_err(|why| damaged(&why.reason))?;
        if checkpoint.version != env!("CARGO_PKG_VERSION") {
            let versions = format!("version {}, this is {}", checkpoint.version, env!("CARGO_PKG_VERSION"));
            return Err(other_version(path, &versions));
        }
        Ok(Some(checkpoint))
    }

    /// Whether it is a state of this job.
    ///
    /// # Errors
    /// K003 to K005 and K010: what is another.
    pub fn accept(&self, identity: &Identity) -> Result<(), Diagnostic> {
        let Identity { deck, parameters, mesh, user, precision } = &self.identity;
        let refused = |code, what: String| {
            Err(Diagnostic::error(code, what).help("run without --resume to start anew, or give what the run had"))
        };
        if *parameters != identity.parameters {
            let what = differences(parameters, &identity.parameters);
            return refused("K004", format!("the checkpoint is of a run with other parameters: {what}"));
        }
        if *deck != identity.deck {
            return refused(
                "K003",
                "the checkpoint is of another deck: its text, or that of a file it includes, has changed".into(),
            );
        }
        if *mesh != identity.mesh {
            return refused("K003", "the checkpoint is of another mesh: nodes or elements have changed".into());
        }
        if *user != identity.user {
            let why = match (user.is_empty(), identity.user.is_empty()) {
                (false, true) => "it had --user files",
                (true, false) => "it had no --user files",
                _ => "sources, flags or compiler have changed",
            };
            return refused("K005", format!("the checkpoint is of a run with other routines of the user: {why}"));
        }
        if *precision != identity.precision {
            let what = format!(
                "the checkpoint is of a run in {precision} precision, and this one is in {}",
                identity.precision
            );
            return refused("K010", what);
        }
        Ok(())
    }
}

/// The first few parameters that differ.
fn differences(there: &str, here: &str) -> String {
    let [there, here]: [Vec<&str>; 2] = [there, here].map(|list| list.split(", ").filter(|p| !p.is_empty()).collect());
    let only = |list: &[&str], other: &[&str]| {
        let different: Vec<_> = list.iter().filter(|p| !other.contains(p)).copied().collect();
        let more = if different.len() > 4 { ", …" } else { "" };
        if different.is_empty() { "nothing".into() } else { different[..different.len().min(4)].join(", ") + more }
    };
    format!("{} there, {} here", only(&there, &here), only(&here, &there))
}

fn other_version(path: &Path, versions: &str) -> Diagnostic {
    let message = format!("the checkpoint {} is of another version of the program: {versions}", path.display());
    Diagnostic::error("K002", message).help("go on with that version, or run without --resume to start anew")
}

#[cfg(test)]
mod tests {
    use super::{Checkpoint, Identity};

    #[test]
    fn every_cut_and_every_flipped_byte_is_found() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.checkpoint");
        assert_eq!(Checkpoint::read(&path).expect("nothing is there"), None);
        let identity = Identity { deck: "d".into(), parameters: "V = 600".into(), ..Identity::default() };
        let version = env!("CARGO_PKG_VERSION").to_owned();
        let mut checkpoint = Checkpoint { version, identity, state: vec![1, 2, 3], ..Checkpoint::default() };
        checkpoint.write(&path).expect("written");
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
        checkpoint.write(&path).expect("written");
        assert_eq!(Checkpoint::read(&path).expect_err("old").code, "K002");
    }

    #[test]
    fn what_is_another_is_named() {
        let identity = Identity { deck: "d".into(), parameters: "V = 600".into(), ..Identity::default() };
        let checkpoint = Checkpoint { identity: identity.clone(), ..Checkpoint::default() };
        assert!(checkpoint.accept(&identity).is_ok());
        let code = |other: Identity| checkpoint.accept(&other).expect_err("another").code;
        assert_eq!(code(Identity { deck: "e".into(), ..identity.clone() }), "K003");
        assert_eq!(code(Identity { mesh: "m".into(), ..identity.clone() }), "K003");
        assert_eq!(code(Identity { parameters: "V = 700".into(), ..identity.clone() }), "K004");
        assert_eq!(super::differences("a = 1.0, b = 2.0", "a = 1.0, b = 3.0"), "b = 2.0 there, b = 3.0 here");
        assert_eq!(super::differences("", "b = 3.0"), "nothing there, b = 3.0 here");
        assert_eq!(code(Identity { user: "u".into(), ..identity.clone() }), "K005");
        assert_eq!(code(Identity { precision: "single".into(), ..identity.clone() }), "K010");
    }
}
