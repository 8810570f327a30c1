//! Failure of elements: damage initiation by plastic strain or mean stress, degradation of the stress, deletion.
#![allow(clippy::needless_range_loop)] // Loops over lanes are written as in the other phases.

use crate::kernel::lanes::{InlineMap, LANES, Lanes};
use crate::kernel::levels::NestedTable;
use crate::kernel::transcendental::{exp, ln};
use crate::material::carried::{CarriedState, carried_state};
use crate::state::archive::Persist;
use crate::variables::Variable;

/// A failure model. Materials without failure use [`NoDamage`], which has no state and no cost.
pub trait FailureLaw: Send + Sync + 'static {
    /// State variables of a block of elements.
    type State: Clone + Send + Sync + Persist + CarriedState;
    const FAILS: bool;
    /// Whether failed elements stay: [`FailureLaw::stiffness_shares`] can fall below 1.
    const STAYS: bool = false;
    /// Returns the initial state of a block, from the section areas, whose square roots are the characteristic lengths,
    /// and the volumes of its elements.
    fn fresh(&self, area: &Lanes, volume: &Lanes) -> Self::State;
    /// Sets the characteristic length of an element.
    fn set_length(&self, _state: &mut Self::State, _lane: usize, _length: f64) {}
    /// Returns whether elements can be deleted.
    fn deletes(&self) -> bool {
        Self::FAILS
    }
    /// Updates damage over an increment and returns the remaining stress of the block's elements. Lanes of deleted
    /// elements and lanes without element are not updated.
    fn degrade(&self, state: &mut Self::State, input: &FailureInput) -> RemainingStress;
    /// Returns the initial volume of an element.
    fn volume(&self, state: &Self::State, lane: usize) -> f64;
    /// Returns the factor on the stress, 1 minus damage; 0 for a deleted element.
    fn share(&self, state: &Self::State, lane: usize) -> f64;
    /// Returns whether [`FailureLaw::mean_share`] can differ from [`FailureLaw::share`].
    fn keeps_pressure(&self) -> bool {
        Self::STAYS
    }
    /// Returns the factor on the mean stress, where it is not that on the stress.
    fn mean_share(&self, state: &Self::State, lane: usize) -> f64 {
        self.share(state, lane)
    }
    /// Returns the largest mean stress in tension; infinite without a limit.
    fn tension_limit(&self, _state: &Self::State, _lane: usize) -> f64 {
        f64::INFINITY
    }
    /// Returns the factors on bulk and shear modulus of an element that limit the increment, where the moduli are constant.
    fn stiffness_shares(&self, _state: &Self::State, _lane: usize) -> [f64; 2] {
        [1.0; 2]
    }
    /// Returns an output variable of an element: damage, the largest initiation criterion of a kind (1 where damage
    /// begins), or 1 until the element is deleted. `None` if the model does not have it.
    fn value(&self, _state: &Self::State, _lane: usize, _variable: Variable) -> Option<f64> {
        None
    }
}

/// Inputs of a failure model: the elements of a block at the end of an increment.
#[derive(Clone, Debug)]
pub struct FailureInput {
    /// Equivalent plastic strain increments.
    pub plastic: Lanes,
    /// Mean stress of the undamaged material.
    pub mean: Lanes,
    /// Von Mises stress of the undamaged material.
    pub mises: Lanes,
    /// Temperature; 0 if it is not computed.
    pub temperature: Lanes,
    /// Bulk modulus of a law whose mean stress is the sum of its increments; 0 for an equation of state.
    pub bulk: f64,
    /// Volumetric strain increments, where failed elements stay.
    pub dilation: Lanes,
    pub dt: f64,
    /// Number of elements of the block.
    pub count: usize,
}

impl FailureInput {
    /// Returns the stress triaxiality, mean stress over von Mises stress; 0 if the latter is 0.
    #[inline(always)]
    fn triaxiality(&self, l: usize) -> f64 {
        if self.mises[l] > 0.0 { self.mean[l] / self.mises[l] } else { 0.0 }
    }

