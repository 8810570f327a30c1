//! Targets with radial cracks, which form where the hoop stress exceeds the tensile strength. Between the elastic and
//! the plastic zone there is a zone of columns with radial stress only (Forrestal and Tzou 1997, Int. J. Solids Struct.
//! 34, 4127).

use super::front::{ElasticZone, PlasticFront};
use super::root;
use super::target::ScaledTarget;

/// Returns the state at the plastic front inside a cracked zone; `None` if the plastic front is at least as fast as the
/// crack front.
///
/// Lengths are divided by c t, with the speed c of the plastic front. The crack front is at x = eta. Outside it the
/// elastic displacement is A (x^-2 - 3 M^2 + 2 M^3 x). In the columns E (u'' + 2 u'/r) = rho u'' has the solution N
/// (1/x + m x / e) + L, with e = E/Y. At the crack front the displacement is continuous; stress and velocity satisfy
/// the balance of momentum. At the plastic front the columns are crushed at their unconfined strength, the cracks
/// close, and mass and momentum are conserved.
pub fn front(target: &ScaledTarget, m: f64, tension: f64) -> Option<PlasticFront> {
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
    let crushed = crushed_front(target, m, strength, displacement, columns.shift + 2.0 * columns.amplitude)?;
    Some(PlasticFront { crack: Some(eta), ..crushed })
}

/// Constants of the displacement of the columns, N (1/x + m x / e) + L.
struct CrackedColumns {
    amplitude: f64,
    shift: f64,
}

/// Returns the columns inside a crack front of speed eta c; `None` if the hoop stress there is not tensile.
fn columns(target: &ScaledTarget, elastic: &ElasticZone, m: f64, tension: f64, eta: f64) -> Option<CrackedColumns> {
    let (mach, e, g) = (elastic.mach, target.young, target.shear);
    let cube = mach * mach * mach;
    // Divided by the amplitude A: Mises stress, pressure, hoop stress.
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

/// Returns the state of the crushed target at the plastic front. By conservation of mass (1 - u/r)^3 is the mass flux
/// through the front, and also exp(-D) times the density.
fn crushed_front(
    target: &ScaledTarget,
    m: f64,
    strength: f64,
    displacement: f64,
    velocity: f64,
) -> Option<PlasticFront> {
    let flux = libm::pow(1.0 - displacement, 3.0);
    let grows = 1.0 + 2.0 / 3.0 * target.pressure_slope;
    let mut stress = strength;
    let mut density = 1.0;
    // Fixed-point iteration: the density depends only weakly on the stress jump, so that it converges fast.
    for _ in 0..60 {
        let pressure = (stress - 2.0 / 3.0) / grows;
        density = 1.0 / (1.0 - target.compressibility * pressure);
        let inner_velocity = 1.0 - flux / density;
        let next = strength + m * flux * (inner_velocity - velocity);
        let moved = (next - stress).abs();
        stress = next;
        if moved <= 1e-15 * stress.abs() {
            break;
        }
    }
    let shear_strain = libm::log(density) - 3.0 * libm::log1p(-displacement);
    (density > 0.0 && shear_strain > 0.0).then_some(PlasticFront { stress, shear_strain, strain: 1.0, crack: None })
}
