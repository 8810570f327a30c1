//! Yield surface and paths of a law whose strength depends on pressure: one material point, with the law's own update.

use serde::Serialize;

use super::chart::{Chart, ChartSeries, SeriesForm};
use super::table::{TextTable, digits};
use crate::material::returns::law::StressReturn;
use crate::material::returns::path::LawPath;
use crate::model::strength_law::strength_law;
use crate::model::{DeckUnits, MaterialDefinition};
use crate::resistance::LawTarget;

/// Number of points of the surface and of a path.
const POINTS: u32 = 100;
/// Axial compression at the end of a path, if the command has no smaller strain.
const LARGEST_STRAIN: f64 = 0.1;
/// Increments of a path between two points.
const INCREMENTS: u32 = 10;
/// Default confining pressures over the strength in uniaxial compression.
const CONFINEMENTS: [f64; 3] = [0.0, 0.5, 2.0];
/// Increment of the logarithm of the volume, from a share of which a pressure is approached.
const VOLUME_INCREMENT: f64 = 1e-4;
/// Largest change of the logarithm of the volume on the way to a pressure.
const LARGEST_VOLUME_CHANGE: f64 = 0.5;
/// Bisections of a volume change and of a shear strain, and of the largest tension.
const BISECTIONS: u32 = 50;
const TENSION_BISECTIONS: u32 = 40;
/// Smallest von Mises stress of the surface over the largest one; below it the surface is closed.
const CLOSED: f64 = 1e-6;

/// Settings of the curves of a law.
#[derive(Clone, Debug)]
pub struct StrengthRequest {
    /// Confining pressures of triaxial compression; empty for shares of the strength in uniaxial compression.
    pub confinements: Vec<f64>,
    /// Axial strain at the end of a path.
    pub strain: f64,
    /// Characteristic element length of softening over displacements.
    pub length: f64,
}

/// Point of a path of compression; strains and stresses are positive in compression.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StrengthPoint {
    /// Axial logarithmic strain.
    pub strain: f64,
    /// Axial stress.
    pub stress: f64,
    /// Pressure.
    pub pressure: f64,
    /// Von Mises stress.
    pub mises: f64,
    /// Logarithm of the initial over the current volume.
    pub compaction: f64,
}

/// Path of compression.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StrengthPath {
    /// Confining pressure of triaxial compression; `None` for uniaxial strain.
    pub confinement: Option<f64>,
    /// Points from the hydrostatic state on.
    pub points: Vec<StrengthPoint>,
}

/// Yield surface and paths of a material.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StrengthCurves {
    /// Name of the material.
    pub name: String,
    /// Pressure and von Mises stress at first yield in triaxial compression, after hydrostatic loading to the pressure.
    pub surface: Vec<[f64; 2]>,
    /// Triaxial compression, then uniaxial strain.
    pub paths: Vec<StrengthPath>,
}

impl StrengthPath {
    fn label(&self, units: Option<&DeckUnits>) -> String {
        let unit = units.map_or(String::new(), |units| format!(" {}", units.name([-1, 1, -2, 0])));
        match self.confinement {
            Some(pressure) => format!("triaxial compression, {}{unit}", digits(pressure, 4)),
            None => "uniaxial strain".into(),
        }
    }
}

/// Computes surface and paths of a material with cards of strength; `None` for other materials and for laws that are not
/// accepted, which a run reports.
pub fn curves(material: &MaterialDefinition, request: &StrengthRequest) -> Option<StrengthCurves> {
    let law = strength_law(material, request.length).ok().filter(|_| material.has_strength_law())?.law;
    let law = &*law;
    let confinements = if request.confinements.is_empty() {
        let strength = LawTarget::compressive_strength(law, request.length).ok()?;
        CONFINEMENTS.map(|share| share * strength).to_vec()
    } else {
        request.confinements.clone()
    };
    let confined = |&pressure: &f64| path(law, request, Some(pressure));
    let paths: Vec<StrengthPath> = confinements.iter().map(confined).chain([path(law, request, None)]).collect();
    let triaxial = paths.iter().filter(|path| path.confinement.is_some());
    let largest = triaxial.flat_map(|path| path.points.iter().map(|point| point.pressure)).fold(0.0, f64::max);
    Some(StrengthCurves { name: material.name.clone(), surface: surface(law, request.length, largest), paths })
}

