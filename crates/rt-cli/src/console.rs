//! Text for people: reports on standard output, complaints on standard error.

use std::borrow::Cow;
use std::fmt::Display;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use crate::error::Failure;

/// A result goes to standard output, which is to hold nothing else.
static STDOUT_IS_RESERVED: AtomicBool = AtomicBool::new(false);

/// From here on, reports go to standard error: standard output is for a result.
pub(crate) fn reserve_stdout() {
    STDOUT_IS_RESERVED.store(true, Ordering::Relaxed);
}

/// Where a command talks to its user.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Console {
    /// Say nothing but why the command failed.
    pub(crate) quiet: bool,
}

impl Console {
    /// Reports with a line break: on standard output, unless a result goes there.
    pub(crate) fn say(self, text: impl Display) -> Result<(), Failure> {
        if self.quiet { Ok(()) } else { show(format_args!("{text}\n")) }
    }

    /// Warns on standard error, with a line break.
    pub(crate) fn warn(self, text: impl Display) {
        if !self.quiet {
            to_stderr(format_args!("warning: {text}\n"));
        }
    }
}

/// Writes text for people to standard output, or to standard error if a result goes to the former.
pub(crate) fn show(text: impl Display) -> Result<(), Failure> {
    if STDOUT_IS_RESERVED.load(Ordering::Relaxed) {
        to_stderr(text);
        return Ok(());
    }
    print(visible(&text.to_string()))
}

/// Writes what was asked for to standard output, as it is.
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
        // The line of a file below a message is indented.
        let head = if line.starts_with(' ') { "" } else { "error: " };
        to_stderr(format_args!("{head}{line}\n"));
    }
}

/// Writes a line to standard error if that is a terminal: for a person who waits, beside a progress bar.
pub(crate) fn tell_terminal(text: &str) {
    if io::stderr().is_terminal() {
        to_stderr(format_args!("\n{text}\n"));
    }
}

/// Nobody is left to be told if this fails.
fn to_stderr(text: impl Display) {
    let _ = io::stderr().lock().write_all(visible(&text.to_string()).as_bytes());
}

/// Writes control characters out, but for line breaks and tabs: names in files may hold orders for the terminal.
fn visible(text: &str) -> Cow<'_, str> {
    let is_order = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
    if !text.contains(is_order) {
        return Cow::Borrowed(text);
    }
    let shown = |c: char| if is_order(c) { c.escape_default().to_string() } else { c.to_string() };
    Cow::Owned(text.chars().map(shown).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_for_the_terminal_are_written_out() {
        assert_eq!(visible("plan for 'a\u{1b}]0;b\u{7}'\n\tc"), "plan for 'a\\u{1b}]0;b\\u{7}'\n\tc");
        assert!(matches!(visible("Würfel\n"), Cow::Borrowed(_)));
    }
}
