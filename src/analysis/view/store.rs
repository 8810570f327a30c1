//! Frames of a run in the form in which a page receives them: numbers of 32 bits. The most recently used frames are kept
//! in memory.

use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::http::Refusal;
use crate::output::sums::Checksums;
use crate::report::frame_mesh::FrameMesh;
use crate::report::frames::{FrameData, ScalarField, is_facet_field, rank, read_arrays};
use crate::variables::Variable;

/// Largest size of the frames in memory, in bytes.
const MEMORY: usize = 256 << 20;

/// Scalar field of a run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ViewField {
    pub name: String,
    pub on_cells: bool,
    /// Array of the file from which it is made.
    array: String,
}

/// Mesh of one frame or more.
#[derive(Default)]
pub struct ViewMesh {
    /// Index of a frame that has this mesh.
    id: usize,
    mesh: FrameMesh,
}

impl ViewMesh {
    /// Returns the number of points, the number of cells, four corners of each cell, its element number and its material
    /// number, as integers of 32 bits.
    pub fn bytes(&self) -> Vec<u8> {
        let FrameMesh { points, nodes: _, corners, elements, materials } = &self.mesh;
        let counts = [*points as u32, corners.len() as u32];
        let labels = elements.iter().chain(materials).map(|label| *label as u32);
        counts.into_iter().chain(corners.iter().flatten().copied()).chain(labels).flat_map(u32::to_le_bytes).collect()
    }

    /// Returns the cell with the element of a cell of another mesh; `None` if this mesh does not have the element.
    fn cell_of_element(&self, other: &ViewMesh, cell: usize) -> Option<usize> {
        let element = *other.mesh.elements.get(cell)?;
        if self.id == other.id {
            return Some(cell);
        }
        // Meshes often have the element in the same cell.
        let has_element = |cell: &usize| element != 0 && self.mesh.elements.get(*cell) == Some(&element);
        std::iter::once(cell).chain(0..self.mesh.elements.len()).find(has_element)
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
    mesh: Arc<ViewMesh>,
    shape: Arc<FrameShape>,
    /// Values by the index of the field; empty if the frame does not have it.
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
    /// Number of the run in this folder.
    generation: u64,
    files: Vec<(f64, PathBuf)>,
    sums: Arc<Checksums>,
    /// Arrays of the frames that have been read.
    arrays: Vec<String>,
    /// Fields of the arrays. Their order does not change, because pages know them by index.
    fields: Vec<ViewField>,
    kept: HashMap<usize, KeptFrame>,
    uses: u64,
}

/// File of a frame, and the checksums of its folder.
struct FrameFile {
    time: f64,
    path: PathBuf,
    sums: Arc<Checksums>,
}

impl FrameFile {
    /// Reads the frame with the arrays whose names `wanted` accepts.
    fn read(&self, wanted: &dyn Fn(&str) -> bool) -> Result<FrameData, Refusal> {
        read_arrays(self.time, &self.path, &self.sums, wanted).map_err(|why| Refusal::new(500, why))
    }
}

impl Series {
    fn file(&self, index: usize) -> Result<FrameFile, Refusal> {
        let (time, path) = self.files.get(index).cloned().ok_or_else(|| absent("frame"))?;
        Ok(FrameFile { time, path, sums: self.sums.clone() })
    }

    /// Removes the frames that have not been used for the longest time, until the others fit into memory with their
    /// meshes.
    fn forget(&mut self) {
        while self.bytes() > MEMORY && self.kept.len() > 1 {
            let Some(oldest) = self.kept.iter().min_by_key(|kept| kept.1.used).map(|kept| *kept.0) else { return };
            self.kept.remove(&oldest);
        }
    }

    fn bytes(&self) -> usize {
        let meshes = self.meshes();
        let of_meshes: usize = meshes.values().map(|mesh| mesh.mesh.bytes()).sum();
        of_meshes + self.kept.values().map(KeptFrame::bytes).sum::<usize>()
    }

    /// Returns the meshes of the frames in memory by their number.
    fn meshes(&self) -> BTreeMap<usize, Arc<ViewMesh>> {
        self.kept.values().map(|kept| (kept.mesh.id, kept.mesh.clone())).collect()
    }

