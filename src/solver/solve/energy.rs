//! Energy balance: the work of every force over each increment by the trapezoidal rule, and the total energy, which
//! must be constant.

use serde::Serialize;

use super::energy_supply::EnergySupply;
use crate::element::removed::DeletionTotals;
use crate::load::{EnergyAccount, GeneralizedForce};
use crate::state::BodyState;
use crate::state::archive::Persist;
use crate::state::dofs::Dofs;
use crate::state::energies::{BoundaryFlow, EnergyTotals};

/// Energies at an instant, with ABAQUS names. `ETOTAL = ALLKE + ALLIE + ALLVD + ALLFD + ALLCW + ALLPW + ALLDC + ALLADV +
/// ALLCAV - ALLWK - ALLMW - ALLFKE` is constant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Persist)]
// Heat, penalty, damage and deletion are filled in by their owners.
#[persist(derived: penalty, mass_scaling, added_mass, advection, inflow, flow, damage, heat, internal_heat, removed)]
pub struct Energy {
    /// Kinetic energy ALLKE of nodes and rigid bodies.
    #[serde(rename = "ALLKE")]
    pub kinetic: f64,
    /// Work of prescribed loads and motions.
    #[serde(rename = "ALLWK")]
    pub work: f64,
    /// Energy dissipated by friction.
    #[serde(rename = "ALLFD")]
    pub friction: f64,
    /// Energy dissipated by cavity expansion in targets.
    #[serde(rename = "ALLCAV")]
    pub cavity: f64,
    /// Internal energy: elastic, plastic, artificial, and lost by damage.
    #[serde(rename = "ALLIE")]
    pub internal: f64,
    /// Recoverable strain energy.
    #[serde(rename = "ALLSE")]
    pub strain: f64,
    /// Plastic dissipation.
    #[serde(rename = "ALLPD")]
    pub plastic: f64,
    /// Elastic energy lost by damage; `None` if there is no damage.
    #[serde(rename = "ALLDMD", skip_serializing_if = "Option::is_none")]
    pub damage: Option<f64>,
    /// Energy dissipated by bulk viscosity.
    #[serde(rename = "ALLVD")]
    pub viscous: f64,
    /// Energy lost in contact.
    #[serde(rename = "ALLCW")]
    pub contact: f64,
    /// Energy stored and lost by penalty springs of contact; `None` if none has been under pressure.
    #[serde(rename = "ALLPW", skip_serializing_if = "Option::is_none")]
    pub penalty: Option<f64>,
    /// Work done in propelling mass added by mass scaling; `None` without mass scaling.
    #[serde(rename = "ALLMW", skip_serializing_if = "Option::is_none")]
    pub mass_scaling: Option<f64>,
    /// Mass added by mass scaling, percent of the original mass of the deformable bodies; `None` without mass scaling.
    #[serde(rename = "DMASS", skip_serializing_if = "Option::is_none")]
    pub added_mass: Option<f64>,
    /// Artificial strain energy of hourglass control.
    #[serde(rename = "ALLAE")]
    pub artificial: f64,
    /// Energy dissipated by distortion control.
    #[serde(rename = "ALLDC")]
    pub distortion: f64,
    /// Kinetic energy lost in the transport through adaptive meshes; `None` without such meshes.
    #[serde(rename = "ALLADV", skip_serializing_if = "Option::is_none")]
    pub advection: Option<f64>,
    /// Kinetic energy that has entered through Eulerian boundaries less that which has left; `None` without flow.
    #[serde(rename = "ALLFKE", skip_serializing_if = "Option::is_none")]
    pub inflow: Option<f64>,
    /// Mass, momentum and kinetic energy that have passed through Eulerian boundaries.
    #[serde(skip)]
    pub flow: BoundaryFlow,
    /// Heat from outside; `None` if no temperatures are solved for.
    #[serde(rename = "ALLHF", skip_serializing_if = "Option::is_none")]
    pub heat: Option<f64>,
    /// Internal heat energy; `None` if no temperatures are solved for.
    #[serde(rename = "ALLIHE", skip_serializing_if = "Option::is_none")]
    pub internal_heat: Option<f64>,
    /// Mass and energy of deleted elements; `None` if they are not recorded.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub removed: Option<DeletionTotals>,
    /// Total energy ETOTAL, constant up to integration errors.
    #[serde(rename = "ETOTAL")]
    pub total: f64,
    /// Total energy at the start.
    pub initial: f64,
    /// Largest drift of the total energy, relative to the energy put in.
    pub drift: f64,
}

