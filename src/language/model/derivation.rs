//! A request of `*CAVITY EXPANSION, DERIVE`, stored until its material is complete.

use crate::deck::Span;
use crate::resistance::{CavityShape, FitRequest};

/// A request to derive cavity expansion constants.
pub(super) struct DerivationRequest {
    /// Index of the material whose resistance is derived.
    pub material: usize,
    /// Range and form of the fit.
    pub request: FitRequest,
    /// Shape of the cavity.
    pub shape: CavityShape,
    /// Radius of the cavity, which determines strain rates; `None` for quasi-static constants.
    pub radius: Option<f64>,
    /// Tensile strength at which the target cracks.
    pub tension: Option<f64>,
    /// Source position of the card.
    pub span: Span,
}
