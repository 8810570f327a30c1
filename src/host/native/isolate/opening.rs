//! Requests between the two processes as bytes, and the report about opening the libraries.

use std::io::{Read as _, Write as _};
use std::os::unix::net::UnixStream;

use serde::{Deserialize, Serialize};

use super::super::{Routines, UncallableRoutine};
use revolve_diagnostics::Diagnostic;
use revolve_numerics::state::archive::{Persist, StateArchive};

/// Sends a number that identifies a request, and a value; `None` if the other process has ended.
pub fn send(stream: &mut UnixStream, what: u8, value: &mut impl Persist) -> Option<()> {
    let mut bytes = vec![0; 9];
    value.persist(&mut StateArchive::writer(&mut bytes));
    bytes[0] = what;
    let length = bytes.len() - 9;
    bytes[1..9].copy_from_slice(&length.to_le_bytes());
    stream.write_all(&bytes).ok()
}

/// Receives a number and the bytes of a value; `None` if the other process has ended.
pub fn receive(stream: &mut UnixStream) -> Option<(u8, Vec<u8>)> {
    let mut head = [0; 9];
    stream.read_exact(&mut head).ok()?;
    let (what, length) = (head[0], head[1..].try_into().map_or(0, usize::from_le_bytes));
    let mut bytes = Vec::new();
    stream.take(length as u64).read_to_end(&mut bytes).ok().filter(|read| *read == length)?;
    Some((what, bytes))
}

/// Result of opening the libraries in the separate process.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct OpeningReport {
    /// Code, message and help of the error, if opening failed.
    pub fault: Option<[String; 3]>,
    /// Subroutines that can be called.
    pub routines: Vec<String>,
    /// Subroutines that cannot be called, as in [`Routines::uncallable`].
    pub uncallable: Vec<UncallableRoutine>,
    /// Names of unsupported subroutines, as in [`Routines::unsupported`].
    pub unsupported: Vec<String>,
}

impl OpeningReport {
    /// Creates the report that the process of the subroutines sends after it has loaded them.
    pub fn of(opened: &Result<Routines, Diagnostic>) -> OpeningReport {
        let routines = match opened {
            Ok(routines) => routines,
            Err(fault) => {
                let help = fault.help.clone().unwrap_or_default();
                return OpeningReport {
                    fault: Some([fault.code.into(), fault.message.clone(), help]),
                    ..OpeningReport::default()
                };
            }
        };
        OpeningReport {
            fault: None,
            routines: routines.names().into_iter().map(str::to_owned).collect(),
            uncallable: routines.uncallable.clone(),
            unsupported: routines.unsupported.iter().map(|name| (*name).to_owned()).collect(),
        }
    }

    /// Returns the error, if opening failed.
    pub fn refused(&self) -> Option<Diagnostic> {
        let [code, message, help] = self.fault.as_ref()?;
        let code = super::super::codes::CODES.iter().map(|known| known.code).find(|known| known == code);
        let finding = Diagnostic::error(code.unwrap_or("U005"), message.clone());
        Some(if help.is_empty() { finding } else { finding.help(help.clone()) })
    }
}
