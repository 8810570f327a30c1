//! What is shown when: history rows and frames at the instants that are due. Looking never changes the motion.
//! Never here: files.

use super::{Energy, Run};
use crate::element::body::Solid;
use crate::element::values;
use crate::model::Position;
use crate::output::variables::{Part, Place, Variable};
use crate::output::{Field, Frame};
use crate::plan::{Column, FrameField, Plan, Schedule, Source, StepPlan};
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
            *value = run.value(column, &energy);
        }
        self.shown[0] = Some(run.now.increment);
        sink.row(run.now.total_time, &self.row).map_err(unwritten)
    }
}

pub(super) fn unwritten(reason: String) -> Halt {
    Halt { code: "R205", reason }
}

/// A number of a node of what deforms; not a number where nodes do not have it.
pub fn node_value(solid: &Solid, node: usize, part: Part) -> f64 {
    let axis = part.component;
    match part.variable {
        Variable::Displacement => solid.displacement(node)[axis],
        Variable::Velocity => solid.velocity_now(node)[axis],
        Variable::Acceleration => solid.acceleration[node][axis],
        Variable::Reaction => solid.reaction(node, axis),
        Variable::Coordinate => solid.place(node)[axis],
        _ => f64::NAN,
    }
}

/// A number of the whole model; not a number where it does not have it.
fn model_value(energy: &Energy, increment: f64, variable: Variable) -> f64 {
    match variable {
        Variable::KineticEnergy => energy.kinetic,
        Variable::Work => energy.work,
        Variable::FrictionEnergy => energy.friction,
        Variable::CavityEnergy => energy.cavity,
        Variable::InternalEnergy => energy.internal,
        Variable::AllStrainEnergy => energy.strain,
        Variable::AllPlasticEnergy => energy.plastic,
        Variable::ViscousEnergy => energy.viscous,
        Variable::ArtificialEnergy => energy.artificial,
        Variable::ConstraintWork => energy.contact,
        Variable::DistortionEnergy => energy.distortion,
        Variable::TotalEnergy => energy.total,
        Variable::TimeIncrement => increment,
        _ => f64::NAN,
    }
}

impl Run<'_> {
    fn value(&self, column: &Column, energy: &Energy) -> f64 {
        let part = column.part;
        match (column.source, &self.solid) {
            (Source::Model, _) => model_value(energy, self.last_increment, part.variable),
            (Source::Body { body, node }, _) => self.body_value(body, node, part),
            (Source::Node(node), Some(solid)) => node_value(solid, node, part),
            (Source::Element(group, e), Some(solid)) => element_value(solid, (group, e), part),
            (_, None) => f64::NAN,
        }
    }

    /// A number of a node (of the mesh) of a rigid body. Axial symmetry keeps it at its radius.
    fn body_value(&self, body: usize, node: usize, part: Part) -> f64 {
        let state = &self.bodies[body];
        match (part.variable, part.component) {
            (Variable::Coordinate, 0) => self.plan.mesh.points[node][0],
            (Variable::Coordinate, _) => self.plan.mesh.points[node][1] + state.displacement,
            (_, 0) => 0.0,
            (Variable::Displacement, _) => state.displacement,
            (Variable::Velocity, _) => state.velocity,
            (Variable::Acceleration, _) => state.acceleration,
            (Variable::Reaction, _) => state.reaction,
            _ => f64::NAN,
        }
    }
}

/// A number of an element; not a number where its group does not have it.
fn element_value(solid: &Solid, (group, e): (usize, usize), part: Part) -> f64 {
    values::value(&*solid.groups[group], &solid.nodes, e, part).unwrap_or(f64::NAN)
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
            of_point.push(Owner::Body(b, node));
        }
        elements.extend(body.elements.iter().filter(|&&e| !mesh.elements[e].kind.is_discrete()));
    }
    let corners = |e: usize| mesh.elements[e].nodes.iter().map(|&n| point_of_node[n]).collect();
    frame.cells = elements.iter().map(|&e| corners(e)).collect();
    let solid: Vec<(usize, usize)> = run.plan.places.elements.values().copied().collect();
    for field in &run.plan.fields {
        let values = match (field.variable().place(), field.position) {
            (Place::Node, _) => of_nodes(run, field, &of_point),
            (_, Position::Element) => of_elements(run, field, &solid, elements.len()),
            (_, Position::Nodes) => averaged_at_nodes(run, field, &solid, &frame),
        };
        let list = if field.is_on_points() { &mut frame.point_fields } else { &mut frame.cell_fields };
        list.push(array(field, values));
    }
    frame.cell_fields.extend(facet_fields(run, step, &elements));
    frame
}

