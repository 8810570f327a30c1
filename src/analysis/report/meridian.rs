//! Pictures of frames for `revolve chart --field`: the meridian section, mirrored about the axis and coloured by a field.

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::frames::{self, FrameData, ScalarField, is_facet_field};
use super::mesh::{CELLS, bounds, drawn};
use super::picture::missing;
use super::units::UnitNames;
use super::{ReportError, find};
use crate::output::HISTORY;
use crate::output::drawing::{Colour, Drawing, DrawingShape, LineStroke, ShapePaint, TextAnchor, TextLabel};
use crate::output::sums::Checksums;
use crate::study::axis::{self, ticks};
use crate::study::table::digits;

/// Largest and smallest width of a picture, and largest height of the plot, in points.
const WIDTH: f64 = 1200.0;
const LEAST_WIDTH: f64 = 900.0;
const HEIGHT: f64 = 560.0;
/// Margins around the plot in points: left, right, top, bottom.
const MARGIN: [f64; 4] = [100.0, 40.0, 56.0, 140.0];
/// Free space around the bodies, relative to their size.
const SPACE: f64 = 0.05;
/// Width and height of the colour bar in points, and the number of its rectangles.
const BAR: [f64; 2] = [480.0, 14.0];
const BAR_PARTS: usize = 64;
/// Parts along each side of an element in smooth shading.
const PARTS: usize = 4;
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

/// Contents of pictures of frames.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldOptions {
    /// Name of the field, regardless of case.
    pub field: String,
    pub range: ColourRange,
    /// Whether values of elements are averaged at the nodes and interpolated.
    pub smooth: bool,
    /// Part of the plane that is shown; `None` shows all.
    pub window: Option<PictureWindow>,
}

/// Range of values of the colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ColourRange {
    /// Smallest and largest value of the frame.
    Frame,
    /// Smallest and largest value of all frames.
    Run,
    /// Given values.
    Given([f64; 2]),
}

impl std::str::FromStr for ColourRange {
    type Err = String;

    fn from_str(text: &str) -> Result<ColourRange, String> {
        match text {
            "frame" => Ok(ColourRange::Frame),
            "run" => Ok(ColourRange::Run),
            _ => {
                let ends = text.split_once("..").and_then(|(low, high)| Some([low.parse().ok()?, high.parse().ok()?]));
                let ends = ends.filter(|[low, high]: &[f64; 2]| low < high && (high - low).is_finite());
                ends.map(ColourRange::Given).ok_or("expected frame, run or LOW..HIGH".into())
            }
        }
    }
}

/// Part of the r-z plane that a picture shows, in the units of the deck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureWindow {
    /// Smallest z, largest z, and largest r.
    region: [f64; 3],
}

impl std::str::FromStr for PictureWindow {
    type Err = String;

    fn from_str(text: &str) -> Result<PictureWindow, String> {
        let region = || {
            let (ends, reach) = text.split_once(',')?;
            let (low, high) = ends.split_once("..")?;
            Some([low.parse().ok()?, high.parse().ok()?, reach.parse().ok()?])
        };
        let is_area = |&[low, high, reach]: &[f64; 3]| low < high && reach > 0.0 && (high - low + reach).is_finite();
        region().filter(is_area).map(|region| PictureWindow { region }).ok_or("expected LOW..HIGH,R".into())
    }
}

/// Frames of the run in a folder.
pub struct RunFrames {
    name: String,
    sums: Checksums,
    series: Vec<(f64, PathBuf)>,
    scene: Value,
    units: UnitNames,
}

impl RunFrames {
    /// Reads the list of frames of the only run in a folder.
    ///
    /// # Errors
    /// If the folder has no run, several runs, or damaged files.
    pub fn of(folder: &Path) -> Result<RunFrames, ReportError> {
        let name = find::only_run(folder)?;
        let (list, sums) = (folder.join(format!("{name}.pvd")), Checksums::of(folder)?);
        sums.verify(&list)?;
        let (series, scene) = (frames::series(&list)?, find::scene(folder, &name, &sums)?);
        let units = find::units(&folder.join(format!("{name}{HISTORY}")));
        Ok(RunFrames { name, sums, series, scene, units })
    }

