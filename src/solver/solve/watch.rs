//! Monitors that issue warnings: energies out of bounds or negative, growing hourglass patterns, very small increments.
//! Warnings state when it began, where it is, and a remedy. Checks that halt a run are in `guard.rs`.

use super::collapse::{CollapseMonitor, name_remedies};
use super::contact_losses::name_absorbed_energy;
use super::energy::{ADVECTION, ARTIFICIAL, Energy, EnergyBalance, INTERNAL, KINETIC, STRAIN, TERMS};
use super::masses::warning_of_added_mass;
use super::missing_action::largest_utilization;
use super::outcome::Outcome;
use super::ranges::RangeMonitor;
use super::run_state::RunState;
use super::volumes::warn_of_volumes;
use crate::constraint::contact::{ContactConstraint, ContactPair};
use crate::kernel::lanes::InlineMap;
use crate::model::IncrementControl;
use crate::plan::Plan;
use crate::state::Instant;
use crate::state::archive::Persist;
use crate::state::halt::HaltReason;

/// Fraction of the energy put in below which internal energy is too small to be compared with artificial energy.
pub(super) const SMALL: f64 = 0.01;

/// Bounds for warnings at the end of a run: drift of ETOTAL over the energy put in, and ALLAE over ALLIE. Above the
/// second, a common rule of practice, hourglass control influences the results.
const SOUND: [f64; 2] = [0.01, 0.05];

/// Bound of the drift of ETOTAL if error control chooses the increments, in units of `accuracy`.
const DRIFT_OVER_ACCURACY: f64 = 10.0;

/// Fractions of the energy put in for warnings of dissipation at the end of a run: bulk viscosity; friction and contact
/// of surfaces that flutter. Sliding without flutter loses no energy in contact.
const DISSIPATED: f64 = 0.05;
const FLUTTERS: [f64; 2] = [0.1, 0.02];
/// Fractions of the energy put in for a warning of the energy that contact absorbs, without and with deleted elements.
const ABSORBED: [f64; 2] = [0.05, 0.1];

/// Size of a negative energy, as a fraction of the energy put in, above which it is counted where the sign is strict: of
/// kinetic energy, and of the energies of materials that release no heat.
const BELOW_ZERO: f64 = 0.01;
/// Amount of a term below zero or above the energy put in, as a fraction of the latter, above which it is counted for all
/// materials.
const EXCESS: f64 = 0.1;

/// Remedy for energies with a wrong sign or size.
const COMPARE: &str = "compare with SCALE FACTOR=0.5 on *DYNAMIC or a finer mesh";

/// Number of increments with an excess before the warning, because a sudden release causes a few.
const SEEN: u64 = 10;

/// Explanations for kinetic and for internal energy below zero.
const REVERSES: &str = "nodal velocities change sign within an increment, which is close to or above the stable time increment; \
                        compare with SCALE FACTOR=0.5 on *DYNAMIC";
const RELEASES: &str = "elements have released more energy than was put in. Hypoelastic material laws do so on large closed \
                        strain paths, *HYPERELASTIC does not; compare with SCALE FACTOR=0.5 on *DYNAMIC or a finer mesh to \
                        exclude other causes";

/// Number of remaining increments above which a step is slow: hours on any machine, except for a few elements.
const CRAWL: f64 = 1e8;
/// Ratio of the number of increments to that expected at the start of the step above which a step is slow, and the number
/// of remaining increments below which this costs too little for a warning.
const SLOWER: f64 = 10.0;
const WORTH_A_WARNING: f64 = 1e5;

/// Increments between expensive checks: few at first, then many. The number is odd so that checks do not coincide with
/// timed increments, which would overestimate their cost.
const LOOK_EVERY: [u64; 2] = [17, 511];

/// Fraction of the kinetic energy within elements that an hourglass pattern must have for a warning.
const PATTERN: f64 = 0.75;
/// Growth of the pattern's kinetic energy since the last check that is needed for a warning.
const GROWTH: f64 = 4.0;
/// Fraction of the energy put in that the hourglass pattern must have before it is reported.
const WORTH: f64 = 0.01;

