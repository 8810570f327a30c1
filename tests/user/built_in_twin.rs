//! A user's material beside its built-in twin: what any material has, a user's has too.
//!
//! Goal: the law of `*PLASTIC` with linear hardening, written as a user's material, has the same bits on any number of
//! threads, and the increments, masses and hourglass control of the built-in law. Source: the built-in law. Each test says
//! its tolerance and why.

use std::sync::{Arc, Mutex};

use revolve::solve::Instant;
use revolve::user::{
    AnalysisMoment, LoadFailure, MaterialAnswer, MaterialCall, Routines, RunAction, UserEvents, UserMaterial,
};

use crate::common;
use crate::common::Memory;
use crate::common::solid::grid;

/// Bulk modulus, twice the shear modulus, yield stress and its slope.
struct Yielding;

impl UserMaterial for Yielding {
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure> {
        (0..call.count).for_each(|i| radial_return(call, answer, i));
        Ok(())
    }
}

/// Radial return (Simo and Hughes 1998, box 3.1); elastic at time zero.
fn radial_return(call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>, i: usize) {
    let [e, nu, yields, slope] = [0, 1, 2, 3].map(|k| call.properties[k]);
    let (bulk, shear2) = (e / (3.0 * (1.0 - 2.0 * nu)), e / (1.0 + nu));
    let of = |list: &[f64]| [0, 1, 2, 3].map(|k| list[k * call.count + i]);
    let (strain, old) = (of(call.strain), of(call.stress));
    let third = |t: [f64; 4]| (t[0] + t[1] + t[2]) / 3.0;
    let mean = third(old) + 3.0 * bulk * third(strain);
    let volumetric = |k: usize, value: f64| if k < 3 { value } else { 0.0 };
    let trial =
        [0, 1, 2, 3].map(|k| old[k] - volumetric(k, third(old)) + shear2 * (strain[k] - volumetric(k, third(strain))));
    let [a, b, c, d] = trial.map(|s| s * s);
    let mises = (1.5 * (a + b + c) + 3.0 * d).sqrt();
    let excess = mises - (yields + slope * call.state[i]);
    let flow = if call.now.total_time > 0.0 && excess > 0.0 { excess / (1.5 * shear2 + slope) } else { 0.0 };
    let factor = if flow > 0.0 { 1.0 - 1.5 * shear2 * flow / mises } else { 1.0 };
    for (k, trial) in trial.into_iter().enumerate() {
        answer.stress[k * call.count + i] = factor * trial + volumetric(k, mean);
    }
    answer.state[i] = call.state[i] + flow;
    answer.inelastic[i] = call.inelastic[i] + factor * mises * flow / call.density[i];
}

const BUILT_IN: &str = "*Elastic\n 117.e9, 0.35\n*Plastic\n 400.e6, 0.\n 900.e6, 5.\n";
const BY_USER: &str = "*User Material, constants=4\n 117.e9, 0.35, 400.e6, 100.e6\n*Depvar\n 1,\n";

/// A copper bar of so many elements along r and z against a wall, with rows at each increment. `section` goes behind the
/// section's card and its parameters, `cards` into the step.
fn bar([n, m]: [usize; 2], section: &str, material: &str, time: f64, cards: &str) -> String {
    let place = |i: usize, j: usize| [i as f64 * 3.2e-3 / n as f64, j as f64 * 12.8e-3 / m as f64];
    let strain = if material == BUILT_IN { "PEEQ" } else { "SDV1" };
    grid(n, m, false, place)
        + &format!(
            "*Solid Section, elset=SOLID, material=COPPER{section}\n*Material, name=COPPER\n*Density\n 8930.,\n{material}\
             *Initial Conditions, type=VELOCITY\n ALL, 2, -227.\n*Elset, elset=FOOT\n 1,\n*Step\n*Dynamic, Explicit\n \
             , {time:e}\n{cards}*Boundary\n I0, 1, 1\n J0, 2, 2\n*Output, history, frequency=1\n*Incrementation Output\n \
             DT\n*Energy Output\n ALLIE, ALLPD, ALLSE, ALLVD, ALLAE, ALLKE\n*Element Output, elset=FOOT\n S, LE, {strain}\n\
             *End Step\n"
        )
}

