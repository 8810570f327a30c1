//! Choice of mesh and increment of a run for an error target within a time budget.

use std::time::{Duration, Instant as Stopwatch};

use serde::Serialize;
use serde_json::Value;

use super::StudyError;
use super::causes::limits_of_order;
use super::convergence::{self, RefinementRequest};
use super::jitter::NoiseRequest;
use super::quantity::Quantity;
use super::record::{self, CompletedStudy};
use super::refinement::RefinementStudy;
use super::runner::{DeckReader, RunSource, StudyRun, StudyRunner};
use super::settings::{self, ModelEdit, StudyAxis, StudyParameter, deforms};
use super::target::ErrorTarget;
use super::uncertainty::{MeshLevel, QuantityUncertainty};
use crate::deck::MESH_SETTINGS;
use crate::job::ParameterOverrides;
use crate::model;

/// Coarser meshes that are tried first, if the deck allows them.
const COARSER: [&str; 2] = ["1/4", "1/2"];
/// Fraction of the target up to which the error of the increment needs no shorter increment.
const INCREMENT_SHARE: f64 = 0.5;

/// Request of a run whose error is below a target.
pub struct TargetRequest<'a> {
    /// Deck and user subroutines.
    pub source: RunSource<'a>,
    /// Overrides of the deck.
    pub overrides: &'a [(String, String)],
    /// Quantity whose error is limited.
    pub quantity: &'a Quantity,
    /// Error target.
    pub target: ErrorTarget,
    /// Largest time of the choice and of the run with the chosen setting.
    pub budget: Duration,
    /// Function that shows the expected cost of each level before it starts.
    pub announce: &'a dyn Fn(&str),
}

/// Setting of a run for an error target, part of `<job>_certificate.json`. The keys are stable.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ChosenSetting {
    /// Error target.
    pub target: ErrorTarget,
    /// Whether the setting meets the target.
    pub reached: bool,
    /// Number of parts of each edge of the mesh, or its inverse; with `local`, those of the coarsest level.
    pub mesh: String,
    /// Mesh that is refined in some regions, with `--local`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub local: Option<LocalMesh>,
    /// Factor on the time increment.
    pub increment: f64,
    /// Element-cycles of all runs before the chosen one.
    pub element_cycles: f64,
    /// Record of the study of the mesh, with its levels, orders, estimate and noise.
    pub study: Value,
    /// Quantity with its uncertainties, before the run with the chosen setting.
    #[serde(skip)]
    pub quantity: QuantityUncertainty,
    /// Lines to print.
    #[serde(skip)]
    pub conclusions: Vec<String>,
}

/// A region of an error map and its bisections.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BisectedRegion {
    /// Name of the region.
    pub name: String,
    /// Expected change of the quantity if the region is refined without limit.
    pub share: f64,
    /// Number of bisections of its edges.
    pub bisections: u32,
}

/// A mesh that is refined in some regions, part of `<job>_certificate.json`. The keys are stable.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LocalMesh {
    /// Regions of the coarsest level.
    pub regions: Vec<BisectedRegion>,
    /// Value that the shares predict.
    pub predicted: f64,
    /// Number of elements and facets.
    pub elements: usize,
    /// Element-cycles of a run.
    pub element_cycles: f64,
    /// Element-cycles of a run on a uniform mesh with the same error bound, by the order of the study.
    pub uniform_element_cycles: Option<f64>,
    /// Text of the deck.
    #[serde(skip)]
    pub text: String,
}

impl<'a> TargetRequest<'a> {
    /// Returns a runner of single runs, whose time ends with the budget.
    pub fn runner(&self, ignore_progress: &'a dyn Fn(), begin: Stopwatch) -> StudyRunner<'a> {
        let RunSource { deck, user, .. } = self.source;
        let mut bench = StudyRunner::new(deck, self.overrides, user, self.quantity, 1, ignore_progress);
        bench.limited_to(self.budget.saturating_sub(begin.elapsed()), self.announce);
        bench
    }

    /// Studies the levels of the mesh, and further ones until a target is reached.
    pub fn study(
        &self,
        bench: &mut StudyRunner<'_>,
        axes: &[StudyAxis],
        target: Option<ErrorTarget>,
    ) -> Result<CompletedStudy, StudyError> {
        let model = model::build(&(self.source.deck)(self.overrides).0).0;
        let study_request = RefinementRequest {
            axes,
            exact: None,
            target,
            noise: NoiseRequest::new(None, &model),
            causes: limits_of_order(&model),
            announce: self.announce,
            around: false,
        };
        convergence::refine(bench, &study_request)
    }

    /// Returns the setting with a mesh: with half the increment if the error of the increment is large.
    pub fn setting(
        &self,
        bench: &mut StudyRunner<'_>,
        axes: &[StudyAxis],
        completed: &CompletedStudy,
        mesh: ChosenMesh,
    ) -> Result<ChosenSetting, StudyError> {
        let study = &completed.study;
        let model = model::build(&(self.source.deck)(self.overrides).0).0;
        let increment = if deforms(&model) { increment_change(bench, axes, study)? } else { None };
        let quantity = quantity(self, study, &mesh, increment);
        let allowed = self.target.bound(study).unwrap_or(0.0);
        let too_long = quantity.increment.is_some_and(|error| error > INCREMENT_SHARE * allowed);
        Ok(ChosenSetting {
            target: self.target,
            reached: mesh.reached,
            mesh: mesh.name,
            local: None,
            increment: if too_long { 0.5 } else { 1.0 },
            element_cycles: study.rows.iter().flat_map(|r| &r.run).map(|run| run.element_cycles()).sum(),
            study: serde_json::json!(record::record(&self.quantity.text, None, completed)),
            quantity,
            conclusions: record::conclusions(completed, &self.quantity.text),
        })
    }
}

/// A mesh that was run.
pub struct ChosenMesh {
    /// Number of parts of each edge, or a description.
    pub name: String,
    /// Whether its error is below the target.
    pub reached: bool,
    /// Value of the quantity.
    pub value: Option<f64>,
    /// Bound of its error.
    pub bound: Option<f64>,
    /// Number of increments.
    pub increments: u64,
}

/// Refines the mesh, coarser levels first, until the error is below the target or the budget is exhausted, and chooses
/// the setting.
pub fn choose(request: &TargetRequest<'_>) -> Result<ChosenSetting, StudyError> {
    let begin = Stopwatch::now();
    let axes = mesh_axes(request.source.deck, request.overrides)?;
    let ignore_progress = || {};
    let mut bench = request.runner(&ignore_progress, begin);
    let completed = request.study(&mut bench, &axes, Some(request.target))?;
    let study = &completed.study;
    let named = completed.target.as_ref().and_then(|target| target.run);
    let row = named.or_else(|| (0..study.rows.len()).rev().find(|&row| study.rows[row].run.is_ok()));
    let row = &study.rows[row.ok_or_else(|| first_error(study))?];
    let mesh = ChosenMesh {
        name: row.values[0].clone(),
        reached: named.is_some(),
        value: row.value,
        bound: row.bound,
        increments: row.run.as_ref().map_or(1, |run| run.increments),
    };
    request.setting(&mut bench, &axes, &completed, mesh)
}

impl ChosenSetting {
    /// Returns the changes of the model.
    pub fn edits(&self) -> Result<Vec<ModelEdit>, StudyError> {
        if self.increment == 1.0 {
            return Ok(Vec::new());
        }
        let edit = settings::edit(&StudyParameter::Increment, &self.increment.to_string());
        Ok(edit.map_err(StudyError::Setting)?.into_iter().collect())
    }

