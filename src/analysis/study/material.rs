//! Stress-strain curves of materials: one CAX4R element in uniaxial tension at a constant true strain rate, with the
//! material of the deck.

use std::fmt::Write as _;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use serde::Serialize;
use serde_json::{Value, json};

use super::StudyError;
use super::chart::{Chart, ChartSeries, SeriesForm};
use super::strength::StrengthCurves;
use super::table::{TextTable, digits};
use crate::deck::{self, Severity};
use crate::job::{self, PreparedJob};
use crate::model::{self, DamageEvolution, DeckUnits, MaterialDefinition, MaterialId, Model};
use crate::output::RunHistory;
use crate::solve::{Instant, Sink, SinkError};
use crate::user::Routines;

/// Number of increments of a run. The element is so large that the stable time increment gives this number: its
/// velocity is then about 1e-5 of the wave speed, and the effect of inertia on the stress 1e-6 of Young's modulus.
const INCREMENTS: f64 = 50_000.0;
/// Durations of the run that gives the stable time increment of an element of size 1. A run may have at most 1e10
/// increments, and its duration must be longer than an increment.
const TRIAL_DURATIONS: [f64; 3] = [1e6, 1.0, 1e-6];
/// Number of points of a curve.
const POINTS: u32 = 1000;
/// Number of points of the velocity over time; linear interpolation changes the strain rate by less than 1e-6.
const VELOCITY_POINTS: u32 = 400;
/// True strains of the columns of the table.
pub const STRAINS: [f64; 5] = [0.01, 0.05, 0.1, 0.2, 0.5];
/// Names of the axes of the curves.
pub const AXES: [&str; 2] = ["true strain", "true stress"];
/// Plastic strain of the tabulated yield stress.
const YIELD_STRAIN: f64 = 0.002;
/// Decrease of the stress relative to its maximum from which a curve softens.
const SOFTENING: f64 = 1e-3;
/// Relative difference below which stresses are equal; the oscillation of the element after yield is smaller.
const PLATEAU: f64 = 1e-6;

/// Settings of the curves of one material.
#[derive(Clone, Debug, PartialEq)]
pub struct TensionRequest {
    /// True strain rates.
    pub rates: Vec<f64>,
    /// Initial temperatures; with `None` the model has no initial temperature.
    pub temperatures: Vec<Option<f64>>,
    /// True strain at the end.
    pub strain: f64,
    /// Whether plastic work heats the material.
    pub adiabatic: bool,
    /// Characteristic element length for damage evolution and cracks of concrete.
    pub length: f64,
}

/// Point of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TensionPoint {
    /// True strain.
    pub strain: f64,
    /// True stress.
    pub stress: f64,
    /// Equivalent plastic strain; NaN if the material has none.
    pub plastic: f64,
    /// Temperature; NaN if the material has none.
    pub temperature: f64,
}

/// True stress over true strain at one rate and initial temperature.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TensionCurve {
    /// True strain rate.
    pub rate: f64,
    /// Initial temperature.
    pub temperature: Option<f64>,
    /// Points with ascending strain.
    pub points: Vec<TensionPoint>,
    /// True strain at which the element is deleted.
    pub failure: Option<f64>,
    /// Reason for an early end of the run.
    pub halt: Option<String>,
}

impl TensionCurve {
    /// Returns the stress at a strain; `None` beyond the last point.
    pub fn stress_at(&self, strain: f64) -> Option<f64> {
        self.stress_where(strain, |point| point.strain)
    }

    /// Returns the stress at a plastic strain of 0.2 %; `None` without plastic strain.
    pub fn yield_stress(&self) -> Option<f64> {
        self.stress_where(YIELD_STRAIN, |point| point.plastic)
    }

    /// Returns the strain of the largest stress after 0.2 % plastic strain, if the stress decreases later; of equal
    /// stresses, the last one.
    pub fn softening_strain(&self) -> Option<f64> {
        let yielded = self.points.iter().position(|p| p.plastic >= YIELD_STRAIN).unwrap_or(0);
        let points = self.points.get(yielded..)?;
        let peak = points.iter().map(|p| p.stress).fold(f64::NEG_INFINITY, f64::max);
        let is_softer = points.last()?.stress < (1.0 - SOFTENING) * peak;
        let top = points.iter().rfind(|p| p.stress >= peak - PLATEAU * peak.abs())?;
        is_softer.then_some(top.strain)
    }

