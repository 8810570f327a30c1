//! The equation of state of a material, with the specific energy of each element. The laws are in `eos` and
//! `explosive`.
#![allow(clippy::needless_range_loop)] // Loops over lanes are written as in the laws.

use super::available::AvailableEnergy;
use super::compaction::{DistensionState, PorousCompaction};
use super::eos::{EosLine, IdealGas, LinearEos, Tabulated, UsUp, advance_block};
use super::explosive::{BurnState, HighExplosive};
use super::isentrope::{end_of_limited_tension, isentropic_work};
use super::user_eos::UserEos;
use super::volumetric::{ElementSize, PressureUpdate, VolumetricLaw};
use super::{BlockStart, PointValue};
use crate::kernel::lanes::{LANES, Lanes};
use crate::material::carried::carried_state;
use crate::state::archive::Persist;
use crate::variables::Variable;

/// An equation of state with the energy of each element. One enum for all laws, matched once per block: with one type
/// per law, every hardening law and failure criterion would be compiled once more for each.
#[derive(Clone, Debug)]
pub enum EquationOfState {
    IdealGas(IdealGas),
    UsUp(UsUp),
    Tabulated(Tabulated),
    Explosive(HighExplosive),
    /// Porous material that compacts.
    Compacting(PorousCompaction),
    User(UserEos),
}

/// State variables of a block.
#[derive(Clone, Debug, Persist)]
#[persist(present: burn, distension, mass_factors, mass_scales)]
pub struct EosState {
    /// Specific energy, energy per mass.
    energy: Lanes,
    /// Burn fractions; for explosives only.
    burn: Option<Box<BurnState>>,
    /// Distensions; for porous materials only.
    distension: Option<Box<DistensionState>>,
    /// Mass of the material over the mass of the element, for meshes that do not follow the material
    /// ([`Material::volume_ratio`]) and for scaled masses.
    ///
    /// [`Material::volume_ratio`]: super::Material::volume_ratio
    mass_factors: Option<Box<Lanes>>,
    /// Factors of mass scaling, which the mass of the material does not have.
    mass_scales: Option<Box<Lanes>>,
}

impl EosState {
    fn new(energy: f64, burn: Option<Box<BurnState>>) -> EosState {
        EosState { energy: [energy; LANES], burn, distension: None, mass_factors: None, mass_scales: None }
    }

    /// Returns the factor of mass scaling.
    fn scale(&self, lane: usize) -> f64 {
        self.mass_scales.as_ref().map_or(1.0, |scales| scales[lane])
    }
}

impl EquationOfState {
    /// Returns specific heat and absolute zero, for laws with a specific heat.
    fn thermal(&self) -> Option<[f64; 2]> {
        match self {
            EquationOfState::IdealGas(law) => Some([law.specific_heat, law.absolute_zero]),
            _ => None,
        }
    }

    /// Returns the isentropic bulk modulus at a specific volume and energy; `None` for explosives, which have two laws, and
    /// materials with pores, whose modulus depends on their distension.
    fn bulk_modulus(&self, specific_volume: f64, energy: f64) -> Option<f64> {
        let density = 1.0 / specific_volume;
        Some(match self {
            EquationOfState::IdealGas(law) => law.curve(density, specific_volume).bulk_modulus(law, density, energy),
            EquationOfState::UsUp(law) => law.curve(density, specific_volume).bulk_modulus(law, density, energy),
            EquationOfState::Tabulated(law) => law.bulk_modulus(specific_volume, energy),
            EquationOfState::User(law) => law.bulk_modulus(density, energy),
            EquationOfState::Explosive(_) | EquationOfState::Compacting(_) => return None,
        })
    }

    /// Returns the work per mass on the isentrope from a specific volume and energy to zero pressure, where the tension
    /// is below `limit`. Explosives release the energy of the unburnt fraction; that of the products is chemical.
    fn isentropic_work(&self, [specific_volume, energy]: [f64; 2], unburnt: f64, limit: f64) -> f64 {
        match self {
            EquationOfState::IdealGas(law) => {
                let line = |volume: f64| law.curve(1.0 / volume, volume);
                let [volume, energy] = end_of_limited_tension(line, law.ambient(), limit, [specific_volume, energy]);
                law.available_energy(volume, energy)
            }
            EquationOfState::UsUp(law) => {
                isentropic_work_below(|volume: f64| law.curve(1.0 / volume, volume), [specific_volume, energy], limit)
            }
            EquationOfState::Tabulated(law) => {
                isentropic_work_below(|volume: f64| law.line(volume), [specific_volume, energy], limit)
            }
            EquationOfState::User(law) => {
                isentropic_work_below(|volume: f64| law.line(volume, energy), [specific_volume, energy], limit)
            }
            EquationOfState::Explosive(law) => unburnt * law.unburnt_energy(specific_volume),
            // Its isentrope needs the state.
            EquationOfState::Compacting(_) => 0.0,
        }
    }
}

/// Returns the isentropic work from a specific volume and energy, where the tension is below `limit`.
fn isentropic_work_below(line: impl Fn(f64) -> EosLine, start: [f64; 2], limit: f64) -> f64 {
    let [volume, energy] = end_of_limited_tension(&line, 0.0, limit, start);
    isentropic_work(line, 0.0, volume, energy)
}

impl VolumetricLaw for EquationOfState {
    type State = EosState;
    const EOS: bool = true;

    fn fresh(&self, start: &BlockStart) -> EosState {
        match self {
            EquationOfState::Explosive(law) => EosState::new(law.energy, Some(Box::new(law.start_burn(start)))),
            EquationOfState::Compacting(law) => {
                EosState { distension: Some(Box::new(law.start())), ..EosState::new(0.0, None) }
            }
            _ => EosState::new(0.0, None),
        }
    }

