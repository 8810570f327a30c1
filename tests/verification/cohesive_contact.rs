//! Cohesive behaviour of contact surfaces (`*COHESIVE BEHAVIOR`).
//!
//! Goal: bonded surfaces with equal and unequal meshes transmit uniform tractions, and dissipate the fracture energy times
//! their area; with equal meshes they are cohesive elements; plates debond at the energy release rate of theory; friction
//! acts after failure; bonds on later and repeated contact; energy balance, stable increment, steps.
//! Source: the energies of the deck; cohesive elements of the same mesh; the closed forms of `cohesive.rs`; Coulomb's law;
//! ABAQUS Analysis User's Guide, "Surface-based cohesive behavior".
//! Tolerance: 1e-6 for energies, 1 % for debonding.

use std::f64::consts::PI;
use std::fmt::Write as _;

use super::cohesive::{
    ELASTIC, ENERGY, FOUNDATION, QUADS, RING, assert_close, assert_reported, edge_separation, layer, mean,
    plate_shells, radii, rings,
};
use crate::common::prepared;
use crate::common::solid::{column, last, run};
use revolve::user::Routines;

/// Cards of the cohesive behaviour with the stiffnesses of [`ELASTIC`].
const BOND: &str = "*Cohesive behavior, eligibility=ORIGINAL CONTACTS\n 1000., 800.\n";
const EVOLUTION: &str = "*Damage evolution, type=ENERGY\n 0.3,\n";

/// Returns a contact pair of the inner faces of [`rings`] with this interaction.
fn pair(interaction: &str) -> String {
    format!("*Surface interaction, name=GLUE\n{interaction}*Contact pair, interaction=GLUE\n ABOVE, BELOW\n")
}

pub(super) fn bonded() -> String {
    pair(&format!("{BOND}{QUADS}{EVOLUTION}"))
}

/// Patch test: rings with equal and unequal meshes under uniform traction. Forces of points on facets of another size are
/// not exact for a uniform traction.
#[test]
fn bonded_rings_transmit_uniform_tractions() {
    for ([n, m], tolerance) in [([3, 3], 2e-3), ([2, 4], 2e-2), ([5, 3], 2e-2)] {
        let nodes = format!("*Nset, nset=JOINT, generate\n 100, {}\n 200, {}\n", 100 + n, 200 + m);
        let mesh = rings(n, m) + &nodes + &bonded();
        let text = format!(
            "{mesh}*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 2., 1.\n*Step\n*Dynamic, explicit\n , \
             3.\n*Boundary\n LOW, 1, 2\n TOP, 1\n*Dsload, amplitude=A\n TOP, P, -5.\n*Output, history, number \
             interval=300\n*Energy output\n ETOTAL, ALLWK, ALLSE\n*Node output, nset=JOINT\n CPRESS, CSHEAR, CSDMG, U2\n*Contact \
             output\n CFN, CFS\n*Element output, elset=RINGS\n S22\n*End step\n"
        );
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        let value = |name: String| mean(&text, &memory, &name);
        // The finer surface carries the tractions.
        let (first, count) = if n > m { (100, n) } else { (200, m) };
        let mut separation = 0.0;
        for i in 0..=count {
            assert_close("traction", value(format!("CPRESS@{}", first + i)), -5.0, tolerance);
            assert!(value(format!("CSHEAR1@{}", first + i)).abs() < 5.0 * tolerance);
            assert_eq!(last(&text, &memory, &format!("CSDMG@{}", first + i)), 0.0);
        }
        for (node, sign) in [(200, 1.0), (100, -1.0)] {
            separation += sign * value(format!("U2@{node}"));
        }
        assert_close("separation", separation, 5.0 / 1000.0, tolerance);
        assert_close("force", value("CFN2@ABOVE_BELOW".into()), -5.0 * RING, 2e-3);
        assert!(value("CFS1@ABOVE_BELOW".into()).abs() < 5.0 * RING * tolerance);
        // The first layer of elements of unequal meshes has stresses that are not uniform.
        if n == m {
            assert_close("stress", value("S22@200".into()), 5.0, tolerance);
        }
        // The increments at the end of the step differ.
        assert!(last(&text, &memory, "ETOTAL").abs() < 1e-5 * last(&text, &memory, "ALLWK"));
    }
}

