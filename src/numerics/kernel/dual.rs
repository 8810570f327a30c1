//! Numbers with derivatives: forward mode of automatic differentiation. Functions over [`Scalar`] give the same bits with
//! `f64` as functions over `f64`, and exact derivatives with [`Dual`].

use std::fmt::Debug;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::lanes::inline_from_fn;

/// A number, alone or with derivatives.
pub trait Scalar:
    Copy
    + Debug
    + PartialEq
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + Mul<f64, Output = Self>
{
    /// Returns a number without derivatives.
    fn constant(value: f64) -> Self;

    /// Returns the number without its derivatives.
    fn value(self) -> f64;

    /// Returns f(x) from its value and its slope f'(x), which is computed only for numbers with derivatives.
    fn chain_with(self, value: f64, slope: impl FnOnce() -> f64) -> Self;

    /// Returns the root of a function of which `excess` is the value at `root`, zero up to rounding, with its derivatives
    /// by the parameters; `slope` is the derivative by the unknown.
    fn of_root(root: f64, excess: Self, slope: f64) -> Self;

    /// Returns whether value and derivatives are finite.
    fn is_finite(self) -> bool;

    /// Returns whether value and derivatives are at most a part of the value and derivatives of a sum.
    fn is_negligible(self, sum: Self, part: f64) -> bool;

    /// Returns the square root.
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value().sqrt();
        self.chain_with(root, || 0.5 / root)
    }

    /// Returns the exponential function.
    #[inline(always)]
    fn exp(self) -> Self {
        let value = libm::exp(self.value());
        self.chain_with(value, || value)
    }

    /// Returns `(1 - exp(-x))/x` for x ≥ 0, 1 at zero.
    fn mean_of_decay(self) -> Self {
        let x = self.value();
        let value = if x > 0.0 { -libm::expm1(-x) / x } else { 1.0 };
        // Σ (-1)^n n x^(n-1)/(n+1)!, without the cancellation of the closed form.
        let slope = || if x < SMALL { series(-0.5, |n| -x / (n + 2.0), |n| n) } else { (libm::exp(-x) - value) / x };
        self.chain_with(value, slope)
    }

    /// Returns `ln(1 + x)/x` for x ≥ 0, 1 at zero.
    fn mean_of_logarithm(self) -> Self {
        let x = self.value();
        let value = if x > 0.0 { libm::log1p(x) / x } else { 1.0 };
        // Σ (-1)^n n x^(n-1)/(n+1).
        let slope = || if x < SMALL { series(-1.0, |_| -x, |n| n / (n + 1.0)) } else { (1.0 / (1.0 + x) - value) / x };
        self.chain_with(value, slope)
    }
}

/// Argument below which slopes are series, and number of their terms.
const SMALL: f64 = 0.05;
const TERMS: u32 = 14;

/// Returns the sum of `weight(n)` times powers for n = 1, 2, …; `ratio(n)` is the ratio of power n + 1 to power n.
fn series(first: f64, ratio: impl Fn(f64) -> f64, weight: impl Fn(f64) -> f64) -> f64 {
    let (mut sum, mut power) = (0.0, first);
    for n in (1..=TERMS).map(f64::from) {
        sum += weight(n) * power;
        power *= ratio(n);
    }
    sum
}

impl Scalar for f64 {
    #[inline(always)]
    fn constant(value: f64) -> f64 {
        value
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self
    }

    #[inline(always)]
    fn chain_with(self, value: f64, _: impl FnOnce() -> f64) -> f64 {
        value
    }

    #[inline(always)]
    fn of_root(root: f64, _: f64, _: f64) -> f64 {
        root
    }

    #[inline(always)]
    fn is_finite(self) -> bool {
        f64::is_finite(self)
    }

    #[inline(always)]
    fn is_negligible(self, sum: f64, part: f64) -> bool {
        self.abs() <= part * sum.abs()
    }
}

/// A number with its derivatives by N parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<const N: usize> {
    /// The number.
    pub value: f64,
    /// Its derivatives.
    pub slopes: [f64; N],
}

