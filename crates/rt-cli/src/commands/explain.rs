//! `explain`: prints the render plan.

use rt_render::RenderPlan;

use crate::args::ExplainArgs;
use crate::console::{Console, show};
use crate::error::CliError;
use crate::input::{self, Input};
use crate::settings;

pub(super) fn run(args: &ExplainArgs) -> Result<(), CliError> {
    let console = Console { quiet: false };
    let Input { scene, environment, options: loaded, .. } = input::read(&args.input, Some(&args.image), console)?;
    if args.strict {
        input::refuse_warnings(&args.input.scene, &scene.warnings)?;
    }
    let (scene, options) = settings::resolve(scene, &args.image, None, environment.as_ref(), loaded.memory.limit())?;
    let plan = RenderPlan::compile(&scene, &options).map_err(|error| CliError::plan(&args.input.scene, error))?;
    input::print_notes(&scene, console)?;
    show(plan.explain())
}
