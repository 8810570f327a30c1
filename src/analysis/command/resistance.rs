//! The command `revolve resistance`: constants of `*CAVITY EXPANSION` from a stress-strain curve.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Instant as Stopwatch;

use clap::{Args, ValueEnum};

use super::options::OutputOptions;
use super::words::{self, print_err, print_out};
use super::{
    AlreadyPrinted, CommandStatus, PictureFormat, pairs, print_findings, print_table, print_unit_warnings, read_model,
};
use crate::deck::{Diagnostic, Diagnostics, Sources};
use crate::model::MaterialDefinition;
use crate::model::derive::{depends_on_rate, expansion_target, has_law, target_of};
use crate::output::{self, csv};
use crate::resistance::fit::FitWeight;
use crate::resistance::rate::{StrainRateEffect, StrainRateFactor};
use crate::resistance::{
    CavityShape, ExpansionTarget, FitRequest, ResistanceError, ScaledTarget, TargetMaterial, TargetScale, TargetSizes,
    YieldCurve, derive,
};
use crate::study::expansion::{self, MeasuredMaterial};
use crate::study::law::ResistanceRecord;

/// Values of `--type`.
#[derive(Clone, Copy, ValueEnum)]
enum ShapeArgument {
    /// Sphere in an unbounded target: deep penetration.
    Spherical,
    /// Cylinder in plane strain: hole expansion in plates by slender noses.
    Cylindrical,
}

impl From<ShapeArgument> for CavityShape {
    fn from(shape: ShapeArgument) -> CavityShape {
        match shape {
            ShapeArgument::Spherical => CavityShape::Spherical,
            ShapeArgument::Cylindrical => CavityShape::Cylindrical,
        }
    }
}

/// Values of `--weight`.
#[derive(Clone, Copy, ValueEnum)]
enum WeightArgument {
    /// Equal weights.
    Even,
    /// Relative differences (weight 1/pressure²).
    Relative,
    /// Weight proportional to velocity: the depth is the integral of m V / F over V.
    Velocity,
}

impl From<WeightArgument> for FitWeight {
    fn from(weight: WeightArgument) -> FitWeight {
        match weight {
            WeightArgument::Even => FitWeight::Even,
            WeightArgument::Relative => FitWeight::Relative,
            WeightArgument::Velocity => FitWeight::Velocity,
        }
    }
}

/// Compute the constants A, B and C of *CAVITY EXPANSION from the stress-strain curve of a target.
#[derive(Args)]
pub struct ResistanceCommand {
    /// Deck that defines the material; without a deck the material is given by the options below.
    deck: Option<PathBuf>,
    /// Material name; required if the deck has several materials.
    #[arg(short, long, requires = "deck", value_name = "NAME")]
    material: Option<String>,
    /// Override a *PARAMETER of the deck: NAME=VALUE; can be repeated.
    #[arg(short, long = "set", requires = "deck", value_name = "NAME=VALUE")]
    set: Vec<String>,
    #[command(flatten)]
    given: MaterialArguments,
    /// Shape of the cavity: a sphere for deep penetration, a cylinder for the expansion of a hole in a plate.
    #[arg(long = "type", value_name = "SHAPE", default_value = "spherical")]
    shape: ShapeArgument,
    /// Tensile strength; above it the target has radial cracks, as concrete does.
    #[arg(long, value_name = "STRESS")]
    tension: Option<f64>,
    /// Radius of the cavity; required for strain-rate dependence.
    #[arg(long, value_name = "LENGTH")]
    radius: Option<f64>,
    /// Lowest velocity of the fit.
    #[arg(long, value_name = "VELOCITY", default_value_t = 0.0)]
    from: f64,
    /// Highest velocity of the fit.
    #[arg(long, value_name = "VELOCITY")]
    to: f64,
    /// Number of equally spaced velocities (default: 41; 9 for a law of strength over pressure).
    #[arg(long)]
    points: Option<usize>,
    /// Length of the elements whose softening over displacements the target has (*CONCRETE TENSION STIFFENING).
    #[arg(long, value_name = "LENGTH", requires = "deck")]
    length: Option<f64>,
    /// Number of fitted constants: 3, or 2 for B = 0.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u8).range(2..=3))]
    terms: u8,
    /// Set A to the quasi-static pressure instead of fitting it.
    #[arg(long = "static")]
    pinned: bool,
    /// Weights of the least-squares fit.
    #[arg(long, value_enum, default_value_t = WeightArgument::Even)]
    weight: WeightArgument,
    /// Also compute the pressure with finite elements, on a meshed cavity that opens at these velocities (default: 1/4,
    /// 1/2 and 1 times the highest velocity).
    #[arg(long, value_name = "VELOCITIES", num_args = 0..=1, require_equals = true, value_delimiter = ',')]
    measure: Option<Vec<f64>>,
    /// Write a picture of the pressures and the fitted law, .png or .svg.
    #[arg(long, value_name = "FILE")]
    chart: Option<PathBuf>,
    /// Write the *CAVITY EXPANSION card to a file, for *INCLUDE below *MATERIAL.
    #[arg(long, value_name = "FILE")]
    card: Option<PathBuf>,
    #[command(flatten)]
    output: OutputOptions,
}

