//! What cards say of contact: penalty springs, clearances, which pairs are shown.
//!
//! Goal: springs as stiff as they should be, with their energy in the books; gaps at the start that are what a card says.
//! Source: closed forms; each test says its tolerance and why.

use std::f64::consts::PI;

use super::contact::{Patch, SPEED, bars};
use crate::common::bodies::{assembly, cell_field, elastic, part, rigid_line, run, short};

const PAIR: &str = "*Contact Pair, interaction=HARD\n";

/// Two bars with springs as stiff as `factor` times an element: with h the length of an element and c = 1 the pressure rises with
/// the time tau = h/(2 factor) to rho c v/2, at an overlap of h v/(2 factor); what comes back from the ends then lets it fall as
/// 2 (1 + x) e^-x - 1 over x = (t - 2)/tau, to none at x = 1.678347. Pressure and overlap are met to 1 % where they have levelled
/// out, the end of contact to half an element and two increments. Books close to rounding. Springs hold p^2/(2 k) of what they
/// took. They press half an increment ahead, which loses k dt/2 times the integral of the square of the rate of the overlap: with
/// the pressure above (1 + 1.304) C/(4 n) of the energy, C the Courant number, less where the pressure rises within few increments.
#[test]
fn bars_with_penalty_springs() {
    for (rows, factor) in [(20, 1.0), (40, 1.0), (40, 0.25), (20, 10.0)] {
        let pair = "*Contact Pair, interaction=HARD, mechanical constraint=PENALTY, cpset=BOTH\n";
        let controls = format!("*Contact Controls, cpset=BOTH, scale penalty={factor}\n");
        let deck = bars(rows, [1, 1], 1e-10, 3.0)
            .replace(PAIR, &(controls + pair))
            .replace("*End Step", "*Output, history, frequency=1\n*Contact Output\n CFN\n*Contact Output, nset=LOWER.J1\n COPEN\n*Energy Output\n ALLPW, ALLCW\n*End Step");
        let ran = run(&deck).whole();
        let (energy, h) = (ran.outcome.energy, 1.0 / rows as f64);
        let (force, held) = (ran.column("CFN2@LOWER.J1_UPPER.J0"), ran.column("ALLPW"));
        let level = 0.5 * SPEED * PI;
        let last = force.iter().rfind(|f| f[1] != 0.0).expect("contact")[0];
        let end = 2.0 + 1.678_347 * h / (2.0 * factor);
        let mean = |list: &[[f64; 2]]| {
            let inside: Vec<f64> = list.iter().filter(|f| f[0] > 1.4 && f[0] < 1.9).map(|f| f[1]).collect();
            inside.iter().sum::<f64>() / inside.len() as f64
        };
        let (pressed, kept) = (mean(&force) / -level, mean(&held));
        let opening = ran.prepared.plan.columns.iter().find(|c| c.name.starts_with("COPEN@")).expect("a column");
        let overlap = -mean(&ran.column(&opening.name)) / (h * SPEED / (2.0 * factor));
        // p^2/(2 k), with k = factor/h.
        let exact = 0.25 * SPEED * SPEED * PI * h / (2.0 * factor);
        let lost = energy.penalty.expect("springs") / energy.initial;
        println!(
            "bars, {rows} rows, springs of {factor}: force {pressed:.5}, overlap {overlap:.5}, held {:.5}, ends at {:.4} of {end:.4}, lost {:.3}/(4n), \
             ALLCW {:.1e}, drift {:.1e}",
            kept / exact,
            last,
            lost * 4.0 * rows as f64,
            energy.contact / energy.initial,
            energy.drift
        );
        assert!((pressed - 1.0).abs() < 0.01 && (overlap - 1.0).abs() < 0.01, "{pressed} {overlap}");
        assert!((last - end).abs() < 0.5 * h + 2.0 * 0.9 * h, "{last} {end}");
        assert!(energy.drift < 1e-13 && energy.contact.abs() < 1e-13 * energy.initial, "{energy:?}");
        assert!(kept > exact && lost >= 0.0 && lost < 2.304 * 0.9 * 0.25 * h, "{kept} {exact} {lost}");
    }
}

/// The patch of meshes that do not match has one stress with springs, too: they are the same everywhere, as the elements are.
#[test]
fn a_patch_with_penalty_springs_has_one_stress() {
    let pressure = 1e-7;
    for (columns, from) in [([3, 4], 0.5), ([6, 8], 0.5)] {
        let patch = Patch { from, columns, random: false, lower_first: true };
        let deck = patch.deck(pressure).replace("*Contact Pair,", "*Contact Pair, mechanical constraint=PENALTY,");
        let ran = run(&deck).whole();
        let mut worst = [0.0_f64; 4];
        for s in cell_field(ran.end(), "S").chunks(4) {
            for ((worst, s), expected) in worst.iter_mut().zip(s).zip([0.0, -1.0, 0.0, 0.0]) {
                *worst = worst.max((s / pressure - expected).abs());
            }
        }
        println!("patch with springs {columns:?}: S11, S22, S33, S12 off by {}", short(&worst));
        assert!(worst.iter().all(|w| *w < 1e-8), "{worst:?}");
    }
}

