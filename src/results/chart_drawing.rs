//! Drawing of charts as SVG and PNG with linear or logarithmic axes and a legend below the plot.

use super::axis;
use super::chart::{AxisScale, Chart, ChartError, ChartSeries, SeriesForm, stacked};
use crate::drawing::{Colour, Drawing, LETTERS, LineStroke, ShapePaint, TextAnchor, TextLabel};

/// Width and height of a picture, in points.
const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 640.0;
/// Margins around the plot in points: left, right, top. The bottom margin is separate, because the legend is below it.
const MARGIN: [f64; 3] = [92.0, 28.0, 56.0];
const BOTTOM_MARGIN: f64 = 66.0;
/// Height of a legend row and average width of a letter, in points.
const ROW: f64 = 24.0;
const LETTER: f64 = 0.62 * LETTERS;
/// Width of a legend symbol with its spacing.
const MARK: f64 = 42.0;
/// Lines with more points are drawn without markers.
const MARKED: usize = 60;
/// Factor by which a logarithmic axis extends beyond its outermost decades, so that no marker is cut off.
const LOG_AXIS_MARGIN: f64 = 1.15;
/// The colour-blind-safe palette of Okabe and Ito, with violet and grey added.
const PALETTE: [Colour; 8] =
    [0x00_72_b2, 0xd5_5e_00, 0x00_9e_73, 0xcc_79_a7, 0xe6_9f_00, 0x56_b4_e9, 0x8c_6b_b1, 0x5a_5a_5a];

impl Chart {
    /// Returns the drawing of the chart.
    ///
    /// # Errors
    /// If the chart has no points.
    pub fn drawing(&self) -> Result<Drawing, ChartError> {
        let drawing = ChartDrawing::of(self).ok_or_else(|| ChartError("the chart has no points".into()))?;
        Ok(drawing.complete())
    }

    /// Returns the chart as SVG text.
    ///
    /// # Errors
    /// If the chart has no points.
    pub fn svg(&self) -> Result<String, ChartError> {
        Ok(self.drawing()?.svg())
    }

    /// Returns the chart as the bytes of a PNG file.
    ///
    /// # Errors
    /// If the chart has no points.
    pub fn png(&self) -> Result<Vec<u8>, ChartError> {
        self.drawing()?.png().map_err(|e| ChartError(format!("the chart cannot be drawn: {e}")))
    }
}

/// A chart with the ranges of its axes and its drawing.
struct ChartDrawing<'a> {
    chart: &'a Chart,
    x: [f64; 2],
    y: [f64; 2],
    /// Indices of the series in each legend row.
    legend: Vec<Vec<usize>>,
    drawing: Drawing,
}

