//! Loops over lists of nodes in chunks of fixed size, compiled for the instruction set of the run and distributed over the
//! threads of the current pool. Results do not depend on the number of threads.

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

/// Number of items from which loops use several threads.
const PARALLEL: usize = 1000;
/// Items of a chunk.
const CHUNK: usize = 512;

/// Returns the number of chunks of a list.
pub fn chunks_of(items: usize) -> usize {
    items.div_ceil(CHUNK)
}

/// Calls `of_chunk` with the index of the first item of each chunk, and the chunk. Returns the sum of its values in the
/// order of the chunks; `parts` is a work array with one entry for each chunk. The closure, and functions that it calls,
/// must be marked `#[inline(always)]`: functions that are not inlined are compiled for the base instruction set.
pub fn sum_of_chunks<T: Send>(
    arch: Arch,
    list: &mut [T],
    parts: &mut [f64],
    of_chunk: impl Fn(usize, &mut [T]) -> f64 + Sync,
) -> f64 {
    let chunk = |(index, (items, part)): (usize, (&mut [T], &mut f64))| {
        *part = arch.dispatch(ChunkLoop { first: index * CHUNK, items, of_chunk: &of_chunk });
    };
    if uses_threads(list) {
        list.par_chunks_mut(CHUNK).zip(&mut *parts).enumerate().for_each(chunk);
    } else {
        list.chunks_mut(CHUNK).zip(&mut *parts).enumerate().for_each(chunk);
    }
    parts.iter().sum()
}

/// Calls `of_chunk` as [`sum_of_chunks`] does, without a sum.
pub fn for_chunks<T: Send>(arch: Arch, list: &mut [T], of_chunk: impl Fn(usize, &mut [T]) + Sync) {
    let chunk = |(index, items): (usize, &mut [T])| {
        arch.dispatch(ChunkLoop { first: index * CHUNK, items, of_chunk: &of_chunk });
    };
    if uses_threads(list) {
        list.par_chunks_mut(CHUNK).enumerate().for_each(chunk);
    } else {
        list.chunks_mut(CHUNK).enumerate().for_each(chunk);
    }
}

fn uses_threads<T>(list: &[T]) -> bool {
    list.len() >= PARALLEL && rayon::current_num_threads() > 1
}

/// The loop over a chunk.
struct ChunkLoop<'a, T, F> {
    first: usize,
    items: &'a mut [T],
    of_chunk: &'a F,
}

impl<T, R, F: Fn(usize, &mut [T]) -> R> WithSimd for ChunkLoop<'_, T, F> {
    type Output = R;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> R {
        (self.of_chunk)(self.first, self.items)
    }
}
