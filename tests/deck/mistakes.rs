//! Typical mistakes of analysts, one per deck: each gives one message, at its place, with the cure. Trivial deviations
//! are accepted.
//!
//! Goal: one cause, one message. Source: a small deck and a list of mistakes; the messages are in the snapshots.

use revolve::job::{self, PreparedJob};
use revolve::user::Routines;

/// A bar that hits a rigid wall.
const BAR: &str = "*Heading
 bar
*Parameter
length = 2.
*Node, nset=FOOT
 1, 0., 0.
 2, 1., 0.
*Node, nset=TOP
 11, 0., <length>
 12, 1., <length>
*Nfill, nset=BAR
 FOOT, TOP, 2, 5
*Element, type=CAX4R
 1, 1, 2, 7, 6
*Elgen, elset=BAR
 1, 1, 1, 1, 2, 5, 1
*Elset, elset=UPPER
 2,
*Surface, name=END
 UPPER, S3
*Solid Section, elset=BAR, material=METAL
*Material, name=METAL
*Density
 1.,
*Elastic
 100., 0.3
*Plastic
 0.5, 0.
 2., 1.
*Initial Conditions, type=VELOCITY
 BAR, 2, -1.
*Step, name=Impact
*Dynamic, Explicit
 , 0.1
*Boundary
 FOOT, 2, 2
*Output, field, number interval=2
*Node Output
 U
*Element Output
 S, PEEQ
*Output, history, number interval=2
*Node Output, nset=TOP
 U2
*End Step
";

fn prepared(text: &str) -> PreparedJob {
    job::prepare_text("bar.inp", text, &[], &Routines::none())
}

/// Returns the bar deck with changes `from => to`, separated by `;;`.
fn changed(changes: &str) -> String {
    changes.split(";;").fold(BAR.to_owned(), |text, change| {
        let (from, to) = change.trim().split_once("=>").expect("a change");
        let plain = |s: &str| s.trim_matches(' ').replace("\\n", "\n");
        let (from, to) = (plain(from), plain(to));
        assert!(text.contains(&from), "`{change}` finds nothing");
        text.replacen(&from, &to, 1)
    })
}

