//! Comparison of the arguments of the user's subroutines with those of the call (`subroutines.rs`).

use super::subroutines::{ArgumentKind, interface};
use revolve_diagnostics::lists;

/// Checks the prototypes printed by `gfortran -fc-prototypes-external`. Returns each subroutine that differs, with a
/// description of the difference.
pub fn check(prototypes: &str) -> Vec<(String, String)> {
    let difference = |(name, list): (String, Vec<String>)| check_one(&name, &list).map(|found| (name, found));
    prototypes.lines().filter_map(prototype).filter_map(difference).collect()
}

/// Returns whether a known subroutine has an argument in single precision where the call passes double precision.
pub fn has_single_precision(prototypes: &str) -> bool {
    let is_single = |(name, list): (String, Vec<String>)| {
        let expected = interface(&name).map_or(&[][..], |known| known.arguments);
        let real = |kind: &ArgumentKind| matches!(kind, ArgumentKind::Real | ArgumentKind::RealResult);
        list.iter().zip(expected).any(|(given, (_, kind))| real(kind) && type_of(given) == "float")
    };
    prototypes.lines().filter_map(prototype).any(is_single)
}

/// Returns name and arguments of a line `void name_ (int *a, ...);`, without the hidden text lengths at the end.
fn prototype(line: &str) -> Option<(String, Vec<String>)> {
    let (head, parameters) = line.trim().split_once('(')?;
    let name = head.split_whitespace().last()?.strip_suffix('_')?.to_owned();
    let list = parameters.trim_end().strip_suffix(");")?;
    // An argument may be a procedure, whose arguments are separated by commas.
    let arguments = lists::split(list).into_iter().map(|a| a.trim().to_owned());
    Some((name, arguments.filter(|a| !a.is_empty() && !a.starts_with("size_t ")).collect()))
}

fn check_one(name: &str, arguments: &[String]) -> Option<String> {
    let expected = interface(name)?.arguments;
    if arguments.len() != expected.len() {
        let names_given: Vec<&str> = arguments.iter().map(|a| argument_name(a)).collect();
        let missing: Vec<&str> =
            expected.iter().map(|e| e.0).filter(|e| !names_given.iter().any(|g| g.eq_ignore_ascii_case(e))).collect();
        let names: Vec<&str> = expected.iter().map(|e| e.0).collect();
        let hint = if arguments.len() < expected.len() && missing.len() == expected.len() - arguments.len() {
            format!("; missing: {}", missing.join(", "))
        } else {
            String::new()
        };
        return Some(format!(
            "{name} has {} arguments, expected {}: {}{hint}",
            arguments.len(),
            expected.len(),
            names.join(", ")
        ));
    }
    let wrong = arguments.iter().zip(expected).position(|(given, (_, kind))| !fits(given, *kind))?;
    let (argument, (expected_name, kind)) = (&arguments[wrong], expected[wrong]);
    Some(format!(
        "argument {} of {name}, `{}` ({expected_name}), is {}; it must be {}",
        wrong + 1,
        argument_name(argument),
        describe(argument),
        match kind {
            ArgumentKind::Integer | ArgumentKind::IntegerResult => "a default integer (4 bytes)",
            ArgumentKind::Real | ArgumentKind::RealResult =>
                "double precision (real*8): include 'vaba_param.inc', or declare it as real*8",
            ArgumentKind::Character => "character*80",
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

fn fits(argument: &str, kind: ArgumentKind) -> bool {
    match kind {
        ArgumentKind::Integer | ArgumentKind::IntegerResult => matches!(type_of(argument), "int" | "int32_t"),
        ArgumentKind::Real | ArgumentKind::RealResult => type_of(argument) == "double",
        // A name that is not declared has the implicit type, and is not used as text.
        ArgumentKind::Character => matches!(type_of(argument), "char" | "double"),
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

    fn differences(prototypes: &str) -> Vec<String> {
        check(prototypes).into_iter().map(|(_, differences)| differences).collect()
    }

    #[test]
    fn prototype_of_the_manual_is_accepted() {
        assert_eq!(check(GOOD), []);
        assert_eq!(check("void helper_ (float *x);"), []);
    }

    #[test]
    fn missing_argument_is_reported() {
        let differences = differences(&GOOD.replace("int *jltyp, ", ""));
        assert!(
            differences[0].contains("10 arguments") && differences[0].ends_with("missing: jltyp"),
            "{}",
            differences[0]
        );
    }

    #[test]
    fn single_precision_is_reported() {
        let differences = differences(&GOOD.replace("double *amplitude", "float *amplitude"));
        assert!(
            differences[0].contains("argument 5") && differences[0].contains("single precision"),
            "{}",
            differences[0]
        );
    }

    #[test]
    fn arguments_in_the_wrong_order_are_reported() {
        let differences = differences(&GOOD.replace("int *jltyp, char *sname", "char *sname, int *jltyp"));
        assert!(differences[0].contains("argument 9") && differences[0].contains("character"), "{}", differences[0]);
    }
}
