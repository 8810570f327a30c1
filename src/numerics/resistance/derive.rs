//! Computes the constants of `*CAVITY EXPANSION`: pressures over a range of velocities, and the law fitted to them.

use super::ResistanceError;
use super::fit::{self, FitForm, FitWeight, ResistanceFit};
use super::similarity::{CavityPressure, ExpandingCavity};
use super::target::ScaledTarget;

/// Default number of velocities at which the pressure is computed.
pub const POINTS: usize = 41;

/// Velocity range and options of the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitRequest {
    /// Range of velocities, in the units of the material.
    pub range: [f64; 2],
    /// Number of equally spaced velocities, including both ends.
    pub points: usize,
    /// Whether B is fitted; otherwise B = 0.
    pub linear: bool,
    /// Whether A is set to the quasi-static pressure, which is independent of strain rate.
    pub pinned: bool,
    /// Weights of the least-squares fit.
    pub weight: FitWeight,
}

impl FitRequest {
    /// Creates a request for three constants over a range, with equal weights.
    pub fn over(range: [f64; 2]) -> FitRequest {
        FitRequest { range, points: POINTS, linear: true, pinned: false, weight: FitWeight::Even }
    }
}

/// Fitted resistance law of a target.
#[derive(Clone, Debug)]
pub struct DerivedResistance {
    /// A, B, C as on the card, rounded to six digits.
    pub constants: [f64; 3],
    /// Result of the least-squares fit.
    pub fit: ResistanceFit,
    /// Quasi-static pressure divided by Y.
    pub static_pressure: f64,
    /// Pressures over the velocity range.
    pub points: Vec<CavityPressure>,
    /// Largest relative difference of the law from a pressure, and its velocity.
    pub worst: [f64; 2],
}

/// Computes the pressures of a target and fits the resistance law.
pub fn derive(target: &ScaledTarget, request: &FitRequest) -> Result<DerivedResistance, ResistanceError> {
    let [from, to] = request.range;
    if !(from >= 0.0 && to > from && to.is_finite()) {
        return Err(ResistanceError::Range(format!("invalid velocity range {from} to {to}: expected 0 <= from < to")));
    }
    if !(5..=100_000).contains(&request.points) {
        return Err(ResistanceError::Range(format!("{} points: a fit needs 5 to 100000", request.points)));
    }
    let expansion = ExpandingCavity::new(target)?;
    let still = expansion.pressure(0.0)?.stress;
    let step = (to - from) / (request.points - 1) as f64;
    let velocity = |i: usize| if i + 1 == request.points { to } else { from + step * i as f64 };
    // The highest velocity first: if it is too high, the error names the limit.
    expansion.pressure(to)?;
    let points: Vec<CavityPressure> =
        (0..request.points).map(|i| expansion.pressure(velocity(i))).collect::<Result<_, _>>()?;
    let pairs: Vec<[f64; 2]> = points.iter().map(|p| [p.velocity / target.velocity, p.stress]).collect();
    let pinned = request.pinned.then_some(still);
    let fit = fit::fit(&pairs, FitForm { linear: request.linear, pinned, weight: request.weight })?;
    let constants = fit.constants.map(six_digits);
    let off = |p: &CavityPressure| [fit::law(constants, p.velocity / target.velocity) / p.stress - 1.0, p.velocity];
    let worst = points.iter().map(off).fold([0.0, from], |w, o| if o[0].abs() > w[0].abs() { o } else { w });
    Ok(DerivedResistance { constants, fit, static_pressure: still, points, worst })
}

/// Rounds a number to six significant digits.
fn six_digits(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
