//! `*EQUATION`: linear equations between displacements or between temperatures.

use super::context::{Context, MAX_GENERATED};
use super::families::MeshReader;
use super::nodes;
use super::types::LinearEquation;
use crate::deck::{Card, Span, Word};

/// A term of equations between sets.
struct SetTerm {
    /// Nodes in order of labels, or in the order of an UNSORTED set.
    nodes: Vec<usize>,
    dof: u8,
    coefficient: f64,
}

pub fn read_equation(context: &mut Context<'_>, mesh: &mut MeshReader, card: &Card) {
    if context.first_line(card).is_none() {
        return;
    }
    let mut index = 0;
    while index < card.lines.len() {
        let line = &card.lines[index];
        let Some(count) = context.integer(line, 0, "the number of terms") else { return };
        for word in (1..line.fields.len()).filter_map(|index| line.field(index)) {
            context.report_surplus(word, "the first line of an equation has the number of terms only");
        }
        if !(2..=MAX_GENERATED as i64).contains(&count) {
            return context.out_of_range(line.span, format!("an equation requires at least two terms, found {count}"));
        }
        let (words, next) = match index + 1 < card.lines.len() {
            true => super::elements::joined(card, index + 1, 3 * count as usize),
            false => (Vec::new(), index + 1),
        };
        if words.len() != 3 * count as usize {
            let message = format!("{count} terms require {} values, found {}", 3 * count, words.len());
            return context.error("M102", message, line.span, "this equation");
        }
        let terms: Option<Vec<SetTerm>> = words.chunks(3).map(|w| equation_term(context, mesh, w)).collect();
        if let Some(terms) = terms {
            add_equations(context, &terms, line.span);
        }
        index = next;
    }
}

fn equation_term(context: &mut Context<'_>, mesh: &mut MeshReader, words: &[&Word]) -> Option<SetTerm> {
    let nodes = nodes::nodes_in_order(context, mesh, words[0])?;
    let dof = words[1].integer(&mut context.diagnostics)?;
    let coefficient = words[2].number(&mut context.diagnostics)?;
    if !matches!(dof, 1 | 2 | 11) {
        let message = format!("degree of freedom must be 1 (r), 2 (z) or 11 (temperature), found {dof}");
        return context.refuse_value(words[1].span, message);
    }
    if coefficient == 0.0 || !coefficient.is_finite() {
        let message = format!("a coefficient must be finite and nonzero, found {coefficient}");
        return context.refuse_value(words[2].span, message);
    }
    Some(SetTerm { nodes, dof: dof as u8, coefficient })
}

/// Adds one equation per node of the sets; single nodes appear in all equations.
fn add_equations(context: &mut Context<'_>, terms: &[SetTerm], span: Span) {
    let count = terms[0].nodes.len();
    if let Some(other) = terms.iter().find(|t| t.nodes.len() != count && t.nodes.len() != 1) {
        let message =
            format!("the sets of an equation must have equal sizes, found {count} and {} nodes", other.nodes.len());
        return context.out_of_range(span, message);
    }
    if terms.iter().any(|t| t.dof == 11) && terms.iter().any(|t| t.dof != 11) {
        return context.out_of_range(span, "an equation cannot combine temperatures (11) and displacements");
    }
    for i in 0..count {
        let term = |t: &SetTerm| (t.nodes[i.min(t.nodes.len() - 1)], t.dof, t.coefficient);
        context.model.constraints.equations.push(LinearEquation { terms: terms.iter().map(term).collect(), span });
    }
}
