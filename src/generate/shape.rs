//! What a projectile looks like: the outline of its nose and of what lies behind it, and what cannot be one.

use super::profile::{Piece, Point};
use crate::deck::Diagnostic;

/// The form of a nose.
#[derive(Clone, Debug, PartialEq)]
pub enum Nose {
    /// An arc that meets the shank without a corner; its radius is `crh` times the calibre.
    Ogive {
        /// Calibre-radius-head, radius of the arc over the diameter of the shank; at least 1/2.
        crh: f64,
    },
    /// A hemisphere.
    Sphere,
    /// A cone.
    Cone {
        /// Angle between axis and flank, in degrees.
        half_angle: f64,
    },
    /// A level front: a cylinder.
    Blunt,
    /// The whole outline as points `[r, z]` from the tip to the base, which give radius and length too.
    Polyline(Vec<Point>),
}

/// An outline: a pointed nose (none if the front is level) and what lies behind it, both from the front backwards.
#[derive(Clone, Debug, PartialEq)]
pub struct Outline {
    /// From the tip to the largest radius; empty where the front is level.
    pub nose: Vec<Piece>,
    /// From there to the base.
    pub body: Vec<Piece>,
}

impl Outline {
    /// The outline of a nose on a shank of a radius; `length` is that of the whole projectile. The tip lies in the origin, the base
    /// at z = length.
    ///
    /// # Errors
    /// G001 to G004: what cannot be a projectile.
    pub fn new(nose: &Nose, radius: f64, length: f64) -> Result<Outline, Diagnostic> {
        if let Nose::Polyline(points) = nose {
            return polyline(points);
        }
        positive("radius", radius)?;
        positive("length", length)?;
        let height = height(nose, radius)?;
        if length < height * (1.0 - 1e-12) {
            let message = format!("the projectile is {length} long, its nose alone {height}");
            return Err(Diagnostic::error("G003", message).help("--length is that of the whole projectile"));
        }
        let shoulder = [radius, height];
        let nose = match *nose {
            Nose::Ogive { crh } => {
                let arc = 2.0 * crh * radius;
                vec![Piece::Arc { centre: [radius - arc, height], from: [0.0, 0.0], to: shoulder }]
            }
            Nose::Sphere => vec![Piece::Arc { centre: [0.0, height], from: [0.0, 0.0], to: shoulder }],
            Nose::Cone { .. } => vec![Piece::Line([0.0, 0.0], shoulder)],
            Nose::Blunt | Nose::Polyline(_) => Vec::new(),
        };
        let body =
            if length > height * (1.0 + 1e-12) { vec![Piece::Line(shoulder, [radius, length])] } else { Vec::new() };
        Ok(Outline { nose, body })
    }

    /// Radius and height of the shoulder, where the nose ends.
    pub fn shoulder(&self) -> Point {
        match (self.nose.last(), self.body.first()) {
            (Some(piece), _) => piece.ends()[1],
            (None, Some(piece)) => piece.ends()[0],
            (None, None) => [0.0, 0.0],
        }
    }

    /// Radius and height of the base's rim.
    pub fn rim(&self) -> Point {
        self.body.last().map_or(self.shoulder(), |piece| piece.ends()[1])
    }

    pub fn widest(&self) -> f64 {
        let ends = self.nose.iter().chain(&self.body).flat_map(Piece::ends);
        ends.fold(0.0, |most, end| most.max(end[0]))
    }

    pub fn volume(&self) -> f64 {
        self.nose.iter().chain(&self.body).map(Piece::volume).sum()
    }
}

/// Height of a nose on a shank of a radius: for an ogive a sqrt(4 CRH - 1).
fn height(nose: &Nose, radius: f64) -> Result<f64, Diagnostic> {
    match *nose {
        Nose::Ogive { crh } if !(crh >= 0.5 && crh.is_finite()) => {
            let message = format!("an ogive of calibre-radius-head {crh} does not exist");
            Err(Diagnostic::error("G002", message).help("1/2 is a hemisphere; common are 2 to 6"))
        }
        Nose::Ogive { crh } => Ok(radius * (4.0 * crh - 1.0).sqrt()),
        Nose::Sphere => Ok(radius),
        Nose::Cone { half_angle } if half_angle > 0.0 && half_angle < 90.0 => {
            Ok(radius / libm::tan(half_angle.to_radians()))
        }
        Nose::Cone { half_angle } => {
            let message = format!("a cone with {half_angle} degrees between axis and flank does not exist");
            Err(Diagnostic::error("G002", message).help("the half angle lies between 0 and 90 degrees"))
        }
        Nose::Blunt | Nose::Polyline(_) => Ok(0.0),
    }
}

/// Refuses what is no positive length.
pub fn positive(name: &str, value: f64) -> Result<(), Diagnostic> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    let message = format!("the {name} is {value}, which is no length");
    Err(Diagnostic::error("G001", message).help("a positive number in the unit of length of the deck"))
}

fn polyline(points: &[Point]) -> Result<Outline, Diagnostic> {
    let refuse = |n: usize, what: &str| {
        let [r, z] = points.get(n).copied().unwrap_or_default();
        let message = format!("point {} of the profile, ({r}, {z}), {what}", n + 1);
        Diagnostic::error("G004", message).help("points `r, z` from the tip to the base, one a line")
    };
    if points.len() < 2 {
        let message = format!("the profile has {} points", points.len());
        return Err(Diagnostic::error("G004", message).help("it takes two at least, from the tip to the base"));
    }
    for (n, p) in points.iter().enumerate() {
        if p.iter().any(|x| !x.is_finite()) || p[0] < 0.0 {
            return Err(refuse(n, "is not on the outer side of the axis"));
        }
        if n > 0 && p[0] == 0.0 {
            return Err(refuse(n, "lies on the axis, where only a tip may lie"));
        }
        if n > 0 && p[1] < points[n - 1][1] {
            return Err(refuse(n, "lies in front of the one before it"));
        }
        if n > 0 && p[1] == points[n - 1][1] && !(n == 1 && points[0][0] == 0.0) {
            return Err(refuse(n, "lies beside the one before it: only the front may be level"));
        }
    }
    let level = points[0][0] == 0.0 && points[1][1] == points[0][1];
    let pointed = points[0][0] == 0.0 && !level;
    let points = if level { &points[1..] } else { points };
    let moved: Vec<Point> = points.iter().map(|p| [p[0], p[1] - points[0][1]]).collect();
    let pieces: Vec<Piece> = moved.windows(2).map(|p| Piece::Line(p[0], p[1])).collect();
    let largest = moved.iter().fold(0.0, |most: f64, p| most.max(p[0]));
    let shoulder = moved.iter().position(|p| p[0] == largest).unwrap_or(0);
    if !pointed {
        if pieces.is_empty() {
            return Err(refuse(0, "has nothing behind it"));
        }
        return Ok(Outline { nose: Vec::new(), body: pieces });
    }
    if let Some(n) = (1..=shoulder).find(|&n| moved[n][0] < moved[n - 1][0]) {
        return Err(refuse(n, "is nearer to the axis than the one before it, in front of the largest radius"));
    }
    let (nose, body) = pieces.split_at(shoulder);
    Ok(Outline { nose: nose.to_vec(), body: body.to_vec() })
}

/// Length along pieces.
pub fn length(pieces: &[Piece]) -> f64 {
    pieces.iter().map(Piece::length).sum()
}
