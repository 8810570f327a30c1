//! Shots of rigid bodies through layers without time increments: the path of each body is divided into stages, in which
//! the motion has a closed form or a Taylor series (`kernel/shot_stages.rs`). Only the final instant is known.

use std::any::Any;

use super::observe::{Sink, output_failure};
use super::outcome::{ImpactEnd, RunEnd};
use crate::kernel::shot_stages::{ForceStage, PathMotion, ShotPath};
use crate::load::cavity::{AxialResistance, CavityExpansion, force_stages};
use crate::load::{Load, PenetrationOutcome};
use crate::model::{IncrementControl, LoadVelocity};
use crate::plan::{ColumnSource, HistoryColumn, Plan, State};
use crate::state::dofs::Dofs;
use crate::state::{BodyState, Instant, direction};
use crate::variables::Variable;

/// Paths of the rigid bodies of a plan, for many runs with other velocities.
pub struct StagedShots {
    paths: Vec<BodyPath>,
    /// Source of each history column; `None` for a column that only increments give.
    pub(super) sources: Vec<Option<FinalValue>>,
    /// Work arrays: motion at the end, and the row of the history.
    end: Dofs,
    row: Vec<f64>,
}

/// Path of a body in its direction of motion.
struct BodyPath {
    direction: f64,
    path: ShotPath,
}

/// Value of a history column at the end of a run.
#[derive(Clone, Copy)]
pub(super) enum FinalValue {
    Displacement(usize),
    Velocity(usize),
    Acceleration(usize),
    /// Coordinate along z: body, and initial z of the node.
    Coordinate(usize, f64),
    Constant(f64),
    Kinetic,
    /// Energy dissipated in the target.
    Dissipated,
    /// Total energy, which is the initial kinetic energy.
    Total,
    /// Index of the expression among those of the plan.
    Expression(usize),
}

impl StagedShots {
    /// Prepares the bodies of a plan with their initial state. Returns `None` unless the model consists of rigid bodies
    /// that move along z in one step, against resistances of laterally unbounded layers only, and error control chooses
    /// the increments.
    pub fn new(plan: &Plan, start: &State) -> Option<StagedShots> {
        if !has_rigid_bodies_alone(plan, start) {
            return None;
        }
        let paths = start.dofs.bodies.iter().enumerate().map(|(body, state)| path_of(start, body, state));
        let paths = paths.collect::<Option<Vec<_>>>()?;
        let has_friction = resistances(start)?.iter().any(|resistance| resistance.friction() > 0.0);
        let mut sources = Vec::with_capacity(plan.columns.len());
        for column in &plan.columns {
            sources.push(source_of(plan, column, has_friction, &sources));
        }
        let end = Dofs { bodies: start.dofs.bodies.clone(), ..Dofs::default() };
        Some(StagedShots { paths, sources, end, row: vec![0.0; plan.columns.len()] })
    }

    /// Returns whether the final value of a history column is known.
    pub fn has_column(&self, name: &str, plan: &Plan) -> bool {
        let mut columns = plan.columns.iter().zip(&self.sources);
        columns.any(|(column, source)| column.name.eq_ignore_ascii_case(name) && source.is_some())
    }

    /// Returns the stages of a body in a direction, +1 or -1; `None` if they are those of the other direction.
    pub(super) fn stages(&self, body: usize, direction: f64) -> Option<&[ForceStage]> {
        self.paths.get(body).filter(|path| path.direction == direction).map(|path| path.path.stages())
    }

    /// Runs the shots from a state that differs from that of [`StagedShots::new`] in velocities only, and passes one row,
    /// that of the end, to `sink`. Columns that are not [known](StagedShots::has_column) are NaN. Returns `None` if the
    /// motion must be integrated in increments.
    pub fn run(&mut self, plan: &Plan, start: &State, sink: &mut dyn Sink) -> Option<RunEnd> {
        let step = plan.steps.first()?;
        for (body, state) in start.dofs.bodies.iter().enumerate() {
            if state.velocity * self.paths[body].direction < 0.0 {
                self.paths[body] = path_of(start, body, state)?;
            }
            let BodyPath { direction, path } = &mut self.paths[body];
            let motion = path.motion_at(state.velocity.abs(), step.duration)?;
            place(&mut self.end.bodies[body], motion, *direction);
        }
        let mut end = RunEnd { total_time: step.duration, ..RunEnd::default() };
        for record in start.loads.iter().flat_map(|load| load.penetrations(&self.end)) {
            end.still_moving += usize::from(record.outcome == PenetrationOutcome::Moving);
            let speed = self.end.bodies[record.body].velocity.abs();
            end.impacts.push(ImpactEnd { body: record.body, outcome: record.outcome, speed });
        }
        if !step.outputs.history.is_empty() {
            self.fill_row(plan, start, step.duration);
            let now = Instant { step_time: step.duration, total_time: step.duration, step: 1, ..Instant::default() };
            end.halt = sink.row(&now, &self.row).map_err(output_failure).err();
        }
        Some(end)
    }

