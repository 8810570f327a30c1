//! Bodies that slide onto each other over edges, and soft contact at edges.
//!
//! Goal: contact exists whichever surface carries the pressures, and soft contact releases at most what it has stored.
//! Source: Lame's thick vessels (Timoshenko and Goodier 1970, Theory of Elasticity, art. 28) for the level of the
//! press fit; conservation of energy. The tolerance and its reason are stated at each test.

use std::fmt::Write as _;

use revolve::user::Routines;

use crate::common::bodies::{DeckRun, assembly, elastic, part, run};
use crate::common::prepared;

/// Materials, and a step of 5 ms in which the ring moves down by 10 mm.
fn press_cards(contact: &str) -> String {
    let steel = [210e3, 0.3, 7.85e-9];
    assembly(&["RING", "SHAFT"], "")
        + &elastic("RING", steel, "")
        + &elastic("SHAFT", steel, "")
        + "*Surface Interaction, name=DRY\n*Initial Conditions, type=VELOCITY\n RING.ALL, 2, -2e3\n*Step\n*Dynamic, Explicit\n , 5e-3\n\
           *Boundary, type=VELOCITY\n RING.J1, 2, 2, -2e3\n*Boundary\n SHAFT.J0, 2, 2\n"
        + contact
        + "*Output, history, number interval=200\n*Contact Output\n CFN\n*Energy Output\n ALLCW, ALLIE\n*End Step\n"
}

/// All faces of a part.
pub const SKIN: &str = "*Surface, name=SKIN\n EI0, S4\n EI1, S2\n EJ0, S1\n EJ1, S3\n";

/// Presses a chamfered ring with an interference of 0.02 mm over the edge of a shaft of the radius 20 mm. `bore` are
/// the rows of elements over 12 mm of the bore, after two rows of chamfer, `shaft` those over 20 mm of the shaft.
fn press([bore, shaft]: [usize; 2], contact: &str) -> DeckRun {
    let height = |j: usize| if j < 2 { 0.05 + 2.0 * j as f64 } else { 4.05 + 12.0 * (j - 2) as f64 / bore as f64 };
    let radius = |z: f64| 20.08 - 0.1 * ((z - 0.05) / 4.0).min(1.0);
    let ring = |i: usize, j: usize| {
        let inner = radius(height(j));
        [inner + (40.0 - inner) * 0.5 * i as f64, height(j)]
    };
    let deck = part("RING", [2, bore + 2], ring, SKIN)
        + &part("SHAFT", [2, shaft], |i, j| [10.0 * i as f64, 20.0 * (j as f64 / shaft as f64 - 1.0)], SKIN)
        + &press_cards(contact);
    run(&deck).whole()
}

/// Returns the mean radial force of the last tenth of the run, kN, and the lowest ALLCW over the final ALLIE.
fn force_and_energy(ran: &DeckRun) -> [f64; 2] {
    let name = ran.prepared.plan.columns.iter().find(|c| c.name.starts_with("CFN1@")).expect("a column").name.clone();
    let force = ran.column(&name);
    let last = &force[force.len() - 20..];
    let lowest = ran.column("ALLCW").iter().fold(0.0_f64, |least, c| least.min(c[1]));
    let stored = ran.column("ALLIE").last().expect("a row")[1];
    [last.iter().map(|f| f[1].abs()).sum::<f64>() / 20e3, lowest / stored]
}

/// The ring slides over the edge of the shaft for any ratio of the meshes, in both orders of the card and in general
/// contact. The force is within 3 % of 110 kN on each mesh, also with facets of 4 mm over the contact length of 6 mm.
/// Contact creates no energy: 1e-3 of the strain energy.
#[test]
fn press_fit_over_an_edge_does_not_depend_on_the_carrying_surface() {
    let pair = |names: &str| format!("*Contact Pair, interaction=DRY\n {names}\n");
    let general = "*Contact\n*Contact Inclusions\n RING.SKIN, SHAFT.SKIN\n*Contact Property Assignment\n , , DRY\n";
    let mut reference = f64::NAN;
    for bore in [3, 6, 12, 24] {
        for shaft in [5, 10, 20, 40] {
            let [force, created] = force_and_energy(&press([bore, shaft], &pair("RING.SKIN, SHAFT.SKIN")));
            println!("{bore} rows of the bore, {shaft} of the shaft: {force:.1} kN, ALLCW {created:.1e} of ALLIE");
            assert!(created > -1.2e-3, "{bore} {shaft}: {created}");
            assert!((force / 110.0 - 1.0).abs() < 0.03, "{bore} {shaft}: {force}");
            if [bore, shaft] == [12, 20] {
                reference = force;
            }
        }
    }
    for contact in [pair("SHAFT.SKIN, RING.SKIN"), general.into()] {
        let force = force_and_energy(&press([12, 20], &contact))[0];
        assert!((force / reference - 1.0).abs() < 1e-12, "{force} {reference}");
    }
}

