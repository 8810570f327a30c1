//! The one keyword table: parser, `explain` and the keyword manual all read it.
//! Never here: what a card does.

/// What is done with a keyword.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tier {
    /// Parsed and used.
    Used,
    /// Changes only output files of another program: accepted, one summary note.
    OutputOnly,
    /// Parsed now; used where the capability is there, otherwise the model says why not.
    Parsed,
    /// Known and not supported; ignoring it would change the physics: an error.
    UnsupportedPhysics,
    /// Known and not supported; ignoring it changes no result: a note.
    UnsupportedInert,
}

/// A parameter that a keyword line may carry.
#[derive(Debug, PartialEq)]
pub struct ParameterRule {
    /// Canonical name, upper case, single blanks.
    pub name: &'static str,
    /// One line for the manual.
    pub help: &'static str,
}

/// One keyword.
#[derive(Debug, PartialEq)]
pub struct Keyword {
    /// Canonical name, upper case, single blanks, no star.
    pub name: &'static str,
    /// What is done with it.
    pub tier: Tier,
    /// Not in ABAQUS: ours.
    pub extension: bool,
    /// One line for the manual.
    pub summary: &'static str,
    /// The parameters it may carry.
    pub parameters: &'static [ParameterRule],
    /// What the data lines say, one line per data line.
    pub data: &'static [&'static str],
}

use Tier::{OutputOnly, Parsed, UnsupportedInert, UnsupportedPhysics, Used};

const fn rule(name: &'static str, help: &'static str) -> ParameterRule {
    ParameterRule { name, help }
}

const fn used(
    name: &'static str,
    summary: &'static str,
    parameters: &'static [ParameterRule],
    data: &'static [&'static str],
) -> Keyword {
    Keyword { name, tier: Used, extension: false, summary, parameters, data }
}

const fn other(name: &'static str, tier: Tier) -> Keyword {
    let summary = match tier {
        OutputOnly => "Changes only output files of another program; accepted.",
        Parsed => "Read; used as capabilities arrive.",
        UnsupportedInert => "Known, not supported; changes no result here.",
        _ => "Known, not supported.",
    };
    Keyword { name, tier, extension: false, summary, parameters: &[], data: &[] }
}

