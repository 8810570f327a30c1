//! The rotation of a tensor with the material.
//! Never here: spins.

use super::real::Real;

/// The stress turned with the material by a spin increment.
#[inline(always)]
pub fn rotated<T: Real>(tensor: [T; 4], spin: T) -> [T; 4] {
    turned(tensor, of_spin(spin))
}

/// Cosine and sine of the angle by which a spin increment turns: Hughes and Winget 1980 (Int. J. Numer. Meth. Eng. 15, 1862), a
/// rotation of which the tangent of half the angle is half the spin increment; orthogonal for any increment.
#[inline(always)]
pub fn of_spin<T: Real>(spin: T) -> [T; 2] {
    let quarter = T::of(0.25) * spin * spin;
    let inverse = T::ONE / (T::ONE + quarter);
    [(T::ONE - quarter) * inverse, spin * inverse]
}

/// A spin increment that is a quotient, with what one division gives for its rotation and for one over the divisor.
#[derive(Clone, Copy)]
pub struct SpinOver<T = f64> {
    /// Spin increment times the divisor.
    pub dividend: T,
    /// What it is divided by, a volume.
    pub divisor: T,
    /// The division.
    pub inverse: T,
}

impl<T: Real> SpinOver<T> {
    /// Divides.
    #[inline(always)]
    pub fn new(dividend: T, divisor: T) -> Self {
        let inverse = T::ONE / (divisor * (divisor * divisor + T::of(0.25) * dividend * dividend));
        SpinOver { dividend, divisor, inverse }
    }

    /// One over the divisor.
    #[inline(always)]
    pub fn per(&self) -> T {
        (self.divisor * self.divisor + T::of(0.25) * self.dividend * self.dividend) * self.inverse
    }

    /// The sine of the rotation and one less its cosine.
    #[inline(always)]
    pub fn turn_by(&self) -> [T; 2] {
        let per = self.divisor * self.inverse;
        [self.dividend * self.divisor * per, T::of(0.5) * self.dividend * self.dividend * per]
    }

    /// The rotation, as [`of_spin`] gives it.
    #[inline(always)]
    pub fn turn(&self) -> [T; 2] {
        let (square, quarter) = (self.divisor * self.divisor, T::of(0.25) * self.dividend * self.dividend);
        let per = self.divisor * self.inverse;
        [(square - quarter) * per, self.dividend * self.divisor * per]
    }
}

/// The same tensor by what the rotation adds to it, given the sine of the angle and one less the cosine: without rotation no digit
/// changes, however often.
#[inline(always)]
pub fn turned_by<T: Real>([rr, zz, hoop, rz]: [T; 4], [sine, versine]: [T; 2]) -> [T; 4] {
    let two = T::of(2.0);
    let (sine2, versine2) = (two * sine * (T::ONE - versine), two * sine * sine);
    let radius = T::of(0.5) * (rr - zz);
    let more = rz * sine2 - radius * versine2;
    [rr + more, zz - more, hoop, rz - (radius * sine2 + rz * versine2)]
}

/// A tensor rr, zz, hoop, rz turned by an angle of this cosine and sine.
#[inline(always)]
pub fn turned<T: Real>([rr, zz, hoop, rz]: [T; 4], [cosine, sine]: [T; 2]) -> [T; 4] {
    // Components turn by twice the angle.
    let (cosine2, sine2) = (cosine * cosine - sine * sine, T::of(2.0) * sine * cosine);
    let (centre, radius) = (T::of(0.5) * (rr + zz), T::of(0.5) * (rr - zz));
    let turned = radius * cosine2 + rz * sine2;
    [centre + turned, centre - turned, hoop, rz * cosine2 - radius * sine2]
}
