//! Meshes of bodies with a rectangular meridian section: blocks, plates, discs, rings and tubes.

use std::f64::consts::PI;
use std::fmt::Write as _;

use super::measure::{PartVolume, QuadQuality};
use super::mesh::MAX_ELEMENTS;
use super::picture;
use super::quality::volume;
use super::shape::positive;
use super::sheet::QuadMesh;
use super::spacing::graded;
use crate::deck::Diagnostic;
use crate::output::drawing::Drawing;

/// Parameters of a body with a rectangular section. All lengths have the length unit of the deck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RectangleRequest {
    /// Inner and outer radius; an inner radius of 0 is a solid body.
    pub radii: [f64; 2],
    /// Height of the lower face, along z.
    pub bottom: f64,
    /// Distance of the upper face from the lower one.
    pub height: f64,
    /// Smallest element size.
    pub size: f64,
    /// Ratio of the element widths at the outer and at the inner radius.
    pub across: f64,
    /// Ratio of the element heights at the upper and at the lower face.
    pub along: f64,
}

/// Labels and names in the deck of a body with a rectangular section.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyLabels {
    /// First node and element label.
    pub first: usize,
    /// Set of all nodes and of all elements, and prefix of the other names.
    pub name: String,
    /// Material of the body.
    pub material: String,
}

/// A mesh of rows of rectangles.
#[derive(Clone, Debug)]
pub struct RectangleMesh {
    request: RectangleRequest,
    sheet: QuadMesh,
    /// Number of elements along r and along z.
    counts: [usize; 2],
}

/// Faces by name, with the number of the side of their elements.
const FACES: [(&str, usize); 4] = [("BOTTOM", 1), ("RIM", 2), ("TOP", 3), ("INNER", 4)];

impl RectangleMesh {
    /// Generates the mesh.
    ///
    /// # Errors
    /// G001 for invalid lengths, sizes and gradings.
    pub fn new(request: &RectangleRequest) -> Result<RectangleMesh, Diagnostic> {
        let RectangleRequest { radii: [inner, outer], bottom, height, size, across, along } = *request;
        for (what, value) in [
            ("outer radius", outer),
            ("height", height),
            ("element size", size),
            ("grading across", across),
            ("grading along", along),
        ] {
            positive(what, value)?;
        }
        if !(inner >= 0.0 && inner < outer && bottom.is_finite()) {
            let message =
                format!("the inner radius is {inner} and the outer one {outer}, the lower face is at {bottom}");
            return Err(Diagnostic::error("G001", message).help("0 <= inner radius < outer radius"));
        }
        let divisions = [(outer - inner, across), (height, along)].map(|(length, ratio)| count(length, size, ratio));
        if divisions[0] * divisions[1] > MAX_ELEMENTS {
            let message = format!("the mesh would have {:.1e} elements", divisions[0] * divisions[1]);
            return Err(Diagnostic::error("G001", message).help("use a larger element size"));
        }
        let counts = divisions.map(|count| count as usize);
        let place = |fraction: f64, [start, end]: [f64; 2]| {
            if fraction == 1.0 { end } else { start + (end - start) * fraction }
        };
        let columns = graded(counts[0], 1.0 / across);
        let rows = graded(counts[1], 1.0 / along);
        let mut sheet = QuadMesh::default();
        for row in &rows {
            for column in &columns {
                sheet.node([place(*column, [inner, outer]), place(*row, [bottom, bottom + height])]);
            }
        }
        let width = counts[0] + 1;
        for j in 0..counts[1] {
            for i in 0..counts[0] {
                let corner = j * width + i;
                sheet.elements.push([corner, corner + 1, corner + width + 1, corner + width]);
            }
        }
        Ok(RectangleMesh { request: *request, sheet, counts })
    }

    /// Returns the quality of the elements.
    pub fn quality(&self) -> QuadQuality {
        self.sheet.quality()
    }

    /// Returns the volume of the elements and that of the body.
    pub fn volume(&self) -> PartVolume {
        let RectangleRequest { radii: [inner, outer], height, .. } = self.request;
        let meshed = (0..self.sheet.elements.len()).map(|element| volume(self.sheet.corners(element))).sum();
        PartVolume { meshed, exact: PI * (outer - inner) * (outer + inner) * height }
    }

    /// Draws the meridian section, mirrored about the axis.
    pub fn drawing(&self, title: &str) -> Drawing {
        picture::drawing(&self.sheet, |_| 0xdf_e7_ee, title)
    }

    /// Returns the deck: `*NODE`, `*ELEMENT, TYPE=CAX4R`, sets, surfaces and `*SOLID SECTION`, after lines of
    /// `comments`. Sets and surfaces of the faces are TOP, BOTTOM, RIM and INNER, the set on the axis is AXIS, and the
    /// surface OUTER has all faces.
    pub fn deck(&self, labels: &BodyLabels, comments: &[String]) -> String {
        let BodyLabels { first, name, material } = labels;
        let mut text = String::new();
        comments.iter().for_each(|line| text += &format!("** {line}\n"));
        let _ = writeln!(text, "*Node, nset={name}");
        for (n, [r, z]) in self.sheet.points.iter().enumerate() {
            let _ = writeln!(text, " {}, {r:?}, {z:?}", n + first);
        }
        let _ = writeln!(text, "*Element, type=CAX4R, elset={name}");
        for (n, corners) in self.sheet.elements.iter().enumerate() {
            let [a, b, c, d] = corners.map(|corner| corner + first);
            let _ = writeln!(text, " {}, {a}, {b}, {c}, {d}", n + first);
        }
        let [columns, rows] = self.counts;
        let generated = |text: &mut String, card: &str, set: &str, [start, end, step]: [usize; 3]| {
            let _ = writeln!(text, "*{card}={name}_{set}, generate\n {}, {}, {step}", start + first, end + first);
        };
        let (width, nodes) = (columns + 1, self.sheet.points.len());
        let is_solid = self.request.radii[0] == 0.0;
        let left = if is_solid { "AXIS" } else { "INNER" };
        for (set, range) in [
            ("BOTTOM", [0, columns, 1]),
            ("RIM", [columns, nodes - 1, width]),
            ("TOP", [nodes - width, nodes - 1, 1]),
            (left, [0, nodes - width, width]),
        ] {
            generated(&mut text, "Nset, nset", set, range);
        }
        let last = columns * rows - 1;
        let faces = FACES.iter().filter(|(face, _)| !(is_solid && *face == "INNER"));
        let mut outer = format!("*Surface, name={name}_OUTER\n");
        for (face, side) in faces {
            let range = match side {
                1 => [0, columns - 1, 1],
                2 => [columns - 1, last, columns],
                3 => [last + 1 - columns, last, 1],
                _ => [0, last + 1 - columns, columns],
            };
            generated(&mut text, "Elset, elset", face, range);
            let _ = writeln!(text, "*Surface, name={name}_{face}\n {name}_{face}, S{side}");
            let _ = writeln!(outer, " {name}_{face}, S{side}");
        }
        text += &outer;
        let _ = writeln!(text, "*Solid Section, elset={name}, material={material}");
        text
    }
}

/// Returns the number of divisions of a length, of which the smallest has the size, or a little less.
fn count(length: f64, size: f64, ratio: f64) -> f64 {
    // The sum of a geometric progression from `size` to `size` times the ratio is (size ratio - size)/ln(ratio) per
    // division in the limit of many divisions.
    let ratio = ratio.max(1.0 / ratio);
    let mean = if ratio - 1.0 < 1e-9 { size } else { size * (ratio - 1.0) / libm::log(ratio) };
    (length / mean - 1e-9).ceil().max(1.0)
}
