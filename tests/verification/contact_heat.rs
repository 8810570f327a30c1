//! Heat where surfaces of elements meet: across gaps, and of friction.
//!
//! Goal: temperatures on both sides of a conductance, steady and over time, on meshes that do not match; heat that goes where a card
//! says and is neither lost nor made. Source: closed forms; each test says its tolerance and why.

use crate::common::bodies::{Ran, assembly, part, point_field, run};

/// A material that takes up 1 a volume and temperature.
fn conductor(name: &str, modulus: f64, conductivity: f64, more: &str) -> String {
    format!(
        "*Material, name={name}\n*Density\n 2.,\n*Elastic\n {modulus:e}, 0.3\n{more}*Conductivity\n {conductivity},\n*Specific Heat\n 0.5,\n"
    )
}

/// Two rings between `from` and 1, each .5 high, one on the other, of so many columns and rows; 1 is the temperature of the upper
/// one at the start.
fn stack(columns: [usize; 2], rows: usize, from: f64, conductivity: f64, interaction: &str) -> String {
    let ring = |name: &str, n: usize, below: f64| {
        let place =
            |i: usize, j: usize| [from + (1.0 - from) * i as f64 / n as f64, below + 0.5 * j as f64 / rows as f64];
        part(name, [n, rows], place, "").replace("CAX4R", "CAX4RT")
    };
    ring("LOWER", columns[0], -0.5)
        + &ring("UPPER", columns[1], 0.0)
        + &assembly(&["LOWER", "UPPER"], "")
        + &conductor("LOWER", 0.01, conductivity, "*Damping, alpha=0.1\n")
        + &conductor("UPPER", 0.01, conductivity, "*Damping, alpha=0.1\n")
        + &format!(
            "*Surface Interaction, name=GAP\n{interaction}*Initial Conditions, type=TEMPERATURE\n UPPER.ALL, 1.\n"
        )
}

fn step(time: f64, cards: &str) -> String {
    format!(
        "*Step\n*Dynamic Temperature-displacement, Explicit\n , {time}\n*Contact Pair, interaction=GAP\n LOWER.J1, UPPER.J0\n\
         *Boundary\n LOWER.J0, 2, 2\n{cards}*Output, field, number interval=1\n*Node Output\n NT\n*Output, history, number interval=1\n\
         *Energy Output\n ALLHF, ALLIHE, ALLFD\n*End Step\n"
    )
}

/// Places and temperatures at the end.
fn temperatures(ran: &Ran, instance: &str) -> Vec<([f64; 2], f64)> {
    let (frame, nodes) = (ran.end(), ran.nodes(instance));
    let field = point_field(frame, "NT11");
    nodes.iter().map(|n| (frame.points[n[0]], field[n[0]])).collect()
}

