//! Drawings as lists of shapes, written as SVG here and as pixels in `raster`. Lengths are in points, y points
//! downwards.

use std::fmt::{self, Display, Write as _};

use super::vtu::escape;

/// Colour as `0xRRGGBB`.
pub type Colour = u32;

/// Default height of letters.
pub const LETTERS: f64 = 15.0;
/// Radius of a dot.
pub const DOT: f64 = 4.5;

/// Shapes on a white background, in drawing order.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// Width and height, in points.
    pub size: [f64; 2],
    /// Shapes in drawing order.
    pub shapes: Vec<DrawingShape>,
}

/// Element of a drawing.
#[derive(Clone, Debug, PartialEq)]
pub enum DrawingShape {
    /// Straight lines through points.
    Path {
        /// Corners of the line in drawing coordinates, in points.
        points: Vec<[f64; 2]>,
        /// Whether the last point is connected to the first.
        closed: bool,
        /// Fill and stroke.
        paint: ShapePaint,
    },
    /// An axis-parallel rectangle.
    Rectangle {
        /// Upper left corner.
        corner: [f64; 2],
        /// Width and height.
        size: [f64; 2],
        /// Fill and stroke.
        paint: ShapePaint,
    },
    /// A filled circle.
    Dot {
        /// Centre in drawing coordinates, in points.
        centre: [f64; 2],
        /// Colour of the fill.
        colour: Colour,
    },
    /// A line of text.
    Label(TextLabel),
    /// Clips the following shapes to a rectangle with this upper left corner, width and height.
    BeginClip([f64; 2], [f64; 2]),
    /// Ends the last clipping rectangle.
    EndClip,
}

/// Fill and stroke of a shape.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShapePaint {
    /// Colour and opacity (0 to 1) of the inside.
    pub fill: Option<(Colour, f64)>,
    /// Line along the outline; `None` for a fill only.
    pub stroke: Option<LineStroke>,
}

/// Line along an outline.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineStroke {
    /// Colour of the line.
    pub colour: Colour,
    /// Width of the line, in points.
    pub width: f64,
    /// Lengths of dashes and gaps, alternating; empty for a solid line.
    pub dashes: &'static [f32],
    /// Whether ends and corners are round.
    pub round: bool,
}

/// A line of text.
#[derive(Clone, Debug, PartialEq)]
pub struct TextLabel {
    /// Position of the anchor on the base line.
    pub at: [f64; 2],
    /// The characters, without line breaks.
    pub text: String,
    /// Part of the text that is placed at `at`.
    pub anchor: TextAnchor,
    /// Height of the letters.
    pub size: f64,
    /// Colour of the letters.
    pub colour: Colour,
    /// Whether the text is rotated by 90 degrees counter-clockwise.
    pub upright: bool,
}

/// Part of a text that is placed at the position of its label.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextAnchor {
    /// The text begins at the position.
    Start,
    /// The text is centred on the position.
    Middle,
    /// The text ends at the position.
    End,
}

impl Drawing {
    /// Creates an empty drawing of this width and height, in points.
    pub fn new(size: [f64; 2]) -> Drawing {
        Drawing { size, shapes: Vec::new() }
    }

    /// Adds lines through points; nothing without points.
    pub fn path(&mut self, points: impl IntoIterator<Item = [f64; 2]>, closed: bool, paint: ShapePaint) {
        let points: Vec<[f64; 2]> = points.into_iter().collect();
        if !points.is_empty() {
            self.shapes.push(DrawingShape::Path { points, closed, paint });
        }
    }

    /// Adds a rectangle by its upper left corner, its width and its height.
    pub fn rectangle(&mut self, corner: [f64; 2], size: [f64; 2], paint: ShapePaint) {
        self.shapes.push(DrawingShape::Rectangle { corner, size, paint });
    }

    /// Adds a filled circle of the standard size.
    pub fn dot(&mut self, centre: [f64; 2], colour: Colour) {
        self.shapes.push(DrawingShape::Dot { centre, colour });
    }

    /// Adds a line of text.
    pub fn label(&mut self, label: TextLabel) {
        self.shapes.push(DrawingShape::Label(label));
    }

