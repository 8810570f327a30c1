//! Conditions on degrees of freedom above 2, which only some nodes have.

use crate::deck::Span;

/// A condition on degrees of freedom above 2.
#[derive(Clone, Debug)]
pub(super) struct RotationalCondition {
    /// Source position of the data line.
    pub span: Span,
    /// Node set as named in the deck; empty if not known.
    pub set: String,
    /// First and last degree of freedom.
    pub dofs: [u8; 2],
    /// Node indices.
    pub nodes: Vec<usize>,
    /// Intended effect, for the message: `nothing {lost} by this line`.
    pub lost: &'static str,
    /// Prescribed value; it is multiplied with the amplitude.
    pub value: f64,
}
