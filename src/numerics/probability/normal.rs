//! The standard normal distribution, with the same bits on every machine.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// Smallest probability: the distance between random numbers of 53 bits.
const LEAST: f64 = 1.0 / (1_u64 << 53) as f64;

/// Returns the cumulative distribution function.
pub fn cumulative(x: f64) -> f64 {
    0.5 * libm::erfc(-x * FRAC_1_SQRT_2)
}

/// Returns the probability density.
pub fn density(x: f64) -> f64 {
    libm::exp(-0.5 * x * x) / TAU.sqrt()
}

/// Returns the quantile of a probability, with a relative error of about 1e-16. Probabilities 0 and 1 are limited to
/// finite quantiles.
///
/// Source: M. J. Wichura, Algorithm AS 241, Applied Statistics 37 (1988) 477, routine PPND16. Statistics crates use the
/// logarithm of the platform, whose last bit differs between machines.
pub fn quantile(part: f64) -> f64 {
    let part = part.clamp(LEAST, 1.0 - LEAST);
    let q = part - 0.5;
    if q.abs() <= 0.425 {
        let r = 0.180_625 - q * q;
        return q * ratio(r, &A, &B);
    }
    let r = (-libm::log(if q < 0.0 { part } else { 1.0 - part })).sqrt();
    let x = if r <= 5.0 { ratio(r - 1.6, &C, &D) } else { ratio(r - 5.0, &E, &F) };
    if q < 0.0 { -x } else { x }
}

fn ratio(x: f64, over: &[f64], under: &[f64]) -> f64 {
    let polynomial = |c: &[f64]| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
    polynomial(over) / polynomial(under)
}

const A: [f64; 8] = [
    3.387_132_872_796_366_5,
    1.331_416_678_917_843_8e2,
    1.971_590_950_306_551_3e3,
    1.373_169_376_550_946e4,
    4.592_195_393_154_987e4,
    6.726_577_092_700_87e4,
    3.343_057_558_358_813e4,
    2.509_080_928_730_122_7e3,
];
const B: [f64; 8] = [
    1.0,
    4.231_333_070_160_091e1,
    6.871_870_074_920_579e2,
    5.394_196_021_424_751e3,
    2.121_379_430_158_659_7e4,
    3.930_789_580_009_271e4,
    2.872_908_573_572_194_3e4,
    5.226_495_278_852_854e3,
];
const C: [f64; 8] = [
    1.423_437_110_749_683_5,
    4.630_337_846_156_546,
    5.769_497_221_460_691,
    3.647_848_324_763_204_5,
    1.270_458_252_452_368_4,
    2.417_807_251_774_506e-1,
    2.272_384_498_926_918_4e-2,
    7.745_450_142_783_414e-4,
];
const D: [f64; 8] = [
    1.0,
    2.053_191_626_637_759,
    1.676_384_830_183_803_8,
    6.897_673_349_851e-1,
    1.481_039_764_274_800_8e-1,
    1.519_866_656_361_645_7e-2,
    5.475_938_084_995_345e-4,
    1.050_750_071_644_416_9e-9,
];
const E: [f64; 8] = [
    6.657_904_643_501_103,
    5.463_784_911_164_114,
    1.784_826_539_917_291_3,
    2.965_605_718_285_048_7e-1,
    2.653_218_952_657_612_4e-2,
    1.242_660_947_388_078_4e-3,
    2.711_555_568_743_487_6e-5,
    2.010_334_399_292_288_1e-7,
];
const F: [f64; 8] = [
    1.0,
    5.998_322_065_558_88e-1,
    1.369_298_809_227_358e-1,
    1.487_536_129_085_061_5e-2,
    7.868_691_311_456_133e-4,
    1.846_318_317_510_054_8e-5,
    1.421_511_758_316_446e-7,
    2.044_263_103_389_939_8e-15,
];

#[cfg(test)]
mod tests {
    use super::{cumulative, density, quantile};
    use statrs::distribution::{Continuous as _, ContinuousCDF as _, Normal};

    /// Comparison with the crate statrs within its accuracy, and with the cumulative distribution function.
    #[test]
    fn quantiles_are_those_of_the_normal_distribution() {
        let known = Normal::standard();
        for part in [1e-300, 1e-12, 1e-9, 1e-5, 0.01, 0.074, 0.0751, 0.3, 0.5, 0.6, 0.92, 0.93, 0.999, 1.0 - 1e-9] {
            let x = quantile(part);
            if part > 1e-15 {
                assert!((x - known.inverse_cdf(part)).abs() < 1e-9 * (1.0 + x.abs()), "{part}: {x}");
                assert!((cumulative(x) / part - 1.0).abs() < 3e-14, "{part}: {x} {}", cumulative(x));
            }
            assert!(x.is_finite() && (density(x) - known.pdf(x)).abs() < 1e-15);
        }
        assert_eq!([quantile(0.0), quantile(1.0)].map(f64::is_finite), [true; 2]);
        assert_eq!(quantile(0.5), 0.0);
    }
}