/// History of the monitored values.
#[derive(Clone, Debug, Default, Persist)]
#[persist(derived: shown, drift_bound, term_excess)]
pub(super) struct RunMonitor {
    /// Bound for the warning of the drift of ETOTAL in this step, relative to the energy put in.
    pub(super) drift_bound: f64,
    /// Total times since which the drift of ETOTAL and ALLAE have been out of bounds.
    unsound: [Option<f64>; 2],
    /// Drift of ETOTAL, relative to the energy put in, at the last check.
    pub(super) drift: f64,
    /// Number of increments, up to the current one, whose drift of ETOTAL is large enough to halt the run and does not
    /// decrease.
    pub(super) lasting_drifts: u64,
    /// Number of all increments with such a drift.
    pub(super) drift_count: u64,
    /// Amounts of the terms of the energy below zero, and above the energy put in.
    excess: [[ExcessRecord; 2]; TERMS.len()],
    /// Largest excess of all terms in this increment.
    pub(super) term_excess: f64,
    /// Number of increments, up to the current one, with an excess that halts.
    pub(super) lasting_excess: u64,
    /// Largest values so far of the energies dissipated in deformable bodies, and their largest decreases.
    dissipated: [f64; 3],
    decreases: [f64; 3],
    /// Increments with a negative energy of contact, up to the warning, and successive ones with an energy that halts.
    pub(super) contact_below_zero: [u64; 2],
    /// Whether warnings of a pattern and of small increments have been issued.
    pattern_reported: bool,
    slow_reported: bool,
    /// Whether a section, and a corner, that has turned over has been reported.
    pub(super) sections_reported: bool,
    pub(super) corners_reported: bool,
    /// Whether the last check found a corner that has turned over.
    pub(super) corners_turned: bool,
    /// Whether the last check found increments too small.
    slow: bool,
    /// Number of increments of the step with the increment of its first check; 0 before it.
    expected: f64,
    /// Kinetic energy of the pattern at the last check.
    pattern: f64,
    next_look: u64,
    /// Stable time increments of the elements.
    pub(super) collapse: CollapseMonitor,
    /// Limits of the deck on energies that have been reported in this step.
    pub(super) limits_reported: [bool; 2],
    /// Largest von Mises stress so far, relative to the initial yield stress of the material.
    pub(super) utilization: f64,
    /// Shares of materials beyond the range of their constants.
    ranges: RangeMonitor,
    /// Number of warnings that the sink has received.
    pub(super) shown: usize,
}

/// Increments in which a term of the energy exceeds a bound.
#[derive(Clone, Copy, Debug, Default, Persist)]
struct ExcessRecord {
    /// Number of increments.
    count: u64,
    /// The largest excess; value of the term, increment and total time there.
    largest: f64,
    value: f64,
    increment: u64,
    total_time: f64,
}

impl ExcessRecord {
    fn record(&mut self, excess: f64, value: f64, now: &Instant) {
        self.count += 1;
        if excess > self.largest {
            let count = self.count;
            let (increment, total_time) = (now.increment, now.total_time);
            *self = ExcessRecord { count, largest: excess, value, increment, total_time };
        }
    }
}

impl RunMonitor {
    /// Allows the warning of small increments once in each step.
    pub(super) fn begin_step(&mut self) {
        (self.slow_reported, self.slow, self.expected) = (false, false, 0.0);
    }

    /// Sets the bound for the warning of drift: error control keeps the drift below `accuracy`.
    pub(super) fn begin_drift_bound(&mut self, run: &RunState<'_>) {
        self.ranges.prepare(run);
        self.drift_bound = match run.step.control {
            IncrementControl::Automatic { accuracy, .. } if run.state.dofs.nodes.is_empty() => {
                SOUND[0].min(DRIFT_OVER_ACCURACY * accuracy)
            }
            _ => SOUND[0],
        };
    }

