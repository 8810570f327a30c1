//! Von Mises plasticity with a cutoff of the tensile mean stress (ABAQUS Analysis User's Guide, "Dynamic failure models", tensile
//! failure without element deletion).

use super::law::{ReturnPoint, StressReturn};
use super::root::{Start, nearby_root};
use crate::kernel::hardening::LinearTable;
use crate::kernel::moduli::ElasticModuli;
use crate::variables::{Variable, VariableComponent};

/// Solid that fails for good when its mean stress exceeds a cutoff, and stays.
#[derive(Clone, Debug)]
pub struct SpallingSolid {
    /// Largest tensile mean stress, stress.
    pub cutoff: f64,
    /// Whether a failed point has no deviatoric stress; otherwise it keeps that of the plasticity.
    pub loses_shear: bool,
    /// Whether a failed point has no tension; otherwise its mean stress is limited by the cutoff.
    pub loses_tension: bool,
    /// Yield stress over plastic strain; elastic without rows.
    pub hardening: LinearTable,
    /// Elastic moduli.
    pub moduli: ElasticModuli,
}

const STRAIN: usize = 0;
/// 1 after failure.
const FAILED: usize = 1;

impl SpallingSolid {
    /// Returns the increment of the equivalent plastic strain that returns a von Mises stress. Equation (6.2).
    fn flow(&self, mises: f64, strain: f64) -> f64 {
        let shear3 = 3.0 * self.moduli.shear;
        if self.hardening.rows.is_empty() {
            return 0.0;
        }
        let hardening = self.hardening.line(strain);
        let first = mises - hardening.value;
        if first <= 0.0 {
            return 0.0;
        }
        let outside = |flow: f64| mises - shear3 * flow - hardening.at(strain + flow);
        let start = Start { start: 0.0, first, guess: first / (shear3 + hardening.slope) };
        nearby_root(start, mises / shear3, 1e-13 * mises, outside).unwrap_or(mises / shear3)
    }
}

impl StressReturn for SpallingSolid {
    fn describe(&self) -> String {
        let word = |brittle: bool| if brittle { "brittle" } else { "ductile" };
        let (shear, tension) = (word(self.loses_shear), word(self.loses_tension));
        format!("tensile failure at {}, shear {shear}, pressure {tension}", self.cutoff)
    }

    fn moduli(&self) -> ElasticModuli {
        self.moduli
    }

    fn initial_state(&self) -> Vec<f64> {
        vec![0.0; 2]
    }

    fn hardening_state(&self) -> Option<usize> {
        Some(STRAIN)
    }

    fn output(&self, part: VariableComponent) -> Option<usize> {
        match part.variable {
            Variable::PlasticStrain => Some(STRAIN),
            Variable::Damage => Some(FAILED),
            _ => None,
        }
    }

    /// Equation (20.35).
    fn update(&self, point: &mut ReturnPoint<'_>) {
        let trial = point.trial;
        let flow = self.flow(trial.mises, point.state[STRAIN]);
        let (mut pressure, mut mises) = (trial.pressure, trial.mises - 3.0 * self.moduli.shear * flow);
        if -trial.pressure > self.cutoff {
            point.state[FAILED] = 1.0;
        }
        if point.state[FAILED] > 0.0 {
            pressure = pressure.max(if self.loses_tension { 0.0 } else { -self.cutoff });
            mises = if self.loses_shear { 0.0 } else { mises };
        }
        // A deviator without strength flows, too.
        point.state[STRAIN] += (trial.mises - mises) / (3.0 * self.moduli.shear);
        point.return_to(pressure, mises, (pressure - trial.pressure) / self.moduli.bulk);
    }
}