/// Held at 0 below and 1 above: q = 1/(2 L/k + 1/h), linear in each ring, with the jump q/h between them. What is left of the way
/// there is e^-20; the pressure strains by 1e-6. The conductance is .4 in all: over the clearance, in between two rows; over
/// the pressure, likewise.
#[test]
fn a_conductance_holds_two_temperatures_apart() {
    let held = "*Boundary\n LOWER.J0, 11, 11, 0.\n UPPER.J1, 11, 11, 1.\n";
    let over_clearance = "*Gap Conductance\n 0.4, 0.\n 0.4, 0.1\n";
    let between = "*Gap Conductance\n 0.5, 0.\n 0.3, 0.02\n";
    let over_pressure = "*Gap Conductance, pressure\n 0.2, 0.\n 0.6, 2.e-8\n";
    let pressed = held.to_owned() + "*Dsload\n UPPER.J1, P, 1.e-8\n";
    for (name, columns, from, interaction, cards, time, gap, tolerance) in [
        ("over the clearance", [3, 4], 0.0, over_clearance, held, 40.0, 0.0, 1e-8),
        ("over the clearance", [4, 7], 0.5, over_clearance, held, 40.0, 0.0, 1e-8),
        ("between rows", [3, 4], 0.5, between, held, 40.0, 0.01, 1e-8),
        ("over the pressure", [3, 4], 0.5, over_pressure, pressed.as_str(), 600.0, 0.0, 2e-6),
    ] {
        let held = if pressed == cards { "" } else { " UPPER.J1, 2, 2\n" };
        let deck = stack(columns, 4, from, 0.1, interaction) + &step(time, &(held.to_owned() + cards));
        // Apart by a gap: the upper ring is moved.
        let deck = match gap {
            0.0 => deck,
            gap => deck.replace(
                "*Instance, name=UPPER, part=UPPER\n",
                &format!("*Instance, name=UPPER, part=UPPER\n 0., {gap}\n"),
            ),
        };
        let ran = run(&deck).whole();
        let (h, k) = (0.4, 0.1);
        let flow = 1.0 / (2.0 * 0.5 / k + 1.0 / h);
        let mut worst: f64 = 0.0;
        for (instance, sign) in [("LOWER", -1.0), ("UPPER", 1.0)] {
            for ([_, z], t) in temperatures(&ran, instance) {
                // The way from the other end, on the ring as it was.
                let way = if sign < 0.0 { (z + 0.5).min(0.5) } else { (z - gap).max(0.0) };
                let exact = if sign < 0.0 { flow * way / k } else { flow * (0.5 / k + 1.0 / h + way / k) };
                worst = worst.max((t - exact).abs());
            }
        }
        println!("conductance {name}, {columns:?}, r >= {from}: temperatures off by {worst:.1e}");
        assert!(worst < tolerance, "{worst}");
    }
}

/// Rings that hardly have gradients of their own, left alone: the difference between them falls at 2/(C L (1/h + 2 L/(3 k))), with
/// the way of heat within them to first order in h L/k = .0025; eight rows have 1/64 of that way too little, which is 3e-5.
/// No heat is lost.
#[test]
fn two_lumps_come_to_one_temperature() {
    let (h, k, time) = (0.05, 10.0, 5.0);
    let interaction = format!("*Gap Conductance\n {h}, 0.\n {h}, 1.\n");
    let deck = stack([3, 4], 8, 0.5, k, &interaction) + &step(time, " UPPER.J1, 2, 2\n");
    let ran = run(&deck).whole();
    let heat = |instance: &str| {
        let field = point_field(ran.end(), "NT11");
        let nodes = ran.nodes(instance);
        let sum: f64 = nodes.iter().map(|n| 0.5 * ran.state.dofs.nodes.mass[n[1]] * field[n[0]]).sum();
        sum / nodes.iter().map(|n| 0.5 * ran.state.dofs.nodes.mass[n[1]]).sum::<f64>()
    };
    let rate = 2.0 / (0.5 * (1.0 / h + 2.0 * 0.5 / (3.0 * k)));
    let (lower, upper) = (heat("LOWER"), heat("UPPER"));
    let energy = ran.outcome.energy;
    println!(
        "two lumps: difference {:.7} of {:.7}, sum {:.1e} off, ALLIHE {:.1e}",
        upper - lower,
        (-rate * time).exp(),
        upper + lower - 1.0,
        energy.internal_heat.unwrap_or(f64::NAN)
    );
    assert!(((upper - lower) / (-rate * time).exp() - 1.0).abs() < 5e-5);
    assert!((upper + lower - 1.0).abs() < 1e-12 && energy.internal_heat.is_some_and(|h| h.abs() < 1e-12), "{energy:?}");
}

