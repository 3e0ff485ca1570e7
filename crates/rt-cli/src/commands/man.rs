//! `man`: manual pages from the texts of `--help`.

use std::io;
use std::path::Path;

use clap::{Command, CommandFactory};
use clap_mangen::Man;

use crate::args::Cli;
use crate::console::print;
use crate::error::CliError;
use crate::output_file::OutputFile;

pub(super) fn run(folder: Option<&Path>) -> Result<(), CliError> {
    let mut program = Cli::command();
    // Set the full name of each command.
    program.build();
    let name = program.get_name().to_owned();
    let subcommands = program.get_subcommands().map(|command| (format!("{name}-{}", command.get_name()), command));
    for (name, command) in [(name.clone(), &program)].into_iter().chain(subcommands) {
        let page = page(&name, command).map_err(CliError::Stdout)?;
        match folder {
            Some(folder) => {
                OutputFile::prepare(&folder.join(format!("{name}.1")), &[])?.write(|file| file.write_all(&page))?
            }
            None => print(String::from_utf8_lossy(&page))?,
        }
    }
    Ok(())
}

fn page(name: &str, command: &Command) -> io::Result<Vec<u8>> {
    let mut page = Vec::new();
    Man::new(command.clone().display_name(name.to_owned())).render(&mut page)?;
    Ok(if command.has_subcommands() { with_usage(command, &page) } else { page })
}

/// The page of a program whose usage is a text of its own, which the generator passes over.
fn with_usage(command: &Command, page: &[u8]) -> Vec<u8> {
    let usage = command.clone().render_usage().to_string();
    let forms = usage.trim_start_matches("Usage:").lines().map(|line| line.trim().replace('-', "\\-"));
    let synopsis = forms.collect::<Vec<_>>().join("\n.br\n");
    let text = String::from_utf8_lossy(page);
    let mut is_synopsis = false;
    let lines = text.lines().map(|line| {
        let shown = if is_synopsis { &synopsis } else { line };
        is_synopsis = line == ".SH SYNOPSIS";
        format!("{shown}\n")
    });
    lines.collect::<String>().into_bytes()
}
