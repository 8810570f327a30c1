//! `*EQUATION`: linear equations between degrees of freedom, all displacements or all temperatures.
//! Never here: how they are kept.

use super::builder::{Builder, MOST};
use super::types::Equation;
use crate::deck::{Card, Diagnostic, Span, Word};

/// A term as read: nodes in the order of their labels, of an UNSORTED set in its own, degree of freedom, coefficient.
type Term = (Vec<usize>, u8, f64);

impl Builder<'_> {
    pub(super) fn equation(&mut self, card: &Card) {
        if self.first_line(card).is_none() {
            return;
        }
        let mut at = 0;
        while at < card.lines.len() {
            let line = &card.lines[at];
            let Some(count) = self.integer(line, 0, "the number of terms") else { return };
            if !(2..=MOST as i64).contains(&count) {
                return self.out_of_range(line.span, format!("an equation has two terms or more, not {count}"));
            }
            let (words, next) = match at + 1 < card.lines.len() {
                true => super::elements::joined(card, at + 1, 3 * count as usize),
                false => (Vec::new(), at + 1),
            };
            if words.len() != 3 * count as usize {
                let message = format!("{count} terms have {} values; {} are given", 3 * count, words.len());
                return self.diagnostics.push(Diagnostic::error("M102", message).at(line.span, "this equation"));
            }
            let terms: Option<Vec<Term>> = words.chunks(3).map(|w| self.equation_term(w)).collect();
            if let Some(terms) = terms {
                self.add_equations(&terms, line.span);
            }
            at = next;
        }
    }

    fn equation_term(&mut self, words: &[&Word]) -> Option<Term> {
        let nodes = self.nodes_in_order(words[0])?;
        let dof = words[1].integer(&mut self.diagnostics)?;
        let coefficient = words[2].number(&mut self.diagnostics)?;
        if !matches!(dof, 1 | 2 | 11) {
            return self
                .refuse_value(words[1].span, format!("degree of freedom {dof}: 1 is r, 2 is z, 11 a temperature"));
        }
        if coefficient == 0.0 || !coefficient.is_finite() {
            return self.refuse_value(words[2].span, format!("a coefficient must not be {coefficient}"));
        }
        Some((nodes, dof as u8, coefficient))
    }

    /// A set stands for as many equations as it has nodes; single nodes take part in all of them.
    fn add_equations(&mut self, terms: &[Term], span: Span) {
        let count = terms[0].0.len();
        if let Some(other) = terms.iter().find(|t| t.0.len() != count && t.0.len() != 1) {
            let message = format!("the first term has {count} nodes, another {}", other.0.len());
            return self.out_of_range(span, message);
        }
        if terms.iter().any(|t| t.1 == 11) && terms.iter().any(|t| t.1 != 11) {
            return self.out_of_range(span, "an equation between temperatures (11) and displacements");
        }
        for i in 0..count {
            let term = |(nodes, dof, c): &Term| (nodes[i.min(nodes.len() - 1)], *dof, *c);
            self.model.constraints.equations.push(Equation { terms: terms.iter().map(term).collect(), span });
        }
    }
}
