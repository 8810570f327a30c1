//! Forces on walls: reactions of reference nodes and of fixed node sets, forces of contact pairs.
//!
//! Goal: the reported wall force balances the momentum of the bodies, and their weight at rest. Source: balance of
//! momentum. For central differences it holds to rounding: reported forces are means over the output interval, and their
//! integral is the change of momentum.

use std::f64::consts::PI;

use crate::common::bodies::{DeckRun, assembly, elastic, part, rigid_line, run, short};
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

/// Returns the integral over time of a column of means.
fn impulse(rows: &[[f64; 2]]) -> f64 {
    rows.windows(2).map(|w| (w[1][0] - w[0][0]) * w[1][1]).sum()
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

/// Output intervals of the same run.
const INTERVALS: [&str; 5] =
    ["frequency=1", "frequency=7", "number interval=3", "number interval=41", "time interval=0.37"];

/// The written contact and reaction forces times their intervals are the change of momentum for any output interval: they
/// are means, not samples. With friction, and with magnitudes of the means.
#[test]
fn contact_impulse_is_the_change_of_momentum_at_any_output_interval() {
    let cone = rigid_line("WALL", &[[0.0, -0.302], [3.0, 0.598]], "");
    for output in INTERVALS {
        let deck = thrown_disc([0.5, 0.3], &cone, "*Friction\n 0.3,\n", "\n , 8.", "");
        let ran = run(&deck.replace("history, frequency=1", &format!("history, {output}"))).whole();
        let change = ran.momentum() + SPEED * PI * 0.75;
        let sum = |name: &str| impulse(&ran.column(name));
        let parts = sum("CFN2@BAR.J0_WALL.SKIN") + sum("CFS2@BAR.J0_WALL.SKIN");
        let off = [sum("CFT2@BAR.J0_WALL.SKIN"), parts, sum("RF2@WALL.REF")].map(|impulse| impulse / change - 1.0);
        println!("{output}: errors of the impulse {}", short(&off));
        assert!(off.iter().all(|off| off.abs() < 1e-10), "{output}: {off:?}");
    }
}

/// Returns the axial momentum at the end, by the velocities of the last row.
fn final_momentum(ran: &DeckRun) -> f64 {
    let (nodes, bodies) = (&ran.state.dofs.nodes, &ran.state.dofs.bodies);
    let of_nodes: f64 = (0..nodes.len()).map(|n| nodes.mass[n] * nodes.velocity_now(n)[1]).sum();
    of_nodes + bodies.iter().map(|b| b.mass * b.velocity).sum::<f64>()
}

/// Returns the impulse of all axial reactions of nodes and reference nodes.
fn reaction_impulse(ran: &DeckRun) -> f64 {
    let names = ran.prepared.plan.columns.iter().map(|c| c.name.as_str());
    names.filter(|name| name.starts_with("RF2@")).map(|name| impulse(&ran.column(name))).sum()
}

/// The impulse of fixed nodes is the change of momentum at any output interval, and the sum over the set is that of its
/// members. The fixed nodes have no velocity at the start.
#[test]
fn fixed_node_impulse_is_the_change_of_momentum() {
    for (output, control) in
        INTERVALS.iter().flat_map(|output| [(output, ", direct user control\n 0.02, 1.7"), (output, "\n , 1.7")])
    {
        let deck = grid(3, 8, false, |i, j| [1.0 + i as f64 / 3.0, j as f64 / 8.0])
            + &material(1.0, 0.3, 1.0, &format!("*Initial Conditions, type=VELOCITY\n ALL, 2, {:e}\n", -SPEED))
            + &format!("*Step\n*Dynamic, Explicit{control}\n*Boundary\n J0, 2, 2\n*Output, history, {output}\n")
            + "*Node Output, nset=J0, statistics=SUM\n RF2\n*Node Output, nset=J0\n RF2\n*End Step\n";
        let ran = run(&deck).whole();
        let change = final_momentum(&ran) + SPEED * ran.state.dofs.nodes.mass[4..].iter().sum::<f64>();
        let rows = ran.column("RF2_SUM@J0");
        let off = [impulse(&rows), reaction_impulse(&ran)].map(|impulse| impulse / change - 1.0);
        println!("{output}: change of momentum {change:.6e}, errors of the impulses {}", short(&off));
        assert!(off.iter().all(|off| off.abs() < 1e-10), "{output}: {off:?}");
    }
}

/// A heavy ram with a prescribed velocity presses a block on fixed nodes, with and without an equation
/// between a fixed node and two others, over two steps: in the second one the foot moves. The impulses of all reactions
/// are the change of momentum at any output interval.
#[test]
fn reactions_of_ram_and_foot_are_the_change_of_momentum() {
    let ram = part_of_ram();
    for (name, link) in
        [("plain", ""), ("linked", "*Equation\n 3\n BAR.I0J0, 2, 2., BAR.I2J4, 2, -1., BAR.I3J4, 2, -1.\n")]
    {
        for output in INTERVALS {
            let history = format!(
                "*Output, history, {output}\n*Node Output, nset=RAM.REF\n RF2\n*Node Output, nset=BAR.J0\n RF2\n*End Step\n"
            );
            let deck = part(
                "BAR",
                [3, 8],
                |i, j| [i as f64 / 3.0, j as f64 / 8.0],
                "*Nset, nset=I0J0\n 1\n*Nset, nset=I2J4\n 19\n*Nset, nset=I3J4\n 20\n",
            ) + &ram
                + &assembly(&["BAR", "RAM"], &format!("*Rigid Body, ref node=RAM.REF, elset=RAM.E\n{link}"))
                + &elastic("BAR", [1.0, 0.3, 1.0], "")
                + "*Surface Interaction, name=I\n*Amplitude, name=A, definition=SMOOTH STEP\n 0., 0., 1., 1., 9., 1.\n\
                   *Step\n*Dynamic, Explicit\n , 2.\n*Boundary\n BAR.J0, 2, 2\n\
                   *Boundary, type=VELOCITY, amplitude=A\n RAM.REF, 2, 2, -0.02\n*Contact Pair, interaction=I\n BAR.J1, RAM.SKIN\n"
                + &history
                + "*Step\n*Dynamic, Explicit\n , 1.3\n*Boundary, op=NEW, type=VELOCITY, amplitude=A\n BAR.J0, 2, 2, -0.01\n RAM.REF, 2, 2, -0.015\n"
                + &history;
            let ran = run(&deck).whole();
            let change = final_momentum(&ran);
            let off = reaction_impulse(&ran) / change - 1.0;
            println!("{name}, {output}: change of momentum {change:.6e}, error of the impulse {off:.1e}");
            assert!(off.abs() < 1e-10, "{name}, {output}: {off}");
        }
    }
}

/// Returns a rigid ram above the block, with a point mass at its reference node.
fn part_of_ram() -> String {
    rigid_line("RAM", &[[2.0, 1.001], [0.0, 1.001]], "*Element, type=MASS, elset=M\n 99, 1000\n*Mass, elset=M\n 3.,\n")
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
