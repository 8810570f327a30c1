//! Equations and links as a constraint of each step.

use crate::constraint::Constraint;
use crate::constraint::bonds::{DependentEquation, LinkConflict, LinkSystem, PrescribedDofs};
use crate::constraint::equation::EquationConstraint;
use crate::deck::{Diagnostic, Span};
use crate::model::Step;
use crate::plan::{Report, Scene, StepInput};

/// Creates the constraint of all equations and links of a step, factorised with its prescribed degrees of freedom.
pub fn link_constraint(input: StepInput, given: &PrescribedDofs, report: &mut Report) -> Option<Box<dyn Constraint>> {
    let StepInput { scene, links, state, index, .. } = input;
    let step = &scene.model.steps[index];
    if links.is_empty() {
        return None;
    }
    let first = links.first?;
    let equations = links.equations_with(&given.all);
    match LinkSystem::new(&equations, &links.merged, &state.dofs.nodes.mass, given) {
        Ok(bonds) => {
            let count = links.equations.len() + links.merged.len();
            let detail = format!("exact, in {} independent systems", bonds.systems.len());
            let id = report.ledger_row(first, "linear equations", count, "equations", detail);
            Some(Box::new(EquationConstraint::new(id, bonds)))
        }
        Err(LinkConflict::Dependent(dependent)) => {
            refuse_dependent_equation(step, &dependent, &links.spans, report);
            None
        }
        Err(LinkConflict::ConflictingMotions(nodes, axis)) => {
            refuse_conflict(scene, step, first, nodes, axis, report);
            None
        }
    }
}

/// Reports a redundant or contradictory equation; `spans` are the places of all equations.
pub fn refuse_dependent_equation(
    step: &Step,
    DependentEquation { equation, follows_from }: &DependentEquation,
    spans: &[Span],
    report: &mut Report,
) {
    let message = format!("this equation cannot be satisfied in step `{}`", step.name);
    let label = if follows_from.is_empty() {
        "all its degrees of freedom are prescribed"
    } else {
        "it follows from the other marked equations"
    };
    let finding = Diagnostic::error("P018", message).at(spans[*equation], label);
    let finding = follows_from.iter().fold(finding, |f, &i| f.at(spans[i], "from this one"));
    report.push(finding.help("remove the equation, or free one of its degrees of freedom"));
}

fn refuse_conflict(scene: Scene, step: &Step, first: Span, nodes: [usize; 2], axis: usize, report: &mut Report) {
    let name = |place: usize| {
        let node = scene.places.nodes.iter().find(|n| *n.1 == place);
        node.map_or("", |n| scene.model.mesh.node_names[n.0].as_str())
    };
    let [a, b] = nodes.map(name);
    let along = ["r", "z"][axis];
    let message =
        format!("nodes {a} and {b} are linked along {along}, and step `{}` prescribes the motion of both", step.name);
    let boundaries = step.boundaries.iter().filter(|s| usize::from(s.dof) == axis + 1);
    let boundaries =
        boundaries.filter(|s| s.nodes.iter().any(|n| nodes.iter().any(|p| scene.places.free_node(*n) == Some(*p))));
    let finding = Diagnostic::error("P018", message).at(first, "the link");
    let finding = boundaries.fold(finding, |f, boundary| f.at(boundary.span, "prescribed here"));
    report.push(finding.help("prescribe only the motion of the reference node"));
}
