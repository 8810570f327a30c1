//! Reads `*SECTION CONTROLS`: hourglass control, distortion control, weighting, degradation and element deletion.

use super::context::Context;
use super::families::SectionReader;
use super::types::{HourglassMethod, SectionControls};
use crate::deck::Card;
use crate::deck::table::materials as cards;

/// Default `LENGTH RATIO` of distortion control (ABAQUS Analysis User's Guide, "Section controls").
const LENGTH_RATIO: f64 = 0.1;

pub fn read_section_controls(context: &mut Context<'_>, sections: &mut SectionReader, card: &Card) {
    let values: cards::SectionControls = card.values();
    if values.length_ratio.is_some() && !values.distortion {
        return context.out_of_range(card.span, "LENGTH RATIO requires DISTORTION CONTROL=YES");
    }
    let kinds = [
        HourglassMethod::RelaxStiffness,
        HourglassMethod::Stiffness,
        HourglassMethod::Viscous,
        HourglassMethod::Combined(values.weight),
        HourglassMethod::Enhanced,
    ];
    let keeps_failed = (!values.deletes).then_some(card.span);
    // ABAQUS Analysis User's Guide, "Section controls": 1 if elements are deleted, otherwise 0.99.
    let most_damage = values.most_damage.unwrap_or(if values.deletes { 1.0 } else { 0.99 });
    let controls = SectionControls {
        hourglass: values.hourglass.map(|kind| kinds[kind]),
        factor: values.factor[0],
        by_area: values.by_area,
        distortion: values.distortion.then(|| values.length_ratio.unwrap_or(LENGTH_RATIO)),
        max_degradation: most_damage,
        viscosity: values.viscosity,
        averaged: values.averaged,
        subzonal: values.subzonal,
        keep_failed_elements: keeps_failed,
    };
    sections.controls.entry(values.name).or_insert(controls);
}
