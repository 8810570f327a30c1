//! The language server protocol: messages on a byte stream, and the structures of requests and answers.

mod file_uri;
mod message;
mod structures;

pub use file_uri::{path_of_uri, uri_of_path};
pub use message::{ErrorCode, ProtocolMessage, RequestId, ResponseError, read_message, write_message};
pub use structures::*;
