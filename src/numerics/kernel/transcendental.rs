//! Logarithm and exponential in branch-free plain arithmetic: compilers vectorize loops over lanes, and every instruction
//! set gives the same bits. A loop over lanes should contain all of the arithmetic on a lane: compilers unroll short loops,
//! and then vectorize only parts of the arithmetic.
//!
//! Both reduce the argument and evaluate a polynomial (Tang 1989 and 1990, ACM Trans. Math. Softw. 15, 144 and 16, 378;
//! the coefficients are those of the minimax polynomials published with Sun's fdlibm, `e_log.c` and `e_exp.c`). Errors
//! are below 1 unit in the last place; errors of powers are below 2 + |n ln x| units.
#![allow(clippy::needless_range_loop)] // Compilers vectorize loops over lanes in this form.

use super::lanes::{LANES, Lanes};
use std::f64::consts::LOG2_E;

/// ln 2 in two parts; the first ends in zero bits, so that its multiples up to 2^11 are exact.
const LN2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
/// Bits of sqrt(1/2): mantissas are reduced to the interval from sqrt(1/2) to sqrt(2).
const ROOT_HALF: u64 = 0x3fe6_a09e_667f_3bcd;
/// Bits of 1.
const ONE: u64 = 0x3ff0_0000_0000_0000;
/// Bits of 2^52: an integer below 2^52 in the mantissa bits is added to the value.
const WHOLE: u64 = 0x4330_0000_0000_0000;
/// 1.5 * 2^52: adding and subtracting it rounds to the nearest integer.
const NEAREST: f64 = 6_755_399_441_055_744.0;
/// First value of [`inverse_cbrt`].
const START: f64 = 1_499_660_000_000_000.0;

/// Returns the natural logarithm. The number must be normal and positive; the result is otherwise meaningless.
#[inline(always)]
pub fn ln_of(x: f64) -> f64 {
    let bits = x.to_bits();
    // x = 2^k m with m between sqrt(1/2) and sqrt(2).
    let biased = bits.wrapping_sub(ROOT_HALF).wrapping_add(ONE) >> 52;
    let k = f64::from_bits(WHOLE | biased) - f64::from_bits(WHOLE | 1023);
    let f = f64::from_bits(bits.wrapping_sub(biased << 52).wrapping_add(ONE)) - 1.0;
    let s = f / (2.0 + f);
    let z = s * s;
    let w = z * z;
    let odd = w * (3.999_999_999_940_942e-1 + w * (2.222_219_843_214_978_4e-1 + w * 1.531_383_769_920_937_3e-1));
    let even = z
        * (6.666_666_666_666_735e-1
            + w * (2.857_142_874_366_239e-1 + w * (1.818_357_216_161_805e-1 + w * 1.479_819_860_511_658_6e-1)));
    let square = 0.5 * f * f;
    k * LN2[0] - ((square - (s * (square + (even + odd)) + k * LN2[1])) - f)
}

/// Returns 2^k and 1 - exp(x)/2^k; the argument is limited to the range of normal results.
#[inline(always)]
fn reduced_exp(x: f64) -> [f64; 2] {
    let x = if x > 709.0 { 709.0 } else { x };
    let x = if x < -708.0 { -708.0 } else { x };
    // x = k ln 2 + r.
    let near = x * LOG2_E + NEAREST;
    let k = near - NEAREST;
    let (high, low) = (x - k * LN2[0], k * LN2[1]);
    let r = high - low;
    let z = r * r;
    let p = z
        * (1.666_666_666_666_66e-1
            + z * (-2.777_777_777_701_559_3e-3
                + z * (6.613_756_321_437_934e-5 + z * (-1.653_390_220_546_525_2e-6 + z * 4.138_136_797_057_238_5e-8))));
    let c = r - p;
    // The last bits of `near` are those of k.
    [f64::from_bits(near.to_bits().wrapping_add(1023) << 52), (low - (r * c) / (2.0 - c)) - high]
}

/// Returns the exponential; the argument is limited to the range of normal results.
#[inline(always)]
pub fn exp_of(x: f64) -> f64 {
    let [scale, fall] = reduced_exp(x);
    (1.0 - fall) * scale
}