    /// Returns the overrides of the deck with the chosen mesh, or of the deck that lists the local mesh.
    pub fn overrides(&self, given: &[(String, String)]) -> Vec<(String, String)> {
        if self.local.is_some() { settings::without_mesh(given) } else { settings::with_mesh(given, &self.mesh) }
    }
}

fn first_error(study: &RefinementStudy) -> StudyError {
    let error = study.rows.iter().find_map(|row| row.run.as_ref().err().cloned());
    error.unwrap_or_else(|| StudyError::Comparison("the study has no row".into()))
}

/// Returns the refinement of the mesh from coarser levels that the deck allows to the mesh of the deck, or to twice as
/// many elements along each edge if it allows none.
pub fn mesh_axes(source: &DeckReader<'_>, overrides: &ParameterOverrides) -> Result<Vec<StudyAxis>, StudyError> {
    if source(overrides).0.parameters.iter().any(|(name, _)| name == MESH_SETTINGS[1]) {
        return Err(StudyError::Setting("the deck has a *PARAMETER `mesh`: rename it to refine the mesh".into()));
    }
    let is_possible = |level: &&str| {
        let (deck, diagnostics) = source(&settings::with_mesh(overrides, level));
        !diagnostics.has_errors() && !model::build(&deck).1.has_errors()
    };
    let mut levels: Vec<&str> = COARSER.into_iter().filter(is_possible).collect();
    levels.push("1");
    if levels.len() == 1 {
        levels.push("2");
    }
    settings::axes(&[format!("mesh={}", levels.join(","))], &[])
}

/// Returns the change of the quantity on the coarsest level with half the increment.
fn increment_change(
    bench: &mut StudyRunner<'_>,
    axes: &[StudyAxis],
    study: &RefinementStudy,
) -> Result<Option<f64>, StudyError> {
    let Some(base) = study.rows.first() else { return Ok(None) };
    let edit = settings::edit(&StudyParameter::Increment, "0.5").map_err(StudyError::Setting)?;
    let quantities = [bench.measure().clone()];
    let runs = bench.changed(axes, &base.values.clone(), edit.into_iter().collect(), &quantities)?;
    let number = |run: &[Result<StudyRun, StudyError>]| run.first()?.as_ref().ok()?.found.number();
    Ok(runs.first().and_then(|run| number(run)).zip(base.value).map(|(half, whole)| (half - whole).abs()))
}

/// Returns the quantity of a mesh with its uncertainties. `increment` is the change with half the increment on the
/// coarsest level; its error is of order 1.
fn quantity(
    request: &TargetRequest<'_>,
    study: &RefinementStudy,
    mesh: &ChosenMesh,
    increment: Option<f64>,
) -> QuantityUncertainty {
    let series = &study.series[0];
    let finest = series.sizes.last().copied().unwrap_or(1.0);
    let level = |(row, size): (&usize, &f64)| Some(MeshLevel { size: size / finest, value: study.rows[*row].value? });
    let coarsest = study.rows[0].run.as_ref().map_or(1.0, |run| run.increments.max(1) as f64);
    let estimate = series.estimate;
    let parts = QuantityUncertainty {
        quantity: request.quantity.text.clone(),
        value: mesh.value.unwrap_or(f64::NAN),
        levels: series.rows.iter().zip(&series.sizes).filter_map(level).collect(),
        order: estimate.and_then(|e| e.order),
        behaviour: estimate.map(|e| e.behaviour),
        mesh: mesh.bound,
        increment: increment.map(|change| 2.0 * change * coarsest / mesh.increments.max(1) as f64),
        mass_scaling: None,
        noise: study.noise.as_ref().map(|noise| noise.uncertainty),
        input: None,
        inputs: Vec::new(),
        regions: Vec::new(),
        dominant: None,
    };
    QuantityUncertainty { dominant: parts.dominant_part(), ..parts }
}
