//! `*BOUNDARY`. Propagation over the steps is in `history`.

use super::context::Context;
use super::families::{ConditionReader, RotationalCondition, StepReader};
use super::names::upper;
use super::refinement::listed;
use super::types::{BoundaryCondition, MotionKind};
use super::{adaptive, amplitudes};
use crate::deck::{Card, DataLine, Diagnostic, Word};

/// Degrees of freedom named on a data line of `*BOUNDARY`.
struct DofSelection {
    /// First and last degree of freedom.
    range: [u8; 2],
    /// Rotation that a named symmetry constrains in addition.
    rotation: Option<u8>,
}

impl DofSelection {
    fn range(first: u8, last: u8) -> DofSelection {
        DofSelection { range: [first, last], rotation: None }
    }
}

pub fn read_boundary(context: &mut Context<'_>, conditions: &mut ConditionReader, steps: &mut StepReader, card: &Card) {
    let kinds = [MotionKind::Displacement, MotionKind::Velocity, MotionKind::Acceleration];
    let kind = match card.read::<Option<usize>>("TYPE") {
        None if card.has("TYPE") => return,
        kind => kinds[kind.unwrap_or(0)],
    };
    let user = card.has("USER");
    let ramp = steps.current.as_ref().is_some_and(|s| s.ramp);
    let Ok(amplitude) = amplitudes::amplitude_of(context, card, "AMPLITUDE") else { return };
    boundary_operation(context, steps, card);
    let from = steps.state().boundaries.len();
    for line in &card.lines {
        let Some(set) = line.field(0) else { continue };
        let Some(nodes) = context.node_members(set) else { continue };
        let Some((degrees, value)) = boundary_dofs(context, line) else { continue };
        let ([first, last], rotation) = (degrees.range, degrees.rotation);
        let value = amplitudes::scaled(context, value, amplitude);
        if first == 11 {
            let (set, kind, span) = (set.text.clone(), MotionKind::Temperature, line.span);
            let condition = BoundaryCondition { nodes, set, dof: 11, kind, user: false, value, amplitude, span };
            prescribe_temperature(context, steps, card, condition);
            continue;
        }
        if steps.current.is_none() && (value != 0.0 || user) {
            // ABAQUS Analysis User's Guide 34.3.1, "Prescribing boundary conditions as model data".
            let message = "a boundary condition before the first step can only fix degrees of freedom";
            let diagnostic = Diagnostic::error("M105", message).at(line.span, "nonzero value");
            context.diagnostics.push(diagnostic.help("give it inside a *STEP"));
            continue;
        }
        if kind == MotionKind::Displacement && value != 0.0 && amplitude.is_none() && !user && !ramp {
            let message = format!(
                "the displacement {value} without AMPLITUDE would be a jump: the \
                 value is ignored and the degree of freedom is fixed"
            );
            let diagnostic = Diagnostic::warning("M140", message).at(line.span, "as ABAQUS/Explicit does");
            context.diagnostics.push(diagnostic.help("give AMPLITUDE=, or prescribe a velocity"));
        }
        if first > 2 {
            let (span, set, nodes) = (line.span, set.text.clone(), nodes.clone());
            let (dofs, lost) = ([first, last], "is constrained");
            conditions.rotational.push(RotationalCondition { span, set, dofs, nodes, lost, value });
        }
        for dof in (first..=last).chain(rotation) {
            let (nodes, set, span) = (nodes.clone(), set.text.clone(), line.span);
            let condition = BoundaryCondition { nodes, set, dof, kind, user, value, amplitude, span };
            steps.state().boundaries.push(condition);
        }
    }
    listed::complete_boundaries(context, steps, from);
    let nodes = steps.state().boundaries[from..].iter().flat_map(|boundary| &boundary.nodes).copied().collect();
    adaptive::adaptive_region(steps, card, Vec::new(), nodes);
}

