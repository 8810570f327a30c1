//! Profiles of analytical surfaces: chains of straight lines and circular arcs, signed distances, fillets.
//!
//! The front is to the left of the direction along the chain: the normal of a segment is its direction rotated 90
//! degrees counter-clockwise (Getting Started with Abaqus, 12.5, "Modeling issues for rigid surfaces"). Distances are
//! positive in front.

use super::lanes::InlineMap;
/// A straight line or an arc of less than half a circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProfileSegment {
    /// Line between two points.
    Line([[f64; 2]; 2]),
    /// Arc with its end points, centre, radius and direction: 1 counter-clockwise, -1 clockwise.
    Arc([[f64; 2]; 2], [f64; 2], f64, f64),
}

/// Sine of the angle below which the transition between segments is smooth.
const SMOOTH: f64 = 1e-6;

/// A point is on the axis if its |r| is at most this multiple of |z|.
const ON_AXIS: f64 = 1e-9;

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn length(a: [f64; 2]) -> f64 {
    libm::hypot(a[0], a[1])
}

fn unit(a: [f64; 2]) -> [f64; 2] {
    let l = length(a);
    [a[0] / l, a[1] / l]
}

impl ProfileSegment {
    /// Creates the shorter arc between two points around a centre; the radius is the mean distance of the end points
    /// from the centre.
    pub fn arc(from: [f64; 2], to: [f64; 2], centre: [f64; 2]) -> ProfileSegment {
        let (u, v) = (minus(from, centre), minus(to, centre));
        let turn = if cross(u, v) < 0.0 { -1.0 } else { 1.0 };
        ProfileSegment::Arc([from, to], centre, 0.5 * (length(u) + length(v)), turn)
    }

    /// Returns the start and the end of the segment, `[r, z]` each.
    pub fn ends(&self) -> [[f64; 2]; 2] {
        match *self {
            ProfileSegment::Line(ends) | ProfileSegment::Arc(ends, ..) => ends,
        }
    }

    /// Returns the segment in the opposite direction.
    pub fn reversed(&self) -> ProfileSegment {
        match *self {
            ProfileSegment::Line([a, b]) => ProfileSegment::Line([b, a]),
            ProfileSegment::Arc([a, b], centre, radius, turn) => ProfileSegment::Arc([b, a], centre, radius, -turn),
        }
    }

    /// Returns the unit direction at the start (0) or the end (1).
    pub fn direction(&self, end: usize) -> [f64; 2] {
        match *self {
            ProfileSegment::Line([a, b]) => unit(minus(b, a)),
            ProfileSegment::Arc(ends, centre, _, turn) => {
                let u = unit(minus(ends[end], centre));
                [-turn * u[1], turn * u[0]]
            }
        }
    }

    /// Returns the signed distance of a point from the infinite line or full circle of the segment, which is displaced
    /// by `lift` along z.
    pub fn gap(&self, point: [f64; 2], lift: f64) -> f64 {
        match *self {
            ProfileSegment::Line([a, _]) => {
                let n = self.normal(point, lift);
                n[0] * (point[0] - a[0]) + n[1] * (point[1] - (a[1] + lift))
            }
            ProfileSegment::Arc(_, c, radius, turn) => {
                turn * (radius - length([point[0] - c[0], point[1] - (c[1] + lift)]))
            }
        }
    }

    /// Returns the unit normal at the projection of a point.
    pub fn normal(&self, point: [f64; 2], lift: f64) -> [f64; 2] {
        match *self {
            ProfileSegment::Line([a, b]) => {
                let t = unit(minus(b, a));
                [-t[1], t[0]]
            }
            ProfileSegment::Arc(_, c, _, turn) => {
                let u = unit([point[0] - c[0], point[1] - (c[1] + lift)]);
                [-turn * u[0], -turn * u[1]]
            }
        }
    }

