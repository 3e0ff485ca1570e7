//! Signals: Ctrl-C, and those that batch systems and terminals send to end a job.
//!
//! | signal | with a [`SignalGuard`] | otherwise |
//! |---|---|---|
//! | SIGINT | the first ends the render and saves it; another one at least half a second later ends the program at once | ends the program |
//! | SIGTERM, SIGHUP | ends the render and saves it, even if repeated | ends the program |
//! | SIGXFSZ | has no effect: a write beyond the limit of `ulimit -f` returns an error | the same |
//!
//! `render` handles signals from its start, so that the exit code is the same while it loads the scene. Between frames, signals end the
//! program with the message on the next frame.
//!
//! `timeout` and shells send a signal twice: to the program and to its process group. A repeated signal therefore does not end the
//! program at once, unless it is a late SIGINT.

use std::process;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, Once, PoisonError};
use std::time::Duration;

use crate::console::{print_error, print_to_terminal};
use crate::error::{CliError, INTERRUPTED_EXIT_CODE};

/// Further SIGINTs within this time of the first count as the same.
const SAME_INTERRUPT: Duration = Duration::from_millis(500);

static INTERRUPTED: AtomicBool = AtomicBool::new(false);
/// Number of live [`SignalGuard`]s.
static GUARDS: AtomicUsize = AtomicUsize::new(0);
/// True in a render that has not had a guard, and before each frame.
static IS_BEFORE_RENDER: AtomicBool = AtomicBool::new(false);
/// Frame that is rendered next, and whether earlier ones are finished.
static NEXT_FRAME: Mutex<Option<(u32, bool)>> = Mutex::new(None);

/// Signals only set a flag while the guard lives, except for a second SIGINT half a second after the first.
pub(crate) fn guard() -> SignalGuard {
    GUARDS.fetch_add(1, Ordering::Relaxed);
    IS_BEFORE_RENDER.store(false, Ordering::Relaxed);
    install_once();
    SignalGuard(())
}

/// Lets signals before the next guard end the program with the message and the exit code of an interrupted render.
pub(crate) fn end_render_on_signals() {
    IS_BEFORE_RENDER.store(true, Ordering::Relaxed);
    install_once();
}

/// Version of [`end_render_on_signals`] whose message names the frame. `has_frames` is true if earlier frames are finished.
pub(crate) fn end_frame_on_signals(frame: u32, has_frames: bool) {
    *NEXT_FRAME.lock().unwrap_or_else(PoisonError::into_inner) = Some((frame, has_frames));
    end_render_on_signals();
}

/// Lets signals end the program, even if the parent process ignores SIGINT, as shells do for jobs in the background.
#[cfg(feature = "view")]
pub(crate) fn end_on_signals() {
    install_once();
}

fn install_once() {
    static INSTALLED: Once = Once::new();
    INSTALLED.call_once(install);
}

/// Lets writes beyond the file-size limit fail with an error. By default, SIGXFSZ ends the program without a message.
#[cfg(unix)]
pub(crate) fn report_file_size_limit() {
    // Any handler replaces the default action; its flag is not read. If this fails, the default action stays.
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default());
}

/// Other systems have no file-size limit.
#[cfg(not(unix))]
pub(crate) const fn report_file_size_limit() {}

/// True after the first signal.
pub(crate) fn is_interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}

/// Keeps signals from ending the program before its results are saved.
pub(crate) struct SignalGuard(());

impl SignalGuard {
    /// Flag that the first signal sets.
    #[expect(clippy::unused_self, reason = "without a guard, the flag is never set")]
    pub(crate) const fn flag(&self) -> &'static AtomicBool {
        &INTERRUPTED
    }
}

impl Drop for SignalGuard {
    fn drop(&mut self) {
        GUARDS.fetch_sub(1, Ordering::Relaxed);
    }
}

fn end() -> ! {
    process::exit(INTERRUPTED_EXIT_CODE.into())
}

/// Sets the flag; ends the program without a guard.
fn interrupt() {
    if GUARDS.load(Ordering::Relaxed) == 0 {
        if IS_BEFORE_RENDER.load(Ordering::Relaxed) {
            let next = *NEXT_FRAME.lock().unwrap_or_else(PoisonError::into_inner);
            print_error(&match next {
                Some((frame, has_frames)) => CliError::InterruptedLoading { has_frames }.in_frame(frame),
                None => CliError::InterruptedLoading { has_frames: false },
            });
        }
        end();
    }
    INTERRUPTED.store(true, Ordering::Relaxed);
}

/// Starts a thread that waits for signals. If that fails, signals keep their default action.
#[cfg(unix)]
fn install() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;

    // `nohup` ignores SIGHUP, so that the program outlives its terminal.
    let hangup = Some(SIGHUP).filter(|&signal| !is_ignored(signal));
    let Ok(mut signals) = Signals::new([SIGINT, SIGTERM].into_iter().chain(hangup)) else { return };
    let wait = move || {
        let mut had_interrupt = false;
        loop {
            let has_interrupt = signals.wait().fold(false, |has, signal| has | (signal == SIGINT));
            interrupt();
            if has_interrupt && had_interrupt {
                print_to_terminal("ended without saving");
                end();
            }
            if has_interrupt {
                print_to_terminal(
                    "interrupted: finishing and saving the tiles that were started; Ctrl-C again ends without saving",
                );
                had_interrupt = true;
                // Drop repeated signals together, however late a busy machine delivers them.
                std::thread::sleep(SAME_INTERRUPT);
                signals.pending().for_each(drop);
            }
        }
    };
    let _ = std::thread::Builder::new().name("signals".to_owned()).spawn(wait);
}

/// True if the parent process set the signal to be ignored (proc(5)).
#[cfg(target_os = "linux")]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    u32::try_from(signal - 1).ok().and_then(|bit| mask.checked_shr(bit)).is_some_and(|mask| mask & 1 == 1)
}

/// Unknown on this system.
#[cfg(all(unix, not(target_os = "linux")))]
const fn is_ignored(_signal: i32) -> bool {
    false
}

/// Handles Ctrl-C, the only signal of other systems.
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
