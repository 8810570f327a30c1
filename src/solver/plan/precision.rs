//! Selection of the elements in single precision.

use super::{Compiler, State};
use crate::deck::{Diagnostic, Span};
use crate::element::constants::ElementConstants;
use crate::model::{MaterialDefinition, Precision, SolidSection};

impl Compiler<'_> {
    /// Returns whether the elements of a section are in single precision, and lists the precision in the ledger if
    /// single precision was requested.
    pub(super) fn is_single(
        &mut self,
        section: &SolidSection,
        material: &MaterialDefinition,
        constants: &ElementConstants,
    ) -> bool {
        if self.model.settings.precision == Precision::Double {
            return false;
        }
        let count = section.elements.iter().filter(|e| !self.body_of_element.contains_key(*e)).count();
        let why = if material.eos.is_some() {
            "equation of state: the pressure follows from small volume changes"
        } else if material.hyperelastic.is_some() {
            "rubber: the stress follows from the total deformation"
        } else if material.foam.shape.is_some() {
            "crushable foam"
        } else if constants.hourglass.enhanced > 0.0 {
            "HOURGLASS=ENHANCED"
        } else if section.controls.by_area {
            "WEIGHTING=AREA"
        } else {
            let detail =
                "stresses, strain increments and forces; nodes, plastic strains and sums are in double precision";
            self.ledger_row(section.span, "single precision", count, "elements", detail.into());
            return true;
        };
        self.note_double_precision(section.span, count, why);
        false
    }

    /// Lists elements in the ledger that are in double precision although single precision was requested.
    pub(super) fn note_double_precision(&mut self, span: Span, count: usize, why: &str) {
        if self.model.settings.precision == Precision::Single {
            self.ledger_row(span, "double precision", count, "elements", why.into());
        }
    }

    /// Warns if single precision was requested but no element supports it.
    pub(super) fn warn_without_single_precision(&mut self, state: &State) {
        let none = state.elements.groups.iter().all(|group| !group.properties().single);
        if self.model.settings.precision == Precision::Double || !none || self.diagnostics.has_errors() {
            return;
        }
        let message = "single precision was requested, but no element supports it: the run uses double precision";
        let mut finding = Diagnostic::warning("P120", message);
        if let Some(step) = self.model.steps.first() {
            finding = finding.at(step.span, "this step");
        }
        self.diagnostics.push(finding.help(
            "solid elements with *ELASTIC support it, with *PLASTIC, rates, temperatures and failure; not *EOS, rubber, foam, \
             user subroutines, HOURGLASS=ENHANCED and WEIGHTING=AREA",
        ));
    }
}
