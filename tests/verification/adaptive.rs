//! Adaptive meshes.
//!
//! Goal: the same results as on meshes that follow the material, where these work; good elements and larger increments
//! in upsetting. Source: runs without the card. Tolerances are stated at each test.

use revolve::job;
use revolve::output::HistorySummary;
use revolve::solve::{self, Outcome};
use revolve::user::Routines;

use crate::common;
use crate::common::solid::last;

/// Card of the Taylor bar.
const BAR: &str = "*Adaptive Mesh, elset=BAR\n";

fn run(deck: &str, settings: &[(&str, &str)]) -> (Outcome, HistorySummary) {
    let prepared = common::prepared(deck, settings, &Routines::none());
    job::run_in_memory(&prepared)
}

fn taylor(card: &str) -> String {
    let deck = std::fs::read_to_string(common::project("input/taylor_copper.inp")).expect("the deck");
    deck.replacen(" , 80.e-6\n", &format!(" , 80.e-6\n{card}"), 1)
}

/// Length and foot radius within .3 % of the mesh that follows the material; the drift includes the lost kinetic energy.
#[test]
fn taylor_bar_keeps_its_length_and_foot() {
    let (follows, reference) = run(&taylor(""), &[]);
    for card in [BAR, "*Adaptive Mesh, elset=BAR, frequency=1\n", "*Adaptive Mesh, elset=BAR, mesh sweeps=3\n"] {
        let (outcome, history) = run(&taylor(card), &[]);
        assert_eq!(outcome.halt, None);
        for name in ["COOR2@TIP", "COOR1@CORNER"] {
            let apart = history.0[name].last / reference.0[name].last - 1.0;
            println!("{}: {name} {:.3} % apart", card.trim(), 100.0 * apart);
            assert!(apart.abs() < 3e-3, "{card}: {name} {apart}");
        }
        let lost = outcome.energy.advection.expect("an energy of the transport");
        assert!(lost > 0.0 && lost < 1e-2 * outcome.energy.initial, "{lost}");
        assert!(outcome.energy.drift < 1e-3, "{}", outcome.energy.drift);
        assert!(outcome.increments < follows.increments);
    }
}

/// Returns the smallest angle at a corner of an element, degrees.
fn smallest_angle(state: &revolve::plan::State) -> f64 {
    let place = |n: u32| state.dofs.nodes[n as usize].place();
    let angle = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| {
        let ([x, y], [u, v]) = ([a[0] - b[0], a[1] - b[1]], [c[0] - b[0], c[1] - b[1]]);
        // A flat corner has 180 degrees, with either sign.
        let angle = (u * y - v * x).atan2(x * u + y * v).to_degrees();
        if angle < -90.0 { angle + 360.0 } else { angle }
    };
    let group = &state.elements.groups[0];
    let corners = (0..group.len()).flat_map(|e| {
        let nodes = group.nodes(e);
        (0..4).map(move |i| [(i + 3) % 4, i, (i + 1) % 4].map(|k| nodes[k]))
    });
    corners.map(|[a, b, c]| angle(place(a), place(b), place(c))).fold(180.0, f64::min)
}

/// Upsetting to a quarter of the height: the force is that of the mesh that follows the material (which works here at low
/// friction), with elements that stay good.
#[test]
fn upsetting_keeps_elements_and_force() {
    let deck = std::fs::read_to_string(common::project("input/upsetting.inp")).expect("the deck");
    let card = "*Adaptive Mesh, elset=BILLET, frequency=<every>\n";
    let follows = deck.replacen(card, "", 1).replace("ALLADV, ", "");
    let settings = [("nr", "10"), ("nz", "15"), ("mu", "0.1")];
    let ends = [&deck, &follows].map(|text| {
        let prepared = common::prepared(text, &settings, &Routines::none());
        let (plan, mut shown) = (&prepared.plan, common::RecordedOutput::default());
        let (outcome, state) = solve::run(plan, prepared.state.clone(), &mut shown);
        assert_eq!(outcome.halt, None);
        let force = last(text, &shown, "RF2@DIE");
        (outcome, smallest_angle(&state), force)
    });
    let [(adapted, angle, force), (plain, before, reference)] = ends;
    println!(
        "upsetting: angles {angle:.0} and {before:.0} degrees, increments {} and {}, forces {force:e} and {reference:e}",
        adapted.increments, plain.increments
    );
    assert!(angle > 25.0, "{angle}");
    assert!((force / reference - 1.0).abs() < 0.02, "{force} {reference}");
    assert!(adapted.energy.drift < 1e-3, "{}", adapted.energy.drift);
}

/// Combinations that are not supported are refused, with the card and what would be right.
#[test]
fn unsupported_domains_are_refused() {
    let section = "*Solid Section, elset=BAR, material=COPPER";
    let controlled = format!("*Section Controls, name=S, distortion control=YES\n{section}, controls=S");
    let with_part = format!("*Elset, elset=PART\n 1, 2\n{section}");
    let twice = format!("{BAR}*Adaptive Mesh, elset=PART\n");
    for (deck, words) in [
        (taylor(&format!("{BAR}*Fixed Mass Scaling, factor=2.\n")), "mass scaling"),
        (taylor(BAR).replacen(section, &controlled, 1), "DISTORTION CONTROL"),
        (taylor(&twice).replacen(section, &with_part, 1), "two adaptive meshes"),
    ] {
        let prepared = job::prepare_text("test.inp", &deck, &common::pairs(&[]), &Routines::none());
        let found = prepared.diagnostics.render(&prepared.deck.sources);
        assert!(found.contains("P071") && found.contains(words), "{found}");
    }
}
