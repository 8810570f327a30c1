//! What keeps nodes together, as a constraint of each step.
//! Never here: where it comes from, its solution.

use super::{Compiler, State};
use crate::constraint::Constraint;
use crate::constraint::bonds::{Bonds, Dependent, Given, Unkept};
use crate::constraint::equation::Equations;
use crate::deck::{Diagnostic, Span};
use crate::model::Step;

impl Compiler<'_> {
    /// The equations of a step and the nodes that move alike, factorised with what is prescribed in it.
    pub(super) fn equations(&mut self, step: &Step, state: &State, given: &Given) -> Option<Box<dyn Constraint>> {
        if self.kept.is_empty() {
            return None;
        }
        let first = self.kept.first?;
        match Bonds::new(&self.kept.equations, &self.kept.alike, &state.dofs.nodes.mass, given) {
            Ok(bonds) => {
                let count = self.kept.equations.len() + self.kept.alike.len();
                let detail = format!("exact, in {} independent systems", bonds.count());
                let id = self.cause(first, "linear equations", count, "equations", detail);
                Some(Box::new(Equations::new(id, bonds)))
            }
            Err(Unkept::Dependent(dependent)) => {
                let spans = std::mem::take(&mut self.kept.spans);
                self.dependent(step, &dependent, &spans);
                self.kept.spans = spans;
                None
            }
            Err(Unkept::Torn(nodes, axis)) => {
                self.torn(step, first, nodes, axis);
                None
            }
        }
    }

    /// Refuses an equation; `spans` are the places of all.
    pub(super) fn dependent(&mut self, step: &Step, Dependent { equation, follows_from }: &Dependent, spans: &[Span]) {
        let message = format!("this equation cannot be kept in step `{}`", step.name);
        let label =
            if follows_from.is_empty() { "all of it is prescribed" } else { "it follows from the others marked" };
        let finding = Diagnostic::error("P018", message).at(spans[*equation], label);
        let finding = follows_from.iter().fold(finding, |f, &i| f.at(spans[i], "from this one"));
        self.diagnostics.push(finding.help("leave it out, or free one of its degrees of freedom"));
    }

    fn torn(&mut self, step: &Step, first: Span, nodes: [usize; 2], axis: usize) {
        let name = |place: usize| {
            let found = self.places.nodes.iter().find(|n| *n.1 == place);
            found.map_or("", |n| self.model.mesh.node_names[*n.0].as_str())
        };
        let [a, b] = nodes.map(name);
        let along = ["r", "z"][axis];
        let message = format!(
            "nodes {a} and {b} move alike along {along}, and step `{}` prescribes the motion of both",
            step.name
        );
        let given = step.boundaries.iter().filter(|s| usize::from(s.dof) == axis + 1);
        let given =
            given.filter(|s| s.nodes.iter().any(|n| nodes.iter().any(|p| self.places.free_node(*n) == Some(*p))));
        let finding = Diagnostic::error("P018", message).at(first, "what keeps them together");
        let finding = given.fold(finding, |f, boundary| f.at(boundary.span, "prescribed here"));
        self.diagnostics.push(finding.help("prescribe the motion of the reference node alone"));
    }
}
