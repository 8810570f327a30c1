//! Linear fields of elements, limited so that no value leaves the range of the element and its neighbours (Barth and
//! Jespersen 1989, AIAA paper 89-0366), neither where material leaves an element nor in the material that stays. Loops
//! over several variables are vectorized.

use crate::kernel::lanes::inline_from_fn;

/// What passes through the sides of an element when its nodes move.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ElementFlow {
    /// Weights that enter through each side, over the weight of the element after the motion; negative if they leave.
    pub inflow: [f64; 4],
    /// Centres of the rings that pass through each side, from the centre of the element that loses them.
    pub places: [[f64; 2]; 4],
    /// Centre of the material that stays, from the centre of the element.
    pub rest: [f64; 2],
    /// Gradient for a unit difference of the value of each neighbour.
    pub slopes: [[f64; 2]; 4],
}

/// Gradient of several values along r and z.
pub(super) type Gradient<const N: usize> = [[f64; N]; 2];

impl ElementFlow {
    /// Returns the limited gradient of values, from those of the element and of its neighbours, and their range.
    #[inline(always)]
    pub fn gradient<const N: usize>(&self, own: &[f64; N], around: [&[f64; N]; 4]) -> (Gradient<N>, [[f64; N]; 2]) {
        let (mut low, mut high) = (*own, *own);
        let (mut along_r, mut along_z) = ([0.0; N], [0.0; N]);
        for (value, [r, z]) in around.iter().zip(self.slopes) {
            for l in 0..N {
                let step = value[l] - own[l];
                low[l] = smaller(value[l], low[l]);
                high[l] = larger(value[l], high[l]);
                along_r[l] += r * step;
                along_z[l] += z * step;
            }
        }
        let mut steps = [[0.0; N]; 2];
        extend(&mut steps, [&along_r, &along_z], self.rest);
        for (inflow, place) in self.inflow.iter().zip(self.places) {
            if *inflow < 0.0 {
                extend(&mut steps, [&along_r, &along_z], place);
            }
        }
        let [fall, rise] = steps;
        for l in 0..N {
            let share = smaller(share_within(high[l] - own[l], rise[l]), share_within(own[l] - low[l], -fall[l]));
            along_r[l] *= share;
            along_z[l] *= share;
        }
        ([along_r, along_z], [low, high])
    }

    /// Returns the values after the motion, from the values and gradients of the element and of its neighbours.
    #[inline(always)]
    pub fn moved<const N: usize>(
        &self,
        (own, gradient): (&[f64; N], [&[f64; N]; 2]),
        beside: [(&[f64; N], [&[f64; N]; 2]); 4],
    ) -> [f64; N] {
        let mut sum = [0.0; N];
        for ((inflow, [r, z]), (value, other)) in self.inflow.iter().zip(self.places).zip(beside) {
            if *inflow > 0.0 {
                for l in 0..N {
                    sum[l] += inflow * ((value[l] - own[l]) + (r * other[0][l] + z * other[1][l]));
                }
            } else if *inflow < 0.0 {
                for l in 0..N {
                    sum[l] += inflow * (r * gradient[0][l] + z * gradient[1][l]);
                }
            }
        }
        inline_from_fn(
            #[inline(always)]
            |l| own[l] + sum[l],
        )
    }
}

/// Extends the range of steps from the centre of an element to that of a place.
#[inline(always)]
fn extend<const N: usize>([fall, rise]: &mut [[f64; N]; 2], [along_r, along_z]: [&[f64; N]; 2], [r, z]: [f64; 2]) {
    for l in 0..N {
        let step = along_r[l] * r + along_z[l] * z;
        fall[l] = smaller(step, fall[l]);
        rise[l] = larger(step, rise[l]);
    }
}

/// Returns the share of a step that does not exceed a limit.
#[inline(always)]
fn share_within(limit: f64, step: f64) -> f64 {
    if step > limit { limit / step } else { 1.0 }
}

#[inline(always)]
pub(super) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
