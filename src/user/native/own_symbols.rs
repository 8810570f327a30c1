//! The symbols of the library that this code is part of.
//! Never here: opening the user's files.
#![allow(unsafe_code)]

use std::ffi::{CStr, c_void};

/// Makes the symbols of the library that this code is part of visible to libraries that are opened later: the host routines that
/// user subroutines call. Those of a program are visible from its start.
///
/// # Errors
/// In the loader's words.
pub fn show_symbols() -> Result<(), String> {
    let mut own = libc::Dl_info {
        dli_fname: std::ptr::null(),
        dli_fbase: std::ptr::null_mut(),
        dli_sname: std::ptr::null(),
        dli_saddr: std::ptr::null_mut(),
    };
    // SAFETY: an address of this library, and room for what is known of it.
    let found = unsafe { libc::dladdr(show_symbols as *const c_void, &mut own) };
    if found == 0 || own.dli_fname.is_null() {
        return Err("the loader does not know the file of this library".into());
    }
    // SAFETY: the file of a library that is there; nothing is loaded, and so no initialiser runs. It stays open.
    let opened = unsafe { libc::dlopen(own.dli_fname, libc::RTLD_NOW | libc::RTLD_NOLOAD | libc::RTLD_GLOBAL) };
    if !opened.is_null() {
        return Ok(());
    }
    // SAFETY: the loader's words, or null.
    let words = unsafe { libc::dlerror() };
    if words.is_null() {
        return Err("the loader gives no reason".into());
    }
    // SAFETY: a text that ends in a zero.
    Err(unsafe { CStr::from_ptr(words) }.to_string_lossy().into_owned())
}
