//! Figures of an identification: computed over measured values, and the corner plot of a posterior with the distribution
//! of each parameter and of each pair of parameters.

use super::data::{MeasuredData, Observation};
use super::posterior::Posterior;
use crate::output::drawing::{Colour, Drawing, ShapePaint, TextAnchor, TextLabel};
use crate::study::axis;
use crate::study::chart::{Chart, ChartSeries, SeriesForm};
use crate::study::statistics::IntervalEstimate;
use crate::study::statistics::summary::between;
use crate::study::table::short;

/// Size of the drawing in points.
const SIZE: f64 = 960.0;
/// Left and bottom margin for labels, top and right margin, and gap between panels, in points.
const MARGIN: f64 = 96.0;
const EDGE: f64 = 28.0;
const GAP: f64 = 12.0;
/// Number of bins along a side of a panel.
const BINS: usize = 24;
/// Probability on each side that the panels leave out.
const LEFT_OUT: f64 = 0.002;
/// Size of the letters of ticks, in points.
const TICKS: f64 = 12.0;
const COLOUR: Colour = 0x00_72_b2;
const FRAME: Colour = 0x88_88_88;
const MARK: Colour = 0xd5_5e_00;

/// Returns a chart of a series: measured values and those computed with the fitted parameters, over the abscissa
/// of curves or over the first known parameter. `band` has the limits of the prediction of each observation; empty
/// without a posterior.
pub fn prediction_chart(data: &MeasuredData, title: &str, series: usize, computed: &[f64], band: &[[f64; 2]]) -> Chart {
    let mut drawn_series = Vec::new();
    let of_series = |o: &&(usize, &Observation)| o.1.series == series;
    let numbered: Vec<(usize, &Observation)> = data.observations.iter().enumerate().collect();
    let is_curve = numbered.iter().filter(of_series).any(|(_, o)| o.abscissa.is_some());
    let groups: Vec<Option<usize>> = if is_curve { (0..data.shots.len()).map(Some).collect() } else { vec![None] };
    for group in groups {
        let mut points: Vec<(f64, usize)> = numbered
            .iter()
            .filter(of_series)
            .filter(|(_, o)| group.is_none_or(|shot| o.shot == shot))
            .map(|(i, o)| (chart_abscissa(data, o), *i))
            .collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let name = group.filter(|_| data.shots.len() > 1).map_or(String::new(), |shot| format!(" {}", shot + 1));
        let line = is_curve || data.names.len() == 1;
        let along = |value: &dyn Fn(usize) -> f64| points.iter().map(|(x, i)| (*x, value(*i))).collect::<Vec<_>>();
        if !band.is_empty() && line {
            let mut edges = along(&|i| band[i][0]);
            edges.extend(along(&|i| band[i][1]).into_iter().rev());
            drawn_series.push(ChartSeries::new(format!("95 % of predictions{name}"), SeriesForm::Band, edges));
        }
        let measured = along(&|i| data.observations[i].value);
        drawn_series.push(ChartSeries::new(
            format!("{}{name}, measured", data.series[series]),
            SeriesForm::Marks,
            measured,
        ));
        let form = if line { SeriesForm::Line } else { SeriesForm::Marks };
        drawn_series.push(ChartSeries::new(format!("computed{name}"), form, along(&|i| computed[i])));
    }
    let x = if is_curve { "x" } else { data.names.first().map_or("shot", String::as_str) };
    Chart::new(title, [x, &data.series[series]], drawn_series)
}

fn chart_abscissa(data: &MeasuredData, observation: &Observation) -> f64 {
    let first = data.shots[observation.shot].first().copied();
    observation.abscissa.or(first).unwrap_or(observation.shot as f64 + 1.0)
}

/// Returns the corner plot: histograms on the diagonal with the median and the 95 % interval, and densities of pairs
/// below it.
pub fn corner_plot(posterior: &Posterior) -> Drawing {
    let count = posterior.names.len();
    let values: Vec<Vec<f64>> = (0..count).map(|i| posterior.draws.iter().map(|draw| draw[i]).collect()).collect();
    let axes = values.iter().map(|values| shown_range(values)).collect();
    let side = (SIZE - MARGIN - EDGE - GAP * (count as f64 - 1.0)) / count as f64;
    let mut plot = CornerPlot { drawing: Drawing::new([SIZE, SIZE]), names: &posterior.names, values, axes, side };
    let estimates = posterior.estimates();
    for (row, estimate) in estimates.iter().enumerate() {
        (0..row).for_each(|column| plot.draw_pair(row, column));
        plot.draw_histogram(row, *estimate);
    }
    plot.drawing
}

/// Returns the range that contains all but a small part of the values.
fn shown_range(values: &[f64]) -> [f64; 2] {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let [low, high] = [LEFT_OUT, 1.0 - LEFT_OUT].map(|part| between(&sorted, part));
    let margin = if high > low { 0.05 * (high - low) } else { 0.5 * low.abs().max(1.0) };
    [low - margin, high + margin]
}

