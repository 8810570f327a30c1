//! SVG pictures, element by element, with coordinates in hundredths of a point.

use std::fmt::{Display, Write as _};

use super::vtu::escape;

/// Text that is centred at its place, and text that ends there.
pub const MIDDLE: &str = "text-anchor=\"middle\"";
/// Text that ends at its place.
pub const END: &str = "text-anchor=\"end\"";

/// A picture on a white ground.
pub struct Svg(String);

impl Svg {
    /// An empty picture of this width and height; `letters` is the height of its letters.
    pub fn new([width, height]: [f64; 2], letters: f64) -> Svg {
        Svg(format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             font-family=\"DejaVu Sans, sans-serif\" font-size=\"{letters}\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
        ))
    }

    /// Adds an element that is written already.
    pub fn raw(&mut self, element: impl Display) {
        let _ = writeln!(self.0, "{element}");
    }

    /// Adds a text.
    pub fn text(&mut self, [x, y]: [f64; 2], attributes: impl Display, text: &str) {
        self.raw(format_args!("<text x=\"{x:.2}\" y=\"{y:.2}\" {attributes}>{}</text>", escape(text)));
    }

    /// Adds a path.
    pub fn path(&mut self, path: impl Display, attributes: impl Display) {
        self.raw(format_args!("<path d=\"{path}\" {attributes}/>"));
    }

    /// Adds a filled rectangle by its upper left corner, its width and its height.
    pub fn rect(&mut self, [x, y]: [f64; 2], [wide, high]: [f64; 2], attributes: impl Display) {
        self.raw(format_args!(
            "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{wide:.2}\" height=\"{high:.2}\" {attributes}/>"
        ));
    }

    /// Adds a dot.
    pub fn dot(&mut self, [x, y]: [f64; 2], colour: &str) {
        self.raw(format_args!("<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"4.5\" fill=\"{colour}\"/>"));
    }

    /// The text of the picture.
    pub fn finish(self) -> String {
        self.0 + "</svg>\n"
    }
}

/// The straight lines through some places as the words of a path; empty without places.
pub fn polyline(places: impl IntoIterator<Item = [f64; 2]>) -> String {
    let words: Vec<String> = places.into_iter().map(|[x, y]| format!("{x:.2} {y:.2}")).collect();
    if words.is_empty() { String::new() } else { format!("M{}", words.join("L")) }
}
