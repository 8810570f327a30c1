//! Pressure laws: the mean stress over the change of volume.
//! Never here: deviators, forces.

use super::BlockStart;
use crate::kernel::lanes::Lanes;
use crate::state::archive::Persist;

/// The volumetric part of a material. A constant bulk modulus is a type without state, and costs nothing.
pub trait Volumetric: Send + Sync + 'static {
    /// What a block of elements keeps.
    type State: Clone + Send + Sync + Persist;

    /// Whether the pressure is other than a constant bulk modulus times the dilation.
    const EOS: bool;

    /// Returns the state of a block at the start.
    fn fresh(&self, start: &BlockStart) -> Self::State;

    /// Updates mean stress and tangent bulk modulus over an increment.
    fn update_pressure(&self, state: &mut Self::State, update: PressureUpdate<'_>);

    /// Begins an increment that ends at this total time.
    fn begin(&self, _state: &mut Self::State, _now: f64) {}

    /// Share of an explosive that has burnt, where it is one.
    fn burnt(&self, _state: &Self::State, _lane: usize) -> Option<f64> {
        None
    }

    /// Adds heat (energy) beyond what [`Volumetric::update_pressure`] expected.
    fn add_heat(&self, _state: &mut Self::State, _heat: &Lanes, _mass: &Lanes) {}

    /// Energy a mass of a lane, where it is followed.
    fn energy(&self, _state: &Self::State, _lane: usize) -> Option<f64> {
        None
    }

    /// Sets the energy a mass at the start.
    fn set_energy(&self, _state: &mut Self::State, _lane: usize, _energy: f64) {}

    /// Temperature of a lane, where the energy gives it.
    fn temperature(&self, _state: &Self::State, _lane: usize) -> Option<f64> {
        None
    }

    /// Sets the energy by the temperature at the start.
    fn heat(&self, _state: &mut Self::State, _lane: usize, _temperature: f64) {}

    /// Returns the bytes that the state of a block holds in addition to its own size.
    fn bytes(&self, _state: &Self::State) -> usize {
        0
    }
}

/// Pressure update of a block.
pub struct PressureUpdate<'a> {
    /// Mean stress: before the increment; the answer after it.
    pub mean: &'a mut Lanes,
    /// Answer: isentropic bulk modulus.
    pub bulk: &'a mut Lanes,
    /// Stress of the bulk viscosity an increment before.
    pub viscous: &'a Lanes,
    /// Answer: work of the bulk viscosity that was expected.
    pub heat: &'a mut Lanes,
    /// Increment of the volumetric strain.
    pub dilation: &'a Lanes,
    /// Work of the deviator in the increment, energy.
    pub work: &'a Lanes,
    /// Volume in the middle of the increment; 0 for lanes without element.
    pub middle: &'a Lanes,
    /// Volume now.
    pub volume: &'a Lanes,
    /// Mass.
    pub mass: &'a Lanes,
}

/// A constant bulk modulus.
#[derive(Clone, Copy, Debug)]
pub struct Linear;

impl Volumetric for Linear {
    type State = ();
    const EOS: bool = false;

    fn fresh(&self, _start: &BlockStart) {}

    #[inline(always)]
    fn update_pressure(&self, (): &mut (), _update: PressureUpdate<'_>) {}
}
