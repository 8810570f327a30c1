//! What is shown when: history rows and frames at the instants that are due. Looking never changes the motion.
//! Never here: files.

use super::{Energy, Run};
use crate::element::body::Solid;
use crate::output::{Field, Frame};
use crate::plan::{COMPONENTS, ElementVariable, FieldVariable, Plan, Quantity, Schedule, StepPlan};
use crate::state::Instant;
use crate::state::archive::{Archive, Persist, persist_fields};
use crate::state::halt::Halt;
use crate::user::Wish;

/// Takes what a run shows.
pub trait Sink {
    /// Whether frames are wanted at all.
    fn wants_frames(&self) -> bool {
        false
    }
    /// The scene at an instant.
    ///
    /// # Errors
    /// In words, if it cannot be kept; the run halts.
    fn frame(&mut self, _frame: &Frame) -> Result<(), String> {
        Ok(())
    }
    /// A history row at a total time, one value a column.
    ///
    /// # Errors
    /// In words, if it cannot be kept; the run halts.
    fn row(&mut self, time: f64, values: &[f64]) -> Result<(), String>;
    /// Fraction of the step done, called now and then.
    fn progress(&mut self, _step: &str, _fraction: f64, _increment: u64) {}
    /// Whether states can be kept.
    fn keeps(&self) -> bool {
        false
    }
    /// Keeps the state of a run, from which another can go on ([`super::Control::state`]).
    ///
    /// # Errors
    /// In words, if it cannot be kept; the run halts.
    fn keep(&mut self, _state: &[u8], _now: &Instant) -> Result<(), String> {
        Ok(())
    }
}

/// The next instants of one kind of output.
#[derive(Debug, Default)]
pub(super) struct Rhythm {
    schedules: Vec<Schedule>,
    pub(super) next_time: f64,
    pub(super) next_increment: u64,
}

impl Rhythm {
    /// Whether nothing is ever due.
    pub(super) fn is_empty(&self) -> bool {
        self.schedules.is_empty()
    }

    pub(super) fn begin(&mut self, schedules: &[Schedule], increment: u64) {
        self.schedules = schedules.to_vec();
        self.advance(0.0, increment);
    }

    pub(super) fn due(&self, time: f64, increment: u64) -> bool {
        time >= self.next_time || increment >= self.next_increment
    }

    /// Sets the next marks after this instant. Marks are multiples of the interval; an instant within rounding counts.
    pub(super) fn advance(&mut self, time: f64, increment: u64) {
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
    /// Increments at which the last row and frame were shown.
    shown: [Option<u64>; 2],
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
            shown: [None; 2],
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
        if run.now.step_time < self.next_time && run.now.increment < self.next_increment && run.wish == Wish::Continue {
            return Ok(());
        }
        self.show_due(run, step, sink)
    }

    fn show_due(&mut self, run: &Run<'_>, step: &StepPlan, sink: &mut dyn Sink) -> Result<(), Halt> {
        let (time, increment) = (run.now.step_time, run.now.increment);
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
            self.show_frame(run, step, sink)?;
        }
        self.next_time = self.field.next_time.min(self.history.next_time).min(step.duration);
        self.next_increment = self.field.next_increment.min(self.history.next_increment).min(self.next_progress);
        Ok(())
    }

    /// The last complete instant before a halt, unless it has been shown. Of what deforms an instant that is not complete
    /// is no good state.
    pub(super) fn last(&mut self, run: &Run<'_>, step: &StepPlan, sink: &mut dyn Sink) -> Result<(), Halt> {
        if run.solid.is_some() && !run.complete {
            return Ok(());
        }
        let now = Some(run.now.increment);
        if self.shown[0] != now {
            self.show_row(run, sink)?;
        }
        if self.shown[1] != now {
            self.show_frame(run, step, sink)?;
        }
        Ok(())
    }

    fn show_frame(&mut self, run: &Run<'_>, step: &StepPlan, sink: &mut dyn Sink) -> Result<(), Halt> {
        if !sink.wants_frames() {
            return Ok(());
        }
        self.shown[1] = Some(run.now.increment);
        sink.frame(&frame(run, step)).map_err(unwritten)
    }

    fn show_row(&mut self, run: &Run<'_>, sink: &mut dyn Sink) -> Result<(), Halt> {
        let energy = run.balance.energy();
        for (value, column) in self.row.iter_mut().zip(&run.plan.columns) {
            *value = run.value(column.quantity, &energy);
        }
        self.shown[0] = Some(run.now.increment);
        sink.row(run.now.total_time, &self.row).map_err(unwritten)
    }
}

