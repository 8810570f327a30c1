//! Contact of surfaces with each other, with themselves and with analytical surfaces. Overlaps do not grow, for any
//! stiffness of the bodies.
//!
//! Each point of one surface of a pair carries a pressure. It is the Lagrange multiplier of the gap in front of the
//! point, weighted with the point's hat function over the surface of revolution ([`gaps`]). The impulses of an
//! increment satisfy `G v + max(g, 0)/dt >= 0` for the velocities `v` after the impulses. Pressures are not negative,
//! and friction is within Coulomb's cone ([`sweeps`]). An existing overlap is kept and not pushed apart. In front of an
//! analytical surface each point has a separate gap ([`analytical`]). Contact does not limit the time increment.

mod active_pairs;
pub mod analytical;
mod analytical_rows;
mod area;
mod bonding;
pub mod cohesion;
mod continuation;
pub mod curve;
mod direct;
mod dofs;
mod gaps;
pub mod heat;
mod impact;
mod initial_gaps;
mod keys;
mod light;
mod measured_gaps;
mod mesh_continuation;
mod mesh_motion;
mod near;
mod new_places;
mod pairs;
mod search;
mod shown;
mod slip_damping;
pub mod stations;
mod stored_energy;
mod surfaces;
mod sweeps;
mod system;
mod user_friction;
pub mod wall_stations;
mod written;

use self::analytical::AnalyticalSurface;
use self::cohesion::{CohesivePair, CohesiveSurfaces};
use self::curve::{FacetCurve, SurfacePoint};
use self::dofs::ContactDofs;
use self::heat::ContactHeat;
use self::impact::ImpactLimit;
use self::initial_gaps::set_initial_gaps;
pub use self::initial_gaps::{AdjustedGap, InitialGaps, SurfaceOverlap};
use self::mesh_continuation::MeshContinuation;
pub use self::pairs::{ContactPair, InitialClearance};
use self::stations::StationContact;
pub use self::system::ContactSystem;
use super::bonds::MergedDofs;
use super::{Constraint, ConstraintForces, MeshMotion, NodeRelation, StoredConstraint};
use crate::kernel::interaction::InteractionLaw;
use crate::kernel::lists::Memory;
use crate::kernel::topology::ElementNodes;
use crate::kernel::traction_separation::TractionSeparationLaw;
use crate::routines::FrictionInput;
use crate::state::EffectId;
use crate::state::archive::{Persist, StateArchive};
use crate::state::dofs::{Dof, Dofs};
use crate::state::halt::HaltReason;
use crate::state::limit::IncrementLimit;
use crate::state::magnitude::AmplitudeClock;

/// Contact of all pairs of a step.
#[derive(Clone, Debug, Default, Persist, Memory)]
#[persist(fixed: stations; present: heat, cohesion; derived: mesh; then: ContactConstraint::list_again)]
#[memory(inside: cohesion, heat, mesh)]
pub struct ContactConstraint {
    pub system: ContactSystem,
    /// Pairs of a rigid body with six degrees of freedom and an analytical surface.
    stations: Vec<StationContact>,
    /// Limit of the time increment by impacts.
    impact: ImpactLimit,
    /// Bonds of surfaces; `None` without cohesive behaviour.
    cohesion: Option<Box<CohesiveSurfaces>>,
    /// Heat exchange; `None` if no temperatures are solved for.
    heat: Option<Box<ContactHeat>>,
    /// Continuation of contact when adaptive meshes change; `None` without such meshes.
    mesh: Option<Box<MeshContinuation>>,
}

impl ContactConstraint {
    /// Creates contact of pairs of curves, and of curves with analytical surfaces.
    pub fn new(
        points: Vec<SurfacePoint>,
        curves: Vec<FacetCurve>,
        analyticals: Vec<AnalyticalSurface>,
        pairs: Vec<ContactPair>,
        laws: Vec<InteractionLaw>,
    ) -> ContactConstraint {
        let system = ContactSystem::new(points, curves, analyticals, pairs, laws);
        ContactConstraint { system, ..ContactConstraint::default() }
    }

    /// Returns the contact with additional pairs of rigid bodies with six degrees of freedom.
    pub fn with_stations(self, stations: Vec<StationContact>) -> ContactConstraint {
        ContactConstraint { stations, ..self }
    }

    /// Returns the contact in which the points of each set of nodes with equal motion have one common degree of freedom.
    /// The first node of a set is the one with the prescribed motion, if there is one; `SurfacePoint::free` of its points
    /// states whether there is.
    pub fn with_equal_motions(mut self, sets: Vec<MergedDofs>) -> ContactConstraint {
        self.system.dofs.merge(sets, &self.system.surfaces.points);
        self.system.surfaces.alike = self.system.dofs.points_that_move_alike();
        self
    }

