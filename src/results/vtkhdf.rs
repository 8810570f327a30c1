//! VTKHDF files: all frames of a run in one HDF5 file (VTK File Formats, "VTKHDF", version 2.1, unstructured grid with
//! steps). VTK 9.5 and ParaView 6.0 or later read them.
//!
//! Each array is a dataset of rows of all frames; the group `Steps` has the first row of each frame. An array that is the
//! same as in the previous frame is not written again, so that the mesh of a run without element deletion is in the file
//! once. The last change of a frame is that of one address, which makes it visible: a killed process leaves the frames
//! before.

use std::io;
use std::path::Path;

use indexmap::IndexMap;
use sha2::{Digest as _, Sha256};

use super::hdf5::{Attribute, AttributeValue, Dataset, Element, Group, Hdf5File, RowType, Storage};
use super::{EntityLabels, FieldArray, FramePoints, OutputFrame};

/// Largest number of rows of a compressed chunk.
const MOST_ROWS: usize = 16384;
/// Rows of the chunks of the small lists in `Steps`.
const LISTED_ROWS: usize = 32;
/// Rows of the chunks of the lists of cells.
const CELL_ROWS: usize = 256;

/// Groups of the arrays over points and over cells, and of their first rows.
const PLACES: [[&str; 2]; 2] = [["PointData", "PointDataOffsets"], ["CellData", "CellDataOffsets"]];
/// List of the times of the steps.
const TIMES: &str = "Values";
/// Attribute with the number of steps.
const NUMBER: &str = "NSteps";
/// Numbers of each mesh, one row per mesh.
const COUNTS: [&str; 3] = ["NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"];
/// First rows of each step. Those of cells and connectivity have a second dimension.
const LISTS: [(&str, Option<usize>); 6] = [
    (TIMES, None),
    ("PartOffsets", None),
    ("NumberOfParts", None),
    ("PointOffsets", None),
    ("CellOffsets", Some(1)),
    ("ConnectivityIdOffsets", Some(1)),
];

/// Writer of a `.vtkhdf` file.
#[derive(Debug)]
pub struct VtkHdfWriter {
    file: Hdf5File,
    points: FramePoints,
    /// Number of frames in the file.
    steps: usize,
    groups: Groups,
    /// Lists with one row per step or mesh, by name.
    lists: IndexMap<&'static str, Dataset>,
    /// First connectivity number of each cell, and cell types.
    cells: [Dataset; 2],
    coordinates: Series,
    connectivity: Series,
    /// Arrays over points and over cells, by name.
    arrays: [IndexMap<String, StepArray>; 2],
    /// Mesh of the previous frame.
    mesh: Option<WrittenMesh>,
}

/// Groups of the file that change.
#[derive(Debug)]
struct Groups {
    top: Group,
    steps: Group,
    /// Arrays over points and over cells.
    data: [Group; 2],
    /// Their first rows.
    offsets: [Group; 2],
}

/// A mesh in the file.
#[derive(Debug)]
struct WrittenMesh {
    digest: [u8; 32],
    part: usize,
    first_cell: usize,
}

/// A compressed dataset, and what was last written to it.
#[derive(Debug)]
struct Series {
    data: Dataset,
    previous: Option<([u8; 32], usize)>,
}

/// An array, and its first rows.
#[derive(Debug)]
struct StepArray {
    series: Series,
    offsets: Dataset,
}

/// Values of an array in one frame.
struct ArrayValues<'a> {
    name: &'a str,
    element: Element,
    components: usize,
    bytes: Vec<u8>,
}

