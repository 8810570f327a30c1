//! The process of the routines: opens them, answers calls, and does what is asked beside calls.
//! Never here: the run.
#![allow(unsafe_code)]

use std::os::unix::net::UnixStream;

use super::super::host::{self, JobInfo};
use super::super::{Kept, LoadFailure, LoadPoints, Locked, MAX_BLOCK, Routines, call, guard};
use super::arena::{ASK, Arena, Content, PRESSURE, Side};
use super::words::{Opening, receive, send};
use crate::deck::Diagnostic;
use crate::state::Instant;
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
    let mut room = vec![f64::NAN; MAX_BLOCK + 1];
    while arena.wait(Side::Routines, || is_child_of(run)) {
        match arena.with(|content| content.purpose) {
            PRESSURE => arena.with(|content| answer(content, &mut held, &mut room)),
            ASK => asked(&mut stream, &routines)?,
            _ => return Some(()),
        }
        arena.hand_to(Side::Caller);
    }
    None
}

/// Calls the load and leaves its answer, or why it failed. The room holds no number before and after.
fn answer(content: &mut Content, held: &mut Locked<'_>, room: &mut [f64]) {
    let count = (content.count as usize).min(MAX_BLOCK);
    let called = pressure(content, held, &mut room[..count]);
    let intact = room[count].is_nan() && room[MAX_BLOCK].is_nan();
    let failure = called.err().or_else(|| {
        let words = format!("it wrote past the nblock = {count} points of its argument value");
        (!intact).then(|| LoadFailure::new(words))
    });
    content.words.set(failure.as_ref().map_or("", |failure| &failure.reason));
    content.point = failure.and_then(|failure| failure.point).map_or(-1, |point| point as i32);
    content.value.0[..count].copy_from_slice(&room[..count]);
    // What the next call leaves out is none.
    room[..if intact { count } else { MAX_BLOCK + 1 }].fill(f64::NAN);
}

fn pressure(content: &Content, held: &mut Locked<'_>, value: &mut [f64]) -> Result<(), LoadFailure> {
    let n = value.len();
    let name = &content.name[..(content.name_length as usize).min(content.name.len())];
    let [step_time, total_time, lost] = content.times;
    let (motion, directions) = (&content.motion.0[..6 * n], &content.directions.0[..9 * n]);
    let points = LoadPoints {
        surface: std::str::from_utf8(name).unwrap_or_default(),
        load_type: content.load_type,
        now: Instant { step_time, total_time, step: content.step, increment: content.increment, lost },
        amplitude: content.factors[0],
        magnitude: content.factors[1],
        r: &content.coordinates.0[..n],
        z: &content.coordinates.0[n..2 * n],
        velocity_r: &motion[..n],
        velocity_z: &motion[n..2 * n],
        // A compiled routine has them in `directions`.
        normal_r: &directions[..n],
        normal_z: &directions[2 * n..3 * n],
        coordinates: &content.coordinates.0[..3 * n],
        motion,
        directions,
    };
    let Some(load) = held.load.as_deref_mut() else { return Err(LoadFailure::new("there is no such routine")) };
    load.pressure(&points, value)
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
