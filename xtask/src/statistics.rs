//! The renderer's statistics file, as far as tasks read it, and the report's figures to compare with.

use std::{fs, path::Path};

use serde::Deserialize;

use crate::{error::TaskError, renderer::Renderer};

/// Contents of the file that `--stats` writes.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
pub(crate) struct Statistics {
    pub rays: Rays,
    pub shading: Shading,
}

/// Rays by kind.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
pub(crate) struct Rays {
    pub primary: Cost,
    pub shadow: Cost,
    pub total: Cost,
}

/// Counters of the rays of one kind.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
pub(crate) struct Cost {
    pub rays: u64,
    pub primitive_tests: u64,
    pub hits: u64,
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq)]
pub(crate) struct Shading {
    pub shadow_rays_spared: u64,
}

impl Statistics {
    /// Shadow rays as the report counts them: also those that ours need not trace.
    pub(crate) fn shadow_rays(&self) -> u64 {
        self.rays.shadow.rays + self.shading.shadow_rays_spared
    }
}

/// A row of the report's Table 1: 1280×720 pixels, 16 half-jittered samples, two lights.
#[derive(Debug)]
pub(crate) struct ReportRow {
    pub scene: &'static str,
    pub spheres: u64,
    /// Printed value, times 10⁶.
    pub shadow_rays: f64,
    pub seconds: f64,
}

/// Primary rays of every row.
pub(crate) const REPORT_PRIMARY: u64 = 14_745_600;

pub(crate) const REPORT: [ReportRow; 3] = [
    ReportRow { scene: "scenes/report/mound10.ron", spheres: 10, shadow_rays: 2.84e6, seconds: 4.0 },
    ReportRow { scene: "scenes/report/mound100.ron", spheres: 100, shadow_rays: 11.1e6, seconds: 44.0 },
    ReportRow { scene: "scenes/report/mound1000.ron", spheres: 1000, shadow_rays: 23.4e6, seconds: 681.0 },
];

/// Renders `scene` in `folder` with these arguments and reads its statistics; `Err` in the inside if rendering fails.
pub(crate) fn measure(
    renderer: &Renderer,
    folder: &Path,
    scene: &Path,
    args: &[&str],
) -> Result<Result<Statistics, String>, TaskError> {
    let args = ["--stats", "stats.json"].iter().chain(args).copied();
    if let Err(problem) = renderer.render(folder, scene, "picture.png", args)?.succeeded() {
        return Ok(Err(problem));
    }
    let path = folder.join("stats.json");
    let text = fs::read_to_string(&path).map_err(TaskError::file(&path))?;
    serde_json::from_str(&text).map(Ok).map_err(|source| TaskError::Json { path, source })
}
