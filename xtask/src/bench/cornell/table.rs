//! Results of `bench cornell`, and their table.

use std::fmt::{self, Display, Formatter};

use serde::Serialize;

use super::peers::{CornellPeer, PEERS};
use crate::{number::three_digits, table::Table};

/// Means over renders that differ only in their seeds.
#[derive(Debug, Serialize)]
pub(super) struct CornellResult {
    /// `None` for one for each processor.
    pub threads: Option<u32>,
    pub spp: u32,
    pub cpu_seconds: f64,
    pub wall_seconds: f64,
    pub rmse: f64,
    pub relative_mse: f64,
    /// The image's mean by that of the reference.
    pub mean_ratio: f64,
    /// 1 / (MSE · CPU seconds).
    pub efficiency: f64,
}

#[derive(Debug, Serialize)]
pub(super) struct CornellResults {
    pub processor: String,
    pub sampler: String,
    pub passes: u32,
    pub seeds: u32,
    pub figures: Vec<CornellResult>,
    pub peers: [CornellPeer; 2],
    pub peers_source: &'static str,
}

impl Display for CornellResults {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let header = ["threads", "samples", "CPU s", "wall s", "RMSE", "relMSE", "mean : reference", "1 / (MSE · s)"];
        let peers = PEERS.iter().flat_map(|peer| [format!("[{}]", peer.name), "ours : that".to_owned()]);
        let mut table = Table::new(0, header.map(str::to_owned).into_iter().chain(peers));
        self.figures.iter().for_each(|result| table.push(cells(result)));
        writeln!(
            f,
            "{table}\nMeans of {} renders with different seeds, sampler `{}`, of the whole process from start to written \
             image. [{}]",
            self.seeds, self.sampler, self.peers_source,
        )
    }
}

fn cells(result: &CornellResult) -> Vec<String> {
    let mut cells = vec![
        result.threads.map_or_else(|| "all".to_owned(), |threads| threads.to_string()),
        result.spp.to_string(),
        format!("{:.3}", result.cpu_seconds),
        format!("{:.3}", result.wall_seconds),
        format!("{:.5}", result.rmse),
        format!("{:.5}", result.relative_mse),
        format!("{:.4}", result.mean_ratio),
        three_digits(result.efficiency),
    ];
    for peer in &PEERS {
        let efficiency = peer.at(result.spp).map(|point| point.efficiency);
        cells.push(efficiency.map(three_digits).unwrap_or_default());
        cells.push(efficiency.map(|theirs| three_digits(result.efficiency / theirs)).unwrap_or_default());
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_compares_efficiency_at_equal_samples() {
        let result = CornellResult {
            threads: Some(1),
            spp: 16,
            cpu_seconds: 0.5,
            wall_seconds: 0.6,
            rmse: 0.01,
            relative_mse: 0.005,
            mean_ratio: 1.0,
            efficiency: 20_000.0,
        };
        let expected = "1; 16; 0.500; 0.600; 0.01000; 0.00500; 1.0000; 20,000; 7,629; 2.62; 1,906; 10.5";
        assert_eq!(cells(&result).join("; "), expected);
        let other = cells(&CornellResult { threads: None, spp: 17, ..result }).join("; ");
        assert!(other.starts_with("all; 17; ") && other.ends_with("; 20,000; ; ; ; "), "{other}");
    }
}
