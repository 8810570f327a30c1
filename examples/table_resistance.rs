//! A target with a table of strength over depth, in Rust and, if gfortran is installed, as a VDLOAD in free form.
//! Run with `cargo run --release --example table_resistance`.

use std::error::Error;
use std::path::Path;

use revolve::job;
use revolve::user::compile::compile;
use revolve::user::{LoadFailure, LoadPoints, Routines, UserLoad};

/// Depth and strength; linear between the rows, constant after the last.
const TABLE: [[f64; 2]; 4] = [[0.0, 0.4e9], [0.01, 1.2e9], [0.03, 1.4e9], [0.2, 1.4e9]];

/// `p = strength(depth) + factor v_n^2` where the surface moves into the target, which occupies z < 0.
pub struct Table;

fn strength(depth: f64) -> f64 {
    let row = TABLE.windows(2).find(|w| depth < w[1][0]);
    row.map_or(TABLE[TABLE.len() - 1][1], |w| w[0][1] + (w[1][1] - w[0][1]) * ((depth - w[0][0]) / (w[1][0] - w[0][0])))
}

impl UserLoad for Table {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        let factor = 0.983 * 2710.0;
        for (k, p) in pressure.iter_mut().enumerate() {
            let vn = points.velocity_r[k] * points.normal_r[k] + points.velocity_z[k] * points.normal_z[k];
            let inside = vn > 0.0 && points.z[k] < 0.0;
            *p = if inside { points.amplitude * (strength(-points.z[k]) + factor * vn * vn) } else { 0.0 };
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
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("input/vdload_table.f90");
    let compiled = compile(&[file], false).map_err(|faults| faults.render(&revolve::deck::Sources::default()))?;
    compiled.open().map_err(|fault| fault.message.into())
}

#[allow(dead_code)] // Tests call the functions only.
fn main() -> Result<(), Box<dyn Error>> {
    println!("in Rust:    u, v = {:?}", fly(&Routines::none().with_load(Table))?);
    match in_fortran() {
        Ok(routines) => println!("in Fortran: u, v = {:?}", fly(&routines)?),
        Err(reason) => println!("in Fortran: left out, {reason}"),
    }
    Ok(())
}
