//! `*MPC`, `*COUPLING`, `*TIE` and `*EQUATION` as equations between solver nodes and sets of nodes that move together.
//! Nodes that follow a rigid body become part of the body.

use std::collections::HashSet;

use indexmap::IndexMap;

use super::{Compiler, State};
use crate::constraint::bonds::{MergedDofs, NodalEquation};
use crate::deck::{Diagnostic, Span};
use crate::model::{self, LinkKind, NodeLink, RigidBody};

/// Equations and links between solver nodes, which are active in all steps.
#[derive(Debug, Default)]
pub(super) struct LinkSet {
    /// Equations, and the card of each.
    pub equations: Vec<NodalEquation>,
    pub spans: Vec<Span>,
    /// Sets of nodes with equal motion along an axis.
    pub merged: Vec<MergedDofs>,
    /// Index in `merged` of the set that contains a node and axis.
    group: IndexMap<(usize, usize), usize>,
    /// First card with an equation or link.
    pub first: Option<Span>,
}

impl LinkSet {
    /// Returns whether there are no equations and links.
    pub fn is_empty(&self) -> bool {
        self.equations.is_empty() && self.merged.is_empty()
    }

    /// Gives two nodes the same motion along an axis; the first one is the leader. Returns `false` if they already had
    /// it.
    fn merge(&mut self, leader: usize, node: usize, axis: usize) -> bool {
        match (self.group.get(&(leader, axis)).copied(), self.group.get(&(node, axis)).copied()) {
            (Some(a), Some(b)) if a == b => return leader == node,
            (Some(a), Some(b)) => {
                let moved = std::mem::take(&mut self.merged[b].nodes);
                moved.iter().for_each(|&n| {
                    self.group.insert((n, axis), a);
                });
                self.merged[a].nodes.extend(moved);
            }
            (Some(a), None) => self.add(a, node, axis),
            (None, Some(b)) => {
                self.merged[b].nodes.insert(0, leader);
                self.group.insert((leader, axis), b);
            }
            (None, None) => {
                self.merged.push(MergedDofs { nodes: Vec::new(), axis });
                let group = self.merged.len() - 1;
                self.add(group, leader, axis);
                self.add(group, node, axis);
            }
        }
        true
    }

    /// Returns the set of nodes with the same motion as a node along an axis.
    pub fn merged_with(&self, node: usize, axis: usize) -> Option<&MergedDofs> {
        self.merged.get(*self.group.get(&(node, axis))?)
    }

    fn add(&mut self, group: usize, node: usize, axis: usize) {
        self.merged[group].nodes.push(node);
        self.group.insert((node, axis), group);
    }

    fn equation(&mut self, terms: Vec<(usize, usize, f64)>, spare: bool, span: Span) {
        self.equations.push(NodalEquation { terms, is_redundant: spare });
        self.spans.push(span);
    }

    /// Returns the degrees of freedom (node, axis) in equations, and those with the same motion as one in an equation.
    pub fn dofs_of_equations(&self) -> HashSet<(usize, usize)> {
        let mut dofs: HashSet<(usize, usize)> = self.terms().collect();
        for MergedDofs { nodes, axis } in &self.merged {
            if nodes.iter().any(|&n| dofs.contains(&(n, *axis))) {
                dofs.extend(nodes.iter().map(|&n| (n, *axis)));
            }
        }
        dofs
    }

    /// Returns the sets of nodes with equal motion, the node with a prescribed motion first, and the degrees of freedom
    /// of the sets with a prescribed motion.
    pub fn equal_motions(&self, prescribed: &HashSet<(usize, usize)>) -> (Vec<MergedDofs>, HashSet<(usize, usize)>) {
        let (mut sets, mut given) = (self.merged.clone(), HashSet::new());
        for MergedDofs { nodes, axis } in &mut sets {
            if let Some(leader) = nodes.iter().position(|&n| prescribed.contains(&(n, *axis))) {
                nodes.swap(0, leader);
                given.extend(nodes.iter().map(|&n| (n, *axis)));
            }
        }
        (sets, given)
    }

    /// Returns the degrees of freedom (node, axis) in equations and links.
    pub fn involved_dofs(&self) -> HashSet<(usize, usize)> {
        self.group.keys().copied().chain(self.terms()).collect()
    }

    fn terms(&self) -> impl Iterator<Item = (usize, usize)> {
        self.equations.iter().flat_map(|e| e.terms.iter().map(|t| (t.0, t.1)))
    }
}

