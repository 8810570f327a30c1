//! Computes the constants of `*CAVITY EXPANSION`: pressures over a range of velocities, and the law fitted to them.

use super::ResistanceError;
use super::fit::{self, FitForm, FitWeight, ResistanceFit};
use super::similarity::{CavityPressure, ExpandingCavity};
use super::target::{CavityShape, ScaledTarget};

/// Function from the velocity of a cavity to its pressure.
pub type PressureOfVelocity<'a> = Box<dyn Fn(f64) -> Result<CavityPressure, ResistanceError> + 'a>;

/// Target in which a cavity can open.
pub trait ExpansionTarget {
    /// Returns what makes pressures and velocities dimensionless.
    fn scale(&self) -> TargetScale;

    /// Returns the number of velocities at which the pressure is computed by default.
    fn default_points(&self) -> usize;

    /// Returns the pressure as a function of the velocity.
    ///
    /// # Errors
    /// If the target has no pressure even at rest.
    fn pressures(&self) -> Result<PressureOfVelocity<'_>, ResistanceError>;
}

/// Shape of a cavity and what makes its pressure and velocity dimensionless, in the units of the material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetScale {
    /// Shape of the cavity.
    pub shape: CavityShape,
    /// Reference stress Y.
    pub yield_stress: f64,
    /// Density.
    pub density: f64,
}

impl TargetScale {
    /// Returns the reference velocity sqrt(Y/rho).
    pub fn velocity(self) -> f64 {
        (self.yield_stress / self.density).sqrt()
    }
}

impl ExpansionTarget for ScaledTarget {
    fn scale(&self) -> TargetScale {
        TargetScale { shape: self.shape, yield_stress: self.yield_stress, density: self.density }
    }

    fn default_points(&self) -> usize {
        41
    }

    fn pressures(&self) -> Result<PressureOfVelocity<'_>, ResistanceError> {
        let expansion = ExpandingCavity::new(self)?;
        Ok(Box::new(move |velocity| expansion.pressure(velocity)))
    }
}

/// Velocity range and options of the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FitRequest {
    /// Range of velocities, in the units of the material.
    pub range: [f64; 2],
    /// Number of equally spaced velocities, including both ends; `None` for that of the target.
    pub points: Option<usize>,
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
        FitRequest { range, points: None, linear: true, pinned: false, weight: FitWeight::Even }
    }
}

/// Fitted resistance law of a target.
#[derive(Clone, Debug)]
pub struct DerivedResistance {
    /// A, B, C as on the card, rounded to six digits.
    pub constants: [f64; 3],
    /// Result of the least-squares fit.
    pub fit: ResistanceFit,
    /// Quasi-static pressure divided by Y; NaN if the target has none and the range does not begin at rest.
    pub static_pressure: f64,
    /// Pressures over the velocity range.
    pub points: Vec<CavityPressure>,
    /// Largest relative difference of the law from a pressure, and its velocity.
    pub worst: [f64; 2],
}

/// Computes the pressures of a target and fits the resistance law.
pub fn derive(target: &dyn ExpansionTarget, request: &FitRequest) -> Result<DerivedResistance, ResistanceError> {
    let [from, to] = request.range;
    if !(from >= 0.0 && to > from && to.is_finite()) {
        return Err(ResistanceError::Range(format!("invalid velocity range {from} to {to}: expected 0 <= from < to")));
    }
    let count = request.points.unwrap_or(target.default_points());
    if !(5..=100_000).contains(&count) {
        return Err(ResistanceError::Range(format!("{count} points: a fit needs 5 to 100000")));
    }
    let pressure = target.pressures()?;
    let still = match pressure(0.0) {
        Err(ResistanceError::Unsteady { .. }) if from > 0.0 && !request.pinned => f64::NAN,
        at_rest => at_rest?.stress,
    };
    let scale = target.scale().velocity();
    let step = (to - from) / (count - 1) as f64;
    let velocity = |i: usize| if i + 1 == count { to } else { from + step * i as f64 };
    // The highest velocity first: if it is too high, the error names the limit.
    pressure(to)?;
    let points: Vec<CavityPressure> = (0..count).map(|i| pressure(velocity(i))).collect::<Result<_, _>>()?;
    let pairs: Vec<[f64; 2]> = points.iter().map(|p| [p.velocity / scale, p.stress]).collect();
    let pinned = request.pinned.then_some(still);
    let fit = fit::fit(&pairs, FitForm { linear: request.linear, pinned, weight: request.weight })?;
    let constants = fit.constants.map(six_digits);
    let off = |p: &CavityPressure| [fit::law(constants, p.velocity / scale) / p.stress - 1.0, p.velocity];
    let worst = points.iter().map(off).fold([0.0, from], |w, o| if o[0].abs() > w[0].abs() { o } else { w });
    Ok(DerivedResistance { constants, fit, static_pressure: still, points, worst })
}

/// Rounds a number to six significant digits.
fn six_digits(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
