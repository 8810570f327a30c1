//! Numbers side by side: the width in which inner loops are written, so that compilers make vectors of them.
//! Never here: what the numbers mean.

use pulp::{Arch, NullaryFnOnce};

use super::real::Real;

/// Elements side by side in the inner loop.
pub const LANES: usize = 16;

/// One number of each element of a block.
pub type Lanes<T = f64> = [T; LANES];

/// What the inner loops use in place of the standard library's `map` of arrays. That one is built from functions which a compiler
/// is free not to inline; a call inside a loop compiled for wide vectors is then compiled for the base instruction set.
pub trait InlineMap<T: Copy, const N: usize> {
    /// The array of the function's values, which is inlined always.
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

/// The array of a function's values over its indices; in place of [`std::array::from_fn`] for the reason that [`InlineMap`] gives.
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

/// Runs an operation with an instruction set; it is compiled once for all that call it.
#[inline(never)]
pub fn dispatch_outlined<F: NullaryFnOnce>(arch: Arch, operation: F) -> F::Output {
    arch.dispatch(operation)
}

/// Forces `[r, z]` of a block's elements on their corners, corner by corner. Like all that the inner loop touches it begins with
/// a cache line.
#[derive(Clone, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Corners<T = f64>(pub [[[T; 2]; LANES]; 4]);

impl<T: Real> Corners<T> {
    /// An element that no longer pulls at its corners.
    #[inline(always)]
    pub fn clear(&mut self, lane: usize) {
        self.0.iter_mut().for_each(|corner| corner[lane] = [T::ZERO; 2]);
    }
}

/// The same numbers in double precision.
#[inline(always)]
pub fn wide<T: Real>(list: &Lanes<T>) -> Lanes {
    list.inline_map(T::wide)
}

/// The nearest numbers of another precision.
#[inline(always)]
pub fn near<T: Real>(list: &Lanes) -> Lanes<T> {
    list.inline_map(T::of)
}

/// The numbers of one element in lists of four.
#[inline(always)]
pub fn column<T: Real>(list: &[Lanes<T>; 4], l: usize) -> [T; 4] {
    [list[0][l], list[1][l], list[2][l], list[3][l]]
}

/// Sum of the products of four and four numbers, in this order.
#[inline(always)]
pub fn dot(a: [f64; 4], b: [f64; 4]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}
