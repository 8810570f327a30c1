//! Numerics of Revolve: arithmetic, degrees of freedom, surfaces, material laws, elements, adaptive meshes, loads, constraints, heat, the
//! resistance of targets, and the interface of user subroutines. The layers above it, and the public interface, are in the crate `revolve`.
#![forbid(unsafe_code)]
#![warn(missing_docs)]
// Links to private items serve readers of the sources.
#![allow(rustdoc::private_intra_doc_links)]

// The name of this crate in the code of derives.
extern crate self as revolve_numerics;

#[allow(missing_docs)]
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
pub mod adaptive;
pub mod codes;
#[allow(missing_docs)]
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
pub mod constraint;
#[allow(missing_docs)]
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
pub mod element;
#[allow(missing_docs)]
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
pub mod heat;
#[allow(missing_docs)]
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
pub mod kernel;
#[allow(missing_docs)]
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
pub mod load;
#[allow(missing_docs)]
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
pub mod material;
#[allow(missing_docs)]
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
pub mod mesh;
pub mod names;
#[allow(missing_docs)]
pub mod platform;
pub mod probability;
pub mod remesh;
pub mod resistance;
pub mod routines;
#[allow(missing_docs)]
#[cfg_attr(not(test), warn(clippy::disallowed_methods))]
pub mod state;
pub mod variables;
