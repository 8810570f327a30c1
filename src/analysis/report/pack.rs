//! Packs the frames of a series for a report page, with fewer frames and coarser meshes if necessary.

use std::path::PathBuf;
use std::rc::Rc;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

use super::data::{MeridianFrames, PackedField, PackedMesh};
use super::frame_mesh::{FrameMesh, NO_CORNER, corners};
use super::frames::{self, FrameData, ScalarField, rank};
use super::mesh::{CELLS, DrawnMesh, bounds, drawn};
use super::units::UnitNames;
use crate::output::sums::Checksums;
use crate::variables::Variable;

/// Largest number of frames on a page.
pub const FRAMES: usize = 60;
/// Largest size of the packed frames of a run, in bytes.
pub const BYTES: usize = 6_000_000;
/// Largest number of fields of a run.
const FIELDS: usize = 20;
const NONE: u16 = u16::MAX;

/// Packs a series of frames; `notes` receives remarks on omitted data.
pub fn pack(
    files: &[(f64, PathBuf)],
    scene: &Value,
    (units, sums): (&UnitNames, &Checksums),
    notes: &mut Vec<String>,
) -> Result<Option<MeridianFrames>, String> {
    let Some(((time, path), _)) = files.split_first() else { return Ok(None) };
    let mut meshes = SeriesMeshes::default();
    let first = meshes.draw(frames::read(*time, path, sums)?);
    if first.mesh.drawn.corners.is_empty() {
        notes.push("the frames contain nothing to draw".into());
        return Ok(None);
    }
    let first_fields = chosen_fields(std::slice::from_ref(&first), &mut Vec::new());
    let frame_limit = FRAMES.min(BYTES / first.bytes(&first_fields)).max(2);
    let mut drawn_frames = vec![first];
    for &i in &spread(files.len(), frame_limit)[1..] {
        drawn_frames.push(meshes.draw(frames::read(files[i].0, &files[i].1, sums)?));
    }
    let coarsened = drawn_frames.iter().map(|frame| &frame.mesh).filter(|mesh| mesh.is_coarsened);
    if let Some(mesh) = coarsened.max_by_key(|mesh| mesh.cell_count) {
        let cells = mesh.drawn.cells.len();
        notes.push(format!("the mesh is drawn coarser, with {cells} of {} cells", mesh.cell_count));
    }
    let fields = chosen_fields(&drawn_frames, notes);
    let drawn_frames = within_size_limit(drawn_frames, &fields);
    if drawn_frames.len() < files.len() {
        notes.push(format!("{} of {} frames are shown", drawn_frames.len(), files.len()));
    }
    let mut meridian = meridian(&drawn_frames, &fields, scene);
    meridian.units = units.length_and_time();
    meridian.fields.iter_mut().for_each(|field| field.unit = units.of_column(&field.name));
    Ok(Some(meridian))
}

/// Returns at most `most` of `count` indices, equally spaced, including the first and the last.
pub fn spread(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    (0..most).map(|i| i * (count - 1) / (most - 1)).collect()
}

/// Mesh of successive frames, as it is drawn.
struct SeriesMesh {
    drawn: DrawnMesh,
    /// Element number of each drawn cell; 0 without one.
    elements: Vec<i32>,
    /// Number of cells in the files.
    cell_count: usize,
    is_coarsened: bool,
    /// Size on the page.
    bytes: usize,
}

impl SeriesMesh {
    fn of(frame: &FrameData, mesh: &FrameMesh) -> SeriesMesh {
        let drawn = drawn(&frame.points, &frame.cells, CELLS);
        let is_present = |cell: usize| !frame.deleted.get(cell).copied().unwrap_or(false);
        let visible = frame.cells.iter().enumerate().filter(|(i, cell)| cell.len() > 1 && is_present(*i)).count();
        let elements: Vec<i32> = drawn.cells.iter().map(|&cell| mesh.elements[cell]).collect();
        let digits: usize = elements.iter().map(|element| element.to_string().len() + 1).sum();
        SeriesMesh {
            cell_count: frame.cells.len(),
            is_coarsened: drawn.cells.len() < visible,
            bytes: base64_length(4 * drawn.cells.len()) + digits,
            elements,
            drawn,
        }
    }

