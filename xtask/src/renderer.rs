//! The renderer as users run it: a process of its own, watched or measured.

use std::{
    ffi::OsStr,
    fs::{self, File},
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    thread,
    time::{Duration, Instant},
};

use wait4::Wait4;

use crate::error::TaskError;

/// The program under test.
#[derive(Debug)]
pub(crate) struct Renderer {
    program: PathBuf,
    timeout: Duration,
}

/// Outcome of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    /// By itself, with this code.
    Code(i32),
    /// By a signal: a crash.
    Crashed,
    /// It was stopped for taking too long.
    TimedOut(Duration),
}

#[derive(Debug)]
pub(crate) struct Run {
    pub exit: Exit,
    /// All that it printed.
    pub log: String,
}

/// Resources of one run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Usage {
    pub wall_seconds: f64,
    /// In the program and in the system, over all threads.
    pub cpu_seconds: f64,
    /// Maximum resident memory. Before a process becomes the program it shares the memory of this one, which counts as
    /// well. No run takes less than one that does nothing.
    pub bytes: u64,
}

impl Renderer {
    pub(crate) fn new(program: PathBuf, timeout: Duration) -> Self {
        Self { program, timeout }
    }

    /// Runs the program in `folder`, which must exist, and waits for it. What it prints is kept in `log.txt` there.
    pub(crate) fn run<A: AsRef<OsStr>>(
        &self,
        folder: &Path,
        args: impl IntoIterator<Item = A>,
    ) -> Result<Run, TaskError> {
        self.run_at_most(folder, args, self.timeout)
    }

    /// Runs the program as [`run`](Self::run) does, and kills it after this time: it gets no chance to tidy up.
    pub(crate) fn run_at_most<A: AsRef<OsStr>>(
        &self,
        folder: &Path,
        args: impl IntoIterator<Item = A>,
        time: Duration,
    ) -> Result<Run, TaskError> {
        let (mut child, log_path) = spawn(&self.program, folder, args)?;
        let exit = wait(&mut child, time).map_err(TaskError::file(&self.program))?;
        let log = fs::read(&log_path).map_err(TaskError::file(&log_path))?;
        Ok(Run { exit, log: String::from_utf8_lossy(&log).into_owned() })
    }

    /// Runs the program in `folder` to its end, however long that takes; an error if it fails.
    pub(crate) fn measure(&self, folder: &Path, args: &[&str]) -> Result<Usage, TaskError> {
        let started = Instant::now();
        let (mut child, log_path) = spawn(&self.program, folder, args)?;
        let used = child.wait4().map_err(TaskError::file(&self.program))?;
        let wall_seconds = started.elapsed().as_secs_f64();
        let run = Run { exit: used.status.into(), log: fs::read_to_string(&log_path).unwrap_or_default() };
        run.succeeded().map_err(|error| TaskError::Command {
            command: format!("{} {}", self.program.display(), args.join(" ")),
            reason: error.to_string(),
        })?;
        let cpu_seconds = (used.rusage.utime + used.rusage.stime).as_secs_f64();
        Ok(Usage { wall_seconds, cpu_seconds, bytes: used.rusage.maxrss })
    }

    /// Renders `scene` to `output` in `folder`, without a word. Colours are rounded to the nearest byte unless `args` say
    /// otherwise, so that images can be compared byte by byte.
    pub(crate) fn render<'a>(
        &self,
        folder: &Path,
        scene: &'a Path,
        output: &'a str,
        args: impl IntoIterator<Item = &'a str>,
    ) -> Result<(), TaskError> {
        let mut all: Vec<&OsStr> = vec!["render".as_ref(), scene.as_ref(), "-o".as_ref(), output.as_ref()];
        all.push("--quiet".as_ref());
        let args: Vec<&OsStr> = args.into_iter().map(OsStr::new).collect();
        if !args.contains(&OsStr::new("--dither")) {
            all.extend(["--dither", "off"].map(OsStr::new));
        }
        all.extend(args);
        self.run(folder, all)?.succeeded()
    }
}

