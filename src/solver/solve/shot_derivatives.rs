//! Exact derivatives of shots by stages: velocities, masses, resistances and friction are numbers with derivatives
//! (`kernel/dual.rs`) on the whole path. Geometry is constant.

use super::staged_shots::{FinalValue, StagedShots, resistances};
use crate::kernel::cavity::CavityResistance;
use crate::kernel::dual::{Dual, derivative_along};
use crate::kernel::lanes::inline_from_fn;
use crate::kernel::shot_stages::{ForceStage, PathMotion, ShotPath};
use crate::load::cavity::{AxialResistance, ResistanceConstants, force_stage_slopes, force_stages};
use crate::plan::{Plan, State};
use crate::state::BodyState;

/// Numbers of a state on which shots by stages depend, or their derivatives by a parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct ShotInputs {
    /// Velocity and mass of each body; then, for each resistance, friction, and c0, c1, c2 of each layer.
    numbers: Vec<f64>,
    /// Planes between layers, which must not change.
    planes: Vec<f64>,
}

/// Values of the history columns at the end of a shot, with their derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct FinalRow {
    /// Value of each column; NaN if only increments give it.
    pub values: Vec<f64>,
    /// For each parameter the derivative of each column.
    pub slopes: Vec<Vec<f64>>,
}

/// Motion of a body at the end with derivatives.
struct BodyEnd<const N: usize> {
    mass: Dual<N>,
    striking: Dual<N>,
    displacement: Dual<N>,
    velocity: Dual<N>,
    acceleration: Dual<N>,
}

impl ShotInputs {
    /// Returns the numbers of a state; `None` if shots by stages do not apply.
    pub fn of(start: &State) -> Option<ShotInputs> {
        let mut inputs = ShotInputs { numbers: Vec::new(), planes: Vec::new() };
        inputs.numbers.extend(start.dofs.bodies.iter().flat_map(|body| [body.velocity, body.mass]));
        for resistance in resistances(start)? {
            let ResistanceConstants { laws, friction } = resistance.constants();
            inputs.numbers.push(friction);
            inputs.numbers.extend(laws.iter().flat_map(|law| [law.c0, law.c1, law.c2]));
            inputs.planes.extend(resistance.planes());
        }
        Some(inputs)
    }

    /// Returns a sum of inputs with a factor each, for example a difference quotient. `None` if the planes differ.
    pub fn combined(terms: &[(f64, &ShotInputs)]) -> Option<ShotInputs> {
        let first = terms.first()?.1;
        let is_alike =
            |(_, term): &(f64, &ShotInputs)| term.planes == first.planes && term.numbers.len() == first.numbers.len();
        let sum = |i: usize| terms.iter().map(|(factor, term)| factor * term.numbers[i]).sum();
        let numbers = (0..first.numbers.len()).map(sum).collect();
        terms.iter().all(is_alike).then(|| ShotInputs { numbers, planes: first.planes.clone() })
    }

    /// Returns velocity and mass of a body.
    fn of_body(&self, body: usize) -> [f64; 2] {
        [self.numbers[2 * body], self.numbers[2 * body + 1]]
    }

    /// Returns the constants of all resistances.
    fn constants(&self, bodies: usize, all: &[AxialResistance<'_>]) -> Vec<ResistanceConstants> {
        let mut numbers = self.numbers[2 * bodies..].iter().copied();
        let mut next = || numbers.next().unwrap_or_default();
        let mut constants = Vec::with_capacity(all.len());
        for resistance in all {
            let friction = next();
            let laws = (1..resistance.planes().len()).map(|_| CavityResistance { c0: next(), c1: next(), c2: next() });
            constants.push(ResistanceConstants { laws: laws.collect(), friction });
        }
        constants
    }
}

impl StagedShots {
    /// Returns the final values of the columns of a run from `start` and their derivatives by N parameters, of which
    /// `slopes` are the derivatives of the inputs. `None` if the motion must be integrated in increments.
    pub fn derivatives<const N: usize>(
        &self,
        plan: &Plan,
        start: &State,
        slopes: &[&ShotInputs; N],
    ) -> Option<FinalRow> {
        let duration = plan.steps.first()?.duration;
        let all = resistances(start)?;
        let bodies = &start.dofs.bodies;
        let constants: Vec<_> = slopes.iter().map(|slope| slope.constants(bodies.len(), &all)).collect();
        let mut ends = Vec::with_capacity(bodies.len());
        for (index, body) in bodies.iter().enumerate() {
            let on_body: Vec<usize> = (0..all.len()).filter(|i| all[*i].body() == index).collect();
            let of_body: Vec<_> = on_body.iter().map(|i| all[*i]).collect();
            let slopes_of_body = |constants: &Vec<ResistanceConstants>| {
                on_body.iter().map(|i| constants[*i].clone()).collect::<Vec<_>>()
            };
            let along = if body.velocity < 0.0 { -1.0 } else { 1.0 };
            let force_slopes = constants.iter().map(|all| slopes_of(&of_body, &slopes_of_body(all), along)).collect();
            let stages = match self.stages(index, along) {
                Some(known) => with_slopes(known, force_slopes),
                None => with_slopes(&force_stages(&of_body, along), force_slopes),
            };
            let of_slopes: [[f64; 2]; N] = inline_from_fn(|i| slopes[i].of_body(index));
            ends.push(end_of(body, of_slopes, stages, along, duration)?);
        }
        Some(self.final_row(plan, &ends, duration))
    }

