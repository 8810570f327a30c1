//! Diagnostic codes of cavity expansion (`C…`), for `revolve explain`.

use crate::codes;
use crate::codes::DiagnosticCode;

/// Diagnostic codes C001 to C006 with their titles and explanations.
pub const CODES: &[DiagnosticCode] = codes! {
    "C001" "invalid target material" "The target needs Young's modulus, density and yield stress above zero, Poisson's ratio from 0 to 0.5, and a yield stress below twice the shear modulus (below 1.73 times for a cylindrical cavity, which also needs a Poisson's ratio below 0.5 and no tensile strength). The stress-strain curve must begin at the yield stress and plastic strain 0, with increasing plastic strains."
    "C002" "cavity velocity above the range of the similarity solution" "The similarity solution is valid if the plastic front is slower than the plastic wave, sqrt(K/rho); at higher velocities the front is a shock. The message states the largest velocity with a solution: reduce the upper end of the velocity range to it."
    "C003" "invalid velocity range or number of points" "The fit needs velocities of at least zero, an upper velocity above the lower one, and 5 to 100000 points."
    "C004" "integration of the plastic zone failed" "The plastic zone could not be integrated to the cavity wall: the stress-strain curve decreases too steeply, the strength increases too fast with pressure, or the pressure exceeds the bulk modulus, where the linear compression law ends."
    "C005" "no fit with constants of at least zero" "A, B and C of *CAVITY EXPANSION must not be negative, but the least-squares fit with this restriction failed. Use a different velocity range or three constants (--terms 3)."
    "C006" "cavity pressure that depends on the step" "Cards of strength over pressure are integrated along the path of a material point. If the law loses its strength at once and without a length, as a ceramic that fractures, the fractured zone has no definite size and the pressure has no definite value: on a mesh it depends on the elements. Use velocities at which fracture follows the plastic front at once (raise the lowest velocity of the range), constants of fracture that soften less, or a measured resistance."
};
