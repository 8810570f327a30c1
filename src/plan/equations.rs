//! `*EQUATION` as constraints of what deforms.
//! Never here: their solution.

use std::collections::HashSet;

use super::{Compiler, State};
use crate::constraint::Constraint;
use crate::constraint::equation::{Dependent, Equation, Equations, System};
use crate::deck::Diagnostic;
use crate::model::Step;

impl Compiler<'_> {
    /// The equations of a step, factorised with what is prescribed in it.
    pub(super) fn equations(
        &mut self,
        step: &Step,
        state: &State,
        prescribed: &HashSet<(usize, usize)>,
    ) -> Option<Box<dyn Constraint>> {
        let model = self.model;
        let (mut equations, mut spans) = (Vec::new(), Vec::new());
        for equation in &model.equations {
            let term =
                |&(node, dof, c): &(usize, u8, f64)| Some((self.places.free_node(node)?, usize::from(dof) - 1, c));
            match equation.terms.iter().map(term).collect() {
                Some(terms) => {
                    equations.push(Equation { terms });
                    spans.push(equation.span);
                }
                None => {
                    let message = "*EQUATION is for nodes that deform and that no rigid body carries";
                    let finding = Diagnostic::error("P011", message).at(equation.span, "this equation has others");
                    self.diagnostics.push(finding);
                    return None;
                }
            }
        }
        let &span = spans.first()?;
        match System::all(&equations, &state.dofs.nodes.mass, prescribed) {
            Ok(systems) => {
                let detail = format!("exact, in {} independent systems", systems.len());
                let id = self.cause(span, "linear equations", equations.len(), "equations", detail);
                Some(Box::new(Equations::new(id, systems)))
            }
            Err(Dependent { equation, follows_from }) => {
                let message = format!("this equation cannot be kept in step `{}`", step.name);
                let label = if follows_from.is_empty() {
                    "all of it is prescribed"
                } else {
                    "it follows from the others marked"
                };
                let finding = Diagnostic::error("P018", message).at(spans[equation], label);
                let finding = follows_from.iter().fold(finding, |f, &i| f.at(spans[i], "from this one"));
                self.diagnostics.push(finding.help("leave it out, or free one of its degrees of freedom"));
                None
            }
        }
    }
}
