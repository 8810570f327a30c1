//! A spherical cavity that opens at a constant velocity in an unbounded compressible target: elastic, cracked and plastic zones
//! that grow alike.
//!
//! Compression is positive, lengths are r/(c t) with c the speed of the plastic front, stresses by Y, densities by rho0, and
//! m = rho0 c^2 / Y. With u = v/c and w = x - u mass, momentum and p = K (1 - rho0/rho) are
//! u' = w rho'/rho - 2 u/x and s' = -2 tau/x + rho m w u', s = p + 2 tau/3. Along the label l = ln(r0/(c t)), which removes the
//! singularity at the cavity, dx/dl = w; and mass gives w = x exp(-D), where D = ln rho + 3 ln(r/r0) is the difference of the
//! logarithmic strains around and along a radius. So D, which grows without bound towards the cavity, leaves two unknowns, ln x
//! and s; the strain q of the stress-strain curve, which is a function of D, is what is integrated over: kinks of a table are
//! met exactly, and neither the cavity, a cavity at rest nor incompressibility is singular.

use super::ResistanceError;
use super::front::{PlasticFront, front};
use super::integrate::{WALL, integrate};
use super::overstress;
use super::root;
use super::target::Target;

/// Relative error of the velocity that is met, and the one that is believed where rounding lets none nearer.
const FOUND: f64 = 1e-11;
const ROUGHLY: f64 = 1e-9;

/// The pressure on a cavity at one velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Velocity at which the cavity opens, in the units of the material.
    pub velocity: f64,
    /// Radial stress on its wall over Y.
    pub stress: f64,
    /// Radius of the plastic front over that of the cavity.
    pub plastic: f64,
    /// Radius of the front of cracks over that of the cavity, where there is one.
    pub cracked: Option<f64>,
}

/// A solution at a speed of the plastic front.
#[derive(Clone, Copy, Debug)]
struct SimilarityZones {
    front: PlasticFront,
    /// Radius of the cavity over that of the plastic front.
    cavity: f64,
    /// Radial stress on its wall over Y.
    stress: f64,
}

/// A target around a cavity.
pub struct Expansion<'a> {
    target: &'a Target,
    still: SimilarityZones,
}

impl<'a> Expansion<'a> {
    /// Around a cavity at rest.
    pub fn new(target: &'a Target) -> Result<Self, ResistanceError> {
        Ok(Expansion { target, still: zones(target, 0.0)? })
    }

    /// The pressure on a cavity that opens at a velocity, rates included.
    ///
    /// # Errors
    /// `C002` where the plastic front would be a shock, `C004` where the plastic zone cannot be followed.
    pub fn pressure(&self, velocity: f64) -> Result<Point, ResistanceError> {
        let zones = if velocity == 0.0 { self.still } else { self.opened(velocity)? };
        let rate = self.target.rate.as_ref();
        let rates = rate.map_or(Ok(0.0), |rate| overstress::gain(self.target, rate, velocity))?;
        let plastic = 1.0 / zones.cavity;
        let cracked = zones.front.crack.map(|eta| eta * plastic);
        Ok(Point { velocity, stress: zones.stress + rates, plastic, cracked })
    }

    /// The zones of a cavity that opens at a velocity. The front is faster than the cavity and, but for the jump where cracks end,
    /// slower than in proportion to a cavity at rest; and the cavity that belongs to that front is larger than its own.
    fn opened(&self, velocity: f64) -> Result<SimilarityZones, ResistanceError> {
        let target = self.target;
        let v = velocity / target.velocity;
        let mut last = Err(ResistanceError::Lost("there are no zones".into()));
        let mut excess = |c: f64| {
            last = zones(target, c * c);
            last.as_ref().ok().map(|zones| c * zones.cavity - v)
        };
        let mut high = (1.0001 * v / self.still.cavity, None);
        high.1 = excess(high.0);
        while high.1.is_some_and(|value| value < 0.0) {
            high.0 *= 1.5;
            high.1 = excess(high.0);
        }
        let near = high.1.map(|value| v * high.0 / (value + v));
        let near = near.map(|c| (c, excess(c))).filter(|low| low.1.is_some_and(|value| value < 0.0));
        let low = near.unwrap_or_else(|| (v, excess(v)));
        let [low, high] = root::bracketed(&mut excess, [low, high], FOUND * v);
        if low == high && last.is_ok() {
            return last;
        }
        match (zones(target, low * low), zones(target, high * high)) {
            (Ok(zones), _) if (low * zones.cavity / v - 1.0).abs() < ROUGHLY => Ok(zones),
            // The bracket closed on the end of cracks, where the cavity's velocity jumps.
            (Ok(_), Ok(beyond)) => Ok(beyond),
            (Err(lost @ ResistanceError::Lost(_)), _) | (_, Err(lost @ ResistanceError::Lost(_))) => Err(lost),
            _ => Err(ResistanceError::Fast { velocity, fastest: fastest(target, high)? }),
        }
    }
}

