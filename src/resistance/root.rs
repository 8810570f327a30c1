//! A root within a bracket.
//! Never here: what it is a root of.

/// Rounds after which the bracket is as narrow as numbers allow, whatever the function.
const ROUNDS: usize = 200;

/// Where a function that is below zero at `low` and above at `high` passes zero, to a relative width: secants, each end's value
/// halved when it stays (Illinois), and halves where the function has no value, which counts as above zero.
pub fn bracketed(mut f: impl FnMut(f64) -> Option<f64>, [mut low, mut high]: [f64; 2], width: f64) -> [f64; 2] {
    let (mut at_low, mut at_high): (f64, Option<f64>) = match f(low) {
        Some(value) if value < 0.0 => (value, f(high)),
        _ => return [low, low],
    };
    if at_high.is_some_and(|value| value <= 0.0) {
        return [high, high];
    }
    let mut stayed = 0;
    for round in 0..ROUNDS {
        let middle = 0.5 * (low + high);
        if (high - low).abs() <= width * middle.abs() || middle == low || middle == high {
            break;
        }
        let secant = at_high.map(|at_high| low - at_low * (high - low) / (at_high - at_low));
        let inside = |x: &f64| (*x > low && *x < high) && round % 8 != 7;
        let x = secant.filter(inside).unwrap_or(middle);
        match f(x) {
            Some(0.0) => return [x, x],
            Some(value) if value < 0.0 => {
                (low, at_low) = (x, value);
                at_high = if stayed == -1 { at_high.map(|v| 0.5 * v) } else { at_high };
                stayed = -1;
                if value.abs() <= f64::MIN_POSITIVE {
                    break;
                }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_found_to_their_width_even_where_there_is_no_value() {
        let mut asked = 0;
        let counted = |x: f64| {
            asked += 1;
            Some(x * x * x - 2.0)
        };
        let [low, high] = bracketed(counted, [0.0, 5.0], 1e-13);
        assert!(low <= 2f64.cbrt() && high >= 2f64.cbrt() && high - low < 1e-12, "{low} {high}");
        assert!(asked < 40, "{asked}");
        let half = |x: f64| (x < 3.0).then(|| x - 4.0);
        let [low, high] = bracketed(half, [0.0, 8.0], 1e-12);
        assert!(low < 3.0 && high >= 3.0 && high - low < 1e-10, "{low} {high}");
    }
}
