//! A target that cracks along rays where the tension around the cavity passes what it bears: between the elastic and the plastic
//! zone columns carry radial stress alone (Forrestal and Tzou 1997, Int. J. Solids Struct. 34, 4127).

use super::front::{ElasticZone, PlasticFront};
use super::root;
use super::target::Target;

/// The plastic front behind a cracked zone; `None` where the plastic front runs at least as fast as cracks would.
///
/// With lengths by c t, c the speed of the plastic front: elastic displacement A (x^-2 - 3 M^2 + 2 M^3 x) in front of the cracks at
/// x = eta; in the columns E (u'' + 2 u'/r) = rho u'', solved by N (1/x + m x / e) + L, e = E/Y. Displacement passes the cracks'
/// front without a jump, stress and velocity with that of the balance of momentum. The columns are crushed at their strength
/// without pressure around; there the cracks close, and mass and momentum are kept.
pub fn front(target: &Target, m: f64, tension: f64) -> Option<PlasticFront> {
    let elastic = ElasticZone::new(target, m)?;
    let strength = 1.0 / (1.0 - target.pressure_slope / 3.0);
    let e = target.young;
    let excess = |eta: f64| columns(target, &elastic, m, tension, eta).map(|c| c.amplitude * (e - m) - strength);
    let fastest = if m > 0.0 { (e / m).sqrt().min(1e6) } else { 1e6 };
    if fastest <= 1.0 || excess(1.0).is_none_or(|value| value >= 0.0) {
        return None;
    }
    let [eta, _] = root::between(excess, [1.0, fastest], 1e-15);
    let columns = columns(target, &elastic, m, tension, eta)?;
    let displacement = columns.amplitude * (1.0 + m / e) + columns.shift;
    if !(0.0..1.0).contains(&displacement) {
        return None;
    }
    let crushed = crush(target, m, strength, displacement, columns.shift + 2.0 * columns.amplitude)?;
    Some(PlasticFront { crack: Some(eta), ..crushed })
}

/// Displacement of the columns, N (1/x + m x / e) + L.
struct CrackedColumns {
    amplitude: f64,
    shift: f64,
}

/// The columns behind cracks that run at eta c; `None` where no tension can open cracks there.
fn columns(target: &Target, elastic: &ElasticZone, m: f64, tension: f64, eta: f64) -> Option<CrackedColumns> {
    let (mach, e, g) = (elastic.mach, target.young, target.shear);
    let cube = mach * mach * mach;
    // By the amplitude A: Mises stress, pressure, strains.
    let mises = 6.0 * g * (1.0 / (eta * eta * eta) - mach * mach / eta);
    let pressure = 6.0 * m * elastic.bulk_share * (1.0 / eta - mach);
    let hoop = mises / 3.0 - pressure;
    if hoop <= 0.0 {
        return None;
    }
    let a = tension / hoop;
    let displacement = a * eta * (1.0 / (eta * eta * eta) - 3.0 * mach * mach / eta + 2.0 * cube);
    let radial = a * 2.0 * (cube - 1.0 / (eta * eta * eta));
    let stress = a * (pressure + 2.0 / 3.0 * mises);
    let slower = 1.0 - m * eta * eta / e;
    let amplitude = eta * eta * (stress + m * eta * eta * radial) / (e * slower * slower);
    let shift = displacement - amplitude * (1.0 / eta + m * eta / e);
    (slower > 0.0).then_some(CrackedColumns { amplitude, shift })
}

/// The crushed target behind its front: all mass that was inside a shell stays inside, so 1 - u/r to the third power is both what
/// flows through the front and exp(-D) times the density.
fn crush(target: &Target, m: f64, strength: f64, displacement: f64, velocity: f64) -> Option<PlasticFront> {
    let flux = libm::pow(1.0 - displacement, 3.0);
    let grows = 1.0 + 2.0 / 3.0 * target.pressure_slope;
    let mut stress = strength;
    let mut density = 1.0;
    // The density hardly follows from the jump of stress: each round gains some digits.
    for _ in 0..60 {
        let pressure = (stress - 2.0 / 3.0) / grows;
        density = 1.0 / (1.0 - target.compressibility * pressure);
        let behind = 1.0 - flux / density;
        let next = strength + m * flux * (behind - velocity);
        let moved = (next - stress).abs();
        stress = next;
        if moved <= 1e-15 * stress.abs() {
            break;
        }
    }
    let shear_strain = libm::log(density) - 3.0 * libm::log1p(-displacement);
    (density > 0.0 && shear_strain > 0.0).then_some(PlasticFront { stress, shear_strain, strain: 1.0, crack: None })
}
