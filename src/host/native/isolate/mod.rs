//! User subroutines in a separate process, so that their crashes and memory errors do not affect the run. Calls go
//! through memory that both processes share; results have the same bits as without isolation.

mod calls;
mod channel;
mod child;
mod client;
mod message;
mod opening;
mod server;
mod shared_memory;

use std::io;
use std::sync::Arc;

use super::{Routines, library};
use channel::RoutineChannel;
use client::RoutineClient;
use opening::{OpeningReport, receive};
use revolve_diagnostics::Diagnostic;
use revolve_numerics::state::archive::{Persist, StateArchive};

/// Opens user subroutines in a process forked from this one, which must not have other threads yet.
///
/// # Errors
/// Errors of opening them in this process; U012 for subroutines that cannot be isolated.
pub fn open(open: impl FnOnce() -> Result<Routines, Diagnostic> + Send) -> Result<Routines, Diagnostic> {
    let failed =
        |why: io::Error| Diagnostic::error("U012", format!("cannot create a process for the user subroutines: {why}"));
    let channel = RoutineChannel::make(open).map_err(failed)?;
    let received = receive(&mut channel.stream()).and_then(|(_, bytes)| {
        let mut text = String::new();
        text.persist(&mut StateArchive::reader(&bytes));
        serde_json::from_str::<OpeningReport>(&text).ok()
    });
    let Some(opening) = received else {
        return Err(Diagnostic::error(
            "U005",
            format!("the user subroutines cannot be opened: {}", channel.failure_reason()),
        ));
    };
    if let Some(fault) = opening.refused() {
        return Err(fault);
    }
    if opening.routines.iter().any(|name| name == "vusdfld") {
        let finding = Diagnostic::error("U012", "vusdfld cannot run in a separate process");
        return Err(
            finding.help("it reads values of the run during its call: run without --isolate, or without vusdfld")
        );
    }
    let channel = Arc::new(channel);
    let mut routines = Routines {
        uncallable: opening.uncallable,
        unsupported: opening.unsupported.iter().filter_map(|name| library::unsupported(name)).collect(),
        memory: Some(channel.clone()),
        ..Routines::none()
    };
    for name in &opening.routines {
        let client = RoutineClient::new(&channel);
        routines = match name.as_str() {
            "vdload" => routines.with_load(client),
            "vuamp" => routines.with_amplitude(client),
            "vdisp" => routines.with_motion(client),
            "vumat" => routines.with_material(client),
            "vuanisohyper_inv" => routines.with_energy(client),
            "vuhard" => routines.with_hardening(client),
            "vufield" => routines.with_nodal_fields(client),
            "vfriction" => routines.with_friction(client),
            "vucharlength" => routines.with_lengths(client),
            _ => routines.with_events(client),
        };
    }
    Ok(routines)
}