    /// Adds the arrays and fields of a frame that no other frame had.
    fn add_fields(&mut self, data: &FrameData) {
        let is_new = |scalar: &&ScalarField| !self.arrays.contains(&scalar.array);
        let scalars: Vec<&ScalarField> = data.scalars.iter().filter(is_new).collect();
        self.arrays.extend(scalars.iter().map(|scalar| scalar.array.clone()));
        let has_mises = self.arrays.iter().any(|array| array == "MISES");
        let is_shown = |name: &str| name != Variable::Status.name() && !(has_mises && name == "S_MISES");
        let mut fields: Vec<ViewField> = scalars
            .into_iter()
            .filter(|scalar| is_shown(&scalar.name))
            .map(|s| ViewField { name: s.name.clone(), on_cells: s.on_cells, array: s.array.clone() })
            .collect();
        fields.sort_by_key(|field| rank(&field.name));
        self.fields.extend(fields);
    }
}

/// Frames of a run.
#[derive(Default)]
pub struct FrameStore {
    series: Mutex<Series>,
    /// Held while a file is read, so that a view uses at most one processor.
    reading: Mutex<()>,
}

/// Frame for a page: mesh, shape, values of a field, and the time to read the file.
pub struct ViewFrame {
    pub mesh: Arc<ViewMesh>,
    pub shape: Arc<FrameShape>,
    pub values: Option<Arc<Vec<f32>>>,
    pub reading: Duration,
}

impl ViewFrame {
    /// Returns the number of the mesh, the numbers of coordinates, values and hidden cells, then these, with or without the
    /// shape.
    pub fn bytes(&self, with_shape: bool) -> Vec<u8> {
        let empty = FrameShape::default();
        let shape = if with_shape { &*self.shape } else { &empty };
        let values = self.values.as_ref().map_or(&[][..], |values| values);
        let counts = [self.mesh.id, shape.positions.len(), values.len(), shape.hidden.len()].map(|n| n as u32);
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

    /// Returns the fields of the frames that have been read; reads the first frame if there is none.
    ///
    /// # Errors
    /// If there is no frame, or it cannot be read.
    pub fn fields(&self) -> Result<Vec<ViewField>, Refusal> {
        if self.lock().arrays.is_empty() {
            self.frame(0, None)?;
        }
        Ok(self.lock().fields.clone())
    }

    /// Returns the number of fields of the frames that have been read.
    pub fn field_count(&self) -> usize {
        self.lock().fields.len()
    }

    /// Returns a frame with the values of a field.
    ///
    /// # Errors
    /// If the frame or field does not exist, or the file cannot be read.
    pub fn frame(&self, index: usize, field: Option<usize>) -> Result<ViewFrame, Refusal> {
        if let Some(frame) = self.kept(index, field) {
            return Ok(frame);
        }
        let begin = Instant::now();
        let _one = self.reading.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(frame) = self.kept(index, field) {
            return Ok(frame);
        }
        let (data, generation) = self.read(index, field)?;
        self.keep(index, field, data, generation);
        let stored_frame = self.kept(index, field).ok_or_else(|| absent("frame"))?;
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
        Some(ViewFrame { mesh: stored.mesh.clone(), shape: stored.shape.clone(), values, reading: Duration::ZERO })
    }

    /// Reads a frame with a field, and with arrays that no other frame had. Returns it with the generation of the run.
    fn read(&self, index: usize, field: Option<usize>) -> Result<(FrameData, u64), Refusal> {
        let (file, generation, arrays, array) = {
            let series = self.lock();
            let array = match field {
                Some(field) => Some(series.fields.get(field).ok_or_else(|| absent("field"))?.array.clone()),
                None => None,
            };
            (series.file(index)?, series.generation, series.arrays.clone(), array)
        };
        let is_needed = |name: &str| {
            let is_known = arrays.iter().any(|array| array == name);
            name == Variable::Status.name() || array.as_deref() == Some(name) || !is_known
        };
        Ok((file.read(&is_needed)?, generation))
    }

    /// Keeps the mesh and shape of a frame, and its fields that have been read, unless the run has been restarted.
    fn keep(&self, index: usize, field: Option<usize>, mut data: FrameData, generation: u64) {
        let (meshes, fields) = {
            let mut series = self.lock();
            if series.generation != generation {
                return;
            }
            series.add_fields(&data);
            (series.meshes(), series.fields.clone())
        };
        let known = meshes.into_values().find(|mesh| mesh.mesh.complete(&mut data));
        let mesh = known.unwrap_or_else(|| Arc::new(ViewMesh { id: index, mesh: FrameMesh::of(&data) }));
        let shape = Arc::new(shape(&mesh.mesh, &data));
        let mut values: HashMap<usize, Arc<Vec<f32>>> = HashMap::new();
        values.extend(field.map(|field| (field, Arc::default())));
        let of_fields = fields.iter().enumerate();
        values.extend(of_fields.filter_map(|(i, field)| Some((i, Arc::new(numbers(&mesh.mesh, field, &data)?)))));
        let mut series = self.lock();
        if series.generation != generation {
            return;
        }
        series.uses += 1;
        let uses = series.uses;
        let stored = series.kept.entry(index).or_default();
        (stored.mesh, stored.shape, stored.used) = (mesh, shape, uses);
        stored.values.extend(values);
        series.forget();
    }

    /// Returns the values of a field in successive frames at the element of a cell of a mesh; those of points are averaged.
    /// Then a byte for each frame: 1 if its mesh has the element, else 0.
    ///
    /// # Errors
    /// If a frame, field or cell does not exist, or a file cannot be read.
    pub fn trace(
        &self,
        (mesh, cell): (usize, usize),
        field: usize,
        frames: std::ops::Range<usize>,
    ) -> Result<Vec<u8>, Refusal> {
        let picked_mesh = self.frame(mesh, None)?.mesh;
        if cell >= picked_mesh.mesh.corners.len() {
            return Err(absent("cell"));
        }
        let on_cells = self.lock().fields.get(field).ok_or_else(|| absent("field"))?.on_cells;
        let (mut values, mut has_element) = (Vec::new(), Vec::new());
        for index in frames {
            let frame = self.frame(index, Some(field))?;
            let cell = frame.mesh.cell_of_element(&picked_mesh, cell);
            let value = |cell: usize| {
                let is_hidden = frame.shape.hidden.get(cell).is_some_and(|hidden| *hidden != 0);
                let values = frame.values.as_ref().filter(|_| !is_hidden)?;
                value_at(on_cells, &frame.mesh.mesh, cell, values)
            };
            values.extend(cell.and_then(value).unwrap_or(f32::NAN).to_le_bytes());
            has_element.push(u8::from(cell.is_some()));
        }
        Ok([values, has_element].concat())
    }

    /// Returns the values of all fields at a cell in a frame.
    ///
    /// # Errors
    /// If the frame or cell does not exist, or the file cannot be read.
    pub fn state(&self, cell: usize, index: usize) -> Result<Vec<(String, f32)>, Refusal> {
        let fields = self.fields()?;
        let file = self.lock().file(index)?;
        let mesh = &self.frame(index, None)?.mesh.mesh;
        let _one = self.reading.lock().unwrap_or_else(PoisonError::into_inner);
        let mut data = file.read(&|_| true)?;
        mesh.complete(&mut data);
        if cell >= mesh.corners.len() {
            return Err(absent("cell"));
        }
        let value = |field: &ViewField| {
            let value = value_at(field.on_cells, mesh, cell, &numbers(mesh, field, &data)?)?;
            value.is_finite().then(|| (field.name.clone(), value))
        };
        Ok(fields.iter().filter_map(value).collect())
    }
}

fn value_at(on_cells: bool, mesh: &FrameMesh, cell: usize, values: &[f32]) -> Option<f32> {
    if on_cells {
        return values.get(cell).copied();
    }
    let corners = mesh.corners_of(cell).map(|point| values.get(point).copied());
    let corner_values: Vec<f32> = corners.collect::<Option<_>>()?;
    Some(corner_values.iter().sum::<f32>() / corner_values.len() as f32)
}

/// Returns the values of a field. Element variables are zero on the facets of rigid bodies, and facet variables on
/// elements: these are no values.
fn numbers(mesh: &FrameMesh, field: &ViewField, data: &FrameData) -> Option<Vec<f32>> {
    let of_facets = is_facet_field(&field.name);
    let belongs = |cell: usize| !field.on_cells || mesh.is_line(cell) == of_facets;
    let value = |(i, value): (usize, &f64)| if belongs(i) { *value as f32 } else { f32::NAN };
    Some(data.values(&field.name, field.on_cells)?.iter().enumerate().map(value).collect())
}

fn shape(mesh: &FrameMesh, data: &FrameData) -> FrameShape {
    let status = data.values(Variable::Status.name(), true);
    let is_deleted = |cell: usize| {
        let by_status = status.and_then(|values| values.get(cell)).is_some_and(|status| *status < 0.5);
        data.deleted.get(cell).copied().unwrap_or(false) || by_status && mesh.corners_of(cell).count() > 2
    };
    let hidden: Vec<u8> = (0..mesh.corners.len()).map(|cell| u8::from(is_deleted(cell))).collect();
    let hidden = if hidden.contains(&1) { hidden } else { Vec::new() };
    FrameShape { positions: data.points.iter().flatten().map(|x| *x as f32).collect(), hidden }
}
