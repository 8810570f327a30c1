//! Three loads as closures in Rust and, if gfortran is installed, as VDLOADs in Fortran: they give the same bits.
//! `cargo run --release --example rust_and_fortran`.

use std::error::Error;
use std::path::Path;

use revolve::job;
use revolve::user::Routines;
use revolve::user::compile::compile;

/// A load in both languages, on a rigid body.
pub struct Twin {
    pub name: &'static str,
    deck: &'static str,
    fortran: &'static str,
    pub in_rust: fn() -> Routines,
}

pub const TWINS: [Twin; 3] = [
    Twin { name: "moving blast", deck: "blast_disk.inp", fortran: "vdload_blast.f", in_rust: blast },
    Twin { name: "table", deck: "ogive_user.inp", fortran: "vdload_table.f90", in_rust: table },
    Twin { name: "crushed bed", deck: "ogive_user.inp", fortran: "vdload_state.f", in_rust: bed },
];

/// A blast wave that moves outward at 800 m/s: `p = peak (1 - s) exp(-1.5 s)`, s the time since arrival over the positive phase
/// of 1 ms (Friedlander's law).
fn blast() -> Routines {
    Routines::none().with_pressure(|points, i| {
        let s = (points.now.total_time - points.r[i] / 800.0) / 1e-3;
        if (0.0..1.0).contains(&s) { points.amplitude * 2e6 * (1.0 - s) * (-1.5 * s).exp() } else { 0.0 }
    })
}

/// A target in z < 0 with a table of strength over depth: `p = strength + 0.983 rho v_n^2` on surfaces that move into it.
fn table() -> Routines {
    const TABLE: [[f64; 2]; 4] = [[0.0, 0.4e9], [0.01, 1.2e9], [0.03, 1.4e9], [0.2, 1.4e9]];
    Routines::none().with_pressure(|points, i| {
        let vn = points.velocity_r[i] * points.normal_r[i] + points.velocity_z[i] * points.normal_z[i];
        let depth = -points.z[i];
        let slope = |w: &[[f64; 2]]| w[0][1] + (w[1][1] - w[0][1]) * ((depth - w[0][0]) / (w[1][0] - w[0][0]));
        let strength = TABLE.windows(2).find(|w| depth < w[1][0]).map_or(TABLE[3][1], slope);
        let is_met = vn > 0.0 && points.z[i] < 0.0;
        if is_met { points.amplitude * (strength + 0.983 * 2710.0 * vn * vn) } else { 0.0 }
    })
}

/// A bed with a hundredth of its strength where a point has been before. Its depths are lost in a restart, unlike those of
/// `own_load.rs`.
fn bed() -> Routines {
    let mut deepest = Vec::new();
    Routines::none().with_pressure(move |points, i| {
        deepest.resize(points.z.len(), 0.0);
        let (z, is_new) = (points.z[i], points.z[i] < deepest[i]);
        deepest[i] = z.min(deepest[i]);
        let strength = points.amplitude * 1.2e9;
        if z >= 0.0 { 0.0 } else { strength * if is_new { 1.0 } else { 0.01 } }
    })
}

impl Twin {
    /// Returns the final displacement and velocity of the body.
    pub fn fly(&self, routines: &Routines) -> Result<[f64; 2], Box<dyn Error>> {
        let deck = Path::new(env!("CARGO_MANIFEST_DIR")).join("input").join(self.deck);
        let history = job::run_to_end(&job::prepare(&deck, &[], routines))?;
        Ok(["U2@REF", "V2@REF"].map(|name| history.0[name].last))
    }

    /// Returns the load in Fortran.
    pub fn in_fortran(&self) -> Result<Routines, Box<dyn Error>> {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("input").join(self.fortran);
        let compiled = compile(&[file], false).map_err(|faults| faults.render(&revolve::deck::Sources::default()))?;
        compiled.open().map_err(|fault| fault.message.into())
    }
}

#[allow(dead_code)] // Tests call the functions only.
fn main() -> Result<(), Box<dyn Error>> {
    for twin in &TWINS {
        println!("{} in Rust: u, v = {:?}", twin.name, twin.fly(&(twin.in_rust)())?);
        match twin.in_fortran() {
            Ok(routines) => println!("{} in Fortran: u, v = {:?}", twin.name, twin.fly(&routines)?),
            Err(reason) => println!("in Fortran: left out, {reason}"),
        }
    }
    Ok(())
}