    /// Returns since when the drift has been out of bounds.
    pub(super) fn drifts_since(&self) -> String {
        self.unsound[0]
            .map_or_else(String::new, |since| format!(", above {} % since time {since:e}", 100.0 * self.drift_bound))
    }

    /// Returns whether no further check is needed.
    #[inline(always)]
    pub(super) fn needs_no_check(&mut self, balance: &EnergyBalance, now: &Instant) -> bool {
        let drifts = balance.drifts(self.drift_bound);
        note_since(&mut self.unsound[0], drifts, now);
        let below = balance.has_solid() && self.compare_solid(balance, now);
        !drifts && !below && now.increment < self.next_look.min(self.ranges.next)
    }

    /// Compares the energies of deformable bodies with their values so far and with the energy put in. Returns whether one
    /// is below zero or larger.
    #[inline(never)]
    fn compare_solid(&mut self, balance: &EnergyBalance, now: &Instant) -> bool {
        note_since(&mut self.unsound[1], balance.is_artificial(SOUND[1], SMALL), now);
        let dissipated = self.dissipated.iter_mut().zip(&mut self.decreases);
        for ((highest, decrease), now) in dissipated.zip(balance.dissipated_in_solid()) {
            *highest = highest.max(now);
            *decrease = decrease.max(*highest - now);
        }
        self.term_excess = balance.terms().largest_excess();
        let excess = self.term_excess.max(-balance.absorbed_by_contact());
        let exceeds = excess > BELOW_ZERO * balance.put_in();
        if !exceeds {
            self.lasting_excess = 0;
        }
        exceeds
    }
}

/// Records the total time since which a value has been out of bounds.
#[inline]
fn note_since(since: &mut Option<f64>, is_out: bool, now: &Instant) {
    if is_out != since.is_some() {
        *since = is_out.then_some(now.total_time);
    }
}

/// Warnings and results of a run, and the monitors that find them.
#[derive(Default, Persist)]
pub(super) struct RunReport {
    pub(super) watch: RunMonitor,
    pub(super) outcome: Outcome,
}

impl RunReport {
    /// Makes the checks that are due.
    pub(super) fn watch(&mut self, run: &mut RunState<'_>) {
        self.watch_terms(run);
        self.watch_contact(run);
        self.watch.ranges.sample(run, false);
        if run.now.increment >= self.watch.next_look {
            self.watch.next_look = run.now.increment + run.now.increment.clamp(LOOK_EVERY[0], LOOK_EVERY[1]);
            self.watch_pattern(run);
            self.warn_of_sections(run, false);
            run.masses.record_kinetic(run.balance.kinetic_of_solid(), &run.state);
            self.watch_pace(run);
            self.watch.utilization = largest_utilization(run, self.watch.utilization);
            if let Some(warning) = self.watch.collapse.check(run) {
                self.outcome.warn("R307", warning);
            }
        }
    }

    /// Records negative energies, which central differences give for ALLKE if velocities change sign between half steps,
    /// and terms above the energy put in.
    fn watch_terms(&mut self, run: &RunState<'_>) {
        let terms = run.balance.terms();
        for (term, value) in terms.values.into_iter().enumerate() {
            for ((which, bound), excess) in bounds(run.plan, term).into_iter().enumerate().zip(terms.excess(term)) {
                if excess > bound * terms.put_in && excess > 0.0 && !run.is_noise() {
                    self.watch.excess[term][which].record(excess, value, &run.now);
                }
            }
        }
    }

