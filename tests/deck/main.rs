//! The deck language, the meaning of keywords, and mesh files.

#[path = "../common/mod.rs"]
mod common;

mod dialects;
mod histories;
mod language;
mod mesh_files;
mod mesh_groups;
mod mistakes;
mod test_data;
mod variables;
mod words;
mod writers;