pub(super) fn unwritten(reason: String) -> Halt {
    Halt { code: "R205", reason }
}

/// A number of an element; not a number where its group does not have it.
pub fn element_value(solid: &Solid, group: usize, e: usize, variable: ElementVariable) -> f64 {
    let (group, nodes) = (&*solid.groups[group], &solid.nodes);
    if !variable.is_of(group, e) {
        return f64::NAN;
    }
    let followed = || group.followed(e).unwrap_or_default();
    // Strains are told with the engineering shear, as ABAQUS does.
    let strain = |tensor: [f64; 4], i: usize| if i == 3 { 2.0 * tensor[3] } else { tensor[i] };
    let stress = group.stress(e);
    let [rr, zz, hoop, rz] = stress;
    match variable {
        ElementVariable::Stress(i) => stress[i],
        ElementVariable::Pressure => -(rr + zz + hoop) / 3.0,
        ElementVariable::Mises => {
            let [a, b, c] = [rr - zz, zz - hoop, hoop - rr].map(|d| d * d);
            (0.5 * (a + b + c) + 3.0 * rz * rz).sqrt()
        }
        ElementVariable::PlasticStrain => group.plastic_strain(e).unwrap_or(f64::NAN),
        ElementVariable::Temperature => group.temperature(e).unwrap_or(f64::NAN),
        ElementVariable::LogarithmicStrain(i) => strain(followed().strain, i),
        ElementVariable::PlasticComponent(i) => strain(followed().plastic, i),
        ElementVariable::StrainRate(i) => strain(followed().rate, i),
        ElementVariable::StrainEnergy => followed().energy[0] / group.volume(e, nodes),
        ElementVariable::PlasticEnergy => followed().energy[1] / group.volume(e, nodes),
        ElementVariable::Status => group.status(e).unwrap_or(1.0),
        ElementVariable::Volume => group.volume(e, nodes),
        ElementVariable::Density => group.mass(e) / group.volume(e, nodes),
        ElementVariable::State(i) => group.state_variable(e, i).unwrap_or(f64::NAN),
    }
}

