//! Uncertainty of the quantities of one run from cheap companion runs: coarser meshes, another increment,
//! small perturbations, and values of random parameters.

use rayon::prelude::*;
use serde::Serialize;

use super::StudyError;
use super::causes::is_sensitive;
use super::chosen::ChosenSetting;
use super::inputs::RandomInputs;
use super::noise::{self, perturbations};
use super::price::tolerance_in_words;
use super::quantity::Quantity;
use super::richardson::{ConvergenceBehaviour, LimitEstimate, RefinementLevel, estimate};
use super::runner::{RunSource, StudyRun};
use super::settings::{ModelEdit, StudyParameter, deforms, edit};
use super::statistics::{normal, student};
use super::table::{digits, short};
use crate::deck::MESH_SETTINGS;
use crate::job::VerdictReason;
use crate::model::Model;

/// Largest cost of the companion runs relative to that of the plain run.
pub const DEFAULT_BUDGET: f64 = 0.4;
/// Element-cycles that are always allowed (a few milliseconds): below them the cost of a run is that of reading the deck.
const NEGLIGIBLE_CYCLES: f64 = 5e4;
/// Ratios of the element size of coarser meshes to that of the run, in the order in which they are tried.
const RATIOS: [&[u32]; 2] = [&[4, 2], &[3]];
/// Smallest uncertainty of a value from two meshes, as a fraction of the value, over the change of the kinetic or internal
/// energy between them as a fraction of their sum.
const SHARE_OF_ENERGIES: f64 = 0.25;
/// Number of random parameters or regions that a line names.
const LISTED_SHARES: usize = 3;
/// Largest uncertainty of a value that counts as known, as a fraction of the value.
const LARGEST_SHARE: f64 = 0.1;
/// Largest expected cost of a run without mass scaling, relative to that with it.
const UNSCALED_COST: f64 = 4.0;
/// Number of perturbed runs.
const NOISE_RUNS: usize = 4;

/// Properties of the model of a run on which the choice of companion runs depends.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelTraits {
    /// Whether perturbations can be amplified.
    pub sensitive: bool,
    /// Whether the model has deformable elements.
    pub deforms: bool,
    /// Whether a step scales masses.
    pub scales_masses: bool,
    /// Names of the columns of `*OUTPUT EXPRESSION`.
    pub expressions: Vec<String>,
}

impl ModelTraits {
    /// Returns the traits of a model.
    pub fn of(model: &Model) -> ModelTraits {
        ModelTraits {
            sensitive: is_sensitive(model),
            deforms: deforms(model),
            scales_masses: model.scales_masses(),
            expressions: model.output.expressions.iter().map(|e| e.name.clone()).collect(),
        }
    }
}

/// A finished run whose uncertainty is estimated.
#[derive(Clone, Debug, PartialEq)]
pub struct PlainRun {
    /// Values of the quantities; `None` for a quantity without a value.
    pub values: Vec<Option<f64>>,
    /// Number of elements and facets.
    pub elements: usize,
    /// Number of increments.
    pub increments: u64,
    /// Kinetic and internal energy at the end.
    pub energies: [f64; 2],
}

/// Request of the companion runs of a plain run.
pub struct UncertaintyRequest<'a> {
    /// Deck and user subroutines.
    pub source: RunSource<'a>,
    /// Overrides of the deck.
    pub overrides: &'a [(String, String)],
    /// Properties of the model.
    pub traits: &'a ModelTraits,
    /// Quantities of the run.
    pub quantities: &'a [Quantity],
    /// Random parameters.
    pub inputs: Option<&'a RandomInputs>,
    /// Largest cost of the companion runs relative to that of the plain run.
    pub budget: f64,
}

/// Value on one mesh.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeshLevel {
    /// Element size relative to that of the run.
    pub size: f64,
    /// Value of the quantity.
    pub value: f64,
}

/// Part of an uncertainty with its source.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NamedShare {
    /// Name of a random parameter or of a region.
    pub name: String,
    /// Fraction of the whole.
    pub share: f64,
}

