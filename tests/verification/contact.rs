//! Contact between element surfaces: bars and patches.
//!
//! Goal: contact time, momentum, energy, and stresses that are independent of the meshes, with default parameters.
//! Source: closed forms. The tolerance and its reason are stated at each test.

use std::f64::consts::PI;

use crate::common::bodies::{assembly, cell_field, elastic, part, rigid_line, run, short};

/// Courant number of the bars.
const COURANT: f64 = 0.9;
/// Speed of the upper bar.
pub const SPEED: f64 = 1e-5;

/// Returns the deck of two elastic bars of length 1 and radius 1 with E = rho = c = 1; the upper bar falls on the lower
/// one. `rows` are the elements of each bar along z, `columns` those along the radius of the lower and upper bar.
pub fn bars(rows: usize, columns: [usize; 2], gap: f64, time: f64) -> String {
    let bar = |name: &str, n: usize, from: f64| {
        part(name, [n, rows], |i, j| [i as f64 / n as f64, from + j as f64 / rows as f64], "")
    };
    let dt = COURANT / rows as f64;
    bar("LOWER", columns[0], -1.0)
        + &bar("UPPER", columns[1], gap)
        + &assembly(&["LOWER", "UPPER"], "")
        + &elastic("LOWER", [1.0, 0.0, 1.0], "")
        + &elastic("UPPER", [1.0, 0.0, 1.0], "")
        + &format!("*Surface Interaction, name=HARD\n*Initial Conditions, type=VELOCITY\n UPPER.ALL, 2, {:e}\n", -SPEED)
        + &format!("*Step\n*Dynamic, Explicit, direct user control\n {dt}, {}\n", dt * (time / dt).round())
        + "*Bulk Viscosity\n 0., 0.\n*Contact Pair, interaction=HARD\n LOWER.J1, UPPER.J0\n\
           *Output, field, number interval=1000\n*Node Output\n V\n*End Step\n"
}

/// Contact lasts 2 L/c, the bars exchange their velocities, and momentum and energy are conserved to rounding. The
/// energy lost at first contact is that of the nodes that meet, 1/(4 n) of the total. If the gap closes within a
/// fraction x of an increment, the loss is 1 + 2 C^2 x (1 - x) times as large, where C is the Courant number. The first
/// increment removes 1 - x^2 of this energy and leaves the velocity x v, and the second increment stops what the
/// adjacent row has accelerated meanwhile.
#[test]
fn colliding_bars_exchange_their_velocities() {
    for (columns, gap) in [([1, 1], 1e-10), ([3, 4], 1e-10), ([1, 1], 3.3e-7), ([3, 4], 3.3e-7)] {
        for rows in [10, 20, 40] {
            let ran = run(&bars(rows, columns, gap, 3.0)).whole();
            let (energy, start, lower) = (ran.outcome.energy, -PI * SPEED, ran.nodes("LOWER"));
            let given = |f| ran.momentum_of(&lower, f) / start;
            let pushes = ran.memory.frames.windows(2).map(|w| (given(&w[1]) - given(&w[0])) / (w[1].time - w[0].time));
            let dt = COURANT / rows as f64;
            // The force is 1/2 of the momentum per unit of time.
            let (time, given) = (pushes.filter(|p| *p > 0.25).count() as f64 * dt, given(ran.end()));
            let (loss, momentum) = (energy.contact / energy.initial * 4.0 * rows as f64, ran.momentum() / start - 1.0);
            let part = (gap / (SPEED * dt)).fract();
            let expected = 1.0 + 2.0 * COURANT * COURANT * part * (1.0 - part);
            println!(
                "bars, {rows} rows, {columns:?}, gap {gap:.1e}: loss {loss:.4}/(4n) ({expected:.4}), given {given:.4}, lasts \
                 {time:.4}, momentum {momentum:.1e}, drift {:.1e}",
                energy.drift
            );
            assert!((loss - expected).abs() < 2e-3, "{loss} {expected}");
            assert!(momentum.abs() < 1e-13 && energy.drift < 1e-13, "{momentum} {energy:?}");
            // The loss reduces the transferred momentum; the tolerance is that of half a row.
            assert!((1.0 - given).abs() < 0.5 / rows as f64, "{given}");
            assert!((time / 2.0 - 1.0).abs() < dt.max(0.02), "{time}");
        }
    }
}

