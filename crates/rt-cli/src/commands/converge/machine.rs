//! What times were measured on. It names no folder and no host.

use serde::Serialize;

use crate::processor::processor;

/// The machine, and how the program was compiled.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Machine {
    program: &'static str,
    version: &'static str,
    processor: String,
    /// Threads that the processor runs at once.
    hardware_threads: Option<usize>,
    compiler: &'static str,
    target: &'static str,
    flags: &'static str,
}

impl Machine {
    /// This machine and this program.
    pub(super) fn here() -> Self {
        Self {
            program: env!("CARGO_PKG_NAME"),
            version: env!("CARGO_PKG_VERSION"),
            processor: processor(),
            hardware_threads: std::thread::available_parallelism().ok().map(usize::from),
            compiler: env!("RT_CLI_COMPILER"),
            target: env!("RT_CLI_TARGET"),
            flags: env!("RT_CLI_FLAGS"),
        }
    }

    /// One line for people.
    pub(super) fn line(&self) -> String {
        let threads = self.hardware_threads.map(|count| format!(", {count} hardware threads")).unwrap_or_default();
        let Self { program, version, processor, compiler, target, flags, .. } = self;
        format!("{processor}{threads}; {program} {version} by {compiler} for {target}, {flags}")
    }
}
