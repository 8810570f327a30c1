//! Lanes: the arrays of fixed width over which inner loops are written, so that compilers vectorize them.

use pulp::{Arch, NullaryFnOnce};

use super::real::Real;

/// Number of elements of a block.
pub const LANES: usize = 16;

/// One number for each element of a block.
pub type Lanes<T = f64> = [T; LANES];

/// Inlined replacement of the standard library's `map` of arrays. That one consists of functions that a compiler need
/// not inline; a call inside a loop compiled for wide vectors is then compiled for the base instruction set.
pub trait InlineMap<T: Copy, const N: usize> {
    /// Returns the array of the function's values; always inlined.
    fn inline_map<U: Copy>(self, value: impl FnMut(T) -> U) -> [U; N];
}

impl<T: Copy, const N: usize> InlineMap<T, N> for [T; N] {
    #[inline(always)]
    fn inline_map<U: Copy>(self, mut value: impl FnMut(T) -> U) -> [U; N] {
        inline_from_fn(
            #[inline(always)]
            |i| value(self[i]),
        )
    }
}

/// Returns the array of a function's values over its indices. Replaces [`std::array::from_fn`] for the reason given at
/// [`InlineMap`].
#[inline(always)]
pub fn inline_from_fn<T: Copy, const N: usize>(mut value: impl FnMut(usize) -> T) -> [T; N] {
    const { assert!(N > 0) };
    let mut list = [value(0); N];
    #[expect(clippy::needless_range_loop, reason = "iterators are calls as well")]
    for i in 1..N {
        list[i] = value(i);
    }
    list
}

/// Runs an operation with an instruction set; it is compiled once for all callers.
#[inline(never)]
pub fn dispatch_outlined<F: NullaryFnOnce>(arch: Arch, operation: F) -> F::Output {
    arch.dispatch(operation)
}

/// Corner forces `[r, z]` of a block's elements, corner by corner; aligned to cache lines, as all data of the inner
/// loop.
#[derive(Clone, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct BlockCornerForces<T = f64>(pub [[[T; 2]; LANES]; 4]);

impl<T: Real> BlockCornerForces<T> {
    /// Sets the forces of an element to zero.
    #[inline(always)]
    pub fn clear(&mut self, lane: usize) {
        self.0.iter_mut().for_each(|corner| corner[lane] = [T::ZERO; 2]);
    }
}

/// Converts to double precision.
#[inline(always)]
pub fn wide<T: Real>(list: &Lanes<T>) -> Lanes {
    list.inline_map(T::wide)
}

/// Rounds to another precision.
#[inline(always)]
pub fn near<T: Real>(list: &Lanes) -> Lanes<T> {
    list.inline_map(T::of)
}

/// Returns the four values of one element.
#[inline(always)]
pub fn column<T: Real>(list: &[Lanes<T>; 4], l: usize) -> [T; 4] {
    [list[0][l], list[1][l], list[2][l], list[3][l]]
}

/// Returns the scalar product of four numbers, summed in this order.
#[inline(always)]
pub fn dot(a: [f64; 4], b: [f64; 4]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}
