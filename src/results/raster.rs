//! Drawings as PNG pixels. The font is included in the program, so that text has the same pixels on every machine.

use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Mask, Paint as Ink, Path, PathBuilder, Pixmap, Rect, Stroke as Pen, StrokeDash,
    Transform,
};
use ttf_parser::{Face, OutlineBuilder};

use super::drawing::{Colour, DOT, Drawing, DrawingShape, LineStroke, ShapePaint, TextAnchor, TextLabel};

impl Drawing {
    /// Returns the bytes of a PNG file with one pixel per point, or an error message if there is not enough memory.
    pub fn png(&self) -> Result<Vec<u8>, String> {
        self.pixels()?.encode_png().map_err(|e| e.to_string())
    }

    /// Returns the pixels of the drawing.
    pub(super) fn pixels(&self) -> Result<Pixmap, String> {
        let [width, height] = self.size.map(|length| length.round() as u32);
        let pixels = Pixmap::new(width, height);
        let mut pixels = pixels.ok_or_else(|| format!("a picture cannot have {width} x {height} pixels"))?;
        pixels.fill(Color::WHITE);
        let font = Face::parse(dejavu::sans::regular(), 0).map_err(|e| e.to_string())?;
        let mut canvas = PixelCanvas { pixels, font, clip: None };
        self.shapes.iter().for_each(|shape| canvas.draw(shape));
        Ok(canvas.pixels)
    }
}

/// Pixel image of a drawing.
struct PixelCanvas<'a> {
    pixels: Pixmap,
    font: Face<'a>,
    /// Region to which shapes are clipped; `None` for the whole picture.
    clip: Option<Mask>,
}

impl PixelCanvas<'_> {
    fn draw(&mut self, shape: &DrawingShape) {
        match shape {
            DrawingShape::Path { points, closed, paint } => self.paint(polygon(points, *closed), *paint),
            DrawingShape::Rectangle { corner, size, paint } => self.paint(rectangle(*corner, *size), *paint),
            DrawingShape::Dot { centre: [x, y], colour } => {
                let circle = PathBuilder::from_circle(*x as f32, *y as f32, DOT as f32);
                self.paint(circle, ShapePaint::fill(*colour, 1.0));
            }
            DrawingShape::Label(label) => self.paint(self.letters(label), ShapePaint::fill(label.colour, 1.0)),
            DrawingShape::BeginClip(corner, size) => {
                self.clip = Mask::new(self.pixels.width(), self.pixels.height());
                if let Some((mask, path)) = self.clip.as_mut().zip(rectangle(*corner, *size)) {
                    mask.fill_path(&path, FillRule::Winding, true, Transform::identity());
                }
            }
            DrawingShape::EndClip => self.clip = None,
        }
    }

    fn paint(&mut self, path: Option<Path>, ShapePaint { fill, stroke }: ShapePaint) {
        let Some(path) = path else { return };
        let (clip, transform) = (self.clip.as_ref(), Transform::identity());
        if let Some((colour, opacity)) = fill {
            self.pixels.fill_path(&path, &ink(colour, opacity), FillRule::Winding, transform, clip);
        }
        if let Some(stroke) = stroke {
            self.pixels.stroke_path(&path, &ink(stroke.colour, 1.0), &pen(stroke), transform, clip);
        }
    }

    /// Returns the outlines of all letters of a label.
    fn letters(&self, label: &TextLabel) -> Option<Path> {
        let scale = label.size as f32 / f32::from(self.font.units_per_em());
        let glyphs: Vec<_> = label.text.chars().map(|c| self.font.glyph_index(c).unwrap_or_default()).collect();
        let advance = |glyph| scale * f32::from(self.font.glyph_hor_advance(glyph).unwrap_or(0));
        let width: f32 = glyphs.iter().map(|glyph| advance(*glyph)).sum();
        let [x, y] = label.at.map(|place| place as f32);
        let start = match label.anchor {
            TextAnchor::Start => x,
            TextAnchor::Middle => x - 0.5 * width,
            TextAnchor::End => x - width,
        };
        let mut outline = GlyphOutline { path: PathBuilder::new(), scale, pen: [start, y] };
        for glyph in glyphs {
            self.font.outline_glyph(glyph, &mut outline);
            outline.pen[0] += advance(glyph);
        }
        let turn = if label.upright { Transform::from_rotate_at(-90.0, x, y) } else { Transform::identity() };
        outline.path.finish()?.transform(turn)
    }
}

/// Path of glyph outlines, in font units with y upwards.
struct GlyphOutline {
    path: PathBuilder,
    /// Points per font unit.
    scale: f32,
    /// Origin of the next glyph.
    pen: [f32; 2],
}

impl GlyphOutline {
    fn place(&self, x: f32, y: f32) -> [f32; 2] {
        [self.pen[0] + self.scale * x, self.pen[1] - self.scale * y]
    }
}

