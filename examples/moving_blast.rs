//! A blast wave that moves outward over a rigid disc, in Rust and, if gfortran is installed, as a VDLOAD in Fortran.
//! Run with `cargo run --release --example moving_blast`.

use std::error::Error;
use std::path::Path;

use revolve::job;
use revolve::user::compile::compile;
use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

/// `p = peak (1 - s) exp(-decay s)`, s the time since arrival of the front over the positive phase (Friedlander's law).
pub struct Blast {
    peak: f64,
    speed: f64,
    duration: f64,
    decay: f64,
}

impl Default for Blast {
    fn default() -> Self {
        Blast { peak: 2e6, speed: 800.0, duration: 1e-3, decay: 1.5 }
    }
}

impl UserLoad for Blast {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        for (p, r) in pressure.iter_mut().zip(points.r) {
            let s = (points.now.total_time - r / self.speed) / self.duration;
            let inside = (0.0..1.0).contains(&s);
            *p = if inside { points.amplitude * self.peak * (1.0 - s) * (-self.decay * s).exp() } else { 0.0 };
        }
        Ok(())
    }
}

/// Returns the final displacement and velocity of the disc.
pub fn fly(routines: &Routines) -> Result<[f64; 2], Box<dyn Error>> {
    let deck = Path::new(env!("CARGO_MANIFEST_DIR")).join("input/blast_disk.inp");
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
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("input/vdload_blast.f");
    let compiled = compile(&[file], false).map_err(|faults| faults.render(&revolve::deck::Sources::default()))?;
    compiled.open().map_err(|fault| fault.message.into())
}

#[allow(dead_code)] // Tests call the functions only.
fn main() -> Result<(), Box<dyn Error>> {
    println!("in Rust:    u, v = {:?}", fly(&Routines::none().with_load(Blast::default()))?);
    match in_fortran() {
        Ok(routines) => println!("in Fortran: u, v = {:?}", fly(&routines)?),
        Err(reason) => println!("in Fortran: left out, {reason}"),
    }
    Ok(())
}