/// The table.
pub const KEYWORDS: &[Keyword] = &[
    used("HEADING", "Title of the analysis.", &[], &["any text"]),
    used(
        "NODE",
        "Nodes by coordinates.",
        &[
            rule("NSET", "put the nodes into this set"),
            rule("INPUT", "not supported here; use *INCLUDE"),
            rule("SYSTEM", "only R (rectangular) is supported"),
        ],
        &["label, r, z"],
    ),
    used(
        "ELEMENT",
        "Elements by their nodes.",
        &[
            rule("TYPE", "RAX2, CAX3, CAX4R or MASS"),
            rule("ELSET", "put the elements into this set"),
            rule("INPUT", "not supported here; use *INCLUDE"),
        ],
        &["label, node 1, node 2, ... (continued on the next line where more are needed)"],
    ),
    used(
        "NSET",
        "A set of nodes.",
        &[
            rule("NSET", "name"),
            rule("GENERATE", "data lines give first, last, increment"),
            rule("INSTANCE", "the instance the labels belong to"),
            rule("INTERNAL", "written by CAE; no effect"),
            rule("ELSET", "the nodes of these elements"),
            rule("UNSORTED", "no effect; sets are kept in ascending order"),
        ],
        &["labels or set names; with GENERATE: first, last, increment (default 1)"],
    ),
    used(
        "ELSET",
        "A set of elements.",
        &[
            rule("ELSET", "name"),
            rule("GENERATE", "data lines give first, last, increment"),
            rule("INSTANCE", "the instance the labels belong to"),
            rule("INTERNAL", "written by CAE; no effect"),
            rule("UNSORTED", "no effect"),
        ],
        &["labels or set names; with GENERATE: first, last, increment (default 1)"],
    ),
    used(
        "NGEN",
        "Nodes between two nodes, on a line or an arc.",
        &[rule("NSET", "put the nodes into this set"), rule("LINE", "C for a circular arc")],
        &["first node, last node, label increment, centre node (or blank and r, z of the centre)"],
    ),
    used(
        "NFILL",
        "Rows of nodes between two bounding sets.",
        &[rule("NSET", "put the nodes into this set"), rule("BIAS", "ratio of neighbouring intervals")],
        &["first set, last set, number of intervals, label increment"],
    ),
    used(
        "ELGEN",
        "Elements by repeating one.",
        &[rule("ELSET", "put the elements into this set"), rule("ALLNODES", "not used by the elements of this code")],
        &[
            "master element, number in a row, node increment, element increment, rows, node increment, element increment",
        ],
    ),
    used("PART", "Begins a part.", &[rule("NAME", "name")], &[]),
    used("END PART", "Ends a part.", &[], &[]),
    used("ASSEMBLY", "Begins the assembly.", &[rule("NAME", "name")], &[]),
    used("END ASSEMBLY", "Ends the assembly.", &[], &[]),
    used(
        "INSTANCE",
        "Places a part.",
        &[
            rule("NAME", "name"),
            rule("PART", "the part"),
            rule("LIBRARY", "not supported"),
            rule("INSTANCE", "not supported"),
        ],
        &["translation r, z, 0", "rotation: point a, point b, angle in degrees"],
    ),
    used("END INSTANCE", "Ends an instance.", &[], &[]),
    used(
        "MATERIAL",
        "Begins a material.",
        &[rule("NAME", "name"), rule("SRATE FACTOR", "no effect"), rule("RTOL", "no effect")],
        &[],
    ),
    used("DENSITY", "Mass per volume.", &[rule("DEPENDENCIES", "not supported")], &["density"]),
    used(
        "ELASTIC",
        "Linear elasticity.",
        &[rule("TYPE", "ISOTROPIC"), rule("DEPENDENCIES", "not supported"), rule("MODULI", "no effect")],
        &["Young's modulus, Poisson's ratio"],
    ),
    used(
        "PLASTIC",
        "Yield stress and hardening.",
        &[
            rule("HARDENING", "ISOTROPIC (tabular) or JOHNSON COOK"),
            rule("DEPENDENCIES", "not supported"),
            rule("RATE", "not supported"),
            rule("SCALESTRESS", "not supported"),
        ],
        &["yield stress, plastic strain, temperature; or A, B, n, m, melting, transition temperature"],
    ),
    used(
        "RATE DEPENDENT",
        "Rate dependence of the yield stress.",
        &[rule("TYPE", "JOHNSON COOK, POWER LAW or YIELD RATIO"), rule("DEPENDENCIES", "not supported")],
        &["C, reference strain rate; or D, n; or ratio, rate"],
    ),
    used(
        "SOLID SECTION",
        "Gives elements a material.",
        &[
            rule("ELSET", "element set"),
            rule("MATERIAL", "material"),
            rule("CONTROLS", "section controls"),
            rule("ORIENTATION", "not supported"),
        ],
        &["blank, or the thickness of a plane element"],
    ),
    used(
        "SECTION CONTROLS",
        "Hourglass and distortion control.",
        &[
            rule("NAME", "name"),
            rule("HOURGLASS", "kind"),
            rule("DISTORTION CONTROL", "yes or no"),
            rule("ELEMENT DELETION", "yes or no"),
            rule("MAX DEGRADATION", "value"),
            rule("KINEMATIC SPLIT", "kind"),
            rule("SECOND ORDER ACCURACY", "yes or no"),
            rule("LENGTH RATIO", "value"),
            rule("VISCOSITY", "value"),
        ],
        &["scale factors"],
    ),
    used(
        "STEP",
        "Begins a step.",
        &[
            rule("NAME", "name"),
            rule("NLGEOM", "always on here"),
            rule("INC", "no effect"),
            rule("PERTURBATION", "not supported"),
            rule("UNSYMM", "no effect"),
            rule("EXTRAPOLATION", "no effect"),
        ],
        &["a subtitle"],
    ),
    used("END STEP", "Ends a step.", &[], &[]),
    used(
        "DYNAMIC",
        "Explicit dynamics by central differences.",
        &[
            rule("EXPLICIT", "required"),
            rule("ADIABATIC", "plastic work heats"),
            rule("ELEMENT BY ELEMENT", "stable increment by elements"),
            rule("SCALE FACTOR", "factor on the automatic increment"),
            rule("DIRECT USER CONTROL", "fixed increment, first data field"),
            rule("FIXED TIME INCREMENTATION", "not supported; use DIRECT USER CONTROL"),
            rule("IMPROVED DT METHOD", "no effect"),
            rule(
                "ACCURACY",
                "(extension) relative error of the motion aimed at where nothing limits the increment; default 1e-4",
            ),
            rule("LOAD VELOCITY", "(extension) PREDICTED (default) or LAGGED, as ABAQUS passes it"),
        ],
        &["increment (with DIRECT USER CONTROL), length of the step"],
    ),
    used("BULK VISCOSITY", "Bulk viscosity of deformable elements.", &[], &["linear, quadratic coefficient"]),
    used(
        "FIXED MASS SCALING",
        "Scales mass at the start of a step.",
        &[
            rule("ELSET", "element set"),
            rule("FACTOR", "factor"),
            rule("DT", "increment aimed at"),
            rule("TYPE", "how"),
        ],
        &[],
    ),
    used(
        "BOUNDARY",
        "Prescribed motion.",
        &[
            rule("AMPLITUDE", "function of time"),
            rule("TYPE", "DISPLACEMENT, VELOCITY or ACCELERATION"),
            rule("OP", "MOD (default) or NEW"),
            rule("LOAD CASE", "no effect"),
            rule("REGION TYPE", "no effect"),
            rule("USER", "not supported"),
            rule("FIXED", "not supported"),
        ],
        &["set or node, first dof, last dof, value; or set, ENCASTRE | PINNED | XSYMM | YSYMM | ZSYMM"],
    ),
    used(
        "AMPLITUDE",
        "A function of time.",
        &[
            rule("NAME", "name"),
            rule("DEFINITION", "TABULAR (default), SMOOTH STEP or EQUALLY SPACED"),
            rule("TIME", "STEP TIME (default) or TOTAL TIME"),
            rule("VALUE", "RELATIVE or ABSOLUTE"),
            rule("FIXED INTERVAL", "interval of EQUALLY SPACED"),
            rule("BEGIN", "first time of EQUALLY SPACED"),
            rule("SMOOTH", "not supported"),
            rule("VARIABLES", "not supported"),
        ],
        &["time, value, time, value, ..."],
    ),
    used(
        "INITIAL CONDITIONS",
        "State at the start.",
        &[rule("TYPE", "VELOCITY, TEMPERATURE or STRESS")],
        &["set or node, dof, velocity; or set, temperature; or set, stresses"],
    ),
    used(
        "CLOAD",
        "Concentrated forces.",
        &[
            rule("AMPLITUDE", "function of time"),
            rule("OP", "MOD (default) or NEW"),
            rule("LOAD CASE", "no effect"),
            rule("REGION TYPE", "no effect"),
            rule("FOLLOWER", "not supported"),
        ],
        &["set or node, dof, force"],
    ),
    used(
        "DLOAD",
        "Distributed loads on elements.",
        &[
            rule("AMPLITUDE", "function of time"),
            rule("OP", "MOD (default) or NEW"),
            rule("LOAD CASE", "no effect"),
            rule("REGION TYPE", "no effect"),
            rule("TARGET", "(extension) target of CAVITY"),
            rule("FRICTION", "(extension) Coulomb coefficient of CAVITY"),
        ],
        &[
            "set or element (blank: whole model), GRAV | P | P1..P4 | PNU | P1NU..P4NU | CAVITY, magnitude, direction of GRAV",
        ],
    ),
    used(
        "DSLOAD",
        "Distributed loads on surfaces.",
        &[
            rule("AMPLITUDE", "function of time"),
            rule("OP", "MOD (default) or NEW"),
            rule("LOAD CASE", "no effect"),
            rule("REGION TYPE", "no effect"),
            rule("FOLLOWER", "no effect"),
            rule("CONSTANT RESULTANT", "not supported"),
            rule("TARGET", "(extension) target of CAVITY"),
            rule("FRICTION", "(extension) Coulomb coefficient of CAVITY"),
        ],
        &["surface, P | PNU | CAVITY, magnitude"],
    ),
    used(
        "SURFACE",
        "A surface of element sides.",
        &[
            rule("NAME", "name"),
            rule("TYPE", "ELEMENT (default) or NODE"),
            rule("INTERNAL", "written by CAE; no effect"),
            rule("COMBINE", "not supported"),
            rule("TRIM", "no effect"),
        ],
        &["element set or element, SPOS | SNEG | S1..S4 (blank: free faces of solids)"],
    ),
    used(
        "RIGID BODY",
        "A rigid body.",
        &[
            rule("REF NODE", "reference node"),
            rule("ELSET", "elements"),
            rule("PIN NSET", "further nodes"),
            rule("TIE NSET", "further nodes"),
            rule("DENSITY", "mass per volume of its RAX2 elements"),
            rule("POSITION", "only INPUT is supported"),
            rule("ISOTHERMAL", "no effect"),
            rule("ANALYTICAL SURFACE", "not supported"),
        ],
        &["thickness of its RAX2 elements"],
    ),
    used(
        "MASS",
        "Mass of elements of TYPE=MASS.",
        &[rule("ELSET", "element set"), rule("ALPHA", "not supported")],
        &["mass"],
    ),
    used(
        "INCLUDE",
        "Reads another file here.",
        &[rule("INPUT", "file, relative to this one"), rule("PASSWORD", "not supported")],
        &[],
    ),
    used(
        "PARAMETER",
        "Names for values, used as <name>.",
        &[rule("INDEPENDENT", "no effect"), rule("DEPENDENT", "no effect"), rule("TABLE", "not supported")],
        &["name = expression"],
    ),
    used(
        "OUTPUT",
        "Output request.",
        &[
            rule("FIELD", "frames"),
            rule("HISTORY", "histories"),
            rule("VARIABLE", "PRESELECT or ALL"),
            rule("FREQUENCY", "every so many increments"),
            rule("NUMBER INTERVAL", "so many over the step"),
            rule("TIME INTERVAL", "every so much time"),
            rule("TIME MARKS", "YES or NO"),
            rule("TIME POINTS", "not supported"),
            rule("OP", "ADD, NEW or REPLACE"),
            rule("NAME", "name"),
            rule("FILTER", "no effect"),
            rule("SENSOR", "no effect"),
        ],
        &[],
    ),
    used(
        "NODE OUTPUT",
        "Variables of nodes.",
        &[
            rule("NSET", "node set"),
            rule("VARIABLE", "PRESELECT or ALL"),
            rule("EXTERIOR", "no effect"),
            rule("SURFACE", "no effect"),
        ],
        &["variables"],
    ),
    used(
        "ELEMENT OUTPUT",
        "Variables of elements.",
        &[
            rule("ELSET", "element set"),
            rule("VARIABLE", "PRESELECT or ALL"),
            rule("DIRECTIONS", "no effect"),
            rule("POSITION", "no effect"),
            rule("SURFACE", "no effect"),
            rule("EXTERIOR", "no effect"),
            rule("REBAR", "no effect"),
            rule("SECTION POINTS", "no effect"),
        ],
        &["variables"],
    ),
    used(
        "ENERGY OUTPUT",
        "Energies.",
        &[rule("ELSET", "element set"), rule("VARIABLE", "PRESELECT or ALL"), rule("PER ELEMENT SET", "no effect")],
        &["variables"],
    ),
    used("INCREMENTATION OUTPUT", "Data of the increment.", &[rule("VARIABLE", "PRESELECT or ALL")], &["variables"]),
    used(
        "CONTACT OUTPUT",
        "Contact variables; no contact is simulated, so they have no value.",
        &[
            rule("NSET", "node set"),
            rule("VARIABLE", "PRESELECT or ALL"),
            rule("SURFACE", "surface"),
            rule("CONTACT PAIR", "pair"),
            rule("CPSET", "pairs"),
            rule("GENERAL CONTACT", "all"),
            rule("SECOND SURFACE", "surface"),
        ],
        &["variables"],
    ),
    Keyword {
        extension: true,
        ..used(
            "TARGET",
            "A target that is not meshed: layers of material with cavity expansion.",
            &[
                rule("NAME", "name"),
                rule("FRONT", "z of the impact face"),
                rule("DIRECTION", "+1 or -1, the way the layers follow each other along z"),
            ],
            &["material, thickness (blank: without end)"],
        )
    },
    Keyword {
        extension: true,
        ..used(
            "CAVITY EXPANSION",
            "Resistance of a material: sigma_n = Y (A + B x + C x^2), x = v_n sqrt(rho / Y).",
            &[rule("YIELD", "Y, stress")],
            &["A, B, C"],
        )
    },
    Keyword {
        extension: true,
        ..used(
            "MESH",
            "Nodes, elements and sets from a VTK file.",
            &[
                rule("INPUT", ".vtu, .vtk or .vtp file, relative to this one"),
                rule("TYPE", "element type in place of the default"),
            ],
            &[],
        )
    },
    other("PREPRINT", OutputOnly),
    other("RESTART", OutputOnly),
    other("NODE PRINT", OutputOnly),
    other("EL PRINT", OutputOnly),
    other("ENERGY PRINT", OutputOnly),
    other("CONTACT PRINT", OutputOnly),
    other("NODE FILE", OutputOnly),
    other("EL FILE", OutputOnly),
    other("ENERGY FILE", OutputOnly),
    other("CONTACT FILE", OutputOnly),
    other("FILE OUTPUT", OutputOnly),
    other("MONITOR", OutputOnly),
    other("FILTER", OutputOnly),
    other("TIME POINTS", OutputOnly),
    other("EQUATION", Parsed),
    other("INELASTIC HEAT FRACTION", Parsed),
    other("SPECIFIC HEAT", Parsed),
    other("CONDUCTIVITY", Parsed),
    other("EXPANSION", Parsed),
    other("VARIABLE MASS SCALING", Parsed),
    other("USER MATERIAL", Parsed),
    other("DEPVAR", Parsed),
    other("COUPLING", Parsed),
    other("KINEMATIC", Parsed),
    other("DISTRIBUTING", Parsed),
    other("MPC", Parsed),
    other("NCOPY", Parsed),
    other("CONTACT PAIR", Parsed),
    other("SURFACE INTERACTION", Parsed),
    other("SURFACE BEHAVIOR", Parsed),
    other("FRICTION", Parsed),
    other("CONTACT", Parsed),
    other("DYNAMIC TEMPERATURE-DISPLACEMENT", Parsed),
    other("DAMAGE INITIATION", Parsed),
    other("DAMAGE EVOLUTION", Parsed),
    other("TIE", Parsed),
    other("ORIENTATION", Parsed),
    other("TRANSFORM", Parsed),
    other("STATIC", UnsupportedPhysics),
    other("VISCO", UnsupportedPhysics),
    other("FREQUENCY", UnsupportedPhysics),
    other("BUCKLE", UnsupportedPhysics),
    other("HEAT TRANSFER", UnsupportedPhysics),
    other("COUPLED TEMPERATURE-DISPLACEMENT", UnsupportedPhysics),
    other("STEADY STATE DYNAMICS", UnsupportedPhysics),
    other("MODAL DYNAMIC", UnsupportedPhysics),
    other("GEOSTATIC", UnsupportedPhysics),
    other("SOILS", UnsupportedPhysics),
    other("ANNEAL", UnsupportedPhysics),
    other("CREEP", UnsupportedPhysics),
    other("SWELLING", UnsupportedPhysics),
    other("HYPERELASTIC", UnsupportedPhysics),
    other("HYPERFOAM", UnsupportedPhysics),
    other("VISCOELASTIC", UnsupportedPhysics),
    other("EOS", UnsupportedPhysics),
    other("TENSILE FAILURE", UnsupportedPhysics),
    other("SHEAR FAILURE", UnsupportedPhysics),
    other("CAP PLASTICITY", UnsupportedPhysics),
    other("CAP HARDENING", UnsupportedPhysics),
    other("DRUCKER PRAGER", UnsupportedPhysics),
    other("DRUCKER PRAGER HARDENING", UnsupportedPhysics),
    other("MOHR COULOMB", UnsupportedPhysics),
    other("CRUSHABLE FOAM", UnsupportedPhysics),
    other("CRUSHABLE FOAM HARDENING", UnsupportedPhysics),
    other("POROUS METAL PLASTICITY", UnsupportedPhysics),
    other("CONCRETE DAMAGED PLASTICITY", UnsupportedPhysics),
    other("CYCLIC HARDENING", UnsupportedPhysics),
    other("POTENTIAL", UnsupportedPhysics),
    other("DAMPING", UnsupportedPhysics),
    other("USER DEFINED FIELD", UnsupportedPhysics),
    other("FIELD", UnsupportedPhysics),
    other("TEMPERATURE", UnsupportedPhysics),
    other("INITIAL CONDITIONS FIELD", UnsupportedPhysics),
    other("SHELL SECTION", UnsupportedPhysics),
    other("MEMBRANE SECTION", UnsupportedPhysics),
    other("BEAM SECTION", UnsupportedPhysics),
    other("SURFACE SECTION", UnsupportedPhysics),
    other("COHESIVE SECTION", UnsupportedPhysics),
    other("GASKET SECTION", UnsupportedPhysics),
    other("CONNECTOR SECTION", UnsupportedPhysics),
    other("CONNECTOR BEHAVIOR", UnsupportedPhysics),
    other("CONNECTOR ELASTICITY", UnsupportedPhysics),
    other("CONNECTOR MOTION", UnsupportedPhysics),
    other("CONNECTOR LOAD", UnsupportedPhysics),
    other("SPRING", UnsupportedPhysics),
    other("DASHPOT", UnsupportedPhysics),
    other("ROTARY INERTIA", UnsupportedPhysics),
    other("NONSTRUCTURAL MASS", UnsupportedPhysics),
    other("REBAR LAYER", UnsupportedPhysics),
    other("EMBEDDED ELEMENT", UnsupportedPhysics),
    other("FASTENER", UnsupportedPhysics),
    other("SHELL TO SOLID COUPLING", UnsupportedPhysics),
    other("DISPLAY BODY", UnsupportedPhysics),
    other("CONTACT INCLUSIONS", UnsupportedPhysics),
    other("CONTACT EXCLUSIONS", UnsupportedPhysics),
    other("CONTACT PROPERTY ASSIGNMENT", UnsupportedPhysics),
    other("CONTACT FORMULATION", UnsupportedPhysics),
    other("CONTACT CONTROLS", UnsupportedPhysics),
    other("CONTACT CONTROLS ASSIGNMENT", UnsupportedPhysics),
    other("CONTACT DAMPING", UnsupportedPhysics),
    other("CONTACT INITIALIZATION DATA", UnsupportedPhysics),
    other("CONTACT INITIALIZATION ASSIGNMENT", UnsupportedPhysics),
    other("CONTACT CLEARANCE", UnsupportedPhysics),
    other("CONTACT CLEARANCE ASSIGNMENT", UnsupportedPhysics),
    other("SURFACE PROPERTY ASSIGNMENT", UnsupportedPhysics),
    other("CLEARANCE", UnsupportedPhysics),
    other("COHESIVE BEHAVIOR", UnsupportedPhysics),
    other("GAP HEAT GENERATION", UnsupportedPhysics),
    other("DFLUX", UnsupportedPhysics),
    other("CFLUX", UnsupportedPhysics),
    other("FILM", UnsupportedPhysics),
    other("SFILM", UnsupportedPhysics),
    other("RADIATE", UnsupportedPhysics),
    other("SRADIATE", UnsupportedPhysics),
    other("INERTIA RELIEF", UnsupportedPhysics),
    other("BASE MOTION", UnsupportedPhysics),
    other("INCIDENT WAVE", UnsupportedPhysics),
    other("INCIDENT WAVE INTERACTION", UnsupportedPhysics),
    other("INCIDENT WAVE INTERACTION PROPERTY", UnsupportedPhysics),
    other("CONWEP CHARGE PROPERTY", UnsupportedPhysics),
    other("FLUID CAVITY", UnsupportedPhysics),
    other("FLUID BEHAVIOR", UnsupportedPhysics),
    other("FLUID DENSITY", UnsupportedPhysics),
    other("ADAPTIVE MESH", UnsupportedPhysics),
    other("ADAPTIVE MESH CONSTRAINT", UnsupportedPhysics),
    other("ADAPTIVE MESH CONTROLS", UnsupportedPhysics),
    other("EULERIAN SECTION", UnsupportedPhysics),
    other("SYMMETRIC MODEL GENERATION", UnsupportedPhysics),
    other("MODEL CHANGE", UnsupportedPhysics),
    other("IMPORT", UnsupportedPhysics),
    other("IMPORT ELSET", UnsupportedPhysics),
    other("IMPORT NSET", UnsupportedPhysics),
    other("MAP SOLUTION", UnsupportedPhysics),
    other("SUBMODEL", UnsupportedPhysics),
    other("ELCOPY", UnsupportedPhysics),
    other("SYSTEM", UnsupportedPhysics),
    other("DISTRIBUTION", UnsupportedPhysics),
    other("DISTRIBUTION TABLE", UnsupportedPhysics),
    other("SUBSTRUCTURE GENERATE", UnsupportedPhysics),
    other("MATRIX INPUT", UnsupportedPhysics),
    other("USER ELEMENT", UnsupportedPhysics),
    other("UEL PROPERTY", UnsupportedPhysics),
    other("RIGID SURFACE", UnsupportedPhysics),
    other("ELEMENT PROPERTIES", UnsupportedPhysics),
    other("PHYSICAL CONSTANTS", UnsupportedInert),
    other("CONTROLS", UnsupportedInert),
    other("DIAGNOSTICS", UnsupportedInert),
    other("ELEMENT RESPONSE", UnsupportedInert),
    other("MODAL OUTPUT", UnsupportedInert),
    other("INTEGRATED OUTPUT", UnsupportedInert),
    other("INTEGRATED OUTPUT SECTION", UnsupportedInert),
    other("SURFACE OUTPUT", UnsupportedInert),
    other("RADIATION OUTPUT", UnsupportedInert),
    other("SECTION PRINT", UnsupportedInert),
    other("SECTION FILE", UnsupportedInert),
    other("PRINT", UnsupportedInert),
    other("PRE-TENSION PRINT", UnsupportedInert),
    other("LOAD CASE", UnsupportedInert),
    other("END LOAD CASE", UnsupportedInert),
    other("PARAMETER DEPENDENCE", UnsupportedInert),
    other("PARAMETER SHAPE VARIATION", UnsupportedInert),
    other("DESIGN PARAMETER", UnsupportedInert),
    other("POST OUTPUT", UnsupportedInert),
    other("WAVEFRONT MINIMIZATION", UnsupportedInert),
];