/// Returns rings with these cards whose faces are pulled apart at the velocity 0.1.
pub(super) fn pulled(mesh: &str, control: &str) -> String {
    format!(
        "{mesh}*Step\n*Dynamic, explicit{control}, 2.\n*Boundary\n LOW, 1, 2\n*Boundary, type=VELOCITY\n TOP, 2, 2, \
         0.1\n*Output, history, number interval=100\n*Energy output\n ALL\n*Node output, nset=TOP\n U, RF\n*End step\n"
    )
}

#[test]
fn rings_that_are_pulled_apart_dissipate_the_fracture_energy() {
    for [n, m] in [[3, 3], [2, 5], [7, 3]] {
        for criterion in [QUADS, "*Damage initiation, criterion=MAXU\n 0.01, 0.015\n"] {
            for softening in ["LINEAR", "EXPONENTIAL"] {
                let evolution = format!("*Damage evolution, type=ENERGY, softening={softening}\n 0.3,\n");
                let mesh = rings(n, m) + &pair(&format!("{BOND}{criterion}{evolution}"));
                let text = pulled(&mesh, "\n ");
                let (outcome, memory) = run(&text);
                assert_eq!(outcome.halt, None);
                // Exponential softening ends at infinity. With unequal meshes the ratio of the modes changes a little.
                let tolerance = match softening {
                    "LINEAR" if n == m => 1e-6,
                    "LINEAR" => 1e-5,
                    _ => 1e-2,
                };
                assert_close("energy", last(&text, &memory, "ALLDMD"), 0.3 * RING, tolerance);
                let work = last(&text, &memory, "ALLWK");
                // The velocity is prescribed suddenly: the first increment has an error.
                assert!(last(&text, &memory, "ETOTAL").abs() < 1e-4 * work, "{}", last(&text, &memory, "ETOTAL"));
                let rows = column(&text, &memory, "ALLSE");
                assert!(rows.iter().all(|row| row.1 > -1e-4 * work));
            }
        }
    }
}

/// Bonds between the nodes of equal meshes are cohesive elements, except that their frame is that of a facet in place of
/// the mid-surface: both give the same forces at equal increments.
#[test]
fn equal_meshes_are_cohesive_elements() {
    assert_equal_to_elements(ELASTIC, BOND, "", 1e-4);
}

#[test]
fn equal_meshes_with_coupled_tractions_are_cohesive_elements() {
    // The rings rotate by different angles: the facet turns by 1e-3 against the mid-surface.
    for coupling in [300.0, -300.0] {
        assert_equal_to_elements(
            &format!("*Elastic, type=COUPLED TRACTION\n 1000., 800., 0., {coupling}\n"),
            &format!("*Cohesive behavior, type=COUPLED, eligibility=ORIGINAL CONTACTS\n 1000., 800., 0., {coupling}\n"),
            "",
            1e-3,
        );
    }
}

#[test]
fn equal_meshes_with_viscous_damage_are_cohesive_elements() {
    // A point fails at the damage 0.999. An element acts until both points have failed.
    assert_equal_to_elements(ELASTIC, BOND, "*Damage stabilization\n 0.05,\n", 1e-3);
}

/// Compares bonds of this behaviour with cohesive elements of this elasticity, with further cards of the damage.
#[track_caller]
fn assert_equal_to_elements(elastic: &str, behavior: &str, more: &str, tolerance: f64) {
    let damage = format!("{QUADS}*Damage evolution, type=ENERGY, mixed mode behavior=BK, power=1.8\n 0.3, 0.5\n{more}");
    let (law, of_surfaces) = (format!("{elastic}{damage}"), format!("{behavior}{damage}"));
    // Shear begins under tension: the contact of the surfaces has no pressure.
    let later = "*Amplitude, name=LATER\n 0., 0., 0.1, 0., 0.2, 1.\n*Step\n";
    let shear = "*Boundary, type=VELOCITY, amplitude=LATER\n TOP, 1, 1, 0.03\n*Output";
    let deck =
        |mesh: &str| pulled(mesh, ", direct user control\n 1e-3").replace("*Step\n", later).replace("*Output", shear);
    let elements = deck(&(rings(3, 3) + &layer(100, 200, 3, &law)));
    let surfaces = deck(&(rings(3, 3) + &pair(&of_surfaces)));
    let [(_, one), (_, other)] = [&elements, &surfaces].map(|text| run(text));
    for name in ["ALLWK", "RF1@301", "RF2@300"] {
        let [a, b] = [(&elements, &one), (&surfaces, &other)].map(|(text, memory)| column(text, memory, name));
        let largest = a.iter().map(|row| row.1.abs()).fold(0.0, f64::max);
        assert_eq!(a.len(), b.len());
        for (x, y) in a.iter().zip(&b) {
            assert!((x.1 - y.1).abs() < tolerance * largest, "{name} {x:?} {y:?}");
        }
        assert!(largest > 1.0, "{name}");
    }
    let [a, b] = [(&elements, &one), (&surfaces, &other)].map(|(text, memory)| last(text, memory, "ALLDMD"));
    assert_close("energy", b, a, tolerance);
}

