//! `*SPRING` and `*DASHPOT`: properties of SPRINGA, SPRING1, DASHPOTA and DASHPOT1 elements.

use super::context::Context;
use super::families::SectionReader;
use super::faults::{ValueCheck, is_non_negative, require};
use super::types::{ConnectorLaw, ConnectorProperty, ElementKind};
use crate::deck::{Card, DataLine};

pub fn read_connectors(context: &mut Context<'_>, sections: &mut SectionReader, card: &Card) {
    let Some(set) = context.required(card, "ELSET") else { return };
    let Some(elements) = context.element_members(set) else { return };
    let is_spring = card.keyword.name == "SPRING";
    let kinds = if is_spring {
        [ElementKind::SpringA, ElementKind::Spring1]
    } else {
        [ElementKind::DashpotA, ElementKind::Dashpot1]
    };
    let kind_of = |e: &usize| context.model.mesh.elements[*e].kind;
    let first = elements.first().map_or(kinds[0], kind_of);
    if !kinds.contains(&first) || elements.iter().any(|e| kind_of(e) != first) {
        let message =
            format!("this set must contain only {} elements, or only {} elements", kinds[0].name(), kinds[1].name());
        return context.out_of_range(set.span, message);
    }
    let along_line = first == kinds[0];
    let filled: Vec<&DataLine> = card.lines.iter().filter(|l| l.field(0).is_some()).collect();
    let mut lines = &filled[..];
    let mut dof = 2;
    if !along_line {
        let Some(line) = context.first_line(card) else { return };
        let Some(given) = context.integer(line, 0, "the degree of freedom") else { return };
        if !(1..=2).contains(&given) {
            return context.out_of_range(line.span, format!("degree of freedom must be 1 (r) or 2 (z), found {given}"));
        }
        dof = given as u8;
        lines = &lines[1..];
    }
    let Some(law) = connector_law(context, card, lines, is_spring) else { return };
    sections.assign_property(context, if is_spring { "spring" } else { "dashpot" }, &elements, card.span);
    let property = ConnectorProperty { elements, dof, law, span: card.span };
    context.model.discrete.connectors.push(property);
}

fn connector_law(context: &mut Context<'_>, card: &Card, lines: &[&DataLine], is_spring: bool) -> Option<ConnectorLaw> {
    if card.has("NONLINEAR") {
        let over = if is_spring { "the relative displacement" } else { "the relative velocity" };
        let row = |line: &&DataLine| Some([context.number(line, 1, over)?, context.number(line, 0, "the force")?]);
        let rows: Vec<[f64; 2]> = lines.iter().map(row).collect::<Option<_>>()?;
        let law = if is_spring { ConnectorLaw::Table(rows) } else { ConnectorLaw::DashpotTable(rows) };
        return context.accepts(card, law.check()).then_some(law);
    }
    // For SPRINGA and DASHPOTA the first data line is optional and has no meaning.
    let line = match lines {
        [line] | [_, line] => line,
        _ => {
            return context.refuse_value(card.span, "expected one value; temperature dependence is not supported");
        }
    };
    let value = context.number(line, 0, if is_spring { "the stiffness" } else { "the coefficient" })?;
    let law = if is_spring { ConnectorLaw::Spring(value) } else { ConnectorLaw::Dashpot(value) };
    context.accepts_at(line.span, law.check()).then_some(law)
}

impl ConnectorLaw {
    /// Checks the value, or the order of the rows.
    pub fn check(&self) -> ValueCheck {
        let (rows, over) = match self {
            ConnectorLaw::Spring(value) | ConnectorLaw::Dashpot(value) => {
                return require(is_non_negative(*value), format!("the value must not be negative, found {value}"));
            }
            ConnectorLaw::Table(rows) => (rows, "the relative displacement"),
            ConnectorLaw::DashpotTable(rows) => (rows, "the relative velocity"),
        };
        let ascends = !rows.is_empty() && rows.windows(2).all(|w| w[0][0] < w[1][0]);
        require(ascends, format!("{over} must increase from row to row"))?;
        require(rows.iter().flatten().all(|x| x.is_finite()), "the rows must be finite")
    }
}