    pub fn count(&self) -> usize {
        self.series.len()
    }

    fn read(&self, number: usize) -> Result<FrameData, ReportError> {
        let Some((time, path)) = number.checked_sub(1).and_then(|i| self.series.get(i)) else {
            return Err(format!("there is no frame {number}; the run has {}", self.series.len()).into());
        };
        Ok(frames::read(*time, path, &self.sums)?)
    }

    /// Draws a frame, numbered from 1; the last one by default. The direction of the axis is that of the first frame. A
    /// field that only other frames have is drawn without values.
    ///
    /// # Errors
    /// If there is no such frame, if no frame has the field, or if a file cannot be read.
    pub fn drawing(&self, number: Option<usize>, options: &FieldOptions) -> Result<Drawing, ReportError> {
        let number = number.unwrap_or(self.series.len());
        let frame = self.read(number)?;
        let picture = FramePicture::of(&frame, options);
        let first = bounds(&self.read(1)?.points);
        let mut range = picture.range();
        if options.range == ColourRange::Run || picture.field.is_none() {
            let run = self.limits(options)?.1;
            range = if options.range == ColourRange::Run { run } else { range };
        }
        let view = PictureView::of(picture.bounds(), first, options.window);
        Ok(self.draw(number, &picture, view, options, range))
    }

    /// Draws all frames with one view and, unless the options say otherwise, one range of colours. `take` receives each
    /// drawing.
    ///
    /// # Errors
    /// If there is no such field, if a file cannot be read, or those of `take`.
    pub fn animation(
        &self,
        options: &FieldOptions,
        take: &mut dyn FnMut(&Drawing) -> Result<(), String>,
    ) -> Result<(), ReportError> {
        let (extent, run) = self.limits(options)?;
        let view = PictureView::of(extent, bounds(&self.read(1)?.points), options.window);
        for number in 1..=self.series.len() {
            let frame = self.read(number)?;
            let picture = FramePicture::of(&frame, options);
            let range = if options.range == ColourRange::Frame { picture.range() } else { run };
            take(&self.draw(number, &picture, view, options, range))?;
        }
        Ok(())
    }

    /// Returns the bounds of the coordinates and the range of the values over all frames.
    ///
    /// # Errors
    /// If no frame has the field, or if a file cannot be read.
    fn limits(&self, options: &FieldOptions) -> Result<([[f64; 2]; 2], [f64; 2]), ReportError> {
        let (mut corners, mut range) = (Vec::new(), [f64::INFINITY, f64::NEG_INFINITY]);
        let (mut has_field, mut names) = (false, Vec::new());
        for number in 1..=self.series.len() {
            let frame = self.read(number)?;
            let picture = FramePicture::of(&frame, options);
            has_field |= picture.field.is_some();
            names.extend(frame.scalars.into_iter().map(|scalar| scalar.name));
            corners.extend(picture.bounds());
            let [low, high] = picture.range();
            range = [range[0].min(low), range[1].max(high)];
        }
        names.sort();
        names.dedup();
        if has_field { Ok((bounds(&corners), range)) } else { Err(missing("field", &options.field, &names).into()) }
    }

    fn draw(
        &self,
        number: usize,
        picture: &FramePicture,
        view: PictureView,
        options: &FieldOptions,
        range: [f64; 2],
    ) -> Drawing {
        let range = if let ColourRange::Given(range) = options.range { range } else { range };
        let [length, time] = self.units.length_and_time();
        let unit = if time.is_empty() { String::new() } else { format!(" {time}") };
        let (shown_time, count) = (digits(picture.time, 4), self.series.len());
        let field = picture.field.as_deref().unwrap_or(&options.field);
        let title = format!("{}: {field} at time {shown_time}{unit}, frame {number} of {count}", self.name);
        let canvas = FrameCanvas { view, range, scene: &self.scene };
        let mut drawing = canvas.begin(&title);
        picture.cells.iter().for_each(|cell| canvas.draw_cell(&mut drawing, cell));
        canvas.end(&mut drawing, &length, &axis::title(field, &self.units.of_column(field), 0));
        drawing
    }
}