/// A tube that is pulled out of a bonded sleeve: uniform shear, the fracture energy of the shear mode, and friction under
/// the pressure on the sleeve afterwards. The tubes have unequal meshes and no Poisson's ratio.
fn sleeve(interaction: &str, pressure: f64, velocity: f64, time: f64) -> String {
    let mut text = String::from("*Node, nset=ALL\n");
    let (n, m) = (5, 7);
    for (first, count, low, high) in [(1, n, 1.0, 2.0), (101, m, 2.0, 3.0)] {
        for j in 0..=count {
            let z = 3.0 * j as f64 / count as f64;
            write!(text, " {}, {low}, {z:.17e}\n {}, {high}, {z:.17e}\n", first + 2 * j, first + 2 * j + 1)
                .expect("text");
        }
    }
    for (name, first, count) in [("TUBE", 1, n), ("SLEEVE", 101, m)] {
        writeln!(text, "*Element, type=CAX4R, elset={name}").expect("text");
        for j in 0..count {
            let a = first + 2 * j;
            writeln!(text, " {}, {a}, {}, {}, {}", first + j, a + 1, a + 3, a + 2).expect("text");
        }
    }
    write!(
        text,
        "*Elset, elset=BOTH\n TUBE, SLEEVE\n*Nset, nset=INNER, generate\n 1, {}, 2\n*Nset, nset=OUTER, generate\n 102, {}, \
         2\n*Nset, nset=JOINT, generate\n 101, {}, 2\n*Surface, name=INSIDE\n SLEEVE, S4\n*Surface, name=OUTSIDE\n TUBE, \
         S2\n*Surface, name=SKIN\n SLEEVE, S2\n*Solid section, elset=BOTH, material=STEEL\n*Material, name=STEEL\n*Density\n \
         1.,\n*Elastic\n 1e5, 0.\n*Surface interaction, name=GLUE\n{interaction}*Contact pair, interaction=GLUE\n INSIDE, \
         OUTSIDE\n*Amplitude, name=V, definition=SMOOTH STEP\n 0., 0., {time:e}, 1.\n*Amplitude, name=P, definition=SMOOTH \
         STEP\n 0., 0., {:e}, 1.\n*Step\n*Dynamic, explicit\n , {time:e}\n*Boundary\n INNER, 1, 2\n*Boundary, \
         amplitude=V\n OUTER, 2, 2, {:e}\n",
        1 + 2 * n,
        102 + 2 * m,
        101 + 2 * m,
        0.2 * time,
        velocity * time
    )
    .expect("text");
    if pressure != 0.0 {
        write!(text, "*Dsload, amplitude=P\n SKIN, P, {pressure:e}\n").expect("text");
    }
    text + "*Output, history, number interval=400\n*Energy output\n ALL\n*Node output, nset=OUTER\n RF2\n*Node output, \
            nset=JOINT\n CPRESS, CSHEAR, CSDMG, CSQUADSCRT\n*Contact output\n CFN, CFS, CAREA\n*End step\n"
}

/// Area of the joint of [`sleeve`].
const JOINT: f64 = 2.0 * PI * 2.0 * 3.0;