    fn packed(&self) -> PackedMesh {
        let number = |corner: u32| if corner == NO_CORNER { NONE } else { corner as u16 };
        let corners = self.drawn.corners.iter().flat_map(|cell| corners(cell)).map(number);
        PackedMesh {
            points: self.drawn.points.len(),
            cells: self.drawn.cells.len(),
            corners: base64(corners),
            elements: self.elements.clone(),
        }
    }
}

/// The mesh of the frame that was read last. A mesh that has been replaced never returns.
#[derive(Default)]
struct SeriesMeshes {
    last: Option<(FrameMesh, Rc<SeriesMesh>)>,
}

impl SeriesMeshes {
    /// Returns the next frame of the series on its mesh.
    fn draw(&mut self, mut frame: FrameData) -> DrawnFrame {
        let (_, mesh) = match self.last.take() {
            Some(known) if known.0.complete(&mut frame) => self.last.insert(known),
            _ => {
                let mesh = FrameMesh::of(&frame);
                let drawn_mesh = Rc::new(SeriesMesh::of(&frame, &mesh));
                self.last.insert((mesh, drawn_mesh))
            }
        };
        DrawnFrame::of(frame, mesh)
    }
}

/// Name of a field, and whether it is on cells.
type FieldName = (String, bool);

/// Values of a frame on its drawn mesh.
struct DrawnFrame {
    time: f64,
    mesh: Rc<SeriesMesh>,
    points: Vec<[f64; 2]>,
    scalars: Vec<ScalarField>,
}

impl DrawnFrame {
    fn of(frame: FrameData, mesh: &Rc<SeriesMesh>) -> DrawnFrame {
        let DrawnMesh { points, cells, .. } = &mesh.drawn;
        let on_drawn = |scalar: ScalarField| {
            let places = if scalar.on_cells { cells } else { points };
            let values = places.iter().map(|&p| scalar.values.get(p).copied().unwrap_or(f64::NAN)).collect();
            ScalarField { values, ..scalar }
        };
        // The page hides the elements whose STATUS is 0.
        let status = if frame.values(Variable::Status.name(), true).is_none() { status(&frame.deleted) } else { None };
        DrawnFrame {
            time: frame.time,
            mesh: mesh.clone(),
            points: points.iter().map(|&p| frame.points[p]).collect(),
            scalars: frame.scalars.into_iter().chain(status).map(on_drawn).collect(),
        }
    }

    /// Returns the values of a field; `None` if the frame does not have it.
    fn values(&self, (name, on_cells): &FieldName) -> Option<&[f64]> {
        let scalar = self.scalars.iter().find(|scalar| scalar.name == *name && scalar.on_cells == *on_cells)?;
        Some(&scalar.values)
    }

    /// Returns the number of values of a field.
    fn count(&self, on_cells: bool) -> usize {
        if on_cells { self.mesh.drawn.cells.len() } else { self.mesh.drawn.points.len() }
    }

    /// Returns the size on the page in bytes, without its mesh.
    fn bytes(&self, fields: &[FieldName]) -> usize {
        let numbers = 2 * self.points.len() + fields.iter().map(|field| self.count(field.1)).sum::<usize>();
        base64_length(numbers).max(1)
    }

    fn is_line(&self, cell: usize) -> bool {
        self.mesh.drawn.corners[cell].len() == 2
    }
}

/// Returns the field STATUS of a frame that marks deleted elements in another way; `None` if none is deleted.
fn status(deleted: &[bool]) -> Option<ScalarField> {
    let values: Vec<f64> = deleted.iter().map(|is_deleted| f64::from(u8::from(!is_deleted))).collect();
    let name = Variable::Status.name().to_owned();
    (!values.is_empty()).then(|| ScalarField { array: name.clone(), name, on_cells: true, values })
}

