//! Error that ends a run before its end time.

/// Reason why a run ended, with a stable code.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{code}: {reason}")]
pub struct HaltReason {
    /// Stable code (`R…`).
    pub code: &'static str,
    /// Description of the error, with its location in the model.
    pub reason: String,
}
