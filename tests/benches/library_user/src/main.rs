//! Runs the copper bar of 2000 elements on one thread without files.

use std::path::Path;

use revolve::job;
use revolve::solve::{self, Sink, SinkError};
use revolve::user::Routines;

struct DiscardingSink;

impl Sink for DiscardingSink {
    fn row(&mut self, _now: &solve::Instant, _values: &[f64]) -> Result<(), SinkError> {
        Ok(())
    }
}

fn main() {
    let overrides = [("nr".to_owned(), "20".to_owned()), ("nz".to_owned(), "100".to_owned())];
    let prepared = job::prepare(Path::new("input/taylor_copper.inp"), &overrides, &Routines::none());
    let (outcome, _) = solve::run(&prepared.plan, prepared.state, &mut DiscardingSink);
    assert!(outcome.halt.is_none());
    println!("{} increments", outcome.increments);
}
