//! Fuzz targets: each is a function that reads bytes. The tests of the project compile them as well and run the corpus.
//! Shared by the targets: a folder in memory and a run of one increment.
#![allow(dead_code)] // Each target uses a part.

pub mod checkpoints;
pub mod decks;
pub mod meshes;
pub mod parameters;
pub mod references;
pub mod results;

use std::path::PathBuf;
use std::sync::atomic::AtomicUsize;

use revolve::job::PreparedJob;
use revolve::output::OutputFrame;
use revolve::solve::{self, CheckpointInterval, RunControl, Sink, SinkError, UnfitState};

/// Returns a folder of this process on a memory file system if there is one.
pub fn folder() -> PathBuf {
    let memory = PathBuf::from("/dev/shm");
    let parent = if memory.is_dir() { memory } else { std::env::temp_dir() };
    let folder = parent.join(format!("revolve-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// Sink that stores the first state.
#[derive(Default)]
pub struct FirstState(pub Vec<u8>);

impl Sink for FirstState {
    fn wants_frames(&self) -> bool {
        true
    }
    fn frame(&mut self, _: &OutputFrame) -> Result<(), SinkError> {
        Ok(())
    }
    fn row(&mut self, _: &solve::Instant, _: &[f64]) -> Result<(), SinkError> {
        Ok(())
    }
    fn keeps(&self) -> bool {
        self.0.is_empty()
    }
    fn keep(&mut self, state: &[u8], _: &solve::Instant) -> Result<(), SinkError> {
        self.0 = state.to_vec();
        Ok(())
    }
}

/// Runs one increment, from a given state if there is one. Returns the number of increments or the reason why the state
/// does not fit, and the resulting state.
pub fn one_increment(prepared: &PreparedJob, state: Option<&[u8]>) -> (Result<u64, UnfitState>, Vec<u8>) {
    let mut first = FirstState::default();
    let signal = AtomicUsize::new(15);
    let control = RunControl {
        every: Some(CheckpointInterval::Increments(1)),
        interrupt: Some(&signal),
        state,
        ..RunControl::default()
    };
    let outcome = solve::run_with(&prepared.plan, prepared.state.clone(), &mut first, control);
    (outcome.map(|(outcome, _)| outcome.increments), first.0)
}
