//! A uniform acceleration of mass along z (`*DLOAD`, GRAV).
//! Never here: forces that do not scale with mass.

use super::{Account, Load, Slot, View};
use crate::state::EffectId;
use crate::state::archive::{Archive, Persist, persist_fields};
use crate::state::flight::{Flight, Wrench};
use crate::state::halt::Halt;
use crate::state::limit::Limit;
use crate::state::magnitude::{Clock, Magnitude};
use crate::user::Locked;

/// Gravity along z on some bodies and nodes.
#[derive(Clone, Debug)]
pub struct Gravity {
    /// Its row of the ledger.
    pub id: EffectId,
    /// `(body, mass it acts on)`.
    pub bodies: Vec<(usize, f64)>,
    /// Bodies with six degrees of freedom, by their index: the mass of each.
    pub flights: Vec<(usize, f64)>,
    /// `(node, mass it acts on)`.
    pub nodes: Vec<(usize, f64)>,
    /// Whether it acts on all of the nodes' mass, whatever that becomes.
    pub whole: bool,
    /// Acceleration along z.
    pub acceleration: Magnitude,
    /// Acceleration along 1, of bodies with six degrees of freedom.
    pub across: Magnitude,
}

impl Load for Gravity {
    fn id(&self) -> EffectId {
        self.id
    }

    fn slots(&self) -> Vec<Slot> {
        self.bodies.iter().map(|&(body, _)| Slot { body, account: Account::Work }).collect()
    }

    fn acts_on_nodes(&self) -> bool {
        !self.nodes.is_empty()
    }

    fn on_nodes(&mut self, view: &View<'_>, _: &mut Locked<'_>, forces: &mut [[f64; 2]]) -> Result<(), Halt> {
        let acceleration = self.acceleration.at(&view.clock);
        self.nodes.iter().for_each(|&(n, mass)| forces[n][1] += mass * acceleration);
        Ok(())
    }

    fn on_bodies(&mut self, view: &View<'_>, _: &mut Locked<'_>, out: &mut [f64]) -> Result<(), Halt> {
        let acceleration = self.acceleration.at(&view.clock);
        for (force, (_, mass)) in out.iter_mut().zip(&self.bodies) {
            *force = mass * acceleration;
        }
        Ok(())
    }

    fn on_flights(&mut self, clock: &Clock<'_>, flights: &mut [Flight]) -> Result<(), Halt> {
        let (along, across) = (self.acceleration.at(clock), self.across.at(clock));
        for &(flight, mass) in &self.flights {
            let force = [mass * across, mass * along, 0.0];
            flights[flight].forces[0].add(&Wrench { force, moment: [0.0; 3] });
        }
        Ok(())
    }

    fn limit(&self, view: &View<'_>) -> Limit {
        self.acceleration.limit(&view.clock)
    }

    fn weigh(&mut self, mass: &[f64]) {
        if self.whole {
            self.nodes.iter_mut().for_each(|m| m.1 = mass[m.0]);
        }
    }

    fn arrays(&self) -> Vec<(&'static str, usize)> {
        let masses =
            size_of::<(usize, f64)>() * (self.bodies.capacity() + self.flights.capacity() + self.nodes.capacity());
        vec![("masses", masses), ("amplitude", self.acceleration.bytes() + self.across.bytes())]
    }

    fn copy(&self) -> Box<dyn Load> {
        Box::new(self.clone())
    }
}

impl Persist for Gravity {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Gravity { id: _, bodies: _, flights: _, nodes, whole: _, acceleration: _, across: _ } = self;
        persist_fields!(archive; nodes.as_mut_slice());
    }
}
