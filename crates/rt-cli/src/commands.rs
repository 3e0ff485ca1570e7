//! The commands, one a file.

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
use crate::error::Failure;

/// Does what the user asks for.
pub(crate) fn run(cli: Cli) -> Result<(), Failure> {
    match cli.command {
        None if cli.limits => limits::run(),
        None => showcase::run(),
        Some(Command::Render(args)) => render::run(&args),
        #[cfg(feature = "view")]
        Some(Command::View(args)) => view::run(&args),
        Some(Command::Explain(args)) => explain::run(&args),
        Some(Command::Check(args)) => check::run(&args),
        Some(Command::Convert(args)) => convert::run(&args),
        Some(Command::Develop(args)) => develop::run(&args),
        Some(Command::Merge(args)) => merge::run(&args),
        Some(Command::Compare(args)) => compare::run(&args),
        Some(Command::Converge(args)) => converge::run(&args),
        Some(Command::Schema { markdown }) => schema::run(markdown),
        Some(Command::Completions { shell }) => completions::run(shell),
        Some(Command::Man { output }) => man::run(output.as_deref()),
    }
}
