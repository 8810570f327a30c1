//! Steps: `*STEP` to `*END STEP`, `*DYNAMIC`, `*BULK VISCOSITY`.
//! Never here: conditions, and what becomes of them over the steps.

use super::builder::Builder;
use super::history::{History, StepTime};
use super::types::{
    Boundary, Clearance, EnergyLimit, GeneralContact, IncrementControl, Load, LoadVelocity, MassScaling, OutputKind,
    OutputRequest, PrescribedField, Restart, Step, SurfaceContact,
};
use crate::deck::table::steps as cards;
use crate::deck::{Card, DataLine, Diagnostic, Span, Word};

/// Increments of a given length that a step may take at most: at ten nanoseconds each, four months.
const MOST_INCREMENTS: f64 = 1e15;
/// Relative error aimed at where the deck says nothing.
pub const DEFAULT_ACCURACY: f64 = 1e-4;

/// What is in force in a step, and what its procedure is.
#[derive(Clone, Debug, Default)]
pub(super) struct StepState {
    pub name: String,
    pub span: Span,
    /// The step as its `*DYNAMIC` card begins it.
    pub procedure: Option<Step>,
    /// Whether conditions without amplitude grow over the step (`AMPLITUDE=RAMP`).
    pub ramp: bool,
    /// Linear and quadratic bulk viscosity.
    pub bulk_viscosity: Option<[f64; 2]>,
    /// What earlier steps leave.
    pub history: History,
    /// Boundaries of this step's cards.
    pub boundaries: Vec<Boundary>,
    /// Loads of this step's cards.
    pub loads: Vec<Load>,
    /// Field variables of this step's cards.
    pub fields: Vec<PrescribedField>,
    /// Output requests of earlier steps.
    pub earlier_outputs: Vec<OutputRequest>,
    pub surface_contacts: Vec<SurfaceContact>,
    pub general_contact: Option<GeneralContact>,
    /// Clearances and factors on penalty springs that cards of this step give sets of pairs.
    pub pair_clearances: Vec<(Word, Clearance)>,
    pub penalty_factors: Vec<(Word, f64)>,
    pub mass_scalings: Vec<MassScaling>,
    pub energy_limit: Option<EnergyLimit>,
    pub outputs: Vec<OutputRequest>,
    pub restart: Option<Restart>,
    /// Families of which a card has cleared what came from earlier steps.
    pub cleared: Vec<&'static str>,
    /// Whether the `*BOUNDARY` cards of this step say OP=NEW; none yet if `None`.
    pub new_boundaries: Option<bool>,
}

/// Bulk viscosity where no step gives another (ABAQUS Analysis User's Guide 6.3.3, "Bulk viscosity").
pub const BULK_VISCOSITY: [f64; 2] = [0.06, 1.2];

