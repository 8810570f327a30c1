//! What a run tells of itself: energies beyond sound bounds or below zero, a pattern that grows, increments that
//! crawl; since when, where, and what helps.
//! Never here: what halts a run (`guard.rs`), how energies are booked.

use super::energy::{Balance, Energy};
use super::run::Run;
use crate::kernel::lanes::InlineMap;
use crate::model::IncrementControl;
use crate::state::archive::persist_struct;
use crate::state::{BodyState, Instant};

/// Internal energy below this fraction of the largest energy is too small to compare artificial energy with.
pub(super) const SMALL: f64 = 0.01;

/// What the end of a run warns of without being asked: drift of ETOTAL over the largest energy, ALLAE over ALLIE. The second
/// is the rule of practice: above it hourglass control has its share in the answer.
const SOUND: [f64; 2] = [0.01, 0.05];

/// Kinetic or internal energy so far below zero, over the largest energy, is told ...
const BELOW_ZERO: f64 = 0.01;

/// ... once so many increments have found it: what is let go all at once brings it for a few.
const SEEN: u64 = 10;

/// What is said of kinetic and of internal energy below zero.
const SIGNS: [[&str; 2]; 2] = [
    [
        "ALLKE",
        "nodes turn around within an increment, which is near or beyond the stable one; SCALE FACTOR=0.5 on *DYNAMIC shows \
         what that does",
    ],
    [
        "ALLIE",
        "elements have given more than they were given, which none of their laws has in store. Rates of stress do so on large \
         closed paths of strain, where *HYPERELASTIC does not; SCALE FACTOR=0.5 on *DYNAMIC or a finer mesh shows whether \
         it is something else",
    ],
];

/// Increments to go above which a step crawls: hours on any machine for what has more than a few elements.
const CRAWL: f64 = 1e8;

/// Increments between looks at what costs some of them: at first few, then many. Odd, so that looks do not fall on the increments
/// that are timed, which would count them too often.
const LOOK_EVERY: [u64; 2] = [17, 511];

/// A pattern is told once its kinetic energy is this share of all that moves within elements ...
const PATTERN: f64 = 0.75;
/// ... so many times that of the look before ...
const GROWTH: f64 = 4.0;
/// ... and more than this of the largest energy.
const WORTH: f64 = 0.01;

/// What is known of the run behind.
#[derive(Clone, Debug, Default)]
pub(super) struct Watch {
    /// Since when the drift of ETOTAL and ALLAE have been beyond sound bounds, total time.
    unsound: [Option<f64>; 2],
    /// Increments in a row, up to this one, that found a drift which halts.
    pub(super) adrift: u64,
    /// All of them.
    pub(super) beyond: u64,
    /// Increments that found kinetic and internal energy below zero, up to that which told it.
    below_zero: [u64; 2],
    /// Whether a pattern and crawling have been told.
    trembles: bool,
    crawls: bool,
    /// Whether the look before found increments too small.
    slow: bool,
    /// Kinetic energy in the pattern at the look before.
    pattern: f64,
    next_look: u64,
    /// Which of the deck's limits on energies have been reported in this step.
    pub(super) limits_reported: [bool; 2],
    /// Warnings that the sink has been shown.
    pub(super) shown: usize,
}

impl Watch {
    /// Each step may crawl anew.
    pub(super) fn begin_step(&mut self) {
        (self.crawls, self.slow) = (false, false);
    }

    /// Whether nothing calls for a closer look.
    #[inline(always)]
    pub(super) fn is_content(&mut self, balance: &Balance, now: &Instant) -> bool {
        let unsound = balance.exceeds(SOUND, SMALL);
        for (since, unsound) in self.unsound.iter_mut().zip(unsound) {
            if unsound != since.is_some() {
                *since = unsound.then_some(now.total_time);
            }
        }
        let lowest = balance.kinetic_of_solid().min(balance.internal_of_solid());
        let below = lowest < -BELOW_ZERO * balance.largest();
        !unsound[0] && !below && now.increment < self.next_look
    }
}

