//! Contact of oblique rigid bodies with analytical walls, and loads on them.
//!
//! Goal: plastic bounce of a tilted body, transition of a ball from sliding to rolling, reaction to the weight at rest,
//! pendulum motion in a bowl, gravity, forces, moments and pressures in any direction; balances of momentum and energy.
//! In soft contact oscillation, rebound, damping, shear stresses and energy; walls that move.
//! Sources: Routh, Dynamics of a System of Rigid Bodies, I, 179 (impulse at a point); Lamb, Dynamics, 64 (rolling at
//! 5/7 v0).

use std::f64::consts::PI;

use revolve::solve::Outcome;
use revolve::user::{LoadPoints, Routines};

use crate::common::{self, RecordedOutput};

const MASS: f64 = 0.05;
const GRAVITY: f64 = 9.81;

/// Rigid body with its wall and loads.
#[derive(Clone)]
struct WallScene {
    points: Vec<[f64; 2]>,
    height: f64,
    /// Moments of inertia about the axis and about a transverse axis.
    inertia: [f64; 2],
    angles: [f64; 2],
    starts: [f64; 6],
    /// Data lines of the wall surface.
    wall: String,
    friction: f64,
    /// Options of `*FRICTION`, and other cards of the surface interaction.
    friction_options: &'static str,
    interaction: String,
    /// Boundary conditions of the wall, and its mass.
    wall_motion: &'static str,
    wall_mass: f64,
    contact: &'static str,
    loads: String,
    time: f64,
    accuracy: f64,
}

const PAIR: &str = "*Contact Pair, interaction=RUB\n SKIN, WALL\n";
const FREE: &str = "";

impl WallScene {
    fn new(points: Vec<[f64; 2]>, height: f64) -> WallScene {
        WallScene {
            points,
            height,
            inertia: [1e-6, 8e-6],
            angles: [0.0; 2],
            starts: [0.0; 6],
            wall: floor_plane(-1.0),
            friction: 0.0,
            friction_options: "",
            interaction: String::new(),
            wall_motion: "*Boundary\n WREF, 2, 2\n",
            wall_mass: 0.0,
            contact: PAIR,
            loads: String::new(),
            time: 1e-3,
            accuracy: 1e-4,
        }
    }

    fn deck(&self) -> String {
        let nodes = self.points.iter().enumerate().map(|(i, [r, z])| format!(" {}, {r:e}, {z:e}\n", i + 1));
        let elements = (1..self.points.len()).map(|i| format!(" {i}, {i}, {}\n", i + 1));
        let starts = (1..=6).map(|dof| format!(" REF, {dof}, {:e}\n", self.starts[dof - 1]));
        let WallScene { height, inertia: [axial, across], angles: [a, b], wall, friction, loads, .. } = self;
        let WallScene { friction_options, interaction, wall_motion, wall_mass, contact, time, accuracy, .. } = self;
        let mass_cards = format!("*Element, type=MASS, elset=W\n 9996, 9000\n*Mass, elset=W\n {wall_mass}\n");
        let wall_mass = if *wall_mass > 0.0 { mass_cards } else { String::new() };
        format!(
            "*Node\n{}*Node, nset=REF\n 9999, 0., {height:e}\n*Node, nset=WREF\n 9000, 0., 0.\n\
             *Element, type=RAX2, elset=SKIN\n{}*Element, type=MASS, elset=M\n 9998, 9999\n*Mass, elset=M\n {MASS}\n\
             *Element, type=ROTARYI, elset=I\n 9997, 9999\n*Rotary Inertia, elset=I\n {across:e}, {axial:e}, {across:e}\n\
             {wall_mass}*Rigid Body, ref node=REF, elset=SKIN\n*Attitude, ref node=REF, stations=64\n {a:e}, {b:e}\n\
             *Surface, name=SKIN\n SKIN, SNEG\n*Surface, type=SEGMENTS, name=WALL\n{wall}\
             *Rigid Body, ref node=WREF, analytical surface=WALL\n*Surface Interaction, name=RUB\n\
             {interaction}*Friction{friction_options}\n {friction:e},\n\
             *Initial Conditions, type=VELOCITY\n{}*Step\n*Dynamic, Explicit, accuracy={accuracy:e}\n , {time:e}\n\
             {wall_motion}{contact}{loads}*Output, history, frequency=1\n\
             *Node Output, nset=REF\n U, V, A, UR, VR, AR, TILT\n*Node Output, nset=WREF\n V, RF\n\
             *Contact Output\n CFN, CFS, CAREA\n*Energy Output\n ALLKE, ALLWK, ALLFD, ALLCW, ETOTAL\n*End Step\n",
            nodes.collect::<String>(),
            elements.collect::<String>(),
            starts.collect::<String>(),
        )
    }

