//! User loads that are stiff: pressures that follow the place of what they push.
//!
//! Goal: the stable increment follows a stiffness that only the routine knows, and says so; pressures that jump, blink or
//! follow velocity are no stiffness.
//! Source: Hooke's law of a column on a foundation; the same deck with given increments.

use revolve::solve::Outcome;
use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

use crate::common::solid::{grid, material};
use crate::common::{self, Memory};

struct Routine<F>(F);

impl<F: FnMut(&LoadPoints<'_>, &mut [f64]) + Send> UserLoad for Routine<F> {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        (self.0)(points, pressure);
        Ok(())
    }
}

/// A steel column of radius 2 and height 20 mm in squares of 1 mm, pressed by 100 MPa from above within a millisecond (forty
/// ways of a wave there and back), under which the routine's load stands: rows of its middle.
fn column(step: &str, more: &str, routines: &Routines) -> (Outcome, Memory) {
    let deck = grid(2, 20, false, |i, j| [i as f64, j as f64])
        + &material(200e3, 0.0, 7.85e-9, "")
        + "*Nset, nset=FOOT\n 1,\n*Nset, nset=HEAD\n 61,\n*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 1.e-3, 1.\n"
        + more
        + step
        + "*Dsload\n J0, PNU\n*Dsload, amplitude=A\n J1, P, 100.\n\
           *Output, history, number interval=100\n*Node Output, nset=FOOT\n U2\n*Node Output, nset=HEAD\n U2\n*End Step\n";
    common::run(&deck, &[], routines)
}

fn told(outcome: &Outcome) -> Vec<&String> {
    outcome.warnings.iter().filter(|w| w.contains("This stiffness is not part of the stable time increment")).collect()
}

/// A foundation of `ratio` times the stiffness E/h of an element below the column.
fn foundation(ratio: f64) -> Routines {
    let bed = move |points: &LoadPoints<'_>, pressure: &mut [f64]| {
        for (p, z) in pressure.iter_mut().zip(points.z) {
            *p = -ratio * 200e3 * z;
        }
    };
    Routines::none().with_load(Routine(bed))
}

/// Pressures follow E/h times 2, 10 and 100: at the increment that elements alone bear all grow beyond bounds.
#[test]
fn the_stable_increment_follows_the_stiffness_of_a_foundation() {
    for ratio in [2.0, 10.0, 100.0] {
        // 1 mm over 5048 m/s, and less.
        let given =
            column("*Step\n*Dynamic, Explicit, direct user control\n 1.7e-7, 1.2e-3\n", "", &foundation(ratio)).0;
        assert!(given.halt.is_some(), "{ratio}: bears the increments of its elements");
        let (outcome, memory) = column("*Step\n*Dynamic, Explicit\n , 1.2e-3\n", "", &foundation(ratio));
        assert!(outcome.halt.is_none() && outcome.energy.drift < 1e-3, "{ratio}: {outcome:?}");
        let last = &memory.rows.last().expect("a row").1;
        let exact = [-100.0 / (ratio * 200e3), -100.0 * (1.0 / (ratio * 200e3) + 20.0 / 200e3)];
        println!("{ratio}: {} increments, {last:?}, {exact:?}; {:?}", outcome.increments, told(&outcome));
        // The column still swings by some thousandths of its shortening.
        assert!((0..2).all(|i| (last[i] - exact[i]).abs() < 5e-3 * exact[1].abs()), "{ratio}: {last:?} {exact:?}");
        assert_eq!(told(&outcome).len(), 1, "{:?}", outcome.warnings);
    }
}

/// Resistance that is there or not by the sign of the velocity, a front in the way, pressures that blink or come late: the
/// increments are those of elements, and nothing is told.
#[test]
fn what_jumps_or_follows_velocity_is_no_stiffness() {
    let front = |points: &LoadPoints<'_>, pressure: &mut [f64]| {
        for (p, z) in pressure.iter_mut().zip(points.z) {
            *p = if *z < -0.02 { 300.0 } else { 0.0 };
        }
    };
    let mut calls = 0_u64;
    let blink = move |_: &LoadPoints<'_>, pressure: &mut [f64]| {
        pressure.fill(if calls.is_multiple_of(2) { 200.0 } else { 0.0 });
        calls += 1;
    };
    let late = |points: &LoadPoints<'_>, pressure: &mut [f64]| {
        let after = points.now.total_time - 3e-4;
        pressure.fill(if after > 0.0 { 300.0 * (-after / 1e-4).exp() } else { 0.0 });
    };
    let drag = |points: &LoadPoints<'_>, pressure: &mut [f64]| {
        for (p, v) in pressure.iter_mut().zip(points.velocity_z) {
            *p = -2.7e-9 * v * v.abs();
        }
    };
    let cavity = |points: &LoadPoints<'_>, pressure: &mut [f64]| {
        for (p, v) in pressure.iter_mut().zip(points.velocity_z) {
            *p = if *v < 0.0 { 139.0 + 0.983 * 2.71e-9 * v * v } else { 0.0 };
        }
    };
    let flies = "*Initial Conditions, type=VELOCITY\n ALL, 2, -1.e5\n";
    for (name, routine) in [
        ("front", Routines::none().with_load(Routine(front))),
        ("blink", Routines::none().with_load(Routine(blink))),
        ("late", Routines::none().with_load(Routine(late))),
        ("drag", Routines::none().with_load(Routine(drag))),
        ("cavity", Routines::none().with_load(Routine(cavity))),
    ] {
        for more in ["", flies] {
            let (outcome, _) = column("*Step\n*Dynamic, Explicit\n , 1.2e-3\n", more, &routine);
            println!("{name}: {} increments, {:?}, {:?}", outcome.increments, outcome.halt, told(&outcome));
            assert!(told(&outcome).is_empty(), "{name}: {:?}", outcome.warnings);
        }
    }
}
