//! Random physical scenes: bodies, meshes, all materials, loads, contact, walls, erosion, hourglass control, rigid
//! noses. Each result is classified: energy balance closed, warning issued, or halted with increment and time.
//!
//! The same seed and number give the same scene on every machine.

use std::fmt::Write as _;
use std::panic::{AssertUnwindSafe, catch_unwind};

use revolve::job;
use revolve::solve::{self, Instant, Outcome};
use revolve::user::{AnalysisMoment, LoadFailure, Routines, RunAction, UserEvents};

use super::RecordedOutput;
use super::bodies::{assembly, between, rigid_line};
use super::solid::grid;

/// Increments after which a scene is ended.
const MOST: u64 = 6000;

/// Largest relative energy drift that needs no warning.
const CLOSED: f64 = 0.01;
/// Largest relative energy drift of any completed run.
const HALTS: f64 = 0.2;

/// Result of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum SceneResult {
    /// Energy balance closed within 1 %, no warning.
    Closed,
    /// Energy balance closed within 1 %, with a warning about something else.
    ClosedWithWarning,
    /// Energy drift above 1 %, with a warning.
    WarnedDrift,
    /// Halted with an increment and a time.
    Halted,
    /// Rejected when the deck was read: the generator made invalid input.
    Refused,
    /// Energy drift above 1 % without a warning.
    SilentDrift,
    /// Completed with an energy drift above 20 %.
    ExcessiveDrift,
    /// A final energy that is not finite.
    NotFinite,
    /// Halted without increment or time.
    Unlocated,
    /// Panicked.
    Panicked,
}

impl SceneResult {
    /// Returns whether the result is an error of the program.
    pub fn is_fault(self) -> bool {
        self > SceneResult::Refused
    }
}

/// A scene and its result.
pub struct SceneVerdict {
    pub number: u64,
    pub name: String,
    pub deck: String,
    pub end: SceneResult,
    pub drift: f64,
    pub words: String,
    pub increments: u64,
}

type RandomNumbers<'a> = &'a mut dyn FnMut(f64, f64) -> f64;

/// Ends a run after `MOST` increments.
struct IncrementBudget;

impl UserEvents for IncrementBudget {
    fn moment(&mut self, _: AnalysisMoment, now: &Instant, _: f64) -> Result<RunAction, LoadFailure> {
        Ok(if now.increment < MOST { RunAction::Continue } else { RunAction::EndAnalysis })
    }
}

