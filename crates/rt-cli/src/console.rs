//! Text for people: reports on standard output, complaints on standard error.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write};

use crate::error::Failure;

/// Where a command talks to its user.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Console {
    /// Say nothing but why the command failed.
    pub(crate) quiet: bool,
}

impl Console {
    /// Reports on standard output, with a line break.
    pub(crate) fn say(self, text: impl Display) -> Result<(), Failure> {
        if self.quiet { Ok(()) } else { print(format_args!("{text}\n")) }
    }

    /// Warns on standard error, with a line break.
    pub(crate) fn warn(self, text: impl Display) {
        if !self.quiet {
            to_stderr(format_args!("warning: {text}\n"));
        }
    }
}

/// Writes what was asked for to standard output.
///
/// A reader that has left, as `head` does, has seen enough: that is no failure.
pub(crate) fn print(text: impl Display) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match write!(stdout, "{text}").and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Failure::Stdout(error)),
        _ => Ok(()),
    }
}

/// Says why the command failed: one line for each problem.
pub(crate) fn complain(failure: &Failure) {
    for line in failure.to_string().lines() {
        to_stderr(format_args!("error: {line}\n"));
    }
}

/// Nobody is left to be told if this fails.
fn to_stderr(text: impl Display) {
    let _ = write!(io::stderr().lock(), "{text}");
}
