//! `revolve view` and `run --view`: who is refused, what a running job sends, and the page in a browser.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use revolve::user::Routines;
use serde_json::Value;

use crate::browser::{HeadlessBrowser, PageView, SILENCE};
use crate::common::{self, project, revolve};
use crate::new_meshes;

/// More connections than the server has.
const MANY: usize = 40;

/// A process that serves a view; it is killed at the end.
struct ViewProcess {
    child: Child,
    output: BufReader<std::process::ChildStdout>,
    /// `127.0.0.1:port`
    host: String,
    /// `/token/`
    path: String,
}

impl ViewProcess {
    fn start(arguments: &[&str]) -> ViewProcess {
        let mut child = Command::new(env!("CARGO_BIN_EXE_revolve"))
            .args(arguments)
            .arg("--no-browser")
            .current_dir(project(""))
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program starts");
        let mut output = BufReader::new(child.stdout.take().expect("a pipe"));
        let mut line = String::new();
        while !line.starts_with("view http://") {
            line.clear();
            assert_ne!(output.read_line(&mut line).expect("text"), 0, "the program ends without an address");
        }
        let address = line.trim().strip_prefix("view http://").expect("an address");
        let (host, path) = address.split_once('/').expect("a path");
        ViewProcess { child, output, host: host.to_owned(), path: format!("/{path}") }
    }

    /// Connects to the server, which must not be silent for longer than [`SILENCE`].
    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.host).expect("a connection");
        stream.set_read_timeout(Some(SILENCE)).expect("a limit");
        stream
    }

    /// Sends the first lines of a request; returns status, headers and body.
    fn send(&self, lines: &[&str]) -> (u16, String, Vec<u8>) {
        let mut stream = self.connect();
        stream.write_all(format!("{}\r\n\r\n", lines.join("\r\n")).as_bytes()).expect("sent");
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).expect("an answer");
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n").expect("headers");
        let head = String::from_utf8_lossy(&answer[..end]).into_owned();
        let status = head.split(' ').nth(1).and_then(|status| status.parse().ok()).expect("a status");
        (status, head, answer[end + 4..].to_vec())
    }

    /// Requests a path below the token.
    fn get(&self, path: &str) -> (u16, String, Vec<u8>) {
        self.send(&[&format!("GET {}{path} HTTP/1.1", self.path), &format!("Host: {}", self.host)])
    }

    /// Opens the stream of events.
    fn events(&self) -> impl Iterator<Item = (String, Value)> + use<> {
        let mut stream = self.connect();
        let request = format!("GET {}events HTTP/1.1\r\nHost: {}\r\n\r\n", self.path, self.host);
        stream.write_all(request.as_bytes()).expect("sent");
        let mut event = String::new();
        BufReader::new(stream).lines().filter_map(move |line| {
            let line = line.expect("text");
            if let Some(name) = line.strip_prefix("event: ") {
                name.clone_into(&mut event);
            }
            let data = line.strip_prefix("data: ")?;
            Some((event.clone(), serde_json::from_str(data).expect("JSON")))
        })
    }

    fn status(&self, lines: &[&str]) -> u16 {
        self.send(lines).0
    }
}

impl Drop for ViewProcess {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn name(path: &Path) -> &str {
    path.to_str().expect("a name")
}

/// Returns the numbers of an answer: unsigned integers or floats of 32 bits.
fn words(bytes: &[u8]) -> Vec<[u8; 4]> {
    bytes.as_chunks::<4>().0.to_vec()
}

#[test]
fn other_origins_tokens_paths_and_slow_connections_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    common::run_ogive(folder.path(), &[]);
    let view = ViewProcess::start(&["view", name(folder.path())]);
    assert!(view.host.starts_with("127.0.0.1:") && view.path.len() >= 2 + 32, "{} {}", view.host, view.path);
    let (status, head, body) = view.get("");
    assert_eq!(status, 200);
    let page = String::from_utf8(body).expect("text");
    assert!(page.contains("default-src 'none'; connect-src 'self'; ") && page.contains("script-src 'sha256-"));
    assert!(head.contains("Content-Security-Policy: frame-ancestors 'self'") && head.contains("nosniff"), "{head}");

