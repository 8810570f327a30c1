//! Cards of steps: procedure, increments, mass scaling, and amplitudes.
//! Never here: loads and prescribed motions.

use super::{card, row, rules};
use crate::deck::keywords::Keyword;
use crate::deck::value::{COUNT, INTEGER, NOT_NEGATIVE, NUMBER, POSITIVE, TEXT, ZERO, variant, word};

card!(Dynamic: "DYNAMIC", "Explicit dynamics", (once step), {
    explicit: bool = "EXPLICIT" read "Must be there",
    adiabatic: bool = "ADIABATIC" read "Heat stays where plastic work makes it",
    element_by_element: bool = "ELEMENT BY ELEMENT" read "Stable increment element by element",
    global: bool = "GLOBAL" read "Stable increment from the highest frequency (default)",
    "FIXED TIME INCREMENTATION" refused "give DIRECT USER CONTROL",
    direct: bool = "DIRECT USER CONTROL" read "The increment is given on the data line",
    scale_factor: f64 = "SCALE FACTOR" (POSITIVE.or(1.0)) "Factor on the stable increment",
    "IMPROVED DT METHOD" inert "of three-dimensional elements",
    accuracy: f64 = "ACCURACY" extension (NUMBER.from(1e-14).to(0.1).or(1e-4)) "Relative error of the motion aimed at where nothing else limits the increment",
    lagged: bool = "LOAD VELOCITY" extension (word(&["PREDICTED", "LAGGED"]).or(0.0)) "Which velocity loads are given",
    "DIRECT" refused "of implicit dynamics: give DIRECT USER CONTROL",
} refused {
    "of implicit dynamics": "ALPHA", "APPLICATION", "BETA", "GAMMA", "HAFTOL", "HALFINC SCALE FACTOR", "IMPACT",
        "INCREMENTATION", "INITIAL", "NOHAF", "SINGULAR MASS", "SUBSPACE", "TIME INTEGRATOR";
}, times: [f64; 4] = [
    (when "DIRECT USER CONTROL" = "" lines [
        "increment" (POSITIVE.required()), "length of the step" (POSITIVE.required()),
        "third field" only ["0"] "the manual leaves it empty",
        "largest of given increments" only ["0"] "the increment is given",
    ]),
    (lines [
        "first field" only ["0"] "the increment is automatic: leave it empty, or give DIRECT USER CONTROL",
        "length of the step" (POSITIVE.required()),
        "third field" only ["0"] "the manual leaves it empty",
        "largest increment" (NOT_NEGATIVE.or(0.0)),
    ]),
]);

/// `*DYNAMIC TEMPERATURE-DISPLACEMENT`, which is read as [`Dynamic`] and has its data lines.
const COUPLED_DYNAMIC: Keyword = Keyword {
    name: "DYNAMIC TEMPERATURE-DISPLACEMENT",
    summary: "Explicit dynamics with conduction of heat",
    parameters: rules!(
        "EXPLICIT" read "Must be there",
        "ELEMENT BY ELEMENT" read "Stable increment element by element",
        "GLOBAL" inert "the default",
        "FIXED TIME INCREMENTATION" refused "give DIRECT USER CONTROL",
        "DIRECT USER CONTROL" read "The increment is given on the data line",
        "SCALE FACTOR" (POSITIVE.or(1.0)) "Factor on the stable increment",
        "IMPROVED DT METHOD" inert "of three-dimensional elements",
    ),
    ..Dynamic::ROW
};

card!(BulkViscosity: "BULK VISCOSITY", "Linear and quadratic bulk viscosity", (once step), {}, factors: [f64; 2] = [
    (lines ["linear factor" (NUMBER.or(0.06)), "quadratic factor" (NUMBER.or(1.2))]),
]);

card!(EnergyLimit: extension "ENERGY LIMIT", "Warns or halts where the energy balance or hourglass control goes wrong", (once step), {
    error: Option<f64> = "ERROR" (POSITIVE) "Largest drift of ETOTAL over the largest energy met, in place of the 20 % at which every run halts",
    artificial: Option<f64> = "ARTIFICIAL" (POSITIVE) "Largest ALLAE over ALLIE, from the time that ALLIE is 1 % of the largest energy",
    halts: bool = "ACTION" (variant(&["WARN", "HALT"]).or(0.0)) "WARN does so once a step",
}, []);

