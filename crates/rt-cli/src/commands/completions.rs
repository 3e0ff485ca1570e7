//! `completions`: what shells need to complete arguments.

use clap::CommandFactory;
use clap_complete::Shell;

use crate::args::Cli;
use crate::console::print;
use crate::error::Failure;
use crate::stdin::FORMATS;

pub(super) fn run(shell: Shell) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), env!("CARGO_PKG_NAME"), &mut script);
    let script = String::from_utf8_lossy(&script);
    if shell == Shell::Bash { print(mended_for_bash(&script)) } else { print(script) }
}

/// The script for bash with commands under the names that it looks for, and with files in place of a command as scenes to render.
///
/// The generator takes the hyphen in the program's name for the end of a command, in half of the places where it writes it.
fn mended_for_bash(script: &str) -> String {
    let name = env!("CARGO_PKG_NAME").replace('-', "__");
    let mangled = env!("CARGO_PKG_NAME").replace('-', "__subcmd__");
    let script = script.replace(&format!("{mangled}__subcmd__"), &format!("{name}__subcmd__"));
    let scenes: Vec<_> = FORMATS.iter().map(|ending| format!("{name},*.{ending}")).collect();
    let command = format!("            {name},render)\n");
    script.replace(&command, &format!("            {name},render|{})\n", scenes.join("|")))
}
