//! Bodies with changing meshes (`*ADAPTIVE MESH`, `*REMESH`) in contact with analytical surfaces.
//!
//! Goal: energies of the mesh that follows the material; no halt of a sound analysis. Source: the same runs without the card.
//! Tolerances are stated at each test. Units: m, kg, s.

use super::remeshing::new_meshes;
use super::remeshing_contact::last;
use crate::common::bodies::{DeckRun, run};
use crate::common::solid::grid;

const PLASTIC: &str = "*Plastic\n 4e8, 0.\n 6e8, 1.\n";
const LINEAR: &str = "*Surface Behavior, pressure-overclosure=LINEAR\n 1e14\n";
const EXPONENTIAL: &str = "*Surface Behavior, pressure-overclosure=EXPONENTIAL\n 1e-5, 1e8\n";
const REMESH: &str = "*Remesh, elset=SOLID, angle=45., frequency=5\n";
const FIXED: &str = " W, 2, 2\n";
/// Lines of the surface in its direction, and against it.
const LINE: &str = "START, 0., 0.\n LINE, 0.1, 0.";
const REVERSED: &str = "START, 0.1, 0.\n LINE, 0., 0.";
/// Sphere with a radius of 32.5 mm.
const SPHERE: &str = "START, 0., 0.\n CIRCL, 0.03, -0.02, 0., -0.0325";

/// A steel bar of 5 by 10 mm with 5 by 10 elements that hits a wall at z = 0.
#[derive(Clone, Copy)]
struct Bar<'a> {
    /// Displacement of the nodes inside, over the edge of an element.
    distortion: f64,
    /// Further cards of the material.
    material: &'a str,
    /// Cards of the interaction.
    interaction: &'a str,
    speed: f64,
    time: f64,
    /// Points of the surface of the wall.
    wall: &'a str,
    /// Cards of the mass of the wall.
    mass: &'a str,
    /// Lines of `*BOUNDARY`.
    boundary: &'a str,
    /// General contact instead of a contact pair.
    is_general: bool,
}

const BAR: Bar<'_> = Bar {
    distortion: 0.15,
    material: PLASTIC,
    interaction: "",
    speed: 300.0,
    time: 1.5e-5,
    wall: LINE,
    mass: "",
    boundary: FIXED,
    is_general: false,
};

/// A free wall of 20 g.
const FREE: Bar<'_> =
    Bar { mass: "*Element, type=MASS, elset=M\n 900, 9000\n*Mass, elset=M\n 0.02,\n", boundary: "", ..BAR };

impl Bar<'_> {
    /// Runs the bar to its end, with cards of its mesh in the step.
    fn run(&self, cards: &str) -> DeckRun {
        run(&self.deck(cards)).whole()
    }

    fn deck(&self, cards: &str) -> String {
        let Bar { distortion, material, interaction, speed, time, wall, mass, boundary, is_general } = self;
        let place = |i: usize, j: usize| {
            let (x, y) = (i as f64, j as f64);
            let part = if (1..5).contains(&i) && (1..10).contains(&j) { *distortion } else { 0.0 };
            [1e-3 * (x + part * (2.1 * x + 3.7 * y).sin()), 1e-3 * (y + part * (4.3 * x + 1.9 * y).sin())]
        };
        let contact = match is_general {
            true => "*Contact\n*Contact Inclusions\n SKIN, WALL\n*Contact Property Assignment\n , , I\n",
            false => "*Contact Pair, interaction=I\n SKIN, WALL\n",
        };
        grid(5, 10, false, place)
            + "*Surface, name=SKIN\n SOLID,\n*Solid Section, elset=SOLID, material=STEEL\n"
            + &format!(
                "*Node, nset=W\n 9000, 0., 0.\n*Surface, type=SEGMENTS, name=WALL\n {wall}\n{mass}*Rigid Body, ref \
                 node=9000, analytical surface=WALL\n*Material, name=STEEL\n*Density\n 7800.,\n*Elastic\n 2e11, \
                 .3\n{material}*Surface Interaction, name=I\n{interaction}*Initial Conditions, type=VELOCITY\n ALL, 2, \
                 -{speed:e}\n*Boundary\n I0, 1, 1\n{boundary}*Step\n*Dynamic, Explicit\n , {time:e}\n{contact}{cards}*Output, \
                 history, number interval=50\n*Energy Output\n ALL\n*End Step\n"
            )
    }
}

/// Returns the largest differences of energies between two runs over the initial kinetic energy: at the end, and at any
/// time.
fn differences(ran: &DeckRun, follows: &DeckRun, names: &[&str]) -> [f64; 2] {
    let put_in = follows.column("ALLKE")[0][1];
    let mut most = [0.0_f64; 2];
    for name in names {
        let [a, b] = [ran, follows].map(|run| run.column(name));
        let apart = a.iter().zip(&b).map(|(a, b)| (a[1] - b[1]).abs() / put_in);
        most[1] = apart.fold(most[1], f64::max);
        most[0] = most[0].max((last(ran, name) - last(follows, name)).abs() / put_in);
    }
    most
}

