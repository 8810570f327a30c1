//! A mesh as an SVG picture: the meridian, mirrored about the axis, with the nose to the left.

use super::mesh::{Mesh, MeshPart};
use crate::output::svg::{Svg, polyline};

/// Width of the picture and room around the mesh, in points.
const WIDTH: f64 = 1600.0;
const MARGIN: f64 = 24.0;
const TITLE: f64 = 40.0;

impl Mesh {
    /// Draws the meridian, mirrored about the axis.
    pub fn svg(&self, title: &str) -> String {
        let points = &self.sheet.points;
        let [widest, longest] = [0, 1].map(|k| points.iter().fold(0.0, |most: f64, p| most.max(p[k])));
        let unit = (WIDTH - 2.0 * MARGIN) / longest;
        let height = 2.0 * (MARGIN + widest * unit) + TITLE;
        let mut svg = Svg::new([WIDTH, height.round()], 16.0);
        svg.text([MARGIN, 28.0], "", title);
        let middle = TITLE + MARGIN + widest * unit;
        for (element, belongs) in self.belongs.iter().enumerate() {
            let fill = match (belongs, element < self.in_nose) {
                (MeshPart::Fill, _) => "#f2d9b0",
                (MeshPart::Case, true) => "#b8d4ea",
                (MeshPart::Case, false) => "#dfe7ee",
            };
            for side in [1.0, -1.0] {
                let places = self.corners_of(element).map(|[r, z]| [MARGIN + z * unit, middle - side * r * unit]);
                let style = format!("fill=\"{fill}\" stroke=\"#334\" stroke-width=\"0.5\"");
                svg.path(polyline(places) + "Z", style);
            }
        }
        svg.finish()
    }
}