/// A drawn cell: corners `[r, z]`, and the values at the corners if there are any.
struct DrawnCell {
    corners: Vec<[f64; 2]>,
    values: Option<Vec<f64>>,
}

/// Cells of a frame with the values of a field.
struct FramePicture {
    /// Name of the field; `None` if the frame does not have it.
    field: Option<String>,
    time: f64,
    cells: Vec<DrawnCell>,
}

impl FramePicture {
    fn of(frame: &FrameData, options: &FieldOptions) -> FramePicture {
        let scalar = frame.scalars.iter().find(|scalar| scalar.name.eq_ignore_ascii_case(&options.field));
        let mesh = drawn(&frame.points, &frame.cells, CELLS);
        let is_present = |cell: usize| !frame.deleted.get(cell).copied().unwrap_or(false);
        let values = scalar.map(|scalar| CellValues::of(frame, scalar, options.smooth, is_present));
        let cell = |(corners, &index): (&Vec<usize>, &usize)| {
            let nodes: Vec<usize> = corners.iter().map(|&p| mesh.points[p]).collect();
            DrawnCell {
                corners: nodes.iter().map(|&n| frame.points[n]).collect(),
                values: values.as_ref().and_then(|values| values.at_corners(index, &nodes)),
            }
        };
        let cells = mesh.corners.iter().zip(&mesh.cells).filter(|c| is_present(*c.1)).map(cell).collect();
        FramePicture { field: scalar.map(|scalar| scalar.name.clone()), time: frame.time, cells }
    }

    fn range(&self) -> [f64; 2] {
        let values = || self.cells.iter().filter_map(|c| c.values.as_ref()).flatten().copied();
        [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
    }

    fn bounds(&self) -> [[f64; 2]; 2] {
        bounds(&self.cells.iter().flat_map(|c| c.corners.iter().copied()).collect::<Vec<_>>())
    }
}

/// Values of a field at the corners of drawn cells.
struct CellValues<'a> {
    frame: &'a FrameData,
    scalar: &'a ScalarField,
    is_smooth: bool,
    /// Mean values at the nodes, for a field on cells in smooth shading.
    at_nodes: Option<Vec<f64>>,
}

impl CellValues<'_> {
    fn of<'a>(
        frame: &'a FrameData,
        scalar: &'a ScalarField,
        is_smooth: bool,
        is_present: impl Fn(usize) -> bool,
    ) -> CellValues<'a> {
        let values = CellValues { frame, scalar, is_smooth, at_nodes: None };
        let counts = |cell: usize| is_present(cell) && values.belongs(frame.cells[cell].len());
        let at_nodes = (is_smooth && scalar.on_cells).then(|| node_means(frame, &scalar.values, counts));
        CellValues { at_nodes, ..values }
    }

    /// Returns whether cells with this number of corners have values: element fields are zero on the facets of rigid
    /// bodies, and facet fields on deformable elements.
    fn belongs(&self, corners: usize) -> bool {
        !self.scalar.on_cells || (corners == 2) == is_facet_field(&self.scalar.name)
    }

    /// Returns the values at the drawn corners of a cell; `None` if one is not finite.
    fn at_corners(&self, cell: usize, nodes: &[usize]) -> Option<Vec<f64>> {
        let values = &self.scalar.values;
        let mean = |corners: &[usize]| corners.iter().map(|&p| values[p]).sum::<f64>() / corners.len() as f64;
        let cell_value = if self.scalar.on_cells { values[cell] } else { mean(&self.frame.cells[cell]) };
        let corner_values: Vec<f64> = match (self.is_smooth, &self.at_nodes) {
            (true, Some(means)) => nodes.iter().map(|&n| means[n]).collect(),
            (true, None) => nodes.iter().map(|&n| values[n]).collect(),
            (false, _) => vec![cell_value; nodes.len()],
        };
        let is_shown =
            self.belongs(nodes.len()) && cell_value.is_finite() && corner_values.iter().all(|v| v.is_finite());
        is_shown.then_some(corner_values)
    }
}

/// Returns the mean value of the cells around each node; NaN without cells.
fn node_means(frame: &FrameData, values: &[f64], counts: impl Fn(usize) -> bool) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); frame.points.len()];
    for (cell, corners) in frame.cells.iter().enumerate().filter(|c| counts(c.0)) {
        for &node in corners {
            sums[node].0 += values[cell];
            sums[node].1 += 1.0;
        }
    }
    sums.into_iter().map(|(sum, count)| sum / count).collect()
}

