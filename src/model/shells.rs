//! Sections of shells: `*SHELL SECTION`.
//! Never here: what a material does under load.

use super::builder::Builder;
use super::types::{ElementKind, ShellSection, ShellThinning};
use crate::deck::{Card, Diagnostic};

/// Points through the thickness without a word of the deck (ABAQUS Keywords Guide, *SHELL SECTION).
const POINTS: i64 = 5;

impl Builder<'_> {
    pub(super) fn shell_section(&mut self, card: &Card) {
        let Some((elements, material)) = self.section_of(card, |kind| kind == ElementKind::Sax1) else { return };
        let Some(line) = self.first_line(card) else { return };
        let Some(thickness) = self.number(line, 0, "the thickness") else { return };
        let Some(points) = line.field(1).map_or(Some(POINTS), |w| w.integer(&mut self.diagnostics)) else { return };
        if thickness <= 0.0 {
            self.out_of_range(line.span, format!("a thickness must be above zero, not {thickness}"));
            return;
        }
        if points < 3 || points % 2 == 0 || points > 1001 {
            self.out_of_range(
                line.span,
                format!("Simpson's rule takes an odd number of points from 3 on, not {points}"),
            );
            return;
        }
        let per_area = card.value("DENSITY").map_or(Some(0.0), |w| w.number(&mut self.diagnostics));
        let (Some(per_area), Some(thinning)) = (per_area, self.thinning(card)) else { return };
        let (points, span) = (points as usize, card.span);
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
            self.diagnostics.push(finding.at(word.span, "MATERIAL, ELASTIC or a ratio"));
            return None;
        }
        Some(ShellThinning::Ratio(ratio))
    }
}
