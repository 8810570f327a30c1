//! Equations and links as a constraint of each step.

use crate::constraint::Constraint;
use crate::constraint::bonds::{DependentEquation, LinkConflict, LinkSystem, PrescribedDofs};
use crate::constraint::equation::EquationConstraint;
use crate::deck::{Diagnostic, Span};
use crate::model::Step;
use crate::plan::{Compiler, State};

impl Compiler<'_> {
    /// Creates the constraint of all equations and links of a step, factorised with its prescribed degrees of freedom.
    pub(crate) fn equations(
        &mut self,
        step: &Step,
        state: &State,
        given: &PrescribedDofs,
    ) -> Option<Box<dyn Constraint>> {
        if self.links.is_empty() {
            return None;
        }
        let first = self.links.first?;
        let equations = self.links.equations_with(&given.all);
        match LinkSystem::new(&equations, &self.links.merged, &state.dofs.nodes.mass, given) {
            Ok(bonds) => {
                let count = self.links.equations.len() + self.links.merged.len();
                let detail = format!("exact, in {} independent systems", bonds.count());
                let id = self.ledger_row(first, "linear equations", count, "equations", detail);
                Some(Box::new(EquationConstraint::new(id, bonds)))
            }
            Err(LinkConflict::Dependent(dependent)) => {
                let spans = std::mem::take(&mut self.links.spans);
                self.refuse_dependent_equation(step, &dependent, &spans);
                self.links.spans = spans;
                None
            }
            Err(LinkConflict::ConflictingMotions(nodes, axis)) => {
                self.refuse_conflicting_motion(step, first, nodes, axis);
                None
            }
        }
    }

    /// Reports a redundant or contradictory equation; `spans` are the places of all equations.
    pub(crate) fn refuse_dependent_equation(
        &mut self,
        step: &Step,
        DependentEquation { equation, follows_from }: &DependentEquation,
        spans: &[Span],
    ) {
        let message = format!("this equation cannot be satisfied in step `{}`", step.name);
        let label = if follows_from.is_empty() {
            "all its degrees of freedom are prescribed"
        } else {
            "it follows from the other marked equations"
        };
        let finding = Diagnostic::error("P018", message).at(spans[*equation], label);
        let finding = follows_from.iter().fold(finding, |f, &i| f.at(spans[i], "from this one"));
        self.diagnostics.push(finding.help("remove the equation, or free one of its degrees of freedom"));
    }

    fn refuse_conflicting_motion(&mut self, step: &Step, first: Span, nodes: [usize; 2], axis: usize) {
        let name = |place: usize| {
            let found = self.places.nodes.iter().find(|n| *n.1 == place);
            found.map_or("", |n| self.model.mesh.node_names[n.0].as_str())
        };
        let [a, b] = nodes.map(name);
        let along = ["r", "z"][axis];
        let message = format!(
            "nodes {a} and {b} are linked along {along}, and step `{}` prescribes the motion of both",
            step.name
        );
        let given = step.boundaries.iter().filter(|s| usize::from(s.dof) == axis + 1);
        let given =
            given.filter(|s| s.nodes.iter().any(|n| nodes.iter().any(|p| self.places.free_node(*n) == Some(*p))));
        let finding = Diagnostic::error("P018", message).at(first, "the link");
        let finding = given.fold(finding, |f, boundary| f.at(boundary.span, "prescribed here"));
        self.diagnostics.push(finding.help("prescribe only the motion of the reference node"));
    }
}
