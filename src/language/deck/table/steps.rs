//! Cards of steps: procedure, increments, mass scaling and amplitudes.

use super::{card, row, rules};
use crate::deck::keywords::Keyword;
use crate::deck::value::{COUNT, FLAG, INTEGER, NOT_NEGATIVE, NUMBER, POSITIVE, TEXT, ZERO, variant, word};

card!(Dynamic: "DYNAMIC", "Explicit dynamics", (once step), {
    explicit: bool = "EXPLICIT" (FLAG) "Required",
    adiabatic: bool = "ADIABATIC" (FLAG) "Adiabatic heating by plastic work",
    element_by_element: bool = "ELEMENT BY ELEMENT" (FLAG) "Stable time increment estimated element by element",
    "GLOBAL" inert "the stable time increment follows from the highest frequency of the model by default",
    "FIXED TIME INCREMENTATION" refused "give DIRECT USER CONTROL",
    direct: bool = "DIRECT USER CONTROL" (FLAG) "The time increment is given on the data line",
    scale_factor: f64 = "SCALE FACTOR" (POSITIVE.or(1.0)) "Factor on the stable time increment",
    "IMPROVED DT METHOD" inert "applies only to three-dimensional elements",
    accuracy: f64 = "ACCURACY" extension (NUMBER.from(1e-14).to(0.1).or(1e-4)) "Target relative error of the motion, if no stability condition limits the increment",
    lagged: bool = "LOAD VELOCITY" extension (word(&["PREDICTED", "LAGGED"]).or(0.0)) "Velocity passed to loads: PREDICTED at the time of the increment, or LAGGED by half an increment",
    "DIRECT" refused "applies only to implicit dynamics: give DIRECT USER CONTROL",
} refused {
    "applies only to implicit dynamics": "ALPHA", "APPLICATION", "BETA", "GAMMA", "HAFTOL", "HALFINC SCALE FACTOR", "IMPACT",
        "INCREMENTATION", "INITIAL", "NOHAF", "SINGULAR MASS", "SUBSPACE", "TIME INTEGRATOR";
}, times: [f64; 4] = [
    (when "DIRECT USER CONTROL" lines [
        "increment" (POSITIVE.required()), "length of the step" (POSITIVE.required()),
        "third field" only ["0"] "ABAQUS leaves it empty",
        "largest of given increments" only ["0"] "the time increment is given",
    ]),
    (lines [
        "first field" inert "the time increment is automatic; for a given one use DIRECT USER CONTROL",
        "length of the step" (POSITIVE.required()),
        "third field" inert "there is no smallest increment",
        "largest increment" (NOT_NEGATIVE.or(0.0)),
    ]),
]);

/// Row of `*DYNAMIC TEMPERATURE-DISPLACEMENT`, which is read as [`Dynamic`] and has the same data lines.
const COUPLED_DYNAMIC: Keyword = Keyword {
    name: "DYNAMIC TEMPERATURE-DISPLACEMENT",
    summary: "Explicit dynamics with heat conduction",
    parameters: rules!(
        "EXPLICIT" (FLAG) "Required",
        "ELEMENT BY ELEMENT" (FLAG) "Stable time increment estimated element by element",
        "GLOBAL" inert "the default",
        "FIXED TIME INCREMENTATION" refused "give DIRECT USER CONTROL",
        "DIRECT USER CONTROL" (FLAG) "The time increment is given on the data line",
        "SCALE FACTOR" (POSITIVE.or(1.0)) "Factor on the stable time increment",
        "IMPROVED DT METHOD" inert "applies only to three-dimensional elements",
        "CONDUCTION" extension (word(&["HELD", "CURRENT"]).or(0.0)) "HELD: heat rates of conduction are evaluated at intervals of at most 5e-4 of its stable time increment; CURRENT: in each increment",
    ),
    ..Dynamic::ROW
};

card!(BulkViscosity: "BULK VISCOSITY", "Linear and quadratic bulk viscosity", (once step), {
    whole_rate: bool = "LINEAR TERM" extension (word(&["FILTERED", "UNFILTERED"]).or(0.0)) "FILTERED: the linear term acts on quick changes of the volumetric strain rate; UNFILTERED: on the whole rate, as in ABAQUS, and always for materials with *EOS and for WEIGHTING=AREA",
}, factors: [f64; 2] = [
    (lines ["linear factor" (NUMBER.or(0.06)), "quadratic factor" (NUMBER.or(1.2))]),
]);

card!(EnergyLimit: extension "ENERGY LIMIT", "Warns or halts if the energy error or the hourglass energy exceeds a limit", (once step), {
    error: Option<f64> = "ERROR" (POSITIVE) "Maximum drift of ETOTAL relative to the energy put in; replaces the default limit of 20 %",
    artificial: Option<f64> = "ARTIFICIAL" (POSITIVE) "Maximum ratio of ALLAE to ALLIE, once ALLIE exceeds 1 % of the energy put in",
    halts: bool = "ACTION" (variant(&["WARN", "HALT"]).or(0.0)) "WARN prints one warning per step",
}, []);

