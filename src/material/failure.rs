//! Failure of elements: criteria over the plastic strain or the mean stress, degradation of the stress, deletion.
//! Never here: yield stresses, forces.
#![allow(clippy::needless_range_loop)] // Loops over lanes are written as in the other phases.

use crate::kernel::lanes::{InlineMap, LANES, Lanes};
use crate::kernel::levels::NestedTable;
use crate::kernel::transcendental::{exp, ln};
use crate::state::archive::{Persist, persist_struct};

/// Whether and how elements fail. An absent one is a type without state, and costs nothing.
pub trait Failure: Send + Sync + 'static {
    /// What a block of elements keeps.
    type State: Clone + Send + Sync + Persist;
    const FAILS: bool;
    /// State of a block: the areas of its elements' sections, whose roots are their lengths, and their volumes.
    fn fresh(&self, area: &Lanes, volume: &Lanes) -> Self::State;
    /// Gives an element another length than the root of its area.
    fn set_length(&self, _state: &mut Self::State, _lane: usize, _length: f64) {}
    /// Whether an element of a block still carries; `None` if none can fail.
    fn alive(&self, state: &Self::State, lane: usize) -> Option<bool>;
    /// Whether elements can be deleted.
    fn deletes(&self) -> bool {
        Self::FAILS
    }
    /// What an increment leaves of the stress of a block's elements, as many as are there; of those that are gone what was left.
    fn degrade(&self, state: &mut Self::State, seen: &Seen) -> Shares;
    /// Volume of an element at the start.
    fn volume(&self, state: &Self::State, lane: usize) -> f64;
    /// Share of the stress that damage leaves; 0 of a deleted element.
    fn share(&self, state: &Self::State, lane: usize) -> f64;
    /// Share of the stress that damage has taken, where damage grows.
    fn damage(&self, _state: &Self::State, _lane: usize) -> Option<f64> {
        None
    }
    /// How far a criterion has come, 1 where damage begins: the largest of those that are meant, where there is one.
    fn initiation(&self, _state: &Self::State, _lane: usize, _of: Initiation) -> Option<f64> {
        None
    }
}

/// Criteria of the beginning of damage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Initiation {
    Any,
    Ductile,
    JohnsonCook,
}

/// What failure sees of a block's elements at the end of an increment.
#[derive(Clone, Debug)]
pub struct Seen {
    /// Increments of the equivalent plastic strain.
    pub plastic: Lanes,
    /// Mean stresses of the undamaged material.
    pub mean: Lanes,
    /// Von Mises stresses of the undamaged material.
    pub mises: Lanes,
    /// Temperatures, 0 where they are not followed.
    pub temperature: Lanes,
    pub dt: f64,
    /// Elements of the block.
    pub count: usize,
}

impl Seen {
    /// Mean stress over von Mises stress; 0 without any.
    #[inline(always)]
    fn triaxiality(&self, l: usize) -> f64 {
        if self.mises[l] > 0.0 { self.mean[l] / self.mises[l] } else { 0.0 }
    }

    /// Rate of the equivalent plastic strain.
    #[inline(always)]
    fn rate(&self, l: usize) -> f64 {
        if self.dt > 0.0 { self.plastic[l] / self.dt } else { 0.0 }
    }
}

/// What an increment leaves of the stresses of a block's elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares {
    /// Factors on the stress of the undamaged material.
    pub stress: Lanes,
    /// Mean stresses that the material bears, where tension is cut off.
    pub mean: Lanes,
}

#[derive(Clone, Copy, Debug)]
pub struct NoDamage;

impl Failure for NoDamage {
    type State = ();
    const FAILS: bool = false;

    fn fresh(&self, _area: &Lanes, _volume: &Lanes) {}

    fn volume(&self, (): &(), _lane: usize) -> f64 {
        1.0
    }

    fn alive(&self, (): &(), _lane: usize) -> Option<bool> {
        None
    }

    fn degrade(&self, (): &mut (), seen: &Seen) -> Shares {
        Shares { stress: [1.0; LANES], mean: seen.mean }
    }

    fn share(&self, (): &(), _lane: usize) -> f64 {
        1.0
    }
}

/// Equivalent plastic strain at which an element fails or its damage begins.
#[derive(Clone, Debug)]
pub enum FailureStrain {
    Constant(f64),
    /// (d1 + d2 exp(-d3 x)) (1 + d4 ln(rate/reference)) (1 + d5 theta), x = mean stress over von Mises stress
    /// (Johnson and Cook 1985, Eng. Fract. Mech. 21, 31; sign of d3 as ABAQUS has it).
    JohnsonCook {
        /// d1 to d5.
        d: [f64; 5],
        melt: f64,
        transition: f64,
        reference: f64,
    },
    /// Over the triaxiality (mean stress over von Mises stress), the rate of the plastic strain, and the temperature.
    Ductile(NestedTable),
    /// Over the rate, pressure over von Mises stress, and the temperature.
    Shear(NestedTable),
}

