//! Language of Revolve: input decks, the model, mesh generation and the resistance of targets. The public interface is in
//! the crate `revolve`.
#![warn(missing_docs)]
// Links to private items serve readers of the sources.
#![allow(rustdoc::private_intra_doc_links)]

use revolve_numerics::{kernel, platform, remesh, variables};
use revolve_results as output;

pub mod deck;
pub mod generate;
pub mod model;
pub mod probability;
pub mod resistance;
