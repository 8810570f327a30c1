//! Reads frames of a `.pvd` series and packs them for a report page, with fewer frames and coarser meshes if necessary.

use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

use super::data::{MeridianFrames, PackedField};
use super::mesh::{DrawnMesh, bounds, drawn};
use super::read;
use super::units::UnitNames;
use crate::deck::printable;
use crate::kernel::stress::mises;
use crate::model::vtk_file;
use crate::output::EntityLabels;
use crate::output::sums::Checksums;
use crate::output::vtu::{BLANKING, REFERENCE};
use crate::variables::Variable;

/// Largest number of frames on a page.
pub const FRAMES: usize = 60;
/// Largest number of cells that are drawn.
pub const CELLS: usize = 6000;
/// Largest size of the packed frames of a run, in bytes.
pub const BYTES: usize = 6_000_000;
/// Largest number of fields of a run.
const FIELDS: usize = 20;
const NONE: u16 = u16::MAX;

/// Contents of a frame file, with vectors and tensors split into scalars.
#[derive(Clone, Debug, Default)]
pub struct FrameData {
    pub time: f64,
    /// `[r, z]` of each point.
    pub points: Vec<[f64; 2]>,
    pub cells: Vec<Vec<usize>>,
    /// Whether the element of each cell is deleted; empty if none is.
    pub deleted: Vec<bool>,
    /// Element number of each cell in the deck; empty if the file has none.
    pub elements: Vec<i32>,
    /// Material number of each cell, counted from 1; empty if the file has none.
    pub materials: Vec<i32>,
    pub scalars: Vec<ScalarField>,
}

impl FrameData {
    /// Returns the values of a scalar field.
    pub fn values(&self, name: &str, on_cells: bool) -> Option<&[f64]> {
        let field = self.scalars.iter().find(|field| field.name == name && field.on_cells == on_cells);
        field.map(|field| &field.values[..])
    }
}

#[derive(Clone, Debug)]
pub struct ScalarField {
    pub name: String,
    pub on_cells: bool,
    pub values: Vec<f64>,
    /// Array of the file from which it was made.
    pub array: String,
}

/// Reads the times and files of a series.
pub fn series(pvd: &Path) -> Result<Vec<(f64, PathBuf)>, String> {
    let text = read::text(pvd)?;
    let folder = pvd.parent().unwrap_or(Path::new(""));
    // Only files of the same folder are read, so that a foreign list cannot refer to other files.
    let entry = |tag: &str| {
        let time = attribute(tag, "timestep")?.parse().ok()?;
        let name = unescape(attribute(tag, "file")?);
        (!name.contains('/')).then(|| (time, folder.join(name)))
    };
    let wrong = |tag: &str| format!("{}: `{}` is not a frame in this folder", pvd.display(), printable(tag.trim()));
    let first_line = |tag: &str| tag.lines().next().unwrap_or_default().chars().take(80).collect::<String>();
    if !text.contains("</VTKFile>") {
        return Err(format!("{}: the file is truncated", pvd.display()));
    }
    text.split("<DataSet").skip(1).map(|tag| entry(tag).ok_or_else(|| wrong(&first_line(tag)))).collect()
}

pub fn read(time: f64, path: &Path, sums: &Checksums) -> Result<FrameData, String> {
    read_arrays(time, path, sums, &|_| true)
}

/// Reads a frame with the arrays whose names `wanted` accepts, and those that its shape needs.
pub fn read_arrays(
    time: f64,
    path: &Path,
    sums: &Checksums,
    wanted: &dyn Fn(&str) -> bool,
) -> Result<FrameData, String> {
    let text = read::verified_text(path, sums)?;
    let is_reference = text.contains(REFERENCE);
    let needed = |name: &str| name == BLANKING || name == "U" && is_reference || wanted(name);
    let mesh = read::in_file(path, vtk_file::read(path, &needed))?;
    let is_field = |name: &str| name != BLANKING && !EntityLabels::is_name(name);
    let mut scalars = Vec::new();
    for (on_cells, arrays, count) in
        [(false, &mesh.point_arrays, mesh.points.len()), (true, &mesh.cell_arrays, mesh.cells.len())]
    {
        for (array, values) in arrays.iter().filter(|array| is_field(&array.0)) {
            let field = |(name, values)| ScalarField { name, on_cells, values, array: array.clone() };
            scalars.extend(split(array, values, count, &text).into_iter().map(field));
        }
    }
    let around = |cell: Vec<usize>| match cell[..] {
        [a, b, c, ab, bc, ca] => vec![a, ab, b, bc, c, ca],
        _ => cell,
    };
    let moved = mesh.point_arrays.iter().find(|(name, _)| name == "U" && is_reference);
    let shift = |i: usize| moved.map_or([0.0; 2], |(_, values)| [values[3 * i], values[3 * i + 1]]);
    let places = mesh.points.iter().enumerate().map(|(i, p)| [p[0] + shift(i)[0], p[1] + shift(i)[1]]).collect();
    let of_cells = |name: &str| mesh.cell_arrays.iter().find(|array| array.0 == name).map_or(&[][..], |array| &array.1);
    let [elements, materials] = ["ELEMENT", "MATERIAL"].map(|name| of_cells(name).iter().map(|v| *v as i32).collect());
    let deleted = of_cells(BLANKING).iter().map(|v| *v != 0.0).collect();
    let cells = mesh.cells.into_iter().map(around).collect();
    Ok(FrameData { time, points: places, cells, deleted, elements, materials, scalars })
}

fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    let tag = &tag[..tag.find('>')?];
    tag.split_once(&format!(" {name}=\""))?.1.split('"').next()
}

fn unescape(text: &str) -> String {
    text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&amp;", "&")
}

/// Splits an array into scalars: a vector into magnitude and two components, a stress into its components and the Mises
/// stress.
fn split(name: &str, values: &[f64], count: usize, text: &str) -> Vec<(String, Vec<f64>)> {
    let parts = values.len().checked_div(count).unwrap_or(0);
    if parts == 0 || values.len() != parts * count {
        return Vec::new();
    }
    if parts == 1 {
        return vec![(name.to_owned(), values.to_vec())];
    }
    let component = |i: usize| values.iter().skip(i).step_by(parts).copied().collect::<Vec<f64>>();
    let names = component_names(name, parts, text);
    if parts == 3 {
        let magnitude = values.chunks_exact(3).map(|v| libm::hypot(v[0], v[1])).collect();
        let [first, second, _] = <[String; 3]>::try_from(names).unwrap_or_default();
        return vec![(format!("|{name}|"), magnitude), (first, component(0)), (second, component(1))];
    }
    let mut scalars: Vec<_> = names.into_iter().enumerate().map(|(i, n)| (n, component(i))).collect();
    // The last two components of a symmetric tensor are zero in axisymmetric models.
    scalars.truncate(if parts == 6 { 4 } else { parts });
    if name == Variable::Stress.name() && scalars.len() == 4 {
        let stresses = values.chunks_exact(parts);
        scalars.insert(0, ("S_MISES".into(), stresses.map(|s| mises([s[0], s[1], s[2], s[3]])).collect()));
    }
    scalars
}

/// Returns the component names of the file, or numbered names.
fn component_names(name: &str, parts: usize, text: &str) -> Vec<String> {
    let tag = text.split("<DataArray").find(|t| attribute(t, "Name").is_some_and(|n| unescape(n) == name));
    let named = |i: usize| tag.and_then(|t| attribute(t, &format!("ComponentName{i}"))).map(unescape);
    (0..parts).map(|i| named(i).unwrap_or_else(|| format!("{name}{}", i + 1))).collect()
}

/// Returns the sort rank of a field: the most common fields come first.
pub fn rank(name: &str) -> usize {
    const FIRST: [&str; 9] = ["S_MISES", "MISES", "PEEQ", "PRESSURE", "|V|", "V2", "|U|", "TEMP", "STATUS"];
    FIRST.iter().position(|f| *f == name).unwrap_or(FIRST.len())
}

