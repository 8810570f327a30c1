//! A bar that hits a rigid wall, and changes of its deck: mistakes, doubtful input and harmless deviations.

/// A bar that hits a rigid wall.
pub const BAR: &str = "*Heading
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

/// Returns the bar deck with changes `from => to`, separated by `;;`.
pub fn changed(changes: &str) -> String {
    changes.split(";;").fold(BAR.to_owned(), |text, change| {
        let (from, to) = change.trim().split_once("=>").expect("a change");
        let plain = |s: &str| s.trim_matches(' ').replace("\\n", "\n");
        let (from, to) = (plain(from), plain(to));
        assert!(text.contains(&from), "`{change}` finds nothing");
        text.replacen(&from, &to, 1)
    })
}

/// Mistakes that are errors: name of the snapshot, change, number of errors.
pub const WRONG: &[(&str, &str, usize)] = &[
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

/// Mistakes that give a warning.
pub const DOUBTFUL: &[(&str, &str)] = &[
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
        "1.,\\n*Elastic\\n 100., 0.3 => 7850.,\\n*Elastic\\n 2.1e11, 0.3\\n*Specific Heat\\n 4.6e8, ;; 0.5, 0.\\n 2., 1. => 3.e8, 0.\\n 8.e8, 1.",
    ),
    (
        "yield_of_other_units",
        "1.,\\n*Elastic\\n 100., 0.3 => 7850.,\\n*Elastic\\n 2.1e11, 0.3 ;; 0.5, 0.\\n 2., 1. => 300., 0.\\n 800., 1.",
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

/// Deviations that are accepted without a message or with a ledger entry.
pub const TRIFLES: &[(&str, &str)] = &[
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
