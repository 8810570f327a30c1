//! User loads in Rust: agreement with the built-in resistance, state, and located errors.

use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

use crate::common;

/// A load defined by a closure.
struct ClosureLoad<F>(F);

impl<F: FnMut(&LoadPoints<'_>, &mut [f64]) -> Result<(), LoadFailure> + Send> UserLoad for ClosureLoad<F> {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        (self.0)(points, pressure)
    }
}

fn user_deck() -> String {
    common::ogive().replace("*Dsload, target=BLOCK, friction=<friction>\n NOSE, CAVITY", "*Dsload\n NOSE, PNU")
}

fn cavity() -> Routines {
    Routines::none().with_load(ClosureLoad(|points: &LoadPoints<'_>, pressure: &mut [f64]| {
        for (i, p) in pressure.iter_mut().enumerate() {
            let v_n = points.velocity_r[i] * points.normal_r[i] + points.velocity_z[i] * points.normal_z[i];
            *p = if v_n > 0.0 { 5.0394 * 276e6 + 0.983 * 2710.0 * v_n * v_n } else { 0.0 };
        }
        Ok(())
    }))
}

#[test]
fn user_load_matches_the_built_in_resistance() {
    for v in ["569", "1147"] {
        let settings = [("V", v), ("front", "0.1")];
        let (built_in, _) = common::run(&common::ogive(), &settings, &Routines::none());
        let (own, _) = common::run(&user_deck(), &settings, &cavity());
        let (a, b) = (built_in.rests[0].displacement, own.rests[0].displacement);
        assert!((a / b - 1.0).abs() < 1e-12, "{a} against {b}");
    }
}

fn halt(routines: Routines) -> (String, common::RecordedOutput) {
    let (outcome, memory) = common::run(&user_deck(), &[("front", "0.1")], &routines);
    (outcome.halt.expect("a halt").message().to_owned(), memory)
}

#[test]
fn nan_is_located_and_the_last_valid_state_is_written() {
    let mut calls = 0;
    let routine = Routines::none().with_load(ClosureLoad(move |_: &LoadPoints<'_>, pressure: &mut [f64]| {
        calls += 1;
        pressure.fill(1e8);
        if calls == 50 {
            pressure[3] = f64::NAN;
        }
        Ok(())
    }));
    let (reason, memory) = halt(routine);
    for part in ["NOSE", "point 4", "time", "NaN"] {
        assert!(reason.contains(part), "`{part}` in: {reason}");
    }
    let frame = memory.frames.last().expect("a frame");
    assert!(frame.point_fields.iter().chain(&frame.cell_fields).all(|f| f.values.iter().all(|v| v.is_finite())));
    assert!(memory.rows.iter().all(|r| r.1.iter().all(|v| v.is_finite())));
}

#[test]
fn missing_point_and_error_are_reported() {
    let (reason, _) = halt(Routines::none().with_load(ClosureLoad(|_: &LoadPoints<'_>, pressure: &mut [f64]| {
        pressure[0] = 0.0;
        Ok(())
    })));
    assert!(reason.contains("point 2"), "{reason}");
    let (reason, _) = halt(Routines::none().with_load(ClosureLoad(|_: &LoadPoints<'_>, _: &mut [f64]| {
        Err(LoadFailure { point: Some(1), reason: "table exhausted".into() })
    })));
    assert!(reason.contains("table exhausted") && reason.contains("point 2"), "{reason}");
}

#[test]
fn pnu_without_a_subroutine_is_rejected() {
    let prepared = revolve::job::prepare_text("t.inp", &user_deck(), &[], &Routines::none());
    assert!(prepared.diagnostics.iter().any(|d| d.code == "P004"));
}

/// A pressure that begins at an instant that no increment ends at: the final velocity is the impulse over the mass, to the
/// precision of the instant. A pressure that grows from zero keeps its increments.
#[test]
fn sudden_load_begins_at_its_instant() {
    let deck = "*Node\n 1, 0., 0.\n 2, 1., 0.\n 9, 0., 0.\n*Element, type=RAX2, elset=DISC\n 1, 1, 2\n\
                *Element, type=MASS, elset=M\n 10, 9\n*Mass, elset=M\n 2.\n*Rigid Body, ref node=9, elset=DISC\n*Nset, nset=REF\n 9\n\
                *Surface, name=FACE\n DISC, SPOS\n*Step\n*Dynamic, Explicit\n , 1.\n*Dsload\n FACE, PNU\n\
                *Output, history, number interval=1\n*Node Output, nset=REF\n V2\n*End Step\n";
    let run = |pressure: fn(f64) -> f64| {
        let load = move |points: &LoadPoints<'_>, values: &mut [f64]| {
            values.fill(pressure(points.now.total_time));
            Ok(())
        };
        let (outcome, memory) = common::run(deck, &[], &Routines::none().with_load(ClosureLoad(load)));
        assert_eq!(outcome.halt, None);
        (memory.rows.last().expect("a row").1[0], outcome.energy.drift)
    };
    let area_over_mass = std::f64::consts::PI / 2.0;
    for (name, pressure, impulse) in [
        ("step", (|t| if t >= 0.377 { 1.0 } else { 0.0 }) as fn(f64) -> f64, 0.623),
        ("decay", |t| if t >= 0.377 { (-50.0 * (t - 0.377)).exp() } else { 0.0 }, 0.02),
        ("ramp", |t| (t - 0.377).max(0.0), 0.5 * 0.623 * 0.623),
    ] {
        let (velocity, drift) = run(pressure);
        let expected = -impulse * area_over_mass;
        println!("{name}: {velocity:.7}, expected {expected:.7}, drift {drift:.1e}");
        assert!((velocity / expected - 1.0).abs() < 5e-4, "{name}: {velocity} {expected}");
        assert!(drift < 1e-3, "{name}: {drift:e}");
    }
}
