//! A `view` that runs, and requests to it.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::program::Workplace;

/// Longest wait for anything.
const PATIENCE: Duration = Duration::from_secs(60);

/// A program that serves a view, killed at the end of the test.
pub(crate) struct ViewServer {
    pub(crate) place: Workplace,
    pub(crate) program: Child,
    pub(crate) url: String,
    port: u16,
    pub(crate) page: String,
}

#[derive(Debug)]
pub(crate) struct Answer {
    pub(crate) status: u16,
    pub(crate) headers: String,
    pub(crate) body: Vec<u8>,
}

impl Answer {
    pub(crate) fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }

    pub(crate) fn json(&self) -> Value {
        assert_eq!(self.status, 200, "{}", self.text());
        serde_json::from_slice(&self.body).expect("JSON")
    }
}

impl Drop for ViewServer {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

impl ViewServer {
    /// Views a scene that the folder gets as `scene.ron`.
    pub(crate) fn start(scene: &str, options: &str) -> Self {
        let place = Workplace::with("scene.ron", scene);
        Self::start_in(place, &format!("scene.ron {options}"))
    }

    pub(crate) fn start_in(place: Workplace, arguments: &str) -> Self {
        let command = place.command(&format!("view {arguments} --no-open"));
        Self::start_command(place, command)
    }

    /// Starts a command that views a scene.
    pub(crate) fn start_command(place: Workplace, mut command: Command) -> Self {
        let mut program = command.stdout(Stdio::piped()).spawn().expect("it starts");
        let mut lines = BufReader::new(program.stdout.take().expect("a pipe")).lines().map_while(Result::ok);
        let url = lines.find_map(|line| Some(line.split_once(" at http://")?.1.to_owned())).expect("an address");
        let (authority, page) = url.split_once('/').expect("a path");
        let port = authority.rsplit_once(':').expect("a port").1.parse().expect("a number");
        Self { place, program, port, page: format!("/{page}"), url: format!("http://{url}") }
    }

    /// Sends these bytes and receives all that comes back.
    pub(crate) fn exchange(&self, request: &[u8]) -> Answer {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).expect("a connection");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        stream.write_all(request).expect("sent");
        let mut received = Vec::new();
        stream.read_to_end(&mut received).expect("received");
        let end = received.windows(4).position(|window| window == b"\r\n\r\n").expect("a head");
        let headers = String::from_utf8(received[..end].to_vec()).expect("text");
        let status = headers.split(' ').nth(1).and_then(|code| code.parse().ok()).expect("a status");
        Answer { status, headers, body: received[end + 4..].to_vec() }
    }

    /// Sends a request as a browser would.
    pub(crate) fn request(&self, method: &str, path: &str, body: &str) -> Answer {
        let (page, port, length) = (&self.page, self.port, body.len());
        let head =
            format!("{method} {page}{path} HTTP/1.1\r\nHost: localhost:{port}\r\nOrigin: http://localhost:{port}\r\n");
        self.exchange(format!("{head}Content-Length: {length}\r\nConnection: close\r\n\r\n{body}").as_bytes())
    }

    pub(crate) fn get(&self, path: &str) -> Answer {
        self.request("GET", path, "")
    }

    /// True if the page is served, false if the connection is refused or closed.
    pub(crate) fn is_reachable(&self) -> bool {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).expect("a connection");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        let request = format!("GET {} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n", self.page);
        let mut received = Vec::new();
        let is_answered = stream.write_all(request.as_bytes()).and_then(|()| stream.read_to_end(&mut received)).is_ok();
        is_answered && received.starts_with(b"HTTP/1.1 200")
    }

    pub(crate) fn post(&self, path: &str, body: &str) -> Value {
        self.request("POST", path, body).json()
    }

    /// State of the render, and the image if there is a later one than `after`.
    pub(crate) fn frame(&self, after: u64) -> (Value, Vec<u8>) {
        let Answer { status, body, .. } = self.get(&format!("frame?after={after}"));
        assert_eq!(status, 200, "{}", String::from_utf8_lossy(&body));
        let end = body.iter().position(|byte| *byte == b'\n').expect("a line");
        (serde_json::from_slice(&body[..end]).expect("JSON"), body[end + 1..].to_vec())
    }

    /// Looks on until the image is finished, or the condition holds for its state.
    pub(crate) fn watch(&self, is_enough: impl Fn(&Value) -> bool) -> (Value, Vec<u8>) {
        let deadline = Instant::now() + PATIENCE;
        let (mut version, mut latest) = (0, Vec::new());
        loop {
            let (state, image) = self.frame(version);
            version = state["version"].as_u64().expect("a number");
            if !image.is_empty() {
                latest = image;
            }
            if state["is_finished"] == true || is_enough(&state) {
                return (state, latest);
            }
            assert!(Instant::now() < deadline, "{state}");
        }
    }

    pub(crate) fn finished(&self) -> (Value, Vec<u8>) {
        self.watch(|_| false)
    }

    /// The page shows, and saves, what `render` writes of the scene with these options.
    pub(crate) fn assert_shows(&self, scene: &str, options: &str) {
        let (state, shown) = self.finished();
        for name in ["expected.png", "expected.exr"] {
            self.place.succeed(&format!("render {scene} {options} --time 1h -o {name}"));
        }
        let (png, exr) = (self.place.read("expected.png"), self.place.read("expected.exr"));
        assert!(shown == png, "{options}: the page shows something else: {state}");
        assert!(self.get("image.png").body == png, "{options}: the saved PNG differs");
        assert!(self.get("image.exr").body == exr, "{options}: the saved EXR differs");
    }

    /// Seconds of processor time that the program has taken.
    #[cfg(target_os = "linux")]
    pub(crate) fn processor_seconds(&self) -> f64 {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.program.id())).expect("it runs");
        let (_, fields) = stat.rsplit_once(") ").expect("a name");
        let ticks: f64 = fields.split(' ').skip(11).take(2).map(|ticks| ticks.parse::<f64>().expect("ticks")).sum();
        // proc(5): a tick is a hundredth of a second on all machines that Linux runs on today.
        ticks / 100.0
    }
}
