//! General contact: `*CONTACT`, `*CONTACT INCLUSIONS`, `*CONTACT EXCLUSIONS` and the assignment cards.

use super::builder::ModelBuilder;
use super::types::{AssignedInteraction, ContactDomain, GeneralContact, InteractionLaw};
use crate::deck::read::FromValue;
use crate::deck::{Card, DataLine, Diagnostic, Word};

impl ModelBuilder<'_> {
    /// Reads `*CONTACT` (ABAQUS Keywords Reference Guide): OP=MOD, the default, extends the definition in force; NEW
    /// replaces it.
    pub(super) fn general_contact(&mut self, card: &Card) {
        let new = self.is_new(card);
        let in_force = &mut self.state().general_contact;
        if new || in_force.is_none() {
            *in_force = Some(GeneralContact { span: card.span, ..GeneralContact::default() });
        }
    }

    /// Reads a card that follows `*CONTACT`.
    pub(super) fn general_contact_card(&mut self, card: &Card) {
        if self.state().general_contact.is_none() {
            let message = format!("*{} must follow a *CONTACT", card.keyword.name);
            return self.diagnostics.push(Diagnostic::error("M105", message).at(card.span, "no *CONTACT before"));
        }
        if let Some(general) = &mut self.state().general_contact {
            general.all |= card.has("ALL EXTERIOR");
            // NODAL EROSION=NO, the default, keeps the nodes of completely eroded elements in contact as point masses;
            // YES removes them (ABAQUS Keywords Reference Guide, *CONTACT CONTROLS ASSIGNMENT).
            if card.has("NODAL EROSION") {
                general.excludes_detached_nodes = card.read("NODAL EROSION");
            }
        }
        for (at, line) in card.lines.iter().enumerate() {
            let Some(domains) = self.domains(line) else { continue };
            let (third, given) = (line.field(2).cloned(), || card.given_field(at, 2));
            let Some(general) = &mut self.state().general_contact else { continue };
            match (card.keyword.name, third) {
                ("CONTACT INCLUSIONS", _) if domains.iter().all(|d| matches!(d, ContactDomain::Analytical(_))) => {
                    let message = "contact of analytical surfaces with each other is not supported";
                    self.unsupported(line.span, message, "one of the surfaces must have elements");
                }
                ("CONTACT INCLUSIONS", _) => general.included.push((domains, line.span)),
                ("CONTACT EXCLUSIONS", _) => general.excluded.push(domains),
                ("CONTACT CONTROLS ASSIGNMENT", _) => general.penalties.push((domains, f64::from_value(given()))),
                ("CONTACT FORMULATION", _) => general.roles.push((domains, usize::from_value(given()) < 2)),
                (_, None) => {}
                ("CONTACT PROPERTY ASSIGNMENT", Some(word)) => {
                    let interaction = self.interaction(&word);
                    let Some(general) = &mut self.state().general_contact else { continue };
                    general.assigned.push(AssignedInteraction { domains, interaction, law: InteractionLaw::default() });
                }
                (_, Some(word)) => {
                    let clearance = self.clearance(&word);
                    let Some(general) = &mut self.state().general_contact else { continue };
                    general.clearances.extend(clearance.map(|clearance| (domains, clearance)));
                }
            }
        }
    }

    /// Returns the pair of surfaces of a data line. An empty first field is the whole exterior, an empty second field
    /// the first.
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
        match self.analytical_id(word) {
            Some(surface) => Some(ContactDomain::Analytical(surface)),
            None => self.contact_sides(word).map(ContactDomain::Surface),
        }
    }
}
