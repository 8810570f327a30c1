//! Memory allocations of a run.
//!
//! Goal: nothing is allocated inside an increment; an elastic deck has no memory for plasticity. Source: a counting
//! allocator; the size of a loop compiled for a law without plasticity.

use std::sync::Arc;

use revolve::deck;
use revolve::internals::QuadGroup;
use revolve::internals::bulk_viscosity::BulkViscosity;
use revolve::internals::constants::{ElementConstants, HourglassControl};
use revolve::internals::group::ElementGroup;
use revolve::internals::volumetric::ConstantBulkModulus;
use revolve::internals::von_mises::VonMises;
use revolve::job::{self, JobOptions};
use revolve::model::{self, Mesh, Model};
use revolve::output::{JobFiles, RunHistory};
use revolve::plan::ledger::{Ledger, LedgerRow};
use revolve::plan::{self, CompiledModel};
use revolve::user::{LoadFailure, LoadPoints, MaterialAnswer, MaterialCall, Routines, UserLoad, UserMaterial};

use crate::common;
use crate::common::bodies::{BOTH_ADAPTIVE, assembly, elastic, part, punch_and_block, rigid_line};
use crate::common::routines::NoPlasticity;
use crate::common::solid::{grid, in_six_node_triangles, material};

/// Returns a heavy fully embedded ogive at nearly constant velocity for 200 000 increments.
fn flight() -> String {
    let deck = common::ogive()
        .replace("mass = 0.021", "mass = 1.e4")
        .replace("front = 0.\n", "front = 0.1\n")
        .replace("AL6061, 0.5", "AL6061, 50.")
        .replace("*Dynamic, Explicit\n , 1.e-3", "*Dynamic, Explicit, direct user control\n 5e-9, 1.e-3");
    deck.split("*Output, field").next().expect("text").to_owned() + "*End Step\n"
}

struct ConstantPressure;

impl UserLoad for ConstantPressure {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        pressure.fill(1e9 * points.magnitude);
        Ok(())
    }
}

/// Allocations of a warning at the end of a run: its text and its place in the list.
const OF_A_WARNING: u64 = 12;

/// Returns the increments of a run and the number of its allocations.
fn allocations(deck: &str) -> (u64, u64) {
    let (increments, allocations, _) = count_run(deck, &Routines::none().with_load(ConstantPressure));
    (increments, allocations)
}

/// Returns the increments of a run, the number of its allocations, and the number of its warnings.
fn count_run(deck: &str, routines: &Routines) -> (u64, u64, u64) {
    let prepared = job::prepare_text("test.inp", deck, &[], routines);
    assert!(!prepared.diagnostics.has_errors(), "{}", prepared.diagnostics.render(&prepared.deck.sources));
    let (mut increments, mut warnings) = (0, 0);
    let counted = allocation_counter::measure(|| {
        let outcome = job::run_in_memory(&prepared).0;
        (increments, warnings) = (outcome.increments, outcome.warnings.len() as u64);
        outcome.warnings.iter().for_each(|warning| println!("{warning}"));
    });
    (increments, counted.count_total, warnings)
}

/// Asserts that a longer run has as many allocations as a short one, apart from those of further warnings at its end. An
/// allocation in each increment would exceed these.
fn assert_same_allocations(name: &str, short: (u64, u64, u64), long: (u64, u64, u64)) {
    println!("{name}: {} allocations over {} increments, {} over {}", short.1, short.0, long.1, long.0);
    let permitted = OF_A_WARNING * long.2.saturating_sub(short.2);
    assert!(long.0 > 5 * short.0 && long.0 - short.0 > 4 * permitted, "{name}: too few increments");
    assert!((short.1..=short.1 + permitted).contains(&long.1), "{name}: {} and {} allocations", short.1, long.1);
}

