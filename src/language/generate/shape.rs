//! Outlines of projectiles, and validation of their parameters.

use super::profile::{MeridianPoint, ProfilePiece};
use crate::deck::Diagnostic;

/// Shape of the front end of a projectile.
#[derive(Clone, Debug, PartialEq)]
pub enum NoseShape {
    /// Arc tangent to the shank; its radius is `crh` times the calibre.
    Ogive {
        /// Calibre-radius-head: radius of the arc over shank diameter, at least 1/2.
        crh: f64,
    },
    /// Hemisphere of the shank radius.
    Sphere,
    /// Cone that ends at the shank.
    Cone {
        /// Angle between axis and flank, degrees.
        half_angle: f64,
    },
    /// Flat front: a cylinder.
    Blunt,
    /// Outline of the whole projectile as points `[r, z]` from the tip to the base.
    Polyline(Vec<MeridianPoint>),
}

/// Outline of a projectile from the tip to the base.
#[derive(Clone, Debug, PartialEq)]
pub struct ProjectileOutline {
    /// Pieces from the tip to the largest radius; empty for a flat front.
    pub nose: Vec<ProfilePiece>,
    /// Pieces from there to the base.
    pub body: Vec<ProfilePiece>,
}

impl ProjectileOutline {
    /// Creates the outline of a nose on a shank with a radius. `length` is that of the whole projectile. The tip is at
    /// the origin and the base at z = length.
    ///
    /// # Errors
    /// G001 to G004 for invalid parameters.
    pub fn new(nose: &NoseShape, radius: f64, length: f64) -> Result<ProjectileOutline, Diagnostic> {
        if let NoseShape::Polyline(points) = nose {
            return polyline(points);
        }
        positive("radius", radius)?;
        positive("length", length)?;
        let height = height(nose, radius)?;
        if length < height * (1.0 - 1e-12) {
            let message = format!("the projectile length {length} is less than the nose length {height}");
            return Err(Diagnostic::error("G003", message).help("--length is that of the whole projectile"));
        }
        let shoulder = [radius, height];
        let nose = match *nose {
            NoseShape::Ogive { crh } => {
                let arc = 2.0 * crh * radius;
                vec![ProfilePiece::Arc { centre: [radius - arc, height], from: [0.0, 0.0], to: shoulder }]
            }
            NoseShape::Sphere => vec![ProfilePiece::Arc { centre: [0.0, height], from: [0.0, 0.0], to: shoulder }],
            NoseShape::Cone { .. } => vec![ProfilePiece::Line([0.0, 0.0], shoulder)],
            NoseShape::Blunt | NoseShape::Polyline(_) => Vec::new(),
        };
        let body = if length > height * (1.0 + 1e-12) {
            vec![ProfilePiece::Line(shoulder, [radius, length])]
        } else {
            Vec::new()
        };
        Ok(ProjectileOutline { nose, body })
    }

    /// Returns the shoulder `[r, z]`, where the nose ends.
    pub fn shoulder(&self) -> MeridianPoint {
        match (self.nose.last(), self.body.first()) {
            (Some(piece), _) => piece.ends()[1],
            (None, Some(piece)) => piece.ends()[0],
            (None, None) => [0.0, 0.0],
        }
    }

    /// Returns the rim of the base `[r, z]`.
    pub fn rim(&self) -> MeridianPoint {
        self.body.last().map_or(self.shoulder(), |piece| piece.ends()[1])
    }

    pub fn widest(&self) -> f64 {
        let ends = self.nose.iter().chain(&self.body).flat_map(ProfilePiece::ends);
        ends.fold(0.0, |most, end| most.max(end[0]))
    }

    pub fn volume(&self) -> f64 {
        self.nose.iter().chain(&self.body).map(ProfilePiece::volume).sum()
    }
}

