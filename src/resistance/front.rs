//! What lies in front of the plastic zone, in closed form: an elastic zone alone, or one that has cracked along rays.

use super::cracked;
use super::target::Target;

/// The target just behind the plastic front, which runs at the speed c: stress over Y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlasticFront {
    /// Radial stress, compression positive.
    pub stress: f64,
    /// ln(rho/rho0) + 3 ln(r/r0): what the shell of a material point has been sheared by.
    pub shear_strain: f64,
    /// Strain q of the stress-strain curve.
    pub strain: f64,
    /// Speed of the front of the cracks over c.
    pub crack: Option<f64>,
}

/// Numbers of an elastic zone in front of what runs at c, with m = rho c^2 / Y.
pub struct ElasticZone {
    /// c over the speed of dilatational waves.
    pub mach: f64,
    /// K / (K + 4G/3).
    pub bulk_share: f64,
}

impl ElasticZone {
    /// `None` if c is not below the speed of dilatational waves.
    pub fn new(target: &Target, m: f64) -> Option<ElasticZone> {
        let bulk_share = 1.0 / (1.0 + 4.0 / 3.0 * target.shear * target.compressibility);
        let mach = (m * target.compressibility * bulk_share).sqrt();
        (mach < 1.0).then_some(ElasticZone { mach, bulk_share })
    }
}

/// The front at m; `None` where it runs too fast for there to be one.
pub fn front(target: &Target, m: f64) -> Option<PlasticFront> {
    let plain = elastic(target, m)?;
    match target.tension.filter(|tension| -plain.hoop > *tension) {
        Some(tension) => Some(cracked::front(target, m, tension).unwrap_or(plain.front)),
        None => Some(plain.front),
    }
}

struct ElasticFront {
    front: PlasticFront,
    /// Stress around, compression positive.
    hoop: f64,
}

/// The spherical wave u = a0 (s^3/r^2 - 3 s + 2 r), s = c_d t, whose Mises stress reaches the yield stress at r = c t. Velocity and
/// radial stress pass the front without a jump. The convective acceleration, which a wave of small strains leaves out, takes
/// rho v^2/2 from the stress, so that an incompressible target has 3/2 rho V^2 exactly.
fn elastic(target: &Target, m: f64) -> Option<ElasticFront> {
    let ElasticZone { mach, bulk_share } = ElasticZone::new(target, m)?;
    // Pressure over Mises stress.
    let pressure = m * bulk_share / (target.shear * (1.0 + mach));
    let mises = 1.0 / (1.0 - target.pressure_slope * pressure);
    let velocity = 0.5 * mises / target.shear;
    if !(0.0..1.0).contains(&velocity) {
        return None;
    }
    let shear_strain = -libm::log1p(-velocity);
    let strain = target.strain_at(shear_strain);
    let stress = mises * (pressure + 2.0 / 3.0) - 0.5 * m * velocity * velocity;
    let front = PlasticFront { stress, shear_strain, strain, crack: None };
    Some(ElasticFront { front, hoop: mises * (pressure - 1.0 / 3.0) })
}
