//! `explain`: the plan in words.

use rt_render::RenderPlan;

use crate::args::ExplainArgs;
use crate::console::{Console, show};
use crate::error::Failure;
use crate::input::{self, Input};
use crate::overrides;

pub(super) fn run(args: &ExplainArgs) -> Result<(), Failure> {
    let console = Console { quiet: false };
    let Input { mut scene, options: loaded, .. } = input::read(&args.input, Some(&args.picture), console)?;
    if args.strict {
        input::refuse_warnings(&args.input.scene, &scene.warnings)?;
    }
    let options = overrides::apply(&args.picture, &loaded, &mut scene)?;
    let plan = RenderPlan::compile(&scene, &options).map_err(|error| Failure::plan(&args.input.scene, error))?;
    input::say_notes(&scene, console)?;
    show(plan.explain())
}