/// Chooses the fields that are packed: those of all frames, the most common ones first.
fn chosen_fields(frames: &[DrawnFrame], notes: &mut Vec<String>) -> Vec<FieldName> {
    let mut fields: Vec<FieldName> = Vec::new();
    for scalar in frames.iter().flat_map(|frame| &frame.scalars) {
        if !fields.iter().any(|(name, on_cells)| *name == scalar.name && *on_cells == scalar.on_cells) {
            fields.push((scalar.name.clone(), scalar.on_cells));
        }
    }
    let has_mises = fields.iter().any(|field| field.0 == "MISES");
    fields.retain(|field| !(has_mises && field.0 == "S_MISES"));
    fields.sort_by_key(|field| rank(&field.0));
    if fields.len() > FIELDS {
        let left_out: Vec<&str> = fields[FIELDS..].iter().map(|f| f.0.as_str()).collect();
        notes.push(format!("fields that are not shown: {}", left_out.join(", ")));
        fields.truncate(FIELDS);
    }
    fields
}

/// Returns as many frames, equally spaced, as fit on the page with their meshes; the first and the last one at least.
fn within_size_limit(frames: Vec<DrawnFrame>, fields: &[FieldName]) -> Vec<DrawnFrame> {
    let bytes = |chosen: &[usize]| {
        // The limit does not count the mesh that every page has.
        let new_mesh = |pair: &[usize]| {
            let [last, next] = [&frames[pair[0]].mesh, &frames[pair[1]].mesh];
            if Rc::ptr_eq(last, next) { 0 } else { next.bytes }
        };
        let of_frames: usize = chosen.iter().map(|&i| frames[i].bytes(fields)).sum();
        of_frames + chosen.windows(2).map(new_mesh).sum::<usize>()
    };
    let choices = (2..=frames.len()).rev().map(|count| spread(frames.len(), count));
    let fitting = choices.into_iter().find(|chosen| chosen.len() == 2 || bytes(chosen) <= BYTES);
    let Some(chosen) = fitting else { return frames };
    frames.into_iter().enumerate().filter(|(i, _)| chosen.contains(i)).map(|(_, frame)| frame).collect()
}

fn meridian(frames: &[DrawnFrame], fields: &[FieldName], scene: &Value) -> MeridianFrames {
    let all_points: Vec<[f64; 2]> = frames.iter().flat_map(|f| &f.points).copied().collect();
    let [low, high] = bounds(&all_points);
    let places = all_points.iter().flat_map(|p| [0, 1].map(|i| scale(p[i], low[i], high[i])));
    let mut meshes = vec![frames[0].mesh.packed()];
    let mut mesh_of_frame = vec![0];
    for pair in frames.windows(2) {
        if !Rc::ptr_eq(&pair[0].mesh, &pair[1].mesh) {
            meshes.push(pair[1].mesh.packed());
        }
        mesh_of_frame.push(meshes.len() - 1);
    }
    let first = meshes.remove(0);
    if meshes.is_empty() {
        mesh_of_frame.clear();
    }
    MeridianFrames {
        times: frames.iter().map(|f| f.time).collect(),
        points: first.points,
        bounds: [low[0], high[0], low[1], high[1]],
        places: base64(places),
        cells: first.cells,
        corners: first.corners,
        fields: fields.iter().filter_map(|name| field(name, frames)).collect(),
        scene: scene.clone(),
        elements: first.elements,
        new_meshes: meshes,
        mesh_of_frame,
        ..MeridianFrames::default()
    }
}