    fn run(&self) -> WallRun {
        self.run_with(&Routines::none())
    }

    fn run_with(&self, routines: &Routines) -> WallRun {
        self.run_deck(&self.deck(), routines)
    }

    fn run_deck(&self, deck: &str, routines: &Routines) -> WallRun {
        let prepared = common::prepared(deck, &[], routines);
        let names = prepared.plan.column_names();
        let mut memory = RecordedOutput::default();
        let (outcome, _) = revolve::solve::run(&prepared.plan, prepared.state.clone(), &mut memory);
        assert!(outcome.halt.is_none(), "{:?}", outcome.halt);
        WallRun { names, memory, outcome }
    }
}

struct WallRun {
    names: Vec<String>,
    memory: RecordedOutput,
    outcome: Outcome,
}

impl WallRun {
    fn column(&self, name: &str) -> Vec<f64> {
        let at = self.names.iter().position(|n| n == name).unwrap_or_else(|| panic!("no {name} in {:?}", self.names));
        self.memory.rows.iter().map(|row| row.1[at]).collect()
    }

    fn last(&self, name: &str) -> f64 {
        self.column(name).last().copied().unwrap_or(f64::NAN)
    }

    fn times(&self) -> Vec<f64> {
        self.memory.rows.iter().map(|row| row.0).collect()
    }
}

/// Returns the data lines of a plane that faces +z.
fn floor_plane(z: f64) -> String {
    format!(" START, 0., {z:e}\n LINE, 9., {z:e}\n")
}

fn gravity(direction: [f64; 3]) -> String {
    let [a, b, c] = direction;
    format!("*Dload\n , GRAV, {GRAVITY}, {a:e}, {b:e}, {c:e}\n")
}

fn cylinder(radius: f64, length: f64) -> Vec<[f64; 2]> {
    vec![[0.0, 0.0], [radius, 0.0], [radius, 0.5 * length], [radius, length], [0.0, length]]
}

fn sphere(facets: usize, radius: f64) -> Vec<[f64; 2]> {
    let angle = |i: usize| PI * i as f64 / facets as f64;
    let place = |i: usize| if i == 0 || i == facets { 0.0 } else { radius * angle(i).sin() };
    (0..=facets).map(|i| [place(i), radius * (1.0 - angle(i).cos())]).collect()
}

/// Returns a ball with its axis along 3 and its lowest point at z = 0.
fn ball(radius: f64) -> WallScene {
    let inertia = 0.4 * MASS * radius * radius;
    WallScene {
        inertia: [inertia; 2],
        angles: [0.0, 90.0],
        wall: floor_plane(0.0),
        ..WallScene::new(sphere(24, radius), radius)
    }
}

/// A tilted cylinder falls on its edge: J = v / (1/m + x^2/I), V = -v + J/m, w = x J/I.
#[test]
fn plastic_bounce_of_a_tilted_body_matches_closed_form() {
    let (radius, length, tilt, speed) = (0.006, 0.04, 30.0_f64, 10.0);
    let (sine, cosine) = tilt.to_radians().sin_cos();
    // Edge of the foot at angle 0 on the side towards which the body is tilted.
    let (x, y) = (-radius * cosine + 0.5 * length * sine, -radius * sine - 0.5 * length * cosine);
    let base = WallScene::new(cylinder(radius, length), 0.5 * length);
    let scene = WallScene {
        angles: [tilt, 0.0],
        wall: floor_plane(0.5 * length + y - 1e-4),
        starts: [0.0, -speed, 0.0, 0.0, 0.0, 0.0],
        time: 4e-5,
        accuracy: 1e-8,
        ..base
    };
    let run = scene.run();
    let across = scene.inertia[1];
    let impulse = speed / (1.0 / MASS + x * x / across);
    let expected = [-speed + impulse / MASS, x * impulse / across, 0.5 * speed * impulse];
    let found = [run.last("V2@REF"), run.last("VR3@REF"), run.last("ALLCW")];
    println!("bounce: {found:?}, expected {expected:?}, drift {:e}", run.outcome.energy.drift);
    for (found, expected) in found.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 2e-3, "{found}, expected {expected}");
    }
    assert!(run.last("V1@REF").abs() < 1e-9 && run.outcome.energy.drift < 1e-9);
    // Momentum: contact forces times their duration.
    let (times, forces) = (run.times(), run.column("CFN2@SKIN_WALL"));
    let given: f64 = (1..times.len()).map(|i| forces[i] * (times[i] - times[i - 1])).sum();
    assert!((given / impulse - 1.0).abs() < 2e-3, "{given}, expected {impulse}");
}

