//! A concentrated force on bodies (`*CLOAD`).
//! Never here: distributed loads.

use crate::load::Account;
use crate::load::Force;
use crate::load::Slot;
use crate::state::EffectId;
use crate::state::archive::{Archive, Persist};
use crate::state::halt::Halt;
use crate::state::limit::Limit;
use crate::state::magnitude::Magnitude;
use crate::state::{BodyState, Instant};

/// The same force along z on each of some bodies.
#[derive(Debug)]
pub struct Concentrated {
    /// What asked for it.
    pub cause: EffectId,
    /// The bodies it acts on.
    pub bodies: Vec<usize>,
    /// Force.
    pub magnitude: Magnitude,
}

impl Force for Concentrated {
    fn cause(&self) -> EffectId {
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
