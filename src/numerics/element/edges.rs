//! Plastic flow of assumed strains at the edges of an element, from the plastic state at its centre.
#![allow(clippy::needless_range_loop)] // Both fields are treated in parallel, as lanes elsewhere.

/// Ratio of the full plastic moment of a rectangular section to its first-yield moment.
const PLASTIC_MOMENT: f64 = 1.5;
/// Smallest fraction of the plastic moment that remains under full uniform stress, so that no pattern is without
/// resistance.
const LEAST_MOMENT: f64 = 0.05;

/// Returns the largest von Mises stress at the edges, given the von Mises stress at the centre and the yield stress
/// `limit`: interaction of moment and normal force in a perfectly plastic rectangular section.
#[inline(always)]
pub(super) fn largest(mises: f64, limit: f64) -> f64 {
    let used = mises / limit;
    let rest = 1.0 - used * used;
    PLASTIC_MOMENT * limit * if rest > LEAST_MOMENT { rest } else { LEAST_MOMENT }
}

/// Plastic state that limits the stresses at the edges of an element.
pub(super) struct EdgeYield {
    /// Deviator at the centre along both directions, and in the hoop direction.
    pub normal: [f64; 2],
    pub hoop: f64,
    /// Ratio of the returned stress to the trial stress at the centre.
    pub left: f64,
    /// Moduli of a strain: for the stress in its direction, and for the transverse stress.
    pub modulus: [f64; 2],
    /// Plastic strain at the centre over its trial stress.
    pub most: f64,
    /// Largest von Mises stress of a pattern.
    pub bound: f64,
}

impl EdgeYield {
    /// Returns the stresses of both fields after plastic flow. The edge flows along the deviator at the centre, and not
    /// more than the centre does.
    #[inline(always)]
    pub fn flow(&self, stress: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
        let ([along, transverse], s_h) = (self.modulus, self.hoop);
        let (mut flow, mut projected, mut norm) = ([[0.0; 2]; 2], [0.0; 2], [0.0; 2]);
        for p in 0..2 {
            let (s_t, [t, h]) = (self.normal[p], stress[p]);
            flow[p] = [along * s_t + transverse * s_h, along * s_h + transverse * s_t];
            let square = s_t * flow[p][0] + s_h * flow[p][1];
            norm[p] = if square > 0.0 { square } else { 1.0 };
            projected[p] = s_t * t + s_h * h;
        }
        let both = 1.0 / (norm[0] * norm[1]);
        let (mut rest, mut size) = (stress, [1.0; 2]);
        for p in 0..2 {
            let flowed = projected[p] * norm[1 - p] * both;
            // NaN, from numbers below the normal range, passes both bounds.
            let flowed = if flowed < self.most { flowed } else { self.most };
            let flowed = if flowed > -self.most { flowed } else { -self.most };
            rest[p] = [stress[p][0] - flowed * flow[p][0], stress[p][1] - flowed * flow[p][1]];
            let [t, h] = rest[p];
            size[p] = (t * (t - h) + h * h).sqrt();
        }
        let over = [self.left * size[0] > self.bound, self.left * size[1] > self.bound];
        let per = [if over[0] { size[0] } else { 1.0 }, if over[1] { size[1] } else { 1.0 }];
        let both = self.bound / (per[0] * per[1]);
        for p in 0..2 {
            let scale = if over[p] { both * per[1 - p] } else { self.left };
            rest[p] = [scale * rest[p][0], scale * rest[p][1]];
        }
        rest
    }
}