/// What a word of a deck matches.
#[derive(Clone, Debug, PartialEq)]
pub enum Lookup<T> {
    /// One entry.
    Found(T),
    /// An abbreviation of several.
    Ambiguous(Vec<&'static str>),
    /// None; the nearest name, if one is near.
    Unknown(Option<&'static str>),
}

/// The keyword a word stands for: case and blanks do not matter, an unambiguous abbreviation will do.
pub fn find_keyword(word: &str) -> Lookup<&'static Keyword> {
    match find(word, KEYWORDS.iter().map(|k| k.name)) {
        Lookup::Found(index) => Lookup::Found(&KEYWORDS[index]),
        Lookup::Ambiguous(names) => Lookup::Ambiguous(names),
        Lookup::Unknown(nearest) => Lookup::Unknown(nearest),
    }
}

/// The parameter of a keyword that a word stands for, by the same rules.
pub fn find_parameter(keyword: &Keyword, word: &str) -> Lookup<&'static str> {
    match find(word, keyword.parameters.iter().map(|p| p.name)) {
        Lookup::Found(index) => Lookup::Found(keyword.parameters[index].name),
        Lookup::Ambiguous(names) => Lookup::Ambiguous(names),
        Lookup::Unknown(nearest) => Lookup::Unknown(nearest),
    }
}