    /// Warns of terms below zero or above the energy put in, by amounts that are not small in comparison with the energy
    /// put in over the whole run: at the first touch of bodies all energies are small.
    fn warn_of_excess(&mut self, run: &RunState<'_>) {
        let (put_in, released) = (run.balance.put_in(), run.balance.terms().released);
        for (term, name) in TERMS.into_iter().enumerate() {
            for (which, bound) in bounds(run.plan, term).into_iter().enumerate() {
                let record = self.watch.excess[term][which];
                if record.count < SEEN || record.largest <= bound * put_in {
                    continue;
                }
                let below = which == 0;
                let bounded = match (term, below) {
                    (INTERNAL | STRAIN, true) if released > 0.0 => " below the energy that elements can have released",
                    (_, true) => " below zero",
                    (ADVECTION, false) => "",
                    _ => " above it",
                };
                let why = match (term, below) {
                    (KINETIC, true) => REVERSES.to_owned(),
                    (INTERNAL, true) if bound < EXCESS => RELEASES.to_owned(),
                    _ => cause_of_excess(run),
                };
                self.outcome.warn(
                    "R303",
                    format!(
                        "{name} is {:.3e}, {:.1} % of the energy put in ({put_in:.3e}){bounded}, at increment {}, time {:e}: {why}{}",
                        record.value,
                        100.0 * record.largest / put_in,
                        record.increment,
                        record.total_time,
                        name_folded(run)
                    ),
                );
            }
        }
    }

    /// Returns the term with the largest excess at this instant, for a halt.
    pub(super) fn name_excess(&self, run: &RunState<'_>) -> String {
        let terms = run.balance.terms();
        let largest = |term: &usize| terms.excess(*term).into_iter().fold(0.0, f64::max);
        let term = (0..TERMS.len()).max_by(|a, b| largest(a).total_cmp(&largest(b))).unwrap_or_default();
        let ratio = terms.values[term].abs() / terms.put_in;
        let amount = if terms.put_in > 0.0 {
            format!("{ratio:.1} times the energy put in ({:.3e})", terms.put_in)
        } else {
            "and no energy was put in".to_owned()
        };
        format!(
            "{} is {:.3e}, {amount}, at increment {}, time {:e}: energy was created (drift of ETOTAL {:.1} %); {}{}",
            TERMS[term],
            terms.values[term],
            run.now.increment,
            run.now.total_time,
            100.0 * run.balance.drift_now(),
            cause_of_excess(run),
            name_folded(run)
        )
    }

    /// Warns of dissipated energies that have decreased, and of energies that are negative at the end. ALLPD may decrease
    /// with kinematic hardening.
    fn warn_of_terms(&mut self, run: &RunState<'_>) {
        let (energy, put_in) = (run.balance.energy(), run.balance.put_in());
        if run.is_noise() {
            return;
        }
        for (name, decrease) in ["ALLVD", "ALLFD", "ALLCAV"].into_iter().zip(self.watch.decreases) {
            if decrease > BELOW_ZERO * put_in {
                self.outcome.warn(
                    "R303",
                    format!(
                        "{name} of deformable bodies has decreased by {decrease:.3e}, {:.1} % of the energy put in: dissipated \
                         energy cannot decrease; {COMPARE}",
                        100.0 * decrease / put_in
                    ),
                );
            }
        }
        // A material with an equation of state pays for its hourglass control, and may release energy by it.
        let artificial = if run.plan.has_equation_of_state { 0.0 } else { energy.artificial };
        let lost = energy.damage.unwrap_or(0.0);
        for (name, now) in
            [("ALLPD", energy.plastic), ("ALLDMD", lost), ("ALLAE", artificial), ("ALLDC", energy.distortion)]
        {
            if now < -BELOW_ZERO * put_in {
                self.outcome.warn(
                    "R303",
                    format!(
                        "{name} is {now:.3e}, negative by {:.1} % of the energy put in; {COMPARE}",
                        -100.0 * now / put_in
                    ),
                );
            }
        }
    }

    /// Checks for energy that contact has created.
    fn watch_contact(&mut self, run: &RunState<'_>) {
        let [count, _] = &mut self.watch.contact_below_zero;
        if *count > SEEN || run.balance.absorbed_by_contact() >= -BELOW_ZERO * run.balance.put_in() {
            return;
        }
        *count += 1;
        if *count < SEEN || run.is_noise() {
            return;
        }
        self.watch.contact_below_zero[0] = SEEN + 1;
        let warning = name_created_energy(run);
        self.outcome.warn("R304", warning);
    }

