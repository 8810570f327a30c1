//! Bulk viscosity of what has an equation of state: how fast a shock compresses, and over which length it is spread.
//! Never here: pressures, loops over lanes.

use crate::kernel::real::Real;

/// Rate that takes the place of the volumetric one in the quadratic viscosity of a volume that shrinks at the rate `shrinking`
/// (not negative): s^2/shrinking with s the strongest principal compression in the section, whose rates are rr, zz, rz. In a
/// shock it is the volumetric rate; where rings converge smoothly it is nothing, and a cold gas is not heated ahead of
/// the shock.
#[inline(always)]
pub(super) fn principal_compression<T: Real>([rr, zz, rz]: [T; 3], shrinking: T) -> T {
    let half = T::of(0.5);
    let apart = half * (rr - zz);
    let strongest = (apart * apart + rz * rz).root() - half * (rr + zz);
    let s = if strongest > T::ZERO { strongest } else { T::ZERO };
    let s = if s < shrinking { s } else { shrinking };
    if shrinking > T::ZERO { s * s / shrinking } else { T::ZERO }
}

/// Of a gas, the share of the viscosity that resists each rate by itself and not the volumetric one. Where a shock runs along the
/// lines of a mesh a pressure alone lets columns of elements run ahead beside each other.
pub(super) const BY_DIRECTION: f64 = 0.1;

/// Stress rr, zz, hoop, rz that a viscosity adds to its own pressure where it resists the rates rr, zz, rz each by itself: of a
/// plane shock the stress along its way stays, beside it there is none.
#[inline(always)]
pub(super) fn by_direction<T: Real>([rr, zz, rz]: [T; 3], dilation: T, viscosity: T) -> [T; 4] {
    let along = |rate: T| viscosity * (rate - dilation);
    [along(rr), along(zz), -viscosity * (rr + zz), viscosity * rz]
}

#[cfg(test)]
mod tests {
    use super::{by_direction, principal_compression};

    #[test]
    fn viscosity_by_direction_leaves_a_plane_shock_its_stress() {
        // Its pressure is 3 * -2.
        assert_eq!(by_direction([0.0, -2.0, 0.0], -2.0, 3.0).map(|s| s + 0.0), [6.0, 0.0, 6.0, 0.0]);
        // The same turned by 45 degrees: all of it along rr = zz = rz, nothing across.
        let [rr, zz, hoop, rz] = by_direction([-1.0, -1.0, 1.0], -2.0, 3.0);
        assert_eq!([rr - 6.0, zz - 6.0, hoop - 6.0, rz], [-3.0, -3.0, 0.0, 3.0]);
    }

    #[test]
    fn a_shock_counts_and_a_converging_ring_does_not() {
        assert!((principal_compression([0.0, -2.0, 0.0], 2.0_f64) - 2.0).abs() < 1e-15);
        // The same shock, running at 45 degrees.
        assert!((principal_compression([-1.0, -1.0, 1.0], 2.0_f64) - 2.0).abs() < 1e-15);
        assert!(principal_compression([0.0, 0.0, 0.0], 2.0_f64).abs() < 1e-300);
        assert!((principal_compression([-1.0, 0.0, 0.0], 2.0_f64) - 0.5).abs() < 1e-15);
        assert!(principal_compression([-1.0, 3.0, 0.0], 0.0_f64).abs() < 1e-300);
    }
}
