//! Single precision: which elements are in it, which stay in double and why.
//! Never here: arithmetic.

use super::{Compiler, State};
use crate::deck::{Diagnostic, Span};
use crate::element::constants::ElementConstants;
use crate::model::{MaterialDefinition, Precision, SolidSection};

impl Compiler<'_> {
    /// Whether elements of a section are in single precision, which only those of a job can be that asks for it.
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
            "an equation of state tells the pressure by small changes of the volume"
        } else if material.hyperelastic.is_some() {
            "rubber answers to the whole deformation"
        } else if material.foam.shape.is_some() {
            "crushable foam"
        } else if constants.hourglass.enhanced > 0.0 {
            "HOURGLASS=ENHANCED"
        } else if section.controls.by_area {
            "WEIGHTING=AREA"
        } else {
            let detail = "stresses, strain increments and forces; nodes, plastic strains and sums are in double";
            self.ledger_row(section.span, "single precision", count, "elements", detail.into());
            return true;
        };
        self.note_double_precision(section.span, count, why);
        false
    }

    /// Books elements that are in double precision although the job asks for single.
    pub(super) fn note_double_precision(&mut self, span: Span, count: usize, why: &str) {
        if self.model.settings.precision == Precision::Single {
            self.ledger_row(span, "double precision", count, "elements", why.into());
        }
    }

    /// Warns where single precision was asked for and nothing is in it.
    pub(super) fn warn_without_single_precision(&mut self, state: &State) {
        let none = state.elements.groups.iter().all(|group| !group.properties().single);
        if self.model.settings.precision == Precision::Double || !none || self.diagnostics.has_errors() {
            return;
        }
        let message = "single precision was asked for, and nothing here has it: the run is one in double precision";
        let mut finding = Diagnostic::warning("P120", message);
        if let Some(step) = self.model.steps.first() {
            finding = finding.at(step.span, "this step");
        }
        self.diagnostics.push(finding.help(
            "solid elements with *ELASTIC have it, with *PLASTIC, rates, temperatures and failure; without *EOS, rubber, foam, \
             routines of the user, HOURGLASS=ENHANCED and WEIGHTING=AREA",
        ));
    }
}