    let (get, host) = (format!("GET {} HTTP/1.1", view.path), format!("Host: {}", view.host));
    let own = format!("Origin: http://{}", view.host);
    assert_eq!(view.status(&[&get, &host, &own]), 200);
    for origin in ["Origin: http://example.org", "Origin: null", "Origin: http://127.0.0.1:1"] {
        assert_eq!(view.status(&[&get, &host, origin]), 403, "{origin}");
    }
    // A name of another site that has been resolved to this machine.
    for host in ["Host: example.org", "Host: 127.0.0.1.example.org:80", "Host: 10.0.0.1"] {
        assert_eq!(view.status(&[&get, host]), 403, "{host}");
    }
    assert_eq!(view.status(&[&get, "Host: localhost:9000"]), 200, "a forwarded port");

    let wrong = view.path.replace(['0', '1', '2', '3', '4', '5', '6', '7'], "8");
    for path in ["/", "/events", "/mesh", &wrong, &view.path[..20], "//", "/../"] {
        assert_eq!(view.status(&[&format!("GET {path} HTTP/1.1"), &host]), 403, "{path}");
    }
    for path in [
        "../../../etc/passwd",
        "%2e%2e/%2e%2e/etc/passwd",
        "..%5cogive.json",
        "ogive.json",
        "ogive_0000.vtu",
        "/etc/passwd",
        "frame?frame=99&field=0",
        "frame?frame=0&field=99",
        "mesh?frame=99",
        "trace?mesh=0&cell=999999&field=0&from=0&to=1",
        "trace?mesh=99&cell=0&field=0&from=0&to=1",
    ] {
        assert_eq!(view.get(path).0, 404, "{path}");
    }
    for path in ["frame?frame=-1", "frame", "frame?frame=1e9", "trace?cell=0"] {
        assert_eq!(view.get(path).0, 400, "{path}");
    }
    assert_eq!(view.status(&[&get.replace("GET", "POST"), &host]), 405);

    // Connections that send nothing more, and connections that read nothing.
    let slow_senders: Vec<TcpStream> = (0..MANY).map(|_| sent(&view, "GET / HT")).collect();
    assert_eq!(view.get("").0, 200);
    let request = format!("GET {}report HTTP/1.1\r\n{host}\r\n\r\n", view.path);
    let slow_readers: Vec<TcpStream> = (0..MANY).map(|_| sent(&view, &request)).collect();
    assert_eq!(view.get("").0, 200);
    drop((slow_senders, slow_readers));
}

fn sent(view: &ViewProcess, text: &str) -> TcpStream {
    let mut stream = view.connect();
    // The server may already have closed the connection.
    let _ = stream.write_all(text.as_bytes());
    stream
}

