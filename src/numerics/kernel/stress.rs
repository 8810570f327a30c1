//! Invariants of a stress rr, zz, hoop, rz.

use super::lanes::InlineMap;

/// Returns the von Mises stress, sqrt(3/2 s:s). Equation (1.1).
#[inline(always)] // Into loops over lanes, compiled for the instruction set of the machine.
pub fn mises([rr, zz, hoop, rz]: [f64; 4]) -> f64 {
    let [a, b, c] = [rr - zz, zz - hoop, hoop - rr].inline_map(|d| d * d);
    (0.5 * (a + b + c) + 3.0 * rz * rz).sqrt()
}

/// Returns the pressure, positive in compression: minus a third of the trace. Equation (1.1).
#[inline(always)] // Likewise.
pub fn pressure([rr, zz, hoop, _]: [f64; 4]) -> f64 {
    -(rr + zz + hoop) / 3.0
}

/// Returns the stress whose product with a factor on it, and another one on its mean stress, is given.
#[inline(always)] // Likewise.
pub fn undamaged(stress: [f64; 4], [factor, of_mean]: [f64; 2]) -> [f64; 4] {
    if factor == of_mean {
        return stress.inline_map(|s| s / factor);
    }
    let mean = -pressure(stress);
    let [rr, zz, hoop] = [stress[0], stress[1], stress[2]].inline_map(|s| (s - mean) / factor + mean / of_mean);
    [rr, zz, hoop, stress[3] / factor]
}

/// Returns the principal stresses, ascending: two in the plane of r and z, and the hoop stress. A NaN may be lost.
#[inline(always)] // Likewise.
pub fn principal([rr, zz, hoop, rz]: [f64; 4]) -> [f64; 3] {
    let (centre, radius) = (0.5 * (rr + zz), (0.25 * (rr - zz) * (rr - zz) + rz * rz).sqrt());
    let (low, high) = (centre - radius, centre + radius);
    [low.min(hoop), low.max(high.min(hoop)), high.max(hoop)]
}

/// Returns the Tresca stress: the largest difference of principal stresses.
pub fn tresca(stress: [f64; 4]) -> f64 {
    let [low, _, high] = principal(stress);
    high - low
}

/// Returns the stress triaxiality: mean stress over von Mises stress; 0 for zero mean stress.
pub fn triaxiality(stress: [f64; 4]) -> f64 {
    let (mean, mises) = (-pressure(stress), mises(stress));
    if mean == 0.0 { 0.0 } else { mean / mises }
}

/// Returns the magnitude of a strain with tensor shear: sqrt(2/3 e:e).
pub fn magnitude([rr, zz, hoop, rz]: [f64; 4]) -> f64 {
    (2.0 / 3.0 * (rr * rr + zz * zz + hoop * hoop + 2.0 * rz * rz)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::{magnitude, mises, pressure, principal, tresca, triaxiality};

    /// Uniaxial tension, pure shear, hoop compression, and a general state checked by the invariants.
    #[test]
    fn principal_stresses_tresca_and_triaxiality_are_exact() {
        assert_eq!(principal([300.0, 0.0, 0.0, 0.0]), [0.0, 0.0, 300.0]);
        assert_eq!(principal([0.0, 0.0, 0.0, 100.0]), [-100.0, 0.0, 100.0]);
        assert_eq!((tresca([0.0, 0.0, 0.0, 100.0]), tresca([0.0, 0.0, -70.0, 0.0])), (200.0, 70.0));
        let check = |stress, expected: f64| assert!((triaxiality(stress) - expected).abs() < 1e-15, "{expected}");
        check([0.0, 300.0, 0.0, 0.0], 1.0 / 3.0);
        check([-300.0, -300.0, 0.0, 0.0], -2.0 / 3.0);
        check([0.0; 4], 0.0);
        let stress: [f64; 4] = [120.0, -35.0, 60.0, 44.0];
        let [a, b, c] = principal(stress);
        assert!((a + b + c + 3.0 * pressure(stress)).abs() < 1e-12);
        let from_principal = (0.5 * ((a - b).powi(2) + (b - c).powi(2) + (c - a).powi(2))).sqrt();
        assert!((from_principal / mises(stress) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn magnitudes_of_tension_and_shear_are_exact() {
        // Uniaxial strain without volume change, and pure shear with the engineering shear 0.3: 0.3/sqrt(3).
        assert!((magnitude([-0.05, 0.1, -0.05, 0.0]) - 0.1).abs() < 1e-16);
        assert!((magnitude([0.0, 0.0, 0.0, 0.15]) - 0.3 / 3.0_f64.sqrt()).abs() < 1e-16);
        assert!((mises([300.0_f64, 0.0, 0.0, 0.0]) - 300.0).abs() < 1e-12);
        assert!((mises([0.0_f64, 0.0, 0.0, 100.0]) - 100.0 * 3.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!((mises([5.0, 5.0, 5.0, 0.0]), pressure([1.0, 2.0, -9.0, 4.0])), (0.0, 2.0));
    }
}
