//! Checks that halt a run: energies that are not finite, energy limits of the deck (`*ENERGY LIMIT`) and of every run,
//! and increments too small to complete the step. Warnings are in `watch.rs`.

use super::collapse::name_folding_remedy;
use super::increment::shortened;
use super::mesh_quality::has_turned_corner;
use super::run_state::RunState;
use super::watch::{RunReport, SMALL, likely_cause, name_created_energy, name_folded};
use crate::constraint::overlaps::OverlapMonitor;
use crate::constraint::{Constraint, of_kind_mut};
use crate::element::elements::CollapsedElement;
use crate::kernel::lanes::InlineMap;
use crate::kernel::quad;
use crate::kernel::shape::middle;
use crate::kernel::topology::ElementTopology;
use crate::load::Load;
use crate::load::stiffness::LoadStiffness;
use crate::plan::StepPlan;
use crate::state::Instant;
use crate::state::halt::{HaltDetails, HaltReason};

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

/// Returns the index of the first value above its limit that has not been reported, and the limit.
fn first_exceeded(values: [f64; 2], limits: [Option<f64>; 2], reported: [bool; 2]) -> Option<(usize, f64)> {
    (0..2).filter(|&i| !reported[i]).find_map(|i| Some((i, limits[i].filter(|l| values[i] > *l)?)))
}

impl RunReport {
    /// Checks the energies after an increment.
    ///
    /// # Errors
    /// If they are not finite, or exceed a limit that halts.
    #[inline(always)]
    pub(super) fn guard_energy(&mut self, run: &mut RunState<'_>) -> Result<(), HaltReason> {
        let watched = self.watch.needs_no_check(&run.balance, &run.now);
        if watched && run.balance.is_finite() && run.step.energy_limit.is_none() {
            Ok(())
        } else {
            self.check_energy(run)
        }
    }

    /// Warns of stiff loads that end, if they reduced the increment or should have.
    pub(super) fn warn_of_stiff_loads(&mut self, run: &RunState<'_>, loads: &[Box<dyn Load>]) {
        let alone = run.state.elements.stable_increment();
        let fixed = run.step.is_fixed();
        for load in loads {
            let Some(LoadStiffness { squared, rate, point, place: [r, z], time }) = load.stiffness() else { continue };
            let ratio = shortened(*squared, alone);
            let consequence = if fixed {
                format!(
                    "a stable increment is {ratio:.1} times smaller than that of the elements, and the increments of the deck are fixed"
                )
            } else {
                format!("since then increments are {ratio:.1} times smaller than those of the elements")
            };
            let row = &run.plan.ledger.effects[load.effect()];
            self.outcome.warn("R312", format!(
                "{} ({}): the pressure increases by {rate:.3e} per unit of outward displacement at point {} (r = {r:.4e}, z = {z:.4e}). \
                 This stiffness is not part of the stable time increment of the elements, and an instability began at time \
                 {time:e}; {consequence}. SCALE FACTOR={:.2} on *DYNAMIC avoids the instability",
                row.effect,
                row.asked_by.join(", "),
                point + 1,
                (1.0 / ratio).min(1.0)
            ));
        }
    }

    /// Adds the warnings of constraints that end.
    pub(super) fn warn_of_constraints(&mut self, run: &RunState<'_>, constraints: &mut [Box<dyn Constraint>]) {
        for monitor in of_kind_mut::<OverlapMonitor>(constraints) {
            let overlaps = monitor.overlaps(&run.state.dofs, &run.clock());
            for text in overlaps {
                // "although they are tied", "although contact is defined between them"
                self.outcome.warn(if text.contains("although") { "R325" } else { "R311" }, text);
            }
        }
    }

    /// Adds the warnings of the effects in force at the end of the run.
    pub(super) fn warn_of_effects(&mut self, run: &mut RunState<'_>) {
        let (loads, mut constraints) =
            (std::mem::take(&mut run.state.loads), std::mem::take(&mut run.state.constraints));
        self.warn_of_stiff_loads(run, &loads);
        self.warn_of_constraints(run, &mut constraints);
        (run.state.loads, run.state.constraints) = (loads, constraints);
    }