/// The numbers that a page receives are those of the frames of the solver.
#[test]
fn frames_are_those_of_the_run() {
    let folder = tempfile::tempdir().expect("a folder");
    let settings = [("nr", "3"), ("nz", "12"), ("speed", "100.")];
    let text = std::fs::read_to_string(project("input/taylor_copper.inp")).expect("a deck");
    let (_, memory) = common::run(&text, &settings, &Routines::none());
    let out = name(folder.path());
    assert!(
        revolve(&["run", "input/taylor_copper.inp", "-q", "-o", out, "-s", "nr=3", "-s", "nz=12", "-s", "speed=100"])
            .status
            .success()
    );
    let view = ViewProcess::start(&["view", out]);
    assert!(
        view.events().any(|(event, data)| event == "frames" && data["times"].as_array().is_some_and(|t| t.len() == 21))
    );
    let mesh = words(&view.get("mesh?frame=0").2);
    let [points, cells] = [mesh[0], mesh[1]].map(|n| u32::from_le_bytes(n) as usize);
    assert_eq!((points, cells, mesh.len()), (4 * 13, 36, 2 + 6 * 36));
    let corners: Vec<u32> = mesh[2..2 + 4 * cells].iter().map(|n| u32::from_le_bytes(*n)).collect();
    assert_eq!(corners, memory.frames[0].cells.corners());
    assert!(mesh[2 + 5 * cells..].iter().all(|n| u32::from_le_bytes(*n) == 1), "one material");
    for index in [0, 7, 20] {
        let frame = &memory.frames[index];
        let answer = words(&view.get(&format!("frame?frame={index}&field=0&shape=1")).2);
        let counts = [answer[0], answer[1], answer[2], answer[3]].map(u32::from_le_bytes);
        assert_eq!(counts, [0, 2 * points as u32, cells as u32, 0], "the mesh of frame 0");
        let numbers: Vec<f32> = answer[4..].iter().map(|n| f32::from_le_bytes(*n)).collect();
        let mises = frame.cell_fields.iter().find(|field| field.name == "MISES").expect("a field");
        let expected = frame.points.iter().flatten().chain(&mises.values).map(|v| *v as f32);
        assert_eq!(numbers, expected.collect::<Vec<_>>(), "frame {index}");
    }
    let trace = view.get("trace?mesh=0&cell=5&field=0&from=7&to=8").2;
    assert_eq!((trace.len(), trace[4]), (5, 1), "the mesh of the frame has the element");
    let trace = words(&trace);
    let mises = memory.frames[7].cell_fields.iter().find(|field| field.name == "MISES").expect("a field").values[5];
    assert_eq!(trace.iter().map(|n| f32::from_le_bytes(*n)).collect::<Vec<_>>(), [mises as f32]);
    let state: Value = serde_json::from_slice(&view.get("state?cell=5&frame=7").2).expect("JSON");
    let shown = state.as_array().expect("a list").iter().find(|row| row[0] == "MISES").expect("a row");
    assert!((shown[1].as_f64().expect("a number") / mises - 1.0).abs() < 1e-6, "{shown}");
}

/// Frames are sent with the mesh that they have, in any order. Elements are followed by their numbers.
#[test]
fn frames_with_new_meshes_are_sent_with_their_mesh() {
    let folder = tempfile::tempdir().expect("a folder");
    let frames = new_meshes::run_into(folder.path());
    let starts = new_meshes::first_frames_of_meshes(&frames);
    let view = ViewProcess::start(&["view", name(folder.path())]);
    let field = field_index(&view, frames.len(), "MISES");
    let mises = |frame: usize| &frames[frame].cell_fields.iter().find(|f| f.name == "MISES").expect("a field").values;
    let mut meshes = Vec::new();
    for index in [20, 0, starts[1], 20, starts[2], 1] {
        let answer = words(&view.get(&format!("frame?frame={index}&field={field}&shape=1")).2);
        let counts = [answer[0], answer[1], answer[2], answer[3]].map(|n| u32::from_le_bytes(n) as usize);
        let frame = &frames[index];
        assert_eq!(counts[1..], [2 * frame.points.len(), frame.cells.len(), 0], "frame {index}");
        let numbers: Vec<f32> = answer[4..].iter().map(|n| f32::from_le_bytes(*n)).collect();
        let expected = frame.points.iter().flatten().chain(mises(index)).map(|v| *v as f32);
        assert_eq!(numbers, expected.collect::<Vec<_>>(), "frame {index}");
        let mesh = words(&view.get(&format!("mesh?frame={}", counts[0])).2);
        let mesh: Vec<u32> = mesh.iter().map(|n| u32::from_le_bytes(*n)).collect();
        let elements = &frame.cell_labels.iter().find(|label| label.name == "ELEMENT").expect("numbers").values;
        assert_eq!(mesh[..2], [frame.points.len() as u32, frame.cells.len() as u32]);
        let corners = frame.cells.iter().flat_map(|cell| (0..4).map(|i| cell.get(i).map_or(u32::MAX, |p| *p)));
        let expected: Vec<u32> = corners.chain(elements.iter().map(|e| *e as u32)).collect();
        assert_eq!(mesh[2..2 + expected.len()], expected, "frame {index}");
        meshes.push(counts[0]);
    }
    assert_eq!(meshes, [20, 0, starts[1], 20, starts[2], 0], "a frame that has the mesh");
    // An element of the first mesh, and one of the last mesh, in the first 16 frames.
    let last = starts[starts.len() - 1];
    assert!((1..16).contains(&last), "{starts:?}");
    for (mesh, exists) in [(0, 0..starts[1]), (20, last..16)] {
        let bytes = view.get(&format!("trace?mesh={mesh}&cell=7&field={field}&from=0&to=21")).2;
        let values: Vec<f32> = words(&bytes[..64]).iter().map(|n| f32::from_le_bytes(*n)).collect();
        assert_eq!((values.len(), bytes.len()), (16, 80));
        for frame in 0..16 {
            let expected = if exists.contains(&frame) { mises(frame)[7] as f32 } else { f32::NAN };
            assert_eq!(
                (values[frame].to_bits(), bytes[64 + frame]),
                (expected.to_bits(), u8::from(!expected.is_nan()))
            );
        }
    }
    assert_eq!(view.get(&format!("trace?mesh=0&cell=9999&field={field}&from=0&to=1")).0, 404);
    assert_eq!(view.get("state?cell=9999&frame=0").0, 404);
}

