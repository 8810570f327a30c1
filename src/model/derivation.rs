//! A `*CAVITY EXPANSION, DERIVE` between its card and the end of the deck, when its material is complete.
//! Never here: what comes of it.

use crate::deck::Span;
use crate::resistance::Request;

/// What a card asks for.
pub(super) struct Asked {
    /// Index of the material.
    pub material: usize,
    /// Range and form of the fit.
    pub request: Request,
    /// Radius of the cavity, with which strain rates count.
    pub radius: Option<f64>,
    /// Tension beyond which the target cracks.
    pub tension: Option<f64>,
    /// The card.
    pub span: Span,
}
