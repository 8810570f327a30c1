//! Temperatures of nodes over time: forward differences of lumped capacities.
//! Never here: what a source is, stresses.

use crate::kernel::lanes::InlineMap;
use std::sync::Arc;

use super::conductors::{Conductors, Largest, at};
use super::sources::{Held, Source};
use crate::constraint::Constraint;
use crate::constraint::bonds::Bonds;
use crate::element::elements::Elements;
use crate::kernel::lists::heap_bytes;
use crate::kernel::topology::ElementNodes;
use crate::state::EffectId;
use crate::state::archive::{Archive, Persist, persist_fields, persist_struct};
use crate::state::dofs::Dofs;
use crate::state::limit::Limit;
use crate::state::magnitude::Clock;

/// What gives and holds heat in a step.
#[derive(Clone, Debug, Default)]
pub struct Conditions {
    pub sources: Vec<Source>,
    /// Temperatures that are held; a node once.
    pub held: Vec<Held>,
    /// Equations between temperatures, with capacities for masses.
    pub bonds: Bonds,
}

/// Heat so far.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeatEnergies {
    /// Given from outside: by fluxes, films and temperatures that are held.
    pub external: f64,
    /// Taken up.
    pub internal: f64,
    /// Made by plastic work and by friction; the first and this are the second.
    pub inelastic: f64,
}

/// Passes in which temperatures that are tied settle, where capacities vary: what is left is of the eighth order in the rise
/// over an increment.
const PASSES: usize = 3;

/// What flows between nodes has as much beside the diagonal as on it (Gershgorin's circles); a tenth more, so that swings die out.
const BESIDE: f64 = 2.2;

/// Temperatures of nodes, with all that changes them.
#[derive(Clone)]
pub struct Heat {
    pub id: EffectId,
    conductors: Arc<Conductors>,
    /// Conditions from a step on; `None` where those of the step before go on.
    steps: Arc<Vec<Option<Conditions>>>,
    now: Conditions,
    /// Mass of each node by material, for capacities that depend on the temperature; empty where none does.
    masses: Vec<Vec<f64>>,
    /// Capacity of each node, where none depends on the temperature; 0 where nothing conducts.
    capacity: Vec<f64>,
    temperature: Vec<f64>,
    /// Heat a time into each node, but for what holds it.
    power: Vec<f64>,
    /// The part of it from outside.
    given: f64,
    /// What films and surfaces in contact take a temperature; empty without any.
    exchange: Vec<f64>,
    /// Temperatures to come before equations share them out; empty without any.
    aims: Vec<f64>,
    /// Heat of corners, and the mean temperatures that elements were given.
    corners: Vec<[f64; 4]>,
    means: Vec<f64>,
    warmed: Vec<f64>,
    largest: Vec<Largest>,
    /// Highest rate, and its element.
    rate: Largest,
    energies: HeatEnergies,
}

impl Heat {
    /// Temperatures at the start, and the conditions of each step; whether surfaces that meet exchange heat.
    pub fn new(
        id: EffectId,
        conductors: Conductors,
        steps: Vec<Option<Conditions>>,
        temperature: Vec<f64>,
        meets: bool,
    ) -> Self {
        let (nodes, count) = (temperature.len(), conductors.list.len());
        let varies = conductors.parts.iter().any(|p| p.properties.capacity.rows.len() > 1);
        let masses = masses(&conductors, nodes);
        let capacity = capacities(&conductors, &masses, &temperature);
        let bound = steps.iter().flatten().any(|s| s.bonds.count() > 0);
        let films = steps.iter().flatten().flat_map(|s| &s.sources).any(Source::exchanges);
        Heat {
            id,
            now: Conditions::default(),
            masses: if varies { masses } else { Vec::new() },
            capacity,
            power: vec![0.0; nodes],
            given: 0.0,
            exchange: if films || meets { vec![0.0; nodes] } else { Vec::new() },
            aims: if bound { vec![0.0; nodes] } else { Vec::new() },
            corners: vec![[0.0; 4]; count],
            means: vec![0.0; count],
            warmed: vec![0.0; count],
            largest: vec![(0.0, 0); conductors.chunks()],
            rate: (0.0, 0),
            energies: HeatEnergies::default(),
            temperature,
            conductors: Arc::new(conductors),
            steps: Arc::new(steps),
        }
    }

