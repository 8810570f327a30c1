//! Routines in a process of their own: what they do to memory, and their end, are theirs alone. The run calls them over memory
//! that both share; the bits are those of routines in the process of the run.
//! Never here: compiling, opening libraries.

mod arena;
mod callers;
mod child;
mod door;
mod served;
mod tape;
mod words;

use std::io;
use std::sync::Arc;

use super::{Misfit, Routines, library};
use crate::deck::Diagnostic;
use crate::state::archive::{Archive, Persist};
use callers::Caller;
use door::Door;
use words::{Opening, receive};

/// Opens routines in a process of their own, which this one makes; it must have no other threads yet.
///
/// # Errors
/// As opening them here; routines that cannot be called over there are refused by their names (U012).
pub fn open(open: impl FnOnce() -> Result<Routines, Diagnostic> + Send) -> Result<Routines, Diagnostic> {
    let failed = |why: io::Error| Diagnostic::error("U012", format!("no process can be made for the routines: {why}"));
    let door = Door::make(open).map_err(failed)?;
    let mut opening = Opening::default();
    let told = receive(&mut door.stream());
    let Some((_, bytes)) = told else {
        return Err(Diagnostic::error("U005", format!("the routines cannot be opened: {}", door.last_words())));
    };
    opening.persist(&mut Archive::reader(&bytes));
    if let Some(fault) = opening.refused() {
        return Err(fault);
    }
    if opening.routines.iter().any(|name| name == "vusdfld") {
        let finding = Diagnostic::error("U012", "vusdfld cannot run in a process of its own");
        return Err(
            finding.help("it asks the run for what points hold: run without --isolate, or without that routine")
        );
    }
    let door = Arc::new(door);
    let misfit = |(routine, (code, message)): (String, (String, String))| Misfit { routine, code, message };
    let mut routines = Routines {
        misfits: opening.misfits.into_iter().map(misfit).collect(),
        strangers: opening.strangers.iter().filter_map(|name| library::stranger(name)).collect(),
        memory: Some(door.clone()),
        ..Routines::none()
    };
    for name in &opening.routines {
        let caller = Caller::new(&door);
        routines = match name.as_str() {
            "vdload" => routines.with_load(caller),
            "vuamp" => routines.with_amplitude(caller),
            "vdisp" => routines.with_motion(caller),
            "vumat" => routines.with_material(caller),
            "vuhard" => routines.with_hardening(caller),
            "vucharlength" => routines.with_lengths(caller),
            _ => routines.with_events(caller),
        };
    }
    Ok(routines)
}
