//! The stiffness of a load that follows the motion of what it pushes, measured from its own answers: what a pressure by a
//! user's routine adds to the highest frequency. Never here: what the pressure is, the choice of an increment.

use crate::kernel::lists::heap_bytes;
use crate::state::archive::persist_struct;

/// What a load was found to add to the stiffness of nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stiffness {
    /// Bound of the square of the highest angular frequency of the nodes on the load alone, 1/time^2.
    pub squared: f64,
    /// Pressure for each unit of length that a face moves outwards, of the stiffest one.
    pub rate: f64,
    /// That point, from 0 on, and its place `[r, z]`.
    pub point: u64,
    /// Its place then.
    pub place: [f64; 2],
    /// Total time at which it was first noticed.
    pub time: f64,
}

/// By how much two slopes of the pressure over the way may differ that are taken for one: what jumps has none.
const ALIKE: f64 = 0.15;
/// By how much the way of an increment must exceed that of the one before, back again: what central differences amplify.
const GROWTH: f64 = 1.3;
/// Below this square of frequency times increment a load is not what makes motion grow (the limit is 4).
const FELT: f64 = 1.0;

/// A face at the last evaluation.
#[derive(Clone, Copy, Debug)]
struct Point {
    place: [f64; 2],
    pressure: f64,
    /// Way along the outward normal and change of pressure over the increment before.
    way: f64,
    change: f64,
}

/// A face now.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Its middle.
    pub place: [f64; 2],
    /// Its outward normal.
    pub normal: [f64; 2],
    pub pressure: f64,
    /// The larger one of force at unit pressure over mass of its two nodes.
    pub mobility: f64,
}

/// Watches the faces of a load.
///
/// A pressure that changes with time, jumps at a front or follows velocity gives slopes over the way as well, so a slope alone
/// says nothing. What central differences cannot follow says more: it turns round with every increment and grows, and a
/// pressure that depends on the place changes in proportion. So a slope counts where the way turns round and is longer by
/// [`GROWTH`], the pressure turns round with it, both slopes are one within [`ALIKE`], and the load is stiff enough to be the
/// cause ([`FELT`]). It is noticed within some increments, while the motion is still as small as it began.
#[derive(Clone, Debug)]
pub struct Watch {
    points: Vec<Point>,
    most: Option<Stiffness>,
}

impl Watch {
    pub fn new(count: usize) -> Self {
        // What was never seen compares with nothing.
        let none = Point { place: [f64::NAN; 2], pressure: f64::NAN, way: f64::NAN, change: f64::NAN };
        Watch { points: vec![none; count], most: None }
    }

    pub fn bytes(&self) -> usize {
        heap_bytes(&self.points)
    }

    pub fn most(&self) -> Option<&Stiffness> {
        self.most.as_ref()
    }

    /// Goes on with what another one knows of a face.
    pub fn continue_from(&mut self, i: usize, other: &Watch, at: usize) {
        self.points[i] = other.points[at];
        self.most = self.most.or(other.most);
    }

    /// Looks at a face after an increment; the number of its point in the load, and total time.
    #[inline]
    pub fn look(&mut self, i: usize, seen: &Seen, increment: f64, point: usize, time: f64) {
        let Point { place, pressure, way, change } = self.points[i];
        // At the start of a later step the instant has been looked at.
        if increment == 0.0 && !place[0].is_nan() {
            return;
        }
        let now = Point {
            place: seen.place,
            pressure: seen.pressure,
            way: (seen.place[0] - place[0]) * seen.normal[0] + (seen.place[1] - place[1]) * seen.normal[1],
            change: seen.pressure - pressure,
        };
        self.points[i] = now;
        let turned = now.way * way < 0.0 && now.change * change < 0.0 && now.way * now.change > 0.0;
        if !turned || now.way.abs() < GROWTH * way.abs() {
            return;
        }
        let [rate, before] = [now.change / now.way, change / way];
        // A node has at most two faces of a surface, and on each half of the way of a face is its own.
        let squared = 2.0 * rate * seen.mobility;
        let alike = (rate - before).abs() <= ALIKE * rate;
        if alike && squared * increment * increment > FELT && squared > self.most.map_or(0.0, |m| m.squared) {
            let time = self.most.map_or(time, |m| m.time);
            self.most = Some(Stiffness { squared, rate, point: point as u64, place: seen.place, time });
        }
    }
}

persist_struct!(Stiffness { squared, rate, point, place, time });

persist_struct!(Point { place, pressure, way, change });

persist_struct!(Watch { points: fixed, most });

#[cfg(test)]
mod tests {
    use super::{Seen, Watch};

    /// What is measured of a face that stands at these places along its normal under a pressure.
    fn measured(places: &[f64], pressure: impl Fn(usize, f64) -> f64) -> Option<f64> {
        let mut watch = Watch::new(1);
        for (i, &z) in places.iter().enumerate() {
            let seen = Seen { place: [0.0, z], normal: [0.0, 1.0], pressure: pressure(i, z), mobility: 1.0 };
            watch.look(0, &seen, 1.0, 0, i as f64);
        }
        watch.most().map(|m| m.rate)
    }

    #[test]
    fn a_slope_counts_where_it_makes_motion_grow() {
        let growing = [0.0, 1e-3, -2e-3, 4e-3, -8e-3];
        assert_eq!(measured(&growing, |_, z| 5.0 + 4.0 * z).map(|k| (1e6 * k).round()), Some(4e6));
        // Motion that does not grow, or does not turn round.
        assert_eq!(measured(&[0.0, 1e-3, 0.0, 1e-3, 0.0], |_, z| 4.0 * z), None);
        assert_eq!(measured(&[0.0, 1e-3, 2e-3, 4e-3], |_, z| 4.0 * z), None);
        // A pressure that drives, one that jumps at a front, one that blinks, one too soft to matter, one that stays.
        assert_eq!(measured(&growing, |_, z| -4.0 * z), None);
        assert_eq!(measured(&growing, |_, z| if z > 0.0 { 1e3 } else { 0.0 }), None);
        assert_eq!(measured(&growing, |i, _| if i % 2 == 1 { 1e3 } else { 0.0 }), None);
        assert_eq!(measured(&growing, |_, z| 0.1 * z), None);
        assert_eq!(measured(&growing, |_, _| 7.0), None);
    }
}