/// Value of a quantity with its uncertainties, in the units of the quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct QuantityUncertainty {
    /// Expression of the quantity.
    pub quantity: String,
    /// Value of the plain run.
    pub value: f64,
    /// Values on all meshes, coarsest first; the last is that of the plain run.
    pub levels: Vec<MeshLevel>,
    /// Observed order of convergence.
    pub order: Option<f64>,
    /// Convergence behaviour; `None` without a coarser mesh.
    pub behaviour: Option<ConvergenceBehaviour>,
    /// Uncertainty from the mesh: the grid convergence index.
    pub mesh: Option<f64>,
    /// Uncertainty from the time increment, with order 1.
    pub increment: Option<f64>,
    /// Effect of mass scaling: the change of a coarse mesh without it.
    pub mass_scaling: Option<f64>,
    /// Noise: half-width of the 95 % interval over perturbed runs of the coarsest mesh.
    pub noise: Option<f64>,
    /// Half-width of the 95 % interval due to the random parameters, to first order.
    pub input: Option<f64>,
    /// Fractions of the variance due to each random parameter, the largest first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub inputs: Vec<NamedShare>,
    /// Fractions of the mesh error of each region of an error map, those of the largest magnitude first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<NamedShare>,
    /// Name of the largest part; `None` if no part is known.
    pub dominant: Option<&'static str>,
}

/// Uncertainties of a run, the contents of `<job>_certificate.json`. The keys are stable.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RunCertificate {
    /// Quantities with their uncertainties.
    pub quantities: Vec<QuantityUncertainty>,
    /// Parts that are not estimated, with the reason.
    pub missing: Vec<String>,
    /// One line for each quantity, one for each missing part, and the cost.
    pub conclusions: Vec<String>,
    /// Setting that was chosen for an error target.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<ChosenSetting>,
    /// Number of companion runs.
    pub companions: usize,
    /// Element-cycles of the companion runs divided by those of the plain run.
    pub cost: f64,
    /// Element-cycles of the plain run.
    pub element_cycles: f64,
    /// SHA-256 hash of the deck and its included files; absent for a run in memory.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub deck: String,
    /// SHA-256 hash of the final state of the plain run; absent for a run in memory.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub digest: String,
    /// Version of the program that wrote the record.
    pub version: &'static str,
}

/// CompanionPurpose of a companion run on the coarsest mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
enum CompanionPurpose {
    Noise,
    /// Factor on the increment.
    Increment(f64),
    /// No mass scaling.
    Unscaled,
    /// Index of the random parameter.
    Input(usize),
}

/// A companion run: changes of the deck and the model, and its cost relative to the coarsest mesh.
struct CompanionRun {
    purpose: CompanionPurpose,
    overrides: Vec<(String, String)>,
    edits: Vec<ModelEdit>,
    cost: f64,
}

/// Result of each quantity of a companion run.
type CompanionResult = Vec<Result<StudyRun, StudyError>>;

/// Runs the companion runs and estimates the uncertainty of each quantity; `deck` and `digest` identify the plain run.
pub fn estimate_run(
    request: &UncertaintyRequest<'_>,
    plain: &PlainRun,
    deck: String,
    digest: String,
) -> RunCertificate {
    let cycles = plain.elements as f64 * plain.increments as f64;
    let mut missing = Vec::new();
    let meshes = coarser_runs(request, &mut missing);
    let spent = |runs: &[CompanionResult]| runs.iter().map(element_cycles).sum::<f64>();
    let mut cost = meshes.iter().map(|mesh| element_cycles(&mesh.1)).sum::<f64>();
    let allowed = (request.budget * cycles).max(NEGLIGIBLE_CYCLES) - cost;
    let companions = meshes.first().map_or(Vec::new(), |(ratio, base)| {
        affordable(companions(request, *ratio), allowed / element_cycles(base), &mut missing)
    });
    let runs: Vec<CompanionResult> = companions.par_iter().map(|c| run(request, &c.overrides, &c.edits)).collect();
    cost += spent(&runs);
    let quantity = |index: usize| {
        let value = plain.values[index]?;
        let quantity_runs = QuantityRuns { plain, meshes: &meshes, companions: &companions, runs: &runs, index, value };
        Some(quantity_runs.uncertainty(request))
    };
    let certificate = RunCertificate {
        quantities: (0..request.quantities.len()).filter_map(quantity).collect(),
        missing,
        conclusions: Vec::new(),
        target: None,
        companions: meshes.len() + runs.len(),
        cost: cost / cycles.max(1.0),
        element_cycles: cycles,
        deck,
        digest,
        version: env!("CARGO_PKG_VERSION"),
    };
    RunCertificate { conclusions: certificate.lines(), ..certificate }
}

