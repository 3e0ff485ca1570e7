//! A render from a loaded scene to a finished file and its report.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use rt_camera::FilmSettings;
use rt_image::{ImageFormat, write_image};
use rt_render::{
    Crop, FirstHitLayer, PlanOptions, RenderError, RenderPlan, Rendering, RunOptions, Shard, ShardSpec, Statistics,
    StopRule, Stopped,
};
use rt_scene_io::{Integrator, Scene};
use serde_json::Value;

use crate::aov_file::AovFile;
use crate::artifact_error::{ArtifactError, ArtifactKind};
use crate::checkpoint_format::{self, Label};
use crate::checkpointer::{CheckpointOptions, Checkpointer};
use crate::console::Console;
use crate::display::Display;
use crate::error::CliError;
use crate::output_error::OutputError;
use crate::output_file::{OutputFile, fallback_dirs, write_all};
use crate::render_observer::RenderObserver;
use crate::saved_checkpoint::SavedCheckpoint;
use crate::signals::SignalGuard;
use crate::stats::{self, Outcome};
use crate::{empty_image, image_file, input, memory, report, signals};

/// A render with all settings resolved.
#[derive(Debug)]
pub(crate) struct Job<'a> {
    /// For messages.
    pub(crate) scene_file: &'a Path,
    pub(crate) scene: &'a Scene,
    pub(crate) load_seconds: f64,
    pub(crate) options: PlanOptions,
    pub(crate) output: JobOutput,
    pub(crate) stats: Option<OutputFile>,
    /// Stop rule, unless the number of samples is fixed.
    pub(crate) rule: Option<StopRule>,
    pub(crate) checkpoint: Option<CheckpointOptions>,
    pub(crate) fallback_dir: Option<&'a Path>,
    /// Number of threads; 0 for one per processor.
    pub(crate) threads: usize,
    pub(crate) strict: bool,
    pub(crate) verbose: bool,
    /// Address of the viewer tev.
    pub(crate) display_server: Option<&'a str>,
    pub(crate) console: Console,
}

#[derive(Debug)]
pub(crate) enum JobOutput {
    Image {
        format: ImageFormat,
        file: OutputFile,
        aovs: Vec<AovFile>,
    },
    /// Shard of an image.
    Shard(OutputFile),
}

impl JobOutput {
    pub(crate) const fn file(&self) -> &OutputFile {
        match self {
            Self::Image { file, .. } | Self::Shard(file) => file,
        }
    }

    fn aovs(&self) -> &[AovFile] {
        match self {
            Self::Image { aovs, .. } => aovs,
            Self::Shard(_) => &[],
        }
    }

    /// Layers of first hits in any of the files.
    fn layers(&self) -> Vec<FirstHitLayer> {
        let mut layers = Vec::new();
        for &layer in self.aovs().iter().flat_map(AovFile::first_hit_layers) {
            if !layers.contains(&layer) {
                layers.push(layer);
            }
        }
        layers
    }

    /// True if standard errors and sample counts are kept. `merge` may ask for those of a shard.
    fn needs_maps(&self) -> bool {
        matches!(self, Self::Shard(_)) || self.aovs().iter().any(AovFile::needs_maps)
    }
}

