//! Material laws: one trait for all laws, one file per law. Laws know neither elements nor meshes.

pub mod available;
pub mod carried;
pub mod compaction;
pub mod eos;
pub mod equation_of_state;
pub mod explosive;
pub mod failed;
pub mod failure;
pub mod foam;
#[cfg(test)]
mod hardening_combinations;
pub mod hyperelastic;
pub mod increment;
mod isentrope;
pub mod kinematic;
pub mod kinematic_rate;
pub mod plasticity;
pub mod point_law;
pub mod returns;
pub mod strain_energy;
pub mod user;
pub mod user_eos;
pub mod volumetric;
pub mod von_mises;

use crate::kernel::lanes::{LANES, Lanes};
use crate::state::archive::Persist;
use crate::variables::VariableComponent;
use available::AvailableEnergy;
use carried::{ArrivedElement, CarriedState};
use increment::{StrainIncrement, StressUpdate};
use user::PointCalls;
use volumetric::ElementSize;

/// The direction of plastic flow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlasticFlow {
    None,
    /// Along the deviator of the trial stress, by [`StressUpdate::flow`].
    Deviatoric,
    /// With a volumetric part; [`StressUpdate::plastic`] holds the plastic strain increments.
    Coupled,
    /// Unknown: the law is a user subroutine or a law in Rust.
    Unknown,
}

/// Elements of a block at the start of the analysis. Lanes without element repeat the last one.
#[derive(Clone, Copy, Debug)]
pub struct BlockStart {
    /// Elements of the block.
    pub count: usize,
    /// Areas of the meridional sections of the elements.
    pub area: Lanes,
    /// Volumes of the elements.
    pub volume: Lanes,
    /// Centres, `[r, z]`.
    pub centre: [Lanes; 2],
    /// Corners of each lane: their r, then their z.
    pub corners: [[[f64; 4]; 2]; LANES],
    /// Index of the first element in its group.
    pub first: usize,
}

/// A value prescribed to a material point, at the start of the analysis unless stated otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointValue {
    /// Stress rr, zz, hoop, rz.
    Stress([f64; 4]),
    /// Temperature of the start.
    Temperature(f64),
    /// Temperature of the nodes at the end of an increment.
    NodalTemperature(f64),
    /// Thermal strain that the next increment subtracts.
    ThermalStrain(f64),
    /// Initial internal energy per mass.
    SpecificEnergy(f64),
    /// Initial equivalent plastic strain.
    PlasticStrain(f64),
    /// Characteristic length of an integration point, by its index; otherwise the square root of the section area.
    Length(usize, f64),
    /// State variable of the user, by its index.
    StateVariable(usize, f64),
    /// Field variable, by its index.
    Field(usize, f64),
    /// Field variable of the nodes at the end of an increment.
    NodalField(usize, f64),
    /// Ratio of volumes ([`Material::volume_ratio`]), after a change of the mesh.
    VolumeRatio(f64),
    /// Factor of mass scaling on the mass of the element.
    MassScale(f64),
}

