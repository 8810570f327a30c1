//! What stops a run that has gone wrong: energies that are not finite, limits that the deck sets on them
//! (`*ENERGY LIMIT`), increments that would never reach the end of the step; and what is told of it where it ends.
//! Never here: how energies are booked, how an increment is chosen.

use super::increment::shortened;
use super::run::Run;
use crate::load::stiffness::Stiffness;
use crate::model::IncrementControl;
use crate::state::halt::Halt;
use crate::state::magnitude::Clock;

/// The smallest stable increment over the length of the step: below it the step would take more than ten thousand million
/// increments, which only an element that collapses asks for.
const FLOOR: f64 = 1e-10;

/// Internal energy below this fraction of the largest energy is too small to compare artificial energy with.
const SMALL: f64 = 0.01;

/// What the end of a run warns of without being asked: drift of ETOTAL over the largest energy, ALLAE over ALLIE. The second
/// is the rule of practice: above it hourglass control has its share in the answer.
const SOUND: [f64; 2] = [0.01, 0.05];

/// What is passed first of what has not been told: which limit, the value reached and the limit.
fn passed(values: [f64; 2], limits: [Option<f64>; 2], told: [bool; 2]) -> Option<(usize, f64, f64)> {
    (0..2).filter(|&i| !told[i]).find_map(|i| Some((i, values[i], limits[i].filter(|l| values[i] > *l)?)))
}

impl Run<'_> {
    /// After energies are booked.
    ///
    /// # Errors
    /// Where they are not finite, or pass a limit that halts.
    #[inline(always)]
    pub(super) fn guard_energy(&mut self) -> Result<(), Halt> {
        let unsound = self.balance.exceeds(SOUND, SMALL);
        for (since, unsound) in self.unsound.iter_mut().zip(unsound) {
            if unsound != since.is_some() {
                *since = unsound.then_some(self.now.total_time);
            }
        }
        if self.balance.is_finite() && self.step.energy_limit.is_none() { Ok(()) } else { self.look_at_energy() }
    }

    /// At the end: what is beyond sound bounds then, since when, and where the mesh is folded most.
    pub(super) fn warn_of_energy(&mut self) {
        let values = [self.balance.drift(), self.balance.artificial_share(SMALL)];
        let of_deck = self.step.energy_limit.map_or([false; 2], |l| [l.error.is_some(), l.artificial.is_some()]);
        let [drift, artificial] = [0, 1].map(|i| self.unsound[i].filter(|_| !of_deck[i] && !self.warned[i]));
        if let Some(since) = drift {
            self.outcome.warnings.push(format!(
                "ETOTAL has drifted by {:.2} % of the largest energy, more than {} % since time {since:e}: energy was made or \
                 lost{}",
                100.0 * values[0],
                100.0 * SOUND[0],
                self.name_folded()
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

    /// At the end of a step: which loads shortened the increment, or would have.
    pub(super) fn warn_of_stiff_loads(&mut self) {
        let alone = self.elements.stable_increment();
        let fixed = matches!(self.step.control, IncrementControl::Fixed(_));
        for load in &self.loads {
            let Some(found) = load.stiffness() else { continue };
            let by = shortened(found.squared, alone);
            let done = if fixed {
                "the increments that the deck gives do not follow it"
            } else {
                "since then increments follow it"
            };
            let row = &self.plan.ledger.effects[load.id()];
            let Stiffness { rate, point, place: [r, z], time, .. } = found;
            self.outcome.warnings.push(format!(
                "{} ({}): the pressure grows by {rate:.3e} for each unit of length that the surface moves out, at point {} \
                 (r = {r:.4e}, z = {z:.4e}), a stiffness that elements know nothing of. Motion began to grow by it at time \
                 {time:e}; {done}, {by:.1} times shorter than those of the elements. With SCALE FACTOR={:.2} on *DYNAMIC \
                 nothing grows from the start",
                row.effect,
                row.asked_by.join(", "),
                point + 1,
                (1.0 / by).min(1.0)
            ));
        }
    }

    /// At the end of a step: what constraints have noticed.
    pub(super) fn warn_of_constraints(&mut self) {
        let clock = Clock { now: self.now, told: &self.told };
        for constraint in &mut self.constraints {
            self.outcome.warnings.extend(constraint.warnings(&self.dofs, &clock));
        }
    }

    fn name_folded(&self) -> String {
        let Some(most) = self.elements.most_folded(&self.dofs.nodes) else { return String::new() };
        let name = self.plan.element_name(most.group, most.element);
        format!(". The mesh is folded most in element {name}, by {:.0} % of its size", 100.0 * most.fold)
    }

    #[inline(never)]
    fn look_at_energy(&mut self) -> Result<(), Halt> {
        if !self.balance.is_finite() {
            let reason = format!(
                "the energy of the scene is no finite number at increment {}, time {:e}",
                self.now.increment, self.now.total_time
            );
            return Err(Halt { code: "R203", reason });
        }
        let Some(limit) = &self.step.energy_limit else { return Ok(()) };
        let values = [self.balance.drift(), self.balance.artificial_share(SMALL)];
        let Some((which, value, allowed)) = passed(values, [limit.error, limit.artificial], self.warned) else {
            return Ok(());
        };
        let what = ["energy drift", "artificial over internal energy"][which];
        let reason = format!(
            "{what} is {value:.2e}, above the limit {allowed:e}, at increment {}, time {:e}",
            self.now.increment, self.now.total_time
        );
        if limit.halts {
            return Err(Halt { code: "R208", reason });
        }
        self.warned[which] = true;
        self.outcome.warnings.push(reason);
        Ok(())
    }

    /// Whether the elements let the step come to an end.
    ///
    /// # Errors
    /// If one of them has collapsed so far that it would not.
    #[inline(always)]
    pub(super) fn guard_increment(&self) -> Result<(), Halt> {
        if !self.elements.is_empty() && self.elements.stable_increment() < FLOOR * self.step.duration {
            return Err(self.crawls());
        }
        Ok(())
    }

    #[cold]
    fn crawls(&self) -> Halt {
        let (stable, (group, element)) = (self.elements.stable_increment(), self.elements.limiting());
        let reason = format!(
            "element {} has collapsed: at increment {}, time {:e} its stable increment is {stable:e}, with which the step \
             would need more than 1e10 increments",
            self.plan.element_name(group, element),
            self.now.increment,
            self.now.total_time
        );
        Halt { code: "R209", reason }
    }
}

#[cfg(test)]
mod tests {
    use super::passed;

    #[test]
    fn limits_are_told_once() {
        let limits = [Some(0.1), Some(0.05)];
        assert_eq!(passed([0.1, 0.05], limits, [false; 2]), None);
        assert_eq!(passed([0.2, 0.06], limits, [false; 2]), Some((0, 0.2, 0.1)));
        assert_eq!(passed([0.2, 0.06], limits, [true, false]), Some((1, 0.06, 0.05)));
        assert_eq!(passed([0.2, 0.06], limits, [true; 2]), None);
        assert_eq!(passed([0.2, 0.06], [None, None], [false; 2]), None);
    }
}