    /// Returns the position of a point's projection: -1 before the start, 1 beyond the end, 0 on the segment.
    pub fn side_of(&self, point: [f64; 2], lift: f64) -> i8 {
        let [a, b] = self.ends();
        let p = [point[0], point[1] - lift];
        let (before_start, beyond_end) = match *self {
            ProfileSegment::Line(_) => {
                let t = minus(b, a);
                (dot(minus(p, a), t) < 0.0, dot(minus(p, b), t) > 0.0)
            }
            ProfileSegment::Arc(_, c, _, turn) => {
                let (u, v, w) = (minus(a, c), minus(b, c), minus(p, c));
                let (before_start, beyond_end) = (turn * cross(u, w) < 0.0, turn * cross(w, v) < 0.0);
                // On the opposite side of the circle the nearer end point decides.
                let nearer_start = dot(w, u) > dot(w, v);
                (before_start && (!beyond_end || nearer_start), beyond_end && (!before_start || !nearer_start))
            }
        };
        i8::from(beyond_end) - i8::from(before_start)
    }

    /// Returns the lower and upper corner of the bounding box.
    fn bounds(&self) -> [[f64; 2]; 2] {
        let [a, b] = self.ends();
        let mut low = [a[0].min(b[0]), a[1].min(b[1])];
        let mut high = [a[0].max(b[0]), a[1].max(b[1])];
        if let ProfileSegment::Arc(_, c, radius, _) = *self {
            for (axis, sign) in [(0, -1.0), (0, 1.0), (1, -1.0), (1, 1.0)] {
                let mut extreme = c;
                extreme[axis] += sign * radius;
                if self.side_of(extreme, 0.0) == 0 {
                    low[axis] = low[axis].min(extreme[axis]);
                    high[axis] = high[axis].max(extreme[axis]);
                }
            }
        }
        [low, high]
    }
}

/// A chain of segments, each starting at the end of the previous one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceProfile {
    /// Segments in order; at least one.
    pub segments: Vec<ProfileSegment>,
}

/// The point of a profile that is closest to a given point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestPlace {
    pub segment: usize,
    /// Signed distance of the given point from the profile; positive in front.
    pub gap: f64,
    /// Whether the closest point is an end of the chain, beyond which the given point is.
    pub beyond: bool,
}

impl SurfaceProfile {
    /// Returns the closest point of a profile that is displaced by `lift` along z. If it is a corner, the given point
    /// is in front of a convex corner, and behind a concave one.
    pub fn nearest(&self, point: [f64; 2], lift: f64) -> NearestPlace {
        // A node on the axis without boundary condition may be slightly at r < 0; its mirror image is used.
        let point = [point[0].abs(), point[1]];
        let mut nearest = NearestPlace { segment: 0, gap: f64::INFINITY, beyond: true };
        let (count, last) = (self.segments.len(), self.segments.len() - 1);
        let open = self.segments[0].ends()[0] != self.segments[last].ends()[1];
        for (k, segment) in self.segments.iter().enumerate() {
            let mut side = segment.side_of(point, lift);
            let gap = segment.gap(point, lift);
            let end = segment.ends()[usize::from(side > 0)];
            if end[0].abs() <= ON_AXIS * end[1].abs() && point[0] <= ON_AXIS * point[1].abs() {
                // A surface that ends on the axis continues as its mirror image; the axis is not an edge.
                side = 0;
            }
            if side == 0 {
                if gap.abs() < nearest.gap.abs() {
                    nearest = NearestPlace { segment: k, gap, beyond: false };
                }
                continue;
            }
            let corner = segment.ends()[usize::from(side > 0)];
            let distance = length([point[0] - corner[0], point[1] - (corner[1] + lift)]);
            if distance >= nearest.gap.abs() {
                continue;
            }
            let beyond = open && (side < 0 && k == 0 || side > 0 && k == last);
            let (previous, after) = if side > 0 { (k, (k + 1) % count) } else { ((k + last) % count, k) };
            let turn = || cross(self.segments[previous].direction(1), self.segments[after].direction(0));
            let sign = if beyond { gap } else { Some(-turn()).filter(|t| t.abs() > SMOOTH).unwrap_or(gap) };
            nearest = NearestPlace { segment: k, gap: if sign < 0.0 { -distance } else { distance }, beyond };
        }
        nearest
    }

