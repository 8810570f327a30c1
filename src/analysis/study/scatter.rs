//! `scatter`: Monte Carlo study of quantities for random parameters, with Sobol indices.

use std::sync::atomic::AtomicUsize;

use super::StudyError;
use super::chart::{Chart, ChartSeries, SeriesForm};
use super::evaluate::{SampleEvaluator, SampleFailure, SampleTable};
use super::inputs::RandomInputs;
use super::statistics::design::{SampleDesign, SamplingScheme};
use super::statistics::indices::{SobolIndices, indices};
use super::statistics::summary::histogram;

/// Options of a Monte Carlo study.
#[derive(Clone, Copy, Debug)]
pub struct ScatterRequest {
    pub sampling: SamplingScheme,
    pub count: usize,
    pub seed: u64,
    /// Whether Sobol indices are computed; each point then needs two runs more than there are parameters.
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
    /// Values of each quantity, one per point; NaN if the run failed.
    pub values: Vec<Vec<f64>>,
    /// Start index of each independent set of points, followed by the end of the last set.
    pub sets: Vec<usize>,
    /// Sobol indices of each quantity; `None` for a constant quantity.
    pub indices: Vec<Option<SobolIndices>>,
    /// Number of failed runs.
    pub failed: usize,
    /// Error of the first failed run.
    pub reason: Option<StudyError>,
}

/// Number of points that are drawn, run and written at a time.
const BLOCK: usize = 4096;

/// Runs all points. `keep` receives rows of parameters and quantities, `look` the number of finished runs.
pub fn run(
    evaluator: &SampleEvaluator,
    inputs: &RandomInputs,
    quantities: usize,
    request: ScatterRequest,
    keep: &mut dyn FnMut(&[f64]) -> Result<(), StudyError>,
    look: &mut dyn FnMut(usize),
) -> Result<ScatterResults, StudyError> {
    let (width, runs) = (inputs.names.len(), request.runs(inputs));
    let dimensions = if request.indices { 2 * width } else { width };
    let design = SampleDesign::new(request.sampling, dimensions, request.count, request.seed);
    let mut design = design.map_err(|why| StudyError::Setting(format!("--sampling: {why}")))?;
    let mut results = ScatterResults {
        values: vec![Vec::with_capacity(request.count); quantities],
        sets: SampleDesign::sets(request.sampling, request.count),
        ..ScatterResults::default()
    };
    // Data of the Sobol indices: f at two points A and B, and at A with one parameter replaced by that of B.
    let mut mixed = vec![Vec::new(); if request.indices { quantities } else { 0 }];
    let (mut finished, mut row) = (0, Vec::new());
    while finished < request.count {
        let count = BLOCK.min(request.count - finished);
        let mut points = vec![0.0; dimensions * count];
        design.fill(&mut points);
        let samples = samples(inputs, &points, dimensions, runs);
        let mut table = vec![f64::NAN; quantities * runs * count];
        let block = SampleTable { values: &samples, count: runs * count };
        let finished_runs = finished * runs;
        let never = AtomicUsize::new(0);
        let failures = evaluator.run(block, &mut table, request.threads, &never, &mut |n| look(finished_runs + n))?;
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
        finished += count;
        look(finished * runs);
    }
    results.indices = mixed.iter().map(|rows| indices(rows, width, request.seed)).collect();
    Ok(results)
}

/// Returns the parameters of all runs of some points.
fn samples(inputs: &RandomInputs, points: &[f64], dimensions: usize, runs: usize) -> Vec<f64> {
    let width = inputs.names.len();
    let mut samples = vec![0.0; points.len() / dimensions * runs * width];
    for (point, rows) in points.chunks_exact(dimensions).zip(samples.chunks_exact_mut(runs * width)) {
        let mut rows = rows.chunks_exact_mut(width);
        // A, B, and A with one coordinate of B.
        for (run, row) in rows.by_ref().enumerate() {
            let from = |i: usize| if run == 1 || run == i + 2 { point[width + i] } else { point[i] };
            let coordinates: Vec<f64> = (0..width).map(from).collect();
            inputs.values(&coordinates, row);
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

/// Returns the histogram of a quantity.
pub fn chart(title: &str, quantity: &str, values: &[f64]) -> Chart {
    let (edges, counts) = histogram(values);
    let steps = counts.iter().enumerate().flat_map(|(i, n)| [(edges[i], *n as f64), (edges[i + 1], *n as f64)]);
    Chart::new(title, [quantity, "samples"], vec![ChartSeries::new(quantity, SeriesForm::Area, steps.collect())])
}
