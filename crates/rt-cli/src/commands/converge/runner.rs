//! Runner of an experiment: renders every method at every sample count with every seed, within a time limit.

use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use cpu_time::ProcessTime;
use rt_image::Image;
use rt_render::{Progress, RenderPlan, RunOptions, Stopped};
use serde::Serialize;

use super::methods::{Method, MethodName};
use super::reference::{Errors, Reference};
use crate::error::CliError;
use crate::progress::ProgressDisplay;

/// Renders methods one after the other, with progress over all of them.
#[derive(Debug)]
pub(super) struct BenchRunner<'a> {
    /// For messages.
    pub(super) scene_file: &'a std::path::Path,
    /// Number of threads; 0 for one per processor.
    pub(super) threads: usize,
    pub(super) clock: Clock,
    /// Flag that a signal sets.
    interrupt: &'static AtomicBool,
    progress: ProgressDisplay,
    /// Samples and rays of all finished renders.
    samples: u64,
    rays: u64,
    /// Samples of all planned renders.
    total_samples: u64,
}

/// Time limit of an experiment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clock {
    started: Instant,
    limit: Option<Duration>,
}

#[derive(Debug)]
pub(super) struct TimedRender {
    pub(super) film: Image,
    pub(super) spp: u32,
    /// Processor time of all threads for rendering.
    pub(super) cpu_seconds: f64,
    /// Wall-clock time of rendering.
    pub(super) wall_seconds: f64,
    /// Wall-clock time of compiling the plan.
    pub(super) build_seconds: f64,
    pub(super) bad_samples: u64,
    pub(super) threads: usize,
}

impl Clock {
    pub(super) fn start(limit: Option<Duration>) -> Self {
        Self { started: Instant::now(), limit }
    }

    pub(super) fn elapsed(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }

    /// Limit in seconds.
    pub(super) fn limit(&self) -> Option<f64> {
        self.limit.map(|limit| limit.as_secs_f64())
    }

    /// True if the limit leaves this many seconds.
    pub(super) fn has(&self, seconds: f64) -> bool {
        self.limit().is_none_or(|limit| self.elapsed() + seconds <= limit)
    }
}

impl<'a> BenchRunner<'a> {
    pub(super) fn new(
        scene_file: &'a std::path::Path,
        threads: usize,
        clock: Clock,
        interrupt: &'static AtomicBool,
        progress: ProgressDisplay,
        total_samples: u64,
    ) -> Self {
        Self { scene_file, threads, clock, interrupt, progress, samples: 0, rays: 0, total_samples }
    }

    /// Renders an image.
    ///
    /// # Errors
    /// [`CliError`] if the method cannot be rendered, or after a signal.
    pub(super) fn render(&mut self, method: &mut Method, spp: u32, seed: u64) -> Result<TimedRender, CliError> {
        let failed = |error| CliError::plan(self.scene_file, error);
        (method.scene.settings.spp, method.scene.settings.seed) = (spp, seed);
        let plan = RenderPlan::compile(&method.scene, &method.options).map_err(failed)?;
        let run = RunOptions { threads: self.threads, interrupt: Some(self.interrupt), ..RunOptions::default() };
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
        if rendering.stopped == Stopped::Interrupted {
            return Err(CliError::RenderInterrupted);
        }
        let statistics = &rendering.statistics;
        self.samples += statistics.samples;
        self.rays += statistics.counters.total().rays;
        Ok(TimedRender {
            spp: plan.samples_per_pixel(),
            cpu_seconds,
            wall_seconds: statistics.render_seconds,
            build_seconds: statistics.build_seconds,
            bad_samples: statistics.bad_samples,
            threads: statistics.threads,
            film: rendering.film,
        })
    }

    pub(super) fn set_total_samples(&mut self, total_samples: u64) {
        self.total_samples = total_samples;
    }

    pub(super) fn close(self) {
        self.progress.finish();
    }
}

#[derive(Debug)]
pub(super) struct Experiment {
    pub(super) methods: Vec<Measured>,
    /// Samples per pixel beyond the time limit, or after an interrupt.
    pub(super) left_out: Vec<u32>,
    pub(super) is_interrupted: bool,
    /// NaN, infinite or negative samples in all renders; they count as black.
    pub(super) bad_samples: u64,
    pub(super) threads: usize,
}

#[derive(Debug)]
pub(super) struct Measured {
    pub(super) name: MethodName,
    /// Ascending samples per pixel.
    pub(super) points: Vec<Point>,
    /// Images of the first seed with the fewest and the most samples.
    pub(super) images: [Option<MeasuredImage>; 2],
}

#[derive(Debug)]
pub(super) struct MeasuredImage {
    pub(super) spp: u32,
    pub(super) film: Image,
}

/// Measurements of a method at one sample count.
#[derive(Clone, Debug)]
pub(super) struct Point {
    /// Samples per pixel that were taken.
    pub(super) spp: u32,
    /// One run per seed.
    pub(super) runs: Vec<Run>,
    /// FLIP of the first seed; `None` without a reference image.
    pub(super) flip: Option<f64>,
}

/// Errors and times of one render.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Run {
    pub(super) seed: u64,
    #[serde(flatten)]
    pub(super) errors: Errors,
    /// Processor time of all threads for rendering.
    pub(super) cpu_seconds: f64,
    pub(super) wall_seconds: f64,
    pub(super) build_seconds: f64,
}

