//! Scenes of two bodies that meet at corners, sides and slopes.
//!
//! Goal: the energy balance closes, contact creates no energy, momentum is conserved, forces are smooth.
//! Source: conservation laws; bounds are the values found.

use std::fmt::Write as _;

use revolve::output::OutputFrame;
use revolve::solve::Energy;

use crate::common::bodies::{DeckRun, assembly, cell_field, elastic, part, point_field, rigid_line, run};
use crate::common::random::RandomSequence;
use crate::common::solid::WHOLE_VISCOSITY;

const SKIN: &str = "*Surface, name=SKIN\n EI0, S4\n EI1, S2\n EJ0, S1\n EJ1, S3\n";

/// Block whose face towards the other block is wavy.
struct WavyBlock {
    cells: [usize; 2],
    from: f64,
    width: f64,
    height: f64,
    wave: [f64; 4],
}

impl WavyBlock {
    fn new(dice: &mut RandomSequence) -> WavyBlock {
        let from = if dice.next() < 0.5 { 0.0 } else { dice.between(0.2, 1.0) };
        WavyBlock {
            cells: [dice.count(2, 5), dice.count(2, 5)],
            from,
            width: dice.between(0.5, 1.5),
            height: dice.between(0.5, 1.2),
            wave: [dice.between(0.0, 0.15), dice.between(1.0, 6.0), dice.between(0.0, 6.0), dice.between(-0.3, 0.3)],
        }
    }

    fn radius(&self, i: usize) -> f64 {
        self.from + self.width * i as f64 / self.cells[0] as f64
    }

    /// Returns the axial position of the wavy face at a column of nodes.
    fn face(&self, i: usize) -> f64 {
        let [amplitude, number, phase, slope] = self.wave;
        amplitude * libm::sin(number * self.radius(i) + phase) + slope * (self.radius(i) - self.from - 0.5 * self.width)
    }

