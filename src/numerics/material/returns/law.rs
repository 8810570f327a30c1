//! Interface of laws that return an elastic trial stress to a yield surface, evaluated one material point at a time.

use std::any::Any;

use crate::kernel::lanes::InlineMap;
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::stress::{mises, pressure};
use crate::variables::VariableComponent;

/// A law with elastic moduli and a yield surface. It knows neither elements nor blocks; the state of a point is a list of
/// scalars.
pub trait StressReturn: Any + Send + Sync {
    /// Returns the name of the law for the ledger, with its options.
    fn describe(&self) -> String;

    /// Returns the initial moduli, which also determine hourglass control.
    fn moduli(&self) -> ElasticModuli;

    /// Returns the state of a point at the start of the analysis.
    fn initial_state(&self) -> Vec<f64>;

    /// Returns the index of the state that is an output variable; `None` if the law does not have the variable.
    fn output(&self, part: VariableComponent) -> Option<usize>;

    /// Returns the index of the state that prescribed initial hardening sets; `None` if the yield surface does not depend
    /// on the equivalent plastic strain.
    fn hardening_state(&self) -> Option<usize> {
        None
    }

    /// Returns whether the pressure follows from the density, with moduli that can exceed the initial ones.
    fn holds_pressure(&self) -> bool {
        false
    }

    /// Returns whether an increment of any length has the energy of a jump between its ends, so that a path may take it at once.
    fn is_exact_over_jumps(&self) -> bool {
        false
    }

    /// Returns whether the law deletes elements.
    fn deletes(&self) -> bool {
        false
    }

    /// Returns the recoverable energy per current volume of a stress and state.
    fn recoverable_energy(&self, stress: [f64; 4], _state: &[f64]) -> f64 {
        self.moduli().energy(stress)
    }

    /// Updates state and stress over an increment.
    fn update(&self, point: &mut ReturnPoint<'_>);
}

/// A material point in one increment. Tensors have the components rr, zz, hoop, rz (tensor shear) along the global axes.
#[derive(Debug)]
pub struct ReturnPoint<'a> {
    /// Strain increment.
    pub strain: [f64; 4],
    /// Previous stress, rotated with the spin of the material (Jaumann rate).
    pub carried: [f64; 4],
    /// That stress plus the elastic stress increment of [`StressReturn::moduli`].
    pub trial: TrialStress,
    /// Angle in the (r, z) plane by which the material has rotated since the start, radians.
    pub angle: f64,
    /// Length of the increment.
    pub dt: f64,
    /// Characteristic length of the element, from its initial section area ([`super::characteristic_length`]).
    pub length: f64,
    /// State of the point; the law updates it.
    pub state: &'a mut [f64],
    /// Moduli for the stable time increment, on entry those of [`StressReturn::moduli`].
    pub moduli: ElasticModuli,
    /// Result: stress.
    pub stress: [f64; 4],
    /// Result: plastic strain increment, whose work is dissipated.
    pub plastic: [f64; 4],
    /// Result: energy per current volume that compaction dissipates, less what bulking stores. It counts as plastic
    /// dissipation.
    pub compacted: f64,
    /// Result: elastic energy per current volume that damage removes; negative when stiffness recovers.
    pub lost: f64,
    /// Result: whether the element is deleted.
    pub deleted: bool,
}

/// Elastic trial stress, split into its invariants.
#[derive(Clone, Copy, Debug)]
pub struct TrialStress {
    /// Pressure, positive in compression.
    pub pressure: f64,
    /// Deviator.
    pub deviator: [f64; 4],
    /// Von Mises stress.
    pub mises: f64,
}

impl TrialStress {
    /// Splits a stress.
    #[inline(always)] // Into the loop over the points of a block.
    pub fn of(stress: [f64; 4]) -> TrialStress {
        let pressure = pressure(stress);
        let deviator = [stress[0] + pressure, stress[1] + pressure, stress[2] + pressure, stress[3]];
        TrialStress { pressure, deviator, mises: mises(stress) }
    }

    /// Returns a previous stress plus the elastic stress of a strain increment.
    #[inline(always)] // Into the loop over the points of a block.
    pub fn elastic(previous: [f64; 4], strain: [f64; 4], moduli: ElasticModuli) -> TrialStress {
        let mean = (moduli.bulk - 2.0 / 3.0 * moduli.shear) * (strain[0] + strain[1] + strain[2]);
        let change = |i: usize| 2.0 * moduli.shear * strain[i] + if i < 3 { mean } else { 0.0 };
        TrialStress::of([0, 1, 2, 3].inline_map(|i| previous[i] + change(i)))
    }

    /// Returns the stress.
    #[inline]
    pub fn stress(&self) -> [f64; 4] {
        let [rr, zz, hoop, rz] = self.deviator;
        [rr - self.pressure, zz - self.pressure, hoop - self.pressure, rz]
    }
}

