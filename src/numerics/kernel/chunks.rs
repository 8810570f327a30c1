//! Loops over long lists, of nodes, elements or edges, in chunks of fixed size: compiled for the instruction set of the run
//! and distributed over threads. Results do not depend on the number of threads.

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// Number of items from which loops use several threads.
const PARALLEL: usize = 1000;
/// Items of a chunk.
pub const CHUNK: usize = 512;

/// Number of nodes that are updated or skipped together, a part of a chunk.
pub const FEW: usize = 32;

/// Returns the number of chunks of a list.
pub fn chunks_of(items: usize) -> usize {
    items.div_ceil(CHUNK)
}

/// Instruction set and threads of loops. Closures, and functions that they call, must be marked `#[inline(always)]` to be
/// compiled for this instruction set; others are compiled for the base set.
#[derive(Clone, Copy, Debug)]
pub struct ChunkLoops {
    pub arch: Arch,
    /// Whether loops are distributed over the threads of the current pool.
    pub threads: bool,
}

impl ChunkLoops {
    /// Creates loops on all threads of the current pool.
    pub fn new(arch: Arch) -> ChunkLoops {
        ChunkLoops { arch, threads: rayon::current_num_threads() > 1 }
    }

    /// Calls `of_chunk` with the index of the first item of each chunk, and the chunk.
    pub fn each<T: Send>(&self, list: &mut [T], of_chunk: impl Fn(usize, &mut [T]) + Sync) {
        let chunk = |(index, items)| self.run(index, items, &of_chunk);
        if self.uses_threads(list) {
            list.par_chunks_mut(CHUNK).enumerate().for_each(chunk);
        } else {
            list.chunks_mut(CHUNK).enumerate().for_each(chunk);
        }
    }

    /// Calls `of_chunk` as [`Self::each`] does. Returns the sum of its values in the order of the chunks; `parts` is a work
    /// array with one entry for each chunk.
    pub fn sum<T: Send>(
        &self,
        list: &mut [T],
        parts: &mut [f64],
        of_chunk: impl Fn(usize, &mut [T]) -> f64 + Sync,
    ) -> f64 {
        let chunk = |(index, (items, part)): (usize, (&mut [T], &mut f64))| *part = self.run(index, items, &of_chunk);
        if self.uses_threads(list) {
            list.par_chunks_mut(CHUNK).zip(&mut *parts).enumerate().for_each(chunk);
        } else {
            list.chunks_mut(CHUNK).zip(&mut *parts).enumerate().for_each(chunk);
        }
        parts.iter().sum()
    }

    /// Calls `of_chunk` as [`Self::each`] does, and combines its results. `combine` must not depend on the order.
    pub fn combined<T: Send, R: Send + Sync + Copy>(
        &self,
        list: &mut [T],
        (start, combine): (R, impl Fn(R, R) -> R + Sync + Send),
        of_chunk: impl Fn(usize, &mut [T]) -> R + Sync,
    ) -> R {
        let chunk = |(index, items)| self.run(index, items, &of_chunk);
        if self.uses_threads(list) {
            list.par_chunks_mut(CHUNK).enumerate().map(chunk).reduce(|| start, combine)
        } else {
            list.chunks_mut(CHUNK).enumerate().map(chunk).fold(start, combine)
        }
    }

    fn run<T, R>(&self, index: usize, items: &mut [T], of_chunk: &impl Fn(usize, &mut [T]) -> R) -> R {
        self.arch.dispatch(ChunkCall { first: index * CHUNK, items, of_chunk })
    }

    fn uses_threads<T>(&self, list: &[T]) -> bool {
        self.threads && list.len() >= PARALLEL
    }
}

/// The call for a chunk.
struct ChunkCall<'a, T, F> {
    first: usize,
    items: &'a mut [T],
    of_chunk: &'a F,
}

impl<T, R, F: Fn(usize, &mut [T]) -> R> WithSimd for ChunkCall<'_, T, F> {
    type Output = R;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> R {
        (self.of_chunk)(self.first, self.items)
    }
}
