//! A yielding rod in a cavity-expansion target (`input/ogive_rod.inp`, mesh of `revolve mesh`).
//!
//! Goal: without yielding the depth is that of the rigid body; with the yield stress of the steel the rod stops earlier
//! and shortens, and the energy balance closes. The tolerance and its reason are stated at each test.

use revolve::job;
use revolve::output::HistorySummary;
use revolve::user::Routines;

use crate::common;

fn run_shot(deck: &str, settings: &[(&str, &str)]) -> (HistorySummary, f64) {
    let prepared = job::prepare(&common::project(deck), &common::pairs(settings), &Routines::none());
    assert!(!prepared.diagnostics.has_errors(), "{}", prepared.diagnostics.render(&prepared.deck.sources));
    let (outcome, history) = job::run_in_memory(&prepared);
    assert!(outcome.halt.is_none(), "{:?}", outcome.halt);
    (history, outcome.energy.drift)
}

fn rigid_depth(velocity: &str) -> f64 {
    -run_shot("input/ogive.inp", &[("V", velocity), ("B", "0.9830"), ("C", "0.9402")]).0.0["U2@REF"].last
}

/// Ten times the yield stress of VAR 4340: the rod stays elastic and the depth is the rigid one within 1 %. Reached:
/// 0.1 % at both velocities. The rest is the polygonal nose and the elastic shortening during deceleration.
#[test]
fn elastic_rod_reaches_the_rigid_depth() {
    for velocity in ["300.", "569."] {
        let (history, drift) = run_shot("input/ogive_rod.inp", &[("V", velocity), ("Ys", "11.24e9")]);
        let (depth, rigid) = (-history.0["U2@TIP"].min, rigid_depth(velocity));
        println!("{velocity} m/s: {depth} rigid {rigid}, drift {drift:.1e}");
        assert!((depth / rigid - 1.0).abs() < 0.01, "{depth} {rigid}");
        assert_eq!(history.0["ALLPD"].last, 0.0);
        assert!(drift < 3e-4, "{drift}");
    }
}

/// With its own yield stress the rod stops earlier than the rigid body, and shortens and swells more with increasing
/// velocity. The energy drift is below 3e-4 and the hourglass energy below 1 % of the plastic dissipation.
#[test]
fn yielding_rod_stops_earlier_and_shortens() {
    let mut before = [0.0; 2];
    for (velocity, least, most) in [("569.", 0.92, 0.97), ("966.", 0.86, 0.95)] {
        let (history, drift) = run_shot("input/ogive_rod.inp", &[("V", velocity)]);
        let last = |column: &str| history.0[column].last;
        let ratio = -history.0["U2@TIP"].min / rigid_depth(velocity);
        let shorter = [last("U2@TIP") - last("U2@BACK"), history.0["U1@SHOULDER"].max].map(f64::abs);
        println!("{velocity} m/s: {ratio:.3} of the rigid depth, shorter and wider by {shorter:?}, drift {drift:.1e}");
        assert!(ratio > least && ratio < most, "{ratio}");
        assert!(shorter[0] > before[0] && shorter[1] > before[1] && shorter[0] > 0.5e-3, "{shorter:?} {before:?}");
        assert!(drift < 3e-4 && last("ALLAE").abs() < 0.01 * last("ALLPD"), "{drift} {:?}", history.0["ALLAE"]);
        before = shorter;
    }
}

/// The resistance law of the shank has little influence at 569 m/s. An elastic wall and no resistance give depths within
/// 0.5 %. The full law, which a vibrating shank meets at any velocity, gives 3 % less (2.7 %; 3.0 % with a tenth of the
/// increment). A free shank bulges most.
#[test]
fn shank_resistance_has_little_influence_on_depth() {
    let laws = [["0.", "0."], ["0.", "19.35"], ["5.0394", "0.9830"]];
    let [unloaded, wall, whole] = laws.map(|[a, b]| {
        let (history, _) = run_shot("input/ogive_rod.inp", &[("V", "569."), ("WA", a), ("WB", b), ("WC", "0.")]);
        println!("{a} {b}: {:?} {:?}", history.0["U2@TIP"].min, history.0["U1@SHOULDER"].max);
        [-history.0["U2@TIP"].min, history.0["U1@SHOULDER"].max]
    });
    assert!((unloaded[0] / wall[0] - 1.0).abs() < 0.005, "{unloaded:?} {wall:?}");
    let ratio = whole[0] / wall[0];
    assert!(ratio > 0.965 && ratio < 0.98, "{whole:?} {wall:?}");
    assert!(unloaded[1] > wall[1] && unloaded[1] > whole[1], "{unloaded:?} {wall:?} {whole:?}");
}
