//! General contact: `*CONTACT`, `*CONTACT INCLUSIONS`, `*CONTACT EXCLUSIONS`, and the cards that give what meets something.
//! Never here: which surfaces there are, pairs that the deck names one by one.

use super::builder::Builder;
use super::types::{AssignedInteraction, ContactDomain, GeneralContact, Law};
use crate::deck::read::FromValue;
use crate::deck::{Card, DataLine, Diagnostic, Word};

impl Builder<'_> {
    /// ABAQUS Keywords Reference Guide, *CONTACT: OP=MOD (default) goes on with what is in force, NEW begins anew.
    pub(super) fn general_contact(&mut self, card: &Card) {
        let new = self.is_new(card);
        let in_force = &mut self.state().general_contact;
        if new || in_force.is_none() {
            *in_force = Some(GeneralContact { span: card.span, ..GeneralContact::default() });
        }
    }

    /// One of the cards below *CONTACT.
    pub(super) fn general_contact_card(&mut self, card: &Card) {
        if self.state().general_contact.is_none() {
            let message = format!("*{} belongs below a *CONTACT", card.keyword.name);
            return self.diagnostics.push(Diagnostic::error("M105", message).at(card.span, "no *CONTACT above"));
        }
        if let Some(general) = &mut self.state().general_contact {
            general.all |= card.has("ALL EXTERIOR");
            // With NODAL EROSION=NO, the default, nodes whose faces have all eroded stay in contact as point masses, with YES they
            // do not (ABAQUS Keywords Reference Guide, *CONTACT CONTROLS ASSIGNMENT).
            if card.has("NODAL EROSION") {
                general.drops_points = card.read("NODAL EROSION");
            }
        }
        for (at, line) in card.lines.iter().enumerate() {
            let Some(domains) = self.domains(line) else { continue };
            let (third, factor) = (line.field(2).cloned(), f64::from_value(card.given_field(at, 2)));
            let Some(general) = &mut self.state().general_contact else { continue };
            match (card.keyword.name, third) {
                ("CONTACT INCLUSIONS", _) => general.included.push((domains, line.span)),
                ("CONTACT EXCLUSIONS", _) => general.excluded.push(domains),
                ("CONTACT CONTROLS ASSIGNMENT", _) => general.penalties.push((domains, factor)),
                (_, None) => {}
                ("CONTACT PROPERTY ASSIGNMENT", Some(word)) => {
                    let interaction = self.interaction(&word);
                    let Some(general) = &mut self.state().general_contact else { continue };
                    general.assigned.push(AssignedInteraction { domains, interaction, law: Law::default() });
                }
                (_, Some(word)) => {
                    let clearance = self.clearance(&word);
                    let Some(general) = &mut self.state().general_contact else { continue };
                    general.clearances.extend(clearance.map(|clearance| (domains, clearance)));
                }
            }
        }
    }

    /// The two surfaces of a line: the first is all that is outside where it is left out, the second the first.
    fn domains(&mut self, line: &DataLine) -> Option<[ContactDomain; 2]> {
        let first = self.domain(line.field(0))?;
        let second = match line.field(1).filter(|w| !w.text.is_empty()) {
            None if line.field(0).is_none_or(|w| w.text.is_empty()) => ContactDomain::All,
            None => first.clone(),
            some => self.domain(some)?,
        };
        Some([first, second])
    }

    fn domain(&mut self, word: Option<&Word>) -> Option<ContactDomain> {
        let Some(word) = word.filter(|w| !w.text.is_empty()) else { return Some(ContactDomain::All) };
        self.contact_sides(word).map(ContactDomain::Surface)
    }
}
