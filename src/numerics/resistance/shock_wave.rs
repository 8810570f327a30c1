//! Shock that compresses a target at rest: the state after the jump, on the straight line through both states whose slope is the
//! square of the velocity of the front (Rayleigh line).

use crate::material::returns::law::StressReturn;
use crate::material::returns::path::LawPath;
use crate::material::returns::root::bracketed_root;

/// Increment of the logarithmic strain of the search.
const SEARCH: f64 = 0.01;
/// Largest compression, logarithmic strain.
const LIMIT: f64 = 3.0;
/// Smallest compression, from which the search starts.
const LEAST: f64 = 1e-6;
/// Accepted error of the stress, over the longitudinal modulus.
const BALANCE: f64 = 1e-13;

/// Returns a point after the shock whose front moves at `ratio` times the speed of elastic waves, and its radial strain; `None` if
/// the law does not stiffen enough. The strain is radial, so that the stress is -M ratio² (1 - exp(strain)) with the modulus M.
/// Equation (2.23).
pub fn shocked_point<'a>(law: &'a dyn StressReturn, length: f64, ratio: f64) -> Option<(LawPath<'a>, f64)> {
    let moduli = law.moduli();
    let modulus = moduli.bulk + 4.0 / 3.0 * moduli.shear;
    let after = |strain: f64| {
        let mut path = LawPath::new(law, length);
        path.advance([strain, 0.0, 0.0, 0.0], f64::INFINITY);
        path
    };
    // Positive where the law is softer than the line. An equation of state has no state beyond its largest compression.
    let softer = |strain: f64| {
        let value = after(strain).stress[0] / modulus - ratio * ratio * libm::expm1(strain);
        if value.is_nan() { -1.0 } else { value }
    };
    let mut soft = -LEAST;
    if softer(soft) <= 0.0 {
        return None;
    }
    while soft > -LIMIT {
        let next = soft - SEARCH;
        if softer(next) <= 0.0 {
            let strain = bracketed_root(soft, next, BALANCE, softer);
            return Some((after(strain), strain)).filter(|(path, _)| path.stress[0].is_finite());
        }
        soft = next;
    }
    None
}
