//! Derives of `Persist` (state of checkpoints) and `Memory` (heap memory) of `revolve-numerics`.
//!
//! Both visit all fields in the order of their declaration. Exceptions are listed by name in an attribute of the type:
//! `#[persist(fixed: a, b; derived: c)]`, `#[memory(uncounted: a)]`. A new field is therefore visited, or the code does not
//! compile until the type of the field has the trait or the field is listed.

#![forbid(unsafe_code)]

mod memory;
mod persist;
mod roles;

use proc_macro::TokenStream;
use syn::{DeriveInput, parse_macro_input};

/// Implements `Persist`. Documentation: `revolve_numerics::state::archive::Persist`.
#[proc_macro_derive(Persist, attributes(persist))]
pub fn derive_persist(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    persist::expand(input).unwrap_or_else(|error| error.into_compile_error()).into()
}

/// Implements `Memory`. Documentation: `revolve_numerics::kernel::lists::Memory`.
#[proc_macro_derive(Memory, attributes(memory))]
pub fn derive_memory(input: TokenStream) -> TokenStream {
    let input = parse_macro_input!(input as DeriveInput);
    memory::expand(input).unwrap_or_else(|error| error.into_compile_error()).into()
}
