//! Integration through the plastic zone, from its front to the cavity, by the strain.

use differential_equations::ivp::IVP;
use differential_equations::methods::ExplicitRungeKutta;
use differential_equations::ode::ODE;

use super::ResistanceError;
use super::target::Target;

/// Difference of the logarithmic strains where the integration ends: the cavity's wall is exp(-36) nearer, below rounding.
pub const WALL: f64 = 36.0;
/// Relative and absolute error of a step.
const TOLERANCE: f64 = 1e-10;
/// Steps between two kinks; a smooth zone takes some twenty.
const STEPS: usize = 2000;
/// The first step that is tried, of ln q: between two kinks mostly the only one.
const FIRST: f64 = 0.3;

/// A slope between two kinks.
struct SmoothPiece<'a, F> {
    slope: &'a F,
    /// Values of q; the last one belongs to the next piece.
    ends: [f64; 2],
}

impl<const N: usize, F: Fn(f64, &[f64; N]) -> [f64; N]> ODE<f64, [f64; N]> for SmoothPiece<'_, F> {
    fn diff(&self, log_q: f64, y: &[f64; N], slope: &mut [f64; N]) {
        // Rounding must not reach across a kink.
        let q = libm::exp(log_q).clamp(self.ends[0], self.ends[1].next_down());
        *slope = (self.slope)(q, y);
    }
}

/// Integrates `dy / d ln q = slope(q, y)` between two values of q by Dormand and Prince, order 8, from kink to kink.
pub fn integrate<const N: usize>(
    slope: &impl Fn(f64, &[f64; N]) -> [f64; N],
    [from, to]: [f64; 2],
    target: &Target,
    mut y: [f64; N],
) -> Result<[f64; N], ResistanceError> {
    let mut at = from;
    for next in target.kinks([from, to]).chain([to]) {
        let ends = [libm::log(at), libm::log(next)];
        // Nothing happens within the rounding of a strain.
        if ends[1] - ends[0] < 1e-13 {
            continue;
        }
        let first = FIRST.min(ends[1] - ends[0]);
        let method = ExplicitRungeKutta::dop853().h0(first).rtol(TOLERANCE).atol(TOLERANCE).max_steps(STEPS);
        let lost = |why: &str| {
            let [from, to] = [at, next].map(|q| q / target.young);
            ResistanceError::Lost(format!("{why} between the strains {from:.3e} and {to:.3e}"))
        };
        let piece = SmoothPiece { slope, ends: [at, next] };
        let solved = IVP::ode(&piece, ends[0], ends[1], y).method(method).solve();
        let solution = solved.map_err(|_| lost("no step is small enough"))?;
        y = *solution.y.last().ok_or_else(|| lost("nothing is integrated"))?;
        if y.iter().any(|v| !v.is_finite()) {
            return Err(lost("the stress has no value"));
        }
        at = next;
    }
    Ok(y)
}