impl OutlineBuilder for GlyphOutline {
    fn move_to(&mut self, x: f32, y: f32) {
        let [x, y] = self.place(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let [x, y] = self.place(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ([x1, y1], [x, y]) = (self.place(x1, y1), self.place(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ([x1, y1], [x2, y2], [x, y]) = (self.place(x1, y1), self.place(x2, y2), self.place(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}

/// Returns lines through points; `None` if a coordinate is not finite.
fn polygon(points: &[[f64; 2]], closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (i, [x, y]) in points.iter().map(|point| point.map(|p| p as f32)).enumerate() {
        if i == 0 { path.move_to(x, y) } else { path.line_to(x, y) }
    }
    if closed {
        path.close();
    }
    path.finish()
}

fn rectangle([x, y]: [f64; 2], [wide, high]: [f64; 2]) -> Option<Path> {
    Rect::from_xywh(x as f32, y as f32, wide as f32, high as f32).map(PathBuilder::from_rect)
}

fn ink(colour: Colour, opacity: f64) -> Ink<'static> {
    let [_, red, green, blue] = colour.to_be_bytes();
    let mut ink = Ink::default();
    ink.set_color_rgba8(red, green, blue, (255.0 * opacity).round() as u8);
    ink
}

fn pen(LineStroke { width, dashes, round, .. }: LineStroke) -> Pen {
    let (line_cap, line_join) =
        if round { (LineCap::Round, LineJoin::Round) } else { (LineCap::Butt, LineJoin::Miter) };
    let dash = (!dashes.is_empty()).then(|| StrokeDash::new(dashes.to_vec(), 0.0)).flatten();
    Pen { width: width as f32, line_cap, line_join, dash, ..Pen::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixels(drawing: &Drawing) -> Pixmap {
        Pixmap::decode_png(&drawing.png().expect("a picture")).expect("PNG")
    }

    fn colour(pixels: &Pixmap, x: u32, y: u32) -> Colour {
        let pixel = pixels.pixel(x, y).expect("a pixel");
        Colour::from_be_bytes([0, pixel.red(), pixel.green(), pixel.blue()])
    }

    /// Returns first and last column and row with a pixel that is not white.
    fn extent(pixels: &Pixmap) -> [u32; 4] {
        let positions = (0..pixels.width()).flat_map(|x| (0..pixels.height()).map(move |y| [x, y]));
        positions
            .filter(|[x, y]| colour(pixels, *x, *y) != 0xff_ffff)
            .fold([u32::MAX, 0, u32::MAX, 0], |e, [x, y]| [e[0].min(x), e[1].max(x), e[2].min(y), e[3].max(y)])
    }

    #[test]
    fn shapes_cover_their_pixels_and_no_others() {
        let mut drawing = Drawing::new([100.0, 80.0]);
        drawing.rectangle([10.0, 10.0], [20.0, 20.0], ShapePaint::fill(0x12_34_56, 1.0));
        drawing.rectangle([10.0, 40.0], [20.0, 20.0], ShapePaint::fill(0, 0.25));
        drawing.dot([50.0, 20.0], 0xff_00_00);
        drawing.shapes.push(DrawingShape::BeginClip([40.0, 40.0], [10.0, 10.0]));
        drawing.path([[40.0, 45.0], [90.0, 45.0]], false, ShapePaint::stroke(0x00_ff_00, 4.0));
        drawing.shapes.push(DrawingShape::EndClip);
        let dashed = LineStroke { dashes: &[10.0, 10.0], ..LineStroke::new(0, 2.0) };
        drawing.path([[40.0, 70.0], [90.0, 70.0]], false, ShapePaint { fill: None, stroke: Some(dashed) });
        drawing.path([[f64::NAN, 0.0], [100.0, 80.0]], false, ShapePaint::stroke(0, 1.0));
        let pixels = pixels(&drawing);
        for (x, y, expected) in [
            (0, 0, 0xff_ff_ff),
            (10, 10, 0x12_34_56),
            (29, 29, 0x12_34_56),
            (30, 29, 0xff_ff_ff),
            (20, 50, 0xbf_bf_bf),
            (50, 20, 0xff_00_00),
            (53, 20, 0xff_00_00),
            (50, 26, 0xff_ff_ff),
            (49, 45, 0x00_ff_00),
            (50, 45, 0xff_ff_ff),
            (45, 70, 0),
            (55, 70, 0xff_ff_ff),
            (65, 70, 0),
        ] {
            assert_eq!(colour(&pixels, x, y), expected, "pixel {x}, {y}");
        }
        assert!(Drawing::new([0.0, 10.0]).png().is_err());
    }

    #[test]
    fn labels_are_placed_by_their_anchors() {
        let extent = |anchor, upright| {
            let mut drawing = Drawing::new([200.0, 200.0]);
            drawing.label(TextLabel { upright, size: 20.0, ..TextLabel::new([100.0, 100.0], anchor, "HHHHH") });
            extent(&pixels(&drawing))
        };
        let ([left_edge, right, top, bottom], middle) =
            (extent(TextAnchor::Start, false), extent(TextAnchor::Middle, false));
        // Five letters of 0.752 em width and 0.729 em height (DejaVu Sans).
        assert!((100..104).contains(&left_edge) && (171..176).contains(&right), "{left_edge} {right}");
        assert!((84..87).contains(&top) && bottom == 99, "{top} {bottom}");
        assert!((middle[0] + middle[1]).abs_diff(199) <= 1 && middle[1] - middle[0] == right - left_edge, "{middle:?}");
        let end = extent(TextAnchor::End, false);
        assert!(end[0] + right == left_edge + end[1] && (96..100).contains(&end[1]), "{end:?}");
        // Turned about its position: the text runs upwards, its letters are to the left.
        assert_eq!(extent(TextAnchor::Start, true), [top, bottom, 199 - right, 199 - left_edge]);
    }
}
