//! Companion runs of an error map, and the shares that follow from them.

use rayon::prelude::*;

use super::base::{ElementMarks, MapBase};
use super::divide::{LEAST_ELEMENTS, patches};
use super::regions::MeshRegion;
use super::{ErrorMap, FactorSource, RegionShare, bounds};
use crate::model::{self, Mesh, Model};
use crate::study::StudyError;
use crate::study::price::setting;
use crate::study::refinement::RefinementStudy;
use crate::study::richardson::{CREDIBLE, FORMAL_ORDER};
use crate::study::runner::{StudyRun, StudyRunner};
use crate::study::settings::{StudyAxis, StudyParameter, deforms, edit};

/// Smallest, default and largest number of regions.
pub const REGIONS: [usize; 3] = [8, 12, 32];
/// Smallest number of elements of a mesh that is divided into enough regions.
pub const LEAST_MESH: usize = REGIONS[0] * LEAST_ELEMENTS;
/// Largest cost of the companion runs relative to the uniform study, by which the number of regions and the runs that refine
/// all other regions are chosen.
const LARGEST_COST: f64 = 2.0;

/// An error map and the mesh that is divided into regions.
pub struct ErrorMapRun {
    /// The map.
    pub map: ErrorMap,
    /// Undeformed mesh of the coarsest level.
    pub mesh: Mesh,
    /// Indices of the elements of each region in this mesh.
    pub patches: Vec<Vec<usize>>,
}

/// Measures the share of each region of the coarsest mesh of a study in the error of its quantity. `count` is the number
/// of regions; by default it follows from the cost.
///
/// # Errors
/// If the study has no series of one refined parameter with an estimate, if the quantity is no number, or if the
/// coarsest level cannot be read again.
pub fn measure(
    bench: &StudyRunner<'_>,
    axes: &[StudyAxis],
    study: &RefinementStudy,
    count: Option<usize>,
) -> Result<ErrorMapRun, StudyError> {
    let wrong = |why: &str| StudyError::Setting(format!("--map: {why}"));
    let [series] = &study.series[..] else {
        return Err(wrong("give one --refine with numeric levels, for example mesh=1,2,4"));
    };
    let row = *series.rows.first().ok_or_else(|| wrong("the study has no level"))?;
    let run = study.rows[row].run.as_ref().map_err(StudyError::clone)?;
    let value = run.found.number().ok_or_else(|| wrong("the quantity must be a number"))?;
    let reference = study.reference.ok_or_else(|| wrong("the study has no estimate of the limit"))?;
    let base = MapBase::of(bench, axes, &study.rows[row].values)?;
    let model = model::build(&base.read().0).0;
    let study_cycles: f64 = study.rows.iter().flat_map(|row| &row.run).map(StudyRun::element_cycles).sum();
    let all_elements = vec![true; model.mesh.elements.len()];
    let all = &base.run(Some(&all_elements.into()), &[])?;
    let plan = MapPlan { all: all.element_cycles(), budget: LARGEST_COST * study_cycles };
    let patches = patches(&model, plan.regions(count));
    let has_both_orders = plan.fits(patches.len());
    let runs = CompanionRuns::of(&base, &model, &patches, has_both_orders);
    let uniform = all.found.number().ok_or_else(|| wrong("the quantity must be a number"))?;
    if base.is_listed() && !is_repeated(study, uniform - value) {
        return Err(wrong(
            "the listed mesh of the first level, refined again, differs from the second level: begin with mesh=1, or with \
             two levels of the ratio 2; values that the deck lists node by node are interpolated once only",
        ));
    }
    let (factor, factor_source) = factor(study, reference.value - value, uniform - value);
    let half = runs.half.as_ref().and_then(|half| half.as_ref().ok());
    let correction = IncrementCorrection::of([run, all], value, half);
    let noise = noise(study, factor, has_both_orders);
    let changes = runs.changes([run, all], &correction);
    let region = |at: usize| {
        let elements = patches[at].iter().map(|&e| model.mesh.elements[e].name.to_string()).collect();
        MeshRegion { name: format!("R{}", at + 1), elements }
    };
    let shares: Vec<RegionShare> = changes
        .into_iter()
        .enumerate()
        .map(|(at, changes)| changes.share(region(at), bounds(&model.mesh, &patches[at]), factor, noise))
        .collect();
    let increment = factor * correction.whole;
    let sum = increment + shares.iter().filter_map(|region| region.share).sum::<f64>();
    let error = reference.value - value;
    let element_cycles = runs.element_cycles() + all.element_cycles();
    let map = ErrorMap {
        quantity: bench.measure().text.clone(),
        setting: setting(study, row),
        value,
        error,
        error_uncertainty: reference.uncertainty,
        uniform_change: uniform - value,
        level_change: level_change(study),
        factor,
        factor_source,
        regions: shares,
        increment,
        noise,
        sum,
        difference: sum - error,
        companions: runs.count() + 1,
        element_cycles,
        cost: element_cycles / study_cycles,
        version: env!("CARGO_PKG_VERSION"),
    };
    Ok(ErrorMapRun { map, mesh: Mesh::clone(&model.mesh), patches })
}

