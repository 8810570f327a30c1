//! The energy balance: work of every force over each increment by the trapezoid of F du, and the sum that must not change.
//! Never here: forces.

use serde::Serialize;

use crate::element::removed::Books;
use crate::load::{Account, GeneralizedForce};
use crate::state::BodyState;
use crate::state::archive::persist_struct;
use crate::state::dofs::Dofs;
use crate::state::energies::Energies;

/// Energies now, in ABAQUS's names. `ETOTAL = ALLKE + ALLIE + ALLVD + ALLFD + ALLCW + ALLPW + ALLDC + ALLCAV - ALLWK` is constant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Energy {
    /// Kinetic energy.
    #[serde(rename = "ALLKE")]
    pub kinetic: f64,
    /// Work of prescribed loads and motions.
    #[serde(rename = "ALLWK")]
    pub work: f64,
    /// Dissipated by friction.
    #[serde(rename = "ALLFD")]
    pub friction: f64,
    /// Dissipated by opening the cavity.
    #[serde(rename = "ALLCAV")]
    pub cavity: f64,
    /// Internal: strain, plastic and artificial.
    #[serde(rename = "ALLIE")]
    pub internal: f64,
    /// Recoverable strain energy.
    #[serde(rename = "ALLSE")]
    pub strain: f64,
    /// Plastic dissipation.
    #[serde(rename = "ALLPD")]
    pub plastic: f64,
    /// Dissipated by bulk viscosity.
    #[serde(rename = "ALLVD")]
    pub viscous: f64,
    /// Lost where surfaces meet.
    #[serde(rename = "ALLCW")]
    pub contact: f64,
    /// Held and lost by penalty springs of contact; `None` where none has pressed.
    #[serde(rename = "ALLPW", skip_serializing_if = "Option::is_none")]
    pub penalty: Option<f64>,
    /// Artificial: taken by hourglass control.
    #[serde(rename = "ALLAE")]
    pub artificial: f64,
    /// Taken by distortion control.
    #[serde(rename = "ALLDC")]
    pub distortion: f64,
    /// Heat from outside; `None` where no temperatures are solved for.
    #[serde(rename = "ALLHF", skip_serializing_if = "Option::is_none")]
    pub heat: Option<f64>,
    /// Heat taken up, likewise.
    #[serde(rename = "ALLIHE", skip_serializing_if = "Option::is_none")]
    pub internal_heat: Option<f64>,
    /// Books of what deletion took away; `None` where they are not kept.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub removed: Option<Books>,
    /// The sum.
    #[serde(rename = "ETOTAL")]
    pub total: f64,
    /// The sum at the start.
    pub initial: f64,
    /// Largest departure of the sum from its start, over the largest energy met: kinetic, or work of loads and motions.
    pub drift: f64,
}

/// What is booked increment by increment; [`Balance::energy`] sums it up for those who look.
#[derive(Clone, Debug)]
pub struct Balance {
    entries: Vec<Entry>,
    prescribed: Vec<Prescribed>,
    /// Sums of the steps before, without the drift.
    settled: Energy,
    kinetic: f64,
    /// Work of all forces on bodies: what their kinetic energy should have gained.
    done: f64,
    /// The part of loads and motions.
    external: f64,
    /// What tied nodes have passed on to bodies.
    tied: f64,
    largest: f64,
    departure: f64,
    /// Departure at the last instant that was booked, absolute.
    departure_now: f64,
    /// Of what deforms, and their sum at the start.
    solid: Energies,
    solid_initial: Option<f64>,
}

/// The work of one generalised force in this step.
#[derive(Clone, Copy, Debug)]
struct Entry {
    body: usize,
    coordinate: u32,
    account: Account,
    /// 1 for the work of loads and motions, else 0.
    external: f64,
    /// 1 for what comes from tied nodes, else 0.
    tied: f64,
    force: f64,
    last: f64,
    work: f64,
}

impl Entry {
    fn add_to(&self, energy: &mut Energy) {
        match self.account {
            Account::Work => energy.work += self.work,
            Account::Friction => energy.friction -= self.work,
            Account::Cavity => energy.cavity -= self.work,
            Account::Tie => {}
        }
    }
}