impl Run<'_> {
    /// What calls for a closer look.
    pub(super) fn watch(&mut self) {
        self.watch_sign();
        if self.now.increment >= self.watch.next_look {
            self.watch.next_look = self.now.increment + self.now.increment.clamp(LOOK_EVERY[0], LOOK_EVERY[1]);
            self.watch_pattern();
            self.watch_pace();
        }
    }

    /// Kinetic energy below zero, as central differences have it where velocities change sign from one half step to the next;
    /// internal energy below zero, where no element has any to give.
    fn watch_sign(&mut self) {
        let largest = self.balance.largest();
        let energies = [self.balance.kinetic_of_solid(), self.balance.internal_of_solid()];
        for (which, energy) in energies.into_iter().enumerate() {
            let told = self.watch.below_zero[which] > SEEN;
            if told || energy >= -BELOW_ZERO * largest || (which == 1 && self.plan.stores_energy) {
                continue;
            }
            self.watch.below_zero[which] += 1;
            if self.watch.below_zero[which] < SEEN || self.is_noise() {
                continue;
            }
            self.watch.below_zero[which] = SEEN + 1;
            let [name, why] = SIGNS[which];
            self.outcome.warnings.push(format!(
                "{name} is {energy:.3e}, below zero by {:.1} % of the largest energy, at increment {}, time {:e}: {why}{}",
                -100.0 * energy / largest,
                self.now.increment,
                self.now.total_time,
                self.name_folded()
            ));
        }
    }

    /// Hourglass patterns that grow.
    fn watch_pattern(&mut self) {
        if self.watch.trembles || self.state.elements.is_empty() {
            return;
        }
        let now = self.state.elements.trembling(&self.state.dofs.nodes);
        let before = std::mem::replace(&mut self.watch.pattern, now.kinetic);
        let counts = now.kinetic > WORTH * self.balance.largest() && !self.is_noise();
        let grows = before > 0.0 && now.kinetic >= GROWTH * before;
        if !counts || !grows || now.kinetic < PATTERN * now.relative {
            return;
        }
        self.watch.trembles = true;
        let (group, element) = now.most;
        self.outcome.warnings.push(format!(
            "an hourglass pattern grows at increment {}, time {:e}: {:.0} % of what moves within elements is in it, most in \
             element {}; HOURGLASS=ENHANCED or a larger factor on *SECTION CONTROLS stands against it",
            self.now.increment,
            self.now.total_time,
            100.0 * (now.kinetic / now.relative).min(1.0),
            self.plan.element_name(group, element)
        ));
    }

    /// Increments that hardly advance: told at the second look in a row that finds them so.
    fn watch_pace(&mut self) {
        let remaining = self.step.duration - self.now.step_time;
        let slow = self.last_increment > 0.0 && remaining > CRAWL * self.last_increment;
        let told = std::mem::replace(&mut self.watch.slow, slow) && slow && !self.watch.crawls;
        if !told {
            return;
        }
        self.watch.crawls = true;
        let by = match self.step.control {
            IncrementControl::Fixed(_) => "; DIRECT USER CONTROL gives it".into(),
            IncrementControl::Automatic { .. } if self.state.elements.is_empty() => String::new(),
            IncrementControl::Automatic { .. } => self.name_slowest(),
        };
        self.outcome.warnings.push(format!(
            "the run crawls: at increment {}, time {:e} the increment is {:.3e}, with which the step has {:.1e} increments to \
             go{by}",
            self.now.increment,
            self.now.total_time,
            self.last_increment,
            remaining / self.last_increment
        ));
    }

    fn name_slowest(&self) -> String {
        let (group, element) = self.state.elements.limiting();
        format!(
            "; element {} limits it: DISTORTION CONTROL=YES on *SECTION CONTROLS, *VARIABLE MASS SCALING or *EROSION keep \
             such elements from it",
            self.plan.element_name(group, element)
        )
    }

    /// Whether all energies so far are within what rounding of coordinates makes: the mass at a velocity of as much in an
    /// increment; or within what contact keeps from bodies at rest in each.
    pub(super) fn is_noise(&self) -> bool {
        const ROUNDINGS: f64 = 100.0;
        let nodes = &self.state.dofs.nodes;
        let extent = nodes.start.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
        let speed = ROUNDINGS * f64::EPSILON * extent / self.last_increment;
        let rounding = 0.5 * nodes.mass.iter().sum::<f64>() * speed * speed;
        // Below the second products of energies are lost.
        let stopped: f64 = self.state.dofs.bodies.iter().map(BodyState::energy_stopped).sum();
        self.balance.largest() <= rounding.max(stopped).max(f64::MIN_POSITIVE / f64::EPSILON)
    }

    /// At the end: what is beyond sound bounds then, since when, and where the mesh is folded most.
    pub(super) fn warn_of_energy(&mut self) {
        let values = [self.balance.drift(), self.balance.artificial_share(SMALL)];
        let of_deck = self.step.energy_limit.map_or([false; 2], |l| [l.error.is_some(), l.artificial.is_some()]);
        // A halt by either has said it.
        let halted = self.outcome.halt.as_ref().is_some_and(|h| h.code == "R208");
        let told = |i: usize| of_deck[i] || self.watch.limits_reported[i] || halted;
        let [drift, artificial] = [0, 1].inline_map(|i| self.watch.unsound[i].filter(|_| !told(i)));
        if drift.is_some() && !self.is_noise() {
            self.outcome.warnings.push(format!(
                "ETOTAL has drifted by {:.2} % of the largest energy, more than {} %{}: energy was made or lost{}. {}",
                100.0 * values[0],
                100.0 * SOUND[0],
                self.drifts_since(),
                self.name_folded(),
                self.likely_cause()
            ));
        }
        if let Some(since) = artificial {
            self.outcome.warnings.push(format!(
                "ALLAE is {:.1} % of ALLIE, more than {} % since time {since:e}: hourglass control has its share in the \
                 answer; a finer mesh, or another HOURGLASS of *SECTION CONTROLS, shows by how much{}",
                100.0 * values[1],
                100.0 * SOUND[1],
                self.name_folded()
            ));
        }
    }

    /// Since when the drift has not been sound.
    pub(super) fn drifts_since(&self) -> String {
        self.watch.unsound[0]
            .map_or_else(String::new, |since| format!(", above {} % since time {since:e}", 100.0 * SOUND[0]))
    }

    pub(super) fn name_folded(&self) -> String {
        let Some(most) = self.state.elements.most_folded(&self.state.dofs.nodes) else { return String::new() };
        let name = self.plan.element_name(most.group, most.element);
        format!(". The mesh is folded most in element {name}, by {:.0} % of its size", 100.0 * most.fold)
    }

    /// What a drift most likely comes from, and the card that cures it.
    pub(super) fn likely_cause(&self) -> String {
        let beyond = match self.step.control {
            IncrementControl::Fixed(given) if given > self.previous_stable_increment => {
                Some(given / self.previous_stable_increment)
            }
            _ => None,
        };
        cause(&self.balance.energy(), self.balance.drift() * self.balance.largest(), beyond)
    }
}