    /// Returns the profile with the front on the other side.
    pub fn reversed(&self) -> SurfaceProfile {
        SurfaceProfile { segments: self.segments.iter().rev().map(ProfileSegment::reversed).collect() }
    }

    /// Returns the lower and upper corner of the bounding box.
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        let boxes = self.segments.iter().map(ProfileSegment::bounds);
        boxes.fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[l, h], [a, b]| {
            [[l[0].min(a[0]), l[1].min(a[1])], [h[0].max(b[0]), h[1].max(b[1])]]
        })
    }

    /// Returns the segments that form a re-entrant corner with a segment at its start and at its end: a point in front
    /// may touch both.
    pub fn reentrant_neighbors(&self, segment: usize) -> [Option<usize>; 2] {
        let (count, last) = (self.segments.len(), self.segments.len() - 1);
        let closed = self.segments[0].ends()[0] == self.segments[last].ends()[1];
        let turns = |a: usize, b: usize| cross(self.segments[a].direction(1), self.segments[b].direction(0)) > SMOOTH;
        let previous = (segment > 0 || closed && count > 1).then_some((segment + last) % count);
        let after = (segment < last || closed && count > 1).then_some((segment + 1) % count);
        [previous.filter(|&b| turns(b, segment)), after.filter(|&a| turns(segment, a))]
    }

    /// Returns z if the whole profile is one plane z = constant.
    pub fn height(&self) -> Option<f64> {
        let [[_, low], [_, high]] = self.bounds();
        let straight = self.segments.iter().all(|s| matches!(s, ProfileSegment::Line(_)));
        (straight && low == high).then_some(low)
    }

    /// Returns points along the profile for plotting; arcs are divided into steps of at most five degrees.
    pub fn outline(&self) -> Vec<[f64; 2]> {
        let mut points = vec![self.segments[0].ends()[0]];
        for segment in &self.segments {
            let [a, b] = segment.ends();
            if let ProfileSegment::Arc(_, c, _, _) = *segment {
                let (u, v) = (minus(a, c), minus(b, c));
                let angle = libm::atan2(cross(u, v), dot(u, v));
                let steps = (angle.abs().to_degrees() / 5.0).ceil().max(1.0);
                for i in 1..steps as usize {
                    let (sine, cosine) = libm::sincos(angle * i as f64 / steps);
                    points.push([c[0] + u[0] * cosine - u[1] * sine, c[1] + u[0] * sine + u[1] * cosine]);
                }
            }
            points.push(b);
        }
        points
    }

    /// Rounds all corners with tangent arcs of the given radius.
    ///
    /// # Errors
    /// The index of the segment after the first corner where the arc does not fit.
    pub fn fillet(&self, radius: f64) -> Result<SurfaceProfile, usize> {
        let mut segments: Vec<ProfileSegment> = vec![self.segments[0]];
        for (k, next) in self.segments.iter().enumerate().skip(1) {
            let previous = segments[segments.len() - 1];
            let (t, u) = (previous.direction(1), next.direction(0));
            let turn = cross(t, u);
            if turn.abs() < SMOOTH && dot(t, u) > 0.0 {
                segments.push(*next);
                continue;
            }
            segments.pop();
            segments.extend(rounded(previous, *next, radius, turn.signum()).ok_or(k)?);
        }
        Ok(SurfaceProfile { segments })
    }
}

