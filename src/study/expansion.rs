//! The pressure on an expanding cavity, measured: a deck of a wedge of a sphere whose cavity is opened at a constant velocity.

use std::f64::consts::PI;
use std::fmt::Write as _;

use rayon::prelude::*;
use serde::Serialize;

use super::StudyError;
use super::error::accepted;
use super::richardson::{self, Level, LimitEstimate};
use crate::job;
use crate::output::History;
use crate::resistance::{Curve, Material};
use crate::solve::Halt;
use crate::user::Routines;

/// Radius at the end over that at the start: by then the start is forgotten to a few hundredths of a percent.
const STRETCH: f64 = 14.0;
/// Share of the end over which the pressure is averaged.
const LATE: f64 = 0.3;
/// Steps of the logarithm of the radius from shell to shell.
pub const LEVELS: [f64; 3] = [0.08, 0.04, 0.02];
/// Poisson's ratio beyond which increments become short for nothing.
const LARGEST_RATIO: f64 = 0.499;

/// The pressure at one velocity.
#[derive(Clone, Debug, Serialize)]
pub struct MeasuredPressure {
    /// Velocity at which the cavity opens.
    pub velocity: f64,
    /// Pressure over the yield stress, on the meshes of [`LEVELS`].
    pub levels: Vec<f64>,
    /// What these say of the limit.
    pub estimate: LimitEstimate,
    /// Half of the difference between the pressures of the halves of the time that is averaged over, of the finest mesh.
    pub drift: f64,
}

impl MeasuredPressure {
    /// Distance within which the limit is expected.
    pub fn uncertainty(&self) -> f64 {
        self.estimate.uncertainty + self.drift
    }
}

/// Measures the pressure at velocities, on three meshes each, several at once.
pub fn measure(target: &Material, velocities: &[f64]) -> Result<Vec<MeasuredPressure>, StudyError> {
    check(target, velocities)?;
    let pairs: Vec<(f64, f64)> = velocities.iter().flat_map(|&v| LEVELS.map(|step| (v, step))).collect();
    let runs: Vec<[f64; 2]> = pairs.par_iter().map(|&(v, step)| run(target, v, step)).collect::<Result<_, _>>()?;
    let of = |(velocity, runs): (&f64, &[[f64; 2]])| {
        let series: Vec<Level> = LEVELS.iter().zip(runs).map(|(&size, r)| Level { size, value: r[0] }).collect();
        let estimate = richardson::estimate(&series)?;
        let levels = runs.iter().map(|r| r[0]).collect();
        Some(MeasuredPressure { velocity: *velocity, levels, estimate, drift: runs.last()?[1] })
    };
    Ok(velocities.iter().zip(runs.chunks(LEVELS.len())).filter_map(of).collect())
}

fn check(target: &Material, velocities: &[f64]) -> Result<(), StudyError> {
    let wrong = |what: &str| Err(StudyError::Setting(format!("--measure: {what}")));
    if target.poisson > LARGEST_RATIO {
        return wrong("the increments of an incompressible target have no length; give a Poisson's ratio below 0.499");
    }
    if target.pressure_slope > 0.0 || target.tension.is_some() || target.rate.is_some() {
        return wrong("strength that grows with pressure or rate, and cracks, are not in the deck that measures");
    }
    if matches!(target.curve, Curve::Power(n) if n > 0.9) {
        return wrong("a target that hardens as steeply as it is elastic does not yield; give --power 0.9 or less");
    }
    if velocities.iter().any(|v| *v <= 0.0 || !v.is_finite()) {
        return wrong("a cavity is opened at a velocity above zero");
    }
    Ok(())
}

/// Pressure over the yield stress, and its drift.
fn run(target: &Material, velocity: f64, step: f64) -> Result<[f64; 2], StudyError> {
    let wedge = Wedge::new(target, velocity, step);
    let prepared = accepted(job::prepare_text("cavity.inp", &wedge.deck(target), &[], &Routines::none()))?;
    let mut history = History::of_rows(prepared.plan.column_names());
    if let Some(Halt { code, reason, .. }) = job::run_into(&prepared, &mut history).0.halt {
        return Err(StudyError::Comparison(format!("--measure: at {velocity} the run halted: {code}: {reason}")));
    }
    Ok(wedge.pressure(&history).map(|p| p / target.yield_stress))
}

/// Shells between two rays, the first the equator; the cavity's first radius is 1.
struct Wedge {
    velocity: f64,
    radii: Vec<f64>,
    /// Cosine and sine of the second ray.
    ray: [f64; 2],
}

