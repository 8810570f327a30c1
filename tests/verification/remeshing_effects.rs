//! New meshes together with temperatures, mass scaling, deletion of elements, soft contact, and bonds and distortion control of
//! other bodies.
//!
//! Goal: conservation of heat and mass over all new meshes, and the results of the mesh that follows the material. Source:
//! conservation laws, and runs without the card. Tolerances are stated at each test.

use revolve::job;
use revolve::output::HistorySummary;
use revolve::plan::State;
use revolve::solve::Outcome;
use revolve::user::Routines;

use super::cohesive::{ELASTIC, QUADS, RING, layer, rings};
use super::cohesive_contact::{bonded, pulled};
use super::remeshing::{OFTEN, new_meshes, taylor};
use super::remeshing_contact::{EAGER, last};
use crate::common;
use crate::common::bodies::{DeckRun, assembly, elastic, part, run as run_deck};

/// A finished run with its states.
struct BarRun {
    outcome: Outcome,
    history: HistorySummary,
    start: State,
    end: State,
}

impl BarRun {
    fn of(deck: &str) -> BarRun {
        let prepared = common::prepared(deck, &[], &Routines::none());
        let start = prepared.state.clone();
        let mut memory = common::RecordedOutput::default();
        let (outcome, end) = job::run_into(&prepared, &mut memory);
        assert_eq!(outcome.halt, None, "{deck}");
        let (_, history) = job::run_in_memory(&prepared);
        BarRun { outcome, history, start, end }
    }

    fn mass(state: &State) -> f64 {
        state.dofs.nodes.mass.iter().sum()
    }

    /// Returns the largest relative difference of length and foot radius to another run.
    fn apart(&self, other: &BarRun) -> f64 {
        let names = ["COOR2@TIP", "COOR1@CORNER"].into_iter().filter(|name| self.history.0.contains_key(*name));
        names.map(|name| (self.history.0[name].last / other.history.0[name].last - 1.0).abs()).fold(0.0, f64::max)
    }
}

/// Returns the Taylor bar with a card in the model and one in the step, without and with new meshes.
fn both(edit: impl Fn(String) -> String) -> [BarRun; 2] {
    ["*Remesh, automatic=NO\n", OFTEN].map(|card| BarRun::of(&edit(taylor(card))))
}

fn in_step(deck: &str, cards: &str) -> String {
    let step = "*Dynamic, Explicit\n , 80.e-6\n";
    assert!(deck.contains(step));
    deck.replacen(step, &format!("{step}{cards}"), 1)
}

/// A bar that plastic work heats, with conduction and thermal expansion. The heat in the nodes is that which has been made,
/// to 1e-12; to 1e-7 with a variable specific heat, which is evaluated at the middle of each rise. Scaled masses take no heat.
/// Length and foot agree within 1 %, and the heat within 1 %, as for a bar without temperatures.
#[test]
fn heat_is_conserved() {
    let scaled = "*Fixed Mass Scaling, type=BELOW MIN, dt=6.e-8\n";
    for (capacity, tolerance, cards) in
        [("385.\n", 1e-12, ""), ("385., 20.\n 800., 400.\n", 1e-7, ""), ("385.\n", 1e-12, scaled)]
    {
        let [follows, ran] = both(|deck| {
            let deck = in_step(&deck, cards);
            deck.replace("type=CAX4R", "type=CAX4RT")
                .replace("*Dynamic, Explicit", "*Dynamic Temperature-displacement, Explicit")
                .replace(
                    "*Elastic",
                    &format!(
                        "*Conductivity\n 390.,\n*Specific Heat\n {capacity}*Inelastic Heat Fraction\n 0.9\n*Expansion\n 17e-6,\n*Elastic"
                    ),
                )
                .replace("*Initial Conditions", "*Initial Conditions, type=TEMPERATURE\n BAR, 20.\n*Initial Conditions")
        });
        let field = |state: &State| state.thermal.as_ref().and_then(|t| t.heat.clone()).expect("temperatures");
        let content = |state: &State| field(state).content();
        let made = field(&ran.end).energies().internal;
        let off = (content(&ran.end) - content(&ran.start) - made) / content(&ran.end);
        let heat = made / field(&follows.end).energies().internal - 1.0;
        println!(
            "{} meshes, heat off by {off:.1e}, differs by {:.3} %, length and foot by {:.3} %, drift {:.1e}",
            new_meshes(&ran.outcome),
            100.0 * heat,
            100.0 * ran.apart(&follows),
            ran.outcome.energy.drift
        );
        assert!(new_meshes(&ran.outcome) >= 2 && off.abs() < tolerance && heat.abs() < 0.01);
        assert!(ran.apart(&follows) < 0.01 && ran.outcome.energy.drift < 1e-3);
    }
}

