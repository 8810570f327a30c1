//! Roots of a function in all lanes of a block: secants, which converge in a few iterations after a tangent.

use crate::kernel::lanes::{LANES, Lanes};

/// Whether a property holds for each lane: 1 or 0, so that loops over lanes stay in vector registers.
pub type Flags = [u64; LANES];

/// Returns whether a flag is set.
#[inline(always)] // Into the update of a block, compiled for the instruction set of the machine.
pub fn any(flags: &Flags) -> bool {
    flags.iter().fold(0, |any, flag| any | flag) != 0
}

/// Most evaluations of the function.
const ROUNDS: usize = 10;

/// Where [`lane_roots`] starts.
#[derive(Clone, Copy)]
pub struct LaneStarts {
    /// Arguments, and the values there.
    pub start: Lanes,
    pub first: Lanes,
    /// First arguments to try.
    pub guess: Lanes,
    /// Arguments that a root does not reach, on the side of the guess.
    pub limit: Lanes,
    /// Values that are zero.
    pub tolerance: Lanes,
    /// Lanes with a root.
    pub open: Flags,
}

/// Returns the arguments at which a function of all lanes is zero within the tolerance, and flags of open lanes for which
/// none was found: secants that leave the way or do not reduce the value. The function is called last with the arguments that
/// are returned. No lane depends on another one.
#[inline(always)] // Into the update of a block, compiled for the instruction set of the machine.
pub fn lane_roots(
    LaneStarts { start, first, guess, limit, tolerance, open }: &LaneStarts,
    mut function: impl FnMut(&Lanes) -> Lanes,
) -> (Lanes, Flags) {
    let (mut last, mut last_value, mut next, mut active) = (*start, *first, *start, *open);
    let mut failed = [0; LANES];
    for l in 0..LANES {
        let is_on_way = (guess[l] - start[l]) * (limit[l] - guess[l]) > 0.0;
        failed[l] = active[l] & u64::from(!is_on_way);
        active[l] &= u64::from(is_on_way);
        next[l] = if active[l] == 1 { guess[l] } else { start[l] };
    }
    for _ in 0..ROUNDS {
        let value = function(&next);
        let mut remaining = 0;
        for l in 0..LANES {
            let is_root = value[l].abs() <= tolerance[l];
            let secant = next[l] - value[l] * (next[l] - last[l]) / (value[l] - last_value[l]);
            let is_on_way = (secant - start[l]) * (limit[l] - secant) > 0.0;
            let goes_on = u64::from(is_on_way) & u64::from(value[l].abs() < last_value[l].abs());
            let is_unfinished = active[l] & u64::from(!is_root);
            failed[l] |= is_unfinished & (1 - goes_on);
            active[l] = is_unfinished & goes_on;
            last[l] = if active[l] == 1 { next[l] } else { last[l] };
            last_value[l] = if active[l] == 1 { value[l] } else { last_value[l] };
            next[l] = if active[l] == 1 { secant } else { next[l] };
            remaining |= active[l];
        }
        if remaining == 0 {
            return (next, failed);
        }
    }
    for l in 0..LANES {
        failed[l] |= active[l];
    }
    (next, failed)
}
