//! `revolve resistance`.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant as Stopwatch;

use clap::Args;

use super::words::{self, say, tell};
use super::{AlreadyPrinted, PictureFormat, Status, pairs, print_findings, print_table};
use crate::deck::Diagnostic;
use crate::model::derive::target_of;
use crate::output::{self, csv};
use crate::resistance::fit::Weight;
use crate::resistance::rate::{Factor, Rate};
use crate::resistance::similarity::Expansion;
use crate::resistance::{Curve, Material, Request, ResistanceError, Target, derive};
use crate::study::expansion;
use crate::study::law::ResistanceRecord;
use crate::{deck, model};

/// Derive the resistance of a target, A, B and C of *CAVITY EXPANSION, from its stress-strain curve.
#[derive(Args)]
pub struct Resistance {
    /// Deck with the material; without one the options below describe it.
    deck: Option<PathBuf>,
    /// Which material of the deck; needed where it has several.
    #[arg(short, long, requires = "deck", value_name = "NAME")]
    material: Option<String>,
    /// Replace the value of a *PARAMETER of the deck: NAME=VALUE.
    #[arg(short, long = "set", requires = "deck", value_name = "NAME=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    given: MaterialArguments,
    /// Largest tension: beyond it the target cracks along rays, as concrete does.
    #[arg(long, value_name = "STRESS")]
    tension: Option<f64>,
    /// Radius of the cavity, with which strain rates count.
    #[arg(long, value_name = "LENGTH")]
    radius: Option<f64>,
    /// Lowest velocity of the fit.
    #[arg(long, value_name = "VELOCITY", default_value_t = 0.0)]
    from: f64,
    /// Highest velocity of the fit.
    #[arg(long, value_name = "VELOCITY")]
    to: f64,
    /// Velocities at equal steps.
    #[arg(long, default_value_t = crate::resistance::derive::POINTS)]
    points: usize,
    /// Constants of the law: 3, or 2 for B = 0.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u8).range(2..=3))]
    terms: u8,
    /// A is the pressure at rest instead of being fitted.
    #[arg(long = "static")]
    pinned: bool,
    /// What the fit looks at.
    #[arg(long, value_enum, default_value_t = Weight::Even)]
    weight: Weight,
    /// Measure the pressure as well, on a meshed cavity that is opened at these velocities (default: a quarter, a half and all of
    /// the highest).
    #[arg(long, value_name = "VELOCITIES", num_args = 0..=1, require_equals = true, value_delimiter = ',')]
    measure: Option<Vec<f64>>,
    /// Picture of pressures and law, .png or .svg.
    #[arg(long, value_name = "FILE")]
    chart: Option<PathBuf>,
    /// Write the card into a file, for *INCLUDE below the *MATERIAL.
    #[arg(long, value_name = "FILE")]
    card: Option<PathBuf>,
    /// Print all of it as JSON, and nothing else.
    #[arg(long)]
    json: bool,
    /// Print the card alone.
    #[arg(short, long, conflicts_with = "json")]
    quiet: bool,
}

/// A material without a deck.
#[derive(Args)]
struct MaterialArguments {
    /// Young's modulus.
    #[arg(long, value_name = "STRESS", conflicts_with = "deck", required_unless_present = "deck")]
    young: Option<f64>,
    /// Poisson's ratio; 0.5 is incompressible.
    #[arg(long, value_name = "RATIO", conflicts_with = "deck", required_unless_present = "deck")]
    poisson: Option<f64>,
    /// Mass per volume.
    #[arg(long, value_name = "DENSITY", conflicts_with = "deck", required_unless_present = "deck")]
    density: Option<f64>,
    /// Yield stress Y; with --table the first stress there.
    #[arg(long = "yield", value_name = "STRESS", conflicts_with_all = ["deck", "table"], required_unless_present_any = ["deck", "table"])]
    yield_stress: Option<f64>,
    /// Hardening Y (E e / Y)^n over the total strain e.
    #[arg(long, value_name = "N", conflicts_with_all = ["deck", "table"])]
    power: Option<f64>,
    /// CSV file of yield stress and plastic strain, as the rows of *PLASTIC.
    #[arg(long, value_name = "FILE", conflicts_with = "deck")]
    table: Option<PathBuf>,
    /// Growth of the yield stress with pressure (Mohr and Coulomb).
    #[arg(long, value_name = "SLOPE", conflicts_with = "deck", default_value_t = 0.0)]
    pressure_slope: f64,
    /// Factor 1 + (e'/REFERENCE)^EXPONENT of the strain rate e'.
    #[arg(
        long,
        value_name = "REFERENCE,EXPONENT",
        value_delimiter = ',',
        num_args = 1,
        requires = "radius",
        conflicts_with = "deck"
    )]
    rate: Vec<f64>,
    /// Factor 1 + C ln(e'/REFERENCE), as of Johnson and Cook.
    #[arg(long, value_name = "C,REFERENCE", value_delimiter = ',', num_args = 1, requires = "radius", conflicts_with_all = ["deck", "rate"])]
    rate_johnson_cook: Vec<f64>,
}

