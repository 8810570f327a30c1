//! Linked nodes: `*MPC`, `*COUPLING` with `*KINEMATIC` or `*DISTRIBUTING`, `*TIE`.

use super::context::Context;
use super::families::{ConditionReader, MeshReader, PendingCoupling};
use super::names::upper;
use super::refinement::mesh::NodePair;
use super::types::{LinkKind, NodeLink, SurfaceTie};
use super::{contact, nodes};
use crate::deck::{Card, Diagnostic, Span, Word};
use crate::platform::PortableMath as _;

/// Links nodes to reference nodes. Two sets are paired in the order of their labels, or in the given order of an
/// UNSORTED set (ABAQUS Analysis User's Guide, "General multi-point constraints", "Identifying the nodes involved
/// in the MPC").
pub fn read_mpc(context: &mut Context<'_>, mesh: &mut MeshReader, card: &Card) {
    if context.first_line(card).is_none() {
        return;
    }
    for line in &card.lines {
        let Some(kind) = line.field(0) else { continue };
        let name = upper(&kind.text);
        if !matches!(name.as_str(), "BEAM" | "TIE" | "PIN") {
            let help = "supported: BEAM, TIE, PIN; or use *EQUATION";
            context.unsupported(kind.span, format!("*MPC type {} is not supported", kind.text), help);
            continue;
        }
        let (Some(first), Some(second)) = (line.field(1), line.field(2)) else {
            let message = format!("*MPC {name} requires nodes and a reference node");
            let diagnostic = Diagnostic::error("M102", message).at(line.span, "node or set missing");
            context
                .diagnostics
                .push(diagnostic.help(format!("expected: {name}, dependent node or set, reference node or set")));
            continue;
        };
        let (followers, references) =
            (nodes::nodes_in_order(context, mesh, first), nodes::nodes_in_order(context, mesh, second));
        let (Some(followers), Some(references)) = (followers, references) else { continue };
        if references.len() != 1 && references.len() != followers.len() {
            let (n, m) = (followers.len(), references.len());
            let message = format!(
                "{n} dependent nodes have {m} reference nodes; give one, or as many as there are dependent nodes"
            );
            context.out_of_range(line.span, message);
            continue;
        }
        let mut links: Vec<(usize, Vec<usize>)> = Vec::new();
        for (i, &node) in followers.iter().enumerate() {
            let reference = references[i.min(references.len() - 1)];
            if context.scaling.refined.is_some() && node != reference {
                let (name, nodes) = (format!("MPC {name}"), [node, reference]);
                context.scaling.linked_pairs.push(NodePair { name, nodes, span: line.span });
            }
            match links.last_mut() {
                Some(last) if last.0 == reference => last.1.push(node),
                _ => links.push((reference, vec![node])),
            }
        }
        for (reference, nodes) in links {
            link(context, format!("MPC {name}"), LinkKind::Rigid([true; 2]), reference, nodes, line.span);
        }
    }
}

fn link(context: &mut Context<'_>, name: String, kind: LinkKind, reference: usize, mut nodes: Vec<usize>, span: Span) {
    if let LinkKind::Rigid(_) = kind {
        nodes.retain(|&n| n != reference);
    }
    context.model.constraints.links.push(NodeLink { name, kind, reference, nodes, span });
}

pub fn read_coupling(context: &mut Context<'_>, conditions: &mut ConditionReader, card: &Card) {
    end_coupling(context, conditions);
    let name = card.value("CONSTRAINT NAME").map_or_else(String::new, |w| upper(&w.text));
    let (reference, surface) = (context.required(card, "REF NODE"), context.required(card, "SURFACE"));
    let (Some(reference), Some(surface)) = (reference, surface) else { return };
    let (node, members) = (context.single_node(reference, "REF NODE"), contact::nodes_and_faces(context, surface));
    let (Some(node), Some((mut members, _))) = (node, members) else { return };
    let points = &context.model.mesh.points;
    let distance = |n: usize| (points[n][0] - points[node][0]).portable_hypot(points[n][1] - points[node][1]);
    if let Some(radius) = card.read::<Option<f64>>("INFLUENCE RADIUS") {
        members.retain(|&n| distance(n) <= radius);
    }
    if members.is_empty() {
        let message = format!("the coupling {name} has no nodes");
        return context.error("M103", message, surface.span, "no node within the influence radius");
    }
    let areas = areas(context, surface, &members);
    conditions.coupled = None;
    conditions.coupling = Some(PendingCoupling { name, reference: node, nodes: members, areas, span: card.span });
}