/// Time of a run, to predict the next one.
#[derive(Clone, Copy, Debug)]
struct Cost {
    /// Seconds for building and measuring.
    fixed: f64,
    /// Seconds for rendering.
    per_sample: f64,
}

/// Sample counts and repetitions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent<'a> {
    /// Samples per pixel, ascending.
    pub(super) series: &'a [u32],
    pub(super) seeds: u32,
}

impl Extent<'_> {
    /// Samples of all renders.
    pub(super) fn samples(&self, methods: &[Method]) -> u64 {
        let of = |method: &Method| self.series.iter().map(|&spp| method.samples(spp)).sum::<u64>();
        methods.iter().map(of).sum::<u64>() * u64::from(self.seeds)
    }
}

/// Runs the experiment within the time limit, or until a signal. A sample count is measured with all methods and seeds, or skipped;
/// a time limit never skips the first. `after` is called after each one.
///
/// Methods take turns, so that other load on the machine affects all of them.
pub(super) fn run(
    runner: &mut BenchRunner<'_>,
    methods: &mut [Method],
    extent: Extent<'_>,
    reference: &Reference,
    mut after: impl FnMut(&Experiment) -> Result<(), CliError>,
) -> Result<Experiment, CliError> {
    let empty = |method: &Method| Measured { name: method.name.clone(), points: Vec::new(), images: [None, None] };
    let mut experiment = Experiment {
        methods: methods.iter().map(empty).collect(),
        left_out: Vec::new(),
        is_interrupted: false,
        bad_samples: 0,
        threads: 0,
    };
    let first_seeds: Vec<u64> = methods.iter().map(|method| method.scene.settings.seed).collect();
    let mut costs: Vec<Option<Cost>> = vec![None; methods.len()];
    for (wave, &spp) in extent.series.iter().enumerate() {
        let needed: f64 = methods.iter().zip(&costs).map(|(method, cost)| predicted(method, *cost, spp)).sum();
        let mut is_complete = wave == 0 || runner.clock.has(needed * f64::from(extent.seeds));
        let mut points = vec![Point { spp: 0, runs: Vec::new(), flip: None }; methods.len()];
        let mut films: Vec<Option<Image>> = vec![None; methods.len()];
        'wave: for number in 0..extent.seeds {
            for (index, method) in methods.iter_mut().enumerate() {
                is_complete &= wave == 0 || runner.clock.has(predicted(method, costs[index], spp));
                if !is_complete {
                    break 'wave;
                }
                let started = runner.clock.elapsed();
                let seed = first_seeds[index].wrapping_add(number.into());
                let timed = match runner.render(method, spp, seed) {
                    Err(CliError::RenderInterrupted) => {
                        (experiment.is_interrupted, is_complete) = (true, false);
                        break 'wave;
                    }
                    timed => timed?,
                };
                points[index].add(&timed, seed, reference, method)?;
                let samples = method.samples(spp) as f64;
                let elapsed = runner.clock.elapsed() - started;
                let fixed = (elapsed - timed.wall_seconds).max(0.0);
                costs[index] = Some(Cost { fixed, per_sample: timed.wall_seconds / samples });
                experiment.bad_samples += timed.bad_samples;
                experiment.threads = timed.threads;
                if number == 0 {
                    films[index] = Some(timed.film);
                }
            }
        }
        if !is_complete {
            experiment.left_out = extent.series[wave..].to_vec();
            break;
        }
        for ((measured, point), film) in experiment.methods.iter_mut().zip(points).zip(films) {
            measured.add(point, film);
        }
        after(&experiment)?;
    }
    Ok(experiment)
}

/// Predicted seconds of a render; 0 before the first measurement.
fn predicted(method: &Method, cost: Option<Cost>, spp: u32) -> f64 {
    cost.map_or(0.0, |cost| cost.fixed + cost.per_sample * method.samples(spp) as f64)
}

impl Measured {
    /// Adds a point, unless the sampler rounded up to the previous sample count.
    fn add(&mut self, point: Point, film: Option<Image>) {
        let Some(film) = film.filter(|_| self.points.last().is_none_or(|last| last.spp != point.spp)) else { return };
        let slot = usize::from(self.images[0].is_some());
        self.images[slot] = Some(MeasuredImage { spp: point.spp, film });
        self.points.push(point);
    }

    /// Image with the most samples.
    pub(super) fn last_image(&self) -> Option<&MeasuredImage> {
        self.images.iter().flatten().last()
    }
}

impl Point {
    fn add(&mut self, timed: &TimedRender, seed: u64, reference: &Reference, method: &Method) -> Result<(), CliError> {
        let unlike = |source| CliError::Pair { test: "the render".into(), reference: "the reference".into(), source };
        let errors = reference.measure(&timed.film).map_err(unlike)?;
        if self.runs.is_empty() {
            let development = &method.scene.film.development;
            let flip = reference.image().map(|reference| reference.flip(&timed.film, development));
            self.flip = flip.transpose().map_err(unlike)?;
        }
        self.spp = timed.spp;
        let TimedRender { cpu_seconds, wall_seconds, build_seconds, .. } = *timed;
        self.runs.push(Run { seed, errors, cpu_seconds, wall_seconds, build_seconds });
        Ok(())
    }
}
