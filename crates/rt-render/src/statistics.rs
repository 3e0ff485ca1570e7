//! Counts and times of a render.

use rt_geometry::{Counters, RayKind, RayStats};
use rt_shading::ShadingCounts;
use serde::{Deserialize, Serialize};

use crate::{
    ContentError,
    content_checks::{MAX_COUNT, MAX_PASSES, MAX_THREADS, check_count, check_number},
};

/// Counts and times of one render. Counts are deterministic; times are not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Statistics {
    /// Camera samples taken.
    pub samples: u64,
    /// Camera samples that hit a surface.
    pub camera_hits: u64,
    /// Pixels without an edge, which took the minimum of samples; only with adaptive sampling in object space.
    pub simple_pixels: u64,
    /// Rays by kind, and with [`RunOptions::count`](crate::RunOptions) also nodes, primitive tests and hits.
    pub counters: Counters,
    /// Skipped camera rays: those of tiles without an object in view.
    pub primary_rays_skipped: u64,
    /// Work of shading.
    pub shading: ShadingCounts,
    /// Independent passes taken.
    pub passes: u32,
    /// Samples that are NaN, infinite or negative; they count as black.
    pub bad_samples: u64,
    /// Pixels in which light tracing exceeded the largest radiance of a pass, 2⁴¹, summed over passes; the excess is lost.
    pub saturated_pixels: u64,
    /// Number of threads, summed over all machines.
    pub threads: usize,
    /// Wall-clock seconds to flatten the scene and build acceleration structures, summed over all machines.
    pub build_seconds: f64,
    /// Wall-clock seconds to render, summed over all runs and machines.
    pub render_seconds: f64,
}

impl Statistics {
    /// Statistics before the first sample.
    pub(crate) fn new(threads: usize, build_seconds: f64) -> Self {
        Self { threads, build_seconds, ..Self::default() }
    }

    /// Statistics of a resumed render.
    pub(crate) const fn continued(self, run: &Self) -> Self {
        Self { threads: run.threads, build_seconds: run.build_seconds, ..self }
    }

    /// Adds the counts and times of a part of the same image: a tile, light paths, or another shard.
    pub(crate) fn join(&mut self, other: &Self) {
        self.samples += other.samples;
        self.camera_hits += other.camera_hits;
        self.simple_pixels += other.simple_pixels;
        self.counters += other.counters;
        self.primary_rays_skipped += other.primary_rays_skipped;
        self.shading += other.shading;
        self.passes = self.passes.max(other.passes);
        self.bad_samples += other.bad_samples;
        self.saturated_pixels += other.saturated_pixels;
        self.threads += other.threads;
        self.build_seconds += other.build_seconds;
        self.render_seconds += other.render_seconds;
    }

    /// Counts of camera samples and rays, by the names of their fields.
    pub const fn named(&self) -> [(&'static str, u64); 6] {
        // All fields are listed, so that a new one cannot be forgotten.
        let Self {
            samples,
            camera_hits,
            simple_pixels,
            primary_rays_skipped,
            bad_samples,
            saturated_pixels,
            counters: _,
            shading: _,
            passes: _,
            threads: _,
            build_seconds: _,
            render_seconds: _,
        } = *self;
        [
            ("samples", samples),
            ("camera_hits", camera_hits),
            ("simple_pixels", simple_pixels),
            ("primary_rays_skipped", primary_rays_skipped),
            ("bad_samples", bad_samples),
            ("saturated_pixels", saturated_pixels),
        ]
    }

    /// Checks that counts are at most [`MAX_COUNT`] and times are finite and not negative.
    pub(crate) fn validate(&self) -> Result<(), ContentError> {
        // `clamped_units` saturates, so that any value is valid.
        let clamped = [("clamped", self.shading.clamped)];
        for (name, count) in self.named().into_iter().chain(self.shading.named()).chain(clamped) {
            check_count(name, count, MAX_COUNT)?;
        }
        for kind in RayKind::ALL {
            let RayStats { rays, nodes, tests, hits } = self.counters.of(kind);
            check_count("rays", rays, MAX_COUNT)?;
            check_count("nodes", nodes, MAX_COUNT)?;
            check_count("primitive_tests", tests, MAX_COUNT)?;
            check_count("hits", hits, MAX_COUNT)?;
        }
        check_count("passes", self.passes.into(), MAX_PASSES.into())?;
        check_count("threads", self.threads as u64, MAX_THREADS)?;
        check_number("the build time in seconds", self.build_seconds)?;
        check_number("the render time in seconds", self.render_seconds)
    }

    /// Millions of rays of all kinds per second of rendering.
    pub fn mega_rays_per_second(&self) -> f64 {
        self.counters.total().rays as f64 / self.render_seconds.max(1e-9) * 1e-6
    }
}