fn pick<'a, T: ?Sized>(dice: RandomNumbers<'_>, list: &[&'a T]) -> &'a T {
    list[dice(0.0, list.len() as f64) as usize]
}

fn power(dice: RandomNumbers<'_>, low: f64, high: f64) -> f64 {
    10_f64.powf(dice(low, high))
}

/// A material: its name, stiffness, density and cards.
struct SceneMaterial {
    name: &'static str,
    modulus: f64,
    density: f64,
    cards: String,
    /// Whether hourglass control may be selected; rubber and gases have their own.
    has_shear: bool,
    /// Cards that follow those of nodes.
    conditions: String,
}

const LAWS: [&str; 19] = [
    "elastic",
    "elastic, nu 0.49",
    "plastic",
    "perfectly plastic",
    "Johnson-Cook",
    "rate by a power",
    "kinematic",
    "shear failure",
    "Johnson-Cook failure",
    "ductile damage",
    "tensile failure",
    "Us-Up",
    "neo-Hooke",
    "Mooney-Rivlin",
    "Ogden",
    "foam, volumetric",
    "foam, isotropic",
    "ideal gas",
    "explosive",
];

fn law(name: &'static str, dice: RandomNumbers<'_>) -> SceneMaterial {
    let density = power(dice, 2.0, 4.3);
    let modulus = power(dice, 6.0, 11.5);
    let yields = modulus * power(dice, -4.0, -1.7);
    let nu = if name == "elastic, nu 0.49" { 0.49 } else { dice(0.0, 0.45) };
    let metal = format!("*Elastic\n {modulus:e}, {nu}\n");
    let plastic = format!("{metal}*Plastic\n {yields:e}, 0.\n {:e}, 0.5\n", yields * dice(1.0, 3.0));
    let strain = power(dice, -1.5, 0.0);
    let shear = modulus / 2.6;
    let cards = match name {
        "elastic" | "elastic, nu 0.49" => metal,
        "perfectly plastic" => format!("{metal}*Plastic\n {yields:e}, 0.\n"),
        "Johnson-Cook" => format!(
            "{metal}*Plastic, hardening=JOHNSON COOK\n {yields:e}, {:e}, {}, 1., 1000., 300.\n*Rate Dependent, type=JOHNSON COOK\n {}, 1.\n",
            yields * dice(0.1, 2.0),
            dice(0.05, 0.9),
            dice(0.0, 0.1)
        ),
        "rate by a power" => format!("{plastic}*Rate Dependent\n {:e}, {}\n", power(dice, 0.0, 4.0), dice(1.0, 8.0)),
        "kinematic" => {
            format!("{metal}*Plastic, hardening=KINEMATIC\n {yields:e}, 0.\n {:e}, 0.5\n", yields * dice(1.1, 4.0))
        }
        "shear failure" => format!("{plastic}*Shear Failure\n {strain:e},\n"),
        "Johnson-Cook failure" => {
            format!("{plastic}*Shear Failure, type=JOHNSON COOK\n {:e}, {:e}, -1.5, 0., 0.\n", 0.5 * strain, strain)
        }
        "ductile damage" => format!(
            "{plastic}*Damage Initiation, criterion=DUCTILE\n {strain:e}, 0., 0.\n*Damage Evolution, type=DISPLACEMENT\n {:e},\n",
            power(dice, -4.0, -2.0)
        ),
        "tensile failure" => format!("{plastic}*Tensile Failure\n {:e},\n", yields * dice(0.5, 4.0)),
        "Us-Up" => format!(
            "*Eos, type=USUP\n {:e}, {}, {}\n*Elastic, type=SHEAR\n {shear:e},\n*Plastic\n {yields:e}, 0.\n",
            (modulus / density).sqrt(),
            dice(0.0, 1.8),
            dice(0.5, 2.2)
        ),
        "neo-Hooke" => {
            format!("*Hyperelastic, neo hooke\n {:e}, {:e}\n", 0.5 * shear, power(dice, -2.0, 0.3) / modulus)
        }
        "Mooney-Rivlin" => format!(
            "*Hyperelastic, mooney-rivlin\n {:e}, {:e}, {:e}\n",
            0.4 * shear,
            0.1 * shear,
            power(dice, -2.0, 0.3) / modulus
        ),
        "Ogden" => {
            format!("*Hyperelastic, ogden\n {shear:e}, {}, {:e}\n", dice(1.0, 5.0), power(dice, -2.0, 0.3) / modulus)
        }
        "foam, volumetric" => format!(
            "*Elastic\n {modulus:e}, {}\n*Crushable Foam, hardening=VOLUMETRIC\n 1.1, 0.1\n*Crushable Foam Hardening\n {yields:e}, 0.\n {:e}, 0.8\n",
            dice(0.0, 0.3),
            yields * dice(1.2, 4.0)
        ),
        "foam, isotropic" => format!(
            "*Elastic\n {modulus:e}, {}\n*Crushable Foam, hardening=ISOTROPIC\n 1.1, 0.2\n*Crushable Foam Hardening\n {yields:e}, 0.\n {:e}, 0.8\n",
            dice(0.0, 0.3),
            yields * dice(1.2, 4.0)
        ),
        "ideal gas" => "*Eos, type=IDEAL GAS\n 287., 0.\n*Specific Heat\n 718.,\n".into(),
        "explosive" => {
            "*Eos, type=JWL\n 6930., 3.712E11, 3.231E9, 0.3, 4.15, 0.95, 4.29E6\n*Detonation Point\n 0., 0.\n".into()
        }
        _ => plastic,
    };
    let temperature = dice(200.0, 2000.0);
    let (modulus, density) = match name {
        "ideal gas" => (1.4 * density * 287.0 * temperature, density),
        "explosive" => (1630.0 * 6930.0 * 6930.0, 1630.0),
        _ => (modulus, density),
    };
    // The initial temperature of a gas is given as energy per mass.
    let conditions = match name {
        "ideal gas" => format!("*Initial Conditions, type=SPECIFIC ENERGY\n @SOLID, {:e}\n", 718.0 * temperature),
        _ => String::new(),
    };
    let cards = format!("*Density\n {density:e},\n{cards}");
    let has_shear = !["ideal gas", "explosive", "neo-Hooke", "Mooney-Rivlin", "Ogden"].contains(&name);
    SceneMaterial { name, modulus, density, cards, has_shear, conditions }
}

/// A grid of cells and its size.
struct SceneBody {
    cells: [usize; 2],
    inner: f64,
    size: [f64; 2],
    text: String,
    triangles: bool,
}

fn body(dice: RandomNumbers<'_>, base: f64, most: [f64; 2], bottom: f64) -> SceneBody {
    let cells = [dice(1.0, most[0]) as usize, dice(1.0, most[1]) as usize];
    let cell = power(dice, -4.0, -1.0) * base;
    let aspect = if dice(0.0, 1.0) < 0.5 { dice(0.5, 2.0) } else { power(dice, -1.0, 1.0) };
    let sides = [cell, cell * aspect];
    let size = [0, 1].map(|a| sides[a] * cells[a] as f64);
    let inner = if dice(0.0, 1.0) < 0.5 { 0.0 } else { size[0] * power(dice, -1.5, 1.5) };
    let wobble = if dice(0.0, 1.0) < 0.4 { 0.0 } else { dice(0.0, 0.35) };
    let skew = if dice(0.0, 1.0) < 0.7 { 0.0 } else { dice(-0.5, 0.5) };
    let moves: Vec<f64> = (0..2 * (cells[0] + 1) * (cells[1] + 1)).map(|_| dice(-wobble, wobble)).collect();
    let triangles = dice(0.0, 1.0) < 0.2;
    let place = |i: usize, j: usize| {
        let n = i + j * (cells[0] + 1);
        let edge = [i == 0 || i == cells[0], j == 0 || j == cells[1]];
        let moved = [0, 1].map(|a| if edge[a] { 0.0 } else { moves[2 * n + a] });
        let slant = skew * j as f64 / cells[1] as f64 * if edge[0] { 0.0 } else { 1.0 };
        [inner + sides[0] * (i as f64 + moved[0] + 0.3 * slant), bottom + sides[1] * (j as f64 + moved[1])]
    };
    let mut text = grid(cells[0], cells[1], triangles, place);
    if triangles {
        text += &edges_of_triangles(cells);
    }
    SceneBody { cells, inner, size, text, triangles }
}

/// Returns the sets and surfaces of the lower and upper edge, which grids of triangles lack.
fn edges_of_triangles([n, m]: [usize; 2]) -> String {
    let row = n + 1;
    let mut text = format!(
        "*Nset, nset=I0, generate\n 1, {}, {row}\n*Nset, nset=J0, generate\n 1, {row}\n*Nset, nset=J1, generate\n {}, {}\n",
        1 + m * row,
        1 + m * row,
        (m + 1) * row
    );
    for (name, side, first) in [("J0", 1, 1), ("J1", 2, 2 + 2 * n * (m - 1))] {
        let last = first + 2 * (n - 1);
        writeln!(
            text,
            "*Elset, elset=E{name}, generate\n {first}, {last}, 2\n*Surface, name={name}\n E{name}, S{side}"
        )
        .expect("text");
    }
    text
}

fn section(law: &SceneMaterial, dice: RandomNumbers<'_>, material: &str) -> (String, String) {
    let kinds: &[&str] = if law.has_shear {
        &["", "", "RELAX STIFFNESS", "STIFFNESS", "VISCOUS", "COMBINED", "ENHANCED"]
    } else {
        &["", "", "VISCOUS"]
    };
    let hourglass = pick(dice, kinds);
    let controlled = dice(0.0, 1.0) < 0.2;
    let name = format!(
        "{}{}",
        if hourglass.is_empty() { "default" } else { hourglass },
        if controlled { ", distortion" } else { "" }
    );
    let mut controls = String::from("*Section Controls, name=C");
    if !hourglass.is_empty() {
        write!(controls, ", hourglass={hourglass}").expect("text");
    }
    if controlled {
        controls += ", distortion control=YES";
    }
    (name, format!("{controls}\n*Solid Section, elset=SOLID, material={material}, controls=C\n"))
}

fn out() -> &'static str {
    "*Output, field, number interval=1\n*Node Output\n U\n*Element Output\n S\n*End Step\n"
}

