//! The server: a loop over the messages of the client, with a thread that reads them and one that checks decks.

mod answers;
mod capabilities;
mod checks;
mod documents;
mod publish;
mod reader;
mod requests;
mod roots;
mod state;

use std::io::{self, BufRead, Write};
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};

use lsp_server::Message;
use thiserror::Error;

use checks::{CheckResult, DeckChecker};
use reader::{Incoming, ProtocolError};
use state::{ServerState, SessionPhase};

/// Error that ends the server.
#[derive(Debug, Error)]
pub enum EditorError {
    /// A stream has failed.
    #[error("the connection to the editor failed: {0}")]
    Stream(#[from] io::Error),
    /// The client has ended the connection without the request `shutdown`.
    #[error("the editor ended the connection without shutting the server down")]
    NotShutDown,
}

/// What the loop of the server waits for.
enum ServerEvent {
    Received(Message),
    Malformed(ProtocolError),
    /// The end of the messages, with its reason if it is an error.
    Closed(Option<io::Error>),
    Checked(Box<CheckResult>),
}

/// Serves a client until it sends `exit` or ends the stream.
///
/// # Errors
/// If a stream fails, or ends before the client has shut the server down.
pub fn serve(input: impl BufRead + Send + 'static, output: impl Write) -> Result<(), EditorError> {
    let (sender, events) = channel();
    let reader = sender.clone();
    std::thread::spawn(move || read_messages(input, &reader));
    let checker = DeckChecker::start(move |result| sender.send(ServerEvent::Checked(Box::new(result))).is_ok());
    let mut state = ServerState::new(Box::new(checker));
    run_loop(&mut state, &events, output)
}

fn read_messages(mut input: impl BufRead, events: &Sender<ServerEvent>) {
    loop {
        let (event, ends) = match reader::read(&mut input) {
            Ok(Some(Incoming::Message(message))) => (ServerEvent::Received(message), false),
            Ok(Some(Incoming::Malformed(error))) => (ServerEvent::Malformed(error), false),
            Ok(None) => (ServerEvent::Closed(None), true),
            Err(error) => (ServerEvent::Closed(Some(error)), true),
        };
        if events.send(event).is_err() || ends {
            return;
        }
    }
}

fn run_loop(
    state: &mut ServerState,
    events: &Receiver<ServerEvent>,
    mut output: impl Write,
) -> Result<(), EditorError> {
    loop {
        // Diagnostics are updated once for all edits that have arrived.
        let event = match events.try_recv() {
            Ok(event) => Some(event),
            Err(TryRecvError::Empty) => {
                state.update_diagnostics();
                send_all(state, &mut output)?;
                events.recv().ok()
            }
            Err(TryRecvError::Disconnected) => None,
        };
        match event {
            Some(ServerEvent::Received(message)) => state.receive(message),
            Some(ServerEvent::Malformed(error)) => error.write(&mut output)?,
            Some(ServerEvent::Checked(result)) => state.take_result(*result),
            Some(ServerEvent::Closed(Some(error))) => return Err(error.into()),
            Some(ServerEvent::Closed(None)) | None => {
                return if state.phase == SessionPhase::Running { Err(EditorError::NotShutDown) } else { Ok(()) };
            }
        }
        send_all(state, &mut output)?;
        match state.phase {
            SessionPhase::Exited { after_shutdown: true } => return Ok(()),
            SessionPhase::Exited { after_shutdown: false } => return Err(EditorError::NotShutDown),
            _ => {}
        }
    }
}

fn send_all(state: &mut ServerState, output: &mut impl Write) -> io::Result<()> {
    state.outbox.drain(..).try_for_each(|message| message.write(output))
}