/// Options that describe the material without a deck.
#[derive(Args)]
struct MaterialArguments {
    /// Young's modulus.
    #[arg(long, value_name = "STRESS", conflicts_with = "deck", required_unless_present = "deck")]
    young: Option<f64>,
    /// Poisson's ratio; 0.5 is incompressible.
    #[arg(long, value_name = "RATIO", conflicts_with = "deck", required_unless_present = "deck")]
    poisson: Option<f64>,
    /// Density.
    #[arg(long, value_name = "DENSITY", conflicts_with = "deck", required_unless_present = "deck")]
    density: Option<f64>,
    /// Yield stress Y at zero pressure; with --table it is the first stress of the table. With --pressure-slope, Y is
    /// (1 - SLOPE/3) times the yield stress in uniaxial compression, where the pressure is a third of the stress.
    #[arg(long = "yield", value_name = "STRESS", conflicts_with_all = ["deck", "table"], required_unless_present_any = ["deck", "table"])]
    yield_stress: Option<f64>,
    /// Exponent n of the power-law hardening Y (E e / Y)^n, with the total strain e.
    #[arg(long, value_name = "N", conflicts_with_all = ["deck", "table"])]
    power: Option<f64>,
    /// CSV file with rows of yield stress and plastic strain, as in *PLASTIC.
    #[arg(long, value_name = "FILE", conflicts_with = "deck")]
    table: Option<PathBuf>,
    /// Slope of the yield stress over pressure (Mohr-Coulomb): yield stress = Y + SLOPE p.
    #[arg(long, value_name = "SLOPE", conflicts_with = "deck", default_value_t = 0.0)]
    pressure_slope: f64,
    /// Strain-rate factor 1 + (e'/REFERENCE)^EXPONENT of the yield stress.
    #[arg(
        long,
        value_name = "REFERENCE,EXPONENT",
        value_delimiter = ',',
        num_args = 1,
        requires = "radius",
        conflicts_with = "deck"
    )]
    rate: Vec<f64>,
    /// Johnson-Cook strain-rate factor 1 + C ln(e'/REFERENCE) of the yield stress.
    #[arg(long, value_name = "C,REFERENCE", value_delimiter = ',', num_args = 1, requires = "radius", conflicts_with_all = ["deck", "rate"])]
    rate_johnson_cook: Vec<f64>,
}

/// Target of the command, and its material for meshed cavities.
struct CommandTarget {
    target: Box<dyn ExpansionTarget>,
    material: MeasuredMaterial,
}