impl<const N: usize> Dual<N> {
    /// Combines the slopes of two numbers.
    #[inline(always)]
    fn combined(self, other: Self, value: f64, slope: impl Fn(f64, f64) -> f64) -> Self {
        Dual { value, slopes: inline_from_fn(|i| slope(self.slopes[i], other.slopes[i])) }
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.combined(other, self.value + other.value, |a, b| a + b)
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.combined(other, self.value - other.value, |a, b| a - b)
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;

    #[inline(always)]
    #[expect(clippy::suspicious_arithmetic_impl, reason = "product rule of slopes")]
    fn mul(self, other: Self) -> Self {
        self.combined(other, self.value * other.value, |a, b| a * other.value + self.value * b)
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;

    #[inline(always)]
    #[expect(clippy::suspicious_arithmetic_impl, reason = "quotient rule of slopes")]
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        self.combined(other, value, |a, b| (a - value * b) / other.value)
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        self.chain_with(-self.value, || -1.0)
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f64) -> Self {
        self.chain_with(self.value * factor, || factor)
    }
}

impl<const N: usize> Scalar for Dual<N> {
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Dual { value, slopes: [0.0; N] }
    }

    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }

    #[inline(always)]
    fn chain_with(self, value: f64, slope: impl FnOnce() -> f64) -> Self {
        let slope = slope();
        Dual { value, slopes: inline_from_fn(|i| slope * self.slopes[i]) }
    }

    #[inline(always)]
    fn of_root(root: f64, excess: Self, slope: f64) -> Self {
        excess.chain_with(root, || -1.0 / slope)
    }

    fn is_finite(self) -> bool {
        self.value.is_finite() && self.slopes.iter().all(|slope| slope.is_finite())
    }

    fn is_negligible(self, sum: Self, part: f64) -> bool {
        let mut pairs = self.slopes.iter().zip(&sum.slopes);
        self.value.is_negligible(sum.value, part) && pairs.all(|(slope, sum)| slope.is_negligible(*sum, part))
    }
}

/// Relative change of arguments in [`derivative_along`].
const STEP: f64 = 1e-3;

/// Returns the derivative of a function of several numbers along their `slopes`, by central differences of fourth order
/// with an error of about 1e-13 of the value for smooth functions (Abramowitz and Stegun 25.3.24). `None` if the function
/// has no value.
pub fn derivative_along(
    numbers: &[f64],
    slopes: &[f64],
    function: &mut dyn FnMut(&[f64]) -> Option<f64>,
) -> Option<f64> {
    let relative = |(number, slope): (&f64, &f64)| if *number != 0.0 { (slope / number).abs() } else { slope.abs() };
    let largest = numbers.iter().zip(slopes).map(relative).fold(0.0, f64::max);
    if largest == 0.0 {
        return Some(0.0);
    }
    let step = STEP / largest;
    let mut moved = |steps: f64| {
        let moved: Vec<f64> = numbers.iter().zip(slopes).map(|(number, slope)| number + steps * step * slope).collect();
        function(&moved)
    };
    let near = moved(1.0)? - moved(-1.0)?;
    let far = moved(2.0)? - moved(-2.0)?;
    Some((8.0 * near - far) / (12.0 * step))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn variable(value: f64) -> Dual<1> {
        Dual { value, slopes: [1.0] }
    }

    /// Source: derivatives of elementary functions. Slopes that are series agree with the closed forms where both are
    /// accurate.
    #[test]
    fn derivatives_match_closed_forms() {
        for x in [1e-9, 1e-3, 0.0499, 0.0501, 0.7, 5.0] {
            let dual = variable(x);
            let quotient = (dual * dual + Dual::constant(1.0)) / (dual * 3.0 - Dual::constant(20.0));
            let bottom = 3.0 * x - 20.0;
            for (found, expected) in [
                (quotient, (2.0 * x * bottom - 3.0 * (x * x + 1.0)) / (bottom * bottom)),
                (dual.sqrt(), 0.5 / x.sqrt()),
                ((-dual).exp(), -(-x).exp()),
            ] {
                assert!((found.slopes[0] / expected - 1.0).abs() < 1e-13, "{x}: {found:?} {expected}");
            }
            // Taylor polynomials with remainders below 1e-16 for small x, closed forms otherwise.
            let [decay, logarithm] = if x < 1e-2 {
                [-0.5 + x / 3.0 - x * x / 8.0 + x.powi(3) / 30.0 - x.powi(4) / 144.0, {
                    -0.5 + 2.0 / 3.0 * x - 0.75 * x * x + 0.8 * x.powi(3) - 5.0 / 6.0 * x.powi(4)
                }]
            } else {
                let squared = x * x;
                [(x * (-x).exp() + (-x).exp_m1()) / squared, (x / (1.0 + x) - x.ln_1p()) / squared]
            };
            let pairs = [(dual.mean_of_decay(), decay), (dual.mean_of_logarithm(), logarithm)];
            for (found, expected) in pairs {
                assert!((found.slopes[0] / expected - 1.0).abs() < 1e-11, "{x}: {found:?} {expected}");
            }
        }
        let at_zero = [variable(0.0).mean_of_decay(), variable(0.0).mean_of_logarithm()];
        assert_eq!(at_zero, [Dual { value: 1.0, slopes: [-0.5] }; 2]);
    }

    /// Source: d/ds of exp(x) y along (2, 3).
    #[test]
    fn derivative_along_slopes_matches_closed_form() {
        let [x, y] = [0.3, -4.0_f64];
        let function = |numbers: &[f64]| Some(libm::exp(numbers[0]) * numbers[1]);
        let found = derivative_along(&[x, y], &[2.0, 3.0], &mut { function }).expect("a derivative");
        let expected = libm::exp(x) * (2.0 * y + 3.0);
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
    }
}
