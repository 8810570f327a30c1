//! Chunked datasets to which rows are added.

use std::io;

use flate2::{Compress, Compression, FlushCompress};

use super::header::{
    DATASPACE, DATATYPE, Element, FILL_VALUE, FILTERS, LAYOUT, MESSAGE_HEAD, PREFIX, dataspace, message, messages,
    object_header,
};
use super::tree::{Chunk, ChunkTree};
use super::{Hdf5File, UNDEFINED, damaged, word};

/// Address of the number of rows, from the address of the dataset: the dataspace is the first message.
const ROWS: u64 = PREFIX + MESSAGE_HEAD + 8;

/// How rows are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storage {
    /// In compressed chunks. Each group of rows begins with a chunk, and unused rows are left at its end.
    Compressed,
    /// Without gaps and without compression; rows can be overwritten.
    Plain,
}

/// Shape and type of the rows of a dataset.
#[derive(Clone, Copy, Debug)]
pub struct RowType {
    /// Type of the numbers.
    pub element: Element,
    /// Numbers in a row; `None` for a dataset with one dimension.
    pub width: Option<usize>,
    /// Rows of a chunk.
    pub chunk_rows: usize,
    /// How rows are stored.
    pub storage: Storage,
}

impl RowType {
    /// Returns the numbers in a row.
    fn width(&self) -> usize {
        self.width.unwrap_or(1)
    }

    /// Returns the bytes of a row.
    pub fn row_bytes(&self) -> usize {
        self.element.size() * self.width()
    }
}

/// A dataset whose first dimension grows.
#[derive(Debug)]
pub struct Dataset {
    /// Address of its object header.
    pub address: u64,
    /// Shape and type of its rows.
    pub row_type: RowType,
    /// Number of rows.
    pub rows: usize,
    /// Addresses of the chunks.
    chunks: Vec<u64>,
    tree: ChunkTree,
}

