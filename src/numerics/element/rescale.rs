//! Application of mass scaling: factors of due requests, scaled masses of elements and nodes, and the new time
//! increment limit.

use std::collections::BTreeSet;

use super::group::{ElementGroup, GroupSetting};
use super::mass_scaling::{
    AddedMass, ArrivedScaling, MassScaling, ScaledMasses, ScalingRequest, ScalingTarget, StepMassScaling,
};
use super::stable_limit::StableLimit;
use crate::kernel::lanes::InlineMap;
use crate::kernel::topology::PerNode;
use crate::material::PointValue;
use crate::state::Instant;
use crate::state::dofs::Dofs;
use crate::state::nodes::Nodes;

/// Relative resolution of a target within a budget of added mass.
const RESOLUTION: f64 = 1e-6;

/// Set of factors that a request changes.
#[derive(Clone, Copy)]
enum FactorSet {
    Fixed,
    All,
}

impl FactorSet {
    fn of(self, masses: &mut ScaledMasses) -> &mut Vec<Vec<f64>> {
        match self {
            FactorSet::Fixed => &mut masses.fixed,
            FactorSet::All => &mut masses.factors,
        }
    }
}

impl MassScaling {
    /// Stores the current masses as reference of all factors. `linked` marks the nodes with equations or links.
    pub fn store_unscaled(&mut self, groups: &mut [Box<dyn ElementGroup>], nodes: &Nodes, linked: Vec<bool>) {
        groups.iter_mut().for_each(|group| group.configure(GroupSetting::StableRates));
        let elements: Vec<Vec<PerNode<f64>>> =
            groups.iter().map(|g| (0..g.len()).map(|e| g.masses(e)).collect()).collect();
        let ones: Vec<Vec<f64>> = elements.iter().map(|c| vec![1.0; c.len()]).collect();
        let nodes = nodes.mass.clone();
        let (sums, original) = (nodes.clone(), nodes.iter().sum());
        self.masses = Some(Box::new(ScaledMasses {
            nodes,
            elements,
            linked,
            fixed: ones.clone(),
            factors: ones.clone(),
            applied: ones,
            sums,
            rates: Vec::new(),
            original,
            added: 0.0,
            added_to_links: 0.0,
        }));
    }

    /// Returns the mass that scaling has added at nodes that are not nodes of rigid bodies; `None` without mass scaling.
    pub fn added_mass(&self) -> Option<AddedMass> {
        let &ScaledMasses { original, added, added_to_links, .. } = self.masses.as_deref()?;
        Some(AddedMass { original, added, linked: added_to_links })
    }

    /// Returns the mass that scaling adds at nodes of a rigid body, which have no mass themselves.
    pub fn added_to_body(&self, nodes: &[usize]) -> f64 {
        self.masses.as_deref().map_or(0.0, |masses| nodes.iter().map(|&n| masses.sums[n] - masses.nodes[n]).sum())
    }

    /// Returns the factor of mass scaling on the mass of an element; `None` without mass scaling.
    pub fn factor(&self, group: usize, element: usize) -> Option<f64> {
        Some(self.masses.as_deref()?.applied[group][element])
    }

    /// Returns the masses of an element at its nodes without scaling.
    pub fn unscaled_masses(&self, groups: &[Box<dyn ElementGroup>], group: usize, element: usize) -> PerNode<f64> {
        self.masses.as_deref().map_or_else(|| groups[group].masses(element), |m| m.elements[group][element])
    }

    /// Returns the factors of an element: of fixed requests, and the product of all; `None` without mass scaling.
    pub fn factors_of(&self, group: usize, element: usize) -> Option<[f64; 2]> {
        let masses = self.masses.as_deref()?;
        Some([masses.fixed[group][element], masses.factors[group][element]])
    }

    /// Returns the parts of an element's mass that it would have without scaling and with fixed requests alone. Both are
    /// conserved when elements exchange mass.
    pub fn unscaled_shares(&self, group: usize, element: usize) -> [f64; 2] {
        let [fixed, all] = self.factors_of(group, element).unwrap_or([1.0; 2]);
        [1.0 / all, fixed / all]
    }

    /// Takes the corner masses of an element that has exchanged mass with others, and their parts as
    /// [`MassScaling::unscaled_shares`].
    pub fn take_masses(
        &mut self,
        groups: &[Box<dyn ElementGroup>],
        (group, element): (usize, usize),
        scaled: [f64; 4],
        [plain, fixed]: [f64; 2],
    ) {
        let Some(masses) = &mut self.masses else { return };
        let unscaled: PerNode<f64> = scaled.inline_map(|mass| plain * mass).into();
        let previous = std::mem::replace(&mut masses.elements[group][element], unscaled);
        for ((n, previous), now) in groups[group].nodes(element).into_iter().zip(previous).zip(unscaled) {
            masses.nodes[n as usize] += now - previous;
        }
        let inverse = 1.0 / plain;
        masses.fixed[group][element] = fixed * inverse;
        (masses.factors[group][element], masses.applied[group][element]) = (inverse, inverse);
    }

