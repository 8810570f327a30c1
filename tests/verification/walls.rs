//! Forces on walls: reactions of reference nodes and of fixed node sets, forces of contact pairs.
//!
//! Goal: the reported wall force balances the momentum of the bodies, and their weight at rest. Source: balance of
//! momentum. For central differences it holds to rounding: the trapezoidal integral of a force over all increments is
//! the change of momentum.

use std::f64::consts::PI;

use crate::common::bodies::{assembly, elastic, part, rigid_line, run, short};
use crate::common::solid::{grid, material};

const SPEED: f64 = 1e-3;

/// Returns a disc or ring (r from `inner` to 1, length 1, conical ends of this slope) with modulus and density 1,
/// moving towards a wall at a distance of 0.002.
fn thrown_disc([inner, slope]: [f64; 2], wall: &str, more: &str, step: &str, pair: &str) -> String {
    let place = |i: usize, j: usize| {
        let r = inner + (1.0 - inner) * i as f64 / 3.0;
        [r, slope * (r - 1.0) + j as f64 / 8.0]
    };
    part("BAR", [3, 8], place, "")
        + wall
        + &assembly(&["BAR", "WALL"], "*Rigid Body, ref node=WALL.REF, elset=WALL.E\n")
        + &elastic("BAR", [1.0, 0.3, 1.0], "")
        + &format!(
            "*Surface Interaction, name=I\n{more}*Initial Conditions, type=VELOCITY\n BAR.ALL, 2, {:e}\n",
            -SPEED
        )
        + &format!(
            "*Step\n*Dynamic, Explicit{step}\n*Boundary\n WALL.REF, 2, 2\n*Contact Pair, interaction=I{pair}\n BAR.J0, WALL.SKIN\n"
        )
        + "*Output, history, frequency=1\n*Node Output, nset=WALL.REF\n RF\n*Contact Output\n CFN, CFS, CFT, CFTM\n\
           *Output Expression\n UNBALANCED = RF2@WALL.REF - CFT2@BAR.J0_WALL.SKIN\n*End Step\n"
}

/// Returns the trapezoidal integral of a column over time.
fn impulse(rows: &[[f64; 2]]) -> f64 {
    rows.windows(2).map(|w| 0.5 * (w[1][0] - w[0][0]) * (w[0][1] + w[1][1])).sum()
}

fn largest_value(rows: &[[f64; 2]]) -> f64 {
    rows.iter().map(|row| row[1].abs()).fold(0.0, f64::max)
}

/// Impact on a rigid wall, flat or conical, with direct or penalty contact, with and without friction, with fixed and
/// variable increments, with and without contact at the start. The impulse of the wall is the change of momentum. In each row the contact force equals the
/// reaction force.
#[test]
fn rigid_wall_impulse_is_the_change_of_momentum() {
    let flat = rigid_line("WALL", &[[0.0, -0.002], [2.0, -0.002]], "");
    let touching = rigid_line("WALL", &[[0.0, 0.0], [2.0, 0.0]], "");
    let cone = rigid_line("WALL", &[[0.0, -0.302], [3.0, 0.598]], "");
    let friction = "*Friction\n 0.3,\n";
    for (name, shape, wall, more, step, pair) in [
        ("flat", [0.0; 2], &flat, "", "\n , 8.", ""),
        ("flat, touching at the start", [0.0; 2], &touching, "", ", direct user control\n 0.02, 8.", ""),
        ("flat, fixed increments", [0.0; 2], &flat, "", ", direct user control\n 0.02, 8.", ""),
        ("flat, penalty", [0.0; 2], &flat, "", "\n , 8.", ", mechanical constraint=PENALTY"),
        ("cone, friction", [0.5, 0.3], &cone, friction, "\n , 8.", ""),
        ("cone, friction, penalty", [0.5, 0.3], &cone, friction, "\n , 8.", ", mechanical constraint=PENALTY"),
    ] {
        let ran = run(&thrown_disc(shape, wall, more, step, pair)).whole();
        let before = -SPEED * PI * (1.0 - shape[0] * shape[0]);
        let change = ran.momentum() - before;
        let [held, shown, unbalanced] = ["RF2@WALL.REF", "CFT2@BAR.J0_WALL.SKIN", "UNBALANCED"].map(|c| ran.column(c));
        let by = [impulse(&held), impulse(&shown)].map(|i| i / change - 1.0);
        println!(
            "{name}: change of momentum {change:.6e}, errors of the impulses {}, in a row {:.1e}",
            short(&by),
            largest_value(&unbalanced) / largest_value(&held)
        );
        assert_eq!(held.last().map(|row| row[1]), Some(0.0), "{name}: still in contact with the wall");
        let sideways = largest_value(&ran.column("CFS2@BAR.J0_WALL.SKIN"));
        assert_eq!(sideways > 0.0, name.contains("friction"), "{name}: {sideways}");
        assert!(change > 1.2 * -before, "{name}: no rebound");
        assert!(by[0].abs() < 1e-10 && by[1].abs() < 1e-10, "{name}: {by:?}");
        assert!(largest_value(&unbalanced) < 1e-12 * largest_value(&held), "{name}");
    }
}