/// A material law: it computes the stress of a block of elements. The associated constants select the code that is
/// compiled for its elements; unused features have no cost.
pub trait Material: Send + Sync + 'static {
    /// State variables of a block of elements.
    type State: Clone + Send + Sync + Persist + CarriedState;

    /// Direction of plastic flow. [`PlasticFlow::Deviatoric`] and [`PlasticFlow::Unknown`] laws are given the von Mises
    /// stress of the trial.
    const FLOW: PlasticFlow = PlasticFlow::None;
    /// Whether [`Material::update`] gives the moduli ([`StressUpdate::bulk`], [`StressUpdate::shear`]) in every
    /// increment.
    const MODULI_VARY: bool = false;
    /// Whether the pressure follows from density and energy. The element then closes its energy balance with
    /// [`Material::add_heat`].
    const EQUATION_OF_STATE: bool = false;
    /// Whether [`Material::share`] can fall below 1.
    const FAILS: bool = false;
    /// Whether [`StrainIncrement::spin`] is used.
    const USES_SPIN: bool = false;
    /// Whether the stress follows from the deformation gradient: its work is that of
    /// [`StressUpdate::set_total_stress`](increment::StressUpdate::set_total_stress).
    const OF_GRADIENT: bool = false;
    /// Whether [`StrainIncrement::place`] is used.
    const USES_PLACE: bool = false;
    /// Whether [`Material::calls`] calls user subroutines between the kinematics of elements and [`Material::update`].
    const CALLS: bool = false;

    /// Returns the state of a block at the start of the analysis.
    fn initial_state(&self, start: &BlockStart) -> Self::State;

    /// Begins an increment that ends at this total time.
    fn begin(&self, _state: &mut Self::State, _total_time: f64) {}

    /// Updates state and stress (rr, zz, hoop, rz) over an increment. `update` holds the elastic trial on entry.
    fn update(
        &self,
        state: &mut Self::State,
        stress: &mut [Lanes; 4],
        strain: &StrainIncrement,
        update: &mut StressUpdate,
    );

    /// Adds heat (energy) that the element found after [`Material::update`].
    fn add_heat(&self, _state: &mut Self::State, _heat: &Lanes, _mass: &Lanes) {}

    /// Returns the initial bulk modulus of a law with varying moduli, where the constants of the elements have none.
    fn initial_bulk(&self) -> f64 {
        0.0
    }

    /// Returns whether a law of [`PlasticFlow::Coupled`] has a pressure that follows from the density, with moduli that can
    /// exceed the initial ones.
    fn holds_pressure(&self) -> bool {
        false
    }

    /// Returns the share of the stress that damage leaves, 0 for a deleted element.
    fn share(&self, _state: &Self::State, _lane: usize) -> f64 {
        1.0
    }

    /// Returns the share of the mean stress that damage leaves, where it is not that of the stress.
    fn mean_share(&self, state: &Self::State, lane: usize) -> f64 {
        self.share(state, lane)
    }

    fn can_delete(&self) -> bool {
        Self::FAILS
    }

    /// Returns the volume of an element at the start of the analysis, where the material fails.
    fn initial_volume(&self, _state: &Self::State, _lane: usize) -> f64 {
        1.0
    }

    /// Returns the von Mises stress at which each of the first `count` elements begins to yield at rest; `None` without
    /// a hardening law.
    fn yield_stress(&self, _state: &Self::State, _shear: f64, _count: usize) -> Option<Lanes> {
        None
    }

    /// Returns an output variable of an element; `None` where the material does not have it.
    fn value(&self, _state: &Self::State, _lane: usize, _part: VariableComponent) -> Option<f64> {
        None
    }

    /// Returns the energy per mass that an element can release from its initial state, apart from that of its initial
    /// stress.
    fn available_energy(&self, _state: &Self::State, _lane: usize, _specific_volume: f64) -> AvailableEnergy {
        AvailableEnergy::NONE
    }

    /// Returns the recoverable energy of the volume change of an element with an equation of state, from its current
    /// volume and mass: the work of the undamaged material on the isentrope to zero pressure. `None` without an equation
    /// of state.
    fn recoverable_energy(&self, _state: &Self::State, _lane: usize, _element: ElementSize) -> Option<f64> {
        None
    }

    /// Sets a value of an element. Returns whether the material uses it.
    fn set(&self, _state: &mut Self::State, _lane: usize, _value: PointValue) -> bool {
        false
    }

    /// Returns whether all variables of the state can move from element to element in an adaptive mesh.
    fn can_be_carried(&self) -> bool {
        true
    }

    /// Allocates what [`Material::arrive`] needs, before the first increment.
    fn prepare_transport(&self, _state: &mut Self::State) {}

    /// Returns the volume of the material in an element, its mass times the specific volume from which the pressure
    /// follows, over the volume of the element. It differs from 1 after a change of the mesh that gives the element
    /// another volume than its material has. `None` if no pressure follows from the density.
    fn volume_ratio(&self, _state: &Self::State, _lane: usize) -> Option<f64> {
        None
    }

    /// Allocates what [`PointValue::MassScale`] needs. A density from which a pressure follows is that without mass scaling.
    fn prepare_scaling(&self, _state: &mut Self::State) {}

    /// Returns the current isentropic bulk modulus of an element of this size; `None` if the material has none without an
    /// increment.
    fn bulk_modulus(&self, _state: &Self::State, _lane: usize, _element: ElementSize) -> Option<f64> {
        None
    }

    /// Completes the state of an element whose variables have been transported ([`CarriedState`]).
    fn arrive(&self, _state: &mut Self::State, _lane: usize, _element: &ArrivedElement) {}

    /// Returns the calls of user subroutines.
    fn calls(&self) -> Option<&dyn PointCalls<Self::State>> {
        None
    }

    /// Returns the heap memory of a block's state in bytes.
    fn bytes(&self, _state: &Self::State) -> usize {
        0
    }
}
