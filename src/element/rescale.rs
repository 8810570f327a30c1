//! Masses that are scaled: factors on elements and nodes where a request is due, and the bound of the increment that follows.
//! Never here: what a deck may request.

use super::elements::Elements;
use super::mass_scaling::{Aim, Masses, Request, Scaling};
use crate::state::Instant;
use crate::state::dofs::Dofs;
use crate::state::nodes::Nodes;

impl Elements {
    /// Keeps the masses as they are now, from which all factors count.
    pub fn remember_masses(&mut self, nodes: &Nodes) {
        let corners: Vec<Vec<[f64; 4]>> =
            self.groups.iter().map(|g| (0..g.len()).map(|e| g.corner_masses(e)).collect()).collect();
        let ones: Vec<Vec<f64>> = corners.iter().map(|c| vec![1.0; c.len()]).collect();
        let nodes = nodes.mass.clone();
        let scaled = nodes.clone();
        self.masses = Some(Box::new(Masses {
            nodes,
            corners,
            fixed: ones.clone(),
            factors: ones.clone(),
            carried: ones,
            scaled,
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
            fixed
                .iter()
                .for_each(|request| self.find_factors(request, &dofs.nodes, &masses.corners, &mut masses.fixed));
        }
        for (all, fixed) in masses.factors.iter_mut().zip(&masses.fixed) {
            all.copy_from_slice(fixed);
        }
        for variable in &scaling.variable {
            self.find_factors(&variable.request, &dofs.nodes, &masses.corners, &mut masses.factors);
        }
        self.apply(&mut masses, starts, dofs, changed);
        self.masses = Some(masses);
        true
    }

    /// Factors of one request, on top of those that are there. The frequency falls with the root of the mass.
    fn find_factors(&self, request: &Request, nodes: &Nodes, corners: &[Vec<[f64; 4]>], factors: &mut [Vec<f64>]) {
        // A deleted element has no increment; its mass stays.
        let rate = |factors: &[Vec<f64>], (g, e): (usize, usize)| {
            let group = &self.groups[g];
            let own = if group.is_deleted(e) { None } else { group.own_rate(e, &corners[g][e], nodes.as_slice()) };
            own.map_or(0.0, |rate| rate / factors[g][e].sqrt())
        };
        for &(g, e) in &request.elements {
            factors[g][e] *= request.factor;
        }
        let Some((aim, dt)) = request.aim else { return };
        let usable = |rate: f64| rate.is_finite() && rate > 0.0;
        let largest = request.elements.iter().map(|&at| rate(factors, at)).filter(|r| usable(*r)).fold(0.0, f64::max);
        for &(g, e) in &request.elements {
            let own = if aim == Aim::Uniform { largest } else { rate(factors, (g, e)) };
            let ratio = dt * own;
            if usable(own) && (aim != Aim::BelowMin || ratio > 1.0) {
                factors[g][e] *= ratio * ratio;
            }
        }
    }

    /// Puts factors on elements and nodes. At the start of a step the elements may have been updated already: then the
    /// bound of the increment must serve those whose mass has fallen, too.
    fn apply(&mut self, masses: &mut Masses, starts: bool, dofs: &mut Dofs, changed: &mut dyn FnMut(usize, [f64; 2])) {
        masses.scaled.copy_from_slice(&masses.nodes);
        for (g, (group, factors)) in self.groups.iter_mut().zip(&masses.factors).enumerate() {
            for (e, &factor) in factors.iter().enumerate() {
                let plain = masses.corners[g][e];
                // What is not scaled keeps its masses to the last bit.
                if factor != masses.carried[g][e] {
                    group.set_corner_masses(e, plain.map(|m| m * factor));
                    masses.carried[g][e] = factor;
                }
                for (n, m) in group.corners(e).into_iter().zip(plain) {
                    masses.scaled[n as usize] += (factor - 1.0) * m;
                }
            }
        }
        for (n, &mass) in masses.scaled.iter().enumerate() {
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
                let own = group.own_rate(e, &masses.corners[g][e].map(|m| m * factor), nodes.as_slice());
                if let Some(rate) = own.filter(|_| !group.is_deleted(e)) {
                    self.raise_limit(g, e, rate);
                }
            }
        }
    }
}
