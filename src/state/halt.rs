//! Why a run stops before its end.
//! Never here: when it does.

/// The reason, with a stable code.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{code}: {reason}")]
pub struct Halt {
    /// Stable code (`R…`).
    pub code: &'static str,
    /// What happened, with the place in the scene.
    pub reason: String,
}