/// Penalty springs give the same force on any ratio of the meshes, for each choice of the carrying surface: within 3 % of
/// 110 kN. The springs and elements of 10 mm in the radial direction are in series, which takes 0.5 %. General contact
/// chooses one of both surfaces, and has the force of this choice.
#[test]
fn press_fit_with_penalty_springs_has_the_force_of_hard_contact() {
    let pair = |weight: &str| {
        format!("*Contact Pair, interaction=DRY, mechanical constraint=PENALTY{weight}\n RING.SKIN, SHAFT.SKIN\n")
    };
    let general = "*Contact\n*Contact Inclusions\n RING.SKIN, SHAFT.SKIN\n*Contact Property Assignment\n , , DRY\n\
                   *Contact Controls Assignment, type=SCALE PENALTY\n RING.SKIN, SHAFT.SKIN, 1.\n";
    for bore in [3, 6, 12, 24] {
        for shaft in [5, 10, 20, 40] {
            let force_of = |contact: &str| {
                let [force, created] = force_and_energy(&press([bore, shaft], contact));
                println!("{bore} rows of the bore, {shaft} of the shaft: {force:.1} kN, ALLCW {created:.1e} of ALLIE");
                assert!((force / 110.0 - 1.0).abs() < 0.03, "{bore} {shaft} {contact}: {force}");
                force
            };
            let chosen = [", weight=0.", ", weight=1."].map(|weight| force_of(&pair(weight)));
            if [[3, 40], [12, 20], [24, 5]].contains(&[bore, shaft]) {
                let force = force_of(general);
                assert!(chosen.iter().any(|other| (force / other - 1.0).abs() < 1e-12), "{force} {chosen:?}");
            }
        }
    }
}

/// Returns a wide and a narrow block that approach at 0.02, with a soft contact between them.
fn blocks(wide_below: bool, cells: [usize; 2], contact: &str) -> String {
    let place = |width: f64, base: f64, n: usize| {
        move |i: usize, j: usize| [width * i as f64 / n as f64, base + 0.25 * j as f64]
    };
    let [below, above] = if wide_below { [2.0, 1.0] } else { [1.0, 2.0] };
    part("LOWER", [cells[0], 4], place(below, -1.0, cells[0]), SKIN)
        + &part("UPPER", [cells[1], 4], place(above, 0.005, cells[1]), SKIN)
        + &assembly(&["LOWER", "UPPER"], "")
        + &elastic("LOWER", [1.0, 0.3, 1.0], "")
        + &elastic("UPPER", [1.0, 0.3, 1.0], "")
        + "*Surface Interaction, name=SOFT\n"
        + contact
}

/// Two blocks of different width: soft contact of any kind absorbs energy, stores it and releases at most as much, and
/// the bodies separate with the momentum of the closed system.
#[test]
fn soft_contact_at_edges_releases_at_most_what_it_stored() {
    let pair = "*Contact Pair, interaction=SOFT";
    let laws = [
        ("", ", mechanical constraint=PENALTY"),
        ("*Surface Behavior, pressure-overclosure=LINEAR\n 8.,\n", ""),
        ("*Surface Behavior, pressure-overclosure=EXPONENTIAL\n 0.002, 0.004\n", ""),
        ("*Surface Behavior, pressure-overclosure=TABULAR\n 0., 0.\n 0.02, 0.01\n 0.2, 0.03\n", ""),
    ];
    for (law, constraint) in laws {
        for (wide_below, cells) in [(true, [5, 3]), (false, [5, 3]), (true, [6, 2]), (false, [2, 6])] {
            let mut deck = blocks(wide_below, cells, law);
            write!(
                deck,
                "*Initial Conditions, type=VELOCITY\n LOWER.ALL, 2, 0.02\n UPPER.ALL, 2, -0.02\n*Step\n*Dynamic, Explicit\n , 12.\n\
                 {pair}{constraint}\n LOWER.SKIN, UPPER.SKIN\n*Output, history, frequency=1\n*Energy Output\n ALLCW, ALLPW, ALLKE\n*End Step\n"
            )
            .expect("text");
            let ran = run(&deck).whole();
            let penalty = if law.is_empty() { ran.column("ALLPW") } else { Vec::new() };
            let absorbed: Vec<f64> = ran
                .column("ALLCW")
                .iter()
                .enumerate()
                .map(|(at, c)| c[1] + penalty.get(at).map_or(0.0, |p| p[1]))
                .collect();
            let energy = ran.outcome.energy;
            let least = absorbed.iter().fold(0.0_f64, |least, a| least.min(*a)) / energy.initial;
            let most = absorbed.iter().fold(0.0_f64, |most, a| most.max(*a)) / energy.initial;
            println!("{law:?} {cells:?}: between {least:.1e} and {most:.1e} of the energy, drift {:.1e}", energy.drift);
            assert!(least > -1e-6 && most > 1e-3, "{law} {cells:?}: {least} {most}");
            assert!(energy.kinetic <= energy.initial * (1.0 + 1e-9), "{energy:?}");
        }
    }
}