fn erosion(dice: RandomNumbers<'_>) -> String {
    match dice(0.0, 1.0) {
        x if x < 0.7 => String::new(),
        x if x < 0.85 => "*Erosion, distortion=0.05\n".into(),
        _ => format!("*Erosion, principal strain={:e}\n", power(dice, -1.0, 0.3)),
    }
}

/// Returns name and deck of the scene with a number.
pub fn deck(seed: u64, number: u64) -> (String, String) {
    let mut between = between(seed.wrapping_mul(1_000_003).wrapping_add(number));
    let dice: RandomNumbers<'_> = &mut between;
    // The leading digits of the first few random numbers depend on the seed alone.
    for _ in 0..8 {
        dice(0.0, 1.0);
    }
    match dice(0.0, 1.0) {
        x if x < 0.65 => single(dice),
        x if x < 0.85 => pair(dice),
        _ => nose(dice),
    }
}

/// Returns one body under a load, with or without a wall.
fn single(dice: RandomNumbers<'_>) -> (String, String) {
    let law = law(LAWS[dice(0.0, LAWS.len() as f64) as usize], dice);
    let body = body(dice, 1.0, [6.0, 10.0], 0.0);
    let (controls, section) = section(&law, dice, "M");
    let sound = (law.modulus / law.density).sqrt();
    let time = body.size[1].max(body.size[0]) / sound * power(dice, -0.3, 1.3);
    let speed = sound * power(dice, -3.5, -0.4);
    let pressure = law.modulus * power(dice, -5.0, -1.0);
    let last = (body.cells[0] + 1) * (body.cells[1] + 1);
    let load = ["thrown at a wall", "pressed", "pulled", "forces at nodes", "gravity", "driven", "shaken"]
        [dice(0.0, 7.0) as usize];
    let (mut before, mut held, mut more) = (String::new(), String::from(" J0, 2, 2\n"), String::new());
    match load {
        "thrown at a wall" => before = format!("*Initial Conditions, type=VELOCITY\n ALL, 2, {:e}\n", -speed),
        "pressed" => more = format!("*Dsload\n J1, P, {pressure:e}\n"),
        "pulled" => more = format!("*Dsload\n J1, P, {:e}\n", -pressure),
        "forces at nodes" => {
            let force = pressure * body.size[0] * (body.inner + body.size[0]);
            more = format!("*Cload\n {last}, 1, {force:e}\n {last}, 2, {:e}\n", -0.5 * force);
        }
        "gravity" => more = format!("*Dload\n SOLID, GRAV, {:e}, 0., -1.\n", pressure / law.density / body.size[1]),
        "driven" => {
            more = format!(
                "*Boundary, type=VELOCITY\n J1, 2, 2, {:e}\n",
                speed * if dice(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 }
            )
        }
        _ => {
            held.clear();
            before = String::from("*Initial Conditions, type=VELOCITY\n");
            for node in 1..=last {
                let (a, b) = (dice(-speed, speed), dice(-speed, speed));
                if body.inner > 0.0 || node % (body.cells[0] + 1) != 1 {
                    writeln!(before, " {node}, 1, {a:e}").expect("text");
                }
                writeln!(before, " {node}, 2, {b:e}").expect("text");
            }
        }
    }
    if body.inner == 0.0 {
        held += " I0, 1, 1\n";
    }
    let held = if held.is_empty() { held } else { format!("*Boundary\n{held}") };
    let text = body.text.clone()
        + &section
        + &format!("*Material, name=M\n{}", law.cards)
        + &law.conditions.replace('@', "")
        + &erosion(dice)
        + &before
        + &format!("*Step\n*Dynamic, Explicit\n , {time:e}\n{held}{more}")
        + out();
    let shape = if body.triangles { "triangles" } else { "quadrilaterals" };
    (format!("{}, {load}, {controls}, {shape}", law.name), text)
}