#[test]
fn nothing_allocates_inside_an_increment() {
    let text = flight();
    let own = text.replace("*Dsload, target=BLOCK, friction=<friction>\n NOSE, CAVITY", "*Dsload\n NOSE, PNU");
    let automatic = |accuracy| text.replace(", direct user control\n 5e-9,", &format!(", accuracy={accuracy}\n ,"));
    let shorter = |deck: &str| deck.replace(", 1.e-3", ", 1.e-4");
    // Allocations made once per process.
    allocations(&shorter(&text));
    let tilted = text
        .replace("direction=-1", "direction=-1, obliquity=10.")
        .replace("*Surface, name=NOSE", "*Attitude, ref node=REF, stations=8, inertia=UNIFORM\n*Surface, name=NOSE");
    for (name, short, long) in [
        ("CAVITY", shorter(&text), text.clone()),
        ("CAVITY, six degrees of freedom", shorter(&tilted), tilted.clone()),
        ("UserLoad", shorter(&own), own.clone()),
        ("automatic increments", automatic("1e-8"), automatic("1e-10")),
    ] {
        let (short, long) = (allocations(&short), allocations(&long));
        println!("{name}: {} allocations over {} increments, {} over {}", short.1, short.0, long.1, long.0);
        assert!(long.0 > 5 * short.0 && short.0 > 1000);
        assert_eq!(long.1, short.1, "{name}");
    }
}

/// User material with a constant stress.
struct ConstantStress;

impl UserMaterial for ConstantStress {
    fn stress(&mut self, call: &MaterialCall<'_>, answer: &mut MaterialAnswer<'_>) -> Result<(), LoadFailure> {
        let elastic = call.now.total_time == 0.0;
        let new = |(old, strain): (&f64, &f64)| old + if elastic { 1e5 * strain } else { 0.0 };
        answer.stress.iter_mut().zip(call.stress.iter().zip(call.strain).map(new)).for_each(|(s, v)| *s = v);
        Ok(())
    }
}

const OF_THE_USER: &str =
    "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 1.,\n*User Material, constants=1\n 1.,\n";

/// With the global estimate, which is recomputed from time to time.
#[test]
fn nothing_allocates_inside_an_increment_of_elements() {
    let mesh = grid(12, 24, false, |i, j| [i as f64, j as f64]);
    let plastic = material(1e5, 0.3, 1.0, "*Plastic\n 100., 0.\n");
    for (name, mesh, material) in [
        ("CAX4R of a user material", mesh.clone(), OF_THE_USER),
        ("CAX6M", in_six_node_triangles(&mesh, [12, 24]), &plastic),
        ("CAX6M of a user material", in_six_node_triangles(&mesh, [12, 24]), OF_THE_USER),
    ] {
        allocate_once_a_run(name, &(mesh + material));
    }
}

/// Asserts that a long run of a body has as many allocations as a short one.
fn allocate_once_a_run(name: &str, body: &str) {
    let deck = |time: &str| {
        body.to_owned()
            + &format!("*Initial Conditions, type=VELOCITY\n I1, 2, 1.\n*Step\n*Dynamic, Explicit\n , {time}\n")
            + "*Output, history, number interval=1\n*Energy Output\n ALLIE\n*End Step\n"
    };
    let count = |time: &str| count_run(&deck(time), &Routines::none().with_material(ConstantStress));
    // Allocations made once per process.
    count("0.1");
    assert_same_allocations(name, count("0.1"), count("1."));
}

