//! Profiles of analytical surfaces: chains of straight lines and circular arcs, signed distances, rounded corners.
//! Never here: what meets them.
//!
//! The front is to the left of the way along the chain: the normal of a segment is its direction turned 90 degrees
//! counter-clockwise (Getting Started with Abaqus, 12.5, "Modeling issues for rigid surfaces"). Distances are above zero in front.

use super::lanes::InlineMap;
/// A straight line or an arc of less than half a circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Segment {
    /// From one point to another.
    Line([[f64; 2]; 2]),
    /// Ends, centre, radius, and 1 where it runs counter-clockwise, -1 clockwise.
    Arc([[f64; 2]; 2], [f64; 2], f64, f64),
}

/// Sine of the angle below which segments meet without a corner.
const SMOOTH: f64 = 1e-6;

/// What is nearer to the axis than so many times its z is on it.
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

impl Segment {
    /// The arc from one point to another around a centre, the shorter way; its radius is the mean of those of its ends.
    pub fn arc(from: [f64; 2], to: [f64; 2], centre: [f64; 2]) -> Segment {
        let (u, v) = (minus(from, centre), minus(to, centre));
        let turn = if cross(u, v) < 0.0 { -1.0 } else { 1.0 };
        Segment::Arc([from, to], centre, 0.5 * (length(u) + length(v)), turn)
    }

    /// Its ends.
    pub fn ends(&self) -> [[f64; 2]; 2] {
        match *self {
            Segment::Line(ends) | Segment::Arc(ends, ..) => ends,
        }
    }

    /// The same, the other way round.
    pub fn reversed(&self) -> Segment {
        match *self {
            Segment::Line([a, b]) => Segment::Line([b, a]),
            Segment::Arc([a, b], centre, radius, turn) => Segment::Arc([b, a], centre, radius, -turn),
        }
    }

    /// Direction at the start (0) or the end (1).
    pub fn direction(&self, end: usize) -> [f64; 2] {
        match *self {
            Segment::Line([a, b]) => unit(minus(b, a)),
            Segment::Arc(ends, centre, _, turn) => {
                let u = unit(minus(ends[end], centre));
                [-turn * u[1], turn * u[0]]
            }
        }
    }

    /// Signed distance of a point from the line or circle that it lies on, carried by `lift` along z.
    pub fn gap(&self, point: [f64; 2], lift: f64) -> f64 {
        match *self {
            Segment::Line([a, _]) => {
                let n = self.normal(point, lift);
                n[0] * (point[0] - a[0]) + n[1] * (point[1] - (a[1] + lift))
            }
            Segment::Arc(_, c, radius, turn) => turn * (radius - length([point[0] - c[0], point[1] - (c[1] + lift)])),
        }
    }

    /// Unit normal at the foot of a point.
    pub fn normal(&self, point: [f64; 2], lift: f64) -> [f64; 2] {
        match *self {
            Segment::Line([a, b]) => {
                let t = unit(minus(b, a));
                [-t[1], t[0]]
            }
            Segment::Arc(_, c, _, turn) => {
                let u = unit([point[0] - c[0], point[1] - (c[1] + lift)]);
                [-turn * u[0], -turn * u[1]]
            }
        }
    }

    /// Where the foot of a point is: below 0 before the start, above 0 behind the end, 0 between.
    pub fn side_of(&self, point: [f64; 2], lift: f64) -> i8 {
        let [a, b] = self.ends();
        let p = [point[0], point[1] - lift];
        let (before, behind) = match *self {
            Segment::Line(_) => {
                let t = minus(b, a);
                (dot(minus(p, a), t) < 0.0, dot(minus(p, b), t) > 0.0)
            }
            Segment::Arc(_, c, _, turn) => {
                let (u, v, w) = (minus(a, c), minus(b, c), minus(p, c));
                let (before, behind) = (turn * cross(u, w) < 0.0, turn * cross(w, v) < 0.0);
                // On the far side of the circle the nearer end counts.
                let nearer_start = dot(w, u) > dot(w, v);
                (before && (!behind || nearer_start), behind && (!before || !nearer_start))
            }
        };
        i8::from(behind) - i8::from(before)
    }