/// Terms of the energy that are compared with the energy put in, in this order. Contact has its own limits.
pub const TERMS: [&str; 11] =
    ["ALLKE", "ALLIE", "ALLSE", "ALLPD", "ALLDMD", "ALLVD", "ALLAE", "ALLFD", "ALLCAV", "ALLDC", "ALLADV"];
pub const KINETIC: usize = 0;
pub const INTERNAL: usize = 1;
pub const STRAIN: usize = 2;
pub const VISCOUS: usize = 5;
pub const ARTIFICIAL: usize = 6;
pub const ADVECTION: usize = 10;

/// Values of the terms at an instant, the energy put in, and the energy that elements can have released.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyTerms {
    pub values: [f64; TERMS.len()],
    pub put_in: f64,
    pub released: f64,
    /// Viscous heat that can do work again: ALLVD counts it each time, and internal energies pay for it each time.
    pub returned: f64,
}

impl EnergyTerms {
    /// Returns the amounts by which a term is below zero, and above the energy put in. Elements that release energy have
    /// internal energies below zero; the transport in adaptive meshes should lose none. Equation (14.6).
    #[inline(always)]
    pub fn excess(&self, term: usize) -> [f64; 2] {
        let value = self.values[term];
        let lowest = if term == INTERNAL || term == STRAIN { -self.released - self.returned } else { 0.0 };
        let highest = match term {
            ADVECTION => 0.0,
            VISCOUS => self.put_in + self.returned,
            _ => self.put_in,
        };
        [lowest - value, value - highest]
    }

    /// Returns the largest excess of all terms.
    #[inline(always)]
    pub fn largest_excess(&self) -> f64 {
        (0..TERMS.len()).map(|term| self.excess(term)).fold(0.0, |most, [low, high]| most.max(low).max(high))
    }
}

/// Sums that are updated in each increment; [`EnergyBalance::energy`] computes the energies for output.
#[derive(Clone, Debug, Persist)]
// The step has begun when the state is read, so the entries exist.
#[persist(fixed: entries, prescribed)]
pub struct EnergyBalance {
    entries: Vec<ForceWork>,
    prescribed: Vec<PrescribedBody>,
    /// Sums of the previous steps, without the drift.
    previous_steps: Energy,
    kinetic: f64,
    /// Work of all forces on bodies, which should equal the change of their kinetic energy.
    done: f64,
    /// Work of loads and prescribed motions on bodies.
    external: f64,
    /// Work that tied nodes have transferred to bodies.
    tied: f64,
    /// Largest energy so far.
    largest: f64,
    /// Energies that the model can release, and the energy put in.
    pub(super) supply: EnergySupply,
    /// Largest drift of the total energy.
    departure: f64,
    /// Drift of the total energy at the last instant, as a positive energy.
    departure_now: f64,
    /// Kinetic energy that added mass has brought along; part of the work on deformable bodies.
    mass_scaling: f64,
    /// Energies of the deformable bodies.
    solid: EnergyTotals,
    /// Sum of these energies at the start.
    solid_initial: Option<f64>,
}

/// Work of one generalised force in this step.
#[derive(Clone, Copy, Debug, Persist)]
#[persist(derived: body, coordinate, account, external, tied)]
struct ForceWork {
    body: usize,
    coordinate: u32,
    account: EnergyAccount,
    /// 1 for loads and prescribed motions, else 0.
    external: f64,
    /// 1 for forces of tied nodes, else 0.
    tied: f64,
    force: f64,
    last: f64,
    work: f64,
}

