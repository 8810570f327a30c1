//! Adaptive meshes.
//!
//! Goal: the same results as on meshes that follow the material, where these work; the force of upsetting. Source: runs
//! without the card. Tolerances are stated at each test.

use revolve::job;
use revolve::output::HistorySummary;
use revolve::solve::Outcome;
use revolve::user::Routines;

use crate::common;

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

/// Upsetting to a quarter of the height: the force on a coarse adaptive mesh is that on the mesh of twice the fineness
/// that follows the material, which works at this friction (2 %: the coarse mesh that follows the material is 3 % below).
#[test]
fn upsetting_needs_the_force_of_a_finer_mesh() {
    let deck = std::fs::read_to_string(common::project("input/upsetting.inp")).expect("the deck");
    let card = "*Adaptive Mesh, elset=BILLET, frequency=<every>\n";
    let follows = deck.replacen(card, "", 1).replace("ALLADV, ", "");
    let coarse = [("nr", "10"), ("nz", "15"), ("mu", "0.1")];
    let [(adapted, history), (_, reference)] = [run(&deck, &coarse), run(&follows, &[("mu", "0.1")])];
    assert_eq!(adapted.halt, None);
    let [force, expected] = [&history, &reference].map(|of| of.0["RF2@DIE"].last);
    println!("upsetting: force {force:e}, reference {expected:e}, drift {:.1e}", adapted.energy.drift);
    assert!((force / expected - 1.0).abs() < 0.02, "{force} {expected}");
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
