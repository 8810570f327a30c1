//! Equations and multi-point constraints between nodes of two lines, which are completed by the new nodes of both.

use crate::model::context::Context;
use std::collections::{BTreeSet, HashMap, HashSet};

use indexmap::IndexMap;

use super::mesh::{NodePair, RefinedMesh};
use crate::deck::{Diagnostic, Span};
use crate::kernel::lists::sorted_pair;
use crate::model::types::{LinearEquation, LinkKind, NodeLink};

/// Nodes in the order of the terms of an equation, or a node and its reference node.
type Related = Vec<usize>;

/// An equation or a multi-point constraint of one node.
struct Relation {
    /// Index of the equation or constraint.
    at: usize,
    nodes: Related,
    /// Source position of the data line.
    span: Span,
}

/// Line of an equation between sets, and degrees of freedom and coefficients of its terms.
type EquationForm = (Option<Span>, Vec<(u8, u64)>);

/// Two relations of the same kind whose nodes are connected by an edge in one term, but not in all.
struct Ambiguity {
    relations: [usize; 2],
}

/// Returns the relations of new nodes, each with index and position of the one that it is like, and the groups that
/// cannot be completed.
fn complete_groups<'g>(
    refined: &RefinedMesh,
    what: &str,
    groups: impl Iterator<Item = &'g Vec<Relation>>,
) -> (Vec<Relation>, Vec<Diagnostic>) {
    let (mut made, mut findings) = (Vec::new(), Vec::new());
    for group in groups {
        let nodes: Vec<&[usize]> = group.iter().map(|relation| &relation.nodes[..]).collect();
        match complete(refined, &nodes) {
            Ok(more) => made.extend(more.into_iter().map(|(like, nodes)| {
                let Relation { at, span, .. } = group[like];
                Relation { at, nodes, span }
            })),
            Err(fault) => findings.push(ambiguous(what, fault.relations.map(|at| group[at].span))),
        }
    }
    (made, findings)
}

/// Returns the relations of new nodes, each with the relation that it is like. Two relations are completed if the
/// nodes of each term are the same node or are connected by an edge.
fn complete(refined: &RefinedMesh, relations: &[&[usize]]) -> Result<Vec<(usize, Related)>, Ambiguity> {
    let mut made = Vec::new();
    let mut known: BTreeSet<[usize; 2]> = BTreeSet::new();
    for term in 0..relations[0].len() {
        let relation_of: HashMap<usize, usize> = relations.iter().enumerate().map(|(at, r)| (r[term], at)).collect();
        let mut nodes: Vec<usize> = relation_of.keys().copied().collect();
        nodes.sort_unstable();
        let selected = refined.selection(&nodes);
        let edges: BTreeSet<usize> = selected.edges.into_iter().collect();
        for (ends, _) in refined.edges.iter().enumerate().filter(|(at, _)| edges.contains(at)).map(|(_, edge)| edge) {
            let pair = ends.map(|node| relation_of[&node]);
            if known.insert(sorted_pair(pair)) {
                between(refined, relations, pair, &mut made)?;
            }
        }
        for element in selected.elements {
            let members: Vec<usize> = refined.parents[element].nodes.iter().map(|node| relation_of[node]).collect();
            inside(refined, relations, (element, term), &members, &mut made)?;
        }
    }
    Ok(made)
}

/// Adds the relations between two relations.
fn between(
    refined: &RefinedMesh,
    relations: &[&[usize]],
    pair: [usize; 2],
    made: &mut Vec<(usize, Related)>,
) -> Result<(), Ambiguity> {
    let [first, second] = pair.map(|at| relations[at]);
    let ends: Vec<[usize; 2]> = first.iter().zip(second).map(|(&a, &b)| [a, b]).collect();
    let is_followed = ends.iter().all(|&[a, b]| a == b || refined.edges.connects([a, b]));
    // A node in two terms: a chain of equations, whose new nodes have no partner.
    let is_chain = ends.iter().enumerate().any(|(at, [a, b])| {
        a != b && ends.iter().enumerate().any(|(other, [c, d])| other != at && c != d && (a == d || b == c))
    });
    let mut different = ends.iter().filter(|[a, b]| a != b).map(|&ends| refined.edges.is_divided(ends));
    let is_divided = different.next().unwrap_or(false);
    if is_followed && !is_divided && different.all(|other| !other) {
        return Ok(());
    }
    let are_all_divided = ends.iter().all(|&[a, b]| a == b || refined.edges.is_divided([a, b]));
    if !is_followed || is_chain || !are_all_divided {
        return Err(Ambiguity { relations: pair });
    }
    for part in 1..refined.factor {
        made.push((pair[0], ends.iter().map(|&ends| refined.edges.node(ends, part)).collect()));
    }
    Ok(())
}

