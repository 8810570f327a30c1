//! A concentrated force on bodies (`*CLOAD`).
//! Never here: distributed loads.

use super::{Account, Cause, Force, Halt, Limit, Magnitude, Slot};
use crate::state::archive::{Archive, Persist};
use crate::state::{BodyState, Instant};

/// The same force along z on each of some bodies.
#[derive(Debug)]
pub struct Concentrated {
    /// What asked for it.
    pub cause: Cause,
    /// The bodies it acts on.
    pub bodies: Vec<usize>,
    /// Force.
    pub magnitude: Magnitude,
}

impl Force for Concentrated {
    fn cause(&self) -> Cause {
        self.cause
    }

    fn slots(&self) -> Vec<Slot> {
        self.bodies.iter().map(|&body| Slot { body, account: Account::Work }).collect()
    }

    fn evaluate(&mut self, now: &Instant, _bodies: &[BodyState], out: &mut [f64]) -> Result<(), Halt> {
        out.fill(self.magnitude.at(now));
        Ok(())
    }

    fn limit(&self, now: &Instant, _bodies: &[BodyState]) -> Limit {
        self.magnitude.limit(now)
    }
}

impl Persist for Concentrated {
    fn persist(&mut self, _archive: &mut Archive<'_>) {
        let Concentrated { cause: _, bodies: _, magnitude: _ } = self;
    }
}
