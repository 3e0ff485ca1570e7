//! Renders one after the other, timed, within a time limit, with progress over all of them.

use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use rt_image::Image;
use rt_render::{Progress, RenderPlan, RunOptions};

use super::methods::Method;
use crate::error::Failure;
use crate::progress::ProgressDisplay;

/// Where methods are rendered.
#[derive(Debug)]
pub(super) struct Laboratory<'a> {
    /// For messages.
    pub(super) scene_file: &'a std::path::Path,
    /// 0 for one for each processor.
    pub(super) threads: usize,
    pub(super) clock: Clock,
    progress: ProgressDisplay,
    /// Of all renders before the one under way.
    samples: u64,
    rays: u64,
    /// Of all renders that are planned.
    total_samples: u64,
}

/// The time that there is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clock {
    started: Instant,
    limit: Option<Duration>,
}

/// A finished render.
#[derive(Debug)]
pub(super) struct Shot {
    pub(super) film: Image,
    /// Samples per pixel that were taken.
    pub(super) spp: u32,
    /// Processor time of all threads for rendering.
    pub(super) cpu_seconds: f64,
    /// Time that passed while rendering.
    pub(super) wall_seconds: f64,
    /// Time that passed while the plan was made.
    pub(super) build_seconds: f64,
    pub(super) bad_samples: u64,
    /// Threads that worked.
    pub(super) threads: usize,
}

impl Clock {
    pub(super) fn start(limit: Option<Duration>) -> Self {
        Self { started: Instant::now(), limit }
    }

    /// Seconds since the start.
    pub(super) fn elapsed(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Seconds that are allowed in all.
    pub(super) fn limit(&self) -> Option<f64> {
        self.limit.map(|limit| limit.as_secs_f64())
    }

    /// Whether there is time for so many seconds more.
    pub(super) fn has(&self, seconds: f64) -> bool {
        self.limit().is_none_or(|limit| self.elapsed() + seconds <= limit)
    }
}

impl<'a> Laboratory<'a> {
    /// A laboratory for renders of so many samples in all.
    pub(super) fn new(
        scene_file: &'a std::path::Path,
        threads: usize,
        clock: Clock,
        progress: ProgressDisplay,
        total_samples: u64,
    ) -> Self {
        Self { scene_file, threads, clock, progress, samples: 0, rays: 0, total_samples }
    }

    /// Renders a method with this seed and at least so many samples per pixel.
    pub(super) fn render(&mut self, method: &mut Method, spp: u32, seed: u64) -> Result<Shot, Failure> {
        let failed = |error| Failure::plan(self.scene_file, error);
        (method.scene.settings.spp, method.scene.settings.seed) = (spp, seed);
        let plan = RenderPlan::compile(&method.scene, &method.options).map_err(failed)?;
        let run = RunOptions { threads: self.threads, ..RunOptions::default() };
        let (samples, rays, total_samples) = (self.samples, self.rays, self.total_samples);
        let progress = &mut self.progress;
        let started = ProcessTime::now();
        let rendering = plan.render(&run, |so_far: Progress| {
            progress.update(Progress {
                samples: samples + so_far.samples,
                total_samples,
                rays: rays + so_far.rays,
                ..so_far
            });
        });
        let cpu_seconds = started.elapsed().as_secs_f64();
        let rendering = rendering.map_err(failed)?;
        let statistics = &rendering.statistics;
        self.samples += statistics.samples;
        self.rays += statistics.counters.total().rays;
        Ok(Shot {
            spp: plan.samples_per_pixel(),
            cpu_seconds,
            wall_seconds: statistics.render_seconds,
            build_seconds: statistics.build_seconds,
            bad_samples: statistics.bad_samples,
            threads: statistics.threads,
            film: rendering.film,
        })
    }

    /// Corrects how many samples are planned.
    pub(super) fn plan(&mut self, total_samples: u64) {
        self.total_samples = total_samples;
    }

    /// Takes the progress away.
    pub(super) fn close(self) {
        self.progress.finish();
    }
}