impl Wedge {
    /// Shells in equal steps of the logarithm of the radius as they lie when the cavity has grown to the root of its stretch: not
    /// too thick at the start, and not too thin at the end. Waves do not come back from the outside before the end.
    fn new(target: &Material, velocity: f64, step: f64) -> Wedge {
        let Material { young, poisson, density, .. } = *target;
        let modulus = young * (1.0 - poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson));
        let outside = 0.6 * (modulus / density).sqrt() * (STRETCH - 1.0) / velocity + 2.0 * STRETCH;
        let inside = STRETCH.sqrt();
        let radius =
            |i: i32| (libm::pow(inside * (step * f64::from(i)).exp(), 3.0) - libm::pow(inside, 3.0) + 1.0).cbrt();
        let mut radii: Vec<f64> = (0..).map(radius).take_while(|r| *r < outside).collect();
        radii.push(outside);
        Wedge { velocity, radii, ray: [libm::cos(2.0 * step), libm::sin(2.0 * step)] }
    }

    /// All nodes move along their rays, the two of a shell alike; volume follows the pressure linearly, as in the similarity
    /// solution: the equation of state of a shock speed that does not grow.
    fn deck(&self, target: &Material) -> String {
        let (n, [c, s], v) = (self.radii.len(), self.ray, self.velocity);
        let mut text = String::from("*Node\n");
        for (i, r) in self.radii.iter().enumerate() {
            let _ = write!(text, " {}, {r:?}, 0.\n {}, {:?}, {:?}\n", i + 1, n + i + 1, r * c, r * s);
        }
        text += "*Element, type=CAX4R, elset=WEDGE\n";
        for i in 1..n {
            let _ = writeln!(text, " {i}, {i}, {}, {}, {}", i + 1, n + i + 1, n + i);
        }
        let _ = write!(text, "*Nset, nset=LOW, generate\n 2, {n}\n*Nset, nset=A\n 1,\n*Nset, nset=B\n {},\n", n + 1);
        text += &material(target);
        text += "*Equation\n";
        for i in 2..=n {
            for (dof, part) in [(1, c), (2, s)] {
                let _ = writeln!(text, " 2\n {}, {dof}, 1., {i}, 1, {:?}", n + i, -part);
            }
        }
        let (a, b) = (v * c, v * s);
        let time = (STRETCH - 1.0) / v;
        let _ = write!(
            text,
            "*Initial Conditions, type=VELOCITY\n A, 1, {v:?}\n B, 1, {a:?}\n B, 2, {b:?}\n*Step\n*Dynamic, Explicit\n , {time:?}\n\
             *Boundary\n LOW, 2, 2\n*Boundary, type=VELOCITY\n A, 1, 1, {v:?}\n A, 2, 2, 0.\n B, 1, 1, {a:?}\n B, 2, 2, {b:?}\n\
             *Output, history, number interval=200\n*Node Output, nset=A\n RF1\n*Node Output, nset=B\n RF1, RF2\n*End Step\n"
        );
        text
    }

    /// The mean pressure at the end and its drift: the power of the forces that open the cavity over what its wall sweeps.
    fn pressure(&self, history: &History) -> [f64; 2] {
        let column = |name: &str| history.columns.iter().position(|c| c == name);
        let (Some(low), Some(across), Some(along)) = (column("RF1@A"), column("RF1@B"), column("RF2@B")) else {
            return [f64::NAN; 2];
        };
        let [c, s] = self.ray;
        let half = libm::sqrt(0.5 * (1.0 - c));
        let pressure = |row: usize, time: f64| {
            let radius = 1.0 + self.velocity * time;
            let force = history.cell(row, low) + c * history.cell(row, across) + s * history.cell(row, along);
            // A frustum: the chord is 2 a sin(angle/2), and moves at V cos(angle/2) along its normal.
            force / (PI * radius * (1.0 + c) * 2.0 * radius * half * libm::sqrt(1.0 - half * half))
        };
        let rows = history.times().iter().enumerate();
        let end = (STRETCH - 1.0) / self.velocity;
        let begin = end - LATE * STRETCH / self.velocity;
        let late: Vec<f64> = rows.filter(|(_, t)| **t > begin).map(|(i, t)| pressure(i, *t)).collect();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let (first, second) = late.split_at(late.len() / 2);
        [mean(&late), 0.5 * (mean(first) - mean(second)).abs()]
    }
}

/// Cards of the material; a power law by rows within 0.02 % of it.
fn material(target: &Material) -> String {
    let Material { young, poisson, density, yield_stress, .. } = *target;
    let bulk = young / (3.0 * (1.0 - 2.0 * poisson));
    let shear = 0.5 * young / (1.0 + poisson);
    let (rows, extrapolation) = match &target.curve {
        Curve::Perfect => (vec![[yield_stress, 0.0]], ""),
        Curve::Power(n) => (power(*n, young, yield_stress), ""),
        Curve::Table { rows, extrapolates } => {
            (rows.clone(), if *extrapolates { ", extrapolation=LINEAR" } else { "" })
        }
    };
    let rows: String = rows.iter().map(|[stress, strain]| format!(" {stress:?}, {strain:?}\n")).collect();
    format!(
        "*Solid Section, elset=WEDGE, material=M\n*Material, name=M\n*Density\n {density:?},\n*Eos, type=USUP\n {:?}, 0., 0.\n\
         *Elastic, type=SHEAR\n {shear:?},\n*Plastic{extrapolation}\n{rows}",
        (bulk / density).sqrt()
    )
}

/// Rows of a power law from yield to a strain of 30.
fn power(n: f64, young: f64, yield_stress: f64) -> Vec<[f64; 2]> {
    const ROWS: i32 = 120;
    let ratio = 30.0 * young / yield_stress;
    let row = |i: i32| {
        let q = libm::pow(ratio, f64::from(i) / f64::from(ROWS));
        let stress = yield_stress * libm::pow(q, n);
        [stress, if i == 0 { 0.0 } else { (yield_stress * q - stress) / young }]
    };
    let rows = (0..=ROWS).map(row);
    // Without plastic strain between them rows are one.
    rows.scan(-1.0, |last, r| Some((r[1] > std::mem::replace(last, r[1].max(*last))).then_some(r))).flatten().collect()
}