    /// Sets the node numbers that a user subroutine for friction receives; `number` returns that of a point.
    pub fn with_node_numbers(mut self, number: impl Fn(u32) -> i32) -> ContactConstraint {
        if let Some(friction) = &mut self.system.keys.user_friction {
            friction.numbers = (0..self.system.surfaces.points.len() as u32).map(number).collect();
        }
        self
    }

    /// Returns whether contact points belong to nodes with equal motion.
    pub fn has_equal_motions(&self) -> bool {
        !self.system.dofs.merged.is_empty()
    }

    /// Returns the contact with heat exchange; `has` returns whether a node has a temperature, `of_body` the node with
    /// the temperature of a rigid body.
    pub fn with_heat(
        mut self,
        has: impl Fn(usize) -> bool,
        of_body: impl Fn(usize) -> Option<usize>,
    ) -> ContactConstraint {
        self.heat = Some(Box::new(ContactHeat::of_contact(&self.system, has, of_body)));
        self
    }

    /// Returns the contact with cohesive behaviour of `pairs`, which ascend by the index of the contact pair.
    pub fn with_cohesion(mut self, laws: Vec<TractionSeparationLaw>, pairs: Vec<CohesivePair>) -> ContactConstraint {
        self.cohesion = Some(Box::new(CohesiveSurfaces::new(&mut self.system, laws, pairs)));
        self
    }

    /// Returns the numbers of bonded points and of all points on the secondary surface of a pair; `None` without cohesive
    /// behaviour.
    pub fn bonded_points(&self, pair: usize) -> Option<[usize; 2]> {
        self.cohesion.as_ref()?.bonded_points(&self.system, pair)
    }

    /// Returns the bound of the square of the highest frequency of the bonds.
    pub fn squared_frequency(&self) -> f64 {
        self.cohesion.as_ref().map_or(0.0, |cohesion| cohesion.squared_frequency)
    }

    /// Allocates for changes of adaptive meshes.
    pub fn reserve_mesh_motion(&mut self) {
        if self.mesh.is_none() {
            self.mesh = MeshContinuation::of_contact(&self.system);
        }
    }

    /// Corrects new places of nodes of adaptive meshes, and moves the values of the keys to them. It follows
    /// [`ContactSystem::begin_mesh_motion`].
    pub fn follow_meshes(&mut self, dofs: &Dofs, mesh: &mut dyn MeshMotion) {
        self.reserve_mesh_motion();
        if let Some(continuation) = &mut self.mesh {
            continuation.follow(&mut self.system, dofs, mesh);
        }
    }

    /// Returns the heat exchange across the surfaces; `None` if no temperatures are solved for.
    pub fn heat(&self) -> Option<&ContactHeat> {
        self.heat.as_deref()
    }

    /// Measures the gaps at the start from the coordinates of the points, sets initial clearances and returns the
    /// gaps of each pair.
    pub fn start(&mut self, places: &[[f64; 2]]) -> Vec<InitialGaps> {
        let contact = &mut self.system;
        contact.surfaces.places.copy_from_slice(places);
        contact.search();
        contact.measure(0.0);
        let gaps = set_initial_gaps(contact);
        if let Some(exchange) = &mut self.heat {
            exchange.update(contact);
        }
        if let Some(cohesion) = &mut self.cohesion {
            cohesion.bond_new_pairs(contact);
        }
        contact.surfaces.listed.clear();
        gaps
    }

    /// Moves the bodies over an increment; `friction` is the user subroutine for friction, if contact calls one.
    fn advance(&mut self, dofs: &mut Dofs, dt: f64, friction: Option<FrictionInput<'_>>) -> Result<(), HaltReason> {
        let ContactConstraint { system: contact, stations, impact, cohesion, heat, .. } = self;
        contact.begin_increment(dofs, dt);
        if let Some(exchange) = heat {
            exchange.update(contact);
        }
        if let Some(cohesion) = cohesion {
            cohesion.act(contact, dofs, dt);
        }
        impact.advance(dt);
        impact.limit_impacts(contact, dt);
        let outcome = contact.solve(dofs, dt, friction);
        contact.apply_impulses(dofs, dt);
        if let Some(exchange) = heat {
            exchange.add_friction_heat(contact);
        }
        if let Some(cohesion) = cohesion {
            cohesion.add_work(&contact.dofs, dofs, dt);
        }
        stations.iter_mut().for_each(|stations| stations.act(&mut contact.dofs, dofs, dt));
        contact.dofs.push_bodies(dofs, |dof| cohesion.as_ref().map_or(0.0, |cohesion| cohesion.impulses[dof]));
        contact.keys.add_slip(&contact.measured.rows, &contact.dofs.motion, dt);
        outcome
    }