    /// Corners of the box around it.
    fn bounds(&self) -> [[f64; 2]; 2] {
        let [a, b] = self.ends();
        let mut low = [a[0].min(b[0]), a[1].min(b[1])];
        let mut high = [a[0].max(b[0]), a[1].max(b[1])];
        if let Segment::Arc(_, c, radius, _) = *self {
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

/// A chain of segments, each beginning where the one before ends.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Profile {
    /// Segments in order; at least one.
    pub segments: Vec<Segment>,
}

/// The nearest place of a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestPlace {
    pub segment: usize,
    /// Signed distance.
    pub gap: f64,
    /// Whether the nearest place is an end of the chain that the point lies beyond.
    pub beyond: bool,
}

impl Profile {
    /// The nearest place to a point, of a profile carried by `lift` along z. Where that is a corner, what lies in front of a
    /// convex one is in front, what lies behind a concave one is behind.
    pub fn nearest(&self, point: [f64; 2], lift: f64) -> NearestPlace {
        // A node on the axis that nothing holds there may be a rounding across it: it is where its mirror image is.
        let point = [point[0].abs(), point[1]];
        let mut found = NearestPlace { segment: 0, gap: f64::INFINITY, beyond: true };
        let (count, last) = (self.segments.len(), self.segments.len() - 1);
        let open = self.segments[0].ends()[0] != self.segments[last].ends()[1];
        for (k, segment) in self.segments.iter().enumerate() {
            let mut side = segment.side_of(point, lift);
            let own = segment.gap(point, lift);
            let end = segment.ends()[usize::from(side > 0)];
            if end[0].abs() <= ON_AXIS * end[1].abs() && point[0] <= ON_AXIS * point[1].abs() {
                // Where a surface ends on the axis it goes on as its mirror image: no edge for what is there.
                side = 0;
            }
            if side == 0 {
                if own.abs() < found.gap.abs() {
                    found = NearestPlace { segment: k, gap: own, beyond: false };
                }
                continue;
            }
            let corner = segment.ends()[usize::from(side > 0)];
            let distance = length([point[0] - corner[0], point[1] - (corner[1] + lift)]);
            if distance >= found.gap.abs() {
                continue;
            }
            let beyond = open && (side < 0 && k == 0 || side > 0 && k == last);
            let (before, after) = if side > 0 { (k, (k + 1) % count) } else { ((k + last) % count, k) };
            let turn = || cross(self.segments[before].direction(1), self.segments[after].direction(0));
            let sign = if beyond { own } else { Some(-turn()).filter(|t| t.abs() > SMOOTH).unwrap_or(own) };
            found = NearestPlace { segment: k, gap: if sign < 0.0 { -distance } else { distance }, beyond };
        }
        found
    }

    /// The same, with the front on the other side.
    pub fn reversed(&self) -> Profile {
        Profile { segments: self.segments.iter().rev().map(Segment::reversed).collect() }
    }

    /// Corners of the box around it.
    pub fn bounds(&self) -> [[f64; 2]; 2] {
        let boxes = self.segments.iter().map(Segment::bounds);
        boxes.fold([[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]], |[l, h], [a, b]| {
            [[l[0].min(a[0]), l[1].min(a[1])], [h[0].max(b[0]), h[1].max(b[1])]]
        })
    }

    /// The segments that meet a segment in a re-entrant corner at its start and at its end: what is in front of it may meet both.
    pub fn beside(&self, segment: usize) -> [Option<usize>; 2] {
        let (count, last) = (self.segments.len(), self.segments.len() - 1);
        let closed = self.segments[0].ends()[0] == self.segments[last].ends()[1];
        let turns = |a: usize, b: usize| cross(self.segments[a].direction(1), self.segments[b].direction(0)) > SMOOTH;
        let before = (segment > 0 || closed && count > 1).then_some((segment + last) % count);
        let after = (segment < last || closed && count > 1).then_some((segment + 1) % count);
        [before.filter(|&b| turns(b, segment)), after.filter(|&a| turns(segment, a))]
    }

    /// z, where all of it is one plane z = constant.
    pub fn height(&self) -> Option<f64> {
        let [[_, low], [_, high]] = self.bounds();
        let straight = self.segments.iter().all(|s| matches!(s, Segment::Line(_)));
        (straight && low == high).then_some(low)
    }

