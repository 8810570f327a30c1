//! Reader of XML files of VTK with a mesh: `.vtu` and `.vtp`, with inline or appended arrays.

use std::borrow::Cow;

use super::vtk_mesh::{NOT_A_MESH, VtkMesh};
use super::xml_array::{ArrayBudget, ArrayFormat, Compression, NumberType, StoredArray, decode};

/// Largest number of arrays of a file.
const MAX_ARRAYS: usize = 20_000;
/// Largest ratio of the memory for points and cells to the size of the file. Structured meshes are compressed by a
/// factor of 7 to 13 (measured for 10^6 quadrilaterals, `Float64` and `Int64`, zlib level 9).
const MESH_RATIO: u64 = 30;
/// Largest ratio for all other arrays; an array of a set is compressed by a factor of up to 1000.
const DATA_RATIO: u64 = 100;

/// An opening, closing or empty tag.
struct Tag<'a> {
    name: &'a [u8],
    /// Text between the name and the end.
    attributes: Cow<'a, str>,
    /// Bytes of the file before the tag, and up to its end.
    span: [usize; 2],
}

impl Tag<'_> {
    fn attribute(&self, name: &str) -> Option<&str> {
        let mut remaining = &*self.attributes;
        loop {
            let (key, after) = remaining.split_once('=')?;
            let after = after.trim_start();
            let quote = after.chars().next().filter(|c| matches!(c, '"' | '\''))?;
            let (value, after) = after[1..].split_once(quote)?;
            if key.trim() == name {
                return Some(value);
            }
            remaining = after;
        }
    }

    /// Returns an attribute that is a count; a missing one is 0.
    fn count(&self, name: &str) -> Result<u64, String> {
        let Some(text) = self.attribute(name) else { return Ok(0) };
        let count = text.trim().parse().map_err(|_| format!("`{name}` is not a count"))?;
        if count <= u64::from(u32::MAX) { Ok(count) } else { Err(format!("`{name}` is {count}, more than 2^32 - 1")) }
    }
}

/// Returns the next tag from a place. Comments and declarations are skipped.
fn next_tag(bytes: &[u8], mut from: usize) -> Option<Tag<'_>> {
    loop {
        let start = from + bytes.get(from..)?.iter().position(|b| *b == b'<')?;
        let text = &bytes[start..];
        let skipped = [("<!--", "-->"), ("<![CDATA[", "]]>"), ("<?", "?>")];
        if let Some((_, end)) = skipped.iter().find(|(begin, _)| text.starts_with(begin.as_bytes())) {
            from = start + text.windows(end.len()).position(|w| w == end.as_bytes())? + end.len();
            continue;
        }
        let mut quote = None;
        let length = text.iter().position(|&byte| {
            match quote {
                Some(open) if open == byte => quote = None,
                None if matches!(byte, b'"' | b'\'') => quote = Some(byte),
                _ => {}
            }
            quote.is_none() && byte == b'>'
        })?;
        let inside = &text[1..length];
        let end = inside.iter().skip(1).position(|b| b.is_ascii_whitespace() || *b == b'/');
        let (name, attributes) = inside.split_at(end.map_or(inside.len(), |end| end + 1));
        let span = [start, start + length + 1];
        return Some(Tag { name, attributes: String::from_utf8_lossy(attributes), span });
    }
}

/// An array before it is decoded.
struct ArrayEntry<'a> {
    /// Name of the tag that contains it, for example `PointData`.
    section: &'a [u8],
    name: String,
    kind: String,
    components: u64,
    place: ArrayPlace<'a>,
}

enum ArrayPlace<'a> {
    Inline(StoredArray<'a>),
    /// Offset in the appended data.
    Appended(u64),
}

/// Tags of a file, read up to the appended data.
struct XmlMesh<'a> {
    format: ArrayFormat,
    /// Attributes of the only piece: points, and cells of each section.
    points: u64,
    cells: Vec<(&'static [u8], u64)>,
    arrays: Vec<ArrayEntry<'a>>,
    appended: Option<StoredArray<'a>>,
    mesh_budget: ArrayBudget,
    data_budget: ArrayBudget,
}

/// Sections with arrays other than those of cells.
const SECTIONS: [&[u8]; 4] = [b"Points", b"PointData", b"CellData", b"FieldData"];
/// Sections with cells, and the attribute with their number. Cell arrays of poly data cover them in this order.
const CELLS: [(&[u8], &str); 5] = [
    (b"Cells", "NumberOfCells"),
    (b"Verts", "NumberOfVerts"),
    (b"Lines", "NumberOfLines"),
    (b"Polys", "NumberOfPolys"),
    (b"Strips", "NumberOfStrips"),
];

