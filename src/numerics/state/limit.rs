//! Limit of the time increment by loads and motions.

/// Limit of the next increment by an event: it must not extend beyond this time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IncrementLimit {
    /// Time from the current instant.
    pub time: f64,
    /// Whether the force is discontinuous there; central differences are then restarted.
    pub jump: bool,
}

impl IncrementLimit {
    /// No limit.
    pub const NONE: IncrementLimit = IncrementLimit { time: f64::INFINITY, jump: false };

    /// Returns the limit with the smaller time.
    #[inline]
    #[must_use]
    pub fn earlier(self, other: IncrementLimit) -> IncrementLimit {
        if other.time < self.time { other } else { self }
    }
}