    /// Returns the highest (`sign` 1) or lowest (`sign` -1) point of the face, times `sign`.
    fn extreme(&self, sign: f64) -> f64 {
        (0..=self.cells[0]).map(|i| sign * self.face(i)).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Returns the deck of a random scene, run at `factor` times the stable increment, and its description.
fn random_scene(seed: u64, factor: f64) -> (String, String) {
    let mut dice = RandomSequence(seed);
    let [lower, upper] = [WavyBlock::new(&mut dice), WavyBlock::new(&mut dice)];
    let apart = lower.extreme(1.0) + upper.extreme(-1.0) + 0.01;
    let below = |i: usize, j: usize| {
        let part = j as f64 / lower.cells[1] as f64;
        [lower.radius(i), part * lower.face(i) - (1.0 - part) * lower.height]
    };
    let above = |i: usize, j: usize| {
        let part = j as f64 / upper.cells[1] as f64;
        [upper.radius(i), apart + (1.0 - part) * upper.face(i) + part * upper.height]
    };
    let rigid = dice.next() < 0.25;
    let (speed, sideways) = (dice.between(0.01, 0.1), dice.one_of(&[0.0, 0.02, -0.02]));
    let friction = dice.one_of(&[0.0, 0.05, 0.1, 0.3]);
    let material = |name: &str, dice: &mut RandomSequence| {
        let yields = dice.one_of(&[0.0, 0.01, 0.03]);
        let plastic =
            if yields > 0.0 { format!("*Plastic\n {yields}, 0.\n {}, 1.\n", 2.0 * yields) } else { String::new() };
        let numbers = [dice.one_of(&[0.5, 1.0, 4.0]), dice.one_of(&[0.0, 0.3, 0.45]), dice.between(0.5, 2.0)];
        elastic(name, numbers, &plastic)
    };
    let materials = material("LOWER", &mut dice) + &material("UPPER", &mut dice);
    let more = if rigid { "*Rigid Body, ref node=UPPER.REF, elset=UPPER.SOLID\n" } else { "" };
    let top = if rigid { format!("{SKIN}*Node, nset=REF\n 1000, 0., 0.\n") } else { SKIN.into() };
    let moving = if rigid { "UPPER.REF" } else { "UPPER.ALL" };
    let pair = if dice.next() < 0.5 { "LOWER.SKIN, UPPER.SKIN" } else { "UPPER.SKIN, LOWER.SKIN" };
    let mut deck = part("LOWER", lower.cells, below, SKIN) + &part("UPPER", upper.cells, above, &top);
    deck += &assembly(&["LOWER", "UPPER"], more);
    deck += &materials;
    write!(
        deck,
        "*Surface Interaction, name=DRY\n*Friction\n {friction},\n*Initial Conditions, type=VELOCITY\n {moving}, 2, {}\n \
         LOWER.ALL, 2, {speed}\n LOWER.ALL, 1, {sideways}\n*Step\n*Dynamic, Explicit, scale factor={factor}\n , {}\n*Contact Pair, interaction=DRY\n {pair}\n\
         *Output, history, frequency=1\n*Energy Output\n ALLCW, ALLKE\n*End Step\n",
        -speed,
        dice.between(4.0, 8.0) / (speed / 0.05).max(1.0)
    )
    .expect("text");
    (deck, format!("rigid {rigid}, friction {friction}, speed {speed:.3}"))
}

/// Returns the largest energy created by contact over the initial energy, the momentum error over the momentum of that
/// energy, and the final energies.
fn balance_errors(seed: u64, factor: f64) -> (f64, f64, Energy) {
    let (deck, what) = random_scene(seed, factor);
    let ran = run(&deck).whole();
    let energy = ran.outcome.energy;
    let momentum = (ran.momentum() - momentum_at_start(&ran)).abs() / (2.0 * energy.initial).sqrt();
    let created = ran.column("ALLCW").iter().fold(0.0_f64, |most, c| most.max(-c[1])) / energy.initial;
    assert!(momentum < 1e-13, "scene {seed} ({what}): {momentum:e}");
    assert!(energy.friction > -1e-12 * energy.initial, "scene {seed} ({what}): {energy:?}");
    (created, momentum, energy)
}

/// Returns the deck of a random scene with soft contact: penalty springs or one of the pressure-overclosure
/// relationships, of a stiffness between a third of that of the elements and 30 times as much.
fn soft_scene(seed: u64) -> String {
    let deck = random_scene(seed, 1.0).0;
    let mut dice = RandomSequence(seed ^ 0x50f7);
    let stiffness = 10_f64.powf(dice.between(-0.5, 1.5));
    let behavior = match dice.count(0, 3) {
        0 => {
            return deck.replace("interaction=DRY", "interaction=DRY, cpset=P, mechanical constraint=PENALTY").replace(
                "*Contact Pair",
                &format!("*Contact Controls, cpset=P, scale penalty={}\n*Contact Pair", stiffness / 50.0),
            );
        }
        1 => format!("LINEAR\n {},\n", 5.0 * stiffness),
        2 => format!("EXPONENTIAL\n 0.003, {}\n", 0.01 * dice.between(0.4, 2.0)),
        _ => format!("TABULAR\n 0., 0.\n {}, 0.01\n {}, 0.03\n", 0.02 * stiffness, 0.2 * stiffness),
    };
    deck.replace("name=DRY\n", &format!("name=DRY\n*Surface Behavior, pressure-overclosure={behavior}"))
}

/// Runs scenes with soft contact at corners, edges and slopes: the energy that contact has absorbed is never below -1e-6 of
/// the largest energy, and momentum is conserved.
fn run_soft_scenes(seeds: std::ops::Range<u64>) {
    let (mut worst, mut met, count) = (0.0_f64, 0, seeds.clone().count());
    for seed in seeds {
        let ran = run(&soft_scene(seed).replace("ALLCW, ALLKE", "ALLCW, ALLKE, ALLPW"));
        assert_eq!(ran.outcome.halt, None, "scene {seed}");
        let has_springs = ran.prepared.plan.columns.iter().any(|c| c.name == "ALLPW");
        let penalty = if has_springs { ran.column("ALLPW") } else { Vec::new() };
        let (contact, energy) = (ran.column("ALLCW"), ran.outcome.energy);
        let absorbed = contact.iter().enumerate().map(|(at, c)| c[1] + penalty.get(at).map_or(0.0, |p| p[1]));
        let least = absorbed.fold(0.0_f64, f64::min) / energy.initial;
        let momentum = (ran.momentum() - momentum_at_start(&ran)).abs() / (2.0 * energy.initial).sqrt();
        assert!(least > -1e-6 && momentum < 1e-13, "scene {seed}: {least:e} {momentum:e}");
        worst = worst.min(least);
        met += usize::from(energy.contact + energy.penalty.unwrap_or(0.0) > 1e-6 * energy.initial);
    }
    println!("{count} scenes with soft contact, {met} meet: at worst {worst:.1e} of the energy");
    assert!(4 * met > 3 * count, "{met}");
}

#[test]
fn soft_contact_in_random_scenes_creates_no_energy() {
    run_soft_scenes(0..200);
}

#[test]
#[ignore = "half a minute"]
fn soft_contact_in_a_thousand_scenes_creates_no_energy() {
    run_soft_scenes(0..1000);
}

/// In 200 scenes contact creates no energy and the centre of mass keeps its motion, with the stable increment and with
/// a quarter of that increment. The drift of the energy balance decreases with the increment, because strains are large
/// and meshes coarse.
#[test]
fn contact_in_random_scenes_creates_no_energy() {
    for (factor, [middle, most]) in [(1.0, [1e-3, 3e-2]), (0.25, [1e-4, 5e-3])] {
        let (mut worst, mut met, mut drifts) = ([0.0_f64; 2], 0, Vec::new());
        for seed in 0..200 {
            let (created, momentum, energy) = balance_errors(seed, factor);
            assert!(created < 1e-6, "scene {seed}: {created:e} {energy:?}");
            met += usize::from(energy.contact > 1e-6 * energy.initial);
            worst = [worst[0].max(created), worst[1].max(momentum)];
            drifts.push(energy.drift);
        }
        drifts.sort_by(f64::total_cmp);
        println!(
            "200 scenes at {factor}, {met} meet: created {:.1e}, momentum {:.1e}; drift {:.1e} in the middle, {:.1e} at most",
            worst[0], worst[1], drifts[100], drifts[199]
        );
        assert!(met > 150, "{met}");
        assert!(drifts[100] < middle && drifts[199] < most, "{drifts:?}");
    }
}

/// Scenes most of which last fewer than 100 increments. Contact closes the predicted gaps with the geometry of the
/// previous increment. If a node slides over several facets of different slope within an increment, the error has
/// either sign. A few of 1000 scenes therefore create more than 1e-6 of the energy at the stable increment. At a
/// quarter of the increment they create at most a tenth of that, or less than 1e-6. `cargo test --release --test
/// verification contact_scenes -- --ignored --nocapture`
#[test]
#[ignore = "a search, without a fixed bound"]
fn energy_created_by_contact_decreases_with_the_increment() {
    let created: Vec<_> = (200..2200).map(|seed| (seed, balance_errors(seed, 1.0).0)).filter(|c| c.1 > 1e-6).collect();
    for &(seed, full) in &created {
        let quarter = balance_errors(seed, 0.25).0;
        println!("scene {seed}: created {full:.1e}, {quarter:.1e} with a quarter of the increment");
        assert!(full < 2e-3 && quarter < 1e-6_f64.max(0.1 * full), "{seed}");
    }
    println!("{} of 2000 scenes create more than 1e-6", created.len());
    assert!(created.len() < 20);
}

/// Returns the initial axial momentum.
fn momentum_at_start(ran: &DeckRun) -> f64 {
    let (nodes, bodies) = (&ran.prepared.state.dofs.nodes, &ran.prepared.state.dofs.bodies);
    let of_nodes: f64 = nodes.as_slice().iter().zip(&nodes.mass).map(|(n, m)| m * n.v_z).sum();
    of_nodes + bodies.iter().map(|b| b.mass * b.velocity).sum::<f64>()
}

/// Runs a rigid nose with the given corners, from the top to the axis, and a mass, at 60 m/s into a block of E = 70 GPa
/// and yield stress 0.3 GPa, which keeps its mesh; mm, t, s.
fn run_nose(mass: f64, corners: &[[f64; 2]], cells: usize) -> DeckRun {
    let place = |i: usize, j: usize| [10.0 * i as f64 / cells as f64, 10.0 * (j as f64 / cells as f64 - 1.0)];
    let point = format!("*Element, type=MASS, elset=M\n 900, 1000\n*Mass, elset=M\n {mass:e},\n");
    let deck = part("BLOCK", [cells; 2], place, "")
        + &rigid_line("NOSE", corners, &point)
        + &assembly(&["BLOCK", "NOSE"], "*Rigid Body, ref node=NOSE.REF, elset=NOSE.E\n")
        + &elastic("BLOCK", [70e3, 0.3, 2.7e-9], "*Plastic\n 300., 0.\n 400., 1.\n")
        + "*Remesh, automatic=NO\n*Surface Interaction, name=DRY\n*Initial Conditions, type=VELOCITY\n NOSE.REF, 2, -6e4\n*Step\n*Dynamic, Explicit\n , 5e-5\n"
        + WHOLE_VISCOSITY
        + "*Boundary\n BLOCK.J0, 2, 2\n*Contact Pair, interaction=DRY\n NOSE.SKIN, BLOCK.J1\n\
           *Output, field, number interval=20\n*Node Output\n U\n*Output, history, frequency=1\n*Node Output, nset=NOSE.REF\n A2, V2, U2\n\
           *Energy Output\n ALLCW\n*End Step\n";
    run(&deck).whole()
}

/// Returns the largest penetration of nose corners into the nearest facet of the upper face of the block.
fn largest_penetration(ran: &DeckRun, corners: &[[f64; 2]], cells: usize, frame: &OutputFrame, moved: f64) -> f64 {
    let (mesh, u) = (&ran.prepared.plan.mesh, point_field(frame, "U"));
    let first = (0..mesh.points.len()).find(|&n| mesh.node_names[n] == format!("BLOCK.{}", 1 + cells * (cells + 1)));
    let first = first.expect("the face");
    let face: Vec<_> = (first..=first + cells).map(|n| [0, 1].map(|i| mesh.points[n][i] + u[2 * n + i])).collect();
    let depth = |&[r, z]: &[f64; 2]| {
        let place = [r, z + moved];
        let along = |w: &[[f64; 2]]| [w[1][0] - w[0][0], w[1][1] - w[0][1]];
        let over = face.windows(2).find(|w| w[0][0] <= r && r < w[1][0]);
        let above = over.map_or(0.0, |w| w[0][1] + along(w)[1] * (r - w[0][0]) / along(w)[0] - place[1]);
        let nearest = face.windows(2).map(|w| {
            let ([dr, dz], d) = (along(w), [place[0] - w[0][0], place[1] - w[0][1]]);
            let part = ((d[0] * dr + d[1] * dz) / (dr * dr + dz * dz)).clamp(0.0, 1.0);
            (d[0] - part * dr).hypot(d[1] - part * dz)
        });
        if above > 0.0 { nearest.fold(above, f64::min) } else { 0.0 }
    };
    corners.iter().map(depth).fold(0.0, f64::max)
}

/// A pointed cone and a chamfered flat plug: the contact force is one pulse (its total variation over twice its
/// maximum), corners and tip penetrate by a few increments' approach at most, and the energy balance closes. Corners
/// of the plug have contact as points: on cells of 0.25 mm the variation is 1.57 when a node passes a corner. The drift
/// comes from the integration of plastic strains and decreases with the square of the increment. It is largest for the
/// plug on cells of 0.5 mm (1.05e-4), because its corners deform single cells instead of entering them.
#[test]
fn rigid_nose_enters_a_block_with_one_force_pulse() {
    let cone: &[[f64; 2]] = &[[3.0, 8.0], [3.0, 3.0], [0.0, 0.0]];
    let plug: &[[f64; 2]] = &[[3.0, 8.0], [3.0, 1.0], [2.0, 0.0], [0.0, 0.0]];
    let cases = [
        ("cone", 4e-6, cone, 20, [1.5, 0.01, 1e-4]),
        ("plug", 1.2e-5, plug, 20, [1.5, 0.01, 1.1e-4]),
        ("plug", 1.2e-5, plug, 40, [1.6, 0.04, 1e-4]),
    ];
    for (name, mass, corners, cells, [most, deep, drift]) in cases {
        let ran = run_nose(mass, corners, cells);
        let of = |what: &str| ran.column(&format!("{what}@NOSE.REF"));
        let force = of("A2");
        let varied: f64 = force.windows(2).map(|w| (w[1][1] - w[0][1]).abs()).sum();
        let pulse = 0.5 * varied / force.iter().fold(0.0_f64, |most, f| most.max(f[1].abs()));
        let rest = of("V2").iter().find(|v| v[1] > 0.0).expect("it comes to rest")[0];
        let moved = of("U2");
        let at = |time: f64| {
            moved.iter().min_by(|a, b| (a[0] - time).abs().total_cmp(&(b[0] - time).abs())).expect("a row")[1]
        };
        let frames = ran.memory.frames.iter();
        let inside = frames.map(|f| largest_penetration(&ran, corners, cells, f, at(f.time))).fold(0.0, f64::max)
            * cells as f64
            / 10.0;
        let energy = ran.outcome.energy;
        let created = ran.column("ALLCW").iter().fold(0.0_f64, |most, c| most.max(-c[1])) / energy.initial;
        println!(
            "{name}, h {:.2} mm: {pulse:.2} pulses, rest {rest:.3e} s, corners {inside:.3} h deep, lost {:.1e}, created {created:.1e}, \
             drift {:.1e}",
            10.0 / cells as f64,
            energy.contact / energy.initial,
            energy.drift
        );
        assert!(pulse < most && inside < deep, "{name}: {pulse} {inside}");
        assert!(energy.drift < drift && created < 1e-6 && energy.contact < 1e-2 * energy.initial, "{name}: {energy:?}");
    }
}

/// Throws a rigid plate of this mass on a disc of area pi and pushes it with a pressure of 1e-6.
fn run_light_plate(mass: f64) -> DeckRun {
    let cells = 8;
    let point = format!("*Element, type=MASS, elset=M\n 900, 1000\n*Mass, elset=M\n {mass:e},\n");
    let deck = part("DISC", [cells; 2], |i, j| [i as f64 / cells as f64, j as f64 / cells as f64 - 1.0], "")
        + &rigid_line("PLATE", &[[2.0, 1e-9], [0.0, 1e-9]], &point)
        + &assembly(&["DISC", "PLATE"], "*Rigid Body, ref node=PLATE.REF, elset=PLATE.E\n")
        + &elastic("DISC", [1.0, 0.3, 1.0], "*Damping, alpha=1.5\n")
        + "*Surface Interaction, name=DRY\n*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., 20., 1.\n\
           *Initial Conditions, type=VELOCITY\n PLATE.REF, 2, -1e-6\n*Step\n*Dynamic, Explicit\n , 60.\n"
        + &format!(
            "*Boundary\n DISC.J0, 2, 2\n*Cload, amplitude=RAMP\n PLATE.REF, 2, {:e}\n",
            -1e-6 * std::f64::consts::PI
        )
        + "*Contact Pair, interaction=DRY\n PLATE.SKIN, DISC.J1\n*Output, field, number interval=1\n*Element Output\n S\n\
           *Output, history, number interval=100\n*Energy Output\n ALLCW\n*End Step\n";
    run(&deck).whole()
}

/// A rigid plate of any mass transmits its load; the nodes in contact have a mass of 0.2.
#[test]
fn light_rigid_plate_transmits_its_load() {
    for mass in [1.0, 0.1, 1e-2, 1e-3, 1e-4] {
        let ran = run_light_plate(mass);
        let off = cell_field(ran.end(), "S").chunks(4).fold(0.0_f64, |most, s| most.max((s[1] / 1e-6 + 1.0).abs()));
        println!(
            "plate with {:.0e} of the contacting mass: error of the stress {off:.1e}, drift {:.1e}",
            mass / 0.196,
            ran.outcome.energy.drift
        );
        assert!(off < 2e-6, "{mass}: {off}");
        // The work of a load that is applied suddenly is of second order in the increment, and largest for the heaviest
        // plate.
        assert!(ran.outcome.energy.drift < 1e-2, "{mass}: {}", ran.outcome.energy.drift);
    }
}
