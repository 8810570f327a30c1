//! Contact laws of element surfaces: friction, and pressure-overclosure.
//!
//! Goal: forces and energies that agree with the specified laws.
//! Source: Newton's second law for a ring on a shaft with Lame's pressure; statics of a loaded block. The tolerance and
//! its reason are stated at each test.

use revolve::output::OutputFrame;

use crate::common::bodies::{
    DeckRun, LAME, PER_COEFFICIENT, PRESSURE, RAMP, assembly, elastic, mean_velocities, part, point_field, rigid_body,
    ring_on_shaft, run, straight_line,
};

/// Runs a ring on a rigid shaft.
fn run_ring(cells: usize, friction: &str, speed: f64, time: f64) -> DeckRun {
    run(&ring_on_shaft(cells, friction, speed, time)).whole()
}

/// Returns the slope of a straight line through the points between two times.
fn slope(points: &[[f64; 2]], from: f64, to: f64) -> f64 {
    let part: Vec<_> = points.iter().filter(|p| (from..=to).contains(&p[0])).collect();
    let mean = |i: usize| part.iter().map(|p| p[i]).sum::<f64>() / part.len() as f64;
    let [t, v] = [mean(0), mean(1)];
    let above: f64 = part.iter().map(|p| (p[0] - t) * (p[1] - v)).sum();
    above / part.iter().map(|p| (p[0] - t) * (p[0] - t)).sum::<f64>()
}

/// The deceleration is constant at constant pressure, then the contact face sticks, and ALLFD is the initial kinetic
/// energy.
#[test]
fn ring_deceleration_matches_coulomb_friction() {
    for (cells, mu) in [(4, 0.1), (8, 0.1), (16, 0.1), (8, 0.05)] {
        let fall = mu * PER_COEFFICIENT;
        // The ramp counts for half of its duration: the ring is at rest after 200.
        let (speed, stop) = (170.0 * fall, 200.0);
        let ran = run_ring(cells, &format!("*Friction\n {mu},\n"), speed, 300.0);
        let speeds = mean_velocities(&ran);
        let deceleration = -slope(&speeds, RAMP + 15.0, stop - 10.0) / fall;
        let foot = |frame: &OutputFrame| point_field(frame, "U")[1];
        let later: Vec<_> = ran.memory.frames.iter().filter(|f| f.time > stop + 10.0).map(foot).collect();
        let way = later[later.len() - 1];
        let crept = later.iter().fold(0.0_f64, |most, u| most.max((u - way).abs())) / way;
        let energy = ran.outcome.energy;
        let heat = energy.friction / energy.initial;
        println!(
            "ring on a shaft, {cells} cells, {mu}: deceleration {deceleration:.5}, crept {crept:.1e} of the way, friction {heat:.5} \
             of what it had, contact {:.1e}, drift {:.1e}",
            energy.contact / energy.initial,
            energy.drift
        );
        assert!((deceleration - 1.0).abs() < 2e-3, "{deceleration}");
        // At the ends of the contact face the ring still vibrates.
        assert!(crept < 2e-5, "{crept}");
        assert!(
            (heat - 1.0).abs() < 1e-3 && energy.contact.abs() < 1e-8 * energy.initial && energy.drift < 1e-5,
            "{energy:?}"
        );
    }
}

/// dv/dt = -(N/m) (mu + (rest - mu) exp(-d v)). With u = exp(d v), u' = -d (N/m) (mu u + rest - mu) over the time
/// weighted by the pressure.
#[test]
fn friction_decays_exponentially_to_its_sliding_value() {
    let [at_rest, sliding, decay] = [0.1, 0.05, 800.0];
    let speed = 170.0 * 0.06 * PER_COEFFICIENT;
    let ran = run_ring(8, &format!("*Friction, exponential decay\n {at_rest}, {sliding}, {decay}\n"), speed, 250.0);
    let (speeds, more) = (mean_velocities(&ran), (at_rest - sliding) / sliding);
    let mut worst = 0.0_f64;
    for s in speeds.iter().filter(|s| s[0] > RAMP + 15.0) {
        let time = s[0] - 0.5 * RAMP;
        let u = ((decay * speed).exp() + more) * (-decay * sliding * PER_COEFFICIENT * time).exp() - more;
        let expected = u.max(1.0).ln() / decay;
        if expected > 0.02 * speed {
            worst = worst.max((s[1] - expected).abs() / speed);
        }
    }
    println!("friction that decays: error of the velocity {worst:.1e} of the initial one");
    assert!(worst < 2e-3, "{worst}");
}

