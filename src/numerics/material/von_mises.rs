//! Isotropic solids and fluids, composed of a hardening law of von Mises plasticity, a pressure law and a failure
//! model.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use super::available::AvailableEnergy;
use super::failure::{FailureInput, FailureLaw, NoDamage};
use super::increment::{StrainIncrement, StressUpdate};
use super::plasticity::{FlowUpdate, HardeningLaw};
use super::volumetric::{ElementSize, PressureUpdate, VolumetricLaw};
use super::{BlockStart, Material, PlasticFlow, PointValue};
use crate::kernel::lanes::{InlineMap, LANES, Lanes, column, inline_from_fn};
use crate::kernel::moduli::ElasticModuli;
use crate::kernel::rotation::rotated;
use crate::kernel::stress;
use crate::material::carried::carried_state;
use crate::state::archive::Persist;
use crate::variables::{Variable, VariableComponent};

/// A material composed of three laws.
#[derive(Clone, Debug)]
pub struct VonMises<H, V, F = NoDamage> {
    /// Hardening law; [`super::plasticity::ElasticOnly`] without yield.
    pub hardening: H,
    /// Pressure law; [`super::volumetric::ConstantBulkModulus`] for a constant bulk modulus.
    pub volumetric: V,
    /// Failure model; [`NoDamage`] if elements do not fail.
    pub failure: F,
}

/// State variables of a block: those of the three laws.
#[derive(Clone, Debug, Persist)]
pub struct VonMisesState<S, Q, X> {
    hardening: S,
    volumetric: Q,
    failure: X,
}

impl<H: HardeningLaw, V: VolumetricLaw> VonMises<H, V> {
    /// Returns a material without failure.
    pub fn new(hardening: H, volumetric: V) -> Self {
        VonMises { hardening, volumetric, failure: NoDamage }
    }
}

impl<H: HardeningLaw, V: VolumetricLaw, F: FailureLaw> Material for VonMises<H, V, F> {
    type State = VonMisesState<H::State, V::State, F::State>;

    const FLOW: PlasticFlow = if H::PLASTIC { PlasticFlow::Deviatoric } else { PlasticFlow::None };
    const MODULI_VARY: bool = V::EOS || F::STAYS;
    const EQUATION_OF_STATE: bool = V::EOS;
    const FAILS: bool = F::FAILS;
    const USES_SPIN: bool = H::BACKSTRESS;

    fn initial_state(&self, start: &BlockStart) -> Self::State {
        VonMisesState {
            hardening: self.hardening.fresh(),
            volumetric: self.volumetric.fresh(start),
            failure: self.failure.fresh(&start.area, &start.volume),
        }
    }

    #[inline(always)]
    fn begin(&self, state: &mut Self::State, total_time: f64) {
        self.volumetric.begin(&mut state.volumetric, total_time);
    }

    #[inline(always)]
    fn update(
        &self,
        state: &mut Self::State,
        stress: &mut [Lanes; 4],
        strain: &StrainIncrement,
        update: &mut StressUpdate,
    ) {
        let shear3 = 3.0 * strain.moduli.shear;
        if F::STAYS && !V::EOS {
            update.add_averaged_dilation(strain);
        }
        if H::BACKSTRESS {
            update.plastic = self.hardening.back_stress(&state.hardening);
            update.shift(&strain.spin);
        }
        if H::PLASTIC {
            let previous = &if H::HEATS { update.previous_along_flow(strain) } else { [0.0; LANES] };
            let shares = (F::FAILS && H::HEATS).then(|| inline_from_fn(|l| self.failure.share(&state.failure, l)));
            let remaining = shares.as_ref();
            let StressUpdate { trial, flow: increment, .. } = &mut *update;
            let count = strain.count;
            let flow = &mut FlowUpdate { trial, previous, shear3, dt: strain.dt, count, remaining, increment };
            self.hardening.flow(&mut state.hardening, flow);
            if H::BACKSTRESS {
                self.hardening.update_back_stress(
                    &mut state.hardening,
                    &update.plastic,
                    &update.deviator,
                    &update.trial,
                    &update.flow,
                    remaining,
                );
            }
        }
        if V::EOS {
            if !H::PLASTIC && strain.viscosity > 0.0 && strain.dt > 0.0 {
                update.set_viscous_deviator(strain);
            }
            self.update_pressure(&mut state.volumetric, strain, update);
        }
        if H::PLASTIC {
            update.return_to_yield_surface(strain);
        }
        match (H::PLASTIC, H::BACKSTRESS) {
            (false, _) => update.set_stress::<false, false>(stress, strain),
            (true, false) => update.set_stress::<true, false>(stress, strain),
            (true, true) => update.set_stress::<true, true>(stress, strain),
        }
        if F::FAILS {
            self.degrade(state, stress, strain, update);
        }
    }