/// Pressure over the yield stress at a velocity, by similarity.
type PressureAt<'a> = dyn Fn(f64) -> Option<f64> + 'a;

/// Steps in which a curve is drawn.
const DRAWN: u32 = 120;

impl Resistance {
    pub fn execute(self) -> Result<Status, Box<dyn Error>> {
        let format = self.chart.as_deref().map(PictureFormat::of).transpose()?;
        let material = match &self.deck {
            Some(deck) => self.of_deck(deck)?,
            None => self.given.material(self.tension, self.radius)?,
        };
        let begin = Stopwatch::now();
        let target = Target::new(&material).map_err(|fault| finding(&fault))?;
        let derived = derive(&target, &self.request()).map_err(|fault| finding(&fault))?;
        let seconds = begin.elapsed().as_secs_f64();
        let measured = match &self.measure {
            Some(velocities) => {
                let default = [0.25, 0.5, 1.0].map(|share| share * self.to);
                expansion::measure(&material, if velocities.is_empty() { &default } else { velocities })?
            }
            None => Vec::new(),
        };
        let record = ResistanceRecord::new(&target, &self.request(), &derived, measured, seconds);
        let expansion = Expansion::new(&target).map_err(|fault| fault.to_string())?;
        let similar = |v: f64| expansion.pressure(v).ok().map(|p| p.stress);
        self.write(&record, format, &target, &similar)?;
        self.print(&record, &similar)?;
        Ok(super::shown())
    }

    fn request(&self) -> Request {
        Request {
            range: [self.from, self.to],
            points: self.points,
            linear: self.terms == 3,
            pinned: self.pinned,
            weight: self.weight,
        }
    }

    fn of_deck(&self, path: &Path) -> Result<Material, Box<dyn Error>> {
        let (deck, mut diagnostics) = deck::read(path, &pairs(&self.set)?);
        let (model, found) = model::build(&deck);
        diagnostics.append(found);
        if diagnostics.has_errors() {
            print_findings(&diagnostics, &deck.sources);
            return Err(AlreadyPrinted.into());
        }
        let names: Vec<&str> = model.materials.iter().map(|m| &m.name[..]).collect();
        let wanted = match (&self.material, &names[..]) {
            (Some(name), _) => name.to_uppercase(),
            (None, [only]) => (*only).to_owned(),
            (None, _) => {
                return Err(format!("--material: the deck has the materials {}; which?", names.join(", ")).into());
            }
        };
        let Some(material) = model.materials.iter().find(|m| m.name == wanted) else {
            return Err(format!("--material {wanted}: the deck has {}", names.join(", ")).into());
        };
        if material.rate.is_some() && self.radius.is_none() {
            tell!("warning: the *RATE DEPENDENT of {wanted} does not count without --radius");
        }
        target_of(material, self.radius, self.tension).map_err(|finding| {
            let mut findings = deck::Diagnostics::default();
            findings.push(finding);
            print_findings(&findings, &deck.sources);
            AlreadyPrinted.into()
        })
    }

