//! The way from the run to the process of the routines: made, asked after, and left.
//! Never here: what calls mean, what the other process does.
#![allow(unsafe_code)]

use std::io::{self, Write as _};
use std::os::unix::net::UnixStream;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::super::host::{self, Message};
use super::super::memory::Recall;
use super::super::{Kept, Routines};
use super::arena::{ASK, Arena, LEAVE, Side};
use super::child;
use super::words::{receive, send};
use crate::deck::Diagnostic;
use crate::state::archive::{Archive, Persist, UnfitState};

/// The way to the process of the routines.
pub struct Door {
    /// What both share.
    pub arena: Arena,
    stream: Mutex<UnixStream>,
    process: i32,
    /// How it ended, as the system says it.
    ended: Mutex<Option<i32>>,
}

impl Door {
    /// Makes the process.
    ///
    /// # Errors
    /// That of the system, or that this process has threads.
    pub fn make(open: impl FnOnce() -> Result<Routines, Diagnostic> + Send) -> io::Result<Door> {
        if std::fs::read_dir("/proc/self/task")?.count() > 1 {
            return Err(io::Error::other("this one has threads already"));
        }
        let arena = Arena::new()?;
        let (here, there) = UnixStream::pair()?;
        io::stdout().flush()?;
        // SAFETY: this process has one thread, so that its copy is as whole as it is itself.
        let (run, process) = unsafe { (libc::getpid(), libc::fork()) };
        match process {
            0 => {
                drop(here);
                child::live(arena, there, run, open)
            }
            1.. => Ok(Door { arena, stream: Mutex::new(here), process, ended: Mutex::new(None) }),
            _ => Err(io::Error::last_os_error()),
        }
    }

    /// The stream beside the memory.
    pub fn stream(&self) -> MutexGuard<'_, UnixStream> {
        self.stream.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether the process is there.
    fn is_there(&self) -> bool {
        let mut ended = self.ended.lock().unwrap_or_else(PoisonError::into_inner);
        let mut status = 0;
        // SAFETY: asks after a child of this process that nobody else asks after.
        if ended.is_none() && unsafe { libc::waitpid(self.process, &raw mut status, libc::WNOHANG) } != 0 {
            *ended = Some(status);
        }
        ended.is_none()
    }

    /// What became of the process that was about to answer.
    pub fn last_words(&self) -> String {
        let gone = std::iter::repeat_with(|| self.is_there()).take(200);
        for there in gone {
            if !there {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        let said = self.arena.with(|content| content.words.get());
        if !said.is_empty() {
            return said;
        }
        match *self.ended.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(status) if libc::WIFSIGNALED(status) => format!("signal {} ended its process", libc::WTERMSIG(status)),
            Some(status) => format!("its process ended with status {}", libc::WEXITSTATUS(status)),
            None => "its process does not answer".into(),
        }
    }

    /// Hands the turn over and waits for it to come back; `None` where the process is gone.
    pub fn turn(&self) -> Option<()> {
        self.arena.hand_to(Side::Routines);
        self.arena.wait(Side::Caller, || self.is_there()).then_some(())
    }

    /// Asks for something beside calls.
    fn ask<T: Persist + Default>(&self, what: u8, value: &mut impl Persist) -> Option<T> {
        if !self.is_there() {
            return None;
        }
        let mut stream = self.stream();
        self.arena.with(|content| content.purpose = ASK);
        self.arena.hand_to(Side::Routines);
        send(&mut stream, what, value)?;
        let (_, bytes) = receive(&mut stream)?;
        self.arena.wait(Side::Caller, || self.is_there()).then_some(())?;
        let mut answer = T::default();
        answer.persist(&mut Archive::reader(&bytes));
        Some(answer)
    }
}

impl Drop for Door {
    /// Lets the process go, which may have things to tidy up.
    fn drop(&mut self) {
        if self.is_there() {
            self.arena.with(|content| content.purpose = LEAVE);
            self.arena.hand_to(Side::Routines);
        }
    }
}

impl Recall for Door {
    fn begin(&self) {
        let mut job = host::with_job(Clone::clone);
        let _: Option<()> = self.ask(child::BEGIN, &mut job);
    }

    fn end(&self) {
        let messages: Vec<Message> = self.ask(child::END, &mut ()).unwrap_or_default();
        host::add_messages(messages);
    }

    fn keep(&self) -> Kept {
        match self.ask::<(Kept, Vec<Message>)>(child::KEEP, &mut ()) {
            Some((kept, messages)) => {
                host::add_messages(messages);
                kept
            }
            None => Kept::nothing("the process of the routines is gone"),
        }
    }

    fn take_up(&self, kept: &Kept) -> Result<(), UnfitState> {
        match self.ask::<Option<String>>(child::TAKE_UP, &mut kept.clone()) {
            Some(None) => Ok(()),
            Some(Some(reason)) => Err(UnfitState { reason }),
            None => Err(UnfitState { reason: "the process of the routines is gone".into() }),
        }
    }
}
