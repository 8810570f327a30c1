//! Frames of a run in the form in which a page receives them: numbers of 32 bits. The most recently used frames are kept
//! in memory.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::http::Refusal;
use crate::output::sums::Checksums;
use crate::report::frames::{FrameData, ScalarField, is_facet_field, is_same_mesh, rank, read_arrays};
use crate::variables::Variable;

/// Largest size of the frames in memory, in bytes.
const MEMORY: usize = 256 << 20;
/// Corner that a cell does not have.
const NONE: u32 = u32::MAX;

/// Scalar field of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ViewField {
    pub name: String,
    pub on_cells: bool,
    /// Array of the file from which it is made.
    array: String,
}

/// What all frames have in common.
pub struct ViewMesh {
    /// First frame, without fields.
    first: FrameData,
    pub fields: Vec<ViewField>,
}

impl ViewMesh {
    fn of(data: &FrameData) -> ViewMesh {
        let field = |scalar: &ScalarField| ViewField {
            name: scalar.name.clone(),
            on_cells: scalar.on_cells,
            array: scalar.array.clone(),
        };
        let mut fields: Vec<ViewField> = data.scalars.iter().map(field).collect();
        let has_mises = fields.iter().any(|f| f.name == "MISES");
        fields.retain(|f| f.name != Variable::Status.name() && !(has_mises && f.name == "S_MISES"));
        fields.sort_by_key(|f| rank(&f.name));
        let (points, cells) = (data.points.clone(), data.cells.clone());
        let (elements, materials) = (data.elements.clone(), data.materials.clone());
        let first = FrameData { time: data.time, points, cells, elements, materials, ..FrameData::default() };
        ViewMesh { first, fields }
    }

    /// Returns the number of points, the number of cells, four corners of each cell, its element number and its material
    /// number, as integers of 32 bits.
    pub fn bytes(&self) -> Vec<u8> {
        let cells = &self.first.cells;
        let counts = [self.first.points.len() as u32, cells.len() as u32];
        // Six-node triangles are drawn by their corners; a point is not drawn.
        let step = |cell: &[usize]| if cell.len() == 6 { 2 } else { 1 };
        let corner = |cell: &[usize], i: usize| cell.get(step(cell) * i).map_or(NONE, |&p| p as u32);
        let corners =
            cells.iter().flat_map(|cell| (0..4).map(move |i| if cell.len() < 2 { NONE } else { corner(cell, i) }));
        let labels =
            |list: &[i32]| (0..cells.len()).map(|i| list.get(i).copied().unwrap_or(0) as u32).collect::<Vec<_>>();
        let (elements, materials) = (labels(&self.first.elements), labels(&self.first.materials));
        counts.into_iter().chain(corners).chain(elements).chain(materials).flat_map(u32::to_le_bytes).collect()
    }
}

/// Positions and deleted elements of a frame.
#[derive(Debug, Default)]
pub struct FrameShape {
    /// r and z of each point.
    positions: Vec<f32>,
    /// Whether each cell is hidden; empty if none is.
    hidden: Vec<u8>,
}

#[derive(Default)]
struct KeptFrame {
    shape: Arc<FrameShape>,
    /// Values by the index of the field.
    values: HashMap<usize, Arc<Vec<f32>>>,
    used: u64,
}

impl KeptFrame {
    fn bytes(&self) -> usize {
        let values: usize = self.values.values().map(|values| 4 * values.len()).sum();
        4 * self.shape.positions.len() + self.shape.hidden.len() + values
    }
}

#[derive(Default)]
struct Series {
    /// Number of the run in this folder: a restarted run has another mesh.
    generation: u64,
    files: Vec<(f64, PathBuf)>,
    sums: Arc<Checksums>,
    mesh: Option<Arc<ViewMesh>>,
    kept: HashMap<usize, KeptFrame>,
    uses: u64,
}

impl Series {
    /// Removes the frames that have not been used for the longest time, until the others fit into memory.
    fn forget(&mut self) {
        let mut bytes: usize = self.kept.values().map(KeptFrame::bytes).sum();
        while bytes > MEMORY && self.kept.len() > 1 {
            let Some(oldest) = self.kept.iter().min_by_key(|kept| kept.1.used).map(|kept| *kept.0) else { return };
            bytes -= self.kept.remove(&oldest).map_or(0, |kept| kept.bytes());
        }
    }
}

/// Frames of a run.
#[derive(Default)]
pub struct FrameStore {
    series: Mutex<Series>,
    /// Held while a file is read, so that a view uses at most one processor.
    reading: Mutex<()>,
}

