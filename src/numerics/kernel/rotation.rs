//! Rotation of a tensor with the material.

use super::real::Real;

/// Returns a stress rotated with the material by a spin increment.
#[inline(always)]
pub fn rotated<T: Real>(tensor: [T; 4], spin: T) -> [T; 4] {
    rotate(tensor, rotation_of_spin(spin))
}

/// Returns cosine and sine of the rotation of a spin increment (Hughes and Winget 1980, Int. J. Numer. Meth. Eng. 15,
/// 1862): the tangent of half the angle is half the spin increment, which is orthogonal for any increment.
#[inline(always)]
pub fn rotation_of_spin<T: Real>(spin: T) -> [T; 2] {
    let quarter = T::of(0.25) * spin * spin;
    let inverse = T::ONE / (T::ONE + quarter);
    [(T::ONE - quarter) * inverse, spin * inverse]
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
        let inverse = T::ONE / (divisor * (divisor * divisor + T::of(0.25) * dividend * dividend));
        SpinQuotient { dividend, divisor, inverse }
    }

    /// Returns one over the divisor.
    #[inline(always)]
    pub fn per(&self) -> T {
        (self.divisor * self.divisor + T::of(0.25) * self.dividend * self.dividend) * self.inverse
    }

    /// Returns the sine of the rotation, and 1 minus its cosine.
    #[inline(always)]
    pub fn rotation_difference(&self) -> [T; 2] {
        let per = self.divisor * self.inverse;
        [self.dividend * self.divisor * per, T::of(0.5) * self.dividend * self.dividend * per]
    }

    /// Returns cosine and sine of the rotation, as [`rotation_of_spin`].
    #[inline(always)]
    pub fn rotation(&self) -> [T; 2] {
        let (square, quarter) = (self.divisor * self.divisor, T::of(0.25) * self.dividend * self.dividend);
        let per = self.divisor * self.inverse;
        [(square - quarter) * per, self.dividend * self.divisor * per]
    }
}

/// Returns a rotated tensor as the sum of the tensor and its change, from the sine and 1 minus the cosine of the angle:
/// without rotation, no bit changes.
#[inline(always)]
pub fn rotate_by_difference<T: Real>([rr, zz, hoop, rz]: [T; 4], [sine, versine]: [T; 2]) -> [T; 4] {
    let two = T::of(2.0);
    let (sine2, versine2) = (two * sine * (T::ONE - versine), two * sine * sine);
    let radius = T::of(0.5) * (rr - zz);
    let more = rz * sine2 - radius * versine2;
    [rr + more, zz - more, hoop, rz - (radius * sine2 + rz * versine2)]
}

/// Returns a tensor rr, zz, hoop, rz rotated by an angle with this cosine and sine.
#[inline(always)]
pub fn rotate<T: Real>([rr, zz, hoop, rz]: [T; 4], [cosine, sine]: [T; 2]) -> [T; 4] {
    // Components rotate by twice the angle.
    let (cosine2, sine2) = (cosine * cosine - sine * sine, T::of(2.0) * sine * cosine);
    let (centre, radius) = (T::of(0.5) * (rr + zz), T::of(0.5) * (rr - zz));
    let turned = radius * cosine2 + rz * sine2;
    [centre + turned, centre - turned, hoop, rz * cosine2 - radius * sine2]
}
