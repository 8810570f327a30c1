//! What several tests share: scenes as text and a sink that keeps what a run shows.
#![allow(dead_code)]

use revolve::output::Frame;
use revolve::solve::Sink;

/// Keeps rows and frames in memory.
#[derive(Default)]
pub struct Memory {
    pub rows: Vec<(f64, Vec<f64>)>,
    pub frames: Vec<Frame>,
    pub with_frames: bool,
}

impl Sink for Memory {
    fn wants_frames(&self) -> bool {
        self.with_frames
    }
    fn frame(&mut self, frame: &Frame) -> Result<(), String> {
        self.frames.push(frame.clone());
        Ok(())
    }
    fn row(&mut self, time: f64, values: &[f64]) -> Result<(), String> {
        self.rows.push((time, values.to_vec()));
        Ok(())
    }
}
