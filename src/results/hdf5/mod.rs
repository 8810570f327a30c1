//! HDF5 files that are complete after each change (HDF5 File Format Specification, version 3.0).
//!
//! The file has the oldest form of the format: superblock 1, object headers 1 and B-trees 1. These have no checksums, so
//! that each update is one write of a few bytes after the data that it refers to. A killed process leaves a file that
//! every HDF5 library opens, without recovery.

mod dataset;
mod header;
mod tree;

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

pub use dataset::{Dataset, RowType, Storage};
pub use header::{Attribute, AttributeValue, Element};
use header::{
    GROUP_INFO, LINK, LINK_INFO, PREFIX, integer_of, link, link_target, messages, object_header, target_address,
};

/// Address that refers to nothing.
const UNDEFINED: u64 = u64::MAX;
const SIGNATURE: [u8; 8] = *b"\x89HDF\r\n\x1a\n";
/// Bytes of the superblock, rounded up.
const SUPERBLOCK: u64 = 104;
/// Addresses of the end of the file and of the root group's header.
const END: u64 = 44;
const ROOT: u64 = 68;
/// Half of the largest number of children of a node of the chunk trees. The default, 32, would use 2.6 kB per array.
const TREE_ORDER: u16 = 8;

/// An open HDF5 file.
#[derive(Debug)]
pub struct Hdf5File {
    file: File,
    /// Length of the file, at which data are added.
    end: u64,
}

impl Hdf5File {
    /// Creates a file. It becomes a valid HDF5 file with [`Hdf5File::set_root`].
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn create(path: &Path) -> io::Result<Hdf5File> {
        let mut file = OpenOptions::new().read(true).write(true).create(true).truncate(true).open(path)?;
        file.write_all(&[0; SUPERBLOCK as usize])?;
        Ok(Hdf5File { file, end: SUPERBLOCK })
    }

    /// Opens a file that was written by this module; returns it with the address of its root group.
    ///
    /// # Errors
    /// If it cannot be read, or is no such file.
    pub fn open(path: &Path) -> io::Result<(Hdf5File, u64)> {
        let file = OpenOptions::new().read(true).write(true).open(path)?;
        let end = file.metadata()?.len().next_multiple_of(8);
        let mut file = Hdf5File { file, end };
        let head = file.read(0, SUPERBLOCK as usize)?;
        if !head.starts_with(&SIGNATURE) || head[8] != 1 {
            return Err(damaged());
        }
        Ok((file, word(&head, ROOT as usize)?))
    }

    /// Writes the superblock with the root group.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn set_root(&mut self, root: u64) -> io::Result<()> {
        let mut head = SIGNATURE.to_vec();
        // Version; sizes of addresses and lengths.
        head.extend([1, 0, 0, 0, 0, 8, 8, 0]);
        // Orders of the nodes of old groups, which are not used; flags; order of chunk trees.
        head.extend([4, 0, 16, 0, 0, 0, 0, 0]);
        head.extend(TREE_ORDER.to_le_bytes());
        head.extend([0; 2]);
        head.extend([0, UNDEFINED, self.end, UNDEFINED, 0, root].into_iter().flat_map(u64::to_le_bytes));
        head.resize(SUPERBLOCK as usize, 0);
        self.overwrite(0, &head)
    }

    /// Adds bytes at the end of the file and returns their address.
    fn append(&mut self, bytes: &[u8]) -> io::Result<u64> {
        let address = self.end;
        self.overwrite(address, bytes)?;
        let padding = bytes.len().next_multiple_of(8) - bytes.len();
        self.file.write_all(&[0; 8][..padding])?;
        self.end += (bytes.len() + padding) as u64;
        self.overwrite(END, &self.end.to_le_bytes())?;
        Ok(address)
    }

    /// Writes bytes at an address.
    fn overwrite(&mut self, address: u64, bytes: &[u8]) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(address))?;
        self.file.write_all(bytes)
    }

    /// Returns the bytes of an object header.
    fn header(&mut self, address: u64) -> io::Result<Vec<u8>> {
        let prefix = self.read(address, PREFIX as usize)?;
        self.read(address, PREFIX as usize + word(&prefix, 8)? as u32 as usize)
    }

    fn read(&mut self, address: u64, length: usize) -> io::Result<Vec<u8>> {
        if address.checked_add(length as u64).is_none_or(|end| end > self.end) {
            return Err(damaged());
        }
        self.file.seek(SeekFrom::Start(address))?;
        let mut bytes = vec![0; length];
        self.file.read_exact(&mut bytes)?;
        Ok(bytes)
    }
}