/// A sliding ball reaches rolling at 5/7 of its speed; friction dissipates 2/7 of its energy.
#[test]
fn sliding_ball_reaches_rolling_speed() {
    let (radius, speed) = (0.01, 1.0);
    let scene = WallScene {
        starts: [speed, 0.0, 0.0, 0.0, 0.0, 0.0],
        friction: 0.3,
        loads: gravity([0.0, -1.0, 0.0]),
        time: 0.15,
        ..ball(radius)
    };
    let run = scene.run();
    let (v, w) = (run.last("V1@REF"), run.last("VR3@REF"));
    let energy = 0.5 * MASS * speed * speed;
    println!(
        "rolling: v {v}, w r {}, friction {}, drift {:e}",
        w * radius,
        run.last("ALLFD") / energy,
        run.outcome.energy.drift
    );
    assert!((v / (5.0 / 7.0 * speed) - 1.0).abs() < 2e-3 && (w * radius / v + 1.0).abs() < 1e-6);
    assert!((run.last("ALLFD") / energy - 2.0 / 7.0).abs() < 2e-3 && run.last("ALLCW").abs() < 1e-3 * energy);
    assert!((run.last("RF2@WREF") / (MASS * GRAVITY) - 1.0).abs() < 1e-3 && run.outcome.energy.drift < 1e-3);
    assert!((run.last("U2@REF")).abs() < 1e-3 * radius);
}

/// A cylinder on its side: the reaction of the floor is its weight; friction holds it on a slope below the coefficient
/// of friction and not above it.
#[test]
fn body_at_rest_has_its_weight_as_reaction() {
    let scene = |across: f64| WallScene {
        angles: [90.0, 0.0],
        wall: floor_plane(0.02 - 0.006),
        friction: 0.3,
        loads: gravity([across, -1.0, 0.0]),
        time: 0.05,
        ..WallScene::new(cylinder(0.006, 0.04), 0.02)
    };
    let down = |across: f64| MASS * GRAVITY / across.hypot(1.0);
    let still = scene(0.2).run();
    assert_eq!(still.outcome.warnings, Vec::<String>::new());
    let reaction = still.last("RF2@WREF") / down(0.2);
    println!("at rest: reaction {reaction}, speed {:e}, drift {:e}", still.last("V1@REF"), still.outcome.energy.drift);
    assert!((reaction - 1.0).abs() < 1e-6);
    assert!(
        still.last("V1@REF").abs() + still.last("V2@REF").abs() < 1e-6 && (still.last("TILT@REF") - 90.0).abs() < 1e-3
    );
    let slides = scene(0.5).run();
    let expected = 0.05 * GRAVITY * (0.5 - 0.3) / 0.5_f64.hypot(1.0);
    println!("on a slope: {}, expected {expected}", slides.last("V1@REF"));
    assert!((slides.last("V1@REF") / expected - 1.0).abs() < 5e-3 && slides.outcome.energy.drift < 1e-3);
}

/// A frictionless ball in a bowl is a pendulum whose length is the difference of the radii.
#[test]
fn ball_in_a_bowl_moves_as_a_pendulum() {
    let (radius, bowl, angle) = (0.01, 0.11, 0.5_f64);
    let arm = bowl - radius;
    let wall = format!(" START, 0., 0.\n CIRCL, {bowl:e}, {bowl:e}, 0., {bowl:e}\n");
    let speed = (2.0 * GRAVITY * arm * (1.0 - angle.cos())).sqrt();
    let scene = WallScene {
        wall,
        starts: [speed, 0.0, 0.0, 0.0, 0.0, 0.0],
        loads: gravity([0.0, -1.0, 0.0]),
        time: 0.4,
        ..ball(radius)
    };
    let run = scene.run();
    let highest = run.column("U2@REF").into_iter().fold(0.0, f64::max);
    let expected = arm * (1.0 - angle.cos());
    let loss = run.last("ALLCW") / (0.5 * MASS * speed * speed);
    println!("pendulum: rises to {} of {expected}, lost {loss:e}, drift {:e}", highest, run.outcome.energy.drift);
    assert!((highest / expected - 1.0).abs() < 5e-3 && loss.abs() < 1e-2 && run.outcome.energy.drift < 1e-2);
}