impl<'a> ChartDrawing<'a> {
    /// Returns `None` for a chart without points.
    fn of(chart: &'a Chart) -> Option<ChartDrawing<'a>> {
        let points = || chart.series.iter().flat_map(|s| &s.points);
        let lines = chart.series.iter().filter(|s| s.form != SeriesForm::Area).flat_map(|s| &s.points).map(|p| p.1);
        let stack = stacked(&chart.series);
        let edges = stack.iter().flatten().flatten().flat_map(|edge| [edge.0, edge.1]);
        let x = range(points().map(|p| p.0), chart.scale)?;
        let y = range(lines.chain(edges), chart.scale)?;
        Some(ChartDrawing { chart, x, y, legend: legend(&chart.series), drawing: Drawing::new([WIDTH, HEIGHT]) })
    }

    /// Returns the right and bottom coordinates of the plot area.
    fn corner(&self) -> [f64; 2] {
        [WIDTH - MARGIN[1], HEIGHT - BOTTOM_MARGIN - ROW * self.legend.len() as f64]
    }

    fn place(&self, (x, y): (f64, f64)) -> Option<[f64; 2]> {
        let along = |value: f64, [low, high]: [f64; 2]| match self.chart.scale {
            AxisScale::Linear => (value - low) / (high - low),
            AxisScale::LogLog => libm::log(value / low) / libm::log(high / low),
        };
        let [right, bottom] = self.corner();
        let position =
            [MARGIN[0] + along(x, self.x) * (right - MARGIN[0]), bottom - along(y, self.y) * (bottom - MARGIN[2])];
        position.iter().all(|p| p.is_finite()).then_some(position)
    }

    fn complete(mut self) -> Drawing {
        let title = TextLabel::new([0.5 * WIDTH, 34.0], TextAnchor::Middle, &self.chart.title);
        self.drawing.label(TextLabel { size: 20.0, ..title });
        self.draw_axis(0);
        self.draw_axis(1);
        let [right, bottom] = self.corner();
        let axes = [[MARGIN[0], MARGIN[2]], [MARGIN[0], bottom], [right, bottom]];
        self.drawing.path(axes, false, ShapePaint::stroke(0x44_44_44, 1.0));
        self.draw_areas();
        let chart = self.chart;
        for (index, series) in chart.series.iter().enumerate().filter(|s| s.1.form != SeriesForm::Area) {
            self.draw_series(series, colour(chart, index));
        }
        self.draw_legend();
        self.drawing
    }

    /// Draws grid lines, ticks and label of the horizontal (0) or the vertical (1) axis.
    fn draw_axis(&mut self, axis: usize) {
        let [low, high] = [self.x, self.y][axis];
        let AxisTicks { ticks, labels, exponent } = AxisTicks::of(low, high, self.chart.scale);
        let [right, bottom] = self.corner();
        for (tick, label) in ticks.into_iter().zip(labels) {
            let point = if axis == 0 { (tick, self.y[0]) } else { (self.x[0], tick) };
            let Some([x, y]) = self.place(point) else { continue };
            let (line, label_position, anchor) = match axis {
                0 => ([[x, bottom], [x, MARGIN[2]]], [x, bottom + 22.0], TextAnchor::Middle),
                _ => ([[MARGIN[0], y], [right, y]], [MARGIN[0] - 8.0, y + 5.0], TextAnchor::End),
            };
            self.drawing.path(line, false, ShapePaint::stroke(0xe2_e2_e2, 1.0));
            self.drawing.label(TextLabel::new(label_position, anchor, label));
        }
        let name = [&self.chart.x_label, &self.chart.y_label][axis];
        let name = axis::title(name, &self.chart.units[axis], exponent);
        let (across, up) = (0.5 * (MARGIN[0] + right), 0.5 * (MARGIN[2] + bottom));
        let title_position = if axis == 0 { [across, bottom + 48.0] } else { [24.0, up] };
        self.drawing.label(TextLabel {
            size: 17.0,
            upright: axis == 1,
            ..TextLabel::new(title_position, TextAnchor::Middle, name)
        });
    }

    fn draw_areas(&mut self) {
        let chart = self.chart;
        let coloured = chart.series.iter().zip(PALETTE.into_iter().cycle()).filter(|s| s.0.form == SeriesForm::Area);
        for ((series, colour), edges) in coloured.zip(stacked(&chart.series)) {
            for side in edges.iter().filter(|side| side.iter().any(|e| e.0 != e.1)) {
                let x = || series.points.iter().map(|p| p.0);
                let upper = x().zip(side).map(|(x, edge)| (x, edge.1));
                let lower = x().zip(side).map(|(x, edge)| (x, edge.0));
                let outline: Vec<(f64, f64)> = upper.chain(lower.rev()).collect();
                let paint = ShapePaint { stroke: Some(LineStroke::new(colour, 0.5)), ..ShapePaint::fill(colour, 0.75) };
                self.drawing.path(self.places(&outline), true, paint);
            }
        }
    }

    fn places(&self, points: &[(f64, f64)]) -> Vec<[f64; 2]> {
        points.iter().filter_map(|p| self.place(*p)).collect()
    }

    fn draw_series(&mut self, series: &ChartSeries, colour: Colour) {
        let places = self.places(&series.points);
        if series.form == SeriesForm::Marks || series.form == SeriesForm::Line && series.points.len() <= MARKED {
            places.iter().for_each(|place| self.drawing.dot(*place, colour));
        }
        match series.form {
            SeriesForm::Marks => {}
            SeriesForm::Band => self.drawing.path(places, true, ShapePaint::fill(colour, 0.25)),
            form => self.drawing.path(places, false, stroke(form, colour)),
        }
    }

    fn draw_legend(&mut self) {
        let top = self.corner()[1] + BOTTOM_MARGIN + 4.0;
        for (row, entries) in std::mem::take(&mut self.legend).into_iter().enumerate() {
            let (mut x, y) = (MARGIN[0], top + ROW * row as f64);
            for index in entries {
                let series = &self.chart.series[index];
                let colour = colour(self.chart, index);
                match series.form {
                    SeriesForm::Marks => self.drawing.dot([x + 13.0, y - 5.0], colour),
                    SeriesForm::Area => {
                        self.drawing.rectangle([x, y - 11.0], [26.0, 12.0], ShapePaint::fill(colour, 0.75))
                    }
                    SeriesForm::Band => {
                        self.drawing.rectangle([x, y - 11.0], [26.0, 12.0], ShapePaint::fill(colour, 0.25))
                    }
                    form => {
                        let line = [[x, y - 5.0], [x + 26.0, y - 5.0]];
                        self.drawing.path(line, false, stroke(form, colour));
                    }
                }
                self.drawing.label(TextLabel::new([x + 32.0, y], TextAnchor::Start, &series.name));
                x += entry_width(series);
            }
        }
    }
}

/// Returns the colour of a series; a guide line over areas is dark.
fn colour(chart: &Chart, index: usize) -> Colour {
    let on_areas = chart.series.first().is_some_and(|s| s.form == SeriesForm::Area);
    if on_areas && chart.series[index].form == SeriesForm::Guide { 0x11_11_11 } else { PALETTE[index % PALETTE.len()] }
}

/// Ticks of an axis, their labels, and the common power of ten of the labels.
struct AxisTicks {
    ticks: Vec<f64>,
    labels: Vec<String>,
    exponent: i32,
}

impl AxisTicks {
    fn of(low: f64, high: f64, scale: AxisScale) -> AxisTicks {
        match scale {
            AxisScale::Linear => {
                let ticks = axis::ticks(low, high, 7.0);
                let exponent = axis::exponent(&ticks);
                AxisTicks { labels: ticks.iter().map(|t| axis::label(*t, exponent)).collect(), ticks, exponent }
            }
            AxisScale::LogLog => {
                let ticks = axis::decades(low, high);
                AxisTicks { labels: axis::logarithmic(&ticks), ticks, exponent: 0 }
            }
        }
    }
}

fn stroke(form: SeriesForm, colour: Colour) -> ShapePaint {
    let stroke = match form {
        SeriesForm::Guide => LineStroke { dashes: &[7.0, 5.0], ..LineStroke::new(colour, 1.6) },
        _ => LineStroke { round: true, ..LineStroke::new(colour, 2.2) },
    };
    ShapePaint { fill: None, stroke: Some(stroke) }
}

fn entry_width(series: &ChartSeries) -> f64 {
    MARK + LETTER * series.name.chars().count() as f64 + 14.0
}

/// Distributes the series over legend rows.
fn legend(series: &[ChartSeries]) -> Vec<Vec<usize>> {
    let (mut rows, mut used): (Vec<Vec<usize>>, f64) = (Vec::new(), 0.0);
    for (i, series) in series.iter().enumerate() {
        let wide = entry_width(series);
        match rows.last_mut() {
            Some(row) if used + wide <= WIDTH - MARGIN[0] - MARGIN[1] => row.push(i),
            _ => {
                rows.push(vec![i]);
                used = 0.0;
            }
        }
        used += wide;
    }
    rows
}

/// Returns the range of an axis: the range of the values with a margin, or whole decades on a logarithmic axis. `None`
/// without values.
fn range(values: impl Iterator<Item = f64>, scale: AxisScale) -> Option<[f64; 2]> {
    let fits = |v: &f64| v.is_finite() && (scale == AxisScale::Linear || *v > 0.0);
    let (low, high) = values.filter(fits).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return None;
    }
    Some(match scale {
        AxisScale::Linear => {
            let margin = if high > low { 0.04 * (high - low) } else { 0.5 * high.abs().max(1.0) };
            [low - margin, high + margin]
        }
        AxisScale::LogLog => {
            let decade = |v: f64, round: fn(f64) -> f64| libm::pow(10.0, round(libm::log10(v)));
            [decade(low, f64::floor) / LOG_AXIS_MARGIN, decade(high, f64::ceil) * LOG_AXIS_MARGIN]
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(name: &str, points: &[(f64, f64)]) -> ChartSeries {
        ChartSeries { name: name.into(), points: points.to_vec(), ..ChartSeries::default() }
    }

    /// Returns the numbers that follow `word` in a text.
    fn numbers(text: &str, word: &str) -> Vec<f64> {
        text.split(word).skip(1).filter_map(|rest| rest.split('"').next()?.parse().ok()).collect()
    }

    #[test]
    fn long_legend_is_below_the_plot() {
        let series: Vec<ChartSeries> = (0..9)
            .map(|i| line(&format!("a quantity with a long name, number {i}"), &[(0.0, 0.0), (1.0, 1.0)]))
            .collect();
        let chart = Chart { series, ..Chart::default() };
        let svg = chart.svg().expect("a chart");
        let lowest_mark = numbers(&svg, "cy=\"").into_iter().fold(0.0, f64::max);
        let names = svg.lines().filter(|l| l.contains("number ")).flat_map(|l| numbers(l, " y=\""));
        let names: Vec<f64> = names.collect();
        assert_eq!(names.len(), 9);
        assert!(names.iter().all(|y| *y > lowest_mark + 20.0 && *y < HEIGHT), "{names:?} {lowest_mark}");
    }

    #[test]
    fn points_without_a_position_are_skipped_and_empty_charts_are_errors() {
        let chart = Chart { series: vec![line("a", &[(1.0, f64::NAN), (2.0, 3.0)])], ..Chart::default() };
        let svg = chart.svg().expect("a chart");
        assert!(!svg.contains("NaN") && svg.matches("<circle").count() == 1);
        assert!(Chart::default().svg().is_err());
        let below = Chart { series: vec![line("a", &[(1.0, -1.0)])], scale: AxisScale::LogLog, ..Chart::default() };
        assert!(below.svg().is_err());
    }
}