/// A group. Links are added by a new header, to which the parent's link is then changed.
#[derive(Debug)]
pub struct Group {
    /// Address of its object header.
    pub address: u64,
    links: Vec<(String, u64)>,
    attributes: Vec<Vec<u8>>,
}

impl Group {
    /// Writes a group with links to objects of the file.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn create(file: &mut Hdf5File, attributes: &[Attribute<'_>], links: Vec<(String, u64)>) -> io::Result<Group> {
        let attributes = attributes.iter().map(Attribute::message).collect();
        let mut group = Group { address: UNDEFINED, links, attributes };
        group.write(file)?;
        Ok(group)
    }

    /// Reads a group.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn open(file: &mut Hdf5File, address: u64) -> io::Result<Group> {
        let mut group = Group { address, links: Vec::new(), attributes: Vec::new() };
        for message in messages(file, address)? {
            match message.kind {
                LINK => group.links.push(link_target(&message.body)?),
                LINK_INFO | GROUP_INFO => {}
                _ => group.attributes.push(message.whole()),
            }
        }
        Ok(group)
    }

    fn write(&mut self, file: &mut Hdf5File) -> io::Result<()> {
        let mut parts = self.attributes.clone();
        parts.extend(header::of_group());
        parts.extend(self.links.iter().map(|(name, address)| link(name, *address)));
        self.address = file.append(&object_header(&parts))?;
        Ok(())
    }

    /// Returns the address of a member.
    ///
    /// # Errors
    /// If it does not exist.
    pub fn member(&self, name: &str) -> io::Result<u64> {
        let found = self.links.iter().find(|(known, _)| known == name);
        found.map(|(_, address)| *address).ok_or_else(damaged)
    }

    /// Returns the names and addresses of all members.
    pub fn members(&self) -> &[(String, u64)] {
        &self.links
    }

    /// Adds members. The group gets another address.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn add(&mut self, file: &mut Hdf5File, links: Vec<(String, u64)>) -> io::Result<()> {
        self.links.extend(links);
        self.write(file)
    }

    /// Returns the value of the first attribute, an integer.
    ///
    /// # Errors
    /// If there is none.
    pub fn first_integer(&self) -> io::Result<u64> {
        integer_of(self.attributes.first().ok_or_else(damaged)?)
    }

    /// Changes the first attribute and the address of a member. The group gets another address.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn change(
        &mut self,
        file: &mut Hdf5File,
        attribute: &Attribute<'_>,
        (name, address): (&str, u64),
    ) -> io::Result<()> {
        self.attributes.first_mut().into_iter().for_each(|first| *first = attribute.message());
        self.links.iter_mut().filter(|(known, _)| known == name).for_each(|link| link.1 = address);
        self.write(file)
    }

    /// Changes the address of a member.
    ///
    /// # Errors
    /// If it does not exist or cannot be written.
    pub fn redirect(&mut self, file: &mut Hdf5File, name: &str, address: u64) -> io::Result<()> {
        for message in messages(file, self.address)?.iter().filter(|message| message.kind == LINK) {
            if link_target(&message.body)?.0 == name {
                let link = self.links.iter_mut().find(|(known, _)| known == name);
                link.into_iter().for_each(|link| link.1 = address);
                return file.overwrite(target_address(message.address, name), &address.to_le_bytes());
            }
        }
        Err(damaged())
    }
}

fn damaged() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, "it is damaged, or another program wrote it")
}

/// Returns the eight-byte integer at a position.
fn word(bytes: &[u8], position: usize) -> io::Result<u64> {
    let eight = bytes.get(position..).and_then(|rest| rest.first_chunk::<8>());
    eight.map(|eight| u64::from_le_bytes(*eight)).ok_or_else(damaged)
}

/// Returns the two-byte integer at a position.
fn short(bytes: &[u8], position: usize) -> io::Result<usize> {
    let two = bytes.get(position..).and_then(|rest| rest.first_chunk::<2>());
    two.map(|two| usize::from(u16::from_le_bytes(*two))).ok_or_else(damaged)
}
