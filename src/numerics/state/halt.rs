//! Error that ends a run before its end time.

use std::fmt::{Display, Formatter, Result};

use super::Instant;

/// Details of a halt: its message, and where and when the error occurred.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct HaltDetails {
    /// Description of the error, with its location in the model.
    pub message: String,
    /// Name of the element that caused the error, `12` or `PART.12`, if it was one element.
    pub element: Option<String>,
    /// Time, step and increment of the error; `None` if no increment had begun.
    pub instant: Option<Instant>,
    /// Current place `[r, z]` of the point of a load, or of the centre of the element, if it is known; length.
    pub place: Option<[f64; 2]>,
}

/// Declares the reasons of a halt with their codes.
macro_rules! halt_reasons {
    ($($(#[$doc:meta])* $reason:ident = $code:literal;)*) => {
        /// Reason why a run ended before its end time. [`HaltReason::details`] says where and when. The details are
        /// boxed, so that results of functions within an increment stay small.
        #[derive(Clone, Debug, PartialEq)]
        #[non_exhaustive]
        pub enum HaltReason {
            $($(#[$doc])* $reason(Box<HaltDetails>),)*
        }

        impl HaltReason {
            /// Returns the stable code (`R…`).
            pub fn code(&self) -> &'static str {
                match self {
                    $(HaltReason::$reason(_) => $code,)*
                }
            }

            /// Returns the name of the reason: that of its variant.
            pub fn name(&self) -> &'static str {
                match self {
                    $(HaltReason::$reason(_) => stringify!($reason),)*
                }
            }

            /// Returns message, element, instant and place of the error.
            pub fn details(&self) -> &HaltDetails {
                match self {
                    $(HaltReason::$reason(details) => details,)*
                }
            }

            /// Returns the details for completion.
            pub fn details_mut(&mut self) -> &mut HaltDetails {
                match self {
                    $(HaltReason::$reason(details) => details,)*
                }
            }
        }
    };
}

halt_reasons! {
    /// A user subroutine or a law in Rust failed, or returned an invalid value.
    UserRoutine = "R201";
    /// The resistance of a target is not finite.
    ResistanceNotFinite = "R202";
    /// The energy or an acceleration is not finite.
    NotFinite = "R203";
    /// The next increment is too small to change the time.
    IncrementTooSmall = "R204";
    /// Results could not be written.
    Output = "R205";
    /// An element is inverted, or its state is not finite.
    ElementFailed = "R206";
    /// A signal interrupted the run.
    Interrupted = "R207";
    /// Energy is not conserved, or a limit of `*ENERGY LIMIT` is exceeded.
    EnergyLimit = "R208";
    /// An element has collapsed, so that the step would need too many increments.
    ElementCollapsed = "R209";
    /// A new mesh of a body cannot be used.
    NewMesh = "R210";
}

impl HaltReason {
    /// Returns the description of the error, without its code.
    pub fn message(&self) -> &str {
        &self.details().message
    }

    /// Adds the element that caused the error.
    #[must_use]
    pub fn at_element(mut self, name: &str) -> Self {
        self.details_mut().element = Some(name.to_owned());
        self
    }
}

impl HaltDetails {
    /// Creates details with a message only.
    pub fn new(message: impl Into<String>) -> Box<HaltDetails> {
        Box::new(HaltDetails { message: message.into(), ..HaltDetails::default() })
    }

    /// Creates details with a message and the instant of the error.
    pub fn at_instant(message: impl Into<String>, instant: Instant) -> Box<HaltDetails> {
        Box::new(HaltDetails { instant: Some(instant), ..*HaltDetails::new(message) })
    }
}

impl Display for HaltReason {
    fn fmt(&self, f: &mut Formatter<'_>) -> Result {
        write!(f, "{}: {}", self.code(), self.message())
    }
}

impl std::error::Error for HaltReason {}

/// Writes code and message, as in summaries of runs.
impl serde::Serialize for HaltReason {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}
