//! The energy balance: work of every force over each increment by the trapezoid of F du, and the sum that must not change.
//! Never here: forces.

use serde::Serialize;

use crate::effect::motion::Motion;
use crate::effect::{Account, Slot};
use crate::state::Bodies;

/// Energies now, in ABAQUS's names. `ETOTAL = ALLKE + ALLFD + ALLCAV - ALLWK` is constant.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Energy {
    /// Kinetic energy.
    #[serde(rename = "ALLKE")]
    pub kinetic: f64,
    /// Work of prescribed loads and motions.
    #[serde(rename = "ALLWK")]
    pub work: f64,
    /// Dissipated by friction.
    #[serde(rename = "ALLFD")]
    pub friction: f64,
    /// Dissipated by opening the cavity.
    #[serde(rename = "ALLCAV")]
    pub cavity: f64,
    /// The sum.
    #[serde(rename = "ETOTAL")]
    pub total: f64,
    /// The sum at the start.
    pub initial: f64,
    /// Largest departure of the sum from its start, over the largest energy met: kinetic at the start or work done.
    pub drift: f64,
    #[serde(skip)]
    largest: f64,
    #[serde(skip)]
    forces_before: Vec<f64>,
    #[serde(skip)]
    moved: Vec<f64>,
    #[serde(skip)]
    afresh: bool,
    #[serde(skip)]
    prescribed: Vec<Prescribed>,
}

/// A body whose motion is prescribed: the reaction does the work that the other forces leave of the change in kinetic
/// energy.
#[derive(Clone, Debug, PartialEq)]
struct Prescribed {
    body: usize,
    kinetic: f64,
}

impl Energy {
    /// The balance at the start of an analysis.
    pub fn start(bodies: &Bodies) -> Self {
        let kinetic = (0..bodies.count()).map(|b| kinetic(bodies, b)).sum();
        Energy { kinetic, total: kinetic, initial: kinetic, largest: kinetic, ..Energy::default() }
    }

    /// A new step with its forces and prescribed motions.
    pub fn begin(&mut self, bodies: usize, slots: &[Slot], motions: &[Motion]) {
        self.forces_before = vec![0.0; slots.len()];
        self.moved = vec![0.0; bodies];
        self.prescribed = motions.iter().map(|m| Prescribed { body: m.body, kinetic: f64::NAN }).collect();
    }

    /// Tells how far the bodies went, and whether the increment ended in a jump: then the forces behind it count.
    pub fn moved(&mut self, bodies: &Bodies, before: &[f64], afresh: bool) {
        self.afresh = afresh;
        for ((moved, now), before) in self.moved.iter_mut().zip(&bodies.displacement).zip(before) {
            *moved = now - before;
        }
    }

    /// Books the increment that led to this instant.
    pub fn book(&mut self, bodies: &Bodies, slots: &[Slot], forces: &[f64]) {
        for (i, slot) in slots.iter().enumerate() {
            let before = self.forces_before[i];
            let mean = if self.afresh { before } else { 0.5 * (before + forces[i]) };
            let work = mean * self.moved[slot.body];
            match slot.account {
                Account::Work => self.work += work,
                Account::Friction => self.friction -= work,
                Account::Cavity => self.cavity -= work,
            }
            if self.prescribed.iter().any(|p| p.body == slot.body) {
                self.work -= work;
            }
        }
        self.forces_before.copy_from_slice(forces);
        self.book_reactions(bodies);
        self.kinetic = (0..bodies.count()).map(|b| kinetic(bodies, b)).sum();
        self.total = self.kinetic + self.friction + self.cavity - self.work;
        self.largest = self.largest.max(self.kinetic).max(self.work.abs());
        if self.largest > 0.0 {
            self.drift = self.drift.max((self.total - self.initial).abs() / self.largest);
        }
    }

    fn book_reactions(&mut self, bodies: &Bodies) {
        for prescribed in &mut self.prescribed {
            let now = kinetic(bodies, prescribed.body);
            if !prescribed.kinetic.is_nan() {
                self.work += now - prescribed.kinetic;
            }
            prescribed.kinetic = now;
        }
    }
}

fn kinetic(bodies: &Bodies, b: usize) -> f64 {
    0.5 * bodies.mass[b] * bodies.velocity[b] * bodies.velocity[b]
}