/// Frame for a page: shape, values of a field, and the time to read the file.
pub struct ViewFrame {
    pub shape: Arc<FrameShape>,
    pub values: Option<Arc<Vec<f32>>>,
    pub reading: Duration,
}

impl ViewFrame {
    /// Returns the numbers of coordinates, hidden cells and values, then these, with or without the shape.
    pub fn bytes(&self, with_shape: bool) -> Vec<u8> {
        let empty = FrameShape::default();
        let shape = if with_shape { &*self.shape } else { &empty };
        let values = self.values.as_ref().map_or(&[][..], |values| values);
        let counts = [shape.positions.len(), values.len(), shape.hidden.len()].map(|n| n as u32);
        let mut bytes: Vec<u8> = counts.into_iter().flat_map(u32::to_le_bytes).collect();
        bytes.extend(shape.positions.iter().chain(values).flat_map(|v| v.to_le_bytes()));
        bytes.extend_from_slice(&shape.hidden);
        bytes
    }
}

fn absent(what: &str) -> Refusal {
    Refusal::new(404, format!("the {what} does not exist"))
}

impl FrameStore {
    fn lock(&self) -> MutexGuard<'_, Series> {
        self.series.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes the list of frames of a run; `is_restarted` if an earlier run had other frames. Returns the generation.
    pub fn set_files(&self, files: Vec<(f64, PathBuf)>, sums: Arc<Checksums>, is_restarted: bool) -> u64 {
        let mut series = self.lock();
        if is_restarted {
            *series = Series { generation: series.generation + 1, ..Series::default() };
        }
        (series.files, series.sums) = (files, sums);
        series.generation
    }

    /// Returns the mesh of the first frame.
    ///
    /// # Errors
    /// If there is no frame, or it cannot be read.
    pub fn mesh(&self) -> Result<Arc<ViewMesh>, Refusal> {
        let mesh = self.lock().mesh.clone();
        if let Some(mesh) = mesh {
            return Ok(mesh);
        }
        let _one = self.reading.lock().unwrap_or_else(PoisonError::into_inner);
        let (data, generation) = self.read(0, "first frame", &|_| true)?;
        let mesh = Arc::new(ViewMesh::of(&data));
        self.keep(&mesh, 0, &data, generation);
        let mut series = self.lock();
        if series.generation == generation {
            series.mesh = Some(mesh.clone());
        }
        Ok(mesh)
    }

    /// Returns a frame with the values of a field.
    ///
    /// # Errors
    /// If the frame or field does not exist, or the file cannot be read.
    pub fn frame(&self, index: usize, field: Option<usize>) -> Result<ViewFrame, Refusal> {
        let mesh = self.mesh()?;
        if field.is_some_and(|field| field >= mesh.fields.len()) {
            return Err(absent("field"));
        }
        if let Some(frame) = self.kept(index, field) {
            return Ok(frame);
        }
        let begin = Instant::now();
        let _one = self.reading.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(frame) = self.kept(index, field) {
            return Ok(frame);
        }
        let array = field.map(|field| mesh.fields[field].array.as_str());
        let is_needed = |name: &str| name == Variable::Status.name() || array == Some(name);
        let (data, generation) = self.read_alike(&mesh, index, &is_needed)?;
        self.keep(&mesh, index, &data, generation);
        let stored_frame = self.kept(index, field).ok_or_else(|| absent("field in this frame"))?;
        Ok(ViewFrame { reading: begin.elapsed(), ..stored_frame })
    }

    fn kept(&self, index: usize, field: Option<usize>) -> Option<ViewFrame> {
        let mut series = self.lock();
        series.uses += 1;
        let uses = series.uses;
        let stored = series.kept.get_mut(&index)?;
        stored.used = uses;
        let values = match field {
            Some(field) => Some(stored.values.get(&field)?.clone()),
            None => None,
        };
        Some(ViewFrame { shape: stored.shape.clone(), values, reading: Duration::ZERO })
    }

    /// Reads a frame and returns it with the generation of the run.
    fn read(&self, index: usize, what: &str, wanted: &dyn Fn(&str) -> bool) -> Result<(FrameData, u64), Refusal> {
        let (file, sums, generation) = {
            let series = self.lock();
            (series.files.get(index).cloned(), series.sums.clone(), series.generation)
        };
        let (time, path) = file.ok_or_else(|| absent(what))?;
        let data = read_arrays(time, &path, &sums, wanted).map_err(|why| Refusal::new(500, why))?;
        Ok((data, generation))
    }

