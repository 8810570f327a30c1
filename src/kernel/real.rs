//! Numbers that the inner loop can be made of: double precision, and single for those who trade digits for time.
//! Never here: which elements are in single precision, the units that keep their numbers near one.

use super::lanes::InlineMap;
use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// A floating-point number. Arithmetic that is written over it has, in double precision, the operations of the same written
/// over `f64`, in their order.
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
    /// Whether it has fewer digits and a smaller range than what nodes have: lengths are then in units of their own.
    const SINGLE: bool;
    const ZERO: Self;
    const ONE: Self;

    /// The nearest number to one of double precision.
    fn of(value: f64) -> Self;
    /// The same number in double precision.
    fn wide(self) -> f64;
    fn root(self) -> Self;
    /// Without sign.
    fn size(self) -> Self;
    /// Whether it is not a number.
    fn is_none(self) -> bool;
    /// Calls a function with a list in double precision: the list itself, or a copy of one in single precision.
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
