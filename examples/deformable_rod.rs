//! Limits of the rigid assumption: a deformable rod of VAR 4340 steel (`input/ogive_rod.inp`) and a rigid one over velocity,
//! on two meshes of `revolve mesh` and extrapolated. Writes the table of `docs/fidelity.md`, `docs/rod-depths.png` and
//! `docs/rod-noses.png`:
//!
//!     cargo run --release --example deformable_rod

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;

use revolve::job;
use revolve::output::OutputFrame;
use revolve::output::drawing::{Colour, Drawing, DrawingShape, LineStroke, ShapePaint, TextAnchor, TextLabel};
use revolve::plan::Plan;
use revolve::solve::{Instant, Sink, SinkError};
use revolve::study::chart::{Chart, ChartSeries, SeriesForm};
use revolve::study::compare::ReferenceTable;
use revolve::user::Routines;
use rod::{SIZES, deck};

#[path = "common/rod.rs"]
mod rod;

/// Striking velocities, m/s, including those of the experiment.
const VELOCITIES: [f64; 9] = [300.0, 450.0, 569.0, 679.0, 821.0, 966.0, 1147.0, 1300.0, 1450.0];
/// Velocities in the picture of noses, m/s.
const DRAWN: [f64; 3] = [569.0, 966.0, 1147.0];
/// Parameters that apply the resistance law of the nose to the shank.
const WHOLE: [(&str, &str); 3] = [("WA", "5.0394"), ("WB", "0.9830"), ("WC", "0.9402")];

/// Depth, shortening and widening of a rod, mm.
#[derive(Clone, Copy)]
struct Shot {
    depth: f64,
    shorter: f64,
    wider: f64,
}

/// History rows and last frame of a shot.
#[derive(Default)]
struct Kept {
    rows: Vec<Vec<f64>>,
    frame: Option<OutputFrame>,
}

impl Sink for Kept {
    fn wants_frames(&self) -> bool {
        true
    }
    fn frame(&mut self, frame: &OutputFrame) -> Result<(), SinkError> {
        self.frame = Some(frame.clone());
        Ok(())
    }
    fn row(&mut self, _: &Instant, values: &[f64]) -> Result<(), SinkError> {
        self.rows.push(values.to_vec());
        Ok(())
    }
}

fn shoot(
    (text, volume): &(String, f64),
    velocity: f64,
    law: &[(&str, &str)],
    quads: &mut Vec<DrawnElement>,
) -> Result<Shot, Box<dyn Error>> {
    let own = [("V", velocity.to_string()), ("volume", volume.to_string())];
    let given = law.iter().map(|(n, v)| (*n, (*v).to_owned()));
    let settings: Vec<(String, String)> = own.into_iter().chain(given).map(|(n, v)| (n.to_owned(), v)).collect();
    let prepared = job::prepare_text("ogive_rod.inp", text, &settings, &Routines::none());
    if prepared.diagnostics.has_errors() {
        return Err(prepared.diagnostics.render(&prepared.deck.sources).into());
    }
    let mut kept = Kept::default();
    let (outcome, _) = job::run_into(&prepared, &mut kept);
    if let Some(halt) = outcome.halt {
        return Err(format!("at {velocity} m/s: {halt}").into());
    }
    let column =
        |name: &str| prepared.plan.columns.iter().position(|c| c.name == name).ok_or(format!("no column {name}"));
    let [tip, back, shoulder] = [column("U2@TIP")?, column("U2@BACK")?, column("U1@SHOULDER")?];
    let least = kept.rows.iter().map(|row| row[tip]).fold(0.0, f64::min);
    let most = kept.rows.iter().map(|row| row[shoulder]).fold(0.0, f64::max);
    let last = kept.rows.last().ok_or("no rows")?;
    if let Some(frame) = &kept.frame {
        *quads = silhouette(&prepared.plan, frame);
    }
    Ok(Shot { depth: -1e3 * least, shorter: 1e3 * (last[tip] - last[back]), wider: 1e3 * most })
}

/// Corners of an element in mm, and its fill colour.
struct DrawnElement {
    corners: Vec<[f64; 2]>,
    colour: Colour,
}

/// Returns the elements of the final rod in the right half, moved back to the initial position of the tip, and of the initial
/// (rigid) rod in the left half, mm.
fn silhouette(plan: &Plan, frame: &OutputFrame) -> Vec<DrawnElement> {
    let mesh = &plan.mesh;
    let Some(moved) = frame.point_fields.iter().find(|f| f.name == "U") else { return Vec::new() };
    let tip = mesh.points.iter().position(|p| *p == [0.0, 0.0]).unwrap_or(0);
    let shift = moved.values[2 * tip + 1];
    let mut drawn = Vec::new();
    for element in mesh.elements.iter().filter(|e| e.nodes.len() == 4) {
        for (side, part, colour) in [(-1.0, 0.0, 0x9a_a4_ad), (1.0, 1.0, 0xc9_70_2b)] {
            let place = |n: &usize| {
                let [r, z] = mesh.points[*n];
                let u = [moved.values[2 * n], moved.values[2 * n + 1] - shift];
                [side * 1e3 * (r + part * u[0]), -1e3 * (z + part * u[1])]
            };
            drawn.push(DrawnElement { corners: element.nodes.iter().map(place).collect(), colour });
        }
    }
    drawn
}