/// Gravity along 3, an eccentric force along 1 and a moment about 1, over a time with small rotations.
#[test]
fn forces_and_moments_accelerate_in_all_directions() {
    let time = 1e-3;
    let loads = format!("{}*Cload\n 3, 1, 2.\n 9999, 4, 1e-3\n", gravity([0.0, 0.0, 1.0]));
    let scene = WallScene { angles: [0.0, 30.0], loads, time, ..WallScene::new(cylinder(0.006, 0.04), 0.01) };
    let run = scene.run();
    let (sine, cosine) = 30.0_f64.to_radians().sin_cos();
    // Node 3 is 0.01 above the centre of mass, on the axis (0, cos, sin).
    let [axial, across] = scene.inertia;
    let moment = [1e-3, 2.0 * 0.01 * sine, -2.0 * 0.01 * cosine];
    let along = moment[1] * cosine + moment[2] * sine;
    let spin = along * (1.0 / axial - 1.0 / across);
    let angular = [moment[0] / across, moment[1] / across + spin * cosine, moment[2] / across + spin * sine];
    for (i, expected) in [2.0 / MASS, 0.0, GRAVITY].into_iter().enumerate() {
        assert!((run.last(&format!("V{}@REF", i + 1)) - expected * time).abs() < 1e-9);
    }
    for (i, expected) in angular.into_iter().enumerate() {
        let found = run.last(&format!("VR{}@REF", i + 1));
        assert!((found - expected * time).abs() < 2e-2 * norm(angular) * time, "{found}, expected {}", expected * time);
    }
    assert!(run.outcome.energy.drift < 1e-6, "{}", run.outcome.energy.drift);
}

fn norm([a, b, c]: [f64; 3]) -> f64 {
    a.hypot(b).hypot(c)
}

/// A uniform pressure on the foot of a tilted body acts along its axis, as a prescribed pressure and as a user load.
#[test]
fn pressure_acts_along_the_axis_of_a_tilted_body() {
    let (radius, pressure, time) = (0.006, 1e5, 1e-4);
    let scene = |loads: &str| WallScene {
        angles: [20.0, 35.0],
        loads: format!("*Dsload\n FOOT, {loads}\n"),
        time,
        ..WallScene::new(cylinder(radius, 0.04), 0.02)
    };
    let run = |scene: &WallScene, routines: &Routines| {
        let scene = WallScene { wall: scene.wall.clone(), ..scene.clone() };
        let deck = scene.deck().replace(
            "*Surface, name=SKIN\n",
            "*Elset, elset=FOOT\n 1\n*Surface, name=FOOT\n FOOT, SNEG\n*Surface, name=SKIN\n",
        );
        let prepared = common::prepared(&deck, &[], routines);
        let names = prepared.plan.column_names();
        let mut memory = RecordedOutput::default();
        let (outcome, _) = revolve::solve::run(&prepared.plan, prepared.state.clone(), &mut memory);
        WallRun { names, memory, outcome }
    };
    let uniform = run(&scene(&format!("P, {pressure:e}")), &Routines::none());
    let routine = Routines::none().with_pressure(move |_: &LoadPoints<'_>, _| pressure);
    let own = run(&scene("PNU"), &routine);
    let expected = pressure * PI * radius * radius / MASS * time;
    let velocity = |run: &WallRun| [1, 2, 3].map(|i| run.last(&format!("V{i}@REF")));
    let (a, b) = (velocity(&uniform), velocity(&own));
    println!("pressure: {a:?} and {b:?}, {}, expected {expected}", norm(a));
    assert!((norm(a) / expected - 1.0).abs() < 1e-9 && (norm(b) / expected - 1.0).abs() < 1e-9);
    assert!((0..3).all(|i| (a[i] - b[i]).abs() < 1e-9 * expected));
    assert!(own.column("VR3@REF").iter().all(|w| w.abs() < 1e-6));
    // A user load receives the spatial normal velocity, which is the full velocity of a foot that moves along its axis.
    let seen = std::sync::Arc::new(std::sync::Mutex::new(0.0_f64));
    let noted = seen.clone();
    let routine = Routines::none().with_pressure(move |points: &LoadPoints<'_>, i| {
        let normal = points.velocity_r[i] * points.normal_r[i] + points.velocity_z[i] * points.normal_z[i];
        let mut most = noted.lock().expect("one thread");
        *most = most.max(-normal);
        pressure
    });
    run(&scene("PNU"), &routine);
    let most = *seen.lock().expect("one thread");
    assert!((most / expected - 1.0).abs() < 1e-6, "{most}, expected {expected}");
}

/// Returns a cylinder of radius 6 mm above a soft floor of the stiffness 1e10 N/m³, which it hits with 5 m/s, and the
/// stiffness of its foot.
fn cylinder_on_soft_floor() -> (WallScene, f64) {
    let (radius, length, stiffness) = (0.006, 0.04, 1e10);
    let scene = WallScene {
        wall: floor_plane(-1e-4),
        starts: [0.0, -5.0, 0.0, 0.0, 0.0, 0.0],
        interaction: format!("*Surface Behavior, pressure-overclosure=LINEAR\n {stiffness:e},\n"),
        ..WallScene::new(cylinder(radius, length), 0.5 * length)
    };
    (scene, stiffness * PI * radius * radius)
}