impl VtkHdfWriter {
    /// Creates a file with the origin of the results and a first frame.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn create(path: &Path, points: FramePoints, origin: &str, frame: &OutputFrame) -> io::Result<VtkHdfWriter> {
        let mut file = Hdf5File::create(path)?;
        let list = |element, width, chunk_rows| RowType { element, width, chunk_rows, storage: Storage::Plain };
        let mut lists = IndexMap::new();
        for name in COUNTS {
            lists.insert(name, Dataset::create(&mut file, list(Element::I64, None, LISTED_ROWS))?);
        }
        for (name, width) in LISTS {
            let element = if name == TIMES { Element::F64 } else { Element::I64 };
            lists.insert(name, Dataset::create(&mut file, list(element, width, LISTED_ROWS))?);
        }
        let cell_list = |file: &mut _, element| Dataset::create(file, list(element, None, CELL_ROWS));
        let cells = [cell_list(&mut file, Element::I64)?, cell_list(&mut file, Element::U8)?];
        let coordinates = Series::create(&mut file, Element::F64, 3, frame.points.len())?;
        let connectivity = Series::create(&mut file, Element::I64, 1, frame.cells.corners().len())?;
        let groups = Groups::create(&mut file, origin, (&lists, &cells), [&coordinates, &connectivity])?;
        let arrays = [IndexMap::new(), IndexMap::new()];
        let mut writer = VtkHdfWriter {
            file,
            points,
            steps: 0,
            groups,
            lists,
            cells,
            coordinates,
            connectivity,
            arrays,
            mesh: None,
        };
        writer.write(frame)?;
        Ok(writer)
    }

    /// Opens a file to continue it after its first `steps` frames, or after all if it has fewer.
    ///
    /// # Errors
    /// If it cannot be read, or is no such file.
    pub fn open(path: &Path, points: FramePoints, steps: usize) -> io::Result<VtkHdfWriter> {
        let (mut file, root) = Hdf5File::open(path)?;
        let root = Group::open(&mut file, root)?;
        let top = Group::open(&mut file, root.member("VTKHDF")?)?;
        let in_steps = Group::open(&mut file, top.member("Steps")?)?;
        let mut group = |of: &Group, name: &str| Group::open(&mut file, of.member(name)?);
        let data = [group(&top, PLACES[0][0])?, group(&top, PLACES[1][0])?];
        let offsets = [group(&in_steps, PLACES[0][1])?, group(&in_steps, PLACES[1][1])?];
        let mut dataset = |of: &Group, name: &str| Dataset::open(&mut file, of.member(name)?);
        let mut lists = IndexMap::new();
        for name in COUNTS {
            lists.insert(name, dataset(&top, name)?);
        }
        for (name, _) in LISTS {
            lists.insert(name, dataset(&in_steps, name)?);
        }
        let cells = [dataset(&top, "Offsets")?, dataset(&top, "Types")?];
        let coordinates = Series { data: dataset(&top, "Points")?, previous: None };
        let connectivity = Series { data: dataset(&top, "Connectivity")?, previous: None };
        let mut arrays = [IndexMap::new(), IndexMap::new()];
        for ((arrays, data), offsets) in arrays.iter_mut().zip(&data).zip(&offsets) {
            for (name, _) in data.members() {
                let series = Series { data: dataset(data, name)?, previous: None };
                arrays.insert(name.clone(), StepArray { series, offsets: dataset(offsets, name)? });
            }
        }
        let groups = Groups { top, steps: in_steps, data, offsets };
        let written = groups.steps.first_integer()? as usize;
        let mut writer = VtkHdfWriter {
            file,
            points,
            steps: written.min(steps),
            groups,
            lists,
            cells,
            coordinates,
            connectivity,
            arrays,
            mesh: None,
        };
        writer.prepare_times()?;
        writer.publish()?;
        Ok(writer)
    }

    /// Returns the number of frames in the file.
    pub fn steps(&self) -> usize {
        self.steps
    }

    /// Adds a frame without deleted elements.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&mut self, frame: &OutputFrame) -> io::Result<()> {
        let frame = &*frame.without_deleted();
        self.write_mesh(frame)?;
        let coordinates: Vec<u8> = frame.coordinates(self.points).flat_map(f64::to_le_bytes).collect();
        let first_point = self.coordinates.write(&mut self.file, &coordinates)?;
        self.prepare_times()?;
        self.list(TIMES, self.steps, frame.time.to_le_bytes())?;
        self.list("NumberOfParts", self.steps, 1_i64.to_le_bytes())?;
        self.list("PointOffsets", self.steps, (first_point as i64).to_le_bytes())?;
        let mut fields: Vec<&FieldArray> = frame.point_fields.iter().collect();
        let displacement = frame.displacement();
        if self.points == FramePoints::Reference && fields.iter().all(|field| field.name != "U") {
            fields.push(&displacement);
        }
        self.write_arrays(0, &fields, &frame.point_labels, frame.points.len())?;
        let fields: Vec<&FieldArray> = frame.cell_fields.iter().collect();
        self.write_arrays(1, &fields, &frame.cell_labels, frame.cells.len())?;
        self.steps += 1;
        self.publish()
    }

    /// Writes another header of the list of times, which readers do not see yet: VTK expects that it has as many rows as
    /// there are steps.
    fn prepare_times(&mut self) -> io::Result<()> {
        let times = self.lists.get_mut(TIMES);
        times.map_or(Ok(()), |times| times.move_header(&mut self.file, self.steps))
    }

    /// Makes the steps so far visible to readers, by one change: that of the address of the group `Steps`.
    fn publish(&mut self) -> io::Result<()> {
        let number = Attribute::new(NUMBER, AttributeValue::Integer(self.steps as i64));
        let times = (TIMES, self.lists[TIMES].address);
        let Groups { top, steps, .. } = &mut self.groups;
        steps.change(&mut self.file, &number, times)?;
        top.redirect(&mut self.file, "Steps", steps.address)
    }

    /// Writes a row of a list.
    fn list(&mut self, name: &str, row: usize, value: [u8; 8]) -> io::Result<()> {
        let list = self.lists.get_mut(name);
        list.map_or(Ok(()), |list| list.write(&mut self.file, row, &value))
    }

    /// Writes the mesh if it is not that of the previous frame, and its place.
    fn write_mesh(&mut self, frame: &OutputFrame) -> io::Result<()> {
        let bytes = |values: &mut dyn Iterator<Item = i64>| -> Vec<u8> { values.flat_map(i64::to_le_bytes).collect() };
        let connectivity = bytes(&mut frame.cells.vtk_connectivity());
        let offsets = bytes(&mut frame.cells.vtk_offsets());
        let mut hash = Sha256::new();
        hash.update((frame.points.len() as u64).to_le_bytes());
        hash.update(&offsets);
        hash.update(&connectivity);
        let digest = hash.finalize().into();
        let written = self.mesh.take().filter(|mesh| mesh.digest == digest);
        let mesh = match written {
            Some(mesh) => mesh,
            None => {
                let mesh =
                    WrittenMesh { digest, part: self.lists["NumberOfPoints"].rows, first_cell: self.cells[1].rows };
                let types: Vec<u8> = frame.cells.vtk_types().collect();
                // The list of first connectivity numbers has one row more for each mesh.
                self.cells[0].write(&mut self.file, mesh.first_cell + mesh.part, &offsets)?;
                self.cells[1].write(&mut self.file, mesh.first_cell, &types)?;
                let counts = [frame.points.len(), frame.cells.len(), frame.cells.corners().len()];
                for (name, count) in COUNTS.into_iter().zip(counts) {
                    self.list(name, mesh.part, (count as i64).to_le_bytes())?;
                }
                mesh
            }
        };
        let first_id = self.connectivity.write(&mut self.file, &connectivity)?;
        for (name, value) in
            [("PartOffsets", mesh.part), ("CellOffsets", mesh.first_cell), ("ConnectivityIdOffsets", first_id)]
        {
            self.list(name, self.steps, (value as i64).to_le_bytes())?;
        }
        self.mesh = Some(mesh);
        Ok(())
    }

    /// Writes the arrays over points (0) or cells (1), and not-a-number or 0 in arrays that only other frames have.
    fn write_arrays(
        &mut self,
        place: usize,
        fields: &[&FieldArray],
        labels: &[EntityLabels],
        count: usize,
    ) -> io::Result<()> {
        let fields = fields.iter().map(|field| ArrayValues {
            name: &field.name,
            element: Element::F64,
            components: field.components_in_space(),
            bytes: field.values_in_space().flat_map(f64::to_le_bytes).collect(),
        });
        let labels = labels.iter().map(|label| ArrayValues {
            name: &label.name,
            element: Element::I32,
            components: 1,
            bytes: label.values.iter().flat_map(|value| value.to_le_bytes()).collect(),
        });
        // A slash would separate groups.
        let named = fields.chain(labels).map(|values| (values.name.replace('/', "∕"), values));
        let all: IndexMap<String, ArrayValues<'_>> = named.collect();
        self.add_arrays(place, &all, count)?;
        for (name, array) in &mut self.arrays[place] {
            match all.get(name) {
                Some(values) => array.write(&mut self.file, self.steps, &values.bytes)?,
                None => {
                    let values = array.absent(count);
                    array.write(&mut self.file, self.steps, &values)?;
                }
            }
        }
        Ok(())
    }

    /// Adds the arrays that the file does not have, without values in the frames so far.
    fn add_arrays(&mut self, place: usize, all: &IndexMap<String, ArrayValues<'_>>, count: usize) -> io::Result<()> {
        let list = RowType { element: Element::I64, width: None, chunk_rows: LISTED_ROWS, storage: Storage::Plain };
        let (mut data_links, mut offset_links) = (Vec::new(), Vec::new());
        let known = &self.arrays[place];
        let new: Vec<_> = all.iter().filter(|(name, _)| !known.contains_key(*name)).collect();
        for (name, values) in new {
            let series = Series::create(&mut self.file, values.element, values.components, count)?;
            let mut array = StepArray { series, offsets: Dataset::create(&mut self.file, list)? };
            if self.steps > 0 {
                let absent = array.absent(self.largest_count(place)?);
                for step in 0..self.steps {
                    array.write(&mut self.file, step, &absent)?;
                }
            }
            data_links.push((name.clone(), array.series.data.address));
            offset_links.push((name.clone(), array.offsets.address));
            self.arrays[place].insert(name.clone(), array);
        }
        if data_links.is_empty() {
            return Ok(());
        }
        let Groups { top, steps, data, offsets } = &mut self.groups;
        offsets[place].add(&mut self.file, offset_links)?;
        steps.redirect(&mut self.file, PLACES[place][1], offsets[place].address)?;
        data[place].add(&mut self.file, data_links)?;
        top.redirect(&mut self.file, PLACES[place][0], data[place].address)
    }

    /// Returns the largest number of points or cells of the meshes so far.
    fn largest_count(&mut self, place: usize) -> io::Result<usize> {
        let list = &self.lists[COUNTS[place]];
        let mut largest = 0;
        for row in 0..list.rows {
            let value = list.read(&mut self.file, row)?;
            largest = largest.max(value.first_chunk().map_or(0, |bytes| u64::from_le_bytes(*bytes)));
        }
        Ok(largest as usize)
    }
}