fn part(name: &str, body: &SceneBody, section: &str) -> String {
    format!("*Part, name={name}\n{}{section}*End Part\n", body.text)
}

fn interaction(dice: RandomNumbers<'_>) -> String {
    if dice(0.0, 1.0) < 0.5 {
        "*Surface Interaction, name=I\n".into()
    } else {
        format!("*Surface Interaction, name=I\n*Friction\n {},\n", dice(0.0, 0.6))
    }
}

/// Returns two bodies that collide.
fn pair(dice: RandomNumbers<'_>) -> (String, String) {
    let laws = [0, 1].map(|_| law(LAWS[dice(0.0, 17.0) as usize], dice));
    let lower = body(dice, 1.0, [6.0, 8.0], 0.0);
    let upper = body(dice, 1.0, [6.0, 8.0], 0.0);
    // Both centred on the axis, `upper` above `lower`.
    let scale = lower.size[0] / upper.size[0] * dice(0.4, 1.6);
    let height = lower.size[1] * 1.02;
    let place = |i: usize, j: usize| {
        let at = |a: usize, k: usize| upper.size[a] * k as f64 / upper.cells[a] as f64 * scale;
        [lower.inner + at(0, i), height + at(1, j)]
    };
    let upper = SceneBody { text: grid(upper.cells[0], upper.cells[1], false, place), triangles: false, ..upper };
    let sections = [section(&laws[0], dice, "M1").1, section(&laws[1], dice, "M2").1];
    let sound = laws.iter().map(|l| (l.modulus / l.density).sqrt()).fold(f64::INFINITY, f64::min);
    let speed = sound * power(dice, -3.0, -0.5);
    let length = lower.size[1].max(upper.size[1] * scale);
    let time = 0.02 * lower.size[1] / speed + length / sound * power(dice, -0.3, 1.0);
    let mut held = String::new();
    if lower.inner == 0.0 {
        held += "*Boundary\n LOWER.I0, 1, 1\n UPPER.I0, 1, 1\n";
    }
    let stiff = laws.iter().all(|law| law.has_shear);
    let penalty = if stiff && dice(0.0, 1.0) < 0.3 { "*Contact Controls Assignment\n , , 1.\n" } else { "" };
    let text = part("LOWER", &lower, &sections[0])
        + &part("UPPER", &upper, &sections[1])
        + &assembly(&["LOWER", "UPPER"], "")
        + &format!("*Material, name=M1\n{}*Material, name=M2\n{}", laws[0].cards, laws[1].cards)
        + &interaction(dice)
        + &format!("*Initial Conditions, type=VELOCITY\n UPPER.ALL, 2, {:e}\n", -speed)
        + &erosion(dice)
        + &format!("*Step\n*Dynamic, Explicit\n , {time:e}\n{held}*Contact\n*Contact Inclusions, all exterior\n")
        + &format!("*Contact Property Assignment\n , , I\n{penalty}")
        + out();
    (format!("{} against {}", laws[1].name, laws[0].name), text)
}