/// Returns the certificate of a run with a setting that was chosen for an error target.
pub fn of_chosen(chosen: ChosenSetting, plain: &PlainRun, deck: String, digest: String) -> RunCertificate {
    let cycles = plain.elements as f64 * plain.increments as f64;
    let value = plain.values.first().copied().flatten().unwrap_or(chosen.quantity.value);
    let quantity = QuantityUncertainty { value, ..chosen.quantity.clone() };
    let goal = tolerance_in_words(chosen.target.value, chosen.target.relative);
    let where_refined = if chosen.local.is_some() { ", bisected in some regions" } else { "" };
    let line = format!(
        "target {goal}: {}reached with mesh = {}{where_refined}, increment = {}",
        if chosen.reached { "" } else { "not " },
        chosen.mesh,
        chosen.increment
    );
    RunCertificate {
        conclusions: vec![quantity.sentence(), line],
        quantities: vec![quantity],
        missing: Vec::new(),
        companions: chosen.study["runs"].as_array().map_or(0, Vec::len),
        cost: chosen.element_cycles / cycles.max(1.0),
        element_cycles: cycles,
        target: Some(chosen),
        deck,
        digest,
        version: env!("CARGO_PKG_VERSION"),
    }
}

/// Runs the deck in memory, then like [`estimate_run`].
pub fn run_and_estimate(request: &UncertaintyRequest<'_>) -> Result<RunCertificate, StudyError> {
    let results = run(request, &[], &[]);
    let first = results.iter().find_map(|run| run.as_ref().ok());
    let (elements, increments, energies) = match (first, results.first()) {
        (Some(run), _) => (run.elements, run.increments, run.energies),
        (None, Some(Err(reason))) => return Err(reason.clone()),
        (None, _) => return Err(StudyError::Setting("no quantity is given".into())),
    };
    let value = |run: &Result<StudyRun, StudyError>| run.as_ref().ok()?.found.number();
    let plain_run = PlainRun { values: results.iter().map(value).collect(), elements, increments, energies };
    Ok(estimate_run(request, &plain_run, String::new(), String::new()))
}

/// Runs the deck with further overrides and edits.
fn run(request: &UncertaintyRequest<'_>, overrides: &[(String, String)], edits: &[ModelEdit]) -> CompanionResult {
    let is_replaced = |name: &String| overrides.iter().any(|(other, _)| other == name);
    let mut merged: Vec<_> = request.overrides.iter().filter(|(name, _)| !is_replaced(name)).cloned().collect();
    merged.extend_from_slice(overrides);
    request.source.run(&merged, &[edits], request.quantities)
}

/// Returns the element-cycles of a run; zero if it has no result.
fn element_cycles(run: &CompanionResult) -> f64 {
    run.iter().flatten().next().map_or(0.0, StudyRun::element_cycles)
}

/// Runs coarser meshes, coarsest first. The first ratios with a result are used.
fn coarser_runs(request: &UncertaintyRequest<'_>, missing: &mut Vec<String>) -> Vec<(u32, CompanionResult)> {
    // Of the ratio 2, which is the most common one.
    let mut reason = String::new();
    for ratios in RATIOS {
        let each = |ratio: &u32| {
            let edits: Vec<ModelEdit> = scaled_targets(request, *ratio).into_iter().collect();
            Some((*ratio, run(request, &[mesh_setting(request, *ratio)?], &edits)))
        };
        let runs: Vec<_> = ratios.par_iter().filter_map(each).collect();
        if let Some(Err(error)) = runs.last().and_then(|run| run.1.first()).filter(|_| reason.is_empty()) {
            reason = error.to_string();
        }
        let ran: Vec<_> = runs.into_iter().filter(|(_, run)| run.iter().any(Result::is_ok)).collect();
        if !ran.is_empty() {
            return ran;
        }
    }
    let reason = reason.lines().next().unwrap_or("the deck refines the mesh by another factor").to_owned();
    missing.push(format!("all parts: no coarser mesh could be run: {reason}"));
    Vec::new()
}