struct CornerPlot<'a> {
    drawing: Drawing,
    names: &'a [String],
    /// Draws of each parameter.
    values: Vec<Vec<f64>>,
    /// Shown range of each parameter.
    axes: Vec<[f64; 2]>,
    /// Side of a panel in points.
    side: f64,
}

impl CornerPlot<'_> {
    /// Returns the upper left corner of a panel.
    fn corner(&self, row: usize, column: usize) -> [f64; 2] {
        [MARGIN + column as f64 * (self.side + GAP), EDGE + row as f64 * (self.side + GAP)]
    }

    /// Returns the position of a value along its axis, from 0 to 1 inside the panel.
    fn part(&self, parameter: usize, value: f64) -> f64 {
        let [low, high] = self.axes[parameter];
        (value - low) / (high - low)
    }

    fn bin(&self, parameter: usize, value: f64) -> Option<usize> {
        let part = self.part(parameter, value);
        (0.0..1.0).contains(&part).then_some((part * BINS as f64) as usize)
    }

    fn draw_histogram(&mut self, parameter: usize, estimate: IntervalEstimate) {
        let mut counts = [0_usize; BINS];
        for value in &self.values[parameter] {
            if let Some(bin) = self.bin(parameter, *value) {
                counts[bin] += 1;
            }
        }
        let highest_count = counts.iter().copied().max().unwrap_or(0).max(1) as f64;
        let ([x, y], width) = (self.corner(parameter, parameter), self.side / BINS as f64);
        for (bin, count) in counts.into_iter().enumerate() {
            let height = 0.92 * self.side * count as f64 / highest_count;
            let corner = [x + bin as f64 * width, y + self.side - height];
            self.drawing.rectangle(corner, [width, height], ShapePaint::fill(COLOUR, 0.6));
        }
        for (value, stroke) in [(estimate.low, 1.0), (estimate.value, 2.0), (estimate.high, 1.0)] {
            let line_x = x + self.part(parameter, value) * self.side;
            self.drawing.path([[line_x, y], [line_x, y + self.side]], false, ShapePaint::stroke(MARK, stroke));
        }
        let [value, low, high] = [estimate.value, estimate.low, estimate.high].map(short);
        let text = format!("{value} ({low} to {high})");
        let label = TextLabel::new([x + 0.5 * self.side, y - 8.0], TextAnchor::Middle, text);
        self.drawing.label(TextLabel { size: 14.0, ..label });
        self.draw_frame(parameter, parameter);
    }

    fn draw_pair(&mut self, row: usize, column: usize) {
        let mut counts = vec![0_usize; BINS * BINS];
        for (down, across) in self.values[row].iter().zip(&self.values[column]) {
            if let (Some(j), Some(i)) = (self.bin(row, *down), self.bin(column, *across)) {
                counts[j * BINS + i] += 1;
            }
        }
        let highest_count = counts.iter().copied().max().unwrap_or(0).max(1) as f64;
        let ([x, y], width) = (self.corner(row, column), self.side / BINS as f64);
        for (place, count) in counts.into_iter().enumerate().filter(|bin| bin.1 > 0) {
            let corner = [x + (place % BINS) as f64 * width, y + self.side - (place / BINS + 1) as f64 * width];
            let paint = ShapePaint::fill(COLOUR, 0.1 + 0.9 * count as f64 / highest_count);
            self.drawing.rectangle(corner, [width, width], paint);
        }
        self.draw_frame(row, column);
    }

    /// Draws the frame of a panel, and names and ticks at the left and at the bottom of the plot.
    fn draw_frame(&mut self, row: usize, column: usize) {
        let ([x, y], side) = (self.corner(row, column), self.side);
        self.drawing.rectangle([x, y], [side, side], ShapePaint::stroke(FRAME, 1.0));
        if row + 1 == self.names.len() {
            let ticks = self.ticks(column);
            for (at, text) in ticks.0 {
                self.label([x + at * side, y + side + 18.0], TextAnchor::Middle, TICKS, false, text);
            }
            self.label([x + 0.5 * side, y + side + 46.0], TextAnchor::Middle, 15.0, false, ticks.1);
        }
        if column == 0 && row > 0 {
            let ticks = self.ticks(row);
            for (at, text) in ticks.0 {
                self.label([x - 6.0, y + (1.0 - at) * side + 4.0], TextAnchor::End, TICKS, false, text);
            }
            self.label([22.0, y + 0.5 * side], TextAnchor::Middle, 15.0, true, ticks.1);
        }
    }

    /// Returns positions and labels of the ticks of a parameter, and the title of its axis.
    fn ticks(&self, parameter: usize) -> (Vec<(f64, String)>, String) {
        let [low, high] = self.axes[parameter];
        let ticks = axis::ticks(low, high, 3.0);
        let exponent = axis::exponent(&ticks);
        let labels = ticks.iter().map(|tick| (self.part(parameter, *tick), axis::label(*tick, exponent))).collect();
        (labels, axis::title(&self.names[parameter], "", exponent))
    }

    fn label(&mut self, at: [f64; 2], anchor: TextAnchor, size: f64, upright: bool, text: String) {
        self.drawing.label(TextLabel { size, upright, ..TextLabel::new(at, anchor, text) });
    }
}
