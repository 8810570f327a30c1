//! User motions and user body forces on deformable bodies.
//!
//! Goal: `*BOUNDARY, USER` moves nodes like the same motion of the deck; BRNU and BZNU are forces per volume. Source:
//! the built-in motion; free fall.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use revolve::user::{LoadFailure, LoadPoints, MotionCall, Routines, UserLoad, UserMotion};

use crate::common;
use crate::common::RecordedOutput;
use crate::common::solid::{grid, material};

fn body() -> String {
    grid(2, 2, false, |i, j| [1.0 + i as f64, j as f64])
        + &material(100.0, 0.3, 2.0, "")
        + "*Nset, nset=ONE\n 6,\n*Amplitude, name=RAMP\n 0., 0., 2., 2.\n"
}

/// Returns the values of a column.
fn column(text: &str, routines: &Routines, memory: &RecordedOutput, name: &str) -> Vec<f64> {
    let prepared = common::prepared(text, &[], routines);
    let at = prepared.plan.columns.iter().position(|c| c.name == name).expect("a column");
    memory.rows.iter().map(|row| row.1[at]).collect()
}

/// A velocity that increases with time; a displacement that increases with time squared and is NaN after some time.
struct GrowingMotion {
    until: f64,
}

impl UserMotion for GrowingMotion {
    fn motion(&mut self, call: &MotionCall<'_>) -> Result<f64, LoadFailure> {
        assert!(call.set == "I1" && (call.node - 3) % 3 == 0 && call.mass > 0.0);
        let t = call.now.total_time;
        // The current coordinate is the initial one plus the displacement.
        let start = if call.dof == 1 { 3.0 } else { f64::from(call.node / 3 - 1) };
        assert!((call.coordinates[call.dof - 1] - start - call.state[0]).abs() < 1e-12);
        Ok(if t > self.until {
            f64::NAN
        } else if call.kind == 1 {
            0.1 * t
        } else {
            0.05 * t * t
        })
    }
}

fn moved(card: &str) -> String {
    let step = |name: &str| {
        format!(
            "*Step, name={name}\n*Dynamic, Explicit, direct user control\n 1.e-3, 1.\n*Boundary, {card}\n\
             *Output, history, time interval=0.1\n*Node Output, nset=ONE\n U, V1, RF\n*Energy Output\n ALLWK, ETOTAL\n*End Step\n"
        )
    };
    body() + &step("One") + &step("Two")
}

#[test]
fn user_velocity_matches_built_in_motion() {
    for axis in [1, 2] {
        let built_in = moved(&format!("type=VELOCITY, amplitude=RAMP\n I1, {axis}, {axis}, 0.1"))
            .replace("*Amplitude, name=RAMP\n", "*Amplitude, name=RAMP, time=TOTAL TIME\n");
        let by_user = moved(&format!("user, type=VELOCITY\n I1, {axis}, {axis}"));
        let (none, routines) = (Routines::none(), Routines::none().with_motion(GrowingMotion { until: 9.0 }));
        let ((_, there), (outcome, here)) = (common::run(&built_in, &[], &none), common::run(&by_user, &[], &routines));
        assert_eq!(outcome.halt, None);
        for name in [&format!("U{axis}@ONE"), &format!("RF{axis}@ONE"), "ALLWK"] {
            let [expected, got] = [column(&built_in, &none, &there, name), column(&by_user, &routines, &here, name)];
            let largest = expected.iter().fold(0_f64, |a, b| a.max(b.abs()));
            assert!(largest > 0.01, "{name}");
            // Values interpolated between two increments: rounding of times.
            assert!(
                expected.iter().zip(&got).all(|(a, b)| (a - b).abs() < 1e-10 * largest),
                "{name} {expected:?} {got:?}"
            );
        }
        assert!(outcome.energy.drift < 1e-3, "{:?}", outcome.energy);
    }
}

#[test]
fn user_displacement_is_total_over_steps() {
    let deck = moved("user\n I1, 1, 1");
    let routines = Routines::none().with_motion(GrowingMotion { until: 9.0 });
    let (outcome, memory) = common::run(&deck, &[], &routines);
    assert_eq!(outcome.halt, None);
    let u = column(&deck, &routines, &memory, "U1@ONE");
    for ((time, _), u) in memory.rows.iter().zip(u) {
        assert!((u - 0.05 * time * time).abs() < 1e-12, "{u} at {time}");
    }
    let failing = Routines::none().with_motion(GrowingMotion { until: 0.5 });
    let halt = common::run(&deck, &[], &failing).0.halt.expect("it halts");
    assert!(
        halt.code() == "R201" && halt.message().contains("`I1` at node 3") && halt.message().contains("NaN"),
        "{halt:?}"
    );
}

