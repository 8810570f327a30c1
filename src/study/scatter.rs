//! `scatter`: quantities of a deck whose parameters are drawn from distributions, and which of them their scatter comes from.

use std::sync::atomic::AtomicUsize;

use super::StudyError;
use super::chart::{Chart, Form, Series};
use super::evaluate::{Evaluator, SampleFailure, Samples};
use super::inputs::RandomInputs;
use super::statistics::design::{Design, Sampling};
use super::statistics::indices::{Indices, indices};
use super::statistics::summary::histogram;

/// What is asked.
#[derive(Clone, Copy, Debug)]
pub struct ScatterRequest {
    pub sampling: Sampling,
    pub count: usize,
    pub seed: u64,
    /// Whether Sobol's indices are asked for: each point then stands for two runs more than there are parameters.
    pub indices: bool,
    pub threads: usize,
}

impl ScatterRequest {
    pub fn runs(&self, inputs: &RandomInputs) -> usize {
        if self.indices { inputs.names.len() + 2 } else { 1 }
    }
}

#[derive(Clone, Debug, Default)]
pub struct ScatterResults {
    /// Values of each quantity, one a point; not a number where there is none.
    pub values: Vec<Vec<f64>>,
    /// Where sets of points begin that are spread by themselves, and the end of the last.
    pub sets: Vec<usize>,
    /// Indices of each quantity, where they are asked for and it varies.
    pub indices: Vec<Option<Indices>>,
    /// How many runs gave nothing, and the first of them.
    pub failed: usize,
    /// Why the first gave nothing.
    pub reason: Option<StudyError>,
}

/// Points that are drawn, run and written at once.
const BLOCK: usize = 4096;

/// Runs all points; `keep` is given rows of parameters and quantities, `look` how many runs are done.
pub fn run(
    evaluator: &Evaluator,
    inputs: &RandomInputs,
    quantities: usize,
    asked: ScatterRequest,
    keep: &mut dyn FnMut(&[f64]) -> Result<(), StudyError>,
    look: &mut dyn FnMut(usize),
) -> Result<ScatterResults, StudyError> {
    let (width, runs) = (inputs.names.len(), asked.runs(inputs));
    let dimensions = if asked.indices { 2 * width } else { width };
    let design = Design::new(asked.sampling, dimensions, asked.count, asked.seed);
    let mut design = design.map_err(|why| StudyError::Setting(format!("--sampling: {why}")))?;
    let mut results = ScatterResults {
        values: vec![Vec::with_capacity(asked.count); quantities],
        sets: Design::sets(asked.sampling, asked.count),
        ..ScatterResults::default()
    };
    // What indices are made of: f at two points, and at the first with one parameter of the second.
    let mut mixed = vec![Vec::new(); if asked.indices { quantities } else { 0 }];
    let (mut done, mut row) = (0, Vec::new());
    while done < asked.count {
        let count = BLOCK.min(asked.count - done);
        let mut points = vec![0.0; dimensions * count];
        design.fill(&mut points);
        let samples = samples(inputs, &points, dimensions, runs);
        let mut table = vec![f64::NAN; quantities * runs * count];
        let asked_now = Samples { values: &samples, count: runs * count };
        let before = done * runs;
        let never = AtomicUsize::new(0);
        let failures = evaluator.run(asked_now, &mut table, asked.threads, &never, &mut |n| look(before + n))?;
        note(&mut results, failures);
        for (sample, found) in samples.chunks_exact(width * runs).zip(table.chunks_exact(quantities * runs)) {
            row.extend_from_slice(&sample[..width]);
            row.extend_from_slice(&found[..quantities]);
            for (of, values) in results.values.iter_mut().enumerate() {
                values.push(found[of]);
            }
            for (of, mixed) in mixed.iter_mut().enumerate() {
                mixed.extend(found.iter().skip(of).step_by(quantities));
            }
        }
        keep(&row)?;
        row.clear();
        done += count;
        look(done * runs);
    }
    results.indices = mixed.iter().map(|rows| indices(rows, width, asked.seed)).collect();
    Ok(results)
}

/// Parameters of all runs of some points.
fn samples(inputs: &RandomInputs, points: &[f64], dimensions: usize, runs: usize) -> Vec<f64> {
    let width = inputs.names.len();
    let mut samples = vec![0.0; points.len() / dimensions * runs * width];
    for (point, rows) in points.chunks_exact(dimensions).zip(samples.chunks_exact_mut(runs * width)) {
        let mut rows = rows.chunks_exact_mut(width);
        // The point itself, the other, and the point with each number of the other.
        for (run, row) in rows.by_ref().enumerate() {
            let from = |i: usize| if run == 1 || run == i + 2 { point[width + i] } else { point[i] };
            let at: Vec<f64> = (0..width).map(from).collect();
            inputs.values(&at, row);
        }
    }
    samples
}

fn note(results: &mut ScatterResults, failures: Vec<SampleFailure>) {
    results.failed += failures.len();
    if results.reason.is_none() {
        results.reason = failures.into_iter().next().map(|failure| failure.reason);
    }
}

/// How often each value came.
pub fn chart(title: &str, quantity: &str, values: &[f64]) -> Chart {
    let (edges, counts) = histogram(values);
    let steps = counts.iter().enumerate().flat_map(|(i, n)| [(edges[i], *n as f64), (edges[i + 1], *n as f64)]);
    Chart::new(title, [quantity, "samples"], vec![Series::new(quantity, Form::Area, steps.collect())])
}