    /// Returns the equivalent plastic strain rate.
    #[inline(always)]
    fn rate(&self, l: usize) -> f64 {
        if self.dt > 0.0 { self.plastic[l] / self.dt } else { 0.0 }
    }
}

/// Remaining stress of the elements of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RemainingStress {
    /// Factors on the stress of the undamaged material.
    pub stress: Lanes,
    /// Mean stress of the undamaged material, limited by the tension cutoff.
    pub mean: Lanes,
    /// Where failed elements stay: volumetric energy per volume that is lost; with an equation of state, the factor on the
    /// energy of tension.
    pub released: Lanes,
}

impl RemainingStress {
    /// Returns the stress without damage.
    #[inline(always)]
    pub(super) fn of(input: &FailureInput) -> RemainingStress {
        RemainingStress { stress: [1.0; LANES], mean: input.mean, released: [0.0; LANES] }
    }
}

#[derive(Clone, Copy, Debug)]
pub struct NoDamage;

impl FailureLaw for NoDamage {
    type State = ();
    const FAILS: bool = false;

    fn fresh(&self, _area: &Lanes, _volume: &Lanes) {}

    fn volume(&self, (): &(), _lane: usize) -> f64 {
        1.0
    }

    fn degrade(&self, (): &mut (), input: &FailureInput) -> RemainingStress {
        RemainingStress::of(input)
    }

    fn share(&self, (): &(), _lane: usize) -> f64 {
        1.0
    }
}

/// Equivalent plastic strain at which an element fails or its damage begins.
#[derive(Clone, Debug)]
pub enum FailureStrain {
    Constant(f64),
    /// Johnson-Cook: (d1 + d2 exp(-d3 x)) (1 + d4 ln(rate/reference)) (1 + d5 theta) with the triaxiality x (Johnson
    /// and Cook 1985, Eng. Fract. Mech. 21, 31; sign of d3 as in ABAQUS).
    JohnsonCook {
        /// Constants d1 to d5 of the failure strain, dimensionless.
        d: [f64; 5],
        melt: f64,
        transition: f64,
        reference: f64,
    },
    /// Table over triaxiality, plastic strain rate and temperature.
    Ductile(NestedTable),
    /// Table over plastic strain rate, pressure over von Mises stress and temperature.
    Shear(NestedTable),
}

impl FailureStrain {
    /// Returns the failure strains of a block.
    #[inline(always)]
    fn strains(&self, input: &FailureInput) -> Lanes {
        match self {
            FailureStrain::Constant(strain) => [*strain; LANES],
            FailureStrain::Ductile(levels) => by_lane(input, |x, rate, t| levels.at(&[x, rate, t])),
            FailureStrain::Shear(levels) => by_lane(input, |x, rate, t| levels.at(&[rate, -x, t])),
            FailureStrain::JohnsonCook { d, melt, transition, reference } => {
                johnson_cook(d, [*melt, *transition, *reference], input)
            }
        }
    }
}

/// Evaluates a function of triaxiality, rate and temperature for each element that flows.
fn by_lane(input: &FailureInput, strain: impl Fn(f64, f64, f64) -> f64) -> Lanes {
    let mut strains = [f64::INFINITY; LANES];
    for l in (0..input.count).filter(|l| input.plastic[*l] > 0.0) {
        strains[l] = strain(input.triaxiality(l), input.rate(l), input.temperature[l]);
    }
    strains
}

/// Returns the Johnson-Cook failure strains of all lanes. Equation (6.17).
#[inline(always)]
fn johnson_cook(d: &[f64; 5], [melt, transition, reference]: [f64; 3], input: &FailureInput) -> Lanes {
    let (mut exponents, mut rates, mut strains) = ([0.0; LANES], [1.0; LANES], [0.0; LANES]);
    for l in 0..LANES {
        exponents[l] = -d[2] * input.triaxiality(l);
        let rate = input.rate(l) / reference;
        rates[l] = if rate > 1.0 { rate } else { 1.0 };
    }
    let (by_triaxiality, logarithms) = (exp(&exponents), ln(&rates));
    let per = 1.0 / (melt - transition);
    for l in 0..LANES {
        let theta = (input.temperature[l] - transition) * per;
        let theta = if theta > 0.0 { theta } else { 0.0 };
        let theta = if theta < 1.0 { theta } else { 1.0 };
        strains[l] = (d[0] + d[1] * by_triaxiality[l]) * (1.0 + d[3] * logarithms[l]) * (1.0 + d[4] * theta);
    }
    strains
}

