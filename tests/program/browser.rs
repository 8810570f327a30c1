//! Chromium without a window, controlled over pipes by its debugging protocol: pages at any width, light or dark, as
//! pictures and as results of their scripts. Source: the Chrome DevTools Protocol, `Target`, `Page`, `Emulation`,
//! `Network`, `Runtime`.

use std::fs::{File, OpenOptions};
use std::io::{BufRead as _, BufReader, Write as _};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};
use tiny_skia::Pixmap;

/// Time without an answer after which a browser or a server counts as failed.
pub const SILENCE: Duration = Duration::from_secs(120);

/// Size and colour scheme in which a page is shown.
#[derive(Clone, Copy, Debug)]
pub struct PageView {
    /// Width in CSS pixels.
    pub width: u32,
    /// Whether the reader prefers a dark theme.
    pub dark: bool,
}

/// A browser with one page.
pub struct HeadlessBrowser {
    child: Child,
    to: File,
    from: Receiver<Value>,
    session: String,
    number: u64,
    /// Addresses requested by the page, and exceptions of its scripts.
    pub requests: Vec<String>,
    pub errors: Vec<String>,
    _folder: tempfile::TempDir,
}

impl HeadlessBrowser {
    /// Starts the browser; returns `None` with a printed note if it is not installed. CI requires it.
    pub fn start() -> Option<HeadlessBrowser> {
        let names = ["chromium", "google-chrome", "chromium-browser", "chrome"];
        let runs = |name: &&&str| Command::new(name).arg("--version").output().is_ok_and(|o| o.status.success());
        let found = names.iter().find(runs);
        assert!(found.is_some() || std::env::var_os("CI").is_none(), "in CI chromium must be installed");
        let Some(name) = found else {
            println!("left out: pages in a browser (no chromium)");
            return None;
        };
        let folder = tempfile::tempdir().expect("a folder");
        let (to, from) = (folder.path().join("to"), folder.path().join("from"));
        assert!(Command::new("mkfifo").args([&to, &from]).status().expect("mkfifo runs").success());
        // The browser reads commands from file 3 and writes answers to file 4.
        let child = Command::new("sh")
            .args(["-c", "p=$1 t=$2 f=$3; shift 3; exec \"$p\" \"$@\" 3<\"$t\" 4>\"$f\"", "sh", name])
            .args([&to, &from])
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run"])
            // WebGL without a graphics processor.
            .args(["--use-angle=swiftshader", "--enable-unsafe-swiftshader"])
            .args(["--hide-scrollbars", "--remote-debugging-pipe"])
            .arg(format!("--user-data-dir={}", folder.path().join("profile").display()))
            .stderr(Stdio::null())
            .spawn()
            .expect("the browser starts");
        let to = OpenOptions::new().write(true).open(to).expect("a pipe");
        let from = listen(File::open(from).expect("a pipe"));
        let (session, number, requests, errors) = (String::new(), 0, Vec::new(), Vec::new());
        let mut browser = HeadlessBrowser { child, to, from, session, number, requests, errors, _folder: folder };
        let target = browser.ask("Target.createTarget", json!({"url": "about:blank"}));
        let attached = browser.ask("Target.attachToTarget", json!({"targetId": target["targetId"], "flatten": true}));
        browser.session = attached["sessionId"].as_str().expect("a session").to_owned();
        ["Page.enable", "Network.enable", "Runtime.enable"].iter().for_each(|m| drop(browser.ask(m, json!({}))));
        Some(browser)
    }

    /// Opens the page of a file; `fragment` is the part of the address after `#`.
    pub fn open(&mut self, page: &Path, fragment: &str, view: PageView) {
        self.open_address(&format!("file://{}{fragment}", page.display()), view);
    }

