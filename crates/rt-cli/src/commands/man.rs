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
    Ok(page)
}