#[test]
fn sleeve_debonds_in_shear() {
    let text = sleeve(&format!("{BOND}{QUADS}{EVOLUTION}"), 0.0, 0.02, 10.0);
    let (outcome, memory) = run(&text);
    assert_eq!(outcome.halt, None);
    // The sleeve bends, so that the shear mode has a small part of the normal mode.
    assert_close("energy", last(&text, &memory, "ALLDMD"), 0.3 * JOINT, 1e-4);
    assert!(last(&text, &memory, "ETOTAL").abs() < 1e-4 * last(&text, &memory, "ALLWK"));
    // The largest shear stress is the strength 12 of the shear mode.
    let largest = (0..=7).flat_map(|j| column(&text, &memory, &format!("CSHEAR1@{}", 101 + 2 * j)));
    let largest = largest.map(|row| row.1.abs()).fold(0.0, f64::max);
    assert_close("strength", largest, 12.0, 2e-2);
    let forces = column(&text, &memory, "CFS2@INSIDE_OUTSIDE");
    let largest = forces.iter().map(|row| row.1.abs()).fold(0.0, f64::max);
    assert_close("force", largest, 12.0 * JOINT, 3e-2);
    for j in 0..=7 {
        assert_eq!(last(&text, &memory, &format!("CSDMG@{}", 101 + 2 * j)), 1.0);
        assert_eq!(last(&text, &memory, &format!("CSHEAR1@{}", 101 + 2 * j)), 0.0);
    }
}

/// Friction begins with the damage; after failure it is Coulomb's.
#[test]
fn friction_acts_after_failure() {
    let text = sleeve(&format!("*Friction\n 0.2,\n{BOND}{QUADS}{EVOLUTION}"), 20.0, 0.02, 10.0);
    let (outcome, memory) = run(&text);
    assert_eq!(outcome.halt, None);
    assert_close("energy", last(&text, &memory, "ALLDMD"), 0.3 * JOINT, 1e-4);
    let [normal, shear] = ["CFN1@INSIDE_OUTSIDE", "CFS2@INSIDE_OUTSIDE"].map(|name| column(&text, &memory, name));
    let intact = column(&text, &memory, "CSDMG@107").iter().take_while(|row| row.1 == 0.0).count();
    let energies = column(&text, &memory, "ALLFD");
    assert!(intact > 20 && energies[..intact].iter().all(|row| row.1 == 0.0), "{intact}");
    let tail = 3 * normal.len() / 4..normal.len();
    let sum = |rows: &[(f64, f64)]| rows[tail.clone()].iter().map(|row| row.1).sum::<f64>();
    assert_close("coefficient", -sum(&shear) / sum(&normal), 0.2, 1e-2);
    assert!(last(&text, &memory, "ALLFD") > 0.0);
    let drift = last(&text, &memory, "ETOTAL") / last(&text, &memory, "ALLWK");
    assert!(drift.abs() < 1e-4, "{drift}");
}

/// Bonds without damage act at a distance of several facets, from which contact reads no facets.
#[test]
fn bonds_act_at_any_distance() {
    for [n, m] in [[3, 3], [2, 5]] {
        let mesh = rings(n, m) + &pair("*Cohesive behavior, eligibility=ORIGINAL CONTACTS\n 1., 1.\n");
        let text = moved(&mesh, [40.0, 40.0, 40.0]);
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        // The foot and the point move apart by 4 along the normal.
        assert_close("stored energy", last(&text, &memory, "ALLWK"), 0.5 * 4.0 * 4.0 * RING, 2e-2);
        assert_close("stress", last(&text, &memory, "S22@1"), 4.0, 2e-2);
        let drift = last(&text, &memory, "ETOTAL") / last(&text, &memory, "ALLWK");
        assert!(drift.abs() < 1e-3, "{drift}");
    }
}

/// Returns a deck of rings whose upper face moves by 0.1 times these values at the times 2, 4, 6.
fn moved(mesh: &str, [first, second, third]: [f64; 3]) -> String {
    format!(
        "{mesh}*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 2., {first}, 4., {second}, 6., \
         {third}\n*Step\n*Dynamic, explicit\n , 6.\n*Boundary\n LOW, 1, 2\n TOP, 1\n*Boundary, amplitude=A\n TOP, 2, 2, \
         0.1\n*Output, history, number interval=600\n*Energy output\n ALLDMD, ETOTAL, ALLWK\n*Element output, \
         elset=RINGS\n S22\n*End step\n"
    )
}

/// Rings that are pulled apart, pressed together and pulled apart again: with REPEATED CONTACTS they are bonded twice. The
/// contact of debonded faces resists compression.
#[test]
fn repeated_contacts_bond_again() {
    for (parameter, times) in [("", 1.0), (", repeated contacts", 2.0)] {
        let mesh = rings(3, 4) + &pair(&format!("*Cohesive behavior{parameter}\n 1000., 800.\n{QUADS}{EVOLUTION}"));
        let text = moved(&mesh, [1.0, -0.5, 1.0]);
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        assert_close("energy", last(&text, &memory, "ALLDMD"), times * 0.3 * RING, 1e-6);
        let pressed = column(&text, &memory, "S22@1").iter().map(|row| row.1).fold(0.0, f64::min);
        assert!(pressed < -200.0, "{pressed}");
        let drift = last(&text, &memory, "ETOTAL") / last(&text, &memory, "ALLWK");
        assert!(drift.abs() < 1e-3, "{drift}");
    }
}