/// Packs a series of frames; `notes` receives remarks on omitted data.
pub fn pack(
    files: &[(f64, PathBuf)],
    scene: &Value,
    (units, sums): (&UnitNames, &Checksums),
    notes: &mut Vec<String>,
) -> Result<Option<MeridianFrames>, String> {
    let Some(((time, path), _)) = files.split_first() else { return Ok(None) };
    let first = read(*time, path, sums)?;
    let mesh = drawn(&first.points, &first.cells, CELLS);
    if mesh.corners.is_empty() {
        notes.push("the frames contain nothing to draw".into());
        return Ok(None);
    }
    if mesh.cells.len() < first.cells.iter().filter(|c| c.len() > 1).count() {
        notes.push(format!("the mesh is drawn coarser, with {} of {} cells", mesh.cells.len(), first.cells.len()));
    }
    let fields = chosen_fields(&first, notes);
    let frame_limit = FRAMES.min(BYTES / bytes_of_frame(&mesh, &fields)).max(2);
    let chosen = spread(files.len(), frame_limit);
    if chosen.len() < files.len() {
        notes.push(format!("{} of {} frames are shown", chosen.len(), files.len()));
    }
    let mut frames = vec![DrawnFrame::of(&first, &mesh, &fields)];
    for &i in &chosen[1..] {
        let frame = read(files[i].0, &files[i].1, sums)?;
        if !is_same_mesh(&first, &frame) {
            notes.push(format!("the frame at time {:e} has a different mesh and is not shown", frame.time));
            continue;
        }
        frames.push(DrawnFrame::of(&frame, &mesh, &fields));
    }
    let mut meridian = meridian(&frames, &mesh, &fields, scene);
    let number = |&cell: &usize| first.elements.get(cell).copied().unwrap_or(0);
    meridian.elements = mesh.cells.iter().map(number).collect();
    meridian.units = units.length_and_time();
    meridian.fields.iter_mut().for_each(|field| field.unit = units.of_column(&field.name));
    Ok(Some(meridian))
}

/// Returns whether a field on cells belongs to the facets of rigid bodies; the others belong to elements.
pub fn is_facet_field(name: &str) -> bool {
    ["PRESSURE", "NORMAL_VELOCITY", "LAYER"].contains(&name)
}

/// Returns whether a frame has the mesh of the first frame; the cells of deleted elements, collapsed to a point, are
/// ignored.
pub fn is_same_mesh(first: &FrameData, frame: &FrameData) -> bool {
    let gone = |cell: usize| frame.deleted.get(cell).copied().unwrap_or(false);
    let mut cells = first.cells.iter().zip(&frame.cells).enumerate();
    let alike = cells.all(|(i, (a, b))| a == b || gone(i) && a.len() == b.len());
    alike && first.cells.len() == frame.cells.len() && first.points.len() == frame.points.len()
}

/// Chooses the fields that are packed: name, and whether on cells.
fn chosen_fields(first: &FrameData, notes: &mut Vec<String>) -> Vec<(String, bool)> {
    let has_mises = first.scalars.iter().any(|s| s.name == "MISES");
    let shown_scalars = first.scalars.iter().filter(|s| !(has_mises && s.name == "S_MISES"));
    let mut fields: Vec<(String, bool)> = shown_scalars.map(|s| (s.name.clone(), s.on_cells)).collect();
    fields.sort_by_key(|f| rank(&f.0));
    if fields.len() > FIELDS {
        let left_out: Vec<&str> = fields[FIELDS..].iter().map(|f| f.0.as_str()).collect();
        notes.push(format!("fields that are not shown: {}", left_out.join(", ")));
        fields.truncate(FIELDS);
    }
    fields
}

/// Returns the size of a frame in bytes; base64 needs four bytes for three.
fn bytes_of_frame(mesh: &DrawnMesh, fields: &[(String, bool)]) -> usize {
    let numbers = |f: &(String, bool)| if f.1 { mesh.cells.len() } else { mesh.points.len() };
    let number_count = 2 * mesh.points.len() + fields.iter().map(numbers).sum::<usize>();
    (number_count * 2 * 4 / 3).max(1)
}

/// Returns at most `most` of `count` indices, equally spaced, including the first and the last.
pub fn spread(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    (0..most).map(|i| i * (count - 1) / (most - 1)).collect()
}

/// Values of a frame on the drawn mesh.
struct DrawnFrame {
    time: f64,
    points: Vec<[f64; 2]>,
    values: Vec<Vec<f64>>,
}

impl DrawnFrame {
    fn of(frame: &FrameData, mesh: &DrawnMesh, fields: &[(String, bool)]) -> DrawnFrame {
        let values = |(name, on_cells): &(String, bool)| {
            let values = frame.values(name, *on_cells).unwrap_or_default();
            let places = if *on_cells { &mesh.cells } else { &mesh.points };
            let value_at = |p: &usize| values.get(*p).copied().unwrap_or(f64::NAN);
            places.iter().map(value_at).collect()
        };
        let points = mesh.points.iter().map(|&p| frame.points[p]).collect();
        DrawnFrame { time: frame.time, points, values: fields.iter().map(values).collect() }
    }
}

