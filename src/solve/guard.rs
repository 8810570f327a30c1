//! What stops a run that has gone wrong: energies that are not finite, limits that the deck sets on them
//! (`*ENERGY LIMIT`) or every run has, increments that would never reach the end of the step.
//! Never here: how energies are booked, how an increment is chosen, what is only told (`watch.rs`).

use super::increment::shortened;
use super::run::Run;
use super::watch::SMALL;
use crate::constraint::Constraint;
use crate::load::Load;
use crate::load::stiffness::Stiffness;
use crate::model::IncrementControl;
use crate::plan::StepPlan;
use crate::state::halt::Halt;
use crate::state::magnitude::Clock;

/// The smallest stable increment over the length of the step: below it the step would take more than ten thousand million
/// increments, which only an element that collapses asks for.
const FLOOR: f64 = 1e-10;

/// Increments of an analysis before which no drift halts, unless it is over: a load that is there at once makes some of nothing
/// while there is next to no energy.
const EARLY: u64 = 500;
/// Drift of ETOTAL over the largest energy at which every run halts ...
const LARGEST_DRIFT: f64 = 0.2;
/// ... once so many increments in a row have found it.
const LASTING: u64 = 10;

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
        let watched = self.watch.is_content(&self.balance, &self.now);
        if watched && self.balance.is_finite() && self.step.energy_limit.is_none() {
            Ok(())
        } else {
            self.look_at_energy()
        }
    }

    /// At the end of loads: which shortened the increment, or would have.
    pub(super) fn warn_of_stiff_loads(&mut self, loads: &[Box<dyn Load>]) {
        let alone = self.state.elements.stable_increment();
        let fixed = matches!(self.step.control, IncrementControl::Fixed(_));
        for load in loads {
            let Some(found) = load.stiffness() else { continue };
            let by = shortened(found.squared, alone);
            let done = if fixed {
                "the increments that the deck gives do not follow it"
            } else {
                "since then increments follow it"
            };
            let row = &self.plan.ledger.effects[load.effect()];
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

    /// At the end of constraints: what they have noticed.
    pub(super) fn warn_of_constraints(&mut self, constraints: &mut [Box<dyn Constraint>]) {
        let clock = Clock { now: self.now, user_amplitudes: &self.state.user_amplitudes };
        for constraint in constraints {
            let upkeep = constraint.upkeep();
            self.outcome.warnings.extend(upkeep.map_or_else(Vec::new, |c| c.warnings(&self.state.dofs, &clock)));
        }
    }

    /// At the end of the run: what the effects in force have noticed.
    pub(super) fn warn_of_effects(&mut self) {
        let (loads, mut constraints) =
            (std::mem::take(&mut self.state.loads), std::mem::take(&mut self.state.constraints));
        self.warn_of_stiff_loads(&loads);
        self.warn_of_constraints(&mut constraints);
        (self.state.loads, self.state.constraints) = (loads, constraints);
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
        self.hold_to_limits()?;
        self.hold_to_balance()?;
        self.watch();
        Ok(())
    }

    /// Limits that the deck gives.
    fn hold_to_limits(&mut self) -> Result<(), Halt> {
        let Some(limit) = &self.step.energy_limit else { return Ok(()) };
        let values = [self.balance.drift(), self.balance.artificial_share(SMALL)];
        let Some((which, value, allowed)) = passed(values, [limit.error, limit.artificial], self.watch.limits_reported)
        else {
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
        self.watch.limits_reported[which] = true;
        self.outcome.warnings.push(reason);
        Ok(())
    }

    /// The limit of every run, unless the deck gives one of its own. The first increments pass, for what is small cannot be
    /// told from what is wrong; and an instant beyond it is none yet, for energies of undamped vibration jump where increments do.
    fn hold_to_balance(&mut self) -> Result<(), Halt> {
        let drift = self.balance.drift_now();
        self.watch.adrift = if drift > LARGEST_DRIFT { self.watch.adrift + 1 } else { 0 };
        self.watch.beyond += u64::from(drift > LARGEST_DRIFT);
        let passes = self.watch.adrift < LASTING || self.now.increment < EARLY || self.step.has_drift_limit();
        if passes || self.is_noise() { Ok(()) } else { Err(self.drifted(drift)) }
    }

    /// The same at the end of an analysis that is over before it has been judged: nobody shall take it for an answer. One
    /// instant alone counts where there are next to no others.
    ///
    /// # Errors
    /// Where energies have not been kept.
    pub(super) fn judge_end(&self) -> Result<(), Halt> {
        let is_early = self.now.increment < EARLY;
        let drift = self.balance.drift();
        let is_met = drift > LARGEST_DRIFT && self.watch.beyond > u64::from(self.now.increment > LASTING);
        let own = self.plan.steps.iter().any(StepPlan::has_drift_limit);
        if !is_early || !is_met || own || self.is_noise() { Ok(()) } else { Err(self.drifted(drift)) }
    }

    fn drifted(&self, drift: f64) -> Halt {
        let reason = format!(
            "ETOTAL has drifted by {:.1} % of the largest energy, more than {:.0} %, at increment {}, time {:e}{}: energy was \
             made or lost{}. {}. *ENERGY LIMIT, ERROR in the step lets a run go on",
            100.0 * drift,
            100.0 * LARGEST_DRIFT,
            self.now.increment,
            self.now.total_time,
            self.drifts_since(),
            self.name_folded(),
            self.likely_cause()
        );
        Halt { code: "R208", reason }
    }

    /// Whether the elements let the step come to an end.
    ///
    /// # Errors
    /// If one of them has collapsed so far that it would not.
    #[inline(always)]
    pub(super) fn guard_increment(&self) -> Result<(), Halt> {
        if !self.state.elements.is_empty() && self.state.elements.stable_increment() < FLOOR * self.step.duration {
            return Err(self.crawls());
        }
        Ok(())
    }

    #[cold]
    fn crawls(&self) -> Halt {
        let (stable, (group, element)) = (self.state.elements.stable_increment(), self.state.elements.limiting());
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
