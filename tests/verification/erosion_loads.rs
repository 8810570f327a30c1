//! Loads on bodies whose elements are deleted: what ends with the faces that go, what begins on those that come to lie bare.
//!
//! Goal: pressure, the user's pressure and the resistance of a target act on the skin there is. Source: projected areas. Each test
//! says its tolerance and why.

use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

use crate::common;
use crate::common::bodies::{Ran, cell_field, run};
use crate::common::solid::{grid, material};

/// Deleted elements at the end.
fn deleted(ran: &Ran) -> usize {
    cell_field(ran.end(), "STATUS").iter().filter(|s| **s == 0.0).count()
}

/// What a run came to, to the bit.
fn bits(ran: &Ran) -> (u64, Vec<u64>) {
    let fields = ran.end().point_fields.iter().chain(&ran.end().cell_fields);
    (ran.outcome.increments, fields.flat_map(|f| f.values.iter().map(|v| v.to_bits())).collect())
}

/// A block of four rows whose upper row flies off until it is deleted, under a pressure on all that lies bare of the upper three, and
/// other cards; what is eroded is the upper row alone.
fn bared(surface: &str, load: &str, more: &str) -> String {
    let (n, m) = (5, 4);
    grid(n, m, false, |i, j| [0.8 * i as f64, j as f64 + 0.05 * ((i * 7 + j * 3) % 5) as f64])
        + &format!(
            "*Elset, elset=UPPER, generate\n {}, {}, 1\n*Elset, elset=TOP, generate\n {}, {}, 1\n",
            n + 1,
            n * m,
            n * (m - 1) + 1,
            n * m
        )
        + &format!("*Surface, name=SKIN\n {surface}\n{more}")
        + &material(200e3, 0.3, 7.8e-9, "*Erosion, elset=TOP, principal strain=0.05\n")
        + "*Initial Conditions, type=VELOCITY\n J1, 2, 2e6\n*Step\n*Dynamic, Explicit\n , 2e-6\n"
        + load
        + "*Output, field, number interval=4\n*Node Output\n U, V\n*Element Output\n STATUS\n*End Step\n"
}

/// Masses times accelerations along z: the forces of loads, for those of elements cancel.
fn force(ran: &Ran) -> f64 {
    let nodes = &ran.state.dofs.nodes;
    nodes.mass.iter().zip(&nodes.acceleration).map(|(mass, a)| mass * a[1]).sum()
}

/// Area of the ring's section across the axis at the rim's foot of the surface: what faces from there to the axis come to along z.
fn area_at(ran: &Ran, node: usize) -> f64 {
    std::f64::consts::PI * ran.state.dofs.nodes[ran.prepared.plan.places.nodes[&node]].r.powi(2)
}

struct Even;

impl UserLoad for Even {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        // Tops, rims and sides on the axis, and the 5 faces that come; what still waits within is not shown.
        assert!(matches!(points.r.len(), 11 | 16), "{}", points.r.len());
        pressure.fill(points.magnitude);
        Ok(())
    }
}

/// Loads follow the skin: when the upper row has gone, the pressure on a surface of elements without a side acts on what it
/// uncovered. Along z it comes to the pressure times the area within the rim's foot, to rounding (1e-12 of the force on all of the
/// face: sums of some tens of terms); so does that of the user, to the same bits, and on 2 threads. A pressure on named sides ends with
/// them, by *DSLOAD and by *DLOAD: no force is left, to rounding. The skin of a whole block is closed before and after: a pressure
/// does not push it.
#[test]
fn pressure_goes_over_to_what_deletion_uncovers() {
    let pressure = 100.0;
    let of = |surface: &str, load: &str| {
        let prepared = common::prepared(&bared(surface, load, ""), &[], &Routines::none().with_load(Even));
        let mut memory = common::Memory::default();
        let (outcome, state) = revolve::solve::run(&prepared.plan, prepared.state.clone(), &mut memory);
        Ran { prepared, outcome, memory, state }.whole()
    };
    // The foot of the rim of the upper three rows is the last node of the second row of nodes.
    let skin = of("UPPER,", "*Dsload\n SKIN, P, 100.\n");
    let whole = pressure * area_at(&skin, 11);
    let off = force(&skin) / -whole - 1.0;
    println!("{} gone, force on the new skin off {off:.1e}", deleted(&skin));
    assert_eq!(deleted(&skin), 5);
    assert!(off.abs() < 1e-12, "{off:e}");
    let user = of("UPPER,", "*Dsload\n SKIN, PNU, 100.\n");
    assert!(bits(&skin) == bits(&user));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
    assert!(bits(&skin) == bits(&pool.install(|| of("UPPER,", "*Dsload\n SKIN, P, 100.\n"))));
    for (name, surface, load) in [
        ("named sides", "TOP, S3", "*Dsload\n SKIN, P, 100.\n"),
        ("sides of elements", "TOP, S3", "*Dload\n TOP, P3, 100.\n"),
        ("a closed skin", "SOLID,", "*Dsload\n SKIN, P, 100.\n"),
    ] {
        let ran = of(surface, load);
        println!("{name}: {:.1e} of the force on the face is left", force(&ran) / whole);
        assert_eq!(deleted(&ran), 5, "{name}");
        assert!(force(&ran).abs() < 1e-12 * whole, "{name}: {:e}", force(&ran));
    }
}

/// A target resists what deletion uncovers: the block flies into it behind its upper row, and at the end, without inertia of the
/// target, the resistance A Y acts on the new face (and on the rim where that moves outward, which has no part along z beyond the
/// slope of it: 2 %). With the sides of the row alone nothing is left to resist.
#[test]
fn a_target_resists_what_deletion_uncovers() {
    let target = "*Material, name=LAW\n*Density\n 1e-9,\n*Cavity Expansion, yield=50.\n 4., 0., 0.\n*Target, name=T, front=0., direction=1\n LAW, 100.\n";
    let of = |surface: &str| {
        let deck = bared(surface, "*Dsload, target=T, friction=0.\n SKIN, CAVITY\n", target);
        run(&deck.replace(" J1, 2, 2e6\n", " ALL, 2, 1e5\n J1, 2, 21e5\n")).whole()
    };
    let [skin, sides] = ["UPPER,", "TOP, S3"].map(of);
    let off = force(&skin) / (-200.0 * area_at(&skin, 23)) - 1.0;
    println!("{} gone, resistance of the new face off {off:.1e}, of the old {:.1e}", deleted(&skin), force(&sides));
    assert_eq!([deleted(&skin), deleted(&sides)], [5, 5]);
    assert!(off.abs() < 0.02, "{off}");
    assert!(force(&sides).abs() < 1e-12 * 200.0 * area_at(&skin, 23));
}
