//! How the edges of an element flow, by what its middle says.
//! Never here: strains, loops over lanes.
#![allow(clippy::needless_range_loop)] // Both fields side by side, as lanes elsewhere.

/// Stress of the full plastic moment of a rectangle over that at which its edge yields.
const PLASTIC_MOMENT: f64 = 1.5;
/// What is left of it at least under full uniform stress, so that no pattern is free.
const LEAST_MOMENT: f64 = 0.05;

/// Largest von Mises stress at the edges beside one in the middle, where the element flows at `limit`: moment beside force in a
/// rectangle of what is perfectly plastic.
#[inline(always)]
pub(super) fn largest(mises: f64, limit: f64) -> f64 {
    let used = mises / limit;
    let rest = 1.0 - used * used;
    PLASTIC_MOMENT * limit * if rest > LEAST_MOMENT { rest } else { LEAST_MOMENT }
}

/// How the edges of an element flow.
pub(super) struct Yields {
    /// Deviator of the middle along both directions, and around.
    pub normal: [f64; 2],
    pub hoop: f64,
    /// Part of the trial stress that is left in the middle.
    pub left: f64,
    /// Moduli along a strain and beside it.
    pub modulus: [f64; 2],
    /// Plastic strain of the middle over its trial stress.
    pub most: f64,
    /// Largest von Mises stress of a pattern.
    pub bound: f64,
}

impl Yields {
    /// What flow leaves of the stresses of both fields: the edge flows along the stress of the middle and no further than that
    /// does.
    #[inline(always)]
    pub fn flow(&self, stress: [[f64; 2]; 2]) -> [[f64; 2]; 2] {
        let ([along, beside], s_h) = (self.modulus, self.hoop);
        let (mut flow, mut wanted, mut norm) = ([[0.0; 2]; 2], [0.0; 2], [0.0; 2]);
        for p in 0..2 {
            let (s_t, [t, h]) = (self.normal[p], stress[p]);
            flow[p] = [along * s_t + beside * s_h, along * s_h + beside * s_t];
            let square = s_t * flow[p][0] + s_h * flow[p][1];
            norm[p] = if square > 0.0 { square } else { 1.0 };
            wanted[p] = s_t * t + s_h * h;
        }
        let both = 1.0 / (norm[0] * norm[1]);
        let (mut rest, mut size) = (stress, [1.0; 2]);
        for p in 0..2 {
            let flowed = wanted[p] * norm[1 - p] * both;
            // What is not a number, beyond the smallest numbers, is within the bounds.
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
