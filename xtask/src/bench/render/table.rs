//! Results of `bench render`, and their table.

use std::{
    fmt::{self, Display, Formatter},
    path::PathBuf,
};

use serde::Serialize;

use super::peers::Peer;
use crate::{
    number::{grouped, three_digits},
    table::Table,
    timings::Spread,
};

#[derive(Debug, Serialize)]
pub(super) struct RenderResult {
    pub scene: String,
    pub size: (u64, u64),
    pub spp: u64,
    pub threads: u16,
    pub primary_rays: u64,
    pub shadow_rays: u64,
    pub all_rays: u64,
    pub cpu_seconds: Spread,
    pub wall_seconds: Spread,
    pub peak_bytes: u64,
    /// From start to end with 8×8 pixels of one sample: start, parsing, building, writing.
    pub small_wall_seconds: Spread,
    pub fastest_peer: Option<Peer>,
    pub image: PathBuf,
}

#[derive(Debug, Default, Serialize)]
pub(super) struct RenderResults {
    pub scenes: Vec<RenderResult>,
    /// Memory of an empty run, a lower bound of all memory measurements.
    pub min_bytes: u64,
    pub peers: &'static str,
}

impl Display for RenderResults {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let header = [
            "scene",
            "pixels, samples",
            "camera + shadow rays",
            "CPU s",
            "wall s",
            "peak MiB",
            "8×8: wall ms",
            "fastest peer, CPU s",
            "peer : ours",
        ];
        let mut table = Table::new(2, header);
        self.scenes.iter().for_each(|scene| table.push(cells(scene)));
        writeln!(
            f,
            "{table}\nMedian (min..max) of the whole process. An empty run has a peak of {} MiB. Shadow rays count as in the \
             report, with those that need not be traced. {}",
            mebibytes(self.min_bytes),
            self.peers,
        )
    }
}

fn cells(result: &RenderResult) -> [String; 9] {
    let RenderResult { scene, size: (width, height), spp, .. } = result;
    let peer = result.fastest_peer;
    [
        scene.clone(),
        format!("{width}×{height}, {spp}"),
        format!("{} + {}", grouped(result.primary_rays), grouped(result.shadow_rays)),
        result.cpu_seconds.shown(|seconds| format!("{seconds:.3}")),
        format!("{:.3}", result.wall_seconds.median),
        mebibytes(result.peak_bytes),
        format!("{:.1}", result.small_wall_seconds.median * 1e3),
        peer.map(|Peer { renderer, cpu_seconds, .. }| format!("[{renderer} {cpu_seconds:.2}]")).unwrap_or_default(),
        peer.map(|peer| three_digits(peer.cpu_seconds / result.cpu_seconds.median)).unwrap_or_default(),
    ]
}

fn mebibytes(bytes: u64) -> String {
    three_digits(bytes as f64 / f64::from(1 << 20))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_compares_processor_seconds() {
        let spread = |median| Spread { median, min: 0.4, max: 0.6 };
        let peer = Peer { scene: "s", renderer: "Other", cpu_seconds: 1.0 };
        let result = RenderResult {
            scene: "s".into(),
            size: (4, 3),
            spp: 2,
            threads: 1,
            primary_rays: 24,
            shadow_rays: 1000,
            all_rays: 1024,
            cpu_seconds: spread(0.5),
            wall_seconds: spread(0.55),
            peak_bytes: 3 << 19,
            small_wall_seconds: spread(0.5),
            fastest_peer: Some(peer),
            image: "s.png".into(),
        };
        let row = cells(&result).join("; ");
        assert_eq!(row, "s; 4×3, 2; 24 + 1,000; 0.500 (0.400..0.600); 0.550; 1.50; 500.0; [Other 1.00]; 2.00");
    }
}
