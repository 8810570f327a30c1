//! Errors on whole numbers that follow from a parameter with a fraction: one error, which names this parameter.

use super::diagnostic::Diagnostics;
use super::parameters::next_reference;
use super::syntax::Deck;

impl Deck {
    /// Gives errors on fields `<name>` that must be whole numbers the message and help of the parameter from which the
    /// fraction comes, so that they are merged.
    pub fn name_fractions(&self, diagnostics: &mut Diagnostics) {
        for finding in diagnostics.iter_mut().filter(|finding| finding.code == "D304") {
            let Some(place) = finding.labels.first() else { continue };
            let Some(reference) = next_reference(self.sources.text(place.span)) else { continue };
            if let Some((origin, value)) = self.origin_of_fraction(reference.name) {
                finding.message =
                    format!("parameter `{origin}` is {value}, which gives fields that are not whole numbers");
                finding.help = Some(format!(
                    "give `{origin}` a whole number; these fields are numbers or counts of nodes and elements"
                ));
            }
        }
    }

    /// Returns the parameter without other fractions in its definition from which a parameter has its fraction.
    fn origin_of_fraction<'a>(&'a self, name: &'a str) -> Option<(&'a str, f64)> {
        let fraction =
            |name: &str| self.parameters.iter().find(|p| p.0 == name).map(|p| p.1).filter(|x| x.fract() != 0.0);
        let mut origin = (name, fraction(name)?);
        // Definitions refer to earlier ones, so that the search ends.
        for definition in self.definitions.iter().rev() {
            if definition.name == origin.0 {
                let words = definition.text.split(|c: char| !c.is_alphanumeric() && c != '_');
                origin = words
                    .filter(|word| *word != origin.0)
                    .find_map(|word| Some((word, fraction(word)?)))
                    .unwrap_or(origin);
            }
        }
        Some(origin)
    }
}