/// Mistakes that are errors: name of the snapshot, change, number of errors.
const WRONG: &[(&str, &str, usize)] = &[
    ("keyword", "*Elastic => *Elastc", 1),
    ("comment_with_one_star", "*Parameter\\n => * units: m, kg\\n*Parameter\\n", 1),
    ("parameter", "BAR, material=METAL => BAR, materail=METAL", 1),
    ("material_name", "material=METAL => material=METALL", 1),
    ("node_set_name", " FOOT, 2, 2 => FEET, 2, 2", 1),
    ("node_set_for_elements", "*Element Output => *Element Output, elset=TOP", 1),
    ("density", "1.,\\n*Elastic => -1.,\\n*Elastic", 1),
    ("poisson", "100., 0.3 => 100., 0.5", 1),
    ("clockwise", "1, 1, 2, 7, 6 => 1, 6, 7, 2, 1", 1),
    ("negative_radius", "2, 1., 0. => 2, -1., 0. ;; 12, 1., => 12, -1.,", 1),
    ("no_area", "2, 1., 0. => 2, 0., 0. ;; 12, 1., => 12, 0.,", 1),
    ("node_twice", "*Element, type => *Node\\n 7, 0., 0.\\n*Element, type", 1),
    ("missing_node", "1, 1, 2, 7, 6 => 1, 1, 2, 99, 6", 1),
    ("too_few_nodes", "1, 1, 2, 7, 6 => 1, 1, 2, 7", 1),
    ("node_in_letters", " 1, 0., 0. => 1, zero, 0.", 1),
    ("undefined_parameter", "11, 0., <length> => 11, 0., <lenght>", 1),
    ("element_type", "CAX4R => C3D8R", 1),
    ("element_type_of_shells", "CAX4R => CPS4R ;; *Boundary => *Boundary\\n FOOT, 3, 3", 1),
    (
        "missing_include",
        "*Solid => *Include, input=nope.inc\\n*Solid ;; *Output, history => *Dsload\\n NOWHERE, P, 1.\\n*Output, history",
        1,
    ),
    ("decimal_comma", "100., 0.3 => 100,5, 0,3", 1),
    ("no_comma", "100., 0.3 => 100. 0.3", 1),
    ("letter_in_number", "1.,\\n*Elastic => 1O.,\\n*Elastic", 1),
    (
        "rate_of_zero",
        "*Plastic\\n 0.5, 0.\\n 2., 1. => *Plastic, hardening=JOHNSON COOK\\n 0.5, 0.1, 0.31\\n*Rate Dependent, type=JOHNSON COOK\\n 0.02, 0.",
        1,
    ),
    ("negative_exponent", "*Plastic\\n 0.5, 0.\\n 2., 1. => *Plastic, hardening=JOHNSON COOK\\n 0.5, 0.1, -0.31", 1),
    ("no_step", "*Step, name=Impact\\n =>", 1),
    ("comment_of_another_program", "*Plastic => $ yield stress\\n# hardening\\n*Plastic", 1),
    ("increment_of_elgen", "*Elgen, elset=BAR\\n 1, 1, 1, 1, 2, 5, 1 => *Elgen, elset=BAR\\n 1, 1, 1, 1, 2, 1, 1", 1),
    ("plastic_from_above_zero", "0.5, 0. => 0.5, 0.1", 1),
    ("plastic_descends", "2., 1. => 2., 1.\\n 3., 0.5", 1),
    ("no_density", "*Density\\n 1.,\\n =>", 1),
    ("no_section", "*Solid Section, elset=BAR, material=METAL\\n =>", 1),
    ("no_procedure", "*Dynamic, Explicit\\n , 0.1 => *Static\\n 0.1, 1.", 1),
    ("implicit", "*Dynamic, Explicit => *Dynamic", 1),
    ("time_in_the_first_field", ", 0.1 => 0.1", 1),
    ("contact_below_nothing", "*Output, field => *Contact Inclusions, ALL EXTERIOR\\n*Output, field", 1),
    ("face", "UPPER, S3 => UPPER, S5 ;; *Output, field => *Dsload\\n END, P, 1.\\n*Output, field", 1),
    ("amplitude", "*Boundary => *Boundary, amplitude=RAMP", 1),
    (
        "consequences_of_one_initiation",
        "*Density => *Damage Initiation, criterion=SHEAR\\n 1., 0., 0.\\n*Damage Evolution, type=ENERGY\\n 1.,\\n*Density",
        1,
    ),
    (
        "consequences_of_one_surface",
        "*Step, name => *Surface, name=SKIN\\n BAR, S9\\n*Contact\\n*Contact Inclusions\\n SKIN,\\n*Step, name",
        1,
    ),
    ("three_at_once", "material=METAL => material=METALL ;; *Elastic => *Elastc ;; FOOT, 2, 2 => FEET, 2, 2", 3),
    ("a_name_and_a_material", "*Density\\n 1.,\\n => ;; nset=TOP\\n U2 => nset=TIP\\n U2", 2),
];

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