/// Function from velocity to the pressure of the similarity solution, divided by the yield stress.
type PressureAt<'a> = dyn Fn(f64) -> Option<f64> + 'a;

/// Number of intervals of a drawn curve.
const DRAWN: u32 = 120;

impl ResistanceCommand {
    pub fn execute(self) -> Result<CommandStatus, Box<dyn Error>> {
        let format = self.chart.as_deref().map(PictureFormat::of).transpose()?;
        let CommandTarget { target, material } = match &self.deck {
            Some(deck) => self.of_deck(deck)?,
            None => self.of_options()?,
        };
        let begin = Stopwatch::now();
        let derived = derive(&*target, &self.request()).map_err(|fault| finding(&fault))?;
        let seconds = begin.elapsed().as_secs_f64();
        let measured = match &self.measure {
            Some(velocities) => {
                let default = [0.25, 0.5, 1.0].map(|share| share * self.to);
                expansion::measure(
                    &material,
                    target.scale(),
                    if velocities.is_empty() { &default } else { velocities },
                )?
            }
            None => Vec::new(),
        };
        let scale = target.scale();
        let record = ResistanceRecord::new(scale, &self.request(), &derived, measured, seconds);
        let pressure = target.pressures().map_err(|fault| fault.to_string())?;
        let similar = |v: f64| pressure(v).ok().map(|p| p.stress);
        self.write(&record, format, scale, &similar)?;
        self.print(&record, &similar)?;
        Ok(super::output_status())
    }

    fn request(&self) -> FitRequest {
        FitRequest {
            range: [self.from, self.to],
            points: self.points,
            linear: self.terms == 3,
            pinned: self.pinned,
            weight: self.weight.into(),
        }
    }

    fn of_options(&self) -> Result<CommandTarget, Box<dyn Error>> {
        print_unit_warnings([&self.given.elastic()], None, &Sources::default());
        let material = TargetMaterial { shape: self.shape.into(), ..self.given.material(self.tension, self.radius)? };
        let target = ScaledTarget::new(&material).map_err(|fault| finding(&fault))?;
        Ok(CommandTarget { target: Box::new(target), material: MeasuredMaterial::Curve(material) })
    }

    fn of_deck(&self, path: &Path) -> Result<CommandTarget, Box<dyn Error>> {
        let (deck, model) = read_model(path, &pairs(&self.set)?)?;
        let names: Vec<&str> = model.materials.iter().map(|m| &m.name[..]).collect();
        let material_name = match (&self.material, &names[..]) {
            (Some(name), _) => name.to_uppercase(),
            (None, [only]) => (*only).to_owned(),
            (None, _) => {
                return Err(format!(
                    "the deck has several materials: give --material with one of {}",
                    names.join(", ")
                )
                .into());
            }
        };
        let Some(material) = model.materials.iter().find(|m| m.name == material_name) else {
            return Err(
                format!("--material {material_name}: no such material; the deck defines {}", names.join(", ")).into()
            );
        };
        print_unit_warnings([material], model.settings.units.as_ref(), &deck.sources);
        if depends_on_rate(material) && self.radius.is_none() {
            print_err!("warning: the strain rates of {material_name} are ignored without --radius");
        }
        let sizes =
            TargetSizes { shape: self.shape.into(), radius: self.radius, tension: self.tension, length: self.length };
        let found = expansion_target(material, &sizes).and_then(|target| {
            let material = if has_law(material) {
                MeasuredMaterial::Law(Box::new(material.clone()))
            } else {
                let curve = target_of(material, self.radius, self.tension)?;
                MeasuredMaterial::Curve(TargetMaterial { shape: sizes.shape, ..curve })
            };
            Ok(CommandTarget { target, material })
        });
        found.map_err(|finding| {
            print_findings(&Diagnostics::from_iter([finding]), &deck.sources);
            AlreadyPrinted.into()
        })
    }