/// Returns the setting of a mesh that is coarser by a ratio; `None` if the factor of the deck is not divisible.
fn mesh_setting(request: &UncertaintyRequest<'_>, ratio: u32) -> Option<(String, String)> {
    let mesh_override = request.overrides.iter().find(|(name, _)| MESH_SETTINGS.contains(&name.as_str()));
    let (name, factor) = match mesh_override {
        Some((name, text)) => (name.as_str(), text.parse::<u32>().ok()?),
        None => (MESH_SETTINGS[0], 1),
    };
    let value = match (factor % ratio, ratio % factor) {
        (0, _) => (factor / ratio).to_string(),
        (_, 0) => format!("1/{}", ratio / factor),
        _ => return None,
    };
    Some((name.to_owned(), value))
}

/// Returns the companion runs on the coarsest mesh, the most useful ones first.
fn companions(request: &UncertaintyRequest<'_>, ratio: u32) -> Vec<CompanionRun> {
    let mesh: Vec<_> = mesh_setting(request, ratio).into_iter().collect();
    let companion_with = |purpose, mut edits: Vec<ModelEdit>, cost| {
        if purpose != CompanionPurpose::Unscaled {
            edits.extend(scaled_targets(request, ratio));
        }
        CompanionRun { purpose, overrides: mesh.clone(), edits, cost }
    };
    let mut runs = Vec::new();
    for (index, [low, high]) in request.inputs.map_or(Vec::new(), deviations).into_iter().enumerate() {
        for value in [low, high] {
            let mut companion = companion_with(CompanionPurpose::Input(index), Vec::new(), 1.0);
            companion.overrides.push(value);
            runs.push(companion);
        }
    }
    if request.traits.sensitive {
        runs.extend(
            perturbations(NOISE_RUNS).into_iter().map(|edit| companion_with(CompanionPurpose::Noise, vec![edit], 1.0)),
        );
    }
    let change = |parameter: &StudyParameter, value: &str| edit(parameter, value).ok().flatten();
    // Smaller than the stable increment; larger than that of error control, which is cheaper.
    let (factor, text) = if request.traits.deforms { (0.5, "0.5") } else { (2.0, "2") };
    runs.extend(
        change(&StudyParameter::Increment, text)
            .map(|edit| companion_with(CompanionPurpose::Increment(factor), vec![edit], f64::recip(factor))),
    );
    if request.traits.scales_masses {
        runs.push(companion_with(CompanionPurpose::Unscaled, vec![without_mass_scaling()], UNSCALED_COST));
    }
    runs
}

/// Returns the edit of a mesh that is coarser by a ratio, after which mass scaling adds as much mass: larger targets. `None` without
/// mass scaling.
fn scaled_targets(request: &UncertaintyRequest<'_>, ratio: u32) -> Option<ModelEdit> {
    let edit: ModelEdit = Box::new(move |model| {
        let scalings = model.steps.iter_mut().flat_map(|step| &mut step.mass_scalings);
        scalings.filter_map(|scaling| scaling.target.as_mut()).for_each(|target| target.1 *= f64::from(ratio));
        Ok(())
    });
    request.traits.scales_masses.then_some(edit)
}

fn without_mass_scaling() -> ModelEdit {
    Box::new(|model| {
        model.steps.iter_mut().for_each(|step| step.mass_scalings.clear());
        Ok(())
    })
}

/// Returns name and value of each random parameter one standard deviation below and above its median, with the others
/// at their median.
fn deviations(inputs: &RandomInputs) -> Vec<[(String, String); 2]> {
    let medians = vec![0.5; inputs.names.len()];
    let shifted_value = |index: usize, sign: f64| {
        let mut point = medians.clone();
        point[index] = normal::cumulative(sign);
        let mut values = vec![0.0; point.len()];
        inputs.values(&point, &mut values);
        (inputs.names[index].clone(), format!("{:e}", values[index]))
    };
    (0..inputs.names.len()).map(|index| [-1.0, 1.0].map(|sign| shifted_value(index, sign))).collect()
}