/// Trims two segments that form a corner, and inserts an arc tangent to both. `side` is 1 for a left turn, -1 for a
/// right turn.
fn rounded(a: ProfileSegment, b: ProfileSegment, radius: f64, side: f64) -> Option<[ProfileSegment; 3]> {
    let corner = a.ends()[1];
    let (a_off, b_off) = (offset(a, side * radius)?, offset(b, side * radius)?);
    let centre = crossings(a_off, b_off).into_iter().flatten().min_by(|p, q| {
        let far = |p: &[f64; 2]| length(minus(*p, corner));
        far(p).total_cmp(&far(q))
    })?;
    let touch = |s: &ProfileSegment| -> Option<[f64; 2]> {
        let closest = {
            let (g, n) = (s.gap(centre, 0.0), s.normal(centre, 0.0));
            [centre[0] - g * n[0], centre[1] - g * n[1]]
        };
        (s.side_of(centre, 0.0) == 0).then_some(closest)
    };
    let (p, q) = (touch(&a)?, touch(&b)?);
    let cut = |s: ProfileSegment, from: [f64; 2], to: [f64; 2]| match s {
        ProfileSegment::Line(_) => ProfileSegment::Line([from, to]),
        ProfileSegment::Arc(_, c, r, turn) => ProfileSegment::Arc([from, to], c, r, turn),
    };
    let arc = ProfileSegment::Arc([p, q], centre, radius, side);
    Some([cut(a, a.ends()[0], p), arc, cut(b, q, b.ends()[1])])
}

/// Returns the line or circle offset to the left of a segment by a distance.
fn offset(s: ProfileSegment, distance: f64) -> Option<ProfileSegment> {
    match s {
        ProfileSegment::Line([a, b]) => {
            let n = s.normal(a, 0.0);
            let moved = |p: [f64; 2]| [p[0] + distance * n[0], p[1] + distance * n[1]];
            Some(ProfileSegment::Line([moved(a), moved(b)]))
        }
        ProfileSegment::Arc(ends, c, radius, turn) => {
            let other = radius - turn * distance;
            (other > 0.0).then_some(ProfileSegment::Arc(ends, c, other, turn))
        }
    }
}