/// Returns the depth of the rigid rod with the three-term law, mm.
fn rigid(velocity: f64) -> Result<f64, Box<dyn Error>> {
    let settings = [("V", velocity.to_string()), ("B", "0.9830".into()), ("C", "0.9402".into())];
    let settings: Vec<(String, String)> = settings.map(|(n, v): (&str, String)| (n.to_owned(), v)).into();
    let prepared = job::prepare(Path::new("input/ogive.inp"), &settings, &Routines::none());
    let (_, history) = job::run_in_memory(&prepared);
    Ok(-1e3 * history.0.get("U2@REF").ok_or("no column U2@REF")?.last)
}

fn main() -> Result<(), Box<dyn Error>> {
    let reference = ReferenceTable::read(Path::new("input/reference/piekutowski_1999.csv"))?;
    let known: Vec<(f64, f64)> = reference.rows.iter().map(|(v, columns)| (*v, columns[0])).collect();
    let decks = [deck(SIZES[0])?, deck(SIZES[1])?];
    let mut table = String::from(
        "| striking velocity, m/s | experiment, mm | rigid | yields, 0.6 mm | 0.3 mm | to size 0 | of rigid | shank as nose, 0.3 mm | shorter, mm | \
         wider, mm |\n|---|---|---|---|---|---|---|---|---|---|\n",
    );
    let mut lines: [Vec<(f64, f64)>; 3] = Default::default();
    let mut noses = Vec::new();
    for velocity in VELOCITIES {
        eprintln!("{velocity} m/s");
        let (mut quads, mut other) = (Vec::new(), Vec::new());
        let coarse = shoot(&decks[0], velocity, &[], &mut other)?;
        let fine = shoot(&decks[1], velocity, &[], &mut quads)?;
        let whole = shoot(&decks[1], velocity, &WHOLE, &mut other)?;
        let (limit, rigid) = (2.0 * fine.depth - coarse.depth, rigid(velocity)?);
        let experiment = known.iter().find(|k| k.0 == velocity).map_or(String::new(), |k| k.1.to_string());
        let _ = writeln!(
            table,
            "| {velocity} | {experiment} | {rigid:.1} | {:.1} | {:.1} | {limit:.1} | {:+.1} % | {:.1} | {:.2} | {:.2} |",
            coarse.depth,
            fine.depth,
            100.0 * (limit / rigid - 1.0),
            whole.depth,
            fine.shorter,
            fine.wider
        );
        for (line, depth) in lines.iter_mut().zip([rigid, limit, whole.depth]) {
            line.push((velocity, depth));
        }
        if DRAWN.contains(&velocity) {
            noses.push(quads);
        }
    }
    print!("{table}");
    put_into_page(&table)?;
    let names = ["rigid", "yields, shank in an elastic wall", "yields, shank resisted as the nose"];
    let mut series: Vec<ChartSeries> =
        names.iter().zip(lines).map(|(name, points)| ChartSeries::new(*name, SeriesForm::Line, points)).collect();
    series.push(ChartSeries::new("experiment", SeriesForm::Marks, known));
    let chart = Chart::new("Depth of a rigid rod and of one that yields", ["striking velocity", "depth"], series);
    let chart = Chart { units: ["m/s".into(), "mm".into()], ..chart };
    std::fs::write("docs/rod-depths.png", chart.png()?)?;
    Ok(std::fs::write("docs/rod-noses.png", picture(&noses).png()?)?)
}

/// Draws the noses next to each other, tips down.
fn picture(noses: &[Vec<DrawnElement>]) -> Drawing {
    let (wide, high, scale) = (360.0, 760.0, 32.0);
    let mut drawing = Drawing::new([wide * noses.len() as f64, high]);
    for (n, (nose, velocity)) in noses.iter().zip(DRAWN).enumerate() {
        let left = wide * n as f64;
        let middle = left + 0.5 * wide;
        drawing.label(TextLabel::new([middle, 26.0], TextAnchor::Middle, format!("{velocity} m/s: rigid | yields")));
        drawing.shapes.push(DrawingShape::BeginClip([left, 40.0], [wide, high - 50.0]));
        for DrawnElement { corners, colour } in nose {
            let places = corners.iter().map(|[x, y]| [middle + scale * x, high - 24.0 + scale * y]);
            let paint =
                ShapePaint { stroke: Some(LineStroke::new(*colour, 0.05 * scale)), ..ShapePaint::fill(*colour, 1.0) };
            drawing.path(places, true, paint);
        }
        drawing.shapes.push(DrawingShape::EndClip);
    }
    drawing
}

/// Replaces the table between the two marks in the page.
fn put_into_page(table: &str) -> Result<(), String> {
    const PAGE: &str = "docs/fidelity.md";
    let text = std::fs::read_to_string(PAGE).map_err(|e| format!("{PAGE}: {e}"))?;
    let marks = text.split_once("<!-- rod -->\n").zip(text.split_once("<!-- end of rod -->"));
    let ((before, _), (_, after)) = marks.ok_or_else(|| format!("{PAGE} has lost the marks of its second table"))?;
    std::fs::write(PAGE, format!("{before}<!-- rod -->\n{table}<!-- end of rod -->{after}"))
        .map_err(|e| format!("{PAGE}: {e}"))
}
