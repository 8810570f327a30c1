//! A hardening law and a load that several tests run.

use revolve::internals::plasticity::{FlowUpdate, HardeningLaw};
use revolve::user::{LoadFailure, LoadPoints, UserLoad};

/// Hardening law without plasticity, whose update must not be called.
pub struct NoPlasticity;

impl HardeningLaw for NoPlasticity {
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

/// Resistance of `input/vdload_cavity.f` in Rust, with the same order of operations.
pub struct CavityResistance;

impl UserLoad for CavityResistance {
    fn pressure(&mut self, points: &LoadPoints<'_>, pressure: &mut [f64]) -> Result<(), LoadFailure> {
        for (k, p) in pressure.iter_mut().enumerate() {
            let vn = points.velocity_r[k] * points.normal_r[k] + points.velocity_z[k] * points.normal_z[k];
            *p = if vn > 0.0 { points.amplitude * (5.0394 * 276e6 + 0.983 * 2710.0 * vn * vn) } else { 0.0 };
        }
        Ok(())
    }
}
