//! Typical mistakes of analysts, one per deck: each gives one message, at its place, with the cure. Trivial deviations
//! are accepted.
//!
//! Goal: one cause, one message. Source: a small deck and a list of mistakes; the messages are in the snapshots.

use revolve::job::{self, PreparedJob};
use revolve::user::Routines;

use crate::common::faulty_decks::{DOUBTFUL, TRIFLES, WRONG, changed};

fn prepared(text: &str) -> PreparedJob {
    job::prepare_text("bar.inp", text, &[], &Routines::none())
}

#[test]
fn one_cause_has_one_message_with_a_place() {
    for (name, change, count) in WRONG {
        let prepared = prepared(&changed(change));
        let text = prepared.diagnostics.render(&prepared.deck.sources);
        assert_eq!(prepared.diagnostics.error_count(), *count, "{name}:\n{text}");
        assert!(prepared.diagnostics.iter().all(|d| !d.labels.is_empty()), "{name} has no place:\n{text}");
        insta::assert_snapshot!(format!("mistake_{name}"), text);
    }
}

#[test]
fn doubtful_input_gives_a_warning() {
    for (name, change) in DOUBTFUL {
        let prepared = prepared(&changed(change));
        let text = prepared.diagnostics.render(&prepared.deck.sources);
        assert_eq!(prepared.diagnostics.error_count(), 0, "{name}:\n{text}");
        assert_eq!(prepared.diagnostics.iter().count(), 1, "{name}:\n{text}");
        insta::assert_snapshot!(format!("doubt_{name}"), text);
    }
}

/// Input files of LS-DYNA and OpenRadioss are recognised: one message instead of one per keyword.
#[test]
fn input_files_of_other_programs_are_recognised() {
    for text in [
        "$# LS-DYNA\n*KEYWORD\n*CONTROL_TERMINATION\n 1.\n*END\n",
        "#RADIOSS STARTER\n/BEGIN\n/NODE\n",
        "# text\n/BEGIN\n",
    ] {
        let prepared = prepared(text);
        let codes: Vec<&str> = prepared.diagnostics.iter().map(|d| d.code).collect();
        assert_eq!(codes, ["D010"], "{}", prepared.diagnostics.render(&prepared.deck.sources));
    }
}

/// A coordinate of one node has a wrong power of ten: its elements are much longer than the others.
#[test]
fn node_far_from_the_others_gives_a_warning() {
    let deck = |far: f64| {
        let place = |i: usize, j: usize| [i as f64, if (i, j) == (2, 9) { far } else { j as f64 }];
        crate::common::solid::grid(2, 9, false, place)
            + &crate::common::solid::material(1.0, 0.3, 1.0, "")
            + "*Step\n*Dynamic, Explicit\n , 1.\n*Boundary\n J0, 2, 2\n*End Step\n"
    };
    let codes = |far: f64| -> Vec<&str> { prepared(&deck(far)).diagnostics.iter().map(|d| d.code).collect() };
    assert_eq!((codes(9.0), codes(9000.0)), (vec![], vec!["P144"]));
}

