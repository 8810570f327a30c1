//! Pictures for `revolve chart`: charts of histories, and the meridian section of a frame coloured by a field.

use std::path::Path;

use serde_json::Value;

use super::frames::{self, CELLS, FrameData};
use super::mesh::{bounds, drawn};
use super::{PageOptions, ReportError, balance, compare};
use super::{find, history};
use crate::output::drawing::{Colour, Drawing, DrawingShape, LineStroke, ShapePaint, TextAnchor, TextLabel};
use crate::output::sums::Checksums;
use crate::study::axis::{self, ticks};
use crate::study::chart::{Chart, ChartSeries, SeriesForm};

/// Width of a picture and largest height of the plot, in points.
const WIDTH: f64 = 1200.0;
const HEIGHT: f64 = 620.0;
/// Margins around the plot in points: left, right, top, bottom.
const MARGIN: [f64; 4] = [100.0, 40.0, 56.0, 120.0];
/// The colour map Viridis (Smith and van der Walt) at nine equally spaced values.
const VIRIDIS: [[f64; 3]; 9] = [
    [68.0, 1.0, 84.0],
    [71.0, 45.0, 123.0],
    [59.0, 82.0, 139.0],
    [44.0, 114.0, 142.0],
    [33.0, 145.0, 140.0],
    [40.0, 174.0, 128.0],
    [94.0, 201.0, 98.0],
    [173.0, 220.0, 48.0],
    [253.0, 231.0, 37.0],
];

/// Returns a chart of history columns of the run in a folder.
pub fn columns(folder: &Path, wanted: &[String], options: &PageOptions) -> Result<ComparedChart, ReportError> {
    let (name, path) = history_file(folder)?;
    let names = history::names(&path)?;
    let find = |wanted: &String| {
        let known = names.iter().find(|n| n.eq_ignore_ascii_case(wanted)).cloned();
        known.ok_or_else(|| missing("column", wanted, &names))
    };
    let wanted = wanted.iter().map(find).collect::<Result<Vec<_>, _>>()?;
    options.labels.check(&wanted)?;
    let mut chart = chart(&name, &path, &wanted, options)?;
    let curves = options.compare.as_ref().map_or(Ok(Vec::new()), |file| compare::curves(file, &path))?;
    for curve in &curves {
        chart.series.push(ChartSeries::new(curve.name(), SeriesForm::Marks, curve.points.clone()));
    }
    Ok(ComparedChart { chart, deviations: curves.iter().map(compare::ReferenceCurve::sentence).collect() })
}

/// A chart, with sentences on the deviation from reference curves.
#[derive(Clone, Debug, Default)]
pub struct ComparedChart {
    pub chart: Chart,
    /// One sentence per reference curve.
    pub deviations: Vec<String>,
}

/// Returns the chart of the energy balance with stacked stored and dissipated energies, or of all energies as lines if
/// the balance has fewer than two.
pub fn energies(folder: &Path) -> Result<Chart, ReportError> {
    let (name, path) = history_file(folder)?;
    let choice = history::choose(&history::names(&path)?, &[]);
    match choice.charts.into_iter().find(|c| c.0 == "Energy") {
        Some((_, columns)) => {
            let wanted: Vec<String> = balance::columns().map(str::to_owned).collect();
            if let Some(balance) = balance::chart(&history::read(&path, &wanted)?, &find::units(&path)) {
                return Ok(titled(&name, balance));
            }
            Ok(chart(&name, &path, &columns, &PageOptions::default())?)
        }
        None => {
            Err(format!("{} contains no energies: the deck does not request them (*ENERGY OUTPUT)", path.display())
                .into())
        }
    }
}

fn history_file(folder: &Path) -> Result<(String, std::path::PathBuf), String> {
    let name = find::only_run(folder)?;
    let path = folder.join(format!("{name}_history.csv"));
    if !path.is_file() {
        return Err(format!("{} is missing", path.display()));
    }
    Checksums::of(folder)?.verify(&path)?;
    Ok((name, path))
}

fn missing(what: &str, wanted: &str, names: &[String]) -> String {
    format!("there is no {what} `{wanted}`; {}", history::hint(wanted, names))
}

/// Sets the title of a chart and removes empty series.
fn titled(title: &str, mut chart: Chart) -> Chart {
    chart.series.retain(|s| !s.points.is_empty());
    Chart { title: title.into(), ..chart }
}

