//! Finite-element computation of the pressure on an expanding cavity: a deck with a wedge of a sphere, or a layer of a cylinder,
//! whose cavity opens at a constant velocity.

use std::f64::consts::PI;
use std::fmt::Write as _;

use rayon::prelude::*;
use serde::Serialize;

use super::StudyError;
use super::richardson::{self, LimitEstimate, RefinementLevel};
use crate::deck::{self, Severity};
use crate::job;
use crate::model::{self, MaterialDefinition};
use crate::output::RunHistory;
use crate::resistance::{CavityShape, TargetMaterial, TargetScale, YieldCurve};
use crate::user::Routines;

/// Final radius of the cavity divided by its initial radius; the influence of the initial state is then a few
/// hundredths of a percent.
const RADIUS_RATIO: f64 = 14.0;
/// Length of the averaging interval at the end, as a fraction of the final cavity radius divided by the velocity.
const AVERAGED_SHARE: f64 = 0.3;
/// Mesh sizes: differences of the logarithm of the radius between shells of nodes.
pub const LEVELS: [f64; 3] = [0.08, 0.04, 0.02];
/// Largest Poisson's ratio; above it the stable time increment becomes very small.
const LARGEST_RATIO: f64 = 0.499;

/// Computed pressure at one velocity.
#[derive(Clone, Debug, Serialize)]
pub struct MeasuredPressure {
    /// Velocity of the cavity wall.
    pub velocity: f64,
    /// Pressure divided by the yield stress on the meshes of [`LEVELS`].
    pub levels: Vec<f64>,
    /// Estimate of the limit for infinitely fine meshes.
    pub estimate: LimitEstimate,
    /// Half of the difference between the mean pressures in the two halves of the averaging interval, on the finest
    /// mesh.
    pub drift: f64,
}

impl MeasuredPressure {
    /// Returns the uncertainty of the limit: discretisation error and drift.
    pub fn uncertainty(&self) -> f64 {
        self.estimate.uncertainty + self.drift
    }
}

/// Material of a meshed cavity.
pub enum MeasuredMaterial {
    /// A stress-strain curve, with a pressure that is linear in the volume.
    Curve(TargetMaterial),
    /// A material of a deck with cards of strength.
    Law(Box<MaterialDefinition>),
}

