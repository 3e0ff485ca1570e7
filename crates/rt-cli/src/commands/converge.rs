//! `converge`: the error of methods against their run time.

mod axis;
mod choice;
mod files;
mod laboratory;
mod machine;
mod measure;
mod methods;
mod outputs;
mod page;
mod plot;
mod report;
mod split;
mod statistics;
mod summary;
mod table;
mod yardstick;

use std::path::PathBuf;

use self::laboratory::{Clock, Laboratory};
use self::measure::Extent;
use self::outputs::Outputs;
use self::report::{Report, Setting};
use crate::args::ConvergeArgs;
use crate::console::Console;
use crate::error::Failure;
use crate::input::{self, Input};
use crate::progress::ProgressDisplay;

pub(super) fn run(args: &ConvergeArgs) -> Result<(), Failure> {
    let clock = Clock::start(args.run.time);
    let console = Console { quiet: args.run.quiet };
    let picture = args.fixed.with(&[]).map_err(Failure::Usage)?;
    let Input { scene, files, options: loaded } = input::read(&args.input, Some(&picture), console)?;
    input::say_notes(&scene, console)?;
    let mut methods = methods::resolve(args, &loaded, &scene)?;
    let against = choice::choose(args, &scene, &picture)?;
    let Some(first) = methods.first() else { return Err(Failure::Usage("there is no method".to_owned())) };
    let development = first.scene.film.development;
    let given = choice::given(args, against, first, &scene, &development)?;
    let outputs = Outputs::prepare(&folder(args), &files)?;

    let extent = Extent { series: &args.spp.0, seeds: args.seeds };
    let planned = extent.samples(&methods);
    let progress = ProgressDisplay::new(args.run.quiet, 0, 0);
    let threads = args.run.threads.unwrap_or(0).into();
    let mut laboratory = Laboratory::new(&args.input.scene, threads, clock, progress, planned);
    let yardstick = match given {
        Some(yardstick) => yardstick,
        None => split::render(&mut laboratory, &methods, args.spp.0[args.spp.0.len() - 1], planned)?,
    };
    let setting = Setting { args, scene: &scene, against, yardstick: &yardstick, development };
    let study = measure::run(&mut laboratory, &mut methods, extent, &yardstick, |so_far| {
        Report::new(setting, so_far).write(&outputs)
    })?;
    laboratory.close();
    let report = Report::new(setting, &study);
    report.write(&outputs)?;
    console.say(report.text())?;
    console.say(format_args!("wrote {}", outputs.folder.display()))?;
    if study.bad_samples > 0 {
        console.warn(format_args!("{} samples were NaN, infinite or negative and count as black", study.bad_samples));
    }
    Ok(())
}

/// The scene's name with `-converge`, in the current folder, unless another is asked for.
fn folder(args: &ConvergeArgs) -> PathBuf {
    let default = || {
        let mut name = args.input.scene.file_stem().unwrap_or_default().to_owned();
        name.push("-converge");
        PathBuf::from(name)
    };
    args.output.clone().unwrap_or_else(default)
}