/// Returns [`rings`] with a gap between them.
fn rings_apart(n: usize, m: usize, gap: f64) -> String {
    let is_upper = |line: &str| line.trim_start().starts_with(['2', '3']) && line.matches(',').count() == 2;
    let raised = |line: &str| match line.rsplit_once(", ") {
        Some((rest, z)) if is_upper(line) => format!("{rest}, {}\n", z.parse::<f64>().expect("z") + gap),
        _ => format!("{line}\n"),
    };
    let text = rings(n, m);
    let (nodes, rest) = text.split_once("*Element").expect("elements");
    nodes.lines().map(raised).collect::<String>() + "*Element" + rest
}

/// Rings that come into contact later are bonded with ELIGIBILITY=CURRENT CONTACTS, the default, only.
#[test]
fn current_contacts_bond_later() {
    for (parameter, area) in
        [("", RING), (", eligibility=CURRENT CONTACTS", RING), (", eligibility=ORIGINAL CONTACTS", 0.0)]
    {
        let bond = format!("*Cohesive behavior{parameter}\n 1000., 800.\n{QUADS}{EVOLUTION}");
        let text = moved(&(rings_apart(4, 3, 0.05) + &pair(&bond)), [-1.0, 1.0, 1.0]);
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        let found = last(&text, &memory, "ALLDMD");
        assert!((found - 0.3 * area).abs() < 1e-6, "{parameter}: {found}");
        let warnings = prepared(&text, &[], &Routines::none()).diagnostics;
        assert_eq!(warnings.iter().any(|d| d.code == "P148"), area == 0.0, "{parameter}");
    }
    // ADJUST closes the gap.
    let closed = format!("{BOND}{QUADS}{EVOLUTION}");
    let closed = pair(&closed).replace("interaction=GLUE\n ABOVE", "interaction=GLUE, adjust=0.06\n ABOVE");
    let text = moved(&(rings_apart(4, 3, 0.05) + &closed), [1.0, 1.0, 1.0]);
    let (_, memory) = run(&text);
    assert_close("energy", last(&text, &memory, "ALLDMD"), 0.3 * RING, 1e-6);
}

/// General contact with an assigned interaction bonds the same points as a contact pair.
#[test]
fn general_contact_assigns_cohesive_behavior() {
    let interaction = format!("*Surface interaction, name=GLUE\n{BOND}{QUADS}{EVOLUTION}");
    let general = |assignment: &str| {
        format!(
            "{}{interaction}*Contact\n*Contact inclusions, all exterior\n*Contact property assignment\n {assignment}, GLUE\n",
            rings(3, 5)
        )
    };
    for assignment in [" , ", "ABOVE, BELOW"] {
        let text = pulled(&general(assignment), "\n ");
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        assert_close("energy", last(&text, &memory, "ALLDMD"), 0.3 * RING, 1e-6);
    }
    let text = pulled(&general("ABOVE, TOP"), "\n ");
    assert_eq!(last(&text, &run(&text).1, "ALLKE").min(0.0), 0.0);
    assert!(
        !prepared(&text, &[], &Routines::none()).plan.ledger.effects.iter().any(|r| r.effect == "cohesive contact")
    );
}