    fn fill_row(&mut self, plan: &Plan, start: &State, time: f64) {
        let bodies = &self.end.bodies;
        let kinetic = |bodies: &[BodyState]| bodies.iter().map(BodyState::kinetic).sum::<f64>();
        let [initial, remaining] = [kinetic(&start.dofs.bodies), kinetic(bodies)];
        for (column, source) in self.sources.iter().enumerate() {
            self.row[column] = match *source {
                Some(FinalValue::Displacement(body)) => bodies[body].displacement,
                Some(FinalValue::Velocity(body)) => bodies[body].velocity,
                Some(FinalValue::Acceleration(body)) => bodies[body].acceleration,
                Some(FinalValue::Coordinate(body, z)) => z + bodies[body].displacement,
                Some(FinalValue::Constant(value)) => value,
                Some(FinalValue::Kinetic) => remaining,
                Some(FinalValue::Dissipated) => initial - remaining,
                Some(FinalValue::Total) => initial,
                Some(FinalValue::Expression(index)) => plan.expressions[index].value(time, &self.row[..column]),
                None => f64::NAN,
            };
        }
    }
}

/// Returns whether a plan has nothing but rigid bodies along z with resistances, in one step with error control.
fn has_rigid_bodies_alone(plan: &Plan, start: &State) -> bool {
    let State { dofs, thermal, constraints, user_motions, amplitude_routines, user_amplitudes, .. } = start;
    let [step] = &plan.steps[..] else { return false };
    matches!(step.control, IncrementControl::Automatic { .. })
        && step.load_velocity == LoadVelocity::Predicted
        && step.energy_limit.is_none()
        && !plan.routines.any()
        && dofs.nodes.is_empty()
        && thermal.is_none()
        && constraints.is_empty()
        && user_motions.is_empty()
        && amplitude_routines.is_empty()
        && user_amplitudes.is_empty()
        && dofs.bodies.iter().all(|body| body.stations().is_none())
}

/// Returns the resistances of all loads; `None` if a load is not one of bodies along z in laterally unbounded layers.
pub(super) fn resistances(start: &State) -> Option<Vec<AxialResistance<'_>>> {
    let mut resistances = Vec::new();
    for load in &start.loads {
        let load: &dyn Load = &**load;
        resistances.extend((load as &dyn Any).downcast_ref::<CavityExpansion>()?.axial_resistances()?);
    }
    resistances.iter().all(AxialResistance::only_resists).then_some(resistances)
}

/// Returns the path of a body in its direction of motion.
fn path_of(start: &State, body: usize, state: &BodyState) -> Option<BodyPath> {
    let mut on_body = resistances(start)?;
    on_body.retain(|resistance| resistance.body() == body);
    let along = if state.velocity < 0.0 { -1.0 } else { 1.0 };
    Some(BodyPath { direction: along, path: ShotPath::new(state.mass, force_stages(&on_body, along))? })
}

fn place(body: &mut BodyState, motion: PathMotion, along: f64) {
    // The sum has no negative zero.
    let signed = |value: f64| along * value + 0.0;
    body.displacement = signed(motion.distance);
    body.velocity = signed(motion.velocity);
    body.acceleration = signed(-motion.deceleration);
    body.direction = direction(body.velocity);
}

/// Returns the source of a column; `previous` are those of the columns before it.
fn source_of(
    plan: &Plan,
    column: &HistoryColumn,
    has_friction: bool,
    previous: &[Option<FinalValue>],
) -> Option<FinalValue> {
    let variable = column.part.map(|part| (part.variable, part.component));
    match (column.source, variable) {
        (ColumnSource::Expression(index), _) => {
            let mut operands = plan.expressions[index].columns();
            operands.all(|operand| previous[operand].is_some()).then_some(FinalValue::Expression(index))
        }
        (ColumnSource::Body { node, .. }, Some((Variable::Coordinate, 0))) => {
            Some(FinalValue::Constant(plan.mesh.points[node][0]))
        }
        (ColumnSource::Body { body, node }, Some((variable, component))) => match variable {
            Variable::Coordinate => Some(FinalValue::Coordinate(body, plan.mesh.points[node][1])),
            Variable::Displacement | Variable::Velocity | Variable::Acceleration if component == 0 => {
                Some(FinalValue::Constant(0.0))
            }
            Variable::Displacement => Some(FinalValue::Displacement(body)),
            Variable::Velocity => Some(FinalValue::Velocity(body)),
            Variable::Acceleration => Some(FinalValue::Acceleration(body)),
            _ => None,
        },
        (ColumnSource::Model, Some((variable, _))) => match variable {
            Variable::KineticEnergy => Some(FinalValue::Kinetic),
            Variable::TotalEnergy => Some(FinalValue::Total),
            Variable::Work | Variable::InternalEnergy => Some(FinalValue::Constant(0.0)),
            // With friction, the stages do not divide the dissipated energy.
            Variable::FrictionEnergy if !has_friction => Some(FinalValue::Constant(0.0)),
            Variable::CavityEnergy if !has_friction => Some(FinalValue::Dissipated),
            _ => None,
        },
        _ => None,
    }
}
