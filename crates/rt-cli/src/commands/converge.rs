//! `converge`: error of several methods against their run time.

mod log_axis;
mod methods;
mod page;
mod plot;
mod reference;
mod report;
mod run_info;
mod runner;
mod split_reference;
mod statistics;
mod summary;
mod table;

use std::path::PathBuf;

use rt_scene_io::{Scene, StudioLights};

use self::methods::Method;
use self::reference::Reference;
use self::report::{Outputs, Report, Setting};
use self::runner::{BenchRunner, Clock, Extent};
use crate::args::{ConvergeArgs, ImageArgs, ReferenceKind};
use crate::console::Console;
use crate::error::{CliError, usage};
use crate::input;
use crate::progress::ProgressDisplay;
use crate::signals;
use crate::stdin::is_dash;

pub(super) fn run(args: &ConvergeArgs) -> Result<(), CliError> {
    let clock = Clock::start(args.run.time);
    let console = Console { quiet: args.run.quiet };
    let image = args.fixed.with(&[]).map_err(CliError::Usage)?;
    // Wrong options are reported before files are read.
    let choices = methods::parse(args)?;
    if args.reference_kind == Some(ReferenceKind::Reference) && args.reference.is_none() {
        return usage("--reference-kind reference requires --reference FILE");
    }
    if args.output.as_deref().is_some_and(is_dash) {
        return usage("--output - is not supported: `converge` writes several files into a directory");
    }
    let input = input::read(&args.input, Some(&image), console)?;
    let scene = &input.scene;
    input::print_notes(scene, console)?;
    let mut methods = methods::resolve(args, &choices, &input)?;
    let kind = reference_kind(args, scene, &image)?;
    let Some(first) = methods.first() else { return usage("there is no method") };
    let development = first.scene.film.development;
    let given = given_reference(args, kind, first, scene)?;
    let outputs = Outputs::prepare(&folder(args), &input.files)?;

    let extent = Extent { series: &args.spp.0, seeds: args.seeds };
    let planned = extent.samples(&methods);
    let progress = ProgressDisplay::new(args.run.quiet, 0, 0);
    let threads = args.run.threads.unwrap_or(0).into();
    // The guard lives until everything is written, so that a signal does not discard the measurements.
    let guard = signals::guard();
    let mut runner = BenchRunner::new(&args.input.scene, threads, clock, guard.flag(), progress, planned);
    let interrupted = |measured: usize| {
        let folder = outputs.folder.clone();
        CliError::MeasurementInterrupted { measured, planned: args.spp.0.len(), folder }
    };
    let reference = match given {
        Some(reference) => reference,
        None => {
            let max_spp = args.spp.0[args.spp.0.len() - 1];
            match split_reference::render(&mut runner, &methods, max_spp, planned) {
                Err(CliError::RenderInterrupted) => {
                    runner.close();
                    return Err(interrupted(0));
                }
                reference => reference?,
            }
        }
    };
    let setting = Setting { args, scene, kind, reference: &reference, development };
    let experiment = runner::run(&mut runner, &mut methods, extent, &reference, |so_far| {
        Report::new(setting, so_far).write(&outputs)
    })?;
    runner.close();
    let measured = args.spp.0.len() - experiment.left_out.len();
    if measured == 0 {
        return Err(interrupted(0));
    }
    let report = Report::new(setting, &experiment);
    report.write(&outputs)?;
    console.println(report.text())?;
    console.println(format_args!("wrote {}", outputs.folder.display()))?;
    if experiment.bad_samples > 0 {
        let bad = experiment.bad_samples;
        console.warn(format_args!("{bad} samples were NaN, infinite or negative and count as black"));
    }
    if experiment.is_interrupted { Err(interrupted(measured)) } else { Ok(()) }
}

/// Kind of reference: the given one, or the best available.
fn reference_kind(args: &ConvergeArgs, scene: &Scene, image: &ImageArgs) -> Result<ReferenceKind, CliError> {
    let (view, input) = (&image.view, &args.input);
    let is_other_view = image.crop.is_some()
        || image.env.is_some()
        || input.lights != StudioLights::Auto
        || input.ground
        || input.at_time.is_some()
        || input.timing.shutter.is_some()
        || image.background.is_some()
        || scene.truth.as_ref().is_some_and(|truth| has_other_aspect(image.size, truth.size))
        || view.camera.is_some()
        || view.look_from.is_some()
        || view.look_at.is_some()
        || view.up.is_some()
        || view.fov.is_some();
    let refuse = |message: &str| usage(format!("--reference-kind {message}"));
    match args.reference_kind {
        Some(ReferenceKind::Truth) if scene.truth.is_none() => {
            refuse("truth: the scene declares no mean radiance; choose reference or split")
        }
        Some(ReferenceKind::Truth) if is_other_view => refuse(
            "truth: the declared mean holds for the view, aspect ratio, lights and time of the scene only; remove options such as --crop, \
             --size, --env and --at-time",
        ),
        Some(kind) => Ok(kind),
        None if args.reference.is_some() => Ok(ReferenceKind::Reference),
        None if scene.truth.is_some() && !is_other_view => Ok(ReferenceKind::Truth),
        None => Ok(ReferenceKind::Split),
    }
}

/// True if the size of `--size` has another aspect ratio than that of the file.
fn has_other_aspect(size: Option<[u32; 2]>, of_file: [u64; 2]) -> bool {
    let [width, height] = of_file.map(u128::from);
    size.is_some_and(|[w, h]| u128::from(w) * height != u128::from(h) * width)
}

/// Reference that needs no render.
fn given_reference(
    args: &ConvergeArgs,
    kind: ReferenceKind,
    first: &Method,
    scene: &Scene,
) -> Result<Option<Reference>, CliError> {
    match (kind, &scene.truth, &args.reference) {
        (ReferenceKind::Truth, Some(truth), _) => Ok(Some(Reference::KnownMean(truth.clone()))),
        (ReferenceKind::Reference, _, Some(path)) => {
            Reference::of_file(path, first.size(), &first.scene.film.development).map(Some)
        }
        _ => Ok(None),
    }
}

/// Output directory: `--output`, or the name of the scene with `-converge`.
fn folder(args: &ConvergeArgs) -> PathBuf {
    let default = || {
        let mut name = args.input.scene.file_stem().unwrap_or_default().to_owned();
        name.push("-converge");
        PathBuf::from(name)
    };
    args.output.clone().unwrap_or_else(default)
}
