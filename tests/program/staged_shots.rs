//! Shots of rigid bodies by stages, as `scatter`, `limit`, `identify` and tables use them.
//!
//! Source: the same shots in small increments; the closed forms of the theory manual for the ogive; bits of runs in
//! increments where stages are not allowed.

use revolve::study::evaluate::{DeckSource, SampleEvaluator, UserRoutines};
use revolve::study::quantity::Quantity;
use revolve::study::shot::FiredShot;

use crate::common;
use crate::common::random::RandomSequence;

fn evaluator(text: &str, parameter: &str, quantities: &[&str]) -> SampleEvaluator {
    let source = DeckSource::Text("shot.inp".into(), text.to_owned());
    let quantities = quantities.iter().map(|text| Quantity::parse(text).expect("a quantity")).collect();
    let made = SampleEvaluator::new(source, Vec::new(), vec![parameter.into()], quantities, UserRoutines::Absent);
    made.expect("an evaluator")
}

fn values(evaluator: &SampleEvaluator, samples: &[f64]) -> Vec<f64> {
    let (table, failures) = evaluator.table(samples, 1).expect("threads");
    assert_eq!(failures, []);
    table
}

/// Returns the profile of a random nose from the tip on, `[r, z]` in metres.
fn random_nose(random: &mut RandomSequence) -> Vec<[f64; 2]> {
    let (radius, parts) = (random.between(2e-3, 6e-3), random.count(1, 12));
    let height = radius * random.between(0.3, 4.0);
    let power = random.one_of(&[0.5, 1.0, 0.7]);
    let point = |i: usize| {
        let s = i as f64 / parts as f64;
        [radius * s.powf(power), height * s]
    };
    let mut nose: Vec<[f64; 2]> = (0..=parts).map(point).collect();
    match random.count(0, 2) {
        // A flat tip.
        0 => nose.iter_mut().skip(1).for_each(|place| place[0] = 0.4 * radius + 0.6 * place[0]),
        // A neck and a flare.
        1 => nose.extend([[0.8 * radius, height + 2e-3], [1.2 * radius, height + 4e-3]]),
        _ => {}
    }
    if nose[1][0] > 0.4 * radius && parts > 1 {
        nose.insert(1, [0.3 * radius, 0.0]);
    }
    nose
}

/// Returns a deck with a random nose that meets random layers, and its largest striking velocity.
fn random_deck(random: &mut RandomSequence) -> String {
    let nose = random_nose(random);
    let mut text = format!("*Parameter\nV = 500.\nz1 = -V\nmass = {}\n*Node\n", random.between(0.005, 0.05));
    for (i, [r, z]) in nose.iter().enumerate() {
        text += &format!(" {}, {r:?}, {z:?}\n", i + 1);
    }
    let last = nose[nose.len() - 1][1];
    text += &format!(" 9999, 0., {last:?}\n*Nset, nset=REF\n 9999\n*Element, type=RAX2, elset=NOSE\n");
    (1..nose.len()).for_each(|i| text += &format!(" {i}, {i}, {}\n", i + 1));
    text += "*Element, type=MASS, elset=PROJECTILE\n 9999, 9999\n*Mass, elset=PROJECTILE\n <mass>\n\
             *Rigid Body, ref node=REF, elset=NOSE\n*Surface, name=NOSE\n NOSE, SNEG\n";
    let linear = random.one_of(&[0.0, 0.9]);
    for (name, strength) in [("SOFT", 8e7), ("HARD", 6e8)] {
        let constants = [random.between(2.0, 5.0), linear, random.one_of(&[0.0, 0.9])];
        let [a, b, c] = constants;
        text += &format!(
            "*Material, name={name}\n*Density\n 2700.,\n*Cavity Expansion, yield={strength}\n {a}, {b}, {c}\n"
        );
    }
    let front = random.one_of(&[0.0, -3e-3, 1e-3]);
    text += &format!("*Target, name=BLOCK, front={front}, direction=-1\n");
    for _ in 0..random.count(1, 3) {
        text += &format!(" {}, {}\n", random.one_of(&["SOFT", "HARD"]), random.between(1e-3, 0.02));
    }
    let block = if random.next() < 0.5 { " HARD, 1.\n" } else { " SOFT, 0.004\n" };
    let friction = random.one_of(&[0.0, 0.1]);
    text + block
        + &format!(
            "*Initial Conditions, type=VELOCITY\n REF, 2, <z1>\n*Step\n*Dynamic, Explicit, accuracy=1e-7\n , {}\n\
             *Dsload, target=BLOCK, friction={friction}\n NOSE, CAVITY\n*Output, history, number interval=20\n\
             *Node Output, nset=REF\n U2, V2, A2, COOR2\n*Energy Output\n ALLKE, ETOTAL\n*End Step\n",
            random.one_of(&["1.e-3", "4.e-5"])
        )
}

