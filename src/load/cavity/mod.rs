//! Resistance of a target that is not meshed (`CAVITY`): dynamic cavity expansion in layers, with Coulomb friction.
//! Facets are clipped by area at the target's faces and between layers; only those that move into the material are loaded.
//! What bounds the target is in `finite`, what a body ahead has opened already in `shadow` and `tunnel`.
//! Never here: the law itself (`kernel::cavity`), deck words.

mod finite;
mod nose;
mod oblique;
mod plug;
mod rings;
mod shadow;
mod skin;
mod stack;
mod tunnel;

use super::{Account, FlightEnd, LastIncrement, Load, Slot, Unfinished, VelocityUse, View};
use crate::kernel::topology::ElementNodes;
use crate::load::fields::FacetFields;
use crate::mesh::surface::{Patch, Surface};
use crate::state::EffectId;
use crate::state::archive::{Archive, Persist, persist_fields};
use crate::state::dofs::Dofs;
use crate::state::flight::Flight;
use crate::state::halt::Halt;
use crate::state::limit::Limit;
use crate::state::magnitude::Clock;
use crate::state::nodes::Nodes;
use crate::user::Locked;
pub use finite::{Bounds, Crater, Finite};
use nose::Nose;
use oblique::Oblique;
pub use oblique::Tilt;
use skin::Resisted;
pub use stack::Stack;

/// The resistance of one stack on a surface.
#[derive(Clone, Debug)]
pub struct CavityExpansion {
    id: EffectId,
    friction: f64,
    stack: Stack,
    noses: Vec<Nose>,
    /// Bodies with six degrees of freedom.
    oblique: Vec<Oblique>,
    skin: Resisted,
}

impl CavityExpansion {
    /// The resistance of `stack` on a surface with a Coulomb coefficient. `travel` is the fraction of a nose's height that one
    /// increment may move while a plane of the stack cuts it.
    pub fn new(id: EffectId, friction: f64, stack: Stack, surface: Surface, travel: f64) -> Self {
        let noses = surface.patches.iter().map(|patch| Nose::new(patch, &stack, travel)).collect();
        CavityExpansion { id, friction, stack, noses, oblique: Vec::new(), skin: Resisted::new(surface.skin) }
    }

    /// The same on a patch of a body with six degrees of freedom, given by its index, with the planes tilted;
    /// layers follow each other along `direction`.
    #[must_use]
    pub fn with_oblique(
        mut self,
        patch: &Patch,
        flight: (usize, &Flight),
        (tilt, direction): (Tilt, f64),
        travel: f64,
    ) -> Self {
        self.oblique.push(Oblique::new(patch, flight, (tilt, direction), (self.friction, travel)));
        self
    }

    /// The same where nothing acts inside the tunnel that has been opened already; `nodes` are those at the start.
    pub fn separating(mut self, nodes: &Nodes) -> Self {
        self.noses.iter_mut().for_each(Nose::separate);
        self.skin.separate(nodes);
        self
    }

    fn forces_of_a_body(&self) -> usize {
        if self.friction > 0.0 { 2 } else { 1 }
    }
}

impl Load for CavityExpansion {
    fn id(&self) -> EffectId {
        self.id
    }

    fn slots(&self) -> Vec<Slot> {
        let accounts = &[Account::Cavity, Account::Friction][..self.forces_of_a_body()];
        let of_nose = |nose: &Nose| {
            let body = nose.body;
            accounts.iter().map(move |&account| Slot { body, account })
        };
        self.noses.iter().flat_map(of_nose).collect()
    }

    fn unfinished(&self, dofs: &Dofs) -> Vec<(usize, Unfinished)> {
        let of_nose = |nose: &Nose| Some((nose.body, nose.unfinished(&self.stack, &dofs.bodies[nose.body])?));
        self.noses.iter().filter_map(of_nose).collect()
    }

    fn acts_on_nodes(&self) -> bool {
        !self.skin.is_empty()
    }