    #[inline(always)]
    fn add_heat(&self, state: &mut Self::State, heat: &Lanes, mass: &Lanes) {
        self.volumetric.add_heat(&mut state.volumetric, heat, mass);
    }

    fn prepare_transport(&self, state: &mut Self::State) {
        self.volumetric.prepare_transport(&mut state.volumetric);
    }

    fn volume_ratio(&self, state: &Self::State, lane: usize) -> Option<f64> {
        self.volumetric.volume_ratio(&state.volumetric, lane)
    }

    fn prepare_scaling(&self, state: &mut Self::State) {
        self.volumetric.prepare_scaling(&mut state.volumetric);
    }

    fn bulk_modulus(&self, state: &Self::State, lane: usize, element: ElementSize) -> Option<f64> {
        self.volumetric.bulk_modulus(&state.volumetric, lane, element)
    }

    fn bytes(&self, state: &Self::State) -> usize {
        self.volumetric.bytes(&state.volumetric)
    }

    #[inline(always)]
    fn share(&self, state: &Self::State, lane: usize) -> f64 {
        self.failure.share(&state.failure, lane)
    }

    #[inline(always)]
    fn mean_share(&self, state: &Self::State, lane: usize) -> f64 {
        self.failure.mean_share(&state.failure, lane)
    }

    fn can_delete(&self) -> bool {
        self.failure.deletes()
    }

    fn initial_volume(&self, state: &Self::State, lane: usize) -> f64 {
        self.failure.volume(&state.failure, lane)
    }

    /// Finds the yield stress by evaluating the hardening law.
    #[cold]
    #[inline(never)]
    fn yield_stress(&self, state: &Self::State, shear: f64, count: usize) -> Option<Lanes> {
        H::PLASTIC.then(|| yield_stress(&self.hardening, &state.hardening, shear, count))
    }

    fn value(&self, state: &Self::State, lane: usize, part: VariableComponent) -> Option<f64> {
        match part.variable {
            Variable::PlasticStrain => H::PLASTIC.then(|| self.hardening.plastic_strain(&state.hardening, lane)),
            Variable::Temperature => self.temperature(state, lane),
            variable => {
                let of_failure = self.failure.value(&state.failure, lane, variable);
                of_failure.or_else(|| self.volumetric.value(&state.volumetric, lane, variable))
            }
        }
    }

    fn available_energy(&self, state: &Self::State, lane: usize, specific_volume: f64) -> AvailableEnergy {
        self.volumetric.available_energy(&state.volumetric, lane, specific_volume)
    }

    fn recoverable_energy(&self, state: &Self::State, lane: usize, element: ElementSize) -> Option<f64> {
        let limit = self.failure.tension_limit(&state.failure, lane);
        self.volumetric.recoverable_energy(&state.volumetric, lane, element, limit)
    }

    fn set(&self, state: &mut Self::State, lane: usize, value: PointValue) -> bool {
        if let PointValue::Length(_, length) = value {
            self.failure.set_length(&mut state.failure, lane, length);
            return true;
        }
        let is_in_hardening = self.hardening.set(&mut state.hardening, lane, value);
        self.volumetric.set(&mut state.volumetric, lane, value) || is_in_hardening
    }
}

impl<H: HardeningLaw, V: VolumetricLaw, F: FailureLaw> VonMises<H, V, F> {
    fn temperature(&self, state: &VonMisesState<H::State, V::State, F::State>, lane: usize) -> Option<f64> {
        let by_energy = self.volumetric.temperature(&state.volumetric, lane);
        by_energy.or_else(|| self.hardening.temperature(&state.hardening, lane))
    }

