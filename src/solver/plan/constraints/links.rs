//! `*MPC`, `*COUPLING`, `*TIE` and `*EQUATION` as equations between solver nodes and sets of nodes that move together.
//! Nodes that follow a rigid body become part of the body.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

use indexmap::IndexMap;

use crate::constraint::bonds::{MergedDofs, NodalEquation};
use crate::deck::{Diagnostic, Span};
use crate::model::{self, LinkKind, NodeLink, RigidBody, SurfaceTie};
use crate::plan::constraints::tie_equations::{TieEquations, TieForm, TiedNode};
use crate::plan::{Compiler, State};

/// Equations and links between solver nodes, which are active in all steps.
#[derive(Debug, Default)]
pub(crate) struct LinkSet {
    /// Equations, and the card of each.
    pub equations: Vec<NodalEquation>,
    pub spans: Vec<Span>,
    /// Equations of nodes at ends of ties.
    ends: Vec<EndEquation>,
    /// Sets of nodes with equal motion along an axis.
    pub merged: Vec<MergedDofs>,
    /// Index in `merged` of the set that contains a node and axis.
    group: IndexMap<(usize, usize), usize>,
    /// First card with an equation or link.
    pub first: Option<Span>,
}

/// The equation of a node at an end of a tie and that of the next node.
#[derive(Clone, Copy, Debug)]
struct EndEquation {
    end: usize,
    next: usize,
    /// Area of the node at the end relative to that of the next one.
    area: f64,
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

    /// Adds the equation that a degree of freedom (node, axis) follows the weighted mean of nodes. Returns its index.
    fn follow(&mut self, (node, axis): (usize, usize), shares: &[(usize, f64)], span: Span) -> usize {
        let others = shares.iter().map(|&(n, share)| (n, axis, -share));
        self.equation(std::iter::once((node, axis, 1.0)).chain(others).collect(), true, span);
        self.equations.len() - 1
    }

    /// Returns the equations of a step. If the motion of a node at the end of a tie is prescribed, and that of the next node
    /// is not, the equation of the end is added to that of the next node: a separate equation would restrain the other
    /// surface more than a common mesh.
    pub fn equations_with(&self, prescribed: &HashSet<(usize, usize)>) -> Cow<'_, [NodalEquation]> {
        let mut equations = Cow::Borrowed(&self.equations[..]);
        let is_prescribed = |i: usize| prescribed.contains(&self.equations[i].dependent());
        for &EndEquation { end, next, area } in &self.ends {
            if is_prescribed(end) && !is_prescribed(next) {
                let equations = equations.to_mut();
                let terms = std::mem::take(&mut equations[end].terms);
                equations[next].add(&terms, area);
            }
        }
        equations
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
    pub(crate) fn add_followers_of_body(&self, rigid: &RigidBody, nodes: &mut Vec<usize>) {
        let model = self.model;
        if model.constraints.links.is_empty() && self.surface_ties.is_empty() {
            return;
        }
        let mut own: HashSet<usize> = nodes.iter().copied().collect();
        let elements: HashSet<usize> = rigid.elements.iter().copied().collect();
        let on_body = self.tied_nodes().filter(|t| elements.contains(&t.element)).map(|t| t.node);
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
    pub(crate) fn linked_nodes(&self) -> Vec<usize> {
        let model = self.model;
        let sprung = model.discrete.connectors.iter().flat_map(|property| &property.elements);
        let ends = sprung.flat_map(|&e| model.mesh.elements[e].nodes.iter());
        let linked = model.constraints.links.iter().flat_map(|l| l.nodes.iter().chain([&l.reference]));
        let tied = self.tied_nodes().map(|t| &t.node);
        let moving = model.constraints.equations.iter().filter(|e| !e.is_thermal());
        let terms = moving.flat_map(|e| e.terms.iter().map(|t| &t.0));
        let free = |n: &&usize| !self.body_of_node.contains_key(*n);
        let heated = self.heated_references();
        linked.chain(tied).chain(terms).filter(free).chain(ends).chain(&heated).copied().collect()
    }

    /// Collects all equations and links, and gives linked nodes the initial velocity of their reference node.
    pub(crate) fn collect_links(&mut self, state: &mut State) {
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

    /// Returns the dependent nodes of all ties.
    pub(crate) fn tied_nodes(&self) -> impl Iterator<Item = &TiedNode> {
        self.surface_ties.iter().flat_map(|tie| &tie.nodes)
    }

    fn add_surface_ties(&mut self) {
        let model = self.model;
        let ties = std::mem::take(&mut self.surface_ties);
        for (tie, equations) in model.constraints.ties.iter().zip(&ties) {
            if !self.add_surface_tie(tie, &equations.nodes) {
                break;
            }
            self.list_surface_tie(tie, equations);
        }
        self.surface_ties = ties;
    }

    /// Adds the equations of a tie. Returns `false` after an error.
    fn add_surface_tie(&mut self, tie: &SurfaceTie, nodes: &[TiedNode]) -> bool {
        let model = self.model;
        let mut added: HashMap<usize, [usize; 2]> = HashMap::new();
        for tied in nodes.iter().filter(|t| !self.body_of_element.contains_key(&t.element)) {
            if self.body_of_node.contains_key(&tied.node) {
                let name = &model.mesh.node_names[tied.node];
                let message = format!("node {name} of the slave surface belongs to a rigid body");
                let help = "make the surface of the rigid body the master surface: give it second";
                self.refuse_link(tie.span, message, help);
                return false;
            }
            let place = |n: usize| self.places.nodes.get(&n).copied();
            let shares: Option<Vec<_>> = tied.shares.iter().map(|&(n, share)| Some((place(n)?, share))).collect();
            let (Some(node), Some(shares)) = (place(tied.node), shares) else {
                let message = "a surface of a tie has elements that belong neither to a deformable nor to a rigid body";
                self.refuse_link(tie.span, message.into(), "give the elements a *SOLID SECTION");
                return false;
            };
            if let [(master, _)] = shares[..] {
                for axis in [0, 1] {
                    self.links.merge(master, node, axis);
                }
            } else {
                added.insert(tied.node, [0, 1].map(|axis| self.links.follow((node, axis), &shares, tie.span)));
            }
            self.links.first.get_or_insert(tie.span);
        }
        for (tied, next) in nodes.iter().filter_map(|tied| Some((tied, tied.next?))) {
            if let (Some(end), Some(next_equations)) = (added.get(&tied.node), added.get(&next.node)) {
                let ends = end.iter().zip(next_equations);
                self.links.ends.extend(ends.map(|(&end, &to)| EndEquation { end, next: to, area: next.area }));
            }
        }
        true
    }

    fn list_surface_tie(&mut self, tie: &SurfaceTie, TieEquations { nodes, form }: &TieEquations) {
        if nodes.is_empty() {
            return;
        }
        let motion = match form {
            TieForm::Integrated => "equal motion in the weighted mean over the common surface",
            _ => "each follows the nearest point of the master surface",
        };
        if *form == TieForm::NothingOpposite {
            let message =
                format!("tie {} is node to surface, because no slave facet is opposite a master facet", tie.name);
            self.diagnostics.push(Diagnostic::note("P061", message).at(tie.span, "surfaces without common area"));
        }
        let adjusted = if tie.adjust { ", moved onto the master surface" } else { "" };
        let detail = format!("{}: {motion}{adjusted}", tie.name);
        self.ledger_row(tie.span, "tied surfaces", nodes.len(), "nodes", detail);
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
