//! Outlines of projectiles: lines and arcs in (r, z) with length, points and the volume that they sweep.

use std::f64::consts::PI;

/// A point `[r, z]`.
pub type Point = [f64; 2];

/// A piece of an outline, run through in the direction of growing z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Piece {
    /// A straight line between two points.
    Line(Point, Point),
    /// An arc about a centre, between two points on the outer side of it (r above that of the centre).
    Arc {
        /// The centre `[r, z]`; its r is negative for ogives.
        centre: Point,
        from: Point,
        to: Point,
    },
}

impl Piece {
    pub fn ends(&self) -> [Point; 2] {
        match *self {
            Piece::Line(from, to) | Piece::Arc { from, to, .. } => [from, to],
        }
    }

    pub fn length(&self) -> f64 {
        match *self {
            Piece::Line(from, to) => distance(from, to),
            Piece::Arc { centre, from, to } => {
                let [start, end] = [from, to].map(|p| angle(centre, p));
                (end - start).abs() * distance(centre, from)
            }
        }
    }

    /// The point at a share of the length from its beginning; the ends are met exactly.
    pub fn at(&self, share: f64) -> Point {
        let [from, to] = self.ends();
        if share <= 0.0 {
            return from;
        }
        if share >= 1.0 {
            return to;
        }
        match *self {
            Piece::Line(..) => [0, 1].map(|i| from[i] + share * (to[i] - from[i])),
            Piece::Arc { centre, .. } => {
                let [start, end] = [from, to].map(|p| angle(centre, p));
                let now = start + share * (end - start);
                let radius = distance(centre, from);
                [centre[0] + radius * libm::cos(now), centre[1] + radius * libm::sin(now)]
            }
        }
    }

    /// The point of an arc in the middle of two of its points; `None` on a line.
    pub fn between(&self, a: Point, b: Point) -> Option<Point> {
        let Piece::Arc { centre, from, .. } = *self else { return None };
        let middle = 0.5 * (angle(centre, a) + angle(centre, b));
        let radius = distance(centre, from);
        Some([centre[0] + radius * libm::cos(middle), centre[1] + radius * libm::sin(middle)])
    }

    /// The volume between the piece and the axis, turned about it: the integral of pi r^2 dz. Of a line that of a frustum; of an
    /// arc r = c + sqrt(R^2 - x^2), with x from the height of the centre.
    pub fn volume(&self) -> f64 {
        match *self {
            Piece::Line(from, to) => {
                PI / 3.0 * (to[1] - from[1]) * (from[0] * from[0] + from[0] * to[0] + to[0] * to[0])
            }
            Piece::Arc { centre, from, to } => {
                let (c, radius) = (centre[0], distance(centre, from));
                let up_to = |x: f64| {
                    let segment = 0.5
                        * (x * (radius * radius - x * x).max(0.0).sqrt()
                            + radius * radius * libm::asin((x / radius).clamp(-1.0, 1.0)));
                    c * c * x + 2.0 * c * segment + radius * radius * x - x * x * x / 3.0
                };
                PI * (up_to(to[1] - centre[1]) - up_to(from[1] - centre[1]))
            }
        }
    }
}

fn angle(centre: Point, p: Point) -> f64 {
    libm::atan2(p[1] - centre[1], p[0] - centre[0])
}

pub fn distance(a: Point, b: Point) -> f64 {
    let [r, z] = [a[0] - b[0], a[1] - b[1]];
    (r * r + z * z).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hemisphere and a cone by their formulas (rounding), and an ogive by the trapezoid of its own points (1e-7: its error
    /// falls with the square of the step).
    #[test]
    fn pieces_sweep_their_volumes() {
        let half = Piece::Arc { centre: [0.0, 2.0], from: [0.0, 0.0], to: [2.0, 2.0] };
        assert!((half.volume() - 2.0 / 3.0 * PI * 8.0).abs() < 1e-13);
        assert!((half.length() - PI).abs() < 1e-14);
        let cone = Piece::Line([0.0, 0.0], [1.0, 3.0]);
        assert!((cone.volume() - PI).abs() < 1e-14);
        let height = 11.0_f64.sqrt();
        let ogive = Piece::Arc { centre: [-5.0, height], from: [0.0, 0.0], to: [1.0, height] };
        let points: Vec<Point> = (0..=4000).map(|i| ogive.at(i as f64 / 4000.0)).collect();
        let sum: f64 = points.windows(2).map(|p| Piece::Line(p[0], p[1]).volume()).sum();
        assert!((sum / ogive.volume() - 1.0).abs() < 1e-7, "{sum} {}", ogive.volume());
    }
}
