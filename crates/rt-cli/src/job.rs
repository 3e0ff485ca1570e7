//! A render from a loaded scene to a finished file and its report.

use std::env;
use std::path::Path;
use std::time::Instant;

use rt_camera::{ImageFormat, write_image};
use rt_render::{PlanOptions, RenderError, RenderPlan, Rendering, RunOptions, StopRule};
use rt_scene_io::Scene;
use serde::Serialize;

use crate::aov_file::AovFile;
use crate::console::Console;
use crate::error::Failure;
use crate::input;
use crate::output::OutputFile;
use crate::picture_file;
use crate::progress::ProgressDisplay;
use crate::report;
use crate::stats::{Outcome, StatsFile};

/// All that a render needs.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// For messages.
    pub(crate) scene_file: &'a Path,
    pub(crate) scene: &'a Scene,
    pub(crate) load_seconds: f64,
    pub(crate) options: PlanOptions,
    pub(crate) format: ImageFormat,
    pub(crate) output: OutputFile,
    pub(crate) stats: Option<OutputFile>,
    pub(crate) aovs: Vec<AovFile>,
    /// What ends the render, if not the scene's number of samples.
    pub(crate) rule: Option<StopRule>,
    /// 0 for one for each processor.
    pub(crate) threads: usize,
    pub(crate) strict: bool,
    pub(crate) console: Console,
}

impl Job<'_> {
    /// Renders, writes the picture and the statistics, and reports.
    pub(crate) fn run(&self) -> Result<(), Failure> {
        let plan = self.compile()?;
        self.say_notes(&plan)?;
        let rendering = self.render(&plan)?;
        let Rendering { film, statistics, .. } = &rendering;
        let written = Instant::now();
        let development = &self.scene.film.development;
        self.output.write_or_rescue(&env::temp_dir(), |file| write_image(film, development, self.format, file))?;
        for aov in &self.aovs {
            aov.write(&rendering)?;
        }
        let outcome = Outcome {
            scene_file: self.scene_file,
            scene: self.scene,
            options: &self.options,
            plan: &plan,
            rendering: &rendering,
            rule: self.rule,
            load_seconds: self.load_seconds,
            output_seconds: written.elapsed().as_secs_f64(),
        };
        if let Some(stats) = &self.stats {
            write_json(stats, &StatsFile::new(&outcome))?;
        }
        self.console.say(report::statistics(&outcome, self.stats.is_some()))?;
        let (width, height) = (film.width(), film.height());
        self.console.say(format_args!("wrote {} ({width}x{height})", self.output.path().display()))?;
        self.judge(statistics.bad_samples, statistics.samples)
    }

    fn compile(&self) -> Result<RenderPlan<'_>, Failure> {
        let film = &self.scene.film;
        let size = self.options.crop.map_or([film.width, film.height], |crop| [crop.width, crop.height]);
        picture_file::check(self.format, size, self.options.transparent)?;
        let plan =
            RenderPlan::compile(self.scene, &self.options).map_err(|error| Failure::plan(self.scene_file, error))?;
        if self.rule.is_some_and(|rule| rule.target.is_some()) && !plan.passes_differ() {
            let error = RenderError::SamePasses(self.scene.settings.pattern.name());
            return Err(Failure::plan(self.scene_file, error));
        }
        if self.rule.is_some() && plan.least_samples_per_pixel().is_some() {
            return Err(Failure::plan(self.scene_file, RenderError::AdaptiveUntil));
        }
        for aov in &self.aovs {
            aov.check(size, self.rule.is_some() || plan.passes() > 1)?;
        }
        Ok(plan)
    }

    /// Says what was chosen or changed.
    fn say_notes(&self, plan: &RenderPlan<'_>) -> Result<(), Failure> {
        input::say_notes(self.scene, self.console)?;
        if let Some(rule) = self.rule {
            return self.console.say(format_args!("note: at most {} samples per pixel", rule.max_spp));
        }
        let (asked, taken) = (self.scene.settings.spp, plan.samples_per_pixel());
        if asked == taken {
            return Ok(());
        }
        let sampler = self.scene.settings.pattern.name();
        self.console.say(format_args!("note: {sampler} takes {taken} samples per pixel rather than {asked}"))
    }

    fn render(&self, plan: &RenderPlan<'_>) -> Result<Rendering, Failure> {
        let run = RunOptions { threads: self.threads, count: self.stats.is_some(), maps: !self.aovs.is_empty() };
        let mut progress = ProgressDisplay::new(self.console.quiet);
        let rendering = match &self.rule {
            Some(rule) => plan.render_until(&run, rule, |so_far| progress.update(so_far)),
            None => plan.render(&run, |so_far| progress.update(so_far)),
        };
        progress.finish();
        rendering.map_err(|error| Failure::plan(self.scene_file, error))
    }

    /// A picture with bad samples is worth keeping, but not worth trusting.
    fn judge(&self, bad_samples: u64, samples: u64) -> Result<(), Failure> {
        if bad_samples == 0 {
            return Ok(());
        }
        let damaged = Failure::Damaged { bad_samples, samples, file: self.output.path().to_owned() };
        if self.strict {
            return Err(damaged);
        }
        self.console.warn(damaged);
        Ok(())
    }
}

fn write_json(file: &OutputFile, content: &impl Serialize) -> Result<(), Failure> {
    Ok(file.write(|file| serde_json::to_writer_pretty(file, content))?)
}
