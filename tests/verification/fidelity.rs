//! The kept scenes of the ladder of fidelity against each other (`docs/fidelity.md`).

use revolve::job;
use revolve::output::HistorySummary;
use revolve::user::Routines;

use crate::common;

fn shoot(deck: &str, settings: &[(&str, &str)]) -> HistorySummary {
    let prepared = job::prepare(&common::project(deck), &common::pairs(settings), &Routines::none());
    assert!(!prepared.diagnostics.has_errors(), "{}", prepared.diagnostics.render(&prepared.deck.sources));
    let (outcome, history) = job::run_in_memory(&prepared);
    assert!(outcome.halt.is_none(), "{:?}", outcome.halt);
    assert!(outcome.energy.drift < 1e-4, "{:?}", outcome.energy);
    history
}

/// A projectile of steel that cannot yield is nearly rigid: the strain at the stresses of its deceleration, 1.4 GPa over
/// 200 GPa, shortens it by some tenths of a millimetre while it is stopped. Both have eight facets along the nose, so
/// that their noses are the same. Reached: 0.02 %.
#[test]
fn an_elastic_projectile_goes_as_deep_as_a_rigid_one() {
    let law = [("V", "821."), ("B", "0.9830"), ("C", "0.9402")];
    let rigid = shoot("input/ogive.inp", &[&law[..], &[("n", "8")]].concat()).0["U2@REF"].last;
    let elastic = [("nn", "8"), ("ns", "20"), ("JCA", "1.e12"), ("JCB", "0."), ("JCC", "0.")];
    let history = shoot("input/ogive_steel.inp", &[&law[..], &elastic].concat());
    let depth = history.0["U2@TIP"].min;
    assert!((depth / rigid - 1.0).abs() < 3e-3, "{depth} {rigid}");
    assert_eq!(history.0["ALLPD"].last, 0.0);

    // Steel of hardness Rc 30 yields under a resistance above its yield stress, and stops earlier.
    let soft = shoot("input/ogive_steel.inp", &[&law[..], &[("nn", "8"), ("ns", "20")]].concat());
    assert!(soft.0["U2@TIP"].min > 0.97 * depth && soft.0["ALLPD"].last > 10.0, "{:?}", soft.0["U2@TIP"]);
}
