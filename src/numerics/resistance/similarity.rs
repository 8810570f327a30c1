//! Similarity solution of a spherical or cylindrical cavity that opens at a constant velocity in an unbounded compressible target with
//! elastic, cracked and plastic zones.
//!
//! Compression is positive. Lengths are x = r/(c t) with the speed c of the plastic front, stresses are divided by Y,
//! densities by rho0, and m = rho0 c^2 / Y. With u = v/c and w = x - u, mass, momentum and p = K (1 - rho0/rho) give u'
//! = w rho'/rho - g u/x and s' = -f (g + 1) tau/x + rho m w u', s = p + f tau, with g and f of the shape. The material label l = ln(r0/(c t)) with dx/dl
//! = w removes the singularity at the cavity wall. Mass gives w = x exp(-D), where D = ln rho + (g + 1) ln(r/r0) is the
//! difference of the logarithmic hoop and radial strains. The unknowns are ln x and s; D tends to infinity at the
//! cavity wall. The integration variable is the strain q of the stress-strain curve, a function of D: the kinks of a
//! table are then resolved exactly, and neither the wall nor a static cavity nor incompressibility is singular.

use super::ResistanceError;
use super::front::{PlasticFront, front};
use super::integrate::{WALL, integrate};
use super::overstress;
use super::root;
use super::target::ScaledTarget;

/// Relative tolerance of the cavity velocity, and the largest error that is accepted if rounding prevents a smaller
/// one.
const VELOCITY_TOLERANCE: f64 = 1e-11;
const ACCEPTED_ERROR: f64 = 1e-9;

/// Pressure on a cavity at one velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CavityPressure {
    /// Velocity of the cavity wall, in the units of the material.
    pub velocity: f64,
    /// Radial stress on the cavity wall divided by Y.
    pub stress: f64,
    /// Radius of the plastic front divided by the cavity radius.
    pub plastic: f64,
    /// Radius of the crack front divided by the cavity radius; `None` without cracks.
    pub cracked: Option<f64>,
}

/// Solution for one speed of the plastic front.
#[derive(Clone, Copy, Debug)]
struct SimilarityZones {
    front: PlasticFront,
    /// Cavity radius divided by the radius of the plastic front.
    cavity: f64,
    /// Radial stress on the cavity wall divided by Y.
    stress: f64,
}

/// Expansion of a cavity in a target.
pub struct ExpandingCavity<'a> {
    target: &'a ScaledTarget,
    at_rest: SimilarityZones,
}

impl<'a> ExpandingCavity<'a> {
    /// Creates the expansion and solves the static case.
    pub fn new(target: &'a ScaledTarget) -> Result<Self, ResistanceError> {
        Ok(ExpandingCavity { target, at_rest: zones(target, 0.0)? })
    }

    /// Returns the pressure on a cavity that opens at a velocity, including strain-rate dependence.
    ///
    /// # Errors
    /// `C002` if the plastic front would be a shock, `C004` if the plastic zone cannot be integrated.
    pub fn pressure(&self, velocity: f64) -> Result<CavityPressure, ResistanceError> {
        let zones = if velocity == 0.0 { self.at_rest } else { self.opened(velocity)? };
        let rate = self.target.rate.as_ref();
        let rates = rate.map_or(Ok(0.0), |rate| overstress::gain(self.target, rate, velocity))?;
        let plastic = 1.0 / zones.cavity;
        let cracked = zones.front.crack.map(|eta| eta * plastic);
        Ok(CavityPressure { velocity, stress: zones.stress + rates, plastic, cracked })
    }

    /// Returns the solution for a cavity velocity. Bracket of the front speed: it is larger than the cavity velocity
    /// and, except at the transition where cracks end, smaller than the cavity velocity times the ratio of the radii in
    /// the static case.
    fn opened(&self, velocity: f64) -> Result<SimilarityZones, ResistanceError> {
        let target = self.target;
        let v = velocity / target.velocity;
        let mut last = Err(ResistanceError::Lost("no solution was found".into()));
        let mut excess = |c: f64| {
            last = zones(target, c * c);
            last.as_ref().ok().map(|zones| c * zones.cavity - v)
        };
        let mut high = (1.0001 * v / self.at_rest.cavity, None);
        high.1 = excess(high.0);
        while high.1.is_some_and(|value| value < 0.0) {
            high.0 *= 1.5;
            high.1 = excess(high.0);
        }
        let near = high.1.map(|value| v * high.0 / (value + v));
        let near = near.map(|c| (c, excess(c))).filter(|low| low.1.is_some_and(|value| value < 0.0));
        let low = near.unwrap_or_else(|| (v, excess(v)));
        let [low, high] = root::bracketed(&mut excess, [low, high], VELOCITY_TOLERANCE * v);
        if low == high && last.is_ok() {
            return last;
        }
        match (zones(target, low * low), zones(target, high * high)) {
            (Ok(zones), _) if (low * zones.cavity / v - 1.0).abs() < ACCEPTED_ERROR => Ok(zones),
            // The bracket has converged to the transition where cracks end; the cavity velocity is discontinuous there.
            (Ok(_), Ok(beyond)) => Ok(beyond),
            (Err(lost @ ResistanceError::Lost(_)), _) | (_, Err(lost @ ResistanceError::Lost(_))) => Err(lost),
            _ => Err(ResistanceError::Fast { velocity, fastest: fastest(target, high)? }),
        }
    }
}