/// Returns the time in which a column is not zero.
fn time_of_force(run: &WallRun, name: &str) -> f64 {
    let (times, forces) = (run.times(), run.column(name));
    (1..times.len()).filter(|&i| forces[i] != 0.0).map(|i| times[i] - times[i - 1]).sum()
}

/// A cylinder that spins about its axis hits a soft floor with its foot: it is half a period of an oscillator in
/// contact, has the area of its foot, and rebounds with its velocity. The shank does not add stiffness.
#[test]
fn flat_cylinder_rebounds_from_a_soft_floor_after_half_a_period() {
    let (scene, stiffness) = cylinder_on_soft_floor();
    let scene = WallScene { starts: [0.0, -5.0, 0.0, 0.0, 100.0, 0.0], ..scene };
    let run = scene.run();
    let frequency = (stiffness / MASS).sqrt();
    let force = run.column("CFN2@SKIN_WALL").into_iter().fold(0.0, f64::max) / (5.0 * (stiffness * MASS).sqrt());
    let (time, area) = (time_of_force(&run, "CFN2@SKIN_WALL"), run.column("CAREA@SKIN_WALL"));
    let area = area.into_iter().fold(0.0, f64::max) / (PI * 0.006 * 0.006);
    let rebound = run.last("V2@REF") / 5.0;
    let lost = run.last("ALLCW") / (0.5 * MASS * 25.0);
    println!(
        "soft floor: time {}, force {force}, area {area}, rebound {rebound}, ALLCW {lost:e}",
        time * frequency / PI
    );
    println!("{} increments, drift {:e}", run.memory.rows.len(), run.outcome.energy.drift);
    assert!((time * frequency / PI - 1.0).abs() < 0.03 && (force - 1.0).abs() < 2e-3 && (area - 1.0).abs() < 1e-12);
    assert!((rebound - 1.0).abs() < 2e-3 && lost.abs() < 4e-3 && run.outcome.energy.drift < 1e-12);
    assert!((run.last("VR2@REF") / 100.0 - 1.0).abs() < 1e-12 && run.last("TILT@REF") < 1e-9);
}

/// A cylinder of one element whose nodes move together, in axisymmetric contact with the same floor.
fn coupled_cylinder(interaction: &str, [increment, time]: [f64; 2]) -> String {
    let density = MASS / (PI * 0.006 * 0.006 * 0.04);
    format!(
        "*Node\n 1, 0., 0.\n 2, 0.006, 0.\n 3, 0.006, 0.04\n 4, 0., 0.04\n*Node, nset=WREF\n 9000, 0., 0.\n\
         *Nset, nset=REF\n 1\n*Nset, nset=ALL\n 1, 2, 3, 4\n*Element, type=CAX4R, elset=BODY\n 1, 1, 2, 3, 4\n\
         *Solid Section, elset=BODY, material=SOFT\n*Material, name=SOFT\n*Density\n {density:e},\n\
         *Elastic\n 1e6, 0.3\n*MPC\n BEAM, 2, 1\n BEAM, 3, 1\n BEAM, 4, 1\n*Surface, name=SKIN\n BODY, S1\n\
         *Surface, type=SEGMENTS, name=WALL\n{}*Rigid Body, ref node=WREF, analytical surface=WALL\n\
         *Surface Interaction, name=RUB\n{interaction}*Initial Conditions, type=VELOCITY\n ALL, 2, -5.\n*Step\n\
         *Dynamic, Explicit, direct user control\n {increment:e}, {time:e}\n*Boundary\n WREF, 2, 2\n ALL, 1, 1\n\
         {PAIR}*Output, history, frequency=1\n*Node Output, nset=REF\n V\n*Contact Output\n CFN, CAREA\n*End Step\n",
        floor_plane(-1e-4)
    )
}

/// At angle zero, soft contact is the limit of axisymmetric contact for small increments, which has an error of first
/// order in the increment.
#[test]
fn upright_cylinder_has_the_limit_of_axisymmetric_contact() {
    let (scene, stiffness) = cylinder_on_soft_floor();
    let (increment, time) = (PI / (stiffness / MASS).sqrt() / 400.0, 8e-4);
    let results = |run: &WallRun| {
        let most = |name: &str| run.column(name).into_iter().fold(0.0, f64::max);
        [run.last("V2@REF"), most("CFN2@SKIN_WALL"), most("CAREA@SKIN_WALL")]
    };
    let axisymmetric = |dt: f64| {
        let deck = coupled_cylinder(&scene.interaction, [dt, time]);
        results(&scene.run_deck(&deck, &Routines::none()))
    };
    let (coarse, fine, oblique) = (axisymmetric(increment), axisymmetric(0.5 * increment), results(&scene.run()));
    println!("axisymmetric {coarse:?}, {fine:?}, oblique {oblique:?}");
    for i in 0..3 {
        let limit = 2.0 * fine[i] - coarse[i];
        assert!((oblique[i] / limit - 1.0).abs() < 2e-3, "{} {limit}", oblique[i]);
    }
}

