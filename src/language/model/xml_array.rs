//! Arrays of XML files of VTK: text, base64 or raw bytes, with or without compression (VTK File Formats, "XML File
//! Formats"). The declared sizes are compared with the expected size and with the file before memory is allocated.

use std::borrow::Cow;
use std::cell::Cell;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::{Decompress, FlushDecompress};

/// How the arrays of a file are stored.
#[derive(Clone, Copy, Debug)]
pub(super) struct ArrayFormat {
    pub big_endian: bool,
    /// Bytes of an integer in the header of an array.
    pub header: usize,
    pub compression: Compression,
}

/// Compression of the blocks of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Compression {
    None,
    Zlib,
    Lz4,
}

/// Type of the numbers of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NumberType {
    Signed(usize),
    Unsigned(usize),
    Float(usize),
}

impl NumberType {
    /// Returns the type of a VTK name.
    pub fn of(name: &str) -> Option<Self> {
        let (kind, bits): (fn(usize) -> Self, _) = if let Some(bits) = name.strip_prefix("UInt") {
            (NumberType::Unsigned, bits)
        } else if let Some(bits) = name.strip_prefix("Int") {
            (NumberType::Signed, bits)
        } else {
            (NumberType::Float, name.strip_prefix("Float")?)
        };
        let kind = kind(["8", "16", "32", "64"].iter().position(|b| *b == bits).map(|i| 1 << i)?);
        (!matches!(kind, NumberType::Float(1 | 2))).then_some(kind)
    }

    fn bytes(self) -> usize {
        match self {
            NumberType::Signed(bytes) | NumberType::Unsigned(bytes) | NumberType::Float(bytes) => bytes,
        }
    }

    /// Returns the number in up to eight bytes.
    fn number(self, bytes: &[u8], big_endian: bool) -> f64 {
        let bits = unsigned(bytes, big_endian);
        match self {
            NumberType::Unsigned(_) => bits as f64,
            NumberType::Signed(size) => {
                let shift = 64 - 8 * size as u32;
                ((bits << shift) as i64 >> shift) as f64
            }
            NumberType::Float(4) => f64::from(f32::from_bits(bits as u32)),
            NumberType::Float(_) => f64::from_bits(bits),
        }
    }
}

fn unsigned(bytes: &[u8], big_endian: bool) -> u64 {
    let join = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
    if big_endian { bytes.iter().fold(0, join) } else { bytes.iter().rev().fold(0, join) }
}

