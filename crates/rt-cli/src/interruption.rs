//! Signals: Ctrl-C, and those by which batch systems and terminals end a job.
//!
//! | signal | while a render is saved | otherwise |
//! |---|---|---|
//! | SIGINT | the first ends the render and saves it; one that comes at least half a second later ends the program at once | ends the program |
//! | SIGTERM, SIGHUP | ends the render and saves it, however often it comes | ends the program |
//!
//! `timeout` sends its signal twice, to the program and to its process group, and shells do so as well. A repeated signal is
//! therefore no order to hurry, unless it is a SIGINT that a person can have sent.

use std::process;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Duration;

use crate::console::tell_terminal;

/// Exit code of what was interrupted: 128 and the number of SIGINT, as shells have it.
pub(crate) const EXIT_CODE: u8 = 130;

/// Time after the first SIGINT within which others count as the same.
const SAME_INTERRUPT: Duration = Duration::from_millis(500);

/// The first signal came.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);
/// Number of [`Listening`]s: if there is one, there is something to be saved.
static LISTENERS: AtomicUsize = AtomicUsize::new(0);

/// From here on, until what it returns is dropped, signals only set a flag; a second SIGINT half a second after the first ends
/// the program at once, and so does any signal when nothing is being saved.
pub(crate) fn listen() -> Listening {
    static INSTALLED: Once = Once::new();
    LISTENERS.fetch_add(1, Ordering::Relaxed);
    INSTALLED.call_once(install);
    Listening(())
}

/// True once a signal has come.
pub(crate) fn is_interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
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
        LISTENERS.fetch_sub(1, Ordering::Relaxed);
    }
}

fn end() -> ! {
    process::exit(EXIT_CODE.into())
}

/// Sets the flag, or ends the program if there is nothing to be saved.
fn interrupt() {
    if LISTENERS.load(Ordering::Relaxed) == 0 {
        end();
    }
    INTERRUPTED.store(true, Ordering::Relaxed);
}

/// Starts a thread that waits for signals. If that is impossible, signals stay what they were.
#[cfg(unix)]
fn install() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    // `nohup` asks for renders that outlive their terminal.
    let hangup = Some(SIGHUP).filter(|&signal| !is_ignored(signal));
    let Ok(mut signals) = Signals::new([SIGINT, SIGTERM].into_iter().chain(hangup)) else { return };
    let wait = move || {
        let mut had_interrupt = false;
        loop {
            let has_interrupt = signals.wait().fold(false, |has, signal| has | (signal == SIGINT));
            interrupt();
            if has_interrupt && had_interrupt {
                tell_terminal("ended without saving");
                end();
            }
            if has_interrupt {
                tell_terminal("interrupted: what has begun is finished and saved; Ctrl-C again ends without saving");
                had_interrupt = true;
                // Repeated signals wait here to be dropped together, so that a busy machine does not tear them apart.
                std::thread::sleep(SAME_INTERRUPT);
                signals.pending().for_each(drop);
            }
        }
    };
    let _ = std::thread::Builder::new().name("signals".to_owned()).spawn(wait);
}

/// True if whoever started the program has it ignore the signal (proc(5)).
#[cfg(target_os = "linux")]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    u32::try_from(signal - 1).ok().and_then(|bit| mask.checked_shr(bit)).is_some_and(|mask| mask & 1 == 1)
}

/// True if whoever started the program has it ignore the signal; not known here.
#[cfg(all(unix, not(target_os = "linux")))]
const fn is_ignored(_signal: i32) -> bool {
    false
}

/// Elsewhere there is Ctrl-C alone.
#[cfg(not(unix))]
fn install() {
    let mut first = None;
    let _ = ctrlc::set_handler(move || {
        interrupt();
        let first: &mut std::time::Instant = first.get_or_insert_with(std::time::Instant::now);
        if first.elapsed() >= SAME_INTERRUPT {
            end();
        }
    });
}
