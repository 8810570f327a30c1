//! `*MPC`, `*COUPLING`, `*TIE` and `*EQUATION` as equations between solver nodes and sets of nodes that move together.
//! Nodes that follow a rigid body become part of the body.

use std::collections::{HashMap, HashSet};

use crate::deck::{Diagnostic, Span};
use crate::model::{self, LinkKind, Model, NodeLink, RigidBody, SurfaceTie};
use crate::plan::constraints::link_set::EndEquation;
use crate::plan::constraints::tie_equations::{TieEquations, TieForm, TiedNode};
use crate::plan::queries::heated_references;
use crate::plan::state::SolidState;
use crate::plan::{Bodies, Links, Report, Scene, SolidPlaces};

/// Adds to `nodes` the nodes that follow a rigid body because they are linked to one of its nodes or tied to one of
/// its elements, directly or through other added nodes.
pub fn add_followers_of_body(model: &Model, ties: &[TieEquations], rigid: &RigidBody, nodes: &mut Vec<usize>) {
    if model.constraints.links.is_empty() && ties.is_empty() {
        return;
    }
    let mut body_nodes: HashSet<usize> = nodes.iter().copied().collect();
    let elements: HashSet<usize> = rigid.elements.iter().copied().collect();
    let on_body = tied_nodes(ties).filter(|t| elements.contains(&t.element)).map(|t| t.node);
    body_nodes.extend(on_body);
    loop {
        let previous_count = body_nodes.len();
        for link in model.constraints.links.iter().filter(|l| l.kind == LinkKind::Rigid([true; 2])) {
            if body_nodes.contains(&link.reference) {
                body_nodes.extend(&link.nodes);
            }
        }
        if body_nodes.len() == previous_count {
            break;
        }
    }
    *nodes = body_nodes.into_iter().collect();
}

/// Returns the nodes of links, ties, equations and masses that do not belong to a rigid body, the ends of springs and
/// dashpots, and the reference nodes of rigid bodies with a temperature. They are solver nodes also if they have no element.
pub fn linked_nodes(model: &Model, bodies: &Bodies, ties: &[TieEquations]) -> Vec<usize> {
    let sprung = model.discrete.connectors.iter().flat_map(|property| &property.elements);
    let ends = sprung.flat_map(|&e| model.mesh.elements[e].nodes.iter());
    let masses = model.discrete.masses.iter().map(|point| &point.node);
    let linked = model.constraints.links.iter().flat_map(|l| l.nodes.iter().chain([&l.reference]));
    let tied = tied_nodes(ties).map(|t| &t.node);
    let moving = model.constraints.equations.iter().filter(|e| !e.is_thermal());
    let terms = moving.flat_map(|e| e.terms.iter().map(|t| &t.0));
    let free = |n: &&usize| !bodies.of_node.contains_key(*n);
    let heated = heated_references(model);
    linked.chain(tied).chain(terms).chain(masses).filter(free).chain(ends).chain(&heated).copied().collect()
}

/// Collects all equations and links, and gives linked nodes the initial velocity of their reference node.
pub fn collect_links(scene: Scene, links: &mut Links, state: &mut SolidState, report: &mut Report) {
    let model = scene.model;
    for link in &model.constraints.links {
        add_link(scene, links, link, report);
    }
    add_surface_ties(scene, links, report);
    for equation in model.constraints.equations.iter().filter(|e| !e.is_thermal()) {
        if !add_equation(scene.places, links, equation, &state.dofs.nodes.mass) {
            let message =
                "*EQUATION is supported only for nodes of deformable bodies that are not tied to a rigid body";
            report.push(Diagnostic::error("P011", message).at(equation.span, "this equation has other nodes"));
            break;
        }
    }
    links.merged.retain(|a| !a.nodes.is_empty());
    links.unresisted_dofs = find_unresisted_dofs(scene.places, links, &state.dofs.nodes.mass);
    start_with_references(scene, state);
}

