//! A render from a loaded scene to a finished file and its report.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

use rt_camera::FilmSettings;
use rt_image::{ImageFormat, write_image};
use rt_render::{Crop, Part, PlanOptions, RenderError, RenderPlan, Rendering, RunOptions, Share, StopRule, Stopped};
use rt_scene_io::Scene;

use crate::aov_file::AovFile;
use crate::args::KeepArgs;
use crate::checkpoints::{self, Checkpoints};
use crate::console::Console;
use crate::display::Display;
use crate::error::Failure;
use crate::identity::Identity;
use crate::interruption::Listening;
use crate::kept_file::{self, KeptError, KeptKind, Label};
use crate::output::{OutputError, OutputFile, refuges, write_all};
use crate::stats::{Outcome, StatsFile};
use crate::watcher::Watcher;
use crate::{empty_picture, input, interruption, picture_file, report};

/// All that a render needs.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// For messages.
    pub(crate) scene_file: &'a Path,
    pub(crate) scene: &'a Scene,
    pub(crate) load_seconds: f64,
    pub(crate) options: PlanOptions,
    pub(crate) result: JobResult,
    pub(crate) stats: Option<OutputFile>,
    /// What ends the render, if not the scene's number of samples.
    pub(crate) rule: Option<StopRule>,
    /// What is kept of it; nothing if it is over soon.
    pub(crate) keep: Option<Keep<'a>>,
    /// 0 for one for each processor.
    pub(crate) threads: usize,
    pub(crate) strict: bool,
    /// Print all statistics rather than two lines.
    pub(crate) verbose: bool,
    /// Where the viewer is that shows the picture as it grows.
    pub(crate) display_server: Option<&'a str>,
    pub(crate) console: Console,
}

/// What a render makes.
#[derive(Debug)]
pub(crate) enum JobResult {
    /// A picture, and what else is known of its pixels.
    Picture { format: ImageFormat, output: OutputFile, aovs: Vec<AovFile> },
    /// A share of a picture.
    Part(OutputFile),
}

/// What is kept of a render that may take long.
#[derive(Debug)]
pub(crate) struct Keep<'a> {
    pub(crate) args: &'a KeepArgs,
    pub(crate) identity: Identity,
}

impl JobResult {
    /// The file that the user wants.
    pub(crate) const fn output(&self) -> &OutputFile {
        match self {
            Self::Picture { output, .. } | Self::Part(output) => output,
        }
    }

    fn aovs(&self) -> &[AovFile] {
        match self {
            Self::Picture { aovs, .. } => aovs,
            Self::Part(_) => &[],
        }
    }

    /// True if standard errors and numbers of samples are to be known. Those of a part may be wanted when it is joined.
    fn wants_maps(&self) -> bool {
        matches!(self, Self::Part(_)) || !self.aovs().is_empty()
    }
}

