//! The answers of a view: a fixed table of paths, no path of a file comes from a request.

use std::io;
use std::net::TcpStream;
use std::sync::Arc;
use std::time::Duration;

use serde_json::json;

use super::board::StateBoard;
use super::http::{Refusal, Request, Response, head, write_bytes};
use super::server::Answers;
use super::store::FrameStore;
use crate::output::JobFiles;
use crate::report::{self, PageContents, SHARED_SCRIPT, STYLE};

/// Style and script of the page.
const VIEW_STYLE: &str = include_str!("view.css");
const SCRIPTS: [&str; 3] = [SHARED_SCRIPT, include_str!("mesh.js"), include_str!("view.js")];

/// Largest number of event streams, one per page.
const STREAMS: usize = 8;
/// Time after which an event stream without events sends an empty line, which finds out whether the page is still open.
const ALIVE: Duration = Duration::from_secs(2);
/// Largest number of frames in a history of an element per request.
const TRACE: usize = 16;

const BYTES: &str = "application/octet-stream";
const JSON: &str = "application/json";
const HTML: &str = "text/html; charset=utf-8";

/// Answers about one job.
pub struct RunAnswers {
    job: JobFiles,
    board: Arc<StateBoard>,
    store: Arc<FrameStore>,
}

impl RunAnswers {
    pub fn new(job: JobFiles, board: Arc<StateBoard>, store: Arc<FrameStore>) -> RunAnswers {
        RunAnswers { job, board, store }
    }

    fn response(&self, path: &str, request: &Request) -> Result<Response, Refusal> {
        let number = |name: &str| {
            request.number(name).ok_or_else(|| Refusal::new(400, format!("the query must have `{name}=number`")))
        };
        match path {
            "" => Ok(Response::new(HTML, self.page().into_bytes())),
            "report" => self.report(),
            "mesh" => Ok(Response::new(BYTES, self.store.frame(number("frame")?, None)?.mesh.bytes())),
            "frame" => {
                let frame = self.store.frame(number("frame")?, request.number("field"))?;
                let body = frame.bytes(request.number("shape").is_some());
                Ok(Response { reading: Some(frame.reading), ..Response::new(BYTES, body) })
            }
            "trace" => {
                let (from, picked, field) = (number("from")?, (number("mesh")?, number("cell")?), number("field")?);
                let end = number("to")?.min(from.saturating_add(TRACE));
                Ok(Response::new(BYTES, self.store.trace(picked, field, from..end)?))
            }
            "state" => {
                let state = self.store.state(number("cell")?, number("frame")?)?;
                Ok(Response::new(JSON, json!(state).to_string().into_bytes()))
            }
            _ => Err(Refusal::new(404, "there is no such page")),
        }
    }

    fn page(&self) -> String {
        let data = json!({"name": self.job.name, "folder": self.job.folder, "version": env!("CARGO_PKG_VERSION")});
        let (style, script) = ([STYLE, VIEW_STYLE].concat(), SCRIPTS.concat());
        let (title, data) = (self.job.name.as_str(), data.to_string());
        PageContents { title, style: &style, script: &script, data: &data, permissions: "connect-src 'self'; " }.html()
    }

    fn report(&self) -> Result<Response, Refusal> {
        let html = report::gather(&self.job.folder).and_then(|page| report::html(&page));
        let html = html.map_err(|why| Refusal::new(500, why.to_string()))?;
        Ok(Response::new(HTML, html.into_bytes()))
    }

    /// Sends events until the page is closed.
    fn send_events(&self, stream: &mut TcpStream) -> io::Result<()> {
        let Some(_counted) = self.board.join(STREAMS) else {
            return Response::refused(&Refusal::new(503, "too many pages are open")).write(stream);
        };
        write_bytes(stream, head(200, "text/event-stream", "").as_bytes())?;
        let mut seen = 0;
        loop {
            let (revision, parts) = self.board.changes_after(seen, ALIVE);
            seen = revision;
            let events = parts.iter().map(|(name, json)| format!("event: {name}\ndata: {json}\n\n"));
            let events = if parts.is_empty() { ":\n\n".to_owned() } else { events.collect() };
            write_bytes(stream, events.as_bytes())?;
        }
    }
}

impl Answers for RunAnswers {
    fn answer(&self, path: &str, request: &Request, stream: &mut TcpStream) -> io::Result<()> {
        if path == "events" {
            return self.send_events(stream);
        }
        self.response(path, request).unwrap_or_else(|refusal| Response::refused(&refusal)).write(stream)
    }
}