impl Dataset {
    /// Writes an empty dataset.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn create(file: &mut Hdf5File, row_type: RowType) -> io::Result<Dataset> {
        let width = row_type.width.map(|width| width as u64);
        let shape: Vec<u64> = [0].into_iter().chain(width).collect();
        let largest: Vec<u64> = [UNDEFINED].into_iter().chain(width).collect();
        // Version 2: storage is allocated when it is written; there is no fill value.
        let mut parts = vec![
            message(DATASPACE, &dataspace(&shape, Some(&largest))),
            message(DATATYPE, &row_type.element.datatype()),
            message(FILL_VALUE, &[2, 3, 2, 0]),
        ];
        if row_type.storage == Storage::Compressed {
            parts.push(message(FILTERS, &filters(row_type.element)));
        }
        let before: usize = parts.iter().map(Vec::len).sum();
        parts.push(message(LAYOUT, &layout(row_type)));
        let address = file.append(&object_header(&parts))?;
        let root_field = address + PREFIX + before as u64 + MESSAGE_HEAD + 3;
        let tree = ChunkTree::new(shape.len(), row_type.chunk_rows as u64, root_field);
        Ok(Dataset { address, row_type, rows: 0, chunks: Vec::new(), tree })
    }

    /// Reads a dataset.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn open(file: &mut Hdf5File, address: u64) -> io::Result<Dataset> {
        let messages = messages(file, address)?;
        let message = |kind| messages.iter().find(|message| message.kind == kind).ok_or_else(damaged);
        let (space, layout) = (&message(DATASPACE)?.body, message(LAYOUT)?);
        let rank = usize::from(*space.get(1).ok_or_else(damaged)?);
        let row_type = RowType {
            element: Element::of_datatype(&message(DATATYPE)?.body)?,
            width: if rank == 2 { Some(word(space, 16)? as usize) } else { None },
            chunk_rows: word(&layout.body, 11)? as u32 as usize,
            storage: if message(FILTERS).is_ok() { Storage::Compressed } else { Storage::Plain },
        };
        if row_type.chunk_rows == 0 {
            return Err(damaged());
        }
        let (tree, chunks) = ChunkTree::open(file, rank, row_type.chunk_rows as u64, layout.address + 3)?;
        Ok(Dataset { address, row_type, rows: word(space, 8)? as usize, chunks, tree })
    }

    /// Adds rows to a compressed dataset and returns the index of the first one.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn append(&mut self, file: &mut Hdf5File, rows: &[u8]) -> io::Result<usize> {
        let row_bytes = self.row_type.row_bytes();
        let first = self.chunks.len() * self.row_type.chunk_rows;
        for part in rows.chunks(self.row_type.chunk_rows * row_bytes) {
            let mut chunk = part.to_vec();
            chunk.resize(self.row_type.chunk_rows * row_bytes, 0);
            self.add_chunk(file, &compressed(&shuffled(&chunk, self.row_type.element.size())))?;
        }
        self.set_rows(file, first + rows.len() / row_bytes)?;
        Ok(first)
    }

    /// Writes rows of a plain dataset from an index on, which is at most the number of rows.
    ///
    /// # Errors
    /// If they cannot be written.
    pub fn write(&mut self, file: &mut Hdf5File, first: usize, rows: &[u8]) -> io::Result<()> {
        let (row_bytes, chunk_rows) = (self.row_type.row_bytes(), self.row_type.chunk_rows);
        let (mut row, mut rest) = (first, rows);
        while !rest.is_empty() {
            let (chunk, offset) = (row / chunk_rows, row % chunk_rows);
            if chunk == self.chunks.len() {
                self.add_chunk(file, &vec![0; chunk_rows * row_bytes])?;
            }
            let (part, later) = rest.split_at(rest.len().min((chunk_rows - offset) * row_bytes));
            file.overwrite(self.chunks[chunk] + (offset * row_bytes) as u64, part)?;
            row += part.len() / row_bytes;
            rest = later;
        }
        if row > self.rows { self.set_rows(file, row) } else { Ok(()) }
    }

    /// Returns rows of a plain dataset.
    ///
    /// # Errors
    /// If they cannot be read.
    pub fn read(&self, file: &mut Hdf5File, row: usize) -> io::Result<Vec<u8>> {
        let (row_bytes, chunk_rows) = (self.row_type.row_bytes(), self.row_type.chunk_rows);
        let chunk = self.chunks.get(row / chunk_rows).ok_or_else(damaged)?;
        file.read(chunk + (row % chunk_rows * row_bytes) as u64, row_bytes)
    }

    /// Writes another header with a number of rows. Readers see it when a link to it is written.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn move_header(&mut self, file: &mut Hdf5File, rows: usize) -> io::Result<()> {
        let mut header = file.header(self.address)?;
        header[ROWS as usize..ROWS as usize + 8].copy_from_slice(&(rows as u64).to_le_bytes());
        let address = file.append(&header)?;
        self.tree.root_field = address + (self.tree.root_field - self.address);
        (self.address, self.rows) = (address, rows);
        Ok(())
    }

    fn add_chunk(&mut self, file: &mut Hdf5File, bytes: &[u8]) -> io::Result<()> {
        let first_row = (self.chunks.len() * self.row_type.chunk_rows) as u64;
        let chunk = Chunk { first_row, address: file.append(bytes)?, size: bytes.len() as u32 };
        self.chunks.push(chunk.address);
        self.tree.add(file, chunk)
    }

    fn set_rows(&mut self, file: &mut Hdf5File, rows: usize) -> io::Result<()> {
        self.rows = rows;
        file.overwrite(self.address + ROWS, &(rows as u64).to_le_bytes())
    }
}

/// Returns the body of the layout message: version 3, chunks, number of dimensions with that of the bytes of an element,
/// address of the tree, shape.
fn layout(row_type: RowType) -> Vec<u8> {
    let width = row_type.width.map(|width| width as u32);
    let shape: Vec<u32> =
        [row_type.chunk_rows as u32].into_iter().chain(width).chain([row_type.element.size() as u32]).collect();
    let mut body = vec![3, 2, shape.len() as u8];
    body.extend(UNDEFINED.to_le_bytes());
    body.extend(shape.into_iter().flat_map(u32::to_le_bytes));
    body
}

/// Returns the body of the filter message: bytes of equal significance are put together (2) and compressed by zlib (1).
fn filters(element: Element) -> Vec<u8> {
    let mut body = vec![1, 2, 0, 0, 0, 0, 0, 0];
    for (filter, value) in [(2_u8, element.size() as u8), (1, 1)] {
        body.extend([filter, 0, 0, 0, 0, 0, 1, 0, value, 0, 0, 0, 0, 0, 0, 0]);
    }
    body
}

/// Puts bytes of equal significance together.
fn shuffled(bytes: &[u8], size: usize) -> Vec<u8> {
    (0..size).flat_map(|i| bytes.iter().skip(i).step_by(size).copied()).collect()
}

fn compressed(bytes: &[u8]) -> Vec<u8> {
    let mut packed = Vec::with_capacity(bytes.len() + bytes.len() / 1024 + 64);
    // Compression into sufficient capacity cannot fail.
    let _ = Compress::new(Compression::fast(), true).compress_vec(bytes, &mut packed, FlushCompress::Finish);
    packed
}
