//! Temperatures that `*TIE` and `*EQUATION` on degree of freedom 11 keep together.
//! Never here: what gives and takes heat, arithmetic of heat.

use std::collections::HashSet;

use super::Compiler;
use crate::constraint::bonds::{Bonds, Equation, Given, Unkept};
use crate::deck::{Diagnostic, Span};
use crate::heat::conductors::Conductors;
use crate::heat::field::{Conditions, capacities_at};

/// Equations between temperatures, and where each comes from.
#[derive(Default)]
struct Tied {
    equations: Vec<Equation>,
    spans: Vec<Span>,
}

impl Compiler<'_> {
    /// Puts them into each step, with the temperatures that are held in it.
    pub(super) fn tie_temperatures(
        &mut self,
        steps: &mut [Option<Conditions>],
        conductors: &Conductors,
        conducting: &HashSet<usize>,
        start: &[f64],
    ) {
        let mut tied = Tied::default();
        self.tied_surfaces(conducting, &mut tied);
        self.tied_by_equations(conducting, &mut tied);
        if tied.equations.is_empty() {
            return;
        }
        let capacities = capacities_at(conductors, start);
        for (index, conditions) in steps.iter_mut().enumerate() {
            let Some(conditions) = conditions else { continue };
            let held = conditions.held.iter().flat_map(|h| &h.nodes).map(|n| (n.node, 0)).collect();
            let given = Given { all: held, ..Given::default() };
            match Bonds::new(&tied.equations, &[], &capacities, &given) {
                Ok(bonds) => conditions.bonds = bonds,
                Err(Unkept::Dependent(found)) => {
                    let step = &self.model.steps[index];
                    self.dependent(step, &found, &tied.spans);
                    return;
                }
                // Only nodes that move alike can be torn.
                Err(Unkept::Torn(..)) => {}
            }
        }
    }

    /// Each node of a slave surface has the temperature of the point of the master surface that it lies on.
    fn tied_surfaces(&mut self, conducting: &HashSet<usize>, tied: &mut Tied) {
        let model = self.model;
        for (index, tie) in model.constraints.ties.iter().enumerate() {
            let before = tied.equations.len();
            for own in self.surface_ties.iter().filter(|t| t.tie == index) {
                let place = |n: usize| self.places.nodes.get(&n).copied().filter(|p| conducting.contains(p));
                let shares: Option<Vec<_>> =
                    own.shares.iter().map(|&(n, share)| Some((place(n)?, 0, -share))).collect();
                // What does not conduct passes no heat on; its motion is tied all the same.
                let (Some(node), Some(shares)) = (place(own.node), shares) else { continue };
                let terms = std::iter::once((node, 0, 1.0)).chain(shares).collect();
                tied.equations.push(Equation { terms, spare: true });
                tied.spans.push(tie.span);
            }
            let count = tied.equations.len() - before;
            if count > 0 {
                let detail = format!("{}: those of the nearest points of the master surface", tie.name);
                self.cause(tie.span, "tied temperatures", count, "nodes", detail);
            }
        }
    }

    fn tied_by_equations(&mut self, conducting: &HashSet<usize>, tied: &mut Tied) {
        let model = self.model;
        let mut first = None;
        let before = tied.equations.len();
        for equation in model.constraints.equations.iter().filter(|e| e.is_thermal()) {
            let mut terms = Vec::with_capacity(equation.terms.len());
            for &(node, _, c) in &equation.terms {
                let Some(place) = self.places.nodes.get(&node).copied().filter(|p| conducting.contains(p)) else {
                    let message = format!("*EQUATION: node {} has no temperature", model.mesh.node_names[node]);
                    let finding = Diagnostic::error("P063", message).at(equation.span, "an equation on 11");
                    return self.diagnostics.push(finding.help("nodes of CAX4RT and CAX3T have temperatures"));
                };
                terms.push((place, 0, c));
            }
            tied.equations.push(Equation { terms, spare: false });
            tied.spans.push(equation.span);
            first = first.or(Some(equation.span));
        }
        if let Some(span) = first {
            let count = tied.equations.len() - before;
            self.cause(span, "equations between temperatures", count, "equations", "exact".into());
        }
    }
}