/// Bisects an interval, at whose upper end a condition holds, around the place from which on it holds.
fn narrowed([mut low, mut high]: [f64; 2], bisections: u32, holds: impl Fn(f64) -> bool) -> [f64; 2] {
    for _ in 0..bisections {
        let middle = 0.5 * (low + high);
        let bound = if holds(middle) { &mut high } else { &mut low };
        *bound = middle;
    }
    [low, high]
}

/// Loads a point hydrostatically to a pressure; `None` if it does not reach it.
fn at_pressure<'a>(law: &'a dyn StressReturn, length: f64, pressure: f64) -> Option<LawPath<'a>> {
    let mut path = LawPath::new(law, length);
    let side = if pressure < 0.0 { 1.0 } else { -1.0 };
    let is_beyond = |path: &LawPath<'_>| -side * (path.invariants()[0] - pressure) >= 0.0;
    let changed = |path: &LawPath<'a>, change: f64| {
        let mut next = path.clone();
        next.advance([change / 3.0, change / 3.0, change / 3.0, 0.0], f64::INFINITY);
        next
    };
    let mut volume = 0.0;
    while volume < LARGEST_VOLUME_CHANGE {
        let next = changed(&path, side * VOLUME_INCREMENT);
        if is_beyond(&next) {
            let [_, change] =
                narrowed([0.0, VOLUME_INCREMENT], BISECTIONS, |change| is_beyond(&changed(&path, side * change)));
            return Some(changed(&path, side * change));
        }
        if pressure < 0.0 && next.is_flowing {
            return None;
        }
        (path, volume) = (next, volume + VOLUME_INCREMENT);
    }
    None
}

/// Returns pressure and von Mises stress at which a point first yields under triaxial compression at constant volume.
fn first_yield(path: &LawPath<'_>) -> [f64; 2] {
    let sheared = |strain: f64| {
        let mut next = path.clone();
        next.advance([0.5 * strain, -strain, 0.5 * strain, 0.0], f64::INFINITY);
        next
    };
    let (mut low, mut high) = (0.0, 1e-6);
    while !sheared(high).is_flowing && high < 1.0 {
        (low, high) = (high, 2.0 * high);
    }
    let [elastic, _] = narrowed([low, high], BISECTIONS, |strain| sheared(strain).is_flowing);
    sheared(elastic).invariants()
}

/// Returns the yield surface up to a pressure, or to where it is closed. It begins at the largest hydrostatic tension.
fn surface(law: &dyn StressReturn, length: f64, largest: f64) -> Vec<[f64; 2]> {
    let is_reached = |pressure: f64| at_pressure(law, length, pressure).is_some();
    let least = if is_reached(-largest) { 0.0 } else { narrowed([-largest, 0.0], TENSION_BISECTIONS, is_reached)[1] };
    let mut points: Vec<[f64; 2]> = Vec::new();
    let mut largest_mises = 0.0_f64;
    for i in 0..=POINTS {
        let pressure = least + (largest - least) * f64::from(i) / f64::from(POINTS);
        let Some(path) = at_pressure(law, length, pressure) else { break };
        let [pressure, mises] = first_yield(&path);
        if i > 0 && mises <= CLOSED * largest_mises {
            break;
        }
        largest_mises = largest_mises.max(mises);
        points.push([pressure, mises]);
    }
    points
}

/// Compresses a point along the axis, at a confining pressure or without radial strain. Ends early where no state is found.
fn path(law: &dyn StressReturn, request: &StrengthRequest, confinement: Option<f64>) -> StrengthPath {
    let end = request.strain.min(LARGEST_STRAIN);
    let increment = -end / f64::from(POINTS * INCREMENTS);
    let mut point = match confinement.map(|pressure| at_pressure(law, request.length, pressure)) {
        Some(Some(loaded)) => loaded,
        Some(None) => return StrengthPath { confinement, points: Vec::new() },
        None => LawPath::new(law, request.length),
    };
    let start = point.strain[1];
    let record = |point: &LawPath<'_>| {
        let [pressure, mises] = point.invariants();
        let [radial, axial, hoop, _] = point.strain;
        StrengthPoint {
            strain: start - axial,
            stress: -point.stress[1],
            pressure,
            mises,
            compaction: -(radial + axial + hoop),
        }
    };
    let mut points = vec![record(&point)];
    for _ in 0..POINTS {
        for _ in 0..INCREMENTS {
            match confinement {
                Some(pressure) if !point.advance_axially(increment, -pressure) => {
                    return StrengthPath { confinement, points };
                }
                Some(_) => {}
                None => point.advance([0.0, increment, 0.0, 0.0], f64::INFINITY),
            }
        }
        points.push(record(&point));
    }
    StrengthPath { confinement, points }
}

