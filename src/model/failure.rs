//! Failure of materials: `*SHEAR FAILURE`, `*TENSILE FAILURE`, `*DAMAGE INITIATION`, `*DAMAGE EVOLUTION`.
//! Never here: what fails when.

use super::builder::Builder;
use super::names::upper;
use super::types::{DamageEvolution, FailureCriterion, StrainAtFailure, TensileFailure};
use crate::deck::{Card, Diagnostic};
use crate::kernel::levels::NestedTable;

impl Builder<'_> {
    /// A parameter in upper case without blanks; the default where it is absent.
    fn word(&mut self, card: &Card, name: &str, default: &str) -> String {
        card.value(name).map_or(default.into(), |w| upper(&w.text).replace(' ', ""))
    }

    pub(super) fn shear_failure(&mut self, card: &Card) {
        let strain = match self.word(card, "TYPE", "TABULAR").as_str() {
            "JOHNSONCOOK" => self.johnson_cook(card, false),
            "TABULAR" => self.shear_strain(card),
            other => {
                let help = "TABULAR and JOHNSON COOK are";
                self.unsupported(card.span, format!("TYPE={other} is not supported"), help);
                None
            }
        };
        self.criterion(card, strain, DamageEvolution::Sudden);
    }

    fn criterion(&mut self, card: &Card, strain: Option<StrainAtFailure>, evolution: DamageEvolution) {
        if let Some(strain) = strain {
            self.last_material().failures.push(FailureCriterion { strain, evolution, span: card.span });
        }
    }

    /// A plastic strain, or rows of it over rate, pressure ratio and temperature.
    fn shear_strain(&mut self, card: &Card) -> Option<StrainAtFailure> {
        let line = self.first_line(card)?;
        if card.lines.len() > 1 || (1..4).any(|i| line.field(i).is_some()) {
            return self.strains(card).map(StrainAtFailure::Shear);
        }
        let strain = self.number(line, 0, "the plastic strain at failure")?;
        if strain <= 0.0 {
            self.out_of_range(line.span, format!("the plastic strain at failure must be above zero, not {strain}"));
            return None;
        }
        Some(StrainAtFailure::Constant(strain))
    }

    /// Rows of a strain and three variables, the first of which varies fastest.
    fn strains(&mut self, card: &Card) -> Option<Vec<[f64; 4]>> {
        let line = self.first_line(card)?;
        let rows: Vec<[f64; 4]> = card.lines.iter().map(|l| self.numbers::<4>(l, &[0.0; 4])).collect::<Option<_>>()?;
        if rows.iter().any(|r| r[0] <= 0.0 || r[0].is_nan()) || NestedTable::new(&rows).is_none() {
            let message =
                "strains must be above zero, and each variable ascend, the first fastest, for each value of the next";
            self.out_of_range(line.span, message);
            return None;
        }
        Some(rows)
    }

    /// d1 to d5, and where the card holds them melting temperature, transition temperature and reference rate.
    fn johnson_cook(&mut self, card: &Card, scales: bool) -> Option<StrainAtFailure> {
        let line = self.first_line(card)?;
        if scales {
            let [d1, d2, d3, d4, d5, melt, transition, rate] = self.numbers::<8>(line, &[0.0; 8])?;
            if d4 != 0.0 && rate <= 0.0 || d5 != 0.0 && melt <= transition {
                let message =
                    "d4 needs a reference rate above zero, d5 a melting temperature above the transition temperature";
                self.out_of_range(line.span, message);
                return None;
            }
            return Some(StrainAtFailure::JohnsonCook([d1, d2, d3, d4, d5], Some([melt, transition, rate])));
        }
        Some(StrainAtFailure::JohnsonCook(self.numbers::<5>(line, &[0.0; 5])?, None))
    }

    pub(super) fn damage_initiation(&mut self, card: &Card) {
        let strain = match self.word(card, "CRITERION", "").as_str() {
            "JOHNSONCOOK" => self.johnson_cook(card, true),
            "DUCTILE" => self.strains(card).map(StrainAtFailure::Ductile),
            other => {
                let help = "JOHNSON COOK and DUCTILE are";
                self.unsupported(card.span, format!("CRITERION={other} is not supported"), help);
                None
            }
        };
        self.criterion(card, strain, DamageEvolution::Absent);
    }

    pub(super) fn damage_evolution(&mut self, card: &Card) {
        let kind = self.word(card, "TYPE", "");
        let Some(line) = self.first_line(card) else { return };
        let Some(value) = self.number(line, 0, "the displacement or energy at failure") else { return };
        if value < 0.0 {
            self.out_of_range(
                line.span,
                format!("displacement or energy at failure must not be below zero, not {value}"),
            );
            return;
        }
        let evolution = match kind.as_str() {
            "DISPLACEMENT" => DamageEvolution::Displacement(value),
            "ENERGY" => DamageEvolution::Energy(value),
            other => {
                self.unsupported(card.span, format!("TYPE={other} is not supported"), "DISPLACEMENT and ENERGY are");
                return;
            }
        };
        match self.last_material().failures.last_mut() {
            Some(last) if last.evolution == DamageEvolution::Absent => last.evolution = evolution,
            _ => {
                let message = "*DAMAGE EVOLUTION belongs below a *DAMAGE INITIATION";
                self.diagnostics.push(Diagnostic::error("M105", message).at(card.span, "none above"));
            }
        }
    }

    pub(super) fn tensile_failure(&mut self, card: &Card) {
        let deletes = match self.word(card, "ELEMENT DELETION", "YES").as_str() {
            "YES" => true,
            "NO" => false,
            other => {
                self.out_of_range(card.span, format!("ELEMENT DELETION is YES or NO, not {other}"));
                return;
            }
        };
        let Some(line) = self.first_line(card) else { return };
        let Some(cutoff) = self.number(line, 0, "the cutoff stress") else { return };
        if cutoff <= 0.0 {
            self.out_of_range(line.span, format!("the cutoff must be above zero (tension), not {cutoff}"));
            return;
        }
        self.last_material().tensile_failure = Some(TensileFailure { cutoff, deletes, span: card.span });
    }
}