    /// Interpolates the stress where an ascending quantity reaches a value.
    fn stress_where(&self, value: f64, quantity: impl Fn(&TensionPoint) -> f64) -> Option<f64> {
        let after = self.points.iter().position(|p| quantity(p) >= value * (1.0 - 1e-9))?;
        let upper = &self.points[after];
        let Some(from) = after.checked_sub(1).and_then(|before| self.points.get(before)) else {
            return Some(upper.stress);
        };
        let share = ((value - quantity(from)) / (quantity(upper) - quantity(from))).clamp(0.0, 1.0);
        Some(from.stress + share * (upper.stress - from.stress))
    }

    /// Returns rate and temperature as text, for example `1000 1/s, 298 K`.
    pub fn label(&self, units: Option<&DeckUnits>) -> String {
        let with = |word: &str, value: f64, unit: &dyn Fn(&DeckUnits) -> String| match units {
            Some(units) => format!("{} {}", digits(value, 6), unit(units)),
            None => format!("{word} {}", digits(value, 6)),
        };
        let rate = with("rate", self.rate, &|units| units.name([0, 0, -1, 0]));
        let Some(temperature) = self.temperature else { return rate };
        let temperature = with("temperature", temperature, &|units| units.temperature.clone());
        format!("{rate}, {temperature}")
    }
}

/// Returns the reason why a material cannot be stretched in one direction; `None` if it can.
pub fn obstacle(material: &MaterialDefinition) -> Option<&'static str> {
    match (&material.eos, material.shear_modulus) {
        _ if material.is_explosive() => Some("an explosive (*EOS, TYPE=JWL) has no strength"),
        (Some(_), None) => Some("a fluid (*EOS without *ELASTIC, TYPE=SHEAR) has no strength"),
        (Some(_), Some(_)) => None,
        _ if material.user.energy.is_some_and(|energy| energy.families > 0) => {
            Some("it has fibres, and its strength depends on the direction (*ANISOTROPIC HYPERELASTIC)")
        }
        _ if material.elastic.is_some()
            || material.hyperelastic.is_some()
            || material.has_strength_law()
            || material.user.material.is_some() =>
        {
            None
        }
        _ if material.lamina.is_some() => Some("a lamina (*ELASTIC, TYPE=LAMINA) is a layer of shells"),
        _ if material.cavity.is_some() => Some("it is the resistance of a target without a mesh (*CAVITY EXPANSION)"),
        _ => Some("it has no elasticity (*ELASTIC, *HYPERELASTIC or *USER MATERIAL)"),
    }
}

/// Returns the initial temperatures that a model gives to the elements of a material, ascending; one `None` if it gives
/// none.
pub fn initial_temperatures(model: &Model, material: MaterialId) -> Vec<Option<f64>> {
    let mut is_node = vec![false; model.mesh.points.len()];
    for &node in elements_of(model, material).flat_map(|e| model.mesh.elements[e].nodes.iter()) {
        is_node[node] = true;
    }
    let meets = |members: &[usize]| members.iter().any(|&n| is_node.get(n) == Some(&true));
    let conditions = model.initial_conditions.iter().filter(|condition| meets(&condition.members));
    let mut temperatures: Vec<f64> = conditions.filter_map(|condition| condition.kind.temperature()).collect();
    temperatures.sort_by(f64::total_cmp);
    temperatures.dedup();
    if temperatures.is_empty() { vec![None] } else { temperatures.into_iter().map(Some).collect() }
}

/// Returns the mean characteristic length of the solid elements of a material, the square root of their areas in the
/// r-z plane; `None` without elements.
pub fn element_length(model: &Model, material: MaterialId) -> Option<f64> {
    let area = |e: usize| {
        let point = |&n: &usize| model.mesh.points[n];
        let corners: Vec<[f64; 2]> = model.mesh.elements[e].nodes.iter().map(point).collect();
        let next = corners.iter().cycle().skip(1);
        0.5 * corners.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum::<f64>().abs()
    };
    let lengths: Vec<f64> = elements_of(model, material).map(|e| area(e).sqrt()).collect();
    (!lengths.is_empty()).then(|| lengths.iter().sum::<f64>() / lengths.len() as f64)
}