/// Scaled masses of half of the bar, of all elements with small increments, and of elements below an increment that changes
/// during the step. The mass of the nodes is that of the start and the added mass, to 1e-12; the added mass of fixed scaling
/// is that without new meshes. Length and foot agree within 1 %. Variable scaling adds 5 to 7 % of mass, and with it as much
/// energy, to a bar that is compared without scaling: the foot, which widens by half of its radius, is up to 3 % wider.
#[test]
fn scaled_mass_is_conserved() {
    for cards in [
        "*Fixed Mass Scaling, elset=HALF, factor=2.\n",
        "*Fixed Mass Scaling, type=BELOW MIN, dt=6.e-8\n",
        "*Variable Mass Scaling, type=BELOW MIN, dt=5.e-8, frequency=10\n",
    ] {
        let [scaled, ran] = both(|deck| {
            let deck = deck.replacen("*Solid Section", "*Elset, elset=HALF, generate\n 1, 250\n*Solid Section", 1);
            in_step(&deck, cards)
        });
        // Without new meshes variable scaling doubles the mass.
        let is_fixed = cards.starts_with("*Fixed");
        let follows = if is_fixed { scaled } else { BarRun::of(&taylor("")) };
        let added = |run: &BarRun| 0.01 * run.outcome.energy.added_mass.expect("mass scaling");
        let off = BarRun::mass(&ran.end) / (BarRun::mass(&ran.start) * (1.0 + added(&ran))) - 1.0;
        println!(
            "{} meshes, mass off by {off:.1e}, added {:.6} and {:.6}, length and foot {:.3} % apart, drift {:.1e}",
            new_meshes(&ran.outcome),
            added(&ran),
            if is_fixed { added(&follows) } else { 0.0 },
            100.0 * ran.apart(&follows),
            ran.outcome.energy.drift
        );
        assert!(new_meshes(&ran.outcome) >= 2 && off.abs() < 1e-12);
        let tolerance = if is_fixed { 0.01 } else { 0.03 };
        assert!(ran.apart(&follows) < tolerance && ran.outcome.energy.drift < 1e-3);
        if is_fixed {
            assert!((added(&ran) / added(&follows) - 1.0).abs() < 1e-12);
        }
    }
}

