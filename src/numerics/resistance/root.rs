//! Root of a function within a bracket.

/// Number of iterations after which the bracket has reached floating-point resolution for any function: at least every
/// eighth iteration is a bisection.
const ROUNDS: usize = 600;

/// Narrows a bracket around a root until a function value is within `enough` of zero or the bracket has reached
/// floating-point resolution. The ends are given with their function values, negative at the lower and positive at the
/// upper end. Iterations are secant steps with the Illinois modification, and bisections where the function has no
/// value, which counts as positive. Returns the bracket; both ends are equal if a value is close enough to zero.
pub fn bracketed(
    mut f: impl FnMut(f64) -> Option<f64>,
    [(mut low, at_low), (mut high, mut at_high)]: [(f64, Option<f64>); 2],
    enough: f64,
) -> [f64; 2] {
    let Some(mut at_low) = at_low.filter(|value| *value < 0.0) else { return [low, low] };
    if at_high.is_some_and(|value| value <= 0.0) {
        return [high, high];
    }
    let mut stayed = 0;
    for round in 0..ROUNDS {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        let secant = at_high.map(|at_high| low - at_low * (high - low) / (at_high - at_low));
        let inside = |x: &f64| (*x > low && *x < high) && round % 8 != 7;
        let x = secant.filter(inside).unwrap_or(middle);
        match f(x) {
            Some(value) if value.abs() <= enough => return [x, x],
            Some(value) if value < 0.0 => {
                (low, at_low) = (x, value);
                at_high = if stayed == -1 { at_high.map(|v| 0.5 * v) } else { at_high };
                stayed = -1;
            }
            value => {
                (high, at_high) = (x, value);
                at_low = if stayed == 1 { 0.5 * at_low } else { at_low };
                stayed = 1;
            }
        }
    }
    [low, high]
}

/// Finds a root like [`bracketed`], but evaluates the function at the ends first.
pub fn between(mut f: impl FnMut(f64) -> Option<f64>, ends: [f64; 2], enough: f64) -> [f64; 2] {
    let ends = ends.map(|x| (x, f(x)));
    bracketed(f, ends, enough)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_found_also_if_the_function_is_partly_undefined() {
        let mut evaluations = 0;
        let counting = |x: f64| {
            evaluations += 1;
            Some(x * x * x - 2.0)
        };
        let [low, high] = between(counting, [0.0, 5.0], 1e-14);
        assert!((low - 2f64.cbrt()).abs() < 1e-14 && high == low, "{low} {high}");
        assert!(evaluations < 40, "{evaluations}");
        let half = |x: f64| (x < 3.0).then_some(x - 4.0);
        let [low, high] = between(half, [0.0, 8.0], 0.0);
        assert!(low < 3.0 && high >= 3.0 && high - low < 1e-10, "{low} {high}");
    }
}