/// What a point of a frame moves with.
#[derive(Clone, Copy)]
enum Owner {
    /// A rigid body, with the node of the mesh.
    Body(usize, usize),
    /// Itself.
    Node(usize),
}

fn array(field: &FrameField, values: Vec<f64>) -> Field {
    let components = field.parts.len();
    let labels = if components > 1 { field.parts.iter().map(|p| p.label()).collect() } else { Vec::new() };
    Field { name: field.name.clone(), components, component_names: labels, values }
}

/// A variable of nodes over points. A rigid body's reaction is that of its reference node.
fn of_nodes(run: &Run<'_>, field: &FrameField, of_point: &[Owner]) -> Vec<f64> {
    let value = |owner: &Owner, part: Part| match (*owner, &run.solid) {
        (Owner::Body(b, node), _) if part.variable == Variable::Reaction && node != run.plan.bodies[b].reference => 0.0,
        (Owner::Body(b, node), _) => run.body_value(b, node, part),
        (Owner::Node(n), Some(solid)) => node_value(solid, n, part),
        (Owner::Node(_), None) => f64::NAN,
    };
    let value = &value;
    of_point.iter().flat_map(|owner| field.parts.iter().map(move |part| value(owner, *part))).collect()
}

/// A variable of elements over cells: those of deformable elements (group and element) come first. Cells that do not have
/// it, as those of rigid bodies, hold NaN, which ParaView leaves out of ranges and draws in a colour of its own.
fn of_elements(run: &Run<'_>, field: &FrameField, solid: &[(usize, usize)], cells: usize) -> Vec<f64> {
    let value = |place, part: &Part| run.solid.as_ref().map_or(f64::NAN, |s| element_value(s, place, *part));
    let value = &value;
    let mut values: Vec<f64> = solid.iter().flat_map(|&e| field.parts.iter().map(move |p| value(e, p))).collect();
    values.resize(cells * field.parts.len(), f64::NAN);
    values
}

/// A variable of integration points over points: the mean over the elements around that have it and are not deleted, not
/// weighted. An element has one such point, so that the value extrapolated to its corners is that of the point.
fn averaged_at_nodes(run: &Run<'_>, field: &FrameField, solid: &[(usize, usize)], frame: &Frame) -> Vec<f64> {
    let of_elements = of_elements(run, field, solid, solid.len());
    let width = field.parts.len();
    let (mut sums, mut counts) = (vec![0.0; width * frame.points.len()], vec![0_u32; frame.points.len()]);
    let is_there = |&(group, e): &(usize, usize)| run.solid.as_ref().is_some_and(|s| !s.groups[group].is_deleted(e));
    let elements = solid.iter().zip(of_elements.chunks(width)).zip(&frame.cells);
    for ((_, values), corners) in elements.filter(|((e, v), _)| is_there(e) && v.iter().all(|x| !x.is_nan())) {
        for &point in corners {
            counts[point] += 1;
            sums[width * point..].iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        }
    }
    let mean = |(i, sum): (usize, f64)| match counts[i / width] {
        0 => f64::NAN,
        count => sum / f64::from(count),
    };
    sums.into_iter().enumerate().map(mean).collect()
}

/// What loads show of facets; several loads on one facet come together as the variable says.
fn facet_fields(run: &Run<'_>, step: &StepPlan, elements: &[usize]) -> Vec<Field> {
    let shown: Vec<_> = step.forces.iter().filter_map(|f| f.facet_fields(&run.bodies)).collect();
    if shown.is_empty() {
        return Vec::new();
    }
    let mut cell_of_element = vec![usize::MAX; run.plan.mesh.elements.len()];
    for (cell, &element) in elements.iter().enumerate() {
        cell_of_element[element] = cell;
    }
    let facet_variables = Variable::ALL.iter().filter(|v| v.place() == Place::Facet);
    let field = |variable: &Variable| {
        let mut values = vec![0.0; elements.len()];
        for fields in &shown {
            for (facet, &element) in fields.elements.iter().enumerate() {
                let value = &mut values[cell_of_element[element]];
                *value = fields.value(facet, *variable).map_or(*value, |next| (variable.row().combined)(*value, next));
            }
        }
        Field { name: variable.name().into(), components: 1, component_names: Vec::new(), values }
    };
    facet_variables.map(field).collect()
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
