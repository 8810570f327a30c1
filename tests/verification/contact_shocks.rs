//! Shocks that begin at contact, and penalty contact of bodies with equations of state.
//!
//! Goal: impacts at closing speeds up to the wave speed of the bodies have the pressure of the Hugoniot relations, for hard
//! and penalty contact, unequal meshes, gaps and rigid surfaces; bodies with any equation of state exchange momentum.
//! Source: Us = c0 + s Up and p = rho0 Us Up in both bodies, with the sum of both Up equal to the closing speed; momentum of
//! equal bars after an elastic impact. Tolerance: 1 % (bulk viscosity and penetration near the surface).

use std::fmt::Write as _;

use crate::common::solid::{last, run};

/// Density, c0, s and Grueneisen coefficient, in tonnes, mm, s.
const ALUMINIUM: [f64; 4] = [2.7e-9, 5.328e6, 1.338, 2.0];
const TUNGSTEN: [f64; 4] = [19.3e-9, 4.03e6, 1.237, 1.67];
const COPPER: [f64; 4] = [8.93e-9, 3.94e6, 1.489, 1.99];

/// Number of elements along the moving column.
const COUNT: usize = 60;

fn column_of_elements(name: &str, first: usize, [from, size]: [f64; 2], count: usize) -> String {
    wide_column(name, first, [from, size], count, 1.0)
}

/// Returns a column of elements of a radius.
fn wide_column(name: &str, first: usize, [from, size]: [f64; 2], count: usize, radius: f64) -> String {
    let mut text = format!("*Node, nset={name}ALL\n");
    for j in 0..=count {
        let (node, z) = (first + 2 * j, from + size * j as f64);
        writeln!(text, " {node}, 0., {z:.17e}\n {}, {radius:e}, {z:.17e}", node + 1).expect("text");
    }
    writeln!(text, "*Element, type=CAX4R, elset={name}").expect("text");
    for j in 0..count {
        let node = first + 2 * j;
        writeln!(text, " {}, {node}, {}, {}, {}", first + j, node + 1, node + 3, node + 2).expect("text");
    }
    text + &format!("*Solid Section, elset={name}, material={name}\n")
}

fn metal(name: &str, [density, c0, s, gamma]: [f64; 4]) -> String {
    format!("*Material, name={name}\n*Density\n {density:e},\n*Eos, type=USUP\n {c0:e}, {s}, {gamma}\n")
}

/// Returns the pressure of an impact at a closing speed; `None` is a rigid wall.
fn hugoniot(moving: [f64; 4], target: Option<[f64; 4]>, speed: f64) -> f64 {
    let pressure = |[density, c0, s, _]: [f64; 4], up: f64| density * (c0 + s * up) * up;
    let Some(target) = target else { return pressure(moving, speed) };
    let (mut low, mut high) = (0.0, speed);
    for _ in 0..100 {
        let up = 0.5 * (low + high);
        if pressure(moving, up) < pressure(target, speed - up) { low = up } else { high = up }
    }
    pressure(moving, low)
}

/// Returns a column that hits another one, or a rigid surface, at a speed. `size` is the element size of the moving column,
/// `ratio` that over the size of the target.
fn impact(
    (moving, target): ([f64; 4], Option<[f64; 4]>),
    speed: f64,
    [gap, size, ratio]: [f64; 3],
    contact: &str,
) -> String {
    let fastest = [Some(moving), target].into_iter().flatten().map(|m| m[1] + m[2] * speed).fold(0.0, f64::max);
    let time = gap / speed + 0.6 * COUNT as f64 * size / fastest;
    let (body, more) = match target {
        None => {
            let cards = "*Node\n 90000, 0., 0.\n*Surface, type=SEGMENTS, name=WALL\n START, 0., 0.\n LINE, 2., 0.\n*Rigid Body, \
                         ref node=90000, analytical surface=WALL\n";
            (cards.to_owned(), " 90000, 1, 6\n")
        }
        Some(target) => {
            let count = COUNT * ratio as usize;
            let below = -size * COUNT as f64;
            let mesh = column_of_elements("B", 10_001, [below, size / ratio], count);
            let top = 10_000 + count;
            (
                mesh + &metal("B", target) + &format!("*Elset, elset=BT\n {top},\n*Surface, name=WALL\n BT, S3\n"),
                " BALL, 1, 1\n",
            )
        }
    };
    column_of_elements("A", 1, [gap, size], COUNT)
        + &metal("A", moving)
        + &body
        + &format!(
            "*Elset, elset=AB\n 1,\n*Surface, name=FOOT\n AB, S1\n*Elset, elset=BEHIND\n 5,\n*Surface Interaction, name=I\n\
             *Initial Conditions, type=VELOCITY\n AALL, 2, {:e}\n*Step\n*Dynamic, Explicit\n , {time:e}\n*Boundary\n AALL, 1, \
             1\n{more}*Contact Pair, interaction=I{contact}\n FOOT, WALL\n*Output, history, number interval=20\n*Element \
             Output, elset=BEHIND\n PRESS\n*Energy Output\n ETOTAL\n*End Step\n",
            -speed
        )
}

fn check_pressure(bodies: ([f64; 4], Option<[f64; 4]>), speed: f64, sizes: [f64; 3], contact: &str) {
    let text = impact(bodies, speed, sizes, contact);
    let (outcome, memory) = run(&text);
    assert_eq!(outcome.halt, None, "{bodies:?} at {speed:e}, {sizes:?}, {contact}");
    let ratio = last(&text, &memory, "PRESS@BEHIND") / hugoniot(bodies.0, bodies.1, speed);
    assert!((ratio - 1.0).abs() < 0.01, "{bodies:?} at {speed:e}, {sizes:?}, {contact}: {ratio}");
}

