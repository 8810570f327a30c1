//! `*SECTION CONTROLS`.
//! Never here: sections, what controls do.

use super::builder::Builder;
use super::names::upper;
use super::types::{Hourglass, SectionControls};
use crate::deck::{Card, Span};

/// What a card says with YES or NO.
struct Said {
    /// The card, where ELEMENT DELETION is NO.
    keeps_failed: Option<Span>,
    averaged: Option<bool>,
    subzonal: Option<bool>,
}

impl Builder<'_> {
    /// `*SECTION CONTROLS`: hourglass control and what else a section can ask of its elements.
    pub(super) fn section_controls(&mut self, card: &Card) {
        let Some(name) = self.required(card, "NAME") else { return };
        // The second and third factor are of shells.
        for word in card.lines.first().into_iter().flat_map(|l| [l.field(3), l.field(4)]).flatten() {
            if word.number(&mut self.diagnostics).is_some_and(|factor| factor != 1.0) {
                let help = "give *BULK VISCOSITY in the step";
                self.unsupported(word.span, "a factor on bulk viscosity by section is not supported", help);
            }
        }
        let kind = card.value("HOURGLASS").map(|w| upper(&w.text).replace(' ', ""));
        let Ok(distortion) = self.distortion_control(card) else { return };
        let weight = card.value("WEIGHT FACTOR").map_or(Some(0.5), |w| w.number(&mut self.diagnostics)).unwrap_or(0.5);
        let factor = card.lines.first().map_or(Some(1.0), |l| self.number_or(l, 0, 1.0)).unwrap_or(1.0);
        let hourglass = match kind.as_deref() {
            None => None,
            Some("RELAXSTIFFNESS") => Some(Hourglass::RelaxStiffness),
            Some("STIFFNESS") => Some(Hourglass::Stiffness),
            Some("VISCOUS") => Some(Hourglass::Viscous),
            Some("COMBINED") => Some(Hourglass::Combined(weight)),
            Some("ENHANCED") => Some(Hourglass::Enhanced),
            Some(other) => {
                let help = "RELAX STIFFNESS, STIFFNESS, VISCOUS, COMBINED and ENHANCED are";
                self.unsupported(card.span, format!("HOURGLASS={other} is not supported"), help);
                return;
            }
        };
        if !(0.0..=1.0).contains(&weight) || factor.is_nan() || factor < 0.0 {
            self.out_of_range(card.span, "WEIGHT FACTOR must lie between 0 and 1, the hourglass factor not below 0");
            return;
        }
        let by_area = match card.value("WEIGHTING") {
            None => false,
            Some(word) if word.is("VOLUME") => false,
            Some(word) if word.is("AREA") => true,
            Some(word) => {
                self.out_of_range(word.span, format!("WEIGHTING is VOLUME or AREA, not {}", word.text));
                return;
            }
        };
        let Ok(Said { keeps_failed, averaged, subzonal }) = self.other_controls(card) else { return };
        // ABAQUS Analysis User's Guide, "Section controls": 1 where elements are deleted, else 0.99.
        let default = if keeps_failed.is_some() { 0.99 } else { 1.0 };
        let word = card.value("MAX DEGRADATION");
        let Some(most_damage) = word.map_or(Some(default), |w| w.number(&mut self.diagnostics)) else { return };
        if !(most_damage > 0.0 && most_damage <= 1.0) {
            self.out_of_range(
                card.span,
                format!("MAX DEGRADATION must lie above 0 and not above 1, not {most_damage}"),
            );
            return;
        }
        let controls =
            SectionControls { hourglass, factor, by_area, distortion, most_damage, averaged, subzonal, keeps_failed };
        self.controls.entry(upper(&name.text)).or_insert(controls);
    }

    /// Controls that are YES or NO, and what of them means nothing here.
    fn other_controls(&mut self, card: &Card) -> Result<Said, ()> {
        let mut said = |name: &str| -> Result<Option<bool>, ()> {
            match card.value(name) {
                None => Ok(None),
                Some(word) if word.is("YES") => Ok(Some(true)),
                Some(word) if word.is("NO") => Ok(Some(false)),
                Some(word) => {
                    self.out_of_range(word.span, format!("{name} is YES or NO, not {}", word.text));
                    Err(())
                }
            }
        };
        let (deletion, accurate) = (said("ELEMENT DELETION")?, said("SECOND ORDER ACCURACY")?);
        let (subzonal, averaged) = (said("SUBZONAL")?, said("AVERAGED PRESSURE")?);
        if accurate == Some(true) {
            let help = "elements follow large rotations of an increment to first order";
            self.unsupported(card.span, "SECOND ORDER ACCURACY=YES is not supported", help);
            return Err(());
        }
        if card.has("RAMP INITIAL STRESS") {
            self.inert(card, "RAMP INITIAL STRESS is of membranes".into());
        }
        Ok(Said { keeps_failed: (deletion == Some(false)).then_some(card.span), averaged, subzonal })
    }

    /// LENGTH RATIO of distortion control (0.1 where the deck says nothing); `Ok(None)` without it, `Err` once refused.
    fn distortion_control(&mut self, card: &Card) -> Result<Option<f64>, ()> {
        let wanted = match card.value("DISTORTION CONTROL").map(|w| upper(&w.text)).as_deref() {
            None if card.has("DISTORTION CONTROL") => true,
            Some("YES") => true,
            None | Some("NO") => false,
            Some(other) => {
                self.out_of_range(card.span, format!("DISTORTION CONTROL is YES or NO, not {other}"));
                return Err(());
            }
        };
        let ratio = card.value("LENGTH RATIO").map_or(Some(0.1), |w| w.number(&mut self.diagnostics)).ok_or(())?;
        if !(ratio > 0.0 && ratio < 1.0) {
            self.out_of_range(card.span, format!("LENGTH RATIO must lie between 0 and 1, not {ratio}"));
            return Err(());
        }
        if card.has("LENGTH RATIO") && !wanted {
            self.out_of_range(card.span, "LENGTH RATIO is of DISTORTION CONTROL=YES");
            return Err(());
        }
        Ok(wanted.then_some(ratio))
    }
}