fn chart(title: &str, path: &Path, columns: &[String], options: &PageOptions) -> Result<Chart, String> {
    let history = history::read(path, columns)?;
    let units = find::units(path);
    let mut chart = titled(title, history::chart("", columns, &history, &units));
    let variable = |name: &String| name.split('@').next().unwrap_or(name).to_owned();
    let all_energies = columns.iter().all(|c| !c.contains('@') && (c.starts_with("ALL") || c == "ETOTAL"));
    let first = columns.first().map(variable).unwrap_or_default();
    let alike = columns.iter().all(|c| variable(c) == first);
    let y_label = if all_energies && columns.len() > 1 {
        "energy".into()
    } else if alike {
        first
    } else {
        String::new()
    };
    chart.units = units.over_time(if y_label == "energy" { "Energy" } else { &y_label });
    // A single line is named by the axis label.
    chart.y_label = if columns.len() == 1 { options.labels.of(&columns[0]).to_owned() } else { y_label };
    chart.series.iter_mut().for_each(|s| s.name = options.labels.of(&s.name).to_owned());
    Ok(chart)
}

/// Draws the meridian section of a frame (numbered from 1; default: the last frame), mirrored about the axis.
pub fn meridian(folder: &Path, number: Option<usize>, field: &str) -> Result<Drawing, ReportError> {
    let name = find::only_run(folder)?;
    let (list, sums) = (folder.join(format!("{name}.pvd")), Checksums::of(folder)?);
    sums.verify(&list)?;
    let series = frames::series(&list)?;
    let number = number.unwrap_or(series.len());
    let Some((time, path)) = number.checked_sub(1).and_then(|i| series.get(i)) else {
        return Err(format!("there is no frame {number}; the run has {}", series.len()).into());
    };
    let frame = frames::read(*time, path, &sums)?;
    let names: Vec<String> = frame.scalars.iter().map(|s| s.0.clone()).collect();
    let at = names.iter().position(|n| n.eq_ignore_ascii_case(field)).ok_or_else(|| missing("field", field, &names))?;
    let title = format!("{name}: {} at time {time:.6e}, frame {number} of {}", names[at], series.len());
    Ok(MeridianPicture::of(&frame, at, &find::scene(folder, &name, &sums)?).drawing(&title))
}

/// A drawn cell: corners `[r, z]`, and the value if there is one.
struct DrawnCell {
    corners: Vec<[f64; 2]>,
    value: Option<f64>,
}

/// Cells, range of values, view and scale of a picture.
struct MeridianPicture {
    cells: Vec<DrawnCell>,
    range: [f64; 2],
    /// Smallest z, largest z, largest r of the view.
    view: [f64; 3],
    /// Whether the z axis is horizontal.
    z_is_horizontal: bool,
    /// Scale in points per unit of length.
    unit: f64,
    /// Layers of targets: start z, end z, name.
    layers: Vec<(f64, f64, String)>,
}

