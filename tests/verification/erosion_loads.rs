//! Loads on bodies with element deletion: end of loads on deleted faces, begin of loads on newly exposed faces.
//!
//! Goal: pressure, user pressure and target resistance act on the current exposed faces. Source: projected areas. The
//! tolerance and its reason are stated at each test.

use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

use crate::common;
use crate::common::bodies::{DeckRun, cell_field, run};
use crate::common::solid::{grid, material};

/// Returns the number of deleted elements at the end.
fn deleted_count(ran: &DeckRun) -> usize {
    cell_field(ran.end(), "STATUS").iter().filter(|s| **s == 0.0).count()
}

/// Returns the bits of the final results.
fn result_bits(ran: &DeckRun) -> (u64, Vec<u64>) {
    let fields = ran.end().point_fields.iter().chain(&ran.end().cell_fields);
    (ran.outcome.increments, fields.flat_map(|f| f.values.iter().map(|v| v.to_bits())).collect())
}

/// Returns a block of four rows whose upper row separates until it is deleted; only this row can be deleted. A load
/// acts on `surface`.
fn block_with_load(surface: &str, load: &str, more: &str) -> String {
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

/// Returns the axial force of the loads: the sum of masses times accelerations, in which element forces cancel.
fn load_force(ran: &DeckRun) -> f64 {
    let nodes = &ran.state.dofs.nodes;
    nodes.mass.iter().zip(&nodes.acceleration).map(|(mass, a)| mass * a[1]).sum()
}

/// Returns the area inside the ring of a node: the projected axial area of all faces from that node to the axis.
fn area_at(ran: &DeckRun, node: usize) -> f64 {
    std::f64::consts::PI * ran.state.dofs.nodes[ran.prepared.plan.places.nodes[&node]].r.powi(2)
}

struct UniformPressure;

impl UserLoad for UniformPressure {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        // The initial faces, or these and the 5 newly exposed faces; inner faces are not passed to the load.
        assert!(matches!(points.r.len(), 11 | 16), "{}", points.r.len());
        pressure.fill(points.magnitude);
        Ok(())
    }
}

/// Loads act on the exposed faces: after deletion of the upper row, the pressure on an element-based surface without
/// face identifiers acts on the new faces. Its axial force is pressure times projected area to rounding (1e-12 of the
/// force on the whole face), for the user pressure and on 2 threads with the same bits. A pressure on specified faces
/// (`*DSLOAD`, `*DLOAD`) ends with them. The surface of a whole block is closed before and after, and its net force is
/// zero.
#[test]
fn pressure_acts_on_newly_exposed_faces() {
    let pressure = 100.0;
    let of = |surface: &str, load: &str| {
        let prepared =
            common::prepared(&block_with_load(surface, load, ""), &[], &Routines::none().with_load(UniformPressure));
        let mut memory = common::RecordedOutput::default();
        let (outcome, state) = revolve::solve::run(&prepared.plan, prepared.state.clone(), &mut memory);
        DeckRun { prepared, outcome, memory, state }.whole()
    };
    // The lower end of the outer side of the three upper rows is the last node of the second node row.
    let skin = of("UPPER,", "*Dsload\n SKIN, P, 100.\n");
    let full_force = pressure * area_at(&skin, 11);
    let off = load_force(&skin) / -full_force - 1.0;
    println!("{} deleted, error of the force on the new faces {off:.1e}", deleted_count(&skin));
    assert_eq!(deleted_count(&skin), 5);
    assert!(off.abs() < 1e-12, "{off:e}");
    let user = of("UPPER,", "*Dsload\n SKIN, PNU, 100.\n");
    assert!(result_bits(&skin) == result_bits(&user));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("threads");
    assert!(result_bits(&skin) == result_bits(&pool.install(|| of("UPPER,", "*Dsload\n SKIN, P, 100.\n"))));
    for (name, surface, load) in [
        ("named sides", "TOP, S3", "*Dsload\n SKIN, P, 100.\n"),
        ("sides of elements", "TOP, S3", "*Dload\n TOP, P3, 100.\n"),
        ("a closed surface", "SOLID,", "*Dsload\n SKIN, P, 100.\n"),
    ] {
        let ran = of(surface, load);
        println!("{name}: {:.1e} of the force on the face remains", load_force(&ran) / full_force);
        assert_eq!(deleted_count(&ran), 5, "{name}");
        assert!(load_force(&ran).abs() < 1e-12 * full_force, "{name}: {:e}", load_force(&ran));
    }
}

/// A target resists newly exposed faces: the block enters the target after its upper row. At the end, without target
/// inertia, the resistance A Y acts on the new face, and on the outer side where it moves outward, whose axial
/// component is below 2 %. If only faces of the deleted row are specified, no resistance remains.
#[test]
fn target_resists_newly_exposed_faces() {
    let target = "*Material, name=LAW\n*Density\n 1e-9,\n*Cavity Expansion, yield=50.\n 4., 0., 0.\n*Target, name=T, front=0., direction=1\n LAW, 100.\n";
    let of = |surface: &str| {
        let deck = block_with_load(surface, "*Dsload, target=T, friction=0.\n SKIN, CAVITY\n", target);
        run(&deck.replace(" J1, 2, 2e6\n", " ALL, 2, 1e5\n J1, 2, 21e5\n")).whole()
    };
    let [skin, sides] = ["UPPER,", "TOP, S3"].map(of);
    let off = load_force(&skin) / (-200.0 * area_at(&skin, 23)) - 1.0;
    println!(
        "{} deleted, error of the resistance of the new face {off:.1e}, rest of the old face {:.1e}",
        deleted_count(&skin),
        load_force(&sides)
    );
    assert_eq!([deleted_count(&skin), deleted_count(&sides)], [5, 5]);
    assert!(off.abs() < 0.02, "{off}");
    assert!(load_force(&sides).abs() < 1e-12 * 200.0 * area_at(&skin, 23));
}