/// A field that only a later frame has is in the list once this frame has been read; in other frames the field has no values.
#[test]
fn fields_of_later_frames_are_added_to_the_list() {
    let folder = tempfile::tempdir().expect("a folder");
    let frames = new_meshes::run_into(folder.path());
    new_meshes::rename_field(folder.path(), 20);
    let view = ViewProcess::start(&["view", name(folder.path())]);
    let mises = field_index(&view, frames.len(), "MISES");
    let value_count = |frame: usize, field: usize| {
        let answer = words(&view.get(&format!("frame?frame={frame}&field={field}")).2);
        u32::from_le_bytes(answer[2]) as usize
    };
    assert_eq!([value_count(0, mises), value_count(20, mises)], [frames[0].cells.len(), 0]);
    let triax = field_index(&view, frames.len(), "TRIAX");
    assert_eq!([value_count(0, triax), value_count(20, triax)], [0, frames[20].cells.len()]);
    assert_eq!(field_index(&view, frames.len(), "MISES"), mises, "the order does not change");
}

/// Waits until the list of fields of a run with so many frames has a field; returns its index.
fn field_index(view: &ViewProcess, frame_count: usize, name: &str) -> usize {
    let index = |(event, data): (String, Value)| {
        let is_complete = event == "frames" && data["times"].as_array()?.len() == frame_count;
        data["fields"].as_array()?.iter().position(|field| is_complete && field["name"] == name)
    };
    view.events().find_map(index).expect("the stream does not end")
}

/// Events arrive before the run has ended; the program ends after the page is closed.
#[test]
fn events_arrive_while_a_run_writes() {
    let folder = tempfile::tempdir().expect("a folder");
    let deck = ["run", "input/taylor_copper.inp", "-s", "nr=16", "-s", "nz=80", "--view", "-o"];
    let mut view = ViewProcess::start(&[&deck[..], &[name(folder.path())]].concat());
    let (mut lengths, mut seen) = (Vec::new(), Vec::new());
    for (event, data) in view.events() {
        match event.as_str() {
            "frames" => lengths.push(data["times"].as_array().expect("times").len()),
            "setup" => assert!(data["ledger"]["effects"].is_array() && data["materials"][0] == "COPPER", "{data}"),
            "faults" => assert_eq!(data, Value::Array(Vec::new())),
            "run" if data["summary"]["status"] == "completed" => {
                seen.push(event);
                break;
            }
            _ => {}
        }
        seen.push(event);
    }
    for name in ["setup", "status", "progress", "frames", "run", "warnings"] {
        assert!(seen.iter().any(|event| event == name), "{name} {seen:?}");
    }
    // The first frame is shown before the last one is written.
    let growing: Vec<usize> = lengths.iter().copied().filter(|count| (1..21).contains(count)).collect();
    assert!(!growing.is_empty() && growing.is_sorted(), "{lengths:?}");
    let mut rest = String::new();
    view.output.read_to_string(&mut rest).expect("text");
    assert!(view.child.wait().expect("an end").success() && rest.contains("results in"), "{rest}");
}