/// A ball with its axis along a soft floor sinks from rest until its weight has done the work of the pressure, `pi k o³
/// (R/3 - o/12)` at the overlap o; the error decreases with the number of stations.
#[test]
fn ball_on_a_soft_floor_sinks_by_its_weight() {
    let (radius, stiffness, overlap) = (0.01, 1e9, 1e-4);
    let weight = PI * stiffness * overlap * overlap * (radius / 3.0 - overlap / 12.0);
    let deepest = |stations: usize, facets: usize| {
        let scene = WallScene {
            points: sphere(facets, radius),
            interaction: format!("*Surface Behavior, pressure-overclosure=LINEAR\n {stiffness:e},\n"),
            loads: format!("*Dload\n , GRAV, {:e}, 0., -1., 0.\n", weight / MASS),
            time: 0.02,
            ..ball(radius)
        };
        let deck = scene.deck().replace("stations=64", &format!("stations={stations}"));
        let run = scene.run_deck(&deck, &Routines::none());
        -run.column("U2@REF").into_iter().fold(0.0, f64::min) / overlap
    };
    let errors = [(64, 32), (128, 64), (256, 128)].map(|(stations, facets)| deepest(stations, facets) - 1.0);
    println!("ball on a soft floor: errors of the largest overlap {errors:?}");
    assert!(errors[2].abs() < 5e-3 && errors[2].abs() < 0.4 * errors[0].abs());
}

/// A cylinder at 45 degrees hits a stiff soft floor with its edge: elastic impulse at a point, J = 2 v / (1/m + x²/I), and
/// no loss of energy.
#[test]
fn elastic_bounce_of_a_tilted_body_matches_closed_form() {
    let (scene, _) = cylinder_on_soft_floor();
    let (radius, length, speed) = (0.006, 0.04, 5.0);
    let half = 0.5_f64.sqrt();
    let (x, y) = ((0.5 * length - radius) * half, -(0.5 * length + radius) * half);
    let scene = WallScene {
        angles: [45.0, 0.0],
        wall: floor_plane(0.5 * length + y - 1e-5),
        interaction: "*Surface Behavior, pressure-overclosure=LINEAR\n 1e16,\n".into(),
        time: 2e-4,
        ..scene
    };
    let run = scene.run();
    let across = scene.inertia[1];
    let impulse = 2.0 * speed / (1.0 / MASS + x * x / across);
    let expected = [-speed + impulse / MASS, x * impulse / across];
    let found = [run.last("V2@REF"), run.last("VR3@REF")];
    let lost = run.last("ALLCW") / (0.5 * MASS * speed * speed);
    println!("elastic bounce: {found:?}, expected {expected:?}, ALLCW {lost:e}, {} increments", run.memory.rows.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 3e-3, "{found}, expected {expected}");
    }
    assert!(lost.abs() < 1e-4 && run.last("V1@REF").abs() < 1e-6 && run.outcome.energy.drift < 1e-12);
}

/// Friction on the foot of a pressed cylinder is limited by TAUMAX times its area, in any direction of the slip.
#[test]
fn shear_stress_is_limited_by_taumax() {
    let (scene, stiffness) = cylinder_on_soft_floor();
    let (largest, area, time, overlap) = (1e4, PI * 0.006 * 0.006, 1e-3, 1e-5);
    let scene = WallScene {
        starts: [1.6, 0.0, 1.2, 0.0, 0.0, 0.0],
        inertia: [1e3, 1e3],
        wall: floor_plane(overlap),
        friction: 0.5,
        friction_options: ", taumax=1e4",
        loads: format!("*Dload\n , GRAV, {:e}, 0., -1., 0.\n", stiffness * overlap / MASS),
        time,
        ..scene
    };
    let run = scene.run();
    let slowed = largest * area / MASS * time;
    let expected = [1.6 * (1.0 - slowed / 2.0), 1.2 * (1.0 - slowed / 2.0)];
    let found = [run.last("V1@REF"), run.last("V3@REF")];
    println!("TAUMAX: {found:?}, expected {expected:?}, drift {:e}", run.outcome.energy.drift);
    assert!((0..2).all(|i| (found[i] - expected[i]).abs() < 1e-6 * slowed));
    assert!((run.last("ALLFD") / (largest * area * (2.0 - 0.5 * slowed) * time) - 1.0).abs() < 1e-2);
}

