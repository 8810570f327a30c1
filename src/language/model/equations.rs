//! `*EQUATION`: linear equations between displacements or between temperatures.

use super::builder::{MAX_GENERATED, ModelBuilder};
use super::types::LinearEquation;
use crate::deck::{Card, Diagnostic, Span, Word};

/// A term: nodes (in order of labels, or in the order of an UNSORTED set), degree of freedom, coefficient.
type EquationTerm = (Vec<usize>, u8, f64);

impl ModelBuilder<'_> {
    pub(super) fn equation(&mut self, card: &Card) {
        if self.first_line(card).is_none() {
            return;
        }
        let mut at = 0;
        while at < card.lines.len() {
            let line = &card.lines[at];
            let Some(count) = self.integer(line, 0, "the number of terms") else { return };
            for word in (1..line.fields.len()).filter_map(|at| line.field(at)) {
                self.report_surplus(word, "the first line of an equation has the number of terms only");
            }
            if !(2..=MAX_GENERATED as i64).contains(&count) {
                return self.out_of_range(line.span, format!("an equation requires at least two terms, found {count}"));
            }
            let (words, next) = match at + 1 < card.lines.len() {
                true => super::elements::joined(card, at + 1, 3 * count as usize),
                false => (Vec::new(), at + 1),
            };
            if words.len() != 3 * count as usize {
                let message = format!("{count} terms require {} values, found {}", 3 * count, words.len());
                return self.diagnostics.push(Diagnostic::error("M102", message).at(line.span, "this equation"));
            }
            let terms: Option<Vec<EquationTerm>> = words.chunks(3).map(|w| self.equation_term(w)).collect();
            if let Some(terms) = terms {
                self.add_equations(&terms, line.span);
            }
            at = next;
        }
    }

    fn equation_term(&mut self, words: &[&Word]) -> Option<EquationTerm> {
        let nodes = self.nodes_in_order(words[0])?;
        let dof = words[1].integer(&mut self.diagnostics)?;
        let coefficient = words[2].number(&mut self.diagnostics)?;
        if !matches!(dof, 1 | 2 | 11) {
            return self.refuse_value(
                words[1].span,
                format!("degree of freedom must be 1 (r), 2 (z) or 11 (temperature), found {dof}"),
            );
        }
        if coefficient == 0.0 || !coefficient.is_finite() {
            return self
                .refuse_value(words[2].span, format!("a coefficient must be finite and nonzero, found {coefficient}"));
        }
        Some((nodes, dof as u8, coefficient))
    }

    /// Adds one equation per node of the sets; single nodes appear in all of them.
    fn add_equations(&mut self, terms: &[EquationTerm], span: Span) {
        let count = terms[0].0.len();
        if let Some(other) = terms.iter().find(|t| t.0.len() != count && t.0.len() != 1) {
            let message =
                format!("the sets of an equation must have equal sizes, found {count} and {} nodes", other.0.len());
            return self.out_of_range(span, message);
        }
        if terms.iter().any(|t| t.1 == 11) && terms.iter().any(|t| t.1 != 11) {
            return self.out_of_range(span, "an equation cannot combine temperatures (11) and displacements");
        }
        for i in 0..count {
            let term = |(nodes, dof, c): &EquationTerm| (nodes[i.min(nodes.len() - 1)], *dof, *c);
            self.model.constraints.equations.push(LinearEquation { terms: terms.iter().map(term).collect(), span });
        }
    }
}