    /// Points along it, for pictures: arcs in steps of at most five degrees.
    pub fn outline(&self) -> Vec<[f64; 2]> {
        let mut points = vec![self.segments[0].ends()[0]];
        for segment in &self.segments {
            let [a, b] = segment.ends();
            if let Segment::Arc(_, c, _, _) = *segment {
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

    /// Rounds all corners with arcs of a radius that touch both segments.
    ///
    /// # Errors
    /// The corner that has no room for it, as the index of the segment behind it.
    pub fn fillet(&self, radius: f64) -> Result<Profile, usize> {
        let mut segments: Vec<Segment> = vec![self.segments[0]];
        for (k, next) in self.segments.iter().enumerate().skip(1) {
            let before = segments[segments.len() - 1];
            let (t, u) = (before.direction(1), next.direction(0));
            let turn = cross(t, u);
            if turn.abs() < SMOOTH && dot(t, u) > 0.0 {
                segments.push(*next);
                continue;
            }
            let (before, arc, next) = rounded(before, *next, radius, turn.signum()).ok_or(k)?;
            segments.pop();
            segments.extend([before, arc, next]);
        }
        Ok(Profile { segments })
    }
}

/// Two segments that meet in a corner, cut where an arc between them touches both. `side` is 1 where the way turns left.
fn rounded(a: Segment, b: Segment, radius: f64, side: f64) -> Option<(Segment, Segment, Segment)> {
    let corner = a.ends()[1];
    let (a_off, b_off) = (offset(a, side * radius)?, offset(b, side * radius)?);
    let centre = crossings(a_off, b_off).into_iter().flatten().min_by(|p, q| {
        let far = |p: &[f64; 2]| length(minus(*p, corner));
        far(p).total_cmp(&far(q))
    })?;
    let touch = |s: &Segment| -> Option<[f64; 2]> {
        let foot = {
            let (g, n) = (s.gap(centre, 0.0), s.normal(centre, 0.0));
            [centre[0] - g * n[0], centre[1] - g * n[1]]
        };
        (s.side_of(centre, 0.0) == 0).then_some(foot)
    };
    let (p, q) = (touch(&a)?, touch(&b)?);
    let cut = |s: Segment, from: [f64; 2], to: [f64; 2]| match s {
        Segment::Line(_) => Segment::Line([from, to]),
        Segment::Arc(_, c, r, turn) => Segment::Arc([from, to], c, r, turn),
    };
    let arc = Segment::Arc([p, q], centre, radius, side);
    Some((cut(a, a.ends()[0], p), arc, cut(b, q, b.ends()[1])))
}

/// The line or circle at a distance to the left of a segment.
fn offset(s: Segment, distance: f64) -> Option<Segment> {
    match s {
        Segment::Line([a, b]) => {
            let n = s.normal(a, 0.0);
            let moved = |p: [f64; 2]| [p[0] + distance * n[0], p[1] + distance * n[1]];
            Some(Segment::Line([moved(a), moved(b)]))
        }
        Segment::Arc(ends, c, radius, turn) => {
            let other = radius - turn * distance;
            (other > 0.0).then_some(Segment::Arc(ends, c, other, turn))
        }
    }
}

/// Where two endless lines or whole circles cross.
fn crossings(a: Segment, b: Segment) -> [Option<[f64; 2]>; 2] {
    match (a, b) {
        (Segment::Line([p, q]), Segment::Line([r, s])) => {
            let (t, u) = (minus(q, p), minus(s, r));
            let whole = cross(t, u);
            let at = cross(minus(r, p), u) / whole;
            [(whole != 0.0).then_some([p[0] + at * t[0], p[1] + at * t[1]]), None]
        }
        (Segment::Line([p, q]), Segment::Arc(_, c, radius, _))
        | (Segment::Arc(_, c, radius, _), Segment::Line([p, q])) => {
            let t = unit(minus(q, p));
            let along = dot(minus(c, p), t);
            let foot = [p[0] + along * t[0], p[1] + along * t[1]];
            let rest = radius * radius - dot(minus(c, foot), minus(c, foot));
            if rest < 0.0 {
                return [None, None];
            }
            [1.0, -1.0]
                .inline_map(|sign| Some([foot[0] + sign * rest.sqrt() * t[0], foot[1] + sign * rest.sqrt() * t[1]]))
        }
        (Segment::Arc(_, c, r1, _), Segment::Arc(_, d, r2, _)) => {
            let way = minus(d, c);
            let distance = length(way);
            if distance == 0.0 {
                return [None, None];
            }
            let along = 0.5 * (distance + (r1 * r1 - r2 * r2) / distance);
            let rest = r1 * r1 - along * along;
            if rest < 0.0 {
                return [None, None];
            }
            let e = unit(way);
            [1.0, -1.0].inline_map(|sign| {
                let h = sign * rest.sqrt();
                Some([c[0] + along * e[0] - h * e[1], c[1] + along * e[1] + h * e[0]])
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Profile, Segment};

    fn lines(points: &[[f64; 2]]) -> Profile {
        Profile { segments: points.windows(2).map(|w| Segment::Line([w[0], w[1]])).collect() }
    }

    #[test]
    fn the_front_is_to_the_left() {
        let floor = lines(&[[0.0, 1.0], [2.0, 1.0]]);
        assert_eq!(floor.nearest([1.0, 3.5], 0.5).gap, 2.0);
        assert_eq!(floor.reversed().nearest([1.0, 3.5], 0.5).gap, -2.0);
        assert!(floor.nearest([2.5, 3.0], 0.0).beyond);
        // A bowl runs counter-clockwise along its bottom, a punch clockwise.
        let bowl = Segment::arc([0.0, -1.0], [1.0, 0.0], [0.0, 0.0]);
        assert!((bowl.gap([0.3, -0.4], 0.0) - 0.5).abs() < 1e-15);
        assert!((bowl.reversed().gap([0.3, -0.4], 0.0) + 0.5).abs() < 1e-15);
    }

    /// A hemisphere whose pole is on the axis meets what lies a rounding across it.
    #[test]
    fn the_axis_is_no_edge() {
        let pole = Profile { segments: vec![Segment::arc([0.0, 0.0], [1.0, 1.0], [0.0, 1.0])] };
        for r in [-1e-12, 0.0, 1e-12] {
            let near = pole.nearest([r, 0.1], 0.0);
            assert!(!near.beyond && (near.gap.abs() - 0.1).abs() < 1e-9, "{r}: {} {}", near.gap, near.beyond);
        }
    }

    #[test]
    fn corners_are_in_front_or_behind() {
        let step = lines(&[[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [2.0, 0.0]]);
        let near = |p| step.nearest(p, 0.0);
        // Out at the convex corner, in behind the concave one.
        assert!((near([1.3, 1.4]).gap - 0.5).abs() < 1e-15);
        assert!((near([0.7, -0.4]).gap + 0.5).abs() < 1e-15);
        assert_eq!(near([0.9, 0.5]).gap, -0.09999999999999998);
        assert_eq!(near([1.5, 0.25]).gap, 0.25);
    }

    #[test]
    fn fillets_touch_both_sides() {
        let corner = lines(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]).fillet(0.25).expect("there is room");
        let Segment::Arc([p, q], c, r, turn) = corner.segments[1] else { panic!("an arc") };
        assert_eq!((p, q, c, r, turn), ([0.75, 0.0], [1.0, 0.25], [0.75, 0.25], 0.25, 1.0));
        assert_eq!(lines(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]).fillet(1.25), Err(1));
        // A line that ends in an arc around (0, 2) of radius 1: the fillet touches both.
        let both = Profile {
            segments: vec![Segment::Line([[3.0, 2.0], [1.0, 2.0]]), Segment::arc([1.0, 2.0], [0.0, 1.0], [0.0, 2.0])],
        };
        let smooth = both.fillet(0.1).expect("there is room");
        for pair in smooth.segments.windows(2) {
            assert!((pair[0].ends()[1][0] - pair[1].ends()[0][0]).abs() < 1e-12);
            let (t, u) = (pair[0].direction(1), pair[1].direction(0));
            assert!((t[0] * u[0] + t[1] * u[1] - 1.0).abs() < 1e-12, "{pair:?}");
        }
        // What is smooth stays as it is.
        let tangent = Profile {
            segments: vec![Segment::arc([0.0, 0.0], [1.0, 1.0], [0.0, 1.0]), Segment::Line([[1.0, 1.0], [1.0, 2.0]])],
        };
        assert_eq!(tangent.fillet(0.1).expect("nothing to round"), tangent);
    }
}