impl ForceWork {
    fn add_to(&self, energy: &mut Energy) {
        match self.account {
            EnergyAccount::Work => energy.work += self.work,
            EnergyAccount::Friction => energy.friction -= self.work,
            EnergyAccount::Cavity => energy.cavity -= self.work,
            EnergyAccount::Tie => {}
        }
    }
}

/// A body with prescribed motion: the reaction force does the work that is missing in the change of its kinetic energy.
#[derive(Clone, Copy, Debug, Persist)]
#[persist(derived: body)]
struct PrescribedBody {
    body: usize,
    kinetic: f64,
}

impl EnergyBalance {
    /// Creates the balance at the start of an analysis.
    pub fn start(dofs: &Dofs) -> Self {
        let kinetic = kinetic(dofs);
        EnergyBalance {
            entries: Vec::new(),
            prescribed: Vec::new(),
            previous_steps: Energy { initial: kinetic, ..Energy::default() },
            kinetic,
            done: 0.0,
            external: 0.0,
            tied: 0.0,
            largest: kinetic,
            supply: EnergySupply::default(),
            departure: 0.0,
            departure_now: 0.0,
            mass_scaling: 0.0,
            solid: EnergyTotals::default(),
            solid_initial: None,
        }
    }

    /// Returns whether the sums are finite numbers.
    pub fn is_finite(&self) -> bool {
        self.departure.is_finite()
    }

    /// Returns the energy put in, with which all others are compared. It is the largest energy so far if none was put in.
    #[inline(always)]
    pub fn put_in(&self) -> f64 {
        let put_in = self.supply.put_in();
        if put_in > 0.0 { put_in } else { self.largest }
    }

    /// Returns the largest drift of the total energy, relative to the energy put in.
    pub fn drift(&self) -> f64 {
        let put_in = self.put_in();
        if put_in > 0.0 { self.departure / put_in } else { 0.0 }
    }

    /// Returns the largest drift of the total energy, relative to the largest energy so far: a number of the motion alone,
    /// for digests.
    pub fn drift_over_largest(&self) -> f64 {
        if self.largest > 0.0 { self.departure / self.largest } else { 0.0 }
    }

    /// Returns the terms of the energy at this instant, in the order of [`TERMS`].
    #[inline(always)]
    pub fn terms(&self) -> EnergyTerms {
        let solid = &self.solid;
        EnergyTerms {
            values: [
                self.kinetic + solid.kinetic,
                solid.internal + solid.artificial,
                solid.internal - solid.plastic,
                solid.plastic - solid.damaged,
                solid.damaged,
                solid.viscous,
                solid.artificial,
                solid.friction,
                solid.cavity,
                solid.distortion,
                solid.advection,
            ],
            put_in: self.supply.put_in(),
            released: self.supply.released(),
            returned: self.supply.returned(solid.viscous),
        }
    }

    /// Returns artificial energy over internal energy; 0 if the internal energy is below the fraction `small` of the
    /// energy put in.
    pub fn artificial_share(&self, small: f64) -> f64 {
        let (artificial, internal) = (self.solid.artificial.abs(), self.solid.internal + self.solid.artificial);
        if internal > small * self.put_in() { artificial / internal } else { 0.0 }
    }

    /// Returns whether the largest drift of the total energy exceeds a fraction of the energy put in.
    #[inline]
    pub fn drifts(&self, bound: f64) -> bool {
        self.departure > bound * self.put_in()
    }

    /// Returns whether the ratio of [`EnergyBalance::artificial_share`] exceeds a bound.
    pub fn is_artificial(&self, bound: f64, small: f64) -> bool {
        let (artificial, internal) = (self.solid.artificial.abs(), self.solid.internal + self.solid.artificial);
        internal > small * self.put_in() && artificial > bound * internal
    }

