//! Summary of a model before it runs: parts with mass and position, wave speeds, initial energy, estimated run time.

mod bodies;
mod effort;
mod storage;
mod text;

use serde::Serialize;

use crate::kernel::moduli::ElasticModuli;
use crate::model::{DeckUnits, MaterialDefinition, Model};
use crate::plan::{Plan, State};
pub use bodies::PartOverview;
pub use effort::{COUNTING_SHARE, RunEstimate, measure};
pub use storage::{StorageEstimate, size};

/// Summary of a model before it runs.
#[derive(Clone, Debug, Serialize)]
pub struct DeckOverview {
    /// Names of the units, if the deck has `*UNITS`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<DeckUnits>,
    /// Sections of deformable elements, and rigid bodies.
    pub parts: Vec<PartOverview>,
    /// Total mass of deformable elements, point masses and rigid bodies.
    pub mass: f64,
    /// Initial kinetic energy of the full rings.
    pub kinetic_energy: f64,
    /// Wave speeds of the materials.
    pub waves: Vec<WaveSpeeds>,
    /// Smallest and largest initial temperature, if the deck gives any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperatures: Option<[f64; 2]>,
    /// Names and durations of the steps.
    pub steps: Vec<StepTime>,
    /// Estimated increments and run time; absent if they were not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effort: Option<RunEstimate>,
    /// Size of the result files.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub output: Option<StorageEstimate>,
}

/// Speeds of small-strain waves in a material.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WaveSpeeds {
    /// Name of the material in the deck.
    pub material: String,
    /// Initial density, mass per length³.
    pub density: f64,
    /// Speed of longitudinal waves, sqrt((K + 4/3 G)/rho).
    pub longitudinal: f64,
    /// Speed of shear waves, sqrt(G/rho).
    pub shear: f64,
}

/// Name and duration of a step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepTime {
    /// Name of the step in the deck.
    pub name: String,
    /// Duration, in the time unit of the deck.
    pub duration: f64,
}

impl DeckOverview {
    /// Summarises a model and its plan.
    pub fn of(model: &Model, plan: &Plan, state: &State) -> DeckOverview {
        let parts = bodies::parts(model, plan, state);
        let temperatures = temperatures(model);
        let uniform = temperatures.filter(|[low, high]| low == high);
        let temperature = uniform.map(|[low, _]| low - model.settings.absolute_zero);
        DeckOverview {
            units: model.settings.units.clone(),
            mass: bodies::mass(plan, state),
            kinetic_energy: bodies::kinetic_energy(state),
            parts,
            waves: model.materials.iter().filter_map(|material| waves(material, temperature)).collect(),
            temperatures,
            steps: plan.steps.iter().map(|s| StepTime { name: s.name.clone(), duration: s.duration }).collect(),
            effort: None,
            output: None,
        }
    }

    /// Formats the summary as text, which is the same each time: without the measured run time.
    pub fn render(&self) -> String {
        text::render(self)
    }

    /// Returns the measured run time as a sentence; `None` without a trial run.
    pub fn run_time(&self) -> Option<String> {
        text::run_time(self.effort.as_ref()?)
    }
}

/// Returns the wave speeds of a material at an absolute temperature, which is given if it is uniform.
fn waves(material: &MaterialDefinition, temperature: Option<f64>) -> Option<WaveSpeeds> {
    let density = material.density.or_else(|| Some(material.densities.first()?[0]))?;
    let ElasticModuli { bulk, shear } = material.small_strain_moduli(temperature)?;
    let longitudinal = ((bulk + 4.0 / 3.0 * shear) / density).sqrt();
    Some(WaveSpeeds { material: material.name.clone(), density, longitudinal, shear: (shear / density).sqrt() })
}

fn temperatures(model: &Model) -> Option<[f64; 2]> {
    let temperatures = model.initial_conditions.iter().filter_map(|condition| condition.kind.temperature());
    temperatures.fold(None, |range, value| {
        let [low, high] = range.unwrap_or([value; 2]);
        Some([low.min(value), high.max(value)])
    })
}
