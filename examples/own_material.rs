//! A material law in Rust: plasticity that softens as plastic work heats the material. A tube of one element is stretched along
//! z at fixed radii; its temperature is compared with the closed form. `cargo run --release --example own_material`.

use std::error::Error;

use revolve::job;
use revolve::user::{ElasticModuli, LoadFailure, MaterialLaw, MaterialPoint, PointQuantity, Routines};

/// Von Mises plasticity with the yield stress `s0 (1 - a T)`. Constants: Young's modulus, Poisson's ratio, s0, a. State
/// variable 1: equivalent plastic strain.
pub struct Softening;

impl MaterialLaw for Softening {
    fn moduli(&self, constants: &[f64]) -> Result<ElasticModuli, LoadFailure> {
        let &[young, ratio, _, _] = constants else { return Err(LoadFailure::new("constants: E, nu, s0, a")) };
        Ok(ElasticModuli::from_young(young, ratio))
    }

    fn state_variables(&self) -> usize {
        1
    }

    fn uses(&self) -> &'static [PointQuantity] {
        &[PointQuantity::Temperature]
    }

    /// Returns the trial stress to the yield surface along its deviator.
    fn update(&self, point: &mut MaterialPoint<'_>) {
        let ElasticModuli { bulk, shear } = ElasticModuli::from_young(point.constants[0], point.constants[1]);
        let trace = |t: [f64; 4]| t[0] + t[1] + t[2];
        let axes = [1.0, 1.0, 1.0, 0.0];
        let (stress_before, dilation) = (point.stress, trace(point.strain));
        let mean = trace(stress_before) / 3.0;
        let trial = [0, 1, 2, 3]
            .map(|i| stress_before[i] - mean * axes[i] + 2.0 * shear * (point.strain[i] - dilation / 3.0 * axes[i]));
        let dot = |a: [f64; 4], b: [f64; 4]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + 2.0 * a[3] * b[3];
        let mises = (1.5 * dot(trial, trial)).sqrt();
        let yield_stress = point.constants[2] * (1.0 - point.constants[3] * point.temperature);
        let flow = (mises - yield_stress).max(0.0) / (3.0 * shear);
        let factor = if flow > 0.0 { yield_stress / mises } else { 1.0 };
        point.stress = [0, 1, 2, 3].map(|i| factor * trial[i] + (mean + bulk * dilation) * axes[i]);
        point.state[0] += flow;
        if flow > 0.0 {
            // The mean of previous and new stress times the plastic strain increment, 3/2 flow trial / mises.
            point.dissipated = 0.75 * flow / mises * (dot(stress_before, trial) + dot(point.stress, trial));
        }
    }
}

const DECK: &str = "*Node\n 1, 1., 0.\n 2, 2., 0.\n 3, 2., 1.\n 4, 1., 1.\n*Nset, nset=ALL\n 1, 2, 3, 4\n*Nset, nset=TOP\n 3, 4
*Nset, nset=FOOT\n 1, 2\n*Element, type=CAX4R, elset=TUBE\n 1, 1, 2, 3, 4\n*Solid Section, elset=TUBE, material=STEEL
*Material, name=STEEL\n*Density\n 7850.,\n*User Material, constants=4\n 210.e9, 0.3, 600.e6, 2.e-3\n*Depvar\n 1,
*Specific Heat\n 460.,\n*Inelastic Heat Fraction\n 0.9,\n*Initial Conditions, type=TEMPERATURE\n ALL, 0.
*Step\n*Dynamic, Explicit, adiabatic, direct user control\n 1.e-6, 1.e-3\n*Boundary, type=VELOCITY\n ALL, 1, 1, 0.
 FOOT, 2, 2, 0.\n TOP, 2, 2, 500.\n*Output, history, number interval=10\n*Element Output, elset=TUBE\n SDV1, TEMP\n*End Step\n";

/// Returns the temperature at the end and that of the closed form. The strain ln(1.5) along z has the equivalent strain 2/3
/// ln(1.5), plastic strain p plus `s / 3G`. With `dT = 0.9 s dp / (rho c)` the yield stress s falls as `s0 exp(-rate p)`.
pub fn temperatures() -> Result<[f64; 2], Box<dyn Error>> {
    let prepared = job::prepare_text("tube.inp", DECK, &[], &Routines::none().with_law("STEEL", Softening));
    let history = job::run_to_end(&prepared)?;
    let (yield_stress, softening) = (600e6, 2e-3);
    let rate: f64 = 0.9 * yield_stress * softening / (7850.0 * 460.0);
    let (strain, shear) = (2.0 / 3.0 * 1.5_f64.ln(), ElasticModuli::from_young(210e9, 0.3).shear);
    let plastic = (0..50).fold(strain, |p, _| strain - yield_stress * (-rate * p).exp() / (3.0 * shear));
    Ok([history.0["TEMP@TUBE"].last, (1.0 - (-rate * plastic).exp()) / softening])
}

#[allow(dead_code)] // Tests call the functions only.
fn main() -> Result<(), Box<dyn Error>> {
    let [temperature, exact] = temperatures()?;
    println!("temperature {temperature:.4}, closed form {exact:.4}");
    if (temperature / exact - 1.0).abs() < 1e-4 { Ok(()) } else { Err("the temperatures differ".into()) }
}