/// All values of a row by their names.
fn columns(text: &str, memory: &Memory, routines: &Routines, name: &str) -> Vec<f64> {
    let prepared = common::prepared(text, &[], routines);
    let at = prepared.plan.columns.iter().position(|c| c.name == name).expect("a column");
    memory.rows.iter().map(|row| row.1[at]).collect()
}

/// Runs a scene with the built-in law and with the user's: they must agree row for row, each variable within `tolerance` of
/// its largest value. Returns what the runs came to.
fn agree(deck: impl Fn(&str) -> String, tolerance: f64) -> [revolve::solve::Outcome; 2] {
    let routines = [Routines::none(), Routines::none().with_material(Yielding)];
    let decks = [BUILT_IN, BY_USER].map(deck);
    let [(expected, there), (got, here)] = [0, 1].map(|k| common::run(&decks[k], &[], &routines[k]));
    assert_eq!((&expected.halt, &got.halt), (&None, &None));
    assert_eq!(expected.increments, got.increments);
    let names = ["DT", "ALLIE", "ALLPD", "ALLSE", "ALLAE", "ALLKE", "S22@FOOT", "LE22@FOOT"];
    for (one, other) in names.map(|n| (n, n)).into_iter().chain([("PEEQ@FOOT", "SDV1@FOOT")]) {
        let a = columns(&decks[0], &there, &routines[0], one);
        let b = columns(&decks[1], &here, &routines[1], other);
        let largest = a.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let apart = a.iter().zip(&b).fold(0.0, |most: f64, (x, y)| most.max((x - y).abs()));
        println!("{one}: largest {largest:e}, apart by {:.1e} of it", apart / largest);
        assert!(a.len() == b.len() && largest > 0.0 && apart <= tolerance * largest, "{one}: {apart:e} of {largest:e}");
    }
    [expected, got]
}

/// Rounding of other sums, carried on over a few hundred increments: 1e-9.
#[test]
fn the_global_estimate_is_that_of_the_built_in_law() {
    let [expected, got] = agree(|material| bar([5, 20], "", material, 8e-6, ""), 1e-9);
    let estimates = expected.steps[0].global_estimates;
    assert!(estimates.is_some_and(|count| count > 0));
    assert_eq!(got.steps[0].global_estimates, estimates);
    let by_elements = bar([5, 20], "", BY_USER, 8e-6, "").replace("Explicit\n", "Explicit, element by element\n");
    let (local, _) = common::run(&by_elements, &[], &Routines::none().with_material(Yielding));
    assert!(local.steps[0].global_estimates.is_none() && got.increments < local.increments);
}

/// The moduli that the routine tells are those of the deck but for rounding, and masses follow their square: 1e-12. The
/// material's density stays what it is: the routine books the same plastic work.
#[test]
fn mass_scaling_adds_the_mass_that_it_adds_to_the_built_in_law() {
    for cards in [
        "*Fixed Mass Scaling, factor=4.\n",
        "*Fixed Mass Scaling, factor=2.\n*Variable Mass Scaling, type=below min, dt=5.e-8, frequency=10\n",
        "*Variable Mass Scaling, type=set equal dt, dt=6.e-8, number interval=5\n",
    ] {
        let [expected, got] = agree(|material| bar([5, 20], "", material, 8e-6, cards), 1e-9);
        let [a, b] = [&expected, &got].map(|o| o.steps[0].added_mass.expect("added mass"));
        println!("{cards} added {a:e}, apart by {:.1e}", b / a - 1.0);
        // Of the last time, on nodes that have moved by rounding apart where the mass is found again.
        let tolerance = if cards.contains("Variable") { 1e-11 } else { 1e-12 };
        assert!(a != 0.0 && (b / a - 1.0).abs() < tolerance, "{cards} {a:e} {b:e}");
    }
}

