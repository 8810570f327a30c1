//! Blocks of stations of a ring: their angles, the part of each station that moves into the material, and the part above
//! a plane. Loops over stations are plain arithmetic over lanes, so that every instruction set gives the same bits.
#![allow(clippy::needless_range_loop)] // Loops over lanes are the form that compilers turn into vectors.

use std::f64::consts::{FRAC_PI_2, PI};

use super::rings::{FacetRing, RingHarmonics, RingKinematics};
use crate::kernel::lanes::inline_from_fn;
use crate::kernel::lists::Memory;

/// Number of stations per array, large enough that compilers vectorise loops over them.
pub(super) const LANES: usize = 8;
/// Values of one quantity at a block of stations.
pub(super) type StationLanes = [f64; LANES];

/// Cosines and sines of the angles of stations, at their midpoints and edges, padded to whole arrays, and of the middle of
/// each block.
#[derive(Clone, Debug, Memory)]
pub(super) struct StationAngles {
    pub(super) count: usize,
    pub(super) middle: [Vec<StationLanes>; 2],
    edges: [[Vec<StationLanes>; 2]; 2],
    /// 1 for stations, 0 for padding.
    pub(super) weight: Vec<StationLanes>,
    /// Half the angle of a station.
    half: f64,
    /// Cosine and sine of the angle at the middle of each block.
    block_middles: Vec<[f64; 2]>,
    /// Lower bound of the cosine and upper bound of the sine of angles within half a block.
    half_block: [f64; 2],
}

impl StationAngles {
    pub(super) fn new(count: usize) -> StationAngles {
        let step = 2.0 * PI / count as f64;
        let half_block = 0.5 * LANES as f64 * step;
        let lanes = |of: &dyn Fn(usize) -> f64| -> Vec<StationLanes> {
            (0..count.div_ceil(LANES)).map(|i| inline_from_fn(|l| of(i * LANES + l))).collect()
        };
        let around = |shift: f64| {
            let angle = move |k: usize| step * (k as f64 + shift);
            [lanes(&|k| libm::cos(angle(k))), lanes(&|k| libm::sin(angle(k)))]
        };
        StationAngles {
            count,
            middle: around(0.5),
            edges: [around(0.0), around(1.0)],
            weight: lanes(&|k| f64::from(u8::from(k < count))),
            half: 0.5 * step,
            block_middles: (0..count.div_ceil(LANES))
                .map(|block| step * (LANES as f64 * (block as f64 + 0.5)))
                .map(|angle| [libm::cos(angle), libm::sin(angle)])
                .collect(),
            half_block: [libm::cos(half_block.min(PI)), libm::sin(half_block.min(FRAC_PI_2))],
        }
    }

    /// Returns bounds of `cosine cos + sine sin` over a block, edges of stations included.
    #[inline(always)]
    pub(super) fn range(&self, block: usize, [cosine, sine]: [f64; 2]) -> [f64; 2] {
        let ([c, s], [cos_half, sin_half]) = (self.block_middles[block], self.half_block);
        let (middle, slope) = (cosine * c + sine * s, (sine * c - cosine * s).abs());
        let swing = slope * sin_half;
        [middle.min(middle * cos_half) - swing, middle.max(middle * cos_half) + swing]
    }

    /// Returns bounds of the heights in the stack of a block of stations.
    #[inline(always)]
    pub(super) fn heights(
        &self,
        block: usize,
        ring: &FacetRing,
        around: &RingHarmonics,
        scene: &RingKinematics,
    ) -> [f64; 2] {
        let [low, high] = self.range(block, around.rise);
        let along = ring.along[1].abs() * scene.up[1].abs() + ring.along[0].abs() * scene.across;
        let extent = along + self.half * ring.radius * scene.across + ring.shortest_extent();
        [around.height + low - extent, around.height + high + extent]
    }
}

/// The part of each station that moves into the material, and its speed.
pub(super) struct LoadedStations {
    /// Normal velocity at the midpoint.
    pub(super) middle: StationLanes,
    /// Normal velocity of the part that moves into the material.
    pub(super) speed: StationLanes,
    /// Mean over the station of the regularisation factor of the pressure, 0 to 1.
    pub(super) share: StationLanes,
    /// Derivative of that factor with respect to the speed.
    pub(super) growth: StationLanes,
}

