//! Contact options: penalty springs, clearances, reported pairs.
//!
//! Goal: springs of the specified stiffness whose energy is in the energy balance; initial gaps equal to the specified
//! clearance.
//! Source: closed forms. The tolerance and its reason are stated at each test.

use std::f64::consts::PI;

use super::contact::{ContactPatch, SPEED, bars};
use crate::common::bodies::{assembly, cell_field, elastic, part, rigid_line, run, short};

/// Stiffness of penalty springs with SCALE PENALTY = 1, over that of the elements.
const STIFFNESS: f64 = 50.0;

const PAIR: &str = "*Contact Pair, interaction=HARD\n";

/// Two bars with penalty springs of `factor` times the element stiffness. With element length h and c = 1, the pressure
/// rises to rho c v/2 with the time constant tau = h/(2 factor), at an overclosure of h v/(2 factor). After the
/// reflection from the ends it falls as 2 (1 + x) e^-x - 1 with x = (t - 2)/tau, and is zero at x = 1.678347.
/// Pressure and overclosure agree to 1 % at the plateau, the end of contact to half an element and two increments. The
/// springs store p^2/(2 k). They act half an increment early, which dissipates k dt/2 times the integral of the squared
/// overclosure rate: with the pressure above (1 + 1.304) C/(4 n) of the energy (C is the Courant number), less if the
/// pressure rises within few increments.
#[test]
fn penalty_contact_of_bars_matches_closed_form() {
    for (rows, factor) in [(20, 1.0), (40, 1.0), (40, 0.25), (20, 10.0)] {
        let pair = "*Contact Pair, interaction=HARD, mechanical constraint=PENALTY, cpset=BOTH\n";
        let scale = factor / STIFFNESS;
        let controls = format!("*Contact Controls, cpset=BOTH, scale penalty={scale}\n");
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
        let (pressed, stored) = (mean(&force) / -level, mean(&held));
        let opening = ran.prepared.plan.columns.iter().find(|c| c.name.starts_with("COPEN@")).expect("a column");
        let overlap = -mean(&ran.column(&opening.name)) / (h * SPEED / (2.0 * factor));
        // Stored energy p^2/(2 k) with k = factor/h.
        let exact = 0.25 * SPEED * SPEED * PI * h / (2.0 * factor);
        let lost = energy.penalty.expect("springs") / energy.initial;
        println!(
            "bars, {rows} rows, springs of {factor}: force {pressed:.5}, overlap {overlap:.5}, held {:.5}, ends at {:.4} of {end:.4}, lost {:.3}/(4n), \
             ALLCW {:.1e}, drift {:.1e}",
            stored / exact,
            last,
            lost * 4.0 * rows as f64,
            energy.contact / energy.initial,
            energy.drift
        );
        assert!((pressed - 1.0).abs() < 0.01 && (overlap - 1.0).abs() < 0.01, "{pressed} {overlap}");
        assert!((last - end).abs() < 0.5 * h + 2.0 * 0.9 * h, "{last} {end}");
        assert!(energy.drift < 1e-13 && energy.contact.abs() < 1e-13 * energy.initial, "{energy:?}");
        assert!(stored > exact && lost >= 0.0 && lost < 2.304 * 0.9 * 0.25 * h, "{stored} {exact} {lost}");
    }
}

/// A disc with the mass `m = 1` per area falls on a rigid plane with the contact stiffness `k = 1e-3` per area and contact
/// damping: a damped oscillator with the fraction z of critical damping, which leaves the plane when the pressure
/// `k x + c x'` vanishes, at tan(wd t) = -2 z s/(1 - 2 z^2) with s = sqrt(1 - z^2). The surface nodes have half of the
/// mass, so that a critical fraction of sqrt(2) z is the same damping. The disc is a thousand times stiffer than the
/// contact, and the overlap at the end of the increment adds a fraction of w dt/2 = 8e-4: 1 %.
#[test]
fn contact_damping_matches_the_damped_oscillator() {
    let stiffness: f64 = 1e-3;
    let rebound = |law: &str, damping: &str| {
        let deck = part("DISC", [2, 1], |i, j| [0.5 * i as f64, 1e-9 + j as f64], "")
            + &rigid_line("WALL", &[[0.0, 0.0], [2.0, 0.0]], "")
            + &assembly(&["DISC", "WALL"], "*Rigid Body, ref node=WALL.REF, elset=WALL.E\n")
            + &elastic("DISC", [1.0, 0.0, 1.0], "")
            + &format!(
                "*Surface Interaction, name=I\n*Surface Behavior, pressure-overclosure={law}\n{damping}\
                 *Initial Conditions, type=VELOCITY\n DISC.ALL, 2, {:e}\n*Step\n*Dynamic, Explicit, direct user control\n 0.05, 120.\n\
                 *Boundary\n WALL.REF, 2, 2\n*Contact Pair, interaction=I\n DISC.J0, WALL.SKIN\n\
                 *Output, history, frequency=1\n*Energy Output\n ALLCW, ETOTAL\n*End Step\n",
                -SPEED
            );
        let ran = run(&deck).whole();
        let absorbed = ran.column("ALLCW").iter().fold(0.0_f64, |least, c| least.min(c[1]));
        assert!(absorbed > -1e-9 * ran.outcome.energy.initial && ran.outcome.energy.drift < 1e-12, "{absorbed}");
        ran.momentum() / (PI * SPEED)
    };
    let linear = format!("LINEAR\n {stiffness},");
    let table = format!("TABULAR\n 0., 0.\n {}, 1.\n", stiffness);
    for fraction in [0.05_f64, 0.2, 0.4] {
        let s = (1.0 - fraction * fraction).sqrt();
        let angle = (2.0 * fraction * s).atan2(2.0 * fraction * fraction - 1.0);
        let decay = (-fraction / s * angle).exp();
        let exact = -decay * (angle.cos() - fraction / s * angle.sin());
        let coefficient = 2.0 * fraction * stiffness.sqrt();
        let given = format!("*Contact Damping, definition=DAMPING COEFFICIENT\n {coefficient:e},\n");
        let critical =
            format!("*Contact Damping, definition=CRITICAL DAMPING FRACTION\n {:e},\n", 2.0_f64.sqrt() * fraction);
        let [one, two, three] =
            [(&linear, &given), (&linear, &critical), (&table, &given)].map(|(law, damping)| rebound(law, damping));
        println!("fraction {fraction}: rebound {one:.4} {two:.4} {three:.4} of {exact:.4}");
        assert!((one / exact - 1.0).abs() < 0.01, "{one} {exact}");
        assert!((two / one - 1.0).abs() < 1e-9 && (three / one - 1.0).abs() < 1e-9, "{one} {two} {three}");
    }
    assert!(rebound(&linear, "") > 0.995);
}