/// A block with waves slides along another block and rebounds from a light plate, so that contact candidates are
/// searched many times.
#[test]
fn nothing_allocates_inside_an_increment_of_contact() {
    let wavy = |r: f64| 0.01 * (9.0 * r).sin();
    let deck = |time: &str| {
        let lower = |i: usize, j: usize| {
            let [r, z] = [1.0 + 0.05 * i as f64, 0.1 * j as f64];
            [r, z - 0.4 + 0.25 * z * wavy(r) / 0.1]
        };
        part("LOWER", [40, 4], lower, "")
            + &part("UPPER", [6, 4], |i, j| [1.2 + 0.07 * i as f64, 0.03 + 0.07 * j as f64], "")
            + &rigid_line(
                "PLATE",
                &[[9.0, 0.32], [0.5, 0.32]],
                "*Element, type=MASS, elset=M\n 900, 1000\n*Mass, elset=M\n 0.02,\n",
            )
            + &assembly(&["LOWER", "UPPER", "PLATE"], "*Rigid Body, ref node=PLATE.REF, elset=PLATE.E\n")
            + &elastic("LOWER", [1.0, 0.3, 1.0], "")
            + &elastic("UPPER", [1.0, 0.3, 1.0], "")
            + "*Surface Interaction, name=DRY\n*Friction\n 0.1,\n*Initial Conditions, type=VELOCITY\n UPPER.ALL, 1, 0.1\n UPPER.ALL, 2, -0.03\n"
            + &format!(
                "*Step\n*Dynamic, Explicit\n , {time}\n*Boundary\n LOWER.J0, 1, 2\n*Cload\n PLATE.REF, 2, -0.002\n"
            )
            + "*Contact Pair, interaction=DRY\n LOWER.J1, UPPER.J0\n UPPER.J1, PLATE.SKIN\n\
               *Output, history, number interval=1\n*Energy Output\n ALLCW\n*End Step\n"
    };
    // With penalty contact and heat conduction across it.
    let warm = |time: &str| {
        deck(time)
            .replace("CAX4R", "CAX4RT")
            .replace("*Dynamic, Explicit", "*Dynamic Temperature-displacement, Explicit")
            .replace("*Elastic", "*Conductivity\n 0.01,\n*Specific Heat\n 1.,\n*Elastic")
            .replace("interaction=DRY\n", "interaction=DRY, mechanical constraint=PENALTY\n")
            .replace("*Friction\n 0.1,\n", "*Friction\n 0.1,\n*Gap Conductance\n 0.5, 0.\n 0.1, 0.05\n")
    };
    // Allocations made once per process.
    allocations(&deck("0.1"));
    for scene in [&deck as &dyn Fn(&str) -> String, &warm] {
        let (short, long) = (allocations(&scene("1.")), allocations(&scene("40.")));
        println!("contact: {} allocations over {} increments, {} over {}", short.1, short.0, long.1, long.0);
        assert!(short.0 > 20 && long.0 > 5 * short.0);
        assert_eq!(long.1, short.1);
    }
}

/// A glued pin that is pushed out of a sleeve; its bonds fail and form again while it slides.
#[test]
fn nothing_allocates_inside_an_increment_of_cohesive_surfaces() {
    let text = std::fs::read_to_string(common::project("input/push_out.inp")).expect("a deck");
    let text = text
        .replace("number interval=400", "number interval=1")
        .replace("number interval=20", "number interval=1")
        .replace("eligibility=ORIGINAL CONTACTS", "repeated contacts");
    let deck = |time: &str| text.replace("T    = 1.e-3", &format!("T    = {time}"));
    // Allocations made once per process.
    allocations(&deck("1.e-3"));
    let (short, long) = (allocations(&deck("1.e-3")), allocations(&deck("3.e-3")));
    assert!(long.0 > 2 * short.0);
    assert_eq!(long.1, short.1);
}

