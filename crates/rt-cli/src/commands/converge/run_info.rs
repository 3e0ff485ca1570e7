//! Settings, machine and compiler of a run.

use crate::processor::processor;
use serde::Serialize;

use super::reference::Floor;

/// Settings and environment of a run.
#[derive(Clone, Debug, Serialize)]
pub(super) struct RunInfo {
    pub(super) scene: String,
    pub(super) width: u32,
    pub(super) height: u32,
    /// `truth`, `reference` or `split`.
    pub(super) against: String,
    /// Description of the reference.
    pub(super) measured_against: String,
    /// Error of the reference, if known.
    pub(super) floor: Option<Floor>,
    pub(super) seeds: u32,
    pub(super) threads: usize,
    pub(super) machine: Machine,
    /// Samples per pixel beyond the time limit, or after an interrupt.
    pub(super) left_out: Vec<u32>,
    pub(super) bad_samples: u64,
}

/// Processor and compilation. Names neither directories nor the host.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Machine {
    program: &'static str,
    version: &'static str,
    processor: String,
    hardware_threads: Option<usize>,
    compiler: &'static str,
    target: &'static str,
    flags: &'static str,
}

pub(super) fn machine() -> Machine {
    Machine {
        program: env!("CARGO_PKG_NAME"),
        version: env!("CARGO_PKG_VERSION"),
        processor: processor(),
        hardware_threads: std::thread::available_parallelism().ok().map(usize::from),
        compiler: env!("RT_CLI_COMPILER"),
        target: env!("RT_CLI_TARGET"),
        flags: env!("RT_CLI_FLAGS"),
    }
}

impl Machine {
    pub(super) fn line(&self) -> String {
        let threads = self.hardware_threads.map(|count| format!(", {count} hardware threads")).unwrap_or_default();
        let Self { program, version, processor, compiler, target, flags, .. } = self;
        format!("{processor}{threads}; {program} {version} by {compiler} for {target}, {flags}")
    }
}