/// The written contact forces times their intervals are the change of momentum for any output interval: they are means,
/// not samples. With friction, and with magnitudes of the means.
#[test]
fn contact_impulse_is_the_change_of_momentum_at_any_output_interval() {
    let cone = rigid_line("WALL", &[[0.0, -0.302], [3.0, 0.598]], "");
    for output in ["frequency=1", "frequency=7", "number interval=3", "number interval=41", "time interval=0.37"] {
        let deck = thrown_disc([0.5, 0.3], &cone, "*Friction\n 0.3,\n", "\n , 8.", "");
        let ran = run(&deck.replace("history, frequency=1", &format!("history, {output}"))).whole();
        let change = ran.momentum() + SPEED * PI * 0.75;
        let sum = |name: &str| -> f64 {
            let rows = ran.column(&format!("{name}@BAR.J0_WALL.SKIN"));
            rows.windows(2).map(|w| (w[1][0] - w[0][0]) * w[1][1]).sum()
        };
        let parts = sum("CFN2") + sum("CFS2");
        let off = [sum("CFT2"), parts].map(|impulse| impulse / change - 1.0);
        println!("{output}: errors of the impulse {}", short(&off));
        assert!(off.iter().all(|off| off.abs() < 1e-10), "{output}: {off:?}");
    }
}

/// The impulse of fixed nodes is the sum of their reactions.
#[test]
fn fixed_node_impulse_is_the_change_of_momentum() {
    let deck = grid(3, 8, false, |i, j| [1.0 + i as f64 / 3.0, j as f64 / 8.0])
        + &material(1.0, 0.3, 1.0, &format!("*Initial Conditions, type=VELOCITY\n ALL, 2, {:e}\n", -SPEED))
        + "*Step\n*Dynamic, Explicit, direct user control\n 0.02, 1.7\n*Boundary\n J0, 2, 2\n\
           *Output, history, frequency=1\n*Node Output, nset=J0, statistics=SUM\n RF2\n*Node Output, nset=J0\n RF2\n*End Step\n";
    let ran = run(&deck).whole();
    let nodes = &ran.state.dofs.nodes;
    let before: f64 = -SPEED * nodes.mass[4..].iter().sum::<f64>();
    let rows = ran.column("RF2_SUM@J0");
    let last = rows[rows.len() - 1][1];
    // The momentum is that of half an increment before the end.
    let change = ran.momentum() - before;
    let off = (impulse(&rows) - 0.01 * last) / change - 1.0;
    println!("held nodes: change of momentum {change:.6e}, error of the impulse {off:.1e}");
    assert!(off.abs() < 1e-12, "{off}");
    let each: Vec<_> = (1..=4).map(|n| ran.column(&format!("RF2@{n}"))).collect();
    for (i, row) in rows.iter().enumerate() {
        let sum: f64 = each.iter().map(|column| column[i][1]).sum();
        assert!((sum - row[1]).abs() <= 1e-15 * largest_value(&rows), "{sum} {}", row[1]);
    }
}

/// At rest on a rigid wall and on fixed nodes the reaction is the weight; with two bodies on one wall each pair reports
/// its own force.
#[test]
fn reactions_at_rest_equal_the_weight() {
    let damped = |name: &str, density: f64| elastic(name, [100.0, 0.3, density], "*Damping, alpha=3.\n");
    let disc = |name: &str, from: f64, to: f64| {
        part(name, [2, 3], move |i, j| [from + (to - from) * i as f64 / 2.0, 0.2 * j as f64], "")
    };
    let deck = disc("INNER", 0.0, 1.0)
        + &disc("OUTER", 1.5, 2.5)
        + &disc("HELD", 3.0, 4.0)
        + &rigid_line("WALL", &[[0.0, 0.0], [2.6, 0.0]], "")
        + &assembly(
            &["INNER", "OUTER", "HELD", "WALL"],
            "*Elset, elset=ALL\n INNER.SOLID, OUTER.SOLID, HELD.SOLID\n*Rigid Body, ref node=WALL.REF, elset=WALL.E\n",
        )
        + &damped("INNER", 1.0)
        + &damped("OUTER", 2.0)
        + &damped("HELD", 3.0)
        + "*Surface Interaction, name=I\n*Amplitude, name=RISE, definition=SMOOTH STEP\n 0., 0., 4., 1.\n*Step\n*Dynamic, Explicit\n , 20.\n\
           *Boundary\n WALL.REF, 2, 2\n HELD.J0, 2, 2\n*Dload, amplitude=RISE\n ALL, GRAV, 1e-3, 0., -1.\n\
           *Contact Pair, interaction=I\n INNER.J0, WALL.SKIN\n OUTER.J0, WALL.SKIN\n*Output, history, frequency=1\n\
           *Node Output, nset=WALL.REF\n RF2\n*Node Output, nset=HELD.J0, statistics=SUM\n RF\n*Contact Output\n CFT2, CFTM\n*End Step\n";
    let ran = run(&deck).whole();
    let last = |name: &str| ran.column(name).last().expect("rows")[1];
    // Volume, density, gravity.
    let weight = |from: f64, to: f64, density: f64| PI * (to * to - from * from) * 0.6 * density * 1e-3;
    let (inner, outer, held) = (weight(0.0, 1.0, 1.0), weight(1.5, 2.5, 2.0), weight(3.0, 4.0, 3.0));
    let off = [
        last("RF2@WALL.REF") / (inner + outer),
        last("CFT2@INNER.J0_WALL.SKIN") / inner,
        last("CFT2@OUTER.J0_WALL.SKIN") / outer,
        last("RF2_SUM@HELD.J0") / held,
    ]
    .map(|ratio| ratio - 1.0);
    println!("weights: errors {}", short(&off));
    // Residual vibration.
    assert!(off.iter().all(|o| o.abs() < 1e-6), "{off:?}");
    assert_eq!(last("CFTM@INNER.J0_WALL.SKIN"), last("CFT2@INNER.J0_WALL.SKIN").abs());
}
