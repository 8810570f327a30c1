//! Stiff user loads: pressures that depend on displacement.
//!
//! Goal: the stable time increment follows a stiffness known only to the user subroutine, and this is reported;
//! pressures that jump, alternate or depend on velocity are not treated as a stiffness. Source: Hooke's law of a column
//! on a foundation; the same deck with given increments.

use revolve::solve::Outcome;
use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

use crate::common::solid::{grid, material};
use crate::common::{self, RecordedOutput};

struct ClosureLoad<F>(F);

impl<F: FnMut(&LoadPoints<'_>, &mut [f64]) + Send> UserLoad for ClosureLoad<F> {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        (self.0)(points, pressure);
        Ok(())
    }
}

/// Runs a steel column of radius 2 and height 20 mm with elements of 1 mm, loaded by 100 MPa from above within a
/// millisecond (forty wave transit times both ways) and supported by the user load. History: the displacement of its
/// axis.
fn column(step: &str, more: &str, routines: &Routines) -> (Outcome, RecordedOutput) {
    let deck = grid(2, 20, false, |i, j| [i as f64, j as f64])
        + &material(200e3, 0.0, 7.85e-9, "")
        + "*Nset, nset=FOOT\n 1,\n*Nset, nset=HEAD\n 61,\n*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 1.e-3, 1.\n"
        + more
        + step
        + "*Dsload\n J0, PNU\n*Dsload, amplitude=A\n J1, P, 100.\n\
           *Output, history, number interval=100\n*Node Output, nset=FOOT\n U2\n*Node Output, nset=HEAD\n U2\n*End Step\n";
    common::run(&deck, &[], routines)
}

fn stiffness_warnings(outcome: &Outcome) -> Vec<&String> {
    outcome.warnings.iter().filter(|w| w.contains("This stiffness is not part of the stable time increment")).collect()
}

/// Returns a foundation of `ratio` times the stiffness E/h of an element.
fn foundation(ratio: f64) -> Routines {
    let bed = move |points: &LoadPoints<'_>, pressure: &mut [f64]| {
        for (p, z) in pressure.iter_mut().zip(points.z) {
            *p = -ratio * 200e3 * z;
        }
    };
    Routines::none().with_load(ClosureLoad(bed))
}

/// Pressures with stiffness E/h times 2, 10 and 100: with the stable time increment of the elements alone all runs are
/// unstable.
#[test]
fn stable_increment_follows_the_foundation_stiffness() {
    for ratio in [2.0, 10.0, 100.0] {
        // 1 mm divided by 5048 m/s, and less.
        let given =
            column("*Step\n*Dynamic, Explicit, direct user control\n 1.7e-7, 1.2e-3\n", "", &foundation(ratio)).0;
        assert!(given.halt.is_some(), "{ratio}: stable with the increment of the elements");
        let (outcome, memory) = column("*Step\n*Dynamic, Explicit\n , 1.2e-3\n", "", &foundation(ratio));
        assert!(outcome.halt.is_none() && outcome.energy.drift < 1e-3, "{ratio}: {outcome:?}");
        let last = &memory.rows.last().expect("a row").1;
        let exact = [-100.0 / (ratio * 200e3), -100.0 * (1.0 / (ratio * 200e3) + 20.0 / 200e3)];
        println!("{ratio}: {} increments, {last:?}, {exact:?}; {:?}", outcome.increments, stiffness_warnings(&outcome));
        // The column still vibrates by some thousandths of its shortening.
        assert!((0..2).all(|i| (last[i] - exact[i]).abs() < 5e-3 * exact[1].abs()), "{ratio}: {last:?} {exact:?}");
        assert_eq!(stiffness_warnings(&outcome).len(), 1, "{:?}", outcome.warnings);
    }
}

/// Resistance that depends on the sign of the velocity, a front plane, pressures that alternate or start late: the
/// increments are those of the elements, without a message.
#[test]
fn discontinuous_or_velocity_dependent_pressure_is_not_a_stiffness() {
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
        ("front", Routines::none().with_load(ClosureLoad(front))),
        ("blink", Routines::none().with_load(ClosureLoad(blink))),
        ("late", Routines::none().with_load(ClosureLoad(late))),
        ("drag", Routines::none().with_load(ClosureLoad(drag))),
        ("cavity", Routines::none().with_load(ClosureLoad(cavity))),
    ] {
        for more in ["", flies] {
            let (outcome, _) = column("*Step\n*Dynamic, Explicit\n , 1.2e-3\n", more, &routine);
            println!(
                "{name}: {} increments, {:?}, {:?}",
                outcome.increments,
                outcome.halt,
                stiffness_warnings(&outcome)
            );
            assert!(stiffness_warnings(&outcome).is_empty(), "{name}: {:?}", outcome.warnings);
        }
    }
}
