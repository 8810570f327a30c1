//! Object headers of version 1 and their messages: datatypes, dataspaces, links and attributes.

use std::io;

use super::{Hdf5File, UNDEFINED, damaged, short, word};

pub const DATASPACE: u16 = 1;
pub const LINK_INFO: u16 = 2;
pub const DATATYPE: u16 = 3;
pub const FILL_VALUE: u16 = 5;
pub const LINK: u16 = 6;
pub const LAYOUT: u16 = 8;
pub const GROUP_INFO: u16 = 10;
pub const FILTERS: u16 = 11;
const ATTRIBUTE: u16 = 12;

/// Bytes before the first message.
pub const PREFIX: u64 = 16;
/// Bytes of a message before its body.
pub const MESSAGE_HEAD: u64 = 8;

/// Type of the elements of an array, in little-endian order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Element {
    /// Floating-point number of 8 bytes.
    F64,
    /// Signed integer of 8 bytes.
    I64,
    /// Signed integer of 4 bytes.
    I32,
    /// Unsigned integer of 1 byte.
    U8,
}

impl Element {
    /// Returns the number of bytes of an element.
    pub fn size(self) -> usize {
        match self {
            Element::F64 | Element::I64 => 8,
            Element::I32 => 4,
            Element::U8 => 1,
        }
    }

    /// Returns the body of the datatype message.
    pub fn datatype(self) -> Vec<u8> {
        let size = self.size() as u8;
        match self {
            // IEEE 754: sign bit 63, exponent of 11 bits from bit 52 with bias 1023, mantissa of 52 bits.
            Element::F64 => vec![0x11, 0x20, 63, 0, 8, 0, 0, 0, 0, 0, 64, 0, 52, 11, 0, 52, 0xff, 3, 0, 0],
            Element::U8 => vec![0x10, 0, 0, 0, 1, 0, 0, 0, 0, 0, 8, 0],
            Element::I64 | Element::I32 => vec![0x10, 8, 0, 0, size, 0, 0, 0, 0, 0, 8 * size, 0],
        }
    }

    /// Returns the type with this datatype message.
    pub fn of_datatype(body: &[u8]) -> io::Result<Element> {
        let known = [Element::F64, Element::I64, Element::I32, Element::U8];
        known.into_iter().find(|element| body.starts_with(&element.datatype())).ok_or_else(damaged)
    }
}

/// An attribute of a group.
#[derive(Debug)]
pub struct Attribute<'a> {
    /// Name.
    pub name: &'a str,
    /// Value.
    pub value: AttributeValue<'a>,
}

/// Value of an attribute.
#[derive(Debug)]
pub enum AttributeValue<'a> {
    /// One integer.
    Integer(i64),
    /// A list of integers.
    Integers(&'a [i64]),
    /// Text in UTF-8 with a fixed length.
    Text(&'a str),
}

impl<'a> Attribute<'a> {
    /// Creates an attribute.
    pub fn new(name: &'a str, value: AttributeValue<'a>) -> Attribute<'a> {
        Attribute { name, value }
    }

    /// Returns the message.
    pub(super) fn message(&self) -> Vec<u8> {
        let name: Vec<u8> = self.name.bytes().chain([0]).collect();
        let (datatype, shape, data) = match self.value {
            AttributeValue::Integer(value) => (Element::I64.datatype(), vec![], value.to_le_bytes().to_vec()),
            AttributeValue::Integers(values) => {
                let data = values.iter().flat_map(|value| value.to_le_bytes()).collect();
                (Element::I64.datatype(), vec![values.len() as u64], data)
            }
            AttributeValue::Text(text) => {
                let charset = if text.is_ascii() { 0 } else { 0x10 };
                let mut datatype = vec![0x13, charset, 0, 0];
                datatype.extend((text.len() as u32).to_le_bytes());
                (datatype, vec![], text.as_bytes().to_vec())
            }
        };
        let space = dataspace(&shape, None);
        let mut body = vec![1, 0];
        body.extend([name.len(), datatype.len(), space.len()].into_iter().flat_map(|n| (n as u16).to_le_bytes()));
        for part in [name, datatype, space, data] {
            body.extend(padded(part));
        }
        message(ATTRIBUTE, &body)
    }
}