/// The shear stress limit is lower than the friction.
#[test]
fn friction_is_limited_by_the_largest_shear_stress() {
    let most = 0.06 * LAME * PRESSURE;
    let ran = run_ring(8, &format!("*Friction, taumax={most:e}\n 0.1,\n"), 170.0 * 0.06 * PER_COEFFICIENT, 190.0);
    let deceleration = -slope(&mean_velocities(&ran), RAMP + 15.0, 190.0) / (0.06 * PER_COEFFICIENT);
    println!("largest shear stress: deceleration {deceleration:.5}");
    assert!((deceleration - 1.0).abs() < 2e-3, "{deceleration}");
}

/// Runs a disc pressed on a rigid plane.
fn run_disc(cells: usize, ratio: f64, interaction: &str, pressure: f64, foot: &str) -> DeckRun {
    let deck = part("DISC", [cells; 2], |i, j| [i as f64 / cells as f64, j as f64 / cells as f64], "")
        + &straight_line("PLANE", [0.0, 0.0], [2.0, 0.0], 3)
        + &assembly(&["DISC", "PLANE"], &rigid_body("PLANE"))
        + &elastic("DISC", [1.0, ratio, 1.0], "*Damping, alpha=0.6\n")
        + &format!(
            "*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., 60., 1.\n*Surface Interaction, name=LAW\n{interaction}*Step\n*Dynamic, Explicit\n , 200.\n*Boundary\n PLANE.REF, 2, 2\n{foot}"
        )
        + &format!(
            "*Dsload, amplitude=RAMP\n DISC.J1, P, {pressure:e}\n*Contact Pair, interaction=LAW\n DISC.J0, PLANE.SKIN\n"
        )
        + "*Output, field, number interval=1\n*Node Output\n U\n*Element Output\n S\n*End Step\n";
    run(&deck).whole()
}

/// On a rough plane the foot of a disc keeps its width.
#[test]
fn rough_plane_fixes_the_foot() {
    let rough = run_disc(6, 0.3, "*Friction, rough\n", 1e-4, "");
    let held = run_disc(6, 0.3, "", 1e-4, " DISC.J0, 1, 1\n");
    let [rough, held] = [&rough, &held].map(|ran| point_field(ran.end(), "U"));
    let largest = held.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
    let off = rough.iter().zip(held).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs())) / largest;
    println!("rough foot: error of displacements {off:.1e}");
    assert!(off < 1e-7, "{off}");
}

/// The overclosure of a loaded block agrees with the law at its pressure.
#[test]
fn overclosure_of_a_loaded_block_follows_its_law() {
    let (p, e) = (1e-3, std::f64::consts::E);
    // p0/(e - 1) x (exp(x) - 1) with x = h/c + 1.
    let exponential = |p0: f64, c: f64| {
        let mut x = 1.0_f64;
        for _ in 0..60 {
            let (value, slope) = (x * (x.exp() - 1.0), x.exp() - 1.0 + x * x.exp());
            x -= (value - p * (e - 1.0) / p0) / slope;
        }
        c * (x - 1.0)
    };
    for (law, closed) in [
        ("linear\n 0.1,", 0.01),
        ("exponential\n 0.01, 2e-3", exponential(2e-3, 0.01)),
        ("exponential\n 0.01, 1e-4", exponential(1e-4, 0.01)),
        ("tabular\n 0., 0.\n 5e-4, 0.004\n 2e-3, 0.006", 0.004 + 0.002 / 3.0),
        ("tabular\n 0., -0.01\n 5e-4, 0.\n 7e-4, 0.002", 0.005),
    ] {
        let ran = run_disc(2, 0.0, &format!("*Surface Behavior, pressure-overclosure={law}\n"), p, "");
        let foot = -point_field(ran.end(), "U")[1];
        println!("{law:?}: closed by {foot:.9} ({closed:.9}), drift {:.1e}", ran.outcome.energy.drift);
        assert!((foot / closed - 1.0).abs() < 5e-6, "{law}: {foot} {closed}");
    }
}