impl Job<'_> {
    /// Renders, writes the image and the statistics, and reports. Signals do not end the program while the returned guard lives.
    pub(crate) fn run(&self) -> Result<SignalGuard, CliError> {
        if self.is_done()? {
            self.remove_leftover()?;
            let shard = self.output.file().path().display();
            self.console.println(format_args!("{shard} exists and is finished"))?;
            return Ok(signals::guard());
        }
        let plan = self.compile()?;
        let display = self.display_server.map(|server| self.connect(server)).transpose()?;
        self.print_notes(&plan)?;
        if let Some(warning) = empty_image::unlit(self.scene, &plan) {
            self.console.warn(&warning);
            if self.strict {
                return Err(CliError::Warnings { file: self.scene_file.to_owned(), count: 1 });
            }
        }
        let fallback_dirs = fallback_dirs(self.fallback_dir)?;
        // The guard lives until everything is written, so that a signal does not discard the image.
        let guard = signals::guard();
        if signals::is_interrupted() {
            return Err(CliError::InterruptedLoading { has_frames: false });
        }
        let (shard, observer) = self.render(&plan, &fallback_dirs, display, &guard)?;
        let RenderObserver { checkpointer, kept, display, .. } = observer;
        let written = Instant::now();
        let (stopped, missing_tiles) = (shard.stopped(), shard.missing_tiles());
        let is_written = matches!(self.output, JobOutput::Image { .. }) || missing_tiles == 0;
        let mut results = vec![self.write_shard(&shard, &fallback_dirs)];
        let mut rendering = shard.into_rendering();
        // A black image would replace an older one.
        if stopped == Stopped::Interrupted && rendering.samples_per_pixel.max == 0 {
            return Err(self.nothing_finished(kept));
        }
        results.push(self.write_image(&rendering, &fallback_dirs));
        let is_interrupted = stopped == Stopped::Interrupted;
        if is_interrupted {
            // Before the layers, which may take long.
            results.push(self.write_stats(&self.outcome(&plan, &rendering, written), &fallback_dirs));
        }
        results.extend(self.write_aovs(&plan, &mut rendering, &fallback_dirs));
        if let Some(display) = display {
            display.finish(&rendering.film);
        }
        let outcome = self.outcome(&plan, &rendering, written);
        if !is_interrupted {
            results.push(self.write_stats(&outcome, &fallback_dirs));
        }
        let written_all = write_all(results);
        if let (Err(_), Some(Ok(checkpoint))) = (&written_all, &kept) {
            self.console.warn(format_args!("the render is not finished; {}", checkpoint.advice("continues")));
        }
        written_all?;
        let image = is_written.then(|| self.output.file().path().to_owned());
        if is_interrupted {
            let after = self.work_done(&plan, &rendering);
            return Err(CliError::Interrupted { after, image, checkpoint: kept });
        }
        if self.verbose {
            self.console.println(report::statistics(&outcome, self.stats.is_some()))?;
        }
        if !rendering.lost.is_empty() {
            return Err(CliError::Lost { tiles: rendering.lost.len(), image, checkpoint: kept });
        }
        self.print_written(&outcome)?;
        if let Some(checkpointer) = checkpointer {
            checkpointer.remove();
        }
        self.check_samples(&rendering.statistics)?;
        self.check_content(&plan, &rendering)?;
        Ok(guard)
    }

    fn nothing_finished(&self, checkpoint: Option<Result<SavedCheckpoint, String>>) -> CliError {
        let in_passes = self.rule.is_some() || self.scene.settings.integrator == Integrator::Caustics;
        CliError::NothingFinished {
            unit: if in_passes { "pass" } else { "tile" },
            can_take_time: !in_passes && matches!(self.output, JobOutput::Image { .. }),
            checkpoint,
        }
    }

    /// Warns of an image that is black or shows no object.
    fn check_content(&self, plan: &RenderPlan<'_>, rendering: &Rendering) -> Result<(), CliError> {
        let JobOutput::Image { format, file, .. } = &self.output else { return Ok(()) };
        if self.options.crop.is_some() {
            return Ok(());
        }
        match empty_image::empty(self.scene, plan, rendering, image_file::is_developed(*format)) {
            Some(warning) if self.strict => Err(CliError::Empty { warning, file: file.path().to_owned() }),
            Some(warning) => {
                self.console.warn(warning);
                Ok(())
            }
            None => Ok(()),
        }
    }

    fn write_shard(&self, shard: &Shard, fallback_dirs: &[PathBuf]) -> Result<(), OutputError> {
        match (&self.output, self.label(ArtifactKind::Shard)) {
            (JobOutput::Shard(file), Some(label)) if shard.missing_tiles() == 0 => {
                file.write_with_fallback(fallback_dirs, |file| checkpoint_format::write(file, &label, shard))
            }
            _ => Ok(()),
        }
    }

    fn outcome<'b>(&'b self, plan: &'b RenderPlan<'_>, rendering: &'b Rendering, written: Instant) -> Outcome<'b> {
        Outcome {
            scene_file: self.scene_file,
            scene: self.scene,
            options: &self.options,
            plan,
            rendering,
            rule: self.rule,
            load_seconds: self.load_seconds,
            output_seconds: written.elapsed().as_secs_f64(),
        }
    }

    fn write_stats(&self, outcome: &Outcome<'_>, fallback_dirs: &[PathBuf]) -> Result<(), OutputError> {
        let Some(stats) = &self.stats else { return Ok(()) };
        let json = stats::json(outcome);
        stats.write_with_fallback(fallback_dirs, |file| writeln!(file, "{json:#}"))
    }

    fn write_image(&self, rendering: &Rendering, fallback_dirs: &[PathBuf]) -> Result<(), OutputError> {
        let JobOutput::Image { format, file, .. } = &self.output else { return Ok(()) };
        let development = &self.scene.film.development;
        file.write_with_fallback(fallback_dirs, |file| write_image(&rendering.film, development, *format, file))
    }

    /// Writes the files of `--aov`.
    fn write_aovs(
        &self,
        plan: &RenderPlan<'_>,
        rendering: &mut Rendering,
        fallback_dirs: &[PathBuf],
    ) -> Vec<Result<(), OutputError>> {
        let JobOutput::Image { aovs, .. } = &self.output else { return Vec::new() };
        let completed = plan.complete_layers(rendering, self.threads);
        let attributes = self.attributes(plan, rendering);
        let write = |aov: &AovFile| match &completed {
            Err(error) if !aov.first_hit_layers().is_empty() => {
                Err(OutputError::Write { path: aov.output().path().to_owned(), reason: error.to_string() })
            }
            _ => aov.write(rendering, &attributes, fallback_dirs),
        };
        aovs.iter().map(write).collect()
    }

    /// Texts that describe the render in files with layers.
    fn attributes(&self, plan: &RenderPlan<'_>, rendering: &Rendering) -> Vec<(&'static str, String)> {
        let settings = &self.scene.settings;
        let mut attributes = vec![
            ("renderer", concat!("rt ", env!("CARGO_PKG_VERSION")).to_owned()),
            ("scene", self.scene.name.clone()),
            ("camera", plan.camera_name().to_owned()),
            ("integrator", settings.integrator.name().to_owned()),
            ("spp", rendering.samples_per_pixel.mean.to_string()),
            ("seed", settings.seed.to_string()),
        ];
        let layers = self.output.layers();
        if layers.contains(&FirstHitLayer::ObjectId) {
            attributes.push(("objects", numbered_names(plan.object_names())));
        }
        if layers.contains(&FirstHitLayer::MaterialId) {
            let names = self.scene.appearance.materials.iter().map(|material| material.name.clone());
            attributes.push(("materials", numbered_names(names)));
        }
        let identity = self.checkpoint.as_ref().map(|options| ("sceneHash", options.identity.to_string()));
        attributes.extend(identity);
        attributes
    }

    /// True if the shard exists already: finished, of this image, and with its statistics if they are wanted.
    fn is_done(&self) -> Result<bool, CliError> {
        let (JobOutput::Shard(output), Some(options)) = (&self.output, &self.checkpoint) else {
            return Ok(false);
        };
        if !options.resume || !output.path().exists() {
            return Ok(false);
        }
        let (label, shard) = checkpoint_format::read::<Shard>(output.path(), ArtifactKind::Shard, self.options.memory)?;
        if label.identity != options.identity || Some(shard.spec()) != options.shard {
            // A checkpoint of this shard is newer than the older shard.
            if options.file.as_ref().is_some_and(|checkpoint| checkpoint.exists()) {
                return Ok(false);
            }
            let advice = "; start over with --restart";
            let file = output.path().to_owned();
            return Err(ArtifactError::Foreign { file, scene: label.scene, advice }.into());
        }
        let lacks_stats = self.stats.as_ref().is_some_and(|stats| !stats.is_file() || !stats.path().exists());
        Ok(shard.missing_tiles() == 0 && !lacks_stats)
    }

    /// Removes the checkpoint of a finished shard, which a kill before its removal left. Checkpoints of other images and shards stay.
    fn remove_leftover(&self) -> Result<(), CliError> {
        let (Some(options), Some(label)) = (&self.checkpoint, self.label(ArtifactKind::Checkpoint)) else {
            return Ok(());
        };
        let Some(file) = options.file.as_ref().filter(|file| file.exists()) else { return Ok(()) };
        let mut checkpointer = Checkpointer::new(file, options, label, self.console);
        // Other files in its place stay.
        if let Ok(Some(earlier)) = checkpointer.earlier(options, self.options.memory)
            && let plan = self.compile()?
            && [false, true]
                .into_iter()
                .any(|count| plan.accepts(&earlier, &RunOptions { count, ..self.run_options(&[], None) }, None))
        {
            checkpointer.remove();
        }
        Ok(())
    }

    fn label(&self, kind: ArtifactKind) -> Option<Label> {
        let development = &self.scene.film.development;
        self.checkpoint.as_ref().map(|options| Label::new(kind, options.identity, self.scene_file, development))
    }

    /// Percentage of the planned samples or, with a stop rule, samples per pixel.
    fn work_done(&self, plan: &RenderPlan<'_>, rendering: &Rendering) -> String {
        let pixels = rendering.film.pixels().len() as f64 / f64::from(self.shard().count());
        let per_pixel = rendering.statistics.samples as f64 / pixels;
        match self.rule {
            Some(_) => format!("{per_pixel:.1} samples per pixel"),
            None => {
                let percent = 100.0 * (per_pixel / f64::from(plan.samples_per_pixel())).min(1.0);
                format!("{percent:.1} % of the samples")
            }
        }
    }

    fn shard(&self) -> ShardSpec {
        self.checkpoint.as_ref().and_then(|options| options.shard).unwrap_or_default()
    }

    /// Prints the output path, the cost, and the estimated error.
    fn print_written(&self, outcome: &Outcome<'_>) -> Result<(), CliError> {
        let path = self.output.file().path().display();
        let rendering = outcome.rendering;
        let what = match &self.output {
            JobOutput::Image { file, format, .. } => {
                format!(
                    "{} ({}x{}, {})",
                    image_file::written(file, *format),
                    rendering.film.width(),
                    rendering.film.height(),
                    report::samples(rendering)
                )
            }
            JobOutput::Shard(_) => {
                let spec = self.shard();
                let (number, count) = (spec.index() + 1, spec.count());
                format!("{path} (shard {number} of {count}; `merge` combines them)")
            }
        };
        self.console.println(format_args!("wrote {what} {}", report::effort(outcome)))?;
        self.console.println(report::stop_reason_and_error(outcome))
    }

    fn compile(&self) -> Result<RenderPlan<'_>, CliError> {
        let film = &self.scene.film;
        let size = self.options.crop.map_or([film.width, film.height], |crop| [crop.width, crop.height]);
        if let JobOutput::Image { format, file, .. } = &self.output {
            image_file::check(file.path(), *format, size, self.options.transparent)?;
        }
        let plan =
            RenderPlan::compile(self.scene, &self.options).map_err(|error| CliError::plan(self.scene_file, error))?;
        // After a crop beyond the image is refused.
        if let JobOutput::Image { format, file, .. } = &self.output {
            file.check_space(image_file::max_bytes(*format, size))?;
        }
        if self.rule.is_some_and(|rule| rule.target.is_some()) && !plan.passes_differ() {
            let error = RenderError::SamePasses(self.scene.settings.pattern.name());
            return Err(CliError::plan(self.scene_file, error));
        }
        if self.rule.is_some() && plan.min_samples_per_pixel().is_some() {
            return Err(CliError::plan(self.scene_file, RenderError::AdaptiveUntil));
        }
        for aov in self.output.aovs() {
            aov.check(size, self.rule.is_some() || plan.passes() > 1)?;
            let pixels = u64::from(size[0]) * u64::from(size[1]);
            // The layers, their copy in the file, and while they are put together.
            let layers = ("the layers of --aov".to_owned(), aov.layer_bytes(pixels).saturating_mul(3));
            let render = ("the render without them".to_owned(), plan.memory().peak());
            memory::check(self.options.memory, aov.output().path(), &[render, layers])?;
            aov.output().check_space(aov.layer_bytes(pixels))?;
        }
        Ok(plan)
    }

    /// Prints chosen defaults and changed settings.
    fn print_notes(&self, plan: &RenderPlan<'_>) -> Result<(), CliError> {
        input::print_notes(self.scene, self.console)?;
        if self.scene.settings.clamp.is_some() && plan.clamp().is_none() {
            let integrator = self.scene.settings.integrator.name();
            let which = if self.scene.settings.integrator.follows_light() { integrator } else { "this view" };
            self.console.note(format_args!(
                "--clamp has no effect: it bounds indirect light of random paths, and {which} traces none"
            ))?;
        }
        if self.rule.is_some() {
            return Ok(());
        }
        let (requested, taken) = (self.scene.settings.spp, plan.samples_per_pixel());
        if requested == taken {
            return Ok(());
        }
        let (sampler, passes) = (self.scene.settings.pattern.name(), plan.passes());
        let how = match passes {
            1 => format!("the next number that the sampler {sampler} supports"),
            passes => format!("{passes} passes of {} {sampler} samples", taken / passes),
        };
        self.console.note(format_args!("{taken} samples per pixel instead of {requested}: {how}"))
    }

    fn connect(&self, server: &str) -> Result<Display, CliError> {
        let Scene { name, film: FilmSettings { width, height, .. }, .. } = self.scene;
        let part = self.options.crop.unwrap_or(Crop { x: 0, y: 0, width: *width, height: *height });
        Display::connect(server, name, part, self.options.transparent, self.console)
    }

    fn render(
        &self,
        plan: &RenderPlan<'_>,
        fallback_dirs: &[PathBuf],
        display: Option<Display>,
        guard: &SignalGuard,
    ) -> Result<(Shard, RenderObserver), CliError> {
        let layers = self.output.layers();
        let run = self.run_options(&layers, Some(guard.flag()));
        let (mut earlier, mut checkpointer) = (None, None);
        if let (Some(options), Some(label)) = (&self.checkpoint, self.label(ArtifactKind::Checkpoint))
            && let Some(file) = &options.file
        {
            let mut writer = Checkpointer::new(file, options, label, self.console);
            earlier = writer.earlier(options, self.options.memory)?;
            if let Some(earlier) = &earlier {
                if !plan.accepts(earlier, &run, self.rule.as_ref()) {
                    return Err(ArtifactError::OtherOptions(file.clone()).into());
                }
                let (samples, file) = (earlier.samples(), file.display());
                self.console.println(format_args!("note: continues from {file}, with {samples} samples"))?;
            }
            checkpointer = Some(writer);
        }
        let (quiet, fallback_dirs) = (self.console.quiet, fallback_dirs.to_vec());
        let mut observer = RenderObserver::new(quiet, earlier.as_ref(), checkpointer, fallback_dirs, display);
        let shard = plan.render_shard(&run, self.rule.as_ref(), earlier, &mut observer);
        observer.progress.finish();
        let shard = shard.map_err(|error| CliError::plan(self.scene_file, error))?;
        Ok((shard, observer))
    }

    fn run_options<'b>(&self, layers: &'b [FirstHitLayer], interrupt: Option<&'b AtomicBool>) -> RunOptions<'b> {
        RunOptions {
            threads: self.threads,
            count: self.stats.is_some(),
            maps: self.output.needs_maps(),
            shard: self.shard(),
            interrupt,
            layers,
        }
    }

    /// Warns of bad samples and of lost light; an error with `--strict`.
    fn check_samples(&self, statistics: &Statistics) -> Result<(), CliError> {
        let Statistics { bad_samples, samples, saturated_pixels: pixels, .. } = *statistics;
        let file = self.output.file().path();
        let damaged = (bad_samples > 0).then(|| CliError::Damaged { bad_samples, samples, file: file.to_owned() });
        let saturated = (pixels > 0).then(|| CliError::Saturated { pixels, file: file.to_owned() });
        for error in damaged.into_iter().chain(saturated) {
            if self.strict {
                return Err(error);
            }
            self.console.warn(error);
        }
        Ok(())
    }
}

/// Names by number as JSON. Numbers begin at 1; 0 is where nothing is hit.
fn numbered_names(names: impl IntoIterator<Item = String>) -> String {
    let named = names.into_iter().map(Value::String);
    Value::Array(core::iter::once(Value::Null).chain(named).collect()).to_string()
}
