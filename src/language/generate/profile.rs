//! Profile curves of projectiles in (r, z): lines and arcs with length, points and volume of revolution.

use std::f64::consts::PI;

/// A point `[r, z]` of the meridian plane.
pub type MeridianPoint = [f64; 2];

/// A piece of a profile, in the direction of increasing z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProfilePiece {
    /// A straight line between two points.
    Line(MeridianPoint, MeridianPoint),
    /// An arc between two points whose r is above that of its centre.
    Arc {
        /// Centre `[r, z]`; r is negative for ogives.
        centre: MeridianPoint,
        from: MeridianPoint,
        to: MeridianPoint,
    },
}

impl ProfilePiece {
    pub fn ends(&self) -> [MeridianPoint; 2] {
        match *self {
            ProfilePiece::Line(from, to) | ProfilePiece::Arc { from, to, .. } => [from, to],
        }
    }

    pub fn length(&self) -> f64 {
        match *self {
            ProfilePiece::Line(from, to) => distance(from, to),
            ProfilePiece::Arc { centre, from, to } => {
                let [start, end] = [from, to].map(|p| angle(centre, p));
                (end - start).abs() * distance(centre, from)
            }
        }
    }

    /// Returns the point at a fraction of the length; 0 and 1 give the exact ends.
    pub fn at(&self, share: f64) -> MeridianPoint {
        let [from, to] = self.ends();
        if share <= 0.0 {
            return from;
        }
        if share >= 1.0 {
            return to;
        }
        match *self {
            ProfilePiece::Line(..) => [0, 1].map(|i| from[i] + share * (to[i] - from[i])),
            ProfilePiece::Arc { centre, .. } => {
                let [start, end] = [from, to].map(|p| angle(centre, p));
                let now = start + share * (end - start);
                let radius = distance(centre, from);
                [centre[0] + radius * libm::cos(now), centre[1] + radius * libm::sin(now)]
            }
        }
    }

    /// Returns the point of an arc in the middle between two of its points; `None` for a line.
    pub fn between(&self, a: MeridianPoint, b: MeridianPoint) -> Option<MeridianPoint> {
        let ProfilePiece::Arc { centre, from, .. } = *self else { return None };
        let middle = 0.5 * (angle(centre, a) + angle(centre, b));
        let radius = distance(centre, from);
        Some([centre[0] + radius * libm::cos(middle), centre[1] + radius * libm::sin(middle)])
    }

    /// Returns the volume between the piece and the axis, ∫ π r² dz: a frustum for a line; for an arc r = c + √(R² −
    /// x²), with x measured from the centre.
    pub fn volume(&self) -> f64 {
        match *self {
            ProfilePiece::Line(from, to) => {
                PI / 3.0 * (to[1] - from[1]) * (from[0] * from[0] + from[0] * to[0] + to[0] * to[0])
            }
            ProfilePiece::Arc { centre, from, to } => {
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

fn angle(centre: MeridianPoint, p: MeridianPoint) -> f64 {
    libm::atan2(p[1] - centre[1], p[0] - centre[0])
}

pub fn distance(a: MeridianPoint, b: MeridianPoint) -> f64 {
    let [r, z] = [a[0] - b[0], a[1] - b[1]];
    (r * r + z * z).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hemisphere and cone match their formulas up to rounding. An ogive matches the trapezoidal rule within 1e-7, the
    /// error of the rule.
    #[test]
    fn pieces_sweep_their_volumes() {
        let half = ProfilePiece::Arc { centre: [0.0, 2.0], from: [0.0, 0.0], to: [2.0, 2.0] };
        assert!((half.volume() - 2.0 / 3.0 * PI * 8.0).abs() < 1e-13);
        assert!((half.length() - PI).abs() < 1e-14);
        let cone = ProfilePiece::Line([0.0, 0.0], [1.0, 3.0]);
        assert!((cone.volume() - PI).abs() < 1e-14);
        let height = 11.0_f64.sqrt();
        let ogive = ProfilePiece::Arc { centre: [-5.0, height], from: [0.0, 0.0], to: [1.0, height] };
        let points: Vec<MeridianPoint> = (0..=4000).map(|i| ogive.at(i as f64 / 4000.0)).collect();
        let sum: f64 = points.windows(2).map(|p| ProfilePiece::Line(p[0], p[1]).volume()).sum();
        assert!((sum / ogive.volume() - 1.0).abs() < 1e-7, "{sum} {}", ogive.volume());
    }
}
