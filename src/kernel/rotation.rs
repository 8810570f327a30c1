//! The rotation of a tensor with the material.
//! Never here: spins.

/// The stress turned with the material by a spin increment.
#[inline(always)]
pub fn rotated(tensor: [f64; 4], spin: f64) -> [f64; 4] {
    turned(tensor, of_spin(spin))
}

/// Cosine and sine of the angle by which a spin increment turns: Hughes and Winget 1980 (Int. J. Numer. Meth. Eng. 15, 1862), a
/// rotation of which the tangent of half the angle is half the spin increment; orthogonal for any increment.
#[inline(always)]
pub fn of_spin(spin: f64) -> [f64; 2] {
    let quarter = 0.25 * spin * spin;
    let inverse = 1.0 / (1.0 + quarter);
    [(1.0 - quarter) * inverse, spin * inverse]
}

/// A spin increment that is a quotient, with what one division gives for its rotation and for one over the divisor.
#[derive(Clone, Copy)]
pub struct SpinOver {
    /// Spin increment times the divisor.
    pub dividend: f64,
    /// What it is divided by, a volume.
    pub divisor: f64,
    /// The division.
    pub inverse: f64,
}

impl SpinOver {
    /// Divides.
    #[inline(always)]
    pub fn new(dividend: f64, divisor: f64) -> SpinOver {
        let inverse = 1.0 / (divisor * (divisor * divisor + 0.25 * dividend * dividend));
        SpinOver { dividend, divisor, inverse }
    }

    /// One over the divisor.
    #[inline(always)]
    pub fn per(&self) -> f64 {
        (self.divisor * self.divisor + 0.25 * self.dividend * self.dividend) * self.inverse
    }

    /// The rotation, as [`of_spin`] gives it.
    #[inline(always)]
    pub fn turn(&self) -> [f64; 2] {
        let (square, quarter) = (self.divisor * self.divisor, 0.25 * self.dividend * self.dividend);
        let per = self.divisor * self.inverse;
        [(square - quarter) * per, self.dividend * self.divisor * per]
    }
}

/// A tensor rr, zz, hoop, rz turned by an angle of this cosine and sine.
#[inline(always)]
pub fn turned([rr, zz, hoop, rz]: [f64; 4], [cosine, sine]: [f64; 2]) -> [f64; 4] {
    // Components turn by twice the angle.
    let (cosine2, sine2) = (cosine * cosine - sine * sine, 2.0 * sine * cosine);
    let (centre, radius) = (0.5 * (rr + zz), 0.5 * (rr - zz));
    let turned = radius * cosine2 + rz * sine2;
    [centre + turned, centre - turned, hoop, rz * cosine2 - radius * sine2]
}