/// A parameter without a value, or with a fraction where whole numbers follow from it, gives one message at its cause. Other
/// parameters and fields follow from it.
#[test]
fn a_wrong_parameter_gives_one_message() {
    let deck = |parameters: &str| {
        "*Parameter\n".to_owned()
            + parameters
            + "*Node\n 1, 0., 0.\n <corner>, 1., 0.\n <top>, 0., 2.\n <last>, 1., 2.\n*Ngen, nset=FOOT\n 1, <corner>, 1\n\
               *Ngen, nset=TOP\n <top>, <last>, 1\n*Nfill, nset=BAR\n FOOT, TOP, <n>, <corner>\n*Element, type=CAX4R\n 1, 1, 2, 7, 6\n\
               *Elset, elset=BAR\n 1\n"
            + "*Solid Section, elset=BAR, material=M\n*Material, name=M\n*Density\n 1.,\n*Elastic\n 100., 0.3\n\
               *Step\n*Dynamic, Explicit\n , 1.\n*End Step\n"
    };
    for (parameters, code, place, words) in [
        ("n = 4\ncorner = row\nrow = 5\ntop = 1 + n*corner\nlast = top + 4\n", "D402", "row", "`row` is not defined"),
        ("n = 4.5\ncorner = 5\ntop = 2 + n*corner\nlast = top + 4\n", "D304", "<top>", "parameter `n` is 4.5"),
    ] {
        let prepared = prepared(&deck(parameters));
        let text = prepared.diagnostics.render(&prepared.deck.sources);
        let found: Vec<_> = prepared.diagnostics.iter().collect();
        assert_eq!(found.len(), 1, "{text}");
        assert_eq!((found[0].code, prepared.deck.sources.text(found[0].labels[0].span)), (code, place), "{text}");
        assert!(text.contains(words), "{text}");
    }
}

/// A boundary condition on the set of the whole body instead of its foot holds it in spite of its initial velocity.
#[test]
fn fixed_nodes_with_an_initial_velocity_give_a_warning() {
    let deck = |held: &str| {
        crate::common::solid::grid(2, 4, false, |i, j| [i as f64, j as f64])
            + &crate::common::solid::material(1.0, 0.3, 1.0, "")
            + "*Elset, elset=ALL\n 1\n*Initial Conditions, type=VELOCITY\n ALL, 2, -1.\n*Step\n*Dynamic, Explicit\n , 1.\n*Boundary\n "
            + held
            + ", 2, 2\n*End Step\n"
    };
    for (held, codes) in [("J0", vec![]), ("ALL", vec!["P145"])] {
        let prepared = prepared(&deck(held));
        let found: Vec<&str> = prepared.diagnostics.iter().map(|d| d.code).collect();
        let text = prepared.diagnostics.render(&prepared.deck.sources);
        assert_eq!(found, codes, "{text}");
        assert!(
            held == "J0" || text.contains("fixes all these nodes") && text.contains("element set of the same name"),
            "{text}"
        );
    }
}

#[test]
fn harmless_deviations_are_accepted() {
    for (message_text, change) in TRIFLES {
        let prepared = prepared(&changed(change));
        let text = prepared.diagnostics.render(&prepared.deck.sources);
        assert!(prepared.diagnostics.is_empty(), "{change}:\n{text}");
        let unused = &prepared.plan.ledger.unused;
        assert!(
            message_text.is_empty() || unused.iter().any(|u| u.what == format!("*{message_text}")),
            "{change}: {unused:?}"
        );
    }
}

/// A request that never writes output, and one that writes at given times.
#[test]
fn outputs_are_written_at_requested_times() {
    use revolve::plan::WriteSchedule;
    let never = prepared(&changed("*Output, field, number interval=2 => *Output, field, frequency=0"));
    assert!(never.diagnostics.is_empty() && never.plan.steps[0].outputs.field.is_empty());
    let points = "*Output, field, number interval=2 => *Output, field, time points=P ;; *Step, name => *Time Points, name=P\\n 0.01, 0.07\\n*Step, name";
    let points = prepared(&changed(points));
    assert!(points.diagnostics.is_empty());
    assert_eq!(points.plan.steps[0].outputs.field, [WriteSchedule::Points([0.01, 0.07].into())]);
}

/// A path of another computer is replaced by the file of that name in the deck's folder.
#[test]
fn foreign_path_falls_back_to_its_file_name() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("metal.inc"), "*Density\n 1.,\n").expect("a file");
    let text = changed("*Density\\n 1.,\\n => *Include, input=C:\\work\\metal.inc\\n");
    let name = folder.path().join("bar.inp").display().to_string();
    let prepared = job::prepare_text(&name, &text, &[], &Routines::none());
    let codes: Vec<_> = prepared.diagnostics.iter().map(|d| d.code).collect();
    assert_eq!(codes, ["D008"]);
}
