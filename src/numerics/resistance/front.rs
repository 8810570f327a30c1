//! Closed-form solution outside the plastic zone: an elastic zone, with or without radial cracks.

use super::cracked;
use super::target::{CavityShape, ScaledTarget};

/// State on the inner side of the plastic front, which moves at the speed c.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlasticFront {
    /// Radial stress divided by Y, compression positive.
    pub stress: f64,
    /// Difference D of the logarithmic hoop and radial strains.
    pub shear_strain: f64,
    /// Strain q of the stress-strain curve.
    pub strain: f64,
    /// Speed of the crack front divided by c; `None` without cracks.
    pub crack: Option<f64>,
}

/// Dimensionless numbers of the elastic zone outside a front of speed c, with m = rho c^2 / Y.
pub struct ElasticZone {
    /// c divided by the speed of dilatational waves.
    pub mach: f64,
    /// Bulk modulus divided by the longitudinal modulus, K / (K + 4G/3).
    pub bulk_share: f64,
}

impl ElasticZone {
    /// Returns `None` if c is not below the speed of dilatational waves.
    pub fn new(target: &ScaledTarget, m: f64) -> Option<ElasticZone> {
        let bulk_share = 1.0 / (1.0 + 4.0 / 3.0 * target.shear * target.compressibility);
        let mach = (m * target.compressibility * bulk_share).sqrt();
        (mach < 1.0).then_some(ElasticZone { mach, bulk_share })
    }
}

/// Returns the state at the front for m; `None` if the front is too fast.
pub fn front(target: &ScaledTarget, m: f64) -> Option<PlasticFront> {
    let elastic_front = elastic(target, m)?;
    match target.tension.filter(|tension| -elastic_front.hoop > *tension) {
        Some(tension) => Some(cracked::front(target, m, tension).unwrap_or(elastic_front.front)),
        None => Some(elastic_front.front),
    }
}

struct ElasticFront {
    front: PlasticFront,
    /// Hoop stress divided by Y, compression positive.
    hoop: f64,
}

/// Evaluates the elastic wave whose Mises stress equals the yield stress at r = c t. Velocity and radial stress are
/// continuous at the front. The convective acceleration, which the small-strain wave neglects, reduces the stress by rho
/// v^2/2. Equations (2.9), (2.14).
///
/// Spherical: u = a0 (s^3/r^2 - 3 s + 2 r), s = c_d t; an incompressible target then has exactly 3/2 rho
/// V^2. Cylindrical: u = a0 (s sinh T - r T), cosh T = s/r.
fn elastic(target: &ScaledTarget, m: f64) -> Option<ElasticFront> {
    let ElasticZone { mach, bulk_share } = ElasticZone::new(target, m)?;
    let deviator = target.shape.deviator();
    let difference = target.shape.divergence() / target.shape.hoops();
    // Radial stress less its deviator f, divided by Mises stress.
    let pressure = match target.shape {
        CavityShape::Spherical => m * bulk_share / (target.shear * (1.0 + mach)),
        CavityShape::Cylindrical => plane_pressure(m * bulk_share / target.shear, mach),
    };
    let mises = 1.0 / (1.0 - target.pressure_slope * pressure);
    let velocity = 0.5 * difference * mises / target.shear;
    if !(0.0..1.0).contains(&velocity) {
        return None;
    }
    let shear_strain = -libm::log1p(-velocity);
    let strain = target.strain_at(shear_strain);
    let stress = mises * (pressure + deviator) - 0.5 * m * velocity * velocity;
    let front = PlasticFront { stress, shear_strain, strain, crack: None };
    Some(ElasticFront { front, hoop: mises * (pressure + deviator - difference) })
}

/// Returns the mean in-plane stress of the cylindrical wave divided by the Mises stress. With S = sinh T and C = cosh T =
/// 1/M, the strains are k (C S - T) along the hoop and -k (C S + T) along the radius, so the ratio is (K + G/3) T / (sqrt(3)
/// G C S). `inertia` is M^2 K / G. Equation (2.14).
fn plane_pressure(inertia: f64, mach: f64) -> f64 {
    let root = (1.0 - mach * mach).sqrt();
    let angle = if mach > 0.0 { libm::log((1.0 + root) / mach) } else { 0.0 };
    (inertia + mach * mach / 3.0) * angle / (3.0_f64.sqrt() * root)
}