    fn final_row<const N: usize>(&self, plan: &Plan, ends: &[BodyEnd<N>], time: f64) -> FinalRow {
        let mut row = FinalRow { values: Vec::new(), slopes: vec![Vec::new(); N] };
        for source in &self.sources {
            let (value, slopes) = match *source {
                Some(FinalValue::Expression(index)) => expression(plan, index, time, &row),
                Some(source) => {
                    let dual = source.with_derivatives(ends);
                    (dual.value, dual.slopes.to_vec())
                }
                None => (f64::NAN, vec![0.0; N]),
            };
            row.values.push(value);
            row.slopes.iter_mut().zip(slopes).for_each(|(slopes, slope)| slopes.push(slope));
        }
        row
    }
}

/// Returns the value of an expression over the previous columns, and its derivatives.
fn expression(plan: &Plan, index: usize, time: f64, row: &FinalRow) -> (f64, Vec<f64>) {
    let expression = &plan.expressions[index];
    let operands: Vec<usize> = expression.columns().collect();
    let value = |row: &[f64]| Some(expression.value(time, row)).filter(|value| value.is_finite());
    let slope = |slopes: &Vec<f64>| {
        let of_operands = |(i, slope): (usize, &f64)| if operands.contains(&i) { *slope } else { 0.0 };
        let slopes: Vec<f64> = slopes.iter().enumerate().map(of_operands).collect();
        derivative_along(&row.values, &slopes, &mut { value }).unwrap_or(f64::NAN)
    };
    (expression.value(time, &row.values), row.slopes.iter().map(slope).collect())
}

/// Returns the derivatives of the forces by one parameter; no stages if the resistances do not depend on it.
fn slopes_of(resistances: &[AxialResistance<'_>], slopes: &[ResistanceConstants], along: f64) -> Vec<ForceStage> {
    let is_zero = |constants: &ResistanceConstants| {
        constants.friction == 0.0 && constants.laws.iter().all(|law| *law == CavityResistance::NONE)
    };
    if slopes.iter().all(is_zero) { Vec::new() } else { force_stage_slopes(resistances, slopes, along) }
}

/// Adds the derivatives of forces by each parameter to stages; a list without stages is zero.
fn with_slopes<const N: usize>(stages: &[ForceStage], slopes: Vec<Vec<ForceStage>>) -> Vec<ForceStage<Dual<N>>> {
    let dual = |stage: usize, k: usize, j: usize| Dual {
        value: stages[stage].force[k][j],
        slopes: inline_from_fn(|i| slopes[i].get(stage).map_or(0.0, |stage| stage.force[k][j])),
    };
    let of_stage = |stage: usize| ForceStage {
        length: constant(stages[stage].length),
        force: inline_from_fn(|k| inline_from_fn(|j| dual(stage, k, j))),
    };
    (0..stages.len()).map(of_stage).collect()
}

/// Returns the motion of a body at the time `duration`; `slopes` are the derivatives of its velocity and mass.
fn end_of<const N: usize>(
    body: &BodyState,
    slopes: [[f64; 2]; N],
    stages: Vec<ForceStage<Dual<N>>>,
    along: f64,
    duration: f64,
) -> Option<BodyEnd<N>> {
    let of = |value: f64, at: usize| Dual { value, slopes: inline_from_fn(|i| slopes[i][at]) };
    let (striking, mass) = (of(body.velocity, 0), of(body.mass, 1));
    let PathMotion { distance, velocity, deceleration, .. } =
        ShotPath::new(mass, stages)?.motion_at(striking * along, duration)?;
    let [displacement, velocity, acceleration] = [distance * along, velocity * along, deceleration * -along];
    Some(BodyEnd { mass, striking, displacement, velocity, acceleration })
}

impl FinalValue {
    /// Returns the value of a column that is no expression.
    fn with_derivatives<const N: usize>(self, ends: &[BodyEnd<N>]) -> Dual<N> {
        let energy = |velocity: fn(&BodyEnd<N>) -> Dual<N>| {
            let kinetic = |end: &BodyEnd<N>| end.mass * velocity(end) * velocity(end) * 0.5;
            ends.iter().map(kinetic).fold(constant(0.0), |sum, energy| sum + energy)
        };
        let [initial, remaining] = [energy(|end| end.striking), energy(|end| end.velocity)];
        match self {
            FinalValue::Displacement(body) => ends[body].displacement,
            FinalValue::Velocity(body) => ends[body].velocity,
            FinalValue::Acceleration(body) => ends[body].acceleration,
            FinalValue::Coordinate(body, z) => constant(z) + ends[body].displacement,
            FinalValue::Constant(value) => constant(value),
            FinalValue::Kinetic => remaining,
            FinalValue::Dissipated => initial - remaining,
            FinalValue::Total => initial,
            FinalValue::Expression(_) => constant(f64::NAN),
        }
    }
}

fn constant<const N: usize>(value: f64) -> Dual<N> {
    Dual { value, slopes: [0.0; N] }
}