/// A damped oscillator that cannot be pulled rebounds with exp(-c (pi - atan(2 c s / (1 - 2 c²))) / s), s = sqrt(1 - c²),
/// for the fraction c of the critical damping.
#[test]
fn damped_floor_has_the_rebound_of_a_damped_oscillator() {
    let (mut scene, _) = cylinder_on_soft_floor();
    let fraction = 0.1_f64;
    scene.interaction += "*Contact Damping, definition=CRITICAL DAMPING FRACTION\n 0.1,\n";
    let run = scene.run();
    let s = (1.0 - fraction * fraction).sqrt();
    let angle = PI - (2.0 * fraction * s / (1.0 - 2.0 * fraction * fraction)).atan();
    let expected = (-fraction / s * angle).exp();
    println!("damped rebound: {}, expected {expected}", run.last("V2@REF") / 5.0);
    assert!((run.last("V2@REF") / 5.0 / expected - 1.0).abs() < 1e-2);
    let lost = run.last("ALLCW") / (0.5 * MASS * 25.0);
    assert!((lost - (1.0 - expected * expected)).abs() < 1e-2 && run.outcome.energy.drift < 1e-12);
}

/// A wall of three times the mass of the body: elastic in soft contact, with the period of the reduced mass, and plastic
/// in hard contact.
#[test]
fn free_wall_takes_momentum_and_energy() {
    let (scene, stiffness) = cylinder_on_soft_floor();
    let free = WallScene { wall_motion: FREE, wall_mass: 3.0 * MASS, ..scene };
    let soft = free.run();
    let reduced = MASS * 0.75;
    let time = time_of_force(&soft, "CFN2@SKIN_WALL") * (stiffness / reduced).sqrt() / PI;
    let found = ["V2@REF", "V2@WREF"].map(|name| soft.last(name));
    println!("free wall: soft {found:?}, time {time}, drift {:e}", soft.outcome.energy.drift);
    assert!((found[0] - 2.5).abs() < 1e-2 && (found[0] + 3.0 * found[1] + 5.0).abs() < 1e-10);
    assert!((time - 1.0).abs() < 0.03 && soft.outcome.energy.drift < 1e-12);
    let hard = WallScene { interaction: String::new(), ..free.clone() }.run();
    let found = ["V2@REF", "V2@WREF", "ALLCW"].map(|name| hard.last(name));
    println!("free wall: hard {found:?}, drift {:e}", hard.outcome.energy.drift);
    assert!(found[..2].iter().all(|v| (v + 1.25).abs() < 1e-9) && hard.outcome.energy.drift < 1e-9);
    assert!((found[2] / (0.5 * reduced * 25.0) - 1.0).abs() < 1e-9);
    // An oblique impact with friction conserves momentum, too.
    let tilted = WallScene { angles: [30.0, 20.0], friction: 0.3, wall: floor_plane(-1e-3), time: 3e-3, ..free };
    let hard = WallScene { interaction: String::new(), ..tilted.clone() };
    for run in [tilted.run(), hard.run()] {
        let momentum = run.last("V2@REF") + 3.0 * run.last("V2@WREF") + 5.0;
        println!("tilted: momentum {momentum:e}, ALLCW {}, drift {:e}", run.last("ALLCW"), run.outcome.energy.drift);
        assert!(run.last("V2@REF") > -4.0 && momentum.abs() < 1e-10 && run.outcome.energy.drift < 1e-9);
    }
}

/// A wall that moves with 5 m/s throws a body at rest with twice its velocity if it is soft and with its velocity if it is
/// hard, and does the work of its force.
#[test]
fn moving_wall_throws_the_body() {
    let (scene, _) = cylinder_on_soft_floor();
    let wall_motion = "*Boundary, type=VELOCITY\n WREF, 2, 2, 5.\n";
    let soft = WallScene { wall_motion, starts: [0.0; 6], ..scene };
    let hard = WallScene { interaction: String::new(), ..soft.clone() };
    for (scene, velocity, lost) in [(soft, 10.0, 0.0), (hard, 5.0, 0.5 * MASS * 25.0)] {
        let run = scene.run();
        let work = run.last("ALLWK") - run.column("ALLWK")[0];
        println!("moving wall: {}, work {work}, ALLCW {}", run.last("V2@REF"), run.last("ALLCW"));
        assert!((run.last("V2@REF") / velocity - 1.0).abs() < 2e-3 && run.outcome.energy.drift < 1e-9);
        assert!((work / (MASS * 5.0 * run.last("V2@REF")) - 1.0).abs() < 1e-9);
        assert!((run.last("ALLCW") - lost).abs() < 4e-3 * 0.5 * MASS * 100.0);
    }
}

