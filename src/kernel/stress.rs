//! Invariants of a stress rr, zz, hoop, rz.
//! Never here: laws that give a stress.

use super::real::Real;

/// Mises equivalent stress, sqrt(3/2 s:s), in the unit of the stress.
#[inline(always)] // Into loops over lanes, compiled for the instruction set of the machine.
pub fn mises<T: Real>([rr, zz, hoop, rz]: [T; 4]) -> T {
    let [a, b, c] = [rr - zz, zz - hoop, hoop - rr].map(|d| d * d);
    (T::of(0.5) * (a + b + c) + T::of(3.0) * rz * rz).root()
}

/// Pressure, positive in compression: minus a third of the trace.
#[inline(always)] // Likewise.
pub fn pressure([rr, zz, hoop, _]: [f64; 4]) -> f64 {
    -(rr + zz + hoop) / 3.0
}

#[cfg(test)]
mod tests {
    use super::{mises, pressure};

    #[test]
    fn tension_and_shear() {
        assert!((mises([300.0_f64, 0.0, 0.0, 0.0]) - 300.0).abs() < 1e-12);
        assert!((mises([0.0_f64, 0.0, 0.0, 100.0]) - 100.0 * 3.0_f64.sqrt()).abs() < 1e-12);
        assert_eq!((mises([5.0, 5.0, 5.0, 0.0]), pressure([1.0, 2.0, -9.0, 4.0])), (0.0, 2.0));
    }
}
