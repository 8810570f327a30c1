//! What is shown when: history rows and frames at the instants that are due. Looking never changes the motion.
//! Never here: files.

use super::{Energy, Run};
use crate::effect::Halt;
use crate::model::ElementKind;
use crate::output::{Field, Frame};
use crate::plan::{FieldVariable, Plan, Quantity, Schedule, StepPlan};
use crate::state::BodyState;
use crate::user::Wish;

/// Takes what a run shows.
pub trait Sink {
    /// Whether frames are wanted at all.
    fn wants_frames(&self) -> bool;
    /// The scene at an instant.
    ///
    /// # Errors
    /// In words, if it cannot be kept; the run halts.
    fn frame(&mut self, frame: &Frame) -> Result<(), String>;
    /// A history row at a total time, one value a column.
    ///
    /// # Errors
    /// In words, if it cannot be kept; the run halts.
    fn row(&mut self, time: f64, values: &[f64]) -> Result<(), String>;
    /// Fraction of the step done, called now and then.
    fn progress(&mut self, _step: &str, _fraction: f64, _increment: u64) {}
}

/// The next instants of one kind of output.
#[derive(Debug, Default)]
struct Rhythm {
    schedules: Vec<Schedule>,
    next_time: f64,
    next_increment: u64,
}

impl Rhythm {
    fn begin(&mut self, schedules: &[Schedule], increment: u64) {
        self.schedules = schedules.to_vec();
        self.advance(0.0, increment);
    }

    fn due(&self, time: f64, increment: u64) -> bool {
        time >= self.next_time || increment >= self.next_increment
    }

    /// Sets the next marks after this instant. Marks are multiples of the interval; an instant within rounding counts.
    fn advance(&mut self, time: f64, increment: u64) {
        self.next_time = f64::INFINITY;
        self.next_increment = u64::MAX;
        for schedule in &self.schedules {
            match *schedule {
                Schedule::Time(interval) => {
                    let mark = ((time / interval) * (1.0 + 1e-12)).floor() + 1.0;
                    self.next_time = self.next_time.min(mark * interval * (1.0 - 1e-12));
                }
                Schedule::Increments(interval) => {
                    self.next_increment = self.next_increment.min((increment / interval + 1) * interval);
                }
            }
        }
    }
}

/// Output over a run.
pub(super) struct Observing {
    field: Rhythm,
    history: Rhythm,
    row: Vec<f64>,
    next_progress: u64,
    /// Nothing is due before these.
    next_time: f64,
    next_increment: u64,
    first: bool,
}

impl Observing {
    pub(super) fn new(plan: &Plan) -> Self {
        Observing {
            field: Rhythm::default(),
            history: Rhythm::default(),
            row: vec![0.0; plan.columns.len()],
            next_progress: 0,
            next_time: 0.0,
            next_increment: 0,
            first: true,
        }
    }

    pub(super) fn begin(&mut self, step: &StepPlan, first: bool, increment: u64) {
        self.field.begin(&step.outputs.field, increment);
        self.history.begin(&step.outputs.history, increment);
        self.first = first;
        self.next_time = 0.0;
    }

    /// Shows what is due: rows and frames at their marks, at the very start, and at the end of each step.
    #[inline]
    pub(super) fn show(&mut self, run: &Run<'_>, step: &StepPlan, sink: &mut dyn Sink) -> Result<(), Halt> {
        if run.now.step_time < self.next_time && run.increment < self.next_increment && run.wish == Wish::Continue {
            return Ok(());
        }
        self.show_due(run, step, sink)
    }

    fn show_due(&mut self, run: &Run<'_>, step: &StepPlan, sink: &mut dyn Sink) -> Result<(), Halt> {
        let (time, increment) = (run.now.step_time, run.increment);
        let edge = std::mem::take(&mut self.first) || run.is_over(step);
        if increment >= self.next_progress {
            self.next_progress = increment + 4096;
            sink.progress(&step.name, time / step.duration, increment);
        }
        if self.history.due(time, increment) || edge && !step.outputs.history.is_empty() {
            self.history.advance(time, increment);
            self.show_row(run, sink)?;
        }
        if self.field.due(time, increment) || edge && !step.outputs.field.is_empty() {
            self.field.advance(time, increment);
            show_frame(run, step, sink)?;
        }
        self.next_time = self.field.next_time.min(self.history.next_time).min(step.duration);
        self.next_increment = self.field.next_increment.min(self.history.next_increment).min(self.next_progress);
        Ok(())
    }

    /// The last complete instant before a failure.
    pub(super) fn last(&mut self, run: &Run<'_>, step: &StepPlan, sink: &mut dyn Sink) -> Result<(), Halt> {
        self.show_row(run, sink)?;
        show_frame(run, step, sink)
    }

