//! A user load in Rust: the resistance of dynamic cavity expansion, as in a VDLOAD, with the deck `input/ogive.inp`.
//! Run with `cargo run --release --example cavity_user_load`; it prints its depth and that of the built-in load.

use std::path::Path;

use revolve::job;
use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

/// `sigma_n = Y (A + C x^2)`, `x = v_n sqrt(rho / Y)`, on every point that moves into the target.
struct Cavity {
    yield_stress: f64,
    density: f64,
    a: f64,
    c: f64,
}

impl UserLoad for Cavity {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        for (i, p) in pressure.iter_mut().enumerate() {
            let v_n = points.velocity_r[i] * points.normal_r[i] + points.velocity_z[i] * points.normal_z[i];
            *p = if v_n > 0.0 { self.a * self.yield_stress + self.c * self.density * v_n * v_n } else { 0.0 };
        }
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("input/ogive.inp");
    // The user load has no target surface, so both shots start with an embedded nose.
    let text = std::fs::read_to_string(&path)?.replace("front = 0.", "front = 0.1");
    let own = text.replace("*Dsload, target=BLOCK, friction=<friction>\n NOSE, CAVITY", "*Dsload\n NOSE, PNU");
    let routine = Routines::none().with_load(Cavity { yield_stress: 276e6, density: 2710.0, a: 5.0394, c: 0.9830 });
    for (name, deck, routine) in [("built-in CAVITY", text, &Routines::none()), ("user load", own, &routine)] {
        let prepared = job::prepare_text("ogive.inp", &deck, &[], routine);
        if prepared.diagnostics.has_errors() {
            return Err(prepared.diagnostics.render(&prepared.deck.sources).into());
        }
        let (outcome, history) = job::run_in_memory(&prepared);
        println!("{name}: depth {:.9} mm, {} increments", -1e3 * history.0["U2@REF"].last, outcome.increments);
    }
    Ok(())
}
