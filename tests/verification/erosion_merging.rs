//! Mass of nodes without elements that joins its body (`NODAL EROSION=MERGE`), and the parts of the energy that contact
//! absorbs.
//!
//! Goal: merging conserves momentum to rounding and closes the energy balance, with and without friction and at the axis;
//! the parts of the loss add up to ALLCW, and the warning names the large ones. Source: conservation laws; the closed form
//! 1/(4n) of the loss at the first touch of a bar of n elements (theory of contact). The tolerance and its reason are
//! stated at each test.

use revolve::job;
use revolve::user::Routines;

use crate::common::bodies::{DeckRun, assembly, cell_field, part, run};
use crate::common::solid::grid;
use crate::common::{pairs, project};

fn deleted_count(ran: &DeckRun) -> usize {
    cell_field(ran.end(), "STATUS").iter().filter(|s| **s == 0.0).count()
}

/// Returns a steel rod that perforates an aluminium plate; both are eroded, and nodes on the axis become free.
fn rod_through_plate(nodal: &str, friction: f64, more: &str) -> String {
    let block = |name: &str, [n, m]: [usize; 2], from: f64| part(name, [n, m], |i, j| [i as f64, from + j as f64], "");
    block("ROD", [3, 8], 0.0)
        + &block("PLATE", [9, 5], -5.01)
        + &assembly(&["ROD", "PLATE"], "")
        + "*Material, name=ROD\n*Density\n 7.85e-9,\n*Elastic\n 207e3, .3\n*Plastic\n 900., 0.\n 1100., .2\n*Material, name=PLATE\n\
           *Density\n 2.71e-9,\n*Elastic\n 69e3, .33\n*Plastic\n 300., 0.\n 400., 1.\n*Erosion, plastic strain=0.6, \
           distortion=0.2\n"
        + more
        + &format!("*Surface Interaction, name=I\n*Friction\n {friction},\n")
        + "*Initial Conditions, type=VELOCITY\n ROD.ALL, 2, -8e5\n*Step\n*Dynamic, Explicit\n , 15e-6\n*Contact\n*Contact \
           Inclusions, all exterior\n"
        + &format!("*Contact Controls Assignment, nodal erosion={nodal}\n*Contact Property Assignment\n , , I\n")
        + "*Output, field, number interval=2\n*Node Output\n U, V\n*Element Output\n STATUS\n*Output, history, number \
           interval=20\n*Energy Output\n ALL\n*End Step\n"
}

/// Momentum is conserved to 1e-12, the accumulated rounding of some hundred increments. The parts of the loss add up to
/// ALLCW, and each way to treat free nodes has its own part. The drift of a coarse mesh is below 1 %, as in the random
/// scenes without merging.
#[test]
fn merging_conserves_momentum_and_closes_the_balance() {
    for friction in [0.0, 0.2] {
        for nodal in ["NO", "YES", "MERGE"] {
            let ran = run(&rod_through_plate(nodal, friction, "")).whole();
            let (energy, nodes) = (ran.outcome.energy, &ran.prepared.state.dofs.nodes);
            let before: f64 = nodes.as_slice().iter().zip(&nodes.mass).map(|(n, m)| m * n.v_z).sum();
            let masses = [nodes, &ran.state.dofs.nodes].map(|nodes| nodes.mass.iter().sum::<f64>());
            let off = ran.momentum() / before - 1.0;
            let parts = ran.state.dofs.energies.impacts;
            let share = |part: f64| part / energy.initial;
            println!(
                "{nodal} {friction}: {} deleted, momentum {off:.1e}, drift {:.1e}, first touch {:.4}, gaps {:.4}, points {:.4}, \
                 merged {:.4}",
                deleted_count(&ran),
                energy.drift,
                share(parts.first_touch),
                share(parts.closing_gaps),
                share(parts.free_points),
                share(parts.merged_points)
            );
            assert!(off.abs() < 1e-12 && deleted_count(&ran) > 10, "{off:e}");
            assert!((masses[1] / masses[0] - 1.0).abs() < 1e-13 && energy.drift < 0.01, "{:e}", energy.drift);
            assert!((parts.sum() / energy.contact - 1.0).abs() < 1e-9, "{parts:?} {}", energy.contact);
            assert!(parts.first_touch > 0.0 && parts.closing_gaps > 0.0);
            assert_eq!(
                (parts.free_points > 0.0, parts.merged_points > 0.0),
                (nodal == "NO", nodal == "MERGE"),
                "{parts:?}"
            );
        }
    }
}

