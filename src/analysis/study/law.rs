//! Output of a computed resistance: table, JSON with stable keys, picture, and a card for `*INCLUDE`.

use serde::Serialize;

use super::chart::{Chart, ChartSeries, SeriesForm};
use super::expansion::MeasuredPressure;
use super::table::TextTable;
use crate::resistance::fit::law;
use crate::resistance::{CavityShape, DerivedResistance, FitRequest, TargetScale};

/// JSON object printed by `revolve resistance --json`. The keys are stable. Velocities are in the units of the
/// material, pressures are divided by Y.
#[derive(Clone, Debug, Serialize)]
pub struct ResistanceRecord {
    /// `spherical` or `cylindrical`.
    pub shape: &'static str,
    pub yield_stress: f64,
    pub density: f64,
    /// Constants A, B, C as on the card (dimensionless).
    pub constants: [f64; 3],
    /// Half-widths of the 95 % confidence intervals; `null` for constants that were not fitted.
    pub half_widths: [Option<f64>; 3],
    pub range: [f64; 2],
    /// Weighted rms difference between law and pressures, divided by Y.
    pub residual: f64,
    /// Largest relative difference, and its velocity.
    pub worst: [f64; 2],
    /// Quasi-static pressure divided by Y.
    pub still: f64,
    pub points: Vec<PressureRow>,
    /// Pressures computed with finite elements; absent without `--measure`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub measured: Vec<MeasuredPressure>,
    /// Seconds spent on the pressures and the fit.
    pub seconds: f64,
    pub card: String,
    pub version: &'static str,
}

#[derive(Clone, Copy, Debug, Serialize)]
pub struct PressureRow {
    /// Velocity of the cavity wall.
    pub velocity: f64,
    pub pressure: f64,
    pub law: f64,
    /// Radius of the plastic front divided by the cavity radius.
    pub plastic: f64,
    /// Radius of the crack front divided by the cavity radius.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cracked: Option<f64>,
}

impl ResistanceRecord {
    /// Collects the derived law and the pressures computed with finite elements.
    pub fn new(
        target: TargetScale,
        request: &FitRequest,
        derived: &DerivedResistance,
        measured: Vec<MeasuredPressure>,
        seconds: f64,
    ) -> ResistanceRecord {
        let row = |p: &crate::resistance::similarity::CavityPressure| PressureRow {
            velocity: p.velocity,
            pressure: p.stress,
            law: law(derived.constants, p.velocity / target.velocity()),
            plastic: p.plastic,
            cracked: p.cracked,
        };
        ResistanceRecord {
            shape: target.shape.word(),
            yield_stress: target.yield_stress,
            density: target.density,
            constants: derived.constants,
            half_widths: derived.fit.half_widths,
            range: request.range,
            residual: derived.fit.residual,
            worst: derived.worst,
            still: derived.static_pressure,
            points: derived.points.iter().map(row).collect(),
            measured,
            seconds,
            card: card(target, request, derived),
            version: env!("CARGO_PKG_VERSION"),
        }
    }

    pub fn table(&self) -> TextTable {
        let cracks = self.points.iter().any(|p| p.cracked.is_some());
        let mut header: Vec<String> =
            ["velocity", "pressure/Y", "law", "difference", "plastic front/a"].map(String::from).into();
        header.extend(cracks.then(|| "cracks/a".to_owned()));
        let row = |p: &PressureRow| {
            let mut row = vec![
                format!("{:.6}", p.velocity).trim_end_matches('0').trim_end_matches('.').to_owned(),
                format!("{:.4}", p.pressure),
                format!("{:.4}", p.law),
                format!("{:+.2} %", 100.0 * (p.law / p.pressure - 1.0)),
                format!("{:.3}", p.plastic),
            ];
            row.extend(cracks.then(|| p.cracked.map_or(String::new(), |c| format!("{c:.3}"))));
            row
        };
        TextTable { header, rows: self.points.iter().map(row).collect() }
    }

