//! Friction by a user subroutine (`*FRICTION, USER`, VFRICTION).
//!
//! Goal: a subroutine with Coulomb's law gives the motion of `*FRICTION`; laws in closed form (viscous friction; friction that
//! falls with the accumulated slip, a state variable) give their velocities; arguments are those of the manual; a resumed run has
//! the bits of a whole one; invalid forces halt the run. The scene is a ring on a rigid shaft. Needs gfortran for Fortran files;
//! without it these tests are left out, except in CI.

use std::f64::consts::TAU;

use revolve::job;
use revolve::user::{FrictionCall, LoadFailure, Routines, UserFriction};

use crate::common;
use crate::common::bodies::{DeckRun, LAME, PER_COEFFICIENT, PRESSURE, RAMP, mean_velocities, ring_on_shaft, run_with};
use crate::material::compiled;
use crate::subroutines::{UserFolder, message_text};

/// Returns a subroutine whose friction force is computed by these statements for the point k.
fn vfriction(statements: &str) -> String {
    let head = std::fs::read_to_string(common::project("input/vfriction_wear.f90")).expect("the example");
    let (head, _) = head.split_once("! law").expect("the law");
    format!("{head}\n{statements}\n      end do\n      end\n")
}

/// Coulomb's law with the coefficient props(1).
const COULOMB: &str = "        fTangential(1,k) = -min(props(1)*fNormal(k), fStickForce(k))";

fn user(constants: &[f64], variables: usize) -> String {
    let values: Vec<String> = constants.iter().map(|c| format!("{c:e}")).collect();
    format!("*Friction, user, properties={}, depvar={variables}\n {}\n", constants.len(), values.join(", "))
}

/// Runs a ring with a user friction.
fn run_ring(cells: usize, friction: &str, speed: f64, time: f64, routines: &Routines) -> DeckRun {
    run_with(&ring_on_shaft(cells, friction, speed, time), routines).whole()
}

/// Coulomb's law in Fortran decelerates the ring as `*FRICTION` does without damping of flutter, on meshes of two sizes, until
/// the contact face sticks.
#[test]
fn coulomb_friction_of_a_subroutine_acts_as_the_built_in_one() {
    if !common::fortran("vfriction in Fortran") {
        return;
    }
    let routines = compiled(&vfriction(COULOMB)).expect("it compiles");
    for (cells, mu) in [(4, 0.1), (8, 0.05)] {
        let speed = 170.0 * mu * PER_COEFFICIENT;
        let built_in = format!("*Friction, slip damping=0\n {mu},\n");
        let expected = mean_velocities(&run_ring(cells, &built_in, speed, 260.0, &Routines::none()));
        let ran = run_ring(cells, &user(&[mu], 0), speed, 260.0, &routines);
        let found = mean_velocities(&ran);
        let worst = found.iter().zip(&expected).map(|(a, b)| (a[1] - b[1]).abs() / speed).fold(0.0, f64::max);
        println!("ring with {cells} cells, friction {mu}: difference {worst:.1e} of the initial velocity");
        assert!(found.len() > 50 && found[0][1] > 0.9 * speed, "{found:?}");
        assert!(worst < 1e-4, "{worst}");
        let energy = ran.outcome.energy;
        assert!((energy.friction / energy.initial - 1.0).abs() < 1e-3 && energy.drift < 1e-5, "{energy:?}");
    }
}

/// A force c A v gives dv/dt = -(c A/m) v: the velocity falls exponentially, and the ring comes to rest after the distance
/// v m/(c A). The contact face has the area A = 2 pi, the ring the mass 3 pi.
struct Viscous {
    coefficient: f64,
    calls: usize,
}

impl UserFriction for Viscous {
    fn friction(&mut self, call: &FrictionCall<'_>, forces: &mut [f64], state: &mut [f64]) -> Result<(), LoadFailure> {
        self.calls += 1;
        assert_eq!((call.interaction, call.variables, state.len()), ("DRY", 0, 0));
        assert_eq!(forces.len(), 2 * call.nodes.len());
        for k in 0..call.nodes.len() {
            let [normal, along] = call.directions.map(|list| [list[3 * k], list[3 * k + 1], list[3 * k + 2]]);
            // The normal of the shaft points away from the axis.
            assert!((normal[0] - 1.0).abs() < 1e-12 && normal[2] == 0.0, "{normal:?}");
            assert!(along[0].abs() < 1e-12 && (along[1].abs() - 1.0).abs() < 1e-12, "{along:?}");
            assert!(call.nodes[k] > 0 && call.coordinates[0][3 * k] > 0.9, "{}", call.nodes[k]);
            let [own, opposite] = call.velocities.map(|list| list[3 * k + 1]);
            // The slip is the mean over the hat function of the point: the velocity of the point differs from it as the ring vibrates.
            assert!((own - opposite).abs() <= 1.1 * call.slip[3 * k] / call.dt && call.dt > 0.0, "{own} {opposite}");
            forces[2 * k] = -(self.coefficient * call.area[k] * call.slip[3 * k] / call.dt).min(call.stick[k]);
        }
        let area: f64 = call.area.iter().sum();
        if call.now.total_time > RAMP && call.nodes.len() == 9 {
            let pressure = call.normal.iter().sum::<f64>() / area;
            assert!((area / TAU - 1.0).abs() < 1e-3, "{area}");
            assert!((pressure / (LAME * PRESSURE) - 1.0).abs() < 0.1, "{pressure}");
        }
        Ok(())
    }
}