/// A rigid ring that is bonded to an elastic one and tears itself off: fracture energy, and balance of energies and
/// momentum.
#[test]
fn rigid_body_debonds() {
    for [n, m] in [[3, 4], [5, 3]] {
        let mesh = rings(n, m) + "*Node, nset=REF\n 900, 0., 0.\n*Rigid body, ref node=900, elset=LOWER\n" + &bonded();
        let text = format!(
            "{mesh}*Initial conditions, type=VELOCITY\n REF, 2, -1.5\n*Step\n*Dynamic, explicit\n , 0.5\n*Boundary\n TOP, 1, \
             2\n*Output, history, number interval=200\n*Energy output\n ALL\n*Node output, nset=REF\n V2, A2, U2\n*Contact \
             output\n CFN\n*End step\n"
        );
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        assert_close("energy", last(&text, &memory, "ALLDMD"), 0.3 * RING, 1e-6);
        let most = 0.5 * RING * 1.5 * 1.5;
        assert!(last(&text, &memory, "ALLSE") + last(&text, &memory, "ALLKE") < most - 0.29 * RING);
        let totals = column(&text, &memory, "ETOTAL");
        assert!(totals.iter().all(|row| (row.1 - totals[0].1).abs() < 1e-4 * most), "{:?}", totals.last());
        // Mass times acceleration of the body is the force of the bonds, which is a mean over the output interval.
        let [a, f] = ["A2@REF", "CFN2@ABOVE_BELOW"].map(|name| column(&text, &memory, name));
        let (a, f) = a.iter().zip(&f).find(|(a, _)| a.0 > 0.02).expect("a row");
        assert_close("acceleration", a.1 * RING, -f.1, 2e-2);
    }
}

/// The increment follows from the stiffness of the bonds and the masses of the nodes, as that of cohesive elements.
#[test]
fn increment_follows_from_the_masses_of_the_nodes() {
    let of = |mesh: String| {
        let text = format!(
            "{mesh}*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 2., 1.\n*Step\n*Dynamic, explicit\n , \
             3.\n*Boundary\n LOW, 1, 2\n TOP, 1\n*Dsload, amplitude=A\n TOP, P, -2.\n*Output, history, number \
             interval=300\n*Energy output\n ETOTAL, ALLWK\n*End step\n"
        );
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        // The increments at the end of the step differ.
        assert!(last(&text, &memory, "ETOTAL").abs() < 1e-5 * last(&text, &memory, "ALLWK"));
        outcome.increments as f64
    };
    let elements = of(rings(3, 3) + &layer(100, 200, 3, "*Elastic, type=TRACTION\n 1e7, 1e7\n"));
    let surfaces = of(rings(3, 3) + &pair("*Cohesive behavior\n 1e7, 1e7\n"));
    // The normal stiffness acts in tension only and counts twice.
    assert_close("increments", surfaces, 2.0_f64.sqrt() * elements, 2e-2);
    // Without a stiffness it is that of the adjacent elements.
    let default = of(rings(3, 3) + &pair("*Cohesive behavior\n"));
    let none = of(rings(3, 3) + &pair(""));
    assert!(default < 2.0 * none, "{default} {none}");
}

/// Returns a plate of shells with nodes at these radii, bonded from the node `first` on to a rigid base of four elements.
/// Elements that are shorter than `coarse` have a density that gives them the increment of this length. The base resists
/// compression by hard contact, or by the stiffness of the bond, as cohesive elements do.
fn bonded_plate(radii: &[f64], first: usize, coarse: f64, (is_hard, time): (bool, f64)) -> String {
    let mut text = String::from("*Node\n");
    for (i, r) in radii.iter().enumerate() {
        writeln!(text, " {}, {r:.17e}, 0.", i + 1).expect("text");
    }
    text += &plate_shells(radii, first, coarse);
    let (count, [from, to]) = (radii.len(), [radii[first], radii[radii.len() - 1]]);
    for i in 0..=4 {
        writeln!(text, "*Node\n {}, {:.17e}, 0.", 20_001 + i, from + (to - from) * f64::from(i) / 4.0).expect("text");
    }
    for i in 20_001..20_005 {
        writeln!(text, "*Element, type=RAX2, elset=BASE\n {i}, {i}, {}", i + 1).expect("text");
    }
    let strength = FOUNDATION * (1.96 * ENERGY / FOUNDATION).sqrt();
    let compression = if is_hard {
        String::new()
    } else {
        format!("*Surface behavior, pressure-overclosure=LINEAR\n {FOUNDATION}\n")
    };
    write!(
        text,
        "*Rigid body, ref node=20001, elset=BASE\n*Surface, name=PLATE\n BONDED, SNEG\n*Surface, name=FLOOR\n BASE, \
         SPOS\n*Surface interaction, name=GLUE\n{compression}*Cohesive behavior, \
         eligibility=ORIGINAL CONTACTS\n {FOUNDATION}, {FOUNDATION}\n*Damage initiation, criterion=MAXS\n \
         {strength:.17e}, {strength:.17e}\n*Damage evolution, type=ENERGY\n {ENERGY:e},\n*Contact pair, \
         interaction=GLUE, no thickness\n PLATE, FLOOR\n*Nset, nset=CENTRE\n 1\n*Nset, nset=END\n {count}\n*Nset, \
         nset=TIP\n {}\n*Amplitude, name=SLOWLY, definition=SMOOTH STEP\n 0., 0., {time:e}, 1.\n*Boundary\n CENTRE, \
         XSYMM\n END, ENCASTRE\n 20001, ENCASTRE\n",
        first + 1
    )
    .expect("text");
    text
}

