//! A law and a load that several tests run.

use revolve::internals::plasticity::{FlowUpdate, HardeningLaw};
use revolve::user::{LoadFailure, LoadPoints, UserLoad};

/// A law without anything: what is called here would be noticed.
pub struct Bare;

impl HardeningLaw for Bare {
    type State = ();
    const PLASTIC: bool = false;

    fn fresh(&self) {}

    fn flow(&self, (): &mut (), _flow: &mut FlowUpdate<'_>) {
        unreachable!("nothing flows");
    }

    fn plastic_strain(&self, (): &(), _lane: usize) -> f64 {
        unreachable!("nothing flows")
    }
}

/// The seed paper's resistance in Rust, in the order of operations of `input/vdload_cavity.f`.
pub struct Cavity;

impl UserLoad for Cavity {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        for (k, p) in pressure.iter_mut().enumerate() {
            let vn = points.velocity_r[k] * points.normal_r[k] + points.velocity_z[k] * points.normal_z[k];
            *p = if vn > 0.0 { points.amplitude * (5.0394 * 276e6 + 0.983 * 2710.0 * vn * vn) } else { 0.0 };
        }
        Ok(())
    }
}