#[test]
fn viscous_friction_matches_exponential_decay() {
    let (coefficient, speed) = (0.02, 1e-4);
    let routines = Routines::none().with_friction(Viscous { coefficient, calls: 0 });
    let ran = run_ring(8, "*Friction, user\n", speed, 400.0, &routines);
    let speeds: Vec<_> = mean_velocities(&ran).into_iter().filter(|s| s[0] > RAMP + 15.0).collect();
    let rate = coefficient * 2.0 / 3.0;
    let [time, first] = speeds[0];
    let worst = speeds.iter().map(|s| (s[1] / first - (-rate * (s[0] - time)).exp()).abs()).fold(0.0, f64::max);
    // The way after this time, from the trapezoidal rule and the rest of the exponential.
    let way: f64 = speeds.windows(2).map(|s| 0.5 * (s[0][1] + s[1][1]) * (s[1][0] - s[0][0])).sum();
    let distance = (way + speeds[speeds.len() - 1][1] / rate) * rate / first;
    println!("viscous friction: error {worst:.1e} of the velocity, stopping distance {distance:.5} of its value");
    assert!(worst < 2e-3, "{worst}");
    assert!((distance - 1.0).abs() < 2e-3, "{distance}");
}

/// Friction mu (1 - s/l) after a slip s, which is a state variable: dv/ds = -(mu N/m)(1 - s/l)/v, so that v^2 falls by 2 (mu N/m)
/// (s - s^2/(2 l)) up to s = l. The slip of the pressure ramp is taken from the run.
#[test]
fn friction_that_falls_with_slip_matches_the_energy_balance() {
    if !common::fortran("vfriction in Fortran") {
        return;
    }
    let (mu, speed) = (0.1, 170.0 * 0.1 * PER_COEFFICIENT);
    let length = 0.5 * speed * 170.0;
    let file = std::fs::read_to_string(common::project("input/vfriction_wear.f90")).expect("the example");
    let routines = compiled(&file).expect("it compiles");
    let ran = run_ring(8, &user(&[mu, length], 1), speed, 190.0, &routines);
    let speeds = mean_velocities(&ran);
    let nodes = ran.nodes("RING");
    let mass: f64 = nodes.iter().map(|n| ran.state.dofs.nodes.mass[n[1]]).sum();
    let ways: Vec<f64> = ran
        .memory
        .frames
        .iter()
        .map(|frame| {
            let displacement = common::bodies::point_field(frame, "U");
            nodes.iter().map(|n| ran.state.dofs.nodes.mass[n[1]] * displacement[2 * n[0] + 1]).sum::<f64>() / mass
        })
        .collect();
    let from = speeds.iter().position(|s| s[0] > RAMP + 15.0).expect("a frame");
    let energy = |way: f64| {
        let worn = way.min(length);
        mu * PER_COEFFICIENT * (worn - worn * worn / (2.0 * length))
    };
    let mut worst = 0.0_f64;
    for (frame, [_, velocity]) in speeds.iter().enumerate().skip(from) {
        let lost = energy(ways[frame]) - energy(ways[from]);
        let expected = (speeds[from][1] * speeds[from][1] - 2.0 * lost).max(0.0).sqrt();
        worst = worst.max((velocity - expected).abs() / speed);
    }
    let last = speeds.len() - 1;
    assert!(ways[last] > 0.2 * length && speeds[last][1] > 0.1 * speed, "{} {length}", ways[last]);
    println!("friction that falls with slip: error {worst:.1e} of the initial velocity");
    assert!(worst < 3e-3, "{worst}");
}

/// Friction mu (1 - s/l) of a slip s that each point sums in its state variable.
struct Worn;

impl UserFriction for Worn {
    fn friction(&mut self, call: &FrictionCall<'_>, forces: &mut [f64], state: &mut [f64]) -> Result<(), LoadFailure> {
        let (count, [mu, length]) = (call.nodes.len(), [call.properties[0], call.properties[1]]);
        assert_eq!((call.variables, state.len()), (1, count));
        for k in 0..count {
            let slip = call.slip[3 * k];
            state[k] += slip.abs();
            let strength = mu * (1.0 - state[k] / length).max(0.0) * call.normal[k];
            forces[2 * k] = -strength.min(call.stick[k]);
        }
        Ok(())
    }
}

