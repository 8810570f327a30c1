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

/// Fraction of the tensile strength below which there is none. New meshes mix cracks with material that can be in tension: it
/// forgets their opening.
const LOOSE: f64 = 0.05;

/// Returns the factor on a tensile mean stress.
fn factor(cohesion: f64) -> f64 {
    if cohesion < LOOSE { 0.0 } else { cohesion }
}

/// State of a block.
#[derive(Clone, Debug, Persist)]
pub struct KeptState {
    damage: DamageState,
    /// Factor on the deviatoric stress.
    share: Lanes,
    /// Fraction of the tensile strength that remains.
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
        let mut remaining = RemainingStress::of(input);
        self.failure.grow(&mut state.damage, input);
        for l in 0..input.count {
            (remaining.mean[l], remaining.released[l]) = self.weaken(state, l, input);
            remaining.stress[l] = state.share[l];
        }
        remaining
    }
}

impl KeptFailure {
    /// Reduces the shear strength of an element towards its residual fraction, and its tensile strength towards zero, in the
    /// time in which the loss crosses the element. Returns the mean stress, and the volumetric energy that is lost
    /// ([`RemainingStress::released`]). Equations (6.20), (6.21), (6.22).
    fn weaken(&self, state: &mut KeptState, l: usize, input: &FailureInput) -> (f64, f64) {
        let (bulk, factor_before) = (input.bulk, factor(state.cohesion[l]));
        // The mean stress of the material without cracks, before and after. Where tension remains, it follows from the stress.
        let (before, after) = if bulk > 0.0 {
            let stress = input.mean[l] - bulk * input.dilation[l];
            let before = match factor_before {
                0.0 => stress + bulk * state.opening[l],
                factor if stress > 0.0 => stress / factor,
                _ => stress,
            };
            (before, before + bulk * input.dilation[l])
        } else {
            (input.mean[l], input.mean[l])
        };
        if self.failure.tears(after) {
            state.damage.fail(l);
        }
        let [damage, loosening] = self.damages(&state.damage, l);
        let lost = input.dt * self.speed / state.damage.length(l);
        let fall = |before: f64, target: f64, lost: f64| target.max(before - lost).min(before);
        state.cohesion[l] = fall(state.cohesion[l], 1.0 - loosening, lost);
        let factor_after = factor(state.cohesion[l]);
        let mean = if after > 0.0 { (factor_after * after).min(self.tension_limit(state, l)) } else { after };
        let is_open = bulk > 0.0 && factor_after == 0.0;
        state.opening[l] = if is_open { (after - mean) / bulk } else { 0.0 };
        // Fragments that have separated have no strength.
        let residual = (self.residual * libm::exp(-state.opening[l])).max(LEAST);
        state.share[l] = fall(state.share[l], (1.0 - damage).max(residual), (1.0 - self.residual) * lost);
        let of_sign = |mean: f64, factor: f64| if mean > 0.0 { factor } else { 1.0 };
        let change = of_sign(before, factor_before) - of_sign(after, factor_after);
        (mean, if bulk > 0.0 { change * before * after / (2.0 * bulk) } else { change })
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
