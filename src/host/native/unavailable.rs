//! Replacement of `native` on platforms other than Linux with the GNU C library, where compiled user subroutines are
//! not available. User subroutines in Rust and functions given by address work on all platforms.

/// Compilation of user files, which always fails.
pub mod compile {
    use std::path::PathBuf;

    use crate::Routines;
    use revolve_diagnostics::{Diagnostic, Diagnostics};

    /// Compiled user subroutines, which do not exist on this platform.
    #[derive(Debug)]
    pub struct Compiled {
        /// Notes for the user.
        pub notes: Diagnostics,
    }

    impl Compiled {
        /// Returns the hashes of the libraries.
        pub fn identity(&self) -> String {
            String::new()
        }

        /// Opens the libraries.
        ///
        /// # Errors
        /// Always: U013.
        pub fn open(&self) -> Result<Routines, Diagnostic> {
            Err(unavailable())
        }

        /// Opens the libraries in a separate process.
        ///
        /// # Errors
        /// Always: U013.
        pub fn open_isolated(&self) -> Result<Routines, Diagnostic> {
            self.open()
        }

        /// Opens the libraries, if there are any.
        ///
        /// # Errors
        /// U013 if there are any.
        pub fn open_any(compiled: Option<&Compiled>) -> Result<Routines, Diagnostic> {
            compiled.map_or(Ok(Routines::none()), Compiled::open)
        }
    }

    /// Rejects the user's files.
    ///
    /// # Errors
    /// Always: U013.
    pub fn compile(_files: &[PathBuf], _checked: bool) -> Result<Compiled, Diagnostics> {
        let mut errors = Diagnostics::default();
        errors.push(unavailable());
        Err(errors)
    }

    fn unavailable() -> Diagnostic {
        let message = "compiled user subroutines are not available in this build of revolve";
        Diagnostic::error("U013", message)
            .help("use a build for Linux with the GNU C library (target ...-linux-gnu), or write the subroutine in Rust or Python")
    }
}

/// Exit after a halted run.
pub mod crash {
    /// Ends the process with a status.
    pub fn leave(status: u8) -> ! {
        std::process::exit(status.into())
    }
}

/// Makes the symbols of this library visible to libraries that are opened later: there are none.
///
/// # Errors
/// None.
pub fn show_symbols() -> Result<(), String> {
    Ok(())
}
