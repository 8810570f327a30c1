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

/// Reads the placement of an instance; `None` if it is not moved, or after an error.
pub fn read_placement(context: &mut Context<'_>, card: &Card) -> Option<InstancePlacement> {
    card.lines.first()?;
    let [r, z]: [f64; 2] = card.read_lines();
    let rotation = match (card.lines.get(1), card.read_lines::<Vec<[f64; 7]>>().get(1)) {
        (Some(line), Some(n)) if n.iter().all(|number| number.is_finite()) => {
            let axis = Unit::try_new(Vector3::new(n[3] - n[0], n[4] - n[1], n[5] - n[2]), 0.0);
            let lies = n[2] == 0.0 && n[5] == 0.0 && (n[6] % 180.0).abs() < 1e-9;
            let Some(axis) = axis.filter(|a| a.x == 0.0 && a.y == 0.0 || lies) else {
                let message = "an instance may be rotated about an axis normal to the r-z \
                               plane, or by 180 degrees about an axis in it";
                return context
                    .diagnostics
                    .refuse(Diagnostic::error("M126", message).at(line.span, "rotation out of the r-z plane"));
            };
            Some((Point3::new(n[0], n[1], n[2]), Rotation3::from_axis_angle(&axis, n[6].to_radians())))
        }
        (None, _) => None,
        _ => return None,
    };
    Some(InstancePlacement { translation: Vector3::new(r, z, 0.0), rotation })
}
