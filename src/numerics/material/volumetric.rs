//! Pressure laws: mean stress as a function of the volume change.

use super::available::AvailableEnergy;
use super::{BlockStart, PointValue};
use crate::kernel::lanes::Lanes;
use crate::material::carried::CarriedState;
use crate::state::archive::Persist;
use crate::variables::Variable;

/// Volumetric part of a material. A constant bulk modulus is a type without state or cost.
pub trait VolumetricLaw: Send + Sync + 'static {
    /// State variables of a block of elements.
    type State: Clone + Send + Sync + Persist + CarriedState;

    /// Whether the law is an equation of state, i.e. not a constant bulk modulus times the volumetric strain.
    const EOS: bool;

    /// Returns the initial state of a block.
    fn fresh(&self, start: &BlockStart) -> Self::State;

    /// Updates mean stress and tangent bulk modulus over an increment.
    fn update_pressure(&self, state: &mut Self::State, update: &mut PressureUpdate);

    /// Begins an increment that ends at this total time.
    fn begin(&self, _state: &mut Self::State, _now: f64) {}

    /// Adds heat (energy) in addition to the estimate of [`VolumetricLaw::update_pressure`].
    fn add_heat(&self, _state: &mut Self::State, _heat: &Lanes, _mass: &Lanes) {}

    /// Returns an output variable of a lane other than the temperature; `None` if the law does not compute it.
    fn value(&self, _state: &Self::State, _lane: usize, _variable: Variable) -> Option<f64> {
        None
    }

    /// Sets a value of a lane: specific energy, initial temperature if it determines the energy, or ratio of volumes.
    /// Returns whether the law uses it.
    fn set(&self, _state: &mut Self::State, _lane: usize, _value: PointValue) -> bool {
        false
    }

    /// Returns the temperature of a lane, if the specific energy determines it.
    fn temperature(&self, _state: &Self::State, _lane: usize) -> Option<f64> {
        None
    }

    /// See [`Material::prepare_transport`](super::Material::prepare_transport).
    fn prepare_transport(&self, _state: &mut Self::State) {}

    /// See [`Material::volume_ratio`](super::Material::volume_ratio).
    fn volume_ratio(&self, _state: &Self::State, _lane: usize) -> Option<f64> {
        None
    }

    /// Returns the energy per mass that a lane can release from its initial state.
    fn available_energy(&self, _state: &Self::State, _lane: usize, _specific_volume: f64) -> AvailableEnergy {
        AvailableEnergy::NONE
    }

    /// Returns the recoverable volumetric energy of an element: the work of its pressure on the isentrope to zero
    /// pressure. Tension is at most `limit`, and counts below it. `None` for laws whose pressure has a constant modulus.
    fn recoverable_energy(
        &self,
        _state: &Self::State,
        _lane: usize,
        _element: ElementSize,
        _limit: f64,
    ) -> Option<f64> {
        None
    }

    /// See [`Material::prepare_scaling`](super::Material::prepare_scaling).
    fn prepare_scaling(&self, _state: &mut Self::State) {}

    /// See [`Material::bulk_modulus`](super::Material::bulk_modulus).
    fn bulk_modulus(&self, _state: &Self::State, _lane: usize, _element: ElementSize) -> Option<f64> {
        None
    }

    /// Returns the number of bytes that the state of a block needs in addition to its own size.
    fn bytes(&self, _state: &Self::State) -> usize {
        0
    }
}

/// Inputs and results of a pressure law for one block. It owns its lists: loops over lists that may overlap in memory are
/// only partly turned into vectors.
pub struct PressureUpdate {
    /// Mean stress: previous value on entry, result on return.
    pub mean: Lanes,
    /// Result: isentropic bulk modulus.
    pub bulk: Lanes,
    /// Bulk viscosity stress of the previous increment.
    pub viscous: Lanes,
    /// Result: estimated work of the bulk viscosity.
    pub heat: Lanes,
    /// Result: energy that the collapse of pores dissipates; 0 on entry.
    pub compacted: Lanes,
    /// Volumetric strain increment.
    pub dilation: Lanes,
    /// Work of the deviatoric stress in the increment, energy.
    pub work: Lanes,
    /// Volume in the middle of the increment; 0 for lanes without element.
    pub middle: Lanes,
    /// Current volume.
    pub volume: Lanes,
    /// Mass of the element of each lane.
    pub mass: Lanes,
}

/// Current volume and mass of an element.
#[derive(Clone, Copy, Debug)]
pub struct ElementSize {
    pub volume: f64,
    pub mass: f64,
}

/// Volumetric law without equation of state: the pressure follows from a constant bulk modulus.
#[derive(Clone, Copy, Debug)]
pub struct ConstantBulkModulus;

impl VolumetricLaw for ConstantBulkModulus {
    type State = ();
    const EOS: bool = false;

    fn fresh(&self, _start: &BlockStart) {}

    #[inline(always)]
    fn update_pressure(&self, (): &mut (), _update: &mut PressureUpdate) {}
}
