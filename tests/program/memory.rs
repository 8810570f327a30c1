//! What a run allocates.
//!
//! Goal: nothing is allocated inside an increment; an elastic deck holds no byte for plasticity.
//! Source: an allocator that counts; the size of a loop built for a law that holds no code of plasticity.

use revolve::internals::constants::Constants;
use revolve::internals::failure::Intact;
use revolve::internals::group::{ElementGroup, Quads};
use revolve::internals::plasticity::{Flow, Hardening};
use revolve::internals::volumetric::Linear;
use revolve::job;
use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

use crate::common;
use crate::common::solid::{grid, material};

/// A heavy ogive that flies on at much the same speed through 200 000 increments, fully embedded.
fn flight() -> String {
    let deck = common::ogive()
        .replace("mass = 0.021", "mass = 1.e4")
        .replace("front = 0.\n", "front = 0.1\n")
        .replace("AL6061, 0.5", "AL6061, 50.")
        .replace("*Dynamic, Explicit\n , 1.e-3", "*Dynamic, Explicit, direct user control\n 5e-9, 1.e-3");
    deck.split("*Output, field").next().expect("text").to_owned() + "*End Step\n"
}

struct Constant;

impl UserLoad for Constant {
    fn pressure(&mut self, _points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        pressure.fill(1e9);
        Ok(())
    }
}

/// Increments of a run, and how often it allocated.
fn allocations(deck: &str) -> (u64, u64) {
    let routine = Routines::none().with_load(Constant);
    let mut prepared = job::prepare_text("ogive.inp", deck, &[], &routine);
    let mut increments = 0;
    let counted = allocation_counter::measure(|| increments = job::run_in_memory(&mut prepared).0.increments);
    (increments, counted.count_total)
}

#[test]
fn nothing_allocates_inside_an_increment() {
    let text = flight();
    let own = text.replace("*Dsload, target=BLOCK, friction=<friction>\n NOSE, CAVITY", "*Dsload\n NOSE, PNU");
    let automatic = |accuracy| text.replace(", direct user control\n 5e-9,", &format!(", accuracy={accuracy}\n ,"));
    let shorter = |deck: &str| deck.replace(", 1.e-3", ", 1.e-4");
    for (name, short, long) in [
        ("CAVITY", shorter(&text), text.clone()),
        ("UserLoad", shorter(&own), own.clone()),
        ("automatic increments", automatic("1e-8"), automatic("1e-10")),
    ] {
        let (short, long) = (allocations(&short), allocations(&long));
        println!("{name}: {} allocations over {} increments, {} over {}", short.1, short.0, long.1, long.0);
        assert!(long.0 > 5 * short.0 && short.0 > 1000);
        assert_eq!(long.1, short.1, "{name}");
    }
}

/// A law without anything: what is called here would be noticed.
struct Bare;

impl Hardening for Bare {
    type State = ();
    const FLOWS: bool = false;

    fn fresh(&self) {}

    fn flow(&self, (): &mut (), _flow: &mut Flow<'_>) {
        unreachable!("nothing flows");
    }

    fn plastic_strain(&self, (): &(), _lane: usize) -> f64 {
        unreachable!("nothing flows")
    }
}

#[test]
fn an_elastic_deck_holds_no_byte_for_plasticity() {
    // Without the strains that a deck without requests would follow.
    let deck = grid(8, 8, false, |i, j| [0.1 * i as f64, 0.1 * j as f64])
        + &material(200e3, 0.3, 7.85e-9, "")
        + "*Step\n*Dynamic, Explicit\n , 1.\n*Output, history\n*Energy Output\n ALLIE\n*End Step\n";
    let state = common::prepared(&deck, &[], &Routines::none()).state;
    let elastic = &state.elements;
    let elements: Vec<[u32; 4]> = (0..64).map(|e| elastic.groups[0].corners(e)).collect();
    let (bulk, shear) = (200e3 / 1.2, 200e3 / 2.6);
    let constants =
        Constants { bulk, shear, hourglass_stiffness: 0.005, hourglass_viscosity: 0.0, bulk_viscosity: [0.06, 1.2] };
    let bare = Quads::new((Bare, Linear, Intact), constants, 7.85e-9, &elements, state.dofs.nodes.as_slice());
    assert_eq!(elastic.groups[0].bytes(), bare.bytes());
}