/// Returns the exponential less 1, without cancellation; the argument is limited to the range of normal results.
#[inline(always)]
pub fn expm1_of(x: f64) -> f64 {
    let [scale, fall] = reduced_exp(x);
    (scale - 1.0) - scale * fall
}

/// pi/2 in two parts; the first ends in zero bits.
const HALF_PI: [f64; 2] = [1.570_796_326_734_125_6, 6.077_100_506_506_192e-11];

/// Returns cosine and sine of an angle in radians; of an angle of zero exactly 1 and 0. Coefficients of fdlibm, `k_sin.c` and
/// `k_cos.c`. The angle must be below 10^5.
#[inline(always)]
pub fn cos_sin_of(angle: f64) -> [f64; 2] {
    // Nearest multiple k of pi/2, and the remainder r.
    let near = angle * std::f64::consts::FRAC_2_PI + NEAREST;
    let (k, quadrant) = (near - NEAREST, near.to_bits() & 3);
    let r = (angle - k * HALF_PI[0]) - k * HALF_PI[1];
    let z = r * r;
    let sine = r + r
        * z
        * (-1.666_666_666_666_663_2e-1
            + z * (8.333_333_333_322_49e-3
                + z * (-1.984_126_982_985_795e-4
                    + z * (2.755_731_370_707_006_8e-6
                        + z * (-2.505_076_025_340_686_3e-8 + z * 1.589_690_995_211_55e-10)))));
    let cosine = 1.0
        - (0.5 * z
            - z * z
                * (4.166_666_666_666_66e-2
                    + z * (-1.388_888_888_887_411e-3
                        + z * (2.480_158_728_947_673e-5
                            + z * (-2.755_731_435_139_066_3e-7
                                + z * (2.087_572_321_298_175e-9 + z * -1.135_964_755_778_819_5e-11))))));
    let is_odd = quadrant & 1 == 1;
    let (a, b) = if is_odd { (sine, cosine) } else { (cosine, sine) };
    let cosine = if (quadrant == 1) | (quadrant == 2) { -a } else { a };
    let sine = if quadrant >= 2 { -b } else { b };
    [cosine, sine]
}

/// Returns the power x^n of a positive number, and 0 for other numbers.
#[inline(always)]
pub fn power_of(x: f64, n: f64) -> f64 {
    let positive = x >= f64::MIN_POSITIVE;
    let power = exp_of(n * ln_of(if positive { x } else { 1.0 }));
    if positive { power } else { 0.0 }
}

/// Returns the natural logarithms; see [`ln_of`].
#[inline(always)]
pub fn ln(x: &Lanes) -> Lanes {
    let mut result = [0.0; LANES];
    for l in 0..LANES {
        result[l] = ln_of(x[l]);
    }
    result
}

/// Returns the exponentials; see [`exp_of`].
#[inline(always)]
pub fn exp(x: &Lanes) -> Lanes {
    let mut result = [0.0; LANES];
    for l in 0..LANES {
        result[l] = exp_of(x[l]);
    }
    result
}

/// Returns x^(-1/3) of a normal positive number; the result is otherwise meaningless. The error is below 1 unit in the
/// last place.
#[inline(always)]
pub fn inverse_cbrt(x: f64) -> f64 {
    // The bits of a number are almost linear in its logarithm; with START the first value is within 4 % (Kahan
    // 1991, "Computing a real cube root").
    let logarithm = f64::from_bits(WHOLE | (x.to_bits() >> 12)) - f64::from_bits(WHOLE);
    let start = (START - (1.0 / 3.0) * logarithm) + f64::from_bits(WHOLE);
    let mut y = f64::from_bits(start.to_bits() << 12);
    // Halley's method for 1/y³ - x, then Newton's.
    let residual = 1.0 - (x * y) * (y * y);
    y += y * residual * (1.0 / 3.0 + 2.0 / 9.0 * residual);
    let residual = 1.0 - (x * y) * (y * y);
    y += y * residual * (1.0 / 3.0 + 2.0 / 9.0 * residual);
    let residual = 1.0 - (x * y) * (y * y);
    y + y * (residual * (1.0 / 3.0))
}

#[cfg(test)]
mod tests {
    use super::{LANES, cos_sin_of, exp, expm1_of, inverse_cbrt, ln, power_of};

