//! Checkpoints: files with a correct checksum, and states of any content and length. Changed values inside a state of
//! the correct length are detected by the checksum only (docs/SECURITY.md).
use std::sync::OnceLock;

use revolve::job::{self, PreparedJob};
use revolve::output::checkpoint::{Checkpoint, JobIdentity};
use revolve::user::Routines;
use sha2::{Digest as _, Sha256};

/// Bytes of the file head that precede the data of the checksum.
const HEAD: usize = 40;

struct CheckpointSample {
    prepared: PreparedJob,
    state: Vec<u8>,
    file: Vec<u8>,
}

fn scene() -> &'static CheckpointSample {
    static SCENE: OnceLock<CheckpointSample> = OnceLock::new();
    SCENE.get_or_init(|| {
        let deck = include_str!("../../../input/taylor_copper.inp");
        let few = [("nr".to_owned(), "2".to_owned()), ("nz".to_owned(), "4".to_owned())];
        let prepared = job::prepare_text("fuzz.inp", deck, &few, &Routines::none());
        assert!(!prepared.diagnostics.has_errors());
        let state = super::one_increment(&prepared, None).1;
        let path = super::folder().join("whole.checkpoint");
        whole(Vec::new()).write(&path, &state).expect("a file");
        CheckpointSample { prepared, state, file: std::fs::read(path).expect("bytes") }
    })
}

/// Returns a checkpoint with this state and otherwise arbitrary contents.
pub fn whole(state: Vec<u8>) -> Checkpoint {
    let identity = JobIdentity { deck: "d".into(), parameters: "p".into(), mesh: "m".into(), user: String::new() };
    let (version, shown) = (env!("CARGO_PKG_VERSION").to_owned(), vec![1, 2, 3]);
    Checkpoint { version, identity, shown, state, ..Default::default() }
}

/// Returns the bytes with replacements, each given as place (two bytes) and value.
fn changed(bytes: &[u8], changes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for change in changes.chunks_exact(3) {
        let at = usize::from(u16::from_le_bytes([change[0], change[1]])) % bytes.len().max(1);
        bytes[at] = change[2];
    }
    bytes
}

/// Reads the data as a checkpoint; must not panic, hang or use much memory.
pub fn read(data: &[u8]) {
    let Some((kind, rest)) = data.split_first() else { return };
    let scene = scene();
    match kind % 4 {
        0 => drop(super::one_increment(&scene.prepared, Some(rest))),
        // The first two bytes give the length of the kept part of the state; the rest is appended.
        1 if rest.len() > 2 => {
            let kept = usize::from(u16::from_le_bytes([rest[0], rest[1]])) % scene.state.len();
            let state = [&scene.state[..kept], &rest[2..]].concat();
            if state.len() != scene.state.len() {
                assert!(super::one_increment(&scene.prepared, Some(&state)).0.is_err(), "a state of another length");
            }
        }
        1 => {}
        which => {
            let mut bytes = if which == 2 { rest.to_vec() } else { changed(&scene.file, rest) };
            if bytes.len() > HEAD {
                let sum = Sha256::digest(&bytes[HEAD..]);
                bytes[8..HEAD].copy_from_slice(&sum);
            }
            let path = super::folder().join("job.checkpoint");
            std::fs::write(&path, &bytes).expect("a file");
            if let Ok(Some(checkpoint)) = Checkpoint::read(&path) {
                let _ = checkpoint.accept(&scene.prepared.identity(""));
            }
        }
    }
}
