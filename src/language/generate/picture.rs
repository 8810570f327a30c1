//! Drawing of a mesh: the meridian section, mirrored about the axis, with the nose on the left.

use super::mesh::{MeshPart, ProjectileMesh};
use crate::output::drawing::{Drawing, LineStroke, ShapePaint, TextAnchor, TextLabel};

/// Width of the picture and margin around the mesh, in points.
const WIDTH: f64 = 1600.0;
const MARGIN: f64 = 24.0;
const TITLE: f64 = 40.0;

impl ProjectileMesh {
    /// Draws the meridian section, mirrored about the axis.
    pub fn drawing(&self, title: &str) -> Drawing {
        let points = &self.sheet.points;
        let [widest, longest] = [0, 1].map(|k| points.iter().fold(0.0, |most: f64, p| most.max(p[k])));
        let unit = (WIDTH - 2.0 * MARGIN) / longest;
        let height = 2.0 * (MARGIN + widest * unit) + TITLE;
        let mut drawing = Drawing::new([WIDTH, height.round()]);
        drawing.label(TextLabel { size: 16.0, ..TextLabel::new([MARGIN, 28.0], TextAnchor::Start, title) });
        let middle = TITLE + MARGIN + widest * unit;
        for (element, part) in self.parts.iter().enumerate() {
            let fill = match (part, element < self.in_nose) {
                (MeshPart::Fill, _) => 0xf2_d9_b0,
                (MeshPart::Case, true) => 0xb8_d4_ea,
                (MeshPart::Case, false) => 0xdf_e7_ee,
            };
            let paint = ShapePaint { stroke: Some(LineStroke::new(0x33_33_44, 0.5)), ..ShapePaint::fill(fill, 1.0) };
            for side in [1.0, -1.0] {
                let places = self.sheet.corners(element).map(|[r, z]| [MARGIN + z * unit, middle - side * r * unit]);
                drawing.path(places, true, paint);
            }
        }
        drawing
    }
}
