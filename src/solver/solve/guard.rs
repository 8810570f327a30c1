//! Checks that halt a run: energies that are not finite, energy limits of the deck (`*ENERGY LIMIT`) and of every run,
//! and increments too small to complete the step. Warnings are in `watch.rs`.

use super::increment::shortened;
use super::run::SolverRun;
use super::watch::SMALL;
use crate::constraint::Constraint;
use crate::load::Load;
use crate::load::stiffness::LoadStiffness;
use crate::plan::StepPlan;
use crate::state::halt::{HaltDetails, HaltReason};
use crate::state::magnitude::AmplitudeClock;

/// Smallest stable time increment over the length of the step. Below it the step would need more than 1e10 increments,
/// which happens only if an element collapses.
const FLOOR: f64 = 1e-10;

/// Increments of an analysis in which drift does not halt, except at its end. A suddenly applied load causes a relative
/// drift while the energies are still close to zero.
const EARLY: u64 = 500;
/// Drift of ETOTAL, relative to the energy put in, above which every run halts.
const LARGEST_DRIFT: f64 = 0.2;
/// Energy created by contact, as a fraction of the energy put in, above which every run halts.
const LARGEST_CREATED: f64 = 0.2;
/// Amount of a term of the energy below zero or above the energy put in, as a fraction of the latter, above which every
/// run halts.
const LARGEST_EXCESS: f64 = 1.0;
/// Number of increments above these limits that halt a run, without an increment below them.
const LASTING: u64 = 10;

/// Returns the first value above its limit that has not been reported: index, value and limit.
fn first_exceeded(values: [f64; 2], limits: [Option<f64>; 2], reported: [bool; 2]) -> Option<(usize, f64, f64)> {
    (0..2).filter(|&i| !reported[i]).find_map(|i| Some((i, values[i], limits[i].filter(|l| values[i] > *l)?)))
}

