//! Tasks that measure run as a release build.

use crate::{
    error::TaskError,
    workspace::{cargo, output_of},
};

/// Runs this task again as a release build: users get neither overflow checks nor single crates that are optimised alone.
pub(crate) fn run_release_build() -> Result<(), TaskError> {
    let mut command = cargo();
    command.args(["run", "--quiet", "--release", "--package", "xtask", "--"]).args(std::env::args_os().skip(1));
    print!("{}", output_of(&mut command)?);
    Ok(())
}
