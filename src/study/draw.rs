//! Charts drawn as SVG and PNG, on linear or logarithmic axes.
//! Never here: where the numbers come from.

use std::sync::Arc;

use plotters::coord::Shift;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::prelude::*;
use resvg::{tiny_skia, usvg};

use super::StudyError;
use super::chart::{Chart, Scale};

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
    pub fn svg(&self) -> Result<String, StudyError> {
        self.svg_on(Scale::Linear)
    }

    /// The chart on axes of a scale.
    ///
    /// # Errors
    /// In words, where there is nothing to draw.
    pub fn svg_on(&self, scale: Scale) -> Result<String, StudyError> {
        let mut text = String::new();
        {
            let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
            self.draw(&root, scale).map_err(|e| undrawn(&*e))?;
            root.present().map_err(|e| undrawn(&e))?;
        }
        Ok(text)
    }

    /// The chart as a PNG file's bytes.
    ///
    /// # Errors
    /// In words, where there is nothing to draw.
    pub fn png(&self) -> Result<Vec<u8>, StudyError> {
        self.png_on(Scale::Linear)
    }

    /// The same on axes of a scale.
    ///
    /// # Errors
    /// In words, where there is nothing to draw.
    pub fn png_on(&self, scale: Scale) -> Result<Vec<u8>, StudyError> {
        png(&self.svg_on(scale)?)
    }

    fn draw(&self, root: &DrawingArea<SVGBackend<'_>, Shift>, scale: Scale) -> Result<(), Box<dyn std::error::Error>> {
        root.fill(&WHITE)?;
        let mut builder = ChartBuilder::on(root);
        builder.caption(&self.title, ("sans-serif", 24)).margin(18).x_label_area_size(56).y_label_area_size(80);
        match scale {
            Scale::Linear => {
                let (x, y) = (self.range(|p| p.0).ok_or("no points")?, self.range(|p| p.1).ok_or("no points")?);
                self.fill(builder.build_cartesian_2d(x.0..x.1, y.0..y.1)?, scale)
            }
            Scale::LogLog => {
                let (x, y) = (self.decades(|p| p.0).ok_or("no points")?, self.decades(|p| p.1).ok_or("no points")?);
                let (x, y) = ((x.0..x.1).log_scale(), (y.0..y.1).log_scale());
                self.fill(builder.build_cartesian_2d(x, y)?, scale)
            }
        }
    }

    fn fill<'a, X, Y>(
        &self,
        mut chart: ChartContext<'a, SVGBackend<'a>, Cartesian2d<X, Y>>,
        scale: Scale,
    ) -> Result<(), Box<dyn std::error::Error>>
    where
        X: Ranged<ValueType = f64> + ValueFormatter<f64> + 'a,
        Y: Ranged<ValueType = f64> + ValueFormatter<f64> + 'a,
    {
        let mut mesh = chart.configure_mesh();
        if scale == Scale::LogLog {
            mesh.x_label_formatter(&logarithmic_label).y_label_formatter(&logarithmic_label);
        }
        mesh.light_line_style(WHITE)
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
            .position(if scale == Scale::LogLog {
                SeriesLabelPosition::LowerLeft
            } else {
                SeriesLabelPosition::UpperLeft
            })
            .margin(16)
            .legend_area_size(34)
            .label_font(("sans-serif", 16))
            .background_style(WHITE.mix(0.85))
            .border_style(RGBColor(200, 200, 200))
            .draw()?;
        Ok(())
    }

    /// Extent of a coordinate on a logarithmic axis: whole decades, for a part of one may hold no tick.
    fn decades(&self, coordinate: impl Fn(&(f64, f64)) -> f64) -> Option<(f64, f64)> {
        let values = self.series.iter().flat_map(|s| &s.points).map(&coordinate).filter(|v| *v > 0.0 && v.is_finite());
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(l, h), v| (l.min(v), h.max(v)));
        let decade = |v: f64, round: fn(f64) -> f64| libm::pow(10.0, round(libm::log10(v)));
        (low <= high).then(|| (decade(low, f64::floor) / BESIDE, decade(high, f64::ceil) * BESIDE))
    }

    /// Extent of a coordinate over all series, a little widened; `None` without points.
    fn range(&self, coordinate: impl Fn(&(f64, f64)) -> f64) -> Option<(f64, f64)> {
        let values = || self.series.iter().flat_map(|s| &s.points).map(&coordinate).filter(|v| v.is_finite());
        let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
        let margin = if high > low { 0.06 * (high - low) } else { 0.5 * high.abs().max(1.0) };
        (low <= high).then_some((low - margin, high + margin))
    }
}

/// Room beside the outermost decades, so that no mark is cut.
const BESIDE: f64 = 1.15;

/// A number at a tick: plain where it is short.
fn logarithmic_label(value: &f64) -> String {
    if (1e-3..1e5).contains(value) { super::price::short(*value) } else { format!("{value:.0e}") }
}

/// An SVG picture as a PNG file's bytes. The font comes with the program, so that every machine draws the same.
///
/// # Errors
/// In words, where the text is no picture.
pub fn png(svg: &str) -> Result<Vec<u8>, StudyError> {
    drawn(svg).map_err(|e| StudyError::Chart(e.to_string()))
}

fn undrawn(why: &dyn std::error::Error) -> StudyError {
    StudyError::Chart(format!("the chart cannot be drawn: {why}"))
}

fn drawn(svg: &str) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let mut options = usvg::Options { font_family: "DejaVu Sans".into(), ..usvg::Options::default() };
    let fonts = Arc::make_mut(&mut options.fontdb);
    fonts.load_font_data(dejavu::sans::regular().to_vec());
    fonts.set_sans_serif_family("DejaVu Sans");
    let tree = usvg::Tree::from_str(svg, &options)?;
    let size = tree.size().to_int_size();
    let mut picture = tiny_skia::Pixmap::new(size.width(), size.height()).ok_or("no memory for the picture")?;
    resvg::render(&tree, tiny_skia::Transform::identity(), &mut picture.as_mut());
    Ok(picture.encode_png()?)
}
