//! B-trees of version 1 that index the chunks of a dataset. Chunks are only added at the end.

use std::io;

use super::{Hdf5File, TREE_ORDER, UNDEFINED, damaged, short, word};

/// Bytes of a node before its first key.
const NODE_HEAD: u64 = 24;
/// Largest number of children of a node.
const MOST: usize = 2 * TREE_ORDER as usize;
/// Largest number of levels that are read; more would need more chunks than there are addresses.
const MOST_LEVELS: usize = 20;

/// Place of a chunk in its dataset and in the file.
#[derive(Clone, Copy, Debug)]
pub struct Chunk {
    pub first_row: u64,
    pub address: u64,
    /// Bytes in the file.
    pub size: u32,
}

/// Index of the chunks of a dataset.
#[derive(Debug)]
pub struct ChunkTree {
    /// Number of dimensions of the dataset.
    rank: usize,
    /// Rows of a chunk.
    chunk_rows: u64,
    /// Address of the field with the address of the root.
    pub root_field: u64,
    /// Last node of each level, from the leaves to the root.
    nodes: Vec<TreeNode>,
}

#[derive(Clone, Copy, Debug)]
struct TreeNode {
    address: u64,
    children: usize,
}

impl ChunkTree {
    /// Creates an empty tree.
    pub fn new(rank: usize, chunk_rows: u64, root_field: u64) -> ChunkTree {
        ChunkTree { rank, chunk_rows, root_field, nodes: Vec::new() }
    }

    /// Reads a tree; returns it with the addresses of all chunks.
    pub fn open(file: &mut Hdf5File, rank: usize, chunk_rows: u64, root_field: u64) -> io::Result<(Self, Vec<u64>)> {
        let mut tree = ChunkTree::new(rank, chunk_rows, root_field);
        let root = file.read(root_field, 8)?;
        let mut level_nodes = vec![word(&root, 0)?];
        if level_nodes[0] == UNDEFINED {
            return Ok((tree, Vec::new()));
        }
        for _ in 0..MOST_LEVELS {
            let (mut level, mut next, mut last) = (0, Vec::new(), None);
            for address in level_nodes {
                let node = file.read(address, tree.node_size())?;
                let children = short(&node, 6)?;
                if !node.starts_with(b"TREE") || children > MOST {
                    return Err(damaged());
                }
                level = node[5];
                last = Some(TreeNode { address, children });
                for child in 0..children {
                    next.push(word(&node, (NODE_HEAD + tree.entry_size() * child as u64 + tree.key_size()) as usize)?);
                }
            }
            tree.nodes.extend(last);
            if level == 0 {
                tree.nodes.reverse();
                return Ok((tree, next));
            }
            level_nodes = next;
        }
        Err(damaged())
    }

    fn key_size(&self) -> u64 {
        8 + 8 * (self.rank as u64 + 1)
    }

    /// Bytes of a key and the address of a child.
    fn entry_size(&self) -> u64 {
        self.key_size() + 8
    }

    fn node_size(&self) -> usize {
        (NODE_HEAD + self.entry_size() * MOST as u64 + self.key_size()) as usize
    }

    fn key(&self, first_row: u64, size: u32) -> Vec<u8> {
        let mut key = size.to_le_bytes().to_vec();
        key.extend([0; 4]);
        key.extend(first_row.to_le_bytes());
        key.resize(self.key_size() as usize, 0);
        key
    }

    /// Adds the chunk after the last one.
    pub fn add(&mut self, file: &mut Hdf5File, chunk: Chunk) -> io::Result<()> {
        if self.nodes.is_empty() {
            self.add_root(file, &self.key(0, 0), None)?;
        }
        self.insert(file, 0, chunk, chunk.address)
    }

    /// Adds a child that begins with a chunk to the last node of a level.
    fn insert(&mut self, file: &mut Hdf5File, level: usize, chunk: Chunk, child: u64) -> io::Result<()> {
        let key = self.key(chunk.first_row, chunk.size);
        if self.nodes[level].children == MOST {
            let full = self.nodes[level].address;
            if level + 1 == self.nodes.len() {
                let first = file.read(full + NODE_HEAD, self.key_size() as usize)?;
                self.add_root(file, &first, Some(full))?;
            }
            let next = file.append(&self.node(level, full, &key, Some(child), chunk))?;
            file.overwrite(full + 16, &next.to_le_bytes())?;
            self.nodes[level] = TreeNode { address: next, children: 1 };
            return self.insert(file, level + 1, chunk, next);
        }
        let TreeNode { address, children } = self.nodes[level];
        let mut entry = key;
        entry.extend(child.to_le_bytes());
        entry.extend(self.end_key(chunk));
        file.overwrite(address + NODE_HEAD + self.entry_size() * children as u64, &entry)?;
        file.overwrite(address + 6, &(children as u16 + 1).to_le_bytes())?;
        self.nodes[level].children += 1;
        // The last key of each node above is the end of what it contains.
        for above in &self.nodes[level + 1..] {
            let last = above.address + NODE_HEAD + self.entry_size() * above.children as u64;
            file.overwrite(last, &self.end_key(chunk))?;
        }
        Ok(())
    }

    fn end_key(&self, chunk: Chunk) -> Vec<u8> {
        self.key(chunk.first_row + self.chunk_rows, 0)
    }

    /// Makes a node the root: an empty leaf, or the parent of the previous root.
    fn add_root(&mut self, file: &mut Hdf5File, key: &[u8], child: Option<u64>) -> io::Result<()> {
        let none = Chunk { first_row: 0, address: UNDEFINED, size: 0 };
        let address = file.append(&self.node(self.nodes.len(), UNDEFINED, key, child, none))?;
        self.nodes.push(TreeNode { address, children: usize::from(child.is_some()) });
        file.overwrite(self.root_field, &address.to_le_bytes())
    }

    /// Returns the bytes of a node with at most one child.
    fn node(&self, level: usize, left: u64, key: &[u8], child: Option<u64>, chunk: Chunk) -> Vec<u8> {
        let mut bytes = b"TREE\x01".to_vec();
        bytes.extend([level as u8, u8::from(child.is_some()), 0]);
        bytes.extend([left, UNDEFINED].into_iter().flat_map(u64::to_le_bytes));
        bytes.extend(key);
        if let Some(child) = child {
            bytes.extend(child.to_le_bytes());
            bytes.extend(self.end_key(chunk));
        }
        bytes.resize(self.node_size(), 0);
        bytes
    }
}
