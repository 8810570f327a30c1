//! Rubber, foam and damping: `*HYPERELASTIC`, `*CRUSHABLE FOAM`, `*CRUSHABLE FOAM HARDENING`, `*DAMPING`.

use super::context::Context;
use super::families::MaterialReader;
use super::faults::{ValueCheck, is_non_negative, is_positive, require};
use super::rubber_fit::{FittedForm, RubberFit};
use super::types::{DeviatoricEnergy, HyperelasticLaw};
use crate::deck::Card;
use crate::deck::table::materials as cards;

/// Highest order of polynomial forms.
const ORDER: usize = 6;
/// Highest order of the Ogden form.
const OGDEN_ORDER: usize = 3;

/// Supported forms of `*HYPERELASTIC`.
const FORMS: [&str; 6] = ["NEO HOOKE", "MOONEY-RIVLIN", "YEOH", "OGDEN", "POLYNOMIAL", "REDUCED POLYNOMIAL"];

/// Returns the exponents of a full polynomial in the order of the card: C10, C01, C20, C11, C02, ...
fn full(order: usize) -> Vec<(usize, usize)> {
    (1..=order).flat_map(|sum| (0..=sum).map(move |j| (sum - j, j))).collect()
}

fn reduced(order: usize) -> Vec<(usize, usize)> {
    (1..=order).map(|i| (i, 0)).collect()
}

/// Constructor of a deviatoric energy from its constants and order.
type EnergyConstructor = fn(&[f64], usize) -> DeviatoricEnergy;

/// Reads `*HYPERELASTIC`; the default form is the polynomial. A data line has eight constants.
pub fn read_hyperelastic(context: &mut Context<'_>, materials: &mut MaterialReader, card: &Card) {
    let form = FORMS.into_iter().find(|form| card.has(form)).unwrap_or("POLYNOMIAL");
    let Some(order) = order(context, card, form) else { return };
    if card.has("TEST DATA INPUT") {
        return request_fit(context, materials, card, form, order);
    }
    let (constant_count, shape): (usize, EnergyConstructor) = match form {
        "NEO HOOKE" => (1, |c, _| DeviatoricEnergy::NeoHooke(c[0])),
        "OGDEN" => (2 * order, |c, _| DeviatoricEnergy::Ogden(c.as_chunks::<2>().0.to_vec())),
        "YEOH" | "REDUCED POLYNOMIAL" => (order, |c, n| polynomial(c, reduced(n))),
        _ => (full(order).len(), |c, n| polynomial(c, full(n))),
    };
    let Some(values) = rubber_constants(context, card, constant_count + order) else { return };
    let (constants, compressibility) = values.split_at(constant_count);
    let shape = shape(constants, order);
    let (compressibility, span) = (compressibility.to_vec(), card.span);
    let rubber = HyperelasticLaw { shape, compressibility, test_data: Vec::new(), span };
    if context.accepts(card, rubber.check()) {
        context.last_material().hyperelastic = Some(rubber);
    }
}

/// Requests the fit of the constants to the test data that follow.
fn request_fit(context: &mut Context<'_>, materials: &mut MaterialReader, card: &Card, form: &str, order: usize) {
    let fitted = match form {
        "OGDEN" => FittedForm::Ogden(order),
        "NEO HOOKE" | "YEOH" | "REDUCED POLYNOMIAL" => FittedForm::Polynomial(reduced(order)),
        _ => FittedForm::Polynomial(full(order)),
    };
    let material = context.model.materials.len() - 1;
    materials.rubber_fits.push(RubberFit { material, form: fitted, order, span: card.span, data: Vec::new() });
}

