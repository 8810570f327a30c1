//! How the mean stress answers to a change of volume.
//! Never here: deviators, forces.

use crate::kernel::lanes::Lanes;
use crate::state::archive::Persist;

/// The volumetric part of a material. A constant bulk modulus is a type without state, and costs nothing.
pub trait Volumetric: Send + Sync + 'static {
    /// What a block of elements keeps.
    type State: Clone + Send + Sync + Persist;

    /// Whether the pressure is other than a constant bulk modulus times the dilation.
    const EOS: bool;

    /// Whether the deviator, too, follows from the whole deformation: [`Volumetric::stretch`] takes the place of
    /// [`Volumetric::squeeze`].
    const TOTAL: bool = false;

    /// Whether something flows: the trial is elastic with the moduli of the group, which stay the upper bounds, and
    /// [`Volumetric::stretch`] brings it back.
    const FLOWS: bool = false;

    /// Whether the answer depends on the time: [`Volumetric::begin`] is told it.
    const TIMED: bool = false;

    /// State of a block at the start.
    fn fresh(&self) -> Self::State;

    /// Mean stress and tangent bulk modulus at the end of an increment.
    fn squeeze(&self, state: &mut Self::State, ask: Squeeze<'_>);

    /// Mean stress, deviator and modulus at the end of an increment, by the whole deformation.
    fn stretch(&self, _state: &mut Self::State, _ask: Stretch<'_>) {}

    /// An increment that ends at this total time begins.
    fn begin(&self, _state: &mut Self::State, _now: f64) {}

    /// Where an element lies at the start, `[r, z]` of its middle, and its length.
    fn place(&self, _state: &mut Self::State, _lane: usize, _middle: [f64; 2], _length: f64) {}

    /// Plastic strain of a lane, where something flows.
    fn plastic_strain(&self, _state: &Self::State, _lane: usize) -> Option<f64> {
        None
    }

    /// Share of an explosive that has burnt, where it is one.
    fn burnt(&self, _state: &Self::State, _lane: usize) -> Option<f64> {
        None
    }

    /// Takes up heat beyond what [`Volumetric::squeeze`] expected (energy).
    fn settle(&self, _state: &mut Self::State, _heat: &Lanes, _mass: &Lanes) {}

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
}

/// One block's question to its volumetric law.
pub struct Squeeze<'a> {
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

/// One block's question to a law of the whole deformation.
pub struct Stretch<'a> {
    /// Strain increments rr, zz, hoop, rz in the middle of the increment.
    pub strain: &'a [Lanes; 4],
    /// Spin increments.
    pub spin: &'a Lanes,
    /// Length of the increment.
    pub dt: f64,
    /// Mean stress of the elastic trial; the answer.
    pub mean: &'a mut Lanes,
    /// Deviator of the elastic trial; the answer.
    pub deviator: &'a mut [Lanes; 4],
    /// Answer of what flows: plastic strain increments rr, zz, hoop, rz, and the energy dissipated a volume.
    pub plastic: &'a mut [Lanes; 4],
    /// See [`Stretch::plastic`].
    pub dissipated: &'a mut Lanes,
    /// Answer: modulus of a wave less 4/3 of the shear modulus at the start.
    pub bulk: &'a mut Lanes,
    /// Answer: shear modulus now, the mean over all directions.
    pub shear: &'a mut Lanes,
    /// Answer: zero.
    pub heat: &'a mut Lanes,
}

/// A constant bulk modulus.
#[derive(Clone, Copy, Debug)]
pub struct Linear;

impl Volumetric for Linear {
    type State = ();
    const EOS: bool = false;

    fn fresh(&self) {}

    #[inline(always)]
    fn squeeze(&self, (): &mut (), _ask: Squeeze<'_>) {}
}
