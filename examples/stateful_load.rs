//! A load with state: a bed that stays crushed where a point has been before. In Rust and, if gfortran is installed, as
//! a VDLOAD with SAVE. Run with `cargo run --release --example stateful_load`.

use std::error::Error;
use std::path::Path;

use revolve::job;
use revolve::user::compile::compile;
use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

/// A bed with full strength at new depths, and a hundredth where a point has been before.
#[derive(Default)]
pub struct Bed {
    deepest: Vec<f64>,
}

impl UserLoad for Bed {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        const STRENGTH: f64 = 1.2e9;
        self.deepest.resize(pressure.len(), 0.0);
        for ((p, &z), deepest) in pressure.iter_mut().zip(points.z).zip(&mut self.deepest) {
            *p = if z >= 0.0 {
                0.0
            } else if z < *deepest {
                *deepest = z;
                points.amplitude * STRENGTH
            } else {
                points.amplitude * STRENGTH * 0.01
            };
        }
        Ok(())
    }
}

/// Returns the final displacement and velocity of the projectile.
pub fn fly(routines: &Routines) -> Result<[f64; 2], Box<dyn Error>> {
    let deck = Path::new(env!("CARGO_MANIFEST_DIR")).join("input/ogive_user.inp");
    let prepared = job::prepare(&deck, &[], routines);
    if prepared.diagnostics.has_errors() {
        return Err(prepared.diagnostics.render(&prepared.deck.sources).into());
    }
    let (outcome, history) = job::run_in_memory(&prepared);
    match outcome.halt {
        Some(halt) => Err(halt.reason.into()),
        None => Ok(["U2@REF", "V2@REF"].map(|name| history.0[name].last)),
    }
}

/// Returns the same load in Fortran.
pub fn in_fortran() -> Result<Routines, Box<dyn Error>> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("input/vdload_state.f");
    let compiled = compile(&[file], false).map_err(|faults| faults.render(&revolve::deck::Sources::default()))?;
    compiled.open().map_err(|fault| fault.message.into())
}

#[allow(dead_code)] // Tests call the functions only.
fn main() -> Result<(), Box<dyn Error>> {
    println!("in Rust:    u, v = {:?}", fly(&Routines::none().with_load(Bed::default()))?);
    match in_fortran() {
        Ok(routines) => println!("in Fortran: u, v = {:?}", fly(&routines)?),
        Err(reason) => println!("in Fortran: left out, {reason}"),
    }
    Ok(())
}
