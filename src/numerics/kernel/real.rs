//! Numbers of the element arithmetic: one `f64`, or the pack of a vector register ([`super::pack::Pack`]).

use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number, or several numbers on which each operation acts in the same way. All types perform the same operations in
/// the same order, so that results have the same bits.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Returns a constant of the same type.
    fn like(self, value: f64) -> Self;
    fn root(self) -> Self;
    /// Returns the absolute value.
    fn size(self) -> Self;
    /// Returns `yes` if the number is less than `limit`, otherwise `no`, also for NaN.
    fn if_less(self, limit: Self, yes: Self, no: Self) -> Self;

    /// Returns the smaller of two numbers; the limit if either is NaN.
    #[inline(always)]
    fn at_most(self, limit: Self) -> Self {
        self.if_less(limit, self, limit)
    }
}

impl Real for f64 {
    #[inline(always)]
    fn like(self, value: f64) -> Self {
        value
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
    fn if_less(self, limit: Self, yes: Self, no: Self) -> Self {
        if self < limit { yes } else { no }
    }
}
