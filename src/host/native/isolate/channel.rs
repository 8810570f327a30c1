//! The connection from the run to the process of the user subroutines.
#![allow(unsafe_code)]

use std::io::{self, Write as _};
use std::os::unix::net::UnixStream;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::super::host::{self, RoutineMessage};
use super::super::{PersistentMemory, Routines, SavedMemory};
use super::child;
use super::opening::{receive, send};
use super::shared_memory::{LEAVE, ProcessSide, REQUEST, SharedMemory};
use revolve_diagnostics::Diagnostic;
use revolve_numerics::state::archive::{Persist, StateArchive, UnfitState};

/// The connection to the process of the user subroutines.
pub struct RoutineChannel {
    /// Memory shared by both processes.
    pub memory: SharedMemory,
    stream: Mutex<UnixStream>,
    process: i32,
    /// Exit status of the process after its end.
    ended: Mutex<Option<i32>>,
}

impl RoutineChannel {
    /// Forks the process of the user subroutines.
    ///
    /// # Errors
    /// Errors of the system; an error if this process already has other threads.
    pub fn make(open: impl FnOnce() -> Result<Routines, Diagnostic> + Send) -> io::Result<RoutineChannel> {
        if std::fs::read_dir("/proc/self/task")?.count() > 1 {
            return Err(io::Error::other("this process already has other threads"));
        }
        let memory = SharedMemory::new()?;
        let (run_end, routine_end) = UnixStream::pair()?;
        io::stdout().flush()?;
        // SAFETY: this process has one thread, so its copy is complete.
        let (run, process) = unsafe { (libc::getpid(), libc::fork()) };
        match process {
            0 => {
                drop(run_end);
                child::live(memory, routine_end, run, open)
            }
            1.. => Ok(RoutineChannel { memory, stream: Mutex::new(run_end), process, ended: Mutex::new(None) }),
            _ => Err(io::Error::last_os_error()),
        }
    }

    /// Returns the stream for requests.
    pub fn stream(&self) -> MutexGuard<'_, UnixStream> {
        self.stream.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns whether the process is running.
    fn is_there(&self) -> bool {
        let mut ended = self.ended.lock().unwrap_or_else(PoisonError::into_inner);
        let mut status = 0;
        // SAFETY: a child of this process for which nothing else waits.
        if ended.is_none() && unsafe { libc::waitpid(self.process, &raw mut status, libc::WNOHANG) } != 0 {
            *ended = Some(status);
        }
        ended.is_none()
    }

    /// Waits until the process has ended, at most a second.
    fn wait_for_end(&self) {
        for _ in 0..1000 {
            if !self.is_there() {
                break;
            }
            std::thread::sleep(std::time::Duration::from_millis(1));
        }
    }

    /// Returns the reason why the process does not answer.
    pub fn failure_reason(&self) -> String {
        self.wait_for_end();
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

    /// Hands over the turn and waits for its return; `None` if the process has ended.
    pub fn turn(&self) -> Option<()> {
        self.memory.hand_to(ProcessSide::Routines);
        self.memory.wait(ProcessSide::Caller, || self.is_there()).then_some(())
    }

    /// Sends a request and waits for the answer.
    fn request<T: Persist + Default>(&self, what: u8, value: &mut impl Persist) -> Option<T> {
        if !self.is_there() {
            return None;
        }
        let mut stream = self.stream();
        self.memory.with(|exchange| exchange.purpose = REQUEST);
        self.memory.hand_to(ProcessSide::Routines);
        send(&mut stream, what, value)?;
        let (_, bytes) = receive(&mut stream)?;
        self.memory.wait(ProcessSide::Caller, || self.is_there()).then_some(())?;
        let mut answer = T::default();
        answer.persist(&mut StateArchive::reader(&bytes));
        Some(answer)
    }
}

impl Drop for RoutineChannel {
    fn drop(&mut self) {
        self.close();
    }
}

impl PersistentMemory for RoutineChannel {
    fn begin(&self) {
        let mut job = host::with_job(Clone::clone);
        let _: Option<()> = self.request(child::BEGIN, &mut job);
    }

    fn end(&self) {
        let messages: Vec<RoutineMessage> = self.request(child::END, &mut ()).unwrap_or_default();
        host::add_messages(messages);
    }

    fn save(&self) -> SavedMemory {
        match self.request::<(SavedMemory, Vec<RoutineMessage>)>(child::KEEP, &mut ()) {
            Some((kept, messages)) => {
                host::add_messages(messages);
                kept
            }
            None => SavedMemory::not_saved("the process of the user subroutines has ended"),
        }
    }

    fn restore(&self, kept: &SavedMemory) -> Result<(), UnfitState> {
        match self.request::<Option<String>>(child::TAKE_UP, &mut kept.clone()) {
            Some(None) => Ok(()),
            Some(Some(reason)) => Err(UnfitState { reason }),
            None => Err(UnfitState { reason: "the process of the user subroutines has ended".into() }),
        }
    }

    fn close(&self) {
        if self.is_there() {
            self.memory.with(|exchange| exchange.purpose = LEAVE);
            self.memory.hand_to(ProcessSide::Routines);
            self.wait_for_end();
        }
    }
}
