//! The numbers as CSV and JSON for other programs.

use serde::Serialize;

use super::machine::Machine;
use super::summary::Summary;
use super::yardstick::Floor;

/// What is known beside the numbers.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Circumstances {
    /// The scene's name.
    pub(super) scene: String,
    pub(super) width: u32,
    pub(super) height: u32,
    /// `truth`, `reference` or `split`.
    pub(super) against: &'static str,
    /// What that is, in words.
    pub(super) measured_against: String,
    /// The error of the reference; `None` if it is unknown, or there is none.
    pub(super) floor: Option<Floor>,
    pub(super) seeds: u32,
    pub(super) threads: usize,
    pub(super) machine: Machine,
    /// Samples per pixel that there was no time for.
    pub(super) left_out: Vec<u32>,
    pub(super) bad_samples: u64,
}

/// The JSON file.
#[derive(Debug, Serialize)]
pub(super) struct JsonFile<'a> {
    #[serde(flatten)]
    pub(super) circumstances: &'a Circumstances,
    #[serde(flatten)]
    pub(super) summary: &'a Summary,
}

/// A line of the CSV file.
#[derive(Debug, Serialize)]
struct Row<'a> {
    method: &'a str,
    integrator: &'a str,
    sampler: &'a str,
    accel: &'a str,
    depth: u32,
    spp: u32,
    seeds: usize,
    threads: usize,
    cpu_seconds: f64,
    wall_seconds: f64,
    build_seconds: f64,
    rmse: Option<f64>,
    rmse_median: Option<f64>,
    rmse_low: Option<f64>,
    rmse_high: Option<f64>,
    relative_mse: f64,
    bias: f64,
    bias_standard_error: f64,
    flip: Option<f64>,
    efficiency: Option<f64>,
    floor_rmse: Option<f64>,
    is_trusted: bool,
}

/// The CSV file.
pub(super) fn csv(circumstances: &Circumstances, summary: &Summary) -> Result<Vec<u8>, String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for method in &summary.methods {
        for point in &method.points {
            let row = Row {
                method: &method.name.label,
                integrator: method.name.integrator,
                sampler: method.name.sampler,
                accel: method.name.accel,
                depth: method.name.depth,
                spp: point.spp,
                seeds: point.runs.len(),
                threads: circumstances.threads,
                cpu_seconds: point.seconds,
                wall_seconds: point.wall_seconds,
                build_seconds: point.build_seconds,
                rmse: point.rmse,
                rmse_median: point.rmse_median,
                rmse_low: point.rmse_interval.map(|interval| interval.low),
                rmse_high: point.rmse_interval.map(|interval| interval.high),
                relative_mse: point.relative_mse,
                bias: point.bias,
                bias_standard_error: point.bias_standard_error,
                flip: point.flip,
                efficiency: point.efficiency,
                floor_rmse: circumstances.floor.map(|floor| floor.mse.sqrt()),
                is_trusted: point.is_trusted,
            };
            writer.serialize(row).map_err(|error| error.to_string())?;
        }
    }
    writer.into_inner().map_err(|error| error.to_string())
}