/// Returns a rigid nose that hits a block.
fn nose(dice: RandomNumbers<'_>) -> (String, String) {
    let law = law(LAWS[dice(0.0, 17.0) as usize], dice);
    let mut block = body(dice, 1.0, [8.0, 8.0], 0.0);
    // Centred on the axis.
    let (n, m, size) = (block.cells[0], block.cells[1], block.size);
    block.text = grid(n, m, false, |i, j| [size[0] * i as f64 / n as f64, size[1] * (j as f64 / m as f64 - 1.0)]);
    let section = section(&law, dice, "M").1;
    let (radius, length) = (size[0] * dice(0.2, 0.8), size[0] * dice(0.05, 0.8));
    let gap = 0.01 * size[1];
    let corners = [[radius, gap + 2.0 * length + radius], [radius, gap + length], [0.0, gap]];
    let mass = law.density * size[0] * size[0] * size[1] * power(dice, -1.0, 1.0);
    let point = format!("*Element, type=MASS, elset=M\n 900, 1000\n*Mass, elset=M\n {mass:e},\n");
    let sound = (law.modulus / law.density).sqrt();
    let speed = sound * power(dice, -3.0, -0.6);
    let time = gap / speed + size[1] / sound * power(dice, 0.0, 1.2);
    let text = part("BLOCK", &block, &section)
        + &rigid_line("NOSE", &corners, &point)
        + &assembly(&["BLOCK", "NOSE"], "*Rigid Body, ref node=NOSE.REF, elset=NOSE.E\n")
        + &format!("*Material, name=M\n{}", law.cards)
        + &interaction(dice)
        + &format!("*Initial Conditions, type=VELOCITY\n NOSE.REF, 2, {:e}\n", -speed)
        + &erosion(dice)
        + &format!("*Step\n*Dynamic, Explicit\n , {time:e}\n*Boundary\n BLOCK.J0, 2, 2\n BLOCK.I0, 1, 1\n")
        + "*Contact Pair, interaction=I\n NOSE.SKIN, BLOCK.J1\n"
        + out();
    (format!("rigid nose into {}", law.name), text)
}

