//! Start and end of a session, and messages out of order.

use serde_json::{Value, json};

use crate::client::{EditorClient, uri};

#[test]
fn session_starts_and_ends() {
    let client = EditorClient::start(&["utf-16"], Value::Null);
    assert_eq!(client.capabilities["serverInfo"]["name"], "revolve");
    assert_eq!(client.capabilities["capabilities"]["positionEncoding"], "utf-16");
    assert!(client.finish().is_ok());
    let client = EditorClient::start(&["utf-16", "utf-8"], json!({ "mode": "revolve" }));
    assert_eq!(client.capabilities["capabilities"]["positionEncoding"], "utf-8");
    assert!(client.finish().is_ok());
}

#[test]
fn requests_out_of_order_are_errors() {
    let mut client = EditorClient::connect();
    let error = client.request("textDocument/hover", json!({})).expect_err("not initialised");
    assert_eq!(error["code"], -32002);
    client.request("initialize", json!({ "capabilities": {} })).expect("initialised");
    let error = client.request("textDocument/hover", json!({})).expect_err("no arguments");
    assert_eq!(error["code"], -32602);
    let error = client.request("textDocument/unknown", json!({})).expect_err("unknown");
    assert_eq!(error["code"], -32601);
    let error = client.request("initialize", json!({})).expect_err("twice");
    assert_eq!(error["code"], -32601);
    client.request("shutdown", Value::Null).expect("shut down");
    let error = client.request("textDocument/hover", json!({})).expect_err("shut down");
    assert_eq!(error["code"], -32600);
    client.notify("exit", Value::Null);
    assert!(client.end().is_ok());
}

#[test]
fn end_of_the_stream_without_shutdown_is_an_error() {
    let mut client = EditorClient::start(&[], Value::Null);
    assert!(client.end().expect_err("not shut down").to_string().contains("without shutting"));
    let mut client = EditorClient::start(&[], Value::Null);
    client.notify("textDocument/didOpen", json!({ "wrong": true }));
    client.notify("exit", Value::Null);
    assert!(client.end().is_err());
}

#[test]
fn changes_of_files_on_disk_are_watched() {
    let mut client = EditorClient::connect();
    let watching = json!({ "workspace": { "didChangeWatchedFiles": { "dynamicRegistration": true } } });
    client.request("initialize", json!({ "capabilities": watching })).expect("initialised");
    client.notify("initialized", json!({}));
    let request = client.receive();
    assert_eq!(request["method"], "client/registerCapability");
    client.send(&json!({ "jsonrpc": "2.0", "id": request["id"], "result": null }));
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path().canonicalize().expect("a folder");
    let (main, part) = (folder.join("main.inp"), folder.join("part.inc"));
    client.open(&uri(&main), "*Include, input=part.inc\n*Heading\n");
    client.wait_for(&uri(&main), |found| found.iter().any(|d| d["code"] == "D002"));
    std::fs::write(part, "*Heading\n").expect("written");
    client.notify("workspace/didChangeWatchedFiles", json!({ "changes": [] }));
    client.wait_for(&uri(&main), |found| found.iter().all(|d| d["code"] != "D002"));
    assert!(client.finish().is_ok());
}

/// Codes of JSON-RPC 2.0, section 5.1. The session continues after each malformed message.
#[test]
fn malformed_messages_are_answered_and_the_session_continues() {
    let mut client = EditorClient::start(&["utf-16"], json!({}));
    let framed = |text: &str| format!("Content-Length: {}\r\n\r\n{text}", text.len());
    for (text, code) in [
        (framed("{\"id\": 1"), -32700),
        (framed("[[]]"), -32600),
        ("no header\r\n".to_owned(), -32700),
        ("Content-Length: -3\r\n\r\n".to_owned(), -32700),
        (format!("Content-Length: 400000000\r\n\r\n{}", " ".repeat(400_000_000)), -32600),
    ] {
        client.send_text(&text);
        let answer = client.receive();
        assert!(answer["error"]["code"] == code && answer["id"].is_null(), "{text:.40}: {answer}");
    }
    assert_eq!(client.request("shutdown", json!(null)), Ok(json!(null)));
}
