//! Material failure: `*SHEAR FAILURE`, `*TENSILE FAILURE`, `*DAMAGE INITIATION`, `*DAMAGE EVOLUTION`.

use super::builder::ModelBuilder;
use super::types::{DamageEvolution, FailureCriterion, StrainAtFailure, TensileFailure};
use crate::deck::table::materials as cards;
use crate::deck::{Card, Diagnostic};
use crate::kernel::levels::NestedTable;

/// Index of the value of `CRITERION` in the keyword table.
const DUCTILE: usize = 1;

impl ModelBuilder<'_> {
    pub(super) fn shear_failure(&mut self, card: &Card) {
        let cards::ShearFailure { johnson_cook } = self.values(card);
        let Some(line) = self.first_line(card) else { return };
        let strain = if johnson_cook {
            Some(StrainAtFailure::JohnsonCook(card.read_lines(), None))
        } else if card.lines.len() > 1 || (1..4).any(|i| line.field(i).is_some()) {
            self.strains(card).map(StrainAtFailure::Shear)
        } else {
            let [strain]: [f64; 1] = card.read_lines();
            Some(StrainAtFailure::Constant(strain))
        };
        self.criterion(card, strain, DamageEvolution::Sudden);
    }

    fn criterion(&mut self, card: &Card, strain: Option<StrainAtFailure>, evolution: DamageEvolution) {
        if let Some(strain) = strain {
            self.last_material().failures.push(FailureCriterion { strain, evolution, span: card.span });
        }
    }

    /// Reads rows of a strain and three variables, the first of which varies fastest.
    fn strains(&mut self, card: &Card) -> Option<Vec<[f64; 4]>> {
        let line = self.first_line(card)?;
        let rows: Vec<[f64; 4]> = card.read_lines();
        if NestedTable::new(&rows).is_none() {
            let message = "the rows must be in ascending order, with the first variable varying fastest";
            return self.refuse_value(line.span, message);
        }
        Some(rows)
    }

    /// Reads d1 to d5, melting temperature, transition temperature and reference strain rate.
    fn johnson_cook(&mut self, card: &Card) -> Option<StrainAtFailure> {
        let line = self.first_line(card)?;
        let [d1, d2, d3, d4, d5, melt, transition, rate]: [f64; 8] = card.read_lines();
        if d4 != 0.0 && rate <= 0.0 || d5 != 0.0 && melt <= transition {
            let message = "d4 requires a positive reference strain rate, d5 a melting \
                 temperature above the transition temperature";
            return self.refuse_value(line.span, message);
        }
        Some(StrainAtFailure::JohnsonCook([d1, d2, d3, d4, d5], Some([melt, transition, rate])))
    }

    pub(super) fn damage_initiation(&mut self, card: &Card) {
        let cards::DamageInitiation { criterion } = self.values(card);
        let cohesive = self.interface_initiation(card, criterion);
        let material = self.last_material();
        if material.interface.initiation.is_some() && (!cohesive || !material.failures.is_empty()) {
            let message = "a material has criteria either of solids or of cohesive elements";
            return self.unsupported(card.span, message, "define two materials");
        }
        if cohesive {
            return;
        }
        let strain = if criterion == DUCTILE {
            self.strains(card).map(StrainAtFailure::Ductile)
        } else {
            self.johnson_cook(card)
        };
        self.criterion(card, strain, DamageEvolution::Absent);
    }

    pub(super) fn damage_evolution(&mut self, card: &Card) {
        if self.last_material().interface.initiation.is_some() {
            return self.interface_evolution(card);
        }
        if !self.is_bulk_evolution(card) {
            return;
        }
        let cards::DamageEvolution { energy, rows, .. } = self.values(card);
        let value = rows.first().map_or(f64::NAN, |row| row[0]);
        let evolution = if energy { DamageEvolution::Energy(value) } else { DamageEvolution::Displacement(value) };
        let is_refused = self.missing.has_card("DAMAGE INITIATION");
        match self.last_material().failures.last_mut() {
            Some(last) if last.evolution == DamageEvolution::Absent => last.evolution = evolution,
            _ if is_refused => {}
            _ => {
                let message = "*DAMAGE EVOLUTION must follow a *DAMAGE INITIATION";
                self.diagnostics.push(Diagnostic::error("M105", message).at(card.span, "no *DAMAGE INITIATION before"));
            }
        }
    }

    pub(super) fn tensile_failure(&mut self, card: &Card) {
        let cards::TensileFailure { deletes, cutoff: [cutoff] } = self.values(card);
        self.last_material().tensile_failure = Some(TensileFailure { cutoff, deletes, span: card.span });
    }
}