impl Compiler<'_> {
    /// Adds to `nodes` the nodes that follow a rigid body because they are linked to one of its nodes or tied to one of
    /// its elements, directly or through other added nodes.
    pub(super) fn add_followers_of_body(&self, rigid: &RigidBody, nodes: &mut Vec<usize>) {
        let model = self.model;
        if model.constraints.links.is_empty() && self.surface_ties.is_empty() {
            return;
        }
        let mut own: HashSet<usize> = nodes.iter().copied().collect();
        let elements: HashSet<usize> = rigid.elements.iter().copied().collect();
        let on_body = self.surface_ties.iter().filter(|t| elements.contains(&t.element)).map(|t| t.node);
        own.extend(on_body);
        loop {
            let before = own.len();
            for link in model.constraints.links.iter().filter(|l| l.kind == LinkKind::Rigid([true; 2])) {
                if own.contains(&link.reference) {
                    own.extend(&link.nodes);
                }
            }
            if own.len() == before {
                break;
            }
        }
        *nodes = own.into_iter().collect();
    }

    /// Returns the nodes of links, ties and equations that do not belong to a rigid body, the ends of springs and
    /// dashpots, and the reference nodes of rigid bodies with a temperature. They are solver nodes also if they have no element.
    pub(super) fn linked_nodes(&self) -> Vec<usize> {
        let model = self.model;
        let sprung = model.discrete.connectors.iter().flat_map(|property| &property.elements);
        let ends = sprung.flat_map(|&e| model.mesh.elements[e].nodes.iter());
        let linked = model.constraints.links.iter().flat_map(|l| l.nodes.iter().chain([&l.reference]));
        let tied = self.surface_ties.iter().map(|t| &t.node);
        let moving = model.constraints.equations.iter().filter(|e| !e.is_thermal());
        let terms = moving.flat_map(|e| e.terms.iter().map(|t| &t.0));
        let free = |n: &&usize| !self.body_of_node.contains_key(*n);
        let heated = self.heated_references();
        linked.chain(tied).chain(terms).filter(free).chain(ends).chain(&heated).copied().collect()
    }

    /// Collects all equations and links, and gives linked nodes the initial velocity of their reference node.
    pub(super) fn collect_links(&mut self, state: &mut State) {
        let model = self.model;
        for link in &model.constraints.links {
            self.add_link(link);
        }
        self.add_surface_ties();
        for equation in model.constraints.equations.iter().filter(|e| !e.is_thermal()) {
            if !self.add_equation(equation, &state.dofs.nodes.mass) {
                let message =
                    "*EQUATION is supported only for nodes of deformable bodies that are not tied to a rigid body";
                let finding = Diagnostic::error("P011", message).at(equation.span, "this equation has other nodes");
                self.diagnostics.push(finding);
                break;
            }
        }
        self.links.merged.retain(|a| !a.nodes.is_empty());
        self.unresisted_dofs = self.find_unresisted_dofs(&state.dofs.nodes.mass);
        self.start_with_references(state);
    }

    fn add_link(&mut self, link: &NodeLink) {
        let names = &self.model.mesh.node_names;
        let reference = &names[link.reference];
        let axes = match &link.kind {
            LinkKind::Rigid([true, true]) => "r and z",
            LinkKind::Rigid([true, false]) => "r",
            LinkKind::Rigid(_) => "z",
            LinkKind::Distributing(_) => "z (weighted mean)",
        };
        let detail = format!("{}: follow node {reference} along {axes}, no rotation", link.name);
        if self.body_of_node.contains_key(&link.reference) {
            if link.kind != LinkKind::Rigid([true; 2]) {
                let message =
                    format!("{}: node {reference} belongs to a rigid body, which moves along z only", link.name);
                let help = "couple all degrees of freedom, or give the nodes as TIE NSET of the *RIGID BODY";
                self.refuse_link(link.span, message, help);
                return;
            }
            self.ledger_row(link.span, "reference node", link.nodes.len(), "nodes", detail);
            return;
        }
        let rigid = link.nodes.iter().find(|n| self.body_of_node.contains_key(*n));
        if let Some(&node) = rigid {
            let message =
                format!("{}: node {} belongs to a rigid body and cannot follow another node", link.name, names[node]);
            self.refuse_link(
                link.span,
                message,
                "move or load the REF NODE of the rigid body, or use it as the reference node",
            );
            return;
        }
        let place = |n: &usize| self.places.free_node(*n);
        let (Some(leader), Some(nodes)) =
            (place(&link.reference), link.nodes.iter().map(place).collect::<Option<Vec<_>>>())
        else {
            let message = format!("{} links nodes of a model without deformable bodies", link.name);
            self.refuse_link(link.span, message, "use *RIGID BODY, TIE NSET= for a rigid body of nodes");
            return;
        };
        match &link.kind {
            LinkKind::Rigid(axes) => {
                for axis in [0, 1].into_iter().filter(|&a| axes[a]) {
                    nodes.iter().for_each(|&n| {
                        self.links.merge(leader, n, axis);
                    });
                }
            }
            LinkKind::Distributing(weights) => {
                let sum: f64 = weights.iter().sum();
                let own = nodes.iter().zip(weights).filter(|w| *w.1 > 0.0).map(|(&n, w)| (n, 1, -w / sum));
                let terms = std::iter::once((leader, 1, 1.0)).chain(own).collect();
                self.links.equation(terms, false, link.span);
            }
        }
        self.links.first.get_or_insert(link.span);
        self.ledger_row(link.span, "reference node", link.nodes.len(), "nodes", detail);
    }

    fn refuse_link(&mut self, span: Span, message: String, help: &str) {
        self.diagnostics.push(Diagnostic::error("P060", message).at(span, "here").help(help));
    }

    fn add_surface_ties(&mut self) {
        let model = self.model;
        let ties = std::mem::take(&mut self.surface_ties);
        for tied in &ties {
            let span = model.constraints.ties[tied.tie].span;
            if self.body_of_element.contains_key(&tied.element) {
                continue;
            }
            if self.body_of_node.contains_key(&tied.node) {
                let name = &model.mesh.node_names[tied.node];
                let message = format!("node {name} of the slave surface belongs to a rigid body");
                self.refuse_link(
                    span,
                    message,
                    "make the surface of the rigid body the master surface: give it second",
                );
                break;
            }
            let place = |n: usize| self.places.nodes.get(&n).copied();
            let shares: Option<Vec<_>> = tied.shares.iter().map(|&(n, share)| Some((place(n)?, share))).collect();
            let (Some(node), Some(shares)) = (place(tied.node), shares) else {
                let message =
                    "the master surface of a tie has elements that belong neither to a deformable nor to a rigid body";
                self.refuse_link(span, message.into(), "give the elements a *SOLID SECTION");
                break;
            };
            for axis in [0, 1] {
                if let [(master, _)] = shares[..] {
                    self.links.merge(master, node, axis);
                } else {
                    let masters = shares.iter().map(|&(n, share)| (n, axis, -share));
                    let terms = std::iter::once((node, axis, 1.0)).chain(masters).collect();
                    self.links.equation(terms, true, span);
                }
            }
            self.links.first.get_or_insert(span);
        }
        let mut counts = vec![0; model.constraints.ties.len()];
        ties.iter().for_each(|tied| counts[tied.tie] += 1);
        for (tie, count) in model.constraints.ties.iter().zip(counts) {
            if count > 0 {
                let adjusted = if tie.adjust { ", moved onto it" } else { "" };
                let detail = format!("{}: each follows the nearest point of the master surface{adjusted}", tie.name);
                self.ledger_row(tie.span, "tied surfaces", count, "nodes", detail);
            }
        }
        self.surface_ties = ties;
    }

    /// Adds an equation. Returns `false` if a node does not belong to a deformable body or is tied to a rigid body.
    fn add_equation(&mut self, equation: &model::LinearEquation, mass: &[f64]) -> bool {
        let term = |&(node, dof, c): &(usize, u8, f64)| Some((self.places.free_node(node)?, usize::from(dof) - 1, c));
        let Some(terms) = equation.terms.iter().map(term).collect::<Option<Vec<_>>>() else { return false };
        self.links.first.get_or_insert(equation.span);
        // An equation of equal motion with a massless node is added as a link, which is cheaper than one equation per
        // node.
        if let [(a, along, c), (b, other, d)] = terms[..]
            && along == other
            && c == -d
            && a != b
            && (mass[a] == 0.0 || mass[b] == 0.0)
        {
            let (leader, node) = if mass[a] == 0.0 { (a, b) } else { (b, a) };
            if self.links.merge(leader, node, along) {
                return true;
            }
        }
        self.links.equation(terms, false, equation.span);
        true
    }

    /// Returns the degrees of freedom (node, axis) of massless nodes without any equation or link.
    fn find_unresisted_dofs(&self, mass: &[f64]) -> HashSet<(usize, usize)> {
        let concerned = self.links.involved_dofs();
        let bare = self.places.nodes.iter().filter(|(node, _)| !self.places.tied.contains_key(node));
        let light = bare.map(|n| *n.1).filter(|&n| mass[n] == 0.0);
        light.flat_map(|n| [(n, 0), (n, 1)]).filter(|dof| !concerned.contains(dof)).collect()
    }

    /// Gives linked nodes the initial velocity of their reference node.
    fn start_with_references(&self, state: &mut State) {
        for condition in &self.model.initial_conditions {
            let model::InitialKind::Velocity(dof @ 1..=2, value) = condition.kind else { continue };
            let axis = usize::from(dof) - 1;
            for link in &self.model.constraints.links {
                let LinkKind::Rigid(axes) = link.kind else { continue };
                if !axes[axis] || condition.members.binary_search(&link.reference).is_err() {
                    continue;
                }
                for n in link.nodes.iter().filter_map(|n| self.places.free_node(*n)) {
                    *state.dofs.nodes[n].velocity(axis) = value;
                }
            }
        }
    }
}
