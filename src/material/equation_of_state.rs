//! The equation of state of a material, one of all laws, with the energy of each element.
//! Never here: the laws.
#![allow(clippy::needless_range_loop)] // Loops over lanes are written as in the laws.

use super::BlockStart;
use super::eos::{IdealGas, Tabulated, UsUp, advance_block};
use super::explosive::{Burn, Explosive};
use super::volumetric::{PressureUpdate, Volumetric};
use crate::kernel::lanes::{LANES, Lanes};
use crate::state::archive::persist_struct;

/// An equation of state with the energy of each element. One type for all, chosen once a block: a type each would compile every
/// hardening law and failure criterion once more.
#[derive(Clone, Debug)]
pub enum EquationOfState {
    IdealGas(IdealGas),
    UsUp(UsUp),
    Tabulated(Tabulated),
    Explosive(Explosive),
}

/// What a block keeps under an equation of state.
#[derive(Clone, Debug)]
pub struct EosState {
    /// Energy a mass.
    energy: Lanes,
    /// Progress of the detonation; of explosives alone.
    burn: Option<Box<Burn>>,
}

impl EquationOfState {
    /// Heat capacity and absolute zero where there is a specific heat.
    fn thermal(&self) -> Option<[f64; 2]> {
        match self {
            EquationOfState::IdealGas(law) => Some([law.specific_heat, law.absolute_zero]),
            _ => None,
        }
    }
}

impl Volumetric for EquationOfState {
    type State = EosState;
    const EOS: bool = true;

    fn fresh(&self, start: &BlockStart) -> EosState {
        match self {
            EquationOfState::Explosive(law) => {
                EosState { energy: [law.energy; LANES], burn: Some(Box::new(law.start_burn(start))) }
            }
            _ => EosState { energy: [0.0; LANES], burn: None },
        }
    }

    #[inline(always)]
    fn begin(&self, state: &mut EosState, now: f64) {
        if let Some(burn) = &mut state.burn {
            burn.advance(now);
        }
    }

    #[inline(always)]
    fn update_pressure(&self, state: &mut EosState, ask: PressureUpdate<'_>) {
        match self {
            EquationOfState::IdealGas(law) => advance_block(law, &mut state.energy, ask),
            EquationOfState::UsUp(law) => advance_block(law, &mut state.energy, ask),
            EquationOfState::Tabulated(law) => advance_block(law, &mut state.energy, ask),
            EquationOfState::Explosive(law) => {
                if let Some(burn) = &state.burn {
                    law.advance_block(burn, &mut state.energy, ask);
                }
            }
        }
    }

    #[inline(always)]
    fn add_heat(&self, state: &mut EosState, heat: &Lanes, mass: &Lanes) {
        for l in 0..LANES {
            state.energy[l] += heat[l] / mass[l];
        }
    }

    fn burnt(&self, state: &EosState, lane: usize) -> Option<f64> {
        state.burn.as_ref().map(|burn| burn.share(lane))
    }

    fn energy(&self, state: &EosState, lane: usize) -> Option<f64> {
        Some(state.energy[lane])
    }

    fn set_energy(&self, state: &mut EosState, lane: usize, energy: f64) {
        state.energy[lane] = energy;
    }

    fn temperature(&self, state: &EosState, lane: usize) -> Option<f64> {
        self.thermal().map(|[heat, zero]| zero + state.energy[lane] / heat)
    }

    fn heat(&self, state: &mut EosState, lane: usize, temperature: f64) {
        if let Some([heat, zero]) = self.thermal() {
            state.energy[lane] = heat * (temperature - zero);
        }
    }

    fn bytes(&self, state: &EosState) -> usize {
        state.burn.as_deref().map_or(0, size_of_val)
    }
}

persist_struct!(EosState { energy, burn: present });
