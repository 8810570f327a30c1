//! What goes over the stream between the two processes beside calls, as bytes.
//! Never here: who asks, and who answers.

use std::io::{Read as _, Write as _};
use std::os::unix::net::UnixStream;

use super::super::{Misfit, Routines};
use crate::deck::Diagnostic;
use crate::state::archive::{Archive, Persist, persist_fields};

/// Sends what something consists of, behind a number that says what it is; `None` where nobody reads.
pub fn send(stream: &mut UnixStream, what: u8, value: &mut impl Persist) -> Option<()> {
    let mut bytes = vec![0; 9];
    value.persist(&mut Archive::writer(&mut bytes));
    bytes[0] = what;
    let length = bytes.len() - 9;
    bytes[1..9].copy_from_slice(&length.to_le_bytes());
    stream.write_all(&bytes).ok()
}

/// What has come; `None` where nobody sends.
pub fn receive(stream: &mut UnixStream) -> Option<(u8, Vec<u8>)> {
    let mut head = [0; 9];
    stream.read_exact(&mut head).ok()?;
    let (what, length) = (head[0], head[1..].try_into().map_or(0, usize::from_le_bytes));
    let mut bytes = Vec::new();
    stream.take(length as u64).read_to_end(&mut bytes).ok().filter(|read| *read == length)?;
    Some((what, bytes))
}

/// What opening came to in the process of the routines.
#[derive(Clone, Debug, Default)]
pub struct Opening {
    /// Code, message and help where it failed.
    pub fault: Option<[String; 3]>,
    /// Routines that can be called.
    pub routines: Vec<String>,
    /// As [`Routines::misfits`]: routine, code, message.
    pub misfits: Vec<(String, (String, String))>,
    /// As [`Routines::strangers`].
    pub strangers: Vec<String>,
}

impl Persist for Opening {
    fn persist(&mut self, archive: &mut Archive<'_>) {
        let Opening { fault, routines, misfits, strangers } = self;
        persist_fields!(archive; fault, routines, misfits, strangers);
    }
}

impl Opening {
    /// In words that can be sent.
    pub fn of(opened: &Result<Routines, Diagnostic>) -> Opening {
        let routines = match opened {
            Ok(routines) => routines,
            Err(fault) => {
                let help = fault.help.clone().unwrap_or_default();
                return Opening { fault: Some([fault.code.into(), fault.message.clone(), help]), ..Opening::default() };
            }
        };
        let misfit = |misfit: &Misfit| (misfit.routine.clone(), (misfit.code.clone(), misfit.message.clone()));
        Opening {
            fault: None,
            routines: routines.names().into_iter().map(str::to_owned).collect(),
            misfits: routines.misfits.iter().map(misfit).collect(),
            strangers: routines.strangers.iter().map(|name| (*name).to_owned()).collect(),
        }
    }

    /// The fault, of one of the codes that there are.
    pub fn refused(&self) -> Option<Diagnostic> {
        let [code, message, help] = self.fault.as_ref()?;
        let code = super::super::codes::CODES.iter().map(|known| known.code).find(|known| known == code);
        let finding = Diagnostic::error(code.unwrap_or("U005"), message.clone());
        Some(if help.is_empty() { finding } else { finding.help(help.clone()) })
    }
}