/// Two bodies that lie .01 in each other at the start and are pressed: without a word the overlap stays and grows no deeper. A
/// clearance takes it off: nothing happens until the bodies have come so much nearer, and the gap that is shown is the one of the
/// card. So does one for bodies apart.
#[test]
fn gaps_begin_as_cards_say() {
    let card = |gap: f64| {
        format!(
            "*Contact Clearance, name=G, clearance={gap}, search above=0.02, search below=0.02\n*Contact\n*Contact Inclusions, all exterior\n\
             *Contact Clearance Assignment\n LOWER.J1, UPPER.J0, G\n"
        )
    };
    let of_pair = |gap: f64| {
        format!("*Clearance, cpset=P, value={gap}\n*Contact Pair, interaction=HARD, cpset=P\n LOWER.J1, UPPER.J0\n")
    };
    let start = |gap: f64| {
        card(gap)
            .replace("Contact Clearance, name=G, clearance", "Contact Initialization Data, name=G, initial clearance")
    };
    let start = |gap: f64| start(gap).replace("Clearance Assignment", "Initialization Assignment");
    let none = |_: f64| "*Contact\n*Contact Inclusions, all exterior\n".to_owned();
    for (apart, gap, cards) in [
        (-0.01, None, &none as &dyn Fn(f64) -> String),
        (-0.01, Some(0.0), &card),
        (-0.01, Some(1e-5), &card),
        (-0.01, Some(1e-5), &of_pair),
        (0.01, Some(1e-5), &of_pair),
        (0.01, Some(1e-5), &start),
        (0.01, Some(1e-5), &card),
        (0.01, None, &none),
    ] {
        let cards = cards(gap.unwrap_or(0.0));
        let request = "*Output, history, frequency=1\n*Contact Output, nset=UPPER.J0\n COPEN, CPRESS\n*End Step";
        let deck = bars(10, [2, 3], apart, 3.0)
            .replace(&format!("{PAIR} LOWER.J1, UPPER.J0\n"), &cards)
            .replace("*End Step", request);
        let ran = run(&deck).whole();
        let name = |begin: &str| {
            let named = ran.prepared.plan.columns.iter().map(|c| &c.name).filter(|n| n.starts_with(begin));
            named.max_by_key(|n| ran.column(n).iter().filter(|x| x[1].is_finite()).count()).expect("a column").clone()
        };
        let (opening, pressure) = (ran.column(&name("COPEN@")), ran.column(&name("CPRESS@")));
        let touch = pressure.iter().find(|p| p[1] > 0.0).map(|p| p[0]);
        let (first, least) = (opening[1][1], opening.iter().map(|o| o[1]).fold(f64::INFINITY, f64::min));
        println!(
            "bodies {apart} apart, clearance {gap:?}: gap {first:.3e}, at least {least:.3e}, touch at {touch:.3?}"
        );
        let expected = gap.unwrap_or(apart);
        assert!((first - expected).abs() < 2.0 * SPEED * 0.09 + 1e-12, "{first} {expected}");
        // What an increment goes on by rounding, and what chatter of sweeps leaves.
        assert!(least > expected.min(0.0) - 1e-9 * SPEED, "{least}");
        match expected {
            gap if gap <= 0.0 => assert!(touch.expect("contact") < 0.2, "{touch:?}"),
            gap if gap < 1e-4 => assert!((touch.expect("contact") - gap / SPEED).abs() < 0.2, "{touch:?}"),
            _ => assert_eq!(touch, None),
        }
    }
}

/// Bodies without contact that go through each other: told once, with when and where, and no bit is another. Bodies that may meet,
/// that part, or that lay in each other from the start (which is told before the run) are not told of.
#[test]
fn bodies_that_go_through_each_other_are_told() {
    let deck = bars(10, [3, 4], 0.01, 3.0).replace(&format!("{PAIR} LOWER.J1, UPPER.J0\n"), "");
    let told = |deck: &str| run(deck).whole().outcome.warnings;
    // So fast that it is in by a tenth of an element after a time of .4.
    let fast = deck.replace("2, -1e-5", "2, -5e-2");
    let warnings = told(&fast);
    println!("{warnings:?}");
    let [warning] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(warning.contains("LOWER and UPPER overlap") && warning.contains("*CONTACT PAIR"), "{warning}");
    assert_eq!(told(&deck.replace("2, -1e-5", "2, 5e-2")), [""; 0]);
    assert_eq!(
        told(&fast.replace("*Bulk Viscosity", "*Contact\n*Contact Inclusions, all exterior\n*Bulk Viscosity")),
        [""; 0]
    );
    let inside = bars(10, [3, 4], -0.05, 1.0).replace(&format!("{PAIR} LOWER.J1, UPPER.J0\n"), "");
    assert_eq!(told(&inside), [""; 0]);
}

