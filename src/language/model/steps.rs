//! `*STEP` to `*END STEP`, `*DYNAMIC`, `*BULK VISCOSITY`.

use super::builder::ModelBuilder;
use super::history::{StepHistory, StepTiming};
use super::types::{
    AdaptiveMesh, AdaptiveRegion, BoundaryCondition, EnergyLimit, GeneralContact, IncrementControl, Load, LoadVelocity,
    MassScaling, OutputKind, OutputRequest, PrescribedClearance, PrescribedField, RestartRequest, Step, SurfaceContact,
};
use crate::deck::table::steps as cards;
use crate::deck::{Card, DataLine, Diagnostic, Span, Word};
use crate::kernel::bulk_viscosity::BulkViscosity;

/// Largest number of increments of a fixed size in a step: four months of computing at ten nanoseconds each.
const MOST_INCREMENTS: f64 = 1e15;
/// Default relative error of automatic increments.
pub const DEFAULT_ACCURACY: f64 = 1e-4;

/// Procedure and conditions of a step while its cards are read.
#[derive(Clone, Debug, Default)]
pub(super) struct StepState {
    pub name: String,
    pub span: Span,
    /// Procedure of the step, set by `*DYNAMIC`.
    pub procedure: Option<Step>,
    /// Whether conditions without amplitude increase linearly over the step (`AMPLITUDE=RAMP`).
    pub ramp: bool,
    /// Linear and quadratic bulk viscosity coefficients.
    pub bulk_viscosity: Option<BulkViscosity>,
    /// Conditions of earlier steps.
    pub history: StepHistory,
    /// Boundary conditions defined in this step.
    pub boundaries: Vec<BoundaryCondition>,
    /// Loads defined in this step.
    pub loads: Vec<Load>,
    /// Field variables defined in this step.
    pub fields: Vec<PrescribedField>,
    /// Output requests of earlier steps.
    pub earlier_outputs: Vec<OutputRequest>,
    pub surface_contacts: Vec<SurfaceContact>,
    pub general_contact: Option<GeneralContact>,
    /// Initial clearances, and penalty scale factors, that this step assigns to contact pair sets.
    pub pair_clearances: Vec<(Word, PrescribedClearance)>,
    pub penalty_factors: Vec<(Word, f64)>,
    pub mass_scalings: Vec<MassScaling>,
    /// Adaptive meshes, and nodes that they do not move.
    pub adaptive: Vec<AdaptiveMesh>,
    pub adaptive_fixed: Vec<(Span, Vec<usize>)>,
    pub adaptive_regions: Vec<AdaptiveRegion>,
    /// Motions of adaptive meshes that this step prescribes, and those of earlier steps.
    pub mesh_motions: Vec<BoundaryCondition>,
    pub mesh_history: StepHistory,
    /// Sets of the domains of this step with named controls.
    pub adaptive_controls_used: Vec<(String, Word)>,
    pub energy_limit: Option<EnergyLimit>,
    pub outputs: Vec<OutputRequest>,
    pub restart: Option<RestartRequest>,
    /// Families of cards for which `OP=NEW` has removed the conditions of earlier steps.
    pub cleared: Vec<&'static str>,
    /// Whether the `*BOUNDARY` cards of this step have OP=NEW; `None` before the first one.
    pub new_boundaries: Option<bool>,
}

