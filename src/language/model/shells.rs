//! Reads `*SHELL SECTION`: thickness, section points and the material of shells.

use super::context::Context;
use super::families::SectionReader;
use super::faults::{ValueCheck, ValueFault, require};
use super::materials;
use super::types::{ElementKind, ShellSection, ShellThinning};
use crate::deck::Card;
use crate::deck::table::materials as cards;

pub fn read_shell_section(context: &mut Context<'_>, sections: &mut SectionReader, card: &Card) {
    let Some((elements, material)) = materials::section_of(context, sections, card, ElementKind::is_shell) else {
        return;
    };
    let cards::ShellSection { per_area, thickness_points: [thickness, points] } = card.values();
    let points = points as usize;
    if !context.accepts(card, check_points(points)) {
        return;
    }
    let Some(thinning) = thinning(context, card) else { return };
    let span = card.span;
    context.model.shell_sections.push(ShellSection { elements, material, thickness, points, per_area, thinning, span });
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

/// Checks the number of section points.
pub fn check_points(points: usize) -> ValueCheck {
    require(points % 2 == 1, format!("the number of Simpson points must be odd, found {points}"))
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
