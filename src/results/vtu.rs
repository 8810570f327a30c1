//! VTU files: one frame as VTK XML with inline base64 and zlib (VTK File Formats, "XML File Formats").

use std::fmt::Write as _;
use std::io::{self, Write};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::{Compress, Compression, FlushCompress};

use super::{CellList, EntityLabels, FieldArray, FramePoints, OutputFrame};

/// Bytes of an uncompressed block; resetting the compressor costs as much as compressing some tens of KiB.
const BLOCK: usize = 1 << 20;

/// Writer of `.vtu` text. It reuses the compressor and its buffers, because allocating them costs more than compressing
/// small arrays.
#[derive(Debug)]
pub struct VtuWriter {
    points: FramePoints,
    /// Origin of the results, as a comment in each file.
    origin: String,
    compressor: Compress,
    text: String,
    /// Uncompressed block.
    block: Vec<u8>,
    packed: Vec<u8>,
}

/// Name of the field data that marks points with initial coordinates.
pub const REFERENCE: &str = "ReferencePoints";

impl Default for VtuWriter {
    fn default() -> Self {
        VtuWriter::new(FramePoints::default(), "")
    }
}

impl VtuWriter {
    /// Creates a writer of current or of initial coordinates, with the origin of the results. The origin is a comment,
    /// because meshio 5.3 reads no file with field data of strings (`findings/meshio_vtu_text_in_field_data.sh`).
    pub fn new(points: FramePoints, origin: &str) -> Self {
        let compressor = Compress::new(Compression::fast(), true);
        // A comment must not contain two hyphens.
        let origin = origin.replace("--", "- -");
        VtuWriter { points, origin, compressor, text: String::new(), block: Vec::new(), packed: Vec::new() }
    }

    /// Returns an upper bound of the length of a frame's text: the length without compression.
    pub fn largest_length(frame: &OutputFrame) -> u64 {
        // Base64 of the data and of the header, the tag, and what zlib adds to incompressible data.
        let array = |bytes: usize| (bytes + bytes / 1000).div_ceil(3) as u64 * 4 + 12 * (bytes / BLOCK) as u64 + 200;
        let (points, cells) = (frame.points.len(), frame.cells.len());
        let field = |field: &FieldArray| {
            let padded = if field.components == 4 { 6 } else { field.components_in_space().max(1) };
            let names: usize = field.component_names.iter().map(|name| name.len() + 20).sum();
            array(field.values.len() / field.components.max(1) * padded * 8) + (2 * field.name.len() + names) as u64
        };
        let corners = frame.cells.corners().len();
        let fields = frame.point_fields.iter().chain(&frame.cell_fields).map(field).sum::<u64>();
        let labels = frame.point_labels.iter().chain(&frame.cell_labels);
        let labels: u64 = labels.map(|label| array(4 * label.values.len()) + label.name.len() as u64).sum();
        // Points, and U if the points have initial coordinates; cells, their offsets and types.
        fields + labels + 2 * array(24 * points) + array(8 * corners) + array(8 * cells) + array(cells) + 1500
    }

    /// Returns the text of a frame.
    pub fn text(&mut self, frame: &OutputFrame) -> String {
        let mut text = Vec::new();
        // Writing to memory cannot fail, and the text is valid.
        let _ = self.write(frame, &mut text);
        String::from_utf8(text).unwrap_or_default()
    }

    /// Writes the text of a frame without deleted elements, one array at a time. r becomes x, z becomes y, and direction 3 becomes z.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn write(&mut self, frame: &OutputFrame, out: &mut dyn Write) -> io::Result<()> {
        let frame = &*frame.without_deleted();
        self.text.clear();
        self.line("<?xml version=\"1.0\"?>");
        if !self.origin.is_empty() {
            let comment = format!("<!-- {} -->", self.origin);
            self.line(&comment);
        }
        self.line(
            "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n<FieldData>",
        );
        self.array("Float64", "TimeValue", " NumberOfTuples=\"1\"", frame.time.to_le_bytes());
        let reference = self.points == FramePoints::Reference;
        if reference {
            self.array("UInt8", REFERENCE, " NumberOfTuples=\"1\"", [1]);
        }
        let (points, cells) = (frame.points.len(), frame.cells.len());
        self.line("</FieldData>");
        let _ = writeln!(self.text, "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">");
        self.point_data(frame, out)?;
        self.cell_data(frame, out)?;
        self.line("<Points>");
        self.array(
            "Float64",
            "Points",
            " NumberOfComponents=\"3\"",
            frame.coordinates(self.points).flat_map(f64::to_le_bytes),
        );
        self.line("</Points>");
        self.flush(out)?;
        self.topology(&frame.cells, out)?;
        self.line("</Piece>\n</UnstructuredGrid>\n</VTKFile>");
        self.flush(out)
    }

