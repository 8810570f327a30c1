//! Words: the deck language, what a deck means, mesh files.

#[path = "../common/mod.rs"]
mod common;

mod dialects;
mod histories;
mod language;
mod mesh_files;
mod mistakes;
mod variables;
mod words;
