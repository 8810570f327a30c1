//! Contribution of strain-rate dependence to the pressure on a cavity. It depends on the cavity radius, because rate
//! dependence breaks similarity.

use super::ResistanceError;
use super::integrate::{WALL, integrate};
use super::rate::StrainRateEffect;
use super::target::ScaledTarget;

/// Returns the increase of the pressure, divided by Y, due to the strain rates around a cavity that opens at
/// `velocity`. The motion is that of an incompressible target, v = V (a/r)^g (Warren and Forrestal 1998, Int. J. Solids
/// Struct. 35, 3737). With x = (a/r)^(g + 1) the strain rate is f (g + 1) V x / a, and the pressure increases by f times
/// the integral of the yield stress increase over ln x, from the wall to the front at x = Y / (f E). Equation (2.10).
pub fn gain(target: &ScaledTarget, rate: &StrainRateEffect, velocity: f64) -> Result<f64, ResistanceError> {
    if velocity == 0.0 {
        return Ok(0.0);
    }
    let deviator = target.shape.deviator();
    let strain = |q: f64| q / (deviator * target.young);
    let slope = |q: f64, _: &[f64; 1]| {
        let opened = -libm::expm1(-strain(q));
        let gain = rate.factor.gain(target.shape.divergence() * velocity / rate.radius * opened);
        [target.flow(q)[0] * gain * strain(q) * libm::exp(-strain(q)) / opened * deviator]
    };
    let front = -libm::log1p(-strain(1.0)) * deviator * target.young;
    let wall = WALL * deviator * target.young;
    integrate(&slope, [front, wall], target, [0.0]).map(|[gain]| gain)
}
