//! Strains and energies of elements that are integrated over increments for output only.
#![allow(clippy::needless_range_loop)] // Loops over lanes, as in the inner loop.

use pulp::NullaryFnOnce;

use crate::kernel::lanes::Lanes;
use crate::kernel::lanes::column;
use crate::kernel::lanes::{InlineMap, LANES};
use crate::kernel::rotation::{rotate, rotation_of_spin};
use crate::material::PlasticFlow;
use crate::material::increment::{StrainIncrement, StressUpdate};
use crate::state::archive::Persist;
use crate::variables::{Variable, VariableComponent};

/// Output variables of the elements of a block.
#[derive(Clone, Copy, Debug, Default, Persist)]
pub struct BlockRecord {
    /// Logarithmic strain rr, zz, hoop, rz (tensor component), integrated with the rotation of the stress.
    strain: [Lanes; 4],
    /// Plastic strain, same components.
    plastic: [Lanes; 4],
    /// Strain rate of the previous increment.
    rate: [Lanes; 4],
    /// Work of the stress, its plastically dissipated part, work of hourglass control, and loss by damage.
    work: [Lanes; 4],
}

/// Recorded values of one element; tensors as rr, zz, hoop, rz with tensor shear.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ElementRecord {
    /// Logarithmic strain.
    pub strain: [f64; 4],
    pub plastic: [f64; 4],
    /// Strain rate, 1/time.
    pub rate: [f64; 4],
    /// Recoverable energy, energy dissipated by plastic flow, work of hourglass control, and loss by damage.
    pub energy: [f64; 4],
}

impl ElementRecord {
    /// Returns a recorded component; strains with engineering shear, as in ABAQUS.
    pub(super) fn value(&self, part: VariableComponent) -> Option<f64> {
        let strain = |tensor: [f64; 4]| {
            let component = *tensor.get(part.component)?;
            Some(if part.component == 3 { 2.0 * component } else { component })
        };
        match part.variable {
            Variable::LogarithmicStrain => strain(self.strain),
            Variable::PlasticComponents => strain(self.plastic),
            Variable::StrainRate => strain(self.rate),
            Variable::ElementStrainEnergy => Some(self.energy[0]),
            Variable::ElementPlasticEnergy => Some(self.energy[1]),
            Variable::ElementArtificialEnergy => Some(self.energy[2]),
            Variable::ElementDamageEnergy => Some(self.energy[3]),
            _ => None,
        }
    }
}

/// Operation that updates a record after the stress update. It is a separate function, so that it is compiled once per
/// instruction set and not for each material.
pub(super) struct RecordUpdate<'a> {
    pub record: &'a mut BlockRecord,
    pub flow: PlasticFlow,
    pub spins: Lanes,
    pub dt: f64,
    pub increment: &'a StrainIncrement,
    pub update: &'a StressUpdate,
}

impl NullaryFnOnce for RecordUpdate<'_> {
    type Output = ();

    #[inline(always)]
    fn call(mut self) {
        // A local copy: with references, compilers must assume that a write may change other fields.
        let mut record = *self.record;
        self.follow(&mut record);
        match self.flow {
            PlasticFlow::None | PlasticFlow::Unknown => {}
            PlasticFlow::Coupled => self.add_material_flow(&mut record),
            PlasticFlow::Deviatoric => self.flow_along_deviator(&mut record),
        }
        *self.record = record;
    }
}

impl RecordUpdate<'_> {
    #[inline(always)]
    fn follow(&mut self, record: &mut BlockRecord) {
        let per_dt = if self.dt > 0.0 { 1.0 / self.dt } else { 0.0 };
        for l in 0..LANES {
            let turn = rotation_of_spin(self.spins[l]);
            let (strain, plastic) = (rotate(column(&record.strain, l), turn), rotate(column(&record.plastic, l), turn));
            let increment = column(&self.increment.strain, l);
            for i in 0..4 {
                record.strain[i][l] = strain[i] + increment[i];
                record.plastic[i][l] = plastic[i];
                record.rate[i][l] = per_dt * increment[i];
            }
        }
    }

    #[inline(always)]
    fn add_material_flow(&self, record: &mut BlockRecord) {
        for l in 0..LANES {
            for i in 0..4 {
                record.plastic[i][l] += self.update.plastic[i][l];
            }
        }
    }

    /// Adds associated plastic flow: 3/2 dp s/q in the direction of the trial deviator.
    #[inline(always)]
    fn flow_along_deviator(&self, record: &mut BlockRecord) {
        for l in 0..LANES {
            let (flow, trial) = (self.update.flow[l], self.update.trial[l]);
            let (flows, per) = (flow > 0.0, 1.5 * flow / trial);
            for i in 0..4 {
                let (previous, along) = (record.plastic[i][l], self.update.deviator[i][l]);
                record.plastic[i][l] = if flows { previous + per * along } else { previous };
            }
        }
    }
}

impl BlockRecord {
    /// Returns the values per mass that move with the material, and the energies of the elements.
    pub(super) fn carried(&mut self) -> ([&mut Lanes; 12], &mut [Lanes; 4]) {
        let BlockRecord { strain: [a, b, c, d], plastic: [e, f, g, h], rate: [i, j, k, l], work } = self;
        ([a, b, c, d, e, f, g, h, i, j, k, l], work)
    }

    /// Adds the work of the stress, of hourglass control, the loss by damage, and the dissipation by plastic flow and
    /// damage in an increment. User materials record their plastic work themselves.
    pub(super) fn add_energies(&mut self, [stress, artificial, damage, dissipated]: &[Lanes; 4], flow: PlasticFlow) {
        let is_recorded = !matches!(flow, PlasticFlow::Unknown);
        for l in 0..LANES {
            self.work[1][l] += if is_recorded { dissipated[l] - damage[l] } else { 0.0 };
            self.work[0][l] += stress[l];
            self.work[2][l] += artificial[l];
            self.work[3][l] += damage[l];
        }
    }

    /// Adds work of the stress and loss by damage to one element.
    pub(super) fn add_to_lane(&mut self, lane: usize, [stress, damage]: [f64; 2]) {
        self.work[0][lane] += stress;
        self.work[3][lane] += damage;
    }

    /// Returns the recorded values of one element.
    pub(super) fn of(&self, lane: usize) -> ElementRecord {
        let tensor = |x: &[Lanes; 4]| [0, 1, 2, 3].inline_map(|i| x[i][lane]);
        let [work, plastic, artificial, damage] = [0, 1, 2, 3].inline_map(|i| self.work[i][lane]);
        ElementRecord {
            strain: tensor(&self.strain),
            plastic: tensor(&self.plastic),
            rate: tensor(&self.rate),
            energy: [work - plastic - damage, plastic, artificial, damage],
        }
    }
}
