//! Default command: `rt-cli scene.ron` means `rt-cli render scene.ron`, and `rt-cli help X` means `rt-cli X --help`.

use std::ffi::{OsStr, OsString};
use std::path::Path;

use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory, Error, Parser};

use super::Cli;
use crate::stdin::is_dash;

/// Options of the program itself.
const OWN: [&str; 5] = ["-h", "--help", "-V", "--version", "--limits"];

/// Advice if options are given without a scene and a command.
const NO_SCENE: &str =
    "add a scene, such as `rt-cli scene.ron [OPTIONS]`; only `rt-cli` without options renders a built-in scene";

/// Parses a command line. The program's name is its first word.
pub(crate) fn parse(arguments: impl Iterator<Item = OsString>) -> Result<Cli, Error> {
    let arguments: Vec<OsString> = arguments.collect();
    let has_leading_option = arguments.get(1).is_some_and(|first| is_option(first));
    Cli::try_parse_from(with_default_command(arguments)).map_err(|mut error| {
        if has_leading_option && lacks_scene(&error) {
            error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![StyledStr::from(NO_SCENE)]));
        }
        error
    })
}

/// True if the scene is missing, and not an option that another one requires.
fn lacks_scene(error: &Error) -> bool {
    let is_scene = |argument: &String| argument.contains("SCENE");
    error.kind() == ErrorKind::MissingRequiredArgument
        && matches!(error.get(ContextKind::InvalidArg), Some(ContextValue::Strings(missing)) if missing.iter().any(is_scene))
}

/// Inserts `render` if the first argument is a file or an option instead of a command. The program's name precedes it.
///
/// Words that may be mistyped commands are left to the parser, which suggests the nearest one.
fn with_default_command(mut arguments: Vec<OsString>) -> Vec<OsString> {
    let [_, first, rest @ ..] = arguments.as_slice() else { return arguments };
    if first == "help" {
        arguments.remove(1);
        arguments.push("--help".into());
        return arguments;
    }
    let renders = if is_option(first) {
        // Options of `render` may come before the scene.
        let is_own = OWN.iter().any(|own| first == own);
        let command = Cli::command();
        let is_command = |word: &OsString| command.get_subcommands().any(|command| word == command.get_name());
        !is_own && !rest.iter().any(is_command)
    } else {
        is_file(first)
    };
    if renders {
        arguments.insert(1, OsString::from("render"));
    }
    arguments
}

fn is_option(word: &OsStr) -> bool {
    word.as_encoded_bytes().starts_with(b"-") && !is_dash(Path::new(word))
}

/// True for `-`, for paths with an extension or several components, and for existing files.
fn is_file(word: &OsStr) -> bool {
    let path = Path::new(word);
    is_dash(path) || path.extension().is_some() || path.components().nth(1).is_some() || path.is_file()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_in_place_of_a_command_is_rendered() {
        let line = |line: &str| {
            let words = with_default_command(line.split(' ').map(OsString::from).collect());
            words.join(OsStr::new(" ")).into_string().expect("text")
        };
        for rendered in
            ["scene.ron", "a.GLB --spp 4", "ok.rno", "a/b", "-", "--spp 4 scene.ron", "-q -o x.png a.json", "--spp 4"]
        {
            assert_eq!(line(&format!("rt-cli {rendered}")), format!("rt-cli render {rendered}"));
        }
        for left in [
            "render scene.ron",
            "rendr scene.ron",
            "rendr",
            "--help",
            "-V",
            "--limits",
            "--version a.ron",
            "-x render a.ron",
        ] {
            assert_eq!(line(&format!("rt-cli {left}")), format!("rt-cli {left}"));
        }
        assert_eq!(line("rt-cli"), "rt-cli");
        assert_eq!(line("rt-cli help render"), "rt-cli render --help");
        assert_eq!(line("rt-cli help"), "rt-cli --help");
    }

    /// The message named the missing SCENE only, although `rt-cli` alone needs none.
    #[test]
    fn options_without_a_scene_get_advice() {
        let message = |line: &str| parse(line.split(' ').map(OsString::from)).expect_err(line).to_string();
        for line in ["rt-cli --size 64x40", "rt-cli -q --spp 4"] {
            assert!(message(line).contains(NO_SCENE), "{}", message(line));
        }
        for line in [
            "rt-cli render",
            "rt-cli --size 64",
            "rt-cli view --spp 4",
            "rt-cli --animation run scene.ron",
            "rt-cli --target-error-pixels 95 scene.ron",
        ] {
            assert!(!message(line).contains(NO_SCENE), "{}", message(line));
        }
    }
}