/// Returns the length of a nose on a shank with a radius: `radius √(4 CRH − 1)` for an ogive.
fn height(nose: &NoseShape, radius: f64) -> Result<f64, Diagnostic> {
    match *nose {
        NoseShape::Ogive { crh } if !(crh >= 0.5 && crh.is_finite()) => {
            let message = format!("the calibre-radius-head of an ogive must be at least 1/2, found {crh}");
            Err(Diagnostic::error("G002", message).help("1/2 is a hemisphere; common values are 2 to 6"))
        }
        NoseShape::Ogive { crh } => Ok(radius * (4.0 * crh - 1.0).sqrt()),
        NoseShape::Sphere => Ok(radius),
        NoseShape::Cone { half_angle } if half_angle > 0.0 && half_angle < 90.0 => {
            Ok(radius / libm::tan(half_angle.to_radians()))
        }
        NoseShape::Cone { half_angle } => {
            let message = format!("the half angle of a cone must be between 0 and 90 degrees, found {half_angle}");
            Err(Diagnostic::error("G002", message).help("the half angle is the angle between axis and flank"))
        }
        NoseShape::Blunt | NoseShape::Polyline(_) => Ok(0.0),
    }
}

/// Checks that a parameter is a positive, finite length.
pub fn positive(name: &str, value: f64) -> Result<(), Diagnostic> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    let message = format!("the {name} must be a positive number, found {value}");
    Err(Diagnostic::error("G001", message).help("use the length unit of the deck"))
}

fn polyline(points: &[MeridianPoint]) -> Result<ProjectileOutline, Diagnostic> {
    let fault = |message: String| {
        Diagnostic::error("G004", message).help("give points `r, z` from the tip to the base, one per line")
    };
    let refuse = |n: usize, what: &str| {
        let [r, z] = points.get(n).copied().unwrap_or_default();
        fault(format!("point {} of the profile, ({r}, {z}), {what}", n + 1))
    };
    if points.len() < 2 {
        return Err(fault(format!("the profile requires at least two points, found {}", points.len())));
    }
    for (n, p) in points.iter().enumerate() {
        if p.iter().any(|x| !x.is_finite()) || p[0] < 0.0 {
            return Err(refuse(n, "must have finite coordinates and r >= 0"));
        }
        if n > 0 && p[0] == 0.0 {
            return Err(refuse(n, "is on the axis, which only the tip may be"));
        }
        if n > 0 && p[1] < points[n - 1][1] {
            return Err(refuse(n, "has a smaller z than the previous point"));
        }
        if n > 0 && p[1] == points[n - 1][1] && !(n == 1 && points[0][0] == 0.0) {
            return Err(refuse(n, "has the same z as the previous point; only the front may be flat"));
        }
    }
    let level = points[0][0] == 0.0 && points[1][1] == points[0][1];
    let pointed = points[0][0] == 0.0 && !level;
    let points = if level { &points[1..] } else { points };
    let moved: Vec<MeridianPoint> = points.iter().map(|p| [p[0], p[1] - points[0][1]]).collect();
    let pieces: Vec<ProfilePiece> = moved.windows(2).map(|p| ProfilePiece::Line(p[0], p[1])).collect();
    let largest = moved.iter().fold(0.0, |most: f64, p| most.max(p[0]));
    let shoulder = moved.iter().position(|p| p[0] == largest).unwrap_or(0);
    if !pointed {
        if pieces.is_empty() {
            return Err(refuse(0, "is followed by no other point"));
        }
        return Ok(ProjectileOutline { nose: Vec::new(), body: pieces });
    }
    if let Some(n) = (1..=shoulder).find(|&n| moved[n][0] < moved[n - 1][0]) {
        return Err(refuse(n, "has a smaller r than the previous point, before the largest radius"));
    }
    let (nose, body) = pieces.split_at(shoulder);
    Ok(ProjectileOutline { nose: nose.to_vec(), body: body.to_vec() })
}

/// Returns the arc length of a chain of pieces.
pub fn length(pieces: &[ProfilePiece]) -> f64 {
    pieces.iter().map(ProfilePiece::length).sum()
}
