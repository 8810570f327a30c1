//! Forces on walls: reactions of reference nodes and of sets of nodes that are held, forces of pairs in contact.
//!
//! Goal: what a history shows as the force on a wall is what the momentum of the bodies in front of it asks for, and at rest
//! their weight. Source: the balance of momentum. Central differences hold it to rounding: the trapezoid of a force over
//! the rows of all increments is the change of momentum.

use std::f64::consts::PI;

use crate::common::bodies::{assembly, elastic, part, rigid_line, run, short};
use crate::common::solid::{grid, material};

const SPEED: f64 = 1e-3;

/// A disc or ring (r from `inner` to 1, length 1, its ends cones of this slope) of modulus and density 1 that flies at a wall
/// 0.002 below it.
fn thrown([inner, slope]: [f64; 2], wall: &str, more: &str, step: &str, pair: &str) -> String {
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

/// Trapezoid of a column over time.
fn impulse(rows: &[[f64; 2]]) -> f64 {
    rows.windows(2).map(|w| 0.5 * (w[1][0] - w[0][0]) * (w[0][1] + w[1][1])).sum()
}

fn largest(rows: &[[f64; 2]]) -> f64 {
    rows.iter().map(|row| row[1].abs()).fold(0.0, f64::max)
}

/// Thrown at a rigid wall that its reference node holds, flat or a cone, with contact at once or penalty springs, with and
/// without friction, in increments of one length and of many: the impulse of the wall is the change of momentum, and what the
/// pair shows is what the wall holds in each row.
#[test]
fn the_impulse_of_a_rigid_wall_is_the_change_of_momentum() {
    let flat = rigid_line("WALL", &[[0.0, -0.002], [2.0, -0.002]], "");
    let cone = rigid_line("WALL", &[[0.0, -0.302], [3.0, 0.598]], "");
    let friction = "*Friction\n 0.3,\n";
    for (name, shape, wall, more, step, pair) in [
        ("flat", [0.0; 2], &flat, "", "\n , 8.", ""),
        ("flat, fixed increments", [0.0; 2], &flat, "", ", direct user control\n 0.02, 8.", ""),
        ("flat, penalty", [0.0; 2], &flat, "", "\n , 8.", ", mechanical constraint=PENALTY"),
        ("cone, friction", [0.5, 0.3], &cone, friction, "\n , 8.", ""),
        ("cone, friction, penalty", [0.5, 0.3], &cone, friction, "\n , 8.", ", mechanical constraint=PENALTY"),
    ] {
        let ran = run(&thrown(shape, wall, more, step, pair)).whole();
        let before = -SPEED * PI * (1.0 - shape[0] * shape[0]);
        let change = ran.momentum() - before;
        let [held, shown, unbalanced] = ["RF2@WALL.REF", "CFT2@BAR.J0_WALL.SKIN", "UNBALANCED"].map(|c| ran.column(c));
        let by = [impulse(&held), impulse(&shown)].map(|i| i / change - 1.0);
        println!(
            "{name}: change of momentum {change:.6e}, impulses {} off, in a row {:.1e}",
            short(&by),
            largest(&unbalanced) / largest(&held)
        );
        assert_eq!(held.last().map(|row| row[1]), Some(0.0), "{name}: it has left the wall");
        let sideways = largest(&ran.column("CFS2@BAR.J0_WALL.SKIN"));
        assert_eq!(sideways > 0.0, name.contains("friction"), "{name}: {sideways}");
        assert!(change > 1.2 * -before, "{name}: it is thrown back");
        assert!(by[0].abs() < 1e-10 && by[1].abs() < 1e-10, "{name}: {by:?}");
        assert!(largest(&unbalanced) < 1e-12 * largest(&held), "{name}");
    }
}

/// Nodes that are held are a wall, too: the sum of their reactions.
#[test]
fn the_impulse_of_nodes_that_are_held() {
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
    println!("held nodes: change of momentum {change:.6e}, impulse {off:.1e} off");
    assert!(off.abs() < 1e-12, "{off}");
    let each: Vec<_> = (1..=4).map(|n| ran.column(&format!("RF2@{n}"))).collect();
    for (i, row) in rows.iter().enumerate() {
        let sum: f64 = each.iter().map(|column| column[i][1]).sum();
        assert!((sum - row[1]).abs() <= 1e-15 * largest(&rows), "{sum} {}", row[1]);
    }
}

/// At rest on a rigid wall, and on nodes that are held, a body weighs what it should; of two bodies on one wall each pair
/// shows its own.
#[test]
fn weights_at_rest() {
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
           *Contact Pair, interaction=I\n INNER.J0, WALL.SKIN\n OUTER.J0, WALL.SKIN\n*Output, history, number interval=10\n\
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
    println!("weights: {} off", short(&off));
    // What still vibrates.
    assert!(off.iter().all(|o| o.abs() < 1e-6), "{off:?}");
    assert_eq!(last("CFTM@INNER.J0_WALL.SKIN"), last("CFT2@INNER.J0_WALL.SKIN").abs());
}
