//! An equation of state in Rust: a stiffened gas, which describes water. A tube of one element is compressed along z at fixed
//! radii; its pressure is compared with the isentrope. `cargo run --release --example own_eos`.

use std::error::Error;

use revolve::job;
use revolve::user::{EosLaw, EosResponse, LoadFailure, Routines};

/// `p = (gamma - 1) rho e - gamma q`. Constants: ratio of heat capacities gamma, stiffness q (a pressure).
pub struct StiffenedGas;

impl EosLaw for StiffenedGas {
    fn respond(&self, constants: &[f64], density: f64, energy: f64) -> EosResponse {
        let (gamma, stiffness) = (constants[0], constants[1]);
        let pressure = (gamma - 1.0) * density * energy - gamma * stiffness;
        EosResponse { pressure, sound_speed: (gamma * (pressure + stiffness) / density).sqrt() }
    }

    fn check(&self, constants: &[f64]) -> Result<(), LoadFailure> {
        match constants {
            [gamma, stiffness] if *gamma > 1.0 && *stiffness >= 0.0 => Ok(()),
            _ => Err(LoadFailure::new("constants: gamma above 1, stiffness")),
        }
    }
}

const GAMMA: f64 = 4.4;
const STIFFNESS: f64 = 6e8;
const DENSITY: f64 = 1000.0;

/// Returns the deck: without pressure the specific energy is `gamma q / ((gamma - 1) rho)`.
fn deck() -> String {
    let energy = GAMMA * STIFFNESS / ((GAMMA - 1.0) * DENSITY);
    format!(
        "*Node\n 1, 1., 0.\n 2, 2., 0.\n 3, 2., 1.\n 4, 1., 1.\n*Nset, nset=ALL\n 1, 2, 3, 4\n*Nset, nset=TOP\n 3, 4
*Nset, nset=FOOT\n 1, 2\n*Element, type=CAX4R, elset=TUBE\n 1, 1, 2, 3, 4\n*Solid Section, elset=TUBE, material=WATER
*Material, name=WATER\n*Density\n {DENSITY},\n*Eos, type=USER, properties=2\n {GAMMA}, {STIFFNESS}
*Initial Conditions, type=SPECIFIC ENERGY\n TUBE, {energy}\n*Step\n*Dynamic, Explicit, direct user control\n 1.e-6, 1.e-3
*Bulk Viscosity\n 0., 0.\n*Boundary, type=VELOCITY\n ALL, 1, 1, 0.\n FOOT, 2, 2, 0.\n TOP, 2, 2, -200.
*Output, history, number interval=10\n*Element Output, elset=TUBE\n S22\n*End Step\n"
    )
}

/// Returns the pressure at the end and that of the isentrope, on which `(p + q) / rho^gamma` is constant. The tube is
/// compressed to 0.8 of its volume.
pub fn pressures() -> Result<[f64; 2], Box<dyn Error>> {
    let routines = Routines::none().with_eos("WATER", StiffenedGas);
    let history = job::run_to_end(&job::prepare_text("tube.inp", &deck(), &[], &routines))?;
    Ok([-history.0["S22@TUBE"].last, STIFFNESS * (0.8_f64.powf(-GAMMA) - 1.0)])
}

#[allow(dead_code)] // Tests call the functions only.
fn main() -> Result<(), Box<dyn Error>> {
    let [pressure, exact] = pressures()?;
    println!("pressure {pressure:.6e}, isentrope {exact:.6e}");
    if (pressure / exact - 1.0).abs() < 1e-6 { Ok(()) } else { Err("the pressures differ".into()) }
}