    /// Returns the drawing as SVG.
    pub fn svg(&self) -> String {
        let [width, height] = self.size;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             font-family=\"DejaVu Sans, sans-serif\" font-size=\"{LETTERS}\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
        );
        for (index, shape) in self.shapes.iter().enumerate() {
            let _ = shape.write_svg(index, &mut svg);
        }
        svg + "</svg>\n"
    }
}

impl DrawingShape {
    fn write_svg(&self, index: usize, svg: &mut String) -> fmt::Result {
        let rectangle = |[x, y]: &[f64; 2], [wide, high]: &[f64; 2]| {
            format!("<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{wide:.2}\" height=\"{high:.2}\"")
        };
        match self {
            DrawingShape::Path { points, closed, paint } => {
                let words: Vec<String> = points.iter().map(|[x, y]| format!("{x:.2} {y:.2}")).collect();
                let end = if *closed { "Z" } else { "" };
                writeln!(svg, "<path d=\"M{}{end}\"{paint}/>", words.join("L"))
            }
            DrawingShape::Rectangle { corner, size, paint } => writeln!(svg, "{}{paint}/>", rectangle(corner, size)),
            DrawingShape::Dot { centre: [x, y], colour } => {
                writeln!(svg, "<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{DOT}\" fill=\"#{colour:06x}\"/>")
            }
            DrawingShape::Label(label) => label.write_svg(svg),
            DrawingShape::BeginClip(corner, size) => {
                let id = format!("clip{index}");
                writeln!(svg, "<clipPath id=\"{id}\">{}/></clipPath>", rectangle(corner, size))?;
                writeln!(svg, "<g clip-path=\"url(#{id})\">")
            }
            DrawingShape::EndClip => writeln!(svg, "</g>"),
        }
    }
}

impl ShapePaint {
    /// Creates a fill of this opacity without an outline.
    pub fn fill(colour: Colour, opacity: f64) -> ShapePaint {
        ShapePaint { fill: Some((colour, opacity)), stroke: None }
    }

    /// Creates a solid outline without a fill.
    pub fn stroke(colour: Colour, width: f64) -> ShapePaint {
        ShapePaint { fill: None, stroke: Some(LineStroke::new(colour, width)) }
    }
}

impl Display for ShapePaint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.fill {
            Some((colour, opacity)) if opacity < 1.0 => {
                write!(f, " fill=\"#{colour:06x}\" fill-opacity=\"{opacity}\"")?
            }
            Some((colour, _)) => write!(f, " fill=\"#{colour:06x}\"")?,
            None => f.write_str(" fill=\"none\"")?,
        }
        let Some(LineStroke { colour, width, dashes, round }) = self.stroke else { return Ok(()) };
        write!(f, " stroke=\"#{colour:06x}\" stroke-width=\"{width}\"")?;
        if !dashes.is_empty() {
            let lengths: Vec<String> = dashes.iter().map(f32::to_string).collect();
            write!(f, " stroke-dasharray=\"{}\"", lengths.join(" "))?;
        }
        f.write_str(if round { " stroke-linecap=\"round\" stroke-linejoin=\"round\"" } else { "" })
    }
}

impl LineStroke {
    /// Creates a solid line with flat ends.
    pub fn new(colour: Colour, width: f64) -> LineStroke {
        LineStroke { colour, width, dashes: &[], round: false }
    }
}

impl TextLabel {
    /// Creates black horizontal text with the default letter height.
    pub fn new(at: [f64; 2], anchor: TextAnchor, text: impl Into<String>) -> TextLabel {
        TextLabel { at, text: text.into(), anchor, size: LETTERS, colour: 0, upright: false }
    }

    fn write_svg(&self, svg: &mut String) -> fmt::Result {
        let [x, y] = self.at;
        write!(svg, "<text x=\"{x:.2}\" y=\"{y:.2}\"")?;
        if self.size != LETTERS {
            write!(svg, " font-size=\"{}\"", self.size)?;
        }
        svg.push_str(match self.anchor {
            TextAnchor::Start => "",
            TextAnchor::Middle => " text-anchor=\"middle\"",
            TextAnchor::End => " text-anchor=\"end\"",
        });
        if self.colour != 0 {
            write!(svg, " fill=\"#{:06x}\"", self.colour)?;
        }
        if self.upright {
            write!(svg, " transform=\"rotate(-90 {x:.2} {y:.2})\"")?;
        }
        writeln!(svg, ">{}</text>", escape(&self.text))
    }
}
