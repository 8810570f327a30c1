//! Charts drawn as SVG and PNG, on linear or logarithmic axes; the legend stands below the curves.

use super::StudyError;
use super::axis;
use super::chart::{Chart, Form, Scale, Series, stacked};
use crate::output::drawing::{Anchor, Colour, Drawing, LETTERS, Label, Paint, Stroke};

/// Size of a picture, in points.
const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 640.0;
/// Room around what is drawn: left, right, top; what is below holds the legend too.
const MARGIN: [f64; 3] = [92.0, 28.0, 56.0];
const BELOW: f64 = 66.0;
/// Height of a row of the legend, and width of a letter in it.
const ROW: f64 = 24.0;
const LETTER: f64 = 0.62 * LETTERS;
/// Width of a legend's mark with the room beside it.
const MARK: f64 = 42.0;
/// Marks on a longer line would hide it.
const MARKED: usize = 60;
/// Room beside the outermost values of a logarithmic axis, so that no mark is cut.
const BESIDE: f64 = 1.15;
/// Okabe and Ito's palette, safe for colour-blind readers, with a violet and a grey after it.
const PALETTE: [Colour; 8] =
    [0x00_72_b2, 0xd5_5e_00, 0x00_9e_73, 0xcc_79_a7, 0xe6_9f_00, 0x56_b4_e9, 0x8c_6b_b1, 0x5a_5a_5a];

impl Chart {
    /// The drawing of the chart; an error if there is nothing to draw.
    pub fn drawing(&self) -> Result<Drawing, StudyError> {
        let drawing = ChartDrawing::of(self).ok_or_else(|| StudyError::Chart("the chart has no points".into()))?;
        Ok(drawing.complete())
    }

    /// The chart as SVG text; an error if there is nothing to draw.
    pub fn svg(&self) -> Result<String, StudyError> {
        Ok(self.drawing()?.svg())
    }

    /// The chart as the bytes of a PNG file; an error if there is nothing to draw.
    pub fn png(&self) -> Result<Vec<u8>, StudyError> {
        self.drawing()?.png().map_err(|e| StudyError::Chart(format!("the chart cannot be drawn: {e}")))
    }
}

/// A chart with the ranges of its axes, and the picture that is drawn.
struct ChartDrawing<'a> {
    chart: &'a Chart,
    x: [f64; 2],
    y: [f64; 2],
    /// Entries of the legend, row by row.
    legend: Vec<Vec<usize>>,
    drawing: Drawing,
}