impl MeridianPicture {
    fn of(frame: &FrameData, field: usize, scene: &Value) -> MeridianPicture {
        let (_, on_cells, values) = &frame.scalars[field];
        let mesh = drawn(&frame.points, &frame.cells, CELLS);
        let there = |cell: usize| !frame.deleted.get(cell).copied().unwrap_or(false);
        let corner_mean = |cell: usize| {
            let corners = &frame.cells[cell];
            corners.iter().map(|&p| values[p]).sum::<f64>() / corners.len() as f64
        };
        // Element fields are zero on the facets of rigid bodies, and facet fields on deformable elements.
        let of_facets = ["PRESSURE", "NORMAL_VELOCITY", "LAYER"].contains(&frame.scalars[field].0.as_str());
        let cell = |(corners, &index): (&Vec<usize>, &usize)| {
            let value = if *on_cells { values[index] } else { corner_mean(index) };
            let belongs = !*on_cells || (corners.len() == 2) == of_facets;
            let corners = corners.iter().map(|&p| frame.points[mesh.points[p]]).collect();
            DrawnCell { corners, value: Some(value).filter(|v| belongs && v.is_finite()) }
        };
        let cells: Vec<DrawnCell> = mesh.corners.iter().zip(&mesh.cells).filter(|c| there(*c.1)).map(cell).collect();
        let values = || cells.iter().filter_map(|c| c.value);
        let range = [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)];
        let points: Vec<[f64; 2]> = cells.iter().flat_map(|c| c.corners.iter().copied()).collect();
        let [low, high] = bounds(&points);
        let size = f64::max(high[1] - low[1], 2.0 * high[0]);
        let view = [low[1] - 0.15 * size, high[1] + 0.15 * size, f64::max(1.35 * high[0], 0.12 * size)];
        let (along, across) = (view[1] - view[0], 2.0 * view[2]);
        let lying = along > across;
        let (wide, high) = if lying { (along, across) } else { (across, along) };
        let unit = f64::min((WIDTH - MARGIN[0] - MARGIN[1]) / wide, HEIGHT / high);
        MeridianPicture { cells, range, view, z_is_horizontal: lying, unit, layers: layers(scene) }
    }

    fn place(&self, [r, z]: [f64; 2]) -> [f64; 2] {
        let [low, high, reach] = self.view;
        let (x, y) = if self.z_is_horizontal { (z - low, reach - r) } else { (r + reach, high - z) };
        [MARGIN[0] + x * self.unit, MARGIN[2] + y * self.unit]
    }

    fn size(&self) -> [f64; 2] {
        let (along, across) = ((self.view[1] - self.view[0]) * self.unit, 2.0 * self.view[2] * self.unit);
        if self.z_is_horizontal { [along, across] } else { [across, along] }
    }

    fn drawing(&self, title: &str) -> Drawing {
        let [wide, high] = self.size();
        let height = high + MARGIN[2] + MARGIN[3];
        let mut drawing = Drawing::new([WIDTH, height.round()]);
        drawing.label(TextLabel { size: 18.0, ..TextLabel::new([MARGIN[0], 32.0], TextAnchor::Start, title) });
        drawing.shapes.push(DrawingShape::BeginClip([MARGIN[0], MARGIN[2]], [wide, high]));
        self.draw_layers(&mut drawing);
        self.cells.iter().for_each(|cell| self.draw_cell(&mut drawing, cell));
        let axis = [self.view[0], self.view[1]].map(|z| self.place([0.0, z]));
        let dashed = LineStroke { dashes: &[10.0, 3.0, 2.0, 3.0], ..LineStroke::new(0x55_55_55, 1.0) };
        drawing.path(axis, false, ShapePaint { fill: None, stroke: Some(dashed) });
        drawing.shapes.push(DrawingShape::EndClip);
        self.draw_axes(&mut drawing);
        self.draw_scale(&mut drawing, height - 34.0);
        drawing
    }

    fn draw_layers(&self, drawing: &mut Drawing) {
        let [low, high, reach] = self.view;
        for (i, (from, to, name)) in self.layers.iter().enumerate() {
            let (bottom, top) = (f64::min(*from, *to).max(low), f64::max(*from, *to).min(high));
            if bottom >= top {
                continue;
            }
            let (a, b) = (self.place([reach, bottom]), self.place([-reach, top]));
            let (x, y) = (f64::min(a[0], b[0]), f64::min(a[1], b[1]));
            let (wide, tall) = ((a[0] - b[0]).abs(), (a[1] - b[1]).abs());
            let fill = if i % 2 == 0 { 0xe9_e4_d8 } else { 0xf3_ef_e6 };
            let paint = ShapePaint { stroke: Some(LineStroke::new(0x8d_83_68, 1.0)), ..ShapePaint::fill(fill, 1.0) };
            drawing.rectangle([x, y], [wide, tall], paint);
            let label = TextLabel::new([x + 8.0, y + tall - 9.0], TextAnchor::Start, name);
            drawing.label(TextLabel { colour: 0x5f_57_42, ..label });
        }
    }

    fn draw_cell(&self, drawing: &mut Drawing, cell: &DrawnCell) {
        let colour = cell.value.map_or(0x9a_a0_a6, |v| colour(share(v, self.range)));
        let is_line = cell.corners.len() == 2;
        let paint = if is_line {
            ShapePaint { fill: None, stroke: Some(LineStroke { round: true, ..LineStroke::new(colour, 6.0) }) }
        } else {
            ShapePaint { stroke: Some(LineStroke::new(colour, 0.6)), ..ShapePaint::fill(colour, 1.0) }
        };
        for side in [1.0, -1.0] {
            let corners = cell.corners.iter().map(|[r, z]| self.place([side * r, *z]));
            drawing.path(corners, !is_line, paint);
        }
    }

    fn draw_axes(&self, drawing: &mut Drawing) {
        let ([wide, high], [low, top, reach]) = (self.size(), self.view);
        let (right, bottom) = (MARGIN[0] + wide, MARGIN[2] + high);
        drawing.rectangle([MARGIN[0], MARGIN[2]], [wide, high], ShapePaint::stroke(0x99_99_99, 1.0));
        let (zs, rs) = (ticks(low, top, 7.0), ticks(-reach, reach, 7.0));
        // Both axes have the same scale and the same power of ten.
        let exponent = axis::exponent(&[&zs[..], &rs].concat());
        let names = ["z", "r"].map(|name| axis::title(name, "", exponent));
        let (level, upright) = if self.z_is_horizontal { (&*names[0], "r") } else { (&*names[1], "z") };
        drawing.label(TextLabel::new([0.5 * (MARGIN[0] + right), bottom + 46.0], TextAnchor::Middle, level));
        drawing.label(TextLabel::new([18.0, MARGIN[2] + 0.5 * high], TextAnchor::Middle, upright));
        let on_z = zs.into_iter().map(|z| (self.place([0.0, z]), z, self.z_is_horizontal));
        let on_r = rs.into_iter().map(|r| (self.place([r, low]), r.abs(), !self.z_is_horizontal));
        for ([x, y], value, is_level) in on_z.chain(on_r) {
            let label = axis::label(value, exponent);
            let (at, anchor) = if is_level {
                ([x, bottom + 22.0], TextAnchor::Middle)
            } else {
                ([MARGIN[0] - 8.0, y + 5.0], TextAnchor::End)
            };
            drawing.label(TextLabel::new(at, anchor, label));
        }
    }

    fn draw_scale(&self, drawing: &mut Drawing, y: f64) {
        let [low, high] = self.range;
        if low > high {
            return drawing.label(TextLabel::new([MARGIN[0], y], TextAnchor::Start, "no values in this frame"));
        }
        for i in 0..64 {
            let paint = ShapePaint::fill(colour(f64::from(i) / 63.0), 1.0);
            drawing.rectangle([MARGIN[0] + 6.0 * f64::from(i), y - 14.0], [6.5, 14.0], paint);
        }
        let range = format!("{} to {}", number(low), number(high));
        drawing.label(TextLabel::new([MARGIN[0] + 400.0, y], TextAnchor::Start, range));
    }
}