    /// Checks for growing hourglass patterns.
    fn watch_pattern(&mut self, run: &RunState<'_>) {
        if self.watch.pattern_reported || run.state.elements.is_empty() {
            return;
        }
        let now = run.state.elements.hourglass_motion(&run.state.dofs.nodes);
        let previous_kinetic = std::mem::replace(&mut self.watch.pattern, now.kinetic);
        let counts = now.kinetic > WORTH * run.balance.put_in() && !run.is_noise();
        let grows = previous_kinetic > 0.0 && now.kinetic >= GROWTH * previous_kinetic;
        if !counts || !grows || now.kinetic < PATTERN * now.relative {
            return;
        }
        self.watch.pattern_reported = true;
        let (group, element) = now.most;
        self.outcome.warn("R305", format!(
            "an hourglass pattern grows at increment {}, time {:e}: it has {:.0} % of the kinetic energy within elements, most in \
             element {}; use HOURGLASS=ENHANCED or a larger factor on *SECTION CONTROLS",
            run.now.increment,
            run.now.total_time,
            100.0 * (now.kinetic / now.relative).min(1.0),
            run.plan.element_name(group, element)
        ));
    }

    /// Checks for very small increments; warns at the second successive check that finds them.
    fn watch_pace(&mut self, run: &RunState<'_>) {
        let remaining = run.step.duration - run.now.step_time;
        if run.last_increment <= 0.0 {
            return;
        }
        let increments_left = remaining / run.last_increment;
        if self.watch.expected == 0.0 {
            self.watch.expected = run.step.duration / run.last_increment;
        }
        let expected = self.watch.expected;
        let slow = increments_left > CRAWL || increments_left > WORTH_A_WARNING && increments_left > SLOWER * expected;
        let must_warn = std::mem::replace(&mut self.watch.slow, slow) && slow && !self.watch.slow_reported;
        if !must_warn {
            return;
        }
        self.watch.slow_reported = true;
        let limiter = match run.step.control {
            IncrementControl::Fixed(_) => "; it is fixed by DIRECT USER CONTROL".into(),
            IncrementControl::Automatic { .. } => {
                run.state.elements.limiting().map_or_else(String::new, |e| name_slowest(run, e))
            }
        };
        self.outcome.warn("R306", format!(
            "the run advances slowly: at increment {}, time {:e} the increment is {:.3e}, and {increments_left:.1e} increments remain in the \
             step; at its start {expected:.1e} were expected{limiter}",
            run.now.increment,
            run.now.total_time,
            run.last_increment
        ));
    }

    /// Warns of energies out of bounds at the end of the run: since when, and where the mesh is distorted most.
    pub(super) fn warn_of_energy(&mut self, run: &mut RunState<'_>) {
        self.warn_of_excess(run);
        self.warn_of_terms(run);
        if let Some(warning) = warning_of_added_mass(run) {
            self.outcome.warn("R316", warning);
        }
        self.warn_of_missing_action(run);
        self.watch.ranges.finish(run, &mut self.outcome);
        warn_of_volumes(run.plan, &mut run.state, &mut self.outcome);
        let values = [run.balance.drift(), run.balance.artificial_share(SMALL)];
        let of_deck = run.step.energy_limit.map_or([false; 2], |l| [l.error.is_some(), l.artificial.is_some()]);
        // A halt for one of these reasons has reported it.
        let halted = self.outcome.halt.as_ref().is_some_and(|h| matches!(h, HaltReason::EnergyLimit(_)));
        let reported = |i: usize| of_deck[i] || self.watch.limits_reported[i] || halted;
        let [drift, artificial] = [0, 1].inline_map(|i| self.watch.unsound[i].filter(|_| !reported(i)));
        if drift.is_some() && !run.is_noise() {
            self.outcome.warn("R301", format!(
                "ETOTAL has drifted by {:.2} % of the energy put in, more than {} %{}: energy is not conserved{}. {}",
                100.0 * values[0],
                100.0 * self.watch.drift_bound,
                self.watch.drifts_since(),
                name_folded(run),
                likely_cause(run)
            ));
        }
        if let Some(since) = artificial {
            self.outcome.warn(
                "R302",
                format!(
                    "ALLAE is {:.1} % of ALLIE, more than {} % since time {since:e}: hourglass control influences the \
                 results; compare with a finer mesh or another HOURGLASS option of *SECTION CONTROLS{}",
                    100.0 * values[1],
                    100.0 * SOUND[1],
                    name_folded(run)
                ),
            );
        }
        self.warn_of_dissipation(run);
    }