    #[inline(never)]
    fn check_energy(&mut self, run: &mut RunState<'_>) -> Result<(), HaltReason> {
        if !run.balance.is_finite() {
            let reason = format!(
                "the energy of the model is not a finite number at increment {}, time {:e}",
                run.now.increment, run.now.total_time
            );
            return Err(HaltReason::NotFinite(HaltDetails::new(reason)));
        }
        self.check_energy_limits(run)?;
        self.check_drift(run)?;
        self.check_contact(run)?;
        self.check_terms(run)?;
        self.watch(run);
        Ok(())
    }

    /// Checks the limits that the deck gives.
    fn check_energy_limits(&mut self, run: &RunState<'_>) -> Result<(), HaltReason> {
        let Some(limit) = &run.step.energy_limit else { return Ok(()) };
        let values = [run.balance.drift(), run.balance.artificial_share(SMALL)];
        let exceeded = first_exceeded(values, [limit.error, limit.artificial], self.watch.limits_reported);
        let Some((which, allowed)) = exceeded else { return Ok(()) };
        let value = values[which];
        let what = ["energy drift", "artificial over internal energy"][which];
        let reason = format!(
            "{what} is {value:.2e}, above the limit {allowed:e}, at increment {}, time {:e}",
            run.now.increment, run.now.total_time
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
    fn check_drift(&mut self, run: &RunState<'_>) -> Result<(), HaltReason> {
        let drift = run.balance.drift_now();
        // While energy is supplied, the relative drift of the first increment under a sudden load decreases.
        let decreases = drift < std::mem::replace(&mut self.watch.drift, drift);
        let lasting = self.watch.lasting_drifts + u64::from(!decreases);
        self.watch.lasting_drifts = if drift > LARGEST_DRIFT { lasting } else { 0 };
        self.watch.drift_count += u64::from(drift > LARGEST_DRIFT);
        let passes = self.watch.lasting_drifts < LASTING || run.now.increment < EARLY || run.step.has_drift_limit();
        if passes || run.is_noise() { Ok(()) } else { Err(self.drift_halt(run, drift)) }
    }

    /// Checks the energy of contact, which is a term of ETOTAL, so that its drift does not show it. The first increments
    /// are excluded as for the drift; the end of a short analysis is not.
    fn check_contact(&mut self, run: &RunState<'_>) -> Result<(), HaltReason> {
        let is_met = run.balance.absorbed_by_contact() < -LARGEST_CREATED * run.balance.put_in();
        let [_, count] = &mut self.watch.contact_below_zero;
        *count = if is_met { *count + 1 } else { 0 };
        let passes = *count < LASTING || run.now.increment < EARLY || run.step.has_drift_limit();
        if passes || run.is_noise() { Ok(()) } else { Err(contact_halt(run)) }
    }

    /// Checks each term of the energy. Terms with opposite errors close ETOTAL, but none exceeds the energy put in. A limit
    /// of the deck on the drift that is larger is the limit of the terms as well. The first increments are excluded as for
    /// the drift.
    fn check_terms(&mut self, run: &RunState<'_>) -> Result<(), HaltReason> {
        let limit = run.step.energy_limit.and_then(|l| l.error).map_or(LARGEST_EXCESS, |e| e.max(LARGEST_EXCESS));
        let excess = self.watch.term_excess;
        let is_met = run.balance.has_solid() && excess > 0.0 && excess > limit * run.balance.supply.put_in();
        self.watch.lasting_excess = if is_met { self.watch.lasting_excess + 1 } else { 0 };
        let passes = self.watch.lasting_excess < LASTING || run.now.increment < EARLY;
        if passes || run.is_noise() { Ok(()) } else { Err(self.excess_halt(run)) }
    }

    /// Checks the drift, the energy of contact and the terms of the energy at the end of an analysis that was too short for
    /// the limits, so that its results are not used.
    /// In a very short analysis one increment above the limit is sufficient.
    ///
    /// # Errors
    /// If energy is not conserved.
    pub(super) fn check_final_drift(&self, run: &RunState<'_>) -> Result<(), HaltReason> {
        let is_early = run.now.increment < EARLY;
        let drift = run.balance.drift();
        let is_met = drift > LARGEST_DRIFT && self.watch.drift_count > u64::from(run.now.increment > LASTING);
        let is_limited_by_deck = run.plan.steps.iter().any(StepPlan::has_drift_limit);
        if is_early && self.watch.lasting_excess >= LASTING && !run.is_noise() {
            return Err(self.excess_halt(run));
        }
        if !is_early || is_limited_by_deck || run.is_noise() {
            Ok(())
        } else if self.watch.contact_below_zero[1] >= LASTING {
            Err(contact_halt(run))
        } else if is_met {
            Err(self.drift_halt(run, drift))
        } else {
            Ok(())
        }
    }

    /// Warns once of elements whose section has turned over or that have passed the axis, for which volumes can be positive, and
    /// once of corners that have turned over in two checks or at the end of the run: a new mesh may replace them before. Bodies
    /// whose elements may be deleted are excluded.
    pub(super) fn warn_of_sections(&mut self, run: &RunState<'_>, is_last: bool) {
        if self.watch.sections_reported {
            return;
        }
        let is_turned = |place| section_area(run, place).is_some_and(|area| area <= 0.0);
        if let Some(turned) = TurnedElements::find(run, is_turned) {
            self.watch.sections_reported = true;
            let meaning = "results there are wrong, although its volume is positive";
            self.warn_of_turned(run, &turned, ["R320", "the section", "has turned over", meaning]);
        } else if let Some(turned) = TurnedElements::find(run, |place| has_passed_axis(run, place)) {
            self.watch.sections_reported = true;
            self.warn_of_turned(run, &turned, ["R320", "a node", "has passed the axis", "results there are wrong"]);
        } else if !self.watch.corners_reported {
            self.warn_of_corners(run, is_last);
        }
    }

    fn warn_of_corners(&mut self, run: &RunState<'_>, is_last: bool) {
        let turned = TurnedElements::find(run, |(group, element)| {
            let group = &*run.state.elements.groups[group];
            group.topology() == ElementTopology::Quadrilateral && has_turned_corner(group, element, &run.state)
        });
        let was_turned = std::mem::replace(&mut self.watch.corners_turned, turned.is_some());
        if let Some(turned) = turned.filter(|_| was_turned || is_last) {
            self.watch.corners_reported = true;
            let meaning = "its shape is not convex, and results there are not reliable";
            self.warn_of_turned(run, &turned, ["R327", "a corner", "has turned over", meaning]);
        }
    }

    fn warn_of_turned(&mut self, run: &RunState<'_>, turned: &TurnedElements, words: [&'static str; 4]) {
        let ([code, part, event, meaning], (group, element)) = (words, turned.place);
        let nodes = run.state.elements.groups[group].nodes(element);
        let [r, z] = middle([0, 1, 2, 3].inline_map(|i: usize| run.state.dofs.nodes[nodes[i] as usize].place()));
        let text = format!(
            "at increment {}, time {:e} {part} of element {} near (r = {r:.4e}, z = {z:.4e}) {event}{}: {meaning}{}",
            run.now.increment,
            run.now.total_time,
            run.plan.element_name(group, element),
            if turned.others > 0 { format!(", and that of {} more", turned.others) } else { String::new() },
            name_folding_remedy(run, group)
        );
        self.outcome.warn(code, text);
    }

    /// Returns why an element has failed, and a remedy.
    #[cold]
    pub(super) fn collapsed(&self, run: &RunState<'_>, collapsed: CollapsedElement) -> HaltReason {
        let CollapsedElement { group, element, volume } = collapsed;
        if let Some(halt) = &run.state.elements.failure {
            return halt.clone();
        }
        let area = section_area(run, (group, element));
        let is_turned = volume <= 0.0 || area.is_some_and(|area| area <= 0.0);
        let why = match area {
            _ if volume <= 0.0 => "it is inverted".to_owned(),
            Some(area) if is_turned => format!("its section has turned over to an area of {area:.3e}"),
            _ => "its state is not finite".to_owned(),
        };
        let remedy = match run.beyond_stability() {
            Some([length, ratio]) => format!(
                "; the increment of DIRECT USER CONTROL, {length:e}, is {ratio:.2} times the stable time increment at the \
                 previous instant, {:.3e}: use a smaller one or automatic increments",
                run.previous_stable_increment
            ),
            None if is_turned || self.watch.collapse.is_reported() => name_folding_remedy(run, group),
            None => String::new(),
        };
        let name = run.plan.element_name(group, element);
        let reason = format!(
            "element {name} failed at increment {}, time {:e}: {why} (volume {volume:e}){remedy}",
            run.now.increment, run.now.total_time
        );
        HaltReason::ElementFailed(HaltDetails::new(reason)).at_element(name)
    }

    fn excess_halt(&self, run: &RunState<'_>) -> HaltReason {
        let reason = format!("{}. *ENERGY LIMIT, ERROR=limit in the step raises this limit", self.name_excess(run));
        HaltReason::EnergyLimit(HaltDetails::new(reason))
    }

    fn drift_halt(&self, run: &RunState<'_>, drift: f64) -> HaltReason {
        let reason = format!(
            "ETOTAL has drifted by {:.1} % of the energy put in, more than {:.0} %, at increment {}, time {:e}{}: energy is \
             not conserved{}. {}. *ENERGY LIMIT, ERROR=limit in the step changes this limit",
            100.0 * drift,
            100.0 * LARGEST_DRIFT,
            run.now.increment,
            run.now.total_time,
            self.watch.drifts_since(),
            name_folded(run),
            likely_cause(run)
        );
        HaltReason::EnergyLimit(HaltDetails::new(reason))
    }
}

/// Elements that have turned over: the group and index of the first one, and the number of others.
struct TurnedElements {
    place: (usize, usize),
    others: usize,
}

impl TurnedElements {
    /// Finds the elements of bodies without deletion that meet a condition; `None` without any.
    fn find(run: &RunState<'_>, is_turned: impl Fn((usize, usize)) -> bool) -> Option<TurnedElements> {
        let groups = run.state.elements.groups.iter().enumerate();
        let remaining = groups.filter(|(_, elements)| !elements.properties().deletable);
        let places = remaining.flat_map(|(group, elements)| (0..elements.len()).map(move |element| (group, element)));
        let mut turned = places.filter(|place| is_turned(*place));
        let place = turned.next()?;
        Some(TurnedElements { place, others: turned.count() })
    }
}

/// Depth beyond the axis of a node that has passed it, over the radial extent of its element.
const BEYOND_AXIS: f64 = 1e-6;

/// Returns whether a node of a quadrilateral or triangle has passed the axis.
fn has_passed_axis(run: &RunState<'_>, (group, element): (usize, usize)) -> bool {
    let group = &run.state.elements.groups[group];
    let radii = || group.nodes(element).into_iter().map(|n| run.state.dofs.nodes[n as usize].r);
    let [least, largest] = radii().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], r| [a.min(r), b.max(r)]);
    group.topology() == ElementTopology::Quadrilateral && least < -BEYOND_AXIS * (largest - least)
}

