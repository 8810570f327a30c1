//! Failed material that stays: it keeps its pressure in compression and a fraction of its shear strength, and has no tension.

use super::failure::{CRITERIA, DamageState, FailureInput, FailureLaw, MaterialFailure, RemainingStress};
use crate::kernel::lanes::{LANES, Lanes};
use crate::material::carried::carried_state;
use crate::state::archive::Persist;
use crate::variables::Variable;

/// Failure without deletion of elements (`*FAILED MATERIAL`).
#[derive(Clone, Debug)]
pub struct KeptFailure {
    /// Criteria of failure, and the damage before it.
    pub failure: MaterialFailure,
    /// Fraction of the deviatoric stress that remains.
    pub residual: f64,
    /// Speed with which the loss of strength crosses an element; infinite for a sudden loss.
    pub speed: f64,
}

/// Smallest factor on the deviatoric stress: 0 marks deleted elements.
const LEAST: f64 = 1e-6;

/// State of a block.
#[derive(Clone, Debug, Persist)]
pub struct KeptState {
    damage: DamageState,
    /// Factor on the deviatoric stress.
    share: Lanes,
    /// Factor on a tensile mean stress.
    cohesion: Lanes,
    /// Volumetric strain of open cracks, which close before a pressure builds up.
    opening: Lanes,
}

carried_state!(KeptState { damage, share, cohesion, opening });

impl FailureLaw for KeptFailure {
    type State = KeptState;
    const FAILS: bool = true;
    const STAYS: bool = true;

    fn fresh(&self, area: &Lanes, volume: &Lanes) -> KeptState {
        KeptState {
            damage: self.failure.fresh(area, volume),
            share: [1.0; LANES],
            cohesion: [1.0; LANES],
            opening: [0.0; LANES],
        }
    }

    fn set_length(&self, state: &mut KeptState, lane: usize, length: f64) {
        self.failure.set_length(&mut state.damage, lane, length);
    }

    fn deletes(&self) -> bool {
        false
    }

    fn volume(&self, state: &KeptState, lane: usize) -> f64 {
        self.failure.volume(&state.damage, lane)
    }

    #[inline(always)]
    fn share(&self, state: &KeptState, lane: usize) -> f64 {
        state.share[lane]
    }

    #[inline(always)]
    fn mean_share(&self, _state: &KeptState, _lane: usize) -> f64 {
        1.0
    }

    fn tension_limit(&self, state: &KeptState, lane: usize) -> f64 {
        if self.failure.tears(f64::INFINITY) { f64::INFINITY } else { self.failure.tension_limit(&state.damage, lane) }
    }

    fn stiffness_shares(&self, state: &KeptState, lane: usize) -> [f64; 2] {
        [libm::exp(-state.opening[lane]), state.share[lane]]
    }

    fn value(&self, state: &KeptState, lane: usize, variable: Variable) -> Option<f64> {
        match variable {
            Variable::Degradation => Some(1.0 - state.share[lane]),
            Variable::Status => None,
            _ => self.failure.value(&state.damage, lane, variable),
        }
    }

    #[inline(always)]
    fn degrade(&self, state: &mut KeptState, input: &FailureInput) -> RemainingStress {
        let mut remaining = RemainingStress { stress: [1.0; LANES], spherical: [1.0; LANES], mean: input.mean };
        self.failure.grow(&mut state.damage, input);
        for l in 0..input.count {
            remaining.mean[l] = self.weaken(state, l, input);
            remaining.stress[l] = state.share[l];
        }
        remaining
    }

    #[inline(always)]
    fn tension(&self, state: &KeptState, lane: usize) -> [f64; 2] {
        [state.cohesion[lane], state.opening[lane]]
    }
}

impl KeptFailure {
    /// Reduces the shear strength of an element towards its residual fraction, and its tensile strength towards zero, in the
    /// time in which the loss crosses the element. Returns the mean stress. Equations (6.20), (6.21).
    fn weaken(&self, state: &mut KeptState, l: usize, input: &FailureInput) -> f64 {
        let closed = input.mean[l] + input.bulk * state.opening[l];
        if self.failure.tears(closed) {
            state.damage.fail(l);
        }
        let [damage, loosening] = self.damages(&state.damage, l);
        let lost = input.dt * self.speed / state.damage.length(l);
        let fall = |before: f64, target: f64, lost: f64| target.max(before - lost).min(before);
        state.cohesion[l] = fall(state.cohesion[l], 1.0 - loosening, lost);
        let tension = (state.cohesion[l] * closed).min(self.tension_limit(state, l));
        let mean = if closed > 0.0 { tension } else { closed };
        state.opening[l] = if input.bulk > 0.0 { (closed - mean) / input.bulk } else { 0.0 };
        // Fragments that have separated have no strength.
        let residual = (self.residual * libm::exp(-state.opening[l])).max(LEAST);
        state.share[l] = fall(state.share[l], (1.0 - damage).max(residual), (1.0 - self.residual) * lost);
        mean
    }

    /// Returns the largest damage of an element, and the largest one that reduces the tensile strength: coupled damage does so
    /// at failure only.
    fn damages(&self, state: &DamageState, l: usize) -> [f64; 2] {
        let (mut damage, mut loosening) = (0.0_f64, 0.0_f64);
        for c in 0..CRITERIA {
            let of_criterion = state.damage(c, l);
            damage = damage.max(of_criterion);
            if of_criterion >= 1.0 || !self.failure.is_coupled(c) {
                loosening = loosening.max(of_criterion);
            }
        }
        [damage, loosening]
    }
}
