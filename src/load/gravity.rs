//! A uniform acceleration of mass (`*DLOAD`, GRAV).
//! Never here: forces that do not scale with mass.

use crate::load::Account;
use crate::load::Force;
use crate::load::Slot;
use crate::state::EffectId;
use crate::state::archive::{Archive, Persist};
use crate::state::halt::Halt;
use crate::state::limit::Limit;
use crate::state::magnitude::Magnitude;
use crate::state::{BodyState, Instant};

/// Gravity along z on some bodies.
#[derive(Debug)]
pub struct Gravity {
    /// What asked for it.
    pub cause: EffectId,
    /// `(body, mass it acts on)`.
    pub masses: Vec<(usize, f64)>,
    /// Acceleration along z.
    pub acceleration: Magnitude,
}

impl Force for Gravity {
    fn cause(&self) -> EffectId {
        self.cause
    }

    fn slots(&self) -> Vec<Slot> {
        self.masses.iter().map(|&(body, _)| Slot { body, account: Account::Work }).collect()
    }

    fn evaluate(&mut self, now: &Instant, _bodies: &[BodyState], out: &mut [f64]) -> Result<(), Halt> {
        let acceleration = self.acceleration.at(now);
        for (force, (_, mass)) in out.iter_mut().zip(&self.masses) {
            *force = mass * acceleration;
        }
        Ok(())
    }

    fn limit(&self, now: &Instant, _bodies: &[BodyState]) -> Limit {
        self.acceleration.limit(now)
    }
}

impl Persist for Gravity {
    fn persist(&mut self, _archive: &mut Archive<'_>) {
        let Gravity { cause: _, masses: _, acceleration: _ } = self;
    }
}
