//! Placement of part instances, and of copies of nodes.

use nalgebra::{Point3, Rotation3, Unit, Vector3};

use super::context::Context;
use crate::deck::{Card, Diagnostic};

/// Placement of an instance: a translation, then a rotation about an axis.
#[derive(Clone, Debug)]
pub struct InstancePlacement {
    translation: Vector3<f64>,
    rotation: Option<(Point3<f64>, Rotation3<f64>)>,
}

impl InstancePlacement {
    /// Transforms a point of the part to the assembly.
    pub fn apply(&self, [r, z]: [f64; 2]) -> [f64; 2] {
        let moved = Point3::new(r, z, 0.0) + self.translation;
        let placed = match &self.rotation {
            Some((centre, rotation)) => centre + rotation * (moved - centre),
            None => moved,
        };
        [placed.x, placed.y]
    }

    /// Transforms a point of the assembly to the part.
    pub fn undo(&self, [r, z]: [f64; 2]) -> [f64; 2] {
        let placed = Point3::new(r, z, 0.0);
        let moved = match &self.rotation {
            Some((centre, rotation)) => centre + rotation.inverse() * (placed - centre),
            None => placed,
        };
        let point = moved - self.translation;
        [point.x, point.y]
    }
}

/// Message of a rotation that moves the r-z plane.
const OUT_OF_PLANE: &str =
    "an instance may be rotated about an axis normal to the r-z plane, or by 180 degrees about an axis in it";

impl InstancePlacement {
    /// Creates a placement from a translation, and from two points of an axis of rotation with the angle in degrees.
    ///
    /// # Errors
    /// The reason if the rotation does not map the r-z plane to itself.
    pub fn new([r, z]: [f64; 2], rotation: Option<[f64; 7]>) -> Result<InstancePlacement, &'static str> {
        let rotation = rotation.map(|n| {
            let axis = Unit::try_new(Vector3::new(n[3] - n[0], n[4] - n[1], n[5] - n[2]), 0.0);
            let is_in_plane = n[2] == 0.0 && n[5] == 0.0 && (n[6] % 180.0).abs() < 1e-9;
            let axis = axis.filter(|a| a.x == 0.0 && a.y == 0.0 || is_in_plane).ok_or(OUT_OF_PLANE)?;
            Ok((Point3::new(n[0], n[1], n[2]), Rotation3::from_axis_angle(&axis, n[6].to_radians())))
        });
        Ok(InstancePlacement { translation: Vector3::new(r, z, 0.0), rotation: rotation.transpose()? })
    }
}

/// Reads the placement of an instance; `None` if it is not moved, or after an error.
pub fn read_placement(context: &mut Context<'_>, card: &Card) -> Option<InstancePlacement> {
    card.lines.first()?;
    let rotation = match (card.lines.get(1), card.read_lines::<Vec<[f64; 7]>>().get(1)) {
        (Some(_), Some(n)) if n.iter().all(|number| number.is_finite()) => Some(*n),
        (None, _) => None,
        _ => return None,
    };
    let placement = InstancePlacement::new(card.read_lines(), rotation);
    let span = card.lines.get(1).map_or(card.span, |line| line.span);
    let refused = |message| Diagnostic::error("M126", message).at(span, "rotation out of the r-z plane");
    placement.map_err(|message| context.diagnostics.push(refused(message))).ok()
}