/// Merged runs have the same bits on 1, 2 and 5 threads. The plate expands along its axis and is torn.
#[test]
fn merging_does_not_depend_on_the_number_of_threads() {
    let (n, m) = (80, 76);
    let rows: String = (0..=m)
        .map(|j| {
            let (first, end) = (j * (n + 1) + 1, (j + 1) * (n + 1));
            let velocity = 8e5 * (2.0 * j as f64 / m as f64 - 1.0);
            format!("*Nset, nset=ROW{j}, generate\n {first}, {end}, 1\n*Initial Conditions, type=VELOCITY\n ROW{j}, 2, {velocity:e}\n")
        })
        .collect();
    let deck = grid(n, m, false, |i, j| [0.05 * i as f64, 0.05 * j as f64 + 0.003 * ((i * 7 + j * 3) % 5) as f64])
        + "*Solid Section, elset=SOLID, material=M\n*Material, name=M\n*Elastic\n 200e3, .3\n*Plastic\n 400., 0.\n 500., .1\n\
          *Density\n 7.8e-9,\n*Erosion, principal strain=0.12, distortion=0.2\n"
        + &rows
        + "*Step\n*Dynamic, Explicit\n , 0.4e-6\n*Contact\n*Contact Inclusions, all exterior\n*Contact Controls Assignment, nodal \
           erosion=MERGE\n*Output, field, number interval=2\n*Element Output\n STATUS\n*End Step\n";
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| run(&deck).whole())
    };
    let bits = |ran: &DeckRun| -> Vec<u64> {
        let nodes = &ran.state.dofs.nodes;
        let motion = nodes.as_slice().iter().flat_map(|n| n.as_array()).chain(nodes.mass.iter().copied());
        motion.chain([ran.outcome.energy.contact]).map(f64::to_bits).collect()
    };
    let one = on(1);
    assert!(one.state.dofs.energies.impacts.merged_points > 0.0 && deleted_count(&one) > 20);
    for threads in [2, 5] {
        assert!(bits(&one) == bits(&on(threads)), "{threads} threads");
    }
}

/// An elastic bar of n elements hits an equal one at rest: masses are lumped, so the first touch loses 1/(4n) of the kinetic
/// energy, times up to 1.4 if the touch is within an increment. The loss has no other part, and the
/// warning advises smaller elements only.
#[test]
fn first_touch_is_the_only_loss_without_deletion() {
    let n = 4;
    let bar = |name: &str, from: f64| part(name, [1, n], |i, j| [i as f64, from + j as f64], "");
    let deck = bar("UPPER", 0.0)
        + &bar("LOWER", -(n as f64) - 1e-3)
        + &assembly(&["UPPER", "LOWER"], "")
        + "*Material, name=UPPER\n*Density\n 7.8e-9,\n*Elastic\n 200e3, 0.\n*Material, name=LOWER\n*Density\n 7.8e-9,\n*Elastic\n \
           200e3, 0.\n*Initial Conditions, type=VELOCITY\n UPPER.ALL, 2, -1e4\n*Step\n*Dynamic, Explicit\n , \
           1e-6\n*Contact\n*Contact Inclusions, all exterior\n*Output, history, number interval=4\n*Energy Output\n ALLCW\n*End \
           Step\n";
    let ran = run(&deck).whole();
    let (parts, energy) = (ran.state.dofs.energies.impacts, ran.outcome.energy);
    let closed = 1.0 / (4.0 * n as f64);
    println!("first touch {:.5} of the kinetic energy, closed form {closed:.5}", parts.first_touch / energy.initial);
    // The factor is 1 + 2 C² x (1 - x), with the Courant number C < 0.9 and the instant x of the touch within its increment.
    assert!((0.999..1.41).contains(&(parts.first_touch / energy.initial / closed)), "{parts:?}");
    assert_eq!((parts.closing_gaps, parts.free_points, parts.merged_points), (0.0, 0.0, 0.0));
    let warning = ran.outcome.warnings.iter().find(|w| w.starts_with("R309")).expect("a warning");
    assert!(warning.contains("smaller elements at the surfaces") && !warning.contains("EROSION"), "{warning}");
}

/// With nodes without elements in contact, theirs is the largest part, and the warning gives advice for it only. The first
/// touch of the fine mesh loses less than the 0.35 % of the mesh twice as coarse, as a loss of first order.
#[test]
fn warning_names_the_kinds_of_impact_that_lose_most() {
    let prepared = job::prepare(&project("input/rod_plate_deletion.inp"), &pairs(&[("mesh", "4")]), &Routines::none());
    let (outcome, _) = job::run_in_memory(&prepared);
    let (losses, energy) = (outcome.contact_losses.expect("deleted elements").parts, outcome.energy);
    let warning = outcome.warnings.iter().find(|w| w.starts_with("R309")).expect("a warning");
    println!("{warning}");
    let named =
        |text: &str, part: f64| assert_eq!(warning.contains(text), part > 0.25 * energy.contact, "{text}: {warning}");
    named("smaller elements at the surfaces", losses.first_touch);
    named("loss of closing gaps", losses.closing_gaps);
    named("NODAL EROSION=MERGE", losses.free_points);
    assert!(losses.free_points > 0.9 * energy.contact && losses.first_touch < 0.0035 * energy.initial, "{losses:?}");
    assert!(warning.contains(&format!("nodes without elements {:.2} %", 100.0 * losses.free_points / energy.initial)));
}

/// Mass scaling and new meshes would not contain the mass that has merged.
#[test]
fn merging_excludes_mass_scaling_and_new_meshes() {
    let messages = |deck: &str| -> String {
        let prepared = job::prepare_text("test.inp", deck, &[], &Routines::none());
        prepared.diagnostics.render(&prepared.deck.sources)
    };
    let scaled =
        rod_through_plate("MERGE", 0.0, "").replace("*Contact\n", "*Fixed Mass Scaling, factor=2.\n*Contact\n");
    assert!(messages(&scaled).contains("error[P022]"), "{}", messages(&scaled));
    let remeshed = rod_through_plate("MERGE", 0.0, "*Remesh, elset=PLATE.SOLID\n");
    assert!(messages(&remeshed).contains("error[P072]"), "{}", messages(&remeshed));
}
