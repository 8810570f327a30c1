//! `*MPC`, `*COUPLING`, `*TIE` and `*EQUATION` as what keeps nodes of the solver together; what follows a rigid body becomes part
//! of it.
//! Never here: the search on surfaces, what is prescribed.

use std::collections::HashSet;

use indexmap::IndexMap;

use super::{Compiler, State};
use crate::constraint::bonds::{Alike, Equation};
use crate::deck::{Diagnostic, Span};
use crate::model::{self, Link, LinkKind, RigidBody};

/// What keeps nodes of the solver together in all steps.
#[derive(Debug, Default)]
pub(super) struct Kept {
    /// Equations, and where each comes from.
    pub equations: Vec<Equation>,
    pub spans: Vec<Span>,
    /// Nodes that move alike, by axis.
    pub alike: Vec<Alike>,
    /// Which of these each node is in, along each axis.
    group: IndexMap<(usize, usize), usize>,
    /// First of the cards that ask for it.
    pub first: Option<Span>,
}

impl Kept {
    /// Whether nothing is.
    pub fn is_empty(&self) -> bool {
        self.equations.is_empty() && self.alike.is_empty()
    }

    /// Lets two nodes move alike along an axis; the first leads. Returns whether they did not already.
    fn join(&mut self, leader: usize, node: usize, axis: usize) -> bool {
        match (self.group.get(&(leader, axis)).copied(), self.group.get(&(node, axis)).copied()) {
            (Some(a), Some(b)) if a == b => return leader == node,
            (Some(a), Some(b)) => {
                let moved = std::mem::take(&mut self.alike[b].nodes);
                moved.iter().for_each(|&n| {
                    self.group.insert((n, axis), a);
                });
                self.alike[a].nodes.extend(moved);
            }
            (Some(a), None) => self.add(a, node, axis),
            (None, Some(b)) => {
                self.alike[b].nodes.insert(0, leader);
                self.group.insert((leader, axis), b);
            }
            (None, None) => {
                self.alike.push(Alike { nodes: Vec::new(), axis });
                let group = self.alike.len() - 1;
                self.add(group, leader, axis);
                self.add(group, node, axis);
            }
        }
        true
    }

    fn add(&mut self, group: usize, node: usize, axis: usize) {
        self.alike[group].nodes.push(node);
        self.group.insert((node, axis), group);
    }

    fn equation(&mut self, terms: Vec<(usize, usize, f64)>, spare: bool, span: Span) {
        self.equations.push(Equation { terms, spare });
        self.spans.push(span);
    }

    /// Nodes of the solver that it concerns, and along which axis.
    pub fn concerned(&self) -> HashSet<(usize, usize)> {
        let terms = self.equations.iter().flat_map(|e| e.terms.iter().map(|t| (t.0, t.1)));
        self.group.keys().copied().chain(terms).collect()
    }
}