/// Returns whether the failure of a material, or the cracking of concrete, depends on the element length.
pub fn takes_length(material: &MaterialDefinition) -> bool {
    material.strength.takes_length() || material.failures.iter().any(|criterion| criterion.takes_length())
}

fn elements_of(model: &Model, material: MaterialId) -> impl Iterator<Item = usize> {
    model.sections.iter().filter(move |s| s.material == material).flat_map(|s| s.elements.iter().copied())
}

/// Computes the curves of a material: all rates at the first temperature, then at the next one. Runs are parallel.
///
/// # Errors
/// If the material is invalid or the run has no increment.
pub fn curves(
    source: &Model,
    material: MaterialId,
    request: &TensionRequest,
    routines: &Routines,
) -> Result<Vec<TensionCurve>, StudyError> {
    let rates = |&temperature: &Option<f64>| request.rates.iter().map(move |&rate| (rate, temperature));
    let settings: Vec<(f64, Option<f64>)> = request.temperatures.iter().flat_map(rates).collect();
    let run = |&(rate, temperature): &(f64, Option<f64>)| {
        let test = TensionTest { source, material: &source.materials[material], request, rate, temperature, routines };
        test.curve()
    };
    settings.par_iter().map(run).collect()
}

/// One run.
struct TensionTest<'a> {
    source: &'a Model,
    material: &'a MaterialDefinition,
    request: &'a TensionRequest,
    rate: f64,
    temperature: Option<f64>,
    routines: &'a Routines,
}

/// Sink that interrupts a run after its first increments.
struct FirstIncrements<'a> {
    rows: usize,
    interrupt: &'a AtomicUsize,
}

impl Sink for FirstIncrements<'_> {
    fn row(&mut self, _now: &Instant, _values: &[f64]) -> Result<(), SinkError> {
        self.rows += 1;
        if self.rows > 2 {
            self.interrupt.store(usize::MAX, Ordering::Relaxed);
        }
        Ok(())
    }
}

