//! Texts of Revolve: files that are read and written, places in them, numbers, and the diagnostics about them. The public
//! interface is in the crate `revolve`.
#![forbid(unsafe_code)]
#![warn(missing_docs)]
// Links to private items serve readers of the sources.
#![allow(rustdoc::private_intra_doc_links)]

pub mod diagnostic;
pub mod digest;
pub mod files;
pub mod finding;
pub mod lists;
pub mod number;
mod printable;
mod render;
pub mod source;
pub mod untrusted;
pub mod verdict;
pub mod whole;

pub use diagnostic::{Correction, Diagnostic, Diagnostics, Severity};
pub use finding::Finding;
pub use printable::{printable, shortened};
pub use revolve_numerics::codes::DiagnosticCode;
pub use source::{OpenTexts, Sources, Span};