impl<'a> ReturnPoint<'a> {
    /// Creates a point without results and without rotation, with an increment and a characteristic length of 1.
    pub fn new(strain: [f64; 4], carried: [f64; 4], state: &'a mut [f64], moduli: ElasticModuli) -> ReturnPoint<'a> {
        ReturnPoint {
            strain,
            carried,
            trial: TrialStress::elastic(carried, strain, moduli),
            angle: 0.0,
            dt: 1.0,
            length: 1.0,
            state,
            moduli,
            stress: carried,
            plastic: [0.0; 4],
            compacted: 0.0,
            lost: 0.0,
            deleted: false,
        }
    }

    /// Returns the volumetric strain increment, positive for expansion.
    pub fn dilation(&self) -> f64 {
        self.strain[0] + self.strain[1] + self.strain[2]
    }

    /// Advances the logarithm of the volume ratio, a state; returns the compression V0/V - 1.
    pub fn advance_volume(&mut self, dilation: usize) -> f64 {
        self.state[dilation] += self.dilation();
        libm::expm1(-self.state[dilation])
    }

    /// Returns the rate of the equivalent deviatoric strain, sqrt(2/3 e:e) over the length of the increment.
    pub fn deviatoric_rate(&self) -> f64 {
        let mean = self.dilation() / 3.0;
        let [rr, zz, hoop] = [0, 1, 2].inline_map(|i| self.strain[i] - mean);
        let square = rr * rr + zz * zz + hoop * hoop + 2.0 * self.strain[3] * self.strain[3];
        if self.dt > 0.0 { (2.0 / 3.0 * square).sqrt() / self.dt } else { 0.0 }
    }

    /// Sets the stress to the trial: without plastic strain.
    #[inline]
    pub fn stay_elastic(&mut self) {
        (self.stress, self.plastic) = (self.trial.stress(), [0.0; 4]);
    }

    /// Sets the stress to a pressure and a von Mises stress along the deviator of the trial. The plastic strain has the
    /// deviator that returns the trial, and the given dilation.
    #[inline]
    pub fn return_to(&mut self, pressure: f64, mises: f64, dilation: f64) {
        let share = if self.trial.mises > 0.0 { mises / self.trial.mises } else { 1.0 };
        self.return_to_deviator(pressure, self.trial.deviator.inline_map(|part| share * part), dilation);
    }

    /// Sets the stress to a pressure and a deviator. The plastic strain has the deviator that returns the trial, and the
    /// given dilation. Equation (20.1).
    #[inline]
    pub fn return_to_deviator(&mut self, pressure: f64, deviator: [f64; 4], dilation: f64) {
        let per_shear = 1.0 / (2.0 * self.moduli.shear);
        (self.stress, self.plastic) = returned(self.trial.deviator, (pressure, deviator), dilation, per_shear);
    }

    /// Replaces the recoverable energy of the pressure (per initial volume, a state). The work of the pressure beyond its
    /// change is dissipated by compaction, in an increment that changes the law of the pressure. Equation (20.3).
    pub fn dissipate_volumetric_work(&mut self, energy: usize, recoverable: f64, compression: f64, changes: bool) {
        if changes {
            let dilation = self.dilation();
            let work = 0.5 * (pressure(self.carried) + pressure(self.stress)) * -dilation;
            // One over the ratio of volumes in the middle of the increment.
            let middle = (1.0 + compression) / (1.0 - 0.5 * dilation);
            self.compacted += work - (recoverable - self.state[energy]) * middle;
        }
        self.state[energy] = recoverable;
    }
}

/// Returns stress and plastic strain of a return of a trial deviator to a pressure and a deviator with a dilation, for one
/// over twice the shear modulus. Equation (20.1).
#[inline(always)] // Into the return of each point.
pub fn returned(
    trial: [f64; 4],
    (pressure, deviator): (f64, [f64; 4]),
    dilation: f64,
    per_shear: f64,
) -> ([f64; 4], [f64; 4]) {
    let third = dilation * (1.0 / 3.0);
    let [rr, zz, hoop, rz] = deviator;
    let [a, b, c, d] = [0, 1, 2, 3].inline_map(|i| (trial[i] - deviator[i]) * per_shear);
    // A sum with zero is never a negative zero.
    ([rr - pressure, zz - pressure, hoop - pressure, rz + 0.0], [a + third, b + third, c + third, d + 0.0])
}

/// Returns the determinant of a tensor rr, zz, hoop, rz.
#[inline(always)] // Into the return of each point.
pub fn determinant(tensor: [f64; 4]) -> f64 {
    tensor[2] * (tensor[0] * tensor[1] - tensor[3] * tensor[3])
}

/// Returns the double contraction of two tensors rr, zz, hoop, rz.
#[inline(always)] // Likewise.
pub fn contraction(a: [f64; 4], b: [f64; 4]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + 2.0 * a[3] * b[3])
}
