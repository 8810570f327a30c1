//! The hypotenuse in portable arithmetic. The last bit of `hypot` differs between C libraries and their versions; this
//! function reproduces the bits of the GNU C library 2.35 and later. Source: C. F. Borges, "Algorithm 1014: An improved
//! algorithm for hypot(x, y)", ACM Trans. Math. Softw. 47 (2021) 9, without fused operations.

/// Beyond the two limits, squares overflow or lose digits, and both numbers are scaled.
const LARGE: f64 = 1e150;
const SMALL: f64 = 1e-140;
/// Scale factor 2^600 for arguments that would underflow or overflow when squared.
const SCALE: f64 = f64::from_bits((1023 + 600) << 52);

/// Functions whose bits are the same with every C library.
pub trait PortableMath {
    /// Returns sqrt(self² + other²) with an error below one unit in the last place, without overflow.
    fn portable_hypot(self, other: Self) -> Self;
}

impl PortableMath for f64 {
    #[inline]
    fn portable_hypot(self, other: f64) -> f64 {
        let (x, y) = (self.abs(), other.abs());
        let (long, short) = if x < y { (y, x) } else { (x, y) };
        if !(long < f64::INFINITY && short < f64::INFINITY) {
            return libm::hypot(long, short);
        }
        // The shorter side only affects the rounding.
        if short <= long * (0.25 * f64::EPSILON) {
            return long + short;
        }
        let scale = if long > LARGE { SCALE.recip() } else { SCALE };
        if long <= LARGE && short >= SMALL {
            corrected_root(long, short)
        } else {
            corrected_root(long * scale, short * scale) / scale
        }
    }
}

/// Returns the root of the sum of squares, corrected by the error of its square.
#[inline]
fn corrected_root(long: f64, short: f64) -> f64 {
    let root = (long * long + short * short).sqrt();
    let excess = if root <= 2.0 * short {
        let more = root - short;
        long * (2.0 * more - long) + (more - 2.0 * (long - short)) * more
    } else {
        let more = root - long;
        2.0 * more * (long - 2.0 * short) + ((4.0 * more - short) * short + more * more)
    };
    root - excess / (2.0 * root)
}

#[cfg(test)]
mod tests {
    use super::PortableMath as _;

    #[test]
    fn pythagorean_triples_are_exact_at_every_scale() {
        for power in [-1000, -500, -470, -1, 0, 3, 480, 500, 1000] {
            let scale = 2.0_f64.powi(power);
            for [a, b, c] in [[3.0, 4.0, 5.0], [5.0, 12.0, 13.0], [119.0, 120.0, 169.0], [-20.0, 99.0, 101.0]] {
                assert_eq!((a * scale).portable_hypot(b * scale), c * scale, "{a} {b} {power}");
                assert_eq!((b * scale).portable_hypot(a * scale), c * scale, "{b} {a} {power}");
            }
        }
        assert_eq!(0.0_f64.portable_hypot(-0.0), 0.0);
        assert_eq!(f64::INFINITY.portable_hypot(f64::NAN), f64::INFINITY);
        assert!(1.0_f64.portable_hypot(f64::NAN).is_nan());
        assert_eq!(1.0_f64.portable_hypot(1e-300), 1.0);
    }

    /// Bits of the GNU C library 2.36; versions before 2.35 differ in the last bit.
    #[test]
    fn bits_are_pinned() {
        let mut state = 88_172_645_463_325_252_u64;
        let mut next = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let bits = (0..100_000).map(|i| (next() * 2.0_f64.powi(i % 60 - 30)).portable_hypot(next()).to_bits());
        assert_eq!(bits.fold(0_u64, |sum, bits| sum.rotate_left(1) ^ bits), 0x9f84_c869_3c92_e3c1);
    }
}
