//! Coarsening of structured meshes: blocks of quadrilaterals, and chains of shells and rigid surface elements, are found
//! and merged before all cards other than those of the mesh are read.

pub mod apply;
mod blocks;
mod chains;
mod kept_lines;
pub mod mesh;
pub mod quadrilaterals;
mod verify;