/// Returns the intersections of two infinite lines or full circles.
fn crossings(a: ProfileSegment, b: ProfileSegment) -> [Option<[f64; 2]>; 2] {
    match (a, b) {
        (ProfileSegment::Line([p, q]), ProfileSegment::Line([r, s])) => {
            let (t, u) = (minus(q, p), minus(s, r));
            let whole = cross(t, u);
            let position = cross(minus(r, p), u) / whole;
            [(whole != 0.0).then_some([p[0] + position * t[0], p[1] + position * t[1]]), None]
        }
        (ProfileSegment::Line([p, q]), ProfileSegment::Arc(_, c, radius, _))
        | (ProfileSegment::Arc(_, c, radius, _), ProfileSegment::Line([p, q])) => {
            let t = unit(minus(q, p));
            let along = dot(minus(c, p), t);
            let closest = [p[0] + along * t[0], p[1] + along * t[1]];
            let square = radius * radius - dot(minus(c, closest), minus(c, closest));
            if square < 0.0 {
                return [None, None];
            }
            [1.0, -1.0].inline_map(|sign| {
                Some([closest[0] + sign * square.sqrt() * t[0], closest[1] + sign * square.sqrt() * t[1]])
            })
        }
        (ProfileSegment::Arc(_, c, r1, _), ProfileSegment::Arc(_, d, r2, _)) => {
            let way = minus(d, c);
            let distance = length(way);
            if distance == 0.0 {
                return [None, None];
            }
            let along = 0.5 * (distance + (r1 * r1 - r2 * r2) / distance);
            let square = r1 * r1 - along * along;
            if square < 0.0 {
                return [None, None];
            }
            let e = unit(way);
            [1.0, -1.0].inline_map(|sign| {
                let h = sign * square.sqrt();
                Some([c[0] + along * e[0] - h * e[1], c[1] + along * e[1] + h * e[0]])
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{ProfileSegment, SurfaceProfile};

    fn lines(points: &[[f64; 2]]) -> SurfaceProfile {
        SurfaceProfile { segments: points.windows(2).map(|w| ProfileSegment::Line([w[0], w[1]])).collect() }
    }

    #[test]
    fn the_front_is_to_the_left() {
        let floor = lines(&[[0.0, 1.0], [2.0, 1.0]]);
        assert_eq!(floor.nearest([1.0, 3.5], 0.5).gap, 2.0);
        assert_eq!(floor.reversed().nearest([1.0, 3.5], 0.5).gap, -2.0);
        assert!(floor.nearest([2.5, 3.0], 0.0).beyond);
        // A counter-clockwise arc at the bottom is concave, a clockwise one convex.
        let bowl = ProfileSegment::arc([0.0, -1.0], [1.0, 0.0], [0.0, 0.0]);
        assert!((bowl.gap([0.3, -0.4], 0.0) - 0.5).abs() < 1e-15);
        assert!((bowl.reversed().gap([0.3, -0.4], 0.0) + 0.5).abs() < 1e-15);
    }

    /// A hemisphere with its pole on the axis also touches points slightly across the axis.
    #[test]
    fn the_axis_is_not_an_edge() {
        let pole = SurfaceProfile { segments: vec![ProfileSegment::arc([0.0, 0.0], [1.0, 1.0], [0.0, 1.0])] };
        for r in [-1e-12, 0.0, 1e-12] {
            let near = pole.nearest([r, 0.1], 0.0);
            assert!(!near.beyond && (near.gap.abs() - 0.1).abs() < 1e-9, "{r}: {} {}", near.gap, near.beyond);
        }
    }

    #[test]
    fn corners_are_in_front_or_behind() {
        let step = lines(&[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [2.0, 0.0]]);
        let near = |p| step.nearest(p, 0.0);
        // In front of the convex corner, behind the concave one.
        assert!((near([1.3, 1.4]).gap - 0.5).abs() < 1e-15);
        assert!((near([0.7, -0.4]).gap + 0.5).abs() < 1e-15);
        assert_eq!(near([0.9, 0.5]).gap, -0.09999999999999998);
        assert_eq!(near([1.5, 0.25]).gap, 0.25);
    }

    #[test]
    fn fillets_touch_both_sides() {
        let corner = lines(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]).fillet(0.25).expect("the fillet fits");
        let ProfileSegment::Arc([p, q], c, r, turn) = corner.segments[1] else { panic!("an arc") };
        assert_eq!((p, q, c, r, turn), ([0.75, 0.0], [1.0, 0.25], [0.75, 0.25], 0.25, 1.0));
        assert_eq!(lines(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]).fillet(1.25), Err(1));
        // A line that ends in an arc around (0, 2) of radius 1; the fillet is tangent to both.
        let both = SurfaceProfile {
            segments: vec![
                ProfileSegment::Line([[3.0, 2.0], [1.0, 2.0]]),
                ProfileSegment::arc([1.0, 2.0], [0.0, 1.0], [0.0, 2.0]),
            ],
        };
        let smooth = both.fillet(0.1).expect("the fillet fits");
        for pair in smooth.segments.windows(2) {
            assert!((pair[0].ends()[1][0] - pair[1].ends()[0][0]).abs() < 1e-12);
            let (t, u) = (pair[0].direction(1), pair[1].direction(0));
            assert!((t[0] * u[0] + t[1] * u[1] - 1.0).abs() < 1e-12, "{pair:?}");
        }
        // Smooth transitions are unchanged.
        let tangent = SurfaceProfile {
            segments: vec![
                ProfileSegment::arc([0.0, 0.0], [1.0, 1.0], [0.0, 1.0]),
                ProfileSegment::Line([[1.0, 1.0], [1.0, 2.0]]),
            ],
        };
        assert_eq!(tangent.fillet(0.1).expect("nothing to round"), tangent);
    }
}