/// Nonmatching patches have a uniform stress with penalty springs as well, because springs and elements are uniform.
#[test]
fn penalty_contact_patch_has_uniform_stress() {
    let pressure = 1e-7;
    for (columns, from) in [([3, 4], 0.5), ([6, 8], 0.5)] {
        let patch = ContactPatch { from, columns, random: false, lower_first: true };
        let deck = patch.deck(pressure).replace("*Contact Pair,", "*Contact Pair, mechanical constraint=PENALTY,");
        let ran = run(&deck).whole();
        let mut worst = [0.0_f64; 4];
        for s in cell_field(ran.end(), "S").chunks(4) {
            for ((worst, s), expected) in worst.iter_mut().zip(s).zip([0.0, -1.0, 0.0, 0.0]) {
                *worst = worst.max((s / pressure - expected).abs());
            }
        }
        println!("patch with springs {columns:?}: errors of S11, S22, S33, S12 {}", short(&worst));
        assert!(worst.iter().all(|w| *w < 1e-8), "{worst:?}");
    }
}

/// Two bodies that overlap by 0.01 at the start are pressed together. By default the overclosure remains and does not
/// increase. A specified clearance removes it: contact begins when the bodies have approached by the clearance, and the
/// reported gap is the specified one. The same holds for bodies that are apart.
#[test]
fn initial_gaps_equal_the_specified_clearance() {
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
        // The change of the gap is listed.
        let listed = ran.prepared.diagnostics.render(&ran.prepared.deck.sources);
        let change = gap.map_or_else(String::new, |gap| format!(" {:.3e},", apart - gap));
        assert!(listed.contains("P125") == gap.is_some() && listed.contains(&change), "{listed}");
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
        // Rounding of an increment, and changes of contact status in the sweeps.
        assert!(least > expected.min(0.0) - 1e-9 * SPEED, "{least}");
        match expected {
            gap if gap <= 0.0 => assert!(touch.expect("contact") < 0.2, "{touch:?}"),
            gap if gap < 1e-4 => assert!((touch.expect("contact") - gap / SPEED).abs() < 0.2, "{touch:?}"),
            _ => assert_eq!(touch, None),
        }
    }
}

/// Bodies without a contact definition that overlap during the run cause one warning with time and place, and the
/// results keep their bits. There is no warning for bodies with contact, bodies that separate, or bodies that overlap
/// from the start (reported before the run).
#[test]
fn overlapping_bodies_without_contact_cause_one_warning() {
    let deck = bars(10, [3, 4], 0.01, 3.0).replace(&format!("{PAIR} LOWER.J1, UPPER.J0\n"), "");
    let warnings_of = |deck: &str| run(deck).whole().outcome.warnings;
    // Fast enough to overlap by a tenth of an element after a time of 0.4.
    let fast = deck.replace("2, -1e-5", "2, -5e-2");
    let warnings = warnings_of(&fast);
    println!("{warnings:?}");
    let [warning] = &warnings[..] else { panic!("{warnings:?}") };
    assert!(warning.contains("LOWER and UPPER overlap") && warning.contains("*CONTACT PAIR"), "{warning}");
    assert_eq!(warnings_of(&deck.replace("2, -1e-5", "2, 5e-2")), [""; 0]);
    assert_eq!(
        warnings_of(&fast.replace("*Bulk Viscosity", "*Contact\n*Contact Inclusions, all exterior\n*Bulk Viscosity")),
        [""; 0]
    );
    let inside = bars(10, [3, 4], -0.05, 1.0).replace(&format!("{PAIR} LOWER.J1, UPPER.J0\n"), "");
    assert_eq!(warnings_of(&inside), [""; 0]);
}

/// Notes on faces with the same or opposite orientation and on a nearly massless plate, and none for gaps within
/// rounding.
#[test]
fn suspicious_contact_pairs_are_reported() {
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
    // The nodes of the block have a mass of pi/10.
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

/// General contact with a specified penalty factor has the springs of a contact pair, bit for bit.
#[test]
fn general_contact_and_pair_have_the_same_penalty_springs() {
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
    // The stiffness doubles if the pair is included twice.
    for repeated in [" LOWER.J1, UPPER.J0\n", " UPPER.J0, LOWER.J1\n"] {
        let inclusion = "*Contact Inclusions\n LOWER.J1, UPPER.J0\n";
        assert_eq!(end(&general.replace(inclusion, &(inclusion.to_owned() + repeated))), of_general, "{repeated}");
    }
}
