//! Bad input and its expected outcome.

use std::{
    fs::{self, File},
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use wait4::Wait4;

/// Greatest processor time of a run, in seconds. The clock on the wall would find fault with a busy machine.
const MAX_SECONDS: f64 = 1.0;

/// Greatest memory of a run.
const MAX_BYTES: u64 = 64 << 20;

/// Bad input file with its companions.
pub(crate) struct Input {
    name: String,
    files: Vec<(String, Content)>,
    has_own_size: bool,
    prepare: Option<fn(&Path)>,
    outcome: Outcome,
}

/// The content of a file: `head`, many times `part`, and `tail`.
///
/// Long files are never in memory here: a child begins with the peak of its parent's memory.
pub(crate) struct Content {
    pub(crate) head: Vec<u8>,
    pub(crate) part: Vec<u8>,
    pub(crate) times: usize,
    pub(crate) tail: Vec<u8>,
}

impl Content {
    fn short(bytes: &[u8]) -> Self {
        Self { head: bytes.to_owned(), part: Vec::new(), times: 0, tail: Vec::new() }
    }

    fn write(&self, path: &Path) -> io::Result<()> {
        let mut file = BufWriter::new(File::create(path)?);
        file.write_all(&self.head)?;
        for _ in 0..self.times {
            file.write_all(&self.part)?;
        }
        file.write_all(&self.tail)?;
        file.flush()
    }
}

/// A kind with one example.
impl From<Input> for Vec<Input> {
    fn from(input: Input) -> Self {
        vec![input]
    }
}

enum Outcome {
    /// Exit code 3, and a message with these parts.
    Refused(Vec<&'static str>),
    /// An image, and a message with these parts.
    Shown(Vec<&'static str>),
}

pub(crate) struct Run {
    pub(crate) code: Option<i32>,
    /// Standard error and notes.
    pub(crate) said: String,
    seconds: f64,
    bytes: u64,
    new_files: Vec<PathBuf>,
}

impl Input {
    pub(crate) fn file(name: &str, content: impl AsRef<[u8]>) -> Self {
        Self::long(name, Content::short(content.as_ref()))
    }

    /// A file of this name and long content.
    pub(crate) fn long(name: &str, content: Content) -> Self {
        Self { files: vec![(name.to_owned(), content)], ..Self::of(name, None) }
    }

    fn of(name: &str, prepare: Option<fn(&Path)>) -> Self {
        Self {
            name: name.to_owned(),
            files: Vec::new(),
            has_own_size: false,
            prepare,
            outcome: Outcome::Shown(Vec::new()),
        }
    }

    pub(crate) fn scene(text: &str) -> Self {
        Self::file("scene.ron", text)
    }

    pub(crate) fn node(fields: &str) -> Self {
        Self::scene(&format!("(nodes: [({fields})])"))
    }

    /// A file that the test makes by itself in the folder that it is given.
    pub(crate) fn made(name: &str, prepare: fn(&Path)) -> Self {
        Self::of(name, Some(prepare))
    }

    /// Adds a companion file.
    pub(crate) fn with_file(mut self, name: &str, content: impl AsRef<[u8]>) -> Self {
        self.files.push((name.to_owned(), Content::short(content.as_ref())));
        self
    }

    /// The image has the size that the file says, rather than a small one.
    pub(crate) fn in_its_own_size(self) -> Self {
        Self { has_own_size: true, ..self }
    }

    /// It must be refused with a message that has these parts.
    pub(crate) fn refused(self, parts: &[&'static str]) -> Self {
        Self { outcome: Outcome::Refused(parts.to_vec()), ..self }
    }

    /// It must be shown with a warning that has these parts; without a warning if there are none.
    pub(crate) fn shown(self, parts: &[&'static str]) -> Self {
        Self { outcome: Outcome::Shown(parts.to_vec()), ..self }
    }

    /// Renders the input, and checks what comes of it.
    pub(crate) fn check(&self, case: &str) {
        let Run { code, said, seconds, bytes, new_files } = self.run(case);
        assert!(!said.contains("panicked"), "{case}: {said}");
        assert!(seconds < MAX_SECONDS, "{case} takes {seconds} s: {said}");
        assert!(bytes < MAX_BYTES, "{case} takes {bytes} bytes: {said}");
        let (expected, parts, files) = match &self.outcome {
            Outcome::Refused(parts) => (3, parts, 0),
            Outcome::Shown(parts) => (0, parts, 1),
        };
        assert_eq!(code, Some(expected), "{case}: {said}");
        for part in parts {
            assert!(said.contains(part), "{case}: no `{part}` in: {said}");
        }
        assert_eq!(new_files.len(), files, "{case}: {new_files:?}");
        let unexpected = parts.is_empty() && said.contains("warning");
        assert!(!unexpected, "{case}: {said}");
        // A message a line, each with the name of a file.
        let nameless = said.lines().find(|line| line.starts_with("error") && !line.contains('.'));
        assert_eq!(nameless, None, "{case}: {said}");
    }

    /// Renders the input in a folder of its own.
    pub(crate) fn run(&self, case: &str) -> Run {
        let outer = tempfile::tempdir().expect("a folder");
        // References to the folder above must have something to find.
        fs::write(outer.path().join("secret.png"), b"secret").expect("written");
        let folder = outer.path().join("scenes");
        fs::create_dir(&folder).expect("a folder");
        for (name, content) in &self.files {
            content.write(&folder.join(name)).expect("written");
        }
        if let Some(prepare) = self.prepare {
            prepare(&folder);
        }
        let before = files(&folder);
        let log_path = outer.path().join("log.txt");
        let log = File::create(&log_path).expect("a file");
        let notes_path = outer.path().join("notes.txt");
        let notes = File::create(&notes_path).expect("a file");
        let mut command = Command::new(env!("CARGO_BIN_EXE_rt-cli"));
        command.args(["render", &self.name, "-o", "picture.png", "--threads", "1", "--memory", "4GiB"]);
        if !self.has_own_size {
            command.args(["--size", "8x6"]);
        }
        command.current_dir(&folder).stdin(Stdio::null()).stdout(notes).stderr(log).env_remove("CARGO");
        let used =
            command.spawn().and_then(|mut child| child.wait4()).unwrap_or_else(|error| panic!("{case}: {error}"));
        let mut said = String::from_utf8_lossy(&fs::read(&log_path).expect("a log")).into_owned();
        let printed = fs::read(&notes_path).expect("notes");
        for note in String::from_utf8_lossy(&printed).lines().filter(|line| line.starts_with("note: ")) {
            said.push_str(note);
            said.push('\n');
        }
        Run {
            code: used.status.code(),
            said,
            seconds: (used.rusage.utime + used.rusage.stime).as_secs_f64(),
            bytes: used.rusage.maxrss,
            new_files: files(&folder).into_iter().filter(|file| !before.contains(file)).collect(),
        }
    }
}

fn files(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path()).collect()
}
