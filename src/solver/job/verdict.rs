//! Verdict of a run in one word, with its reasons. The effect of each diagnostic is a column of the tables of codes.

use serde::{Deserialize, Serialize};

use super::RunSummary;
use crate::deck::verdict::{Verdict, VerdictEffect};
use crate::deck::{DiagnosticCode, Severity};
use crate::{model, output, plan};

/// Code of an uncertainty that is not known.
const UNKNOWN: &str = "R323";

/// Reason for a verdict that is not `ok`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct VerdictReason {
    /// Code of the diagnostic, explained by `revolve explain CODE`.
    pub code: String,
    /// Place in the deck (`file:line`) or in the model; `None` if it concerns the whole model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// Message of the diagnostic.
    pub reason: String,
    /// Correction, or the cards that help.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub card: Option<String>,
    /// Verdict that follows from this reason alone.
    pub verdict: Verdict,
}

/// Verdict with its reasons, part of `<job>.json`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct RunVerdict {
    /// The worst verdict of all reasons; `ok` without any.
    pub verdict: Verdict,
    /// Reasons, the worst first.
    #[serde(rename = "verdict_reasons")]
    pub reasons: Vec<VerdictReason>,
}

impl VerdictReason {
    /// Returns the reason that a diagnostic gives; `None` for information.
    pub(super) fn of(code: &str, message: &str) -> Option<VerdictReason> {
        let effect = effect_of(code)?;
        Some(VerdictReason {
            code: code.to_owned(),
            place: place_in(message),
            reason: message.to_owned(),
            card: Some(effect.card.to_owned()),
            verdict: effect.verdict,
        })
    }

    /// Returns the reason that an uncertainty is not known; `place` names the quantity.
    pub fn unknown_uncertainty(place: Option<String>, message: &str) -> Option<VerdictReason> {
        VerdictReason::of(UNKNOWN, message).map(|reason| VerdictReason { place, ..reason })
    }

    pub(super) fn is_unknown_uncertainty(&self) -> bool {
        self.code == UNKNOWN
    }

    /// Returns code, title, place and card in one line.
    pub fn line(&self) -> String {
        let title = find_code(&self.code).map_or(&*self.reason, |code| code.title);
        let place = self.place.as_ref().map_or(String::new(), |place| format!(", {place}"));
        let card = self.card.as_ref().map_or(String::new(), |card| format!(": {card}"));
        format!("{} {title}{place}{card}", self.code)
    }
}

/// Returns the diagnostic code of a deck, a plan or a run.
fn find_code(code: &str) -> Option<&'static DiagnosticCode> {
    plan::codes::CODES.iter().chain(model::codes::CODES).chain(output::codes::CODES).find(|known| known.code == code)
}

/// Returns the effect of a diagnostic code on the verdict; `None` for information.
pub fn effect_of(code: &str) -> Option<&'static VerdictEffect> {
    plan::codes::EFFECTS
        .iter()
        .chain(model::codes::EFFECTS)
        .chain(output::codes::EFFECTS)
        .find(|effect| effect.code == code)
}

/// Returns whether a message with a code makes the results doubtful.
pub fn is_doubtful(warning: &str) -> bool {
    let effect = warning.split_once(':').and_then(|(code, _)| effect_of(code));
    effect.is_some_and(|effect| effect.verdict >= Verdict::Suspect)
}

/// Returns the place that a message of a run names: coordinates, an element, a pair, or a body.
fn place_in(message: &str) -> Option<String> {
    let ends = |text: &str, stops: &[&str]| stops.iter().filter_map(|stop| text.find(stop)).min().unwrap_or(text.len());
    const STOPS: [&str; 6] = [",", ": ", ";", ". ", " near ", " has "];
    let named = |word: &str| {
        let at = message.find(word)?;
        let text = &message[at + word.len()..];
        Some(format!("{word}{}", &text[..ends(text, &STOPS)]).trim().to_owned())
    };
    let position = message.find("(r = ").and_then(|at| Some(message[at..].split_once(')')?.0[1..].to_owned()));
    position.or_else(|| named("element ")).or_else(|| named("pair ")).or_else(|| named("body of material "))
}

impl RunVerdict {
    /// Derives the verdict of a run from its diagnostics and warnings; `unknown` are uncertainties that are not known.
    pub(super) fn of(summary: &RunSummary, unknown: &[VerdictReason]) -> RunVerdict {
        let halt = summary.halt.as_ref().and_then(|halt| {
            let details = halt.details();
            let element = details.element.as_ref().map(|name| format!("element {name}"));
            let reason = VerdictReason::of(halt.code(), halt.message())?;
            Some(VerdictReason { place: element.or(reason.place), ..reason })
        });
        let warnings = summary.warnings.iter().filter_map(|warning| {
            let (code, message) = warning.split_once(": ")?;
            VerdictReason::of(code, message)
        });
        let is_warning = |severity: &str| severity != Severity::Note.word();
        let of_deck = summary.diagnostics.iter().filter(|finding| is_warning(finding.severity)).filter_map(|finding| {
            let reason = VerdictReason::of(finding.code, &finding.message)?;
            Some(VerdictReason { place: finding.place.clone(), card: finding.help.clone().or(reason.card), ..reason })
        });
        let mut reasons: Vec<VerdictReason> =
            halt.into_iter().chain(warnings).chain(of_deck).chain(unknown.iter().cloned()).collect();
        reasons.sort_by_key(|reason| std::cmp::Reverse(reason.verdict));
        RunVerdict { verdict: reasons.first().map_or(Verdict::Ok, |reason| reason.verdict), reasons }
    }
}

#[cfg(test)]
mod tests {
    use super::place_in;

    #[test]
    fn places_are_those_of_messages() {
        let places = [
            ("the section of element 7 near (r = 1.0000e-3, z = 2.0e0) has turned over", "r = 1.0000e-3, z = 2.0e0"),
            ("most in element BAR.12; use HOURGLASS=ENHANCED", "element BAR.12"),
            ("most in pair ROD_PLATE, with the largest release", "pair ROD_PLATE"),
            ("the outline of the body of material STEEL: elements", "body of material STEEL"),
        ];
        for (message, place) in places {
            assert_eq!(place_in(message).as_deref(), Some(place));
        }
        assert_eq!(place_in("ETOTAL has drifted by 2 % of the energy put in"), None);
    }
}
