//! What a deck amounts to before it runs: bodies with mass and place, waves, energies at the start, and what the run will take.

mod bodies;
mod effort;
mod text;

use serde::Serialize;

use crate::model::{EosKind, InitialKind, Material, Model, Units};
use crate::plan::{Plan, State};
pub use bodies::Part;
pub use effort::{Effort, measure};

/// What a deck amounts to.
#[derive(Clone, Debug, Serialize)]
pub struct Overview {
    /// Names of the units, where the deck gives them.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub units: Option<Units>,
    /// Sections of what deforms, and rigid bodies.
    pub parts: Vec<Part>,
    /// Mass of all that moves.
    pub mass: f64,
    /// Kinetic energy at the start.
    pub kinetic_energy: f64,
    /// Speeds of waves, by material.
    pub waves: Vec<WaveSpeeds>,
    /// Smallest and largest temperature that the deck gives at the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperatures: Option<[f64; 2]>,
    /// Steps and their lengths.
    pub steps: Vec<StepTime>,
    /// What the run will take; absent where it was not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effort: Option<Effort>,
}

/// Speeds of waves of small strain in a material.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WaveSpeeds {
    /// The material.
    pub material: String,
    /// Density.
    pub density: f64,
    /// Of longitudinal waves: sqrt((K + 4/3 G)/rho).
    pub longitudinal: f64,
    /// Of shear waves: sqrt(G/rho).
    pub shear: f64,
}

/// A step and its length.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepTime {
    /// Name.
    pub name: String,
    /// Length, time.
    pub duration: f64,
}

impl Overview {
    /// Of a model and its plan, before anything runs.
    pub fn of(model: &Model, plan: &Plan, state: &State) -> Overview {
        let parts = bodies::parts(model, plan, state);
        Overview {
            units: model.settings.units.clone(),
            mass: bodies::mass(plan, state),
            kinetic_energy: bodies::kinetic_energy(state),
            parts,
            waves: model.materials.iter().filter_map(waves).collect(),
            temperatures: temperatures(model),
            steps: plan.steps.iter().map(|s| StepTime { name: s.name.clone(), duration: s.duration }).collect(),
            effort: None,
        }
    }

    /// As text.
    pub fn render(&self) -> String {
        text::render(self)
    }
}

fn waves(material: &Material) -> Option<WaveSpeeds> {
    let density = material.density.or_else(|| Some(material.densities.first()?[0]))?;
    let [bulk, shear] = moduli(material, density)?;
    let longitudinal = ((bulk + 4.0 / 3.0 * shear) / density).sqrt();
    Some(WaveSpeeds { material: material.name.clone(), density, longitudinal, shear: (shear / density).sqrt() })
}

/// Bulk and shear modulus of small strains; `None` where the user's routine has them.
fn moduli(material: &Material, density: f64) -> Option<[f64; 2]> {
    if let Some([modulus, ratio]) = material.elastic.filter(|_| material.eos.is_none()) {
        return Some([modulus / (3.0 * (1.0 - 2.0 * ratio)), modulus / (2.0 * (1.0 + ratio))]);
    }
    if let Some(rubber) = &material.hyperelastic {
        let shear = rubber.shape.shear();
        let given = rubber.compressibility.first().filter(|d| **d > 0.0);
        // Without D1 Poisson's ratio is 0.475 (ABAQUS Analysis User's Guide, "Hyperelastic behavior", "Compressibility").
        return Some([given.map_or(shear * 2.0 * 1.475 / (3.0 * 0.05), |d| 2.0 / d), shear]);
    }
    let EosKind::UsUp([speed, ..]) = material.eos.as_ref()?.kind else { return None };
    Some([density * speed * speed, material.shear_modulus.unwrap_or(0.0)])
}

fn temperatures(model: &Model) -> Option<[f64; 2]> {
    let given = model.initial_conditions.iter().filter_map(|condition| match condition.kind {
        InitialKind::Temperature(value) => Some(value),
        _ => None,
    });
    given.fold(None, |range, value| {
        let [low, high] = range.unwrap_or([value; 2]);
        Some([low.min(value), high.max(value)])
    })
}
