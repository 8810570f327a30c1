//! Requests and responses of HTTP/1.1 (RFC 9112), as far as a view needs them: GET without a body, one request per
//! connection. Sizes and times are bounded.

use std::io::{self, ErrorKind, Read as _, Write as _};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Largest size of a request in bytes.
const REQUEST_BYTES: usize = 8 << 10;
/// Bytes that are written at a time.
const PART: usize = 64 << 10;
/// Longest time to send a request.
pub const REQUEST_TIME: Duration = Duration::from_secs(5);
/// Time to receive a response: a constant, and a rate in bytes per second.
const RESPONSE_TIME: Duration = Duration::from_secs(10);
const RATE: f64 = 50e3;

/// Reason why a request gets no content: status and explanation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    pub status: u16,
    pub reason: String,
}

impl Refusal {
    pub fn new(status: u16, reason: impl Into<String>) -> Refusal {
        Refusal { status, reason: reason.into() }
    }
}

/// Request with the parts that are used.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Request {
    pub path: String,
    /// Names and values after the question mark.
    pub query: Vec<(String, usize)>,
    pub host: String,
    pub origin: Option<String>,
}

impl Request {
    /// Returns a value of the query.
    pub fn number(&self, name: &str) -> Option<usize> {
        self.query.iter().find(|(known, _)| known == name).map(|found| found.1)
    }

    /// Parses the text of a request up to its empty line.
    ///
    /// # Errors
    /// If it is not a GET request of HTTP/1 without a body.
    pub fn parse(text: &str) -> Result<Request, Refusal> {
        let wrong = |reason: &str| Refusal::new(400, reason);
        let mut lines = text.split("\r\n");
        let first: Vec<&str> = lines.next().unwrap_or_default().split(' ').collect();
        let [method, target, version] = first[..] else { return Err(wrong("the request line is invalid")) };
        if method != "GET" {
            return Err(Refusal::new(405, "only GET is supported"));
        }
        if !version.starts_with("HTTP/1.") || !target.starts_with('/') {
            return Err(wrong("the request line is invalid"));
        }
        let (path, query) = target.split_once('?').unwrap_or((target, ""));
        let mut request = Request { path: path.to_owned(), query: numbers(query)?, ..Request::default() };
        let mut hosts = 0;
        for line in lines.filter(|line| !line.is_empty()) {
            let (name, value) = line.split_once(':').ok_or_else(|| wrong("a header is invalid"))?;
            match name.to_ascii_lowercase().as_str() {
                "host" => (request.host, hosts) = (value.trim().to_owned(), hosts + 1),
                "origin" => request.origin = Some(value.trim().to_owned()),
                "content-length" if value.trim() == "0" => {}
                "content-length" | "transfer-encoding" => return Err(wrong("a request has no body here")),
                _ => {}
            }
        }
        if hosts == 1 { Ok(request) } else { Err(wrong("expected one header Host")) }
    }
}

/// Parses `name=number&…`.
fn numbers(query: &str) -> Result<Vec<(String, usize)>, Refusal> {
    let pair = |text: &str| {
        let (name, value) = text.split_once('=')?;
        Some((name.to_owned(), value.parse().ok()?))
    };
    let pairs = query.split('&').filter(|text| !text.is_empty());
    pairs.map(pair).collect::<Option<_>>().ok_or_else(|| Refusal::new(400, "the query is invalid"))
}

/// Reads a request.
///
/// # Errors
/// The refusal to send; `None` if the connection has ended.
pub fn read_request(stream: &mut TcpStream, within: Duration) -> Result<Request, Option<Refusal>> {
    let deadline = Instant::now() + within;
    let (mut bytes, mut part) = (Vec::new(), [0; 1024]);
    loop {
        let remaining = deadline.saturating_duration_since(Instant::now());
        if remaining.is_zero() {
            return Err(Some(Refusal::new(408, "the request is incomplete")));
        }
        stream.set_read_timeout(Some(remaining)).map_err(|_| None)?;
        match stream.read(&mut part) {
            Ok(0) => return Err(None),
            Ok(count) => bytes.extend_from_slice(&part[..count]),
            Err(e) if is_waiting(&e) => continue,
            Err(_) => return Err(None),
        }
        if let Some(end) = bytes.windows(4).position(|four| four == b"\r\n\r\n") {
            let text = std::str::from_utf8(&bytes[..end]).map_err(|_| Refusal::new(400, "the request is not text"))?;
            return Ok(Request::parse(text)?);
        }
        if bytes.len() > REQUEST_BYTES {
            return Err(Some(Refusal::new(431, "the request is too large")));
        }
    }
}

fn is_waiting(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}

/// Writes bytes; a reader that is too slow is an error.
///
/// # Errors
/// If the connection has ended, or the bytes are not received in time.
pub fn write_bytes(stream: &mut TcpStream, bytes: &[u8]) -> io::Result<()> {
    let allowed = RESPONSE_TIME + Duration::from_secs_f64(bytes.len() as f64 / RATE);
    write_within(stream, bytes, allowed)
}

