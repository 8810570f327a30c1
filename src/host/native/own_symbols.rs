//! Symbols of the library that contains this code.
#![allow(unsafe_code)]

use std::ffi::{CStr, c_void};

/// Makes the symbols of the library that contains this code visible to libraries that are opened later: the host
/// routines that user subroutines call. Symbols of an executable are always visible.
///
/// # Errors
/// The loader's message.
pub fn show_symbols() -> Result<(), String> {
    let mut program = libc::Dl_info {
        dli_fname: std::ptr::null(),
        dli_fbase: std::ptr::null_mut(),
        dli_sname: std::ptr::null(),
        dli_saddr: std::ptr::null_mut(),
    };
    // SAFETY: an address of this library, and a valid Dl_info for the result.
    let is_known = unsafe { libc::dladdr(show_symbols as *const c_void, &mut program) };
    if is_known == 0 || program.dli_fname.is_null() {
        return Err("the loader does not know the file of this library".into());
    }
    // SAFETY: the library is already loaded, so no initialiser runs. It stays open.
    let opened = unsafe { libc::dlopen(program.dli_fname, libc::RTLD_NOW | libc::RTLD_NOLOAD | libc::RTLD_GLOBAL) };
    if !opened.is_null() {
        return Ok(());
    }
    // SAFETY: returns the loader's message or null.
    let words = unsafe { libc::dlerror() };
    if words.is_null() {
        return Err("the loader gives no reason".into());
    }
    // SAFETY: the message is null-terminated.
    Err(unsafe { CStr::from_ptr(words) }.to_string_lossy().into_owned())
}
