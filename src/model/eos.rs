//! Equations of state: `*EOS`, `*PHYSICAL CONSTANTS`.
//! Never here: pressures.

use super::builder::Builder;
use super::names::upper;
use super::types::{EosKind, EquationOfState};
use crate::deck::{Card, Diagnostic};

impl Builder<'_> {
    pub(super) fn eos(&mut self, card: &Card) {
        let Some(kind) = self.required(card, "TYPE") else { return };
        let found = match upper(&kind.text).replace(' ', "").as_str() {
            "IDEALGAS" => self.ideal_gas(card),
            "USUP" => self.us_up(card),
            "TABULAR" => self.tabulated(card),
            "JWL" => self.jwl(card),
            _ => {
                let help = "IDEAL GAS, USUP, TABULAR and JWL are";
                self.unsupported(kind.span, format!("TYPE={} is not supported", kind.text), help);
                None
            }
        };
        if let Some(kind) = found {
            self.last_material().eos = Some(EquationOfState { kind, span: card.span });
        }
    }

    fn ideal_gas(&mut self, card: &Card) -> Option<EosKind> {
        let line = self.first_line(card)?;
        let gas_constant = self.number(line, 0, "the gas constant")?;
        let ambient = self.number_or(line, 1, 0.0)?;
        if gas_constant <= 0.0 || ambient < 0.0 {
            self.out_of_range(line.span, "the gas constant must be above zero, the ambient pressure not below");
            return None;
        }
        Some(EosKind::IdealGas([gas_constant, ambient]))
    }

    fn us_up(&mut self, card: &Card) -> Option<EosKind> {
        let line = self.first_line(card)?;
        let c0 = self.number(line, 0, "the sound speed c0")?;
        let (s, gamma0) = (self.number_or(line, 1, 0.0)?, self.number_or(line, 2, 0.0)?);
        if c0 <= 0.0 || s < 0.0 || gamma0 < 0.0 {
            self.out_of_range(line.span, "c0 must be above zero, s and Gamma0 not below");
            return None;
        }
        Some(EosKind::UsUp([c0, s, gamma0]))
    }

    /// Rows of f1, f2 and the volumetric strain, from tension to compression.
    fn tabulated(&mut self, card: &Card) -> Option<EosKind> {
        self.first_line(card)?;
        let rows: Vec<[f64; 3]> = card.lines.iter().map(|l| self.numbers::<3>(l, &[0.0; 3])).collect::<Option<_>>()?;
        if let Some(line) = (1..rows.len()).find(|&i| rows[i - 1][2] <= rows[i][2]) {
            let message = "the volumetric strains of the rows must descend, from tension to compression";
            self.out_of_range(card.lines[line].span, message);
            return None;
        }
        if !stiffens(&rows) {
            self.out_of_range(card.span, "at least two rows are needed, and f1 must grow with the compression");
            return None;
        }
        Some(EosKind::Tabular(rows))
    }

    /// Explosive. The seventh value is an energy a mass; one that is far too large is likely an energy a volume.
    fn jwl(&mut self, card: &Card) -> Option<EosKind> {
        const NAMES: [&str; 7] = ["the detonation wave speed", "A", "B", "omega", "R1", "R2", "the detonation energy"];
        let line = self.first_line(card)?;
        let mut values = [0.0; 8];
        for (i, name) in NAMES.into_iter().enumerate() {
            values[i] = self.number(line, i, name)?;
        }
        values[7] = self.number_or(line, 7, 0.0)?;
        let [speed, a, b, omega, r1, r2, energy, unburnt] = values;
        if !is_explosive(&values) {
            let message = format!(
                "the detonation wave speed {speed}, A {a}, omega {omega}, R1 {r1} and R2 {r2} must be above zero, B {b}, the \
                 detonation energy {energy} and the pre-detonation bulk modulus {unburnt} not below"
            );
            self.out_of_range(line.span, message);
            return None;
        }
        let square = speed * speed;
        if energy > square {
            let message = format!(
                "the detonation energy {energy:e} is more than the square of the detonation wave speed, {square:e}: it is taken \
                 as an energy a mass"
            );
            let finding = Diagnostic::warning("M169", message).at(line.span, "the seventh value");
            self.diagnostics.push(finding.help("is it an energy a volume? divide it by the density"));
        }
        Some(EosKind::Jwl(values))
    }

    /// `*DETONATION POINT`: places in the plane, the delay in the fourth field.
    pub(super) fn detonation_points(&mut self, card: &Card) {
        if self.first_line(card).is_none() {
            return;
        }
        let points: Option<Vec<[f64; 4]>> = card.lines.iter().map(|l| self.numbers::<4>(l, &[0.0; 4])).collect();
        if let Some(points) = points {
            self.last_material().detonation = points.iter().map(|p| [p[0], p[1], p[3]]).collect();
        }
    }

    /// `*PHYSICAL CONSTANTS`: absolute zero; other constants serve analyses that are not here.
    pub(super) fn physical_constants(&mut self, card: &Card) {
        if let Some(zero) = card.value("ABSOLUTE ZERO").and_then(|w| w.number(&mut self.diagnostics)) {
            self.model.settings.absolute_zero = zero;
        }
    }
}

/// Whether pressure grows with compression in rows of f1, f2 and a volumetric strain that descends.
pub(super) fn stiffens(rows: &[[f64; 3]]) -> bool {
    rows.len() > 1 && rows.windows(2).all(|w| w[1][0] >= w[0][0]) && rows[rows.len() - 1][0] > rows[0][0]
}

/// Whether constants of a JWL equation are such as it can have.
pub(super) fn is_explosive([speed, a, b, omega, r1, r2, energy, unburnt]: &[f64; 8]) -> bool {
    [speed, a, omega, r1, r2].iter().all(|v| **v > 0.0 && v.is_finite())
        && [b, energy, unburnt].iter().all(|v| **v >= 0.0 && v.is_finite())
}
