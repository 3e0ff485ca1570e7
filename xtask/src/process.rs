//! CPU time, wall time and memory of a whole process.

use std::{path::PathBuf, time::Instant};

use wait4::Wait4;

use crate::{
    error::TaskError,
    renderer::{last_line, spawn},
};

/// A program to run in a folder.
#[derive(Debug)]
pub(crate) struct Program {
    pub path: PathBuf,
    pub folder: PathBuf,
}

/// Resources of one run.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Usage {
    pub wall_seconds: f64,
    /// In the program and in the system, over all threads.
    pub cpu_seconds: f64,
    /// Maximum resident memory. Before a process becomes the program it shares the memory of this one, and that counts
    /// as well: no run takes less than [`empty`](Program::empty) says.
    pub bytes: u64,
}

impl Program {
    /// Runs the program to its end; an error if it fails.
    pub(crate) fn run(&self, args: &[&str]) -> Result<Usage, TaskError> {
        let started = Instant::now();
        let (mut child, log_path) = spawn(&self.path, &self.folder, args)?;
        let used = child.wait4().map_err(TaskError::file(&self.path))?;
        let wall_seconds = started.elapsed().as_secs_f64();
        if !used.status.success() {
            let said = std::fs::read_to_string(&log_path).unwrap_or_default();
            let command = format!("{} {}", self.path.display(), args.join(" "));
            let reason = format!("{}: {}", used.status, last_line(&said));
            return Err(TaskError::Command { command, reason });
        }
        let cpu_seconds = (used.rusage.utime + used.rusage.stime).as_secs_f64();
        Ok(Usage { wall_seconds, cpu_seconds, bytes: used.rusage.maxrss })
    }

    /// Resources of a run that does nothing.
    pub(crate) fn empty(&self) -> Result<Usage, TaskError> {
        self.run(&["--version"])
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;

    fn shell(script: &str) -> Result<Usage, TaskError> {
        let folder = tempfile::tempdir().unwrap();
        Program { path: "sh".into(), folder: folder.path().into() }.run(&["-c", script])
    }

    #[test]
    fn sleep_takes_time_on_the_wall_alone() {
        let usage = shell("sleep 0.2").unwrap();
        assert!(usage.wall_seconds >= 0.2 && usage.cpu_seconds < 0.1, "{usage:?}");
        assert!(usage.bytes > 100_000, "{usage:?}");
    }

    #[test]
    fn failure_is_no_figure() {
        let error = shell("echo why >&2; exit 3").unwrap_err().to_string();
        assert!(error.contains("why") && error.contains('3'), "{error}");
    }
}