/// Stored form of an array.
#[derive(Clone, Copy, Debug)]
pub(super) enum StoredArray<'a> {
    /// Numbers separated by white space.
    Text(&'a [u8]),
    /// Base64 text that starts with the header of the array.
    Base64(&'a [u8]),
    /// Bytes that start with the header of the array.
    Raw(&'a [u8]),
}

/// Limits of the memory for the arrays of a file. A file that is compressed further than meshes can be is rejected.
#[derive(Debug)]
pub(super) struct ArrayBudget(Cell<u64>);

impl ArrayBudget {
    /// Allows `ratio` times the size of a file, and 4 MiB.
    pub fn new(file: usize, ratio: u64) -> Self {
        ArrayBudget(Cell::new((file as u64).saturating_mul(ratio).saturating_add(4 << 20)))
    }

    fn spend(&self, bytes: u64) -> Result<(), String> {
        let remaining = self.0.get().checked_sub(bytes).ok_or_else(|| {
            format!(
                "its arrays need at least {} MB, more than a mesh in a file of this size; save it without compression",
                bytes / 1_000_000
            )
        })?;
        self.0.set(remaining);
        Ok(())
    }
}

/// Returns the `count` numbers of an array.
///
/// # Errors
/// The reason if the array has another length, exceeds the budget or is damaged.
pub(super) fn decode(
    stored: StoredArray<'_>,
    kind: NumberType,
    count: u64,
    format: ArrayFormat,
    budget: &ArrayBudget,
) -> Result<Vec<f64>, String> {
    if let StoredArray::Text(text) = stored {
        return numbers_of_text(text, count);
    }
    let size = count.saturating_mul(kind.bytes() as u64);
    budget.spend(count.saturating_mul(8))?;
    let bytes = if format.compression == Compression::None {
        plain_bytes(stored, size, format)?
    } else {
        Cow::Owned(decompressed_bytes(stored, size, format)?)
    };
    Ok(bytes.chunks_exact(kind.bytes()).map(|number| kind.number(number, format.big_endian)).collect())
}

fn numbers_of_text(text: &[u8], count: u64) -> Result<Vec<f64>, String> {
    let text = std::str::from_utf8(text).map_err(|_| "it is not text")?;
    if count > text.len().div_ceil(2) as u64 {
        return Err(format!("it has fewer than the {count} expected numbers"));
    }
    let mut numbers = Vec::with_capacity(count as usize);
    for word in text.split_ascii_whitespace() {
        numbers.push(word.parse().map_err(|_| format!("`{}` is not a number", shortened(word)))?);
    }
    let length = numbers.len();
    if length as u64 == count { Ok(numbers) } else { Err(format!("it has {length} numbers, expected {count}")) }
}

fn shortened(word: &str) -> String {
    word.chars().take(20).collect()
}

/// Returns the first `size` bytes of a stored sequence, and the rest of the sequence. Base64 text is one unit, so the
/// rest starts after its last group of four characters.
fn leading_bytes(stored: StoredArray<'_>, size: u64) -> Result<(Cow<'_, [u8]>, StoredArray<'_>), String> {
    let short = || "it is truncated".to_owned();
    match stored {
        StoredArray::Text(_) => Err("it has no bytes".into()),
        StoredArray::Raw(bytes) => {
            let (head, tail) = usize::try_from(size).ok().and_then(|n| bytes.split_at_checked(n)).ok_or_else(short)?;
            Ok((Cow::Borrowed(head), StoredArray::Raw(tail)))
        }
        StoredArray::Base64(text) => {
            let length = size.div_ceil(3).checked_mul(4).and_then(|n| usize::try_from(n).ok()).ok_or_else(short)?;
            let (head, tail) = text.split_at_checked(length).ok_or_else(short)?;
            let mut bytes = STANDARD.decode(head).map_err(|error| format!("it is not valid base64: {error}"))?;
            if (bytes.len() as u64) < size {
                return Err(short());
            }
            bytes.truncate(size as usize);
            Ok((Cow::Owned(bytes), StoredArray::Base64(tail)))
        }
    }
}

/// Returns the bytes of an array without compression. Its header is its size; in base64 the header is encoded together
/// with the data, or alone.
fn plain_bytes(stored: StoredArray<'_>, size: u64, format: ArrayFormat) -> Result<Cow<'_, [u8]>, String> {
    let header = format.header as u64;
    let (head, data) = leading_bytes(stored, header)?;
    let declared = unsigned(&head, format.big_endian);
    if declared != size {
        if head.iter().all(|byte| *byte == b' ') {
            return Err("its size is blank, as MEDCoupling writes it: write text with WriteVTK(name, False)".into());
        }
        return Err(format!("it declares {declared} bytes, expected {size}"));
    }
    let alone = match stored {
        StoredArray::Base64(text) => text.get(format.header.div_ceil(3) * 4 - 1) == Some(&b'='),
        _ => true,
    };
    if alone {
        return Ok(leading_bytes(data, size)?.0);
    }
    let mut bytes = leading_bytes(stored, header.saturating_add(size))?.0.into_owned();
    bytes.drain(..format.header);
    Ok(Cow::Owned(bytes))
}

/// Returns the bytes of a compressed array. Its header is the number of blocks, the size of a block, the size of the
/// last block if it is smaller (otherwise 0), and the compressed size of each block.
fn decompressed_bytes(stored: StoredArray<'_>, size: u64, format: ArrayFormat) -> Result<Vec<u8>, String> {
    let header = format.header as u64;
    let integer = |bytes: &[u8]| unsigned(bytes, format.big_endian);
    // Three integers need no padding in base64.
    let (head, _) = leading_bytes(stored, 3 * header)?;
    let [blocks, block, last] = [0, 1, 2].map(|i| integer(&head[i * format.header..][..format.header]));
    let declared = match (blocks, last) {
        (0, _) => Some(0),
        (_, 0) => blocks.checked_mul(block),
        _ => (blocks - 1).checked_mul(block).and_then(|sum| sum.checked_add(last)),
    };
    if declared != Some(size) || last > block {
        return Err(format!("it declares {blocks} blocks of {block} bytes, expected {size} bytes in total"));
    }
    let lengths = blocks.checked_add(3).and_then(|n| n.checked_mul(header)).ok_or("it is truncated")?;
    let (head, data) = leading_bytes(stored, lengths)?;
    let lengths = || head[3 * format.header..].chunks_exact(format.header).map(integer);
    let total = lengths().try_fold(0_u64, u64::checked_add).ok_or("it is truncated")?;
    let (packed, _) = leading_bytes(data, total)?;
    let mut bytes = Vec::with_capacity(size as usize);
    let (mut packed, mut remaining) = (&*packed, size);
    for length in lengths() {
        let (block_bytes, following) = packed.split_at(length as usize);
        let expected = block.min(remaining) as usize;
        decompress(block_bytes, expected, format.compression, &mut bytes)?;
        (packed, remaining) = (following, remaining - expected as u64);
    }
    Ok(bytes)
}

/// Appends the `size` bytes of a compressed block.
fn decompress(packed: &[u8], size: usize, compression: Compression, bytes: &mut Vec<u8>) -> Result<(), String> {
    let start = bytes.len();
    let damaged = || "a compressed block is damaged".to_owned();
    if compression == Compression::Lz4 {
        bytes.resize(start + size, 0);
        let decompressed = lz4_flex::block::decompress_into(packed, &mut bytes[start..]).map_err(|_| damaged())?;
        return if decompressed == size { Ok(()) } else { Err(damaged()) };
    }
    // The capacity is that of the whole array; one block must not use that of the next ones.
    let mut block = vec![0; size];
    let mut decompressor = Decompress::new(true);
    decompressor.decompress(packed, &mut block, FlushDecompress::Finish).map_err(|_| damaged())?;
    if decompressor.total_out() != size as u64 {
        return Err(damaged());
    }
    bytes.extend_from_slice(&block);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{ArrayBudget, ArrayFormat, Compression, NumberType, StoredArray, decode};

    #[test]
    fn types_are_those_of_vtk() {
        assert_eq!(NumberType::of("UInt8"), Some(NumberType::Unsigned(1)));
        assert_eq!(NumberType::of("Int64"), Some(NumberType::Signed(8)));
        assert_eq!(NumberType::of("Float32"), Some(NumberType::Float(4)));
        assert!(["Float16", "Int9", "String", "UInt128"].iter().all(|name| NumberType::of(name).is_none()));
        assert_eq!(NumberType::Signed(2).number(&[0xff, 0xfe], true), -2.0);
        assert_eq!(NumberType::Signed(2).number(&[0xfe, 0xff], false), -2.0);
        assert_eq!(NumberType::Float(4).number(&1.5_f32.to_be_bytes(), true), 1.5);
    }

    /// Source: the layout of VTK. Base64 of the header and the data together, and of each alone.
    #[test]
    fn headers_are_encoded_together_or_alone() {
        let format = ArrayFormat { big_endian: false, header: 4, compression: Compression::None };
        let read = |text: &str| {
            let budget = ArrayBudget::new(text.len(), 30);
            decode(StoredArray::Base64(text.as_bytes()), NumberType::Unsigned(1), 2, format, &budget)
        };
        assert_eq!(read("AgAAAAcI"), Ok(vec![7.0, 8.0]));
        assert_eq!(read("AgAAAA==Bwg="), Ok(vec![7.0, 8.0]));
        assert_eq!(read("AgAAAA==").unwrap_err(), "it is truncated");
        assert_eq!(read("AwAAAAcI").unwrap_err(), "it declares 3 bytes, expected 2");
        assert!(read("Ag!AAAcI").unwrap_err().contains("base64"));
    }

    #[test]
    fn declared_sizes_are_checked_before_decompression() {
        let format = ArrayFormat { big_endian: false, header: 8, compression: Compression::Zlib };
        let read = |header: [u64; 4], count| {
            let bytes: Vec<u8> = header.iter().flat_map(|n| n.to_le_bytes()).collect();
            let budget = ArrayBudget::new(bytes.len(), 30);
            decode(StoredArray::Raw(&bytes), NumberType::Float(8), count, format, &budget).unwrap_err()
        };
        assert!(read([1 << 40, 0, 0, 0], 3).contains("1099511627776 blocks"));
        assert!(read([u64::MAX, u64::MAX, 1, 0], 3).contains("expected 24 bytes"));
        assert_eq!(read([1, 24, 0, 99], 3), "it is truncated");
        assert_eq!(read([1, 24, 0, u64::MAX], 3), "it is truncated");
        assert!(read([1, 1 << 30, 0, 0], 1 << 27).contains("more than a mesh in a file of this size"));
        assert_eq!(read([1, 24, 0, 0], 3), "a compressed block is damaged");
    }
}