/// Deleted elements at the foot of the bar, by `*EROSION` and by ductile damage, are not parts of new meshes: the bar loses
/// their mass, at most that of all deleted elements. Its length agrees within 1 %, because elements of other sizes reach the
/// limits: 27 are deleted with new meshes and 36 without. The balance includes the energy.
#[test]
fn deleted_elements_stay_deleted() {
    for (material, control) in [
        ("*Erosion, plastic strain=1.2\n", ""),
        ("", "*Damage Initiation, criterion=DUCTILE\n 1.,\n*Damage Evolution, type=DISPLACEMENT\n 1.e-6,\n"),
    ] {
        let [follows, ran] = both(|deck| {
            deck.replacen("*Initial Conditions", &format!("{control}{material}*Initial Conditions"), 1).replacen(
                "*Node Output, nset=CORNER\n U1, COOR1\n",
                "",
                1,
            )
        });
        let eroded = |run: &BarRun| run.outcome.energy.removed.map_or(0.0, |removed| removed.mass);
        let left = 1.0 - BarRun::mass(&ran.end) / BarRun::mass(&ran.start);
        println!(
            "{} meshes, {} and {} deleted, eroded {:.2e} {:.2e}, lost {:.2e}; apart {:.3} %, drift {:.1e} {:.1e}",
            new_meshes(&ran.outcome),
            ran.outcome.deleted,
            follows.outcome.deleted,
            eroded(&ran) / BarRun::mass(&ran.start),
            eroded(&follows) / BarRun::mass(&ran.start),
            left,
            100.0 * ran.apart(&follows),
            ran.outcome.energy.drift,
            follows.outcome.energy.drift
        );
        assert!(new_meshes(&ran.outcome) >= 3 && ran.outcome.deleted > 10, "{}", ran.outcome.deleted);
        assert!(left > 0.01 && (eroded(&ran) == 0.0 || left < eroded(&ran) / BarRun::mass(&ran.start) + 1e-12));
        assert!(ran.apart(&follows) < 0.01 && ran.outcome.energy.drift < 1e-3);
    }
}

/// A block that erodes under a bar with new meshes: mass and momentum are conserved to rounding, the drift is that without
/// new meshes within 1e-3, and the plastic work within 3 %, for other elements are deleted.
#[test]
fn other_bodies_erode() {
    let bar =
        part("BAR", [4, 12], |i, j| [2.0 * i as f64 / 4.0, 6.0 * j as f64 / 12.0], "*Surface, name=SKIN\n SOLID,\n");
    let block = part(
        "BLOCK",
        [16, 12],
        |i, j| [8.0 * i as f64 / 16.0, 6.0 * (j as f64 / 12.0 - 1.0)],
        "*Surface, name=SKIN\n SOLID, INTERIOR\n SOLID,\n",
    );
    let metal = |name: &str| elastic(name, [117e3, 0.3, 8.93e-9], "*Plastic\n 200., 0.\n 400., 1.\n");
    let deck = |remesh: &str| {
        format!(
            "{bar}{block}{}{}{}*Erosion, elset=BLOCK.SOLID, plastic strain=0.35\n{remesh}*Surface Interaction, \
             name=I\n*Friction\n 0.1,\n*Initial Conditions, type=VELOCITY\n BAR.ALL, 2, -3e5\n*Step\n*Dynamic, Explicit\n \
             , 1e-5\n*Contact Pair, interaction=I\n BAR.SKIN, BLOCK.SKIN\n*Output, history, number interval=20\n*Energy \
             Output\n ALL\n*End Step\n",
            assembly(&["BAR", "BLOCK"], ""),
            metal("BAR"),
            metal("BLOCK")
        )
    };
    let follows = run_deck(&deck("")).whole();
    // Which elements of the block are deleted depends on each change of the bar: the plastic work is a mean.
    let work = [10, 20, 30].map(|frequency| {
        let ran = run_deck(&deck(&format!("*Remesh, elset=BAR.SOLID, frequency={frequency}, {EAGER}\n"))).whole();
        let nodes = &ran.prepared.state.dofs.nodes;
        let before: f64 = nodes.as_slice().iter().zip(&nodes.mass).map(|(n, m)| m * n.v_z).sum();
        let mass = BarRun::mass(&ran.state) / BarRun::mass(&ran.prepared.state) - 1.0;
        let momentum = ran.momentum() / before - 1.0;
        println!(
            "{} meshes, {} and {} deleted, mass {mass:.1e}, momentum {momentum:.1e}, plastic work {:.4e} {:.4e}, drift {:.1e} {:.1e}",
            new_meshes(&ran.outcome),
            ran.outcome.deleted,
            follows.outcome.deleted,
            last(&ran, "ALLPD"),
            last(&follows, "ALLPD"),
            ran.outcome.energy.drift,
            follows.outcome.energy.drift
        );
        assert!(new_meshes(&ran.outcome) >= 2 && ran.outcome.deleted > 5);
        assert!(mass.abs() < 1e-12 && momentum.abs() < 1e-12);
        assert!(ran.outcome.energy.drift < follows.outcome.energy.drift + 1e-3);
        last(&ran, "ALLPD") / last(&follows, "ALLPD")
    });
    assert!((work.iter().sum::<f64>() / 3.0 - 1.0).abs() < 0.03, "{work:?}");
}