/// Runs a scene and classifies its result.
pub fn judge(seed: u64, number: u64) -> SceneVerdict {
    let (name, deck) = deck(seed, number);
    let verdict = |end, drift, words: String, increments| {
        let (name, deck) = (name.clone(), deck.clone());
        SceneVerdict { number, name, deck, end, drift, words, increments }
    };
    let ran = catch_unwind(AssertUnwindSafe(|| {
        let prepared = job::prepare_text("scene.inp", &deck, &[], &Routines::none().with_events(IncrementBudget));
        if prepared.diagnostics.has_errors() {
            return Err(prepared.diagnostics.render(&prepared.deck.sources));
        }
        Ok(solve::run(&prepared.plan, prepared.state.clone(), &mut RecordedOutput::default()).0)
    }));
    match ran {
        Err(_) => verdict(SceneResult::Panicked, f64::NAN, String::new(), 0),
        Ok(Err(words)) => verdict(SceneResult::Refused, 0.0, words, 0),
        Ok(Ok(outcome)) => {
            let (end, words) = of(&outcome);
            verdict(end, outcome.energy.drift, words, outcome.increments)
        }
    }
}

fn of(outcome: &Outcome) -> (SceneResult, String) {
    let (drift, message_text) = (outcome.energy.drift, outcome.warnings.join("\n"));
    if let Some(halt) = &outcome.halt {
        let located = ["increment", "time"].iter().all(|word| halt.message().contains(word));
        return (
            if located { SceneResult::Halted } else { SceneResult::Unlocated },
            format!("{}: {}", halt.code(), halt.message()),
        );
    }
    let end = match drift {
        d if !d.is_finite() || !outcome.energy.total.is_finite() => SceneResult::NotFinite,
        d if d > HALTS => SceneResult::ExcessiveDrift,
        d if d > CLOSED && message_text.contains("ETOTAL") => SceneResult::WarnedDrift,
        d if d > CLOSED => SceneResult::SilentDrift,
        _ if message_text.is_empty() => SceneResult::Closed,
        _ => SceneResult::ClosedWithWarning,
    };
    (end, message_text)
}