impl Compiler<'_> {
    /// Nodes that follow a rigid body because they are linked to one of its nodes or tied to one of its elements: with what is
    /// added they may carry others along.
    pub(super) fn carried_along(&self, rigid: &RigidBody, nodes: &mut Vec<usize>) {
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

    /// Nodes of no element that links and equations join with others: they have a place in the solver, too.
    pub(super) fn bare_nodes(&self) -> Vec<usize> {
        let model = self.model;
        let linked = model.constraints.links.iter().flat_map(|l| l.nodes.iter().chain([&l.reference]));
        let tied = self.surface_ties.iter().map(|t| &t.node);
        let moving = model.constraints.equations.iter().filter(|e| !e.is_thermal());
        let terms = moving.flat_map(|e| e.terms.iter().map(|t| &t.0));
        let free = |n: &&usize| !self.body_of_node.contains_key(*n);
        linked.chain(tied).chain(terms).filter(free).copied().collect()
    }

    /// Gathers what keeps nodes together, and lets nodes start with their reference node.
    pub(super) fn keep(&mut self, state: &mut State) {
        let model = self.model;
        for link in &model.constraints.links {
            self.keep_link(link);
        }
        self.keep_surfaces();
        for equation in model.constraints.equations.iter().filter(|e| !e.is_thermal()) {
            if !self.keep_equation(equation, &state.dofs.nodes.mass) {
                let message = "*EQUATION is for nodes that deform and that no rigid body carries";
                let finding = Diagnostic::error("P011", message).at(equation.span, "this equation has others");
                self.diagnostics.push(finding);
                break;
            }
        }
        self.kept.alike.retain(|a| !a.nodes.is_empty());
        self.idle = self.without_resistance(&state.dofs.nodes.mass);
        self.start_with_references(state);
    }

    fn keep_link(&mut self, link: &Link) {
        let names = &self.model.mesh.node_names;
        let reference = &names[link.reference];
        let axes = match &link.kind {
            LinkKind::Rigid([true, true]) => "r and z",
            LinkKind::Rigid([true, false]) => "r",
            LinkKind::Rigid(_) => "z",
            LinkKind::Distributing(_) => "z in the mean",
        };
        let detail = format!("{}: with node {reference} along {axes}, no rotation", link.name);
        if self.body_of_node.contains_key(&link.reference) {
            if link.kind != LinkKind::Rigid([true; 2]) {
                let message =
                    format!("{}: node {reference} belongs to a rigid body, which moves along z only", link.name);
                let help = "couple all degrees of freedom, or name the nodes as TIE NSET of the *RIGID BODY";
                self.refuse_link(link.span, message, help);
                return;
            }
            self.cause(link.span, "reference node", link.nodes.len(), "nodes", detail);
            return;
        }
        let rigid = link.nodes.iter().find(|n| self.body_of_node.contains_key(*n));
        if let Some(&node) = rigid {
            let message =
                format!("{}: node {} belongs to a rigid body and cannot follow another node", link.name, names[node]);
            self.refuse_link(
                link.span,
                message,
                "move or load the body's own REF NODE, or make that the reference node",
            );
            return;
        }
        let place = |n: &usize| self.places.free_node(*n);
        let (Some(leader), Some(nodes)) =
            (place(&link.reference), link.nodes.iter().map(place).collect::<Option<Vec<_>>>())
        else {
            let message = format!("{} joins nodes of a scene in which nothing deforms", link.name);
            self.refuse_link(link.span, message, "*RIGID BODY, TIE NSET= makes a rigid body of nodes");
            return;
        };
        match &link.kind {
            LinkKind::Rigid(axes) => {
                for axis in [0, 1].into_iter().filter(|&a| axes[a]) {
                    nodes.iter().for_each(|&n| {
                        self.kept.join(leader, n, axis);
                    });
                }
            }
            LinkKind::Distributing(weights) => {
                let sum: f64 = weights.iter().sum();
                let own = nodes.iter().zip(weights).filter(|w| *w.1 > 0.0).map(|(&n, w)| (n, 1, -w / sum));
                let terms = std::iter::once((leader, 1, 1.0)).chain(own).collect();
                self.kept.equation(terms, false, link.span);
            }
        }
        self.kept.first.get_or_insert(link.span);
        self.cause(link.span, "reference node", link.nodes.len(), "nodes", detail);
    }

    fn refuse_link(&mut self, span: Span, message: String, help: &str) {
        self.diagnostics.push(Diagnostic::error("P060", message).at(span, "here").help(help));
    }

    fn keep_surfaces(&mut self) {
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
                self.refuse_link(span, message, "make the surface of the rigid body the master: name it second");
                break;
            }
            let place = |n: usize| self.places.nodes.get(&n).copied();
            let shares: Option<Vec<_>> = tied.shares.iter().map(|&(n, share)| Some((place(n)?, share))).collect();
            let (Some(node), Some(shares)) = (place(tied.node), shares) else {
                let message = "the master surface of a tie has elements that neither deform nor belong to a rigid body";
                self.refuse_link(span, message.into(), "give them a *SOLID SECTION");
                break;
            };
            for axis in [0, 1] {
                if let [(master, _)] = shares[..] {
                    self.kept.join(master, node, axis);
                } else {
                    let masters = shares.iter().map(|&(n, share)| (n, axis, -share));
                    let terms = std::iter::once((node, axis, 1.0)).chain(masters).collect();
                    self.kept.equation(terms, true, span);
                }
            }
            self.kept.first.get_or_insert(span);
        }
        for (index, tie) in model.constraints.ties.iter().enumerate() {
            let count = ties.iter().filter(|t| t.tie == index).count();
            if count > 0 {
                let adjusted = if tie.adjust { ", put on it" } else { "" };
                let detail = format!("{}: each follows the nearest point of the master surface{adjusted}", tie.name);
                self.cause(tie.span, "tied surfaces", count, "nodes", detail);
            }
        }
        self.surface_ties = ties;
    }

    /// Returns whether all of its nodes can take part.
    fn keep_equation(&mut self, equation: &model::Equation, mass: &[f64]) -> bool {
        let term = |&(node, dof, c): &(usize, u8, f64)| Some((self.places.free_node(node)?, usize::from(dof) - 1, c));
        let Some(terms) = equation.terms.iter().map(term).collect::<Option<Vec<_>>>() else { return false };
        self.kept.first.get_or_insert(equation.span);
        // With a node without mass, which any number of others may follow: no need for an equation each.
        if let [(a, along, c), (b, other, d)] = terms[..]
            && along == other
            && c == -d
            && a != b
            && (mass[a] == 0.0 || mass[b] == 0.0)
        {
            let (leader, node) = if mass[a] == 0.0 { (a, b) } else { (b, a) };
            if self.kept.join(leader, node, along) {
                return true;
            }
        }
        self.kept.equation(terms, false, equation.span);
        true
    }

    /// Nodes without mass along axes in which nothing keeps them.
    fn without_resistance(&self, mass: &[f64]) -> HashSet<(usize, usize)> {
        let concerned = self.kept.concerned();
        let bare = self.places.nodes.iter().filter(|(node, _)| !self.places.tied.contains_key(node));
        let light = bare.map(|n| *n.1).filter(|&n| mass[n] == 0.0);
        light.flat_map(|n| [(n, 0), (n, 1)]).filter(|dof| !concerned.contains(dof)).collect()
    }

    /// Where a reference node is given a velocity at the start, what moves with it starts so, too.
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