    /// A step begins, counted from 0. Returns whether its conditions are others than those before.
    pub fn begin(&mut self, step: usize) -> bool {
        let Some(conditions) = &self.steps[step] else { return false };
        let before = std::mem::replace(&mut self.now, conditions.clone());
        for node in self.now.held.iter_mut().flat_map(|h| &mut h.nodes) {
            let known = before.held.iter().flat_map(|h| &h.nodes).find(|n| n.node == node.node);
            *node = known.copied().unwrap_or(*node);
        }
        true
    }

    fn capacity(&self, node: usize, temperature: f64) -> f64 {
        if self.masses.is_empty() {
            return self.capacity[node];
        }
        let parts = self.conductors.parts.iter().zip(&self.masses);
        parts.map(|(p, masses)| masses[node] * at(&p.properties.capacity, temperature)).sum()
    }

    /// By how much a heat warms a node; with the capacity of the middle, to second order.
    fn rise(&self, node: usize, heat: f64) -> (f64, f64) {
        let first = self.capacity(node, self.temperature[node]);
        let capacity = if self.masses.is_empty() {
            first
        } else {
            self.capacity(node, self.temperature[node] + 0.5 * heat / first)
        };
        (heat / capacity, capacity)
    }

    /// Puts nodes whose temperature is held there; what that takes beyond increments is heat from outside.
    pub(super) fn hold(&mut self, clock: &Clock<'_>) {
        for held in &self.now.held {
            let value = held.magnitude.at(clock);
            for node in held.nodes.iter().map(|n| n.node) {
                let change = value - self.temperature[node];
                let heat = change * self.capacity(node, 0.5 * (value + self.temperature[node]));
                self.temperature[node] = value;
                self.energies.external += heat;
                self.energies.internal += heat;
            }
        }
    }

    pub(super) fn warm(&mut self, elements: &mut Elements) {
        for (mean, conductor) in self.means.iter_mut().zip(&self.conductors.list) {
            *mean = conductor.mean(&self.temperature);
        }
        for part in &self.conductors.parts {
            if let Some(group) = elements.groups[part.group].extensions().temperatures() {
                group.set_temperatures(&self.means[part.first..part.end]);
            }
        }
    }

    /// After elements are updated: takes the heat that plastic work made in them out to their nodes.
    pub fn take(&mut self, elements: &mut Elements) {
        self.warmed.copy_from_slice(&self.means);
        let mut any = false;
        for part in &self.conductors.parts {
            let range = part.first..part.end;
            if let Some(group) = elements.groups[part.group].extensions().temperatures() {
                group.temperatures(&mut self.warmed[range.clone()]);
            }
            for e in range {
                let (rise, conductor) = (self.warmed[e] - self.means[e], &self.conductors.list[e]);
                any |= rise != 0.0;
                let heat = rise * at(&part.properties.capacity, self.means[e] + 0.5 * rise);
                self.corners[e] = conductor.masses.inline_map(|mass| mass * heat);
            }
        }
        if !any {
            return;
        }
        self.power.fill(0.0);
        self.conductors.gather(&self.corners, &mut self.power);
        // What equations take or give is not made by plastic work.
        self.energies.inelastic -= self.share(1.0, None);
        self.now.held.iter_mut().flat_map(|h| &mut h.nodes).for_each(|n| {
            n.made += self.power[n.node];
            self.energies.inelastic += self.power[n.node];
            self.power[n.node] = 0.0;
        });
        for node in 0..self.power.len() {
            let heat = self.power[node];
            if heat != 0.0 {
                self.temperature[node] += self.rise(node, heat).0;
                self.energies.internal += heat;
                self.energies.inelastic += heat;
            }
        }
    }

    /// Heat a time into nodes at this instant, and the rate that bounds the increment, with what constraints may pass on.
    pub fn evaluate(
        &mut self,
        elements: &Elements,
        dofs: &Dofs,
        constraints: &[Box<dyn Constraint>],
        clock: &Clock<'_>,
        threads: bool,
    ) {
        self.hold(clock);
        let Heat { conductors, temperature, corners, largest, power, exchange, .. } = self;
        self.rate = conductors.conduct(temperature, elements, &dofs.nodes, corners, largest, threads);
        power.fill(0.0);
        conductors.gather(corners, power);
        exchange.fill(0.0);
        self.given = 0.0;
        for source in &self.now.sources {
            self.given += source.give((conductors, dofs, temperature), clock, power, exchange);
        }
        let mut exchange = std::mem::take(&mut self.exchange);
        if !exchange.is_empty() {
            let exchanges = constraints.iter().filter_map(|c| c.view().heat);
            exchanges.for_each(|heat| heat.largest_exchange(&mut |n, most| exchange[n] += BESIDE * most));
        }
        let rates = exchange.iter().enumerate().filter(|(_, e)| **e > 0.0);
        let most = rates.map(|(n, e)| e / self.capacity(n, self.temperature[n])).fold(0.0, f64::max);
        self.exchange = exchange;
        // No eigenvalue of a sum is above the sum of the highest.
        self.rate.0 += most;
    }

