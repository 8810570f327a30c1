//! Texts of open files: positions as the protocol counts them, and an editable text in blocks of lines.

mod block;
mod buffer;
mod position;

pub use buffer::TextBuffer;
pub use position::{ColumnEncoding, TextPosition, TextRange};
