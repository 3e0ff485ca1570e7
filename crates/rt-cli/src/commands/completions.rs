//! `completions`: shell completions.

use clap::CommandFactory;
use clap_complete::Shell;

use crate::args::Cli;
use crate::console::print;
use crate::error::CliError;
use crate::stdin::FORMATS;

pub(super) fn run(shell: Shell) -> Result<(), CliError> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), env!("CARGO_PKG_NAME"), &mut script);
    let script = String::from_utf8_lossy(&script);
    if shell == Shell::Bash { print(fixed_for_bash(&script)) } else { print(script) }
}

/// Fixes the bash script: the generator mangles the hyphen of the program name inconsistently. Scene files instead of a
/// command complete like `render`.
fn fixed_for_bash(script: &str) -> String {
    let name = env!("CARGO_PKG_NAME").replace('-', "__");
    let mangled = env!("CARGO_PKG_NAME").replace('-', "__subcmd__");
    let script = script.replace(&format!("{mangled}__subcmd__"), &format!("{name}__subcmd__"));
    let scenes: Vec<_> = FORMATS.iter().map(|extension| format!("{name},*.{extension}")).collect();
    let command = format!("            {name},render)\n");
    script.replace(&command, &format!("            {name},render|{})\n", scenes.join("|")))
}
