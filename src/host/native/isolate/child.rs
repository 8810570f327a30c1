//! The process of the user subroutines: opens the libraries, answers calls and requests.
#![allow(unsafe_code)]

use std::os::unix::net::UnixStream;

use super::super::host::{self, JobInfo};
use super::super::{Routines, STACK, SavedMemory, call};
use super::opening::{OpeningReport, receive, send};
use super::server::RoutineServer;
use super::shared_memory::{ProcessSide, REQUEST, SharedMemory, TurnPurpose};
use revolve_diagnostics::Diagnostic;
use revolve_numerics::state::archive::{Persist, StateArchive};

/// Request over the stream: a run begins; with the data of its job.
pub const BEGIN: u8 = 1;
/// Request: save the memory, and return it with the messages so far.
pub const KEEP: u8 = 2;
/// Request: restore a saved memory.
pub const TAKE_UP: u8 = 3;
/// Request: the run has ended; return the remaining messages.
pub const END: u8 = 4;

/// Runs the forked process until its end.
pub fn live(
    memory: SharedMemory,
    stream: UnixStream,
    run: i32,
    open: impl FnOnce() -> Result<Routines, Diagnostic> + Send,
) -> ! {
    // SAFETY: signals that end a run in order reach all processes of a terminal. The run decides when this process
    // ends, and takes it along when it ends itself.
    unsafe {
        libc::prctl(libc::PR_SET_PDEATHSIG, libc::SIGKILL);
        libc::signal(libc::SIGINT, libc::SIG_IGN);
        libc::signal(libc::SIGTERM, libc::SIG_IGN);
    }
    call::report_failure_in(memory.failure());
    std::thread::scope(|scope| {
        let served =
            std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, || serve(memory, stream, run, open));
        served.map(|thread| thread.join().ok()).ok();
    });
    std::process::exit(0)
}

fn is_child_of(run: i32) -> bool {
    // SAFETY: a system call without side effects.
    unsafe { libc::getppid() == run }
}

fn serve(
    memory: SharedMemory,
    mut stream: UnixStream,
    run: i32,
    open: impl FnOnce() -> Result<Routines, Diagnostic>,
) -> Option<()> {
    let opened = open();
    send(&mut stream, 0, &mut serde_json::to_string(&OpeningReport::of(&opened)).ok()?)?;
    let routines = opened.ok()?;
    let mut locked = routines.lock();
    let mut server = RoutineServer::default();
    while memory.wait(ProcessSide::Routines, || is_child_of(run)) {
        let turn = memory.with(|exchange| exchange.purpose);
        match TurnPurpose::of(turn) {
            Some(purpose) => memory.with(|exchange| server.answer(purpose, exchange, &mut locked)),
            None if turn == REQUEST => answer_request(&mut stream, &routines)?,
            None => return Some(()),
        }
        memory.hand_to(ProcessSide::Caller);
    }
    None
}

/// Answers a request; `None` if the run has ended.
fn answer_request(stream: &mut UnixStream, routines: &Routines) -> Option<()> {
    let (what, bytes) = receive(stream)?;
    let memory = routines.memory.as_ref()?;
    match what {
        BEGIN => {
            let mut job = JobInfo::default();
            job.persist(&mut StateArchive::reader(&bytes));
            host::begin_job(job);
            memory.begin();
            send(stream, 0, &mut ())
        }
        KEEP => send(stream, 0, &mut (memory.save(), host::take_messages())),
        TAKE_UP => {
            let mut saved = SavedMemory::default();
            saved.persist(&mut StateArchive::reader(&bytes));
            send(stream, 0, &mut memory.restore(&saved).err().map(|why| why.reason))
        }
        _ => {
            memory.end();
            send(stream, 0, &mut host::take_messages())
        }
    }
}
