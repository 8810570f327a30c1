//! Bulk viscosity of materials with an equation of state: compression rate and length scale of shocks.

use crate::kernel::real::Real;

/// Returns the rate that replaces the volumetric rate in the quadratic viscosity: s²/`shrinking`. Here s is the
/// strongest principal compression rate in the plane section (rates rr, zz, rz), and `shrinking` ≥ 0 is the compression
/// rate of the volume. In a shock the result is the volumetric rate. In smoothly converging flow it vanishes, so that a
/// cold gas is not heated ahead of the shock. Equation (7.7).
#[inline(always)]
pub(super) fn principal_compression<T: Real>([rr, zz, rz]: [T; 3], shrinking: T) -> T {
    let (half, zero) = (rr.like(0.5), rr.like(0.0));
    let apart = half * (rr - zz);
    let strongest = (apart * apart + rz * rz).root() - half * (rr + zz);
    let s = zero.if_less(strongest, strongest, zero).at_most(shrinking);
    zero.if_less(shrinking, s * s / shrinking, zero)
}

/// Fraction of the viscosity of a gas that resists each strain rate separately instead of the volumetric rate. With a
/// scalar viscosity alone, columns of elements can move relative to each other when a shock travels along mesh lines.
pub(super) const BY_DIRECTION: f64 = 0.1;

/// Returns the stress rr, zz, hoop, rz that turns a viscous pressure into a viscosity by direction, which resists the
/// rates rr, zz, rz separately. In a plane shock the stress along its direction is unchanged and the transverse stress
/// vanishes. Equation (7.8).
#[inline(always)]
pub(super) fn by_direction<T: Real>([rr, zz, rz]: [T; 3], dilation: T, viscosity: T) -> [T; 4] {
    let along = |rate: T| viscosity * (rate - dilation);
    [along(rr), along(zz), -viscosity * (rr + zz), viscosity * rz]
}

#[cfg(test)]
mod tests {
    use super::{by_direction, principal_compression};

    #[test]
    fn viscosity_by_direction_keeps_the_stress_along_a_plane_shock() {
        // The viscous pressure is 3 * -2.
        assert_eq!(by_direction([0.0, -2.0, 0.0], -2.0, 3.0).map(|s| s + 0.0), [6.0, 0.0, 6.0, 0.0]);
        // Rotated by 45 degrees: all stress along rr = zz = rz, none across.
        let [rr, zz, hoop, rz] = by_direction([-1.0, -1.0, 1.0], -2.0, 3.0);
        assert_eq!([rr - 6.0, zz - 6.0, hoop - 6.0, rz], [-3.0, -3.0, 0.0, 3.0]);
    }

    #[test]
    fn shocks_are_resisted_and_converging_rings_are_not() {
        assert!((principal_compression([0.0, -2.0, 0.0], 2.0_f64) - 2.0).abs() < 1e-15);
        // The same shock travelling at 45 degrees.
        assert!((principal_compression([-1.0, -1.0, 1.0], 2.0_f64) - 2.0).abs() < 1e-15);
        assert!(principal_compression([0.0, 0.0, 0.0], 2.0_f64).abs() < 1e-300);
        assert!((principal_compression([-1.0, 0.0, 0.0], 2.0_f64) - 0.5).abs() < 1e-15);
        assert!(principal_compression([-1.0, 3.0, 0.0], 0.0_f64).abs() < 1e-300);
    }
}
