//! Nodes that move on their own: those of deformable bodies.
//! Never here: elements.

use super::archive::{Archive, Persist, persist_fields};

/// What elements read of a node: one half of a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct Node {
    /// Current r.
    pub r: f64,
    /// Current z.
    pub z: f64,
    /// Velocity along r at the middle of the increment behind.
    pub v_r: f64,
    /// Velocity along z.
    pub v_z: f64,
}

impl Node {
    /// `[r, z]`.
    pub fn place(&self) -> [f64; 2] {
        [self.r, self.z]
    }

    /// `[r, z, v_r, v_z]`.
    #[inline(always)]
    pub fn as_array(&self) -> [f64; 4] {
        [self.r, self.z, self.v_r, self.v_z]
    }
}

impl Persist for Node {
    #[inline]
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Node { r, z, v_r, v_z } = self;
        persist_fields!(archive; r, z, v_r, v_z);
    }
}