impl HyperelasticLaw {
    /// Checks the constants. An incompressible material has no stable time increment: D = 0 selects the default
    /// compressibility.
    pub fn check(&self) -> ValueCheck {
        let is_valid = match &self.shape {
            DeviatoricEnergy::NeoHooke(_) => true,
            DeviatoricEnergy::Polynomial(terms) => {
                terms.iter().all(|&(c, i, j)| c.is_finite() && i <= ORDER && j <= ORDER && i + j > 0)
            }
            DeviatoricEnergy::Ogden(terms) => {
                require(terms.iter().all(|term| term[1] != 0.0), "each alpha must be nonzero")?;
                terms.iter().flatten().all(|value| value.is_finite())
            }
        };
        require(is_valid, format!("the constants must be finite, and exponents at most {ORDER}"))?;
        let shear = self.shape.shear();
        require(is_positive(shear), format!("the initial shear modulus must be positive, found {shear}"))?;
        let all_zero = self.compressibility.iter().all(|d| *d == 0.0);
        let is_compressible = self.compressibility.first().is_some_and(|first| all_zero || is_positive(*first));
        let message = "D1 must be positive and the others not negative, or all must be zero";
        require(is_compressible && self.compressibility.iter().all(|d| is_non_negative(*d)), message)
    }
}

/// Returns the order N of the form.
fn order(context: &mut Context<'_>, card: &Card, form: &str) -> Option<usize> {
    let fixed = match form {
        "YEOH" => Some(3),
        "NEO HOOKE" | "MOONEY-RIVLIN" => Some(1),
        _ => None,
    };
    let Some(word) = card.value("N") else { return Some(fixed.unwrap_or(1)) };
    if fixed.is_some() {
        return context.refuse_value(word.span, format!("N is not allowed for {form}"));
    }
    let cards::Hyperelastic { order } = card.values();
    let order = order.unwrap_or(1);
    if form == "OGDEN" && order > OGDEN_ORDER {
        return context.refuse_value(word.span, format!("N of OGDEN must be from 1 to {OGDEN_ORDER}, found {order}"));
    }
    Some(order)
}

/// Reads the constants, eight per line; all but the first are zero by default. A temperature may follow and is
/// ignored.
fn rubber_constants(context: &mut Context<'_>, card: &Card, count: usize) -> Option<Vec<f64>> {
    let line = context.first_line(card)?;
    context.number(line, 0, "the first constant")?;
    if let Some(line) = card.lines.get(count / 8 + 1) {
        let help = "give one row; more than eight values continue on the next line";
        return context.refuse_unsupported(line.span, "temperature-dependent constants are not supported", help);
    }
    let surplus = |(l, line): (usize, &crate::deck::DataLine)| {
        line.fields.iter().enumerate().find(|(k, w)| 8 * l + k > count && !w.text.is_empty()).map(|f| f.1.span)
    };
    if let Some(span) = card.lines.iter().enumerate().find_map(surplus) {
        return context.refuse_value(span, format!("this form has {count} constants and a temperature"));
    }
    if card.lines.get(count / 8).is_some_and(|line| line.field(count % 8).is_some()) {
        context.inert(card, "the constants do not depend on temperature");
    }
    (0..count)
        .map(|k| match card.lines.get(k / 8) {
            Some(line) => context.number_or(line, k % 8, 0.0),
            None => Some(0.0),
        })
        .collect()
}

/// Reads `*CRUSHABLE FOAM HARDENING`; both columns are positive in compression.
pub fn read_foam_hardening(context: &mut Context<'_>, card: &Card) {
    let cards::CrushableFoamHardening { rows } = card.values();
    if context.accepts(card, check_foam_hardening(&rows)) {
        context.last_material().foam.hardening = rows;
    }
}

pub fn check_foam_hardening(rows: &[[f64; 2]]) -> ValueCheck {
    require(rows.first().is_none_or(|row| row[1] == 0.0), "plastic strains must start at 0")
}

fn polynomial(constants: &[f64], exponents: Vec<(usize, usize)>) -> DeviatoricEnergy {
    DeviatoricEnergy::Polynomial(constants.iter().zip(exponents).map(|(c, (i, j))| (*c, i, j)).collect())
}
