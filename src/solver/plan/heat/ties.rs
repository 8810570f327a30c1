//! Equations between temperatures: `*TIE`, and `*EQUATION` on degree of freedom 11.

use crate::constraint::bonds::{LinkConflict, LinkSystem, NodalEquation, PrescribedDofs};
use crate::deck::{Diagnostic, Span};
use crate::heat::field::{ThermalConditions, capacities_at};
use crate::plan::constraints::equations::refuse_dependent_equation;
use crate::plan::heat::HeatInput;
use crate::plan::{Links, Report};

/// Equations between temperatures, and the card of each.
#[derive(Default)]
struct TemperatureEquations {
    equations: Vec<NodalEquation>,
    spans: Vec<Span>,
}

/// Adds the temperature equations to the thermal conditions of each step, with its prescribed temperatures.
pub fn tie_temperatures(
    input: HeatInput,
    links: &Links,
    steps: &mut [Option<ThermalConditions>],
    start: &[f64],
    report: &mut Report,
) {
    let mut tied = TemperatureEquations::default();
    tied_surfaces(input, links, &mut tied, report);
    tied_by_equations(input, &mut tied, report);
    if tied.equations.is_empty() {
        return;
    }
    let capacities = capacities_at(input.conductors, start);
    for (index, conditions) in steps.iter_mut().enumerate() {
        let Some(conditions) = conditions else { continue };
        let prescribed_nodes = conditions.held.iter().flat_map(|h| &h.nodes).map(|n| (n.node, 0)).collect();
        let prescribed = PrescribedDofs { all: prescribed_nodes, ..PrescribedDofs::default() };
        match LinkSystem::new(&tied.equations, &[], &capacities, &prescribed) {
            Ok(bonds) => conditions.bonds = bonds,
            Err(LinkConflict::Dependent(found)) => {
                let step = &input.scene.model.steps[index];
                refuse_dependent_equation(step, &found, &tied.spans, report);
                return;
            }
            // Temperatures have no linked nodes, which this error is about.
            Err(LinkConflict::ConflictingMotions(..)) => {}
        }
    }
}

/// Adds the ties: each dependent node has the weighted mean of the temperatures of the nodes that it follows.
fn tied_surfaces(input: HeatInput, links: &Links, tied: &mut TemperatureEquations, report: &mut Report) {
    let HeatInput { scene, conducting, .. } = input;
    for (tie, of_tie) in scene.model.constraints.ties.iter().zip(&links.surface_ties) {
        let previous_count = tied.equations.len();
        for own in &of_tie.nodes {
            let place = |n: usize| scene.places.nodes.get(&n).copied().filter(|p| conducting.contains(p));
            let shares: Option<Vec<_>> = own.shares.iter().map(|&(n, share)| Some(((place(n)?, 0), -share))).collect();
            // Nodes without temperature are skipped; their motion is tied.
            let (Some(node), Some(shares)) = (place(own.node), shares) else { continue };
            let terms = std::iter::once(((node, 0), 1.0)).chain(shares).collect();
            tied.equations.push(NodalEquation { terms, is_redundant: true });
            tied.spans.push(tie.span);
        }
        let count = tied.equations.len() - previous_count;
        if count > 0 {
            let detail = format!("{}: equal temperatures on both surfaces", tie.name);
            report.ledger_row(tie.span, "tied temperatures", count, "nodes", detail);
        }
    }
}

fn tied_by_equations(input: HeatInput, tied: &mut TemperatureEquations, report: &mut Report) {
    let HeatInput { scene, conducting, .. } = input;
    let model = scene.model;
    let mut first = None;
    let previous_count = tied.equations.len();
    for equation in model.constraints.equations.iter().filter(|e| e.is_thermal()) {
        let mut terms = Vec::with_capacity(equation.terms.len());
        for &(node, _, c) in &equation.terms {
            let Some(solver_node) = scene.places.nodes.get(&node).copied().filter(|p| conducting.contains(p)) else {
                let message = format!("*EQUATION: node {} has no temperature", model.mesh.node_names[node]);
                let finding = Diagnostic::error("P063", message).at(equation.span, "an equation on 11");
                return report.push(finding.help("nodes of CAX4RT and CAX3T have temperatures"));
            };
            terms.push(((solver_node, 0), c));
        }
        tied.equations.push(NodalEquation { terms, is_redundant: false });
        tied.spans.push(equation.span);
        first = first.or(Some(equation.span));
    }
    if let Some(span) = first {
        let count = tied.equations.len() - previous_count;
        report.ledger_row(span, "equations between temperatures", count, "equations", "exact".into());
    }
}
