//! `*STEP` to `*END STEP`, `*DYNAMIC`, `*BULK VISCOSITY`, `*ENERGY LIMIT`.

use std::collections::HashMap;

use super::context::Context;
use super::families::{PartReader, StepReader, StepState};
use super::faults::{ValueCheck, require_line};
use super::history::StepTiming;
use super::refinement::listed;
use super::types::{EnergyLimit, IncrementControl, LoadVelocity, OutputKind, OutputRequest, Step};
use super::{adaptive, clearance};
use crate::deck::table::steps as cards;
use crate::deck::{Card, Diagnostic};
use crate::kernel::bulk_viscosity::BulkViscosity;

/// Largest number of increments of a fixed size in a step: four months of computing at ten nanoseconds each.
const MOST_INCREMENTS: f64 = 1e15;
/// Default relative error of automatic increments.
pub const DEFAULT_ACCURACY: f64 = 1e-4;

pub fn read_end_step(context: &mut Context<'_>, parts: &mut PartReader<'_>, steps: &mut StepReader, card: &Card) {
    parts.close(context, "STEP", card);
    close_step(context, steps);
}

pub fn read_step(context: &mut Context<'_>, parts: &mut PartReader<'_>, steps: &mut StepReader, card: &Card) {
    close_step(context, steps);
    parts.open("STEP", card);
    let number = context.model.steps.len() + 1;
    let name = card.value("NAME").map_or_else(|| format!("Step-{number}"), |w| w.text.clone());
    let ramp = card.read("AMPLITUDE");
    let mut carried = steps.carried.clone();
    carried.earlier_outputs = std::mem::take(&mut carried.outputs);
    if !carried.boundaries.is_empty() {
        carried.history.model_data(std::mem::take(&mut carried.boundaries), &mut context.diagnostics);
    }
    let fresh = StepState {
        name,
        span: card.span,
        ramp,
        procedure: None,
        cleared: Vec::new(),
        given: HashMap::new(),
        ..carried
    };
    steps.current = Some(StepState { new_boundaries: None, ..fresh });
}

/// Warns of general contact that includes nothing; not after an error, which may have removed inclusions.
fn check_general_contact(context: &mut Context<'_>, steps: &mut StepReader) {
    if context.diagnostics.has_errors() {
        return;
    }
    let Some(state) = &steps.current else { return };
    let Some(general) = &state.general_contact else { return };
    let is_new = general.span.start > state.span.start || context.model.steps.is_empty();
    if !general.all && general.included.is_empty() && is_new {
        let message = "*CONTACT without *CONTACT INCLUSIONS: nothing is in contact";
        let diagnostic = Diagnostic::warning("M154", message).at(general.span, "no contact domain follows");
        context.diagnostics.push(diagnostic.help("add *CONTACT INCLUSIONS, ALL EXTERIOR"));
    }
}