/// A conductance far above that of the elements bounds the increment, and the rings come to one temperature where they meet, that
/// in the middle of both: at the limit of what is stable swings of increments have gone.
#[test]
fn a_great_conductance_is_stable() {
    let deck =
        stack([3, 4], 4, 0.5, 0.1, "*Gap Conductance\n 1.e4, 0.\n 1.e4, 0.001\n") + &step(0.02, " UPPER.J1, 2, 2\n");
    let ran = run(&deck).whole();
    let face = |instance: &str| {
        let all = temperatures(&ran, instance);
        all.into_iter().filter(|(p, _)| p[1] == 0.0).map(|(_, t)| (t - 0.5).abs()).fold(0.0, f64::max)
    };
    let (steps, worst) = (&ran.outcome.steps[0], face("LOWER").max(face("UPPER")));
    println!("great conductance: {} increments, off by {worst:.1e}", steps.increments);
    assert!(steps.increments > 1000 && worst < 1e-3, "{worst}");
}

/// A ring slides on a shaft, both conduct: of the work of friction that ALLFD books the part that the card says is heat, and the
/// first surface takes its share of that. To rounding; a hundred thousandth of a share goes to and fro by nothing.
#[test]
fn friction_heats_both_surfaces_as_told() {
    let cells = 4;
    let block = |name: &str, [n, m]: [usize; 2], [a, b]: [f64; 2], [c, d]: [f64; 2]| {
        let place = |i: usize, j: usize| [a + (b - a) * i as f64 / n as f64, c + (d - c) * j as f64 / m as f64];
        part(name, [n, m], place, "").replace("CAX4R", "CAX4RT")
    };
    for (card, fraction, first) in
        [("*Gap Heat Generation\n 0.6, 0.25\n", 0.6, 0.25), ("", 1.0, 0.5), ("*Gap Heat Generation\n ,1.\n", 1.0, 1.0)]
    {
        for pair in ["SHAFT.I1, RING.I0", "RING.I0, SHAFT.I1"] {
            let deck = block("SHAFT", [2, 5 * cells], [0.5, 1.0], [-1.0, 3.0])
                + &block("RING", [cells, cells], [1.0, 1.5], [0.0, 1.0])
                + &assembly(&["SHAFT", "RING"], "")
                + &conductor("SHAFT", 1.0, 1e-3, "")
                + &conductor("RING", 1.0, 1e-3, "")
                + &format!("*Surface Interaction, name=DRY\n*Friction\n 0.1,\n{card}")
                + "*Initial Conditions, type=VELOCITY\n RING.ALL, 2, 1.e-3\n*Step\n*Dynamic Temperature-displacement, Explicit\n , 20.\n\
                   *Boundary\n SHAFT.I0, 1, 2\n*Dsload\n RING.I1, P, 1.e-4\n"
                + &format!(
                    "*Contact Pair, interaction=DRY\n {pair}\n*Output, field, number interval=1\n*Node Output\n NT\n*Output, history\n\
                     *Energy Output\n ALLHF, ALLIHE, ALLFD\n*End Step\n"
                );
            let ran = run(&deck).whole();
            let energy = ran.outcome.energy;
            let field = point_field(ran.end(), "NT11");
            let heat = |instance: &str| {
                let nodes = ran.nodes(instance);
                nodes.iter().map(|n| 0.5 * ran.state.dofs.nodes.mass[n[1]] * field[n[0]]).sum::<f64>()
            };
            let total = fraction * energy.friction;
            let named = heat(&pair[..pair.find('.').expect("an instance")]);
            let all = heat("SHAFT") + heat("RING");
            println!(
                "friction {:.4e}: heat {:.1e}, share of the first {:.1e}, ALLIHE {:.1e} off",
                energy.friction,
                all / total - 1.0,
                named / total - first,
                energy.internal_heat.expect("heat") / total - 1.0
            );
            assert!(energy.friction > 0.0 && (all / total - 1.0).abs() < 1e-12, "{all} {total}");
            assert!((named / total - first).abs() < 1e-12, "{named} {total}");
            assert!(energy.internal_heat.is_some_and(|h| (h / total - 1.0).abs() < 1e-12), "{energy:?}");
        }
    }
}