/// The blister of `cohesive.rs` with unequal meshes: a clamped circular plate under pressure debonds at the energy release
/// rate of theory.
#[test]
fn pressurised_blister_debonds_at_the_energy_release_rate_of_theory() {
    let a = 100.0;
    let unit = edge_separation(a * a / 8.0, a / 2.0, a);
    let expected = (2.0 * ENERGY / FOUNDATION).sqrt() / unit;
    let time = 6.0 * 2.0 * PI * a * a / 10.2158;
    let of = |size: f64, is_hard: bool| {
        let (list, first) = radii(a, 40, size, a + 6.0);
        let text = format!(
            "{}*Step\n*Dynamic, explicit\n , {:e}\n*Dload, amplitude=SLOWLY\n FREE, P, {:e}\n*Output, history, number \
             interval=4000\n*Node output, nset=TIP\n CSDMG\n*Energy output\n ETOTAL, ALLWK\n*End step\n",
            bonded_plate(&list, first, 2.0, (is_hard, time)),
            0.6 * time,
            2.0 * expected
        );
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None);
        let drift = last(&text, &memory, "ETOTAL") / last(&text, &memory, "ALLWK");
        assert!(drift.abs() < 1e-4, "{drift}");
        let rows = column(&text, &memory, "CSDMG@TIP");
        let x = rows.iter().find(|row| row.1 > 0.4).expect("debonding").0 / time;
        2.0 * expected * x * x * x * (10.0 - 15.0 * x + 6.0 * x * x)
    };
    let found = [0.2, 0.1, 0.05].map(|size| of(size, false));
    let hard = of(0.1, true);
    println!("blister: {found:?}, hard {hard}, expected {expected}");
    let errors = found.map(|p| (p / expected - 1.0).abs());
    // Order 1.3 over both refinements and over the first one.
    assert!(errors[1] < 0.4 * errors[0] && errors[2] < 0.16 * errors[0], "{errors:?}");
    assert_close("pressure", found[2], expected, 1e-2);
    assert_close("pressure with hard contact", hard, expected, 1e-2);
}

/// A step that repeats the contact pair, or omits it, continues the bonds: the results have the same bits as in one step.
#[test]
fn bonds_continue_over_steps() {
    let mesh = rings(3, 5) + &bonded();
    let one = |duration: f64, extra: &str| {
        format!(
            "*Step\n*Dynamic, explicit, direct user control\n 0.0009765625, {duration}\n{extra}*Boundary, op=NEW\n LOW, 1, \
             2\n*Boundary, type=VELOCITY, op=NEW\n TOP, 2, 2, 0.1\n LOW, 1, 1, 0.\n LOW, 2, 2, 0.\n*Output, history, \
             frequency=64\n*Energy output\n ALL\n*Node output, nset=TOP\n U, RF\n*End step\n"
        )
    };
    let whole = mesh.clone() + &one(1.0, "");
    let (_, reference) = run(&whole);
    let damage = last(&whole, &reference, "ALLDMD");
    assert!(damage > 0.0);
    let pair = "*Contact pair, interaction=GLUE\n ABOVE, BELOW\n";
    // 0.25 is in the middle of the softening.
    for extra in ["", pair] {
        let split = mesh.clone() + &one(0.25, "") + &one(0.75, extra);
        let (outcome, memory) = run(&split);
        assert_eq!(outcome.halt, None);
        for name in ["ALLDMD", "ALLIE", "ALLKE", "U2@301", "RF2@300"] {
            let [a, b] = [last(&whole, &reference, name), last(&split, &memory, name)];
            assert_eq!(a.to_bits(), b.to_bits(), "{name} {a} {b}");
        }
    }
}

