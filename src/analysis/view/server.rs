//! Server of a view on 127.0.0.1: bounded connections, each in a separate thread for one request.

use std::collections::VecDeque;
use std::io;
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::access::{AccessToken, is_local_host, is_own_origin};
use super::http::{REQUEST_TIME, Refusal, Request, Response, read_request};

/// Largest number of connections. A browser opens up to six per page.
const CONNECTIONS: usize = 32;
/// Longest time that a connection waits for the end of another one.
const WAIT: Duration = Duration::from_secs(10);

/// Answers to requests with the token, below it.
pub trait Answers: Send + Sync + 'static {
    /// Answers a request for a path; `request` has the whole path.
    ///
    /// # Errors
    /// If the connection has ended, or a response is not received in time.
    fn answer(&self, path: &str, request: &Request, stream: &mut TcpStream) -> io::Result<()>;
}

/// Open connections: the number of all, and those whose request is not complete, oldest first.
#[derive(Default)]
struct Connections {
    count: usize,
    number: u64,
    pending: VecDeque<(u64, TcpStream)>,
}

pub struct ViewServer {
    listener: TcpListener,
    token: AccessToken,
    answers: Box<dyn Answers>,
    connections: Mutex<Connections>,
    /// Notified when a connection ends.
    ended: Condvar,
}

impl ViewServer {
    /// Opens a port of this machine, one that the system chooses if `port` is 0. Other machines cannot reach it.
    ///
    /// # Errors
    /// If the port is in use.
    pub fn open(port: u16, answers: impl Answers) -> Result<ViewServer, String> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))
            .map_err(|e| format!("cannot open port {port} of 127.0.0.1: {e}; choose another one with --port"))?;
        let (token, connections, ended) = (AccessToken::random()?, Mutex::default(), Condvar::new());
        Ok(ViewServer { listener, token, answers: Box::new(answers), connections, ended })
    }

    /// Returns the address of the page.
    ///
    /// # Errors
    /// Returns the error of the operating system.
    pub fn address(&self) -> io::Result<String> {
        Ok(format!("http://{}/{}/", self.listener.local_addr()?, self.token.text()))
    }

    /// Serves requests until the process ends.
    pub fn serve(self: Arc<Self>) {
        for stream in self.listener.incoming() {
            let Ok(stream) = stream else { continue };
            let Some(number) = self.admit(&stream) else { continue };
            let server = self.clone();
            let serve = move || {
                let mut stream = stream;
                // A connection that has ended concerns nobody else.
                let _ = server.handle(number, &mut stream);
                let _ = stream.shutdown(Shutdown::Both);
                server.end();
            };
            if std::thread::Builder::new().name("view".into()).spawn(serve).is_err() {
                self.begin_answer(number);
                self.end();
            }
        }
    }

    fn end(&self) {
        self.lock().count -= 1;
        self.ended.notify_one();
    }

    fn lock(&self) -> MutexGuard<'_, Connections> {
        self.connections.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Counts a connection and returns its number. If there are too many, the oldest one without a complete request is
    /// closed, so that slow senders do not keep others out; if all are being answered, one connection must end first. `None`
    /// if none does.
    fn admit(&self, stream: &TcpStream) -> Option<u64> {
        let copy = stream.try_clone().ok()?;
        let mut connections = self.lock();
        if connections.count >= CONNECTIONS
            && let Some((_, oldest)) = connections.pending.pop_front()
        {
            let _ = oldest.shutdown(Shutdown::Both);
        }
        let is_full = |connections: &mut Connections| connections.count >= CONNECTIONS;
        let waited = self.ended.wait_timeout_while(connections, WAIT, is_full);
        let (mut connections, waiting) = waited.unwrap_or_else(PoisonError::into_inner);
        if waiting.timed_out() {
            return None;
        }
        connections.count += 1;
        connections.number += 1;
        let number = connections.number;
        connections.pending.push_back((number, copy));
        Some(number)
    }

    fn begin_answer(&self, number: u64) {
        self.lock().pending.retain(|pending| pending.0 != number);
    }

    fn handle(&self, number: u64, stream: &mut TcpStream) -> io::Result<()> {
        stream.set_nodelay(true)?;
        let request = read_request(stream, REQUEST_TIME);
        self.begin_answer(number);
        let request = match request {
            Ok(request) => request,
            Err(Some(refusal)) => return Response::refused(&refusal).write(stream),
            Err(None) => return Ok(()),
        };
        match self.permitted(&request) {
            Ok(path) => self.answers.answer(path, &request, stream),
            Err(refusal) => Response::refused(&refusal).write(stream),
        }
    }

    /// Returns the path after the token.
    ///
    /// # Errors
    /// If the request is from a page of another site, or has no token.
    fn permitted<'a>(&self, request: &'a Request) -> Result<&'a str, Refusal> {
        if !is_local_host(&request.host) {
            return Err(Refusal::new(403, "the header Host must be 127.0.0.1 or localhost"));
        }
        if request.origin.as_ref().is_some_and(|origin| !is_own_origin(origin, &request.host)) {
            return Err(Refusal::new(403, "requests of pages of other sites are refused"));
        }
        let path = request.path.strip_prefix('/').unwrap_or_default();
        let (token, page_path) = path.split_once('/').unwrap_or((path, ""));
        if !self.token.matches(token) {
            return Err(Refusal::new(403, "the address must have the token that `revolve view` has printed"));
        }
        Ok(page_path)
    }
}