/// Returns all points of surfaces and paths, with all digits.
pub fn point_table(all: &[StrengthCurves]) -> TextTable {
    let header = ["material", "curve", "confinement", "strain", "stress", "pressure", "mises", "compaction"];
    let number = |value: f64| format!("{value:?}");
    let mut rows: Vec<Vec<String>> = Vec::new();
    for curves in all {
        let row = |curve: &str, numbers: [String; 6]| {
            [curves.name.clone(), curve.to_owned()].into_iter().chain(numbers).collect()
        };
        rows.extend(curves.surface.iter().map(|[pressure, mises]| {
            let none = String::new;
            row("surface", [none(), none(), none(), number(*pressure), number(*mises), none()])
        }));
        for path in &curves.paths {
            let word = if path.confinement.is_some() { "triaxial" } else { "uniaxial strain" };
            rows.extend(path.points.iter().map(|point| {
                let StrengthPoint { strain, stress, pressure, mises, compaction } = *point;
                let [strain, stress, pressure, mises, compaction] =
                    [strain, stress, pressure, mises, compaction].map(number);
                let confinement = path.confinement.map_or(String::new(), number);
                row(word, [confinement, strain, stress, pressure, mises, compaction])
            }));
        }
    }
    TextTable { header: header.map(String::from).into(), rows }
}

/// Returns the charts of a material, each with the ending of its file: surface with triaxial paths, axial stress over axial
/// strain.
pub fn charts(curves: &StrengthCurves, units: Option<&DeckUnits>) -> [(&'static str, Chart); 2] {
    let stress = units.map_or(String::new(), |u| u.name([-1, 1, -2, 0]));
    let drawn = |path: &StrengthPath, of: fn(&StrengthPoint) -> (f64, f64)| {
        ChartSeries::new(path.label(units), SeriesForm::Line, path.points.iter().map(of).collect())
    };
    let invariants = curves.paths.iter().filter(|path| path.confinement.is_some());
    let invariants = invariants.map(|path| drawn(path, |point| (point.pressure, point.mises)));
    let first = curves.surface.iter().map(|[pressure, mises]| (*pressure, *mises)).collect();
    let surface = [ChartSeries::new("first yield", SeriesForm::Guide, first)].into_iter().chain(invariants).collect();
    let stresses = curves.paths.iter().map(|path| drawn(path, |point| (point.strain, point.stress))).collect();
    let chart = |title: &str, axes, units, series| Chart {
        units,
        ..Chart::new(&format!("{}: {title}", curves.name), axes, series)
    };
    [
        (
            "_surface",
            chart("yield surface", ["pressure", "von Mises stress"], [stress.clone(), stress.clone()], surface),
        ),
        ("_paths", chart("compression", ["axial strain", "axial stress"], [String::new(), stress], stresses)),
    ]
}

/// Returns the largest von Mises stress of each triaxial path.
pub fn table(all: &[StrengthCurves], units: Option<&DeckUnits>) -> TextTable {
    let unit = |name: &str| units.map_or(name.to_owned(), |u| format!("{name} {}", u.name([-1, 1, -2, 0])));
    let header =
        vec!["material".to_owned(), unit("confinement"), unit("largest von Mises stress"), "at strain".to_owned()];
    let mut rows = Vec::new();
    for curves in all {
        for path in &curves.paths {
            let largest = path.points.iter().max_by(|a, b| a.mises.total_cmp(&b.mises));
            let (Some(confinement), Some(largest)) = (path.confinement, largest) else { continue };
            let cells = [confinement, largest.mises, largest.strain].map(|value| digits(value, 4));
            rows.push([curves.name.clone()].into_iter().chain(cells).collect());
        }
    }
    TextTable { header, rows }
}