    /// Writes the text so far.
    fn flush(&mut self, out: &mut dyn Write) -> io::Result<()> {
        out.write_all(self.text.as_bytes())?;
        self.text.clear();
        Ok(())
    }

    fn line(&mut self, line: &str) {
        self.text.push_str(line);
        self.text.push('\n');
    }

    /// Writes arrays over points; with initial coordinates U is always included.
    fn point_data(&mut self, frame: &OutputFrame, out: &mut dyn Write) -> io::Result<()> {
        self.line("<PointData>");
        frame.point_fields.iter().try_for_each(|field| self.field(field, out))?;
        if self.points == FramePoints::Reference && frame.point_fields.iter().all(|field| field.name != "U") {
            self.field(&frame.displacement(), out)?;
        }
        frame.point_labels.iter().try_for_each(|label| self.label(label, out))?;
        self.line("</PointData>");
        Ok(())
    }

    /// Writes arrays over cells.
    fn cell_data(&mut self, frame: &OutputFrame, out: &mut dyn Write) -> io::Result<()> {
        self.line("<CellData>");
        frame.cell_fields.iter().try_for_each(|field| self.field(field, out))?;
        frame.cell_labels.iter().try_for_each(|label| self.label(label, out))?;
        self.line("</CellData>");
        Ok(())
    }

    fn label(&mut self, label: &EntityLabels, out: &mut dyn Write) -> io::Result<()> {
        self.array("Int32", &escape(&label.name), "", label.values.iter().flat_map(|v| v.to_le_bytes()));
        self.flush(out)
    }

    /// Writes one array.
    fn field(&mut self, field: &FieldArray, out: &mut dyn Write) -> io::Result<()> {
        let components = field.components_in_space();
        let mut attributes = String::new();
        if components > 1 {
            let _ = write!(attributes, " NumberOfComponents=\"{components}\"");
        }
        for (i, name) in field.component_names.iter().enumerate() {
            let _ = write!(attributes, " ComponentName{i}=\"{}\"", escape(name));
        }
        let name = escape(&field.name);
        if field.component_names.len() == 2 {
            let _ = write!(attributes, " ComponentName2=\"{name}3\"");
        }
        if field.is_tensor() {
            let _ = write!(attributes, " ComponentName4=\"{name}23\" ComponentName5=\"{name}13\"");
        }
        self.array("Float64", &name, &attributes, field.values_in_space().flat_map(f64::to_le_bytes));
        self.flush(out)
    }

    fn topology(&mut self, cells: &CellList, out: &mut dyn Write) -> io::Result<()> {
        self.line("<Cells>");
        self.array("Int64", "connectivity", "", cells.vtk_connectivity().flat_map(i64::to_le_bytes));
        self.flush(out)?;
        self.array("Int64", "offsets", "", cells.vtk_offsets().skip(1).flat_map(i64::to_le_bytes));
        self.array("UInt8", "types", "", cells.vtk_types());
        self.line("</Cells>");
        Ok(())
    }

    fn array(&mut self, kind: &str, name: &str, attributes: &str, bytes: impl IntoIterator<Item = u8>) {
        let _ = write!(self.text, "<DataArray type=\"{kind}\" Name=\"{name}\"{attributes} format=\"binary\">");
        self.pack(bytes.into_iter());
        self.line("</DataArray>");
    }

    /// Writes the header (number of blocks, block size, size of a last partial block, compressed sizes) and the blocks,
    /// each in base64.
    fn pack(&mut self, mut bytes: impl Iterator<Item = u8>) {
        let mut header = vec![0, BLOCK as u64, 0];
        self.packed.clear();
        loop {
            self.block.clear();
            self.block.extend(bytes.by_ref().take(BLOCK));
            if self.block.is_empty() {
                break;
            }
            let block = &self.block;
            header[0] += 1;
            header[2] = (block.len() % BLOCK) as u64;
            let start = self.packed.len();
            // Capacity for a block that does not compress: zlib adds a few bytes to every 16 KiB (RFC 1950, RFC 1951).
            self.packed.reserve(block.len() + block.len() / 1024 + 64);
            self.compressor.reset();
            // Compression into sufficient capacity cannot fail.
            let _ = self.compressor.compress_vec(block, &mut self.packed, FlushCompress::Finish);
            header.push((self.packed.len() - start) as u64);
        }
        let header: Vec<u8> = header.iter().flat_map(|v| v.to_le_bytes()).collect();
        STANDARD.encode_string(header, &mut self.text);
        STANDARD.encode_string(&self.packed, &mut self.text);
    }
}

/// Escapes text for an XML attribute.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