/// Returns the area of the section of an element; `None` if it does not have four corners.
fn section_area(run: &RunState<'_>, (group, element): (usize, usize)) -> Option<f64> {
    let group = &run.state.elements.groups[group];
    let has_corners = group.topology() == ElementTopology::Quadrilateral;
    let nodes = has_corners.then(|| group.nodes(element))?;
    let corners = [0, 1, 2, 3].inline_map(|i: usize| run.state.dofs.nodes[nodes[i] as usize].place());
    Some(quad::section(corners.inline_map(|p| p[0]), corners.inline_map(|p| p[1])))
}

fn contact_halt(run: &RunState<'_>) -> HaltReason {
    HaltReason::EnergyLimit(HaltDetails::new(name_created_energy(run)))
}

/// Checks that the step can be completed with the increments of the elements, springs and dashpots.
///
/// # Errors
/// If an element has collapsed so far that it cannot, or a spring or dashpot is too stiff.
#[inline(always)]
pub(super) fn guard_increment(run: &RunState<'_>) -> Result<(), HaltReason> {
    if !run.state.dofs.nodes.is_empty() && run.state.elements.stable_increment() < FLOOR * run.step.duration {
        return Err(too_many_increments(run));
    }
    Ok(())
}

#[cold]
fn too_many_increments(run: &RunState<'_>) -> HaltReason {
    let stable = run.state.elements.stable_increment();
    let Some((group, element)) = run.state.elements.limiting() else {
        let reason = format!(
            "the stable time increment of the springs and dashpots is {stable:e} at increment {}, time {:e}; the step would \
             need more than 1e10 increments. Reduce the stiffness or the coefficient, or increase the masses at the ends",
            run.now.increment, run.now.total_time
        );
        return HaltReason::IncrementTooSmall(HaltDetails::new(reason));
    };
    let name = run.plan.element_name(group, element);
    let reason = format!(
        "element {name} has collapsed: at increment {}, time {:e} its stable time increment is {stable:e}; the step \
         would need more than 1e10 increments",
        run.now.increment, run.now.total_time
    );
    HaltReason::ElementCollapsed(HaltDetails::new(reason)).at_element(name)
}