/// Prescribes a temperature (degree of freedom 11). Without amplitude the value is applied at once (ABAQUS Analysis
/// User's Guide 34.1.2, "Amplitude curves").
fn prescribe_temperature(context: &mut Context<'_>, steps: &mut StepReader, card: &Card, condition: BoundaryCondition) {
    let refusal = if card.has("USER") || card.value("TYPE").is_some_and(|w| !w.is("DISPLACEMENT")) {
        Some(("USER and TYPE of a prescribed temperature are not supported", "give a value, with AMPLITUDE="))
    } else if steps.current.is_none() {
        Some(("a temperature cannot be prescribed before the first step", "give it inside a *STEP"))
    } else if steps.current.as_ref().is_some_and(|s| s.ramp) && condition.amplitude.is_none() {
        Some(("*STEP, AMPLITUDE=RAMP with a prescribed temperature is not supported", "give AMPLITUDE="))
    } else {
        None
    };
    if let Some((message, help)) = refusal {
        return context.unsupported(condition.span, message, help);
    }
    steps.state().boundaries.push(condition);
}

/// Applies `OP`: `OP=NEW` removes the boundary conditions of earlier steps. All `*BOUNDARY` cards of a step must
/// have the same `OP` (ABAQUS Keywords Reference Guide, *BOUNDARY).
fn boundary_operation(context: &mut Context<'_>, steps: &mut StepReader, card: &Card) {
    let new = card.read::<bool>("OP");
    let Some(step) = &mut steps.current else { return };
    if step.new_boundaries.is_some_and(|other| other != new) {
        let message = "OP must be the same on all *BOUNDARY cards of a step: NEW \
             removes all earlier conditions, MOD keeps them";
        return context.out_of_range(card.span, message);
    }
    step.new_boundaries = Some(new);
    if new {
        step.history.boundaries.clear();
    }
}

/// Returns the degrees of freedom of a data line, and the value.
fn boundary_dofs(context: &mut Context<'_>, line: &DataLine) -> Option<(DofSelection, f64)> {
    let Some(word) = line.field(1) else {
        let diagnostic = Diagnostic::error("M102", "a degree of freedom is missing").at(line.span, "here");
        return context.diagnostics.refuse(diagnostic);
    };
    let name = upper(&word.text);
    let is_zero = |word: &&Word| word.text.parse().is_ok_and(|value: f64| value == 0.0);
    let further = (2..5).find_map(|k| line.field(k)).filter(|word| !is_zero(word));
    if let Some(word) = further.filter(|_| word.text.parse::<f64>().is_err()) {
        context.report_surplus(word, &format!("{name} is a set of fixed degrees of freedom and has no value"));
        return None;
    }
    match name.as_str() {
        "ENCASTRE" => return Some((DofSelection::range(1, 6), 0.0)),
        "PINNED" => return Some((DofSelection::range(1, 3), 0.0)),
        // Symmetry also constrains the rotations about axes in the plane: 5 and 6, 4 and 6, 4 and 5 (ABAQUS
        // Analysis User's Guide 34.3.1, "Boundary conditions").
        "XSYMM" | "YSYMM" => {
            let dof = if name == "XSYMM" { 1 } else { 2 };
            return Some((DofSelection { rotation: shell_rotation(context), range: [dof; 2] }, 0.0));
        }
        "ZSYMM" => return Some((DofSelection::range(3, 3), 0.0)),
        other @ ("XASYMM" | "YASYMM" | "ZASYMM") => {
            let message = format!("antisymmetry ({other}) is not supported; ABAQUS has it in implicit analyses only");
            return context.refuse_unsupported(word.span, message, "name the degrees of freedom: 1 is r, 2 is z");
        }
        _ => {}
    }
    let first = word.integer(&mut context.diagnostics)?;
    let last = line.field(2).map_or(Some(first), |w| w.integer(&mut context.diagnostics))?;
    let value = context.number_or(line, 3, 0.0)?;
    if [first, last] != [11; 2] && (!(1..=6).contains(&first) || !(first..=6).contains(&last)) {
        let allowed = "1 is r, 2 is z, 6 is rotation, 11 is temperature";
        return context.refuse_value(line.span, format!("invalid degrees of freedom {first} to {last}: {allowed}"));
    }
    Some((DofSelection::range(first as u8, last as u8), value))
}

/// Returns the rotational degree of freedom if the deck has shells.
fn shell_rotation(context: &Context<'_>) -> Option<u8> {
    let shells = |c: &&Card| c.keyword.name == "ELEMENT" && c.value("TYPE").is_some_and(|w| w.is("SAX1"));
    context.deck.cards.iter().find(shells).map(|_| 6)
}
