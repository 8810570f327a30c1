//! Only requested effects exist: cards without influence change no bit, and deleting a card deletes its ledger row.

use revolve::job;
use revolve::solve::{self, Outcome};
use revolve::user::Routines;

use crate::common::{self, RecordedOutput};

fn digest(outcome: &Outcome) -> (u64, u64, u64) {
    let rest = &outcome.rests[0];
    (outcome.increments, rest.time.to_bits(), rest.displacement.to_bits())
}

#[test]
fn cards_without_influence_change_no_bit() {
    let plain = digest(&common::run(&common::ogive(), &[], &Routines::none()).0);
    let without_output = common::ogive().split("*Output, field").next().expect("a deck").to_owned() + "*End Step\n";
    let more_output =
        common::ogive().replace("*End Step", "*Output, history, frequency=3\n*Energy Output\n ALLKE\n*End Step");
    let zero_load =
        common::ogive().replace("*Output, field", "*Cload\n REF, 2, 0.\n*Dsload\n NOSE, P, 0.\n*Output, field");
    let held = common::ogive().replace("*Step,", "*Boundary\n REF, 1, 1\n REF, 6, 6\n*Step,");
    for text in [without_output, more_output, zero_load, held] {
        assert_eq!(digest(&common::run(&text, &[], &Routines::none()).0), plain);
    }
}

#[test]
fn deleting_a_card_deletes_its_ledger_row() {
    let rows = |text: &str, settings: &[(&str, &str)]| {
        let ledger = common::prepared(text, settings, &Routines::none()).plan.ledger;
        ledger.effects.iter().map(|r| r.effect.clone()).collect::<Vec<_>>()
    };
    let full = rows(&common::ogive(), &[("friction", "0.1")]);
    assert!(full.contains(&"friction".to_owned()) && full.contains(&"target".to_owned()));
    let smooth = rows(&common::ogive(), &[]);
    assert_eq!(full.iter().filter(|r| *r != "friction").cloned().collect::<Vec<_>>(), smooth);
    let free = common::ogive().replace("*Dsload, target=BLOCK, friction=<friction>\n NOSE, CAVITY\n", "");
    for effect in ["cavity expansion", "target", "friction", "load velocity"] {
        assert!(!rows(&free, &[]).contains(&effect.to_owned()), "{effect}");
    }
}

#[test]
fn results_do_not_depend_on_units() {
    // mm, t, s: lengths x 1e3, masses x 1e-3, stresses x 1e-6, densities x 1e-12.
    let settings = [("V", "569e3"), ("a", "3.555"), ("mass", "0.021e-3"), ("Y", "276."), ("rho", "2710e-12")];
    let text = common::ogive().replace("AL6061, 0.5", "AL6061, 500.");
    let (si, _) = common::run(&common::ogive(), &[], &Routines::none());
    let (mm, _) = common::run(&text, &settings, &Routines::none());
    let ratio = mm.rests[0].displacement / si.rests[0].displacement / 1e3;
    assert!((ratio - 1.0).abs() < 1e-12, "{ratio}");
}

#[test]
fn steps_continue_and_replace_loads() {
    let second = "*End Step\n*Step\n*Dynamic, Explicit\n , 1.e-4\n*Cload\n REF, 2, 100.\n*End Step\n";
    let text = common::ogive()
        .replace("*End Step\n", second)
        .replace(" NOSE, CAVITY\n", " NOSE, CAVITY\n*Cload\n REF, 2, 50.\n");
    let at_end = |text: &str| {
        let prepared = common::prepared(text, &[], &Routines::none());
        solve::run(&prepared.plan, prepared.state, &mut RecordedOutput::default()).1.loads.len()
    };
    assert_eq!(at_end(&text), 2, "the resistance remains, the force is replaced");
    let cleared = text.replace("*Cload\n REF, 2, 100.", "*Dsload, op=NEW\n NOSE, P, 1.\n*Cload, op=NEW\n REF, 2, 100.");
    assert_eq!(at_end(&cleared), 2, "pressure and force only");
}

/// `*NFILL` pairs nodes by number, independent of their order in the deck; an increment too short to complete a step is
/// an error.
#[test]
fn nodes_are_paired_by_number_and_endless_steps_are_errors() {
    let text = common::ogive()
        + "*Node, nset=LOW\n 901, 0., 1.\n 902, 1., 1.\n*Node, nset=HIGH\n 922, 1., 3.\n 921, 0., 3.\n*Nfill, nset=BETWEEN\n LOW, HIGH, 2, 10\n";
    let prepared = common::prepared(&text, &[], &Routines::none());
    let mesh = &prepared.plan.mesh;
    for (name, r) in [("911", 0.0), ("912", 1.0)] {
        let at = mesh.node_names.iter().position(|n| n == name).expect("a node between");
        assert_eq!(mesh.points[at], [r, 2.0], "{name}");
    }
    let endless = common::ogive()
        .replace("*Dynamic, Explicit\n , 1.e-3", "*Dynamic, Explicit, direct user control\n 1.e-30, 1.e-3");
    let refused = job::prepare_text("case.inp", &endless, &[], &Routines::none());
    assert!(refused.diagnostics.iter().any(|d| d.code == "M103" && d.message.contains("more than the allowed")));
}