/// Waves in blocks with adaptive meshes, one with nodal temperatures and thermal strains, the same with an Eulerian boundary
/// that moves in space, and one of a user material.
#[test]
fn nothing_allocates_inside_an_increment_of_adaptive_meshes() {
    let mesh = grid(6, 8, false, |i, j| [i as f64, j as f64]);
    let warm = material(
        1e5,
        0.3,
        1.0,
        "*Plastic\n 100., 0.\n*Conductivity\n 0.1,\n*Specific Heat\n 1., 0.\n 2., 90.\n*Expansion\n 1e-5,\n",
    );
    let (coupled, procedure) = (mesh.replace("CAX4R", "CAX4RT"), "*Dynamic Temperature-displacement, Explicit");
    let open = coupled.replace("*Surface, name=J0\n", "*Surface, name=J0, region type=EULERIAN\n");
    let held = "*Adaptive Mesh Constraint, type=VELOCITY\n J0, 1, 2, 0.1\n";
    let blocks = [
        (coupled, warm.as_str(), procedure, ""),
        (open, warm.as_str(), procedure, held),
        (mesh, OF_THE_USER, "*Dynamic, Explicit", ""),
    ];
    for (mesh, material, procedure, constraint) in blocks {
        let deck = |time: &str| {
            format!(
                "{mesh}{material}*Initial Conditions, type=TEMPERATURE\n ALL, 20.\n J0, 60.\n*Initial Conditions, type=VELOCITY\n I1, 2, 20.\n*Step\n{procedure}\n , {time}\n"
            ) + constraint
                + "*Adaptive Mesh, elset=SOLID, frequency=2\n*Boundary\n J1, 2, 2\n*Output, history, number interval=1\n*Energy Output\n ALLIE\n*End Step\n"
        };
        let count = |time: &str| count_run(&deck(time), &Routines::none().with_material(ConstantStress));
        // Allocations made once per process.
        count("0.02");
        assert_same_allocations(procedure, count("0.02"), count("0.2"));
    }
}

/// Surfaces of two adaptive meshes that slide in soft contact with friction.
#[test]
fn nothing_allocates_inside_an_increment_of_adaptive_meshes_in_contact() {
    let law = "*Friction\n 0.1,\n*Surface Behavior, pressure-overclosure=LINEAR\n 1e6,\n";
    let deck = |time: f64| punch_and_block(12, time, law, BOTH_ADAPTIVE);
    // Allocations made once per process.
    allocations(&deck(4e-6));
    let (short, long) = (allocations(&deck(4e-6)), allocations(&deck(1.2e-5)));
    assert!(long.0 > 2 * short.0);
    assert_eq!(long.1, short.1);
}

/// A stretched block whose rows are deleted, with eroded mass and energy, and pressure on newly exposed faces.
#[test]
fn nothing_allocates_inside_an_increment_of_erosion() {
    // An energy warning at the end would add allocations.
    let limits = "*Energy Limit, error=10., artificial=10.\n";
    let deck = |time: &str| {
        grid(6, 10, false, |i, j| [i as f64, j as f64])
            + &material(200e3, 0.3, 7.8e-9, "*Plastic\n 400., 0.\n 500., 1.\n")
            + "*Surface, name=SKIN\n SOLID,\n*Erosion, plastic strain=0.1, distortion=0.1, increment=1e-12\n*Initial Conditions, \
               type=VELOCITY\n J0, 2, -4e5\n J1, 2, 4e5\n"
            + &format!("*Step\n*Dynamic, Explicit\n , {time}\n{limits}*Dsload\n SKIN, P, 1.\n SKIN, PNU, 1e-9\n")
            + "*Output, history, number interval=1\n*Energy Output\n EROMASS, EROPKE\n*End Step\n"
    };
    let count = |time: &str| count_run(&deck(time), &Routines::none().with_load(ConstantPressure));
    count("1e-7");
    assert_same_allocations("erosion", count("1e-6"), count("2e-5"));
}