/// A body whose motion is prescribed: the reaction does the work that the other forces leave of the change in kinetic
/// energy.
#[derive(Clone, Copy, Debug)]
struct Prescribed {
    body: usize,
    kinetic: f64,
}

impl Balance {
    /// The balance at the start of an analysis.
    pub fn start(dofs: &Dofs) -> Self {
        let kinetic = kinetic(dofs);
        Balance {
            entries: Vec::new(),
            prescribed: Vec::new(),
            settled: Energy { initial: kinetic, ..Energy::default() },
            kinetic,
            done: 0.0,
            external: 0.0,
            tied: 0.0,
            largest: kinetic,
            departure: 0.0,
            departure_now: 0.0,
            solid: Energies::default(),
            solid_initial: None,
        }
    }

    /// Whether the sums are finite numbers.
    pub fn is_finite(&self) -> bool {
        self.departure.is_finite()
    }

    /// Largest departure of the sum from its start, over the largest energy met.
    pub fn drift(&self) -> f64 {
        if self.largest > 0.0 { self.departure / self.largest } else { 0.0 }
    }

    /// Artificial over internal energy, 0 where the internal energy is below a fraction of the largest.
    pub fn artificial_share(&self, small: f64) -> f64 {
        let (artificial, internal) = (self.solid.artificial.abs(), self.solid.internal + self.solid.artificial);
        if internal > small * self.largest { artificial / internal } else { 0.0 }
    }

    /// Whether the drift, and artificial over internal energy as [`Balance::artificial_share`] has it, are above these bounds.
    #[inline]
    pub fn exceeds(&self, [drift, artificial]: [f64; 2], small: f64) -> [bool; 2] {
        let (of_control, internal) = (self.solid.artificial.abs(), self.solid.internal + self.solid.artificial);
        [self.departure > drift * self.largest, internal > small * self.largest && of_control > artificial * internal]
    }

    /// Departure of the sum from its start now, over the largest energy met.
    pub fn drift_now(&self) -> f64 {
        if self.largest > 0.0 { self.departure_now / self.largest } else { 0.0 }
    }

    /// The largest energy met: kinetic, internal, or work of loads and motions.
    pub fn largest(&self) -> f64 {
        self.largest
    }

    /// Kinetic energy of what deforms.
    #[inline(always)]
    pub fn kinetic_of_solid(&self) -> f64 {
        self.solid.kinetic
    }

    /// Internal energy of what deforms, hourglass control included.
    #[inline(always)]
    pub fn internal_of_solid(&self) -> f64 {
        self.solid.internal + self.solid.artificial
    }

    /// Other forces from now on, beside prescribed motions of some bodies; those that are the same go on.
    pub fn begin(&mut self, forces: &[GeneralizedForce], bodies: &[BodyState]) {
        let prescribed = || (0..bodies.len()).filter(|&b| bodies[b].prescribed);
        let own = self.entries.iter().map(|e| (e.body, e.coordinate, e.account));
        let same = own.eq(forces.iter().map(|f| (f.body, f.coordinate, f.account)));
        if same && self.prescribed.iter().map(|p| p.body).eq(prescribed()) {
            return;
        }
        self.settle();
        let entry = |&GeneralizedForce { body, coordinate, account }: &GeneralizedForce| {
            let is = |of| if account == of { 1.0 } else { 0.0 };
            let (external, tied) = (is(Account::Work), is(Account::Tie));
            Entry { body, coordinate, account, external, tied, force: 0.0, last: 0.0, work: 0.0 }
        };
        self.entries = forces.iter().map(entry).collect();
        self.prescribed = prescribed().map(|body| Prescribed { body, kinetic: bodies[body].kinetic() }).collect();
    }

    /// The forces at this instant are these from now on.
    pub fn take_forces(&mut self, forces: &[f64]) {
        self.entries.iter_mut().zip(forces).for_each(|(entry, &force)| entry.force = force);
    }