    fn show_row(&mut self, run: &Run<'_>, sink: &mut dyn Sink) -> Result<(), Halt> {
        let energy = run.balance.energy();
        for (value, column) in self.row.iter_mut().zip(&run.plan.columns) {
            *value = run.value(column.quantity, &energy);
        }
        sink.row(run.now.total_time, &self.row).map_err(unwritten)
    }
}

fn unwritten(reason: String) -> Halt {
    Halt { code: "R205", reason }
}

fn show_frame(run: &Run<'_>, step: &StepPlan, sink: &mut dyn Sink) -> Result<(), Halt> {
    if !sink.wants_frames() {
        return Ok(());
    }
    sink.frame(&frame(run, step)).map_err(unwritten)
}

impl Run<'_> {
    fn value(&self, quantity: Quantity, energy: &Energy) -> f64 {
        let bodies = &self.bodies;
        match quantity {
            Quantity::Displacement(b) => bodies[b].displacement,
            Quantity::Velocity(b) => bodies[b].velocity,
            Quantity::Acceleration(b) => bodies[b].acceleration,
            Quantity::Reaction(b) => bodies[b].reaction,
            Quantity::Coordinate(node, b) => self.plan.mesh.points[node][1] + bodies[b].displacement,
            Quantity::Zero => 0.0,
            Quantity::Kinetic => energy.kinetic,
            Quantity::Work => energy.work,
            Quantity::Friction => energy.friction,
            Quantity::Cavity => energy.cavity,
            Quantity::Total => energy.total,
            Quantity::Increment => self.last_increment,
        }
    }
}

/// The scene now: facets of all bodies at their current place.
fn frame(run: &Run<'_>, step: &StepPlan) -> Frame {
    let mesh = &run.plan.mesh;
    let mut frame = Frame { time: run.now.total_time, increment: run.increment, ..Frame::default() };
    let mut point_of_node = vec![usize::MAX; mesh.points.len()];
    let mut body_of_point = Vec::new();
    let mut elements = Vec::new();
    for (b, body) in run.plan.bodies.iter().enumerate() {
        for &node in &body.nodes {
            let [r, z] = mesh.points[node];
            point_of_node[node] = frame.points.len();
            frame.points.push([r, z + run.bodies[b].displacement]);
            body_of_point.push(b);
        }
        elements.extend(body.elements.iter().filter(|&&e| mesh.elements[e].kind != ElementKind::Mass));
    }
    let corners = |e: usize| mesh.elements[e].nodes.iter().map(|&n| point_of_node[n]).collect();
    frame.cells = elements.iter().map(|&e| corners(e)).collect();
    frame.point_fields = run.plan.fields.iter().map(|&v| point_field(run, v, &body_of_point)).collect();
    frame.cell_fields = cell_fields(run, step, &elements);
    frame
}

fn point_field(run: &Run<'_>, variable: FieldVariable, body_of_point: &[usize]) -> Field {
    let (name, value): (_, fn(&BodyState) -> f64) = match variable {
        FieldVariable::Displacement => ("U", |b| b.displacement),
        FieldVariable::Velocity => ("V", |b| b.velocity),
        FieldVariable::Acceleration => ("A", |b| b.acceleration),
    };
    Field {
        name: name.into(),
        components: 2,
        component_names: vec![format!("{name}1"), format!("{name}2")],
        values: body_of_point.iter().flat_map(|&b| [0.0, value(&run.bodies[b])]).collect(),
    }
}

/// Pressure, normal velocity and layer of the loaded facets; several loads on one facet add up.
fn cell_fields(run: &Run<'_>, step: &StepPlan, elements: &[usize]) -> Vec<Field> {
    let shown: Vec<_> = step.forces.iter().filter_map(|f| f.facet_fields(&run.bodies)).collect();
    if shown.is_empty() {
        return Vec::new();
    }
    let mut cell_of_element = vec![usize::MAX; run.plan.mesh.elements.len()];
    for (cell, &element) in elements.iter().enumerate() {
        cell_of_element[element] = cell;
    }
    let zeros = || vec![0.0; elements.len()];
    let (mut pressure, mut velocity, mut layer) = (zeros(), zeros(), zeros());
    for fields in &shown {
        for (i, &element) in fields.elements.iter().enumerate() {
            let cell = cell_of_element[element];
            pressure[cell] += fields.pressure[i];
            velocity[cell] = fields.normal_velocity[i];
            layer[cell] = f64::max(layer[cell], fields.layer[i]);
        }
    }
    let scalar = |name: &str, values| Field { name: name.into(), components: 1, component_names: Vec::new(), values };
    vec![scalar("PRESSURE", pressure), scalar("NORMAL_VELOCITY", velocity), scalar("LAYER", layer)]
}
