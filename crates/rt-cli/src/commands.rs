//! Commands, one per file.

mod check;
mod compare;
mod completions;
mod converge;
mod convert;
mod develop;
mod explain;
mod limits;
mod man;
mod merge;
mod render;
mod schema;
mod showcase;
#[cfg(feature = "view")]
mod view;

use crate::args::{Cli, Command};
use crate::error::CliError;
use crate::signals;

pub(crate) fn run(cli: Cli) -> Result<(), CliError> {
    match cli.command {
        None if cli.limits => limits::run(),
        None => showcase::run(),
        Some(Command::Render(mut args)) => {
            signals::end_render_on_signals();
            args.input.take_stdin()?;
            render::run(&args)
        }
        #[cfg(feature = "view")]
        Some(Command::View(mut args)) => {
            args.input.take_stdin()?;
            view::run(&args)
        }
        Some(Command::Explain(mut args)) => {
            args.input.take_stdin()?;
            explain::run(&args)
        }
        Some(Command::Check(mut args)) => {
            args.input.take_stdin()?;
            check::run(&args)
        }
        Some(Command::Convert(mut args)) => {
            args.input.take_stdin()?;
            convert::run(&args)
        }
        Some(Command::Develop(args)) => develop::run(&args),
        Some(Command::Merge(args)) => merge::run(&args),
        Some(Command::Compare(args)) => compare::run(&args),
        Some(Command::Converge(mut args)) => {
            args.input.take_stdin()?;
            converge::run(&args)
        }
        Some(Command::Schema { markdown }) => schema::run(markdown),
        Some(Command::Completions { shell }) => completions::run(shell),
        Some(Command::Man { output }) => man::run(output.as_deref()),
    }
}
