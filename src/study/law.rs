//! A derived resistance as table, JSON with stable keys, picture, and a card to include.

use serde::Serialize;

use super::chart::{Chart, Form, Series};
use super::expansion::MeasuredPressure;
use super::table::Table;
use crate::resistance::fit::law;
use crate::resistance::{Derived, Request, Target};

/// What `revolve resistance --json` prints. The keys are stable; velocities are those of the material's units, pressures over Y.
#[derive(Clone, Debug, Serialize)]
pub struct ResistanceRecord {
    pub yield_stress: f64,
    pub density: f64,
    /// A, B, C as the card has them.
    pub constants: [f64; 3],
    /// Halves of the 95 % intervals; `null` of what was not fitted.
    pub half_widths: [Option<f64>; 3],
    pub range: [f64; 2],
    /// Root of the weighted mean square of the differences, over Y.
    pub residual: f64,
    /// The largest relative difference, and the velocity there.
    pub worst: [f64; 2],
    /// Pressure at rest over Y.
    pub still: f64,
    pub points: Vec<Row>,
    /// Measured pressures; absent where none were asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub measured: Vec<MeasuredPressure>,
    /// Seconds that the pressures and the fit took.
    pub seconds: f64,
    pub card: String,
    pub version: &'static str,
}

#[derive(Clone, Copy, Debug, Serialize)]
pub struct Row {
    /// Velocity at which the cavity opens.
    pub velocity: f64,
    pub pressure: f64,
    pub law: f64,
    /// Radius of the plastic front over the cavity's.
    pub plastic: f64,
    /// Radius of the front of cracks over the cavity's.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cracked: Option<f64>,
}

impl ResistanceRecord {
    /// Of what was derived, and measured.
    pub fn new(
        target: &Target,
        request: &Request,
        derived: &Derived,
        measured: Vec<MeasuredPressure>,
        seconds: f64,
    ) -> ResistanceRecord {
        let row = |p: &crate::resistance::similarity::Point| Row {
            velocity: p.velocity,
            pressure: p.stress,
            law: law(derived.constants, p.velocity / target.velocity),
            plastic: p.plastic,
            cracked: p.cracked,
        };
        ResistanceRecord {
            yield_stress: target.yield_stress,
            density: target.density,
            constants: derived.constants,
            half_widths: derived.fit.half_widths,
            range: request.range,
            residual: derived.fit.residual,
            worst: derived.worst,
            still: derived.still,
            points: derived.points.iter().map(row).collect(),
            measured,
            seconds,
            card: card(target, request, derived),
            version: env!("CARGO_PKG_VERSION"),
        }
    }

    pub fn table(&self) -> Table {
        let cracks = self.points.iter().any(|p| p.cracked.is_some());
        let mut header: Vec<String> =
            ["velocity", "pressure/Y", "law", "difference", "plastic front/a"].map(String::from).into();
        header.extend(cracks.then(|| "cracks/a".to_owned()));
        let row = |p: &Row| {
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
        Table { header, rows: self.points.iter().map(row).collect() }
    }

    pub fn measured_table(&self, similar: &dyn Fn(f64) -> Option<f64>) -> Table {
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
        Table { header: header.into(), rows: self.measured.iter().map(row).collect() }
    }

    /// What the fit came to, line by line.
    pub fn conclusions(&self) -> Vec<String> {
        let each = |(name, (value, half)): (&str, (&f64, &Option<f64>))| match half {
            Some(half) => format!("{name} = {value} ± {half:.2e}"),
            None => format!("{name} = {value}"),
        };
        let constants: Vec<String> =
            ["A", "B", "C"].into_iter().zip(self.constants.iter().zip(&self.half_widths)).map(each).collect();
        vec![
            format!("{} (95 % by Student's t)", constants.join(", ")),
            format!(
                "over velocities {} to {}: residual {:.2e} Y, at most {:+.2} % off (at {}); at rest the pressure is {:.4} Y",
                self.range[0],
                self.range[1],
                self.residual,
                100.0 * self.worst[0],
                self.worst[1],
                self.still
            ),
        ]
    }

    /// The picture: pressures at velocities that lie close, the law, and what was measured.
    pub fn chart(&self, title: &str, target: &Target, pressures: &[(f64, f64)]) -> Chart {
        let [a, b, c] = self.constants;
        let fitted = |p: &(f64, f64)| (p.0, law(self.constants, p.0 / target.velocity));
        let mut series = vec![
            Series::new("similarity solution", Form::Line, pressures.to_vec()),
            Series::new(format!("A = {a}, B = {b}, C = {c}"), Form::Guide, pressures.iter().map(fitted).collect()),
        ];
        if !self.measured.is_empty() {
            let points = self.measured.iter().map(|m| (m.velocity, m.estimate.limit)).collect();
            let widest = self.measured.iter().map(|m| m.uncertainty() / m.estimate.limit).fold(0.0, f64::max);
            let name = format!("finite elements, ± {:.2} %", 100.0 * widest);
            series.push(Series::new(name, Form::Marks, points));
        }
        Chart::new(title, ["velocity of the cavity", "pressure / yield stress"], series)
    }
}

/// The card, for below a `*MATERIAL` with its `*DENSITY`.
fn card(target: &Target, request: &Request, derived: &Derived) -> String {
    let [a, b, c] = derived.constants;
    format!(
        "** Expansion of a spherical cavity at velocities {} to {}, density {}\n\
         ** residual {:.2e} Y, at most {:+.2} % off (at {}); at rest {:.4} Y\n\
         *Cavity Expansion, yield={:?}\n {a:?}, {b:?}, {c:?}\n",
        request.range[0],
        request.range[1],
        target.density,
        derived.fit.residual,
        100.0 * derived.worst[0],
        derived.worst[1],
        derived.still,
        target.yield_stress
    )
}