    /// Books the increment that led to this instant. After one that ended in a jump (`afresh`) the forces behind it count.
    #[inline]
    pub fn book(&mut self, dofs: &Dofs, forces: &[f64], afresh: bool, deforms: bool) {
        let bodies = &dofs.bodies;
        let (mut done, mut external, mut tied) = (self.done, self.external, self.tied);
        for (entry, &force) in self.entries.iter_mut().zip(forces) {
            let body = &bodies[entry.body];
            let work = body.work(entry.coordinate, [entry.force, force], afresh);
            entry.force = force;
            entry.last = work;
            entry.work += work;
            done += work;
            external += entry.external * work;
            tied += entry.tied * work;
        }
        for prescribed in &mut self.prescribed {
            let now = bodies[prescribed.body].kinetic();
            let on_body = self.entries.iter().filter(|e| e.body == prescribed.body);
            let gained = now - prescribed.kinetic;
            let reaction = gained - on_body.map(|e| e.last).sum::<f64>();
            prescribed.kinetic = now;
            self.settled.work += reaction;
            done += reaction;
            external += reaction;
        }
        let kinetic = kinetic(dofs);
        self.largest = self.largest.max(kinetic).max(external.abs());
        (self.kinetic, self.done, self.external, self.tied) = (kinetic, done, external, tied);
        let mut departure = kinetic - self.settled.initial - done;
        // Of rigid bodies alone contact loses energy.
        if deforms || dofs.energies.contact != 0.0 || dofs.energies.friction != 0.0 {
            departure += self.book_nodes(&dofs.energies, deforms);
        }
        self.departure_now = departure.abs();
        self.departure = larger(self.departure, self.departure_now);
    }

    /// Books what deforms, after the bodies: what it passes on to them stays in the scene. Returns by how much its sum has
    /// departed from that at the start.
    fn book_nodes(&mut self, energies: &Energies, deforms: bool) -> f64 {
        self.solid = *energies;
        let sum = energies.sum() + self.tied - energies.external;
        let initial = *self.solid_initial.get_or_insert(if deforms { sum } else { 0.0 });
        self.largest = self.largest.max(energies.kinetic).max(energies.internal).max(energies.external.abs());
        sum - initial
    }

    /// Closes the accounts of the step before.
    fn settle(&mut self) {
        for entry in std::mem::take(&mut self.entries) {
            entry.add_to(&mut self.settled);
        }
    }

    /// The energies now.
    pub fn energy(&self) -> Energy {
        let mut energy = Energy { kinetic: self.kinetic, ..self.settled };
        self.entries.iter().for_each(|entry| entry.add_to(&mut energy));
        let solid = &self.solid;
        energy.kinetic += solid.kinetic;
        energy.work += solid.external;
        energy.plastic = solid.plastic;
        energy.strain = solid.internal - solid.plastic;
        energy.artificial = solid.artificial;
        energy.distortion = solid.distortion;
        energy.internal = solid.internal + solid.artificial;
        energy.viscous = solid.viscous;
        energy.friction += solid.friction;
        energy.cavity += solid.cavity;
        energy.contact = solid.contact;
        energy.penalty = (solid.penalty != 0.0).then_some(solid.penalty);
        let dissipated = energy.friction + energy.cavity + energy.viscous + energy.contact + energy.distortion;
        energy.total = energy.kinetic + energy.internal + dissipated + solid.penalty - energy.work;
        energy.initial += self.solid_initial.unwrap_or(0.0);
        energy.drift = self.drift();
        energy
    }
}

// Of heat, springs and deletion it is told by those who have them.
persist_struct!(Energy {
    kinetic, work, friction, cavity, internal, strain, plastic, viscous, contact, artificial, distortion, total, initial, drift
} derived { penalty, heat, internal_heat, removed });

persist_struct!(Entry { force, last, work } derived { body, coordinate, account, external, tied });

persist_struct!(Prescribed { kinetic } derived { body });

// In a step that has begun: it has the entries of the step.
persist_struct!(Balance {
    entries: fixed,
    prescribed: fixed,
    settled,
    kinetic,
    done,
    external,
    tied,
    largest,
    departure,
    departure_now,
    solid,
    solid_initial
});

/// Kinetic energy of rigid bodies.
fn kinetic(dofs: &Dofs) -> f64 {
    dofs.bodies.iter().map(BodyState::kinetic).sum()
}

/// The larger of two; not a number stays, so that it is found.
fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}
