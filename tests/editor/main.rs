//! The language server `revolve lsp`, driven as an editor drives it: messages over a stream.

#[path = "../common/mod.rs"]
mod common;

mod client;
mod diagnostics;
mod edits;
mod features;
mod session;
