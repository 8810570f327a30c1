//! Bulk viscosity of what has an equation of state: how fast a shock compresses, and over which length it is spread.
//! Never here: pressures, loops over lanes.

/// Rate that takes the place of the volumetric one in the quadratic viscosity of a volume that shrinks at the rate `shrinking`
/// (not negative): s^2/shrinking with s the strongest principal compression in the section, whose rates are rr, zz, rz. In a
/// shock it is the volumetric rate; where rings converge smoothly it is nothing, and a cold gas is not heated ahead of
/// the shock.
#[inline(always)]
pub(super) fn principal_compression([rr, zz, rz]: [f64; 3], shrinking: f64) -> f64 {
    let apart = 0.5 * (rr - zz);
    let strongest = (apart * apart + rz * rz).sqrt() - 0.5 * (rr + zz);
    let s = if strongest > 0.0 { strongest } else { 0.0 };
    let s = if s < shrinking { s } else { shrinking };
    if shrinking > 0.0 { s * s / shrinking } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::principal_compression;

    #[test]
    fn a_shock_counts_and_a_converging_ring_does_not() {
        assert!((principal_compression([0.0, -2.0, 0.0], 2.0) - 2.0).abs() < 1e-15);
        // The same shock, running at 45 degrees.
        assert!((principal_compression([-1.0, -1.0, 1.0], 2.0) - 2.0).abs() < 1e-15);
        assert!(principal_compression([0.0, 0.0, 0.0], 2.0).abs() < 1e-300);
        assert!((principal_compression([-1.0, 0.0, 0.0], 2.0) - 0.5).abs() < 1e-15);
        assert!(principal_compression([-1.0, 3.0, 0.0], 0.0).abs() < 1e-300);
    }
}
