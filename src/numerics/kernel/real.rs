//! Floating-point types of the inner loop: double precision, and single precision for shorter run time at lower
//! accuracy.

use super::lanes::InlineMap;
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// A floating-point number. In double precision, arithmetic over this trait performs the same operations as arithmetic
/// over `f64`, in the same order.
pub trait Real:
    Copy
    + Debug
    + Default
    + PartialEq
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + Send
    + Sync
    + 'static
{
    /// Whether the type is single precision; lengths are then scaled by a unit of the element group.
    const SINGLE: bool;
    const ZERO: Self;
    const ONE: Self;

    /// Rounds a number of double precision.
    fn of(value: f64) -> Self;
    /// Converts to double precision.
    fn wide(self) -> f64;
    fn root(self) -> Self;
    /// Returns the absolute value.
    fn size(self) -> Self;
    /// Returns whether the number is NaN.
    fn is_none(self) -> bool;
    /// Calls a function with a list in double precision: the list itself, or a converted copy.
    fn with_wide<R, const N: usize>(list: &[Self; N], call: impl FnOnce(&[f64; N]) -> R) -> R;
}

macro_rules! real {
    ($number:ty, $single:literal, |$list:ident| $wide:expr) => {
        impl Real for $number {
            const SINGLE: bool = $single;
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;

            #[inline(always)]
            fn of(value: f64) -> Self {
                value as $number
            }

            #[inline(always)]
            fn wide(self) -> f64 {
                self as f64
            }

            #[inline(always)]
            fn root(self) -> Self {
                self.sqrt()
            }

            #[inline(always)]
            fn size(self) -> Self {
                self.abs()
            }

            #[inline(always)]
            fn is_none(self) -> bool {
                self.is_nan()
            }

            #[inline(always)]
            fn with_wide<R, const N: usize>($list: &[Self; N], call: impl FnOnce(&[f64; N]) -> R) -> R {
                call($wide)
            }
        }
    };
}
real!(f64, false, |list| list);
real!(f32, true, |list| &list.inline_map(f64::from));
