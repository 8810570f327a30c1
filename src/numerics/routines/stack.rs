//! Stacks of the threads that may call user subroutines.

/// Stack size in bytes of each thread that may call user subroutines, which may have large local arrays.
pub const STACK: usize = 64 << 20;

/// Returns a builder of a pool of so many threads with stacks of [`STACK`] bytes.
pub fn thread_pool(threads: usize) -> rayon::ThreadPoolBuilder {
    rayon::ThreadPoolBuilder::new().stack_size(STACK).num_threads(threads)
}
