//! Rotation of a tensor with the material.

use super::real::Real;

/// Returns a stress rotated with the material by a spin increment.
#[inline(always)]
pub fn rotated<T: Real>(tensor: [T; 4], spin: T) -> [T; 4] {
    rotate(tensor, rotation_of_spin(spin))
}

/// Returns cosine and sine of the rotation of a spin increment (Hughes and Winget 1980, Int. J. Numer. Meth. Eng. 15,
/// 1862): the tangent of half the angle is half the spin increment, which is orthogonal for any increment. Equation
/// (5.5).
#[inline(always)]
pub fn rotation_of_spin<T: Real>(spin: T) -> [T; 2] {
    let unit = spin.like(1.0);
    let quarter = spin.like(0.25) * spin * spin;
    let inverse = unit / (unit + quarter);
    [(unit - quarter) * inverse, spin * inverse]
}

/// A spin increment given as a quotient; one common inverse yields its rotation and one over the divisor.
#[derive(Clone, Copy)]
pub struct SpinQuotient<T = f64> {
    /// Spin increment times the divisor.
    pub dividend: T,
    /// Divisor, a volume.
    pub divisor: T,
    /// Value from which the rotation and the inverse of the divisor follow by multiplications.
    pub inverse: T,
}

impl<T: Real> SpinQuotient<T> {
    /// Computes the common inverse.
    #[inline(always)]
    pub fn new(dividend: T, divisor: T) -> Self {
        let inverse = divisor.like(1.0) / (divisor * Self::square_sum(dividend, divisor));
        SpinQuotient { dividend, divisor, inverse }
    }

    /// Returns one over the divisor.
    #[inline(always)]
    pub fn per(&self) -> T {
        Self::square_sum(self.dividend, self.divisor) * self.inverse
    }

    /// Returns the square of the divisor plus a quarter of that of the dividend.
    #[inline(always)]
    fn square_sum(dividend: T, divisor: T) -> T {
        divisor * divisor + divisor.like(0.25) * dividend * dividend
    }

    /// Returns cosine and sine of the rotation, as [`rotation_of_spin`]. Equation (5.5).
    #[inline(always)]
    pub fn rotation(&self) -> [T; 2] {
        let (square, quarter) = (self.divisor * self.divisor, self.dividend.like(0.25) * self.dividend * self.dividend);
        let per = self.divisor * self.inverse;
        [(square - quarter) * per, self.dividend * self.divisor * per]
    }
}

/// Returns a tensor rr, zz, hoop, rz rotated by an angle with this cosine and sine.
#[inline(always)]
pub fn rotate<T: Real>([rr, zz, hoop, rz]: [T; 4], [cosine, sine]: [T; 2]) -> [T; 4] {
    // Components rotate by twice the angle.
    let half = rr.like(0.5);
    let (cosine2, sine2) = (cosine * cosine - sine * sine, rr.like(2.0) * sine * cosine);
    let (centre, radius) = (half * (rr + zz), half * (rr - zz));
    let turned = radius * cosine2 + rz * sine2;
    [centre + turned, centre - turned, hoop, rz * cosine2 - radius * sine2]
}

/// Returns the stretch U (rr, zz, hoop, rz) and the rotation R of a deformation gradient F = R U (rr, zz, hoop, rz, zr).
/// The rotation is given as cosine and sine, as for [`rotate`]. In the plane
/// `R = (F + det F F^-T) / sqrt(tr C + 2 det F)` with `C = F^T F` (Hoger and Carlson 1984, Quart. Appl. Math. 42, 113).
pub fn polar_decomposition([rr, zz, hoop, rz, zr]: [f64; 5]) -> ([f64; 4], [f64; 2]) {
    let [even, odd] = [rr + zz, rz - zr];
    let square = even * even + odd * odd;
    let per = if square > 0.0 { 1.0 / square.sqrt() } else { 0.0 };
    let [cosine, sine] = if square > 0.0 { [per * even, per * odd] } else { [1.0, 0.0] };
    let stretch = [cosine * rr - sine * zr, cosine * zz + sine * rz, hoop, cosine * rz - sine * zz];
    (stretch, [cosine, sine])
}