/// The velocity at which cavities end whose plastic front is no shock, below a front of the speed c over sqrt(Y/rho).
fn fastest(target: &Target, c: f64) -> Result<f64, ResistanceError> {
    let still_runs = |c: f64| zones(target, c * c).ok().map(|_| -1.0);
    let [low, _] = root::between(still_runs, [1e-6 * c, c], 0.0);
    // Three digits downwards: what is told must be what can be had.
    let velocity = low * zones(target, low * low)?.cavity * target.velocity;
    let unit = libm::pow(10.0, libm::floor(libm::log10(velocity)) - 2.0);
    Ok(unit * libm::floor(velocity / unit))
}

/// The zones at m = rho c^2 / Y.
fn zones(target: &Target, m: f64) -> Result<SimilarityZones, ResistanceError> {
    let too_fast = || ResistanceError::Fast { velocity: m.sqrt() * target.velocity, fastest: 0.0 };
    let front = front(target, m).ok_or_else(too_fast)?;
    let offset = front.shear_strain - target.shear_strain(front.strain)[0];
    let plastic = PlasticZone { target, m, offset };
    // A front that is faster than the plastic wave is a shock.
    if plastic.stiffness(&plastic.state(front.strain, [0.0, front.stress])) <= 0.0 {
        return Err(too_fast());
    }
    let wall = target.strain_at(WALL - offset);
    let slope = |q: f64, y: &[f64; 2]| plastic.slope(q, *y);
    let [log_x, stress] = integrate(&slope, [front.strain, wall], target, [0.0, front.stress])?;
    Ok(SimilarityZones { front, cavity: libm::exp(log_x), stress })
}

struct PlasticZone<'a> {
    target: &'a Target,
    m: f64,
    /// D at the front beyond what the curve makes of the strain there: cracks that have closed.
    offset: f64,
}

/// What is known at a strain.
struct PlasticState {
    /// exp(-D), which is w/x.
    closes: f64,
    /// u/x.
    opens: f64,
    /// w^2.
    square: f64,
    /// tau.
    shear: f64,
    /// rho.
    density: f64,
    /// d tau / d D at constant pressure.
    hardening: f64,
    /// d D / d ln q.
    straining: f64,
}

impl PlasticZone<'_> {
    fn state(&self, q: f64, [log_x, stress]: [f64; 2]) -> PlasticState {
        let target = self.target;
        let [flow, slope] = target.flow(q);
        let [strain, strain_slope] = target.shear_strain_of(q, [flow, slope]);
        let strain = strain + self.offset;
        let pressure = (stress - 2.0 / 3.0 * flow) / self.grows();
        let (closes, x) = (libm::exp(-strain), libm::exp(log_x));
        PlasticState {
            closes,
            opens: -libm::expm1(-strain),
            square: (x * closes) * (x * closes),
            shear: flow + target.pressure_slope * pressure,
            density: 1.0 / (1.0 - target.compressibility * pressure),
            hardening: slope / strain_slope,
            straining: q * strain_slope,
        }
    }

    /// d s / d p at constant hardening.
    fn grows(&self) -> f64 {
        1.0 + 2.0 / 3.0 * self.target.pressure_slope
    }

    /// What the pressure's slope along the label is divided by.
    fn stiffness(&self, at: &PlasticState) -> f64 {
        let k = at.density * self.target.compressibility;
        self.grows() + 2.0 / 3.0 * at.hardening * k - at.density * self.m * at.square * k
    }

    /// Slopes of ln x and s over ln q; not a number where the zone ends.
    fn slope(&self, q: f64, y: [f64; 2]) -> [f64; 2] {
        let at = self.state(q, y);
        let stiffness = self.stiffness(&at);
        let inertia = at.density * self.m * at.square;
        let load = -2.0 * at.shear * at.closes - 2.0 * inertia * at.opens + 2.0 * at.hardening * at.opens;
        let pressure = load / stiffness;
        let denser = at.density * self.target.compressibility * pressure;
        let strained = denser - 3.0 * at.opens;
        let stress = -2.0 * at.shear * at.closes + inertia * (denser - 2.0 * at.opens);
        if !(stiffness > 0.0 && at.density > 0.0 && strained < 0.0) {
            return [f64::NAN; 2];
        }
        let per_strain = at.straining / strained;
        [at.closes * per_strain, stress * per_strain]
    }
}