/// Returns bytes filled up with zeros to a multiple of eight.
fn padded(mut bytes: Vec<u8>) -> Vec<u8> {
    bytes.resize(bytes.len().next_multiple_of(8), 0);
    bytes
}

/// Returns a message.
pub fn message(kind: u16, body: &[u8]) -> Vec<u8> {
    let body = padded(body.to_vec());
    let mut bytes = kind.to_le_bytes().to_vec();
    bytes.extend((body.len() as u16).to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend(body);
    bytes
}

/// Returns the body of a dataspace message.
pub fn dataspace(shape: &[u64], largest: Option<&[u64]>) -> Vec<u8> {
    let mut body = vec![1, shape.len() as u8, u8::from(largest.is_some()), 0, 0, 0, 0, 0];
    body.extend(shape.iter().chain(largest.unwrap_or_default()).flat_map(|n| n.to_le_bytes()));
    body
}

/// Returns the messages that mark a group whose links are messages.
pub fn of_group() -> [Vec<u8>; 2] {
    let mut info = vec![0, 0];
    info.extend([UNDEFINED; 2].into_iter().flat_map(u64::to_le_bytes));
    [message(LINK_INFO, &info), message(GROUP_INFO, &[0, 0])]
}

/// Returns a link message.
pub fn link(name: &str, address: u64) -> Vec<u8> {
    // Flags: the name is in UTF-8, and its length has two bytes.
    let length = (name.len() as u16).to_le_bytes();
    let mut body = vec![1, 0x11, 1, length[0], length[1]];
    body.extend(name.bytes());
    body.extend(address.to_le_bytes());
    message(LINK, &body)
}

/// Returns the address of the target in a link message with its body at `address`.
pub fn target_address(address: u64, name: &str) -> u64 {
    address + 5 + name.len() as u64
}

/// Returns name and target of a link.
pub fn link_target(body: &[u8]) -> io::Result<(String, u64)> {
    let length = short(body, 3)?;
    let name = body.get(5..5 + length).ok_or_else(damaged)?;
    Ok((String::from_utf8(name.to_vec()).map_err(|_| damaged())?, word(body, 5 + length)?))
}

/// Returns an object header.
pub fn object_header(messages: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = vec![1, 0];
    bytes.extend((messages.len() as u16).to_le_bytes());
    bytes.extend(1_u32.to_le_bytes());
    bytes.extend((messages.iter().map(Vec::len).sum::<usize>() as u32).to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend(messages.iter().flatten());
    bytes
}

/// A message of a header in the file.
pub struct HeaderMessage {
    pub kind: u16,
    /// Address of the body.
    pub address: u64,
    pub body: Vec<u8>,
}

impl HeaderMessage {
    /// Returns the message as bytes.
    pub fn whole(&self) -> Vec<u8> {
        message(self.kind, &self.body)
    }
}

/// Returns the value of an attribute with one integer: the last eight bytes.
pub fn integer_of(attribute: &[u8]) -> io::Result<u64> {
    word(attribute, attribute.len().saturating_sub(8))
}

/// Reads the messages of an object header.
pub fn messages(file: &mut Hdf5File, address: u64) -> io::Result<Vec<HeaderMessage>> {
    let bytes = file.header(address)?;
    let count = short(&bytes, 2)?;
    let (mut position, mut found) = (PREFIX as usize, Vec::new());
    for _ in 0..count {
        let (kind, size) = (short(&bytes, position)? as u16, short(&bytes, position + 2)?);
        position += MESSAGE_HEAD as usize;
        let body = bytes.get(position..position + size).ok_or_else(damaged)?.to_vec();
        found.push(HeaderMessage { kind, address: address + position as u64, body });
        position += size;
    }
    Ok(found)
}