/// Reads the mesh, and the values of the point and cell arrays whose names `wanted` accepts.
///
/// # Errors
/// The reason if the file is damaged or not supported.
pub(super) fn parse(bytes: &[u8], wanted: &dyn Fn(&str) -> bool) -> Result<VtkMesh, String> {
    let file = XmlMesh::scan(bytes)?;
    let values = file.decode(b"Points", "", file.points, 3, &file.mesh_budget)?;
    let points = values.as_chunks::<3>().0.to_vec();
    let (mut cells, mut types) = (Vec::new(), Vec::new());
    for &(section, count) in file.cells.iter().filter(|(_, count)| *count > 0) {
        if section == b"Strips" {
            return Err("it has triangle strips; save it as triangles".into());
        }
        file.add_cells(section, count, &mut cells)?;
        if section == b"Cells" {
            types = file.decode(section, "types", count, 1, &file.mesh_budget)?.iter().map(|t| *t as u8).collect();
        }
    }
    let point_arrays = file.data(b"PointData", points.len(), wanted)?;
    let cell_arrays = file.data(b"CellData", cells.len(), wanted)?;
    Ok(VtkMesh { points, cells, types, point_arrays, cell_arrays })
}

impl<'a> XmlMesh<'a> {
    fn scan(bytes: &'a [u8]) -> Result<Self, String> {
        let root = next_tag(bytes, 0).filter(|tag| tag.name == b"VTKFile").ok_or("it is not a VTK file")?;
        let bytes = bytes.trim_ascii_end().strip_suffix(b"</VTKFile>").ok_or("the file is incomplete")?;
        let mut file = XmlMesh {
            format: array_format(&root)?,
            points: 0,
            cells: Vec::new(),
            arrays: Vec::new(),
            appended: None,
            mesh_budget: ArrayBudget::new(bytes.len(), MESH_RATIO),
            data_budget: ArrayBudget::new(bytes.len(), DATA_RATIO),
        };
        let (mut section, mut pieces): (&[u8], _) = (b"", 0);
        let mut from = root.span[1];
        while let Some(tag) = next_tag(bytes, from) {
            from = tag.span[1];
            match tag.name {
                b"Piece" => {
                    pieces += 1;
                    file.points = tag.count("NumberOfPoints")?;
                    for (name, attribute) in CELLS {
                        file.cells.push((name, tag.count(attribute)?));
                    }
                }
                b"DataArray" => from = file.add_array(bytes, section, &tag)?,
                b"AppendedData" => {
                    file.appended = Some(appended_data(bytes, &tag)?);
                    break;
                }
                name if SECTIONS.contains(&name) || CELLS.iter().any(|(cells, _)| *cells == name) => section = name,
                _ => {}
            }
        }
        if pieces == 1 { Ok(file) } else { Err(format!("it has {pieces} pieces; save it as one piece")) }
    }

    /// Adds an array; returns the end of its content.
    fn add_array(&mut self, bytes: &'a [u8], section: &'a [u8], tag: &Tag<'_>) -> Result<usize, String> {
        if self.arrays.len() == MAX_ARRAYS {
            return Err(format!("it has more than {MAX_ARRAYS} arrays"));
        }
        let name = unescape(tag.attribute("Name").unwrap_or_default());
        let content = if tag.attributes.trim_end().ends_with('/') { &[] } else { &bytes[tag.span[1]..] };
        let content = &content[..content.iter().position(|b| *b == b'<').unwrap_or(content.len())];
        let position = match tag.attribute("format").unwrap_or("ascii") {
            "ascii" => ArrayPlace::Inline(StoredArray::Text(content)),
            "binary" => ArrayPlace::Inline(StoredArray::Base64(content.trim_ascii())),
            "appended" => {
                let offset = tag.attribute("offset").and_then(|text| text.trim().parse().ok());
                ArrayPlace::Appended(offset.ok_or_else(|| format!("array `{name}` has no offset"))?)
            }
            other => return Err(format!("array `{name}` has the format `{other}`, which does not exist in VTK")),
        };
        let components = tag.count("NumberOfComponents")?.max(1);
        let kind = tag.attribute("type").unwrap_or_default().to_owned();
        self.arrays.push(ArrayEntry { section, name, kind, components, place: position });
        Ok(tag.span[1] + content.len())
    }

    /// Decodes the array of a section with a name (empty: any), which must have `count` tuples of `components` numbers.
    fn decode(
        &self,
        section: &[u8],
        name: &str,
        count: u64,
        components: u64,
        budget: &ArrayBudget,
    ) -> Result<Vec<f64>, String> {
        let fits = |entry: &&ArrayEntry<'_>| entry.section == section && (name.is_empty() || entry.name == name);
        let Some(entry) = self.arrays.iter().find(fits) else {
            let array_name = if name.is_empty() { "Points" } else { name };
            return if count == 0 { Ok(Vec::new()) } else { Err(format!("it has no array `{array_name}`")) };
        };
        if entry.components != components {
            return Err(format!("array `{}` has {} components, expected {components}", entry.name, entry.components));
        }
        self.values(entry, count, budget)
    }