/// Elements of a bonded face that are deleted release the bond.
#[test]
fn deleted_elements_release_their_bonds() {
    let mesh =
        rings(3, 3).replace("*Elastic\n 1e4, 0.\n", "*Elastic\n 1e4, 0.\n*Plastic\n 6., 0.\n*Shear failure\n 0.002,\n");
    let bond = pair("*Cohesive behavior\n 1e4, 1e4\n");
    let text = pulled(&(mesh + &bond), "\n ");
    let (outcome, memory) = run(&text);
    assert_eq!(outcome.halt, None);
    assert!(outcome.deleted > 0);
    let work = last(&text, &memory, "ALLWK");
    assert!(last(&text, &memory, "ETOTAL").abs() < 1e-3 * work, "{}", last(&text, &memory, "ETOTAL"));
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let plain = pulled(&(rings(40, 57) + &bonded()), "\n ").replace(", 2.\n", ", 0.5\n");
    let coupled = plain.replace("*Cohesive behavior,", "*Cohesive behavior, type=COUPLED,");
    let coupled = coupled.replace(" 1000., 800.\n", " 1000., 800., , 300.\n");
    let viscous = coupled.replace(EVOLUTION, &format!("{EVOLUTION}*Damage stabilization\n 0.05,\n"));
    for text in [plain, viscous] {
        let digest = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| run(&text).0.digest)
        };
        let one = digest(1);
        for threads in [2, 5] {
            assert!(one == digest(threads), "{threads} threads");
        }
    }
}

#[test]
fn ledger_lists_cohesive_contact() {
    let text = pulled(&(rings(3, 5) + &bonded()), "\n ");
    let found = prepared(&text, &[], &Routines::none());
    let row = found.plan.ledger.effects.iter().find(|row| row.effect == "cohesive contact").expect("a row");
    assert_eq!((row.count, row.unit), (6, "points"));
    assert!(row.detail.contains("6 of 6 points bonded at the start"), "{}", row.detail);
    let plain = pulled(&(rings(3, 5) + &pair("")), "\n ");
    let plain = prepared(&plain, &[], &Routines::none());
    assert!(plain.plan.ledger.effects.iter().all(|row| row.effect != "cohesive contact"));
}

/// Invalid decks end with a code and a place.
#[test]
fn invalid_cohesive_surfaces_are_reported() {
    let good = pulled(&(rings(3, 5) + &bonded()), "\n ");
    let elements = format!("*Material, name=OTHER\n{ELASTIC}*Damage initiation, criterion=MAXU\n 1., 1.\n*Step");
    let cases: &[(&str, &str, &str, &str)] = &[
        (" 1000., 800.\n", " 1000.,\n", "M103", "both the normal and the shear stiffness"),
        (" 1000., 800.\n", " -1000., 800.\n", "M103", "normal stiffness"),
        ("*Cohesive behavior,", "*Cohesive behavior, dependencies=1,", "M104", "DEPENDENCIES"),
        ("eligibility=ORIGINAL", "eligibility=SPECIFIED", "M103", "ELIGIBILITY"),
        (BOND, "", "M105", "must follow its *COHESIVE BEHAVIOR"),
        (QUADS, "", "M105", "*DAMAGE EVOLUTION must follow"),
        (QUADS, "*Damage initiation, criterion=QUADE\n 0.1, 0.1\n", "M104", "does not apply to cohesive surfaces"),
        (
            QUADS,
            "*Damage initiation, criterion=MAXS\n 1., 1.\n*Damage initiation, criterion=MAXU\n 1., 1.\n",
            "M104",
            "one *DAMAGE INITIATION",
        ),
        (" 0.3,\n", " 1e-3,\n", "P027", "less than the elastic energy"),
        ("*Damage evolution", "*Damage stabilization\n 1e-3,\n*Damage evolution", "M105", "DAMAGE STABILIZATION"),
        ("*Step", &elements, "M104", "apply only to cohesive surfaces"),
    ];
    assert_reported(&good, cases);
    let coupled = good.replacen("*Cohesive behavior,", "*Cohesive behavior, type=COUPLED,", 1);
    assert_reported(&coupled, &[(" 1000., 800.\n", " 1000., 800., , 900.\n", "M103", "less than 8.9")]);
    let wall = "*Node\n 900, 0., 1.\n*Surface, name=WALL, type=SEGMENTS\n START, 9., 1.\n LINE, 0., 1.\n*Rigid body, ref \
                node=900, analytical surface=WALL\n*Boundary\n 900, ENCASTRE\n*Surface interaction";
    let text = good.replacen("*Surface interaction", wall, 1);
    assert_reported(&text, &[("ABOVE, BELOW\n", "ABOVE, WALL\n", "P027", "analytical surface")]);
}
