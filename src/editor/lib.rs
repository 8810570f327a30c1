//! Language server for decks: the protocol LSP on two byte streams, the texts of open files, and what an editor asks
//! about them. `revolve lsp` serves standard input and output.
#![forbid(unsafe_code)]
#![warn(missing_docs)]
// Links to private items serve readers of the sources.
#![allow(rustdoc::private_intra_doc_links)]

use revolve_host as user;
use revolve_language::{deck, model};
use revolve_numerics::variables;

use revolve_solver::{job, overview};

mod features;
mod outline;
mod protocol;
mod server;
mod text;

pub use server::{EditorError, serve};
pub use text::{ColumnEncoding, TextBuffer, TextPosition, TextRange};