/// A running job of another process shows its ledger and materials; a deck that has changed since is named.
#[test]
fn job_of_another_process_shows_its_setup_and_a_changed_deck() {
    let folder = tempfile::tempdir().expect("a folder");
    let (deck, out) = (folder.path().join("taylor.inp"), folder.path().join("out"));
    let text = std::fs::read_to_string(project("input/taylor_copper.inp")).expect("a deck");
    std::fs::write(&deck, &text).expect("a deck");
    let mut run = Command::new(env!("CARGO_BIN_EXE_revolve"))
        .args(["run", name(&deck), "-q", "-o", name(&out), "-s", "nr=40", "-s", "nz=200"])
        .spawn()
        .expect("the program starts");
    while !out.join("taylor_0000.vtu").is_file() {
        assert!(run.try_wait().expect("a state").is_none(), "the run has ended");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    let view = ViewProcess::start(&["view", name(&out)]);
    let mut events = view.events();
    let setup = events.find(|(event, _)| event == "setup").expect("a setup").1;
    assert!(setup["ledger"]["effects"].is_array() && setup["materials"][0] == "COPPER", "{setup}");
    assert!(!out.join("taylor.json").is_file(), "the run has not ended");
    run.kill().expect("killed");
    run.wait().expect("an end");
    std::fs::write(&deck, text + "** changed\n").expect("a deck");
    let changed = events.find(|(event, data)| event == "changed" && data[0].is_string()).expect("a change").1;
    assert_eq!(changed[0], name(&deck));
    drop(view);
    // A run to its end leaves the summary only.
    assert!(revolve(&["run", name(&deck), "-q", "-o", name(&out), "-s", "nr=2", "-s", "nz=4"]).status.success());
    assert!(out.join("taylor.json").is_file() && !out.join("taylor.setup").exists());
}

/// A deck without results is run, one with results is shown.
#[test]
fn a_deck_is_run_once_and_then_shown() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("rod.inp"), common::ogive()).expect("a deck");
    let start = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_revolve"));
        let mut child = command
            .args(["view", "rod.inp", "--no-browser"])
            .current_dir(folder.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("the program starts");
        let mut output = BufReader::new(child.stdout.take().expect("a pipe"));
        let (mut text, mut line) = (String::new(), String::new());
        while !(line.contains("ends")) {
            line.clear();
            assert_ne!(output.read_line(&mut line).expect("text"), 0, "{text}");
            text += &line;
        }
        child.kill().expect("killed");
        child.wait().expect("an end");
        text
    };
    let first = start();
    assert!(first.contains("view http://127.0.0.1:") && first.contains("completed: "), "{first}");
    let written =
        || std::fs::metadata(folder.path().join("out/rod/rod.json")).and_then(|file| file.modified()).expect("a time");
    let time = written();
    let second = start();
    assert!(second.contains("view http://127.0.0.1:") && !second.contains("completed: "), "{second}");
    assert_eq!(written(), time);
    let output = revolve(&["view", name(&folder.path().join("out"))]);
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&output.stderr).contains("contains no run"));
}

