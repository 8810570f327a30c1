//! Conditions on degrees of freedom that few nodes have.
//! Never here: what is said of them.

use crate::deck::Span;

/// A condition on degrees of freedom above 2.
#[derive(Clone, Debug)]
pub(super) struct Rotational {
    /// Its line.
    pub span: Span,
    /// What the deck called the nodes; empty where it is not kept.
    pub set: String,
    /// First and last degree of freedom.
    pub dofs: [u8; 2],
    /// Nodes.
    pub nodes: Vec<usize>,
    /// What does not happen where they do not have it.
    pub lost: &'static str,
    /// Magnitude.
    pub value: f64,
}
