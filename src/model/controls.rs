//! `*SECTION CONTROLS`.
//! Never here: sections, what controls do.

use super::builder::Builder;
use super::types::{Hourglass, SectionControls};
use crate::deck::Card;
use crate::deck::table::materials as cards;

/// LENGTH RATIO of distortion control without a word (ABAQUS Analysis User's Guide, "Section controls").
const LENGTH_RATIO: f64 = 0.1;

impl Builder<'_> {
    /// `*SECTION CONTROLS`: hourglass control and what else a section can ask of its elements.
    pub(super) fn section_controls(&mut self, card: &Card) {
        let values: cards::SectionControls = self.values(card);
        if values.length_ratio.is_some() && !values.distortion {
            return self.out_of_range(card.span, "LENGTH RATIO is of DISTORTION CONTROL=YES");
        }
        let kinds = [
            Hourglass::RelaxStiffness,
            Hourglass::Stiffness,
            Hourglass::Viscous,
            Hourglass::Combined(values.weight),
            Hourglass::Enhanced,
        ];
        let keeps_failed = (!values.deletes).then_some(card.span);
        // ABAQUS Analysis User's Guide, "Section controls": 1 where elements are deleted, else 0.99.
        let most_damage = values.most_damage.unwrap_or(if values.deletes { 1.0 } else { 0.99 });
        let controls = SectionControls {
            hourglass: values.hourglass.map(|kind| kinds[kind]),
            factor: values.factor[0],
            by_area: values.by_area,
            distortion: values.distortion.then(|| values.length_ratio.unwrap_or(LENGTH_RATIO)),
            most_damage,
            averaged: values.averaged,
            subzonal: values.subzonal,
            keeps_failed,
        };
        self.controls.entry(values.name).or_insert(controls);
    }
}