fn find(word: &str, names: impl Iterator<Item = &'static str> + Clone) -> Lookup<usize> {
    let sought = squeeze(word);
    if let Some(index) = names.clone().position(|n| squeeze(n) == sought) {
        return Lookup::Found(index);
    }
    let begins: Vec<(usize, &str)> =
        names.clone().enumerate().filter(|(_, n)| !sought.is_empty() && squeeze(n).starts_with(&sought)).collect();
    match begins.as_slice() {
        [(index, _)] => Lookup::Found(*index),
        [] => Lookup::Unknown(nearest(&sought, names)),
        several => Lookup::Ambiguous(several.iter().map(|s| s.1).collect()),
    }
}

fn squeeze(text: &str) -> String {
    text.chars().filter(|c| !c.is_whitespace()).flat_map(char::to_uppercase).collect()
}

/// The name nearest to a word, if near enough to be a slip.
pub fn nearest<'a>(word: &str, names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let sought = squeeze(word);
    let allowed = (sought.chars().count() / 3).max(1);
    names
        .map(|n| (distance(&sought, &squeeze(n), allowed), n))
        .filter(|(d, _)| *d <= allowed)
        .min_by_key(|d| d.0)
        .map(|d| d.1)
}

/// Edit distance (Levenshtein); anything above `limit` counts as `limit + 1`.
fn distance(a: &str, b: &str, limit: usize) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    if a.len().abs_diff(b.len()) > limit || a.len() > 200 {
        return limit + 1;
    }
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.iter().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let next = (diagonal + usize::from(x != y)).min(row[j] + 1).min(row[j + 1] + 1);
            diagonal = std::mem::replace(&mut row[j + 1], next);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn name(word: &str) -> String {
        match find_keyword(word) {
            Lookup::Found(k) => k.name.to_owned(),
            other => format!("{other:?}"),
        }
    }

    #[test]
    fn case_blanks_and_abbreviations() {
        for (word, expected) in [
            ("RigidBody", "RIGID BODY"),
            ("section control", "SECTION CONTROLS"),
            ("node", "NODE"),
            ("end  step", "END STEP"),
            ("contact", "CONTACT"),
        ] {
            assert_eq!(name(word), expected);
        }
        assert!(matches!(find_keyword("END"), Lookup::Ambiguous(_)));
        assert_eq!(find_keyword("ELEMNT"), Lookup::Unknown(Some("ELEMENT")));
        assert_eq!(find_keyword("QQQQQQQQ"), Lookup::Unknown(None));
    }

    #[test]
    fn names_are_canonical_and_unique() {
        for (i, keyword) in KEYWORDS.iter().enumerate() {
            assert_eq!(keyword.name, keyword.name.to_uppercase());
            assert!(KEYWORDS[i + 1..].iter().all(|k| k.name != keyword.name), "{} twice", keyword.name);
        }
    }
}
