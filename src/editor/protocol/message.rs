//! Messages of JSON-RPC 2.0 with a header of their length.

use std::io::{self, BufRead, Write};

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// Identification of a request: a number or a text.
pub type RequestId = Value;

/// Longest message, bytes.
const LONGEST: usize = 1 << 30;

/// A message of the client or of the server.
#[derive(Clone, Debug, PartialEq)]
pub enum ProtocolMessage {
    Request {
        /// Identification that the response repeats.
        id: RequestId,
        method: String,
        params: Value,
    },
    Notification {
        method: String,
        params: Value,
    },
    Response {
        id: RequestId,
        result: Result<Value, ResponseError>,
    },
}

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ResponseError {
    /// Number of the error, one of [`ErrorCode`].
    pub code: i64,
    /// Description in one sentence.
    pub message: String,
}

/// Numbers of errors that the protocol defines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorCode {
    InvalidRequest = -32600,
    MethodNotFound = -32601,
    InvalidParams = -32602,
    /// A request before `initialize`.
    ServerNotInitialized = -32002,
    /// The request is valid, but cannot be fulfilled.
    RequestFailed = -32803,
}

impl ResponseError {
    pub fn new(code: ErrorCode, message: impl Into<String>) -> ResponseError {
        ResponseError { code: code as i64, message: message.into() }
    }
}

/// Reads a message; `None` at the end of the stream.
///
/// # Errors
/// If the stream fails, or its bytes are not a message with a header and an object of JSON.
pub fn read_message(input: &mut dyn BufRead) -> io::Result<Option<ProtocolMessage>> {
    let invalid = |text: &str| io::Error::new(io::ErrorKind::InvalidData, text.to_owned());
    let mut length = None;
    loop {
        let mut line = String::new();
        if input.read_line(&mut line)? == 0 {
            return Ok(None);
        }
        let line = line.trim_end();
        if line.is_empty() {
            break;
        }
        if let Some((name, value)) = line.split_once(':')
            && name.eq_ignore_ascii_case("Content-Length")
        {
            length = value.trim().parse().ok().filter(|length| *length <= LONGEST);
        }
    }
    let length = length.ok_or_else(|| invalid("a message has no valid Content-Length"))?;
    let mut bytes = vec![0; length];
    input.read_exact(&mut bytes)?;
    let value: Value = serde_json::from_slice(&bytes).map_err(|e| invalid(&format!("a message is not JSON: {e}")))?;
    message(value).map(Some).ok_or_else(|| invalid("a message is neither request nor response"))
}

fn message(mut value: Value) -> Option<ProtocolMessage> {
    let object = value.as_object_mut()?;
    let id = object.remove("id");
    let params = object.remove("params").unwrap_or(Value::Null);
    match (object.remove("method"), id) {
        (Some(Value::String(method)), Some(id)) => Some(ProtocolMessage::Request { id, method, params }),
        (Some(Value::String(method)), None) => Some(ProtocolMessage::Notification { method, params }),
        (None, Some(id)) => {
            let error = object.remove("error").map(serde_json::from_value::<ResponseError>);
            let result = match error {
                Some(error) => Err(error.ok()?),
                None => Ok(object.remove("result").unwrap_or(Value::Null)),
            };
            Some(ProtocolMessage::Response { id, result })
        }
        _ => None,
    }
}

/// Writes a message.
///
/// # Errors
/// If the stream fails.
pub fn write_message(output: &mut dyn Write, message: &ProtocolMessage) -> io::Result<()> {
    let value = match message {
        ProtocolMessage::Request { id, method, params } => {
            json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": params })
        }
        ProtocolMessage::Notification { method, params } => {
            json!({ "jsonrpc": "2.0", "method": method, "params": params })
        }
        ProtocolMessage::Response { id, result: Ok(result) } => json!({ "jsonrpc": "2.0", "id": id, "result": result }),
        ProtocolMessage::Response { id, result: Err(error) } => json!({ "jsonrpc": "2.0", "id": id, "error": error }),
    };
    let bytes = serde_json::to_vec(&value)?;
    write!(output, "Content-Length: {}\r\n\r\n", bytes.len())?;
    output.write_all(&bytes)?;
    output.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_read_as_written() {
        let messages = [
            ProtocolMessage::Request { id: json!(7), method: "initialize".into(), params: json!({"a": "\u{e4}"}) },
            ProtocolMessage::Notification { method: "exit".into(), params: Value::Null },
            ProtocolMessage::Response { id: json!("x"), result: Ok(json!([1])) },
            ProtocolMessage::Response { id: json!(8), result: Err(ResponseError::new(ErrorCode::InvalidParams, "no")) },
        ];
        let mut bytes = Vec::new();
        messages.iter().for_each(|message| write_message(&mut bytes, message).expect("written"));
        let mut input = &bytes[..];
        for message in &messages {
            assert_eq!(read_message(&mut input).expect("read").as_ref(), Some(message));
        }
        assert!(read_message(&mut input).expect("end").is_none());
        for bad in ["Content-Length: x\r\n\r\n{}", "Content-Length: 2\r\n\r\n[]", "Content-Length: 9\r\n\r\n{}"] {
            assert!(read_message(&mut bad.as_bytes()).is_err(), "{bad}");
        }
    }
}
