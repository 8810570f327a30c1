//! The arguments that ABAQUS's subroutines have, and whether a user's routine has them.
//! Never here: calling the routine.

/// Size and kind of an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Integer,
    Real,
    Character,
}

use Kind::{Character, Integer, Real};

use crate::deck::lists;

/// A routine and its arguments in order.
struct Interface {
    name: &'static str,
    arguments: &'static [(&'static str, Kind)],
}

/// ABAQUS User Subroutines Reference: 1.2.1 "VDLOAD" (6.6), "VUAMP", "VDISP" (6.11), "VUMAT", "VUHARD", "VUSDFLD",
/// "VEXTERNALDB" (6.14), "VUCHARLENGTH" (2016).
const INTERFACES: &[Interface] = &[
    Interface {
        name: "vdload",
        arguments: &[
            ("nblock", Integer),
            ("ndim", Integer),
            ("stepTime", Real),
            ("totalTime", Real),
            ("amplitude", Real),
            ("curCoords", Real),
            ("velocity", Real),
            ("dirCos", Real),
            ("jltyp", Integer),
            ("sname", Character),
            ("value", Real),
        ],
    },
    Interface {
        name: "vuamp",
        arguments: &[
            ("ampName", Character),
            ("time", Real),
            ("ampValueOld", Real),
            ("dt", Real),
            ("nprops", Integer),
            ("props", Real),
            ("nSvars", Integer),
            ("svars", Real),
            ("lFlagsInfo", Integer),
            ("nSensor", Integer),
            ("sensorValues", Real),
            ("sensorNames", Character),
            ("jSensorLookUpTable", Integer),
            ("ampValueNew", Real),
            ("lFlagsDefine", Integer),
            ("ampDerivative", Real),
            ("ampSecDerivative", Real),
            ("ampIncIntegral", Real),
        ],
    },
    Interface {
        name: "vdisp",
        arguments: &[
            ("nblock", Integer),
            ("nDof", Integer),
            ("nCoord", Integer),
            ("kstep", Integer),
            ("kinc", Integer),
            ("stepTime", Real),
            ("totalTime", Real),
            ("dtNext", Real),
            ("dt", Real),
            ("cbname", Character),
            ("jBCType", Integer),
            ("jDof", Integer),
            ("jNodeUid", Integer),
            ("amp", Real),
            ("coordNp", Real),
            ("u", Real),
            ("v", Real),
            ("a", Real),
            ("rf", Real),
            ("rmass", Real),
            ("rotaryI", Real),
            ("rval", Real),
        ],
    },
    Interface {
        name: "vumat",
        arguments: &[
            ("jblock", Integer),
            ("ndir", Integer),
            ("nshr", Integer),
            ("nstatev", Integer),
            ("nfieldv", Integer),
            ("nprops", Integer),
            ("jInfoArray", Integer),
            ("stepTime", Real),
            ("totalTime", Real),
            ("dtArray", Real),
            ("cmname", Character),
            ("coordMp", Real),
            ("charLength", Real),
            ("props", Real),
            ("density", Real),
            ("strainInc", Real),
            ("relSpinInc", Real),
            ("tempOld", Real),
            ("stretchOld", Real),
            ("defgradOld", Real),
            ("fieldOld", Real),
            ("stressOld", Real),
            ("stateOld", Real),
            ("enerInternOld", Real),
            ("enerInelasOld", Real),
            ("tempNew", Real),
            ("stretchNew", Real),
            ("defgradNew", Real),
            ("fieldNew", Real),
            ("stressNew", Real),
            ("stateNew", Real),
            ("enerInternNew", Real),
            ("enerInelasNew", Real),
        ],
    },
    Interface {
        name: "vuhard",
        arguments: &[
            ("nblock", Integer),
            ("jElem", Integer),
            ("kIntPt", Integer),
            ("kLayer", Integer),
            ("kSecPt", Integer),
            ("lAnneal", Integer),
            ("stepTime", Real),
            ("totalTime", Real),
            ("dt", Real),
            ("cmname", Character),
            ("nstatev", Integer),
            ("nfieldv", Integer),
            ("nprops", Integer),
            ("props", Real),
            ("tempOld", Real),
            ("tempNew", Real),
            ("fieldOld", Real),
            ("fieldNew", Real),
            ("stateOld", Real),
            ("eqps", Real),
            ("eqpsRate", Real),
            ("yield", Real),
            ("dyieldDtemp", Real),
            ("dyieldDeqps", Real),
            ("stateNew", Real),
        ],
    },
    Interface {
        name: "vusdfld",
        arguments: &[
            ("nblock", Integer),
            ("nstatev", Integer),
            ("nfieldv", Integer),
            ("nprops", Integer),
            ("ndir", Integer),
            ("nshr", Integer),
            ("jElem", Integer),
            ("kIntPt", Integer),
            ("kLayer", Integer),
            ("kSecPt", Integer),
            ("stepTime", Real),
            ("totalTime", Real),
            ("dt", Real),
            ("cmname", Character),
            ("coordMp", Real),
            ("direct", Real),
            ("T", Real),
            ("charLength", Real),
            ("props", Real),
            ("stateOld", Real),
            ("stateNew", Real),
            ("field", Real),
        ],
    },
    Interface {
        name: "vucharlength",
        arguments: &[
            ("nblock", Integer),
            ("nfieldv", Integer),
            ("nprops", Integer),
            ("ncomp", Integer),
            ("ndim", Integer),
            ("nnode", Integer),
            ("nstatev", Integer),
            ("kSecPt", Integer),
            ("kLayer", Integer),
            ("kIntPt", Integer),
            ("jElType", Integer),
            ("jElem", Integer),
            ("totalTime", Real),
            ("stepTime", Real),
            ("dt", Real),
            ("cmname", Character),
            ("coordMp", Real),
            ("coordNode", Real),
            ("direct", Real),
            ("T", Real),
            ("props", Real),
            ("field", Real),
            ("stateOld", Real),
            ("charLength", Real),
        ],
    },
    Interface {
        name: "vexternaldb",
        arguments: &[
            ("lOp", Integer),
            ("i_Array", Integer),
            ("niArray", Integer),
            ("r_Array", Real),
            ("nrArray", Integer),
        ],
    },
];

