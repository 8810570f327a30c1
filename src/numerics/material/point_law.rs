//! Adapter from a material law in Rust (`revolve::user::MaterialLaw`) to a material.

#![allow(clippy::needless_range_loop)] // Loops over lanes, with one array per quantity.

use std::sync::Arc;

use super::increment::{StrainIncrement, StressUpdate};
use super::{BlockStart, Material, PlasticFlow, PointValue};
use crate::kernel::heating::PlasticHeating;
use crate::kernel::lanes::{InlineMap, LANES, Lanes, column, inline_from_fn};
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::stress::mises;
use crate::material::carried::CarriedState;
use crate::material::hyperelastic::DeformationState;
use crate::routines::law::{MaterialLaw, MaterialPoint, PointQuantity};
use crate::state::archive::Persist;
use crate::variables::{Variable, VariableComponent};

/// A material law in Rust with the data of the deck. With `DETAILED` the law uses [`PointQuantity`] lists, and the moduli
/// vary; otherwise nothing but strains, stresses and state variables is computed.
pub struct PointLaw<const DETAILED: bool>(pub PointLawData);

/// Data of a [`PointLaw`].
pub struct PointLawData {
    pub law: Arc<dyn MaterialLaw>,
    /// Constants of `*USER MATERIAL`.
    pub constants: Vec<f64>,
    /// Number of state variables.
    pub variables: usize,
    /// Index of the state variable that deletes an element when it becomes zero.
    pub delete: Option<usize>,
    /// Upper bounds of the moduli.
    pub moduli: ElasticModuli,
    /// Initial mass per volume.
    pub density: f64,
    /// Temperature rise by dissipation.
    pub heating: PlasticHeating,
}

/// State variables of a block. The lists of quantities that the law does not use are empty.
#[derive(Clone, Debug, Persist)]
#[persist(fixed: variables, temperature, energy, moduli; present: deformation; derived: volume, total_time)]
pub struct PointState {
    /// State variables, point by point.
    variables: Vec<f64>,
    deleted: [bool; LANES],
    /// Initial volumes.
    volume: Lanes,
    total_time: f64,
    temperature: Vec<Lanes>,
    /// Internal energy per mass.
    energy: Vec<Lanes>,
    /// Bulk and shear modulus.
    moduli: Vec<Lanes>,
    deformation: Option<Box<DeformationState>>,
}

impl PointLawData {
    fn uses(&self, quantity: PointQuantity) -> bool {
        self.law.uses().contains(&quantity)
    }

    /// Sets the moduli that bound the stable time increment; the constants of the elements contain the shear modulus.
    fn set_moduli(&self, state: &PointState, update: &mut StressUpdate) {
        let [bulk, shear] = &state.moduli[..] else { return };
        for l in 0..LANES {
            update.bulk[l] = bulk[l] + 4.0 / 3.0 * (shear[l] - self.moduli.shear);
            update.shear[l] = shear[l];
        }
    }
}

impl PointState {
    /// Returns the ratio of the current to the initial volume of a lane.
    fn volume_ratio(&self, l: usize) -> f64 {
        self.deformation.as_ref().map_or(f64::NAN, |deformation| {
            let [rr, rz, zr, zz, hoop] = deformation.of(l);
            (rr * zz - rz * zr) * hoop
        })
    }

    /// Sets the quantities that the law uses; `density` is the initial one.
    fn describe(&self, point: &mut MaterialPoint<'_>, strain: &StrainIncrement, density: f64, l: usize) {
        let value = |list: &Vec<Lanes>| list.first().map_or(f64::NAN, |list| list[l]);
        (point.temperature, point.energy) = (value(&self.temperature), value(&self.energy));
        point.density = density / self.volume_ratio(l);
        point.place = strain.place.inline_map(|list| list[l]);
        point.spin = strain.spin[l];
        if let Some(deformation) = &self.deformation {
            let [rr, rz, zr, zz, hoop] = deformation.of(l);
            point.gradient = [rr, zz, hoop, rz, zr];
        }
        if let [bulk, shear] = &self.moduli[..] {
            point.moduli = ElasticModuli { bulk: bulk[l], shear: shear[l] };
        }
    }
}

impl<const DETAILED: bool> Material for PointLaw<DETAILED> {
    type State = PointState;
    const FLOW: PlasticFlow = PlasticFlow::Unknown;
    const FAILS: bool = true;
    const MODULI_VARY: bool = DETAILED;
    const USES_SPIN: bool = DETAILED;
    const USES_PLACE: bool = DETAILED;

    fn initial_state(&self, start: &BlockStart) -> PointState {
        let PointLawData { variables: count, delete, moduli, .. } = self.0;
        let mut variables = vec![0.0; LANES * count];
        if let Some(delete) = delete {
            variables.iter_mut().skip(delete).step_by(count).for_each(|variable| *variable = 1.0);
        }
        let list = |quantity| vec![[0.0; LANES]; usize::from(self.0.uses(quantity))];
        let deforms = [PointQuantity::Density, PointQuantity::Energy, PointQuantity::Gradient];
        PointState {
            variables,
            deleted: [false; LANES],
            volume: start.volume,
            total_time: 0.0,
            temperature: list(PointQuantity::Temperature),
            energy: list(PointQuantity::Energy),
            moduli: if DETAILED { vec![[moduli.bulk; LANES], [moduli.shear; LANES]] } else { Vec::new() },
            deformation: deforms.iter().any(|q| self.0.uses(*q)).then(|| Box::new(DeformationState::fresh())),
        }
    }

    fn begin(&self, state: &mut PointState, total_time: f64) {
        state.total_time = total_time;
    }

