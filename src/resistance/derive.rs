//! From a target to the constants of its card: pressures over a range of velocities, and the law fitted to them.

use super::ResistanceError;
use super::fit::{self, Fit, FitForm, Weight};
use super::similarity::{Expansion, Point};
use super::target::Target;

/// Velocities at which the pressure is found, where nothing else is asked for.
pub const POINTS: usize = 41;

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// Range of velocities, in the units of the material.
    pub range: [f64; 2],
    /// Velocities at equal steps, the ends included.
    pub points: usize,
    /// Whether there is a B.
    pub linear: bool,
    /// Whether A is the pressure at rest, which a strain rate does not raise.
    pub pinned: bool,
    /// Weights of the fit.
    pub weight: Weight,
}

impl Request {
    /// Three constants over a range, all points alike.
    pub fn over(range: [f64; 2]) -> Request {
        Request { range, points: POINTS, linear: true, pinned: false, weight: Weight::Even }
    }
}

/// The law of a target.
#[derive(Clone, Debug)]
pub struct Derived {
    /// A, B, C as a card has them: six digits.
    pub constants: [f64; 3],
    /// The fit itself.
    pub fit: Fit,
    /// Pressure at rest over Y.
    pub still: f64,
    /// Pressures over the range.
    pub points: Vec<Point>,
    /// The largest difference of the law from a pressure, over the pressure, and the velocity.
    pub worst: [f64; 2],
}

/// Derives the law of a target.
pub fn derive(target: &Target, request: &Request) -> Result<Derived, ResistanceError> {
    let [from, to] = request.range;
    if !(from >= 0.0 && to > from && to.is_finite()) {
        return Err(ResistanceError::Range(format!(
            "the velocities of a fit ascend from zero or above: {from} to {to} do not"
        )));
    }
    if !(5..=100_000).contains(&request.points) {
        return Err(ResistanceError::Range(format!("{} points: a fit takes 5 to 100000", request.points)));
    }
    let expansion = Expansion::new(target)?;
    let still = expansion.pressure(0.0)?.stress;
    let step = (to - from) / (request.points - 1) as f64;
    let at = |i: usize| if i + 1 == request.points { to } else { from + step * i as f64 };
    // The fastest first: where it is too fast that is all there is to say.
    expansion.pressure(to)?;
    let points: Vec<Point> = (0..request.points).map(|i| expansion.pressure(at(i))).collect::<Result<_, _>>()?;
    let pairs: Vec<[f64; 2]> = points.iter().map(|p| [p.velocity / target.velocity, p.stress]).collect();
    let pinned = request.pinned.then_some(still);
    let fit = fit::fit(&pairs, FitForm { linear: request.linear, pinned, weight: request.weight })?;
    let constants = fit.constants.map(six_digits);
    let off = |p: &Point| [fit::law(constants, p.velocity / target.velocity) / p.stress - 1.0, p.velocity];
    let worst = points.iter().map(off).fold([0.0, from], |w, o| if o[0].abs() > w[0].abs() { o } else { w });
    Ok(Derived { constants, fit, still, points, worst })
}

/// A number with the digits that a card shows.
fn six_digits(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