#[test]
fn elastic_deck_allocates_nothing_for_plasticity() {
    // Without the strains that are default output.
    let deck = grid(8, 8, false, |i, j| [0.1 * i as f64, 0.1 * j as f64])
        + &material(200e3, 0.3, 7.85e-9, "")
        + "*Step\n*Dynamic, Explicit\n , 1.\n*Output, history\n*Energy Output\n ALLIE\n*End Step\n";
    let state = common::prepared(&deck, &[], &Routines::none()).state;
    let elastic = &state.elements;
    let elements: Vec<[u32; 4]> = (0..64).flat_map(|e| elastic.groups[0].cells(e)).collect();
    let (bulk, shear) = (200e3 / 1.2, 200e3 / 2.6);
    let constants = ElementConstants {
        bulk,
        shear,
        hourglass: HourglassControl { stiffness: 0.005, viscosity: 0.0, relaxes: true, enhanced: 0.0 },
        bulk_viscosity: BulkViscosity::default(),
        shear_viscosity: 0.0,
        by_area: false,
    };
    let bare = QuadGroup::new(
        VonMises::new(NoPlasticity, ConstantBulkModulus),
        constants,
        7.85e-9,
        &elements,
        state.dofs.nodes.as_slice(),
    );
    assert_eq!(elastic.groups[0].bytes(), bare.bytes());
}

/// Returns the bytes of all ledger rows, including reserved ones.
fn bytes_of_ledger(ledger: &Ledger) -> usize {
    let of_row = |row: &LedgerRow| row.reserved + row.arrays.iter().map(|array| array.1).sum::<usize>();
    ledger.effects.iter().map(of_row).sum()
}

/// Returns the bytes listed in the ledger, and those allocated by plan, state and run.
fn listed_and_allocated_bytes(text: &str, routines: &Routines) -> (usize, usize) {
    let (deck, _) = deck::read_text("test.inp", text, &[]);
    let (mut model, _) = model::build(&deck);
    // Otherwise the plan shares the model, for new meshes.
    model.kept_meshes = (0..model.mesh.elements.len()).collect();
    let mut compiled = None;
    let compiling = allocation_counter::measure(|| {
        // The plan owns the mesh.
        let mesh = Mesh::clone(&model.mesh).into();
        compiled = Some(plan::compile(&Model { mesh, ..model.clone() }, routines));
    });
    let CompiledModel { plan, state, diagnostics: found } = compiled.expect("a plan");
    assert!(!found.has_errors(), "{}", found.render(&deck.sources));
    let listed = bytes_of_ledger(&plan.ledger);
    let mut memory = RunHistory::default();
    let running = allocation_counter::measure(|| drop(revolve::solve::run(&plan, state, &mut memory)));
    let of_run = running.bytes_max;
    println!("{} bytes at the start, at most {of_run} more in the run", compiling.bytes_current);
    (listed, compiling.bytes_current as usize + of_run as usize)
}

/// Returns a rod on a plate with element deletion: contact reserves memory for every face that deletion may expose.
fn eroding_plate() -> String {
    let text = std::fs::read_to_string(common::project("input/rod_plate_deletion.inp")).expect("a deck");
    text.split("*Output").next().expect("text").replace("<time>", "1e-8") + "*End Step\n"
}

/// Source: a counting allocator. Tolerance: 5 %, for memory that belongs to no row (text of the ledger itself, short
/// lists).
#[test]
fn ledger_lists_allocated_bytes() {
    let end = "*Step\n*Dynamic, Explicit\n , 1e-7\n*Boundary\n J0, 2, 2\n*Dsload\n J1, P, 1.\n*Output, history, number interval=1\n\
               *Energy Output\n ALLIE\n*End Step\n";
    let mesh = |n: usize| grid(n, n, false, |i, j| [0.1 * i as f64, 0.1 * j as f64]);
    let tough = "*Plastic\n 400., 0.\n 500., 0.1\n*Shear Failure\n 0.02,\n";
    let gas = "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Density\n 1e-9,\n*Specific Heat\n 7e8,\n\
               *Eos, type=IDEAL GAS\n 2.87e8,\n";
    let scenes = [
        ("elastic", mesh(60) + &material(200e3, 0.3, 7.85e-9, "") + end),
        ("failing", mesh(60) + &material(200e3, 0.3, 7.85e-9, tough) + end),
        ("gas", mesh(60) + gas + &end.replace("J1, P, 1.", "J1, P, 1e-9")),
        ("of the user", mesh(60) + OF_THE_USER + end),
        ("rigid", common::ogive().replace("n    = 20", "n    = 4000")),
        ("general contact", eroding_plate()),
    ];
    let routines = Routines::none().with_material(ConstantStress);
    for (name, text) in scenes {
        let (listed, held) = listed_and_allocated_bytes(&text, &routines);
        println!("{name}: the ledger lists {listed} bytes, {held} are allocated ({:.3})", listed as f64 / held as f64);
        assert!((listed as f64 / held as f64 - 1.0).abs() < 0.05, "{name}: {listed} of {held}");
    }
}

