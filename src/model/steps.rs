//! Steps: `*STEP` to `*END STEP`, `*DYNAMIC`, what carries over from step to step, and `*BOUNDARY`.
//! Never here: loads.

use super::builder::Builder;
use super::names::upper;
use super::types::{
    Boundary, Contact, EnergyLimit, IncrementControl, Load, LoadVelocity, MassScaling, Motion, OutputRequest, Restart,
    Step,
};
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
    pub procedure: Option<Procedure>,
    pub boundaries: Vec<Boundary>,
    pub loads: Vec<Load>,
    pub contacts: Vec<Contact>,
    pub mass_scalings: Vec<MassScaling>,
    pub energy_limit: Option<EnergyLimit>,
    pub outputs: Vec<OutputRequest>,
    pub restart: Option<Restart>,
    /// Families of which an OP=NEW card has cleared what came from earlier steps.
    pub cleared: Vec<&'static str>,
}

/// The `*DYNAMIC` card.
#[derive(Clone, Copy, Debug)]
pub(super) struct Procedure {
    span: Span,
    duration: f64,
    increment: IncrementControl,
    scale_factor: f64,
    load_velocity: LoadVelocity,
    bulk_viscosity: [f64; 2],
    adiabatic: bool,
}

impl Builder<'_> {
    pub(super) fn step_card(&mut self, card: &Card) {
        match card.keyword.name {
            "STEP" => self.begin_step(card),
            "END STEP" => {
                self.close("STEP", card);
                self.close_step();
            }
            "DYNAMIC" => self.dynamic(card),
            "BULK VISCOSITY" => self.bulk_viscosity(card),
            "FIXED MASS SCALING" | "VARIABLE MASS SCALING" => self.mass_scaling(card),
            "ENERGY LIMIT" => self.energy_limit(card),
            _ => {}
        }
    }

    fn begin_step(&mut self, card: &Card) {
        self.close_step();
        self.open("STEP", card);
        let number = self.model.steps.len() + 1;
        let name = card.value("NAME").map_or_else(|| format!("Step-{number}"), |w| w.text.clone());
        self.step =
            Some(StepState { name, span: card.span, cleared: Vec::new(), procedure: None, ..self.carried.clone() });
    }

    pub(super) fn close_step(&mut self) {
        let Some(state) = self.step.take() else { return };
        self.carried = state.clone();
        let Some(procedure) = state.procedure else {
            let other = self.diagnostics.iter().any(|d| d.severity == crate::deck::Severity::Error);
            if !other {
                let finding = Diagnostic::error("M101", "the step has no procedure").at(state.span, "this step");
                self.diagnostics.push(finding.help("give *DYNAMIC, EXPLICIT"));
            }
            return;
        };
        self.model.steps.push(Step {
            name: state.name,
            span: procedure.span,
            duration: procedure.duration,
            increment: procedure.increment,
            scale_factor: procedure.scale_factor,
            load_velocity: procedure.load_velocity,
            bulk_viscosity: procedure.bulk_viscosity,
            adiabatic: procedure.adiabatic,
            boundaries: state.boundaries,
            loads: state.loads,
            contacts: state.contacts,
            mass_scalings: state.mass_scalings,
            energy_limit: state.energy_limit,
            outputs: state.outputs,
            restart: state.restart,
        });
    }

    fn dynamic(&mut self, card: &Card) {
        if !card.has("EXPLICIT") {
            self.unsupported(card.span, "implicit dynamics is not supported", "write *DYNAMIC, EXPLICIT");
            return;
        }
        let Some(line) = self.first_line(card) else { return };
        let Some(duration) = self.number(line, 1, "the length of the step") else { return };
        if duration <= 0.0 {
            self.out_of_range(line.span, format!("the length of the step must be above zero, not {duration}"));
            return;
        }
        let Some(increment) = self.increment_control(card, line, duration) else { return };
        let scale_factor =
            card.value("SCALE FACTOR").map_or(Some(1.0), |w| w.number(&mut self.diagnostics)).unwrap_or(1.0);
        if scale_factor <= 0.0 {
            self.out_of_range(card.span, "SCALE FACTOR must be above zero");
            return;
        }
        let Some(load_velocity) = self.load_velocity(card) else { return };
        let (span, adiabatic) = (card.span, card.has("ADIABATIC"));
        let procedure = Procedure {
            span,
            duration,
            increment,
            scale_factor,
            load_velocity,
            bulk_viscosity: [0.06, 1.2],
            adiabatic,
        };
        match &mut self.step {
            Some(step) => step.procedure = Some(procedure),
            None => self.outside_step(card),
        }
    }

    pub(super) fn outside_step(&mut self, card: &Card) {
        let message = format!("*{} belongs into a *STEP", card.keyword.name);
        self.diagnostics.push(Diagnostic::error("M105", message).at(card.span, "no step is open"));
    }

    fn increment_control(&mut self, card: &Card, line: &DataLine, duration: f64) -> Option<IncrementControl> {
        if card.has("DIRECT USER CONTROL") {
            let increment = self.number(line, 0, "the increment (DIRECT USER CONTROL)")?;
            if increment > 0.0 && duration / increment > MOST_INCREMENTS {
                let message =
                    format!("the step would take {:.1e} increments: it would never end", duration / increment);
                self.out_of_range(line.span, message);
                return None;
            }
            if increment > 0.0 && increment <= duration {
                return Some(IncrementControl::Fixed(increment));
            }
            self.out_of_range(
                line.span,
                format!("the increment {increment} must be above zero and not above {duration}"),
            );
            return None;
        }
        let accuracy = card.value("ACCURACY").map_or(Some(DEFAULT_ACCURACY), |w| w.number(&mut self.diagnostics))?;
        if !(1e-14..=0.1).contains(&accuracy) {
            self.out_of_range(card.span, format!("ACCURACY must lie between 1e-14 and 0.1, not {accuracy}"));
            return None;
        }
        let element_by_element = card.has("ELEMENT BY ELEMENT");
        if element_by_element && card.has("GLOBAL") {
            self.out_of_range(card.span, "GLOBAL and ELEMENT BY ELEMENT exclude each other");
            return None;
        }
        let largest = self.number_or(line, 3, f64::INFINITY)?;
        if largest.is_nan() || largest <= 0.0 || duration / largest > MOST_INCREMENTS {
            self.out_of_range(
                line.span,
                format!("the largest increment must be above zero, and end the step, not {largest}"),
            );
            return None;
        }
        Some(IncrementControl::Automatic { accuracy, element_by_element, largest })
    }

    fn load_velocity(&mut self, card: &Card) -> Option<LoadVelocity> {
        match card.value("LOAD VELOCITY") {
            None => Some(LoadVelocity::Predicted),
            Some(word) if word.is("PREDICTED") => Some(LoadVelocity::Predicted),
            Some(word) if word.is("LAGGED") => Some(LoadVelocity::Lagged),
            Some(word) => {
                self.out_of_range(word.span, format!("LOAD VELOCITY is PREDICTED or LAGGED, not {}", word.text));
                None
            }
        }
    }

    fn bulk_viscosity(&mut self, card: &Card) {
        let Some(line) = self.first_line(card) else { return };
        let (Some(linear), Some(quadratic)) = (self.number_or(line, 0, 0.06), self.number_or(line, 1, 1.2)) else {
            return;
        };
        match &mut self.step {
            None => self.outside_step(card),
            Some(step) => {
                // Without a procedure the step has been refused already.
                if let Some(procedure) = &mut step.procedure {
                    procedure.bulk_viscosity = [linear, quadratic];
                }
            }
        }
        let deformable = |kind| matches!(kind, super::ElementKind::Cax3 | super::ElementKind::Cax4r);
        if !self.model.mesh.elements.iter().any(|e| deformable(e.kind)) {
            self.inert(card, "nothing here deforms".into());
        }
    }

    /// The state a card adds to: the open step, or what all steps start from.
    pub(super) fn state(&mut self) -> &mut StepState {
        self.step.as_mut().unwrap_or(&mut self.carried)
    }

    /// With OP=NEW the first card of a family in a step clears what earlier steps left in force.
    pub(super) fn operation(&mut self, card: &Card, family: &'static str) -> bool {
        match card.value("OP").map(|w| upper(&w.text)).as_deref() {
            None | Some("MOD") => false,
            Some("NEW") => {
                let cleared = &mut self.state().cleared;
                let first = !cleared.contains(&family);
                if first {
                    cleared.push(family);
                }
                first
            }
            Some(other) => {
                self.out_of_range(card.span, format!("OP is MOD or NEW, not {other}"));
                false
            }
        }
    }

    pub(super) fn boundary(&mut self, card: &Card) {
        let kind = match card.value("TYPE").map(|w| upper(&w.text)).as_deref() {
            None | Some("DISPLACEMENT") => Motion::Displacement,
            Some("VELOCITY") => Motion::Velocity,
            Some("ACCELERATION") => Motion::Acceleration,
            Some(other) => {
                let help = "DISPLACEMENT, VELOCITY and ACCELERATION are";
                self.unsupported(card.span, format!("TYPE={other} on *BOUNDARY is not supported"), help);
                return;
            }
        };
        let user = card.has("USER");
        let Ok(amplitude) = self.amplitude_of(card) else { return };
        if self.operation(card, "BOUNDARY") {
            self.state().boundaries.clear();
        }
        for line in &card.lines {
            let Some(set) = line.field(0) else { continue };
            let Some(nodes) = self.node_members(set) else { continue };
            let Some(([first, last], value)) = self.boundary_dofs(line) else { continue };
            if kind == Motion::Displacement && value != 0.0 && amplitude.is_none() && !user {
                let message = format!(
                    "the displacement {value} has no AMPLITUDE and would be a jump: it is ignored, the motion is held"
                );
                let finding = Diagnostic::warning("M140", message).at(line.span, "as ABAQUS/Explicit does");
                self.diagnostics.push(finding.help("give AMPLITUDE=, or prescribe a velocity"));
            }
            for dof in first..=last {
                let boundary = Boundary {
                    nodes: nodes.clone(),
                    set: set.text.clone(),
                    dof,
                    kind,
                    user,
                    value,
                    amplitude,
                    span: line.span,
                };
                self.put_boundary(boundary);
            }
        }
    }

    /// A boundary on the same nodes and degree of freedom takes the place of the earlier one.
    fn put_boundary(&mut self, boundary: Boundary) {
        let list = &mut self.state().boundaries;
        list.retain(|b| b.nodes != boundary.nodes || b.dof != boundary.dof);
        list.push(boundary);
    }

    /// First and last degree of freedom, and the value.
    fn boundary_dofs(&mut self, line: &DataLine) -> Option<([u8; 2], f64)> {
        let word: &Word = match line.field(1) {
            Some(word) => word,
            None => {
                let finding = Diagnostic::error("M102", "a degree of freedom is missing").at(line.span, "here");
                self.diagnostics.push(finding);
                return None;
            }
        };
        match upper(&word.text).as_str() {
            "ENCASTRE" => return Some(([1, 6], 0.0)),
            "PINNED" => return Some(([1, 3], 0.0)),
            "XSYMM" | "XASYMM" => return Some(([1, 1], 0.0)),
            "YSYMM" | "YASYMM" => return Some(([2, 2], 0.0)),
            "ZSYMM" | "ZASYMM" => return Some(([3, 3], 0.0)),
            _ => {}
        }
        let first = word.integer(&mut self.diagnostics)?;
        let last = line.field(2).map_or(Some(first), |w| w.integer(&mut self.diagnostics))?;
        let value = self.number_or(line, 3, 0.0)?;
        if !(1..=6).contains(&first) || !(first..=6).contains(&last) {
            self.out_of_range(
                line.span,
                format!("degrees of freedom {first} to {last}: 1 is r, 2 is z, 6 the rotation"),
            );
            return None;
        }
        Some(([first as u8, last as u8], value))
    }
}