/// A bar whose upper end is pushed down by 31 % of its length by prescribed displacements. With new meshes the end is where the displacement is, to rounding of the coordinates, and the foot
/// radius and the work agree within 0.5 % with the mesh that follows the material.
#[test]
fn prescribed_displacements_continue() {
    let deck = |card: &str, motion: &str| {
        let pushed = format!("*Boundary\n FOOT, 2, 2\n{motion}");
        let deck = taylor(card)
            .replace("*Boundary\n FOOT, 2, 2\n", &pushed)
            .replace("*Initial Conditions, type=VELOCITY\n BAR, 2, <v>\n", "")
            .replace("*Step, ", "*Amplitude, name=RAMP, definition=SMOOTH STEP\n 0., 0., 80.e-6, 1.\n*Step, ");
        assert!(deck.contains(motion) && !deck.contains("type=VELOCITY\n BAR"));
        deck
    };
    let displaced = "*Boundary, amplitude=RAMP\n TOP, 2, 2, -1.e-2\n";
    let cards = ["*Remesh, automatic=NO\n", OFTEN];
    let [reference, moved] = cards.map(|card| BarRun::of(&deck(card, displaced)));
    let end = moved.history.0["U2@TIP"].last;
    let (work, same_work) = (moved.outcome.energy.work, reference.outcome.energy.work);
    println!("{} new meshes, U2 {end:e}, work {work:e} {same_work:e}", new_meshes(&moved.outcome));
    assert!(new_meshes(&moved.outcome) >= 1, "{:?}", moved.outcome.new_meshes);
    assert!((end + 1e-2).abs() < 1e-15, "{end:e}");
    assert!(moved.apart(&reference) < 5e-3, "{}", moved.apart(&reference));
    assert!((work / same_work - 1.0).abs() < 5e-3, "{work:e} {same_work:e}");
}

/// `*DAMPING` of the bar, and a spring between two other bodies: the energy balance closes, length, foot radius and the
/// energies agree within 1 % with the mesh that follows the material, and the spring has exactly the same energy.
#[test]
fn damping_and_springs_continue() {
    let damped = |deck: String| deck.replacen("*Elastic\n", "*Damping, alpha=2.e4, beta=2.e-9\n*Elastic\n", 1);
    let [reference, moved] = both(damped);
    let terms = |run: &BarRun| [run.outcome.energy.viscous, run.outcome.energy.internal];
    println!("{} new meshes, {:?} {:?}", new_meshes(&moved.outcome), terms(&moved), terms(&reference));
    assert!(new_meshes(&moved.outcome) >= 1 && moved.outcome.energy.drift < 1e-3, "{:?}", moved.outcome.energy);
    assert!(moved.apart(&reference) < 1e-2, "{}", moved.apart(&reference));
    for (a, b) in terms(&moved).into_iter().zip(terms(&reference)) {
        assert!((a / b - 1.0).abs() < 1e-2, "{a:e} {b:e}");
    }
    let sprung = |deck: String| {
        let masses = "*Node, nset=HUNG\n 90001, 0., 1.\n*Element, type=MASS, elset=HUNG_MASS\n 90001, 90001\n\
            *Mass, elset=HUNG_MASS\n 0.1,\n*Element, type=SPRING1, elset=HUNG_SPRING\n 90002, 90001\n\
            *Spring, elset=HUNG_SPRING\n 2,\n 1.e6,\n*Initial Conditions, type=VELOCITY\n HUNG, 2, 3.\n";
        let with_masses = deck.replacen("*Step, ", &format!("{masses}*Step, "), 1);
        with_masses.replace("nset=CORNER\n U1, COOR1", "nset=HUNG\n V2\n*Node Output, nset=CORNER\n U1, COOR1")
    };
    let [reference, moved] = both(sprung);
    let (speed, same) = (moved.history.0["V2@HUNG"].last, reference.history.0["V2@HUNG"].last);
    let exact = 3.0 * (80e-6 * 1e7_f64.sqrt()).cos();
    println!("{} new meshes, {speed} {same} {exact} m/s", new_meshes(&moved.outcome));
    assert!((speed / exact - 1.0).abs() < 1e-6 && moved.outcome.energy.drift < 1e-3, "{speed} {exact}");
}

