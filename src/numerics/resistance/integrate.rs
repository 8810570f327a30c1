//! Integration through the plastic zone, from the front to the cavity wall, over the strain.

use super::ResistanceError;
use super::target::ScaledTarget;

/// Difference of the logarithmic strains at which the integration ends; the relative distance to the cavity wall is
/// then exp(-36), below rounding.
pub const WALL: f64 = 36.0;
/// Relative and absolute error tolerance of a step.
const TOLERANCE: f64 = 1e-11;
/// Smallest step of ln q; smaller steps are below the rounding of a strain.
const LEAST: f64 = 1e-13;
/// Largest number of steps between two kinks; a smooth zone needs about twenty.
const STEPS: usize = 2000;
/// Initial step of ln q; between two kinks it is often the only one.
const FIRST: f64 = 0.3;
/// Numbers of substeps of the midpoint rule.
const DIVISIONS: [usize; 5] = [2, 4, 6, 8, 10];
/// Order of the error estimate in the step size.
const ERROR_ORDER: f64 = 9.0;

/// Integrates `dy / d ln q = slope(q, y)` between two values of q, piecewise between the kinks of the stress-strain
/// curve.
pub fn integrate<const N: usize>(
    slope: &impl Fn(f64, &[f64; N]) -> [f64; N],
    [from, to]: [f64; 2],
    target: &ScaledTarget,
    mut y: [f64; N],
) -> Result<[f64; N], ResistanceError> {
    let mut start = from;
    for next in target.kinks([from, to]).chain([to]) {
        // Rounding must not move q across a kink.
        let smooth = |log_q: f64, y: &[f64; N]| slope(libm::exp(log_q).clamp(start, next.next_down()), y);
        y = integrate_smooth(&smooth, [libm::log(start), libm::log(next)], y).ok_or_else(|| {
            let [from, to] = [start, next].map(|q| q / target.young);
            ResistanceError::Lost(format!(
                "the step size becomes too small between the strains {from:.3e} and {to:.3e}"
            ))
        })?;
        start = next;
    }
    Ok(y)
}

/// Integrates a smooth slope with error control; `None` if the step size becomes too small.
fn integrate_smooth<const N: usize>(
    slope: &impl Fn(f64, &[f64; N]) -> [f64; N],
    [mut x, end]: [f64; 2],
    mut y: [f64; N],
) -> Option<[f64; N]> {
    let mut step = FIRST;
    for _ in 0..STEPS {
        if end - x < LEAST {
            return Some(y);
        }
        if step < LEAST {
            return None;
        }
        let tried = step.min(end - x);
        let (next, error) = extrapolated_step(slope, [x, tried], &y);
        if error <= 1.0 {
            x += tried;
            y = next;
        }
        let factor = if error.is_nan() { 0.0 } else { 0.9 * libm::pow(error, -1.0 / ERROR_ORDER) };
        step = tried * factor.clamp(0.2, 5.0);
    }
    None
}

/// Returns the value after a step and its estimated error divided by the tolerance, by the midpoint rule with
/// Aitken-Neville extrapolation (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, section II.9).
fn extrapolated_step<const N: usize>(
    slope: &impl Fn(f64, &[f64; N]) -> [f64; N],
    [x, step]: [f64; 2],
    y: &[f64; N],
) -> ([f64; N], f64) {
    let first = slope(x, y);
    let mut row = [[0.0; N]; DIVISIONS.len()];
    for (i, parts) in DIVISIONS.into_iter().enumerate() {
        let mut value = midpoint_rule(slope, [x, step], parts, y, &first);
        for k in 0..i {
            let ratio = parts as f64 / DIVISIONS[i - 1 - k] as f64;
            let change = (0..N).map(|c| (value[c] - row[k][c]) / (ratio * ratio - 1.0));
            let mut next = value;
            next.iter_mut().zip(change).for_each(|(next, change)| *next += change);
            row[k] = value;
            value = next;
        }
        row[i] = value;
    }
    let [.., previous, last] = row;
    let scaled = |c: usize| (last[c] - previous[c]).abs() / (TOLERANCE * (1.0 + last[c].abs().max(y[c].abs())));
    // The comparison keeps NaN, unlike `max`.
    let error = (0..N).map(scaled).fold(0.0, |most: f64, e| if e <= most { most } else { e });
    (last, error)
}

/// Integrates with Gragg's midpoint rule, whose error expansion has only even powers of the substep; `first` is the
/// slope at the start.
fn midpoint_rule<const N: usize>(
    slope: &impl Fn(f64, &[f64; N]) -> [f64; N],
    [x, step]: [f64; 2],
    parts: usize,
    y: &[f64; N],
    first: &[f64; N],
) -> [f64; N] {
    let length = step / parts as f64;
    let ahead = |from: &[f64; N], length: f64, slope: &[f64; N]| {
        let mut y = *from;
        y.iter_mut().zip(slope).for_each(|(y, slope)| *y += length * slope);
        y
    };
    let (mut previous, mut current) = (*y, ahead(y, length, first));
    for part in 1..parts {
        let next = ahead(&previous, 2.0 * length, &slope(x + part as f64 * length, &current));
        (previous, current) = (current, next);
    }
    current
}

#[cfg(test)]
mod tests {
    use super::integrate_smooth;

    /// Source: y'' = -y has the solution (cos x, -sin x).
    #[test]
    fn oscillation_has_exact_phase_and_amplitude() {
        let end = integrate_smooth(&|_, y: &[f64; 2]| [y[1], -y[0]], [0.0, 10.0], [1.0, 0.0]).expect("a solution");
        let errors = [end[0] - libm::cos(10.0), end[1] + libm::sin(10.0)];
        assert!(errors.iter().all(|e| e.abs() < 1e-9), "{errors:?}");
    }

    /// Source: y' = y^2 has the solution 1/(1 - x), which ends at x = 1.
    #[test]
    fn integration_stops_at_a_pole() {
        let slope = |_: f64, y: &[f64; 1]| [y[0] * y[0]];
        let [near] = integrate_smooth(&slope, [0.0, 0.99], [1.0]).expect("a solution");
        assert!((near / 100.0 - 1.0).abs() < 1e-7, "{near}");
        assert_eq!(integrate_smooth(&slope, [0.0, 1.5], [1.0]), None);
    }
}