impl FailureStrain {
    /// The strains under the states of a block.
    #[inline(always)]
    fn strains(&self, seen: &Seen) -> Lanes {
        match self {
            FailureStrain::Constant(strain) => [*strain; LANES],
            FailureStrain::Ductile(levels) => by_lane(seen, |x, rate, t| levels.at(&[x, rate, t])),
            FailureStrain::Shear(levels) => by_lane(seen, |x, rate, t| levels.at(&[rate, -x, t])),
            FailureStrain::JohnsonCook { d, melt, transition, reference } => {
                johnson_cook(d, [*melt, *transition, *reference], seen)
            }
        }
    }
}

/// Strains by triaxiality, rate and temperature, one element after the other.
fn by_lane(seen: &Seen, strain: impl Fn(f64, f64, f64) -> f64) -> Lanes {
    let mut strains = [f64::INFINITY; LANES];
    for l in (0..seen.count).filter(|l| seen.plastic[*l] > 0.0) {
        strains[l] = strain(seen.triaxiality(l), seen.rate(l), seen.temperature[l]);
    }
    strains
}

/// Johnson and Cook's strains, all lanes at once.
#[inline(always)]
fn johnson_cook(d: &[f64; 5], [melt, transition, reference]: [f64; 3], seen: &Seen) -> Lanes {
    let (mut exponents, mut rates, mut strains) = ([0.0; LANES], [1.0; LANES], [0.0; LANES]);
    for l in 0..LANES {
        exponents[l] = -d[2] * seen.triaxiality(l);
        let rate = seen.rate(l) / reference;
        rates[l] = if rate > 1.0 { rate } else { 1.0 };
    }
    let (by_triaxiality, logarithms) = (exp(&exponents), ln(&rates));
    let per = 1.0 / (melt - transition);
    for l in 0..LANES {
        let theta = (seen.temperature[l] - transition) * per;
        let theta = if theta > 0.0 { theta } else { 0.0 };
        let theta = if theta < 1.0 { theta } else { 1.0 };
        strains[l] = (d[0] + d[1] * by_triaxiality[l]) * (1.0 + d[3] * logarithms[l]) * (1.0 + d[4] * theta);
    }
    strains
}

/// How damage grows once it has begun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Evolution {
    /// Not at all: the criterion is followed, and changes nothing.
    Absent,
    /// At once: the element is deleted.
    Sudden,
    /// Linear in the plastic displacement, which is the plastic strain times the element's length; the value at failure.
    Displacement(f64),
    /// Linear, so that failure takes this energy an area: the displacement at failure is twice it over the yield stress
    /// where damage began.
    Energy(f64),
}

/// A criterion over the plastic strain and what follows it.
#[derive(Clone, Debug)]
pub struct Criterion {
    /// Strain at failure: the sum of dp over it reaches 1.
    pub strain: FailureStrain,
    pub evolution: Evolution,
}

/// Mean stress that is not exceeded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cutoff {
    /// Its value, tension.
    pub stress: f64,
    /// Whether the element that reaches it is deleted; if not, its mean stress stays there.
    pub deletes: bool,
}

/// Failure of a material: criteria over the plastic strain, and a cutoff of tension.
#[derive(Clone, Debug, Default)]
pub struct Failing {
    /// At most one of each kind; the greatest damage counts.
    pub criteria: Vec<Criterion>,
    pub cutoff: Option<Cutoff>,
    /// By how much less than 1 is the damage at which an element is deleted (ABAQUS Analysis User's Guide, "Section controls":
    /// 1 less MAX DEGRADATION, which is 1 where elements are deleted).
    pub spared: f64,
    /// Whether elements stay with what that damage leaves them (`ELEMENT DELETION=NO`).
    pub kept: bool,
}

/// The most criteria a material has.
pub const CRITERIA: usize = 3;

/// What a block keeps of its failing elements.
#[derive(Clone, Debug)]
pub struct Damaged {
    alive: [bool; LANES],
    /// Of each criterion, the sum of dp over the strain at failure.
    begun: [Lanes; CRITERIA],
    /// Of each criterion, its damage and the displacement at failure, 0 before it begins.
    damage: [Lanes; CRITERIA],
    at_failure: [Lanes; CRITERIA],
    length: Lanes,
    volume: Lanes,
    /// 1 less the greatest damage.
    share: Lanes,
}

impl Failure for Failing {
    type State = Damaged;
    const FAILS: bool = true;

    fn volume(&self, state: &Damaged, lane: usize) -> f64 {
        state.volume[lane]
    }

    fn fresh(&self, area: &Lanes, volume: &Lanes) -> Damaged {
        Damaged {
            alive: [true; LANES],
            begun: [[0.0; LANES]; CRITERIA],
            damage: [[0.0; LANES]; CRITERIA],
            at_failure: [[0.0; LANES]; CRITERIA],
            length: area.inline_map(f64::sqrt),
            volume: *volume,
            share: [1.0; LANES],
        }
    }

    fn set_length(&self, state: &mut Damaged, lane: usize, length: f64) {
        state.length[lane] = length;
    }

    fn alive(&self, state: &Damaged, lane: usize) -> Option<bool> {
        self.deletes().then_some(state.alive[lane])
    }