    /// Opens the page of an address.
    pub fn open_address(&mut self, address: &str, view: PageView) {
        let PageView { width, dark } = view;
        let metrics = json!({"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": false});
        self.ask("Emulation.setDeviceMetricsOverride", metrics);
        let scheme = if dark { "dark" } else { "light" };
        let features = json!([{"name": "prefers-color-scheme", "value": scheme}]);
        self.ask("Emulation.setEmulatedMedia", json!({"features": features}));
        // A change of the fragment alone would not reload the page.
        self.go("about:blank");
        (self.requests, self.errors) = (Vec::new(), Vec::new());
        self.go(address);
        self.requests.remove(0);
    }

    fn go(&mut self, address: &str) {
        self.ask("Page.navigate", json!({"url": address}));
        while self.hear()["method"] != "Page.loadEventFired" {}
    }

    /// Returns the value of a JavaScript expression in the page.
    pub fn value(&mut self, expression: &str) -> Value {
        let requested = json!({"expression": expression, "returnByValue": true, "awaitPromise": true});
        let answer = self.ask("Runtime.evaluate", requested);
        assert!(answer.get("exceptionDetails").is_none(), "{expression}: {answer}");
        answer["result"]["value"].clone()
    }

    /// Returns the result of the test script of a page.
    pub fn self_test(&mut self, page: &Path, view: PageView) -> Value {
        self.open(page, "", view);
        let text = self.value(include_str!("page_test.js"));
        serde_json::from_str(text.as_str().expect("the page tested itself")).expect("JSON")
    }

    /// Returns a picture of the first element that matches a selector.
    pub fn picture(&mut self, selector: &str) -> Pixmap {
        let box_ = self.value(&format!(
            "(() => {{ const b = document.querySelector({selector:?}).getBoundingClientRect(); \
             return {{ x: b.x + scrollX, y: b.y + scrollY, width: b.width, height: b.height, scale: 1 }}; }})()"
        ));
        let requested = json!({"format": "png", "captureBeyondViewport": true, "clip": box_});
        let answer = self.ask("Page.captureScreenshot", requested);
        let bytes = STANDARD.decode(answer["data"].as_str().expect("a picture")).expect("base64");
        Pixmap::decode_png(&bytes).expect("PNG")
    }

    /// Sends a command and waits for its answer.
    fn ask(&mut self, method: &str, parameters: Value) -> Value {
        self.number += 1;
        let mut message = json!({"id": self.number, "method": method, "params": parameters});
        if !self.session.is_empty() {
            message["sessionId"] = self.session.clone().into();
        }
        self.to.write_all(format!("{message}\0").as_bytes()).expect("the browser listens");
        loop {
            let mut answer = self.hear();
            if answer["id"] == self.number {
                assert!(answer.get("error").is_none(), "{method}: {answer}");
                return answer["result"].take();
            }
        }
    }

    /// Returns the next message; requests and exceptions are recorded.
    fn hear(&mut self) -> Value {
        let message = self.from.recv_timeout(SILENCE).expect("the browser answers");
        let parameters = &message["params"];
        match message["method"].as_str() {
            Some("Network.requestWillBeSent") => {
                // Pictures inside the page are no requests.
                let url = parameters["request"]["url"].as_str().unwrap_or_default();
                self.requests.extend((!url.starts_with("data:")).then(|| url.to_owned()));
            }
            Some("Runtime.exceptionThrown") => self.errors.push(parameters["exceptionDetails"].to_string()),
            _ => {}
        }
        message
    }
}

impl Drop for HeadlessBrowser {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Receives messages, each ended by a zero byte.
fn listen(from: File) -> Receiver<Value> {
    let (send, receive) = channel();
    std::thread::spawn(move || {
        let mut from = BufReader::new(from);
        let mut bytes = Vec::new();
        while from.read_until(0, &mut bytes).is_ok_and(|n| n > 0) {
            bytes.pop();
            let Ok(message) = serde_json::from_slice(&bytes) else { return };
            if send.send(message).is_err() {
                return;
            }
            bytes.clear();
        }
    });
    receive
}
