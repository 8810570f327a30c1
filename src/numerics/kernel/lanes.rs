//! Lanes: the arrays of fixed width over which inner loops are written, so that compilers vectorize them.

use pulp::{Arch, WithSimd};

use super::real::Real;

/// Number of elements of a block.
pub const LANES: usize = 16;

/// One number for each element of a block.
pub type Lanes = [f64; LANES];

/// Inlined replacement of the standard library's `map` of arrays. That one consists of functions that a compiler need
/// not inline; a call inside a loop compiled for wide vectors is then compiled for the base instruction set.
pub trait InlineMap<T: Copy, const N: usize> {
    /// Returns the array of the function's values; always inlined.
    fn inline_map<U: Copy>(self, value: impl FnMut(T) -> U) -> [U; N];
}

/// Number of variables of an element that adaptive meshes transport together.
pub const PACK: usize = 8;

/// Variables of an element that are transported together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Pack(pub [f64; PACK]);

/// Short arrays without a loop: before it is unrolled, compilers would keep them in memory.
macro_rules! inline_map {
    ($($count:literal: $($i:literal)*;)*) => {
        $(impl<T: Copy> InlineMap<T, $count> for [T; $count] {
            #[inline(always)]
            fn inline_map<U: Copy>(self, mut value: impl FnMut(T) -> U) -> [U; $count] {
                [$(value(self[$i])),*]
            }
        })*
    };
}
inline_map! {
    1: 0;
    2: 0 1;
    3: 0 1 2;
    4: 0 1 2 3;
    5: 0 1 2 3 4;
    6: 0 1 2 3 4 5;
    7: 0 1 2 3 4 5 6;
    8: 0 1 2 3 4 5 6 7;
}

impl<T: Copy> InlineMap<T, LANES> for [T; LANES] {
    #[inline(always)]
    fn inline_map<U: Copy>(self, mut value: impl FnMut(T) -> U) -> [U; LANES] {
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

/// Runs an operation with an instruction set; it is compiled once for all callers. The operation must not be a closure:
/// the standard library's call of a closure is not inlined here, and would be compiled without the instruction set.
#[inline(never)]
pub fn dispatch_outlined<F: WithSimd>(arch: Arch, operation: F) -> F::Output {
    arch.dispatch(operation)
}

/// Corner forces of a block's elements, corner by corner: along r, then along z.
pub type BlockCornerForces = [[Lanes; 2]; 4];

/// Returns the four values of one element.
#[inline(always)]
pub fn column(list: &[Lanes; 4], l: usize) -> [f64; 4] {
    [list[0][l], list[1][l], list[2][l], list[3][l]]
}

/// Sets the four values of one element.
#[inline(always)]
pub fn put_column(list: &mut [Lanes; 4], l: usize, values: [f64; 4]) {
    for (list, value) in list.iter_mut().zip(values) {
        list[l] = value;
    }
}

/// Returns the scalar product of four numbers, summed in this order.
#[inline(always)]
pub fn dot<T: Real>(a: [T; 4], b: [T; 4]) -> T {
    (a[0] * b[0] + a[1] * b[1]) + (a[2] * b[2] + a[3] * b[3])
}