    /// Returns the units in the last place between two numbers.
    fn apart(a: f64, b: f64) -> u64 {
        a.to_bits().abs_diff(b.to_bits())
    }

    #[test]
    fn angles_and_small_exponents_are_accurate() {
        assert_eq!(cos_sin_of(0.0), [1.0, 0.0]);
        for i in 0..100_000 {
            let angle = 1e-3 * f64::from(i - 50_000);
            let [cosine, sine] = cos_sin_of(angle);
            let error = (cosine - libm::cos(angle)).abs().max((sine - libm::sin(angle)).abs());
            assert!(error < 3e-16, "{angle}: {error:e}");
            let x = 1e-4 * f64::from(i - 50_000);
            let expected = libm::expm1(x);
            assert!((expm1_of(x) - expected).abs() <= 5e-16 * expected.abs(), "{x}");
        }
    }

    /// Arguments over the whole range of use and near the limits of argument reduction, compared with libm, whose own
    /// errors are at most one unit.
    #[test]
    fn errors_are_below_one_unit() {
        let mut worst = [0; 3];
        for i in 0..400_000 {
            let part = f64::from(i) / 400_000.0;
            let x = [
                libm::exp(1400.0 * (part - 0.5)),
                1.0 + (part - 0.5) * 1e-3,
                0.5 + part,
                f64::MIN_POSITIVE * (1.0 + part),
                std::f64::consts::FRAC_1_SQRT_2 * (1.0 + (part - 0.5) * 1e-9),
                1e-12 * (1.0 + part),
                1e9 * part + 1.0,
                f64::MAX * (0.5 + 0.5 * part),
            ];
            let y = [
                1400.0 * (part - 0.5),
                part * 1e-3,
                -part * 1e-9,
                0.5 * std::f64::consts::LN_2 * (1.0 + (part - 0.5) * 1e-6),
                -part,
                -10.0 * part,
                20.0 * part,
                0.0,
            ];
            let n = [0.28, 0.5, 1.03, 0.01, 2.0, 0.2, 1.0 / 6.0, 0.001];
            let [x, y, n] = [x, y, n].map(|list| std::array::from_fn(|l| list[l % 8]));
            let (logs, exps) = (ln(&x), exp(&y));
            let powers: [f64; LANES] = std::array::from_fn(|l| power_of(x[l], n[l]));
            for l in 0..LANES {
                worst[0] = worst[0].max(apart(logs[l], libm::log(x[l])));
                worst[1] = worst[1].max(apart(exps[l], libm::exp(y[l])));
                let exponent = n[l] * libm::log(x[l]);
                let units = apart(powers[l], libm::pow(x[l], n[l])) as f64 / (2.0 + exponent.abs());
                worst[2] = worst[2].max((100.0 * units) as u64);
            }
        }
        println!("ln {}, exp {} units, power {} hundredths of 2 + |n ln x| units", worst[0], worst[1], worst[2]);
        assert!(worst[0] <= 1 && worst[1] <= 1 && worst[2] <= 100, "{worst:?}");
    }

    #[test]
    fn inverse_cube_roots_are_accurate_to_one_unit() {
        let mut worst = 0;
        for i in 0..400_000 {
            let part = f64::from(i) / 400_000.0;
            for x in [0.5 + part, 1.0 + (part - 0.5) * 1e-6, libm::exp(1400.0 * (part - 0.5)), 1.0 + 8.0 * part] {
                worst = worst.max(apart(inverse_cbrt(x), 1.0 / libm::cbrt(x)));
            }
        }
        println!("inverse cube root: {worst} units");
        // The reference has a rounding error of one unit as well.
        assert!(worst <= 2, "{worst}");
        assert!(apart(inverse_cbrt(8.0), 0.5) <= 1 && apart(inverse_cbrt(libm::exp2(-1020.0)), libm::exp2(340.0)) <= 1);
    }

    #[test]
    fn powers_of_nonpositive_numbers_are_zero() {
        let powers = [0.0, -1.0, f64::NAN, 5e-324, 1.0].map(|x| power_of(x, 0.3));
        assert_eq!(powers, [0.0, 0.0, 0.0, 0.0, 1.0]);
    }
}