    fn write(
        &self,
        record: &ResistanceRecord,
        format: Option<PictureFormat>,
        target: &Target,
        similar: &PressureAt<'_>,
    ) -> Result<(), Box<dyn Error>> {
        if let (Some(path), Some(format)) = (&self.chart, format) {
            let at = |i: u32| self.from + (self.to - self.from) * f64::from(i) / f64::from(DRAWN);
            let points: Vec<(f64, f64)> = (0..=DRAWN).map(at).filter_map(|v| Some((v, similar(v)?))).collect();
            let chart = record.chart("Pressure on an expanding cavity", target, &points);
            output::write_whole(path, &format.bytes(&chart.drawing()?)?)?;
        }
        if let Some(path) = &self.card {
            output::write_whole(path, record.card.as_bytes())?;
        }
        Ok(())
    }

    fn print(&self, record: &ResistanceRecord, similar: &PressureAt<'_>) -> Result<(), Box<dyn Error>> {
        if self.json {
            say!("{}", serde_json::to_string_pretty(record)?);
            return Ok(());
        }
        if !self.quiet {
            print_table(&record.table());
            if !record.measured.is_empty() {
                print_table(&record.measured_table(similar));
            }
            record.conclusions().iter().for_each(|line| say!("{line}"));
            say!("{} pressures and the fit: {:.1} ms", record.points.len(), 1e3 * record.seconds);
            self.chart.iter().for_each(|path| say!("picture {}", path.display()));
            self.card.iter().for_each(|path| say!("card {}", path.display()));
        }
        words::write(format_args!("{}", record.card), false);
        Ok(())
    }
}

/// A fault as a finding without a place.
fn finding(fault: &ResistanceError) -> Diagnostic {
    Diagnostic::error(fault.code(), fault.to_string())
}

impl MaterialArguments {
    fn material(&self, tension: Option<f64>, radius: Option<f64>) -> Result<Material, Box<dyn Error>> {
        let (curve, first) = match (&self.table, self.power) {
            (Some(path), _) => {
                let rows = rows(path)?;
                let first = rows.first().map_or(f64::NAN, |r| r[0]);
                (Curve::Table { rows, extrapolates: false }, first)
            }
            (None, Some(n)) => (Curve::Power(n), f64::NAN),
            (None, None) => (Curve::Perfect, f64::NAN),
        };
        // The arguments are there: nothing is derived without a deck or these.
        let there = |value: Option<f64>| value.unwrap_or(f64::NAN);
        Ok(Material {
            young: there(self.young),
            poisson: there(self.poisson),
            density: there(self.density),
            yield_stress: self.yield_stress.unwrap_or(first),
            curve,
            pressure_slope: self.pressure_slope,
            tension,
            rate: self.factor()?.zip(radius).map(|(factor, radius)| Rate { factor, radius }),
        })
    }

    fn factor(&self) -> Result<Option<Factor>, String> {
        match (&self.rate[..], &self.rate_johnson_cook[..]) {
            ([], []) => Ok(None),
            (&[reference, exponent], []) => Ok(Some(Factor::Power { reference, exponent })),
            ([], &[c, reference]) => Ok(Some(Factor::JohnsonCook { c, reference })),
            _ => Err("--rate and --rate-johnson-cook take two numbers: --rate 8e5,0.3".into()),
        }
    }
}

/// Rows of stress and plastic strain; a first line of words is a header.
fn rows(path: &Path) -> Result<Vec<[f64; 2]>, Box<dyn Error>> {
    let wrong = |what: String| format!("--table {}: {what}", path.display());
    let text = std::fs::read_to_string(path).map_err(|e| wrong(e.to_string()))?;
    let mut rows = Vec::new();
    for (number, line) in csv::lines(&text) {
        let fields: Result<Vec<f64>, _> = line.split(',').map(|f| f.trim().parse::<f64>()).collect();
        match fields.as_deref() {
            Ok(&[stress, strain]) => rows.push([stress, strain]),
            Err(_) if rows.is_empty() && number == 1 => {}
            _ => return Err(wrong(format!("line {number}: `{line}` is not a stress and a plastic strain")).into()),
        }
    }
    if rows.is_empty() {
        return Err(wrong("there are no rows".into()).into());
    }
    Ok(rows)
}