/// Evolution of damage after initiation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EvolutionLaw {
    /// No evolution: the criterion is computed for output only.
    Absent,
    /// Immediate failure: the element is deleted.
    Sudden,
    /// Linear in the plastic displacement (plastic strain times characteristic length), with the displacement at
    /// failure.
    Displacement(f64),
    /// Linear, with the fracture energy per area: the displacement at failure is twice the energy over the yield stress
    /// at initiation.
    Energy(f64),
    /// Proportional to the sum of the plastic strain over the failure strain from the start, up to the critical damage at
    /// which the material fails. Strain in an element counts by its length over this one; `None` counts it fully.
    Strain(f64, Option<f64>),
}

/// A criterion on the plastic strain, and the damage evolution after it.
#[derive(Clone, Debug)]
pub struct StrainCriterion {
    /// Failure strain; damage begins when the sum of dp over it reaches 1.
    pub strain: FailureStrain,
    pub evolution: EvolutionLaw,
}

/// Tension cutoff: upper limit of the mean stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TensionCutoff {
    /// Largest mean stress, positive in tension.
    pub stress: f64,
    /// Whether an element that reaches the limit is deleted; if not, its mean stress is limited.
    pub deletes: bool,
}

/// Failure of a material: criteria on the plastic strain, and a tension cutoff.
#[derive(Clone, Debug, Default)]
pub struct MaterialFailure {
    /// Criteria, at most one of each kind; the largest damage counts.
    pub criteria: Vec<StrainCriterion>,
    pub cutoff: Option<TensionCutoff>,
    /// 1 minus the damage at which an element is deleted, i.e. 1 - MAX DEGRADATION (ABAQUS Analysis User's Guide,
    /// "Section controls"); 0 by default, where elements are deleted.
    pub deletion_margin: f64,
    /// Whether elements are kept at that damage (`ELEMENT DELETION=NO`).
    pub keep_elements: bool,
    /// Whether damage before failure does not reduce the mean stress: that of coupled damage reduces the flow stress only.
    pub keeps_pressure: bool,
}

/// Largest number of criteria of a material.
pub const CRITERIA: usize = 3;

/// Damage state of a block.
#[derive(Clone, Debug, Persist)]
#[persist(derived: volume)]
pub struct DamageState {
    alive: [bool; LANES],
    /// Sum of dp over the failure strain, per criterion.
    begun: [Lanes; CRITERIA],
    /// Damage and displacement at failure per criterion; 0 before initiation.
    damage: [Lanes; CRITERIA],
    at_failure: [Lanes; CRITERIA],
    length: Lanes,
    volume: Lanes,
    /// 1 minus the largest damage.
    share: Lanes,
}

impl FailureLaw for MaterialFailure {
    type State = DamageState;
    const FAILS: bool = true;

    fn volume(&self, state: &DamageState, lane: usize) -> f64 {
        state.volume[lane]
    }

    fn fresh(&self, area: &Lanes, volume: &Lanes) -> DamageState {
        DamageState {
            alive: [true; LANES],
            begun: [[0.0; LANES]; CRITERIA],
            damage: [[0.0; LANES]; CRITERIA],
            at_failure: [[0.0; LANES]; CRITERIA],
            length: area.inline_map(f64::sqrt),
            volume: *volume,
            share: [1.0; LANES],
        }
    }

    fn set_length(&self, state: &mut DamageState, lane: usize, length: f64) {
        state.length[lane] = length;
    }

    fn deletes(&self) -> bool {
        let harmless = |c: &StrainCriterion| c.evolution == EvolutionLaw::Absent;
        !self.keep_elements && (self.cutoff.is_some() || !self.criteria.iter().all(harmless))
    }

