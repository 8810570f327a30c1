//! A concentrated force (`*CLOAD`).
//! Never here: distributed loads.

use super::{Account, Load, Slot, View};
use crate::state::EffectId;
use crate::state::archive::{Archive, Persist};
use crate::state::flight::{Flight, Wrench};
use crate::state::halt::Halt;
use crate::state::limit::Limit;
use crate::state::magnitude::{Clock, Magnitude};
use crate::user::Locked;

/// The same force along one axis on each of some bodies and nodes.
#[derive(Clone, Debug)]
pub struct Concentrated {
    /// Its row of the ledger.
    pub id: EffectId,
    /// Bodies, pushed along z.
    pub bodies: Vec<usize>,
    /// Bodies with six degrees of freedom, by their index, pushed along 2 at a height on their axis.
    pub flights: Vec<(usize, f64)>,
    /// Nodes.
    pub nodes: Vec<usize>,
    /// 0 along r, 1 along z.
    pub axis: usize,
    /// Force on each.
    pub magnitude: Magnitude,
}

impl Load for Concentrated {
    fn id(&self) -> EffectId {
        self.id
    }

    fn slots(&self) -> Vec<Slot> {
        self.bodies.iter().map(|&body| Slot { body, account: Account::Work }).collect()
    }

    fn acts_on_nodes(&self) -> bool {
        !self.nodes.is_empty()
    }

    fn on_nodes(&mut self, view: &View<'_>, _: &mut Locked<'_>, forces: &mut [[f64; 2]]) -> Result<(), Halt> {
        let force = self.magnitude.at(&view.clock);
        self.nodes.iter().for_each(|&n| forces[n][self.axis] += force);
        Ok(())
    }

    fn on_bodies(&mut self, view: &View<'_>, _: &mut Locked<'_>, out: &mut [f64]) -> Result<(), Halt> {
        out.fill(self.magnitude.at(&view.clock));
        Ok(())
    }

    fn on_flights(&mut self, clock: &Clock<'_>, flights: &mut [Flight]) -> Result<(), Halt> {
        let force = [0.0, self.magnitude.at(clock), 0.0];
        for &(flight, height) in &self.flights {
            let arm = flights[flight].arm([0.0, height], 0.0);
            flights[flight].forces[0].add(&Wrench::at(arm, force));
        }
        Ok(())
    }

    fn limit(&self, view: &View<'_>) -> Limit {
        self.magnitude.limit(&view.clock)
    }

    fn arrays(&self) -> Vec<(&'static str, usize)> {
        let places = size_of::<usize>() * (self.bodies.capacity() + self.nodes.capacity());
        let places = places + size_of::<(usize, f64)>() * self.flights.capacity();
        vec![("places", places), ("amplitude", self.magnitude.bytes())]
    }

    fn copy(&self) -> Box<dyn Load> {
        Box::new(self.clone())
    }
}

impl Persist for Concentrated {
    fn persist(&mut self, _archive: &mut Archive<'_>) {
        let Concentrated { id: _, bodies: _, flights: _, nodes: _, axis: _, magnitude: _ } = self;
    }
}
