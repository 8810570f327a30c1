//! `*ENERGY LIMIT`.
//! Never here: what a run does where a limit is passed.

use super::builder::Builder;
use super::names::upper;
use super::types::EnergyLimit;
use crate::deck::Card;

impl Builder<'_> {
    /// A step goes on with the limits of the step before until it gives its own.
    pub(super) fn energy_limit(&mut self, card: &Card) {
        if self.step.is_none() {
            self.outside_step(card);
            return;
        }
        let (Some(error), Some(artificial)) = (self.above_zero(card, "ERROR"), self.above_zero(card, "ARTIFICIAL"))
        else {
            return;
        };
        if error.is_none() && artificial.is_none() {
            self.out_of_range(card.span, "*ENERGY LIMIT needs ERROR or ARTIFICIAL");
            return;
        }
        let halts = match card.value("ACTION").map(|w| upper(&w.text)).as_deref() {
            None | Some("WARN") => false,
            Some("HALT") => true,
            Some(other) => {
                self.unsupported(card.span, format!("ACTION={other} is not supported"), "WARN and HALT are");
                return;
            }
        };
        self.state().energy_limit = Some(EnergyLimit { span: card.span, error, artificial, halts });
    }
}