fn write_within(stream: &mut TcpStream, mut bytes: &[u8], within: Duration) -> io::Result<()> {
    let deadline = Instant::now() + within;
    while !bytes.is_empty() {
        let remaining = deadline.saturating_duration_since(Instant::now());
        if remaining.is_zero() {
            return Err(ErrorKind::TimedOut.into());
        }
        stream.set_write_timeout(Some(remaining))?;
        match stream.write(&bytes[..bytes.len().min(PART)]) {
            Ok(0) => return Err(ErrorKind::WriteZero.into()),
            Ok(count) => bytes = &bytes[count..],
            Err(e) if is_waiting(&e) => {}
            Err(e) => return Err(e),
        }
    }
    Ok(())
}

/// Response with its content.
#[derive(Clone, Debug)]
pub struct Response {
    pub status: u16,
    pub content_type: &'static str,
    pub body: Vec<u8>,
    /// Time to read the files.
    pub reading: Option<Duration>,
}

impl Response {
    pub fn new(content_type: &'static str, body: Vec<u8>) -> Response {
        Response { status: 200, content_type, body, reading: None }
    }

    pub fn refused(refusal: &Refusal) -> Response {
        let body = format!("{}\n", refusal.reason).into_bytes();
        Response { status: refusal.status, ..Response::new("text/plain; charset=utf-8", body) }
    }

    /// Writes the response and ends the connection.
    ///
    /// # Errors
    /// If the connection has ended, or the response is not received in time.
    pub fn write(&self, stream: &mut TcpStream) -> io::Result<()> {
        let reading = self.reading.map(|time| format!("Server-Timing: read;dur={:.3}\r\n", 1e3 * time.as_secs_f64()));
        let length = format!("Content-Length: {}\r\n{}", self.body.len(), reading.unwrap_or_default());
        let mut bytes = head(self.status, self.content_type, &length).into_bytes();
        bytes.extend_from_slice(&self.body);
        write_bytes(stream, &bytes)
    }
}

/// Returns the first lines of a response. Nothing is stored by the browser, used by pages of others, or framed by pages of
/// other machines.
pub fn head(status: u16, content_type: &str, more: &str) -> String {
    let meaning = match status {
        200 => "OK",
        400 => "Bad Request",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        408 => "Request Timeout",
        431 => "Request Header Fields Too Large",
        503 => "Service Unavailable",
        _ => "Internal Server Error",
    };
    format!(
        "HTTP/1.1 {status} {meaning}\r\nContent-Type: {content_type}\r\n{more}Connection: close\r\nCache-Control: no-store, no-transform\r\n\
         X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
         Content-Security-Policy: frame-ancestors 'self' http://127.0.0.1:* http://localhost:*\r\n\r\n"
    )
}

#[cfg(test)]
mod tests {
    use std::net::{TcpListener, TcpStream};

    use super::*;

    fn parse(line: &str) -> Result<Request, u16> {
        Request::parse(&format!("{line}\r\nHost: localhost:1\r\nOrigin: null")).map_err(|refusal| refusal.status)
    }

    #[test]
    fn only_get_requests_without_a_body_are_accepted() {
        let request = parse("GET /a/frame?frame=3&field=0 HTTP/1.1").expect("a request");
        assert_eq!((request.path.as_str(), request.number("frame"), request.number("x")), ("/a/frame", Some(3), None));
        assert_eq!((request.host.as_str(), request.origin.as_deref()), ("localhost:1", Some("null")));
        for (line, status) in [
            ("POST / HTTP/1.1", 405),
            ("GET / HTTP/2", 400),
            ("GET http://localhost/ HTTP/1.1", 400),
            ("GET /?a HTTP/1.1", 400),
            ("GET /?a=-1 HTTP/1.1", 400),
            ("GET  / HTTP/1.1", 400),
            ("GET / HTTP/1.1\r\nContent-Length: 4", 400),
            ("GET / HTTP/1.1\r\nHost: localhost", 400),
            ("", 400),
        ] {
            assert_eq!(parse(line), Err(status), "{line}");
        }
    }

    /// The reader receives nothing: the writer ends after its time, although the response is not written.
    #[test]
    fn slow_reader_does_not_hold_the_writer() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let reader = TcpStream::connect(listener.local_addr().expect("an address")).expect("a connection");
        let (mut writer, _) = listener.accept().expect("a connection");
        let more_than_the_system_stores = vec![0; 64 << 20];
        let written = write_within(&mut writer, &more_than_the_system_stores, Duration::from_millis(50));
        assert_eq!(written.map_err(|e| e.kind()), Err(ErrorKind::TimedOut));
        drop(reader);
    }

    #[test]
    fn slow_and_endless_requests_are_refused() {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let mut sender = TcpStream::connect(listener.local_addr().expect("an address")).expect("a connection");
        let (mut stream, _) = listener.accept().expect("a connection");
        sender.write_all(b"GET / HTT").expect("written");
        let read = read_request(&mut stream, Duration::from_millis(50));
        assert_eq!(read, Err(Some(Refusal::new(408, "the request is incomplete"))));
        sender.write_all(&vec![b'a'; 2 * REQUEST_BYTES]).expect("written");
        let read = read_request(&mut stream, Duration::from_secs(60));
        assert_eq!(read.map_err(|refusal| refusal.map(|r| r.status)), Err(Some(431)));
    }
}