impl Job<'_> {
    /// Renders, writes the picture and the statistics, and reports.
    pub(crate) fn run(&self) -> Result<(), Failure> {
        if self.is_done()? {
            let part = self.result.output().path().display();
            return self.console.say(format_args!("{part} is there already, and finished"));
        }
        let plan = self.compile()?;
        let display = self.display_server.map(|server| self.connect(server)).transpose()?;
        self.say_notes(&plan)?;
        if let Some(warning) = empty_picture::unlit(self.scene, &plan) {
            self.console.warn(&warning);
            if self.strict {
                return Err(Failure::Warnings { file: self.scene_file.to_owned(), count: 1 });
            }
        }
        let refuges = refuges(self.keep.as_ref().and_then(|keep| keep.args.fallback.as_deref()));
        // Until everything is written: a signal that comes meanwhile must not cost what the render has made.
        let listening = interruption::listen();
        if interruption::is_interrupted() {
            return Err(Failure::Interrupted { percent: 0.0, picture: None, checkpoint: None });
        }
        let Rendered { part, checkpoints, kept, display } = self.render(&plan, &refuges, display, &listening)?;
        let written = Instant::now();
        let (stopped, missing_tiles) = (part.stopped(), part.missing_tiles());
        let is_written = matches!(self.result, JobResult::Picture { .. }) || missing_tiles == 0;
        let mut results = vec![self.write_part(&part, &refuges)];
        let rendering = part.into_rendering();
        results.extend(self.write_pictures(&rendering, &refuges));
        if let Some(display) = display {
            display.finish(&rendering.film);
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
            let stats_file = StatsFile::new(&outcome);
            results.push(stats.write_or_rescue(&refuges, |file| -> std::io::Result<()> {
                serde_json::to_writer_pretty(&mut *file, &stats_file)?;
                file.write_all(b"\n")
            }));
        }
        let written_all = write_all(results);
        if let (Err(_), Some(Ok(checkpoint))) = (&written_all, &kept) {
            let checkpoint = checkpoint.display();
            self.console
                .warn(format_args!("the render is not finished; --resume goes on from the checkpoint {checkpoint}"));
        }
        written_all?;
        let picture = is_written.then(|| self.result.output().path().to_owned());
        if stopped == Stopped::Interrupted {
            let percent = self.percent(&plan, &rendering);
            return Err(Failure::Interrupted { percent, picture, checkpoint: kept });
        }
        if self.verbose {
            self.console.say(report::statistics(&outcome, self.stats.is_some()))?;
        }
        if !rendering.lost.is_empty() {
            return Err(Failure::Lost { tiles: rendering.lost.len(), picture, checkpoint: kept });
        }
        self.say_written(&outcome)?;
        if let Some(checkpoints) = checkpoints {
            checkpoints.remove();
        }
        self.judge(rendering.statistics.bad_samples, rendering.statistics.samples)?;
        self.judge_content(&plan, &rendering)
    }

    /// A whole picture that shows nothing is probably not what was meant.
    fn judge_content(&self, plan: &RenderPlan<'_>, rendering: &Rendering) -> Result<(), Failure> {
        let JobResult::Picture { format, output, .. } = &self.result else { return Ok(()) };
        if self.options.crop.is_some() {
            return Ok(());
        }
        let (hits, is_developed) = (rendering.statistics.camera_hits, picture_file::is_developed(*format));
        match empty_picture::empty(self.scene, plan, &rendering.film, hits, is_developed) {
            Some(warning) if self.strict => Err(Failure::Empty { warning, file: output.path().to_owned() }),
            Some(warning) => {
                self.console.warn(warning);
                Ok(())
            }
            None => Ok(()),
        }
    }

    /// Writes the part, if that is what is wanted, and it is finished.
    fn write_part(&self, part: &Part, refuges: &[PathBuf]) -> Result<(), OutputError> {
        match (&self.result, self.label(KeptKind::Part)) {
            (JobResult::Part(output), Some(label)) if part.missing_tiles() == 0 => {
                output.write_or_rescue(refuges, |file| kept_file::write(file, &label, part))
            }
            _ => Ok(()),
        }
    }

    /// Writes the picture and what belongs to it, if that is what is wanted.
    fn write_pictures(&self, rendering: &Rendering, refuges: &[PathBuf]) -> Vec<Result<(), OutputError>> {
        let JobResult::Picture { format, output, aovs } = &self.result else { return Vec::new() };
        let development = &self.scene.film.development;
        let picture = output.write_or_rescue(refuges, |file| write_image(&rendering.film, development, *format, file));
        core::iter::once(picture).chain(aovs.iter().map(|aov| aov.write(rendering, refuges))).collect()
    }

    /// True if the part that is to be rendered or continued is there: finished, and of this picture.
    fn is_done(&self) -> Result<bool, Failure> {
        let (JobResult::Part(output), Some(Keep { args, identity })) = (&self.result, &self.keep) else {
            return Ok(false);
        };
        if !args.resume || !output.path().exists() {
            return Ok(false);
        }
        let (label, part) = kept_file::read::<Part>(output.path(), KeptKind::Part, self.options.memory)?;
        if label.identity != *identity || Some(part.share()) != args.shard {
            // An older part does not stand in the way of a newer render that was interrupted.
            if checkpoints::place(args, output).exists() {
                return Ok(false);
            }
            let advice = "; begin anew with --restart";
            let file = output.path().to_owned();
            return Err(KeptError::Foreign { file, scene: label.scene, advice }.into());
        }
        Ok(part.missing_tiles() == 0)
    }

    fn label(&self, kind: KeptKind) -> Option<Label> {
        let development = &self.scene.film.development;
        self.keep.as_ref().map(|keep| Label::new(kind, keep.identity, self.scene_file, development))
    }

    /// Samples taken, of those that were wanted as far as that is known.
    fn percent(&self, plan: &RenderPlan<'_>, rendering: &Rendering) -> f64 {
        let pixels = rendering.film.pixels().len() as f64 / f64::from(self.share().count());
        let per_pixel = self.rule.map_or(plan.samples_per_pixel(), |rule| rule.max_spp);
        100.0 * (rendering.statistics.samples as f64 / (pixels * f64::from(per_pixel))).min(1.0)
    }

    fn share(&self) -> Share {
        self.keep.as_ref().and_then(|keep| keep.args.shard).unwrap_or_default()
    }

    /// Says in two lines where the result is, what it took, and how far from the truth it is.
    fn say_written(&self, outcome: &Outcome<'_>) -> Result<(), Failure> {
        let path = self.result.output().path().display();
        let rendering = outcome.rendering;
        let what = match &self.result {
            JobResult::Picture { .. } => {
                format!(
                    "{path} ({}x{}, {})",
                    rendering.film.width(),
                    rendering.film.height(),
                    report::samples(rendering)
                )
            }
            JobResult::Part(_) => {
                let share = self.share();
                let (number, count) = (share.index() + 1, share.count());
                format!("{path} (part {number} of {count}; `merge` joins them)")
            }
        };
        self.console.say(format_args!("wrote {what} {}", report::effort(outcome)))?;
        self.console.say(report::ending_and_error(outcome))
    }

    fn compile(&self) -> Result<RenderPlan<'_>, Failure> {
        let film = &self.scene.film;
        let size = self.options.crop.map_or([film.width, film.height], |crop| [crop.width, crop.height]);
        if let JobResult::Picture { format, output, .. } = &self.result {
            picture_file::check(*format, size, self.options.transparent)?;
            output.check_space(picture_file::most_bytes(*format, size))?;
        }
        let plan =
            RenderPlan::compile(self.scene, &self.options).map_err(|error| Failure::plan(self.scene_file, error))?;
        if self.rule.is_some_and(|rule| rule.target.is_some()) && !plan.passes_differ() {
            let error = RenderError::SamePasses(self.scene.settings.pattern.name());
            return Err(Failure::plan(self.scene_file, error));
        }
        if self.rule.is_some() && plan.least_samples_per_pixel().is_some() {
            return Err(Failure::plan(self.scene_file, RenderError::AdaptiveUntil));
        }
        for aov in self.result.aovs() {
            aov.check(size, self.rule.is_some() || plan.passes() > 1)?;
        }
        Ok(plan)
    }

    /// Says what was chosen or changed.
    fn say_notes(&self, plan: &RenderPlan<'_>) -> Result<(), Failure> {
        input::say_notes(self.scene, self.console)?;
        if self.scene.settings.clamp.is_some() && plan.clamp().is_none() {
            let integrator = self.scene.settings.integrator.name();
            let which = if self.scene.settings.integrator.follows_light() { integrator } else { "this view" };
            self.console.say(format_args!(
                "note: clamp does nothing: it bounds indirect light of random paths, of which {which} has none"
            ))?;
        }
        if self.rule.is_some() {
            return Ok(());
        }
        let (asked, taken) = (self.scene.settings.spp, plan.samples_per_pixel());
        if asked == taken {
            return Ok(());
        }
        let sampler = self.scene.settings.pattern.name();
        self.console.say(format_args!("note: {sampler} takes {taken} samples per pixel rather than {asked}"))
    }

    /// The viewer, with a black image in it.
    fn connect(&self, server: &str) -> Result<Display, Failure> {
        let Scene { name, film: FilmSettings { width, height, .. }, .. } = self.scene;
        let part = self.options.crop.unwrap_or(Crop { x: 0, y: 0, width: *width, height: *height });
        Display::connect(server, name, part, self.options.transparent, self.console)
    }

    fn render(
        &self,
        plan: &RenderPlan<'_>,
        refuges: &[PathBuf],
        display: Option<Display>,
        listening: &Listening,
    ) -> Result<Rendered, Failure> {
        let label = self.label(KeptKind::Checkpoint);
        let mut earlier = None;
        let mut checkpoints = None;
        // Of what goes to standard output, checkpoints are kept only where they are told to go.
        let output = self.result.output();
        let keep = self.keep.as_ref().filter(|keep| !output.is_stdout() || keep.args.checkpoint.is_some());
        if let (Some(keep), Some(label)) = (keep, label) {
            let of_job = Checkpoints::new(keep.args, self.result.output(), label, self.console);
            earlier = of_job.earlier(keep.args, self.options.memory)?;
            if let Some(earlier) = &earlier {
                let (samples, file) = (earlier.samples(), of_job.file().display());
                self.console.say(format_args!("note: goes on from {file}, with {samples} samples"))?;
            }
            checkpoints = Some(of_job);
        }
        let run = RunOptions {
            threads: self.threads,
            count: self.stats.is_some(),
            maps: self.result.wants_maps(),
            share: self.share(),
            interrupt: Some(listening.flag()),
        };
        let mut watcher = Watcher::new(self.console.quiet, earlier.as_ref(), checkpoints, refuges.to_vec(), display);
        let part = plan.render_part(&run, self.rule.as_ref(), earlier, &mut watcher);
        let (checkpoints, kept, display) = watcher.finish();
        let part = part.map_err(|error| match (error, &checkpoints) {
            (RenderError::Checkpoint, Some(checkpoints)) => {
                KeptError::OtherOptions(checkpoints.file().to_owned()).into()
            }
            (error, _) => Failure::plan(self.scene_file, error),
        })?;
        Ok(Rendered { part, checkpoints, kept, display })
    }

    /// A picture with bad samples is worth keeping, but not worth trusting.
    fn judge(&self, bad_samples: u64, samples: u64) -> Result<(), Failure> {
        if bad_samples == 0 {
            return Ok(());
        }
        let damaged = Failure::Damaged { bad_samples, samples, file: self.result.output().path().to_owned() };
        if self.strict {
            return Err(damaged);
        }
        self.console.warn(damaged);
        Ok(())
    }
}

/// What comes out of a render.
struct Rendered {
    part: Part,
    checkpoints: Option<Checkpoints>,
    /// Where the checkpoint of an unfinished render is, or why it is nowhere.
    kept: Option<Result<PathBuf, String>>,
    display: Option<Display>,
}