/// Returns the tributary area of each node: the integral of its shape function over the rings of the faces. Nodes
/// of a node-based surface have the area 1 (ABAQUS Analysis User's Guide, "Coupling constraints").
fn areas(context: &Context<'_>, word: &Word, members: &[usize]) -> Vec<f64> {
    let mesh = &context.model.mesh;
    let names = context.names_of(word);
    if names.iter().any(|n| context.model.surfaces.nodes.contains_key(n)) {
        return vec![1.0; members.len()];
    }
    let mut areas = vec![0.0; members.len()];
    let surface = names.iter().find_map(|n| context.model.surfaces.faces.get(n));
    for &(element, side) in surface.map_or(&[][..], |s| &s.faces) {
        let Some(ends) = mesh.side_nodes(element, side) else { continue };
        let [a, b] = ends.map(|n| mesh.points[n]);
        let length = (b[0] - a[0]).portable_hypot(b[1] - a[1]);
        for (n, r) in [(ends[0], 2.0 * a[0] + b[0]), (ends[1], a[0] + 2.0 * b[0])] {
            if let Ok(at) = members.binary_search(&n) {
                areas[at] += length * r * std::f64::consts::PI / 3.0;
            }
        }
    }
    areas
}

pub fn read_coupling_kind(context: &mut Context<'_>, conditions: &mut ConditionReader, card: &Card) {
    let Some(coupling) = conditions.coupling.take() else {
        // After an invalid *COUPLING this message would be a consequential error.
        if !context.deck.cards.iter().any(|c| c.keyword.name == "COUPLING") {
            context.misplaced(card, format!("*{} must follow a *COUPLING", card.keyword.name), "COUPLING");
        } else if let Some(first) = conditions.coupled {
            context.refuse_second("a *COUPLING has one *KINEMATIC or *DISTRIBUTING card", [first, card.span]);
        }
        return;
    };
    conditions.coupled = Some(card.span);
    let kind = match card.keyword.name {
        "KINEMATIC" => coupled_degrees(context, card),
        _ => distributing(context, card, &coupling),
    };
    let Some(kind) = kind else { return };
    if kind == LinkKind::Rigid([false; 2]) {
        return context.inert(card, "it couples neither r nor z, and symmetry fixes the rotation");
    }
    link(context, format!("coupling {}", coupling.name), kind, coupling.reference, coupling.nodes, coupling.span);
}

/// Returns the coupled degrees of freedom; all if the data lines are empty.
fn coupled_degrees(context: &mut Context<'_>, card: &Card) -> Option<LinkKind> {
    if card.lines.iter().all(|l| l.field(0).is_none()) {
        return Some(LinkKind::Rigid([true; 2]));
    }
    let mut coupled = [false; 2];
    for line in card.lines.iter().filter(|l| l.field(0).is_some()) {
        let first = context.integer(line, 0, "the first degree of freedom")?;
        let last = line.field(1).map_or(Some(first), |w| w.integer(&mut context.diagnostics))?;
        if last < first {
            let message = format!("the last degree of freedom, {last}, is below the first, {first}");
            return context.refuse_value(line.span, message);
        }
        for (i, coupled) in coupled.iter_mut().enumerate() {
            *coupled |= (first..=last).contains(&(i as i64 + 1));
        }
    }
    Some(LinkKind::Rigid(coupled))
}