    /// Returns whether the balance includes deformable bodies or contact, so that their energies can be watched.
    #[inline]
    pub fn has_solid(&self) -> bool {
        self.solid_initial.is_some()
    }

    /// Returns the current drift of the total energy, relative to the energy put in.
    pub fn drift_now(&self) -> f64 {
        let put_in = self.put_in();
        if put_in > 0.0 { self.departure_now / put_in } else { 0.0 }
    }

    /// Returns the largest energy so far: kinetic, internal, of the overlaps with which soft contact began, or work of
    /// loads and motions.
    pub fn largest(&self) -> f64 {
        self.largest
    }

    /// Returns the kinetic energy of deformable bodies.
    #[inline(always)]
    pub fn kinetic_of_solid(&self) -> f64 {
        self.solid.kinetic
    }

    /// Returns the energies that viscosity, friction and targets have dissipated in deformable bodies.
    #[inline(always)]
    pub fn dissipated_in_solid(&self) -> [f64; 3] {
        [self.solid.viscous, self.solid.friction, self.solid.cavity]
    }

    /// Returns the energy that contact has stored and dissipated in its normal direction, and the energy that friction
    /// has created. It is negative if contact has created energy.
    #[inline(always)]
    pub fn absorbed_by_contact(&self) -> f64 {
        let created_by_friction = self.solid.friction.min(0.0);
        self.solid.contact + self.solid.penalty + self.solid.initial_overlap + created_by_friction
    }

    /// Begins a step with these forces and prescribed motions of bodies; sums continue if they are the same as before.
    pub fn begin(&mut self, forces: &[GeneralizedForce], bodies: &[BodyState]) {
        let prescribed = || (0..bodies.len()).filter(|&b| bodies[b].prescribed);
        let known_forces = self.entries.iter().map(|e| (e.body, e.coordinate, e.account));
        let same = known_forces.eq(forces.iter().map(|f| (f.body, f.coordinate, f.account)));
        if same && self.prescribed.iter().map(|p| p.body).eq(prescribed()) {
            return;
        }
        self.close_step();
        let entry = |&GeneralizedForce { body, coordinate, account }: &GeneralizedForce| {
            let is = |of| if account == of { 1.0 } else { 0.0 };
            let (external, tied) = (is(EnergyAccount::Work), is(EnergyAccount::Tie));
            ForceWork { body, coordinate, account, external, tied, force: 0.0, last: 0.0, work: 0.0 }
        };
        self.entries = forces.iter().map(entry).collect();
        self.prescribed = prescribed().map(|body| PrescribedBody { body, kinetic: bodies[body].kinetic() }).collect();
    }

    /// Adds the kinetic energy of mass that is added at the current velocities.
    pub fn add_mass_work(&mut self, gained: f64) {
        self.mass_scaling += gained;
    }

    /// Returns the force with this index at the last instant of the balance.
    pub fn force(&self, index: usize) -> f64 {
        self.entries[index].force
    }

    /// Replaces the forces at this instant.
    pub fn take_forces(&mut self, forces: &[f64]) {
        self.entries.iter_mut().zip(forces).for_each(|(entry, &force)| entry.force = force);
    }

