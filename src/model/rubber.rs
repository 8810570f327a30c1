//! Rubber, foam and damping: `*HYPERELASTIC`, `*CRUSHABLE FOAM`, `*CRUSHABLE FOAM HARDENING`, `*DAMPING`.
//! Never here: stresses.

use super::builder::Builder;
use super::types::{FoamShape, Hyperelastic, RubberShape};
use crate::deck::Card;
use crate::deck::table::materials as cards;

/// The highest order of a polynomial.
pub(super) const ORDER: usize = 6;
/// That of a sum after Ogden.
const OGDEN_ORDER: usize = 3;

/// The forms of `*HYPERELASTIC` that are known.
const FORMS: [&str; 6] = ["NEO HOOKE", "MOONEY-RIVLIN", "YEOH", "OGDEN", "POLYNOMIAL", "REDUCED POLYNOMIAL"];

/// The exponents of a polynomial of this order, in the order of the card: C10, C01, C20, C11, C02, ...
fn full(order: usize) -> Vec<(usize, usize)> {
    (1..=order).flat_map(|sum| (0..=sum).map(move |j| (sum - j, j))).collect()
}

fn reduced(order: usize) -> Vec<(usize, usize)> {
    (1..=order).map(|i| (i, 0)).collect()
}

/// From constants and an order to the form of an energy.
type Shaping = fn(&[f64], usize) -> RubberShape;

impl Builder<'_> {
    /// `*HYPERELASTIC` by its form; without one it is a polynomial. Eight constants stand on a line.
    pub(super) fn hyperelastic(&mut self, card: &Card) {
        let given: Vec<&str> = FORMS.into_iter().filter(|form| card.has(form)).collect();
        if given.len() > 1 {
            return self.out_of_range(card.span, format!("{} and {} exclude each other", given[0], given[1]));
        }
        let form = given.first().copied().unwrap_or("POLYNOMIAL");
        let Some(order) = self.order(card, form) else { return };
        let (wanted, shape): (usize, Shaping) = match form {
            "NEO HOOKE" => (1, |c, _| RubberShape::NeoHooke(c[0])),
            "OGDEN" => (2 * order, |c, _| RubberShape::Ogden(c.as_chunks::<2>().0.to_vec())),
            "YEOH" | "REDUCED POLYNOMIAL" => (order, |c, n| polynomial(c, reduced(n))),
            _ => (full(order).len(), |c, n| polynomial(c, full(n))),
        };
        let Some(values) = self.rubber_constants(card, wanted + order) else { return };
        let (constants, compressibility) = values.split_at(wanted);
        let shape = shape(constants, order);
        if let RubberShape::Ogden(terms) = &shape
            && terms.iter().any(|t| t[1] == 0.0)
        {
            return self.out_of_range(card.span, "each alpha must be other than zero");
        }
        if shape.shear() <= 0.0 {
            let message = format!("the initial shear modulus must be above zero, not {}", shape.shear());
            return self.out_of_range(card.span, message);
        }
        // What does not give way in volume has no stable increment: all zero means the default.
        let first = compressibility[0];
        if compressibility.iter().any(|d| *d < 0.0) || first == 0.0 && compressibility.iter().any(|d| *d != 0.0) {
            return self.out_of_range(card.span, "D1 must be above zero and the others not below, or all of them zero");
        }
        let rubber = Hyperelastic { shape, compressibility: compressibility.to_vec(), span: card.span };
        self.last_material().hyperelastic = Some(rubber);
    }

    /// N, where the form has an order.
    fn order(&mut self, card: &Card, form: &str) -> Option<usize> {
        let fixed = match form {
            "YEOH" => Some(3),
            "NEO HOOKE" | "MOONEY-RIVLIN" => Some(1),
            _ => None,
        };
        let Some(word) = card.value("N") else { return Some(fixed.unwrap_or(1)) };
        if fixed.is_some() {
            return self.refuse_value(word.span, format!("{form} has no order N"));
        }
        let cards::Hyperelastic { order } = self.values(card);
        let order = order.unwrap_or(1);
        if form == "OGDEN" && order > OGDEN_ORDER {
            return self.refuse_value(word.span, format!("N of OGDEN must be from 1 to {OGDEN_ORDER}, found {order}"));
        }
        Some(order)
    }

    /// So many constants, eight a line; those that are not given are zero, but for the first. A temperature may follow.
    fn rubber_constants(&mut self, card: &Card, count: usize) -> Option<Vec<f64>> {
        let line = self.first_line(card)?;
        self.number(line, 0, "the first constant")?;
        if let Some(line) = card.lines.get(count / 8 + 1) {
            let help = "give one row; where it takes more than eight values, they go on on the next line";
            return self.refuse_unsupported(line.span, "constants over the temperature are not supported", help);
        }
        let surplus = |(l, line): (usize, &crate::deck::DataLine)| {
            line.fields.iter().enumerate().find(|(k, w)| 8 * l + k > count && !w.text.is_empty()).map(|f| f.1.span)
        };
        if let Some(span) = card.lines.iter().enumerate().find_map(surplus) {
            return self.refuse_value(span, format!("this form takes {count} constants and a temperature"));
        }
        (0..count)
            .map(|k| match card.lines.get(k / 8) {
                Some(line) => self.number_or(line, k % 8, 0.0),
                None => Some(0.0),
            })
            .collect()
    }

    /// `*CRUSHABLE FOAM`: the shape of the yield surface.
    pub(super) fn crushable_foam(&mut self, card: &Card) {
        let cards::CrushableFoam { isotropic, ratios } = self.values(card);
        let shape = if isotropic { FoamShape::Isotropic(ratios) } else { FoamShape::Volumetric(ratios) };
        self.last_material().foam.shape = Some((shape, card.span));
    }

    /// `*CRUSHABLE FOAM HARDENING`: both columns are given positive in compression.
    pub(super) fn foam_hardening(&mut self, card: &Card) {
        let cards::CrushableFoamHardening { rows } = self.values(card);
        if rows.first().is_some_and(|row| row[1] != 0.0) {
            return self.out_of_range(card.span, "plastic strains must begin at 0");
        }
        self.last_material().foam.hardening = rows;
    }

    /// `*DAMPING`: a factor of zero is none.
    pub(super) fn damping(&mut self, card: &Card) {
        let cards::Damping { alpha } = self.values(card);
        self.last_material().damping = alpha.filter(|alpha| *alpha != 0.0).map(|alpha| (alpha, card.span));
    }
}

fn polynomial(constants: &[f64], exponents: Vec<(usize, usize)>) -> RubberShape {
    RubberShape::Polynomial(constants.iter().zip(exponents).map(|(c, (i, j))| (*c, i, j)).collect())
}
