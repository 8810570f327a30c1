//! Language of Revolve: input decks, the model and mesh generation. The public interface is in
//! the crate `revolve`.
#![forbid(unsafe_code)]
#![warn(missing_docs)]
// Links to private items serve readers of the sources.
#![allow(rustdoc::private_intra_doc_links)]

use revolve_numerics::{kernel, material, platform, remesh, resistance, variables};
use revolve_results as output;

pub mod deck;
pub mod generate;
pub mod model;