/// The run times of all rows add up to that of the time loop. The integrator gets the remainder by definition, so the
/// test detects time that is counted twice or lost.
#[test]
fn ledger_times_add_up_to_the_loop_time() {
    let deck = grid(40, 40, false, |i, j| [0.1 * i as f64, 0.1 * j as f64])
        + &material(200e3, 0.3, 7.85e-9, "")
        + "*Step\n*Dynamic, Explicit\n , 2e-5\n*Dsload\n J1, P, 1.\n*End Step\n";
    let prepared = common::prepared(&deck, &[], &Routines::none());
    let (outcome, _) = job::run_in_memory(&prepared);
    let rows: f64 = outcome.effect_seconds.iter().sum();
    assert!(rows >= 0.95 * outcome.seconds && rows <= outcome.seconds * (1.0 + 1e-12), "{rows} of {}", outcome.seconds);
    let of = |effect: &str| {
        let row = prepared.plan.ledger.effects.iter().position(|r| r.effect == effect).expect("a row");
        outcome.effect_seconds[row]
    };
    for effect in ["deformable elements", "nodes", "pressure", "central difference"] {
        assert!(of(effect) > 0.0, "{effect}");
    }
}

/// A mesh whose nodes and elements are all listed, as mesh generators write it. Source: bytes allocated while it is
/// read and resolved, including the text.
#[test]
fn memory_per_listed_node_is_small() {
    let (n, mut text) = (150, String::from("*Node, nset=ALL\n"));
    for i in 0..(n + 1) * (n + 1) {
        let (r, z) = (i % (n + 1), i / (n + 1));
        text += &format!("{:7}, {:13.9}, {:13.9}\n", i + 1, f64::from(r) * 0.01, f64::from(z) * 0.01);
    }
    text += "*Element, type=CAX4R, elset=BODY\n";
    for e in 0..n * n {
        let a = e % n + e / n * (n + 1) + 1;
        text += &format!("{:7}, {a:7}, {:7}, {:7}, {:7}\n", e + 1, a + 1, a + n + 2, a + n + 1);
    }
    text += "*Nset, nset=SAME\n";
    for label in 1..=(n + 1) * (n + 1) {
        text += &format!("{label:6},{}", if label % 16 == 0 { "\n" } else { "" });
    }
    let mut elements = 0;
    let counted = allocation_counter::measure(|| {
        let (deck, listed) = deck::read_text("listed.inp", &text, &[]);
        let (model, resolved) = model::build(&deck);
        assert!(!listed.has_errors() && !resolved.has_errors());
        elements = model.mesh.elements.len() as u64;
    });
    let (bytes, times) = (counted.bytes_max / elements, counted.count_total);
    println!("{} bytes of text, at most {bytes} bytes an element, {times} allocations", text.len() as u64 / elements);
    assert!(elements == u64::try_from(n * n).expect("a number") && bytes < 400 && times < elements / 20);
}