/// The page draws frames and fields by WebGL and by the processor, and shows the history of an element.
#[test]
fn page_shows_frames_and_elements_in_a_browser() {
    let Some(mut browser) = HeadlessBrowser::start() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let out = name(folder.path());
    assert!(
        revolve(&["run", "input/taylor_copper.inp", "-q", "-o", out, "-s", "nr=4", "-s", "nz=20", "-s", "speed=100"])
            .status
            .success()
    );
    let view = ViewProcess::start(&["view", out]);
    for (fragment, kind) in [("", "processor"), ("#webgl", "WebGL 2")] {
        let address = format!("http://{}{}{fragment}", view.host, view.path);
        browser.open_address(&address, PageView { width: 1400, dark: kind == "WebGL 2" });
        let text = browser.value(include_str!("view_test.js"));
        let result: Value = serde_json::from_str(text.as_str().expect("the page tested itself")).expect("JSON");
        assert_eq!((&result["kind"], &result["faults"]), (&kind.into(), &Value::Array(Vec::new())), "{result}");
        assert_eq!((&result["frames"], &result["different_frames"]), (&21.into(), &21.into()), "{result}");
        assert_eq!(result["different_fields"], result["fields"], "{result}");
        assert_eq!((&result["badge"], &result["trace"]), (&"completed".into(), &21.into()), "{result}");
        assert!(result["element"].as_str().is_some_and(|title| title.ends_with(", COPPER")), "{result}");
        assert_eq!(result["picked"], result["expected"], "{result}");
        assert!(result["state"].as_u64().is_some_and(|rows| rows >= 6) && result["ledger"] == true, "{result}");
        let titles = result["charts"].as_array().expect("titles");
        assert!(
            ["Energy balance", "Increment", "U2"].iter().all(|title| titles.contains(&(*title).into())),
            "{result}"
        );
        assert_eq!(result["overflow"], 0, "{result}");
        assert!(browser.errors.is_empty(), "{:?}", browser.errors);
        let own = format!("http://{}{}", view.host, view.path);
        assert!(browser.requests.iter().all(|request| request.starts_with(&own)), "{:?}", browser.requests);
    }
}

/// The page switches to the mesh of each frame. An element without a cell in a frame has no values there, and the page
/// says so.
#[test]
fn page_shows_new_meshes_in_a_browser() {
    let Some(mut browser) = HeadlessBrowser::start() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let frames = new_meshes::run_into(folder.path());
    let starts = new_meshes::first_frames_of_meshes(&frames);
    let view = ViewProcess::start(&["view", name(folder.path())]);
    for (fragment, kind) in [("", "processor"), ("#webgl", "WebGL 2")] {
        browser.open_address(
            &format!("http://{}{}{fragment}", view.host, view.path),
            PageView { width: 1400, dark: false },
        );
        let text = browser.value(include_str!("view_test.js"));
        let result: Value = serde_json::from_str(text.as_str().expect("the page tested itself")).expect("JSON");
        assert_eq!((&result["kind"], &result["faults"]), (&kind.into(), &Value::Array(Vec::new())), "{result}");
        assert_eq!((&result["frames"], &result["different_frames"]), (&21.into(), &21.into()), "{result}");
        assert_eq!(result["meshes"], starts.len(), "{result}");
        // The element was picked in the last mesh.
        let last = starts[starts.len() - 1];
        assert_eq!((&result["trace"], &result["missing"]), (&(21 - last).into(), &last.into()), "{result}");
        let reason = result["reason"].as_str().expect("a text");
        assert!(reason.contains(&format!("is not in frames 1 to {last}: ")), "{reason}");
        let in_first = result["in_first_frame"].as_str().expect("a text");
        assert!(in_first.starts_with("The mesh of frame 1 does not have element "), "{in_first}");
        assert_eq!(result["selected"][0], -1, "{result}");
        assert_eq!(result["selected"][1], result["selected"][2], "{result}");
        assert!(browser.errors.is_empty(), "{:?}", browser.errors);
    }
}