/// A ring of shell elements is pressed against a wider one by a uniform pressure. The springs store the energy `W = p²/2k`
/// per area, so that the ring pushes along the surface with the force 2 pi (b - a) W (virtual work). Half the thickness of
/// both is part of the overclosure. Tolerance 2e-3: bending and the remaining vibration (7e-4).
#[test]
fn shells_push_along_a_surface_by_the_energy_of_soft_contact() {
    let mut deck = String::from("*Node, nset=WIDE\n");
    for i in 0..6 {
        writeln!(deck, " {}, {}, 0.", 1 + i, 0.5 + 0.5 * f64::from(i)).expect("text");
    }
    deck += "*Node, nset=RING\n 101, 1.1, 0.15\n 102, 1.6, 0.15\n 103, 2.1, 0.15\n*Element, type=SAX1, elset=BELOW\n";
    for i in 1..6 {
        writeln!(deck, " {i}, {i}, {}", i + 1).expect("text");
    }
    deck += "*Element, type=SAX1, elset=ABOVE\n 101, 101, 102\n 102, 102, 103\n*Shell Section, elset=BELOW, material=M\n 0.2,\n*Shell \
             Section, elset=ABOVE, material=M\n 0.1,\n*Material, name=M\n*Density\n 1.,\n*Elastic\n 1e6, 0.3\n*Surface, \
             name=FLOOR\n BELOW, SPOS\n*Surface, name=FOOT\n ABOVE, SNEG\n*Surface, name=BACK\n ABOVE, SPOS\n*Surface \
             Interaction, name=SOFT\n*Surface Behavior, pressure-overclosure=LINEAR\n 1000.,\n*Amplitude, name=A, \
             definition=SMOOTH STEP\n 0., 0., 1., 1.\n*Step\n*Dynamic, Explicit\n , 2.\n*Boundary\n WIDE, 1, 6\n RING, 1\n RING, \
             6\n*Dsload, amplitude=A\n BACK, P, 10.\n*Contact Pair, interaction=SOFT, weight=0.\n FLOOR, FOOT\n*Output, history, \
             number interval=200\n*Node Output, nset=RING, statistics=SUM\n RF1\n*End Step\n";
    let rows = run(&deck).whole().column("RF1_SUM@RING");
    let tail = &rows[rows.len() * 3 / 4..rows.len() - 1];
    let force = tail.iter().map(|row| row[1]).sum::<f64>() / tail.len() as f64;
    let ratio = force / (std::f64::consts::TAU * (2.1 - 1.1) * 10.0 * 10.0 / (2.0 * 1000.0));
    assert!((ratio - 1.0).abs() < 2e-3, "{ratio}");
}