    pub fn measured_table(&self, similar: &dyn Fn(f64) -> Option<f64>) -> TextTable {
        let header = ["velocity", "measured/Y", "uncertainty", "order", "similar", "difference"].map(String::from);
        let row = |m: &MeasuredPressure| {
            let exact = similar(m.velocity);
            vec![
                m.velocity.to_string(),
                format!("{:.4}", m.estimate.limit),
                format!("{:.4}", m.uncertainty()),
                m.estimate.order.map_or(m.estimate.behaviour.word().into(), |order| format!("{order:.2}")),
                exact.map_or(String::new(), |e| format!("{e:.4}")),
                exact.map_or(String::new(), |e| format!("{:+.3} %", 100.0 * (m.estimate.limit / e - 1.0))),
            ]
        };
        TextTable { header: header.into(), rows: self.measured.iter().map(row).collect() }
    }

    /// Returns the results of the fit as lines of text.
    pub fn conclusions(&self) -> Vec<String> {
        let each = |(name, (value, half)): (&str, (&f64, &Option<f64>))| match half {
            Some(half) => format!("{name} = {value} ± {half:.2e}"),
            None => format!("{name} = {value}"),
        };
        let constants: Vec<String> =
            ["A", "B", "C"].into_iter().zip(self.constants.iter().zip(&self.half_widths)).map(each).collect();
        vec![
            format!("{} (95 % confidence intervals by Student's t)", constants.join(", ")),
            format!(
                "velocities {} to {}: rms residual {:.2e} Y, largest deviation {:+.2} % (at {}); quasi-static pressure {}",
                self.range[0],
                self.range[1],
                self.residual,
                100.0 * self.worst[0],
                self.worst[1],
                still(self.still)
            ),
        ]
    }

    /// Returns the chart of the similarity solution (`pressures`), the fitted law and the finite-element results.
    pub fn chart(&self, title: &str, target: TargetScale, pressures: &[(f64, f64)]) -> Chart {
        let [a, b, c] = self.constants;
        let fitted = |p: &(f64, f64)| (p.0, law(self.constants, p.0 / target.velocity()));
        let mut series = vec![
            ChartSeries::new("similarity solution", SeriesForm::Line, pressures.to_vec()),
            ChartSeries::new(
                format!("A = {a}, B = {b}, C = {c}"),
                SeriesForm::Guide,
                pressures.iter().map(fitted).collect(),
            ),
        ];
        if !self.measured.is_empty() {
            let points = self.measured.iter().map(|m| (m.velocity, m.estimate.limit)).collect();
            let widest = self.measured.iter().map(|m| m.uncertainty() / m.estimate.limit).fold(0.0, f64::max);
            let name = format!("finite elements, ± {:.2} %", 100.0 * widest);
            series.push(ChartSeries::new(name, SeriesForm::Marks, points));
        }
        Chart::new(title, ["velocity of the cavity wall", "pressure / yield stress"], series)
    }
}

/// Returns the pressure at rest as text; a target that softens may have none.
fn still(pressure: f64) -> String {
    if pressure.is_nan() { "not defined".into() } else { format!("{pressure:.4} Y") }
}

/// Writes the card; it belongs below a `*MATERIAL` with `*DENSITY`.
fn card(target: TargetScale, request: &FitRequest, derived: &DerivedResistance) -> String {
    let [a, b, c] = derived.constants;
    format!(
        "** {} cavity expansion, velocities {} to {}, density {}\n\
         ** rms residual {:.2e} Y, largest deviation {:+.2} % (at {}); quasi-static pressure {}\n\
         *Cavity Expansion, yield={:?}\n {a:?}, {b:?}, {c:?}\n",
        match target.shape {
            CavityShape::Spherical => "Spherical",
            CavityShape::Cylindrical => "Cylindrical",
        },
        request.range[0],
        request.range[1],
        target.density,
        derived.fit.residual,
        100.0 * derived.worst[0],
        derived.worst[1],
        still(derived.static_pressure),
        target.yield_stress
    )
}