/// Returns the weights, which decrease with the distance from the reference node relative to the largest distance
/// (ABAQUS Analysis User's Guide, "Coupling constraints", "Specifying the weighting method"). Equation (11.3).
fn distributing(context: &mut Context<'_>, card: &Card, coupling: &PendingCoupling) -> Option<LinkKind> {
    let points = &context.model.mesh.points;
    let [r, z] = points[coupling.reference];
    let distances: Vec<f64> =
        coupling.nodes.iter().map(|&n| (points[n][0] - r).portable_hypot(points[n][1] - z)).collect();
    let farthest = distances.iter().copied().fold(0.0, f64::max);
    let parts = distances.iter().map(|d| if farthest > 0.0 { d / farthest } else { 0.0 });
    let falls: [fn(f64) -> f64; 4] = [|_| 1.0, |x| 1.0 - x, |x| 1.0 - x * x, |x| 1.0 - 3.0 * x * x + 2.0 * x * x * x];
    let fall = falls[card.read::<usize>("WEIGHTING METHOD")];
    let weights: Vec<f64> = parts.zip(&coupling.areas).map(|(x, area)| fall(x) * area).collect();
    if weights.iter().sum::<f64>() <= 0.0 {
        let message = "all weights of this coupling are zero, because its nodes have equal distances";
        return context.refuse_value(card.span, message);
    }
    Some(LinkKind::Distributing(weights))
}

/// Reports a coupling without `*KINEMATIC` or `*DISTRIBUTING`.
pub fn end_coupling(context: &mut Context<'_>, conditions: &mut ConditionReader) {
    let faulty = context.missing.has_card("KINEMATIC") || context.missing.has_card("DISTRIBUTING");
    if let Some(coupling) = conditions.coupling.take().filter(|_| !faulty) {
        let message = format!("the coupling {} has neither *KINEMATIC nor *DISTRIBUTING", coupling.name);
        context.error("M101", message, coupling.span, "one of the two cards must follow");
    }
}

pub fn read_tie(context: &mut Context<'_>, card: &Card) {
    let Some(name) = context.required(card, "NAME") else { return };
    if context.first_line(card).is_none() {
        return;
    }
    let (adjust, tolerance) = (card.read("ADJUST"), card.read::<Option<f64>>("POSITION TOLERANCE"));
    let by_nodes = card.read::<usize>("TYPE") == 1;
    let Some(chosen) = context.optional(card.value("TIED NSET"), Context::node_members) else { return };
    for line in &card.lines {
        let (Some(slave), Some(master)) = (line.field(0), line.field(1)) else {
            let diagnostic = Diagnostic::error("M102", "a tie requires two surfaces").at(line.span, "here");
            context.diagnostics.push(diagnostic.help("expected: slave surface, master surface"));
            continue;
        };
        let slaves = contact::nodes_and_faces(context, slave);
        let Some(masters) = master_faces(context, master) else { continue };
        let Some((slaves, sides)) = slaves else { continue };
        let slave_faces = if by_nodes { Vec::new() } else { sides.first_sides() };
        let tolerance = tolerance.or_else(|| context.tie_tolerance(card, &masters));
        let (name, chosen, span) = (upper(&name.text), chosen.clone(), line.span);
        let tie = SurfaceTie { name, slaves, slave_faces, masters, adjust, tolerance, chosen, span };
        context.model.constraints.ties.push(tie);
    }
}

fn master_faces(context: &mut Context<'_>, word: &Word) -> Option<Vec<(usize, super::types::ElementSide)>> {
    let names = context.names_of(word);
    if names.iter().any(|n| context.model.surfaces.nodes.contains_key(n)) {
        let message = "a node-based surface cannot be the master surface of a tie";
        let help = "give an element-based surface as the second one, or use *MPC, TIE for pairs of nodes";
        return context.refuse_unsupported(word.span, message, help);
    }
    if names.iter().any(|n| context.model.surfaces.analytical.contains_key(n)) {
        let message = "an analytical surface cannot be tied";
        let help = "use *RIGID BODY, TIE NSET= to connect nodes to a rigid body";
        return context.refuse_unsupported(word.span, message, help);
    }
    let id = context.surface_id(word)?;
    Some(context.model.surfaces.faces[id].sides("").first_sides())
}
