//! Dispatch of the messages of a client: the phases of a session and notifications. Requests about files are answered in
//! `answers.rs`.

use lsp_server::{ErrorCode, Message, Notification, Request, Response, ResponseError};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::capabilities::{chosen_encoding, initialize_result};
use super::state::{ServerState, SessionPhase};
use crate::features::completion::resolved_item;
use crate::protocol::InitializeParams;

/// Files of decks: decks, included files and mesh files.
const WATCHED_FILES: &str = "**/*.{inp,inc,dat,txt,csv,msh,vtk,vtu}";

pub type RequestResult = Result<Value, ResponseError>;

impl ServerState {
    /// Handles a message.
    pub fn receive(&mut self, message: Message) {
        match message {
            Message::Request(Request { id, method, params }) => {
                let (result, error) = match self.answer(&method, params) {
                    Ok(result) => (Some(result), None),
                    Err(error) => (None, Some(error)),
                };
                self.outbox.push(Response { id, result, error }.into());
            }
            Message::Notification(Notification { method, params }) => self.take_notification(&method, params),
            // The server sends no requests whose response matters.
            Message::Response(_) => {}
        }
    }

    fn answer(&mut self, method: &str, params: Value) -> RequestResult {
        match (self.phase, method) {
            (SessionPhase::Starting, "initialize") => self.initialize(params),
            (SessionPhase::Starting, _) => Err(error(ErrorCode::ServerNotInitialized, "send `initialize` first")),
            (SessionPhase::Running, "shutdown") => {
                self.phase = SessionPhase::ShutDown;
                Ok(Value::Null)
            }
            (SessionPhase::Running, "completionItem/resolve") if params.is_object() => Ok(resolved_item(params)),
            (SessionPhase::Running, _) => {
                self.update_outlines();
                self.answer_about_document(method, params)
            }
            _ => Err(error(ErrorCode::InvalidRequest, "the server has been shut down")),
        }
    }

    fn initialize(&mut self, params: Value) -> RequestResult {
        let params: InitializeParams = parameters(params)?;
        self.encoding = chosen_encoding(&params.capabilities);
        self.options = params.initialization_options.unwrap_or_default();
        self.client = params.capabilities;
        self.phase = SessionPhase::Running;
        Ok(initialize_result(self.encoding))
    }

    /// Asks the client to report changes of files on disk, if it can.
    fn watch_files(&mut self) {
        if self.client.pointer("/workspace/didChangeWatchedFiles/dynamicRegistration") != Some(&Value::Bool(true)) {
            return;
        }
        let method = "workspace/didChangeWatchedFiles";
        let options = json!({ "watchers": [{ "globPattern": WATCHED_FILES }] });
        let registration = json!({ "id": "files", "method": method, "registerOptions": options });
        let (id, method) = ("register-files".to_owned().into(), "client/registerCapability".into());
        self.outbox.push(Request { id, method, params: json!({ "registrations": [registration] }) }.into());
    }

    fn take_notification(&mut self, method: &str, params: Value) {
        if method == "exit" {
            self.phase = SessionPhase::Exited { after_shutdown: self.phase == SessionPhase::ShutDown };
            return;
        }
        if self.phase != SessionPhase::Running {
            return;
        }
        // Notifications have no response: those with invalid arguments are ignored.
        match method {
            "initialized" => self.watch_files(),
            "textDocument/didOpen" => drop(parameters(params).map(|params| self.open(params))),
            "textDocument/didChange" => drop(parameters(params).map(|params| self.change(params))),
            "textDocument/didClose" => drop(parameters(params).map(|params| self.close(&params))),
            "textDocument/didSave" | "workspace/didChangeWatchedFiles" => self.files_changed(),
            _ => {}
        }
    }
}

/// Creates the error of a request.
pub fn error(code: ErrorCode, message: impl Into<String>) -> ResponseError {
    ResponseError { code: code as i32, message: message.into(), data: None }
}

/// Converts the arguments of a message.
pub fn parameters<T: DeserializeOwned>(params: Value) -> Result<T, ResponseError> {
    serde_json::from_value(params).map_err(|e| error(ErrorCode::InvalidParams, e.to_string()))
}