impl TensionTest<'_> {
    fn curve(&self) -> Result<TensionCurve, StudyError> {
        let size = self.size()?;
        let prepared = self.prepared(&self.deck(size), size)?;
        let mut history = RunHistory::of_rows(prepared.plan.column_names());
        let outcome = job::run_into(&prepared, &mut history).0;
        let halt = outcome.halt.map(|halt| halt.to_string());
        let (points, failure) = points(&history, self.rate);
        // The deletion of the only element may end the run.
        let halt = halt.filter(|_| failure.is_none());
        Ok(TensionCurve { rate: self.rate, temperature: self.temperature, points, failure, halt })
    }

    /// Returns the element size with which the run has the intended number of increments.
    fn size(&self) -> Result<f64, StudyError> {
        let mut why = "no stable time increment".to_owned();
        for duration in TRIAL_DURATIONS {
            let prepared = self.prepared(&self.resting_deck(duration), 1.0)?;
            let interrupt = AtomicUsize::new(0);
            let mut trial = FirstIncrements { rows: 0, interrupt: &interrupt };
            let outcome = job::run_until(&prepared, &mut trial, &interrupt).0;
            let increment = outcome.steps.first().map_or(0.0, |step| step.largest_increment);
            let size = self.request.strain / (INCREMENTS * self.rate * increment);
            if trial.rows > 2 && size > 0.0 && size.is_finite() {
                return Ok(size);
            }
            why = outcome.halt.map_or(why, |halt| halt.to_string());
        }
        Err(StudyError::Comparison(why))
    }

    /// Prepares a deck of one element with the material. Lengths of damage and cracks are scaled to the element size.
    fn prepared(&self, text: &str, size: f64) -> Result<PreparedJob, StudyError> {
        let (deck, diagnostics) = deck::read_text("tension.inp", text, &[]);
        let (mut model, mut findings) = model::build(&deck);
        findings.append(diagnostics);
        if let Some(error) = findings.iter().find(|d| d.severity == Severity::Error) {
            return Err(StudyError::from(error.clone()));
        }
        let mut material = self.material.clone();
        // Damping acts on the motion of a body, not on its stress.
        material.damping = None;
        for criterion in &mut material.failures {
            match &mut criterion.evolution {
                DamageEvolution::Displacement(value) | DamageEvolution::Energy(value) => {
                    *value *= size / self.request.length;
                }
                DamageEvolution::Strain(_, Some(length)) => *length *= size / self.request.length,
                DamageEvolution::Sudden | DamageEvolution::Absent | DamageEvolution::Strain(_, None) => {}
            }
        }
        material.strength.scale_displacements(size / self.request.length);
        model.materials = vec![material];
        model.settings = self.source.settings.clone();
        let prepared = job::prepare_model(&model, self.routines);
        let error = prepared.diagnostics.iter().find(|d| d.severity == Severity::Error).cloned();
        error.map_or(Ok(prepared), |error| Err(StudyError::from(error)))
    }

    /// Writes the deck that gives the stable time increment of an element of size 1.
    fn resting_deck(&self, duration: f64) -> String {
        let mut text = self.bodies(1.0);
        let _ = write!(text, "*Step\n*Dynamic, Explicit\n , {duration:?}\n");
        text += "*Boundary\n ALL, 1, 2\n*Output, history, frequency=1\n\
                 *Energy Output\n ALLKE\n*End Step\n";
        text
    }

    /// Writes the deck of a run: the top moves so that the true strain rate is constant; the side is free.
    fn deck(&self, size: f64) -> String {
        let (rate, strain) = (self.rate, self.request.strain);
        let mut text = self.bodies(size);
        text += "*Amplitude, name=VELOCITY\n";
        for i in 0..=VELOCITY_POINTS {
            let reached = strain * f64::from(i) / f64::from(VELOCITY_POINTS);
            let _ = writeln!(text, " {:?}, {:?}", reached / rate, libm::exp(reached));
        }
        let velocity = rate * size;
        let lateral = -self.poisson() * velocity;
        let adiabatic = if self.request.adiabatic { ", adiabatic" } else { "" };
        let _ = write!(
            text,
            "*Initial Conditions, type=VELOCITY\n TOP, 2, {velocity:?}\n SIDE, 1, {lateral:?}\n\
             *Step\n*Dynamic, Explicit{adiabatic}\n , {:?}\n*Boundary\n BOTTOM, 2, 2\n AXIS, 1, 1\n\
             *Boundary, type=VELOCITY, amplitude=VELOCITY\n TOP, 2, 2, {velocity:?}\n\
             *Output, history, number interval={POINTS}\n*Element Output, elset=ONE\n S22, LE22, PEEQ, TEMP, STATUS\n\
             *End Step\n",
            strain / rate
        );
        text
    }

    /// Writes nodes, the element and initial temperatures. The material is replaced in the model.
    fn bodies(&self, size: f64) -> String {
        let mut text = format!(
            "*Node, nset=ALL\n 1, 0., 0.\n 2, {size:?}, 0.\n 3, {size:?}, {size:?}\n 4, 0., {size:?}\n\
             *Nset, nset=BOTTOM\n 1, 2\n*Nset, nset=TOP\n 3, 4\n*Nset, nset=AXIS\n 1, 4\n*Nset, nset=SIDE\n 2, 3\n\
             *Element, type=CAX4R, elset=ONE\n 1, 1, 2, 3, 4\n*Solid Section, elset=ONE, material=M\n\
             *Material, name=M\n*Density\n 1.,\n*Elastic\n 1., 0.\n"
        );
        if let Some(temperature) = self.temperature {
            let _ = write!(text, "*Initial Conditions, type=TEMPERATURE\n ALL, {temperature:?}\n");
        }
        text
    }

    /// Returns the initial Poisson's ratio, with which the side moves at the start.
    fn poisson(&self) -> f64 {
        match (self.material.elastic, self.material.bulk_modulus(None), self.material.shear_modulus) {
            (Some([_, poisson]), ..) => poisson,
            (None, Some(bulk), Some(shear)) => (3.0 * bulk - 2.0 * shear) / (2.0 * (3.0 * bulk + shear)),
            _ if self.material.hyperelastic.is_some() => 0.48,
            _ => 0.3,
        }
    }
}