impl Groups {
    /// Writes the groups of a file without arrays, and its superblock.
    fn create(
        file: &mut Hdf5File,
        origin: &str,
        (lists, cells): (&IndexMap<&'static str, Dataset>, &[Dataset; 2]),
        [coordinates, connectivity]: [&Series; 2],
    ) -> io::Result<Groups> {
        let mut empty = || Group::create(file, &[], Vec::new());
        let (data, offsets) = ([empty()?, empty()?], [empty()?, empty()?]);
        let entry = |name: &str, address| (name.to_owned(), address);
        let of_lists = |names: &[&str]| -> Vec<_> {
            lists
                .iter()
                .filter(|(name, _)| names.contains(name))
                .map(|(name, list)| entry(name, list.address))
                .collect()
        };
        let mut links = of_lists(&LISTS.map(|(name, _)| name));
        links.extend(PLACES.iter().zip(&offsets).map(|(names, group)| entry(names[1], group.address)));
        let number = Attribute::new(NUMBER, AttributeValue::Integer(0));
        let steps = Group::create(file, &[number], links)?;
        let mut links = of_lists(&COUNTS);
        links.push(entry("Offsets", cells[0].address));
        links.push(entry("Types", cells[1].address));
        links.push(entry("Points", coordinates.data.address));
        links.push(entry("Connectivity", connectivity.data.address));
        links.extend(PLACES.iter().zip(&data).map(|(names, group)| entry(names[0], group.address)));
        links.push(entry("Steps", steps.address));
        let version = Attribute::new("Version", AttributeValue::Integers(&[2, 1]));
        let kind = Attribute::new("Type", AttributeValue::Text("UnstructuredGrid"));
        let mut attributes = vec![version, kind];
        // A text has at least one character.
        attributes.extend((!origin.is_empty()).then_some(Attribute::new("Origin", AttributeValue::Text(origin))));
        let top = Group::create(file, &attributes, links)?;
        let root = Group::create(file, &[], vec![entry("VTKHDF", top.address)])?;
        file.set_root(root.address)?;
        Ok(Groups { top, steps, data, offsets })
    }
}

impl Series {
    /// Creates a dataset for frames with about `rows` rows.
    fn create(file: &mut Hdf5File, element: Element, components: usize, rows: usize) -> io::Result<Series> {
        let parts = rows.div_ceil(MOST_ROWS).max(1);
        let row_type = RowType {
            element,
            width: (components > 1).then_some(components),
            chunk_rows: rows.div_ceil(parts).max(1),
            storage: Storage::Compressed,
        };
        Ok(Series { data: Dataset::create(file, row_type)?, previous: None })
    }

    /// Writes rows unless they are those of the previous frame; returns the index of the first one.
    fn write(&mut self, file: &mut Hdf5File, rows: &[u8]) -> io::Result<usize> {
        let digest = Sha256::digest(rows).into();
        let first = match self.previous {
            Some((previous, first)) if previous == digest => first,
            _ => self.data.append(file, rows)?,
        };
        self.previous = Some((digest, first));
        Ok(first)
    }
}

impl StepArray {
    /// Writes the values of a step.
    fn write(&mut self, file: &mut Hdf5File, step: usize, values: &[u8]) -> io::Result<()> {
        let first = self.series.write(file, values)?;
        self.offsets.write(file, step, &(first as i64).to_le_bytes())
    }

    /// Returns values of a frame without this array.
    fn absent(&self, count: usize) -> Vec<u8> {
        let row_type = self.series.data.row_type;
        let bytes = count * row_type.row_bytes();
        match row_type.element {
            Element::F64 => f64::NAN.to_le_bytes().repeat(bytes / row_type.element.size()),
            _ => vec![0; bytes],
        }
    }
}