/// Visible region and scale of a picture.
#[derive(Clone, Copy)]
struct PictureView {
    /// Smallest z, largest z, largest r of the view.
    region: [f64; 3],
    /// Whether the z axis is horizontal.
    z_is_horizontal: bool,
    /// Scale in points per unit of length.
    unit: f64,
}

impl PictureView {
    /// Creates the view of coordinates with the given bounds, or of a window. The longer side of the first frame is
    /// horizontal.
    fn of([low, high]: [[f64; 2]; 2], first: [[f64; 2]; 2], window: Option<PictureWindow>) -> PictureView {
        let size = f64::max(high[1] - low[1], 2.0 * high[0]);
        let whole = [low[1] - SPACE * size, high[1] + SPACE * size, f64::max(high[0] + SPACE * size, 0.12 * size)];
        let region = window.map_or(whole, |window| window.region);
        let z_is_horizontal = first[1][1] - first[0][1] > 2.0 * first[1][0];
        let (along, across) = (region[1] - region[0], 2.0 * region[2]);
        let (wide, high) = if z_is_horizontal { (along, across) } else { (across, along) };
        let unit = f64::min((WIDTH - MARGIN[0] - MARGIN[1]) / wide, HEIGHT / high);
        PictureView { region, z_is_horizontal, unit }
    }

    fn place(&self, [r, z]: [f64; 2]) -> [f64; 2] {
        let [low, high, reach] = self.region;
        let (x, y) = if self.z_is_horizontal { (z - low, reach - r) } else { (r + reach, high - z) };
        [MARGIN[0] + x * self.unit, MARGIN[2] + y * self.unit]
    }

    fn size(&self) -> [f64; 2] {
        let (along, across) = ((self.region[1] - self.region[0]) * self.unit, 2.0 * self.region[2] * self.unit);
        if self.z_is_horizontal { [along, across] } else { [across, along] }
    }
}

/// View, range of colours and scene of a picture.
struct FrameCanvas<'a> {
    view: PictureView,
    range: [f64; 2],
    scene: &'a Value,
}