    /// Warns of bulk viscosity that changes the results, and of friction that flutters.
    fn warn_of_dissipation(&mut self, run: &RunState<'_>) {
        let (energy, put_in) = (run.balance.energy(), run.balance.put_in());
        let [viscous, friction, contact] =
            [energy.viscous, energy.friction, energy.contact].inline_map(|part| part / put_in);
        if run.is_noise() {
            return;
        }
        if viscous > DISSIPATED && !run.plan.expects_dissipation {
            self.outcome.warn("R308", format!(
                "bulk viscosity has dissipated {:.1} % of the energy put in (ALLVD), more than {} %: the mesh may not resolve \
                 the waves. Compare with a finer mesh, or with smaller coefficients on *BULK VISCOSITY",
                100.0 * viscous,
                100.0 * DISSIPATED
            ));
        }
        if friction > FLUTTERS[0] && contact > FLUTTERS[1] {
            self.outcome.warn("R310", format!(
                "contact has absorbed {:.1} % of the energy put in (ALLCW) while friction has dissipated {:.1} % (ALLFD): surfaces \
                 that slide also separate and collide. If this is not the impact of the bodies, friction causes flutter, and the \
                 mean friction force is too small. Use *DAMPING, ALPHA, a larger SLIP DAMPING on *FRICTION, or elements that \
                 are larger along the surface",
                100.0 * contact,
                100.0 * friction
            ));
        } else if contact > ABSORBED[usize::from(run.state.elements.deletions.count() > 0)] {
            self.outcome.warn("R309", name_absorbed_energy(run, contact));
        }
    }
}

/// Returns the fractions of the energy put in by which a term may be below zero, and above it.
fn bounds(plan: &Plan, term: usize) -> [f64; 2] {
    let releases_heat = plan.has_equation_of_state || plan.has_user_stress;
    let is_strict = term == KINETIC || (term == INTERNAL || term == STRAIN) && !releases_heat;
    // A material with an equation of state pays for its hourglass control, and may release energy by it.
    let lowest = match term {
        ARTIFICIAL if plan.has_equation_of_state => f64::INFINITY,
        _ if is_strict => BELOW_ZERO,
        _ => EXCESS,
    };
    [lowest, EXCESS]
}

/// Returns the most likely cause of energy that was not put in, and a remedy.
fn cause_of_excess(run: &RunState<'_>) -> String {
    if let Some([_, ratio]) = run.beyond_stability() {
        format!(
            "the increments of DIRECT USER CONTROL are {ratio:.2} times the stable time increment: use smaller or automatic \
             increments"
        )
    } else if run.plan.has_user_stress {
        "check the user material: the stress of a closed strain path does no work, and enerInelasNew is the plastic work".into()
    } else if !run.state.adaptive.is_empty() || run.plan.remesh.is_some() {
        "compare with a run without *ADAPTIVE MESH and *REMESH".into()
    } else {
        COMPARE.into()
    }
}

