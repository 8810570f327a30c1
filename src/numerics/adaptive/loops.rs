//! Loops over the elements, edges and nodes of a domain: parts of fixed length, compiled for the instruction set of the
//! run and distributed over threads. Each entry of a list is computed from other lists only, so that results do not depend
//! on the number of threads.

use pulp::Arch;
use rayon::prelude::*;

/// Entries of one part.
const PART: usize = 512;

/// Instruction set and threads of loops over a domain.
#[derive(Clone, Copy, Debug)]
pub struct DomainLoops {
    pub arch: Arch,
    /// Whether loops are distributed over the threads of the current pool.
    pub threads: bool,
}

impl DomainLoops {
    /// Calls `compute` with the first index of each part of a list, and the part.
    pub(super) fn each<T: Send>(&self, list: &mut [T], compute: impl Fn(usize, &mut [T]) + Sync) {
        if self.threads && list.len() > PART {
            list.par_chunks_mut(PART).enumerate().for_each(|(i, part)| compute(PART * i, part));
        } else {
            list.chunks_mut(PART).enumerate().for_each(|(i, part)| compute(PART * i, part));
        }
    }

    /// Calls `compute` as [`Self::each`] does, and combines its results. `combine` must not depend on the order.
    pub(super) fn combined<T: Send, R: Send + Sync + Copy>(
        &self,
        list: &mut [T],
        (start, combine): (R, impl Fn(R, R) -> R + Sync + Send),
        compute: impl Fn(usize, &mut [T]) -> R + Sync,
    ) -> R {
        if self.threads && list.len() > PART {
            let parts = list.par_chunks_mut(PART).enumerate();
            parts.map(|(i, part)| compute(PART * i, part)).reduce(|| start, combine)
        } else {
            list.chunks_mut(PART).enumerate().fold(start, |sum, (i, part)| combine(sum, compute(PART * i, part)))
        }
    }
}