/// Adds the relations of the new nodes inside an element; all other terms must have one node.
fn inside(
    refined: &RefinedMesh,
    relations: &[&[usize]],
    (element, term): (usize, usize),
    members: &[usize],
    made: &mut Vec<(usize, Related)>,
) -> Result<(), Ambiguity> {
    let new = refined.first_inside[element]..refined.first_inside[element + 1];
    let first = relations[members[0]];
    for &other in members.iter().filter(|_| !new.is_empty()) {
        let same = |at: usize| at == term || relations[other][at] == first[at];
        if !(0..first.len()).all(same) {
            return Err(Ambiguity { relations: [members[0], other] });
        }
    }
    for node in new {
        let mut related = first.to_vec();
        related[term] = node;
        made.push((members[0], related));
    }
    Ok(())
}

/// Adds equations and multi-point constraints of the new nodes.
pub(super) fn refine_relations(context: &mut Context<'_>) {
    refine_equations(context);
    refine_pairs(context);
}

fn refine_equations(context: &mut Context<'_>) {
    let Some(refined) = &context.scaling.refined else { return };
    let equations = &context.model.constraints.equations;
    let of_sets = repeated(equations.iter().map(|equation| equation.span));
    let mut groups: IndexMap<EquationForm, Vec<Relation>> = IndexMap::new();
    for (at, LinearEquation { terms, span }) in equations.iter().enumerate() {
        let form = terms.iter().map(|&(_, dof, c)| (dof, c.to_bits())).collect();
        let nodes = terms.iter().map(|term| term.0).collect();
        groups.entry((of_sets.get(span).copied(), form)).or_default().push(Relation { at, nodes, span: *span });
    }
    let (made, findings) = complete_groups(refined, "equations", groups.values());
    let made = made.into_iter().map(|Relation { at, nodes, span }| {
        let terms = nodes.into_iter().zip(&equations[at].terms).map(|(n, &(_, dof, c))| (n, dof, c)).collect();
        LinearEquation { terms, span }
    });
    let made: Vec<LinearEquation> = made.collect();
    let cards: String = made.iter().map(|equation| equation_card(context, equation)).collect();
    context.add_card(&cards);
    context.model.constraints.equations.extend(made);
    findings.into_iter().for_each(|finding| context.diagnostics.push(finding));
}

fn equation_card(context: &Context<'_>, equation: &LinearEquation) -> String {
    let names = &context.model.mesh.node_names;
    let term = |&(node, dof, c): &(usize, u8, f64)| format!(" {}, {dof}, {c:?}", names[node]);
    let terms: Vec<String> = equation.terms.iter().map(term).collect();
    let lines: Vec<String> = terms.chunks(4).map(|terms| terms.join(",")).collect();
    format!("*Equation\n {}\n{}\n", terms.len(), lines.join(",\n"))
}

fn refine_pairs(context: &mut Context<'_>) {
    let Some(refined) = &context.scaling.refined else { return };
    let of_sets = repeated(context.scaling.linked_pairs.iter().map(|pair| pair.span));
    let mut groups: IndexMap<(Option<Span>, &str), Vec<Relation>> = IndexMap::new();
    for (at, NodePair { name, nodes, span }) in context.scaling.linked_pairs.iter().enumerate() {
        let relation = Relation { at, nodes: nodes.to_vec(), span: *span };
        groups.entry((of_sets.get(span).copied(), name)).or_default().push(relation);
    }
    let (made, findings) = complete_groups(refined, "constraints", groups.values());
    let made = made.into_iter().map(|Relation { at, nodes, span }| NodeLink {
        name: context.scaling.linked_pairs[at].name.clone(),
        kind: LinkKind::Rigid([true; 2]),
        reference: nodes[1],
        nodes: vec![nodes[0]],
        span,
    });
    let made: Vec<NodeLink> = made.collect();
    let names = &context.model.mesh.node_names;
    let line = |l: &NodeLink| {
        let kind = l.name.trim_start_matches("MPC ");
        format!("*Mpc\n {kind}, {}, {}\n", names[l.nodes[0]], names[l.reference])
    };
    let cards: String = made.iter().map(line).collect();
    context.add_card(&cards);
    context.model.constraints.links.extend(made);
    findings.into_iter().for_each(|finding| context.diagnostics.push(finding));
}

/// Returns the lines with more than one relation: those between sets. Relations of other lines may belong together.
fn repeated(spans: impl Iterator<Item = Span>) -> HashSet<Span> {
    let mut known = HashSet::new();
    spans.filter(|span| !known.insert(*span)).collect()
}

fn ambiguous(what: &str, [first, second]: [Span; 2]) -> Diagnostic {
    let message = format!("these {what} cannot be refined: the new nodes between their nodes have no unique partners");
    let diagnostic = Diagnostic::error("M190", message).at(second, "here");
    let diagnostic = if first == second { diagnostic } else { diagnostic.at(first, "and here") };
    diagnostic.help(
        "relate the nodes of two lines with equal divisions, or all nodes to one reference node; a *TIE of two surfaces \
         needs no pairs of nodes",
    )
}