/// Number of runs within the largest cost.
struct MapPlan {
    /// Element-cycles of a run with all regions refined.
    all: f64,
    /// Largest element-cycles of all companion runs.
    budget: f64,
}

impl MapPlan {
    /// Returns whether the runs of both orders are within the budget. In the mean over an order, a run has 2.5 instead of 4
    /// times as many elements as the coarsest level, and the increments of half the element size.
    fn fits(&self, regions: usize) -> bool {
        let runs_in_both_orders = 2.0 * regions.saturating_sub(1) as f64;
        self.all * (2.5 / 4.0 * runs_in_both_orders + 1.25) <= self.budget
    }

    /// Returns the given number of regions, or the largest one up to the default that is within the budget.
    fn regions(&self, given: Option<usize>) -> usize {
        let [least, default, _] = REGIONS;
        given.or_else(|| (least..=default).rev().find(|regions| self.fits(*regions))).unwrap_or(least)
    }
}

/// Result of a companion run.
type RunResult = Result<StudyRun, StudyError>;

/// Results of the companion runs.
struct CompanionRuns {
    /// The mesh is unchanged, with half the increment; `None` if the increment cannot be changed.
    half: Option<RunResult>,
    /// The first regions are refined: one, two and so on, but not all.
    first: Vec<RunResult>,
    /// The last regions are refined: one, two and so on, but not all; empty if there are no such runs.
    last: Vec<RunResult>,
}

impl CompanionRuns {
    fn of(base: &MapBase<'_>, model: &Model, patches: &[Vec<usize>], has_both_orders: bool) -> CompanionRuns {
        let marks = |patches: &[Vec<usize>]| -> ElementMarks {
            let mut marks = vec![false; model.mesh.elements.len()];
            patches.iter().flatten().for_each(|&element| marks[element] = true);
            marks.into()
        };
        let half_increment = || edit(&StudyParameter::Increment, "0.5").ok().flatten();
        let half_increment = if deforms(model) { half_increment() } else { None };
        let count = patches.len();
        let mut tasks: Vec<Option<ElementMarks>> = (1..count).map(|refined| Some(marks(&patches[..refined]))).collect();
        tasks.extend((1..count).filter(|_| has_both_orders).map(|refined| Some(marks(&patches[count - refined..]))));
        tasks.extend(half_increment.as_ref().map(|_| None));
        let run = |task: &Option<ElementMarks>| match task {
            Some(marks) => base.run(Some(marks), &[]),
            None => base.run(None, half_increment.as_slice()),
        };
        let mut first: Vec<RunResult> = tasks.par_iter().map(run).collect();
        let half = half_increment.is_some().then(|| first.pop()).flatten();
        let last = first.split_off(count - 1);
        CompanionRuns { half, first, last }
    }

    fn each(&self) -> impl Iterator<Item = &RunResult> {
        self.first.iter().chain(&self.last).chain(&self.half)
    }

    fn count(&self) -> usize {
        self.each().count()
    }

    fn element_cycles(&self) -> f64 {
        self.each().flatten().map(StudyRun::element_cycles).sum()
    }

    /// Returns the changes of the quantity by each region.
    fn changes(&self, [base, all]: [&StudyRun; 2], correction: &IncrementCorrection) -> Vec<RegionChanges> {
        let in_order = |runs: &[RunResult]| -> Vec<RegionChange> {
            let [base, all] = [Ok(base), Ok(all)];
            let each: Vec<_> = [base].into_iter().chain(runs.iter().map(RunResult::as_ref)).chain([all]).collect();
            each.windows(2).map(|pair| correction.change(pair[0], pair[1])).collect()
        };
        let forward = in_order(&self.first).into_iter();
        let mut backward: Vec<Option<RegionChange>> = vec![None; self.first.len() + 1];
        if self.last.len() == self.first.len() {
            backward = in_order(&self.last).into_iter().rev().map(Some).collect();
        }
        forward.zip(backward).map(|(forward, backward)| RegionChanges { forward, backward }).collect()
    }
}

