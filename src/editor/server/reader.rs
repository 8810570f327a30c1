//! Messages of the client: header lines, an empty line, and JSON-RPC 2.0 of the stated length (Language Server Protocol 3.17,
//! "Base Protocol"). A malformed message is answered with an error, and the next one is read.

use std::io::{self, BufRead, Read, Write};

use lsp_server::{ErrorCode, Message};
use serde_json::{Value, json};

/// Largest number of bytes of a message; a longer one is skipped.
const MOST_BYTES: u64 = 1 << 28;
/// Largest number of bytes of a header line.
const LONGEST_LINE: u64 = 4096;

/// Result of reading from the stream.
pub enum Incoming {
    /// A message.
    Message(Message),
    /// Something else, and its answer.
    Malformed(ProtocolError),
}

/// Answer to a malformed message.
pub struct ProtocolError {
    /// Identifier of the request; null if it cannot be read.
    id: Value,
    code: ErrorCode,
    message: String,
}

impl ProtocolError {
    fn without_id(code: ErrorCode, message: impl Into<String>) -> Incoming {
        Incoming::Malformed(ProtocolError { id: Value::Null, code, message: message.into() })
    }

    /// Writes the answer.
    ///
    /// # Errors
    /// If the stream fails.
    pub fn write(&self, output: &mut impl Write) -> io::Result<()> {
        let error = json!({ "code": self.code as i32, "message": self.message });
        let text = json!({ "jsonrpc": "2.0", "id": self.id, "error": error }).to_string();
        write!(output, "Content-Length: {}\r\n\r\n{text}", text.len())?;
        output.flush()
    }
}

/// Reads the next message; `None` at the end of the stream.
///
/// # Errors
/// If the stream fails or ends within a message.
pub fn read(input: &mut impl BufRead) -> io::Result<Option<Incoming>> {
    let mut length: Option<u64> = None;
    loop {
        let mut line = Vec::new();
        if input.take(LONGEST_LINE).read_until(b'\n', &mut line)? == 0 {
            return Ok(None);
        }
        let text = String::from_utf8_lossy(&line);
        let text = text.trim_end();
        if text.is_empty() {
            break;
        }
        let Some((name, value)) = text.split_once(':') else {
            let message = "malformed header line: expected `Content-Length: ` and the number of bytes";
            return Ok(Some(ProtocolError::without_id(ErrorCode::ParseError, message)));
        };
        if name.eq_ignore_ascii_case("Content-Length") {
            length = value.trim().parse().ok();
        }
    }
    let Some(length) = length else {
        return Ok(Some(ProtocolError::without_id(ErrorCode::ParseError, "the header has no valid Content-Length")));
    };
    let mut body = Vec::new();
    if length > MOST_BYTES {
        io::copy(&mut input.take(length), &mut io::sink())?;
        let message = format!("the message has {length} bytes; at most {MOST_BYTES} are read");
        return Ok(Some(ProtocolError::without_id(ErrorCode::InvalidRequest, message)));
    }
    if input.take(length).read_to_end(&mut body)? as u64 != length {
        return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "the stream ends within a message"));
    }
    Ok(Some(message_of(&body)))
}

fn message_of(body: &[u8]) -> Incoming {
    let value: Value = match serde_json::from_slice(body) {
        Ok(value) => value,
        Err(why) => return ProtocolError::without_id(ErrorCode::ParseError, format!("the message is not JSON: {why}")),
    };
    let id = value.get("id").filter(|id| id.is_i64() || id.is_string()).cloned().unwrap_or_default();
    // A response may lack both its result and its error for the library, which ignores other keys.
    let has_kind = match value.get("method") {
        Some(method) => method.is_string(),
        None => value.get("result").or(value.get("error")).is_some(),
    };
    let message = if has_kind { serde_json::from_value(value).ok() } else { None };
    message.map_or_else(
        || {
            let message = "expected a request, notification or response of JSON-RPC 2.0".to_owned();
            Incoming::Malformed(ProtocolError { id, code: ErrorCode::InvalidRequest, message })
        },
        Incoming::Message,
    )
}

#[cfg(test)]
mod tests {
    use super::{Incoming, read};

    /// Codes of JSON-RPC 2.0, section 5.1.
    #[test]
    fn malformed_messages_have_the_codes_of_json_rpc() {
        let framed = |text: &str| format!("Content-Length: {}\r\n\r\n{text}", text.len());
        let exit = framed(r#"{"jsonrpc":"2.0","method":"exit"}"#);
        let cases = [
            (framed("{"), -32700, "null"),
            (framed("[1,"), -32700, "null"),
            ("nonsense\r\n".to_owned(), -32700, "null"),
            ("Content-Length: many\r\n\r\n".to_owned(), -32700, "null"),
            ("Content-Type: text\r\n\r\n".to_owned(), -32700, "null"),
            (framed("[]"), -32600, "null"),
            (framed("1"), -32600, "null"),
            (framed(r#"{"id":7,"method":1}"#), -32600, "7"),
            (framed(r#"{"id":"a","method":[]}"#), -32600, "\"a\""),
            (framed(&"[".repeat(100_000)), -32700, "null"),
        ];
        for (text, code, id) in cases {
            let both = text.clone() + &exit;
            let mut input = both.as_bytes();
            let Some(Incoming::Malformed(error)) = read(&mut input).expect("a stream") else { panic!("{text:.60}") };
            assert_eq!((error.code as i32, error.id.to_string()), (code, id.to_owned()), "{text:.60}");
            let mut answer = Vec::new();
            error.write(&mut answer).expect("a stream");
            assert!(String::from_utf8(answer).expect("text").contains(&format!("\"code\":{code}")));
            assert!(matches!(read(&mut input), Ok(Some(Incoming::Message(_)))), "{text:.60}");
        }
        assert!(read(&mut &b"Content-Length: 9\r\n\r\n{"[..]).is_err());
        assert!(matches!(read(&mut &b""[..]), Ok(None)));
    }
}