/// WEIGHT of a pair and CONTACT FORMULATION of general contact select the surface that carries the pressures: CPRESS has
/// values on the secondary surface only. Without them the finer surface carries the pressures unless it is also stiffer.
#[test]
fn deck_selects_the_carrying_surface() {
    let pair = |weight: &str| format!("*Contact Pair, interaction=SOFT{weight}\n LOWER.SKIN, UPPER.SKIN\n");
    let general = |role: &str| {
        "*Contact\n*Contact Inclusions, all exterior\n*Contact Formulation, type=PURE MASTER-SLAVE\n".to_owned() + role
    };
    for (name, stiffness, contact, carries_below) in [
        ("automatic", 1.0, pair(""), true),
        ("WEIGHT", 1.0, pair(", weight=0.5"), true),
        ("WEIGHT", 1.0, pair(", weight=0."), true),
        ("WEIGHT", 1.0, pair(", weight=1."), false),
        ("automatic, finer is stiffer", 3.0, pair(""), false),
        ("WEIGHT, finer is stiffer", 3.0, pair(", weight=0."), true),
        ("roles", 1.0, general(" LOWER.SKIN, UPPER.SKIN, MASTER\n"), false),
        ("roles", 1.0, general(" LOWER.SKIN, UPPER.SKIN\n"), true),
        ("roles", 1.0, general(" , UPPER.SKIN, MASTER\n"), false),
        ("roles", 1.0, general(" UPPER.SKIN, LOWER.SKIN, SECONDARY\n"), false),
    ] {
        let deck = blocks(true, [16, 1], "")
            .replace(&elastic("LOWER", [1.0, 0.3, 1.0], ""), &elastic("LOWER", [stiffness, 0.3, 1.0], ""))
            + &format!(
                "*Initial Conditions, type=VELOCITY\n UPPER.ALL, 2, -0.02\n*Step\n*Dynamic, Explicit\n , 1.\n{contact}\
             *Output, history, frequency=1\n\
             *Contact Output, nset=LOWER.J1\n CPRESS\n*Contact Output, nset=UPPER.J0\n CPRESS\n*End Step\n"
            );
        let ran = run(&deck).whole();
        let largest = |node_prefix: &str| {
            let columns = ran.prepared.plan.columns.iter().map(|c| c.name.clone());
            let own = columns.filter(|name| name.starts_with("CPRESS") && name.contains(node_prefix));
            own.flat_map(|name| ran.column(&name)).map(|row| row[1]).filter(|p| p.is_finite()).fold(0.0, f64::max)
        };
        let [below, above] = ["LOWER", "UPPER"].map(largest);
        println!("{name}: CPRESS {below:.2e} below, {above:.2e} above");
        // A sudden stop at 0.02 gives 0.014 for density and wave speed 1; pressures oscillate if P121 warns.
        assert!(below.max(above) < 0.1, "{name}: {below} {above}");
        assert_eq!([below > 0.0, above > 0.0], [carries_below, !carries_below], "{name} {contact}");
    }
}

/// Requested contact pressures between facets that differ by more than a factor of 2 cause a warning that names the coarser
/// surface, whichever surface carries the pressures. Facets far from the other surface do not count.
#[test]
fn facets_of_different_size_are_reported() {
    let found = |cells: [usize; 2], carries: &str, output: &str| {
        let deck = blocks(true, cells, "")
            + &format!(
                "*Step\n*Dynamic, Explicit\n , 1.\n*Contact Pair, interaction=SOFT{carries}\n LOWER.SKIN, UPPER.SKIN\n*Output, \
                 history, frequency=1\n*Contact Output, nset=LOWER.J1\n {output}\n*End Step\n"
            );
        let prepared = prepared(&deck, &[], &Routines::none());
        prepared.diagnostics.render(&prepared.deck.sources)
    };
    // Widths are 2 and 1: [10, 2] has facets of 0.2 and 0.5.
    for (cells, coarser) in [([10, 2], "UPPER.SKIN"), ([4, 5], "LOWER.SKIN")] {
        for carries in ["", ", weight=0.", ", weight=1."] {
            for output in ["CPRESS", "CSTRESS"] {
                let text = found(cells, carries, output);
                let named = text.contains("P124") && text.contains("factor of 2.5");
                assert!(
                    named && text.contains(&format!("smaller facets on `{coarser}`")),
                    "{cells:?} {carries}: {text}"
                );
            }
        }
    }
    for (cells, output) in [([10, 2], "COPEN"), ([8, 2], "CPRESS"), ([4, 4], "CPRESS")] {
        assert!(!found(cells, "", output).contains("P124"), "{cells:?} {output}");
    }
}

/// Bodies in contact that overlap by more than 5 % of a face cause one warning with place, time and depth, and stiff
/// contact causes none.
#[test]
fn overlap_of_bodies_in_contact_is_reported() {
    let warnings = |stiffness: f64| {
        let law = format!("*Surface Behavior, pressure-overclosure=LINEAR\n {stiffness},\n");
        let deck = blocks(true, [6, 3], &law)
            + "*Initial Conditions, type=VELOCITY\n UPPER.ALL, 2, -0.05\n*Step\n*Dynamic, Explicit\n , 4.\n\
               *Contact Pair, interaction=SOFT\n LOWER.SKIN, UPPER.SKIN\n*End Step\n";
        let mut warnings = run(&deck).whole().outcome.warnings;
        warnings.retain(|warning| warning.contains("overlap"));
        warnings
    };
    let soft = warnings(0.05);
    println!("{soft:?}");
    let [warning] = &soft[..] else { panic!("{soft:?}") };
    assert!(
        warning.contains("LOWER and UPPER overlap by") && warning.contains("although contact is defined"),
        "{warning}"
    );
    assert_eq!(warnings(50.0), [""; 0]);
}
