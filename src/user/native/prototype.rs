//! Whether a routine of the user has the arguments of its subroutine (`subroutines.rs`).
//! Never here: calling the routine.

use super::subroutines::{Kind, interface};
use crate::deck::lists;

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
    let expected = interface(name)?.arguments;
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
            Kind::Integer | Kind::IntegerResult => "a default integer (4 bytes)",
            Kind::Real | Kind::RealResult => "double precision (real*8): include 'vaba_param.inc', or declare it so",
            Kind::Character => "character*80",
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
    match kind {
        Kind::Integer | Kind::IntegerResult => matches!(type_of(argument), "int" | "int32_t"),
        Kind::Real | Kind::RealResult => type_of(argument) == "double",
        Kind::Character => type_of(argument) == "char",
    }
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