impl MeasuredMaterial {
    /// Returns the speed of dilatational waves.
    fn wave_speed(&self, density: f64) -> f64 {
        let modulus = match self {
            MeasuredMaterial::Curve(TargetMaterial { young, poisson, .. }) => {
                young * (1.0 - poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
            }
            MeasuredMaterial::Law(material) => {
                material.small_strain_moduli(None).map_or(f64::NAN, |m| m.bulk + 4.0 / 3.0 * m.shear)
            }
        };
        (modulus / density).sqrt()
    }

    /// Returns the cards of the material and its section; those of a law are replaced in the model.
    fn cards(&self) -> String {
        match self {
            MeasuredMaterial::Curve(target) => material(target),
            MeasuredMaterial::Law(_) => {
                "*Solid Section, elset=WEDGE, material=M\n*Material, name=M\n*Density\n 1.,\n*Elastic\n 1., 0.\n".into()
            }
        }
    }

    fn prepared(&self, text: &str) -> Result<job::PreparedJob, StudyError> {
        let (deck, diagnostics) = deck::read_text("cavity.inp", text, &[]);
        let (mut model, mut findings) = model::build(&deck);
        findings.append(diagnostics);
        if let MeasuredMaterial::Law(material) = self {
            let material = MaterialDefinition { damping: None, cavity: None, ..(**material).clone() };
            model.materials = vec![material];
        }
        let prepared = job::prepare_model(&model, &Routines::none());
        let error = findings.iter().chain(prepared.diagnostics.iter()).find(|d| d.severity == Severity::Error).cloned();
        error.map_or(Ok(prepared), |error| Err(StudyError::from(error)))
    }
}

/// Computes the pressure at each velocity on three meshes; runs are parallel.
pub fn measure(
    material: &MeasuredMaterial,
    scale: TargetScale,
    velocities: &[f64],
) -> Result<Vec<MeasuredPressure>, StudyError> {
    check(material, velocities)?;
    let pairs: Vec<(f64, f64)> = velocities.iter().flat_map(|&v| LEVELS.map(|step| (v, step))).collect();
    let run = |&(velocity, step): &(f64, f64)| run(material, scale, velocity, step);
    let runs: Vec<[f64; 2]> = pairs.par_iter().map(run).collect::<Result<_, _>>()?;
    let measured = |(velocity, runs): (&f64, &[[f64; 2]])| {
        let series: Vec<RefinementLevel> =
            LEVELS.iter().zip(runs).map(|(&size, r)| RefinementLevel { size, value: r[0] }).collect();
        let estimate = richardson::estimate(&series)?;
        let levels = runs.iter().map(|r| r[0]).collect();
        Some(MeasuredPressure { velocity: *velocity, levels, estimate, drift: runs.last()?[1] })
    };
    Ok(velocities.iter().zip(runs.chunks(LEVELS.len())).filter_map(measured).collect())
}

fn check(material: &MeasuredMaterial, velocities: &[f64]) -> Result<(), StudyError> {
    let wrong = |what: &str| Err(StudyError::Setting(format!("--measure: {what}")));
    if velocities.iter().any(|v| *v <= 0.0 || !v.is_finite()) {
        return wrong("velocities must be above zero");
    }
    let target = match material {
        MeasuredMaterial::Curve(target) => target,
        MeasuredMaterial::Law(material) if model::derive::depends_on_rate(material) => {
            return wrong("strain-rate dependence is unsupported; set its constant to 0, or omit --measure");
        }
        MeasuredMaterial::Law(material) if material.strength.takes_length() => {
            return wrong(
                "softening over displacements is unsupported, because the elements of the cavity change their length",
            );
        }
        MeasuredMaterial::Law(_) => return Ok(()),
    };
    if target.poisson > LARGEST_RATIO {
        return wrong(
            "the stable time increment of an incompressible target is zero; give a Poisson's ratio of at most 0.499",
        );
    }
    if target.pressure_slope > 0.0 || target.tension.is_some() || target.rate.is_some() {
        return wrong(
            "pressure-dependent strength, strain-rate dependence and cracks are unsupported; omit --measure or these options",
        );
    }
    if matches!(target.curve, YieldCurve::Power(n) if n > 0.9) {
        return wrong("the hardening exponent is too close to elastic behaviour; give --power 0.9 or less");
    }
    Ok(())
}

/// Runs one mesh; returns the pressure divided by the yield stress, and its drift.
fn run(material: &MeasuredMaterial, scale: TargetScale, velocity: f64, step: f64) -> Result<[f64; 2], StudyError> {
    let wedge = Wedge::new(scale.shape, material.wave_speed(scale.density), velocity, step);
    let prepared = material.prepared(&wedge.deck(&material.cards()))?;
    let mut history = RunHistory::of_rows(prepared.plan.column_names());
    if let Some(halt) = job::run_into(&prepared, &mut history).0.halt {
        return Err(StudyError::Comparison(format!("--measure: at {velocity} the run halted: {halt}")));
    }
    Ok(wedge.pressure(&history).map(|p| p / scale.yield_stress))
}

/// Mesh of shells. Those of a sphere are between two rays, of which the first is on the equator; those of a cylinder between two
/// planes at the distance 1. The initial cavity radius is 1.
struct Wedge {
    shape: CavityShape,
    velocity: f64,
    radii: Vec<f64>,
    /// Cosine and sine of the second ray; of a cylinder the direction of all radii.
    ray: [f64; 2],
}

impl Wedge {
    /// Creates shells whose radii have equal logarithmic steps at the time when the cavity radius is the square root of
    /// its final value: shells are then neither too thick at the start nor too thin at the end. The outer radius is so
    /// large that no wave returns from it before the end.
    fn new(shape: CavityShape, wave_speed: f64, velocity: f64, step: f64) -> Wedge {
        let outside = 0.6 * wave_speed * (RADIUS_RATIO - 1.0) / velocity + 2.0 * RADIUS_RATIO;
        let inside = RADIUS_RATIO.sqrt();
        let power = shape.hoops() + 1.0;
        let radius = |i: i32| {
            let grown = libm::pow(inside * libm::exp(step * f64::from(i)), power) - libm::pow(inside, power) + 1.0;
            if shape == CavityShape::Spherical { libm::cbrt(grown) } else { grown.sqrt() }
        };
        let mut radii: Vec<f64> = (0..).map(radius).take_while(|r| *r < outside).collect();
        radii.push(outside);
        let ray = match shape {
            CavityShape::Spherical => [libm::cos(2.0 * step), libm::sin(2.0 * step)],
            CavityShape::Cylindrical => [1.0, 0.0],
        };
        Wedge { shape, velocity, radii, ray }
    }