    /// Reads a frame with the mesh of the first one.
    fn read_alike(
        &self,
        mesh: &ViewMesh,
        index: usize,
        wanted: &dyn Fn(&str) -> bool,
    ) -> Result<(FrameData, u64), Refusal> {
        let (data, generation) = self.read(index, "frame", wanted)?;
        if is_same_mesh(&mesh.first, &data) {
            return Ok((data, generation));
        }
        Err(Refusal::new(500, format!("the frame at time {:e} has a different mesh and is not shown", data.time)))
    }

    /// Keeps the shape of a frame, and its fields that have been read, unless the run has been restarted.
    fn keep(&self, mesh: &ViewMesh, index: usize, data: &FrameData, generation: u64) {
        let fields = mesh.fields.iter().enumerate();
        let read: Vec<_> = fields.filter_map(|(i, field)| Some((i, Arc::new(numbers(mesh, field, data)?)))).collect();
        let shape = shape(mesh, data);
        let mut series = self.lock();
        if series.generation != generation {
            return;
        }
        series.uses += 1;
        let uses = series.uses;
        let stored = series.kept.entry(index).or_default();
        (stored.shape, stored.used) = (Arc::new(shape), uses);
        stored.values.extend(read);
        series.forget();
    }

    /// Returns the values of a field at a cell in successive frames; those of points are averaged.
    ///
    /// # Errors
    /// If a frame, field or cell does not exist, or a file cannot be read.
    pub fn trace(&self, cell: usize, field: usize, frames: std::ops::Range<usize>) -> Result<Vec<u8>, Refusal> {
        let mesh = self.mesh()?;
        let corners = mesh.first.cells.get(cell).ok_or_else(|| absent("cell"))?;
        let mut bytes = Vec::new();
        for index in frames {
            let frame = self.frame(index, Some(field))?;
            let values = frame.values.as_ref().ok_or_else(|| absent("field"))?;
            let hidden = frame.shape.hidden.get(cell).is_some_and(|hidden| *hidden != 0);
            let value = if hidden { None } else { value_at(&mesh.fields[field], corners, cell, values) };
            bytes.extend(value.unwrap_or(f32::NAN).to_le_bytes());
        }
        Ok(bytes)
    }

    /// Returns the values of all fields at a cell in a frame.
    ///
    /// # Errors
    /// If the frame or cell does not exist, or the file cannot be read.
    pub fn state(&self, cell: usize, index: usize) -> Result<Vec<(String, f32)>, Refusal> {
        let mesh = self.mesh()?;
        let corners = mesh.first.cells.get(cell).ok_or_else(|| absent("cell"))?;
        let _one = self.reading.lock().unwrap_or_else(PoisonError::into_inner);
        let (data, _) = self.read_alike(&mesh, index, &|_| true)?;
        let value = |field: &ViewField| {
            let value = value_at(field, corners, cell, &numbers(&mesh, field, &data)?)?;
            value.is_finite().then(|| (field.name.clone(), value))
        };
        Ok(mesh.fields.iter().filter_map(value).collect())
    }
}

fn value_at(field: &ViewField, corners: &[usize], cell: usize, values: &[f32]) -> Option<f32> {
    if field.on_cells {
        return values.get(cell).copied();
    }
    let sum: f32 = corners.iter().filter_map(|&p| values.get(p)).sum();
    Some(sum / corners.len() as f32)
}

/// Returns the values of a field. Element variables are zero on the facets of rigid bodies, and facet variables on
/// elements: these are no values.
fn numbers(mesh: &ViewMesh, field: &ViewField, data: &FrameData) -> Option<Vec<f32>> {
    let of_facets = is_facet_field(&field.name);
    let belongs = |cell: usize| !field.on_cells || (mesh.first.cells[cell].len() == 2) == of_facets;
    let value = |(i, value): (usize, &f64)| if belongs(i) { *value as f32 } else { f32::NAN };
    Some(data.values(&field.name, field.on_cells)?.iter().enumerate().map(value).collect())
}

fn shape(mesh: &ViewMesh, data: &FrameData) -> FrameShape {
    let status = data.values(Variable::Status.name(), true);
    let is_deleted = |cell: usize| {
        let by_status = status.and_then(|values| values.get(cell)).is_some_and(|status| *status < 0.5);
        data.deleted.get(cell).copied().unwrap_or(false) || by_status && mesh.first.cells[cell].len() > 2
    };
    let hidden: Vec<u8> = (0..mesh.first.cells.len()).map(|cell| u8::from(is_deleted(cell))).collect();
    let hidden = if hidden.contains(&1) { hidden } else { Vec::new() };
    FrameShape { positions: data.points.iter().flatten().map(|x| *x as f32).collect(), hidden }
}
