//! Heat transfer between contacting element surfaces: gap conductance and frictional heat.
//!
//! Goal: steady and transient temperatures on both sides of a conductance with nonmatching meshes; distribution and
//! conservation of heat. Source: closed forms. The tolerance and its reason are stated at each test.

use crate::common::bodies::{DeckRun, assembly, part, point_field, run};
use crate::common::solid::grid;

/// Returns a material with a heat capacity of 1 per volume.
fn conductor_material(name: &str, modulus: f64, conductivity: f64, more: &str) -> String {
    format!(
        "*Material, name={name}\n*Density\n 2.,\n*Elastic\n {modulus:e}, 0.3\n{more}*Conductivity\n {conductivity},\n*Specific Heat\n 0.5,\n"
    )
}

/// Returns two stacked rings from radius `from` to 1, each of height 0.5, with `columns` and `rows` of elements. The
/// upper ring has an initial temperature of 1.
fn stacked_rings(columns: [usize; 2], rows: usize, from: f64, conductivity: f64, interaction: &str) -> String {
    let ring = |name: &str, n: usize, below: f64| {
        let place =
            |i: usize, j: usize| [from + (1.0 - from) * i as f64 / n as f64, below + 0.5 * j as f64 / rows as f64];
        part(name, [n, rows], place, "").replace("CAX4R", "CAX4RT")
    };
    ring("LOWER", columns[0], -0.5)
        + &ring("UPPER", columns[1], 0.0)
        + &assembly(&["LOWER", "UPPER"], "")
        + &conductor_material("LOWER", 0.01, conductivity, "*Damping, alpha=0.1\n")
        + &conductor_material("UPPER", 0.01, conductivity, "*Damping, alpha=0.1\n")
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

/// A ring between a rigid tool at temperature 0 and a held temperature of 1: q = 1/(L/k + 1/h). The tool is an
/// analytical surface or a facet; its temperature is prescribed, or constant because it is given at the start. The heat
/// that enters at the top leaves through the tool.
#[test]
fn rigid_tool_has_the_temperature_of_its_reference_node() {
    let (h, k) = (0.4, 0.1);
    let flow = 1.0 / (0.5 / k + 1.0 / h);
    let analytical = "*Surface, type=SEGMENTS, name=TOOL\n START, 2., 0.\n LINE, 0., 0.\n*Rigid Body, ref node=900, analytical surface=TOOL\n";
    let facet = "*Node\n 901, 0., 0.\n 902, 2., 0.\n*Element, type=RAX2, elset=PLATE\n 901, 901, 902\n\
                 *Surface, name=TOOL\n PLATE, SPOS\n*Rigid Body, ref node=900, elset=PLATE\n";
    let prescribed = " 900, 11, 11, 2.\n";
    let at_start = "*Initial Conditions, type=TEMPERATURE\n 900, 2.\n";
    for (name, tool, start, held) in [
        ("analytical, prescribed", analytical, "", prescribed),
        ("analytical, constant", analytical, at_start, ""),
        ("facet, prescribed", facet, "", prescribed),
    ] {
        let place = |i: usize, j: usize| [0.5 + 0.25 * i as f64, 0.125 * j as f64];
        let deck = grid(2, 4, false, place).replace("CAX4R", "CAX4RT")
            + "*Solid Section, elset=SOLID, material=M\n"
            + &conductor_material("M", 0.01, k, "*Damping, alpha=0.1\n")
            + "*Node\n 900, 0., 0.\n"
            + tool
            + "*Surface Interaction, name=GAP\n*Gap Conductance\n 0.4, 0.\n 0.4, 0.1\n*Initial Conditions, type=TEMPERATURE\n ALL, 3.\n"
            + start
            + "*Step\n*Dynamic Temperature-displacement, Explicit\n , 40.\n*Contact Pair, interaction=GAP\n J0, TOOL\n\
               *Boundary\n 900, 2, 2\n J1, 2, 2\n J1, 11, 11, 3.\n"
            + held
            + "*Output, field, number interval=1\n*Node Output\n NT\n*Output, history, number interval=1\n*Energy Output\n ALLHF, ALLIHE\n*End Step\n";
        let ran = run(&deck).whole();
        let field = point_field(ran.end(), "NT11");
        let mut worst: f64 = 0.0;
        for (n, [_, z]) in ran.end().points.iter().enumerate().take(15) {
            worst = worst.max((field[n] - (2.0 + flow * (1.0 / h + z / k))).abs());
        }
        println!("rigid tool, {name}: error of temperatures {worst:.1e}");
        assert!(worst < 1e-6, "{name}: {worst}");
    }
    // A tool without temperature takes no heat, and this is said.
    let place = |i: usize, j: usize| [0.5 + 0.25 * i as f64, 0.125 * j as f64];
    let cold = grid(2, 4, false, place).replace("CAX4R", "CAX4RT")
        + "*Solid Section, elset=SOLID, material=M\n"
        + &conductor_material("M", 0.01, k, "")
        + "*Node\n 900, 0., 0.\n"
        + analytical
        + "*Surface Interaction, name=GAP\n*Gap Conductance\n 0.4, 0.\n 0.4, 0.1\n*Step\n*Dynamic Temperature-displacement, Explicit\n , 1.\n\
           *Contact Pair, interaction=GAP\n J0, TOOL\n*Boundary\n 900, 2, 2\n*End Step\n";
    let prepared = crate::common::prepared(&cold, &[], &revolve::user::Routines::none());
    assert!(prepared.diagnostics.iter().any(|d| d.code == "P067"));
}

/// Returns coordinates and temperatures of an instance at the end.
fn temperatures(ran: &DeckRun, instance: &str) -> Vec<([f64; 2], f64)> {
    let (frame, nodes) = (ran.end(), ran.nodes(instance));
    let field = point_field(frame, "NT11");
    nodes.iter().map(|n| (frame.points[n[0]], field[n[0]])).collect()
}

/// Temperatures of 0 below and 1 above: q = 1/(2 L/k + 1/h), linear in each ring, with a jump of q/h. The transient has
/// decayed to e^-20; the pressure causes a strain of 1e-6. The conductance is 0.4 in all cases, tabulated by clearance
/// or by pressure, at a row or between two rows.
#[test]
fn gap_conductance_matches_steady_closed_form() {
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
        let deck = stacked_rings(columns, 4, from, 0.1, interaction) + &step(time, &(held.to_owned() + cards));
        // The upper ring is moved by the gap.
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
                // Distance from the other end in the undeformed ring.
                let way = if sign < 0.0 { (z + 0.5).min(0.5) } else { (z - gap).max(0.0) };
                let exact = if sign < 0.0 { flow * way / k } else { flow * (0.5 / k + 1.0 / h + way / k) };
                worst = worst.max((t - exact).abs());
            }
        }
        println!("conductance {name}, {columns:?}, r >= {from}: error of temperatures {worst:.1e}");
        assert!(worst < tolerance, "{worst}");
    }
}

