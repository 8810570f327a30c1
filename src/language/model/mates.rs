//! Parameters that need another one, and parameters that exclude each other.

use crate::deck::{Card, Diagnostic, Diagnostics, Parameter};

/// Parameters of a keyword that have an effect only with another parameter, or only with one of its values.
const NEEDED: &[(&str, &[&str], &str, &str)] = &[
    ("ANISOTROPIC HYPERELASTIC", &["FORMULATION", "PROPERTIES"], "USER", ""),
    ("AMPLITUDE", &["FIXED INTERVAL", "BEGIN"], "DEFINITION", "EQUALLY SPACED"),
    ("AMPLITUDE", &["VARIABLES", "PROPERTIES"], "DEFINITION", "USER"),
    ("CAVITY EXPANSION", &["STATIC", "TERMS", "WEIGHT", "RADIUS", "TENSION"], "DERIVE", ""),
    ("CHARACTERISTIC LENGTH", &["PROPERTIES"], "DEFINITION", "USER"),
    ("FRICTION", &["DEPVAR", "PROPERTIES"], "USER", ""),
    ("OUTPUT", &["NAME"], "SENSOR", ""),
    ("PLASTIC", &["PROPERTIES"], "HARDENING", "USER"),
    ("SECTION CONTROLS", &["WEIGHT FACTOR"], "HOURGLASS", "COMBINED"),
    ("SURFACE", &["FILLET RADIUS"], "TYPE", "SEGMENTS"),
];

/// Parameters of a keyword of which only one may be given.
const EXCLUSIVE: &[(&str, &[&str])] = &[
    ("ANISOTROPIC HYPERELASTIC", &["HOLZAPFEL", "USER"]),
    ("CONTACT CONTROLS", &["RESET", "SCALE PENALTY"]),
    ("DYNAMIC", &["DIRECT USER CONTROL", "SCALE FACTOR", "ELEMENT BY ELEMENT", "GLOBAL"]),
    ("DYNAMIC TEMPERATURE-DISPLACEMENT", &["DIRECT USER CONTROL", "SCALE FACTOR", "ELEMENT BY ELEMENT"]),
    ("FRICTION", &["ROUGH", "EXPONENTIAL DECAY", "USER"]),
    ("FRICTION", &["TAUMAX", "USER"]),
    ("FRICTION", &["SLIP DAMPING", "USER"]),
    ("HYPERELASTIC", &["NEO HOOKE", "MOONEY-RIVLIN", "YEOH", "OGDEN", "POLYNOMIAL", "REDUCED POLYNOMIAL"]),
    ("INTEGRATED OUTPUT", &["SECTION", "SURFACE"]),
    ("NCOPY", &["SHIFT", "REFLECT"]),
    ("OUTPUT", &["FIELD", "HISTORY"]),
    ("OUTPUT", &["FREQUENCY", "NUMBER INTERVAL", "TIME INTERVAL", "TIME POINTS"]),
    ("RESTART", &["FREQUENCY", "NUMBER INTERVAL"]),
];

/// Pairs of exclusive parameters that are allowed together.
const COMPATIBLE: &[[&str; 2]] = &[["SCALE FACTOR", "ELEMENT BY ELEMENT"], ["SCALE FACTOR", "GLOBAL"]];

/// Reports parameters without the parameter that they need, and parameters that exclude each other.
pub(super) fn check_mates(card: &Card, diagnostics: &mut Diagnostics) {
    let given_parameter = |name: &str| card.parameter(name).filter(|_| card.has(name));
    for (_, names, other, word) in NEEDED.iter().filter(|row| row.0 == card.keyword.name) {
        let has_other = match *word {
            "" => card.has(other),
            word => card.value(other).is_some_and(|value| value.is(word)),
        };
        if has_other {
            continue;
        }
        let needed = if word.is_empty() { (*other).to_owned() } else { format!("{other}={word}") };
        for Parameter { name, span, .. } in names.iter().filter_map(|name| given_parameter(name)) {
            let message = format!("{name} of *{} has an effect only with {needed}", card.keyword.name);
            diagnostics.push(Diagnostic::error("M167", message).at(*span, "here").help("add it, or remove this one"));
        }
    }
    for (_, names) in EXCLUSIVE.iter().filter(|row| row.0 == card.keyword.name) {
        let given_parameters: Vec<&Parameter> = names.iter().filter_map(|name| given_parameter(name)).collect();
        let excluded = given_parameters.iter().enumerate().find_map(|(i, a)| {
            let is_compatible =
                |b: &Parameter| COMPATIBLE.iter().any(|pair| pair.contains(&a.name) && pair.contains(&b.name));
            given_parameters[i + 1..].iter().find(|b| !is_compatible(b)).map(|b| (a, b))
        });
        if let Some((a, b)) = excluded {
            let message = format!("{} and {} of *{} exclude each other", a.name, b.name, card.keyword.name);
            diagnostics.push(
                Diagnostic::error("M167", message)
                    .at(b.span, "here")
                    .at(a.span, "and here")
                    .help("remove one of the parameters"),
            );
        }
    }
}
