//! Integration through the plastic zone, from its front to the cavity, by the strain.
//! Never here: what is integrated.

use differential_equations::ivp::IVP;
use differential_equations::methods::ExplicitRungeKutta;
use differential_equations::ode::ODE;

use super::Fault;
use super::target::Target;

/// Difference of the logarithmic strains where the integration ends: the cavity's wall is exp(-36) nearer, below rounding.
pub const WALL: f64 = 36.0;
/// Relative and absolute error of a step.
const TOLERANCE: f64 = 1e-10;
/// Steps between two kinks; a smooth zone takes some twenty.
const STEPS: usize = 2000;
/// The first step that is tried, of ln q: between two kinks mostly the only one.
const FIRST: f64 = 0.3;

struct System<'a, F>(&'a F);

impl<const N: usize, F: Fn(f64, &[f64; N]) -> [f64; N]> ODE<f64, [f64; N]> for System<'_, F> {
    fn diff(&self, t: f64, y: &[f64; N], dydt: &mut [f64; N]) {
        *dydt = (self.0)(t, y);
    }
}

/// What `y' = slope(ln q, y)` comes to between two values of q, step by step of Dormand and Prince's order 8, from kink to kink
/// of the target's curve.
pub fn integrate<const N: usize>(
    slope: &impl Fn(f64, &[f64; N]) -> [f64; N],
    [from, to]: [f64; 2],
    target: &Target,
    mut y: [f64; N],
) -> Result<[f64; N], Fault> {
    let mut at = libm::log(from);
    for q in target.kinks([from, to]).chain([to]) {
        let next = libm::log(q);
        // Nothing happens within the rounding of a strain.
        if next - at < 1e-13 {
            continue;
        }
        let method =
            ExplicitRungeKutta::dop853().h0(FIRST.min(next - at)).rtol(TOLERANCE).atol(TOLERANCE).max_steps(STEPS);
        let lost = |why: &str| {
            Fault::Lost(format!(
                "{why} between the strains {:.3e} and {:.3e}",
                strain(at, target),
                strain(next, target)
            ))
        };
        let solution = IVP::ode(&System(slope), at, next, y)
            .method(method)
            .solve()
            .map_err(|_| lost("no step is small enough"))?;
        y = *solution.y.last().ok_or_else(|| lost("nothing"))?;
        if y.iter().any(|v| !v.is_finite()) {
            return Err(lost("the stress has no value"));
        }
        at = next;
    }
    Ok(y)
}

fn strain(log_q: f64, target: &Target) -> f64 {
    libm::exp(log_q) / target.young
}