/// Returns the layers of the targets in a summary as intervals of z.
fn layers(scene: &Value) -> Vec<(f64, f64, String)> {
    let mut layers = Vec::new();
    for target in scene.get("targets").and_then(Value::as_array).into_iter().flatten() {
        let number = |key: &str| target.get(key).and_then(Value::as_f64).unwrap_or(0.0);
        let (mut z, direction) = (number("front"), number("direction"));
        let name = target.get("name").and_then(Value::as_str).unwrap_or_default();
        for layer in target.get("layers").and_then(Value::as_array).into_iter().flatten() {
            let thickness = layer.get("thickness").and_then(Value::as_f64).unwrap_or(f64::INFINITY);
            let material = layer.get("material").and_then(Value::as_str).unwrap_or_default();
            // Gaps have no material.
            if !material.is_empty() {
                layers.push((z, z + direction * thickness, format!("{name}: {material}")));
            }
            z += direction * thickness;
        }
    }
    layers
}

/// Returns the position of a value in a range, from 0 to 1.
fn share(value: f64, [low, high]: [f64; 2]) -> f64 {
    if high > low { (value - low) / (high - low) } else { 0.0 }
}

fn colour(part: f64) -> Colour {
    let x = part.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f64;
    let i = (x as usize).min(VIRIDIS.len() - 2);
    let mix = |k: usize| (VIRIDIS[i][k] + (VIRIDIS[i + 1][k] - VIRIDIS[i][k]) * (x - i as f64)).round() as u8;
    Colour::from_be_bytes([0, mix(0), mix(1), mix(2)])
}

/// Formats a number with four digits, without an exponent if this is short.
fn number(value: f64) -> String {
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    if value == 0.0 || (1e-3..1e5).contains(&value.abs()) { format!("{rounded}") } else { format!("{rounded:e}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_and_numbers_match_their_scale() {
        assert_eq!([colour(0.0), colour(1.0), colour(9.0)], [0x44_01_54, 0xfd_e7_25, 0xfd_e7_25]);
        assert_eq!([number(0.025), number(-1.23456e9), number(0.0)], ["0.025", "-1.235e9", "0"]);
    }
}