card!(FixedMassScaling: "FIXED MASS SCALING", "Scales element masses at the start of the step", (step), {
    "ELSET" read "Elements; default: all",
    factor: Option<f64> = "FACTOR" (POSITIVE) "Factor on the mass",
    dt: Option<f64> = "DT" (POSITIVE) "Target stable time increment",
    kind: usize = "TYPE" (variant(&["BELOW MIN", "UNIFORM", "SET EQUAL DT"]).or(0.0)),
    budget: Option<f64> = "BUDGET" extension (POSITIVE) "Largest mass that TYPE=BELOW MIN adds, as a fraction of the mass of the elements: DT is reduced until it suffices",
}, []);

card!(VariableMassScaling: "VARIABLE MASS SCALING", "Scales element masses during the step", (step), {
    "ELSET" read "Elements; default: all",
    dt: Option<f64> = "DT" (POSITIVE) "Target stable time increment",
    kind: usize = "TYPE" (variant(&["BELOW MIN", "UNIFORM", "SET EQUAL DT"]).or(0.0)),
    frequency: Option<usize> = "FREQUENCY" (COUNT) "Interval in increments",
    intervals: Option<usize> = "NUMBER INTERVAL" (COUNT) "Number of times in the step, in place of FREQUENCY",
    budget: Option<f64> = "BUDGET" extension (POSITIVE) "Largest mass that TYPE=BELOW MIN adds, as a fraction of the mass of the elements: DT is reduced until it suffices",
} refused {
    "applies only to rolling": "CROSS SECTION NODES", "EXTRUDED LENGTH", "FEED RATE";
}, []);

card!(Amplitude: "AMPLITUDE", "A function of time", (unique "NAME"), {
    name: String = "NAME" (TEXT.required()) "Name of the amplitude",
    definition: usize = "DEFINITION" (variant(&["TABULAR", "SMOOTH STEP", "EQUALLY SPACED", "USER"]).or(0.0)),
    total_time: bool = "TIME" (word(&["STEP TIME", "TOTAL TIME"]).or(0.0)),
    absolute: bool = "VALUE" (word(&["RELATIVE", "ABSOLUTE"]).or(0.0)) "RELATIVE: factors on the magnitude; ABSOLUTE: the magnitude itself",
    "SMOOTH" only ["0"] "tabular amplitudes are not smoothed; give SMOOTH STEP",
    "INPUT" read "File with the data lines",
    interval: Option<f64> = "FIXED INTERVAL" (POSITIVE) "Interval of EQUALLY SPACED",
    begin: f64 = "BEGIN" (ZERO) "Start time of EQUALLY SPACED",
    scale_time: f64 = "SCALEX" (POSITIVE.or(1.0)) "Factor on time",
    scale: f64 = "SCALEY" (NUMBER.or(1.0)) "Factor on value",
    shift_time: f64 = "SHIFTX" (ZERO) "Added to time",
    shift: f64 = "SHIFTY" (ZERO) "Added to value",
    variables: usize = "VARIABLES" (INTEGER.from(0.0).or(0.0)) "Number of state variables of a user amplitude",
    properties: Option<usize> = "PROPERTIES" (INTEGER.from(0.0)) "Number of constants of a user amplitude, on the data lines",
    "INTERNAL" inert "written by ABAQUS/CAE; has no effect",
}, values: Vec<f64> = [
    (when "DEFINITION" = "EQUALLY SPACED" list "value of EQUALLY SPACED" (NUMBER)),
    (when "DEFINITION" = "USER" list "constant of a user amplitude" (NUMBER)),
    (stream ["time" (NUMBER), "value" (NUMBER)]),
]);

/// Keywords of steps, increments, mass scaling and amplitudes.
pub const CARDS: &[Keyword] = &[
    Amplitude::ROW,
    row!("STEP", "Begins a step", (), {
        "NAME" read "Name of the step",
        "NLGEOM" only ["YES"] "large displacements are always included",
        "INC" inert "applies only to implicit analyses",
        "PERTURBATION" refused "applies only to linear analyses",
        "AMPLITUDE" (word(&["STEP", "RAMP"]).or(0.0)) "RAMP: loads and conditions without an amplitude increase linearly over the step, in place of acting at once",
        "EXTRAPOLATION" inert "applies only to implicit analyses",
        "UNSYMM" inert "applies only to implicit analyses",
        "CONVERT SDI" inert "applies only to implicit analyses",
        "SOLVER" inert "applies only to implicit analyses",
        "FULL NEWTON" inert "applies only to implicit analyses",
        "MIXED" inert "applies only to implicit analyses",
    }, [(text "subtitle" inert "description only")]),
    row!("END STEP", "Ends a step", (), {}, []),
    Dynamic::ROW,
    COUPLED_DYNAMIC,
    BulkViscosity::ROW,
    EnergyLimit::ROW,
    FixedMassScaling::ROW,
    VariableMassScaling::ROW,
];