/// Soft contact keeps its overlaps and its stored energy while the mesh slides along an analytical surface: at the end, all
/// energies are those of the mesh that follows the material within 2 % of the energy put in.
#[test]
fn soft_contact_keeps_its_energies_on_adaptive_meshes() {
    let elastic = Bar { distortion: 0.0, material: "", speed: 30.0, time: 1.2e-5, ..BAR };
    let plastic = Bar { speed: 100.0, time: 1.2e-5, ..BAR };
    let sphere = Bar { wall: SPHERE, speed: 200.0, time: 3e-5, ..BAR };
    let free = Bar { speed: 100.0, ..FREE };
    for (name, bar) in [("elastic", elastic), ("plastic", plastic), ("sphere", sphere), ("free wall", free)] {
        for (interaction, is_general) in [(LINEAR, false), (EXPONENTIAL, false), (LINEAR, true)] {
            let bar = Bar { interaction, is_general, ..bar };
            let follows = bar.run("");
            for frequency in [1, 10] {
                let ran = bar.run(&format!("*Adaptive Mesh, elset=SOLID, frequency={frequency}\n"));
                let [end, most] = differences(&ran, &follows, &["ALLKE", "ALLIE", "ALLSE", "ALLPD", "ALLCW"]);
                println!("{name} {interaction:?} {is_general} {frequency}: {:.2} % {:.2} %", 100.0 * end, 100.0 * most);
                assert!(end < 0.02, "{name}, {interaction} every {frequency} increments: {end}");
            }
        }
    }
}

/// New meshes at a wall that has moved away from its place at the start, with the front on either side of its direction, by
/// a contact pair and general contact: energies are those without new meshes within 1 % of the energy put in, and momentum
/// is conserved.
#[test]
fn a_free_wall_does_not_stop_new_meshes() {
    for (wall, interaction, is_general) in
        [(LINE, "", false), (REVERSED, "", false), (LINE, LINEAR, false), (LINE, "", true), (REVERSED, "", true)]
    {
        let bar = Bar { wall, interaction, is_general, ..FREE };
        let (ran, follows) = (bar.run(REMESH), bar.run(""));
        let [end, _] = differences(&ran, &follows, &["ALLKE", "ALLIE", "ALLPD", "ALLCW"]);
        let momentum = ran.momentum() / follows.momentum() - 1.0;
        println!("{} meshes: {:.2} %, momentum {momentum:.1e}", new_meshes(&ran.outcome), 100.0 * end);
        assert!(new_meshes(&ran.outcome) >= 1 && end < 0.01 && momentum.abs() < 1e-12, "{end} {momentum:e}");
    }
}

/// New meshes with soft contact deeper than a penetration that is accepted at the start: energies are those without new
/// meshes within 1 % of the energy put in.
#[test]
fn deep_soft_contact_does_not_stop_new_meshes() {
    for (interaction, is_general) in [(LINEAR, false), (EXPONENTIAL, false), (LINEAR, true)] {
        let bar = Bar { interaction, is_general, ..BAR };
        let (ran, follows) = (bar.run(REMESH), bar.run(""));
        let [end, _] = differences(&ran, &follows, &["ALLKE", "ALLIE", "ALLPD", "ALLCW"]);
        println!("{} meshes: {:.2} %", new_meshes(&ran.outcome), 100.0 * end);
        assert!(new_meshes(&ran.outcome) >= 1 && end < 0.01, "{end}");
    }
}

/// The wall stays fixed after all nodes of another boundary condition, and all elements at the wall, have been deleted.
#[test]
fn a_wall_stays_fixed_when_conditions_lose_their_nodes() {
    for (material, speed) in
        [("*Tensile Failure\n 3e8\n", 150.0), ("*Shear Failure, element deletion=YES\n .15,\n", 600.0)]
    {
        let material = format!("{PLASTIC}{material}");
        let bar = Bar { distortion: 0.0, material: &material, speed, time: 3e-5, ..BAR };
        let ran = bar.run("*Remesh, elset=SOLID, angle=30., frequency=1\n");
        let wall = &ran.state.dofs.bodies[0];
        println!("{} meshes, {} deleted", new_meshes(&ran.outcome), ran.outcome.deleted);
        assert!(new_meshes(&ran.outcome) >= 1 && ran.outcome.deleted > 10);
        assert!(wall.prescribed && wall.displacement == 0.0 && wall.velocity_half == 0.0, "{wall:?}");
    }
}

/// Fragments smaller than an element, which damage has cut off, remain parts of new meshes.
#[test]
fn small_fragments_remain_on_new_meshes() {
    for (speed, displacement) in [(400.0, "1e-5"), (250.0, "5e-5"), (600.0, "1e-5")] {
        let damage = "*Damage Initiation, criterion=DUCTILE\n .05,\n*Damage Evolution, type=DISPLACEMENT\n";
        let material = format!("{PLASTIC}{damage} {displacement},\n");
        let bar = Bar { material: &material, speed, time: 2e-5, ..BAR };
        let ran = bar.run("*Remesh, elset=SOLID, angle=45., frequency=1, size=2e-3\n");
        println!("{speed}: {} meshes, {} deleted", new_meshes(&ran.outcome), ran.outcome.deleted);
        assert!(new_meshes(&ran.outcome) >= 1 && ran.outcome.deleted > 5);
    }
}