    /// Sums the masses with and without scaling after elements have exchanged mass.
    pub fn sum_masses(&mut self, nodes: &Nodes) {
        if let Some(masses) = &mut self.masses {
            masses.original = masses.nodes.iter().sum();
            masses.sum_added(nodes);
        }
    }

    /// Sets the masses of the elements of a group to those without scaling.
    pub fn remove_from(&self, groups: &mut [Box<dyn ElementGroup>], group: usize) {
        let Some(masses) = &self.masses else { return };
        for (e, plain) in masses.elements[group].iter().enumerate() {
            groups[group].set_masses(e, plain);
        }
    }

    /// Takes the factors of a model in which a group had another mesh, and scales the masses of its new elements.
    pub fn follow_new_mesh(
        &mut self,
        groups: &mut [Box<dyn ElementGroup>],
        previous: &MassScaling,
        group: usize,
        arrived: &ArrivedScaling,
    ) {
        let (Some(masses), Some(before)) = (&mut self.masses, &previous.masses) else { return };
        for g in (0..groups.len()).filter(|g| *g != group) {
            masses.fixed[g].clone_from(&before.fixed[g]);
            masses.factors[g].clone_from(&before.factors[g]);
            masses.applied[g].clone_from(&before.applied[g]);
        }
        (masses.original, masses.added, masses.added_to_links) = (before.original, before.added, before.added_to_links);
        let own_group = &mut groups[group];
        for e in 0..own_group.len() {
            own_group.nodes(e).into_iter().for_each(|n| masses.nodes[n as usize] = 0.0);
        }
        for (e, (plain, [fixed, all])) in arrived.masses.iter().zip(&arrived.factors).enumerate() {
            let nodes = own_group.nodes(e);
            masses.elements[group][e] = (*plain).into();
            nodes.into_iter().zip(plain).for_each(|(n, mass)| masses.nodes[n as usize] += mass);
            (masses.fixed[group][e], masses.factors[group][e], masses.applied[group][e]) = (*fixed, *all, *all);
            own_group.set_masses(e, &masses.scaled(group, e, *all));
        }
        arrived.points.iter().for_each(|(n, mass)| masses.nodes[*n] += mass);
    }

    /// Scales the masses of elements and nodes if due. Returns whether a step starts; `None` if no mass has changed.
    pub(super) fn scale(
        &mut self,
        groups: &mut [Box<dyn ElementGroup>],
        step: &mut StepMassScaling,
        now: &Instant,
        dofs: &mut Dofs,
        changed: &mut dyn FnMut(usize, [f64; 2]),
    ) -> Option<bool> {
        let starts = step.first.is_none();
        let increment = now.increment - *step.first.get_or_insert(now.increment);
        let mut due = false;
        for variable in &mut step.variable {
            due |= variable.take_if_due(increment, now.step_time);
        }
        let masses = self.masses.as_mut().filter(|_| starts || due)?;
        if starts {
            prepare(groups, step, &mut masses.rates);
        }
        if let Some(fixed) = step.fixed.as_ref().filter(|_| starts) {
            masses.fixed.iter_mut().for_each(|list| list.fill(1.0));
            fixed.iter().for_each(|request| masses.find_factors(groups, request, &dofs.nodes, FactorSet::Fixed));
        }
        for (all, fixed) in masses.factors.iter_mut().zip(&masses.fixed) {
            all.copy_from_slice(fixed);
        }
        for variable in &step.variable {
            masses.find_factors(groups, &variable.request, &dofs.nodes, FactorSet::All);
        }
        masses.apply(groups, dofs, changed);
        Some(starts)
    }

    /// Recomputes the limit of the time increment for elements whose mass has decreased. At the start of a step the elements
    /// may have been updated already.
    pub(super) fn raise_limit(&self, groups: &[Box<dyn ElementGroup>], limit: &mut StableLimit, nodes: &Nodes) {
        let Some(masses) = &self.masses else { return };
        for (g, factors) in masses.factors.iter().enumerate() {
            for (e, &factor) in factors.iter().enumerate() {
                let group = &groups[g];
                let scaled = masses.scaled(g, e, factor);
                // The rate of an equation of state that is not scaled is that of its last update.
                if factor == 1.0 && group.properties().equation_of_state {
                    continue;
                }
                let element_rate = group.stable_rate(e, Some(&scaled), nodes.as_slice());
                if let Some(rate) = element_rate.filter(|_| !group.is_deleted(e)) {
                    limit.raise(g, e, rate);
                }
            }
        }
    }
}

/// Allocates the memory of the groups that a step scales, and that of the rates of its elements.
fn prepare(groups: &mut [Box<dyn ElementGroup>], step: &StepMassScaling, rates: &mut Vec<[f64; 2]>) {
    let requests = || step.fixed.iter().flatten().chain(step.variable.iter().map(|v| &v.request));
    let scaled: BTreeSet<usize> = requests().flat_map(|request| &request.elements).map(|at| at.0).collect();
    scaled.into_iter().for_each(|g| groups[g].configure(GroupSetting::MassScales));
    let with_target = requests().filter(|request| request.aim.is_some());
    rates.clear();
    rates.reserve_exact(with_target.map(|request| request.elements.len()).max().unwrap_or(0));
}