/// Two nearly isothermal rings: their temperature difference decays with the rate 2/(C L (1/h + 2 L/(3 k))), which
/// includes internal conduction to first order in h L/k = 0.0025. Eight rows underestimate the internal resistance by
/// 1/64, an error of 3e-5. Heat is conserved.
#[test]
fn temperatures_of_two_lumps_decay_to_their_mean() {
    let (h, k, time) = (0.05, 10.0, 5.0);
    let interaction = format!("*Gap Conductance\n {h}, 0.\n {h}, 1.\n");
    let deck = stacked_rings([3, 4], 8, 0.5, k, &interaction) + &step(time, " UPPER.J1, 2, 2\n");
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
        "two lumps: difference {:.7} of {:.7}, error of the sum {:.1e}, ALLIHE {:.1e}",
        upper - lower,
        (-rate * time).exp(),
        upper + lower - 1.0,
        energy.internal_heat.unwrap_or(f64::NAN)
    );
    assert!(((upper - lower) / (-rate * time).exp() - 1.0).abs() < 5e-5);
    assert!((upper + lower - 1.0).abs() < 1e-12 && energy.internal_heat.is_some_and(|h| h.abs() < 1e-12), "{energy:?}");
}

/// A conductance far above that of the elements limits the increment, and the contacting faces reach the mean
/// temperature. At the largest stable increment, oscillations have decayed.
#[test]
fn large_gap_conductance_is_stable() {
    let deck = stacked_rings([3, 4], 4, 0.5, 0.1, "*Gap Conductance\n 1.e4, 0.\n 1.e4, 0.001\n")
        + &step(0.02, " UPPER.J1, 2, 2\n");
    let ran = run(&deck).whole();
    let face = |instance: &str| {
        let all = temperatures(&ran, instance);
        all.into_iter().filter(|(p, _)| p[1] == 0.0).map(|(_, t)| (t - 0.5).abs()).fold(0.0, f64::max)
    };
    let (steps, worst) = (&ran.outcome.steps[0], face("LOWER").max(face("UPPER")));
    println!("great conductance: {} increments, error {worst:.1e}", steps.increments);
    assert!(steps.increments > 1000 && worst < 1e-3, "{worst}");
}

/// A ring slides on a shaft and both conduct. The specified fraction of the frictional work in ALLFD becomes heat, and
/// the specified share of this heat enters the first surface, to rounding. Conduction between the bodies exchanges less
/// than 1e-5 of a share.
#[test]
fn frictional_heat_is_distributed_as_specified() {
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
                + &conductor_material("SHAFT", 1.0, 1e-3, "")
                + &conductor_material("RING", 1.0, 1e-3, "")
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
                "friction {:.4e}: errors of heat {:.1e}, share of the first {:.1e}, ALLIHE {:.1e}",
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