    fn deletes(&self) -> bool {
        let harmless = |c: &Criterion| c.evolution == Evolution::Absent;
        !self.kept && (self.cutoff.is_some() || !self.criteria.iter().all(harmless))
    }

    fn share(&self, state: &Damaged, lane: usize) -> f64 {
        if state.alive[lane] { state.share[lane] } else { 0.0 }
    }

    fn damage(&self, state: &Damaged, lane: usize) -> Option<f64> {
        (!self.criteria.is_empty()).then(|| 1.0 - state.share[lane])
    }

    fn initiation(&self, state: &Damaged, lane: usize, of: Initiation) -> Option<f64> {
        let meant = |criterion: &Criterion| match (&criterion.strain, criterion.evolution) {
            // Of *SHEAR FAILURE.
            (_, Evolution::Sudden) => false,
            (FailureStrain::Ductile(_), _) => of != Initiation::JohnsonCook,
            (FailureStrain::JohnsonCook { .. }, _) => of != Initiation::Ductile,
            _ => false,
        };
        // Where damage follows it begins at 1; where none does the sum goes on.
        let shown = |(c, begun): (&Criterion, &Lanes)| {
            if c.evolution == Evolution::Absent { begun[lane] } else { begun[lane].min(1.0) }
        };
        self.criteria.iter().zip(&state.begun).filter(|c| meant(c.0)).map(shown).reduce(f64::max)
    }

    #[inline(always)]
    fn degrade(&self, state: &mut Damaged, seen: &Seen) -> Shares {
        let mut left = Shares { stress: [1.0; LANES], mean: seen.mean };
        let mut worst = [0.0; LANES];
        // Where nothing flows no criterion goes on.
        if seen.plastic[..seen.count].iter().any(|plastic| *plastic != 0.0) {
            for (c, criterion) in self.criteria.iter().enumerate() {
                criterion.grow(state, c, seen);
            }
        }
        for damage in &state.damage[..self.criteria.len()] {
            for l in 0..LANES {
                worst[l] = if damage[l] > worst[l] { damage[l] } else { worst[l] };
            }
        }
        let alive = state.alive;
        for l in (0..seen.count).filter(|l| alive[*l]) {
            self.settle(state, l, worst[l], &mut left.mean[l]);
            left.stress[l] = self.share(state, l);
        }
        left
    }
}

impl Failing {
    /// What the greatest damage of an element leaves, and the cutoff of its mean stress.
    fn settle(&self, state: &mut Damaged, l: usize, damage: f64, mean: &mut f64) {
        let mut worst = damage;
        if let Some(cutoff) = self.cutoff.filter(|cutoff| *mean > cutoff.stress) {
            *mean = cutoff.stress;
            if cutoff.deletes {
                worst = 1.0;
            }
        }
        // What is left of the stress divides the stress of the next increment: the last trace of it is let go, or kept.
        if self.kept {
            worst = worst.min(1.0 - self.spared.max(1e-6));
        } else {
            state.alive[l] &= worst < 1.0 - 1e-6 - self.spared;
        }
        state.share[l] = 1.0 - worst;
    }
}

impl Criterion {
    /// Lets the damage of elements that flow grow by this criterion. Not a number is no reason to fail: it must be found.
    #[inline(always)]
    fn grow(&self, state: &mut Damaged, c: usize, seen: &Seen) {
        let strains = self.strain.strains(seen);
        let followed = self.evolution == Evolution::Absent;
        let mut more = [0.0; LANES];
        for l in 0..LANES {
            let part = if strains[l] > 0.0 { seen.plastic[l] / strains[l] } else { 1.0 };
            let goes_on = (seen.plastic[l] > 0.0) & (followed | (state.begun[c][l] < 1.0));
            more[l] = if goes_on { part } else { 0.0 };
        }
        let alive = state.alive;
        for l in (0..seen.count).filter(|l| seen.plastic[*l] > 0.0 && alive[*l]) {
            let begun = state.begun[c][l] >= 1.0;
            state.begun[c][l] += more[l];
            if state.begun[c][l] >= 1.0 && !followed {
                self.evolve(state, (c, l), begun, seen);
            }
        }
    }

    /// Damage of an element that has begun, in an increment before this one or in it.
    fn evolve(&self, state: &mut Damaged, (c, l): (usize, usize), begun: bool, seen: &Seen) {
        if !begun {
            state.at_failure[c][l] = match self.evolution {
                Evolution::Sudden | Evolution::Absent => 0.0,
                Evolution::Displacement(displacement) => displacement,
                Evolution::Energy(energy) => 2.0 * energy / seen.mises[l],
            };
        }
        let at_failure = state.at_failure[c][l];
        let more = if at_failure > 0.0 { seen.plastic[l] * state.length[l] / at_failure } else { 1.0 };
        // The increment in which damage begins counts from its end.
        if begun || at_failure == 0.0 {
            state.damage[c][l] = (state.damage[c][l] + more).min(1.0);
        }
    }
}

// A routine of the user may have given the length, and is not asked again.
persist_struct!(Damaged { alive, begun, damage, at_failure, length, share } derived { volume });
