//! Pinned scenes of `docs/fidelity.md`, which compares models of different fidelity.

use revolve::job;
use revolve::output::HistorySummary;
use revolve::user::Routines;

use crate::common;

fn run_shot(deck: &str, settings: &[(&str, &str)]) -> HistorySummary {
    let prepared = job::prepare(&common::project(deck), &common::pairs(settings), &Routines::none());
    assert!(!prepared.diagnostics.has_errors(), "{}", prepared.diagnostics.render(&prepared.deck.sources));
    let (outcome, history) = job::run_in_memory(&prepared);
    assert!(outcome.halt.is_none(), "{:?}", outcome.halt);
    assert!(outcome.energy.drift < 1e-4, "{:?}", outcome.energy);
    history
}

/// An elastic steel projectile is nearly rigid: the stresses of its deceleration, 1.4 GPa over 200 GPa, shorten it by
/// some tenths of a millimetre. Both models have eight facets along the nose. Reached: 0.02 %.
#[test]
fn elastic_projectile_reaches_the_rigid_depth() {
    let law = [("V", "821."), ("B", "0.9830"), ("C", "0.9402")];
    let rigid = run_shot("input/ogive.inp", &[&law[..], &[("n", "8")]].concat()).0["U2@REF"].last;
    let elastic = [("nn", "8"), ("ns", "20"), ("JCA", "1.e12"), ("JCB", "0."), ("JCC", "0.")];
    let history = run_shot("input/ogive_steel.inp", &[&law[..], &elastic].concat());
    let depth = history.0["U2@TIP"].min;
    assert!((depth / rigid - 1.0).abs() < 3e-3, "{depth} {rigid}");
    assert_eq!(history.0["ALLPD"].last, 0.0);

    // Steel of hardness Rc 30 yields, because the resistance exceeds its yield stress, and stops earlier.
    let soft = run_shot("input/ogive_steel.inp", &[&law[..], &[("nn", "8"), ("ns", "20")]].concat());
    assert!(soft.0["U2@TIP"].min > 0.97 * depth && soft.0["ALLPD"].last > 10.0, "{:?}", soft.0["U2@TIP"]);
}
