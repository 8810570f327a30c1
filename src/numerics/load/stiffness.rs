//! Stiffness of a displacement-dependent load, estimated from its own pressures. A user subroutine whose pressure
//! depends on position raises the highest frequency of the model.

use crate::kernel::lists::Memory;
use crate::state::archive::Persist;

/// Estimated stiffness that a load adds to nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Persist)]
pub struct LoadStiffness {
    /// Upper bound of the squared angular frequency of the nodes on the load alone, 1/time².
    pub squared: f64,
    /// Pressure increase per outward displacement at the stiffest face.
    pub rate: f64,
    /// Index (from 0) of that face.
    pub point: u64,
    /// Position `[r, z]` of that face.
    pub place: [f64; 2],
    /// Total time of the first detection.
    pub time: f64,
}

/// Largest relative difference of two consecutive slopes dp/dx that count as equal. A pressure that jumps has no such
/// slope.
const SLOPE_TOLERANCE: f64 = 0.15;
/// Smallest ratio of the displacement of an increment to the previous, opposite one: growth that shows an instability
/// of central differences.
const GROWTH: f64 = 1.3;
/// Smallest (omega dt)² at which the load can be the cause of the growth (the stability limit is 4).
const MIN_STIFFNESS: f64 = 1.0;

/// Values of a face at the last evaluation.
#[derive(Clone, Copy, Debug, Persist)]
struct FaceHistory {
    place: [f64; 2],
    pressure: f64,
    /// Displacement along the outward normal and change of pressure over the previous increment.
    way: f64,
    change: f64,
}

/// Current values of a face.
#[derive(Clone, Copy, Debug)]
pub struct FaceSample {
    /// Midpoint, `[r, z]`.
    pub place: [f64; 2],
    /// Outward unit normal.
    pub normal: [f64; 2],
    pub pressure: f64,
    /// Nodal force at unit pressure over nodal mass, the larger of its two nodes.
    pub mobility: f64,
}

/// Detects whether a load makes the motion of its faces unstable.
///
/// A slope dp/dx alone is no evidence: pressures that depend on time or velocity, or that jump at a front, also show
/// one. An instability of central differences changes its sign in every increment and grows, and a pressure that
/// depends on position follows it in proportion. A slope therefore counts only if the displacement changes its sign and
/// grows by [`GROWTH`], the pressure changes its sign too, two consecutive slopes agree within [`SLOPE_TOLERANCE`], and
/// the load is stiff enough ([`MIN_STIFFNESS`]). Detection takes a few increments, while the amplitude is still small.
#[derive(Clone, Debug, Persist, Memory)]
#[persist(fixed: points)]
pub struct StiffnessMonitor {
    points: Vec<FaceHistory>,
    most: Option<LoadStiffness>,
}

impl StiffnessMonitor {
    pub fn new(count: usize) -> Self {
        // NaN: the first comparisons are false.
        let none = FaceHistory { place: [f64::NAN; 2], pressure: f64::NAN, way: f64::NAN, change: f64::NAN };
        StiffnessMonitor { points: vec![none; count], most: None }
    }

    pub fn stiffest(&self) -> Option<&LoadStiffness> {
        self.most.as_ref()
    }

    /// Copies the history of face `at` of another monitor to face `i`.
    pub fn continue_from(&mut self, i: usize, other: &StiffnessMonitor, at: usize) {
        self.points[i] = other.points[at];
        self.most = self.most.or(other.most);
    }

    /// Keeps a stiffness that was measured on a previous mesh.
    pub fn keep(&mut self, stiffest: Option<&LoadStiffness>) {
        self.most = self.most.or(stiffest.copied());
    }

    /// Records a face after an increment. `point` is its index in the load, `time` the total time.
    #[inline]
    pub fn sample(&mut self, i: usize, sample: &FaceSample, increment: f64, point: usize, time: f64) {
        let FaceHistory { place, pressure, way, change } = self.points[i];
        // At the start of a later step this instant was already recorded.
        if increment == 0.0 && !place[0].is_nan() {
            return;
        }
        let now = FaceHistory {
            place: sample.place,
            pressure: sample.pressure,
            way: (sample.place[0] - place[0]) * sample.normal[0] + (sample.place[1] - place[1]) * sample.normal[1],
            change: sample.pressure - pressure,
        };
        self.points[i] = now;
        let turned = now.way * way < 0.0 && now.change * change < 0.0 && now.way * now.change > 0.0;
        if !turned || now.way.abs() < GROWTH * way.abs() {
            return;
        }
        let [rate, before] = [now.change / now.way, change / way];
        // Bound by row sums, hence the factor 2: a node belongs to at most two faces of a surface, and the displacement
        // of a face is the mean of its two nodes.
        let squared = 2.0 * rate * sample.mobility;
        let alike = (rate - before).abs() <= SLOPE_TOLERANCE * rate;
        if alike && squared * increment * increment > MIN_STIFFNESS && squared > self.most.map_or(0.0, |m| m.squared) {
            let time = self.most.map_or(time, |m| m.time);
            self.most = Some(LoadStiffness { squared, rate, point: point as u64, place: sample.place, time });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{FaceSample, StiffnessMonitor};

    /// Returns the measured slope of a face at these positions along its normal.
    fn measured(places: &[f64], pressure: impl Fn(usize, f64) -> f64) -> Option<f64> {
        let mut monitor = StiffnessMonitor::new(1);
        for (i, &z) in places.iter().enumerate() {
            let sample = FaceSample { place: [0.0, z], normal: [0.0, 1.0], pressure: pressure(i, z), mobility: 1.0 };
            monitor.sample(0, &sample, 1.0, 0, i as f64);
        }
        monitor.stiffest().map(|m| m.rate)
    }

    #[test]
    fn stiffness_is_detected_only_if_motion_grows() {
        let growing = [0.0, 1e-3, -2e-3, 4e-3, -8e-3];
        assert_eq!(measured(&growing, |_, z| 5.0 + 4.0 * z).map(|k| (1e6 * k).round()), Some(4e6));
        // Motion that does not grow, or does not change its direction.
        assert_eq!(measured(&[0.0, 1e-3, 0.0, 1e-3, 0.0], |_, z| 4.0 * z), None);
        assert_eq!(measured(&[0.0, 1e-3, 2e-3, 4e-3], |_, z| 4.0 * z), None);
        // A pressure that drives the motion, one that jumps, one that alternates in time, one that is too soft, a
        // constant one.
        assert_eq!(measured(&growing, |_, z| -4.0 * z), None);
        assert_eq!(measured(&growing, |_, z| if z > 0.0 { 1e3 } else { 0.0 }), None);
        assert_eq!(measured(&growing, |i, _| if i % 2 == 1 { 1e3 } else { 0.0 }), None);
        assert_eq!(measured(&growing, |_, z| 0.1 * z), None);
        assert_eq!(measured(&growing, |_, _| 7.0), None);
    }
}