/// Returns the largest stable time increment up to `target` for which elements gain at most a fraction `budget` of their mass. Each
/// element is given by the inverse of its stable time increment, and its mass. Equation (4.10).
fn target_within(target: f64, budget: f64, elements: &[[f64; 2]]) -> f64 {
    let allowed = budget * elements.iter().map(|[_, mass]| mass).sum::<f64>();
    let gained = |dt: f64, [rate, mass]: &[f64; 2]| mass * ((dt * rate) * (dt * rate) - 1.0).max(0.0);
    let added = |dt: f64| elements.iter().map(|element| gained(dt, element)).sum::<f64>();
    if added(target) <= allowed {
        return target;
    }
    // The added mass grows with the increment from 0 at that of the fastest element.
    let fastest = elements.iter().map(|[rate, _]| *rate).fold(0.0, f64::max);
    let [mut low, mut high] = [1.0 / fastest, target];
    while high - low > RESOLUTION * high {
        let middle = 0.5 * (low + high);
        *(if added(middle) <= allowed { &mut low } else { &mut high }) = middle;
    }
    low
}

impl ScaledMasses {
    /// Multiplies the current factors by those of one request. The frequency is proportional to the inverse square root
    /// of the mass.
    fn find_factors(
        &mut self,
        groups: &[Box<dyn ElementGroup>],
        request: &ScalingRequest,
        nodes: &Nodes,
        which: FactorSet,
    ) {
        let mut factors = std::mem::take(which.of(self));
        let rate = |factors: &[Vec<f64>], (g, e): (usize, usize)| {
            // A deleted element, or one without a finite rate, has no time increment; its mass is unchanged.
            let group = Some(&groups[g]).filter(|group| !group.is_deleted(e));
            let rate = group.and_then(|group| group.stable_rate(e, Some(&self.elements[g][e]), nodes.as_slice()));
            rate.map(|rate| rate / factors[g][e].sqrt()).filter(|rate| rate.is_finite()).unwrap_or(0.0)
        };
        for &(g, e) in &request.elements {
            factors[g][e] *= request.factor;
        }
        if let Some((aim, target)) = request.aim {
            let mass = |(g, e): (usize, usize)| factors[g][e] * self.elements[g][e].iter().sum::<f64>();
            self.rates.clear();
            self.rates.extend(request.elements.iter().map(|&at| [rate(&factors, at), mass(at)]));
            let dt = request.budget.map_or(target, |budget| target_within(target, budget, &self.rates));
            let largest = self.rates.iter().map(|[rate, _]| *rate).fold(0.0, f64::max);
            for (&(g, e), [own, _]) in request.elements.iter().zip(&self.rates) {
                let element_rate = if aim == ScalingTarget::Uniform { largest } else { *own };
                let ratio = dt * element_rate;
                if element_rate > 0.0 && (aim != ScalingTarget::BelowMin || ratio > 1.0) {
                    factors[g][e] *= ratio * ratio;
                }
            }
        }
        *which.of(self) = factors;
    }

    /// Applies the factors to elements and nodes.
    fn apply(
        &mut self,
        groups: &mut [Box<dyn ElementGroup>],
        dofs: &mut Dofs,
        changed: &mut dyn FnMut(usize, [f64; 2]),
    ) {
        self.sums.copy_from_slice(&self.nodes);
        for (g, group) in groups.iter_mut().enumerate() {
            for e in 0..self.factors[g].len() {
                let factor = self.factors[g][e];
                let (nodes, unscaled) = (group.nodes(e), self.elements[g][e]);
                // Unscaled elements keep the bits of their masses.
                if factor != self.applied[g][e] {
                    group.set_masses(e, &self.scaled(g, e, factor));
                    group.set(e, PointValue::MassScale(factor));
                    self.applied[g][e] = factor;
                }
                for (n, m) in nodes.into_iter().zip(unscaled) {
                    self.sums[n as usize] += (factor - 1.0) * m;
                }
            }
        }
        for (n, &mass) in self.sums.iter().enumerate() {
            // Nodes of rigid bodies have no mass here.
            if self.nodes[n] > 0.0 && mass != dofs.nodes.mass[n] {
                let gained = dofs.nodes.change_mass(n, mass);
                dofs.energies.external += gained[0] + gained[1];
                changed(n, gained);
            }
        }
        self.sum_added(&dofs.nodes);
    }

    /// Sums the mass that scaling has added.
    fn sum_added(&mut self, nodes: &Nodes) {
        self.added = nodes.mass.iter().zip(&self.nodes).map(|(scaled, plain)| scaled - plain).sum();
        let linked = self.linked.iter().zip(nodes.mass.iter().zip(&self.nodes)).filter(|node| *node.0);
        self.added_to_links = linked.fold(0.0, |sum, (_, (scaled, plain))| sum + (scaled - plain));
    }
}
