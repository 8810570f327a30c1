//! The process of the routines: opens them, answers calls and requests.
//! Never here: the run.
#![allow(unsafe_code)]

use std::os::unix::net::UnixStream;

use super::super::host::{self, JobInfo};
use super::super::{Routines, SavedMemory, call, guard};
use super::opening::{OpeningReport, receive, send};
use super::server::Server;
use super::shared_memory::{Purpose, REQUEST, SharedMemory, Side};
use crate::deck::Diagnostic;
use crate::state::archive::{Archive, Persist};

/// Requests over the stream: a run begins, with its job;
pub const BEGIN: u8 = 1;
/// save the memory, and return it with the messages so far;
pub const KEEP: u8 = 2;
/// restore a saved memory;
pub const TAKE_UP: u8 = 3;
/// the run is over, return the messages since.
pub const END: u8 = 4;

/// Stack of the routines, bytes: as the run's own threads have it.
const STACK: usize = 64 << 20;

/// Runs the forked process until it ends.
pub fn live(
    memory: SharedMemory,
    stream: UnixStream,
    run: i32,
    open: impl FnOnce() -> Result<Routines, Diagnostic> + Send,
) -> ! {
    // SAFETY: signals that end a run in order come to all processes of a terminal; the run decides when this one goes, and
    // takes it along wherever it ends.
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
    // SAFETY: asks the system.
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
    let mut held = routines.lock();
    let mut server = Server::default();
    while memory.wait(Side::Routines, || is_child_of(run)) {
        let turn = memory.with(|exchange| exchange.purpose);
        match Purpose::of(turn) {
            Some(purpose) => memory.with(|exchange| server.answer(purpose, exchange, &mut held)),
            None if turn == REQUEST => answer_request(&mut stream, &routines)?,
            None => return Some(()),
        }
        memory.hand_to(Side::Caller);
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
            job.persist(&mut Archive::reader(&bytes));
            host::announce(job);
            memory.begin();
            send(stream, 0, &mut ())
        }
        KEEP => send(stream, 0, &mut (memory.keep(), host::take_messages())),
        TAKE_UP => {
            let mut kept = SavedMemory::default();
            kept.persist(&mut Archive::reader(&bytes));
            send(stream, 0, &mut memory.take_up(&kept).err().map(|why| why.reason))
        }
        _ => {
            memory.end();
            guard::flush();
            send(stream, 0, &mut host::take_messages())
        }
    }
}
