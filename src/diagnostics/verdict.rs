//! Verdict of a run in one word, and the effect of diagnostic codes on it, a column of their tables.

use serde::{Deserialize, Serialize};

/// Verdict of a run, from the best to the worst.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The run completed, no check raised an objection, and the uncertainty of its quantities is known.
    #[default]
    Ok,
    /// No check raised an objection, but the uncertainty due to mesh or noise is not known.
    Unverified,
    /// A check found a reason to doubt the results.
    Suspect,
    /// A signal ended the run.
    Interrupted,
    /// The run ended before its end time because of an error.
    Halted,
}

impl Verdict {
    /// Returns the word.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Ok => "ok",
            Verdict::Unverified => "unverified",
            Verdict::Suspect => "suspect",
            Verdict::Interrupted => "interrupted",
            Verdict::Halted => "halted",
        }
    }
}

/// Effect of a diagnostic on the verdict of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct VerdictEffect {
    /// Code of the diagnostic.
    pub code: &'static str,
    /// Best verdict of a run with the diagnostic as a warning or error.
    pub verdict: Verdict,
    /// Cards or command that help.
    pub card: &'static str,
}

/// Defines `CODES`, the explanations, and `EFFECTS`, the effects on the verdict, from lines of code, verdict with the card
/// that helps (absent for information, and for errors that prevent the run), title and text.
#[macro_export]
macro_rules! codes_with_effects {
    ($(#[$doc:meta])* $($code:literal $([$verdict:ident $card:literal])? $title:literal $text:literal)*) => {
        $(#[$doc])*
        pub const CODES: &[$crate::DiagnosticCode] = revolve_numerics::codes! { $($code $title $text)* };

        /// Effects of the codes on the verdict of a run.
        pub const EFFECTS: &[$crate::verdict::VerdictEffect] = &[$($($crate::verdict::VerdictEffect {
            code: $code,
            verdict: $crate::verdict::Verdict::$verdict,
            card: $card,
        },)?)*];
    };
}