    fn initial_bulk(&self) -> f64 {
        self.0.moduli.bulk
    }

    /// Calls the law for each point of a block; an increment of zero length changes nothing.
    fn update(
        &self,
        state: &mut PointState,
        stress: &mut [Lanes; 4],
        strain: &StrainIncrement,
        update: &mut StressUpdate,
    ) {
        let law = &self.0;
        if strain.dt == 0.0 {
            law.set_moduli(state, update);
            return;
        }
        let mut ratios_before = [f64::NAN; LANES];
        if DETAILED && state.deformation.is_some() {
            (0..LANES).for_each(|l| ratios_before[l] = state.volume_ratio(l));
            state.deformation.iter_mut().for_each(|deformation| deformation.advance(strain));
        }
        let mut variables = std::mem::take(&mut state.variables);
        for l in 0..strain.count {
            if state.deleted[l] {
                continue;
            }
            let (increment, carried) = (column(&strain.strain, l), column(&strain.carried, l));
            let mut point = MaterialPoint {
                constants: &law.constants,
                strain: increment,
                stress: carried,
                state: &mut variables[l * law.variables..(l + 1) * law.variables],
                dissipated: 0.0,
                dt: strain.dt,
                total_time: state.total_time,
                temperature: f64::NAN,
                density: f64::NAN,
                energy: f64::NAN,
                place: [f64::NAN; 2],
                gradient: [f64::NAN; 5],
                spin: f64::NAN,
                moduli: law.moduli,
            };
            if DETAILED {
                state.describe(&mut point, strain, law.density, l);
            }
            law.law.update(&mut point);
            let MaterialPoint { stress: new, dissipated, moduli, .. } = point;
            let double = |i: usize| increment[i] * (carried[i] + new[i]);
            let volume = strain.volume[l];
            update.internal[l] += 0.5 * volume * ((double(0) + double(1)) + (double(2) + 2.0 * double(3)));
            update.dissipated[l] += volume * dissipated;
            if DETAILED {
                let ratio = 0.5 * (ratios_before[l] + state.volume_ratio(l));
                let work = 0.5 * ((double(0) + double(1)) + (double(2) + 2.0 * double(3))) * ratio / law.density;
                state.energy.iter_mut().for_each(|energy| energy[l] += work);
                for temperature in &mut state.temperature {
                    temperature[l] += law.heating.rise(temperature[l], [dissipated]);
                }
                if law.uses(PointQuantity::Moduli) {
                    (state.moduli[0][l], state.moduli[1][l]) = (moduli.bulk, moduli.shear);
                }
            }
            // A ratio within rounding of 1 is set to 1.
            let ratio = mises(new) / update.trial[l];
            update.returned[l] = if ratio < 1.0 - 1e-12 { ratio } else { 1.0 };
            if law.delete.is_some_and(|delete| variables[l * law.variables + delete] == 0.0) {
                state.deleted[l] = true;
                update.deleted += 1;
            }
            for (list, new) in stress.iter_mut().zip(new) {
                list[l] = if state.deleted[l] { 0.0 } else { new };
            }
        }
        state.variables = variables;
        law.set_moduli(state, update);
    }

    fn share(&self, state: &PointState, lane: usize) -> f64 {
        if state.deleted[lane] { 0.0 } else { 1.0 }
    }

    fn can_delete(&self) -> bool {
        self.0.delete.is_some()
    }

    fn initial_volume(&self, state: &PointState, lane: usize) -> f64 {
        state.volume[lane]
    }

    fn value(&self, state: &PointState, lane: usize, part: VariableComponent) -> Option<f64> {
        match part.variable {
            Variable::State if part.component < self.0.variables => {
                Some(state.variables[lane * self.0.variables + part.component])
            }
            Variable::Temperature => state.temperature.first().map(|list| list[lane]),
            Variable::Status => self.0.delete.map(|_| self.share(state, lane)),
            _ => None,
        }
    }

    fn bytes(&self, state: &PointState) -> usize {
        let PointState { variables, temperature, energy, moduli, deformation, .. } = state;
        let lists: usize = [temperature, energy, moduli].into_iter().map(|lists| size_of_val(&**lists)).sum();
        size_of_val(&**variables) + lists + deformation.as_deref().map_or(0, size_of_val)
    }

    fn set(&self, state: &mut PointState, lane: usize, value: PointValue) -> bool {
        match value {
            PointValue::StateVariable(variable, value) if variable < self.0.variables => {
                state.variables[lane * self.0.variables + variable] = value;
                true
            }
            PointValue::Temperature(value) | PointValue::NodalTemperature(value) => {
                state.temperature.iter_mut().map(|list| list[lane] = value).count() > 0
            }
            PointValue::SpecificEnergy(value) => state.energy.iter_mut().map(|list| list[lane] = value).count() > 0,
            _ => false,
        }
    }
}

impl CarriedState for PointState {
    /// Moves the state variables, which are stored point by point.
    fn carry(&mut self, visit: &mut dyn FnMut(&mut Lanes)) {
        let PointState { variables, deleted: _, volume: _, total_time: _, temperature, energy, moduli, deformation } =
            self;
        [temperature, energy, moduli].into_iter().flatten().for_each(&mut *visit);
        deformation.iter_mut().for_each(|deformation| deformation.carry(visit));
        let count = variables.len() / LANES;
        for variable in 0..count {
            let mut lanes: Lanes = inline_from_fn(|l| variables[l * count + variable]);
            visit(&mut lanes);
            for (l, value) in lanes.into_iter().enumerate() {
                variables[l * count + variable] = value;
            }
        }
    }
}