/// A free bar that `*TEMPERATURE` heats as a whole has the logarithmic strain `alpha (T - T0)` without stress, with new meshes and
/// with an adaptive mesh, to 1e-5 of its length (it vibrates): the thermal strain is applied once.
#[test]
fn prescribed_temperatures_continue() {
    let deck = |cards: &str, in_step: &str| {
        let places = |i: usize, j: usize| {
            let inside = (1..4).contains(&i) && (1..8).contains(&j);
            [0.25 * i as f64 + if inside && j % 2 == 1 { 0.17 } else { 0.0 }, 0.25 * j as f64]
        };
        common::solid::grid(4, 8, false, places)
            + "*Nset, nset=TIP\n 45,\n*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 7.85e-9,\n*Elastic\n \
               200e3, .3\n*Expansion, zero=20.\n 2e-5,\n*Amplitude, name=A, definition=SMOOTH STEP\n 0., 20., 2e-5, 420., 4e-5, \
               420.\n*Initial Conditions, type=TEMPERATURE\n ALL, 20.\n"
            + cards
            + "*Step\n*Dynamic, Explicit\n , 4e-5\n*Temperature, amplitude=A\n ALL, 1.\n"
            + in_step
            + "*Output, history, number interval=20\n*Node Output, nset=TIP\n U1, U2\n*Node Output, nset=J0\n U2\n*End Step\n"
    };
    let ways = [
        ("*Remesh, automatic=NO\n", ""),
        ("*Remesh, elset=SOLID, angle=59., frequency=20\n", ""),
        ("*Remesh, automatic=NO\n", "*Adaptive Mesh, elset=SOLID, frequency=5\n"),
    ];
    for (cards, in_step) in ways {
        let ran = run_deck(&deck(cards, in_step)).whole();
        let strain = f64::exp_m1(2e-5 * 400.0);
        let grown = [last(&ran, "U1@TIP"), (last(&ran, "U2@TIP") - last(&ran, "U2@5")) / 2.0].map(|u| u - strain);
        let changes: u64 = ran.outcome.mesh_changes.iter().map(|changes| changes.count).sum();
        println!("{} meshes, {changes} changes: {grown:?}", new_meshes(&ran.outcome));
        assert!(grown.iter().all(|apart| apart.abs() < 1e-5), "{grown:?}");
        assert!(new_meshes(&ran.outcome) + changes > 0 || !cards.contains("elset") && in_step.is_empty());
    }
}