/// Faces that look the same way, or lie back to back; a plate of next to no mass; a rounding that faces do not see.
#[test]
fn pairs_that_can_hardly_be_meant_are_told() {
    let codes = |deck: &str| {
        let ran = run(deck);
        let codes = ran.prepared.diagnostics.iter().map(|d| d.code.to_owned()).filter(|c| c.starts_with("P11"));
        codes.collect::<Vec<_>>()
    };
    let pair = |names: &str| bars(10, [2, 3], 1e-3, 0.5).replace("LOWER.J1, UPPER.J0", names);
    assert_eq!(codes(&pair("LOWER.J1, UPPER.J0")), [""; 0]);
    assert_eq!(codes(&pair("LOWER.J1, UPPER.J1")), ["P110"]);
    assert_eq!(codes(&pair("LOWER.J0, UPPER.J1")), ["P110"]);
    let tool = |corners: &[[f64; 2]], mass: f64| {
        let more = format!("*Element, type=MASS, elset=M\n 900, 1000\n*Mass, elset=M\n {mass},\n");
        part("BLOCK", [5, 5], |i, j| [0.2 * i as f64, 0.2 * j as f64 - 1.0], "")
            + &rigid_line("TOOL", corners, &more)
            + &assembly(&["BLOCK", "TOOL"], "*Rigid Body, ref node=TOOL.REF, elset=TOOL.E\n")
            + &elastic("BLOCK", [1.0, 0.0, 1.0], "")
            + "*Surface Interaction, name=HARD\n*Step\n*Dynamic, Explicit\n , 0.1\n*Contact Pair, interaction=HARD\n BLOCK.J1, TOOL.SKIN\n\
               *End Step\n"
    };
    // The nodes of the block weigh pi/10 under all of it.
    let flat = [[1.0, 1e-3], [0.0, 1e-3]];
    assert_eq!(codes(&tool(&flat, 0.4)), [""; 0]);
    assert_eq!(codes(&tool(&flat, 0.2)), ["P117"]);
    let arc: Vec<[f64; 2]> = (0..=8)
        .map(|i| 0.125 * f64::from(i) * 0.5 * PI)
        .map(|a| [0.5 + 0.05 * a.cos(), 0.06 - 0.05 * a.sin()])
        .chain([[0.0, 0.01]])
        .collect();
    assert_eq!(codes(&tool(&arc, 9.0)), ["P118"]);
    let blunt = [[0.55, 0.06], [0.5, 0.01], [0.0, 0.01]];
    assert_eq!(codes(&tool(&blunt, 9.0)), [""; 0]);
}

/// General contact has penalty springs where a card gives them a factor: those of a pair, to the bit.
#[test]
fn general_contact_has_the_springs_of_a_pair() {
    let pair = "*Contact Pair, interaction=HARD, mechanical constraint=PENALTY, cpset=P\n LOWER.J1, UPPER.J0\n";
    let controls = "*Contact Controls, cpset=P, scale penalty=2.\n";
    let general = "*Contact\n*Contact Inclusions\n LOWER.J1, UPPER.J0\n*Contact Property Assignment\n , , HARD\n\
                   *Contact Controls Assignment, type=SCALE PENALTY\n LOWER.J1, UPPER.J0, 2.\n";
    let end = |cards: &str| {
        let deck = bars(10, [2, 3], 1e-10, 3.0).replace(&format!("{PAIR} LOWER.J1, UPPER.J0\n"), cards);
        let outcome = run(&deck).whole().outcome;
        (outcome.digest, outcome.energy.penalty)
    };
    let [of_pair, of_general, other] =
        [controls.to_owned() + pair, general.to_owned(), pair.to_owned()].map(|cards| end(&cards));
    assert_eq!(of_pair, of_general);
    assert!(of_pair.1.is_some() && of_pair.0 != other.0);
    // Twice the pair would be twice the stiffness.
    for repeated in [" LOWER.J1, UPPER.J0\n", " UPPER.J0, LOWER.J1\n"] {
        let inclusion = "*Contact Inclusions\n LOWER.J1, UPPER.J0\n";
        assert_eq!(end(&general.replace(inclusion, &(inclusion.to_owned() + repeated))), of_general, "{repeated}");
    }
}
