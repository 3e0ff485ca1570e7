//! Runs the binary and looks at what it leaves.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use rt_image::{Image, read_image};
use tempfile::TempDir;

/// One of everything small: three spheres, one of glass, one a mirror, a texture, two lights.
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

/// A folder that the program works in.
pub(crate) struct Workplace {
    folder: TempDir,
}

/// What a run left.
#[derive(Debug)]
pub(crate) struct Run {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Workplace {
    pub(crate) fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a temporary folder") }
    }

    /// A folder that holds [`SCENE`] as `scene.ron`.
    pub(crate) fn with_scene() -> Self {
        let place = Self::new();
        place.write("scene.ron", SCENE);
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

    pub(crate) fn film(&self, name: &str) -> Image {
        read_image(&self.path(name)).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Names of all files, sorted.
    pub(crate) fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).expect("a folder");
        let mut names: Vec<_> =
            entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }

    /// The program, in this folder, with arguments separated by spaces.
    pub(crate) fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rt-cli"));
        command.current_dir(self.folder.path()).env("COLUMNS", "100").env_remove("CARGO");
        command.args(arguments.split_whitespace());
        command
    }

    /// Runs the program. It never panics, whatever it is asked for.
    pub(crate) fn run(&self, arguments: &str) -> Run {
        let Output { status, stdout, stderr } = self.command(arguments).output().expect("it starts");
        let text = |bytes| String::from_utf8(bytes).expect("text");
        let run = Run { code: status.code(), stdout: text(stdout), stderr: text(stderr) };
        assert!(!run.stderr.contains("panicked"), "{arguments}: {run:?}");
        run
    }

    /// Runs the program with this as its standard input, and returns what it leaves as it is.
    pub(crate) fn pipe(&self, input: &[u8], arguments: &str) -> Output {
        let mut command = self.command(arguments);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("it starts");
        let (mut stdin, input) = (child.stdin.take().expect("a pipe"), input.to_vec());
        // It may end without reading, or write before it has read all.
        let writer = std::thread::spawn(move || drop(stdin.write_all(&input)));
        let output = child.wait_with_output().expect("it ends");
        writer.join().expect("written");
        output
    }

    /// Runs the program, which succeeds.
    pub(crate) fn succeed(&self, arguments: &str) -> Run {
        let run = self.run(arguments);
        assert_eq!(run.code, Some(0), "{arguments}: {run:?}");
        run
    }
}
