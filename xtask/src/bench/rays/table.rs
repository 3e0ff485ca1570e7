//! Results of `bench rays`, and their tables.

use std::fmt::{self, Display, Formatter};

use rt_accel::{Accelerator as _, AnyAccelerator, BuildStats};
use serde::Serialize;

use super::{mismatch::Mismatches, trace::Query};
use crate::{number::three_digits, table::Table, timings::Spread};

/// Building one accelerator over one mesh.
#[derive(Debug, Serialize)]
pub(super) struct BuildResult {
    pub scene: String,
    pub accelerator: &'static str,
    /// Relevant for the wide BVH only.
    pub quality: &'static str,
    pub threads: usize,
    /// Triangles with an area.
    pub triangles: usize,
    pub cpu_seconds: Spread,
    pub wall_seconds: Spread,
    /// Memory of the accelerator.
    pub bytes: usize,
    pub bytes_per_triangle: f64,
    /// Memory of vertices and indices, which the caller keeps.
    pub mesh_bytes: usize,
    pub shape: TreeShape,
}

/// Statistics of the built tree.
#[derive(Debug, Serialize)]
pub(super) struct TreeShape {
    pub nodes: usize,
    pub leaves: usize,
    pub references: usize,
    pub max_depth: usize,
    pub sah_cost: Option<f64>,
}

impl TreeShape {
    pub(super) fn of(accelerator: &AnyAccelerator) -> Self {
        let BuildStats { nodes, leaves, references, max_depth, sah_cost, .. } = accelerator.build_stats();
        Self { nodes, leaves, references, max_depth, sah_cost }
    }
}

/// Tracing one set of rays through one accelerator.
#[derive(Debug, Serialize)]
pub(super) struct RayResult {
    pub scene: String,
    pub kind: String,
    pub accelerator: &'static str,
    pub query: Query,
    /// Rays of a batch; `None` for single rays.
    pub batch: Option<usize>,
    pub threads: usize,
    pub rays: usize,
    /// Rays that hit something.
    pub hits: usize,
    /// Millions of rays for each second of a processor.
    pub mrays_per_cpu_second: Spread,
    /// Millions of rays for each second on the wall.
    pub mrays_per_second: Spread,
    /// By the reference, if there is one.
    pub wrong: Option<Mismatches>,
    /// Answers with other bits than those of `--same-as`.
    pub differing: Option<usize>,
}

impl RayResult {
    /// CPU time for one thread, wall time for several threads.
    pub(super) fn mega_rays(&self) -> Spread {
        if self.threads == 1 { self.mrays_per_cpu_second } else { self.mrays_per_second }
    }
}

#[derive(Debug, Default, Serialize)]
pub(super) struct RayResults {
    pub builds: Vec<BuildResult>,
    pub rays: Vec<RayResult>,
}

impl Display for RayResults {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "Millions of rays per second: median (min..max); CPU time on one thread, else wall time.\n")?;
        let header = ["scene", "rays", "accelerator", "Mrays/s", "hits", "leaks / ghosts / wrong t", "other bits"];
        let mut table = Table::new(3, header);
        for figure in &self.rays {
            let batch = figure.batch.map(|rays| format!(" in batches of {rays}")).unwrap_or_default();
            let wrong =
                figure.wrong.map(|Mismatches { leaks, ghosts, wrong_t }| format!("{leaks} / {ghosts} / {wrong_t}"));
            table.push([
                figure.scene.clone(),
                figure.kind.clone(),
                format!("{}{batch}", figure.accelerator),
                figure.mega_rays().shown(three_digits),
                format!("{} of {}", figure.hits, figure.rays),
                wrong.unwrap_or_default(),
                figure.differing.map(|count| count.to_string()).unwrap_or_default(),
            ]);
        }
        writeln!(f, "{table}\nBuilding: milliseconds of CPU time and of wall time, bytes per triangle.\n")?;
        let header = ["scene", "triangles", "accelerator", "CPU ms", "wall ms", "bytes", "nodes", "depth"];
        let mut table = Table::new(3, header);
        for figure in &self.builds {
            table.push([
                figure.scene.clone(),
                figure.triangles.to_string(),
                figure.accelerator.to_owned(),
                three_digits(figure.cpu_seconds.median * 1e3),
                three_digits(figure.wall_seconds.median * 1e3),
                format!("{:.1}", figure.bytes_per_triangle),
                figure.shape.nodes.to_string(),
                figure.shape.max_depth.to_string(),
            ]);
        }
        write!(f, "{table}")
    }
}