impl Builder<'_> {
    pub(super) fn end_step(&mut self, card: &Card) {
        self.close("STEP", card);
        self.close_step();
    }

    pub(super) fn begin_step(&mut self, card: &Card) {
        self.close_step();
        self.open("STEP", card);
        let number = self.model.steps.len() + 1;
        let name = card.value("NAME").map_or_else(|| format!("Step-{number}"), |w| w.text.clone());
        let ramp = card.read("AMPLITUDE");
        let mut carried = self.carried.clone();
        carried.earlier_outputs = std::mem::take(&mut carried.outputs);
        if !carried.boundaries.is_empty() {
            let mut words = Vec::new();
            carried.history.model_data(std::mem::take(&mut carried.boundaries), &mut words);
            words.into_iter().for_each(|word| self.diagnostics.push(word));
        }
        let fresh = StepState { name, span: card.span, ramp, procedure: None, cleared: Vec::new(), ..carried };
        self.step = Some(StepState { new_boundaries: None, ..fresh });
    }

    pub(super) fn close_step(&mut self) {
        if self.step.is_some() {
            self.apply_to_sets();
        }
        let Some(mut state) = self.step.take() else { return };
        let Some(procedure) = state.procedure.take() else {
            let other = self.diagnostics.has_errors() || self.lost.bodies || self.lost.everything;
            if !other {
                let finding = Diagnostic::error("M101", "the step has no procedure").at(state.span, "this step");
                self.diagnostics.push(finding.help("give *DYNAMIC, EXPLICIT"));
            }
            self.carried = state;
            return;
        };
        self.ended_outputs(&state);
        let time = StepTime { duration: procedure.duration, ramp: state.ramp };
        let mut words = Vec::new();
        let given = std::mem::take(&mut state.boundaries);
        let boundaries = state.history.boundaries(given, &time, &mut self.model, &mut words);
        let given = std::mem::take(&mut state.loads);
        let loads = state.history.loads(given, &time, &mut self.model, &mut words);
        let fields = state.history.fields(std::mem::take(&mut state.fields), &time, &self.model);
        state.history.end(&time);
        words.into_iter().for_each(|word| self.diagnostics.push(word));
        state.outputs.splice(0..0, state.earlier_outputs.drain(..));
        self.carried = state.clone();
        self.model.steps.push(Step {
            name: state.name,
            bulk_viscosity: state.bulk_viscosity.unwrap_or(BULK_VISCOSITY),
            boundaries,
            loads,
            fields,
            surface_contacts: state.surface_contacts,
            general_contact: state.general_contact,
            mass_scalings: state.mass_scalings,
            energy_limit: state.energy_limit,
            outputs: state.outputs,
            restart: state.restart,
            ..procedure
        });
    }

    /// Says which output of earlier steps ends because this step asks for other output alone.
    fn ended_outputs(&mut self, state: &StepState) {
        if !state.cleared.contains(&"OUTPUT") {
            return;
        }
        for (kind, name) in [(OutputKind::Field, "field"), (OutputKind::History, "history")] {
            let asked = |list: &[OutputRequest]| list.iter().any(|o| o.kind == kind);
            if asked(&self.carried.outputs) && !asked(&state.outputs) && !asked(&state.earlier_outputs) {
                let message = format!(
                    "from this step on no {name} output is written: an *OUTPUT with OP=NEW, the default, ends every request of \
                     earlier steps"
                );
                let finding = Diagnostic::warning("M148", message).at(state.span, "this step");
                self.diagnostics.push(finding.help("give OP=ADD, or ask again for what is wanted"));
            }
        }
    }

    pub(super) fn dynamic(&mut self, card: &Card) {
        if !card.has("EXPLICIT") {
            let help = format!("write *{}, EXPLICIT", card.keyword.name);
            return self.unsupported(card.span, "implicit dynamics is not supported", &help);
        }
        let Some(line) = self.first_line(card) else { return };
        let coupled = card.keyword.name != "DYNAMIC";
        let mut values: cards::Dynamic = self.values(card);
        if coupled {
            values = cards::Dynamic { accuracy: DEFAULT_ACCURACY, global: false, ..values };
        }
        let Some(increment) = self.increment_control(card, line, &values) else { return };
        let load_velocity = if values.lagged { LoadVelocity::Lagged } else { LoadVelocity::Predicted };
        let (scale_factor, adiabatic) = (values.scale_factor, values.adiabatic);
        let begun = Step::new("", values.times[1]);
        let procedure = Step { span: card.span, increment, scale_factor, load_velocity, adiabatic, coupled, ..begun };
        self.state().procedure = Some(procedure);
    }

    fn increment_control(&mut self, card: &Card, line: &DataLine, values: &cards::Dynamic) -> Option<IncrementControl> {
        let [increment, duration, _, largest] = values.times;
        let given = if values.direct { increment } else { largest };
        if given > 0.0 && duration / given > MOST_INCREMENTS {
            let message = format!("the step would take {:.1e} increments: it would never end", duration / given);
            return self.refuse_value(line.span, message);
        }
        if values.direct {
            if increment <= duration {
                return Some(IncrementControl::Fixed(increment));
            }
            return self.refuse_value(line.span, format!("the increment {increment} must not be above {duration}"));
        }
        let element_by_element = values.element_by_element;
        if element_by_element && values.global {
            return self.refuse_value(card.span, "GLOBAL and ELEMENT BY ELEMENT exclude each other");
        }
        // An empty field or zero is no limit (ABAQUS Keywords Reference Guide, *DYNAMIC).
        let largest = if largest == 0.0 { f64::INFINITY } else { largest };
        Some(IncrementControl::Automatic { accuracy: values.accuracy, element_by_element, largest })
    }

    /// In force from this step on, until another step gives others.
    pub(super) fn bulk_viscosity(&mut self, card: &Card) {
        if self.first_line(card).is_none() {
            return;
        }
        let cards::BulkViscosity { factors } = self.values(card);
        self.state().bulk_viscosity = Some(factors);
        if !self.model.mesh.elements.iter().any(|e| e.kind.is_solid() || e.kind == super::ElementKind::Sax1) {
            self.inert(card, "nothing here deforms".into());
        }
    }

    /// The state a card adds to: the open step, or what all steps start from.
    pub(super) fn state(&mut self) -> &mut StepState {
        self.step.as_mut().unwrap_or(&mut self.carried)
    }

    /// Whether a card clears what earlier steps left in force of its family: the first of a step that says OP=NEW.
    pub(super) fn operation(&mut self, card: &Card, family: &'static str) -> bool {
        if !self.is_new(card) {
            return false;
        }
        let cleared = &mut self.state().cleared;
        let first = !cleared.contains(&family);
        if first {
            cleared.push(family);
        }
        first
    }

    /// Whether OP is NEW; MOD is the default.
    pub(super) fn is_new(&self, card: &Card) -> bool {
        card.read("OP")
    }
}
