//! Diagnostic codes of the cavity's expansion (`C…`), for `revolve explain`.

use crate::deck::Code;

/// All codes of this folder.
pub const CODES: &[Code] = codes! {
    "C001" "target that cannot be" "A cavity expands in a target with Young's modulus, density and yield stress above zero, Poisson's ratio from 0 to 0.5, a yield stress below Young's modulus, and a stress-strain curve that begins at the yield stress and whose plastic strains ascend."
    "C002" "cavity faster than the plastic wave" "The similarity solution holds as long as the plastic front runs more slowly than the plastic wave, sqrt(K/rho); beyond, the front is a shock. The message names the velocity up to which there is a solution: end the range of the fit there."
    "C003" "range of velocities that gives no fit" "The fit needs an upper velocity above the lower one, neither below zero, and more points than it has constants."
    "C004" "expansion that cannot be followed" "The integration of the plastic zone came to no end: the stress-strain curve falls too steeply, the strength grows too fast with pressure, or the pressure passes the bulk modulus, where the linear law of volume ends."
    "C005" "constants that a card cannot have" "A, B and C of *CAVITY EXPANSION are not below zero, and no choice of those that are left fits. Fit another range, or three constants."
};