    /// Writes the deck. All nodes move along their rays, the two nodes of a shell by the same distance. The pressure is
    /// linear in the volume, as in the similarity solution: an equation of state with a constant shock speed.
    fn deck(&self, material: &str) -> String {
        let (n, [c, s], v) = (self.radii.len(), self.ray, self.velocity);
        let mut text = String::from("*Node\n");
        for (i, r) in self.radii.iter().enumerate() {
            let height = if self.shape == CavityShape::Spherical { r * s } else { 1.0 };
            let _ = write!(text, " {}, {r:?}, 0.\n {}, {:?}, {height:?}\n", i + 1, n + i + 1, r * c);
        }
        text += "*Element, type=CAX4R, elset=WEDGE\n";
        for i in 1..n {
            let _ = writeln!(text, " {i}, {i}, {}, {}, {}", i + 1, n + i + 1, n + i);
        }
        let _ = write!(text, "*Nset, nset=LOW, generate\n 2, {n}\n*Nset, nset=A\n 1,\n*Nset, nset=B\n {},\n", n + 1);
        let _ = write!(text, "*Nset, nset=HIGH, generate\n {}, {}\n", n + 2, 2 * n);
        text += material;
        text += "*Equation\n";
        for i in 2..=n {
            for (dof, part) in [(1, c), (2, s)].into_iter().filter(|(_, part)| *part != 0.0) {
                let _ = writeln!(text, " 2\n {}, {dof}, 1., {i}, 1, {:?}", n + i, -part);
            }
        }
        let (a, b) = (v * c, v * s);
        let time = (RADIUS_RATIO - 1.0) / v;
        let planes = if self.shape == CavityShape::Cylindrical { " HIGH, 2, 2\n" } else { "" };
        let _ = write!(
            text,
            "*Initial Conditions, type=VELOCITY\n A, 1, {v:?}\n B, 1, {a:?}\n B, 2, {b:?}\n*Step\n*Dynamic, Explicit\n , {time:?}\n\
             *Boundary\n LOW, 2, 2\n{planes}*Boundary, type=VELOCITY\n A, 1, 1, {v:?}\n A, 2, 2, 0.\n B, 1, 1, {a:?}\n B, 2, 2, {b:?}\n\
             *Output, history, number interval=200\n*Node Output, nset=A\n RF1\n*Node Output, nset=B\n RF1, RF2\n*End Step\n"
        );
        text
    }

    /// Returns the mean pressure at the end and its drift. The pressure is the work of the reaction forces on the cavity
    /// wall over an output interval, of which a row has the mean, divided by the swept volume.
    fn pressure(&self, history: &RunHistory) -> [f64; 2] {
        let column = |name: &str| history.columns.iter().position(|c| c == name);
        let (Some(low), Some(across), Some(along)) = (column("RF1@A"), column("RF1@B"), column("RF2@B")) else {
            return [f64::NAN; 2];
        };
        let [c, s] = self.ray;
        let half = libm::sqrt(0.5 * (1.0 - c));
        let pressure = |row: usize, [begin, end]: [f64; 2]| {
            let [a, b] = [begin, end].map(|time| 1.0 + self.velocity * time);
            let force = history.cell(row, low) + c * history.cell(row, across) + s * history.cell(row, along);
            if self.shape == CavityShape::Cylindrical {
                return force / (PI * (a + b));
            }
            let squared_radius = (a * a + a * b + b * b) / 3.0;
            // The wall is a frustum: its chord is 2 a sin(angle/2) and its normal velocity V cos(angle/2).
            force / (PI * squared_radius * (1.0 + c) * 2.0 * half * libm::sqrt(1.0 - half * half))
        };
        let rows = history.times().windows(2).enumerate();
        let end = (RADIUS_RATIO - 1.0) / self.velocity;
        let begin = end - AVERAGED_SHARE * RADIUS_RATIO / self.velocity;
        let late = rows.filter(|(_, times)| times[1] > begin);
        let late: Vec<f64> = late.map(|(i, times)| pressure(i + 1, [times[0], times[1]])).collect();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let (first, second) = late.split_at(late.len() / 2);
        [mean(&late), 0.5 * (mean(first) - mean(second)).abs()]
    }
}

/// Writes the cards of the material; a power law is approximated by rows within 0.02 %.
fn material(target: &TargetMaterial) -> String {
    let TargetMaterial { young, poisson, density, yield_stress, .. } = *target;
    let bulk = young / (3.0 * (1.0 - 2.0 * poisson));
    let shear = 0.5 * young / (1.0 + poisson);
    let (rows, extrapolation) = match &target.curve {
        YieldCurve::Perfect => (vec![[yield_stress, 0.0]], ""),
        YieldCurve::Power(n) => (power(*n, young, yield_stress), ""),
        YieldCurve::Table { rows, extrapolates } => {
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

/// Returns rows of stress and plastic strain of a power law, up to a strain of 30.
fn power(n: f64, young: f64, yield_stress: f64) -> Vec<[f64; 2]> {
    const ROWS: i32 = 120;
    let ratio = 30.0 * young / yield_stress;
    let row = |i: i32| {
        let q = libm::pow(ratio, f64::from(i) / f64::from(ROWS));
        let stress = yield_stress * libm::pow(q, n);
        [stress, if i == 0 { 0.0 } else { (yield_stress * q - stress) / young }]
    };
    let rows = (0..=ROWS).map(row);
    // Rows with the same plastic strain are merged.
    rows.scan(-1.0, |last, r| Some((r[1] > std::mem::replace(last, r[1].max(*last))).then_some(r))).flatten().collect()
}
