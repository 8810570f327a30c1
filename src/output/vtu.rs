//! VTU: one frame as VTK XML with inline base64 and zlib (VTK File Formats, "XML File Formats").
//! Never here: which fields a frame has.

use std::fmt::Write as _;
use std::io::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::{Field, Frame};

/// Bytes of a block before compression.
const BLOCK: usize = 1 << 15;

/// The text of a `.vtu` file. r becomes x, z becomes y.
pub fn vtu(frame: &Frame) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n<FieldData>\n",
    );
    let time = encode(&[frame.time]);
    let _ = writeln!(
        text,
        "<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"binary\">{time}</DataArray>\n</FieldData>"
    );
    let (points, cells) = (frame.points.len(), frame.cells.len());
    let _ = writeln!(text, "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">");
    section(&mut text, "PointData", &frame.point_fields);
    section(&mut text, "CellData", &frame.cell_fields);
    let places: Vec<f64> = frame.points.iter().flat_map(|p| [p[0], p[1], 0.0]).collect();
    let array = encode(&places);
    let _ = writeln!(
        text,
        "<Points>\n<DataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\" format=\"binary\">{array}</DataArray>\n</Points>"
    );
    topology(&mut text, &frame.cells);
    text + "</Piece>\n</UnstructuredGrid>\n</VTKFile>\n"
}

fn section(text: &mut String, name: &str, fields: &[Field]) {
    let _ = writeln!(text, "<{name}>");
    for field in fields {
        data_array(text, field);
    }
    let _ = writeln!(text, "</{name}>");
}

/// One array; vectors in the plane get a third component, as VTK's filters expect.
fn data_array(text: &mut String, field: &Field) {
    let _ = write!(text, "<DataArray type=\"Float64\" Name=\"{}\"", escape(&field.name));
    let padded = field.components == 2;
    let components = if padded { 3 } else { field.components };
    if components > 1 {
        let _ = write!(text, " NumberOfComponents=\"{components}\"");
    }
    for (i, name) in field.component_names.iter().enumerate() {
        let _ = write!(text, " ComponentName{i}=\"{}\"", escape(name));
    }
    if padded && field.component_names.len() == 2 {
        let _ = write!(text, " ComponentName2=\"{}3\"", escape(&field.name));
    }
    let array = if padded {
        encode(&field.values.chunks_exact(2).flat_map(|v| [v[0], v[1], 0.0]).collect::<Vec<f64>>())
    } else {
        encode(&field.values)
    };
    let _ = writeln!(text, " format=\"binary\">{array}</DataArray>");
}

fn topology(text: &mut String, cells: &[Vec<usize>]) {
    let connectivity: Vec<i64> = cells.iter().flatten().map(|&p| p as i64).collect();
    let ends = cells.iter().scan(0, |sum, cell| {
        *sum += cell.len() as i64;
        Some(*sum)
    });
    let offsets: Vec<i64> = ends.collect();
    let types: Vec<u8> = cells.iter().map(|c| [1, 3, 5, 9][c.len().clamp(1, 4) - 1]).collect();
    let bytes = |values: &[i64]| compressed(&values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>());
    let _ = writeln!(
        text,
        "<Cells>\n<DataArray type=\"Int64\" Name=\"connectivity\" format=\"binary\">{}</DataArray>\n\
         <DataArray type=\"Int64\" Name=\"offsets\" format=\"binary\">{}</DataArray>\n\
         <DataArray type=\"UInt8\" Name=\"types\" format=\"binary\">{}</DataArray>\n</Cells>",
        bytes(&connectivity),
        bytes(&offsets),
        compressed(&types)
    );
}

fn encode(values: &[f64]) -> String {
    compressed(&values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>())
}

/// Header (number of blocks, block size, size of a last partial block, compressed sizes) and blocks, each in base64.
fn compressed(bytes: &[u8]) -> String {
    let blocks: Vec<Vec<u8>> = bytes.chunks(BLOCK).map(deflate).collect();
    let mut header = vec![blocks.len() as u64, BLOCK as u64, (bytes.len() % BLOCK) as u64];
    header.extend(blocks.iter().map(|b| b.len() as u64));
    let header: Vec<u8> = header.iter().flat_map(|v| v.to_le_bytes()).collect();
    STANDARD.encode(header) + &STANDARD.encode(blocks.concat())
}

fn deflate(block: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    // Writing into memory cannot fail.
    let _ = encoder.write_all(block);
    encoder.finish().unwrap_or_default()
}

/// Text as it may stand in an XML attribute.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
