//! Reads `*SHELL SECTION`: layers, section points and materials of shells.

use super::context::Context;
use super::families::SectionReader;
use super::faults::{ValueCheck, ValueFault, require, require_line};
use super::materials;
use super::orientations::{self, ANGLE_FIELD};
use super::types::{ElementKind, ShellLayer, ShellSection, ShellThinning};
use crate::deck::table::materials as cards;
use crate::deck::{Card, Word};

/// Field of the material on a data line of `COMPOSITE`.
const MATERIAL_FIELD: usize = 2;

pub fn read_shell_section(context: &mut Context<'_>, sections: &mut SectionReader, card: &Card) {
    let values: cards::ShellSection = card.values();
    let elements = materials::elements_of_section(context, sections, card, ElementKind::is_shell);
    let Some(mut layers) = layers(context, card, &values, elements.as_deref().unwrap_or_default()) else { return };
    let Some(elements) = elements else { return };
    if values.symmetric {
        layers.extend_from_within(..);
        let given = layers.len() / 2;
        layers[given..].reverse();
    }
    let (Some(offset), Some(thinning)) = (offset(context, card), thinning(context, card)) else { return };
    let (per_area, span) = (values.per_area, card.span);
    context.model.shell_sections.push(ShellSection { elements, layers, offset, per_area, thinning, span });
}

/// Returns the layers of a section; the only one without `COMPOSITE`.
fn layers(
    context: &mut Context<'_>,
    card: &Card,
    values: &cards::ShellSection,
    elements: &[usize],
) -> Option<Vec<ShellLayer>> {
    if values.symmetric && !values.composite {
        return context.refuse_value(card.span, "SYMMETRIC requires COMPOSITE");
    }
    let angle_of = |context: &mut Context<'_>, word: &Word| orientations::shell_angle(context, card, word, elements);
    let section_angle = context.optional(card.value("ORIENTATION"), angle_of)?.unwrap_or(0.0);
    let mut layers = Vec::with_capacity(values.layers.len());
    for (line, &[thickness, points]) in values.layers.iter().enumerate() {
        let points = points as usize;
        if !context.accepts(card, check_points(line, points)) {
            return None;
        }
        let (word, angle) = if values.composite {
            let fields = &card.lines[line];
            let angle = match fields.field(ANGLE_FIELD).filter(|word| word.text.starts_with(char::is_alphabetic)) {
                Some(word) => angle_of(context, word)?,
                None => section_angle + context.number_or(fields, ANGLE_FIELD, 0.0)?,
            };
            (fields.field(MATERIAL_FIELD), angle)
        } else {
            (context.required(card, "MATERIAL"), section_angle)
        };
        let material = materials::material_named(context, word?)?;
        layers.push(ShellLayer { material, thickness, points, angle });
    }
    let message = "MATERIAL and COMPOSITE exclude each other: a layer names its material on its data line";
    let is_clear = !(values.composite && card.has("MATERIAL"));
    (context.accepts(card, require(is_clear, message)) && !layers.is_empty()).then_some(layers)
}

/// Returns the distance from the middle surface to the nodes, over the thickness.
fn offset(context: &mut Context<'_>, card: &Card) -> Option<f64> {
    let Some(word) = card.value("OFFSET") else { return Some(0.0) };
    if word.is("SPOS") {
        return Some(0.5);
    }
    if word.is("SNEG") {
        return Some(-0.5);
    }
    let offset = word.number(&mut context.diagnostics)?;
    context.accepts_at(word.span, check_offset(offset)).then_some(offset)
}

/// Returns the thickness change of `POISSON`; the default of explicit analyses is MATERIAL.
fn thinning(context: &mut Context<'_>, card: &Card) -> Option<ShellThinning> {
    let Some(word) = card.value("POISSON") else { return Some(ShellThinning::Material) };
    if word.is("MATERIAL") {
        return Some(ShellThinning::Material);
    }
    if word.is("ELASTIC") {
        return Some(ShellThinning::Elastic);
    }
    let thinning = ShellThinning::Ratio(word.number(&mut context.diagnostics)?);
    context.accepts_at(word.span, thinning.check()).then_some(thinning)
}

/// Checks the number of section points of the layer on a data line.
pub fn check_points(line: usize, points: usize) -> ValueCheck {
    require_line(line, points % 2 == 1, format!("the number of Simpson points must be odd, found {points}"))
}

/// Checks the offset of the nodes.
pub fn check_offset(offset: f64) -> ValueCheck {
    let message = format!("OFFSET must be SPOS, SNEG or a number from -0.5 to 0.5, found {offset}");
    let help = "OFFSET is a fraction of the thickness; for nodes outside of the shell use *MPC or a rigid body";
    require(offset.abs() <= 0.5, message).map_err(|fault| ValueFault { help, ..fault })
}

impl ShellThinning {
    /// Checks the range of an effective Poisson's ratio.
    pub fn check(&self) -> ValueCheck {
        let ShellThinning::Ratio(ratio) = *self else { return Ok(()) };
        let message = format!("POISSON must be above -1 and at most 0.5, found {ratio}");
        let label = "expected MATERIAL, ELASTIC or a ratio";
        require(ratio > -1.0 && ratio <= 0.5, message).map_err(|fault| ValueFault { label, ..fault })
    }
}
