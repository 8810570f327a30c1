//! A mesh as an SVG picture: the meridian, mirrored about the axis, with the nose to the left.
//! Never here: results of runs.

use std::fmt::Write as _;

use super::mesh::{Belongs, Mesh};
use crate::output::vtu::escape;

/// Width of the picture and room around the mesh, in points.
const WIDTH: f64 = 1600.0;
const MARGIN: f64 = 24.0;
/// Room for the title.
const TITLE: f64 = 40.0;

impl Mesh {
    /// The picture with a title.
    pub fn svg(&self, title: &str) -> String {
        let points = &self.sheet.points;
        let [widest, longest] = [0, 1].map(|k| points.iter().fold(0.0, |most: f64, p| most.max(p[k])));
        let unit = (WIDTH - 2.0 * MARGIN) / longest;
        let height = 2.0 * (MARGIN + widest * unit) + TITLE;
        let mut text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height:.0}\" viewBox=\"0 0 {WIDTH} {height:.0}\" \
             font-family=\"DejaVu Sans, sans-serif\" font-size=\"16\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
             <text x=\"{MARGIN}\" y=\"28\">{}</text>\n",
            escape(title)
        );
        let middle = TITLE + MARGIN + widest * unit;
        for (element, belongs) in self.belongs.iter().enumerate() {
            let fill = match (belongs, element < self.in_nose) {
                (Belongs::Fill, _) => "#f2d9b0",
                (Belongs::Case, true) => "#b8d4ea",
                (Belongs::Case, false) => "#dfe7ee",
            };
            for side in [1.0, -1.0] {
                let places = self.corners_of(element).map(|[r, z]| [MARGIN + z * unit, middle - side * r * unit]);
                let path = places.map(|[x, y]| format!("{x:.2} {y:.2}")).join("L");
                let _ = writeln!(text, "<path d=\"M{path}Z\" fill=\"{fill}\" stroke=\"#334\" stroke-width=\"0.5\"/>");
            }
        }
        text + "</svg>\n"
    }
}
