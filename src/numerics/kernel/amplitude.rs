//! Functions of time (amplitudes) that scale loads and motions.

use crate::kernel::lists::Memory;

/// A tabulated amplitude: linear or smooth-step interpolation between points, constant outside (ABAQUS Analysis User's
/// Guide, "Amplitude curves").
#[derive(Clone, Debug, Memory)]
pub struct AmplitudeCurve {
    points: Vec<[f64; 2]>,
    smooth: bool,
    /// Whether times are total times instead of step times.
    pub total_time: bool,
}

impl AmplitudeCurve {
    /// Creates an amplitude from `(time, value)` points with ascending times; `smooth` selects the smooth step a(ξ) =
    /// a0 + (a1 - a0) ξ³ (10 - 15 ξ + 6 ξ²).
    pub fn new(points: Vec<[f64; 2]>, smooth: bool, total_time: bool) -> Self {
        AmplitudeCurve { points, smooth, total_time }
    }

    /// Equation (4.11).
    pub fn value(&self, time: f64) -> f64 {
        let after = self.points.partition_point(|p| p[0] <= time);
        let (Some(from), Some(to)) = (after.checked_sub(1).map(|i| self.points[i]), self.points.get(after)) else {
            return if after == 0 { self.points.first() } else { self.points.last() }.map_or(1.0, |p| p[1]);
        };
        let xi = (time - from[0]) / (to[0] - from[0]);
        let weight = if self.smooth { xi * xi * xi * (10.0 + xi * (6.0 * xi - 15.0)) } else { xi };
        from[1] + (to[1] - from[1]) * weight
    }

    /// Returns the slope at a time; at a kink the slope after it.
    pub fn slope(&self, time: f64) -> f64 {
        let after = self.points.partition_point(|p| p[0] <= time);
        let (Some(from), Some(to)) = (after.checked_sub(1).map(|i| self.points[i]), self.points.get(after)) else {
            return 0.0;
        };
        let length = to[0] - from[0];
        let xi = (time - from[0]) / length;
        let weight = if self.smooth { 30.0 * xi * xi * (1.0 - xi) * (1.0 - xi) } else { 1.0 };
        (to[1] - from[1]) * weight / length
    }

    /// Returns the time of the first point after `time`. Increments end at points, so that no kink is inside an
    /// increment.
    pub fn next_point(&self, time: f64) -> f64 {
        let scale = self.points.last().map_or(0.0, |p| p[0].abs());
        let after = self.points.partition_point(|p| p[0] <= time + 1e-12 * scale);
        self.points.get(after).map_or(f64::INFINITY, |p| p[0])
    }
}

/// An amplitude sampled during the run: linear between the last two samples, constant outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SampledAmplitude {
    /// Time and value of the previous sample.
    before: [f64; 2],
    /// Time and value of the last sample.
    last: [f64; 2],
}

impl Default for SampledAmplitude {
    fn default() -> Self {
        SampledAmplitude { before: [f64::NEG_INFINITY, 0.0], last: [f64::NEG_INFINITY, 0.0] }
    }
}

impl SampledAmplitude {
    /// Adds a sample at a total time; a sample at the same time replaces the last one.
    pub fn add_sample(&mut self, time: f64, value: f64) {
        if time > self.last[0] {
            self.before = self.last;
        }
        self.last = [time, value];
    }

    pub fn last(&self) -> f64 {
        self.last[1]
    }

    /// Returns time and value of the last two samples, the earlier first.
    pub fn points(&mut self) -> [&mut [f64; 2]; 2] {
        [&mut self.before, &mut self.last]
    }

    pub fn value(&self, time: f64) -> f64 {
        let (previous, last) = (self.before, self.last);
        if time >= last[0] || previous[0] == f64::NEG_INFINITY {
            return last[1];
        }
        if time <= previous[0] { previous[1] } else { last[1] - (last[0] - time) * self.slope() }
    }

    /// Returns the slope between the last two samples.
    pub fn slope(&self) -> f64 {
        let (previous, last) = (self.before, self.last);
        if previous[0] == f64::NEG_INFINITY { 0.0 } else { (last[1] - previous[1]) / (last[0] - previous[0]) }
    }
}

#[cfg(test)]
mod tests {
    use super::{AmplitudeCurve, SampledAmplitude};

    #[test]
    fn sampled_amplitudes_are_linear_between_samples() {
        let mut track = SampledAmplitude::default();
        assert_eq!((track.value(1.0), track.slope()), (0.0, 0.0));
        track.add_sample(0.0, 2.0);
        assert_eq!(track.value(-1.0), 2.0);
        track.add_sample(2.0, 6.0);
        assert_eq!([-1.0, 0.0, 0.5, 2.0, 3.0].map(|t| track.value(t)), [2.0, 2.0, 3.0, 6.0, 6.0]);
        track.add_sample(2.0, 8.0);
        assert_eq!((track.slope(), track.last()), (3.0, 8.0));
    }

    #[test]
    fn linear_between_points_and_constant_outside() {
        let curve = AmplitudeCurve::new(vec![[1.0, 2.0], [3.0, 6.0]], false, false);
        assert_eq!([0.0, 1.0, 2.0, 3.0, 9.0].map(|t| curve.value(t)), [2.0, 2.0, 4.0, 6.0, 6.0]);
        assert_eq!(curve.next_point(0.0), 1.0);
        assert_eq!(curve.next_point(1.0), 3.0);
        assert_eq!(curve.next_point(3.0), f64::INFINITY);
    }

    #[test]
    fn smooth_step_has_zero_slope_at_its_ends() {
        let curve = AmplitudeCurve::new(vec![[0.0, 0.0], [1.0, 1.0]], true, false);
        assert_eq!(curve.value(0.5), 0.5);
        assert!(curve.value(1e-4) < 1e-10);
    }
}
