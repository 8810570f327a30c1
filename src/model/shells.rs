//! Sections of shells: `*SHELL SECTION`.
//! Never here: what a material does under load.

use super::builder::Builder;
use super::types::{ElementKind, ShellSection, ShellThinning};
use crate::deck::table::materials as cards;
use crate::deck::{Card, Diagnostic};

impl Builder<'_> {
    pub(super) fn shell_section(&mut self, card: &Card) {
        let Some((elements, material)) = self.section_of(card, |kind| kind == ElementKind::Sax1) else { return };
        let cards::ShellSection { per_area, thickness_points: [thickness, points] } = self.values(card);
        let points = points as usize;
        if points.is_multiple_of(2) {
            let message = format!("Simpson's rule takes an odd number of points, not {points}");
            return self.out_of_range(card.span, message);
        }
        let Some(thinning) = self.thinning(card) else { return };
        let span = card.span;
        self.model.shell_sections.push(ShellSection {
            elements,
            material,
            thickness,
            points,
            per_area,
            thinning,
            span,
        });
    }

    /// `POISSON`: in explicit analyses MATERIAL by default.
    fn thinning(&mut self, card: &Card) -> Option<ShellThinning> {
        let Some(word) = card.value("POISSON") else { return Some(ShellThinning::Material) };
        if word.is("MATERIAL") {
            return Some(ShellThinning::Material);
        }
        if word.is("ELASTIC") {
            return Some(ShellThinning::Elastic);
        }
        let ratio = word.number(&mut self.diagnostics)?;
        if !(-1.0..=0.5).contains(&ratio) || ratio == -1.0 {
            let finding = Diagnostic::error("M103", format!("POISSON lies above -1 and is 0.5 at most, not {ratio}"));
            return self.diagnostics.refuse(finding.at(word.span, "MATERIAL, ELASTIC or a ratio"));
        }
        Some(ShellThinning::Ratio(ratio))
    }
}
