//! How surfaces interact: `*SURFACE INTERACTION`, `*FRICTION`, `*SURFACE BEHAVIOR`.
//! Never here: which surfaces do.

use super::builder::Builder;
use super::names::upper;
use super::types::{Friction, Interaction, Law, Overclosure};
use crate::deck::Card;
use crate::deck::table::constraints as cards;

/// Pressure-overclosure relationships by their place among the words.
const HARD: usize = 0;
const LINEAR: usize = 1;
const EXPONENTIAL: usize = 2;

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
        let cards::Friction { largest, rough, decays, values: [at_rest, sliding, decay] } = self.values(card);
        let mut friction = if rough {
            Friction::of(f64::INFINITY)
        } else if decays {
            Friction { at_rest, sliding, decay, ..Friction::default() }
        } else {
            self.first_line(card)?;
            Friction::of(at_rest)
        };
        friction.largest = largest.unwrap_or(friction.largest);
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
        let cards::GapConductance { over_pressure, rows } = self.values(card);
        if rows.len() < 2 {
            return self.out_of_range(card.span, "a gap conductance needs two rows or more");
        }
        let Some(interaction) = self.model.interactions.last_mut() else { return };
        let heat = &mut interaction.law.heat;
        *(if over_pressure { &mut heat.over_pressure } else { &mut heat.over_clearance }) = rows;
        interaction.heat_cards.push((card.keyword.name, card.span));
    }

    /// ABAQUS Keywords Reference Guide, *GAP HEAT GENERATION.
    pub(super) fn gap_heat_generation(&mut self, card: &Card) {
        self.contact_note(card);
        let cards::GapHeatGeneration { values: [fraction, to_first] } = self.values(card);
        let Some(interaction) = self.model.interactions.last_mut() else { return };
        (interaction.law.heat.fraction, interaction.law.heat.to_first) = (fraction, to_first);
        interaction.heat_cards.push((card.keyword.name, card.span));
    }

    fn overclosure(&mut self, card: &Card) -> Option<Overclosure> {
        let cards::SurfaceBehavior { kind } = self.values(card);
        match kind {
            HARD => Some(Overclosure::Hard),
            LINEAR => {
                let [stiffness]: [f64; 1] = card.read_lines();
                Some(Overclosure::Linear(stiffness))
            }
            EXPONENTIAL => {
                let [clearance, pressure]: [f64; 2] = card.read_lines();
                Some(Overclosure::Exponential([pressure, clearance]))
            }
            _ => {
                let rows: Vec<[f64; 2]> = card.read_lines();
                if rows.len() > 1 && rows[0][0] == 0.0 && rows.windows(2).all(|w| w[0][0] <= w[1][0]) {
                    return Some(Overclosure::Table(rows));
                }
                let message = "pressures must begin at zero and must not fall, in two rows or more";
                self.refuse_value(card.span, message)
            }
        }
    }
}
