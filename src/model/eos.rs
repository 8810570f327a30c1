//! Equations of state: `*EOS`, `*PHYSICAL CONSTANTS`.
//! Never here: pressures.

use super::builder::Builder;
use super::names::upper;
use super::types::{EosKind, EquationOfState};
use crate::deck::Card;

impl Builder<'_> {
    pub(super) fn eos(&mut self, card: &Card) {
        let Some(kind) = self.required(card, "TYPE") else { return };
        let name = upper(&kind.text).replace(' ', "");
        if !matches!(name.as_str(), "IDEALGAS" | "USUP") {
            let help = "IDEAL GAS and USUP are";
            self.unsupported(kind.span, format!("TYPE={} is not supported", kind.text), help);
            return;
        }
        let Some(line) = self.first_line(card) else { return };
        let kind = if name == "IDEALGAS" {
            let (Some(gas_constant), Some(ambient)) =
                (self.number(line, 0, "the gas constant"), self.number_or(line, 1, 0.0))
            else {
                return;
            };
            if gas_constant <= 0.0 || ambient < 0.0 {
                self.out_of_range(line.span, "the gas constant must be above zero, the ambient pressure not below");
                return;
            }
            EosKind::IdealGas([gas_constant, ambient])
        } else {
            let (Some(c0), Some(s), Some(gamma0)) = (
                self.number(line, 0, "the sound speed c0"),
                self.number_or(line, 1, 0.0),
                self.number_or(line, 2, 0.0),
            ) else {
                return;
            };
            if c0 <= 0.0 || s < 0.0 || gamma0 < 0.0 {
                self.out_of_range(line.span, "c0 must be above zero, s and Gamma0 not below");
                return;
            }
            EosKind::UsUp([c0, s, gamma0])
        };
        self.last_material().eos = Some(EquationOfState { kind, span: card.span });
    }

    /// `*PHYSICAL CONSTANTS`: absolute zero; other constants serve analyses that are not here.
    pub(super) fn physical_constants(&mut self, card: &Card) {
        if let Some(zero) = card.value("ABSOLUTE ZERO").and_then(|w| w.number(&mut self.diagnostics)) {
            self.model.absolute_zero = zero;
        }
    }
}