/// Returns the change of the quantity from the first to the second level, if its size is half as large.
fn level_change(study: &RefinementStudy) -> Option<f64> {
    let series = &study.series[0];
    let [coarse, fine, ..] = series.sizes[..] else { return None };
    let value = |at: usize| study.rows[*series.rows.get(at)?].value;
    (coarse / fine - 2.0).abs().lt(&1e-9).then(|| Some(value(1)? - value(0)?)).flatten()
}

/// Returns whether the change by refinement of the listed first level is that of the second level, within a tenth and the
/// noise.
fn is_repeated(study: &RefinementStudy, change: f64) -> bool {
    let of_run = study.noise.as_ref().map_or(0.0, |noise| noise.uncertainty);
    level_change(study).is_some_and(|level| (change - level).abs() <= 0.1 * level.abs() + 2.0 * of_run)
}

/// Returns the factor from the change with half the element size to the error. Equation (15.11).
fn factor(study: &RefinementStudy, error: f64, change: f64) -> (f64, FactorSource) {
    let of_order = |order: f64| 1.0 / (1.0 - libm::pow(2.0, -order));
    let order = study.series[0].estimate.and_then(|estimate| estimate.order);
    let largest = of_order(CREDIBLE[0]);
    match order.filter(|order| (CREDIBLE[0]..=CREDIBLE[1]).contains(order)) {
        Some(order) => (of_order(order.min(FORMAL_ORDER)), FactorSource::Observed),
        None if (1.0..=largest).contains(&(error / change)) => (error / change, FactorSource::Limit),
        None => (of_order(FORMAL_ORDER), FactorSource::Assumed),
    }
}

/// Returns the noise of a share: that of the difference of two runs, or of the mean of two such differences.
fn noise(study: &RefinementStudy, factor: f64, has_both_orders: bool) -> f64 {
    let of_run = study.noise.as_ref().map_or(0.0, |noise| noise.uncertainty);
    factor * of_run * if has_both_orders { 1.0 } else { std::f64::consts::SQRT_2 }
}

/// Effect of the time increment, of first order in its mean length.
struct IncrementCorrection {
    /// Change of the quantity from the increments of the unchanged mesh to those of the refined mesh.
    whole: f64,
    /// Change of the quantity per change of the mean increment, as a fraction of the step.
    slope: f64,
}

/// Returns the mean increment of a run as a fraction of its time.
fn mean_increment(run: &StudyRun) -> f64 {
    1.0 / run.increments.max(1) as f64
}

impl IncrementCorrection {
    fn of([base, all]: [&StudyRun; 2], value: f64, half: Option<&StudyRun>) -> IncrementCorrection {
        let slope = half.and_then(|half| {
            let change = mean_increment(half) - mean_increment(base);
            Some((half.found.number()? - value) / change).filter(|slope| slope.is_finite())
        });
        let slope = slope.unwrap_or(0.0);
        IncrementCorrection { whole: slope * (mean_increment(all) - mean_increment(base)), slope }
    }

    /// Returns the change of the quantity between two runs without that of the increment.
    fn change(&self, from: Result<&StudyRun, &StudyError>, to: Result<&StudyRun, &StudyError>) -> RegionChange {
        let (from, to) = (from.map_err(StudyError::clone)?, to.map_err(StudyError::clone)?);
        let numbers = from.found.number().zip(to.found.number());
        let (before, after) = numbers.ok_or_else(|| StudyError::Comparison("the quantity is no number".into()))?;
        Ok(after - before - self.slope * (mean_increment(to) - mean_increment(from)))
    }
}

/// Change of the quantity by the refinement of a region, or why it is not known.
type RegionChange = Result<f64, StudyError>;

/// Changes of the quantity by the refinement of a region after those before it in the list, and after those that follow.
struct RegionChanges {
    forward: RegionChange,
    backward: Option<RegionChange>,
}

impl RegionChanges {
    /// Returns the share of a region. Equation (15.10).
    fn share(self, region: MeshRegion, bounds: [[f64; 2]; 2], factor: f64, noise: f64) -> RegionShare {
        let failures = [self.forward.as_ref().err(), self.backward.as_ref().and_then(|change| change.as_ref().err())];
        let failure = failures.into_iter().flatten().next().map(ToString::to_string);
        let (forward, backward) = (self.forward.ok(), self.backward.and_then(Result::ok));
        let change = match (forward, backward) {
            (Some(forward), Some(backward)) => Some(0.5 * (forward + backward)),
            _ => forward.or(backward),
        };
        let interaction = forward.zip(backward).map(|(a, b)| 0.5 * factor * (a - b).abs());
        RegionShare {
            region,
            bounds,
            share: change.map(|change| factor * change),
            forward,
            backward,
            uncertainty: interaction.map(|interaction| interaction + noise),
            failure,
        }
    }
}
