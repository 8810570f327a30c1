//! Reads rigid bodies and their masses and motion: `*RIGID BODY`, `*ATTITUDE`, `*MASS`, `*ROTARY INERTIA` and `*INITIAL
//! CONDITIONS`.

use super::context::Context;
use super::families::{ConditionReader, SectionReader};
use super::names::{SetKind, upper};
use super::refinement::listed;
use super::types::{ElementKind, InitialAttitude, InitialCondition, InitialKind, PointMass, RigidBody, RotaryInertia};
use super::{contact, user_material};
use crate::deck::read::FromValue;
use crate::deck::table::constraints as cards;
use crate::deck::{Card, Diagnostic, Word};

/// Indices of the values of `TYPE` in the keyword table.
const FIELD: usize = 5;
const SOLUTION: usize = 6;

pub fn read_rigid_body(context: &mut Context<'_>, card: &Card) {
    let Some(reference) = context.required(card, "REF NODE") else { return };
    let Some(reference) = context.single_node(reference, "REF NODE") else { return };
    if let Some(word) = card.value("ANALYTICAL SURFACE") {
        contact::carry_surface(context, word, reference);
    }
    let elements = card.value("ELSET").and_then(|w| context.element_members(w)).unwrap_or_default();
    let mut tied = Vec::new();
    for name in ["PIN NSET", "TIE NSET"] {
        tied.extend(card.value(name).and_then(|w| context.node_members(w)).unwrap_or_default());
    }
    let density: f64 = card.read("DENSITY");
    let thickness = f64::from_value(card.given_field(0, 0));
    let is_facet = |e: &usize| context.model.mesh.elements[*e].kind == ElementKind::Rax2;
    if let Some(word) = card.value("DENSITY").filter(|_| density > 0.0 && thickness == 0.0)
        && elements.iter().any(is_facet)
    {
        let message = "DENSITY of RAX2 elements requires their thickness on the data line";
        context.error("M102", message, word.span, "the mass would be zero");
    }
    let name = card.value("ELSET").map_or_else(|| "RIGID BODY".into(), |w| upper(&w.text));
    let span = card.span;
    context.model.rigid_bodies.push(RigidBody { name, reference, elements, nodes: tied, thickness, density, span });
}

/// Assigns a mass to the nodes of the MASS elements of a set.
pub fn read_mass(context: &mut Context<'_>, sections: &mut SectionReader, card: &Card) {
    let Some(set) = context.required(card, "ELSET") else { return };
    let cards::Mass { mass: [mass] } = card.values();
    let elements = match point_elements(context, card, set, ElementKind::Mass) {
        Ok(elements) => elements,
        Err(diagnostic) => {
            let help = "define the point mass with *ELEMENT, TYPE=MASS in a separate \
                        ELSET; the mass of solids is given by *DENSITY";
            return context.diagnostics.push(diagnostic.help(help));
        }
    };
    sections.assign_property(context, "mass", &elements, card.span);
    for element in elements {
        let node = context.model.mesh.elements[element].nodes[0];
        context.model.discrete.masses.push(PointMass { node, mass, span: card.span });
    }
}

/// Returns the elements of a set, which must all be of the type that the card requires.
fn point_elements(
    context: &mut Context<'_>,
    card: &Card,
    set: &Word,
    kind: ElementKind,
) -> Result<Vec<usize>, Diagnostic> {
    let elements = context.element_members(set).unwrap_or_default();
    let mesh = &context.model.mesh;
    let Some(&other) = elements.iter().find(|&&e| mesh.elements[e].kind != kind) else { return Ok(elements) };
    let other = &mesh.elements[other];
    let message = format!(
        "`{}` contains element {} of type {}, but *{} requires elements of TYPE={}",
        set.text,
        other.name,
        other.kind.name(),
        card.keyword.name,
        kind.name()
    );
    Err(Diagnostic::error("M121", message).at(set.span, "this set"))
}