/// Mistakes that give a warning.
const DOUBTFUL: &[(&str, &str)] = &[
    ("output_variables", "S, PEEQ => S, PEQQ, VONMISES"),
    ("faster_than_sound", "BAR, 2, -1. => BAR, 2, -1000."),
    ("endless", ", 0.1 => , 1.e11"),
    ("given_increment", "Explicit\\n , 0.1 => Explicit, direct user control\\n 0.1, 0.1"),
    ("nothing_acts", "*Boundary\\n FOOT, 2, 2\\n =>"),
    ("yield_stress_of_zero", "0.5, 0.\\n => 0., 0.\\n"),
    ("softening_from_the_start", "2., 1.\\n => 0.2, 1.\\n"),
    (
        "exchanged_exponents",
        "*Plastic\\n 0.5, 0.\\n 2., 1. => *Plastic, hardening=JOHNSON COOK\\n 0.5, 0.1, 1.09, 0.31, 1356., 298.",
    ),
    (
        "exchanged_temperatures",
        "*Plastic\\n 0.5, 0.\\n 2., 1. => *Plastic, hardening=JOHNSON COOK\\n 0.5, 0.1, 0.31, 1.09, 298., 1356.",
    ),
    (
        "initially_molten",
        "*Plastic\\n 0.5, 0.\\n 2., 1. => *Plastic, hardening=JOHNSON COOK\\n 0.5, 0.1, 0.31, 1.09, 1356., 298. ;; *Initial Conditions, type=VELOCITY => *Initial Conditions, type=TEMPERATURE\\n BAR, 1400.\\n*Initial Conditions, type=VELOCITY",
    ),
    (
        "rate_constant",
        "*Plastic\\n 0.5, 0.\\n 2., 1. => *Plastic, hardening=JOHNSON COOK\\n 0.5, 0.1, 0.31\\n*Rate Dependent, type=JOHNSON COOK\\n 25., 1.",
    ),
    (
        "sign_of_d3",
        "2., 1.\\n => 2., 1.\\n*Damage Initiation, criterion=JOHNSON COOK\\n 0.5, 3.4, -2.1, 0., 0., 0., 0., 1.\\n*Damage Evolution, type=DISPLACEMENT\\n 0.1,\\n",
    ),
    (
        "no_triaxiality",
        "2., 1.\\n => 2., 1.\\n*Damage Initiation, criterion=JOHNSON COOK\\n 0.05, 3.44\\n*Damage Evolution, type=DISPLACEMENT\\n 0.1,\\n",
    ),
    ("adiabatic_without_heat", "*Dynamic, Explicit => *Dynamic, Explicit, adiabatic"),
    (
        "cold_start",
        "*Plastic\\n 0.5, 0.\\n 2., 1. => *Plastic, hardening=JOHNSON COOK\\n 0.5, 0.1, 0.31, 1.09, 1356., 298.\\n*Specific Heat\\n 0.01,\\n*Inelastic Heat Fraction\\n 0.9, ;; *Dynamic, Explicit => *Dynamic, Explicit, adiabatic",
    ),
    (
        "specific_heat_of_other_units",
        "1.,\\n*Elastic\\n 100., 0.3 => 7850.,\\n*Elastic\\n 2.1e11, 0.3\\n*Specific Heat\\n 4.6e8,",
    ),
    ("bulk_viscosity_of_60", "*Output, field => *Bulk Viscosity\\n 60., 1.2\\n*Output, field"),
    ("mass_factor", "*Output, field => *Fixed Mass Scaling, factor=1.e6\\n*Output, field"),
    ("interval_longer_than_the_step", "*Output, history, number interval=2 => *Output, history, time interval=1."),
    ("lost_support", "FOOT, 2, 2 => FOOT, 3, 3"),
    ("element_set_for_nodes", "*Nfill, nset=BAR => *Nfill"),
    (
        "overlap",
        "*Elset, elset=UPPER => *Node\\n 91, 0.2, 0.2\\n 92, 0.8, 0.2\\n 93, 0.8, 0.8\\n 94, 0.2, 0.8\\n*Element, type=CAX4R, elset=BAR\\n 9, 91, 92, 93, 94\\n*Elset, elset=UPPER",
    ),
    (
        "plane_that_faces_away",
        "FOOT, 2, 2 => 99, 1, 6 ;; *Step, name => *Node\\n 99, 0., 0.\\n*Surface, name=WALL, type=SEGMENTS\\n START, 2., 0.\\n LINE, 0., 0.\\n\
         *Rigid Body, ref node=99, analytical surface=WALL\\n*Surface, name=NOSE, type=NODE\\n FOOT,\\n*Surface Interaction, name=I\\n\
         *Contact Pair, interaction=I\\n WALL, NOSE\\n*Step, name",
    ),
];

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

/// Deviations that are accepted without a message or with a ledger entry.
const TRIFLES: &[(&str, &str)] = &[
    ("", "length = 2. => length = 1.; length = 2*length"),
    ("PREPRINT", "*Heading => *Preprint, echo=NO, model=NO\\n*Heading"),
    ("MONITOR", "*Output, field => *Monitor, node=1, dof=2\\n*Output, field"),
    ("DIAGNOSTICS", "*Output, field => *Diagnostics, cutback=YES\\n*Output, field"),
    ("FILTER", "*Solid => *Filter, name=F, type=BUTTERWORTH\\n 100.\\n*Solid"),
    ("OUTPUT, FILTER", "*Output, history => *Output, history, filter=F"),
    ("", "*Boundary => *Boundary\\n LATER, 1, 1\\n*Nset, nset=LATER\\n 11,\\n*Boundary"),
    (
        "",
        "*Solid Section, elset=BAR, material=METAL\\n => ;; *Heading => *Solid Section, elset=BAR, material=METAL\\n*Heading",
    ),
    ("", "*Step, name => *Restart, write, number interval=1\\n*Step, name"),
    ("", "*Plastic => *Damping, alpha=0., beta=0.\\n*Plastic"),
    (
        "SOLID SECTION, ORIENTATION",
        "*Solid Section, elset=BAR => *Orientation, name=O\\n 1., 0., 0., 0., 1., 0.\\n*Solid Section, elset=BAR, orientation=O",
    ),
    ("S13 of an output request", "S, PEEQ => S, S13"),
];

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