#[test]
fn impacts_have_the_pressure_of_the_hugoniot_at_any_closing_speed() {
    let pairs = [(ALUMINIUM, TUNGSTEN), (TUNGSTEN, ALUMINIUM), (COPPER, COPPER)];
    for (moving, target) in pairs {
        for speed in [0.5e6, 2.4e6, 6e6] {
            for sizes in [[0.0, 0.0625, 1.0], [0.02, 0.1, 2.0]] {
                for contact in ["", ", mechanical constraint=PENALTY"] {
                    check_pressure((moving, Some(target)), speed, sizes, contact);
                }
            }
        }
    }
}

#[test]
fn impacts_on_rigid_surfaces_have_the_pressure_of_the_hugoniot() {
    for speed in [1e6, 2.4e6, 4e6] {
        for gap in [0.0, 0.3] {
            for contact in ["", ", mechanical constraint=PENALTY"] {
                check_pressure((ALUMINIUM, None), speed, [gap, 0.1, 1.0], contact);
            }
        }
    }
}

/// The same impact with another unit of length: lengths and velocities are multiplied, and the density is divided by the
/// third power. The areas of the faces differ by a factor of 1e12, the increments do not.
#[test]
fn increments_before_an_impact_do_not_depend_on_the_unit_of_length() {
    let increments = |unit: f64| {
        let in_unit = |[density, c0, s, gamma]: [f64; 4]| [density / (unit * unit * unit), c0 * unit, s, gamma];
        let [moving, target] = [ALUMINIUM, TUNGSTEN].map(in_unit);
        let ([gap, size], speed) = ([0.4, 0.1].map(|length| length * unit), 2.4e6 * unit);
        let column = |name: &str, first: usize, from: f64| wide_column(name, first, [from, size], 20, unit);
        let text = column("A", 1, gap)
            + &metal("A", moving)
            + &column("B", 10_001, -20.0 * size)
            + &metal("B", target)
            + &format!(
                "*Elset, elset=AB\n 1,\n*Elset, elset=BT\n 10020,\n*Surface, name=FOOT\n AB, S1\n*Surface, name=TOP\n BT, \
                 S3\n*Surface Interaction, name=I\n*Initial Conditions, type=VELOCITY\n AALL, 2, {:e}\n*Step\n*Dynamic, \
                 Explicit\n , 3e-7\n*Boundary\n AALL, 1, 1\n BALL, 1, 1\n*Contact Pair, interaction=I\n FOOT, TOP\n*End \
                 Step\n",
                -speed
            );
        let (outcome, _) = run(&text);
        assert_eq!(outcome.halt, None, "{unit}");
        outcome.increments
    };
    let [small, usual, large] = [1.0 / 1024.0, 1.0, 1024.0].map(increments);
    assert_eq!([small, large], [usual; 2]);
    // From three increments before the contact to four transit times after it, at least ten increments per transit time.
    assert!(usual > 40 + 10, "{usual}");
}

/// Equal bars exchange their velocities in an elastic impact. The impact is slow, so that each law is linear. Bar: 7 % of
/// the velocity (20 elements and bulk viscosity smear the wave; 5.5 %), 1e-9 of the momentum.
#[test]
fn penalty_contact_works_with_every_equation_of_state() {
    let gas = "*Eos, type=IDEAL GAS\n 0.4, 0.4\n*Specific Heat\n 1.,\n*Initial Conditions, type=TEMPERATURE\n AALL, 1.\n BALL, 1.\n";
    let laws = [
        "*Eos, type=TABULAR\n -0.1, 0., 0.1\n 0., 0., 0.\n 0.1, 0., -0.1\n",
        "*Eos, type=TABULAR\n -0.1, 0., 0.1\n 0.1, 0., -0.1\n",
        "*Eos, type=USUP\n 1., 1.5, 2.\n",
        gas,
    ];
    for law in laws {
        let bars = column_of_elements("A", 1, [0.0, 0.1], 20) + &column_of_elements("B", 10_001, [-2.0, 0.1], 20);
        let text = bars.replace("material=B", "material=A")
            + &format!(
                "*Elset, elset=AB\n 1,\n*Surface, name=FOOT\n AB, S1\n*Elset, elset=BT\n 10020,\n*Surface, name=TOP\n BT, \
                 S3\n*Material, name=A\n*Density\n 1.,\n{law}*Initial Conditions, type=VELOCITY\n AALL, 2, -1e-3\n*Surface \
                 Interaction, name=I\n*Step\n*Dynamic, Explicit\n , 8.\n*Boundary\n AALL, 1, 1\n BALL, 1, 1\n*Contact Pair, \
                 interaction=I, mechanical constraint=PENALTY\n FOOT, TOP\n*Output, history, number interval=20\n*Energy \
                 Output, elset=A\n PARTVEL\n*Energy Output, elset=B\n PARTVEL\n*End Step\n"
            );
        let (outcome, memory) = run(&text);
        assert_eq!(outcome.halt, None, "{law}");
        let [moving, hit] = ["PARTVEL@A", "PARTVEL@B"].map(|name| last(&text, &memory, name) / -1e-3);
        assert!((moving + hit - 1.0).abs() < 1e-9, "{law}: momentum {}", moving + hit);
        assert!(moving.abs() < 0.07 && (hit - 1.0).abs() < 0.07, "{law}: {moving} {hit}");
    }
}