    /// Lets nodes exchange what it takes that the heat of the time `dt` leaves them with temperatures that satisfy the equations,
    /// with those held that the clock says or that they have: multipliers as in [`crate::constraint::equation`], which are heat.
    /// Returns the sum, which comes from outside; none where coefficients add up to zero, as those of ties do.
    ///
    /// A capacity that varies with the temperature is that of the middle of the way, by Newton's method: each pass squares what
    /// the equations miss by, and no heat is lost whatever they miss by.
    fn share(&mut self, dt: f64, clock: Option<&Clock<'_>>) -> f64 {
        if self.now.bonds.count() == 0 {
            return 0.0;
        }
        let passes = if self.masses.is_empty() { 1 } else { PASSES };
        let sum = (0..passes).map(|_| self.share_once(dt, clock)).sum();
        self.energies.external += sum;
        sum
    }

    fn share_once(&mut self, dt: f64, clock: Option<&Clock<'_>>) -> f64 {
        let (mut aims, mut bonds) = (std::mem::take(&mut self.aims), std::mem::take(&mut self.now.bonds));
        for system in bonds.systems() {
            for (n, _) in system.changes() {
                aims[n] = self.temperature[n] + self.rise(n, dt * self.power[n]).0;
            }
        }
        for held in &self.now.held {
            let value = clock.map(|clock| held.magnitude.at(clock));
            held.nodes.iter().for_each(|h| aims[h.node] = value.unwrap_or(self.temperature[h.node]));
        }
        let mut sum = 0.0;
        for system in bonds.systems() {
            if !self.masses.is_empty() {
                system.weigh(|n| self.rise(n, dt * self.power[n]).1);
            }
            system.balance(|n| aims[n]);
            for (n, heat) in system.changes() {
                self.power[n] += heat / dt;
                sum += heat;
            }
        }
        (self.aims, self.now.bonds) = (aims, bonds);
        sum
    }

    /// Heat that constraints pass on over the increment whose motion they have made.
    pub fn cross(&mut self, constraints: &[Box<dyn Constraint>], dt: f64) {
        if self.exchange.is_empty() {
            return;
        }
        let Heat { power, temperature, energies, .. } = self;
        for exchange in constraints.iter().filter_map(|c| c.view().heat) {
            energies.inelastic += dt * exchange.exchange(temperature, dt, &mut |n, heat| power[n] += heat);
        }
    }

    /// Carries temperatures over an increment; the clock stands at its start.
    pub fn advance(&mut self, clock: &Clock<'_>, dt: f64) {
        let later = clock.later(dt);
        self.energies.external += dt * self.given;
        self.share(dt, Some(&later));
        let mut held = std::mem::take(&mut self.now.held);
        for held in &mut held {
            let value = held.magnitude.at(&later);
            for held in &mut held.nodes {
                let n = held.node;
                let change = value - self.temperature[n];
                let heat = change * self.capacity(n, 0.5 * (value + self.temperature[n]));
                let reaction = heat - std::mem::take(&mut held.made) - dt * self.power[n];
                held.reaction = reaction / dt;
                self.energies.external += reaction;
                self.energies.internal += heat;
                self.temperature[n] = value;
                self.power[n] = 0.0;
            }
        }
        self.now.held = held;
        for n in 0..self.power.len() {
            let heat = dt * self.power[n];
            if heat != 0.0 {
                self.temperature[n] += self.rise(n, heat).0;
                self.energies.internal += heat;
            }
        }
    }

    /// The largest increment that is stable; infinite where nothing flows.
    pub fn stable_increment(&self) -> f64 {
        2.0 / self.rate.0
    }

    /// Group and element with the highest rate.
    pub fn limiting(&self) -> (usize, usize) {
        self.conductors.place(self.rate.1)
    }

    /// How far the next increment may go.
    pub fn limit(&self, clock: &Clock<'_>) -> Limit {
        let sources = self.now.sources.iter().map(|s| s.limit(clock));
        sources.chain(self.now.held.iter().map(|h| h.magnitude.limit(clock))).fold(Limit::NONE, Limit::nearer)
    }