/// Returns the largest cavity velocity whose plastic front is not a shock; `c` is a front speed above it, divided by
/// sqrt(Y/rho).
fn fastest(target: &ScaledTarget, c: f64) -> Result<f64, ResistanceError> {
    let still_runs = |c: f64| zones(target, c * c).ok().map(|_| -1.0);
    let [low, _] = root::between(still_runs, [1e-6 * c, c], 0.0);
    // Rounded down to three digits, so that the stated velocity has a solution.
    let velocity = low * zones(target, low * low)?.cavity * target.velocity;
    let unit = libm::pow(10.0, libm::floor(libm::log10(velocity)) - 2.0);
    Ok(unit * libm::floor(velocity / unit))
}

/// Returns the solution at m = rho c^2 / Y.
fn zones(target: &ScaledTarget, m: f64) -> Result<SimilarityZones, ResistanceError> {
    let too_fast = || ResistanceError::Fast { velocity: m.sqrt() * target.velocity, fastest: 0.0 };
    let front = front(target, m).ok_or_else(too_fast)?;
    let offset = front.shear_strain - target.shear_strain(front.strain)[0];
    let plastic = PlasticZone { target, m, offset };
    // A front that is faster than the plastic wave is a shock wave.
    if plastic.stiffness(&plastic.state(front.strain, [0.0, front.stress])) <= 0.0 {
        return Err(too_fast());
    }
    let wall = target.strain_at(WALL - offset);
    let slope = |q: f64, y: &[f64; 2]| plastic.slope(q, *y);
    let [log_x, stress] = integrate(&slope, [front.strain, wall], target, [0.0, front.stress])?;
    Ok(SimilarityZones { front, cavity: libm::exp(log_x), stress })
}

struct PlasticZone<'a> {
    target: &'a ScaledTarget,
    m: f64,
    /// Difference between D at the front and D by the stress-strain curve; nonzero if cracks have closed at the front.
    offset: f64,
}

/// Dimensionless state of the plastic zone at a strain q.
struct PlasticState {
    /// exp(-D), which is w/x.
    velocity_ratio: f64,
    /// Velocity ratio u/x.
    opens: f64,
    /// Squared relative velocity w^2.
    square: f64,
    /// Yield stress tau.
    shear: f64,
    /// Density rho.
    density: f64,
    /// d tau / d D at constant pressure.
    hardening: f64,
    /// d D / d ln q.
    straining: f64,
}

impl PlasticZone<'_> {
    /// Equation (2.7).
    fn state(&self, q: f64, [log_x, stress]: [f64; 2]) -> PlasticState {
        let target = self.target;
        let [flow, slope] = target.flow(q);
        let [strain, strain_slope] = target.shear_strain_of(q, [flow, slope]);
        let strain = strain + self.offset;
        let pressure = (stress - target.shape.deviator() * flow) / self.pressure_factor();
        let (closes, x) = (libm::exp(-strain), libm::exp(log_x));
        PlasticState {
            velocity_ratio: closes,
            opens: -libm::expm1(-strain),
            square: (x * closes) * (x * closes),
            shear: flow + target.pressure_slope * pressure,
            density: 1.0 / (1.0 - target.compressibility * pressure),
            hardening: slope / strain_slope,
            straining: q * strain_slope,
        }
    }

    /// Returns d s / d p at constant hardening.
    fn pressure_factor(&self) -> f64 {
        1.0 + self.target.shape.deviator() * self.target.pressure_slope
    }

    /// Returns the denominator of the slope of pressure over the label.
    fn stiffness(&self, at: &PlasticState) -> f64 {
        let k = at.density * self.target.compressibility;
        self.pressure_factor() + self.target.shape.deviator() * at.hardening * k - at.density * self.m * at.square * k
    }

    /// Returns the slopes of ln x and s over ln q; NaN where there is no solution. Equations (2.6), (2.12).
    fn slope(&self, q: f64, y: [f64; 2]) -> [f64; 2] {
        let state = self.state(q, y);
        let stiffness = self.stiffness(&state);
        let inertia = state.density * self.m * state.square;
        let (hoops, divergence) = (self.target.shape.hoops(), self.target.shape.divergence());
        let softens = -divergence * state.shear * state.velocity_ratio;
        let load = softens - hoops * inertia * state.opens + divergence * state.hardening * state.opens;
        let pressure = load / stiffness;
        let denser = state.density * self.target.compressibility * pressure;
        let strained = denser - (hoops + 1.0) * state.opens;
        let stress = softens + inertia * (denser - hoops * state.opens);
        if !(stiffness > 0.0 && state.density > 0.0 && strained < 0.0) {
            return [f64::NAN; 2];
        }
        let per_strain = state.straining / strained;
        [state.velocity_ratio * per_strain, stress * per_strain]
    }
}
