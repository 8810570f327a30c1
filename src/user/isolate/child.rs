//! The process of the routines: opens them, answers calls, and does what is asked beside calls.
//! Never here: the run.
#![allow(unsafe_code)]

use std::os::unix::net::UnixStream;

use super::super::host::{self, JobInfo};
use super::super::{Kept, Routines, call, guard};
use super::arena::{ASK, Arena, Purpose, Side};
use super::served::Service;
use super::words::{Opening, receive, send};
use crate::deck::Diagnostic;
use crate::state::archive::{Archive, Persist};

/// Asked over the stream: a run begins, with its job,
pub const BEGIN: u8 = 1;
/// what is to be kept, and the messages so far,
pub const KEEP: u8 = 2;
/// to take up what was kept,
pub const TAKE_UP: u8 = 3;
/// and that the run is over: the messages since.
pub const END: u8 = 4;

/// Stack of the routines, bytes: as the run's own threads have it.
const STACK: usize = 64 << 20;

/// What the process that has been made is until it ends.
pub fn live(
    arena: Arena,
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
    call::leave_words_in(arena.words());
    std::thread::scope(|scope| {
        let served =
            std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, || serve(arena, stream, run, open));
        served.map(|thread| thread.join().ok()).ok();
    });
    std::process::exit(0)
}

fn is_child_of(run: i32) -> bool {
    // SAFETY: asks the system.
    unsafe { libc::getppid() == run }
}

fn serve(
    arena: Arena,
    mut stream: UnixStream,
    run: i32,
    open: impl FnOnce() -> Result<Routines, Diagnostic>,
) -> Option<()> {
    let opened = open();
    send(&mut stream, 0, &mut Opening::of(&opened))?;
    let routines = opened.ok()?;
    let mut held = routines.lock();
    let mut service = Service::default();
    while arena.wait(Side::Routines, || is_child_of(run)) {
        let turn = arena.with(|content| content.purpose);
        match Purpose::of(turn) {
            Some(purpose) => arena.with(|content| service.answer(purpose, content, &mut held)),
            None if turn == ASK => asked(&mut stream, &routines)?,
            None => return Some(()),
        }
        arena.hand_to(Side::Caller);
    }
    None
}

/// What is asked beside calls; `None` where nobody asks any more.
fn asked(stream: &mut UnixStream, routines: &Routines) -> Option<()> {
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
            let mut kept = Kept::default();
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