/// General contact includes the same wall with the same laws.
#[test]
fn general_contact_with_a_wall_is_that_of_the_pair() {
    let (scene, _) = cylinder_on_soft_floor();
    let tilted = WallScene { friction: 0.2, starts: [1.0, -5.0, 0.0, 0.0, 0.0, 0.0], angles: [20.0, 0.0], ..scene };
    // An attitude of zero angles and axial motion: the body has six degrees of freedom because of the contact alone.
    let upright = WallScene { starts: [0.0, -5.0, 0.0, 0.0, 0.0, 0.0], angles: [0.0; 2], ..tilted.clone() };
    let contact = "*Contact\n*Contact Inclusions, all exterior\n*Contact Property Assignment\n , , RUB\n";
    for (pair, interaction) in
        [(&tilted, tilted.interaction.clone()), (&tilted, String::new()), (&upright, upright.interaction.clone())]
    {
        let pair = WallScene { interaction, wall: floor_plane(-1e-2), time: 4e-3, ..pair.clone() };
        let general = WallScene { contact, ..pair.clone() };
        let velocities = |run: &WallRun| ["V1@REF", "V2@REF", "VR3@REF"].map(|name| run.last(name).to_bits());
        let (pair, general) = (pair.run(), general.run());
        assert!(pair.last("V2@REF") > -4.0, "{}", pair.last("V2@REF"));
        assert_eq!(velocities(&pair), velocities(&general));
    }
}

/// A body at rest on a soft floor remains at rest when a step changes the friction of its pair: the contact continues with
/// its whole impulse.
#[test]
fn change_of_a_pair_does_not_move_a_body_at_rest() {
    let (scene, stiffness) = cylinder_on_soft_floor();
    let weight = MASS * GRAVITY;
    let scene = WallScene {
        starts: [0.0; 6],
        wall: floor_plane(weight / stiffness),
        loads: gravity([0.0, -1.0, 0.0]),
        ..scene
    };
    let second = format!("*Surface Interaction, name=ROUGHER\n{}*Friction\n 0.3,\n", scene.interaction);
    // Velocities in contact belong to instants between equal increments.
    let deck = scene.deck().replace(", accuracy=1e-4\n ,", ", direct user control\n 1e-5,");
    let deck = deck.replace("*Initial Conditions", &(second + "*Initial Conditions"));
    let output = &deck[deck.find("*Output").expect("an output")..];
    let changed = PAIR.replace("RUB", "ROUGHER");
    let deck = format!("{deck}*Step\n*Dynamic, Explicit, direct user control\n 1e-5, 1e-3\n{changed}{output}");
    let run = scene.run_deck(&deck, &Routines::none());
    // In the first increment, forces act over half the increment.
    let fastest = run.column("V2@REF").into_iter().skip(2).fold(0.0, |most: f64, v| most.max(v.abs()));
    let reaction = run.last("RF2@WREF") / weight;
    println!("change of a pair: speed {fastest:e}, reaction {reaction}, {} rows", run.memory.rows.len());
    assert!(run.times().last().is_some_and(|time| *time > 1.5e-3));
    // With half an impulse less the body would fall with GRAVITY * 5e-6.
    assert!(fastest < 1e-9 * GRAVITY * 1e-5 && (reaction - 1.0).abs() < 1e-9);
}

/// Unsupported contact options are errors with a reason.
#[test]
fn unsupported_wall_contact_is_an_error() {
    let scene = WallScene { friction: 0.3, ..ball(0.01) };
    let penalty = "*Contact Pair, interaction=RUB, mechanical constraint=PENALTY\n SKIN, WALL\n";
    let adjusted = "*Contact Pair, interaction=RUB, adjust=0.001\n SKIN, WALL\n";
    let cases = [
        (WallScene { friction_options: ", taumax=1e4", ..scene.clone() }, "P132", "not unique"),
        (WallScene { contact: adjusted, ..scene.clone() }, "P132", "an initial clearance"),
        (WallScene { contact: penalty, ..scene }, "P021", "penalty stiffness cannot be computed"),
    ];
    for (scene, code, reason) in cases {
        let prepared = revolve::job::prepare_text("wall.inp", &scene.deck(), &[], &Routines::none());
        let text = prepared.diagnostics.render(&prepared.deck.sources);
        assert!(text.contains(code) && text.contains(reason), "{text}");
    }
}