/// Returns the first companion runs whose costs, relative to the coarsest mesh, are within the limit; the
/// other companion runs are listed as missing.
fn affordable(companions: Vec<CompanionRun>, limit: f64, missing: &mut Vec<String>) -> Vec<CompanionRun> {
    let mut total = 0.0;
    let mut chosen = Vec::new();
    for companion in companions {
        if total + companion.cost <= limit {
            total += companion.cost;
            chosen.push(companion);
        } else {
            let part = match companion.purpose {
                CompanionPurpose::Noise => "noise (all or some runs)",
                CompanionPurpose::Increment(_) => "increment",
                CompanionPurpose::Unscaled => "mass scaling",
                CompanionPurpose::Input(_) => "input (all or some parameters)",
            };
            missing.push(format!("{part}: outside the budget"));
        }
    }
    missing.dedup();
    chosen
}

/// Results of all runs for one quantity.
struct QuantityRuns<'a> {
    plain: &'a PlainRun,
    meshes: &'a [(u32, CompanionResult)],
    companions: &'a [CompanionRun],
    runs: &'a [CompanionResult],
    index: usize,
    value: f64,
}

impl QuantityRuns<'_> {
    fn uncertainty(&self, request: &UncertaintyRequest<'_>) -> QuantityUncertainty {
        let levels = self.levels();
        let mesh = self.mesh(&levels);
        let increments = self.meshes.first().and_then(|(_, run)| Some(run.get(self.index)?.as_ref().ok()?.increments));
        // Of order 1: proportional to the increment, which is larger on the coarse mesh.
        let shortened = increments.map_or(1.0, |n| n as f64 / self.plain.increments.max(1) as f64).min(1.0);
        let increment =
            self.changes(|p| matches!(p, CompanionPurpose::Increment(_))).next().map(|(purpose, change)| {
                let factor = if let CompanionPurpose::Increment(factor) = purpose { factor } else { 1.0 };
                shortened * change.abs() / (factor - 1.0).abs()
            });
        let mut uncertainty = QuantityUncertainty {
            quantity: request.quantities[self.index].text.clone(),
            value: self.value,
            levels,
            order: mesh.and_then(|m| m.order),
            behaviour: mesh.map(|m| m.behaviour),
            mesh: mesh.map(|m| m.uncertainty),
            increment,
            mass_scaling: self.changes(|p| p == CompanionPurpose::Unscaled).next().map(|(_, change)| change.abs()),
            noise: self.noise(),
            input: self.input(),
            inputs: self.input_shares(request),
            regions: Vec::new(),
            dominant: None,
        };
        uncertainty.dominant = uncertainty.dominant_part();
        uncertainty
    }

    /// Returns the value of the quantity in a run.
    fn number(&self, run: &CompanionResult) -> Option<f64> {
        run.get(self.index)?.as_ref().ok()?.found.number()
    }

    fn levels(&self) -> Vec<MeshLevel> {
        let coarse = self
            .meshes
            .iter()
            .filter_map(|(ratio, run)| Some(MeshLevel { size: f64::from(*ratio), value: self.number(run)? }));
        coarse.chain([MeshLevel { size: 1.0, value: self.value }]).collect()
    }

    fn mesh(&self, levels: &[MeshLevel]) -> Option<LimitEstimate> {
        let series: Vec<RefinementLevel> =
            levels.iter().map(|level| RefinementLevel { size: level.size, value: level.value }).collect();
        let estimated = estimate(&series)?;
        let least = if let [coarse, fine] = levels { self.least_of_two(coarse, fine) } else { 0.0 };
        Some(LimitEstimate { uncertainty: estimated.uncertainty.max(least), ..estimated })
    }

    /// Returns the smallest uncertainty from two meshes: two values can agree by chance, while the energies at the end show
    /// that the solutions differ. Equation (15.4a).
    fn least_of_two(&self, coarse: &MeshLevel, fine: &MeshLevel) -> f64 {
        let run = self.meshes.iter().flat_map(|mesh| &mesh.1).find_map(|run| run.as_ref().ok());
        let Some([coarse_energies, fine_energies]) = run.map(|run| [run.energies, self.plain.energies]) else {
            return 0.0;
        };
        let change = (0..2).map(|i| (fine_energies[i] - coarse_energies[i]).abs()).fold(0.0, f64::max);
        let sum = fine_energies.iter().sum::<f64>().max(coarse_energies.iter().sum());
        if sum > 0.0 { SHARE_OF_ENERGIES * change / sum * coarse.value.abs().max(fine.value.abs()) } else { 0.0 }
    }

    /// Returns the differences of companion runs of some purposes from the run on the coarsest mesh.
    fn changes(&self, wanted: impl Fn(CompanionPurpose) -> bool) -> impl Iterator<Item = (CompanionPurpose, f64)> {
        let base = self.meshes.first().and_then(|mesh| self.number(&mesh.1));
        let pairs = self.companions.iter().zip(self.runs).filter(move |(companion, _)| wanted(companion.purpose));
        pairs.filter_map(move |(companion, run)| Some((companion.purpose, self.number(run)? - base?)))
    }

    fn noise(&self) -> Option<f64> {
        let base = self.meshes.first().and_then(|mesh| self.number(&mesh.1))?;
        let values: Vec<Option<f64>> =
            self.changes(|p| p == CompanionPurpose::Noise).map(|(_, c)| Some(base + c)).collect();
        (!values.is_empty()).then(|| noise::of_runs(base, values.into_iter()).uncertainty)
    }

    /// Returns the variance due to each random parameter, from two values one standard deviation apart from the median.
    fn variances(&self) -> Vec<(usize, f64)> {
        let index = |purpose| if let CompanionPurpose::Input(index) = purpose { Some(index) } else { None };
        let changes: Vec<(usize, f64)> =
            self.changes(|p| index(p).is_some()).filter_map(|(p, change)| Some((index(p)?, change))).collect();
        let pairs = changes.chunk_by(|a, b| a.0 == b.0).filter(|pair| pair.len() == 2);
        pairs.map(|pair| (pair[0].0, 0.25 * (pair[1].1 - pair[0].1) * (pair[1].1 - pair[0].1))).collect()
    }

    /// Adds the variances of the random parameters.
    fn input(&self) -> Option<f64> {
        let variances = self.variances();
        let sum: f64 = variances.iter().map(|variance| variance.1).sum();
        (!variances.is_empty()).then(|| student(f64::INFINITY) * sum.sqrt())
    }

    /// Returns the fraction of the variance due to each random parameter, the largest first.
    fn input_shares(&self, request: &UncertaintyRequest<'_>) -> Vec<NamedShare> {
        let mut variances = self.variances();
        let sum: f64 = variances.iter().map(|variance| variance.1).sum();
        variances.sort_by(|a, b| b.1.total_cmp(&a.1));
        let name = |index: usize| request.inputs.and_then(|inputs| inputs.names.get(index)).cloned();
        let share = |(index, variance): (usize, f64)| Some(NamedShare { name: name(index)?, share: variance / sum });
        variances.into_iter().filter(|_| sum > 0.0).filter_map(share).collect()
    }
}

