//! Options of `render` as text, so that a command can lay others over them.

use std::ffi::OsString;

use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Args, Command, Error, FromArgMatches, Parser};

use super::PictureArgs;

/// How much to render is not for the user of such a command to say.
const DECIDED: [&str; 3] = ["spp", "time", "target-error"];

/// What is seen, and with it the picture that is approached, stays the same.
const SEEN: [&str; 9] = ["size", "crop", "camera", "look-from", "look-at", "up", "fov", "background", "seed"];

/// The options of `render` that were typed: whatever [`PictureArgs`] has, but for how much to render.
#[derive(Clone, Debug, Default)]
pub(crate) struct TypedOptions {
    words: Vec<OsString>,
}

/// [`PictureArgs`] as a command of its own.
#[derive(Debug, Parser)]
#[command(no_binary_name = true)]
struct Picture {
    #[command(flatten)]
    picture: PictureArgs,
}

impl TypedOptions {
    /// What was typed and these options and values together, read as `render` reads them.
    ///
    /// # Errors
    /// What the parser says: of a value that is none, or of an option that was typed already.
    pub(crate) fn with(&self, added: &[(&str, &str)]) -> Result<PictureArgs, String> {
        let added = added.iter().map(|(name, value)| OsString::from(format!("--{name}={value}")));
        let parsed = Picture::try_parse_from(self.words.iter().cloned().chain(added));
        parsed.map(|parsed| parsed.picture).map_err(|error| in_one_line(&error))
    }
}

impl Args for TypedOptions {
    fn augment_args(command: Command) -> Command {
        command.args(options())
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for TypedOptions {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let mut words = Vec::new();
        for option in options() {
            let id = option.get_id().as_str();
            if matches.value_source(id) != Some(ValueSource::CommandLine) {
                continue;
            }
            let name = OsString::from(format!("--{}", option.get_long().unwrap_or(id)));
            if !option.get_action().takes_values() {
                words.push(name);
                continue;
            }
            for value in matches.get_raw(id).into_iter().flatten() {
                let mut word = name.clone();
                word.push("=");
                word.push(value);
                words.push(word);
            }
        }
        Ok(Self { words })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Names of the options whose values make another method for the same picture.
pub(super) fn variable_names() -> Vec<String> {
    let names = options().into_iter().filter(|option| option.get_action().takes_values());
    let names = names.filter_map(|option| option.get_long().map(str::to_owned));
    names.filter(|name| !SEEN.contains(&name.as_str())).collect()
}

/// The options of `render`, without those that say how much.
fn options() -> Vec<Arg> {
    let all = PictureArgs::augment_args(Command::new("render"));
    let is_left = |option: &&Arg| option.get_long().is_some_and(|name| !DECIDED.contains(&name));
    all.get_arguments().filter(is_left).cloned().collect()
}

/// The message of the parser, without its hints at a help page.
fn in_one_line(error: &Error) -> String {
    let text = error.to_string();
    let message = text.split("\n\n").filter(|part| !part.starts_with("For more") && !part.starts_with("Usage"));
    let lines = message.flat_map(str::lines).map(str::trim).filter(|line| !line.is_empty());
    let line = lines.collect::<Vec<_>>().join(" ");
    line.strip_prefix("error: ").unwrap_or(&line).to_owned()
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, Parser};
    use rt_camera::SamplerKind;

    use super::*;

    #[derive(Debug, Parser)]
    struct Program {
        #[command(flatten)]
        options: TypedOptions,
    }

    fn typed(words: &[&str]) -> TypedOptions {
        Program::try_parse_from(["program"].iter().chain(words)).expect("valid").options
    }

    #[test]
    fn what_was_typed_is_kept_and_added_to() {
        let options = typed(&["--size", "8x4", "--depth=3", "--full-plan"]);
        let picture = options.with(&[("sampler", "halton")]).expect("valid");
        assert_eq!((picture.size, picture.depth, picture.full_plan), (Some([8, 4]), Some(3), true));
        assert_eq!((picture.sampler, picture.spp), (Some(SamplerKind::Halton), None));
        assert_eq!(typed(&[]).with(&[]).expect("valid").depth, None);
    }

    #[test]
    fn bad_values_are_told_with_the_nearest_right_one() {
        let error = typed(&[]).with(&[("sampler", "jitered")]).expect_err("no sampler");
        assert!(error.starts_with("invalid value 'jitered' for '--sampler") && error.contains("'jittered'"), "{error}");
        assert!(!error.contains('\n'), "{error}");
        let error = typed(&["--sampler", "sobol"]).with(&[("sampler", "halton")]).expect_err("given twice");
        assert!(error.contains("cannot be used multiple times"), "{error}");
    }

    #[test]
    fn only_options_that_make_a_method_vary() {
        let names = variable_names();
        for name in ["sampler", "integrator", "accel", "quality", "simd", "depth"] {
            assert!(names.iter().any(|known| known == name), "{name} in {names:?}");
        }
        for name in DECIDED.iter().chain(&SEEN) {
            assert!(!names.iter().any(|known| known == name), "{name}");
        }
        Program::command().debug_assert();
        assert!(Program::try_parse_from(["program", "--spp", "4"]).is_err());
    }
}
