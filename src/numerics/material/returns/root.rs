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

/// Returns the root next to `start`, where the function has the positive value `first`, on the way to `limit`; `None` if the
/// function is positive up to there. Returns are short compared with the way, so that secants find it in few steps.
pub fn nearby_root(start: f64, first: f64, limit: f64, tolerance: f64, function: impl Fn(f64) -> f64) -> Option<f64> {
    if first <= tolerance {
        return Some(start);
    }
    let (mut positive, mut value) = (start, first);
    let mut step = FIRST_STEP * (limit - start);
    for _ in 0..ITERATIONS {
        // Rounding does not move the last step off the limit.
        let is_last = (limit - positive).abs() <= step.abs() * (1.0 + 1e-12);
        let next = if is_last { limit } else { positive + step };
        let next_value = function(next);
        if next_value.abs() <= tolerance {
            return Some(next);
        }
        if next_value < 0.0 {
            return Some(bracketed_root(positive, next, tolerance, function));
        }
        if is_last || next_value.is_nan() {
            return None;
        }
        // The secant, slightly longer so that it brackets the root; at least twice the last step if it does not fall.
        let fall = value - next_value;
        let secant = if fall > 0.0 { 1.001 * next_value / fall * step } else { f64::INFINITY * step };
        step = if secant.abs() < 1e3 * step.abs() { secant } else { 1e3 * step };
        (positive, value) = (next, next_value);
    }
    None
}

/// First step of [`nearby_root`] over the way to the limit.
const FIRST_STEP: f64 = 1e-4;

#[cfg(test)]
mod tests {
    use super::{bracketed_root, nearby_root};

    #[test]
    fn nearby_root_is_the_first_one_or_none() {
        let function = |x: f64| (x - 0.7).powi(2) - 0.01;
        let found = nearby_root(1.0, function(1.0), 0.0, 1e-14, function);
        assert!(found.is_some_and(|x| (x - 0.8).abs() < 1e-9), "{found:?}");
        assert_eq!(nearby_root(1.0, 0.5, 0.0, 1e-14, |x| x * x + 0.5), None);
        let steep = nearby_root(1.0, 1.0, 0.0, 1e-12, |x| 1e6 * (x - 1.0) + 1.0);
        assert!(steep.is_some_and(|x| (x - 0.999_999).abs() < 1e-12), "{steep:?}");
    }

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
