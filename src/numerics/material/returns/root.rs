//! Root of a scalar function with kinks, between two bounds.

/// Iterations of [`bracketed_root`]; the interval halves at the latest in every second one.
const ITERATIONS: usize = 120;

/// Returns the argument at which `function` is zero within `tolerance`, from bounds where it is positive and not positive. The
/// bounds may be in either order. Illinois method (Dowell and Jarratt 1971, BIT 11, 168) with a bisection after each
/// retained bound, so that kinks and jumps do not slow it down.
pub fn bracketed_root(mut positive: f64, mut other: f64, tolerance: f64, function: impl Fn(f64) -> f64) -> f64 {
    let (mut high, mut low) = (function(positive), function(other));
    if high <= tolerance {
        return positive;
    }
    if low >= -tolerance {
        return other;
    }
    // Retained bound of the last iteration: 1 the positive one, -1 the other one.
    let mut retained = 0;
    for iteration in 0..ITERATIONS {
        let secant = other + (positive - other) * low / (low - high);
        let next = if iteration % 3 == 2 { 0.5 * (positive + other) } else { secant };
        let value = function(next);
        if value.abs() <= tolerance || (positive - other).abs() <= 1e-15 * (positive.abs() + other.abs()) {
            return next;
        }
        if value > 0.0 {
            (positive, high) = (next, value);
            low *= if retained == -1 { 0.5 } else { 1.0 };
            retained = -1;
        } else {
            (other, low) = (next, value);
            high *= if retained == 1 { 0.5 } else { 1.0 };
            retained = 1;
        }
    }
    other
}

#[cfg(test)]
mod tests {
    use super::bracketed_root;

    #[test]
    fn finds_roots_of_smooth_kinked_and_steep_functions() {
        let kinked = |x: f64| if x < 0.3 { 5.0 - x } else { 4.7 - 1000.0 * (x - 0.3) };
        for (function, root) in [
            (&(|x: f64| 2.0 - x * x) as &dyn Fn(f64) -> f64, 2.0_f64.sqrt()),
            (&kinked, 0.3047),
            (&|x: f64| (1.0 - x) - 50.0 * x.powi(20), 0.764_914_3),
        ] {
            let found = bracketed_root(0.0, 2.0, 1e-13, function);
            assert!((found - root).abs() < 2e-6 * root && function(found).abs() < 1e-12, "{found} {root}");
        }
    }
}
