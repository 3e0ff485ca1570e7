//! Measured costs of one accelerator on one scene.

use serde::Serialize;

/// One accelerator on one scene.
#[derive(Debug, Serialize)]
pub(crate) struct Figure {
    pub scene: &'static str,
    pub primitives: usize,
    pub accelerator: &'static str,
    /// Minimum time of a build, on all threads.
    pub build_seconds: f64,
    /// Bytes held after all rays have been traced.
    pub bytes: usize,
    pub nodes: usize,
    pub leaves: usize,
    pub references: usize,
    pub max_depth: usize,
    pub rays: Vec<RayFigure>,
}

/// Rays of one kind through one accelerator of one scene.
#[derive(Debug, Serialize)]
pub(crate) struct RayFigure {
    pub kind: &'static str,
    pub rays: usize,
    /// Rays that hit something.
    pub hits: usize,
    /// Nodes or cells visited by all rays together.
    pub nodes: u64,
    /// Primitives tested by all rays together.
    pub tests: u64,
    /// Minimum time of all rays together, on one thread.
    pub seconds: f64,
    /// Time of the first pass, which counts and in which a lazy accelerator builds itself.
    pub first_seconds: f64,
}

impl Figure {
    pub(crate) fn of(&self, kind: &str) -> Option<&RayFigure> {
        self.rays.iter().find(|figure| figure.kind == kind)
    }

    pub(crate) fn bytes_per_primitive(&self) -> f64 {
        self.bytes as f64 / self.primitives as f64
    }

    /// Nodes and tests of a ray, the mean over all kinds.
    pub(crate) fn work(&self) -> f64 {
        self.rays.iter().map(RayFigure::work).sum::<f64>() / self.rays.len() as f64
    }

    /// Seconds of a ray, the mean over all kinds.
    pub(crate) fn seconds_per_ray(&self) -> f64 {
        self.rays.iter().map(|figure| figure.seconds / figure.rays as f64).sum::<f64>() / self.rays.len() as f64
    }
}

impl RayFigure {
    pub(crate) fn nodes_per_ray(&self) -> f64 {
        self.nodes as f64 / self.rays as f64
    }

    pub(crate) fn tests_per_ray(&self) -> f64 {
        self.tests as f64 / self.rays as f64
    }

    pub(crate) fn work(&self) -> f64 {
        self.nodes_per_ray() + self.tests_per_ray()
    }

    pub(crate) fn mega_rays(&self) -> f64 {
        self.rays as f64 / self.seconds * 1e-6
    }
}