    /// Completes the velocities at the current instant before a new mesh, with the impulses of contact and of bonds. Returns
    /// the kinetic energy that free degrees of freedom gain.
    pub fn complete_velocities(&mut self, dofs: &mut Dofs) -> f64 {
        let by_contact = self.system.complete_velocities(dofs);
        let by_bonds = self.cohesion.as_mut().map_or(0.0, |bonds| bonds.complete_velocities(&mut self.system, dofs));
        by_contact + by_bonds
    }

    /// Returns the sum of all impulses on a degree of freedom in the previous increment.
    fn whole_impulse(&self, index: usize) -> f64 {
        let [normal, slip] = self.system.dofs.impulses[index];
        normal + slip + self.cohesion.as_ref().map_or(0.0, |cohesion| cohesion.impulses[index])
    }

    /// Informs it that elements with these corner nodes have been deleted.
    pub fn remove_elements(&mut self, deleted: &[ElementNodes]) {
        self.system.surfaces.remove_elements(deleted);
    }

    /// Lists are built again after reading; rows do not depend on when lists were built.
    fn list_again(&mut self, archive: &mut StateArchive<'_>) {
        if archive.reads() {
            self.system.list_again();
            if let Some(cohesion) = &self.cohesion {
                cohesion.check(&self.system, archive);
            }
        }
    }
}

impl Constraint for ContactConstraint {
    fn effect(&self) -> EffectId {
        let of_stations = self.stations.first().map_or(0, |stations| stations.pair.id);
        self.system.pairs.first().map_or(of_stations, |pair| pair.id)
    }

    fn begin(&mut self, dofs: &mut Dofs) {
        self.system.begin(dofs);
        if let Some(cohesion) = &mut self.cohesion {
            cohesion.begin(&mut self.system, dofs);
        }
        self.impact.limit_first_impacts(&mut self.system, dofs);
        let starts = self.system.dofs.half == 0.0;
        self.stations.iter_mut().for_each(|stations| stations.begin(dofs, starts));
    }

    fn accelerations(&mut self, dofs: &mut Dofs, _clock: &AmplitudeClock<'_>) {
        let ContactDofs { half, output_share, bodies, .. } = &self.system.dofs;
        if *half == 0.0 {
            return;
        }
        for known in bodies.iter().filter(|known| known.prescribed) {
            let impulse = self.whole_impulse(known.dof);
            dofs.bodies[known.body].reaction -= impulse / half * output_share;
        }
    }

    fn motion(&mut self, dofs: &mut Dofs, _clock: &AmplitudeClock<'_>, dt: f64) {
        // Without a subroutine nothing fails.
        let _ = self.advance(dofs, dt, None);
    }

    fn motion_with_friction(
        &mut self,
        dofs: &mut Dofs,
        _clock: &AmplitudeClock<'_>,
        dt: f64,
        friction: FrictionInput<'_>,
    ) -> Result<(), HaltReason> {
        self.advance(dofs, dt, Some(friction))
    }

    fn max_increment(&self, _clock: &AmplitudeClock<'_>) -> IncrementLimit {
        let of_stations = self.stations.iter().map(|stations| stations.longest);
        IncrementLimit { time: of_stations.fold(self.impact.increment, f64::min), jump: false }
    }

    fn moves_nodes(&self) -> bool {
        !self.system.pairs.is_empty()
    }

    fn forces(&self) -> Option<&dyn ConstraintForces> {
        Some(self)
    }
}

impl ConstraintForces for ContactConstraint {
    fn constraint_force(&self, dof: Dof) -> f64 {
        let ContactDofs { half, output_share, .. } = self.system.dofs;
        if half == 0.0 {
            return 0.0;
        }
        self.index_of(dof).map_or(0.0, |index| self.whole_impulse(index) / half * output_share)
    }

    fn index_of(&self, dof: Dof) -> Option<usize> {
        self.system.dofs.index_of_prescribed(dof)
    }

    fn impulse(&self, _dof: Dof, index: usize, _half: f64) -> f64 {
        self.whole_impulse(index)
    }
}

impl StoredConstraint for ContactConstraint {
    fn continue_from(&mut self, previous: &dyn Constraint) {
        if let Some(previous) = previous.as_kind() {
            self.take_over(previous);
        }
    }

    fn follow_new_mesh(&mut self, previous: &dyn Constraint, nodes: &NodeRelation<'_>, dofs: &Dofs) {
        if let Some(previous) = previous.as_kind() {
            self.move_to_new_mesh(previous, nodes, dofs);
        }
    }
}