impl SolverRun<'_> {
    /// Checks the energies after an increment.
    ///
    /// # Errors
    /// If they are not finite, or exceed a limit that halts.
    #[inline(always)]
    pub(super) fn guard_energy(&mut self) -> Result<(), HaltReason> {
        let watched = self.watch.needs_no_check(&self.balance, &self.now);
        if watched && self.balance.is_finite() && self.step.energy_limit.is_none() {
            Ok(())
        } else {
            self.check_energy()
        }
    }

    /// Warns of stiff loads that end, if they reduced the increment or should have.
    pub(super) fn warn_of_stiff_loads(&mut self, loads: &[Box<dyn Load>]) {
        let alone = self.state.elements.stable_increment();
        let fixed = self.step.is_fixed();
        for load in loads {
            let Some(found) = load.stiffness() else { continue };
            let by = shortened(found.squared, alone);
            let done = if fixed {
                format!(
                    "a stable increment is {by:.1} times smaller than that of the elements, and the increments of the deck are fixed"
                )
            } else {
                format!("since then increments are {by:.1} times smaller than those of the elements")
            };
            let row = &self.plan.ledger.effects[load.effect()];
            let LoadStiffness { rate, point, place: [r, z], time, .. } = found;
            self.outcome.warn("R312", format!(
                "{} ({}): the pressure increases by {rate:.3e} per unit of outward displacement at point {} (r = {r:.4e}, z = {z:.4e}). \
                 This stiffness is not part of the stable time increment of the elements, and an instability began at time \
                 {time:e}; {done}. SCALE FACTOR={:.2} on *DYNAMIC avoids the instability",
                row.effect,
                row.asked_by.join(", "),
                point + 1,
                (1.0 / by).min(1.0)
            ));
        }
    }

    /// Adds the warnings of constraints that end.
    pub(super) fn warn_of_constraints(&mut self, constraints: &mut [Box<dyn Constraint>]) {
        let clock = AmplitudeClock { now: self.now, user_amplitudes: &self.state.user_amplitudes };
        for constraint in constraints {
            let upkeep = constraint.upkeep();
            let overlaps = upkeep.map_or_else(Vec::new, |c| c.overlaps(&self.state.dofs, &clock));
            overlaps.into_iter().for_each(|text| self.outcome.warn("R311", text));
        }
    }

    /// Adds the warnings of the effects in force at the end of the run.
    pub(super) fn warn_of_effects(&mut self) {
        let (loads, mut constraints) =
            (std::mem::take(&mut self.state.loads), std::mem::take(&mut self.state.constraints));
        self.warn_of_stiff_loads(&loads);
        self.warn_of_constraints(&mut constraints);
        (self.state.loads, self.state.constraints) = (loads, constraints);
    }

    #[inline(never)]
    fn check_energy(&mut self) -> Result<(), HaltReason> {
        if !self.balance.is_finite() {
            let reason = format!(
                "the energy of the model is not a finite number at increment {}, time {:e}",
                self.now.increment, self.now.total_time
            );
            return Err(HaltReason::NotFinite(HaltDetails::new(reason)));
        }
        self.check_energy_limits()?;
        self.check_drift()?;
        self.check_contact()?;
        self.check_terms()?;
        self.watch();
        Ok(())
    }

    /// Checks the limits that the deck gives.
    fn check_energy_limits(&mut self) -> Result<(), HaltReason> {
        let Some(limit) = &self.step.energy_limit else { return Ok(()) };
        let values = [self.balance.drift(), self.balance.artificial_share(SMALL)];
        let Some((which, value, allowed)) =
            first_exceeded(values, [limit.error, limit.artificial], self.watch.limits_reported)
        else {
            return Ok(());
        };
        let what = ["energy drift", "artificial over internal energy"][which];
        let reason = format!(
            "{what} is {value:.2e}, above the limit {allowed:e}, at increment {}, time {:e}",
            self.now.increment, self.now.total_time
        );
        if limit.halts {
            return Err(HaltReason::EnergyLimit(HaltDetails::new(reason)));
        }
        self.watch.limits_reported[which] = true;
        self.outcome.warn("R313", reason);
        Ok(())
    }

    /// Checks the drift limit of every run, unless the deck gives its own. The first increments are excluded, because
    /// energies are too small to be judged. A single increment above the limit does not halt, because energies of
    /// undamped vibration jump when the increment changes.
    fn check_drift(&mut self) -> Result<(), HaltReason> {
        let drift = self.balance.drift_now();
        // While energy is supplied, the relative drift of the first increment under a sudden load decreases.
        let decreases = drift < std::mem::replace(&mut self.watch.drift, drift);
        let lasting = self.watch.lasting_drifts + u64::from(!decreases);
        self.watch.lasting_drifts = if drift > LARGEST_DRIFT { lasting } else { 0 };
        self.watch.drift_count += u64::from(drift > LARGEST_DRIFT);
        let passes = self.watch.lasting_drifts < LASTING || self.now.increment < EARLY || self.step.has_drift_limit();
        if passes || self.is_noise() { Ok(()) } else { Err(self.drift_halt(drift)) }
    }

    /// Checks the energy of contact, which is a term of ETOTAL, so that its drift does not show it. The first increments
    /// are excluded as for the drift; the end of a short analysis is not.
    fn check_contact(&mut self) -> Result<(), HaltReason> {
        let is_met = self.balance.absorbed_by_contact() < -LARGEST_CREATED * self.balance.put_in();
        let [_, count] = &mut self.watch.contact_below_zero;
        *count = if is_met { *count + 1 } else { 0 };
        let passes = *count < LASTING || self.now.increment < EARLY || self.step.has_drift_limit();
        if passes || self.is_noise() { Ok(()) } else { Err(self.contact_halt()) }
    }

    /// Checks each term of the energy. Terms with opposite errors close ETOTAL, but none exceeds the energy put in. A limit
    /// of the deck on the drift that is larger is the limit of the terms as well. The first increments are excluded as for
    /// the drift.
    fn check_terms(&mut self) -> Result<(), HaltReason> {
        let limit = self.step.energy_limit.and_then(|l| l.error).map_or(LARGEST_EXCESS, |e| e.max(LARGEST_EXCESS));
        let terms = self.balance.terms();
        let excess = terms.largest_excess();
        let is_met = self.balance.has_solid() && excess > 0.0 && excess > limit * terms.put_in;
        self.watch.lasting_excess = if is_met { self.watch.lasting_excess + 1 } else { 0 };
        let passes = self.watch.lasting_excess < LASTING || self.now.increment < EARLY;
        if passes || self.is_noise() { Ok(()) } else { Err(self.excess_halt()) }
    }

    /// Checks the drift, the energy of contact and the terms of the energy at the end of an analysis that was too short for
    /// the limits, so that its results are not used.
    /// In a very short analysis one increment above the limit is sufficient.
    ///
    /// # Errors
    /// If energy is not conserved.
    pub(super) fn check_final_drift(&self) -> Result<(), HaltReason> {
        let is_early = self.now.increment < EARLY;
        let drift = self.balance.drift();
        let is_met = drift > LARGEST_DRIFT && self.watch.drift_count > u64::from(self.now.increment > LASTING);
        let own = self.plan.steps.iter().any(StepPlan::has_drift_limit);
        if is_early && self.watch.lasting_excess >= LASTING && !self.is_noise() {
            return Err(self.excess_halt());
        }
        if !is_early || own || self.is_noise() {
            Ok(())
        } else if self.watch.contact_below_zero[1] >= LASTING {
            Err(self.contact_halt())
        } else if is_met {
            Err(self.drift_halt(drift))
        } else {
            Ok(())
        }
    }

    fn contact_halt(&self) -> HaltReason {
        HaltReason::EnergyLimit(HaltDetails::new(self.name_created_energy()))
    }

    fn excess_halt(&self) -> HaltReason {
        let reason = format!("{}. *ENERGY LIMIT, ERROR=limit in the step raises this limit", self.name_excess());
        HaltReason::EnergyLimit(HaltDetails::new(reason))
    }

    fn drift_halt(&self, drift: f64) -> HaltReason {
        let reason = format!(
            "ETOTAL has drifted by {:.1} % of the energy put in, more than {:.0} %, at increment {}, time {:e}{}: energy is \
             not conserved{}. {}. *ENERGY LIMIT, ERROR=limit in the step changes this limit",
            100.0 * drift,
            100.0 * LARGEST_DRIFT,
            self.now.increment,
            self.now.total_time,
            self.drifts_since(),
            self.name_folded(),
            self.likely_cause()
        );
        HaltReason::EnergyLimit(HaltDetails::new(reason))
    }

    /// Checks that the step can be completed with the increments of the elements.
    ///
    /// # Errors
    /// If an element has collapsed so far that it cannot.
    #[inline(always)]
    pub(super) fn guard_increment(&self) -> Result<(), HaltReason> {
        if !self.state.elements.is_empty() && self.state.elements.stable_increment() < FLOOR * self.step.duration {
            return Err(self.too_many_increments());
        }
        Ok(())
    }

    #[cold]
    fn too_many_increments(&self) -> HaltReason {
        let (stable, (group, element)) = (self.state.elements.stable_increment(), self.state.elements.limiting());
        let name = self.plan.element_name(group, element);
        let reason = format!(
            "element {name} has collapsed: at increment {}, time {:e} its stable time increment is {stable:e}; the step \
             would need more than 1e10 increments",
            self.now.increment, self.now.total_time
        );
        HaltReason::ElementCollapsed(HaltDetails::new(reason)).at_element(name)
    }
}

#[cfg(test)]
mod tests {
    use super::first_exceeded;

    #[test]
    fn limits_are_reported_once() {
        let limits = [Some(0.1), Some(0.05)];
        assert_eq!(first_exceeded([0.1, 0.05], limits, [false; 2]), None);
        assert_eq!(first_exceeded([0.2, 0.06], limits, [false; 2]), Some((0, 0.2, 0.1)));
        assert_eq!(first_exceeded([0.2, 0.06], limits, [true, false]), Some((1, 0.06, 0.05)));
        assert_eq!(first_exceeded([0.2, 0.06], limits, [true; 2]), None);
        assert_eq!(first_exceeded([0.2, 0.06], [None, None], [false; 2]), None);
    }
}