    /// Elements with these boundaries are deleted.
    pub fn release(&mut self, deleted: &[ElementNodes]) {
        self.now.sources.iter_mut().for_each(|s| s.release(deleted));
    }

    /// Temperature of a node; not a number where nothing conducts.
    pub fn temperature(&self, node: usize) -> f64 {
        if self.capacity[node] > 0.0 { self.temperature[node] } else { f64::NAN }
    }

    pub fn temperatures(&self) -> &[f64] {
        &self.temperature
    }

    /// Heat a time that holding a temperature took in the increment behind; 0 where none is held.
    pub fn reaction(&self, node: usize) -> f64 {
        let own = self.now.held.iter().flat_map(|h| &h.nodes).find(|n| n.node == node);
        own.map_or(0.0, |n| n.reaction)
    }

    /// Mean temperature of an element now; `None` where it does not conduct.
    pub fn of_element(&self, group: usize, element: usize) -> Option<f64> {
        Some(self.conductors.find(group, element)?.0.mean(&self.temperature))
    }

    /// The temperatures that elements of a group were given last.
    pub(super) fn given_to(&self, group: usize) -> Option<&[f64]> {
        let part = self.conductors.parts.iter().find(|p| p.group == group)?;
        Some(&self.means[part.first..part.end])
    }

    /// Heat flux along r and z in the middle of an element.
    pub fn flux(&self, group: usize, element: usize, dofs: &Dofs) -> Option<[f64; 2]> {
        let (conductor, part) = self.conductors.find(group, element)?;
        Some(conductor.flux(&self.temperature, &dofs.nodes, &part.properties))
    }

    pub fn energies(&self) -> HeatEnergies {
        self.energies
    }

    pub fn bytes(&self) -> usize {
        let Heat { masses, capacity, temperature, power, exchange, aims, corners, means, warmed, largest, .. } = self;
        let singles = [capacity, temperature, power, exchange, aims, means, warmed];
        let singles = singles.into_iter().chain(masses).map(heap_bytes).sum::<usize>();
        let conditions = self.steps.iter().flatten().chain([&self.now]);
        let sources: usize = conditions.clone().flat_map(|s| &s.sources).map(|s| size_of_val(s) + s.bytes()).sum();
        let bonds: usize = conditions.clone().map(|s| s.bonds.bytes()).sum();
        let held: usize = conditions.flat_map(|s| &s.held).map(|h| size_of_val(&*h.nodes) + h.magnitude.bytes()).sum();
        singles + size_of_val(&**corners) + size_of_val(&**largest) + self.conductors.bytes() + sources + held + bonds
    }
}

/// Capacities of nodes at temperatures, 0 where nothing conducts.
pub fn capacities_at(conductors: &Conductors, temperature: &[f64]) -> Vec<f64> {
    capacities(conductors, &masses(conductors, temperature.len()), temperature)
}

fn masses(conductors: &Conductors, nodes: usize) -> Vec<Vec<f64>> {
    let mut masses = vec![vec![0.0; nodes]; conductors.parts.len()];
    for (part, masses) in conductors.parts.iter().zip(&mut masses) {
        for conductor in &conductors.list[part.first..part.end] {
            conductor.nodes.iter().zip(conductor.masses).for_each(|(&n, m)| masses[n as usize] += m);
        }
    }
    masses
}

fn capacities(conductors: &Conductors, masses: &[Vec<f64>], temperature: &[f64]) -> Vec<f64> {
    let of = |(n, t): (usize, &f64)| {
        conductors.parts.iter().zip(masses).map(|(p, m)| m[n] * at(&p.properties.capacity, *t)).sum()
    };
    temperature.iter().enumerate().map(of).collect()
}

persist_struct!(HeatEnergies { external, internal, inelastic });

impl Persist for Heat {
    /// In a step that has begun: it has the step's conditions.
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Heat {
            id: _,
            conductors: _,
            steps: _,
            now,
            masses: _,
            capacity: _,
            temperature,
            power,
            given,
            exchange: _,
            aims: _,
            corners: _,
            means,
            warmed: _,
            largest: _,
            rate,
            energies,
        } = self;
        archive.mark("heat");
        // Factors follow from capacities; multipliers are solved for anew.
        let Conditions { sources, held, bonds: _ } = now;
        persist_fields!(archive; sources.as_mut_slice(), held.as_mut_slice(), temperature.as_mut_slice());
        persist_fields!(archive; power.as_mut_slice(), given, means.as_mut_slice(), rate, energies);
    }
}
