//! A client of the language server: it sends messages through a pipe, and keeps the texts of its files as an editor
//! does.

use std::collections::HashMap;
use std::io::{self, BufRead, BufReader, PipeReader, PipeWriter, Read, Write};
use std::path::Path;
use std::sync::mpsc::{Receiver, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use revolve_editor::{EditorError, serve};
use serde_json::{Value, json};

/// Time after which a message that is waited for counts as missing.
const LONGEST_WAIT: Duration = Duration::from_secs(100);

/// A session with a server on another thread.
pub struct EditorClient {
    input: Option<PipeWriter>,
    messages: Receiver<Value>,
    server: Option<JoinHandle<Result<(), EditorError>>>,
    next_id: u64,
    /// Result of `initialize`.
    pub capabilities: Value,
    /// Newest diagnostics by URI, with the version of the text.
    pub diagnostics: HashMap<String, (Option<i64>, Vec<Value>)>,
}

impl EditorClient {
    /// Starts a server without a session.
    pub fn connect() -> EditorClient {
        let (read_input, input) = io::pipe().expect("a pipe");
        let (output, write_output) = io::pipe().expect("a pipe");
        let server = std::thread::spawn(move || serve(BufReader::new(read_input), write_output));
        let (sender, messages) = channel();
        std::thread::spawn(move || {
            let mut output = BufReader::new(output);
            while let Some(message) = read_message(&mut output) {
                if sender.send(message).is_err() {
                    break;
                }
            }
        });
        EditorClient {
            input: Some(input),
            messages,
            server: Some(server),
            next_id: 0,
            capabilities: Value::Null,
            diagnostics: HashMap::new(),
        }
    }

    /// Starts a server and a session with the encodings that the client offers, and options of the server.
    pub fn start(encodings: &[&str], options: Value) -> EditorClient {
        let mut client = EditorClient::connect();
        let capabilities = json!({ "general": { "positionEncodings": encodings } });
        let params = json!({ "capabilities": capabilities, "initializationOptions": options });
        client.capabilities = client.request("initialize", params).expect("initialised");
        client.notify("initialized", json!({}));
        client
    }

    /// Sends a message.
    pub fn send(&mut self, message: &Value) {
        let text = message.to_string();
        let input = self.input.as_mut().expect("an open session");
        write!(input, "Content-Length: {}\r\n\r\n{text}", text.len()).expect("the server reads");
    }

    /// Sends a text that need not be a message.
    pub fn send_text(&mut self, text: &str) {
        self.input.as_mut().expect("an open session").write_all(text.as_bytes()).expect("the server reads");
    }

    /// Sends a notification.
    pub fn notify(&mut self, method: &str, params: Value) {
        self.send(&json!({ "jsonrpc": "2.0", "method": method, "params": params }));
    }

    /// Sends a request and returns the result, or the error.
    pub fn request(&mut self, method: &str, params: Value) -> Result<Value, Value> {
        self.next_id += 1;
        let id = self.next_id;
        self.send(&json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": params }));
        loop {
            let mut message = self.receive();
            if message["id"] == id {
                let error = message["error"].take();
                return if error.is_null() { Ok(message["result"].take()) } else { Err(error) };
            }
        }
    }

    /// Reads a message; keeps published diagnostics.
    pub fn receive(&mut self) -> Value {
        let message = self.messages.recv_timeout(LONGEST_WAIT);
        let message = message.unwrap_or_else(|_| panic!("no message; diagnostics: {:#?}", self.diagnostics));
        if message["method"] == "textDocument/publishDiagnostics" {
            let params = &message["params"];
            let uri = params["uri"].as_str().expect("a URI").to_owned();
            let list = params["diagnostics"].as_array().expect("a list").clone();
            self.diagnostics.insert(uri, (params["version"].as_i64(), list));
        }
        message
    }

    /// Opens a file.
    pub fn open(&mut self, uri: &str, text: &str) {
        let document = json!({ "uri": uri, "languageId": "abaqus", "version": 1, "text": text });
        self.notify("textDocument/didOpen", json!({ "textDocument": document }));
    }

    /// Sends changes of a file.
    pub fn change(&mut self, uri: &str, version: i64, changes: Value) {
        let document = json!({ "uri": uri, "version": version });
        self.notify("textDocument/didChange", json!({ "textDocument": document, "contentChanges": changes }));
    }

    /// Receives messages until the diagnostics of a file satisfy a condition.
    pub fn wait_for(&mut self, uri: &str, is_wanted: impl Fn(&[Value]) -> bool) -> Vec<Value> {
        loop {
            if let Some((_, list)) = self.diagnostics.get(uri)
                && is_wanted(list)
            {
                return list.clone();
            }
            self.receive();
        }
    }

    /// Asks about a position.
    pub fn ask(&mut self, method: &str, uri: &str, [line, character]: [u32; 2]) -> Value {
        let position = json!({ "line": line, "character": character });
        let context = json!({ "includeDeclaration": true });
        let params = json!({ "textDocument": { "uri": uri }, "position": position, "context": context });
        self.request(&format!("textDocument/{method}"), params).expect("an answer")
    }

    /// Asks about a file.
    pub fn ask_file(&mut self, method: &str, uri: &str) -> Value {
        let params = json!({ "textDocument": { "uri": uri } });
        self.request(&format!("textDocument/{method}"), params).expect("an answer")
    }

    /// Ends the session and returns the result of the server.
    pub fn finish(mut self) -> Result<(), EditorError> {
        self.request("shutdown", Value::Null).expect("shut down");
        self.notify("exit", Value::Null);
        self.end()
    }

    /// Ends the stream and returns the result of the server.
    pub fn end(&mut self) -> Result<(), EditorError> {
        self.input = None;
        self.server.take().expect("a server").join().expect("no panic")
    }
}

/// Reads a message; `None` at the end of the stream.
fn read_message(output: &mut BufReader<PipeReader>) -> Option<Value> {
    let mut length = 0;
    loop {
        let mut line = String::new();
        if output.read_line(&mut line).expect("the server writes") == 0 {
            return None;
        }
        match line.trim_end().strip_prefix("Content-Length: ") {
            Some(number) => length = number.parse().expect("a length"),
            None if line.trim_end().is_empty() => break,
            None => panic!("unknown header {line}"),
        }
    }
    let mut bytes = vec![0; length];
    output.read_exact(&mut bytes).expect("a message");
    Some(serde_json::from_slice(&bytes).expect("JSON"))
}

/// Returns the URI of a file.
pub fn uri(path: &Path) -> String {
    format!("file://{}", path.display())
}

/// Returns the code, first and last line and column of a diagnostic.
pub fn place(diagnostic: &Value) -> (String, [u64; 4]) {
    let number = |path: &str| diagnostic.pointer(path).and_then(Value::as_u64).expect("a number");
    let places = ["/range/start/line", "/range/start/character", "/range/end/line", "/range/end/character"];
    (diagnostic["code"].as_str().expect("a code").to_owned(), places.map(number))
}