/// A constant force per volume.
struct BodyForce(f64);

impl UserLoad for BodyForce {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        assert!(points.load_type <= 2 && points.surface == "SOLID" && points.r.len() == 4);
        assert!(points.r[0] < points.r[1] && points.z[0] < points.z[2]);
        pressure.fill(self.0 * points.amplitude);
        Ok(())
    }
}

#[test]
fn axial_body_force_gives_free_fall() {
    let deck = body()
        + "*Step\n*Dynamic, Explicit, direct user control\n 1.e-3, 1.\n*Dload\n SOLID, BZNU\n\
           *Output, history, time interval=0.1\n*Node Output, nset=ONE\n U2, A2\n*Energy Output\n ALLWK, ALLKE, ALLIE\n*End Step\n";
    let routines = Routines::none().with_load(BodyForce(-6.0));
    let (outcome, memory) = common::run(&deck, &[], &routines);
    assert_eq!(outcome.halt, None);
    let (u, a) = (column(&deck, &routines, &memory, "U2@ONE"), column(&deck, &routines, &memory, "A2@ONE"));
    for (((time, _), u), a) in memory.rows.iter().zip(u).zip(a) {
        // Force per volume over density: -3.
        assert!((u + 1.5 * time * time).abs() < 1e-10 && (a + 3.0).abs() < 1e-10, "{u} {a} at {time}");
    }
    let energy = outcome.energy;
    // The work of the initial half increment uses the mean of its velocities.
    assert!((energy.work / energy.kinetic - 1.0).abs() < 1e-11 && energy.internal < 1e-12, "{energy:?}");
}

#[test]
fn radial_body_force_is_distributed_like_mass() {
    let deck = body()
        + "*Step\n*Dynamic, Explicit\n , 1.\n*Dload\n SOLID, BRNU\n*Output, field, number interval=1\n*Node Output\n A\n\
           *Output, history, number interval=1\n*Energy Output\n ALLWK\n*End Step\n";
    let routines = Routines::none().with_load(BodyForce(4.0));
    let (outcome, memory) = common::run(&deck, &[], &routines);
    assert_eq!(outcome.halt, None);
    for a in memory.frames[0].point_fields[0].values.chunks(2) {
        assert!((a[0] - 2.0).abs() < 1e-12 && a[1] == 0.0, "{a:?}");
    }
    // Two elements vibrate with periods of a few increments, which change with the deformation; the energy balance is
    // of second order.
    assert!(outcome.energy.work > 0.0 && outcome.energy.drift < 5e-3, "{:?}", outcome.energy);
}

/// A load without force that checks the acceleration it receives, that of the previous increment.
struct AccelerationRecorder {
    seen: Arc<AtomicUsize>,
}

impl UserLoad for AccelerationRecorder {
    fn reads_motion(&self) -> bool {
        true
    }

    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        let n = pressure.len();
        let expected = if points.now.increment == 0 { 0.0 } else { -9.81 };
        let right = |a: &f64, expected: f64| (a - expected).abs() < 1e-9;
        let [along_r, along_z] = [&points.motion[4 * n..5 * n], &points.motion[5 * n..6 * n]];
        if along_r.iter().all(|a| right(a, 0.0)) && along_z.iter().all(|a| right(a, expected)) {
            self.seen.fetch_add(1, Ordering::Relaxed);
        }
        pressure.fill(0.0);
        Ok(())
    }
}

#[test]
fn user_load_receives_the_previous_acceleration() {
    for load in ["*Dsload\n J1, PNU\n", "*Dload\n SOLID, BZNU\n"] {
        let deck = body()
            + "*Step\n*Dynamic, Explicit, direct user control\n 1.e-3, 0.02\n*Dload\n SOLID, GRAV, 9.81, 0., -1.\n"
            + load
            + "*End Step\n";
        let seen = Arc::new(AtomicUsize::new(0));
        let routines = Routines::none().with_load(AccelerationRecorder { seen: seen.clone() });
        let (outcome, _) = common::run(&deck, &[], &routines);
        assert_eq!(outcome.halt, None);
        assert_eq!(seen.load(Ordering::Relaxed) as u64, outcome.increments + 1, "{load}");
    }
}
