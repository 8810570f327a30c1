//! Solid with an equation of state and von Mises plasticity, one point at a time: for the resistance of targets. Elements have
//! the same equations in blocks ([`crate::material::von_mises`]).

use super::law::{ReturnPoint, StressReturn, TrialStress, contraction};
use crate::kernel::hardening::{LinearTable, plastic_increment};
use crate::kernel::lanes::{InlineMap, LANES};
use crate::kernel::moduli::ElasticModuli;
use crate::material::compaction::{PointDistension, PorousCompaction};
use crate::material::eos::{LinearEos, Tabulated, UsUp, advance};
use crate::material::volumetric::PressureUpdate;
use crate::variables::{Variable, VariableComponent};

/// Equation of state of a point.
#[derive(Clone, Debug)]
pub enum PointPressure {
    /// Solid with a linear Hugoniot.
    Solid(UsUp),
    /// Functions of the volumetric strain.
    Table(Tabulated),
    /// Solid whose pores close.
    Porous(PorousCompaction),
}

/// Solid with an equation of state, without dependence on rates and temperatures.
#[derive(Clone, Debug)]
pub struct EosSolid {
    /// Pressure over density and energy.
    pub pressure: PointPressure,
    /// Initial density, with pores.
    pub density: f64,
    /// Shear modulus.
    pub shear: f64,
    /// Yield stress over plastic strain.
    pub hardening: LinearTable,
}

/// States: equivalent plastic strain, logarithm of the volume ratio, specific energy, distensions.
const STRAIN: usize = 0;
const DILATION: usize = 1;
const ENERGY: usize = 2;
const SMALLEST: usize = 3;
const CURRENT: usize = 4;

impl PointPressure {
    fn initial_bulk_modulus(&self, density: f64) -> f64 {
        match self {
            PointPressure::Solid(law) => density * law.c0 * law.c0,
            PointPressure::Table(law) => density * law.line(1.0 / density).cold_slope,
            PointPressure::Porous(law) => law.initial_bulk_modulus(),
        }
    }

    /// Updates the first lane and the states; returns what compaction dissipates per mass.
    fn advance(&self, update: &mut PressureUpdate, state: &mut [f64]) -> f64 {
        let before = state[ENERGY];
        match self {
            PointPressure::Solid(law) => {
                let volume = update.volume[0];
                state[ENERGY] = advance(update, 0, law.curve(1.0 / volume, volume), before, [0.0, law.floor()]);
            }
            PointPressure::Table(law) => {
                state[ENERGY] = advance(update, 0, law.line(update.volume[0]), before, [0.0; 2]);
            }
            PointPressure::Porous(law) => {
                let mut distension = PointDistension { smallest: state[SMALLEST], current: state[CURRENT] };
                state[ENERGY] = law.advance_lane(&mut distension, before, update, 0);
                (state[SMALLEST], state[CURRENT]) = (distension.smallest, distension.current);
            }
        }
        update.compacted[0]
    }
}

impl StressReturn for EosSolid {
    fn describe(&self) -> String {
        "equation of state and von Mises plasticity".to_owned()
    }

    fn moduli(&self) -> ElasticModuli {
        ElasticModuli { bulk: self.pressure.initial_bulk_modulus(self.density), shear: self.shear }
    }

    fn initial_state(&self) -> Vec<f64> {
        let distension = match &self.pressure {
            PointPressure::Porous(law) => law.start_of_point(),
            _ => PointDistension { smallest: 1.0, current: 1.0 },
        };
        vec![0.0, 0.0, 0.0, distension.smallest, distension.current]
    }

    fn output(&self, part: VariableComponent) -> Option<usize> {
        match part.variable {
            Variable::PlasticStrain => Some(STRAIN),
            Variable::SpecificEnergy => Some(ENERGY),
            Variable::Distension => Some(CURRENT),
            _ => None,
        }
    }

    fn holds_pressure(&self) -> bool {
        true
    }

    /// The energy of an increment is that of the mean stress: a shock in one increment has the energy of the jump.
    fn is_exact_over_jumps(&self) -> bool {
        true
    }

    /// Equations (6.2), (7.2).
    fn update(&self, point: &mut ReturnPoint<'_>) {
        let dilation = point.dilation();
        let TrialStress { deviator, mises, .. } = point.trial;
        let flow = plastic_increment(&self.hardening, mises, point.state[STRAIN], 0.0, 3.0 * self.shear, 1.0);
        let share = if flow > 0.0 { 1.0 - 3.0 * self.shear * flow / mises } else { 1.0 };
        let deviator = deviator.inline_map(|part| share * part);
        let carried = TrialStress::of(point.carried);
        let both = [0, 1, 2, 3].inline_map(|i: usize| 0.5 * (carried.deviator[i] + deviator[i]));
        let volume = |log_ratio: f64| libm::exp(log_ratio) / self.density;
        let [start, end] = [point.state[DILATION], point.state[DILATION] + dilation].inline_map(volume);
        // The volume whose product with the strain increment is the change of the volume.
        let middle = if dilation == 0.0 { end } else { (end - start) / dilation };
        let of_point = |value: f64| [value; LANES];
        let mut update = PressureUpdate {
            mean: of_point(-carried.pressure),
            bulk: of_point(0.0),
            viscous: of_point(0.0),
            heat: of_point(0.0),
            compacted: of_point(0.0),
            dilation: of_point(dilation),
            work: of_point(middle * contraction(both, point.strain)),
            middle: of_point(middle),
            volume: of_point(end),
            mass: of_point(1.0),
        };
        point.compacted = self.pressure.advance(&mut update, point.state) / end;
        point.state[STRAIN] += flow;
        point.state[DILATION] += dilation;
        point.return_to_deviator(-update.mean[0], deviator, 0.0);
        point.moduli.bulk = update.bulk[0];
    }
}