    /// Updates the mean stress by the pressure law, with the work of the returned deviator.
    #[inline(always)]
    fn update_pressure(&self, state: &mut V::State, strain: &StrainIncrement, update: &mut StressUpdate) {
        let shear3 = 3.0 * strain.moduli.shear;
        let (mut work, mut dilation) = ([0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            let mut factor = 1.0;
            if H::PLASTIC {
                let (trial, flow) = (update.trial[l], update.flow[l]);
                factor = if flow > 0.0 { (trial - shear3 * flow) / trial } else { 1.0 };
            }
            let mean = update.mean[l];
            let returned = |i: usize| {
                let relative = factor * update.deviator[i][l];
                if H::BACKSTRESS { relative + update.plastic[i][l] } else { relative }
            };
            let normal = |i: usize| strain.strain[i][l] * ((strain.carried[i][l] - mean) + returned(i));
            let shear = 2.0 * strain.strain[3][l] * (strain.carried[3][l] + returned(3));
            work[l] = 0.5 * strain.volume[l] * ((normal(0) + normal(1)) + (normal(2) + shear));
            dilation[l] = strain.strain[0][l] + strain.strain[1][l] + strain.strain[2][l];
        }
        let mut pressures = PressureUpdate {
            mean: update.mean,
            bulk: update.bulk,
            viscous: strain.viscous,
            heat: update.heat,
            compacted: [0.0; LANES],
            dilation,
            work,
            middle: strain.volume,
            volume: strain.current_volume,
            mass: strain.mass,
        };
        self.volumetric.update_pressure(state, &mut pressures);
        (update.mean, update.bulk, update.heat) = (pressures.mean, pressures.bulk, pressures.heat);
        for l in 0..LANES {
            update.dissipated[l] += pressures.compacted[l];
        }
    }

    /// Applies failure to the stress of the undamaged material. The added work becomes that of the degraded stress;
    /// lost elastic energy is dissipated.
    #[inline(always)]
    fn degrade(
        &self,
        state: &mut VonMisesState<H::State, V::State, F::State>,
        stress: &mut [Lanes; 4],
        strain: &StrainIncrement,
        update: &mut StressUpdate,
    ) {
        let ElasticModuli { bulk, shear } = strain.moduli;
        let mut input = FailureInput {
            plastic: if H::PLASTIC { update.flow } else { [0.0; LANES] },
            mean: [0.0; LANES],
            mises: [0.0; LANES],
            temperature: [0.0; LANES],
            bulk: if V::EOS { 0.0 } else { bulk },
            dilation: [0.0; LANES],
            dt: strain.dt,
            count: strain.count,
        };
        // Whether the mean stress has its own factors.
        let keeps_pressure = self.failure.keeps_pressure();
        let (mut share_at_start, mut spherical_at_start) = ([0.0; LANES], [0.0; LANES]);
        for l in 0..LANES {
            let stress = column(stress, l);
            (input.mean[l], input.mises[l]) = (-stress::pressure(stress), stress::mises(stress));
        }
        for l in 0..strain.count {
            share_at_start[l] = self.failure.share(&state.failure, l);
            spherical_at_start[l] = share_at_start[l];
            if keeps_pressure {
                spherical_at_start[l] = self.failure.mean_share(&state.failure, l);
            }
            if F::STAYS {
                input.dilation[l] = strain.strain[0][l] + strain.strain[1][l] + strain.strain[2][l];
            }
            input.temperature[l] = self.temperature(state, l).unwrap_or(0.0);
        }
        let remaining = self.failure.degrade(&mut state.failure, &input);
        let per_shear = if shear > 0.0 { 1.0 / (6.0 * shear) } else { 0.0 };
        if F::STAYS && !V::EOS {
            update.shear = [shear; LANES];
            // Of the modulus of plane waves, the shear modulus is taken into account as a constant.
            update.bulk = inline_from_fn(|l| {
                let [of_bulk, of_shear] = self.failure.stiffness_shares(&state.failure, l);
                bulk * of_bulk - 4.0 / 3.0 * shear * (1.0 - of_shear)
            });
        }
        if V::EOS {
            for l in 0..LANES {
                update.tension_excess[l] = input.mean[l] - self.failure.tension_limit(&state.failure, l);
            }
        }
        for l in 0..strain.count {
            if share_at_start[l] == 0.0 {
                stress.iter_mut().for_each(|s| s[l] = 0.0);
                continue;
            }
            let (full, mean, mises) = (column(stress, l), input.mean[l], input.mises[l]);
            let (released, limited) = (remaining.released[l], remaining.mean[l]);
            let remaining = remaining.stress[l];
            let spherical = if keeps_pressure { self.failure.mean_share(&state.failure, l) } else { remaining };
            // What the factors on the mean stress add to those on the stress, before and after.
            let [added_before, added_after] = [spherical_at_start[l] - share_at_start[l], spherical - remaining];
            let limit = self.failure.tension_limit(&state.failure, l);
            let shift = [limited - mean, limited - mean, limited - mean, 0.0];
            let (mut work, mut unloaded, volume) = (0.0, 0.0, strain.volume[l]);
            // Plastic work of the previous and the new stress without damage.
            let (mut flowed_before, mut flowed) = (0.0, 0.0);
            let flow = if input.plastic[l] > 0.0 { 1.5 * input.plastic[l] / update.trial[l] } else { 0.0 };
            for i in 0..4 {
                let mut degraded = remaining * (full[i] + shift[i]);
                let (increment, carried) = (strain.strain[i][l], strain.carried[i][l]);
                let added = carried + full[i];
                let twice = if i == 3 { 2.0 } else { 1.0 };
                let mut degraded_before = share_at_start[l] * carried;
                // The mean stress of elements that stay has its own account.
                let undamaged = if V::EOS || F::STAYS { full[i] + shift[i] } else { full[i] };
                let mut lasting = share_at_start[l] * undamaged;
                if keeps_pressure && i < 3 {
                    let carried = (strain.carried[0][l] + strain.carried[1][l] + strain.carried[2][l]) * (1.0 / 3.0);
                    degraded += added_after * limited;
                    degraded_before += added_before * carried;
                    lasting += added_before * limited;
                }
                work += twice * increment * (degraded_before + degraded - added);
                unloaded += twice * increment * (lasting - degraded);
                let plastic = twice * flow * update.deviator[i][l];
                flowed_before += plastic * carried;
                flowed += plastic * full[i];
                stress[i][l] = degraded;
            }
            update.internal[l] += 0.5 * volume * work;
            let distortion = mises * mises * per_shear;
            // Only a change of the factor takes elastic energy.
            let volumetric = if F::STAYS || V::EOS && spherical_at_start[l] == spherical {
                0.0
            } else if !V::EOS {
                mean * mean / (2.0 * bulk)
            } else {
                let element = ElementSize { volume: strain.current_volume[l], mass: strain.mass[l] };
                self.recoverable_energy(state, l, element).unwrap_or(0.0) / volume
            };
            let elastic = distortion + volumetric;
            let energy_before = share_at_start[l] * elastic + added_before * volumetric;
            let energy_after = remaining * elastic + added_after * volumetric;
            // The work of the increment is that of the degraded stress (trapezoidal rule), without this elastic part.
            let missing = 0.5 * (unloaded - (share_at_start[l] - remaining) * flowed);
            let mut lost = (energy_before - energy_after) - missing;
            if F::STAYS && !V::EOS {
                lost += released;
            } else if F::STAYS {
                let dilation = strain.strain[0][l] + strain.strain[1][l] + strain.strain[2][l];
                update.heat[l] += 0.5 * volume * dilation * (mean - limited).max(0.0);
                if released != 0.0 {
                    let element = ElementSize { volume: strain.current_volume[l], mass: strain.mass[l] };
                    lost += released * self.recoverable_energy(state, l, element).unwrap_or(0.0) / volume;
                }
            }
            if V::EOS && limit < f64::INFINITY {
                lost += spherical_at_start[l] * update.limit_tension(strain, l, (mean, limit));
            }
            let not_flowed = 0.5 * ((1.0 - share_at_start[l]) * flowed_before + (1.0 - remaining) * flowed);
            update.dissipated[l] += volume * (lost - not_flowed);
            update.damaged[l] += volume * lost;
            update.deleted += usize::from(remaining == 0.0);
        }
    }
}

/// Returns the fraction of an increment in which a mean stress is limited, from its excess over the limit at the end and
/// its growth in the increment.
#[inline(always)]
fn limited_fraction(excess: f64, growth: f64) -> f64 {
    let previous = excess - growth;
    match (excess > 0.0, previous > 0.0) {
        (true, true) => 1.0,
        (true, false) => excess / (excess - previous),
        (false, true) => previous / (previous - excess),
        (false, false) => 0.0,
    }
}

impl StressUpdate {
    /// Returns the work per volume of the tension while it is limited, which is dissipated, from the mean stress of the
    /// equation of state and its limit. The specific energy, which has the work of the unlimited tension, is corrected.
    /// Equation (6.19).
    #[inline(always)]
    fn limit_tension(&mut self, strain: &StrainIncrement, l: usize, (mean, limit): (f64, f64)) -> f64 {
        let dilation: f64 = (0..3).map(|i| strain.strain[i][l]).sum();
        let excess = if mean > limit { mean - limit } else { 0.0 };
        self.heat[l] += 0.5 * strain.volume[l] * dilation * excess;
        limited_fraction(mean - limit, self.bulk[l] * dilation) * dilation * limit
    }