/// Packs a field; `None` if it has no finite value. In frames without the field it has no values.
fn field(name: &FieldName, frames: &[DrawnFrame]) -> Option<PackedField> {
    let on_cells = name.1;
    let hidden_kind = if on_cells { foreign_kind(name, frames) } else { None };
    let values: Vec<f64> = frames
        .iter()
        .flat_map(|frame| {
            let values = frame.values(name);
            let is_hidden = move |i: usize| hidden_kind.is_some_and(|is_line| frame.is_line(i) == is_line);
            (0..frame.count(on_cells)).map(move |i| values.filter(|_| !is_hidden(i)).map_or(f64::NAN, |v| v[i]))
        })
        .collect();
    let finite = || values.iter().copied().filter(|v| v.is_finite());
    let (mut low, mut high) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
    if name.0 == Variable::Status.name() && low <= high {
        // The page hides cells below the middle of the range, also if all elements have the same status.
        (low, high) = (0.0, 1.0);
    }
    let packed = base64(values.iter().map(|v| scale(*v, low, high)));
    (low <= high).then(|| PackedField {
        name: name.0.clone(),
        on_cells,
        low,
        high,
        unit: String::new(),
        values: packed,
    })
}

/// Returns which cells a field on cells does not belong to: lines (`true`) for element variables, which are zero on the
/// facets of rigid bodies, or areas for facet variables.
fn foreign_kind(name: &FieldName, frames: &[DrawnFrame]) -> Option<bool> {
    let is_zero = |kind: bool| {
        frames.iter().all(|frame| {
            let values = frame.values(name).unwrap_or_default();
            values.iter().enumerate().all(|(cell, value)| frame.is_line(cell) != kind || *value == 0.0)
        })
    };
    let (lines_are_zero, areas_are_zero) = (is_zero(true), is_zero(false));
    (lines_are_zero != areas_are_zero).then_some(lines_are_zero)
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

/// Returns the length of packed numbers; base64 needs four bytes for three.
fn base64_length(numbers: usize) -> usize {
    numbers * 2 * 4 / 3
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
    fn values_are_scaled_to_integer_steps() {
        assert_eq!([scale(1.0, 1.0, 3.0), scale(2.0, 1.0, 3.0), scale(3.0, 1.0, 3.0)], [0, 32767, 65534]);
        assert_eq!([scale(f64::NAN, 0.0, 1.0), scale(5.0, 5.0, 5.0)], [NONE, 0]);
    }

    /// Returns frames of a square of one cell, each with a new element.
    fn squares(count: i32) -> Vec<DrawnFrame> {
        let square = |element: i32| FrameData {
            points: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
            cells: vec![vec![0, 1, 2, 3]],
            elements: vec![element],
            ..FrameData::default()
        };
        let mut meshes = SeriesMeshes::default();
        (1..=count).map(|element| meshes.draw(square(element))).collect()
    }

    #[test]
    fn meshes_count_for_the_size_limit() {
        let mut frames = squares(9);
        for frame in &mut frames {
            let mesh = SeriesMesh { bytes: BYTES / 4, ..SeriesMesh::of(&FrameData::default(), &FrameMesh::default()) };
            frame.mesh = Rc::new(mesh);
        }
        // The first mesh and three others.
        let elements = |frames: &[DrawnFrame]| frames.iter().map(|frame| frame.mesh.bytes).sum::<usize>();
        let fitting = within_size_limit(frames, &[]);
        assert_eq!((fitting.len(), elements(&fitting)), (4, BYTES));
        assert_eq!(within_size_limit(squares(9), &[]).len(), 9);
    }

    #[test]
    fn a_mesh_is_stored_once() {
        let frames = squares(3);
        let packed = meridian(&frames, &[], &Value::Null);
        assert_eq!((packed.elements, packed.new_meshes.len(), packed.mesh_of_frame), (vec![1], 2, vec![0, 1, 2]));
        let packed = meridian(&frames[..1], &[], &Value::Null);
        assert!(packed.new_meshes.is_empty() && packed.mesh_of_frame.is_empty());
    }

    #[test]
    fn deleted_elements_have_status_zero() {
        let deleted = status(&[false, true]).expect("a field");
        assert_eq!((&*deleted.name, deleted.on_cells, deleted.values), ("STATUS", true, vec![1.0, 0.0]));
        assert!(status(&[]).is_none());
    }
}