/// Reads the rotary inertia of ROTARYI elements. A body of revolution has no products of inertia.
pub fn read_rotary_inertia(context: &mut Context<'_>, sections: &mut SectionReader, card: &Card) {
    let Some(set) = context.required(card, "ELSET") else { return };
    let cards::RotaryInertia { moments: [first, axial, third] } = card.values();
    let [axial, third] = [axial, third].map(|moment| if moment.is_nan() { first } else { moment });
    let elements = match point_elements(context, card, set, ElementKind::RotaryInertia) {
        Ok(elements) => elements,
        Err(diagnostic) => return context.diagnostics.push(diagnostic),
    };
    sections.assign_property(context, "rotary inertia", &elements, card.span);
    for element in elements {
        let node = context.model.mesh.elements[element].nodes[0];
        let moments = [first, axial, third];
        context.model.discrete.inertias.push(RotaryInertia { node, moments, span: card.span });
    }
}

pub fn read_attitude(context: &mut Context<'_>, card: &Card) {
    let Some(reference) = context.required(card, "REF NODE") else { return };
    let Some(reference) = context.single_node(reference, "REF NODE") else { return };
    let cards::Attitude { stations, inertia, angles } = card.values();
    let uniform = inertia.is_some();
    context.model.attitudes.push(InitialAttitude { reference, angles, stations, uniform, span: card.span });
}

pub fn read_initial_conditions(context: &mut Context<'_>, conditions: &mut ConditionReader, card: &Card) {
    let kind: usize = card.read("TYPE");
    if kind == SOLUTION {
        return user_material::initial_state(context, conditions, card);
    }
    if let Some(word) = card.value("VARIABLE").filter(|_| kind != FIELD) {
        return context.unsupported(word.span, "VARIABLE is allowed with TYPE=FIELD only", "remove it");
    }
    let from = context.model.initial_conditions.len();
    for (at, line) in card.lines.iter().enumerate() {
        let Some(set) = line.field(0) else { continue };
        let value = |field| f64::from_value(card.given_field(at, field));
        let kind = match kind {
            0 => InitialKind::Velocity(value(1) as u8, value(2)),
            1 => InitialKind::Temperature(value(1)),
            2 => InitialKind::Stress(
                (1..line.fields.len()).map(|at| if line.field(at).is_some() { value(at) } else { 0.0 }).collect(),
            ),
            3 => InitialKind::Energy(value(1)),
            4 => InitialKind::Hardening(value(1)),
            _ => InitialKind::Field(card.read::<usize>("VARIABLE") - 1, value(1)),
        };
        let of_members = if kind.applies_to_elements() { SetKind::Elements } else { SetKind::Nodes };
        if let Some(members) = context.members(of_members, set) {
            let condition = InitialCondition { kind, members, span: line.span };
            warn_of_repeated_condition(context, conditions, &condition);
            context.model.initial_conditions.push(condition);
        }
    }
    listed::complete_initial_conditions(context, from);
}

/// Warns if an earlier condition of the same kind has the same members: it has no effect.
pub fn warn_of_repeated_condition(
    context: &mut Context<'_>,
    conditions: &mut ConditionReader,
    added: &InitialCondition,
) {
    let InitialCondition { kind, members, span } = added;
    let same = |other: &InitialKind| match (kind, other) {
        (InitialKind::Velocity(dof, _), InitialKind::Velocity(other, _)) => dof == other,
        (InitialKind::Field(variable, _), InitialKind::Field(other, _)) => variable == other,
        _ => std::mem::discriminant(kind) == std::mem::discriminant(other),
    };
    // The number of conditions can be that of nodes, and each comparison of members is short if they differ.
    let first = conditions.repeated_conditions.entry((members.len(), members.first().copied())).or_default();
    let earlier = first.iter().map(|at| &context.model.initial_conditions[*at]);
    let repeated = earlier.filter(|c| same(&c.kind) && c.members == *members).map(|c| c.span).next();
    first.push(context.model.initial_conditions.len());
    if let Some(earlier) = repeated {
        let message = "this initial condition replaces an earlier one of the same kind on the same members";
        context.warn_replaced(message, [earlier, *span]);
    }
}
