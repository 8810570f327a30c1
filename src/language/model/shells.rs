//! Reads `*SHELL SECTION`: thickness, section points and the material of shells.

use super::context::Context;
use super::families::SectionReader;
use super::materials;
use super::types::{ElementKind, ShellSection, ShellThinning};
use crate::deck::table::materials as cards;
use crate::deck::{Card, Diagnostic};

pub(super) fn read_shell_section(context: &mut Context<'_>, sections: &mut SectionReader, card: &Card) {
    let Some((elements, material)) = materials::section_of(context, sections, card, |kind| kind == ElementKind::Sax1)
    else {
        return;
    };
    let cards::ShellSection { per_area, thickness_points: [thickness, points] } = card.values();
    let points = points as usize;
    if points.is_multiple_of(2) {
        let message = format!("the number of Simpson points must be odd, found {points}");
        return context.out_of_range(card.span, message);
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
    let ratio = word.number(&mut context.diagnostics)?;
    if !(-1.0..=0.5).contains(&ratio) || ratio == -1.0 {
        let diagnostic = Diagnostic::error("M103", format!("POISSON must be above -1 and at most 0.5, found {ratio}"));
        return context.diagnostics.refuse(diagnostic.at(word.span, "expected MATERIAL, ELASTIC or a ratio"));
    }
    Some(ShellThinning::Ratio(ratio))
}
