//! The language server protocol: the structures of requests and answers. The library lsp-server has the messages.

mod file_uri;
mod structures;

pub use file_uri::{path_of_uri, uri_of_path};
pub use structures::*;
