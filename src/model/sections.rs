//! Sections: `*SOLID SECTION` and `*SECTION CONTROLS`.
//! Never here: materials, what controls do.

use super::builder::Builder;
use super::names::upper;
use super::types::{Hourglass, SectionControls, SolidSection};
use crate::deck::{Card, Span};

impl Builder<'_> {
    pub(super) fn solid_section(&mut self, card: &Card) {
        let (Some(set), Some(material)) = (self.required(card, "ELSET"), self.required(card, "MATERIAL")) else {
            return;
        };
        // In a part the material follows later in the deck: it is looked up by name in the whole deck.
        let known = self.deck.cards.iter().any(|c| {
            c.keyword.name == "MATERIAL" && c.value("NAME").is_some_and(|n| upper(&n.text) == upper(&material.text))
        });
        let elements = self.element_members(set).unwrap_or_default();
        if !known {
            let names = self.material_names();
            self.unknown("M111", "material", material, &names);
            return;
        }
        self.claim("section", &elements, card.span);
        let index = self.material_names().iter().position(|n| *n == upper(&material.text)).unwrap_or(0);
        let controls = card.value("CONTROLS").map(|w| upper(&w.text));
        self.controls_used.extend(card.value("CONTROLS").cloned());
        self.model.sections.push(SolidSection { elements, material: index, controls, span: card.span });
    }

    /// `*SECTION CONTROLS`: hourglass control; the default, RELAX STIFFNESS in ABAQUS, is a spring here.
    pub(super) fn section_controls(&mut self, card: &Card) {
        let Some(name) = self.required(card, "NAME") else { return };
        let kind = card.value("HOURGLASS").map_or("STIFFNESS".into(), |w| upper(&w.text).replace(' ', ""));
        let Ok(distortion) = self.distortion_control(card) else { return };
        let weight = card.value("WEIGHT FACTOR").map_or(Some(0.5), |w| w.number(&mut self.diagnostics)).unwrap_or(0.5);
        let factor = card.lines.first().map_or(Some(1.0), |l| self.number_or(l, 0, 1.0)).unwrap_or(1.0);
        let hourglass = match kind.as_str() {
            "STIFFNESS" | "RELAXSTIFFNESS" => Hourglass::Stiffness,
            "VISCOUS" => Hourglass::Viscous,
            "COMBINED" => Hourglass::Combined(weight),
            "ENHANCED" => Hourglass::Enhanced,
            other => {
                let help = "STIFFNESS, VISCOUS, COMBINED and ENHANCED are";
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
        let Ok(keeps_failed) = self.keeps_failed(card) else { return };
        let name = upper(&name.text);
        self.model.controls.push(SectionControls { name, hourglass, factor, by_area, distortion, keeps_failed });
    }

    /// Where `ELEMENT DELETION` is NO.
    fn keeps_failed(&mut self, card: &Card) -> Result<Option<Span>, ()> {
        match card.value("ELEMENT DELETION") {
            None => Ok(None),
            Some(word) if word.is("YES") => Ok(None),
            Some(word) if word.is("NO") => Ok(Some(card.span)),
            Some(word) => {
                self.out_of_range(word.span, format!("ELEMENT DELETION is YES or NO, not {}", word.text));
                Err(())
            }
        }
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

    /// Sections may name controls that come later; at the end all must be there.
    pub(super) fn check_controls(&mut self) {
        let cards = self.deck.cards.iter().filter(|c| c.keyword.name == "SECTION CONTROLS");
        let names: Vec<String> = cards.filter_map(|c| c.value("NAME")).map(|w| upper(&w.text)).collect();
        for word in std::mem::take(&mut self.controls_used) {
            if !names.contains(&upper(&word.text)) {
                self.unknown("M116", "section controls", &word, &names);
            }
        }
    }

    /// Names of all materials of the deck, in order, whether read yet or not.
    fn material_names(&self) -> Vec<String> {
        let materials = self.deck.cards.iter().filter(|c| c.keyword.name == "MATERIAL");
        materials.filter_map(|c| c.value("NAME")).map(|n| upper(&n.text)).collect()
    }
}
