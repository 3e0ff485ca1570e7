//! Terminal output: reports on standard output, warnings and errors on standard error.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::fmt::Display;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use crate::error::CliError;

/// True if standard output is reserved for a result.
static STDOUT_IS_RESERVED: AtomicBool = AtomicBool::new(false);

/// Reserves standard output for a result; reports go to standard error from now on.
pub(crate) fn reserve_stdout() {
    STDOUT_IS_RESERVED.store(true, Ordering::Relaxed);
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Console {
    /// Print errors only.
    pub(crate) quiet: bool,
}

impl Console {
    /// Prints a line of the report.
    pub(crate) fn println(self, text: impl Display) -> Result<(), CliError> {
        if self.quiet { Ok(()) } else { show(format_args!("{text}\n")) }
    }

    /// Prints a note once per run: all frames of an animation have the same ones.
    pub(crate) fn note(self, text: impl Display) -> Result<(), CliError> {
        static PRINTED: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
        let text = text.to_string();
        let is_new = PRINTED.lock().unwrap_or_else(PoisonError::into_inner).insert(text.clone());
        if is_new { self.println(format_args!("note: {text}")) } else { Ok(()) }
    }

    pub(crate) fn warn(self, text: impl Display) {
        if !self.quiet {
            to_stderr(format_args!("warning: {text}\n"));
        }
    }
}

/// Prints a report to standard output, or to standard error if the former is reserved.
pub(crate) fn show(text: impl Display) -> Result<(), CliError> {
    if STDOUT_IS_RESERVED.load(Ordering::Relaxed) {
        to_stderr(text);
        return Ok(());
    }
    print(visible(&text.to_string()))
}

/// Writes a result to standard output. A broken pipe means graceful termination.
pub(crate) fn print(text: impl Display) -> Result<(), CliError> {
    flushed(write!(io::stdout().lock(), "{text}"))
}

/// Result of writing to standard output, which is flushed.
pub(crate) fn flushed(written: io::Result<()>) -> Result<(), CliError> {
    match written.and_then(|()| io::stdout().flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(CliError::Stdout(error)),
        _ => Ok(()),
    }
}

/// Prints the error, one line per problem.
pub(crate) fn print_error(failure: &CliError) {
    for line in failure.to_string().lines() {
        // Excerpts of the file are indented.
        let head = if line.starts_with(' ') { "" } else { "error: " };
        to_stderr(format_args!("{head}{line}\n"));
    }
}

/// Prints a line below the progress bar if standard error is a terminal.
pub(crate) fn print_to_terminal(text: &str) {
    if io::stderr().is_terminal() {
        to_stderr(format_args!("\n{text}\n"));
    }
}

/// Ignores failures, which cannot be reported.
fn to_stderr(text: impl Display) {
    let _ = io::stderr().lock().write_all(visible(&text.to_string()).as_bytes());
}

/// Escapes control characters except line breaks and tabs: names in files may contain terminal sequences.
fn visible(text: &str) -> Cow<'_, str> {
    let is_control = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
    if !text.contains(is_control) {
        return Cow::Borrowed(text);
    }
    let shown = |c: char| if is_control(c) { c.escape_default().to_string() } else { c.to_string() };
    Cow::Owned(text.chars().map(shown).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminal_sequences_are_escaped() {
        assert_eq!(visible("plan for 'a\u{1b}]0;b\u{7}'\n\tc"), "plan for 'a\\u{1b}]0;b\\u{7}'\n\tc");
        assert!(matches!(visible("Würfel\n"), Cow::Borrowed(_)));
    }
}