/// Runs rings whose faces move apart by a displacement, and a column that is pressed to .7 of its height, without and with new
/// meshes of the column. The elements of the column are skewed, light, and longer than those of the rings, which determine
/// increments and energies.
fn with_column(rings: &str, displacement: f64) -> [DeckRun; 2] {
    let mut mesh = String::from("*Node\n");
    for (j, i) in (0..9).flat_map(|j| (0..5).map(move |i| (j, i))) {
        mesh += &format!(" {}, {}, {}\n", 9001 + 5 * j + i, 4.0 + 0.3 * i as f64 + 0.2 * j as f64, 0.3 * j as f64);
    }
    mesh += "*Element, type=CAX4R, elset=COLUMN\n";
    for (j, i) in (0..8).flat_map(|j| (0..4).map(move |i| (j, i))) {
        let a = 9001 + 5 * j + i;
        mesh += &format!(" {}, {a}, {}, {}, {}\n", 9001 + 4 * j + i, a + 1, a + 6, a + 5);
    }
    mesh += "*Nset, nset=FOOT, generate\n 9001, 9005\n*Nset, nset=HEAD, generate\n 9041, 9045\n*Solid section, elset=COLUMN, \
             material=LIGHT\n*Material, name=LIGHT\n*Density\n 1e-6,\n*Elastic\n 1e-2, 0.\n*Remesh, elset=COLUMN, frequency=20, increment=0., angle=";
    let motion = format!("*Boundary, amplitude=RISE\n HEAD, 2, 2, -0.72\n TOP, 2, 2, {displacement}");
    let deck = pulled(
        &format!("*Amplitude, name=RISE, definition=SMOOTH STEP\n 0., 0., 2., 1.\n{rings}"),
        ", element by element\n ",
    )
    .replacen(" LOW, 1, 2\n", " LOW, 1, 2\n FOOT, 2\n", 1)
    .replacen("*Boundary, type=VELOCITY\n TOP, 2, 2, 0.1", &motion, 1);
    ["0.1", "59."].map(|card| run_deck(&deck.replacen("*Step\n", &format!("{mesh}{card}\n*Step\n"), 1)).whole())
}

/// Returns the largest difference of the force on the outer ring, as a fraction of its largest value.
fn forces_apart(runs: &[DeckRun; 2]) -> f64 {
    let [alone, ran] = runs.each_ref().map(|run| run.column("RF2@300"));
    let largest = alone.iter().map(|row| row[1].abs()).fold(0.0, f64::max);
    alone.iter().zip(&ran).map(|(a, b)| (a[1] - b[1]).abs()).fold(0.0, f64::max) / largest
}

/// Cohesive surfaces and elements between other bodies dissipate the fracture energy times their area, and the energy is balanced.
/// Forces agree within 3 % of the largest one: the increments differ.
#[test]
fn bonds_of_other_bodies_continue() {
    let evolution = "*Damage evolution, type=ENERGY\n 0.3,\n";
    let elements = rings(5, 5) + &layer(100, 200, 5, &format!("{ELASTIC}{QUADS}{evolution}"));
    for (kind, mesh) in [("surfaces", rings(2, 5) + &bonded()), ("elements", elements)] {
        let runs = with_column(&mesh, 0.2);
        let (apart, [_, ran]) = (forces_apart(&runs), &runs);
        let dissipated = last(ran, "ALLDMD") / (0.3 * RING) - 1.0;
        println!(
            "{kind}: {} meshes, dissipated {dissipated:.1e}, forces {apart:.1e} apart, drift {:.1e}",
            new_meshes(&ran.outcome),
            ran.outcome.energy.drift,
        );
        assert!(new_meshes(&ran.outcome) >= 3 && dissipated.abs() < 1e-5, "{dissipated}");
        assert!(apart < 0.03 && ran.outcome.energy.drift < 5e-5, "{apart}");
    }
}

/// Distortion control of another body, which carries its load, continues.
#[test]
fn distortion_control_of_other_bodies_continues() {
    let mesh = rings(5, 5).replace("material=STEEL\n", "material=STEEL, controls=C\n")
        + "*Section controls, name=C, distortion control=YES, length ratio=0.999\n*Tie, name=T\n BELOW, ABOVE\n";
    let runs = with_column(&mesh, -0.6);
    let (apart, [_, ran]) = (forces_apart(&runs), &runs);
    let meshes = new_meshes(&ran.outcome);
    println!("{meshes} meshes: forces {apart:.1e} apart, drift {:.1e}", ran.outcome.energy.drift);
    assert!(meshes >= 3 && last(ran, "ALLDC") > 0.0, "{meshes}");
    assert!(apart < 1e-2 && ran.outcome.energy.drift < 1e-7, "{apart}");
}
