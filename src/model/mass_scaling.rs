//! `*FIXED MASS SCALING` and `*VARIABLE MASS SCALING`.
//! Never here: which elements can be scaled, what it does to them.

use super::builder::Builder;
use super::types::{MassScaling, ScalingRhythm, ScalingType};
use crate::deck::Card;
use crate::deck::names::fold;

impl Builder<'_> {
    /// A step that scales masses replaces what earlier steps asked for; one that does not goes on with it.
    pub(super) fn mass_scaling(&mut self, card: &Card) {
        if self.step.is_none() {
            self.outside_step(card);
            return;
        }
        let Some(request) = self.scaling_request(card) else { return };
        let state = self.state();
        if !state.cleared.contains(&"MASS SCALING") {
            state.cleared.push("MASS SCALING");
            state.mass_scalings.clear();
        }
        state.mass_scalings.push(request);
    }

    fn scaling_request(&mut self, card: &Card) -> Option<MassScaling> {
        let elements = match card.value("ELSET") {
            Some(word) => Some(self.element_members(word)?),
            None => None,
        };
        let factor = self.above_zero(card, "FACTOR")?;
        let dt = self.above_zero(card, "DT")?;
        let kind = self.scaling_type(card)?;
        let rhythm = self.scaling_rhythm(card)?;
        if factor.is_none() && dt.is_none() {
            let needs = if rhythm.is_none() { "FACTOR or DT" } else { "DT" };
            self.out_of_range(card.span, format!("*{} needs {needs}", card.keyword.name));
            return None;
        }
        if dt.is_none() && card.has("TYPE") {
            self.out_of_range(card.span, "TYPE says how DT is reached, and there is no DT");
            return None;
        }
        let target = dt.map(|dt| (kind, dt));
        Some(MassScaling { span: card.span, elements, factor: factor.unwrap_or(1.0), target, rhythm })
    }

    /// The value of a parameter that must be above zero; `Some(None)` where it is not given.
    pub(super) fn above_zero(&mut self, card: &Card, name: &str) -> Option<Option<f64>> {
        let Some(word) = card.value(name) else {
            if card.has(name) {
                self.out_of_range(card.span, format!("{name} needs a value"));
                return None;
            }
            return Some(None);
        };
        let value = word.number(&mut self.diagnostics)?;
        if value > 0.0 && value.is_finite() {
            return Some(Some(value));
        }
        self.out_of_range(word.span, format!("{name} must be above zero, not {value}"));
        None
    }

    fn scaling_type(&mut self, card: &Card) -> Option<ScalingType> {
        match card.value("TYPE").map(|w| fold(&w.text)).as_deref() {
            None | Some("BELOWMIN") => Some(ScalingType::BelowMin),
            Some("UNIFORM") => Some(ScalingType::Uniform),
            Some("SETEQUALDT") => Some(ScalingType::SetEqual),
            Some(other) => {
                let help = "BELOW MIN, UNIFORM and SET EQUAL DT are";
                self.unsupported(card.span, format!("TYPE={other} of mass scaling is not supported"), help);
                None
            }
        }
    }

    /// `Some(None)` for fixed mass scaling.
    fn scaling_rhythm(&mut self, card: &Card) -> Option<Option<ScalingRhythm>> {
        if card.keyword.name == "FIXED MASS SCALING" {
            return Some(None);
        }
        let (name, make): (&str, fn(u64) -> ScalingRhythm) = match (card.has("FREQUENCY"), card.has("NUMBER INTERVAL"))
        {
            (true, false) => ("FREQUENCY", ScalingRhythm::Increments),
            (false, true) => ("NUMBER INTERVAL", ScalingRhythm::Intervals),
            _ => {
                self.out_of_range(card.span, "*VARIABLE MASS SCALING needs either FREQUENCY or NUMBER INTERVAL");
                return None;
            }
        };
        let count = card.value(name).map_or(Some(0), |w| w.integer(&mut self.diagnostics))?;
        if count < 1 {
            self.out_of_range(card.span, format!("{name} must be a number above zero"));
            return None;
        }
        Some(Some(make(count.unsigned_abs())))
    }
}