    #[inline(always)]
    fn share(&self, state: &DamageState, lane: usize) -> f64 {
        if state.alive[lane] { state.share[lane] } else { 0.0 }
    }

    #[inline(always)]
    fn keeps_pressure(&self) -> bool {
        self.keeps_pressure
    }

    #[inline(always)]
    fn mean_share(&self, state: &DamageState, lane: usize) -> f64 {
        if self.keeps_pressure && state.alive[lane] { 1.0 } else { self.share(state, lane) }
    }

    #[inline(always)]
    fn tension_limit(&self, _state: &DamageState, _lane: usize) -> f64 {
        self.cutoff.map_or(f64::INFINITY, |cutoff| cutoff.stress)
    }

    fn value(&self, state: &DamageState, lane: usize, variable: Variable) -> Option<f64> {
        match variable {
            Variable::Degradation => return (!self.criteria.is_empty()).then(|| 1.0 - state.share[lane]),
            Variable::Status => return self.deletes().then_some(f64::from(u8::from(state.alive[lane]))),
            Variable::DamageInitiation | Variable::DuctileInitiation | Variable::JohnsonCookInitiation => {}
            _ => return None,
        }
        let meant = |criterion: &StrainCriterion| match (&criterion.strain, criterion.evolution) {
            // Criteria of *SHEAR FAILURE have no initiation output.
            (_, EvolutionLaw::Sudden) => false,
            (FailureStrain::Ductile(_), _) => variable != Variable::JohnsonCookInitiation,
            (FailureStrain::JohnsonCook { .. }, _) => variable != Variable::DuctileInitiation,
            _ => false,
        };
        // With damage evolution the output is limited to 1; without, the sum continues.
        let initiation_of = |(c, begun): (&StrainCriterion, &Lanes)| {
            if c.evolution == EvolutionLaw::Absent { begun[lane] } else { begun[lane].min(1.0) }
        };
        self.criteria.iter().zip(&state.begun).filter(|c| meant(c.0)).map(initiation_of).reduce(f64::max)
    }

    #[inline(always)]
    fn degrade(&self, state: &mut DamageState, input: &FailureInput) -> RemainingStress {
        let mut remaining = RemainingStress::of(input);
        let mut worst = [0.0; LANES];
        self.grow(state, input);
        for damage in &state.damage[..self.criteria.len()] {
            for l in 0..LANES {
                worst[l] = if damage[l] > worst[l] { damage[l] } else { worst[l] };
            }
        }
        let alive = state.alive;
        for l in (0..input.count).filter(|l| alive[*l]) {
            self.apply_damage(state, l, worst[l], &mut remaining.mean[l]);
            remaining.stress[l] = self.share(state, l);
        }
        remaining
    }
}

impl MaterialFailure {
    /// Applies the largest damage of an element, and the cutoff to its mean stress.
    fn apply_damage(&self, state: &mut DamageState, l: usize, damage: f64, mean: &mut f64) {
        let mut worst = damage;
        if let Some(cutoff) = self.cutoff.filter(|cutoff| *mean > cutoff.stress) {
            *mean = cutoff.stress;
            if cutoff.deletes {
                worst = 1.0;
            }
        }
        // The next increment divides by the remaining factor: it must not become tiny, so the element is deleted or its
        // damage limited.
        if self.keep_elements {
            worst = worst.min(1.0 - self.deletion_margin.max(1e-6));
        } else {
            state.alive[l] &= worst < 1.0 - 1e-6 - self.deletion_margin;
        }
        state.share[l] = 1.0 - worst;
    }

    /// Returns whether a criterion reduces or ends the stress.
    pub fn can_fail(&self) -> bool {
        let evolves = |c: &StrainCriterion| c.evolution != EvolutionLaw::Absent;
        self.cutoff.is_some_and(|cutoff| cutoff.deletes) || self.criteria.iter().any(evolves)
    }