    fn write(
        &self,
        record: &ResistanceRecord,
        format: Option<PictureFormat>,
        target: TargetScale,
        similar: &PressureAt<'_>,
    ) -> Result<(), Box<dyn Error>> {
        if let (Some(path), Some(format)) = (&self.chart, format) {
            let velocity_at = |i: u32| self.from + (self.to - self.from) * f64::from(i) / f64::from(DRAWN);
            let points: Vec<(f64, f64)> = (0..=DRAWN).map(velocity_at).filter_map(|v| Some((v, similar(v)?))).collect();
            let chart = record.chart("Pressure on an expanding cavity", target, &points);
            output::write_whole(path, &format.bytes(&chart.drawing()?)?)?;
        }
        if let Some(path) = &self.card {
            output::write_whole(path, record.card.as_bytes())?;
        }
        Ok(())
    }

    fn print(&self, record: &ResistanceRecord, similar: &PressureAt<'_>) -> Result<(), Box<dyn Error>> {
        if self.output.json {
            return Ok(self.output.print_json(record)?);
        }
        if !self.output.is_silent() {
            print_table(&record.table());
            if !record.measured.is_empty() {
                print_table(&record.measured_table(similar));
            }
            record.conclusions().iter().for_each(|line| print_out!("{line}"));
            print_out!("{} pressures and fit in {:.1} ms", record.points.len(), 1e3 * record.seconds);
            self.chart.iter().for_each(|path| print_out!("picture {}", path.display()));
            self.card.iter().for_each(|path| print_out!("card {}", path.display()));
        }
        words::write(format_args!("{}", record.card), false);
        Ok(())
    }
}

/// Converts an error into a diagnostic without a location.
fn finding(fault: &ResistanceError) -> Diagnostic {
    Diagnostic::error(fault.code(), fault.to_string())
}

impl MaterialArguments {
    /// Returns the elasticity and the density, for the check of units.
    fn elastic(&self) -> MaterialDefinition {
        let elastic = self.young.zip(self.poisson).map(|(young, poisson)| [young, poisson]);
        MaterialDefinition { name: "target".into(), elastic, density: self.density, ..MaterialDefinition::default() }
    }

    fn material(&self, tension: Option<f64>, radius: Option<f64>) -> Result<TargetMaterial, Box<dyn Error>> {
        let (curve, first) = match (&self.table, self.power) {
            (Some(path), _) => {
                let rows = rows(path)?;
                let first = rows.first().map_or(f64::NAN, |r| r[0]);
                (YieldCurve::Table { rows, extrapolates: false }, first)
            }
            (None, Some(n)) => (YieldCurve::Power(n), f64::NAN),
            (None, None) => (YieldCurve::Perfect, f64::NAN),
        };
        // Without a deck clap requires these arguments.
        let or_nan = |value: Option<f64>| value.unwrap_or(f64::NAN);
        Ok(TargetMaterial {
            shape: CavityShape::Spherical,
            young: or_nan(self.young),
            poisson: or_nan(self.poisson),
            density: or_nan(self.density),
            yield_stress: self.yield_stress.unwrap_or(first),
            curve,
            pressure_slope: self.pressure_slope,
            tension,
            rate: self.factor()?.zip(radius).map(|(factor, radius)| StrainRateEffect { factor, radius }),
        })
    }

    fn factor(&self) -> Result<Option<StrainRateFactor>, String> {
        match (&self.rate[..], &self.rate_johnson_cook[..]) {
            ([], []) => Ok(None),
            (&[reference, exponent], []) => Ok(Some(StrainRateFactor::Power { reference, exponent })),
            ([], &[c, reference]) => Ok(Some(StrainRateFactor::JohnsonCook { c, reference })),
            _ => Err("--rate and --rate-johnson-cook need two numbers, for example --rate 8e5,0.3".into()),
        }
    }
}

/// Reads rows of stress and plastic strain; a non-numeric first line is a header.
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
        return Err(wrong("the file has no rows".into()).into());
    }
    Ok(rows)
}