impl ModelBuilder<'_> {
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
            let mut diagnostics = Vec::new();
            carried.history.model_data(std::mem::take(&mut carried.boundaries), &mut diagnostics);
            diagnostics.into_iter().for_each(|d| self.diagnostics.push(d));
        }
        let fresh = StepState { name, span: card.span, ramp, procedure: None, cleared: Vec::new(), ..carried };
        self.step = Some(StepState { new_boundaries: None, ..fresh });
    }

    /// Warns of general contact that includes nothing; not after an error, which may have removed inclusions.
    fn check_general_contact(&mut self) {
        if self.diagnostics.has_errors() {
            return;
        }
        let Some(state) = &self.step else { return };
        let Some(general) = &state.general_contact else { return };
        if !general.all && general.included.is_empty() && general.span.start > state.span.start {
            let message = "*CONTACT without *CONTACT INCLUSIONS: nothing is in contact";
            let diagnostic = Diagnostic::warning("M154", message).at(general.span, "no contact domain follows");
            self.diagnostics.push(diagnostic.help("add *CONTACT INCLUSIONS, ALL EXTERIOR"));
        }
    }

    pub(super) fn close_step(&mut self) {
        self.check_general_contact();
        self.apply_adaptive_controls();
        if self.step.is_some() {
            self.apply_to_sets();
        }
        let Some(mut state) = self.step.take() else { return };
        let Some(procedure) = state.procedure.take() else {
            let other = self.diagnostics.has_errors() || self.missing.bodies || self.missing.everything;
            if !other {
                let diagnostic = Diagnostic::error("M101", "the step has no procedure").at(state.span, "this step");
                self.diagnostics.push(diagnostic.help("give *DYNAMIC, EXPLICIT"));
            }
            self.carried = state;
            return;
        };
        self.ended_outputs(&state);
        let time = StepTiming { duration: procedure.duration, ramp: state.ramp };
        let mut diagnostics = Vec::new();
        let given = std::mem::take(&mut state.boundaries);
        let boundaries = state.history.boundaries(given, &time, &mut self.model, &mut diagnostics);
        let given = std::mem::take(&mut state.loads);
        let loads = state.history.loads(given, &time, &mut self.model, &mut diagnostics);
        let fields = state.history.fields(std::mem::take(&mut state.fields), &time, &self.model);
        state.history.end(&time);
        let (given, of_mesh) = (std::mem::take(&mut state.mesh_motions), StepTiming { ramp: false, ..time });
        let mesh_motions = state.mesh_history.boundaries(given, &of_mesh, &mut self.model, &mut diagnostics);
        state.mesh_history.end(&of_mesh);
        diagnostics.into_iter().for_each(|d| self.diagnostics.push(d));
        state.outputs.splice(0..0, state.earlier_outputs.drain(..));
        self.carried = state.clone();
        self.model.steps.push(Step {
            name: state.name,
            bulk_viscosity: state.bulk_viscosity.unwrap_or_default(),
            boundaries,
            loads,
            fields,
            surface_contacts: state.surface_contacts,
            general_contact: state.general_contact,
            mass_scalings: state.mass_scalings,
            adaptive: state.adaptive,
            adaptive_fixed: state.adaptive_fixed,
            adaptive_regions: state.adaptive_regions,
            mesh_motions,
            energy_limit: state.energy_limit,
            outputs: state.outputs,
            restart: state.restart,
            ..procedure
        });
    }

    /// Reports output types that end because a request of this step has OP=NEW.
    fn ended_outputs(&mut self, state: &StepState) {
        if !state.cleared.contains(&"OUTPUT") {
            return;
        }
        for (kind, name) in [(OutputKind::Field, "field"), (OutputKind::History, "history")] {
            let is_requested = |list: &[OutputRequest]| list.iter().any(|o| o.kind == kind);
            if is_requested(&self.carried.outputs)
                && !is_requested(&state.outputs)
                && !is_requested(&state.earlier_outputs)
            {
                let message = format!(
                    "no {name} output is written from this step on, because *OUTPUT with OP=NEW, the default, \
                     ends all requests of earlier steps"
                );
                let diagnostic = Diagnostic::warning("M148", message).at(state.span, "this step");
                self.diagnostics.push(diagnostic.help("use OP=ADD, or repeat the requests"));
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
            let message = format!(
                "the step would take {:.1e} increments, more than the allowed {MOST_INCREMENTS:.0e}",
                duration / given
            );
            return self.refuse_value(line.span, message);
        }
        if values.direct {
            if increment <= duration {
                return Some(IncrementControl::Fixed(increment));
            }
            return self.refuse_value(
                line.span,
                format!("the increment must be at most the step duration {duration}, found {increment}"),
            );
        }
        let element_by_element = values.element_by_element;
        if element_by_element && values.global {
            return self.refuse_value(card.span, "GLOBAL and ELEMENT BY ELEMENT cannot be combined");
        }
        // An empty field or zero means no limit (ABAQUS Keywords Reference Guide, *DYNAMIC).
        let largest = if largest == 0.0 { f64::INFINITY } else { largest };
        Some(IncrementControl::Automatic { accuracy: values.accuracy, element_by_element, largest })
    }

    /// Reads bulk viscosity, which remains in force until another step changes it.
    pub(super) fn bulk_viscosity(&mut self, card: &Card) {
        if self.first_line(card).is_none() {
            return;
        }
        let cards::BulkViscosity { whole_rate, factors: [linear, quadratic] } = self.values(card);
        self.state().bulk_viscosity = Some(BulkViscosity { linear, quadratic, filtered: !whole_rate });
        if !self.model.mesh.elements.iter().any(|e| e.kind.is_solid() || e.kind == super::ElementKind::Sax1) {
            self.inert(card, "the model has no deformable elements".into());
        }
    }

    /// Returns the state that a card extends: that of the open step, or that of the model data.
    pub(super) fn state(&mut self) -> &mut StepState {
        self.step.as_mut().unwrap_or(&mut self.carried)
    }

    /// Returns whether a card removes the conditions of its family from earlier steps: the first one of a step with
    /// OP=NEW.
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

    /// Returns whether OP is NEW; the default is MOD.
    pub(super) fn is_new(&self, card: &Card) -> bool {
        card.read("OP")
    }
}
