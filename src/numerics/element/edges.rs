//! Plastic flow of assumed strains at the edges of an element, from the plastic state at its centre.

use pulp::Simd;

use crate::kernel::lanes::InlineMap;
use crate::kernel::pack::Pack;
use crate::kernel::real::Real;

/// Ratio of the full plastic moment of a rectangular section to its first-yield moment.
const PLASTIC_MOMENT: f64 = 1.5;
/// Smallest fraction of the plastic moment that remains under full uniform stress, so that no pattern is without
/// resistance.
const LEAST_MOMENT: f64 = 0.05;

/// Stresses of both fields: in their direction, and hoop.
type EdgeStress<T> = [[T; 2]; 2];

/// Plastic flow at the edges of an element.
pub(super) struct EdgeFlow<T> {
    /// Deviator at the centre along both directions, and in the hoop direction.
    pub normal: [T; 2],
    pub hoop: T,
    /// Moduli of a strain: for the stress in its direction, and for the transverse stress.
    pub modulus: [T; 2],
    /// Plastic strain at the centre over its trial stress.
    pub most: T,
}

impl<T: Real> EdgeFlow<T> {
    /// Returns the stresses of both fields after plastic flow. The edge flows along the deviator at the centre, and not
    /// more than the centre does. Equation (5.12).
    #[inline(always)]
    pub fn apply(&self, stress: EdgeStress<T>) -> EdgeStress<T> {
        let ([along, transverse], s_h, cap) = (self.modulus, self.hoop, self.most);
        let flow = self.normal.inline_map(
            #[inline(always)]
            |s_t| [along * s_t + transverse * s_h, along * s_h + transverse * s_t],
        );
        let (zero, unity) = (s_h.like(0.0), s_h.like(1.0));
        let norm = [0, 1].inline_map(
            #[inline(always)]
            |p: usize| {
                let square = self.normal[p] * flow[p][0] + s_h * flow[p][1];
                zero.if_less(square, square, unity)
            },
        );
        let both = unity / (norm[0] * norm[1]);
        [0, 1].inline_map(
            #[inline(always)]
            |p: usize| {
                let [t, h] = stress[p];
                // NaN, from numbers below the normal range, becomes the bound.
                let flowed = ((self.normal[p] * t + s_h * h) * norm[1 - p] * both).at_most(cap);
                let flowed = (-cap).if_less(flowed, flowed, -cap);
                [t - flowed * flow[p][0], h - flowed * flow[p][1]]
            },
        )
    }
}

/// Limit of the stresses at the edges of an element: interaction of moment and normal force in a perfectly plastic
/// rectangular section.
pub(super) struct EdgeLimit<T> {
    /// Largest von Mises stress of a pattern times the yield stress.
    most: T,
    /// Yield stress.
    limit: T,
    /// Ratio of the returned stress to the trial stress at the centre.
    left: T,
}

impl<T: Real> EdgeLimit<T> {
    /// Returns the limit from the von Mises stress at the centre, the yield stress, and the stress fraction that damage
    /// leaves.
    #[inline(always)]
    pub fn new(mises: T, limit: T, share: T, left: T) -> Self {
        let square = limit * limit;
        let (remainder, least) = (square - mises * mises, square.like(LEAST_MOMENT) * square);
        EdgeLimit {
            most: share * square.like(PLASTIC_MOMENT) * least.if_less(remainder, remainder, least),
            limit,
            left,
        }
    }

    /// Returns the square of the von Mises stress of a field.
    #[inline(always)]
    pub fn square([t, h]: [T; 2]) -> T {
        t * (t - h) + h * h
    }

    /// Returns the stresses of both fields, reduced to the limit, from the stresses before the return at the centre and
    /// their squares.
    #[inline(always)]
    pub fn apply(&self, stress: EdgeStress<T>, squares: [T; 2]) -> EdgeStress<T> {
        let (cap, share) = (self.most, self.left);
        let [first, second] = self.products(squares);
        let (square, unity) = (cap * cap, cap.like(1.0));
        let size = [square.if_less(first, squares[0].root(), unity), square.if_less(second, squares[1].root(), unity)];
        let both = cap / (self.limit * (size[0] * size[1]));
        let scale = [square.if_less(first, both * size[1], share), square.if_less(second, both * size[0], share)];
        let [[t_a, h_a], [t_c, h_c]] = stress;
        [[scale[0] * t_a, scale[0] * h_a], [scale[1] * t_c, scale[1] * h_c]]
    }

    /// Returns the squares of the returned stresses times the squared yield stress.
    #[inline(always)]
    fn products(&self, squares: [T; 2]) -> [T; 2] {
        let returned = self.left * self.limit;
        [squares[0] * (returned * returned), squares[1] * (returned * returned)]
    }
}

impl<S: Simd> EdgeLimit<Pack<S>> {
    /// Returns whether any stress exceeds the limit.
    #[inline(always)]
    pub fn is_exceeded(&self, squares: [Pack<S>; 2]) -> bool {
        let [first, second] = self.products(squares);
        let square = self.most * self.most;
        square.any_less(first.if_less(second, second, first))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Yield stress, von Mises stress at the centre, stress fraction that damage leaves, and ratio of the returned stress.
    const CASES: [[f64; 4]; 4] =
        [[300.0, 0.0, 1.0, 1.0], [300.0, 200.0, 1.0, 0.8], [0.02, 0.0199, 1.0, 0.3], [4e8, 4e8, 0.5, 0.6]];

    /// The von Mises stress of a field is the fraction that returns, and at most that of the plastic moment of a
    /// rectangular section under an axial force, 1.5 Y (1 - (q/Y)²), where the bracket is at least 1/20. Each field has its own
    /// limit, in any unit of stress.
    #[test]
    fn each_field_is_limited_to_the_plastic_moment() {
        for [yielding, mises, share, returned] in CASES {
            let limit = EdgeLimit::new(mises, yielding, share, returned);
            let moment = 1.5 * share * yielding * (1.0 - (mises / yielding).powi(2)).max(0.05);
            let sizes = [0.1, 0.99, 1.01, 30.0].map(|part| part * moment / returned);
            for [first, second] in sizes.iter().flat_map(|&first| sizes.map(|second| [first, second])) {
                // Pure tension, and pure shear with the von Mises stress √3 times the shear stress.
                let stress = [[0.0, -first], [second / 3.0_f64.sqrt(), -second / 3.0_f64.sqrt()]];
                let limited = limit.apply(stress, stress.map(EdgeLimit::square));
                for (trial, [direct, hoop]) in [first, second].into_iter().zip(limited) {
                    let size = (direct * direct - direct * hoop + hoop * hoop).sqrt();
                    let expected = moment.min(returned * trial);
                    assert!((size / expected - 1.0).abs() < 1e-12, "{first} {second}: {size} {expected}");
                }
                assert_eq!(limited[0][0], 0.0);
                assert_eq!(limited[1][0], -limited[1][1]);
            }
        }
    }
}
