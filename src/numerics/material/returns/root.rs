//! Root of a scalar function with kinks, between two bounds.

use crate::kernel::lanes::InlineMap;

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

/// Returns the root next to `start`, where the function has the positive value `first`, on the way to `limit`, which may be
/// infinite (then with a guess); `None` if the function is positive up to there. The guess is where the tangent at `start` is
/// zero. Secants through the last two points follow, with the curvature of the inverse function from the point before them
/// (inverse quadratic interpolation). Returns are short compared with the way, so that a few suffice.
#[inline(always)] // Into each law: the function is called a few times only.
pub fn nearby_root(start: Start, limit: f64, tolerance: f64, function: impl Fn(f64) -> f64) -> Option<f64> {
    nearby_state(start, limit, tolerance, |x| (function(x), ())).map(|(root, ())| root)
}

/// Returns the root of [`nearby_root`] with the state there, which the function returns with its value.
#[inline(always)] // Likewise.
pub fn nearby_state<T>(
    Start { start, first, guess }: Start,
    limit: f64,
    tolerance: f64,
    function: impl Fn(f64) -> (f64, T),
) -> Option<(f64, T)> {
    if first <= tolerance {
        return Some((start, function(start).1));
    }
    let forward = if limit < start { -1.0 } else { 1.0 };
    let (mut positive, mut last, mut last_value) = (start, start, first);
    // Bound of the way: a place where the function is negative, once there is one.
    let (mut bound, mut is_bracketed) = (limit, false);
    let mut next = guess;
    // Inverse slope between the two points before the last secant, at first the tangent, and the value at the first of them.
    let (mut inverse, mut earlier_value) = ((start - guess) / first, first);
    for iteration in 0..ITERATIONS {
        if !(forward * (next - positive) > 0.0 && forward * (bound - next) > 0.0) {
            next = inside(start, [positive, bound, next], forward, iteration == 0, is_bracketed);
            next = if next.is_nan() { limit } else { next };
        }
        let (value, state) = function(next);
        if value.abs() <= tolerance {
            return Some((next, state));
        }
        if value < 0.0 {
            (bound, is_bracketed) = (next, true);
        } else if value.is_nan() || next == limit {
            return None;
        } else {
            positive = next;
        }
        if is_bracketed && iteration >= SECANTS {
            let root = bracketed_root(positive, bound, tolerance, |x| function(x).0);
            return Some((root, function(root).1));
        }
        let slope = (next - last) / (value - last_value);
        let bend = (slope - inverse) * last_value / (value - earlier_value);
        let is_smooth = bend.abs() < SMOOTH * slope.abs();
        let candidate = next - value * if is_smooth { slope - bend } else { slope };
        // Far from the root of a function without a bound, secants may be much too long.
        let is_short = is_bracketed || (candidate - start).abs() <= LONGEST * (next - start).abs();
        (inverse, earlier_value) = (slope, last_value);
        (last, last_value) = (next, value);
        next = if is_short { candidate } else { f64::NAN };
    }
    None
}

/// Returns the argument to try in place of one outside the way; NaN for its end.
#[cold]
fn inside(start: f64, places: [f64; 3], forward: f64, is_first: bool, is_bracketed: bool) -> f64 {
    let [least, most, distance] = places.inline_map(|x| forward * (x - start));
    if is_bracketed {
        return start + forward * 0.5 * (least + most);
    }
    let longer = if is_first { FIRST_STEP * most } else { GROWTH * least };
    let longer = if is_first && distance >= most { most } else { longer };
    if longer >= most { f64::NAN } else { start + forward * longer }
}

/// Where [`nearby_root`] starts.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// Argument with a positive value.
    pub start: f64,
    /// The value.
    pub first: f64,
    /// First argument to try; any number outside the way if there is none.
    pub guess: f64,
}

/// Secants of [`nearby_root`] before a bracketed root is found in another way.
const SECANTS: usize = 8;
/// First step of [`nearby_root`] without guess, over the way; factor of later steps without secant; longest secant over the
/// distance from the start.
const FIRST_STEP: f64 = 1e-4;
const GROWTH: f64 = 8.0;
const LONGEST: f64 = 1e3;
/// Largest change of the inverse slope by its curvature, over the slope; kinks have larger ones.
const SMOOTH: f64 = 0.3;

#[cfg(test)]
mod tests {
    use super::{Start, bracketed_root, nearby_root};

    #[test]
    fn nearby_root_is_the_first_one_or_none() {
        let function = |x: f64| (x - 0.7).powi(2) - 0.01;
        for guess in [f64::NAN, 0.82, 0.99, 3.0] {
            let from = |first: f64| Start { start: 1.0, first, guess };
            let found = nearby_root(from(function(1.0)), 0.0, 1e-14, function);
            assert!(found.is_some_and(|x| (x - 0.8).abs() < 1e-9), "{found:?}");
            assert_eq!(nearby_root(from(0.5), 0.0, 1e-14, |x| x * x + 0.5), None);
            let steep = nearby_root(from(1.0), 0.0, 1e-12, |x| 1e6 * (x - 1.0) + 1.0);
            assert!(steep.is_some_and(|x| (x - 0.999_999).abs() < 1e-12), "{steep:?}");
        }
        let start = Start { start: 0.0, first: 7.0, guess: 1e-9 };
        let far = nearby_root(start, f64::INFINITY, 1e-12, |x| 7.0 - x);
        assert!(far.is_some_and(|x| (x - 7.0).abs() < 1e-11), "{far:?}");
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