fn add_link(scene: Scene, links: &mut Links, link: &NodeLink, report: &mut Report) {
    let names = &scene.model.mesh.node_names;
    let reference = &names[link.reference];
    let axes = match &link.kind {
        LinkKind::Rigid([true, true]) => "r and z",
        LinkKind::Rigid([true, false]) => "r",
        LinkKind::Rigid(_) => "z",
        LinkKind::Distributing(_) => "z (weighted mean)",
    };
    let detail = format!("{}: follow node {reference} along {axes}, no rotation", link.name);
    if scene.bodies.of_node.contains_key(&link.reference) {
        if link.kind != LinkKind::Rigid([true; 2]) {
            let message = format!("{}: node {reference} belongs to a rigid body, which moves along z only", link.name);
            let help = "couple all degrees of freedom, or give the nodes as TIE NSET of the *RIGID BODY";
            refuse_link(link.span, message, help, report);
            return;
        }
        report.ledger_row(link.span, "reference node", link.nodes.len(), "nodes", detail);
        return;
    }
    let rigid = link.nodes.iter().find(|n| scene.bodies.of_node.contains_key(*n));
    if let Some(&node) = rigid {
        let message =
            format!("{}: node {} belongs to a rigid body and cannot follow another node", link.name, names[node]);
        let help = "move or load the REF NODE of the rigid body, or use it as the reference node";
        refuse_link(link.span, message, help, report);
        return;
    }
    let place_of = |n: &usize| scene.places.free_node(*n);
    let (Some(leader), Some(nodes)) =
        (place_of(&link.reference), link.nodes.iter().map(place_of).collect::<Option<Vec<_>>>())
    else {
        let message = format!("{} links nodes of a model without deformable bodies", link.name);
        refuse_link(link.span, message, "use *RIGID BODY, TIE NSET= for a rigid body of nodes", report);
        return;
    };
    match &link.kind {
        LinkKind::Rigid(axes) => {
            for axis in [0, 1].into_iter().filter(|&a| axes[a]) {
                nodes.iter().for_each(|&n| {
                    links.merge(leader, n, axis);
                });
            }
        }
        LinkKind::Distributing(weights) => {
            let sum: f64 = weights.iter().sum();
            let weighted = nodes.iter().zip(weights).filter(|w| *w.1 > 0.0).map(|(&n, w)| ((n, 1), -w / sum));
            let terms = std::iter::once(((leader, 1), 1.0)).chain(weighted).collect();
            links.equation(terms, false, link.span);
        }
    }
    links.first.get_or_insert(link.span);
    report.ledger_row(link.span, "reference node", link.nodes.len(), "nodes", detail);
}

fn refuse_link(span: Span, message: String, help: &str, report: &mut Report) {
    report.push(Diagnostic::error("P060", message).at(span, "here").help(help));
}

/// Returns the dependent nodes of all ties.
pub fn tied_nodes(ties: &[TieEquations]) -> impl Iterator<Item = &TiedNode> {
    ties.iter().flat_map(|tie| &tie.nodes)
}

fn add_surface_ties(scene: Scene, links: &mut Links, report: &mut Report) {
    let model = scene.model;
    let ties = std::mem::take(&mut links.surface_ties);
    for (tie, equations) in model.constraints.ties.iter().zip(&ties) {
        if !add_surface_tie(scene, links, tie, &equations.nodes, report) {
            break;
        }
        list_surface_tie(tie, equations, report);
    }
    links.surface_ties = ties;
}

