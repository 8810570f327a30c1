//! Revolve.
#![warn(missing_docs)]
pub mod deck;
pub mod model;
pub mod output;
pub mod user;
