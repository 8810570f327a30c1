//! Stacks of the threads that may call user subroutines.

use crate::platform::memory_limit;

/// Stack size in bytes of each thread that may call user subroutines, which may have large local arrays.
pub const STACK: usize = 64 << 20;

/// Returns a builder of a pool of so many threads with stacks of [`STACK`] bytes.
pub fn thread_pool(threads: usize) -> rayon::ThreadPoolBuilder {
    rayon::ThreadPoolBuilder::new().stack_size(STACK).num_threads(threads)
}

/// Returns the message that so many threads cannot start, with the memory that their stacks reserve and the limit of memory.
pub fn thread_failure(threads: usize, error: &rayon::ThreadPoolBuildError) -> String {
    let limit = memory_limit()
        .map_or_else(String::new, |limit| format!("; {} is {:.0} MB", limit.name, 1e-6 * limit.bytes as f64));
    let stacks = 1e-6 * (threads * STACK) as f64;
    format!("cannot start {threads} threads, whose stacks reserve {stacks:.0} MB of memory{limit}: {error}")
}