/// Returns how much energy contact has created, the pair, and the place of the largest release.
pub(super) fn name_created_energy(run: &RunState<'_>) -> String {
    let energy = run.balance.absorbed_by_contact();
    let pairs = run.contacts().filter_map(ContactConstraint::lowest_energy);
    let lowest = pairs.min_by(|a, b| a.absorbed.total_cmp(&b.absorbed));
    let position = lowest.map_or_else(String::new, |ContactPair { name, largest_release: (_, [r, z]), .. }| {
        format!(", most in pair {name}, with the largest release near (r = {r:.4e}, z = {z:.4e})")
    });
    format!(
        "contact has created energy: ALLCW + ALLPW is {energy:.3e}, {:.1} % of the energy put in below zero, at increment {}, \
         time {:e}{position}. Use smaller facets there, SCALE FACTOR=0.5 on *DYNAMIC, or hard contact instead of a \
         pressure-overclosure relationship",
        -100.0 * energy / run.balance.put_in(),
        run.now.increment,
        run.now.total_time
    )
}

fn name_slowest(run: &RunState<'_>, (group, element): (usize, usize)) -> String {
    format!("; it is limited by element {}. {}", run.plan.element_name(group, element), name_remedies(run, group, None))
}

pub(super) fn name_folded(run: &RunState<'_>) -> String {
    let Some(folded) = run.state.elements.most_folded(&run.state.dofs.nodes) else { return String::new() };
    let name = run.plan.element_name(folded.group, folded.element);
    format!(". The largest hourglass distortion is in element {name}: {:.0} % of its size", 100.0 * folded.fold)
}

/// Returns the most likely cause of a drift, and a remedy.
pub(super) fn likely_cause(run: &RunState<'_>) -> String {
    if let (true, IncrementControl::Automatic { accuracy, .. }) = (run.state.elements.is_empty(), run.step.control) {
        return format!(
            "Compare with ACCURACY={:e} on *DYNAMIC: a load that changes within an increment is resolved by smaller \
             increments",
            0.1 * accuracy
        );
    }
    let departure = run.balance.drift() * run.balance.put_in();
    cause(&run.balance.energy(), departure, run.beyond_stability().map(|[_, ratio]| ratio))
}

/// Returns the likely cause of a drift of ETOTAL; `beyond` is the ratio of fixed increments to the stable time
/// increment.
fn cause(energy: &Energy, departure: f64, beyond: Option<f64>) -> String {
    let part = 0.5 * departure;
    if let Some(beyond) = beyond {
        return format!(
            "The increments of DIRECT USER CONTROL are {beyond:.2} times the stable time increment: use smaller or automatic increments"
        );
    }
    if energy.distortion.abs() > part {
        return "A likely cause is distortion control, whose work is of the same size: compare with DISTORTION CONTROL=NO on \
                *SECTION CONTROLS, or with *EROSION of crushed elements"
            .into();
    }
    if energy.internal < -part {
        return "A likely cause is that elements have released more energy than was put in: delete failed material with \
                *TENSILE FAILURE or *EROSION"
            .into();
    }
    if energy.artificial.abs() > part {
        return "A likely cause is hourglass control, whose work is of the same size: use HOURGLASS=ENHANCED on *SECTION CONTROLS, or a finer mesh"
            .into();
    }
    "Compare with SCALE FACTOR=0.5 on *DYNAMIC: the increment may be too large for loads, contact or a stiffening material"
        .into()
}

#[cfg(test)]
mod tests {
    use super::{Energy, cause};

    #[test]
    fn each_cause_of_drift_names_a_keyword() {
        let energy = Energy::default();
        let named = |energy: Energy, beyond| cause(&energy, 1.0, beyond);
        assert!(named(energy, Some(2.0)).contains("2.00 times the stable time increment"));
        assert!(named(Energy { distortion: 0.6, ..energy }, None).contains("DISTORTION CONTROL"));
        assert!(named(Energy { internal: -0.6, ..energy }, None).contains("*TENSILE FAILURE"));
        assert!(named(Energy { artificial: -0.6, ..energy }, None).contains("HOURGLASS"));
        assert!(named(energy, None).contains("SCALE FACTOR"));
    }
}