    fn on_nodes(&mut self, view: &View<'_>, _: &mut Locked<'_>, forces: &mut [[f64; 2]]) -> Result<(), Halt> {
        let refused = self.skin.resist(&self.stack, self.friction, view, forces);
        refused.map_err(|speed| not_finite(view, speed))
    }

    #[inline]
    fn on_bodies(&mut self, view: &View<'_>, _: &mut Locked<'_>, out: &mut [f64]) -> Result<(), Halt> {
        let each = self.forces_of_a_body();
        for (nose, out) in self.noses.iter_mut().zip(out.chunks_exact_mut(each)) {
            let body = &view.dofs.bodies[nose.body];
            let Some([normal, tangential]) = nose.resist(&self.stack, body) else {
                return Err(not_finite(view, body.velocity_load.abs()));
            };
            out[0] = normal;
            if let Some(friction) = out.get_mut(1) {
                *friction = self.friction * tangential;
            }
        }
        Ok(())
    }

    fn on_flights(&mut self, clock: &Clock<'_>, flights: &mut [Flight]) -> Result<(), Halt> {
        let time = clock.now.total_time;
        for oblique in &mut self.oblique {
            oblique
                .resist(&self.stack, flights, time)
                .ok_or_else(|| unbounded(time, flights[oblique.flight()].fastest))?;
        }
        Ok(())
    }

    fn resists(&self) -> Vec<usize> {
        self.oblique.iter().map(Oblique::flight).collect()
    }

    fn ends(&self, dofs: &Dofs) -> Vec<FlightEnd> {
        self.oblique.iter().map(|oblique| oblique.end(&dofs.flights)).collect()
    }

    fn velocity(&self) -> VelocityUse {
        VelocityUse::Resists
    }

    fn limit(&self, view: &View<'_>) -> Limit {
        let noses = self.noses.iter().map(|nose| nose.limit(&self.stack, &view.dofs.bodies[nose.body]));
        let oblique = self.oblique.iter().map(|oblique| oblique.limit(&self.stack, &view.dofs.flights));
        noses.chain(oblique).fold(self.skin.limit(&self.stack, &view.dofs.nodes), Limit::nearer)
    }

    fn dissipated(&self, behind: &LastIncrement<'_>) -> [f64; 2] {
        self.skin.dissipated(behind)
    }

    fn release(&mut self, deleted: &[ElementNodes]) {
        self.skin.release(deleted);
    }

    fn fields(&self, dofs: &Dofs) -> Option<FacetFields> {
        let mut fields = FacetFields::default();
        self.noses.iter().for_each(|nose| nose.show(&self.stack, &dofs.bodies[nose.body], &mut fields));
        self.oblique.iter().for_each(|oblique| oblique.show(&self.stack, &dofs.flights, &mut fields));
        self.skin.show(&self.stack, &dofs.nodes, &mut fields);
        Some(fields)
    }

    fn arrays(&self) -> Vec<(&'static str, usize)> {
        let noses = self.noses.iter().map(Nose::bytes).sum::<usize>() + size_of::<Nose>() * self.noses.capacity();
        let oblique =
            self.oblique.iter().map(Oblique::bytes).sum::<usize>() + size_of::<Oblique>() * self.oblique.capacity();
        vec![("facets", noses + self.skin.bytes()), ("rings", oblique), ("layers", self.stack.bytes())]
    }

    fn copy(&self) -> Box<dyn Load> {
        Box::new(self.clone())
    }
}

#[cold]
fn not_finite(view: &View<'_>, speed: f64) -> Halt {
    unbounded(view.clock.now.total_time, speed)
}

#[cold]
fn unbounded(time: f64, speed: f64) -> Halt {
    Halt { code: "R202", reason: format!("the resistance is not finite at time {time:e}, speed {speed:e}") }
}

impl Persist for CavityExpansion {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let CavityExpansion { id: _, friction: _, stack: _, noses, oblique, skin } = self;
        persist_fields!(archive; noses.as_mut_slice(), skin);
        if !oblique.is_empty() {
            oblique.as_mut_slice().persist(archive);
        }
    }
}
