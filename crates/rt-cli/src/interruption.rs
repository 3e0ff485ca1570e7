//! Ctrl-C, and the signal by which batch systems end a job.

use std::process;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code of what was interrupted: 128 and the number of SIGINT, as shells have it.
pub(crate) const EXIT_CODE: u8 = 130;

/// The first signal came.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);
/// There is something to be saved.
static RENDERING: AtomicBool = AtomicBool::new(false);

/// From here on, until what it returns is dropped, the first signal only sets a flag; the second ends the program at once, and so
/// does the first when nothing is being rendered.
pub(crate) fn listen() -> Listening {
    // A handler that cannot be installed, or has been already, leaves signals what they were.
    let _ = ctrlc::set_handler(|| {
        let is_first = !INTERRUPTED.swap(true, Ordering::Relaxed);
        if !(is_first && RENDERING.load(Ordering::Relaxed)) {
            process::exit(EXIT_CODE.into());
        }
    });
    RENDERING.store(true, Ordering::Relaxed);
    Listening(())
}

/// Lasts as long as a signal saves what there is.
pub(crate) struct Listening(());

impl Listening {
    /// Set by the first signal.
    #[expect(clippy::unused_self, reason = "whoever has no listener has no flag that is ever set")]
    pub(crate) const fn flag(&self) -> &'static AtomicBool {
        &INTERRUPTED
    }
}

impl Drop for Listening {
    fn drop(&mut self) {
        RENDERING.store(false, Ordering::Relaxed);
    }
}