impl QuantityUncertainty {
    fn parts(&self) -> [(&'static str, Option<f64>); 5] {
        let [mesh, increment, scaling] = self.numerical_parts();
        [mesh, increment, scaling, ("noise", self.noise), ("input", self.input)]
    }

    fn numerical_parts(&self) -> [(&'static str, Option<f64>); 3] {
        [("mesh", self.mesh), ("increment", self.increment), ("mass scaling", self.mass_scaling)]
    }

    pub(super) fn dominant_part(&self) -> Option<&'static str> {
        let known = self.parts().into_iter().filter_map(|(name, part)| Some((name, part?)));
        known.max_by(|a, b| a.1.total_cmp(&b.1)).map(|part| part.0)
    }

    /// Returns the sum of the numerical parts: mesh, increment and mass scaling; `None` if none is known.
    pub fn numerical(&self) -> Option<f64> {
        let known: Vec<f64> = self.numerical_parts().iter().filter_map(|part| part.1).collect();
        (!known.is_empty()).then(|| known.iter().sum())
    }

    /// Returns why the uncertainty is not known, or that it is large.
    fn unknown(&self, traits: &ModelTraits) -> Option<String> {
        if traits.deforms && self.mesh.is_none() {
            return Some("the error from the mesh is not estimated".into());
        }
        if traits.sensitive && self.noise.is_none() {
            return Some("noise is not estimated, and the model amplifies perturbations: a larger --budget".into());
        }
        let total = self.numerical().unwrap_or(0.0) + self.noise.unwrap_or(0.0);
        let is_large = total > LARGEST_SHARE * self.value.abs();
        is_large
            .then(|| format!("its uncertainty {} is more than {} % of the value", short(total), 100.0 * LARGEST_SHARE))
    }

    /// Returns value and uncertainties in one line.
    pub fn sentence(&self) -> String {
        let Some(numerical) = self.numerical() else {
            return format!("{} = {}, uncertainty not estimated", self.quantity, digits(self.value, 9));
        };
        let regions = if self.regions.is_empty() { String::new() } else { format!(": {}", list(&self.regions)) };
        let inputs = if self.inputs.is_empty() { String::new() } else { format!(" ({})", list(&self.inputs)) };
        let named = self.numerical_parts().into_iter().filter_map(|(name, part)| {
            Some(format!("{name} {}{}", short(part?), if name == "mesh" { &regions } else { "" }))
        });
        let more = [(self.noise, "noise", ""), (self.input, "input", &*inputs)];
        let more = more.into_iter().filter_map(|(part, name, of)| Some(format!(" ± {} {name}{of}", short(part?))));
        let reason = self.behaviour.and_then(ConvergenceBehaviour::reason);
        format!(
            "{} = {} ± {} numerical ({}){}; dominant: {}{}",
            self.quantity,
            digits(self.value, 9),
            short(numerical),
            named.collect::<Vec<_>>().join(", "),
            more.collect::<String>(),
            self.dominant.unwrap_or("none"),
            reason.map_or(String::new(), |reason| format!("; mesh: {reason}"))
        )
    }
}

/// Returns the names of the largest shares with their fractions in per cent.
fn list(shares: &[NamedShare]) -> String {
    let named = |share: &NamedShare| format!("{} {} %", share.name, digits(100.0 * share.share, 2));
    shares.iter().take(LISTED_SHARES).map(named).collect::<Vec<_>>().join(", ")
}

impl RunCertificate {
    /// Adds the shares of the regions of an error map to the quantities that have its expression. Returns whether there is
    /// one.
    pub fn add_regions(&mut self, expression: &str, regions: &[NamedShare]) -> bool {
        let mut quantities = self.quantities.iter_mut().filter(|quantity| quantity.quantity == expression).peekable();
        let is_known = quantities.peek().is_some();
        quantities.for_each(|quantity| quantity.regions = regions.to_vec());
        self.conclusions = self.lines();
        is_known
    }

    /// Returns the uncertainties that are not known well enough for the verdict `ok`.
    pub fn unknown(&self, traits: &ModelTraits) -> Vec<VerdictReason> {
        let missed = self.target.as_ref().filter(|chosen| !chosen.reached);
        let missed = missed.map(|chosen| (&chosen.quantity, "the error target is not reached".to_owned()));
        let unknown = self.quantities.iter().filter_map(|quantity| Some((quantity, quantity.unknown(traits)?)));
        let reasons = missed.into_iter().chain(unknown);
        reasons.filter_map(|(q, why)| VerdictReason::unknown_uncertainty(Some(q.quantity.clone()), &why)).collect()
    }

    fn lines(&self) -> Vec<String> {
        let mut lines: Vec<String> = self.quantities.iter().map(QuantityUncertainty::sentence).collect();
        lines.extend(self.missing.iter().map(|part| format!("not estimated: {part}")));
        if self.companions > 0 {
            lines.push(format!(
                "uncertainty from {} companion runs, {} % of the element-cycles of the run",
                self.companions,
                short(100.0 * self.cost)
            ));
        }
        lines
    }
}
