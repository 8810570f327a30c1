//! A `*COUPLING` between its card and the one that says its kind.
//! Never here: what is coupled how.

use crate::deck::Span;

/// A `*COUPLING` that waits for its kind.
pub(super) struct Coupling {
    /// Upper-case name.
    pub name: String,
    /// Reference node.
    pub reference: usize,
    /// Nodes of the surface, ascending.
    pub nodes: Vec<usize>,
    /// Tributary area of each node; one each for a surface of nodes.
    pub areas: Vec<f64>,
    /// The card.
    pub span: Span,
}
