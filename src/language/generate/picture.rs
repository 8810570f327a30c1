//! Drawing of a mesh: the meridian section, mirrored about the axis, with the nose or the lower face on the left.

use super::sheet::QuadMesh;
use crate::output::drawing::{Drawing, LineStroke, ShapePaint, TextAnchor, TextLabel};

/// Width of the picture and margin around the mesh, in points.
const WIDTH: f64 = 1600.0;
const MARGIN: f64 = 24.0;
const TITLE: f64 = 40.0;

/// Draws a mesh whose elements have the given colours.
pub fn drawing(sheet: &QuadMesh, colour: impl Fn(usize) -> u32, title: &str) -> Drawing {
    let [widest, highest] = [0, 1].map(|k| sheet.points.iter().fold(f64::NEG_INFINITY, |most: f64, p| most.max(p[k])));
    let lowest = sheet.points.iter().fold(f64::INFINITY, |least: f64, p| least.min(p[1]));
    let unit = (WIDTH - 2.0 * MARGIN) / (highest - lowest).max(2.0 * widest);
    let height = 2.0 * (MARGIN + widest * unit) + TITLE;
    let mut drawing = Drawing::new([WIDTH, height.round()]);
    drawing.label(TextLabel { size: 16.0, ..TextLabel::new([MARGIN, 28.0], TextAnchor::Start, title) });
    let middle = TITLE + MARGIN + widest * unit;
    for element in 0..sheet.elements.len() {
        let fill = ShapePaint::fill(colour(element), 1.0);
        let paint = ShapePaint { stroke: Some(LineStroke::new(0x33_33_44, 0.5)), ..fill };
        for side in [1.0, -1.0] {
            let places = sheet.corners(element).map(|[r, z]| [MARGIN + (z - lowest) * unit, middle - side * r * unit]);
            drawing.path(places, true, paint);
        }
    }
    drawing
}