#[cold]
pub(super) fn not_finite(run: &RunState<'_>) -> HaltReason {
    let bodies = &run.state.dofs.bodies;
    let b = bodies.iter().position(|body| !body.acceleration.is_finite()).unwrap_or_default();
    let (name, time, body) = (&run.plan.bodies[b].name, run.now.total_time, &bodies[b]);
    let reason = format!(
        "the acceleration of rigid body `{name}` is {} at increment {}, time {time:e} ({}, mass {})",
        body.acceleration,
        run.now.increment,
        body.describe_force(),
        body.mass
    );
    HaltReason::NotFinite(HaltDetails::new(reason))
}

/// Adds instant and place to a halt that does not have them. The place of an element is its current centre.
#[cold]
pub(super) fn located(run: &RunState<'_>, mut halt: HaltReason, instant: Instant) -> HaltReason {
    let RunState { plan, state, .. } = run;
    let details = halt.details_mut();
    details.instant.get_or_insert(instant);
    if details.place.is_none()
        && let Some(name) = &details.element
        && let Some((_, (group, element))) =
            plan.places.elements.iter().find(|(e, _)| &*plan.mesh.elements[*e].name == name.as_str())
    {
        let corners = state.elements.groups[*group].boundary(*element);
        let places: Vec<[f64; 2]> = corners.iter().map(|n| state.dofs.nodes[*n as usize].place()).collect();
        let centre = [0, 1].inline_map(|axis: usize| places.iter().map(|p| p[axis]).sum::<f64>() / places.len() as f64);
        details.place = Some(centre);
    }
    halt
}

#[cfg(test)]
mod tests {
    use super::first_exceeded;

    #[test]
    fn limits_are_reported_once() {
        let limits = [Some(0.1), Some(0.05)];
        assert_eq!(first_exceeded([0.1, 0.05], limits, [false; 2]), None);
        assert_eq!(first_exceeded([0.2, 0.06], limits, [false; 2]), Some((0, 0.1)));
        assert_eq!(first_exceeded([0.2, 0.06], limits, [true, false]), Some((1, 0.05)));
        assert_eq!(first_exceeded([0.2, 0.06], limits, [true; 2]), None);
        assert_eq!(first_exceeded([0.2, 0.06], [None, None], [false; 2]), None);
    }
}