impl LoadedStations {
    /// Evaluates a block of stations with regularisation. The normal velocity of a station is nearly linear in the
    /// angle. The mean of the regularisation factor min(v/c, 1), 0 for v < 0, is therefore the difference of its
    /// integral at the edges over the difference of the velocities.
    #[inline(always)]
    pub(super) fn new(around: &RingHarmonics, stations: &StationAngles, block: usize, onset: f64) -> LoadedStations {
        let RingHarmonics { mean, cosine, sine, .. } = *around;
        let [cosines, sines] = [&stations.middle[0][block], &stations.middle[1][block]];
        let [first_cosines, first_sines] = [&stations.edges[0][0][block], &stations.edges[0][1][block]];
        let [second_cosines, second_sines] = [&stations.edges[1][0][block], &stations.edges[1][1][block]];
        let (mut middle, mut speed, mut share, mut growth) = ([0.0; LANES], [0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let (per, small) = (1.0 / onset, 1e-3 * onset);
        for l in 0..LANES {
            let v = mean + (cosine * cosines[l] + sine * sines[l]);
            let first = mean + (cosine * first_cosines[l] + sine * first_sines[l]);
            let second = mean + (cosine * second_cosines[l] + sine * second_sines[l]);
            let (a, b, m) = (above_zero(first), above_zero(second), above_zero(v));
            let difference = second - first;
            let even = difference.abs() < small;
            let over = 1.0 / if even { 1.0 } else { difference };
            let mean_of_line = (integral(b, per, onset) - integral(a, per, onset)) * over;
            share[l] = if even { ramp(m, per) } else { mean_of_line };
            let inside = if m > 0.0 { if m < onset { per } else { 0.0 } } else { 0.0 };
            growth[l] = if even { inside } else { (ramp(b, per) - ramp(a, per)) * over };
            let crossed = 0.5 * (a + b);
            speed[l] = if first.min(second) > 0.0 { m } else { crossed };
            middle[l] = v;
        }
        LoadedStations { middle, speed, share, growth }
    }

    /// Evaluates a block like [`LoadedStations::new`] that moves into the material everywhere at more than the
    /// regularisation speed.
    #[inline(always)]
    pub(super) fn whole(around: &RingHarmonics, stations: &StationAngles, block: usize) -> LoadedStations {
        let RingHarmonics { mean, cosine, sine, .. } = *around;
        let [cosines, sines] = [&stations.middle[0][block], &stations.middle[1][block]];
        let mut middle = [0.0; LANES];
        for l in 0..LANES {
            middle[l] = mean + (cosine * cosines[l] + sine * sines[l]);
        }
        LoadedStations { middle, speed: middle, share: [1.0; LANES], growth: [0.0; LANES] }
    }

    pub(super) fn is_any(&self) -> bool {
        self.share.iter().any(|&s| s > 0.0)
    }
}

/// Returns the positive part.
#[inline(always)]
pub(super) fn above_zero(v: f64) -> f64 {
    if v > 0.0 { v } else { 0.0 }
}

/// Returns the regularisation factor at a normal velocity of at least zero. Equation (13.6).
#[inline(always)]
fn ramp(v: f64, per_onset: f64) -> f64 {
    let share = v * per_onset;
    if share < 1.0 { share } else { 1.0 }
}

/// Returns the integral of [`ramp`] over the normal velocity.
#[inline(always)]
fn integral(v: f64, per_onset: f64, onset: f64) -> f64 {
    let (below, above) = (0.5 * v * v * per_onset, v - 0.5 * onset);
    if v < onset { below } else { above }
}

/// Extent of stations in the stack: heights of their midpoints, and half extents along the facet and around the axis.
pub(super) struct StationExtent {
    middle: StationLanes,
    larger: StationLanes,
    smaller: StationLanes,
}

impl StationExtent {
    #[inline(always)]
    pub(super) fn new(
        ring: &FacetRing,
        around: &RingHarmonics,
        stations: &StationAngles,
        block: usize,
        scene: &RingKinematics,
    ) -> StationExtent {
        let ([cosines, sines], up) = (&stations.middle, scene.up);
        let (c, s) = (&cosines[block], &sines[block]);
        let (mut middle, mut larger, mut smaller) = ([0.0; LANES], [0.0; LANES], [0.0; LANES]);
        let least = ring.shortest_extent();
        for l in 0..LANES {
            middle[l] = around.height + (around.rise[0] * c[l] + around.rise[1] * s[l]);
            let along = (ring.along[1] * up[1] + ring.along[0] * (up[0] * c[l] + up[2] * s[l])).abs();
            let across = stations.half * (around.rise[1] * c[l] - around.rise[0] * s[l]).abs();
            larger[l] = along.max(across).max(least);
            smaller[l] = along.min(across);
        }
        StationExtent { middle, larger, smaller }
    }

    /// Returns the part of each station above a plane. A station is approximated by the parallelogram that is tangent
    /// at its midpoint: its height is the sum of two uniform distributions, so the result is the integral of a
    /// trapezoid, which is smooth in the position of the plane.
    #[inline(always)]
    pub(super) fn share_above(&self, plane: f64) -> StationLanes {
        let mut share = [0.0; LANES];
        for l in 0..LANES {
            let (a, b) = (self.larger[l], self.smaller[l]);
            let distance = self.middle[l] - plane;
            let x = distance.abs().min(a + b);
            // From the midpoint outwards: 1/2 + x/2a minus the contribution of the rounded end.
            let beyond = (x - (a - b)).max(0.0);
            let rounded = beyond * beyond / (8.0 * a * b.max(1e-100));
            let half = (0.5 * x / a - rounded).min(0.5);
            share[l] = if distance > 0.0 { 0.5 + half } else { 0.5 - half };
        }
        share
    }
}