/// Of assumed strains those at the edges flow first, and where is known of a law that is built in alone: a routine's element
/// tells it once its middle has flowed. Until then its patterns are elastic, which is 2e-3 of their energy here.
#[test]
fn hourglass_control_follows_the_moduli() {
    let section = ", controls=C\n*Section Controls, name=C, hourglass=ENHANCED";
    agree(|material| bar([5, 20], section, material, 8e-6, ""), 5e-3);
}

/// 6250 elements, more than it takes to spread them over threads: rows and digest are those of one thread.
#[test]
fn the_number_of_threads_changes_no_bit() {
    let text = bar([50, 125], "", BY_USER, 0.3e-6, "");
    let bits = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let (outcome, memory) = common::run(&text, &[], &Routines::none().with_material(Yielding));
            assert!(outcome.halt.is_none() && outcome.increments > 10, "{outcome:?}");
            assert!(outcome.energy.plastic > 0.0 && outcome.energy.artificial != 0.0);
            let rows: Vec<u64> = memory.rows.iter().flat_map(|r| r.1.iter().map(|v| v.to_bits())).collect();
            (outcome.digest, rows)
        })
    };
    let one = bits(1);
    for threads in [2, 5] {
        assert!(one == bits(threads), "{threads} threads");
    }
}

/// What the routines of a job are told, in order.
#[derive(Clone, Default)]
struct Told(Arc<Mutex<Vec<String>>>);

impl Told {
    fn note(&self, what: String) {
        self.0.lock().expect("a list").push(what);
    }
}

impl UserEvents for Told {
    fn moment(&mut self, moment: AnalysisMoment, now: &Instant, _increment: f64) -> Result<RunAction, LoadFailure> {
        self.note(format!("{moment:?} of step {}", now.step));
        Ok(RunAction::Continue)
    }
}

impl UserMaterial for Told {
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure> {
        let when = if call.now.total_time == 0.0 { "time zero" } else { "later" };
        self.note(format!("{} points at {when}", call.count));
        Yielding.stress(call, answer)
    }
}

/// The analysis begins for the routine of events, then the material is asked for its moduli, block by block and once.
#[test]
fn the_moduli_are_asked_for_when_the_analysis_begins() {
    let told = Told::default();
    let routines = Routines::none().with_material(told.clone()).with_events(told.clone());
    let text = bar([5, 28], "", BY_USER, 1e-7, "")
        .replace("*End Step\n", "*End Step\n*Step\n*Dynamic, Explicit\n , 1.e-7\n*End Step\n");
    let (outcome, _) = common::run(&text, &[], &routines);
    assert_eq!((outcome.halt, outcome.steps.len()), (None, 2));
    let told = told.0.lock().expect("a list");
    let first = ["StartAnalysis of step 1", "StartStep of step 1", "128 points at time zero", "12 points at time zero"];
    assert_eq!(told[..4], first);
    assert_eq!(told.iter().filter(|line| line.contains("time zero")).count(), 2);
}

/// The heat of the inelastic work that a routine tells is the built-in material's, and its temperature is told to it.
#[test]
fn heat_follows_the_inelastic_work() {
    let heat = "*Inelastic Heat Fraction\n 0.9,\n*Specific Heat\n 385.,\n";
    let [built_in, by_user] = [BUILT_IN, BY_USER].map(|material| {
        let text =
            bar([5, 25], "", &(material.to_owned() + heat), 10e-6, "").replace("Explicit\n", "Explicit, adiabatic\n");
        text.replace(" S, LE, ", " TEMP, S, LE, ")
    });
    let routines = Routines::none().with_material(Yielding);
    let temperature = |text: &str, routines: &Routines| {
        let (outcome, memory) = common::run(text, &[], routines);
        assert_eq!(outcome.halt, None);
        let prepared = common::prepared(text, &[], routines);
        let at = prepared.plan.columns.iter().position(|c| c.name == "TEMP@FOOT").expect("a column");
        memory.rows.last().expect("a row").1[at]
    };
    let (expected, got) = (temperature(&built_in, &Routines::none()), temperature(&by_user, &routines));
    // Rounding of sums in another order over some 200 increments.
    assert!(expected > 10.0 && (got / expected - 1.0).abs() < 1e-9, "{got} {expected}");
}