pub fn close_step(context: &mut Context<'_>, steps: &mut StepReader) {
    check_general_contact(context, steps);
    adaptive::apply_adaptive_controls(context, steps);
    if steps.current.is_some() {
        clearance::apply_to_sets(context, steps);
    }
    let Some(mut state) = steps.current.take() else { return };
    let Some(procedure) = state.procedure.take() else {
        let other = context.diagnostics.has_errors() || context.missing.bodies || context.missing.everything;
        if !other {
            let diagnostic = Diagnostic::error("M101", "the step has no procedure").at(state.span, "this step");
            context.diagnostics.push(diagnostic.help("give *DYNAMIC, EXPLICIT"));
        }
        steps.carried = state;
        return;
    };
    ended_outputs(context, steps, &state);
    listed::complete_fields(context, &mut state.fields);
    let time = StepTiming { duration: procedure.duration, ramp: state.ramp };
    let Context { model, diagnostics, .. } = context;
    let added = std::mem::take(&mut state.boundaries);
    let boundaries = state.history.boundaries(added, &time, model, diagnostics);
    let added = std::mem::take(&mut state.loads);
    let loads = state.history.loads(added, &time, model, diagnostics);
    let fields = state.history.fields(std::mem::take(&mut state.fields), &time, model);
    state.history.end(&time);
    let (added, of_mesh) = (std::mem::take(&mut state.mesh_motions), StepTiming { ramp: false, ..time });
    let mesh_motions = state.mesh_history.boundaries(added, &of_mesh, model, diagnostics);
    state.mesh_history.end(&of_mesh);
    state.outputs.splice(0..0, state.earlier_outputs.drain(..));
    steps.carried = state.clone();
    context.model.steps.push(Step {
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
fn ended_outputs(context: &mut Context<'_>, steps: &mut StepReader, state: &StepState) {
    if !state.cleared.contains(&"OUTPUT") {
        return;
    }
    for (kind, name) in [(OutputKind::Field, "field"), (OutputKind::History, "history")] {
        let is_requested = |list: &[OutputRequest]| list.iter().any(|o| o.kind == kind);
        if is_requested(&steps.carried.outputs)
            && !is_requested(&state.outputs)
            && !is_requested(&state.earlier_outputs)
        {
            let message = format!(
                "no {name} output is written from this step on, because *OUTPUT with OP=NEW, the default, \
                 ends all requests of earlier steps"
            );
            context.warning("M148", message, state.span, "this step", "use OP=ADD, or repeat the requests");
        }
    }
}

pub fn read_dynamic(context: &mut Context<'_>, steps: &mut StepReader, card: &Card) {
    if !card.has("EXPLICIT") {
        let help = format!("write *{}, EXPLICIT", card.keyword.name);
        return context.unsupported(card.span, "implicit dynamics is not supported", &help);
    }
    if context.first_line(card).is_none() {
        return;
    }
    let coupled = card.keyword.name != "DYNAMIC";
    let mut values: cards::Dynamic = card.values();
    if coupled {
        values.accuracy = DEFAULT_ACCURACY;
    }
    let Some(increment) = increment_control(context, card, &values) else { return };
    let load_velocity = if values.lagged { LoadVelocity::Lagged } else { LoadVelocity::Predicted };
    let (scale_factor, adiabatic) = (values.scale_factor, values.adiabatic);
    let begun = Step::new("", values.times[1]);
    let current_conduction = card.read("CONDUCTION");
    let procedure = Step {
        span: card.span,
        increment,
        scale_factor,
        load_velocity,
        adiabatic,
        coupled,
        current_conduction,
        ..begun
    };
    steps.state().procedure = Some(procedure);
}

fn increment_control(context: &mut Context<'_>, card: &Card, values: &cards::Dynamic) -> Option<IncrementControl> {
    let [increment, duration, _, largest] = values.times;
    let (accuracy, element_by_element) = (values.accuracy, values.element_by_element);
    // An empty field or zero means no limit (ABAQUS Keywords Reference Guide, *DYNAMIC).
    let largest = if largest == 0.0 { f64::INFINITY } else { largest };
    let control = match values.direct {
        true => IncrementControl::Fixed(increment),
        false => IncrementControl::Automatic { accuracy, element_by_element, largest },
    };
    context.accepts(card, control.check(duration)).then_some(control)
}

impl IncrementControl {
    /// Checks given and largest increments in a step of this duration.
    pub fn check(&self, duration: f64) -> ValueCheck {
        let (IncrementControl::Fixed(increment) | IncrementControl::Automatic { largest: increment, .. }) = *self;
        let count = duration / increment;
        let message =
            format_args!("the step would take {count:.1e} increments, more than the allowed {MOST_INCREMENTS:.0e}");
        require_line(0, increment <= 0.0 || count <= MOST_INCREMENTS, message)?;
        let is_short = increment <= duration || !matches!(self, IncrementControl::Fixed(_));
        let message = format_args!("the increment must be at most the step duration {duration}, found {increment}");
        require_line(0, is_short, message)?;
        require_line(0, increment > 0.0, format_args!("the increment must be positive, found {increment}"))
    }
}

/// Reads bulk viscosity, which remains in force until another step changes it.
pub fn read_bulk_viscosity(context: &mut Context<'_>, steps: &mut StepReader, card: &Card) {
    if context.first_line(card).is_none() {
        return;
    }
    let cards::BulkViscosity { whole_rate, factors: [linear, quadratic] } = card.values();
    steps.state().bulk_viscosity = Some(BulkViscosity { linear, quadratic, filtered: !whole_rate });
    if !context.model.mesh.elements.iter().any(|e| e.kind.is_solid() || e.kind.is_shell()) {
        context.inert(card, "the model has no deformable elements");
    }
}

/// Sets the energy limits, which remain in force until a later step sets others.
pub fn read_energy_limit(context: &mut Context<'_>, steps: &mut StepReader, card: &Card) {
    let cards::EnergyLimit { error, artificial, halts } = card.values();
    if error.is_none() && artificial.is_none() {
        return context.out_of_range(card.span, "*ENERGY LIMIT requires ERROR or ARTIFICIAL");
    }
    steps.state().energy_limit = Some(EnergyLimit { span: card.span, error, artificial, halts });
}