    /// Adds the increment that ended at this instant. `after_jump`: the increment ended at a jump of forces, so only
    /// the forces at its start count. `solid_at`: the total time, if the model has deformable bodies.
    #[inline]
    pub fn add_increment(&mut self, dofs: &Dofs, forces: &[f64], after_jump: bool, solid_at: Option<f64>) {
        let bodies = &dofs.bodies;
        let (mut work_of_forces, mut external, mut tied) = (self.done, self.external, self.tied);
        for (entry, &force) in self.entries.iter_mut().zip(forces) {
            let body = &bodies[entry.body];
            let work = body.work(entry.coordinate, [entry.force, force], after_jump);
            entry.force = force;
            entry.last = work;
            entry.work += work;
            work_of_forces += work;
            external += entry.external * work;
            tied += entry.tied * work;
        }
        for prescribed in &mut self.prescribed {
            let now = bodies[prescribed.body].kinetic();
            let on_body = self.entries.iter().filter(|e| e.body == prescribed.body);
            let gained = now - prescribed.kinetic;
            let reaction = gained - on_body.map(|e| e.last).sum::<f64>();
            prescribed.kinetic = now;
            self.previous_steps.work += reaction;
            work_of_forces += reaction;
            external += reaction;
        }
        let kinetic = kinetic(dofs);
        for energy in [kinetic, external.abs()] {
            if energy > self.largest {
                self.largest = energy;
            }
        }
        (self.kinetic, self.done, self.external, self.tied) = (kinetic, work_of_forces, external, tied);
        let mut departure = kinetic - self.previous_steps.initial - work_of_forces;
        // Without deformable bodies, contact still stores and dissipates energy of rigid bodies.
        let EnergyTotals { contact, penalty, friction, .. } = dofs.energies;
        if solid_at.is_some() || contact != 0.0 || penalty != 0.0 || friction != 0.0 {
            departure += self.add_nodes(&dofs.energies, solid_at);
        } else {
            self.supply.take(self.previous_steps.initial + external);
        }
        self.departure_now = departure.abs();
        self.departure = larger(self.departure, self.departure_now);
    }

    /// Adds the energies of deformable bodies, after the rigid bodies; the work of tied nodes on bodies stays in the
    /// model. Returns the change of the sum since the start.
    #[inline(never)]
    fn add_nodes(&mut self, energies: &EnergyTotals, solid_at: Option<f64>) -> f64 {
        self.solid = *energies;
        let sum = energies.sum() + self.tied - energies.external;
        let initial = *self.solid_initial.get_or_insert(if solid_at.is_some() { sum } else { 0.0 });
        let stored = energies.internal.max(energies.initial_overlap);
        self.largest = self.largest.max(energies.kinetic).max(stored).max(energies.external.abs());
        let external_energy =
            self.previous_steps.initial + initial + self.external + energies.external + energies.flow.kinetic;
        self.supply.take_with_elements(external_energy, energies, solid_at.unwrap_or(f64::NEG_INFINITY));
        sum - initial
    }

    /// Adds the work of the ending step to the sums of previous steps.
    fn close_step(&mut self) {
        for entry in std::mem::take(&mut self.entries) {
            entry.add_to(&mut self.previous_steps);
        }
    }

    /// Returns the energies at this instant. Equation (14.1).
    pub fn energy(&self) -> Energy {
        let mut energy = Energy { kinetic: self.kinetic, ..self.previous_steps };
        self.entries.iter().for_each(|entry| entry.add_to(&mut energy));
        let solid = &self.solid;
        energy.kinetic += solid.kinetic;
        energy.work += solid.external - self.mass_scaling;
        energy.mass_scaling = (self.mass_scaling != 0.0).then_some(self.mass_scaling);
        energy.plastic = solid.plastic - solid.damaged;
        energy.damage = (solid.damaged != 0.0).then_some(solid.damaged);
        energy.strain = solid.internal - solid.plastic;
        energy.artificial = solid.artificial;
        energy.distortion = solid.distortion;
        energy.internal = solid.internal + solid.artificial;
        energy.viscous = solid.viscous;
        energy.friction += solid.friction;
        energy.cavity += solid.cavity;
        energy.contact = solid.contact;
        energy.penalty = (solid.penalty != 0.0).then_some(solid.penalty);
        energy.advection = (solid.advection != 0.0).then_some(solid.advection);
        energy.flow = solid.flow;
        energy.inflow = (solid.flow != BoundaryFlow::default()).then_some(solid.flow.kinetic);
        let dissipated =
            energy.friction + energy.cavity + energy.viscous + energy.contact + energy.distortion + solid.advection;
        energy.total = energy.kinetic + energy.internal + dissipated + solid.penalty
            - energy.work
            - self.mass_scaling
            - solid.flow.kinetic;
        energy.initial += self.solid_initial.unwrap_or(0.0);
        energy.drift = self.drift();
        energy
    }
}

