//! How far in time something lets an increment go.
//! Never here: the choice of an increment.

/// A bound on the next increment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// From now on.
    pub time: f64,
    /// Whether the force jumps there: central differences then start afresh.
    pub jump: bool,
}

impl Limit {
    pub const NONE: Limit = Limit { time: f64::INFINITY, jump: false };

    #[must_use]
    pub fn nearer(self, other: Limit) -> Limit {
        if other.time < self.time { other } else { self }
    }
}