/// Steel truss of 2 m, 0.2 m2, 200 GPa and 7800 kg/m3, 1 mm in front of a rigid wall at 1.5 m/s (ABAQUS Benchmarks
/// Guide 1.3, "Rod impact", closed form). Contact begins after 6.667e-4 s, the force is rho c v A = 1.185256e7 N,
/// contact lasts 2 L/(c + v) = 7.897028e-4 s, and the impulse is 9360 kg m/s. The error is of first order in the row
/// height because of the energy loss at first contact.
#[test]
fn truss_impact_matches_closed_form() {
    let radius = (0.2 / PI).sqrt();
    let mut impulses = Vec::new();
    for rows in [20, 80] {
        let deck = part("BAR", [1, rows], |i, j| [radius * i as f64, 0.001 + 2.0 * j as f64 / rows as f64], "")
            + &rigid_line("WALL", &[[0.0, 0.0], [1.0, 0.0]], "")
            + &assembly(&["BAR", "WALL"], "*Rigid Body, ref node=WALL.REF, elset=WALL.E\n")
            + &elastic("BAR", [200e9, 0.0, 7800.0], "")
            + "*Surface Interaction, name=HARD\n*Initial Conditions, type=VELOCITY\n BAR.ALL, 2, -1.5\n*Step\n*Dynamic, Explicit\n , 1.8e-3\n\
               *Bulk Viscosity\n 0., 0.\n*Boundary\n WALL.REF, 2, 2\n*Contact Pair, interaction=HARD\n BAR.J0, WALL.SKIN\n\
               *Output, history, frequency=1\n*Node Output, nset=WALL.REF\n RF2\n*End Step\n";
        let ran = run(&deck).whole();
        let force = ran.column("RF2@WALL.REF");
        let held: Vec<_> = force.iter().filter(|f| f[1].abs() > 0.5 * 1.185256e7).collect();
        let (first, last) = (held[0][0], held[held.len() - 1][0]);
        let impulse: f64 = force.windows(2).map(|w| (w[1][0] - w[0][0]) * w[1][1].abs()).sum();
        let inside: Vec<_> = held.iter().filter(|f| f[0] > first + 1e-4 && f[0] < last - 1e-4).collect();
        let mean = inside.iter().map(|f| f[1].abs()).sum::<f64>() / inside.len() as f64;
        let answer = [first / 6.667e-4, mean / 1.185256e7, (last - first) / 7.897028e-4, impulse / 9360.0];
        println!(
            "truss on a wall, {rows} rows: touch, force, time and impulse {answer:.4?}, drift {:.1e}",
            ran.outcome.energy.drift
        );
        assert!(answer.iter().all(|a| (a - 1.0).abs() < 1.6 / rows as f64), "{answer:?}");
        impulses.push(1.0 - answer[3]);
    }
    assert!(impulses[1] < 0.4 * impulses[0], "{impulses:?}");
}

/// Radius at which the patch begins and ends, subdivisions of its lower and upper disc, and which disc the pair names
/// first.
pub struct ContactPatch {
    pub from: f64,
    pub columns: [usize; 2],
    pub random: bool,
    pub lower_first: bool,
}

impl ContactPatch {
    /// Returns the radius of a node on the interface of a disc, with uniform or random spacing.
    fn radius(&self, disc: usize, i: usize) -> f64 {
        let n = self.columns[disc];
        let shift = if self.random && i > 0 && i < n { 0.35 * libm::sin((12 * i * (disc + 2)) as f64) } else { 0.0 };
        self.from + (1.0 - self.from) * (i as f64 + shift) / n as f64
    }

    pub fn deck(&self, pressure: f64) -> String {
        let disc = |name: &str, which: usize| {
            let rows = self.columns[which] / 2 + 1;
            let place =
                |i: usize, j: usize| [self.radius(which, i), 0.5 * (j as f64 / rows as f64 - (1 - which) as f64)];
            part(name, [self.columns[which], rows], place, "")
        };
        let pair = if self.lower_first { "LOWER.J1, UPPER.J0" } else { "UPPER.J0, LOWER.J1" };
        disc("LOWER", 0)
            + &disc("UPPER", 1)
            + &assembly(&["LOWER", "UPPER"], "")
            + &elastic("LOWER", [1.0, 0.3, 1.0], "*Damping, alpha=1.5\n")
            + &elastic("UPPER", [1.0, 0.3, 1.0], "*Damping, alpha=1.5\n")
            + "*Surface Interaction, name=HARD\n*Step\n*Dynamic, Explicit\n , 60.\n*Boundary\n LOWER.J0, 2, 2\n"
            + &format!("*Contact Pair, interaction=HARD\n {pair}\n*Dsload\n UPPER.J1, P, {pressure:e}\n")
            + "*Output, field, number interval=1\n*Element Output\n S\n*End Step\n"
    }
}

/// Two discs with nonmatching meshes pressed together have a uniform stress without shear. The error is proportional to
/// the pressure over the modulus, that is, to the strain history (1.5e-8 at 1e-6), and depends on the number of contact
/// sweeps.
#[test]
fn contact_patch_has_uniform_stress() {
    let pressure = 1e-7;
    for (columns, random) in [([3, 4], false), ([6, 8], false), ([7, 9], true)] {
        for from in [0.0, 0.5] {
            let patches = [true, false].map(|lower_first| {
                let ran = run(&ContactPatch { from, columns, random, lower_first }.deck(pressure)).whole();
                let mut worst = [0.0_f64; 4];
                for s in cell_field(ran.end(), "S").chunks(4) {
                    for ((worst, s), expected) in worst.iter_mut().zip(s).zip([0.0, -1.0, 0.0, 0.0]) {
                        *worst = worst.max((s / pressure - expected).abs());
                    }
                }
                worst
            });
            let way = if random { "random" } else { "even" };
            println!("patch {columns:?}, {way}, r >= {from}: errors of S11, S22, S33, S12 {}", short(&patches[0]));
            assert!(patches.as_flattened().iter().all(|w| *w < 1e-8), "{patches:?}");
        }
    }
}
