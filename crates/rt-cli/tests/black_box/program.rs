//! Fixture: runs the binary in a directory of its own.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use rt_image::{Development, Image, ImageFormat, read_image, write_image};
use serde_json::Value;
use tempfile::TempDir;

/// Small scene: three spheres, one of glass, one a mirror, a texture, two lights.
pub(crate) const SCENE: &str = r#"(
    camera: (look_from: (0, 1, 6), look_at: (0, 0.5, 0), fov: 40),
    film: (size: (48, 32)),
    settings: (spp: 4, max_depth: 3),
    background: gradient(bottom: gray(0.2), top: rgb(0.2, 0.4, 0.9)),
    lights: [
        ambient(gray(0.3)),
        point(position: (-4, 6, 5), intensity: gray(0.8)),
        directional(direction: (-1, -1, -1), intensity: gray(0.2)),
    ],
    materials: {
        "floor": phong(color: checker(even: gray(0.8), odd: rgb(0.6, 0.1, 0.1))),
        "glass": phong(diffuse: gray(0), transmission: gray(0.9), ior: 1.5, fresnel: true),
        "mirror": phong(diffuse: gray(0.1), specular: gray(0.5), mirror: gray(0.8)),
        "red": phong(color: rgb(0.9, 0.1, 0.1), specular: gray(0.3)),
    },
    nodes: [
        (shape: plane(), material: "floor"),
        (shape: sphere(center: (-1.2, 0.7, 0), radius: 0.7), material: "mirror"),
        (shape: sphere(center: (0.2, 0.5, 1.5), radius: 0.5), material: "glass"),
        (shape: sphere(center: (1.4, 0.8, -0.5), radius: 0.8), material: "red"),
        (transform: [rotate_y(30), translate(0.3, 0, -1)], shape: box(min: (-0.5, 0, -0.5), max: (0.5, 1, 0.5)), material: "red"),
    ],
)"#;

/// A glTF file of a triangle whose animation moves it for half a second; the numbers are in `m.bin`.
pub(crate) const ANIMATED: &str = r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
    "animations": [{"samplers": [{"input": 1, "output": 2}],
        "channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}]}],
    "accessors": [
        {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
        {"bufferView": 1, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [0.5]},
        {"bufferView": 2, "componentType": 5126, "count": 2, "type": "VEC3"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 8},
        {"buffer": 0, "byteOffset": 44, "byteLength": 24}],
    "buffers": [{"uri": "m.bin", "byteLength": 68}]}"#;

/// Working directory of the program.
pub(crate) struct Workplace {
    folder: TempDir,
}

/// Exit code and output of a run.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Run {
    pub(crate) fn of(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).expect("text");
        Self { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }

    /// Waits for the end of the program.
    pub(crate) fn end(child: Child) -> Self {
        Self::of(child.wait_with_output().expect("it ended"))
    }
}

/// Sends a signal to a program.
pub(crate) fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args(["-s", name, &child.id().to_string()]).status().expect("there is a kill");
    assert!(sent.success(), "{name} could not be sent");
}

/// Waits for something that happens within two minutes.
pub(crate) fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let started = Instant::now();
    while !is_so() {
        assert!(started.elapsed() < Duration::from_secs(120), "{what} did not happen");
        thread::sleep(Duration::from_millis(5));
    }
}

