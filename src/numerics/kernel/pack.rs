//! Packs: as many lanes of a block as a vector register of the selected instruction set has. The arithmetic of elements
//! is written over packs, so that intermediate results stay in registers.

use std::ops::{Add, Div, Mul, Neg, Sub};

use pulp::Simd;

use super::lanes::{LANES, Lanes};
use super::real::Real;

/// Numbers of some lanes, in a vector register.
#[derive(Clone, Copy)]
pub struct Pack<S: Simd> {
    simd: S,
    lanes: S::f64s,
}

/// Position of a pack in the lanes of a block.
#[derive(Clone, Copy)]
pub struct PackPosition<S> {
    simd: S,
    index: usize,
}

impl<S: Simd> PackPosition<S> {
    /// Number of packs of a block.
    pub const COUNT: usize = LANES / S::F64_LANES;

    /// Returns the position of the pack `index`, less than [`PackPosition::COUNT`].
    #[inline(always)]
    pub fn new(simd: S, index: usize) -> Self {
        PackPosition { simd, index }
    }

    /// Returns a number for all lanes.
    #[inline(always)]
    pub fn splat(self, value: f64) -> Pack<S> {
        Pack { simd: self.simd, lanes: self.simd.splat_f64s(value) }
    }

    /// Returns the numbers at this position of a list.
    #[inline(always)]
    pub fn load(self, list: &Lanes) -> Pack<S> {
        Pack { simd: self.simd, lanes: S::as_simd_f64s(list).0[self.index] }
    }

    /// Returns the numbers at this position of several lists.
    #[inline(always)]
    pub fn load_all<const N: usize, L: LaneLists<N>>(self, lists: &L) -> [Pack<S>; N] {
        lists.load(self)
    }

    /// Writes numbers to this position of a list.
    #[inline(always)]
    pub fn store(self, pack: Pack<S>, list: &mut Lanes) {
        S::as_mut_simd_f64s(list).0[self.index] = pack.lanes;
    }

    /// Writes numbers to this position of several lists.
    #[inline(always)]
    pub fn store_all<const N: usize, L: LaneLists<N>>(self, packs: [Pack<S>; N], lists: &mut L) {
        lists.store(self, packs);
    }

    /// Adds numbers to those at this position of a list.
    #[inline(always)]
    pub fn add(self, more: Pack<S>, list: &mut Lanes) {
        self.store(self.load(list) + more, list);
    }
}

/// Several lists of lanes. There are no loops over them: before they are unrolled, compilers would keep packs in memory.
pub trait LaneLists<const N: usize> {
    /// Returns the numbers at a position of all lists.
    fn load<S: Simd>(&self, at: PackPosition<S>) -> [Pack<S>; N];
    /// Writes numbers to a position of all lists.
    fn store<S: Simd>(&mut self, at: PackPosition<S>, packs: [Pack<S>; N]);
}

macro_rules! lane_lists {
    ($($count:literal: $($i:literal)*;)*) => {
        $(impl LaneLists<$count> for [Lanes; $count] {
            #[inline(always)]
            fn load<S: Simd>(&self, at: PackPosition<S>) -> [Pack<S>; $count] {
                [$(at.load(&self[$i])),*]
            }

            #[inline(always)]
            fn store<S: Simd>(&mut self, at: PackPosition<S>, packs: [Pack<S>; $count]) {
                $(at.store(packs[$i], &mut self[$i]);)*
            }
        })*
    };
}
lane_lists! {
    2: 0 1;
    3: 0 1 2;
    4: 0 1 2 3;
}

impl<S: Simd> Pack<S> {
    /// Returns whether any number is less than that of `limit`.
    #[inline(always)]
    pub fn any_less(self, limit: Self) -> bool {
        self.simd.first_true_m64s(self.simd.less_than_f64s(self.lanes, limit.lanes)) < S::F64_LANES
    }

    /// Returns `yes` where the number replaces the largest rate so far, otherwise `no`
    /// ([`crate::element::lane_sums::is_larger`]).
    #[inline(always)]
    pub fn if_larger_rate(self, largest: Self, yes: Self, no: Self) -> Self {
        let simd = self.simd;
        let is_none = |x: S::f64s| simd.not_m64s(simd.equal_f64s(x, x));
        let first_none = simd.and_m64s(is_none(self.lanes), simd.not_m64s(is_none(largest.lanes)));
        let larger = simd.or_m64s(simd.less_than_f64s(largest.lanes, self.lanes), first_none);
        Pack { simd, lanes: simd.select_f64s(larger, yes.lanes, no.lanes) }
    }
}

macro_rules! operator {
    ($operator:ident, $name:ident, $operation:ident) => {
        impl<S: Simd> $operator for Pack<S> {
            type Output = Self;

            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Pack { simd: self.simd, lanes: self.simd.$operation(self.lanes, other.lanes) }
            }
        }

        impl<S: Simd> $operator<Pack<S>> for f64 {
            type Output = Pack<S>;

            #[inline(always)]
            fn $name(self, other: Pack<S>) -> Pack<S> {
                other.like(self).$name(other)
            }
        }
    };
}
operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

impl<S: Simd> Neg for Pack<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Pack { simd: self.simd, lanes: self.simd.neg_f64s(self.lanes) }
    }
}

impl<S: Simd> Real for Pack<S> {
    #[inline(always)]
    fn like(self, value: f64) -> Self {
        Pack { simd: self.simd, lanes: self.simd.splat_f64s(value) }
    }

    #[inline(always)]
    fn root(self) -> Self {
        Pack { simd: self.simd, lanes: self.simd.sqrt_f64s(self.lanes) }
    }

    #[inline(always)]
    fn size(self) -> Self {
        Pack { simd: self.simd, lanes: self.simd.abs_f64s(self.lanes) }
    }

    #[inline(always)]
    fn if_less(self, limit: Self, yes: Self, no: Self) -> Self {
        let less = self.simd.less_than_f64s(self.lanes, limit.lanes);
        Pack { simd: self.simd, lanes: self.simd.select_f64s(less, yes.lanes, no.lanes) }
    }
}