/// Noses with and without flat tips and flares, one to four layers, friction, laws with and without terms of v and v²,
/// bodies that stop, leave or still move. Source: increments with an accuracy of 1e-7.
#[test]
fn random_shots_match_small_increments() {
    let mut random = RandomSequence(11);
    let quantities = ["final(U2@REF)", "final(V2@REF)", "final(COOR2@REF) - final(U2@REF)", "final(ETOTAL)"];
    let (mut ends, mut largest) = (std::collections::BTreeMap::new(), 0.0_f64);
    for deck in 0..60 {
        let text = random_deck(&mut random);
        let speeds = [random.between(30.0, 200.0), random.between(200.0, 900.0), random.between(900.0, 2000.0)];
        let staged = evaluator(&text, "V", &quantities);
        let stepped = evaluator(&text, "V", &quantities).in_increments();
        let [found, expected] = [&staged, &stepped].map(|evaluator| values(evaluator, &speeds));
        for (i, speed) in speeds.iter().enumerate() {
            let [found, expected] = [&found, &expected].map(|table| &table[4 * i..4 * i + 4]);
            // Near the limit the velocity is the root of a small difference.
            let energies = (found[1] * found[1] - expected[1] * expected[1]).abs() / (speed * speed);
            let place = (found[0] - expected[0]).abs() / expected[0].abs();
            let rest = (found[2] - expected[2]).abs().max((found[3] / expected[3] - 1.0).abs());
            assert!(energies < 2e-5 && rest < 1e-5, "deck {deck}, {speed} m/s: {found:?} {expected:?}\n{text}");
            assert!(place < 5e-5 || energies > 1e-9, "deck {deck}, {speed} m/s: {found:?} {expected:?}\n{text}");
            largest = largest.max(energies);
        }
        let shots = |evaluator: SampleEvaluator| evaluator.of_shots(None).shots(&speeds, 1).expect("threads");
        for (found, expected) in shots(staged).into_iter().zip(shots(stepped)) {
            let [found, expected]: [FiredShot; 2] = [found, expected].map(|shot| shot.expect("a shot"));
            assert_eq!(found.end, expected.end, "deck {deck}: {found:?} {expected:?}\n{text}");
            *ends.entry(found.end.map_or("none", |end| end.words())).or_insert(0) += 1;
        }
    }
    println!("{ends:?}, largest difference of energies {largest:.1e}");
    assert!(["embedded", "perforation"].iter().all(|end| ends[end] > 20), "{ends:?}");
}

/// Source: closed form without entry, quadrature of the entry integrals (`docs/theory/cavity-expansion.md`).
#[test]
fn ogive_matches_closed_form() {
    let text = common::ogive().replace("n    = 20", "n    = 400");
    for (front, depths) in [("0.1", [59.612643939, 221.597433967]), ("0.", [64.8475307, 226.5690103])] {
        let text = text.replace("front = 0.", &format!("front = {front}"));
        let found = values(&evaluator(&text, "V", &["-1000*final(U2@REF)"]), &[569.0, 1147.0]);
        for (found, expected) in found.iter().zip(depths) {
            assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
        }
    }
}

/// Loads, steps and quantities that stages do not cover are integrated in increments, with the bits of such runs.
#[test]
fn other_models_are_integrated_in_increments() {
    let ogive = common::ogive();
    let dynamic = "*Dynamic, Explicit\n , 1.e-3";
    let samples = [569.0, 900.0];
    let both = |text: &str, quantity: &str| {
        let staged = evaluator(text, "V", &[quantity]);
        let stepped = evaluator(text, "V", &[quantity]).in_increments();
        [values(&staged, &samples), values(&stepped, &samples)]
    };
    let [staged, stepped] = both(&ogive, "final(U2@REF)");
    assert!(staged.iter().zip(&stepped).all(|(a, b)| a != b && (a / b - 1.0).abs() < 1e-4), "{staged:?} {stepped:?}");
    for (from, to, quantity) in [
        ("*Dsload,", "*Dload\n , GRAV, 9.81, 0., -1.\n*Dsload,", "final(U2@REF)"),
        ("*Dsload,", "*Cload\n 9999, 2, 10.\n*Dsload,", "final(U2@REF)"),
        (dynamic, "*Dynamic, Explicit, direct user control\n 1.e-6, 1.e-3", "final(U2@REF)"),
        (dynamic, "*Dynamic, Explicit, load velocity=LAGGED\n , 1.e-3", "final(U2@REF)"),
        ("direction=-1\n", "direction=-1, radius=0.05\n", "final(U2@REF)"),
        ("friction = 0.", "friction = 0.05", "final(ALLCAV)"),
        ("friction = 0.", "friction = 0.", "min(V2@REF)"),
        ("friction = 0.", "friction = 0.", "at(U2@REF, 1e-4)"),
    ] {
        assert!(ogive.contains(from), "the deck has no {from}");
        let [staged, stepped] = both(&ogive.replacen(from, to, 1), quantity);
        assert_eq!(staged, stepped, "{to} {quantity}");
    }
}

/// The tables of runs that share a plan, and of runs that read the deck for each sample, have the same bits.
#[test]
fn staged_tables_do_not_depend_on_plans() {
    let text = common::ogive();
    let [first, second] =
        ["V", "mass"].map(|parameter| evaluator(&text, parameter, &["final(U2@REF)", "final(ALLCAV)"]));
    let whole = values(&first, &[500.0, 569.0, -300.0, 900.0]);
    for (i, speed) in [500.0, 569.0, -300.0, 900.0].iter().enumerate() {
        assert_eq!(whole[2 * i..2 * i + 2], values(&first, &[*speed]), "{speed}");
    }
    assert_eq!(values(&second, &[0.021]), whole[2..4]);
    // The number of facets changes the model.
    let facets = values(&evaluator(&text, "n", &["final(U2@REF)", "final(ALLCAV)"]), &[20.0, 21.0]);
    assert!(facets[..2] == whole[2..4] && facets[2] != facets[0], "{facets:?}");
}
