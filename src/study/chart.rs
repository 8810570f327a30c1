//! Charts as SVG and PNG: lines and markers over one axis.
//! Never here: where the numbers come from.

use std::sync::Arc;

use plotters::coord::Shift;
use plotters::prelude::*;
use resvg::{tiny_skia, usvg};

/// A chart.
#[derive(Clone, Debug, Default)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// Name of the horizontal axis.
    pub x_label: String,
    /// Name of the vertical axis.
    pub y_label: String,
    /// What is drawn, in order.
    pub series: Vec<Series>,
}

/// Points with a name.
#[derive(Clone, Debug)]
pub struct Series {
    /// Shown in the legend.
    pub name: String,
    /// `(x, y)`, ascending in x.
    pub points: Vec<(f64, f64)>,
    /// Whether the points are joined.
    pub joined: bool,
}

const SIZE: (u32, u32) = (960, 640);
/// Okabe and Ito's palette, safe for colour-blind readers, with a violet and a grey after it.
const PALETTE: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(140, 107, 177),
    RGBColor(90, 90, 90),
];

impl Chart {
    /// The chart as SVG text.
    ///
    /// # Errors
    /// In words, where there is nothing to draw.
    pub fn svg(&self) -> Result<String, String> {
        let mut text = String::new();
        {
            let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
            self.draw(&root).map_err(|e| format!("the chart cannot be drawn: {e}"))?;
            root.present().map_err(|e| format!("the chart cannot be drawn: {e}"))?;
        }
        Ok(text)
    }

    /// The chart as a PNG file's bytes. The font comes with the program, so that every machine draws the same.
    ///
    /// # Errors
    /// In words, where there is nothing to draw.
    pub fn png(&self) -> Result<Vec<u8>, String> {
        let mut options = usvg::Options { font_family: "DejaVu Sans".into(), ..usvg::Options::default() };
        let fonts = Arc::make_mut(&mut options.fontdb);
        fonts.load_font_data(dejavu::sans::regular().to_vec());
        fonts.set_sans_serif_family("DejaVu Sans");
        let tree = usvg::Tree::from_str(&self.svg()?, &options).map_err(|e| e.to_string())?;
        let mut picture = tiny_skia::Pixmap::new(SIZE.0, SIZE.1).ok_or("no memory for the picture")?;
        resvg::render(&tree, tiny_skia::Transform::identity(), &mut picture.as_mut());
        picture.encode_png().map_err(|e| e.to_string())
    }

    fn draw(&self, root: &DrawingArea<SVGBackend<'_>, Shift>) -> Result<(), Box<dyn std::error::Error>> {
        root.fill(&WHITE)?;
        let (x, y) = (self.range(|p| p.0).ok_or("no points")?, self.range(|p| p.1).ok_or("no points")?);
        let mut chart = ChartBuilder::on(root)
            .caption(&self.title, ("sans-serif", 24))
            .margin(18)
            .x_label_area_size(56)
            .y_label_area_size(80)
            .build_cartesian_2d(x.0..x.1, y.0..y.1)?;
        chart
            .configure_mesh()
            .light_line_style(WHITE)
            .bold_line_style(RGBColor(225, 225, 225))
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .axis_desc_style(("sans-serif", 18))
            .label_style(("sans-serif", 15))
            .draw()?;
        for (series, colour) in self.series.iter().zip(PALETTE.iter().cycle()) {
            let joined = series.joined;
            if joined {
                chart.draw_series(LineSeries::new(series.points.iter().copied(), colour.stroke_width(2)))?;
            }
            // Marks on a long line would hide it.
            let marked = if joined && series.points.len() > 60 { &[][..] } else { &series.points };
            let marks = marked.iter().map(|&p| Circle::new(p, 5, colour.filled()));
            chart.draw_series(marks)?.label(&series.name).legend(move |(x, y)| {
                let line = if joined { vec![(x, y), (x + 24, y)] } else { vec![] };
                EmptyElement::at((0, 0))
                    + PathElement::new(line, colour.stroke_width(2))
                    + Circle::new((x + 12, y), 5, colour.filled())
            });
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .margin(16)
            .legend_area_size(34)
            .label_font(("sans-serif", 16))
            .background_style(WHITE.mix(0.85))
            .border_style(RGBColor(200, 200, 200))
            .draw()?;
        Ok(())
    }

    /// Extent of a coordinate over all series, a little widened; `None` without points.
    fn range(&self, coordinate: impl Fn(&(f64, f64)) -> f64) -> Option<(f64, f64)> {
        let values = || self.series.iter().flat_map(|s| &s.points).map(&coordinate).filter(|v| v.is_finite());
        let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        let margin = if high > low { 0.06 * (high - low) } else { 0.5 * high.abs().max(1.0) };
        (low <= high).then_some((low - margin, high + margin))
    }
}