/// The cause of a departure of ETOTAL; `beyond`: by how much given increments exceed the stable one.
fn cause(energy: &Energy, departure: f64, beyond: Option<f64>) -> String {
    let part = 0.5 * departure;
    if let Some(beyond) = beyond {
        return format!(
            "DIRECT USER CONTROL gives increments {beyond:.2} times the stable one: give smaller ones, or leave them to the program"
        );
    }
    if energy.distortion.abs() > part {
        return "Distortion control does as much work as that: DISTORTION CONTROL=NO on *SECTION CONTROLS, or *EROSION for \
                elements that are pressed flat, shows what it adds"
            .into();
    }
    if energy.internal < -part {
        return "Elements have given more than they were given: *TENSILE FAILURE or *EROSION ends a law that has no strength \
                left"
            .into();
    }
    if energy.artificial.abs() > part {
        return "Hourglass control does as much work as that: HOURGLASS=ENHANCED on *SECTION CONTROLS, or a finer mesh"
            .into();
    }
    "SCALE FACTOR=0.5 on *DYNAMIC shows whether the increment is too long for loads, contact or a law that stiffens"
        .into()
}

persist_struct!(Watch {
    unsound, adrift, beyond, below_zero, trembles, crawls, slow, pattern, next_look, limits_reported
} derived {
    shown
});

#[cfg(test)]
mod tests {
    use super::{Energy, cause};

    #[test]
    fn a_cause_is_named_with_its_card() {
        let energy = Energy::default();
        let named = |energy: Energy, beyond| cause(&energy, 1.0, beyond);
        assert!(named(energy, Some(2.0)).contains("2.00 times the stable one"));
        assert!(named(Energy { distortion: 0.6, ..energy }, None).contains("DISTORTION CONTROL"));
        assert!(named(Energy { internal: -0.6, ..energy }, None).contains("*TENSILE FAILURE"));
        assert!(named(Energy { artificial: -0.6, ..energy }, None).contains("HOURGLASS"));
        assert!(named(energy, None).contains("SCALE FACTOR"));
    }
}