/// Checks the prototypes that `gfortran -fc-prototypes-external` prints; each routine that differs, and what is to be said.
pub fn check(prototypes: &str) -> Vec<(String, String)> {
    let told = |(name, list): (String, Vec<String>)| check_one(&name, &list).map(|told| (name, told));
    prototypes.lines().filter_map(prototype).filter_map(told).collect()
}

/// Name and argument list of a line `void name_ (int *a, ...);`, without the hidden lengths at the end.
fn prototype(line: &str) -> Option<(String, Vec<String>)> {
    let (head, rest) = line.trim().split_once('(')?;
    let name = head.split_whitespace().last()?.strip_suffix('_')?.to_owned();
    let list = rest.trim_end().strip_suffix(");")?;
    // An argument may be a procedure, with commas of its own.
    let arguments = lists::split(list).into_iter().map(|a| a.trim().to_owned());
    Some((name, arguments.filter(|a| !a.is_empty() && !a.starts_with("size_t ")).collect()))
}

fn check_one(name: &str, arguments: &[String]) -> Option<String> {
    let interface = INTERFACES.iter().find(|i| i.name == name)?;
    let expected = interface.arguments;
    if arguments.len() != expected.len() {
        let given: Vec<&str> = arguments.iter().map(|a| argument_name(a)).collect();
        let missing: Vec<&str> =
            expected.iter().map(|e| e.0).filter(|e| !given.iter().any(|g| g.eq_ignore_ascii_case(e))).collect();
        let names: Vec<&str> = expected.iter().map(|e| e.0).collect();
        let hint = if arguments.len() < expected.len() && missing.len() == expected.len() - arguments.len() {
            format!("; missing: {}", missing.join(", "))
        } else {
            String::new()
        };
        return Some(format!(
            "{name} has {} arguments; it is called with {}: {}{hint}",
            arguments.len(),
            expected.len(),
            names.join(", ")
        ));
    }
    let wrong = arguments.iter().zip(expected).position(|(given, (_, kind))| !fits(given, *kind))?;
    let (given, (expected_name, kind)) = (&arguments[wrong], expected[wrong]);
    Some(format!(
        "argument {} of {name}, `{}` ({expected_name}), is {}; it must be {}",
        wrong + 1,
        argument_name(given),
        describe(given),
        match kind {
            Integer => "a default integer (4 bytes)",
            Real => "double precision (real*8): include 'vaba_param.inc', or declare it so",
            Character => "character*80",
        }
    ))
}

fn argument_name(argument: &str) -> &str {
    let end = argument.trim_end_matches(|c: char| !(c.is_alphanumeric() || c == '_'));
    end.rsplit(|c: char| !(c.is_alphanumeric() || c == '_')).next().unwrap_or(end)
}

fn type_of(argument: &str) -> &str {
    let text = argument.trim_start().trim_start_matches("const ");
    text.split('*').next().unwrap_or(text).trim()
}

fn fits(argument: &str, kind: Kind) -> bool {
    matches!((kind, type_of(argument)), (Integer, "int" | "int32_t") | (Real, "double") | (Character, "char"))
}

fn describe(argument: &str) -> &'static str {
    match type_of(argument) {
        "float" => "single precision (real*4)",
        "double" => "double precision (real*8)",
        "int" | "int32_t" => "an integer",
        "long" | "int64_t" | "long long" => "an integer*8",
        "char" => "character",
        _ => "of another type",
    }
}

#[cfg(test)]
mod tests {
    use super::check;

    const GOOD: &str = "void vdload_ (const int *nblock, int *ndim, double *steptime, double *totaltime, double *amplitude, \
                        double *curcoords, double *velocity, double *dircos, int *jltyp, char *sname, double *value, size_t sname_len);";

    fn told(prototypes: &str) -> Vec<String> {
        check(prototypes).into_iter().map(|(_, told)| told).collect()
    }

    #[test]
    fn the_manuals_prototype_passes() {
        assert_eq!(check(GOOD), []);
        assert_eq!(check("void helper_ (float *x);"), []);
    }

    #[test]
    fn a_missing_argument_is_named() {
        let told = told(&GOOD.replace("int *jltyp, ", ""));
        assert!(told[0].contains("10 arguments") && told[0].ends_with("missing: jltyp"), "{}", told[0]);
    }

    #[test]
    fn single_precision_is_named() {
        let told = told(&GOOD.replace("double *amplitude", "float *amplitude"));
        assert!(told[0].contains("argument 5") && told[0].contains("single precision"), "{}", told[0]);
    }

    #[test]
    fn arguments_out_of_order_are_named() {
        let told = told(&GOOD.replace("int *jltyp, char *sname", "char *sname, int *jltyp"));
        assert!(told[0].contains("argument 9") && told[0].contains("character"), "{}", told[0]);
    }
}
