//! An elastic deck has no run time for plasticity, failure or equations of state. The element group of a deck is
//! measured in alternation with the same loop for a law without any code of plasticity.

use std::time::Instant as Stopwatch;

use revolve::internals::QuadGroup;
use revolve::internals::bulk_viscosity::BulkViscosity;
use revolve::internals::constants::{ElementConstants, HourglassControl};
use revolve::internals::corner_forces::CornerForces;
use revolve::internals::group::{ElementGroup, ElementPass};
use revolve::internals::lanes::LANES;
use revolve::internals::nodes::Node;
use revolve::internals::volumetric::ConstantBulkModulus;
use revolve::internals::von_mises::VonMises;
use revolve::solve::Instant;
use revolve::user::{PointRoutines, Routines};

use crate::common;
use crate::common::routines::NoPlasticity;
use crate::common::solid::{grid, material};

/// Measures one pass in nanoseconds per element and keeps the smallest value.
fn time_pass(group: &mut dyn ElementGroup, nodes: &[Node], corners: &mut CornerForces, best: &mut f64) {
    let begin = Stopwatch::now();
    for _ in 0..4 {
        group.update(ElementPass {
            nodes,
            dt: 1e-9,
            before: Default::default(),
            now: &Instant::default(),
            threads: false,
            user: PointRoutines::default(),
            corners: corners.slots(0..group.len().div_ceil(LANES)),
            tiles: None,
            dilation_correction: None,
            prefetches: false,
        });
    }
    *best = best.min(begin.elapsed().as_secs_f64() * 1e9 / (4 * group.len()) as f64);
}

pub fn run() {
    // Fewer elements than are distributed over threads.
    let n = 64;
    let deck = |plastic: &str| {
        grid(n, n, false, |i, j| [0.1 * i as f64, 0.1 * j as f64])
            + &material(200e3, 0.3, 7.85e-9, plastic)
            // Without strains, which are computed only on request.
            + "*Step\n*Dynamic, Explicit\n , 1.\n*Output, history\n*Energy Output\n ALLIE\n*End Step\n"
    };
    let groups = |plastic: &str| common::prepared(&deck(plastic), &[], &Routines::none()).state;
    let (mut elastic, mut plastic) = (groups(""), groups("*Plastic\n 1e9, 0.\n"));
    let wobble = |i: usize| ((i * 7919) % 101) as f64 * 1e-3;
    let moving = |(i, n): (usize, &Node)| Node { v_r: wobble(i), v_z: wobble(i + 7), ..*n };
    let nodes: Vec<Node> = elastic.dofs.nodes.as_slice().iter().enumerate().map(moving).collect();
    let nodes = &nodes[..];
    let elements: Vec<[u32; 4]> = (0..n * n).flat_map(|e| elastic.elements.groups[0].cells(e)).collect();
    let (bulk, shear) = (200e3 / 1.2, 200e3 / 2.6);
    let constants = ElementConstants {
        bulk,
        shear,
        hourglass: HourglassControl { stiffness: 0.005, viscosity: 0.0, relaxes: true, enhanced: 0.0 },
        bulk_viscosity: BulkViscosity::default(),
        shear_viscosity: 0.0,
        by_area: false,
    };
    let mut without_plasticity =
        QuadGroup::new(VonMises::new(NoPlasticity, ConstantBulkModulus), constants, 7.85e-9, &elements, nodes);
    let mut corners = CornerForces::new(elements.len().div_ceil(LANES));
    let [mut deck, mut without, mut with] = [f64::INFINITY; 3];
    for _ in 0..150 {
        time_pass(&mut *elastic.elements.groups[0], nodes, &mut corners, &mut deck);
        time_pass(&mut without_plasticity, nodes, &mut corners, &mut without);
        time_pass(&mut *plastic.elements.groups[0], nodes, &mut corners, &mut with);
    }
    println!(
        "elastic deck {deck:.2} ns per element ({:.3}), without plasticity {without:.2}, with it {with:.2} ({:.3})",
        deck / without,
        with / without
    );
}
