//! `explain`: the plan in words.

use rt_render::RenderPlan;

use crate::args::ExplainArgs;
use crate::console::{Console, print};
use crate::error::Failure;
use crate::{input, overrides};

pub(super) fn run(args: &ExplainArgs) -> Result<(), Failure> {
    let console = Console { quiet: false };
    let mut scene = input::read(&args.input, args.picture.size, console)?.scene;
    let options = overrides::apply(&args.picture, &mut scene)?;
    let plan = RenderPlan::compile(&scene, &options).map_err(|error| Failure::plan(&args.input.scene, error))?;
    input::say_notes(&scene, console)?;
    print(plan.explain())
}