impl FrameCanvas<'_> {
    /// Begins a drawing with its title, the targets and the rigid surfaces; later shapes are clipped to the plot.
    fn begin(&self, title: &str) -> Drawing {
        let [wide, high] = self.view.size();
        let width = (wide + MARGIN[0] + MARGIN[1]).max(LEAST_WIDTH);
        let mut drawing = Drawing::new([width.round(), (high + MARGIN[2] + MARGIN[3]).round()]);
        drawing.label(TextLabel { size: 18.0, ..TextLabel::new([MARGIN[0], 32.0], TextAnchor::Start, title) });
        drawing.shapes.push(DrawingShape::BeginClip([MARGIN[0], MARGIN[2]], [wide, high]));
        self.draw_layers(&mut drawing);
        self.draw_surfaces(&mut drawing);
        drawing
    }

    /// Completes a drawing: axis of symmetry, coordinate axes and colour bar.
    fn end(&self, drawing: &mut Drawing, length: &str, field: &str) {
        let axis = [self.view.region[0], self.view.region[1]].map(|z| self.view.place([0.0, z]));
        let dashed = LineStroke { dashes: &[10.0, 3.0, 2.0, 3.0], ..LineStroke::new(0x55_55_55, 1.0) };
        drawing.path(axis, false, ShapePaint { fill: None, stroke: Some(dashed) });
        drawing.shapes.push(DrawingShape::EndClip);
        self.draw_axes(drawing, length);
        self.draw_scale(drawing, field);
    }

    fn draw_layers(&self, drawing: &mut Drawing) {
        let [low, high, reach] = self.view.region;
        for (i, TargetLayer { ends: [from, to], name }) in layers(self.scene).into_iter().enumerate() {
            let (bottom, top) = (f64::min(from, to).max(low), f64::max(from, to).min(high));
            if bottom >= top {
                continue;
            }
            let (a, b) = (self.view.place([reach, bottom]), self.view.place([-reach, top]));
            let (x, y) = (f64::min(a[0], b[0]), f64::min(a[1], b[1]));
            let (wide, tall) = ((a[0] - b[0]).abs(), (a[1] - b[1]).abs());
            let fill = if i % 2 == 0 { 0xe9_e4_d8 } else { 0xf3_ef_e6 };
            let paint = ShapePaint { stroke: Some(LineStroke::new(0x8d_83_68, 1.0)), ..ShapePaint::fill(fill, 1.0) };
            drawing.rectangle([x, y], [wide, tall], paint);
            let label = TextLabel::new([x + 8.0, y + tall - 9.0], TextAnchor::Start, name);
            drawing.label(TextLabel { colour: 0x5f_57_42, ..label });
        }
    }

    /// Draws analytical planes and surfaces; dashed if a body carries them, because they are drawn where they began.
    fn draw_surfaces(&self, drawing: &mut Drawing) {
        let list = |key: &str| self.scene.get(key).and_then(Value::as_array).cloned().unwrap_or_default();
        let number = |value: Option<&Value>| value.and_then(Value::as_f64).unwrap_or(f64::NAN);
        let reach = self.view.region[2];
        let planes = list("planes").into_iter().map(|plane| {
            let z = number(plane.get("height"));
            (vec![[0.0, z], [reach, z]], plane.get("carried_by").is_some())
        });
        let surfaces = list("surfaces").into_iter().map(|surface| {
            let points = surface.get("points").and_then(Value::as_array).cloned().unwrap_or_default();
            let points = points.iter().map(|point| [number(point.get(0)), number(point.get(1))]).collect();
            (points, surface.get("carried_by").is_some())
        });
        for (points, is_carried) in planes.chain(surfaces) {
            let dashes: &[f32] = if is_carried { &[6.0, 4.0] } else { &[] };
            let stroke = LineStroke { dashes, ..LineStroke::new(0x33_33_33, 2.5) };
            for side in [1.0, -1.0] {
                let places: Vec<[f64; 2]> = points.iter().map(|[r, z]| self.view.place([side * r, *z])).collect();
                drawing.path(places, false, ShapePaint { fill: None, stroke: Some(stroke) });
            }
        }
    }

    fn draw_cell(&self, drawing: &mut Drawing, cell: &DrawnCell) {
        let Some(values) = &cell.values else { return self.draw_patch(drawing, &cell.corners, 0x9a_a0_a6) };
        let is_even = values.iter().all(|v| *v == values[0]);
        if is_even || !(3..=4).contains(&values.len()) {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            return self.draw_patch(drawing, &cell.corners, self.colour(mean));
        }
        // A triangle is a quadrilateral with two equal corners.
        let corner = |k: usize| (cell.corners[k.min(values.len() - 1)], values[k.min(values.len() - 1)]);
        let blend = |x: f64, y: f64, of: &dyn Fn(usize) -> f64| {
            (1.0 - y) * ((1.0 - x) * of(0) + x * of(1)) + y * (x * of(2) + (1.0 - x) * of(3))
        };
        let point = |x: f64, y: f64| [0, 1].map(|i| blend(x, y, &|k| corner(k).0[i]));
        for part in 0..PARTS * PARTS {
            let [x, y] = [part % PARTS, part / PARTS].map(|i| i as f64 / PARTS as f64);
            let step = 1.0 / PARTS as f64;
            let patch = [point(x, y), point(x + step, y), point(x + step, y + step), point(x, y + step)];
            let value = blend(x + 0.5 * step, y + 0.5 * step, &|k| corner(k).1);
            self.draw_patch(drawing, &patch, self.colour(value));
        }
    }

    fn draw_patch(&self, drawing: &mut Drawing, corners: &[[f64; 2]], colour: Colour) {
        let is_line = corners.len() == 2;
        let paint = if is_line {
            ShapePaint { fill: None, stroke: Some(LineStroke { round: true, ..LineStroke::new(colour, 6.0) }) }
        } else {
            ShapePaint { stroke: Some(LineStroke::new(colour, 0.6)), ..ShapePaint::fill(colour, 1.0) }
        };
        for side in [1.0, -1.0] {
            let corners = corners.iter().map(|[r, z]| self.view.place([side * r, *z]));
            drawing.path(corners, !is_line, paint);
        }
    }

    fn colour(&self, value: f64) -> Colour {
        colour(share(value, self.range))
    }

    fn draw_axes(&self, drawing: &mut Drawing, length: &str) {
        let ([wide, high], [low, top, reach]) = (self.view.size(), self.view.region);
        let (right, bottom) = (MARGIN[0] + wide, MARGIN[2] + high);
        drawing.rectangle([MARGIN[0], MARGIN[2]], [wide, high], ShapePaint::stroke(0x99_99_99, 1.0));
        let (zs, rs) = (ticks(low, top, 7.0), ticks(-reach, reach, 7.0));
        // Both axes have the same scale and the same power of ten.
        let exponent = axis::exponent(&[&zs[..], &rs].concat());
        let names = if self.view.z_is_horizontal { ["z", "r"] } else { ["r", "z"] };
        let [level, upright] = names.map(|name| axis::title(name, length, exponent));
        drawing.label(TextLabel::new([0.5 * (MARGIN[0] + right), bottom + 46.0], TextAnchor::Middle, level));
        let label = TextLabel::new([26.0, MARGIN[2] + 0.5 * high], TextAnchor::Middle, upright);
        drawing.label(TextLabel { upright: true, ..label });
        let on_z = zs.into_iter().map(|z| (self.view.place([0.0, z]), z, self.view.z_is_horizontal));
        let on_r = rs.into_iter().map(|r| (self.view.place([r, low]), r.abs(), !self.view.z_is_horizontal));
        for ([x, y], value, is_level) in on_z.chain(on_r) {
            let label = axis::label(value, exponent);
            let (position, anchor) = if is_level {
                ([x, bottom + 22.0], TextAnchor::Middle)
            } else {
                ([MARGIN[0] - 8.0, y + 5.0], TextAnchor::End)
            };
            drawing.label(TextLabel::new(position, anchor, label));
        }
    }

    /// Draws the colour bar with its ticks, and the name and unit of the field.
    fn draw_scale(&self, drawing: &mut Drawing, field: &str) {
        let y = MARGIN[2] + self.view.size()[1] + 76.0;
        let [low, high] = self.range;
        if low > high {
            return drawing.label(TextLabel::new([MARGIN[0], y], TextAnchor::Start, "no values in this frame"));
        }
        let width = BAR[0] / BAR_PARTS as f64;
        for part in 0..BAR_PARTS {
            let paint = ShapePaint::fill(colour(part as f64 / (BAR_PARTS as f64 - 1.0)), 1.0);
            drawing.rectangle([MARGIN[0] + width * part as f64, y], [width + 0.5, BAR[1]], paint);
        }
        let marks = ticks(low, high, 5.0);
        let exponent = axis::exponent(&marks);
        for mark in marks {
            let x = MARGIN[0] + BAR[0] * share(mark, self.range);
            drawing.path([[x, y + BAR[1]], [x, y + BAR[1] + 5.0]], false, ShapePaint::stroke(0x44_44_44, 1.0));
            let label = axis::label(mark, exponent);
            drawing.label(TextLabel::new([x, y + BAR[1] + 21.0], TextAnchor::Middle, label));
        }
        let power = axis::title("", "", exponent);
        let name = if power.is_empty() { field.to_owned() } else { format!("{field}, {power}") };
        // A smallest value that differs from zero by rounding is shown as zero.
        let rounding = 1e-12 * low.abs().max(high.abs());
        let [low, high] = [low, high].map(|value| number(if value.abs() < rounding { 0.0 } else { value }));
        let text = format!("{name} ({low} to {high})");
        drawing.label(TextLabel::new([MARGIN[0] + BAR[0] + 24.0, y + 12.0], TextAnchor::Start, text));
    }
}

/// Layer of a target: z of its ends, and the names of the target and material.
struct TargetLayer {
    ends: [f64; 2],
    name: String,
}

/// Returns the layers of the targets in a summary.
fn layers(scene: &Value) -> Vec<TargetLayer> {
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
                layers.push(TargetLayer { ends: [z, z + direction * thickness], name: format!("{name}: {material}") });
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
