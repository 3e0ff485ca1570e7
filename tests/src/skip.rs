//! Tests that cannot run: reported, counted, and failed where everything must run.

use std::{
    env,
    fmt::Display,
    fs::OpenOptions,
    io::Write as _,
    panic::Location,
    path::{Path, PathBuf},
    thread,
};

/// Variable that makes [`skip`] panic if it is `1`.
pub const REQUIRE_ALL: &str = "RT_REQUIRE_ALL";
/// Variable with the file that skipped tests are appended to, by default `skipped.txt` in the target folder.
pub const SKIPPED: &str = "RT_SKIPPED";
/// Variable with the folder of shared test data, by default `shared` next to the workspace.
pub const SHARED: &str = "RT_SHARED";

/// True if what cannot be tested must fail: if `RT_REQUIRE_ALL` is `1`.
pub fn requires_all() -> bool {
    env::var_os(REQUIRE_ALL).is_some_and(|value| value == "1")
}

/// Reports that the running test cannot test all that it is there for, and why. The caller then returns, or goes on with the
/// rest.
///
/// The report is the line `skipped: TEST: REASON` on standard error, past the capture of the test runner, and in the file of
/// [`report_skipped`].
///
/// # Panics
///
/// If `RT_REQUIRE_ALL` is `1`.
#[track_caller]
pub fn skip(reason: impl Display) {
    let place = Location::caller();
    let thread = thread::current();
    // The runner names the thread of a test after it, but where it runs tests one by one.
    let name = thread.name().filter(|name| *name != "main");
    let name = name.map_or_else(|| format!("{}:{}", place.file(), place.line()), str::to_owned);
    let program = program();
    report_skipped(format_args!("{program}{name}"), &reason);
    assert!(!requires_all(), "{program}{name} must not be skipped, as {REQUIRE_ALL} is 1: {reason}");
}

/// Writes the line `skipped: NAME: REASON` to standard error, and appends it to the file that `RT_SKIPPED` names, by default
/// `skipped.txt` in the target folder. Errors are ignored: a report must not fail what can run.
pub fn report_skipped(name: impl Display, reason: impl Display) {
    let line = format!("skipped: {name}: {}\n", reason.to_string().trim().replace('\n', " "));
    // Not by the macros: the test runner captures what they print.
    let _ = std::io::stderr().write_all(line.as_bytes());
    if let Some(path) = skipped_file()
        && let Ok(mut file) = OpenOptions::new().create(true).append(true).open(path)
    {
        let _ = file.write_all(line.as_bytes());
    }
}

/// File that skipped tests are appended to; `None` without a target folder.
pub fn skipped_file() -> Option<PathBuf> {
    if let Some(path) = env::var_os(SKIPPED) {
        return Some(path.into());
    }
    let program = env::current_exe().ok()?;
    // Cargo marks its target folder.
    let target = program.ancestors().find(|folder| folder.join("CACHEDIR.TAG").is_file())?;
    Some(target.join("skipped.txt"))
}

/// File or folder of test data outside of the workspace, in the folder `RT_SHARED`; `None` if it is missing. The
/// default folder is `shared` next to the workspace.
pub fn shared(name: impl AsRef<Path>) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    let folder = env::var_os(SHARED).map_or_else(beside, PathBuf::from);
    Some(folder.join(name)).filter(|path| path.exists())
}

/// Path of a file of the [`shared`] folder; [skips](skip) the test if it is missing.
///
/// # Panics
///
/// Skips a test like [`skip`].
#[track_caller]
pub fn shared_or_skip(name: impl AsRef<Path>) -> Option<PathBuf> {
    let found = shared(&name);
    if found.is_none() {
        skip(format_args!("there is no shared/{}", name.as_ref().display()));
    }
    found
}

/// Name of the running program without the hash that cargo appends, and a separator.
fn program() -> String {
    let path = env::current_exe().unwrap_or_default();
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let name = stem.rsplit_once('-').map_or(&*stem, |(name, _)| name);
    format!("{name}::")
}