impl Run {
    /// `Ok` if the program ended with code 0, else what went wrong with the end of what it printed.
    pub(crate) fn succeeded(&self) -> Result<(), TaskError> {
        match self.exit {
            Exit::Code(0) => Ok(()),
            exit => Err(TaskError::Other(format!("{exit}: {}", last_line(&self.log)))),
        }
    }
}

impl std::fmt::Display for Exit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Code(code) => write!(f, "exit code {code}"),
            Self::Crashed => write!(f, "crashed"),
            Self::TimedOut(limit) => write!(f, "stopped after {} s", limit.as_secs()),
        }
    }
}

impl From<ExitStatus> for Exit {
    fn from(status: ExitStatus) -> Self {
        status.code().map_or(Self::Crashed, Self::Code)
    }
}

/// Starts a program in `folder`, and returns it with the file that gets all that it prints: a full pipe would block it.
fn spawn<A: AsRef<OsStr>>(
    program: &Path,
    folder: &Path,
    args: impl IntoIterator<Item = A>,
) -> Result<(Child, PathBuf), TaskError> {
    let log_path = folder.join("log.txt");
    let log = File::create(&log_path).map_err(TaskError::file(&log_path))?;
    let log_twin = log.try_clone().map_err(TaskError::file(&log_path))?;
    let mut command = Command::new(program);
    command.args(args).current_dir(folder).stdin(Stdio::null()).stdout(log).stderr(log_twin);
    Ok((command.spawn().map_err(TaskError::file(program))?, log_path))
}

/// End of what a program printed.
fn last_line(log: &str) -> &str {
    log.trim().lines().last().unwrap_or("no message")
}

fn wait(child: &mut Child, timeout: Duration) -> std::io::Result<Exit> {
    let started = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status.into());
        }
        if started.elapsed() > timeout {
            child.kill()?;
            child.wait()?;
            return Ok(Exit::TimedOut(timeout));
        }
        // Most programs end within some tens of milliseconds.
        thread::sleep((started.elapsed() / 20).clamp(Duration::from_micros(500), Duration::from_millis(5)));
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;

    #[test]
    fn exits_are_distinct_and_output_is_kept() {
        let folder = tempfile::tempdir().unwrap();
        let (long, short) = (Duration::from_secs(60), Duration::from_millis(50));
        for (script, timeout, exit, log, problem) in [
            ("echo out; echo err >&2; exit 3", long, Exit::Code(3), "out\nerr\n", "exit code 3: err"),
            ("kill -SEGV $$", long, Exit::Crashed, "", "crashed: no message"),
            ("exec sleep 600", short, Exit::TimedOut(short), "", "stopped after 0 s: no message"),
        ] {
            let run = Renderer::new("sh".into(), timeout).run(folder.path(), ["-c", script]).unwrap();
            assert_eq!((run.exit, run.log.as_str()), (exit, log), "{script}");
            assert_eq!(run.succeeded().unwrap_err().to_string(), problem, "{script}");
        }
        let run = Renderer::new("true".into(), long).run(folder.path(), [""]).unwrap();
        assert!(run.succeeded().is_ok());
    }

    #[test]
    fn sleep_takes_time_on_the_wall_alone_and_failure_is_no_figure() {
        let folder = tempfile::tempdir().unwrap();
        let measure = |script| Renderer::new("sh".into(), Duration::MAX).measure(folder.path(), &["-c", script]);
        let usage = measure("sleep 0.2").unwrap();
        assert!(usage.wall_seconds >= 0.2 && usage.cpu_seconds < 0.1 && usage.bytes > 100_000, "{usage:?}");
        let error = measure("echo why >&2; exit 3").unwrap_err().to_string();
        assert!(error.contains("why") && error.contains('3'), "{error}");
    }
}