fn meridian(frames: &[DrawnFrame], mesh: &DrawnMesh, fields: &[(String, bool)], scene: &Value) -> MeridianFrames {
    let all_points: Vec<[f64; 2]> = frames.iter().flat_map(|f| &f.points).copied().collect();
    let [low, high] = bounds(&all_points);
    let places = all_points.iter().flat_map(|p| [0, 1].map(|i| scale(p[i], low[i], high[i])));
    // Six-node triangles are drawn by their corners.
    let step = |c: &[usize]| if c.len() == 6 { 2 } else { 1 };
    let corners = mesh.corners.iter().flat_map(|c| (0..4).map(move |i| c.get(step(c) * i).map_or(NONE, |&p| p as u16)));
    let mut packed = Vec::new();
    for (i, (name, on_cells)) in fields.iter().enumerate() {
        let mut values: Vec<Vec<f64>> = frames.iter().map(|f| f.values[i].clone()).collect();
        if *on_cells {
            hide_foreign_zeros(&mut values, mesh);
        }
        packed.extend(field(name, *on_cells, &values));
    }
    MeridianFrames {
        times: frames.iter().map(|f| f.time).collect(),
        points: mesh.points.len(),
        bounds: [low[0], high[0], low[1], high[1]],
        places: base64(places),
        cells: mesh.cells.len(),
        corners: base64(corners),
        fields: packed,
        scene: scene.clone(),
        ..MeridianFrames::default()
    }
}

/// Replaces the zeros of element variables on rigid facets, and of facet variables on deformable elements, by "none".
fn hide_foreign_zeros(values: &mut [Vec<f64>], mesh: &DrawnMesh) {
    let lines: Vec<bool> = mesh.corners.iter().map(|c| c.len() == 2).collect();
    let silent = |kind: bool| {
        let of_kind = |frame: &Vec<f64>| frame.iter().zip(&lines).all(|(v, l)| *l != kind || *v == 0.0);
        values.iter().all(of_kind)
    };
    let (lines_silent, areas_silent) = (silent(true), silent(false));
    if lines_silent == areas_silent {
        return;
    }
    for (value, line) in values.iter_mut().flat_map(|frame| frame.iter_mut().zip(&lines)) {
        if *line == lines_silent {
            *value = f64::NAN;
        }
    }
}

/// Packs a field; `None` if it has no finite value.
fn field(name: &str, on_cells: bool, frames: &[Vec<f64>]) -> Option<PackedField> {
    let finite = || frames.iter().flatten().copied().filter(|v| v.is_finite());
    let (mut low, mut high) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
    if name == Variable::Status.name() && low <= high {
        // The page hides cells below the middle of the range, also if all elements have the same status.
        (low, high) = (0.0, 1.0);
    }
    let values = base64(frames.iter().flatten().map(|v| scale(*v, low, high)));
    (low <= high).then(|| PackedField { name: name.to_owned(), on_cells, low, high, unit: String::new(), values })
}

/// Scales a value to 65535 steps between `low` and `high`.
fn scale(value: f64, low: f64, high: f64) -> u16 {
    if !value.is_finite() {
        return NONE;
    }
    let part = if high > low { (value - low) / (high - low) } else { 0.0 };
    (part * f64::from(NONE - 1)).round() as u16
}

fn base64(numbers: impl Iterator<Item = u16>) -> String {
    STANDARD.encode(numbers.flat_map(u16::to_le_bytes).collect::<Vec<u8>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_spread_from_the_first_to_the_last() {
        assert_eq!(spread(3, 60), [0, 1, 2]);
        assert_eq!(spread(101, 5), [0, 25, 50, 75, 100]);
    }

    #[test]
    fn stress_gives_mises_stress() {
        let split = split("S", &[300.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 100.0], 2, "");
        assert_eq!(split[0].0, "S_MISES");
        assert!((split[0].1[0] - 300.0).abs() < 1e-12, "uniaxial");
        assert!((split[0].1[1] - 100.0 * 3.0_f64.sqrt()).abs() < 1e-12, "shear");
        assert_eq!(split[4], ("S4".to_owned(), vec![0.0, 100.0]));
    }

    #[test]
    fn values_are_scaled_to_integer_steps() {
        assert_eq!([scale(1.0, 1.0, 3.0), scale(2.0, 1.0, 3.0), scale(3.0, 1.0, 3.0)], [0, 32767, 65534]);
        assert_eq!([scale(f64::NAN, 0.0, 1.0), scale(5.0, 5.0, 5.0)], [NONE, 0]);
    }
}
