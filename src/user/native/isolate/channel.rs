//! The connection from the run to the process of the routines.
//! Never here: calls, the other process.
#![allow(unsafe_code)]

use std::io::{self, Write as _};
use std::os::unix::net::UnixStream;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::super::host::{self, RoutineMessage};
use super::super::{PersistentMemory, Routines, SavedMemory};
use super::child;
use super::opening::{receive, send};
use super::shared_memory::{LEAVE, REQUEST, SharedMemory, Side};
use crate::deck::Diagnostic;
use crate::state::archive::{Archive, Persist, UnfitState};

/// The connection to the process of the routines.
pub struct Channel {
    /// Memory shared by both.
    pub memory: SharedMemory,
    stream: Mutex<UnixStream>,
    process: i32,
    /// Exit status of the process, once it has ended.
    ended: Mutex<Option<i32>>,
}

impl Channel {
    /// Forks the process.
    ///
    /// # Errors
    /// That of the system, or that this process has threads.
    pub fn make(open: impl FnOnce() -> Result<Routines, Diagnostic> + Send) -> io::Result<Channel> {
        if std::fs::read_dir("/proc/self/task")?.count() > 1 {
            return Err(io::Error::other("this one has threads already"));
        }
        let memory = SharedMemory::new()?;
        let (here, there) = UnixStream::pair()?;
        io::stdout().flush()?;
        // SAFETY: this process has one thread, so that its copy is as whole as it is itself.
        let (run, process) = unsafe { (libc::getpid(), libc::fork()) };
        match process {
            0 => {
                drop(here);
                child::live(memory, there, run, open)
            }
            1.. => Ok(Channel { memory, stream: Mutex::new(here), process, ended: Mutex::new(None) }),
            _ => Err(io::Error::last_os_error()),
        }
    }

    /// The stream for requests.
    pub fn stream(&self) -> MutexGuard<'_, UnixStream> {
        self.stream.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether the process is running.
    fn is_there(&self) -> bool {
        let mut ended = self.ended.lock().unwrap_or_else(PoisonError::into_inner);
        let mut status = 0;
        // SAFETY: asks after a child of this process that nobody else asks after.
        if ended.is_none() && unsafe { libc::waitpid(self.process, &raw mut status, libc::WNOHANG) } != 0 {
            *ended = Some(status);
        }
        ended.is_none()
    }

    /// Why the process does not answer.
    pub fn last_words(&self) -> String {
        let gone = std::iter::repeat_with(|| self.is_there()).take(200);
        for there in gone {
            if !there {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        let said = self.memory.with(|exchange| exchange.failure.get());
        if !said.is_empty() {
            return said;
        }
        match *self.ended.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(status) if libc::WIFSIGNALED(status) => format!("signal {} ended its process", libc::WTERMSIG(status)),
            Some(status) => format!("its process ended with status {}", libc::WEXITSTATUS(status)),
            None => "its process does not answer".into(),
        }
    }

    /// Hands the turn over and waits for its return; `None` if the process has ended.
    pub fn turn(&self) -> Option<()> {
        self.memory.hand_to(Side::Routines);
        self.memory.wait(Side::Caller, || self.is_there()).then_some(())
    }

    /// Sends a request and waits for the answer.
    fn ask<T: Persist + Default>(&self, what: u8, value: &mut impl Persist) -> Option<T> {
        if !self.is_there() {
            return None;
        }
        let mut stream = self.stream();
        self.memory.with(|exchange| exchange.purpose = REQUEST);
        self.memory.hand_to(Side::Routines);
        send(&mut stream, what, value)?;
        let (_, bytes) = receive(&mut stream)?;
        self.memory.wait(Side::Caller, || self.is_there()).then_some(())?;
        let mut answer = T::default();
        answer.persist(&mut Archive::reader(&bytes));
        Some(answer)
    }
}

impl Drop for Channel {
    /// Tells the process to end.
    fn drop(&mut self) {
        if self.is_there() {
            self.memory.with(|exchange| exchange.purpose = LEAVE);
            self.memory.hand_to(Side::Routines);
        }
    }
}

impl PersistentMemory for Channel {
    fn begin(&self) {
        let mut job = host::with_job(Clone::clone);
        let _: Option<()> = self.ask(child::BEGIN, &mut job);
    }

    fn end(&self) {
        let messages: Vec<RoutineMessage> = self.ask(child::END, &mut ()).unwrap_or_default();
        host::add_messages(messages);
    }

    fn keep(&self) -> SavedMemory {
        match self.ask::<(SavedMemory, Vec<RoutineMessage>)>(child::KEEP, &mut ()) {
            Some((kept, messages)) => {
                host::add_messages(messages);
                kept
            }
            None => SavedMemory::nothing("the process of the routines is gone"),
        }
    }

    fn take_up(&self, kept: &SavedMemory) -> Result<(), UnfitState> {
        match self.ask::<Option<String>>(child::TAKE_UP, &mut kept.clone()) {
            Some(None) => Ok(()),
            Some(Some(reason)) => Err(UnfitState { reason }),
            None => Err(UnfitState { reason: "the process of the routines is gone".into() }),
        }
    }
}