    /// Sets the deviator to 2 η times the rate of the deviatoric strain (Newtonian fluid; ABAQUS Analysis User's Guide
    /// 25.2.1, "Viscous shear behavior"), with the strain rate of the increment. The work of the deviator is viscous
    /// dissipation instead of internal energy. Equation (7.9).
    #[inline(always)]
    fn set_viscous_deviator(&mut self, strain: &StrainIncrement) {
        let twice = 2.0 * strain.viscosity / strain.dt;
        for l in 0..LANES {
            let [rr, zz, hoop, rz] = column(&strain.strain, l);
            let third = (rr + zz + hoop) * (1.0 / 3.0);
            let distortion = [rr - third, zz - third, hoop - third, rz];
            let mut work = 0.0;
            for i in 0..4 {
                let new = twice * distortion[i];
                let both_sides = if i == 3 { 2.0 } else { 1.0 };
                work += both_sides * distortion[i] * (strain.carried[i][l] + new);
                self.deviator[i][l] = new;
            }
            self.sheared[l] = 0.5 * strain.volume[l] * work;
            self.internal[l] -= self.sheared[l];
        }
    }
}

impl StressUpdate {
    /// Rotates the back stress with the material, and subtracts it from the trial stress.
    #[inline(always)]
    fn shift(&mut self, spin: &Lanes) {
        for l in 0..LANES {
            let back = rotated([0, 1, 2, 3].inline_map(|i| self.plastic[i][l]), spin[l]);
            for i in 0..4 {
                self.plastic[i][l] = back[i];
                self.deviator[i][l] -= back[i];
            }
            let [a, b, c, d] = [0, 1, 2, 3].inline_map(|i| self.deviator[i][l] * self.deviator[i][l]);
            self.trial[l] = (1.5 * (a + b + c) + 3.0 * d).sqrt();
        }
    }
}

/// Returns the von Mises stress at which each lane begins to yield at zero strain rate, by bisection on the hardening
/// law.
fn yield_stress<H: HardeningLaw>(hardening: &H, state: &H::State, shear: f64, count: usize) -> Lanes {
    let shear3 = 3.0 * shear;
    let flows = |trial: &Lanes| {
        let (mut state, mut increment) = (state.clone(), [0.0; LANES]);
        let previous = &[0.0; LANES];
        let (dt, increment) = (f64::MAX, &mut increment);
        let flow = &mut FlowUpdate { trial, previous, shear3, dt, count, remaining: None, increment };
        hardening.flow(&mut state, flow);
        increment.inline_map(|dp| dp > 0.0)
    };
    let (mut low, mut high) = ([0.0; LANES], [1e-12 * shear; LANES]);
    // The upper bound 1e-12 shear · 2^60 exceeds every yield stress.
    for _ in 0..60 {
        for (l, flown) in flows(&high).into_iter().enumerate() {
            if !flown {
                (low[l], high[l]) = (high[l], 2.0 * high[l]);
            }
        }
    }
    for _ in 0..30 {
        let between: Lanes = inline_from_fn(|l| 0.5 * (low[l] + high[l]));
        for (l, flown) in flows(&between).into_iter().enumerate() {
            *(if flown { &mut high[l] } else { &mut low[l] }) = between[l];
        }
    }
    high
}

carried_state!(VonMisesState<S, Q, X> { hardening, volumetric, failure });