impl<'a> ChartDrawing<'a> {
    /// `None` without points.
    fn of(chart: &'a Chart) -> Option<ChartDrawing<'a>> {
        let points = || chart.series.iter().flat_map(|s| &s.points);
        let lines = chart.series.iter().filter(|s| s.form != Form::Area).flat_map(|s| &s.points).map(|p| p.1);
        let stack = stacked(&chart.series);
        let edges = stack.iter().flatten().flatten().flat_map(|edge| [edge.0, edge.1]);
        let x = range(points().map(|p| p.0), chart.scale)?;
        let y = range(lines.chain(edges), chart.scale)?;
        Some(ChartDrawing { chart, x, y, legend: legend(&chart.series), drawing: Drawing::new([WIDTH, HEIGHT]) })
    }

    /// Where the plot ends: right and bottom.
    fn corner(&self) -> [f64; 2] {
        [WIDTH - MARGIN[1], HEIGHT - BELOW - ROW * self.legend.len() as f64]
    }

    fn place(&self, (x, y): (f64, f64)) -> Option<[f64; 2]> {
        let along = |value: f64, [low, high]: [f64; 2]| match self.chart.scale {
            Scale::Linear => (value - low) / (high - low),
            Scale::LogLog => libm::log(value / low) / libm::log(high / low),
        };
        let [right, bottom] = self.corner();
        let place =
            [MARGIN[0] + along(x, self.x) * (right - MARGIN[0]), bottom - along(y, self.y) * (bottom - MARGIN[2])];
        place.iter().all(|p| p.is_finite()).then_some(place)
    }

    fn complete(mut self) -> Drawing {
        let title = Label::new([0.5 * WIDTH, 34.0], Anchor::Middle, &self.chart.title);
        self.drawing.label(Label { size: 20.0, ..title });
        self.draw_axis(0);
        self.draw_axis(1);
        let [right, bottom] = self.corner();
        let axes = [[MARGIN[0], MARGIN[2]], [MARGIN[0], bottom], [right, bottom]];
        self.drawing.path(axes, false, Paint::stroke(0x44_44_44, 1.0));
        self.draw_areas();
        let chart = self.chart;
        for (index, series) in chart.series.iter().enumerate().filter(|s| s.1.form != Form::Area) {
            self.draw_series(series, colour(chart, index));
        }
        self.draw_legend();
        self.drawing
    }

    /// Grid, ticks and name of the horizontal (0) or the vertical axis (1).
    fn draw_axis(&mut self, axis: usize) {
        let [low, high] = [self.x, self.y][axis];
        let (ticks, labels, exponent) = ticks(low, high, self.chart.scale);
        let [right, bottom] = self.corner();
        for (tick, label) in ticks.into_iter().zip(labels) {
            let at = if axis == 0 { (tick, self.y[0]) } else { (self.x[0], tick) };
            let Some([x, y]) = self.place(at) else { continue };
            let (line, place, anchor) = match axis {
                0 => ([[x, bottom], [x, MARGIN[2]]], [x, bottom + 22.0], Anchor::Middle),
                _ => ([[MARGIN[0], y], [right, y]], [MARGIN[0] - 8.0, y + 5.0], Anchor::End),
            };
            self.drawing.path(line, false, Paint::stroke(0xe2_e2_e2, 1.0));
            self.drawing.label(Label::new(place, anchor, label));
        }
        let name = [&self.chart.x_label, &self.chart.y_label][axis];
        let name = axis::title(name, &self.chart.units[axis], exponent);
        let (across, up) = (0.5 * (MARGIN[0] + right), 0.5 * (MARGIN[2] + bottom));
        let place = if axis == 0 { [across, bottom + 48.0] } else { [24.0, up] };
        self.drawing.label(Label { size: 17.0, upright: axis == 1, ..Label::new(place, Anchor::Middle, name) });
    }

    fn draw_areas(&mut self) {
        let chart = self.chart;
        let coloured = chart.series.iter().zip(PALETTE.into_iter().cycle()).filter(|s| s.0.form == Form::Area);
        for ((series, colour), edges) in coloured.zip(stacked(&chart.series)) {
            for side in edges.iter().filter(|side| side.iter().any(|e| e.0 != e.1)) {
                let x = || series.points.iter().map(|p| p.0);
                let upper = x().zip(side).map(|(x, edge)| (x, edge.1));
                let lower = x().zip(side).map(|(x, edge)| (x, edge.0));
                let outline: Vec<(f64, f64)> = upper.chain(lower.rev()).collect();
                let paint = Paint { stroke: Some(Stroke::new(colour, 0.5)), ..Paint::fill(colour, 0.75) };
                self.drawing.path(self.places(&outline), true, paint);
            }
        }
    }

    fn places(&self, points: &[(f64, f64)]) -> Vec<[f64; 2]> {
        points.iter().filter_map(|p| self.place(*p)).collect()
    }

    fn draw_series(&mut self, series: &Series, colour: Colour) {
        let places = self.places(&series.points);
        if series.form == Form::Marks || series.form == Form::Line && series.points.len() <= MARKED {
            places.iter().for_each(|place| self.drawing.dot(*place, colour));
        }
        match series.form {
            Form::Marks => {}
            Form::Band => self.drawing.path(places, true, Paint::fill(colour, 0.25)),
            form => self.drawing.path(places, false, stroke(form, colour)),
        }
    }

    fn draw_legend(&mut self) {
        let top = self.corner()[1] + BELOW + 4.0;
        for (row, entries) in std::mem::take(&mut self.legend).into_iter().enumerate() {
            let (mut x, y) = (MARGIN[0], top + ROW * row as f64);
            for index in entries {
                let series = &self.chart.series[index];
                let colour = colour(self.chart, index);
                match series.form {
                    Form::Marks => self.drawing.dot([x + 13.0, y - 5.0], colour),
                    Form::Area => self.drawing.rectangle([x, y - 11.0], [26.0, 12.0], Paint::fill(colour, 0.75)),
                    Form::Band => self.drawing.rectangle([x, y - 11.0], [26.0, 12.0], Paint::fill(colour, 0.25)),
                    form => {
                        let line = [[x, y - 5.0], [x + 26.0, y - 5.0]];
                        self.drawing.path(line, false, stroke(form, colour));
                    }
                }
                self.drawing.label(Label::new([x + 32.0, y], Anchor::Start, &series.name));
                x += entry_width(series);
            }
        }
    }
}

/// The colour of a series; what areas are compared with is dark.
fn colour(chart: &Chart, index: usize) -> Colour {
    let on_areas = chart.series.first().is_some_and(|s| s.form == Form::Area);
    if on_areas && chart.series[index].form == Form::Guide { 0x11_11_11 } else { PALETTE[index % PALETTE.len()] }
}

/// Ticks, their labels, and the power of ten that the labels leave out.
fn ticks(low: f64, high: f64, scale: Scale) -> (Vec<f64>, Vec<String>, i32) {
    match scale {
        Scale::Linear => {
            let ticks = axis::ticks(low, high, 7.0);
            let exponent = axis::exponent(&ticks);
            let labels = ticks.iter().map(|t| axis::label(*t, exponent)).collect();
            (ticks, labels, exponent)
        }
        Scale::LogLog => {
            let ticks = axis::decades(low, high);
            let labels = axis::logarithmic(&ticks);
            (ticks, labels, 0)
        }
    }
}

fn stroke(form: Form, colour: Colour) -> Paint {
    let stroke = match form {
        Form::Guide => Stroke { dashes: &[7.0, 5.0], ..Stroke::new(colour, 1.6) },
        _ => Stroke { round: true, ..Stroke::new(colour, 2.2) },
    };
    Paint { fill: None, stroke: Some(stroke) }
}

fn entry_width(series: &Series) -> f64 {
    MARK + LETTER * series.name.chars().count() as f64 + 14.0
}

/// Indices of series, row by row, as many as fit beside each other.
fn legend(series: &[Series]) -> Vec<Vec<usize>> {
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

/// Extent of values, a little widened; of a logarithmic axis whole decades. `None` without values.
fn range(values: impl Iterator<Item = f64>, scale: Scale) -> Option<[f64; 2]> {
    let fits = |v: &f64| v.is_finite() && (scale == Scale::Linear || *v > 0.0);
    let (low, high) = values.filter(fits).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return None;
    }
    Some(match scale {
        Scale::Linear => {
            let margin = if high > low { 0.04 * (high - low) } else { 0.5 * high.abs().max(1.0) };
            [low - margin, high + margin]
        }
        Scale::LogLog => {
            let decade = |v: f64, round: fn(f64) -> f64| libm::pow(10.0, round(libm::log10(v)));
            [decade(low, f64::floor) / BESIDE, decade(high, f64::ceil) * BESIDE]
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(name: &str, points: &[(f64, f64)]) -> Series {
        Series { name: name.into(), points: points.to_vec(), ..Series::default() }
    }

    /// The number behind a word in each line of a text that has it.
    fn numbers(text: &str, word: &str) -> Vec<f64> {
        text.split(word).skip(1).filter_map(|rest| rest.split('"').next()?.parse().ok()).collect()
    }

    #[test]
    fn the_legend_stands_below_the_curves_however_long_it_is() {
        let series: Vec<Series> = (0..9)
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
    fn what_cannot_be_placed_is_left_out_and_nothing_is_an_error() {
        let chart = Chart { series: vec![line("a", &[(1.0, f64::NAN), (2.0, 3.0)])], ..Chart::default() };
        let svg = chart.svg().expect("a chart");
        assert!(!svg.contains("NaN") && svg.matches("<circle").count() == 1);
        assert!(Chart::default().svg().is_err());
        let below = Chart { series: vec![line("a", &[(1.0, -1.0)])], scale: Scale::LogLog, ..Chart::default() };
        assert!(below.svg().is_err());
    }
}