card!(FixedMassScaling: "FIXED MASS SCALING", "Scales masses at the start of the step", (step), {
    "ELSET" read "Elements; all if absent",
    factor: Option<f64> = "FACTOR" (POSITIVE) "Factor on the mass",
    dt: Option<f64> = "DT" (POSITIVE) "Stable increment aimed at",
    kind: usize = "TYPE" (variant(&["BELOW MIN", "UNIFORM", "SET EQUAL DT"]).or(0.0)),
}, []);

card!(VariableMassScaling: "VARIABLE MASS SCALING", "Scales masses during the step", (step), {
    "ELSET" read "Elements; all if absent",
    dt: Option<f64> = "DT" (POSITIVE) "Stable increment aimed at",
    kind: usize = "TYPE" (variant(&["BELOW MIN", "UNIFORM", "SET EQUAL DT"]).or(0.0)),
    frequency: Option<usize> = "FREQUENCY" (COUNT) "Every so many increments",
    intervals: Option<usize> = "NUMBER INTERVAL" (COUNT) "So many times in the step, instead of FREQUENCY",
} refused {
    "of rolling": "CROSS SECTION NODES", "EXTRUDED LENGTH", "FEED RATE";
}, []);

card!(Amplitude: "AMPLITUDE", "A function of time", (unique "NAME"), {
    name: String = "NAME" (TEXT.required()) "Name of the amplitude",
    definition: usize = "DEFINITION" (variant(&["TABULAR", "SMOOTH STEP", "EQUALLY SPACED", "USER"]).or(0.0)),
    total_time: bool = "TIME" (word(&["STEP TIME", "TOTAL TIME"]).or(0.0)),
    absolute: bool = "VALUE" (word(&["RELATIVE", "ABSOLUTE"]).or(0.0)) "Factors on magnitudes, or magnitudes themselves",
    "SMOOTH" refused "tables have kinks; give SMOOTH STEP",
    "INPUT" read "File with the data lines",
    interval: Option<f64> = "FIXED INTERVAL" (POSITIVE) "Interval of EQUALLY SPACED",
    begin: f64 = "BEGIN" (ZERO) "Start time of EQUALLY SPACED",
    scale_time: f64 = "SCALEX" (POSITIVE.or(1.0)) "Factor on time",
    scale: f64 = "SCALEY" (NUMBER.or(1.0)) "Factor on value",
    shift_time: f64 = "SHIFTX" (ZERO) "Added to time",
    shift: f64 = "SHIFTY" (ZERO) "Added to value",
    variables: usize = "VARIABLES" (INTEGER.from(0.0).or(0.0)) "Number of variables that a user amplitude keeps",
    properties: Option<usize> = "PROPERTIES" (INTEGER.from(0.0)) "Number of constants of a user amplitude, on the data lines",
    "INTERNAL" inert "written by CAE; no meaning",
}, values: Vec<f64> = [
    (when "DEFINITION" = "EQUALLY SPACED" list "value of EQUALLY SPACED" (NUMBER)),
    (when "DEFINITION" = "USER" list "constant of a user amplitude" (NUMBER)),
    (stream ["time" (NUMBER), "value" (NUMBER)]),
]);

/// The rows.
pub const CARDS: &[Keyword] = &[
    Amplitude::ROW,
    row!("STEP", "Begins a step", (), {
        "NAME" read "Name of the step",
        "NLGEOM" only ["YES"] "displacements may be large",
        "INC" inert "of implicit analyses",
        "PERTURBATION" refused "of linear analyses",
        "AMPLITUDE" (word(&["STEP", "RAMP"]).or(0.0)) "RAMP: conditions without amplitude grow over the step in place of acting at once",
        "EXTRAPOLATION" inert "of implicit analyses",
        "UNSYMM" inert "of implicit analyses",
        "CONVERT SDI" inert "of implicit analyses",
        "SOLVER" inert "of implicit analyses",
        "FULL NEWTON" inert "of implicit analyses",
        "MIXED" inert "of implicit analyses",
    }, [(text "subtitle" inert "for people")]),
    row!("END STEP", "Ends a step", (), {}, []),
    Dynamic::ROW,
    COUPLED_DYNAMIC,
    BulkViscosity::ROW,
    EnergyLimit::ROW,
    FixedMassScaling::ROW,
    VariableMassScaling::ROW,
];