impl Workplace {
    pub(crate) fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a temporary folder") }
    }

    /// Directory with this file.
    pub(crate) fn with(name: &str, content: impl AsRef<[u8]>) -> Self {
        let place = Self::new();
        place.write(name, content);
        place
    }

    /// Directory with [`SCENE`] as `scene.ron`.
    pub(crate) fn with_scene() -> Self {
        Self::with("scene.ron", SCENE)
    }

    /// Directory with [`ANIMATED`] as `m.gltf`.
    pub(crate) fn with_animated_model() -> Self {
        let place = Self::with("m.gltf", ANIMATED);
        // Three points, two times, and two places.
        let numbers: [f32; 17] = [0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0.5, 0., 0., 0., 1., 0., 0.];
        place.write("m.bin", numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<_>>());
        place
    }

    pub(crate) fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).expect("written");
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(crate) fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&self.read(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(crate) fn film(&self, name: &str) -> Image {
        read_image(&self.path(name)).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Writes an image in the format of the extension.
    pub(crate) fn save(&self, name: &str, film: &Image) {
        let mut bytes = Vec::new();
        let format = ImageFormat::from_path(name.as_ref()).expect("known");
        write_image(film, &Development::default(), format, &mut bytes).expect("written");
        self.write(name, bytes);
    }

    /// Names of all files, sorted.
    pub(crate) fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).expect("a folder");
        let mut names: Vec<_> =
            entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// Command in this directory; arguments are separated by spaces.
    pub(crate) fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rt-cli"));
        command.current_dir(self.folder.path()).env("COLUMNS", "100").env_remove("CARGO");
        command.args(arguments.split_whitespace());
        command
    }

    /// Starts the program with its output in pipes.
    pub(crate) fn spawn(&self, arguments: &str) -> Child {
        self.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts")
    }

    /// Runs the program, which never panics.
    pub(crate) fn run(&self, arguments: &str) -> Run {
        let run = Run::of(self.command(arguments).output().expect("it starts"));
        assert!(!run.stderr.contains("panicked"), "{arguments}: {run:?}");
        run
    }

    /// Runs the program, and expects success and a report with these words.
    pub(crate) fn prints(&self, arguments: &str, words: &str) -> Run {
        let run = self.succeed(arguments);
        assert!(run.stdout.contains(words), "{arguments}: {run:?}");
        run
    }

    /// Interrupts the program as soon as a file is there, and expects the exit code of interrupts.
    #[cfg(unix)]
    pub(crate) fn interrupt(&self, arguments: &str, file: &str) -> Run {
        let child = self.spawn(arguments);
        wait_until(file, || self.path(file).exists());
        signal(&child, "INT");
        let run = Run::end(child);
        assert_eq!(run.code, Some(130), "{run:?}");
        run
    }

    /// Runs the program, and expects this exit code and a message with these words.
    pub(crate) fn fails(&self, code: i32, arguments: &str, words: &str) -> Run {
        let run = self.run(arguments);
        assert!(run.code == Some(code) && run.stderr.contains(words), "{arguments}: {run:?}");
        run
    }

    /// Runs commands that are refused without output and without a new file; returns their messages.
    pub(crate) fn refusals(&self, command: &str, cases: &[(i32, &str)]) -> String {
        let before = self.files();
        let mut messages = String::new();
        for (code, arguments) in cases {
            let run = self.run(&format!("{command} {arguments}"));
            assert_eq!((run.code, run.stdout.as_str()), (Some(*code), ""), "{arguments}: {run:?}");
            let message = run.stderr.split("\n\n").next().unwrap_or_default().trim_end();
            messages += &format!("# {arguments}\n{code}: {message}\n\n");
        }
        assert_eq!(self.files(), before);
        messages
    }

    /// Runs the program with this standard input.
    pub(crate) fn pipe(&self, input: &[u8], arguments: &str) -> Output {
        let mut command = self.command(arguments);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("it starts");
        let (mut stdin, input) = (child.stdin.take().expect("a pipe"), input.to_vec());
        // It may end without reading, or write before it has read all.
        let writer = thread::spawn(move || drop(stdin.write_all(&input)));
        let output = child.wait_with_output().expect("it ends");
        writer.join().expect("written");
        output
    }

    /// Runs the program and expects success.
    pub(crate) fn succeed(&self, arguments: &str) -> Run {
        let run = self.run(arguments);
        assert_eq!(run.code, Some(0), "{arguments}: {run:?}");
        run
    }
}