impl Run<'_> {
    fn solid(&self) -> Option<&Solid> {
        self.solid.as_ref()
    }

    fn value(&self, quantity: Quantity, energy: &Energy) -> f64 {
        let bodies = &self.bodies;
        match quantity {
            Quantity::Displacement(b) => bodies[b].displacement,
            Quantity::Velocity(b) => bodies[b].velocity,
            Quantity::Acceleration(b) => bodies[b].acceleration,
            Quantity::Reaction(b) => bodies[b].reaction,
            Quantity::Coordinate(node, b) => self.plan.mesh.points[node][1] + bodies[b].displacement,
            Quantity::NodeDisplacement(n, axis) => self.solid().map_or(0.0, |s| s.displacement(n)[axis]),
            Quantity::NodeVelocity(n, axis) => self.solid().map_or(0.0, |s| s.velocity_now(n)[axis]),
            Quantity::NodeAcceleration(n, axis) => self.solid().map_or(0.0, |s| s.acceleration[n][axis]),
            Quantity::NodeReaction(n, axis) => self.solid().map_or(0.0, |s| s.reaction(n, axis)),
            Quantity::NodeCoordinate(n, axis) => self.solid().map_or(0.0, |s| s.place(n)[axis]),
            Quantity::Element(group, e, variable) => self.solid().map_or(0.0, |s| element_value(s, group, e, variable)),
            Quantity::Internal => energy.internal,
            Quantity::Strain => energy.strain,
            Quantity::Plastic => energy.plastic,
            Quantity::Viscous => energy.viscous,
            Quantity::Contact => energy.contact,
            Quantity::Artificial => energy.artificial,
            Quantity::Distortion => energy.distortion,
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

/// The scene now: what deforms, and facets of all rigid bodies at their current place.
fn frame(run: &Run<'_>, step: &StepPlan) -> Frame {
    let mesh = &run.plan.mesh;
    let mut frame = Frame { time: run.now.total_time, increment: run.now.increment, ..Frame::default() };
    let mut point_of_node = vec![usize::MAX; mesh.points.len()];
    let mut of_point = Vec::new();
    if let Some(solid) = &run.solid {
        for (&node, &place) in &run.plan.places.nodes {
            point_of_node[node] = frame.points.len();
            frame.points.push(solid.place(place));
            of_point.push(Owner::Node(place));
        }
    }
    let mut elements: Vec<usize> = run.plan.places.elements.keys().copied().collect();
    for (b, body) in run.plan.bodies.iter().enumerate() {
        for &node in body.nodes.iter().filter(|n| !run.plan.places.tied.contains_key(*n)) {
            let [r, z] = mesh.points[node];
            point_of_node[node] = frame.points.len();
            frame.points.push([r, z + run.bodies[b].displacement]);
            of_point.push(Owner::Body(b, node == body.reference));
        }
        elements.extend(body.elements.iter().filter(|&&e| !mesh.elements[e].kind.is_discrete()));
    }
    let corners = |e: usize| mesh.elements[e].nodes.iter().map(|&n| point_of_node[n]).collect();
    frame.cells = elements.iter().map(|&e| corners(e)).collect();
    let solid: Vec<(usize, usize)> = run.plan.places.elements.values().copied().collect();
    for &variable in &run.plan.fields {
        match point_field(run, variable, &of_point) {
            Some(field) => frame.point_fields.push(field),
            None => frame.cell_fields.push(element_field(run, variable, &solid, elements.len())),
        }
    }
    frame.cell_fields.extend(facet_fields(run, step, &elements));
    frame
}

/// What a point of a frame moves with.
#[derive(Clone, Copy)]
enum Owner {
    /// A rigid body; whether it is its reference node.
    Body(usize, bool),
    /// Itself.
    Node(usize),
}

fn point_field(run: &Run<'_>, variable: FieldVariable, of_point: &[Owner]) -> Option<Field> {
    let name = match variable {
        FieldVariable::Displacement => "U",
        FieldVariable::Velocity => "V",
        FieldVariable::Acceleration => "A",
        FieldVariable::Reaction => "RF",
        _ => return None,
    };
    let value = |owner: &Owner| match (*owner, &run.solid) {
        (Owner::Body(b, reference), _) => {
            let body = &run.bodies[b];
            [
                0.0,
                match variable {
                    FieldVariable::Displacement => body.displacement,
                    FieldVariable::Velocity => body.velocity,
                    FieldVariable::Reaction if reference => body.reaction,
                    FieldVariable::Reaction => 0.0,
                    _ => body.acceleration,
                },
            ]
        }
        (Owner::Node(n), Some(solid)) => match variable {
            FieldVariable::Displacement => solid.displacement(n),
            FieldVariable::Velocity => solid.velocity_now(n),
            FieldVariable::Reaction => [solid.reaction(n, 0), solid.reaction(n, 1)],
            _ => solid.acceleration[n],
        },
        (Owner::Node(_), None) => [0.0; 2],
    };
    Some(Field {
        name: name.into(),
        components: 2,
        component_names: vec![format!("{name}1"), format!("{name}2")],
        values: of_point.iter().flat_map(value).collect(),
    })
}

/// A field over cells: those of deformable elements (group and element) come first. Cells that do not have it, as those of
/// rigid bodies, hold NaN, which ParaView leaves out of ranges and draws in a colour of its own.
fn element_field(run: &Run<'_>, variable: FieldVariable, solid: &[(usize, usize)], cells: usize) -> Field {
    let (name, parts) = (variable.name(), variable.parts());
    let value = |&(group, e): &(usize, usize), part: &ElementVariable| {
        run.solid.as_ref().map_or(f64::NAN, |s| element_value(s, group, e, *part))
    };
    let (value, parts) = (&value, &parts);
    let mut values: Vec<f64> = solid.iter().flat_map(|e| parts.iter().map(move |p| value(e, p))).collect();
    values.resize(cells * parts.len(), f64::NAN);
    let names = COMPONENTS.map(|c| format!("{name}{c}"));
    Field {
        name,
        components: parts.len(),
        component_names: if parts.len() == 4 { names.to_vec() } else { Vec::new() },
        values,
    }
}

/// Pressure, normal velocity and layer of the loaded facets; several loads on one facet add up.
fn facet_fields(run: &Run<'_>, step: &StepPlan, elements: &[usize]) -> Vec<Field> {
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

impl Persist for Rhythm {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Rhythm { schedules: _, next_time, next_increment } = self;
        persist_fields!(archive; next_time, next_increment);
    }
}

impl Persist for Observing {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Observing { field, history, row: _, next_progress, next_time, next_increment, first, shown } = self;
        persist_fields!(archive; field, history, next_progress, next_time, next_increment, first, shown);
    }
}
