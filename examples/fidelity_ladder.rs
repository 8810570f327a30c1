//! Models of increasing fidelity: the same six shots from a closed form to a deformable projectile, each model with its
//! error and run time. Writes the table of `docs/fidelity.md` and `docs/fidelity.png`:
//!
//!     cargo run --release --example fidelity_ladder

use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;
use std::time::Instant;

use revolve::job;
use revolve::study::chart::{Chart, ChartSeries, SeriesForm};
use revolve::study::compare::{ReferenceTable, rms};
use revolve::study::quantity::{FinishedRun, Quantity};
use revolve::user::Routines;

#[path = "common/rod.rs"]
mod rod;

/// A model of the comparison: its row in the table, and how the depth of a shot is computed.
struct Rung {
    name: &'static str,
    model: Model,
}

enum Model {
    /// The two-term law on a rigid nose that is embedded from the start.
    ClosedForm,
    /// A deck, its parameters other than the velocity, and the quantity that gives the depth.
    Deck(&'static str, &'static [(&'static str, &'static str)], &'static str),
    /// `input/ogive_rod.inp`, its parameters other than the velocity, and element sizes; with two sizes, the second half the
    /// first, the depth is extrapolated to size 0.
    Rod(&'static [(&'static str, &'static str)], &'static [f64]),
}

const RIGID: &str = "-1000*final(U2@REF)";
const SOLID: &str = "-1000*min(U2@TIP)";
const THREE_TERMS: &[(&str, &str)] = &[("B", "0.9830"), ("C", "0.9402")];
const FRICTION: &[(&str, &str)] = &[("B", "0.9830"), ("C", "0.9402"), ("friction", "0.02")];
/// Parameters of a steel that does not yield.
const ELASTIC: &[(&str, &str)] = &[("JCA", "1.e12"), ("JCB", "0."), ("JCC", "0.")];

/// Parameters that apply the resistance law of the nose to the shank.
const WHOLE: &[(&str, &str)] = &[("WA", "5.0394"), ("WB", "0.9830"), ("WC", "0.9402")];

const LADDER: [Rung; 7] = [
    Rung { name: "closed form, two terms, embedded", model: Model::ClosedForm },
    Rung { name: "rigid, two terms, entry", model: Model::Deck("input/ogive.inp", &[], RIGID) },
    Rung { name: "rigid, three terms", model: Model::Deck("input/ogive.inp", THREE_TERMS, RIGID) },
    Rung { name: "rigid, three terms, friction 0.02", model: Model::Deck("input/ogive.inp", FRICTION, RIGID) },
    Rung { name: "elastic steel, three terms", model: Model::Deck("input/ogive_steel.inp", ELASTIC, SOLID) },
    Rung { name: "steel that yields, three terms, converged", model: Model::Rod(&[], &rod::SIZES) },
    Rung { name: "the same, shank resisted as the nose", model: Model::Rod(WHOLE, &[rod::SIZES[1]]) },
];

/// Results of a model: depths, mm, and seconds for all shots on one thread.
struct Climbed {
    depths: Vec<f64>,
    seconds: f64,
}

fn main() -> Result<(), Box<dyn Error>> {
    let reference = ReferenceTable::read(Path::new("input/reference/piekutowski_1999.csv"))?;
    let shots: Vec<(f64, f64)> = reference.rows.iter().map(|(v, columns)| (*v, columns[0])).collect();
    let mut climbed = Vec::new();
    for rung in &LADDER {
        eprintln!("{}", rung.name);
        climbed.push(climb(rung, &shots)?);
    }
    let table = table(&shots, &climbed);
    print!("{table}");
    put_into_page(&table)?;
    let picture = picture(&shots, &climbed).png()?;
    Ok(std::fs::write("docs/fidelity.png", picture)?)
}

fn climb(rung: &Rung, shots: &[(f64, f64)]) -> Result<Climbed, Box<dyn Error>> {
    let clock = Instant::now();
    let depth = |&(velocity, _): &(f64, f64)| match rung.model {
        Model::ClosedForm => Ok(closed_form(velocity)),
        Model::Deck(deck, settings, quantity) => {
            shoot(&std::fs::read_to_string(deck)?, deck, settings, quantity, velocity)
        }
        Model::Rod(settings, sizes) => {
            let depth = |&size: &f64| {
                let (text, volume) = rod::deck(size)?;
                let volume = volume.to_string();
                let settings = [settings, &[("volume", &*volume)]].concat();
                shoot(&text, "input/ogive_rod.inp", &settings, SOLID, velocity)
            };
            let depths = sizes.iter().map(depth).collect::<Result<Vec<f64>, Box<dyn Error>>>()?;
            Ok(match depths[..] {
                [coarse, fine] => 2.0 * fine - coarse,
                _ => depths[0],
            })
        }
    };
    let depths = shots.iter().map(depth).collect::<Result<_, Box<dyn Error>>>()?;
    Ok(Climbed { depths, seconds: clock.elapsed().as_secs_f64() })
}

/// `P = m/(2 beta) ln(1 + beta V^2/alpha)`, `alpha = pi a^2 A Y`, `beta = pi a^2 C rho N2`, `N2 = (8 psi - 1)/(24 psi^2)`
/// (Forrestal, Okajima and Luk 1988), with the constants of `input/ogive.inp`; mm.
fn closed_form(velocity: f64) -> f64 {
    let (a, psi, mass, y, rho, c0, c2): (f64, f64, f64, f64, f64, f64, f64) =
        (3.555e-3, 3.0, 0.021, 276e6, 2710.0, 5.0394, 0.983);
    let area = std::f64::consts::PI * a * a;
    let n2 = (8.0 * psi - 1.0) / (24.0 * psi * psi);
    let (alpha, beta) = (area * c0 * y, area * c2 * rho * n2);
    1e3 * mass / (2.0 * beta) * libm::log(1.0 + beta * velocity * velocity / alpha)
}

fn shoot(
    text: &str,
    deck: &str,
    settings: &[(&str, &str)],
    quantity: &str,
    velocity: f64,
) -> Result<f64, Box<dyn Error>> {
    let mut overrides: Vec<(String, String)> = vec![("V".into(), velocity.to_string())];
    overrides.extend(settings.iter().map(|(n, v)| ((*n).to_owned(), (*v).to_owned())));
    let prepared = job::prepare_text(deck, text, &overrides, &Routines::none());
    if prepared.diagnostics.has_errors() {
        return Err(prepared.diagnostics.render(&prepared.deck.sources).into());
    }
    let quantity = Quantity::parse(quantity)?;
    let mut history = quantity.history(&prepared.plan);
    let (outcome, state) = job::run_into(&prepared, &mut history);
    match outcome.halt {
        Some(halt) => Err(format!("{deck} at {velocity}: {halt}").into()),
        None => Ok(quantity.number(FinishedRun { history: &history, end: Some((outcome.total_time(), &state)) })?),
    }
}

fn differences(shots: &[(f64, f64)], climbed: &Climbed) -> Vec<f64> {
    climbed.depths.iter().zip(shots).map(|(depth, (_, known))| depth - known).collect()
}

/// Returns the Markdown table, one model a row.
fn table(shots: &[(f64, f64)], climbed: &[Climbed]) -> String {
    let mut text = String::from("| depth, mm, at |");
    let velocities = shots.iter().map(|(v, _)| format!(" {v} m/s |"));
    velocities.for_each(|v| text += &v);
    text += " mean difference | rms | six shots, s |\n|---|";
    text += &"---|".repeat(shots.len() + 3);
    text += "\n| experiment |";
    shots.iter().for_each(|(_, depth)| text += &format!(" {depth} |"));
    text += " | | |\n";
    for (rung, climbed) in LADDER.iter().zip(climbed) {
        let differences = differences(shots, climbed);
        let mean = differences.iter().sum::<f64>() / differences.len() as f64;
        let _ = write!(text, "| {} |", rung.name);
        climbed.depths.iter().for_each(|d| text += &format!(" {d:.1} |"));
        let _ = writeln!(text, " {mean:+.1} | {:.1} | {:.3} |", rms(&differences).unwrap_or(f64::NAN), climbed.seconds);
    }
    text
}

/// Draws the differences from the experiment over velocity.
fn picture(shots: &[(f64, f64)], climbed: &[Climbed]) -> Chart {
    let line = |(rung, climbed): (&Rung, &Climbed)| {
        let points = shots.iter().zip(differences(shots, climbed)).map(|((v, _), d)| (*v, d)).collect();
        ChartSeries::new(rung.name, SeriesForm::Line, points)
    };
    let series = LADDER.iter().zip(climbed).map(line).collect();
    let chart = Chart::new("Depth: model minus experiment", ["striking velocity", "difference"], series);
    Chart { units: ["m/s".into(), "mm".into()], ..chart }
}

/// Replaces the table between the two marks in the page.
fn put_into_page(table: &str) -> Result<(), String> {
    const PAGE: &str = "docs/fidelity.md";
    let text = std::fs::read_to_string(PAGE).map_err(|e| format!("{PAGE}: {e}"))?;
    let marks = text.split_once("<!-- table -->\n").zip(text.split_once("<!-- end of table -->"));
    let ((before, _), (_, after)) = marks.ok_or_else(|| format!("{PAGE} has lost the marks of its table"))?;
    let page = format!("{before}<!-- table -->\n{table}<!-- end of table -->{after}");
    std::fs::write(PAGE, page).map_err(|e| format!("{PAGE}: {e}"))
}
