//! A user-defined material law: Voce hardening in Rust, registered under the name of its material. A tube of one element is
//! stretched along z at fixed radii; the plastic strain is compared with the closed form. `cargo run --release --example own_material`.

use std::error::Error;

use revolve::job;
use revolve::user::{ElasticModuli, LoadFailure, MaterialLaw, MaterialPoint, Routines};

/// Von Mises plasticity with the yield stress `s0 + q (1 - exp(-b p))` (Voce 1948, J. Inst. Met. 74, 537). Constants: Young's
/// modulus, Poisson's ratio, s0, q, b. State variable 1: equivalent plastic strain p.
pub struct Voce;

fn yield_stress(constants: &[f64], p: f64) -> f64 {
    constants[2] + constants[3] * (1.0 - (-constants[4] * p).exp())
}

impl MaterialLaw for Voce {
    fn moduli(&self, constants: &[f64]) -> Result<ElasticModuli, LoadFailure> {
        let &[young, ratio, _, _, _] = constants else { return Err(LoadFailure::new("constants: E, nu, s0, q, b")) };
        Ok(ElasticModuli::from_young(young, ratio))
    }

    fn state_variables(&self) -> usize {
        1
    }

    /// Returns the stress by radial return; Newton's method starts below the root of a convex function and converges.
    fn update(&self, point: &mut MaterialPoint<'_>) {
        let ElasticModuli { bulk, shear } = ElasticModuli::from_young(point.constants[0], point.constants[1]);
        let dilation = point.strain[0] + point.strain[1] + point.strain[2];
        let old = point.stress;
        let mean = (old[0] + old[1] + old[2]) / 3.0;
        let volumetric = |i: usize, value: f64| if i < 3 { value } else { 0.0 };
        let trial = [0, 1, 2, 3]
            .map(|i| old[i] - volumetric(i, mean) + 2.0 * shear * (point.strain[i] - volumetric(i, dilation / 3.0)));
        let [rr, zz, hoop, rz] = trial.map(|s| s * s);
        let mises = (1.5 * (rr + zz + hoop) + 3.0 * rz).sqrt();
        let (p, mut dp) = (point.state[0], 0.0);
        for _ in 0..30 {
            let hardening = point.constants[3] * point.constants[4] * (-point.constants[4] * (p + dp)).exp();
            let excess = mises - 3.0 * shear * dp - yield_stress(point.constants, p + dp);
            dp += excess.max(0.0) / (3.0 * shear + hardening);
        }
        let factor = if dp > 0.0 { 1.0 - 3.0 * shear * dp / mises } else { 1.0 };
        point.stress = [0, 1, 2, 3].map(|i| factor * trial[i] + volumetric(i, mean + bulk * dilation));
        point.state[0] = p + dp;
        if dp > 0.0 {
            // The work of the mean of previous and new stress; the plastic strain increment is 3/2 dp trial/mises.
            let part = |i: usize| (old[i] + point.stress[i]) * trial[i];
            point.dissipated = 0.75 * dp / mises * (part(0) + part(1) + part(2) + 2.0 * part(3));
        }
    }
}

const DECK: &str = "
*Node
 1, 1., 0.
 2, 2., 0.
 3, 2., 1.
 4, 1., 1.
*Nset, nset=ALL
 1, 2, 3, 4
*Nset, nset=TOP
 3, 4
*Nset, nset=FOOT
 1, 2
*Element, type=CAX4R, elset=TUBE
 1, 1, 2, 3, 4
*Solid Section, elset=TUBE, material=VOCE
*Material, name=VOCE
*Density
 7850.,
*User Material, constants=5
 210.e9, 0.3, 300.e6, 200.e6, 8.
*Depvar
 1,
*Step
*Dynamic, Explicit, direct user control
 1.e-6, 1.e-3
*Boundary, type=VELOCITY
 ALL, 1, 1, 0.
 FOOT, 2, 2, 0.
 TOP, 2, 2, 500.
*Output, history, number interval=10
*Element Output, elset=TUBE
 SDV1
*End Step
";

/// Returns the plastic strain p at the end of the run, and that of the closed form: the strain ln(1.5) along z has the
/// equivalent deviatoric strain 2/3 ln(1.5), and the stress `3 G (2/3 ln 1.5 - p)` is the yield stress at p.
pub fn plastic_strains() -> Result<[f64; 2], Box<dyn Error>> {
    let prepared = job::prepare_text("tube.inp", DECK, &[], &Routines::none().with_law("VOCE", Voce));
    if prepared.diagnostics.has_errors() {
        return Err(prepared.diagnostics.render(&prepared.deck.sources).into());
    }
    let (outcome, history) = job::run_in_memory(&prepared);
    if let Some(halt) = outcome.halt {
        return Err(halt.reason.into());
    }
    let constants = [210e9, 0.3, 300e6, 200e6, 8.0];
    let shear3 = 3.0 * ElasticModuli::from_young(constants[0], constants[1]).shear;
    let strain = 2.0 / 3.0 * 1.5_f64.ln();
    let exact = (0..50).fold(strain, |p, _| strain - yield_stress(&constants, p) / shear3);
    Ok([history.0["SDV1@TUBE"].last, exact])
}

#[allow(dead_code)] // Tests call the functions only.
fn main() -> Result<(), Box<dyn Error>> {
    let [p, exact] = plastic_strains()?;
    println!("plastic strain {p:.9}, closed form {exact:.9}");
    Ok(())
}
