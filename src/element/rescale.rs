//! Masses that are scaled: factors on elements and nodes where a request is due, and the bound of the increment that follows.
//! Never here: what a deck may request.

use super::elements::Elements;
use super::mass_scaling::{Aim, Masses, Request, Scaling};
use crate::kernel::topology::PerNode;
use crate::state::Instant;
use crate::state::dofs::Dofs;
use crate::state::nodes::Nodes;

/// Factors that a request changes.
#[derive(Clone, Copy)]
enum Which {
    Fixed,
    All,
}

impl Which {
    fn of(self, masses: &mut Masses) -> &mut Vec<Vec<f64>> {
        match self {
            Which::Fixed => &mut masses.fixed,
            Which::All => &mut masses.factors,
        }
    }
}

impl Elements {
    /// Keeps the masses as they are now, from which all factors count; those of the nodes in `left` stay.
    pub fn remember_masses(&mut self, nodes: &Nodes, left: Vec<bool>) {
        let elements: Vec<Vec<PerNode<f64>>> =
            self.groups.iter().map(|g| (0..g.len()).map(|e| g.masses(e)).collect()).collect();
        let ones: Vec<Vec<f64>> = elements.iter().map(|c| vec![1.0; c.len()]).collect();
        let nodes = nodes.mass.clone();
        let sums = nodes.clone();
        self.masses = Some(Box::new(Masses {
            nodes,
            elements,
            left,
            fixed: ones.clone(),
            factors: ones.clone(),
            carried: ones,
            sums,
        }));
    }

    /// Mass that scaling has added so far; `None` without scaling.
    pub fn added_mass(&self, nodes: &Nodes) -> Option<f64> {
        let masses = self.masses.as_deref()?;
        Some(nodes.mass.iter().zip(&masses.nodes).map(|(scaled, plain)| scaled - plain).sum())
    }

    /// Scales the masses where it is due, before the forces of this instant. Tells `changed` of every node with another mass,
    /// and by how much its kinetic energy grew along r and z. Returns whether masses may have changed.
    pub fn scale_masses(
        &mut self,
        scaling: &mut Scaling,
        now: &Instant,
        dofs: &mut Dofs,
        changed: &mut dyn FnMut(usize, [f64; 2]),
    ) -> bool {
        let starts = scaling.first.is_none();
        let increment = now.increment - *scaling.first.get_or_insert(now.increment);
        let mut due = false;
        for variable in &mut scaling.variable {
            due |= variable.take_turn(increment, now.step_time);
        }
        if !(starts || due) {
            return false;
        }
        let Some(mut masses) = self.masses.take() else { return false };
        if let Some(fixed) = scaling.fixed.as_ref().filter(|_| starts) {
            masses.fixed.iter_mut().for_each(|list| list.fill(1.0));
            fixed.iter().for_each(|request| self.find_factors(request, &dofs.nodes, &mut masses, Which::Fixed));
        }
        for (all, fixed) in masses.factors.iter_mut().zip(&masses.fixed) {
            all.copy_from_slice(fixed);
        }
        for variable in &scaling.variable {
            self.find_factors(&variable.request, &dofs.nodes, &mut masses, Which::All);
        }
        self.apply(&mut masses, starts, dofs, changed);
        self.masses = Some(masses);
        true
    }

    /// Factors of one request, on top of those that are there. The frequency falls with the root of the mass.
    fn find_factors(&self, request: &Request, nodes: &Nodes, masses: &mut Masses, which: Which) {
        let mut factors = std::mem::take(which.of(masses));
        let of_element = |masses: &[f64], (g, e): (usize, usize)| {
            let group = &self.groups[g];
            // A deleted element has no increment; its mass stays.
            if group.is_deleted(e) { None } else { group.stable_rate(e, Some(masses), nodes.as_slice()) }
        };
        let rate = |factors: &[Vec<f64>], (g, e): (usize, usize)| {
            let (own, factor) = (self.groups[g].nodes(e), factors[g][e]);
            if own.iter().any(|n| masses.stays(*n)) {
                return of_element(&masses.scaled(g, e, &own, factor), (g, e)).unwrap_or(0.0);
            }
            of_element(&masses.elements[g][e], (g, e)).map_or(0.0, |rate| rate / factor.sqrt())
        };
        for &(g, e) in &request.elements {
            factors[g][e] *= request.factor;
        }
        if let Some((aim, dt)) = request.aim {
            let usable = |rate: f64| rate.is_finite() && rate > 0.0;
            let rates = request.elements.iter().map(|&at| rate(&factors, at));
            let largest = rates.filter(|r| usable(*r)).fold(0.0, f64::max);
            for &(g, e) in &request.elements {
                let own = if aim == Aim::Uniform { largest } else { rate(&factors, (g, e)) };
                let ratio = dt * own;
                if usable(own) && (aim != Aim::BelowMin || ratio > 1.0) {
                    factors[g][e] *= ratio * ratio;
                }
            }
        }
        *which.of(masses) = factors;
    }

    /// Puts factors on elements and nodes. At the start of a step the elements may have been updated already: then the
    /// bound of the increment must serve those whose mass has fallen, too.
    fn apply(&mut self, masses: &mut Masses, starts: bool, dofs: &mut Dofs, changed: &mut dyn FnMut(usize, [f64; 2])) {
        masses.sums.copy_from_slice(&masses.nodes);
        for (g, group) in self.groups.iter_mut().enumerate() {
            for e in 0..masses.factors[g].len() {
                let factor = masses.factors[g][e];
                let (nodes, plain) = (group.nodes(e), masses.elements[g][e]);
                // What is not scaled keeps its masses to the last bit.
                if factor != masses.carried[g][e] {
                    group.extensions().settings().set_masses(e, &masses.scaled(g, e, &nodes, factor));
                    masses.carried[g][e] = factor;
                }
                for (n, m) in nodes.into_iter().zip(plain) {
                    if !masses.stays(n) {
                        masses.sums[n as usize] += (factor - 1.0) * m;
                    }
                }
            }
        }
        for (n, &mass) in masses.sums.iter().enumerate() {
            // What a rigid body carries has no mass here.
            if masses.nodes[n] > 0.0 && mass != dofs.nodes.mass[n] {
                let gained = dofs.nodes.change_mass(n, mass);
                dofs.energies.external += gained[0] + gained[1];
                changed(n, gained);
            }
        }
        if let Some(connectors) = &mut self.connectors {
            connectors.bound(&dofs.nodes);
        }
        if let Some(damping) = &mut self.damping {
            damping.weigh(&self.groups);
        }
        if starts {
            self.bound_again(masses, &dofs.nodes);
        }
    }

    fn bound_again(&mut self, masses: &Masses, nodes: &Nodes) {
        for (g, factors) in masses.factors.iter().enumerate() {
            for (e, &factor) in factors.iter().enumerate() {
                let group = &self.groups[g];
                let scaled = masses.scaled(g, e, &group.nodes(e), factor);
                let own = group.stable_rate(e, Some(&scaled), nodes.as_slice());
                if let Some(rate) = own.filter(|_| !group.is_deleted(e)) {
                    self.raise_limit(g, e, rate);
                }
            }
        }
    }
}