/// A bar whose nodes and elements are generated, with constant increments and with the global estimate. Source: bytes
/// allocated at most while it is read, planned and run with result files. The state for a return after a halt is in a
/// file.
#[test]
fn memory_of_a_run_per_element_is_small() {
    let folder = tempfile::tempdir().expect("a folder");
    let files = JobFiles { folder: folder.path().into(), name: "bar".into() };
    for (increment, most) in [(", direct user control\n 1e-9,", 520), ("\n ,", 720)] {
        let text =
            "*Parameter\n row = 301\n right = row\n left = 1 + 300*row\n corner = left + 300\n above = row + 2\n \
                    beside = row + 1\n*Node, nset=LEFT\n 1, 0., 0.\n*Node\n <right>, 3e-3, 0.\n <left>, 0., 3e-3\n \
                    <corner>, 3e-3, 3e-3\n*Ngen, nset=FOOT\n 1, <right>, 1\n*Ngen, nset=TOP\n <left>, <corner>, 1\n\
                    *Nfill, nset=BAR\n FOOT, TOP, 300, <row>\n*Element, type=CAX4R\n 1, 1, 2, <above>, <beside>\n\
                    *Elgen, elset=SOLID\n 1, 300, 1, 1, 300, <row>, 300\n"
                .to_owned()
                + &material(117e9, 0.35, 8930.0, "*Plastic\n 400e6, 0.\n")
                + "*Initial Conditions, type=VELOCITY\n BAR, 2, -227.\n"
                + &format!("*Step\n*Dynamic, Explicit{increment} 3e-9\n*Boundary\n FOOT, 2, 2\n")
                + "*Output, history, number interval=1\n*Energy Output\n ETOTAL\n*End Step\n";
        let mut planned = 0;
        let counted = allocation_counter::measure(|| {
            let mut prepared = None;
            let planning = allocation_counter::measure(|| {
                prepared = Some(job::prepare_text("bar.inp", &text, &[], &Routines::none()));
            });
            planned = planning.bytes_max / 90_000;
            let mut prepared = prepared.expect("a plan");
            assert!(!prepared.diagnostics.has_errors(), "{}", prepared.diagnostics.render(&prepared.deck.sources));
            let state = Some(std::mem::take(&mut prepared.state));
            let options = JobOptions { state, ..JobOptions::default() };
            assert_eq!(job::run_with(&prepared, &files, options, &mut |_| {}).expect("a run").halt, None);
        });
        let bytes = counted.bytes_max / 90_000;
        println!("{increment:?}: at most {planned} bytes an element in planning, {bytes} in all");
        assert!(bytes <= most, "{bytes} bytes an element");
    }
}

/// 40 identical steps need no more memory than one: bytes of the ledger, of plan and state, and allocated in planning.
#[test]
fn memory_does_not_grow_with_the_number_of_steps() {
    let text = std::fs::read_to_string(common::project("input/rod_plate_deletion.inp")).expect("a deck");
    let (head, step) = text.split_at(text.find("*Step").expect("a step"));
    let conditions = &step[step.find("*Contact\n").expect("contact")..step.find("*Output").expect("output")];
    let bytes = |steps: usize| {
        let later = "*End Step\n*Step\n*Dynamic, Explicit\n , 1.e-6\n".repeat(steps - 1);
        let text = format!("{head}*Step\n*Dynamic, Explicit\n , 1.e-6\n{conditions}{later}*End Step\n");
        let (deck, _) = deck::read_text("test.inp", &text, &[]);
        let model = Arc::new(model::build(&deck).0);
        let mut planned = None;
        let counted = allocation_counter::measure(|| planned = Some(plan::compile_shared(&model, &Routines::none())));
        let CompiledModel { plan, diagnostics: found, .. } = planned.expect("a plan");
        assert!(!found.has_errors() && plan.steps.len() == steps);
        [bytes_of_ledger(&plan.ledger) as i64, counted.bytes_current, counted.bytes_total as i64]
    };
    let (one, many) = (bytes(1), bytes(40));
    println!("ledger, held, allocated in all: {one:?} in one step, {many:?} in 40");
    assert!(one[..2].iter().zip(many).all(|(one, many)| 100 * many < 105 * one));
    // Planning such a step allocates its name, its output times and its ledger rows.
    assert!(100 * many[2] < 110 * one[2]);
}
