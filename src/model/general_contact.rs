//! General contact: `*CONTACT`, `*CONTACT INCLUSIONS`, `*CONTACT EXCLUSIONS`, and the cards that give what meets something.
//! Never here: which surfaces there are, pairs that the deck names one by one.

use super::builder::Builder;
use super::names::upper;
use super::types::{AssignedClearance, AssignedInteraction, ContactDomain, GeneralContact, Law};
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
            self.diagnostics.push(Diagnostic::error("M105", message).at(card.span, "no *CONTACT above"));
            return;
        }
        if card.has("ALL EXTERIOR")
            && let Some(general) = &mut self.state().general_contact
        {
            general.all = true;
        }
        if card.keyword.name == "CONTACT CONTROLS ASSIGNMENT" {
            self.nodal_erosion(card);
        }
        for line in &card.lines {
            let Some(domains) = self.domains(line) else { continue };
            let third = line.field(2).filter(|w| !w.text.is_empty()).cloned();
            let factor = match card.keyword.name {
                "CONTACT CONTROLS ASSIGNMENT" => match self.penalty_factor(line) {
                    None => continue,
                    factor => factor,
                },
                _ => None,
            };
            let Some(general) = &mut self.state().general_contact else { continue };
            match (card.keyword.name, third) {
                ("CONTACT INCLUSIONS", _) => general.included.push((domains, line.span)),
                ("CONTACT EXCLUSIONS", _) => general.excluded.push(domains),
                ("CONTACT CONTROLS ASSIGNMENT", _) => general.penalties.extend(factor.map(|f| (domains, f))),
                (_, None) => {}
                ("CONTACT PROPERTY ASSIGNMENT", Some(interaction)) => {
                    self.interactions_used.push(interaction.clone());
                    let Some(general) = &mut self.state().general_contact else { continue };
                    general.assigned.push(AssignedInteraction { domains, interaction, law: Law::default() });
                }
                (_, Some(name)) => general.clearances.push(AssignedClearance { domains, name, clearance: None }),
            }
        }
    }

    /// ABAQUS Keywords Reference Guide, *CONTACT CONTROLS ASSIGNMENT, TYPE=SCALE PENALTY.
    fn penalty_factor(&mut self, line: &DataLine) -> Option<f64> {
        let factor = self.number(line, 2, "factor on the penalty stiffness")?;
        if factor > 0.0 && factor.is_finite() {
            return Some(factor);
        }
        self.out_of_range(line.span, format!("a factor on the penalty stiffness must be above zero, not {factor}"));
        None
    }

    /// ABAQUS Keywords Reference Guide, *CONTACT CONTROLS ASSIGNMENT: with NODAL EROSION=NO, the default, nodes whose faces have
    /// all eroded stay in contact as point masses, with YES they do not.
    fn nodal_erosion(&mut self, card: &Card) {
        let drops = match card.value("NODAL EROSION").map(|w| upper(&w.text)).as_deref() {
            Some("YES") => true,
            Some("NO") => false,
            Some(other) => {
                self.unsupported(card.span, format!("NODAL EROSION={other} is not supported"), "YES and NO are");
                return;
            }
            None => return,
        };
        if let Some(general) = &mut self.state().general_contact {
            general.drops_points = drops;
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