/// The state variables of points continue on new meshes: the velocity is that on the first mesh.
#[test]
fn state_of_friction_continues_on_new_meshes() {
    let (mu, speed) = (0.1, 170.0 * 0.1 * PER_COEFFICIENT);
    let deck = ring_on_shaft(8, &user(&[mu, speed * 85.0], 1), speed, 190.0);
    let card = "*Remesh, elset=RING.SOLID, frequency=20, angle=1., increment=0.9999999\n*Surface Interaction";
    let runs = ["*Remesh, automatic=NO\n*Surface Interaction", card].map(|cards| {
        let routines = Routines::none().with_friction(Worn);
        run_with(&deck.replacen("*Surface Interaction", cards, 1), &routines).whole()
    });
    let [first, last] = runs.each_ref().map(|ran| ran.momentum());
    let meshes: u64 = runs[1].outcome.new_meshes.iter().map(|meshes| meshes.count).sum();
    let friction = runs[1].outcome.energy.friction / runs[0].outcome.energy.friction - 1.0;
    println!("{meshes} meshes: momentum {:.1e} apart, friction {friction:.1e}", last / first - 1.0);
    assert!(meshes >= 4 && (last / first - 1.0).abs() < 2e-3 && friction.abs() < 1e-3, "{first} {last}");
}

/// Runs of files: with and without a separate process for the routine, and resumed from a checkpoint, have equal digests.
#[test]
fn isolated_and_resumed_runs_have_the_same_bits() {
    if !common::fortran("vfriction in Fortran") {
        return;
    }
    let user_dir = UserFolder::new();
    let speed = 170.0 * 0.1 * PER_COEFFICIENT;
    let deck = user_dir.write("ring.inp", &ring_on_shaft(4, &user(&[0.1, speed * 85.0], 1), speed, 120.0));
    let law = std::fs::read_to_string(common::project("input/vfriction_wear.f90")).expect("the example");
    let stops = "      call get_environment_variable('GO', status=igo)\n      if (rData(2) .gt. 90.d0 .and. igo .ne. 0) call xplb_exit";
    let file = user_dir
        .write("wear.f90", &law.replacen("      do k = 1, nBlock", &format!("{stops}\n      do k = 1, nBlock"), 1));
    let go = [("GO", "1".into())];
    let digest = || user_dir.summary("ring")["digest"].as_str().expect("a digest").to_owned();
    let output = user_dir.run_with(&go, &deck, &[&file], &[]);
    assert!(output.status.success(), "{}", message_text(&output));
    let expected = digest();
    let output = user_dir.run_with(&go, &deck, &[&file], &["--isolate"]);
    assert!(output.status.success(), "{}", message_text(&output));
    assert_eq!(digest(), expected);
    let output = user_dir.run(&deck, &[&file], &["--checkpoint-every", "200"]);
    assert_eq!(output.status.code(), Some(1), "{}", message_text(&output));
    let output = user_dir.run_with(&go, &deck, &[&file], &["--resume"]);
    assert!(output.status.success(), "{}", message_text(&output));
    assert!(user_dir.summary("ring")["timing"]["resumed_at"].as_u64() > Some(0));
    assert_eq!(digest(), expected);
}

/// Forces that do not oppose slip, forces along the hoop, values that are not finite, a missing subroutine and cards that exclude
/// each other are errors.
#[test]
fn invalid_friction_forces_are_reported() {
    struct Fixed([f64; 2]);
    impl UserFriction for Fixed {
        fn friction(&mut self, _: &FrictionCall<'_>, forces: &mut [f64], _: &mut [f64]) -> Result<(), LoadFailure> {
            forces[..2].copy_from_slice(&self.0);
            Ok(())
        }
    }
    let deck = ring_on_shaft(4, "*Friction, user\n", 1e-4, 60.0);
    for (force, part) in [
        ([1.0, 0.0], "set fTangential(1)"),
        ([f64::NAN, 0.0], "between -fStickForce and 0"),
        ([0.0, 1.0], "no motion along the hoop"),
    ] {
        let ran = run_with(&deck, &Routines::none().with_friction(Fixed(force)));
        let halt = ran.outcome.halt.expect("a halt").to_string();
        assert!(halt.contains("vfriction of `DRY`") && halt.contains(part), "{halt}");
    }
    for (card, code, part) in [
        ("*Friction, user\n", "P004", "*FRICTION, USER calls vfriction"),
        ("*Friction, user=coefficient\n", "M104", "VFRIC_COEF"),
        ("*Friction, user, taumax=1.\n", "M1", "TAUMAX"),
        ("*Friction, user, properties=2\n 0.1,\n", "M103", "PROPERTIES=2"),
        ("*Friction, depvar=2\n 0.1,\n", "", "DEPVAR"),
    ] {
        let prepared = job::prepare_text("ring.inp", &ring_on_shaft(4, card, 1e-4, 60.0), &[], &Routines::none());
        let text = prepared.diagnostics.render(&prepared.deck.sources);
        assert!(text.contains(code) && text.contains(part), "{card}{text}");
        assert!(prepared.diagnostics.has_errors(), "{card}{text}");
    }
}
