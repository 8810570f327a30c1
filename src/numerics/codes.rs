//! Explanations of diagnostic codes, as data. Each layer lists its own codes in a file `codes.rs`.

/// Explanation of a diagnostic code, as `revolve explain CODE` prints it.
#[derive(Debug)]
pub struct DiagnosticCode {
    /// The code, for example `D101`; it does not change between versions.
    pub code: &'static str,
    /// Description in one line.
    pub title: &'static str,
    /// Cause of the diagnostic and how to fix the deck.
    pub text: &'static str,
}

/// Builds a list of [`DiagnosticCode`]s from lines of code, title and text.
#[macro_export]
macro_rules! codes {
    ($($code:literal $title:literal $text:literal)*) => {
        &[$($crate::codes::DiagnosticCode { code: $code, title: $title, text: $text }),*]
    };
}
