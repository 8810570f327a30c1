//! How surfaces interact: `*SURFACE INTERACTION`, `*FRICTION`, `*SURFACE BEHAVIOR`.
//! Never here: which surfaces do.

use super::builder::Builder;
use super::names::upper;
use super::types::{Friction, Interaction, Law, Overclosure};
use crate::deck::Card;

impl Builder<'_> {
    pub(super) fn surface_interaction(&mut self, card: &Card) {
        let Some(name) = self.required(card, "NAME") else { return };
        let name = upper(&name.text);
        self.model.interactions.push(Interaction { name, law: Law::default(), heat_cards: Vec::new() });
        self.contact_note(card);
    }

    /// ABAQUS Keywords Reference Guide, *FRICTION.
    pub(super) fn friction(&mut self, card: &Card) {
        self.contact_note(card);
        let Some(friction) = self.friction_law(card) else { return };
        if let Some(interaction) = self.model.interactions.last_mut() {
            interaction.law.friction = friction;
        }
    }

    fn friction_law(&mut self, card: &Card) -> Option<Friction> {
        let mut friction = if card.has("ROUGH") {
            Friction::of(f64::INFINITY)
        } else {
            let line = self.first_line(card)?;
            let at_rest = self.number_or(line, 0, 0.0)?;
            match card.has("EXPONENTIAL DECAY") {
                true => Friction {
                    at_rest,
                    sliding: self.number(line, 1, "coefficient at great rates of slip")?,
                    decay: self.number(line, 2, "decay")?,
                    ..Friction::default()
                },
                false => Friction::of(at_rest),
            }
        };
        let Friction { at_rest, sliding, decay, .. } = friction;
        let rough = card.has("ROUGH");
        if [at_rest, sliding, decay].iter().any(|x| *x < 0.0 || x.is_nan() || !rough && x.is_infinite()) {
            let message = format!("numbers of friction must not be below zero, not {at_rest}, {sliding}, {decay}");
            self.out_of_range(card.lines.first().map_or(card.span, |l| l.span), message);
            return None;
        }
        if let Some(largest) = self.above_zero(card, "TAUMAX")? {
            friction.largest = largest;
        }
        Some(friction)
    }

    /// ABAQUS Keywords Reference Guide, *SURFACE BEHAVIOR.
    pub(super) fn surface_behavior(&mut self, card: &Card) {
        self.contact_note(card);
        let Some(overclosure) = self.overclosure(card) else { return };
        if let Some(interaction) = self.model.interactions.last_mut() {
            interaction.law.overclosure = overclosure;
        }
    }

    /// ABAQUS Keywords Reference Guide, *GAP CONDUCTANCE.
    pub(super) fn gap_conductance(&mut self, card: &Card) {
        self.contact_note(card);
        let rows = card.lines.iter().map(|l| Some([self.number(l, 0, "conductance")?, self.number_or(l, 1, 0.0)?]));
        let Some(rows) = rows.collect::<Option<Vec<[f64; 2]>>>() else { return };
        let ascend = rows.windows(2).all(|w| w[0][1] < w[1][1]);
        if rows.len() < 2 || !ascend || rows.as_flattened().iter().any(|x| x.is_nan() || *x < 0.0) {
            let message =
                "a gap conductance has two rows or more; no number is below zero, and clearances or pressures ascend";
            self.out_of_range(card.lines.first().map_or(card.span, |l| l.span), message);
            return;
        }
        let Some(interaction) = self.model.interactions.last_mut() else { return };
        let heat = &mut interaction.law.heat;
        *(if card.has("PRESSURE") { &mut heat.over_pressure } else { &mut heat.over_clearance }) = rows;
        interaction.heat_cards.push((card.keyword.name, card.span));
    }

    /// ABAQUS Keywords Reference Guide, *GAP HEAT GENERATION.
    pub(super) fn gap_heat_generation(&mut self, card: &Card) {
        self.contact_note(card);
        let Some(line) = self.first_line(card) else { return };
        let Some(fraction) = self.number_or(line, 0, 1.0) else { return };
        let Some(to_first) = self.number_or(line, 1, 0.5) else { return };
        if !(fraction >= 0.0 && fraction.is_finite() && (0.0..=1.0).contains(&to_first)) {
            let message =
                format!("the fraction must not be below zero, the weight is from 0 to 1, not {fraction}, {to_first}");
            self.out_of_range(line.span, message);
            return;
        }
        let Some(interaction) = self.model.interactions.last_mut() else { return };
        (interaction.law.heat.fraction, interaction.law.heat.to_first) = (fraction, to_first);
        interaction.heat_cards.push((card.keyword.name, card.span));
    }

    fn overclosure(&mut self, card: &Card) -> Option<Overclosure> {
        let kind = card.value("PRESSURE-OVERCLOSURE").map_or_else(|| "HARD".to_owned(), |w| upper(&w.text));
        if kind == "HARD" {
            return Some(Overclosure::Hard);
        }
        let first = self.first_line(card)?;
        let rows = card.lines.iter().filter_map(|l| Some([self.number(l, 0, "pressure")?, self.number_or(l, 1, 0.0)?]));
        let law = match kind.as_str() {
            "LINEAR" => Overclosure::Linear(self.number(first, 0, "stiffness")?),
            "EXPONENTIAL" => {
                Overclosure::Exponential([self.number(first, 1, "pressure")?, self.number(first, 0, "clearance")?])
            }
            _ => Overclosure::Table(rows.collect()),
        };
        let good = match &law {
            Overclosure::Hard => true,
            Overclosure::Linear(stiffness) | Overclosure::Spring(stiffness) => *stiffness > 0.0,
            Overclosure::Exponential(both) => both.iter().all(|x| *x > 0.0),
            Overclosure::Table(rows) => {
                rows.len() > 1 && rows[0][0] == 0.0 && rows.windows(2).all(|w| w[0][0] <= w[1][0] && w[0][1] < w[1][1])
            }
        };
        if good {
            return Some(law);
        }
        let message = match law {
            Overclosure::Table(_) => "pressures begin at zero and do not fall, overclosures grow, in two rows or more",
            _ => "the numbers of a pressure-overclosure relationship must be above zero",
        };
        self.out_of_range(first.span, message);
        None
    }
}