    fn values(&self, entry: &ArrayEntry<'_>, count: u64, budget: &ArrayBudget) -> Result<Vec<f64>, String> {
        let wrong = |why: String| format!("array `{}`: {why}", entry.name);
        let kind = NumberType::of(&entry.kind)
            .ok_or_else(|| wrong(format!("its type `{}` is not a number type of VTK", entry.kind)))?;
        let after = |bytes: &'a [u8], offset: u64| usize::try_from(offset).ok().and_then(|at| bytes.get(at..));
        let stored = match (&entry.place, self.appended) {
            (ArrayPlace::Inline(stored), _) => Some(*stored),
            (ArrayPlace::Appended(offset), Some(StoredArray::Raw(all))) => after(all, *offset).map(StoredArray::Raw),
            (ArrayPlace::Appended(offset), Some(StoredArray::Base64(all))) => {
                after(all, *offset).map(StoredArray::Base64)
            }
            _ => None,
        };
        let stored = stored.ok_or_else(|| wrong("its offset is outside the appended data".into()))?;
        decode(stored, kind, count.saturating_mul(entry.components), self.format, budget).map_err(wrong)
    }

    fn add_cells(&self, section: &[u8], count: u64, cells: &mut Vec<Vec<usize>>) -> Result<(), String> {
        let offsets = self.decode(section, "offsets", count, 1, &self.mesh_budget)?;
        let total = offsets.last().copied().unwrap_or(0.0);
        if !(0.0..=f64::from(u32::MAX)).contains(&total) || !offsets.is_sorted() {
            return Err("array `offsets`: its values do not increase from 0 to 2^32".into());
        }
        let connectivity = self.decode(section, "connectivity", total as u64, 1, &self.mesh_budget)?;
        let mut start = 0;
        cells.reserve_exact(offsets.len());
        for end in offsets.into_iter().map(|end| end.max(0.0) as usize) {
            // A number that is not an index becomes one that no point has.
            let index = |p: &f64| if *p >= 0.0 { *p as usize } else { usize::MAX };
            cells.push(connectivity[start..end].iter().map(index).collect());
            start = end;
        }
        Ok(())
    }

    fn data(
        &self,
        section: &[u8],
        count: usize,
        wanted: &dyn Fn(&str) -> bool,
    ) -> Result<Vec<(String, Vec<f64>)>, String> {
        let read = |entry: &ArrayEntry<'_>| {
            let values =
                if wanted(&entry.name) { self.values(entry, count as u64, &self.data_budget)? } else { Vec::new() };
            Ok((entry.name.clone(), values))
        };
        self.arrays.iter().filter(|entry| entry.section == section).map(read).collect()
    }
}

fn array_format(root: &Tag<'_>) -> Result<ArrayFormat, String> {
    match root.attribute("type") {
        Some("UnstructuredGrid" | "PolyData") => {}
        Some("PUnstructuredGrid" | "PPolyData") => {
            return Err("it refers to pieces in other files; save it as one file".into());
        }
        _ => return Err(NOT_A_MESH.into()),
    }
    let header = match root.attribute("header_type") {
        None | Some("UInt32") => 4,
        Some("UInt64") => 8,
        Some(other) => return Err(format!("its header_type `{other}` is neither UInt32 nor UInt64")),
    };
    let compression = match root.attribute("compressor") {
        None | Some("") => Compression::None,
        Some("vtkZLibDataCompressor") => Compression::Zlib,
        Some("vtkLZ4DataCompressor") => Compression::Lz4,
        Some(other) => return Err(format!("its compression `{other}` is not supported")),
    };
    Ok(ArrayFormat { big_endian: root.attribute("byte_order") == Some("BigEndian"), header, compression })
}

/// Returns the bytes between the underscore and the end tag of the appended data.
fn appended_data<'a>(bytes: &'a [u8], tag: &Tag<'_>) -> Result<StoredArray<'a>, String> {
    let content = bytes[tag.span[1]..].trim_ascii_start();
    let content = content.strip_prefix(b"_").ok_or("its appended data do not start with an underscore")?;
    let content =
        content.trim_ascii_end().strip_suffix(b"</AppendedData>").ok_or("its appended data are not closed")?;
    match tag.attribute("encoding") {
        Some("raw") => Ok(StoredArray::Raw(content)),
        Some("base64") => Ok(StoredArray::Base64(content)),
        _ => Err("the encoding of its appended data is neither raw nor base64".into()),
    }
}

fn unescape(text: &str) -> String {
    let text = text.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", "\"").replace("&apos;", "'");
    text.replace("&amp;", "&")
}