/// Returns the kinetic energy of rigid bodies.
fn kinetic(dofs: &Dofs) -> f64 {
    dofs.bodies.iter().map(BodyState::kinetic).sum()
}

/// Returns the larger value, or NaN if one is NaN.
fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

#[cfg(test)]
mod tests {
    use super::{ADVECTION, Dofs, EnergyBalance, EnergyTerms, INTERNAL, KINETIC, STRAIN, TERMS};
    use crate::material::available::AvailableEnergy;
    use crate::state::energies::EnergyTotals;

    fn terms(energies: EnergyTotals, available: f64) -> EnergyTerms {
        let mut dofs = Dofs::default();
        let mut balance = EnergyBalance::start(&dofs);
        balance.supply.begin([(AvailableEnergy::initial(available), 1.0)], 0.0, false);
        dofs.energies.kinetic = 100.0;
        balance.add_increment(&dofs, &[], false, Some(0.0));
        dofs.energies = energies;
        balance.add_increment(&dofs, &[], false, Some(1.0));
        balance.terms()
    }

    /// The course of a metal with an equation of state whose volumes a new mesh has changed: 100 J were put in.
    #[test]
    fn energy_from_nothing_exceeds_what_was_put_in_although_the_sum_is_constant() {
        let energies = EnergyTotals { kinetic: 50.0, internal: -451.0, viscous: 501.0, ..EnergyTotals::default() };
        let terms_of_metal = terms(energies, 0.0);
        assert_eq!(
            [terms_of_metal.put_in, terms_of_metal.excess(INTERNAL)[0], terms_of_metal.excess(5)[1]],
            [100.0, 451.0, 401.0]
        );
        assert_eq!((TERMS[5], terms_of_metal.largest_excess()), ("ALLVD", 451.0));
    }

    /// A gas or an explosive of 400 J drives a body: its internal energy is negative, the kinetic energy above that at
    /// the start. Neither exceeds the energy put in; of a metal, both do.
    #[test]
    fn released_energy_is_no_excess() {
        let energies = EnergyTotals { kinetic: 480.0, internal: -380.0, ..EnergyTotals::default() };
        assert_eq!(terms(energies, 400.0).largest_excess(), 0.0);
        let metal = terms(energies, 0.0);
        assert_eq!([metal.excess(KINETIC)[1], metal.excess(STRAIN)[0]], [380.0, 380.0]);
    }

    /// External work raises the energy put in, also if it flows out again. The transport of momentum should lose nothing,
    /// and has no allowance.
    #[test]
    fn work_counts_and_transport_does_not() {
        let energies = EnergyTotals { kinetic: 140.0, external: 50.0, advection: 10.0, ..EnergyTotals::default() };
        let terms_of_work = terms(energies, 0.0);
        assert_eq!(
            [terms_of_work.put_in, terms_of_work.excess(KINETIC)[1], terms_of_work.excess(ADVECTION)[1]],
            [150.0, -10.0, 10.0]
        );
        let lost = EnergyTotals { kinetic: 100.0, advection: -12.0, ..EnergyTotals::default() };
        assert_eq!(terms(lost, 0.0).largest_excess(), 12.0);
    }

    /// Soft contact begins with energy in its overlaps. The drift is relative to it, although no body moves yet.
    #[test]
    fn drift_is_relative_to_the_energy_of_initial_overlaps() {
        let mut dofs = Dofs::default();
        let mut balance = EnergyBalance::start(&dofs);
        dofs.energies.initial_overlap = 10.0;
        balance.add_increment(&dofs, &[], false, Some(0.0));
        (dofs.energies.contact, dofs.energies.kinetic) = (-0.9, 1.0);
        balance.add_increment(&dofs, &[], false, Some(0.0));
        assert_eq!(balance.put_in(), 10.0);
        assert!((balance.drift() - 0.01).abs() < 1e-15, "{}", balance.drift());
    }
}