    /// Advances the criteria, which change only with plastic flow.
    #[inline(always)]
    pub(super) fn grow(&self, state: &mut DamageState, input: &FailureInput) {
        if input.plastic[..input.count].iter().any(|plastic| *plastic != 0.0) {
            for (c, criterion) in self.criteria.iter().enumerate() {
                criterion.grow(state, c, input);
            }
        }
    }

    /// Returns whether a mean stress exceeds a cutoff at which elements fail.
    pub(super) fn tears(&self, mean: f64) -> bool {
        self.cutoff.is_some_and(|cutoff| cutoff.deletes && mean > cutoff.stress)
    }

    /// Returns whether a criterion has coupled damage.
    pub(super) fn is_coupled(&self, c: usize) -> bool {
        self.criteria.get(c).is_some_and(StrainCriterion::is_coupled)
    }
}

impl DamageState {
    /// Returns the damage of an element by a criterion.
    pub(super) fn damage(&self, c: usize, l: usize) -> f64 {
        self.damage[c][l]
    }

    /// Returns the characteristic length of an element.
    pub(super) fn length(&self, l: usize) -> f64 {
        self.length[l]
    }

    /// Sets the damage of an element to 1.
    pub(super) fn fail(&mut self, l: usize) {
        self.damage[0][l] = 1.0;
    }
}

impl StrainCriterion {
    /// Returns whether damage reduces the flow stress from the start.
    pub fn is_coupled(&self) -> bool {
        matches!(self.evolution, EvolutionLaw::Strain(..))
    }

    /// Advances this criterion for elements with plastic flow. A NaN does not delete an element, so that the run halts.
    /// Equations (6.16), (6.18a).
    #[inline(always)]
    fn grow(&self, state: &mut DamageState, c: usize, input: &FailureInput) {
        let strains = self.strain.strains(input);
        let followed = self.evolution == EvolutionLaw::Absent;
        let mut more = [0.0; LANES];
        for l in 0..LANES {
            let part = if strains[l] > 0.0 { input.plastic[l] / strains[l] } else { 1.0 };
            let goes_on = (input.plastic[l] > 0.0) & (followed | (state.begun[c][l] < 1.0));
            more[l] = if goes_on { part } else { 0.0 };
        }
        if let EvolutionLaw::Strain(critical, length) = self.evolution {
            for l in 0..input.count {
                state.begun[c][l] += more[l] * length.map_or(1.0, |length| state.length[l] / length);
                let fails = state.begun[c][l] >= 1.0;
                state.damage[c][l] = if fails { 1.0 } else { critical * state.begun[c][l] };
            }
            return;
        }
        let alive = state.alive;
        for l in (0..input.count).filter(|l| input.plastic[*l] > 0.0 && alive[*l]) {
            let begun = state.begun[c][l] >= 1.0;
            state.begun[c][l] += more[l];
            if state.begun[c][l] >= 1.0 && !followed {
                self.evolve(state, (c, l), begun, input);
            }
        }
    }

    /// Advances the damage of an element; `begun` is whether damage began before this increment. Equation (6.18).
    fn evolve(&self, state: &mut DamageState, (c, l): (usize, usize), begun: bool, input: &FailureInput) {
        if !begun {
            state.at_failure[c][l] = match self.evolution {
                EvolutionLaw::Sudden | EvolutionLaw::Absent | EvolutionLaw::Strain(..) => 0.0,
                EvolutionLaw::Displacement(displacement) => displacement,
                EvolutionLaw::Energy(energy) => 2.0 * energy / input.mises[l],
            };
        }
        let at_failure = state.at_failure[c][l];
        let more = if at_failure > 0.0 { input.plastic[l] * state.length[l] / at_failure } else { 1.0 };
        // In the increment of initiation, damage starts to grow at its end.
        if begun || at_failure == 0.0 {
            state.damage[c][l] = (state.damage[c][l] + more).min(1.0);
        }
    }
}

// Lengths are saved: a user subroutine may have set them, and is not called again after a restart.
// The characteristic length and the volume are those of the element at the start.
carried_state!(DamageState { begun, damage, at_failure, share } stay { alive, length, volume });