/// Adds the equations of a tie. Returns `false` after an error.
fn add_surface_tie(scene: Scene, links: &mut Links, tie: &SurfaceTie, nodes: &[TiedNode], report: &mut Report) -> bool {
    let model = scene.model;
    let mut added: HashMap<usize, [usize; 2]> = HashMap::new();
    for tied in nodes.iter().filter(|t| !scene.bodies.of_element.contains_key(&t.element)) {
        if scene.bodies.of_node.contains_key(&tied.node) {
            let name = &model.mesh.node_names[tied.node];
            let message = format!("node {name} of the slave surface belongs to a rigid body");
            let help = "make the surface of the rigid body the master surface: give it second";
            refuse_link(tie.span, message, help, report);
            return false;
        }
        let place_of = |n: usize| scene.places.nodes.get(&n).copied();
        let shares: Option<Vec<_>> = tied.shares.iter().map(|&(n, share)| Some((place_of(n)?, share))).collect();
        let (Some(node), Some(shares)) = (place_of(tied.node), shares) else {
            let message = "a surface of a tie has elements that belong neither to a deformable nor to a rigid body";
            refuse_link(tie.span, message.into(), "give the elements a *SOLID SECTION", report);
            return false;
        };
        if let [(master, _)] = shares[..] {
            for axis in [0, 1] {
                links.merge(master, node, axis);
            }
        } else {
            added.insert(tied.node, [0, 1].map(|axis| links.follow((node, axis), &shares, tie.span)));
        }
        links.first.get_or_insert(tie.span);
    }
    for (tied, next) in nodes.iter().filter_map(|tied| Some((tied, tied.next?))) {
        if let (Some(end), Some(next_equations)) = (added.get(&tied.node), added.get(&next.node)) {
            let ends = end.iter().zip(next_equations);
            links.ends.extend(ends.map(|(&end, &to)| EndEquation { end, next: to, area: next.area }));
        }
    }
    true
}

fn list_surface_tie(tie: &SurfaceTie, TieEquations { nodes, form }: &TieEquations, report: &mut Report) {
    if nodes.is_empty() {
        return;
    }
    let motion = match form {
        TieForm::Integrated => "equal motion in the weighted mean over the common surface",
        _ => "each follows the nearest point of the master surface",
    };
    if *form == TieForm::NothingOpposite {
        let message = format!("tie {} is node to surface, because no slave facet is opposite a master facet", tie.name);
        report.push(Diagnostic::note("P061", message).at(tie.span, "surfaces without common area"));
    }
    let adjusted = if tie.adjust { ", moved onto the master surface" } else { "" };
    report.ledger_row(tie.span, "tied surfaces", nodes.len(), "nodes", format!("{}: {motion}{adjusted}", tie.name));
}

/// Adds an equation. Returns `false` if a node does not belong to a deformable body or is tied to a rigid body.
fn add_equation(places: &SolidPlaces, links: &mut Links, equation: &model::LinearEquation, mass: &[f64]) -> bool {
    let term = |&(node, dof, c): &(usize, u8, f64)| Some(((places.free_node(node)?, usize::from(dof) - 1), c));
    let Some(terms) = equation.terms.iter().map(term).collect::<Option<Vec<_>>>() else { return false };
    links.first.get_or_insert(equation.span);
    // An equation of equal motion with a massless node is added as a link, which is cheaper than one equation per
    // node.
    if let [((a, along), c), ((b, other), d)] = terms[..]
        && along == other
        && c == -d
        && a != b
        && (mass[a] == 0.0 || mass[b] == 0.0)
    {
        let (leader, node) = if mass[a] == 0.0 { (a, b) } else { (b, a) };
        if links.merge(leader, node, along) {
            return true;
        }
    }
    links.equation(terms, false, equation.span);
    true
}

/// Returns the degrees of freedom (node, axis) of massless nodes without any equation or link.
fn find_unresisted_dofs(places: &SolidPlaces, links: &Links, mass: &[f64]) -> HashSet<(usize, usize)> {
    let concerned = links.involved_dofs();
    let bare = places.nodes.iter().filter(|(node, _)| !places.tied.contains_key(node));
    let light = bare.map(|n| *n.1).filter(|&n| mass[n] == 0.0);
    light.flat_map(|n| [(n, 0), (n, 1)]).filter(|dof| !concerned.contains(dof)).collect()
}

/// Gives linked nodes the initial velocity of their reference node.
fn start_with_references(scene: Scene, state: &mut SolidState) {
    for condition in &scene.model.initial_conditions {
        let model::InitialKind::Velocity(dof @ 1..=2, value) = condition.kind else { continue };
        let axis = usize::from(dof) - 1;
        for link in &scene.model.constraints.links {
            let LinkKind::Rigid(axes) = link.kind else { continue };
            if !axes[axis] || condition.members.binary_search(&link.reference).is_err() {
                continue;
            }
            for n in link.nodes.iter().filter_map(|n| scene.places.free_node(*n)) {
                *state.dofs.nodes[n].velocity(axis) = value;
            }
        }
    }
}