/// Reads the points of a curve, and the strain at which the element is deleted.
fn points(history: &RunHistory, rate: f64) -> (Vec<TensionPoint>, Option<f64>) {
    let column = |name: &str| history.columns.iter().position(|c| c.split('@').next() == Some(name));
    let [stress, strain, plastic, temperature, status] = ["S22", "LE22", "PEEQ", "TEMP", "STATUS"].map(column);
    let mut points = Vec::new();
    for (row, time) in history.times().iter().enumerate() {
        let value = |column: Option<usize>, absent: f64| column.map_or(absent, |column| history.cell(row, column));
        if value(status, 1.0) < 0.5 {
            return (points, Some(time * rate));
        }
        let point = TensionPoint {
            strain: value(strain, time * rate),
            stress: value(stress, f64::NAN),
            plastic: value(plastic, f64::NAN),
            temperature: value(temperature, f64::NAN),
        };
        if point.stress.is_finite() {
            points.push(point);
        }
    }
    (points, None)
}

/// Returns the table of a material: stress at the strains up to the end, yield stress, softening and failure.
pub fn table(named: &[(String, Vec<TensionCurve>)], end: f64, units: Option<&DeckUnits>) -> TextTable {
    let unit = |name: &str, powers: [i32; 4]| units.map_or(name.to_owned(), |u| format!("{name} {}", u.name(powers)));
    let strains: Vec<f64> = STRAINS.into_iter().filter(|s| *s <= end * (1.0 + 1e-9)).collect();
    let mut header = vec!["material".to_owned(), unit("rate", [0, 0, -1, 0])];
    header.push(units.map_or("temperature".into(), |u| format!("temperature {}", u.temperature)));
    header.push(unit("yield 0.2 %", [-1, 1, -2, 0]));
    header.extend(strains.iter().map(|strain| format!("at {strain}")));
    header.extend(["softens at".to_owned(), "fails at".to_owned()]);
    let cell = |value: Option<f64>| value.map_or("-".to_owned(), |v| digits(v, 4));
    let row = |(name, curve): (&String, &TensionCurve)| {
        let mut row = vec![name.clone(), digits(curve.rate, 6), cell(curve.temperature), cell(curve.yield_stress())];
        row.extend(strains.iter().map(|&strain| cell(curve.stress_at(strain))));
        row.extend([cell(curve.softening_strain()), cell(curve.failure)]);
        row
    };
    let rows = named.iter().flat_map(|(name, curves)| curves.iter().map(move |c| (name, c))).map(row).collect();
    TextTable { header, rows }
}

/// Returns all points of all curves, with all digits.
pub fn point_table(named: &[(String, Vec<TensionCurve>)]) -> TextTable {
    let header = ["material", "rate", "initial temperature", "true strain", "true stress", "PEEQ", "TEMP"];
    let cell = |value: f64| if value.is_nan() { String::new() } else { format!("{value:?}") };
    let row = |name: &str, curve: &TensionCurve, p: &TensionPoint| {
        let start = curve.temperature.unwrap_or(f64::NAN);
        let numbers = [curve.rate, start, p.strain, p.stress, p.plastic, p.temperature];
        [name.to_owned()].into_iter().chain(numbers.map(cell)).collect()
    };
    let mut rows = Vec::new();
    for (name, curve) in named.iter().flat_map(|(name, curves)| curves.iter().map(move |c| (name, c))) {
        rows.extend(curve.points.iter().map(|point| row(name, curve, point)));
    }
    TextTable { header: header.map(String::from).into(), rows }
}

/// Returns the chart of a material, with one line per rate and temperature.
pub fn chart(name: &str, curves: &[TensionCurve], units: Option<&DeckUnits>) -> Chart {
    let line = |curve: &TensionCurve| {
        let points = curve.points.iter().map(|p| (p.strain, p.stress)).collect();
        ChartSeries::new(curve.label(units), SeriesForm::Line, points)
    };
    let stress = units.map_or(String::new(), |u| u.name([-1, 1, -2, 0]));
    let series = curves.iter().map(line).collect();
    Chart { units: [String::new(), stress], ..Chart::new(&format!("{name} in uniaxial tension"), AXES, series) }
}

/// Returns the curves of materials, and those of strength over pressure, as a JSON object; numbers that a material does not
/// have are null.
pub fn record(named: &[(String, Vec<TensionCurve>)], strengths: &[StrengthCurves]) -> Value {
    let materials: Vec<Value> = named.iter().map(|(name, curves)| json!({ "name": name, "curves": curves })).collect();
    if strengths.is_empty() {
        json!({ "materials": materials })
    } else {
        json!({ "materials": materials, "strengths": strengths })
    }
}