    #[inline(always)]
    fn begin(&self, state: &mut EosState, now: f64) {
        if let Some(burn) = &mut state.burn {
            burn.advance(now);
        }
    }

    /// Equation (18.17).
    #[inline(always)]
    fn update_pressure(&self, state: &mut EosState, update: &mut PressureUpdate) {
        if let Some(factors) = &state.mass_factors {
            for l in 0..LANES {
                update.mass[l] *= factors[l];
            }
        }
        match self {
            EquationOfState::IdealGas(law) => advance_block(law, &mut state.energy, update),
            EquationOfState::UsUp(law) => advance_block(law, &mut state.energy, update),
            EquationOfState::Tabulated(law) => law.advance_block(&mut state.energy, update),
            EquationOfState::User(law) => law.advance_block(&mut state.energy, update),
            EquationOfState::Explosive(law) => {
                if let Some(burn) = &state.burn {
                    law.advance_block(burn, &mut state.energy, update);
                }
            }
            EquationOfState::Compacting(law) => {
                if let Some(distension) = &mut state.distension {
                    law.advance_block(distension, &mut state.energy, update);
                }
            }
        }
    }

    #[inline(always)]
    fn add_heat(&self, state: &mut EosState, heat: &Lanes, mass: &Lanes) {
        if let Some(factors) = &state.mass_factors {
            for l in 0..LANES {
                state.energy[l] += heat[l] / (mass[l] * factors[l]);
            }
            return;
        }
        for l in 0..LANES {
            state.energy[l] += heat[l] / mass[l];
        }
    }

    fn value(&self, state: &EosState, lane: usize, variable: Variable) -> Option<f64> {
        match variable {
            Variable::BurnFraction => state.burn.as_ref().map(|burn| burn.share(lane)),
            Variable::SpecificEnergy => Some(state.energy[lane]),
            Variable::Distension => state.distension.as_ref().map(|distension| distension.current(lane)),
            _ => None,
        }
    }

    fn set(&self, state: &mut EosState, lane: usize, value: PointValue) -> bool {
        let scale = state.scale(lane);
        match (value, self.thermal(), &mut state.mass_factors) {
            (PointValue::SpecificEnergy(energy), ..) => state.energy[lane] = energy,
            (PointValue::Temperature(temperature), Some([heat, zero]), _) => {
                state.energy[lane] = heat * (temperature - zero);
            }
            (PointValue::VolumeRatio(ratio), _, Some(factors)) => factors[lane] = 1.0 / (ratio * scale),
            (PointValue::MassScale(now), _, Some(factors)) => {
                factors[lane] *= scale / now;
                state.mass_scales.iter_mut().for_each(|scales| scales[lane] = now);
            }
            _ => return false,
        }
        true
    }

    fn available_energy(&self, state: &EosState, lane: usize, specific_volume: f64) -> AvailableEnergy {
        let energy = state.energy[lane];
        if let EquationOfState::Explosive(_) = self {
            let from = state.burn.as_ref().map_or(f64::INFINITY, |burn| burn.arrival(lane));
            return AvailableEnergy { energy: energy.max(0.0), from };
        }
        AvailableEnergy::initial(self.isentropic_work([specific_volume, energy], 0.0, f64::INFINITY))
    }

    #[cold]
    fn recoverable_energy(&self, state: &EosState, lane: usize, element: ElementSize, limit: f64) -> Option<f64> {
        let mass = element.mass * state.mass_factors.as_ref().map_or(1.0, |factors| factors[lane]);
        if let (EquationOfState::Compacting(law), Some(distension)) = (self, &state.distension) {
            let line = |volume: f64| law.unloading_line(distension, lane, [volume, state.energy[lane]]);
            return Some(mass * isentropic_work_below(line, [element.volume / mass, state.energy[lane]], limit));
        }
        let unburnt = state.burn.as_ref().map_or(0.0, |burn| 1.0 - burn.share(lane));
        Some(mass * self.isentropic_work([element.volume / mass, state.energy[lane]], unburnt, limit))
    }

    fn temperature(&self, state: &EosState, lane: usize) -> Option<f64> {
        self.thermal().map(|[heat, zero]| zero + state.energy[lane] / heat)
    }

    fn bytes(&self, state: &EosState) -> usize {
        let EosState { energy: _, burn, distension, mass_factors, mass_scales } = state;
        let lanes = [mass_factors, mass_scales].into_iter().flatten().map(|lanes| size_of_val(&**lanes));
        let distensions = distension.as_deref().map_or(0, size_of_val);
        burn.as_deref().map_or(0, size_of_val) + distensions + lanes.sum::<usize>()
    }

    fn prepare_scaling(&self, state: &mut EosState) {
        self.prepare_transport(state);
        state.mass_scales.get_or_insert_with(|| Box::new([1.0; LANES]));
    }

    fn bulk_modulus(&self, state: &EosState, lane: usize, ElementSize { volume, mass }: ElementSize) -> Option<f64> {
        let mass = mass * state.mass_factors.as_ref().map_or(1.0, |factors| factors[lane]);
        self.bulk_modulus(volume / mass, state.energy[lane])
    }

    fn prepare_transport(&self, state: &mut EosState) {
        state.mass_factors.get_or_insert_with(|| Box::new([1.0; LANES]));
    }

    fn volume_ratio(&self, state: &EosState, lane: usize) -> Option<f64> {
        state.mass_factors.as_ref().map(|factors| 1.0 / (factors[lane] * state.scale(lane)))
    }
}

// A change of the mesh sets the factors of mass afterwards.
carried_state!(EosState { energy, burn, distension, mass_factors } stay { mass_scales });
