//! Options of `render` as text, to be combined with the values of `converge --vary`.

use std::ffi::OsString;

use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Args, Command, Error, FromArgMatches, Parser};

use super::image::ImageArgs;
use super::values::unknown_word;

/// Options that `converge` sets itself.
const MANAGED: [&str; 3] = ["spp", "time", "target-error"];

/// Options that change the converged image, and so cannot vary.
const FIXED: [&str; 10] = ["size", "crop", "camera", "look-from", "look-at", "up", "fov", "background", "env", "seed"];

/// Options of [`ImageArgs`] as typed, without the managed ones.
#[derive(Clone, Debug, Default)]
pub(crate) struct RawOptions {
    words: Vec<OsString>,
}

#[derive(Debug, Parser)]
#[command(no_binary_name = true)]
struct ImageArgsParser {
    #[command(flatten)]
    image: ImageArgs,
}

impl RawOptions {
    /// True if the option of this long name is typed.
    pub(crate) fn contains(&self, name: &str) -> bool {
        let is_name = |word: &OsString| {
            let word = word.to_string_lossy();
            word.strip_prefix("--").is_some_and(|word| word.split('=').next() == Some(name))
        };
        self.words.iter().any(is_name)
    }

    /// Parses the typed options together with the added ones.
    ///
    /// # Errors
    /// Message of the parser: an invalid value, or an option that is given twice.
    pub(crate) fn with(&self, added: &[(&str, &str)]) -> Result<ImageArgs, String> {
        let added = added.iter().map(|(name, value)| OsString::from(format!("--{name}={value}")));
        let parsed = ImageArgsParser::try_parse_from(self.words.iter().cloned().chain(added));
        parsed.map(|parsed| parsed.image).map_err(|error| in_one_line(&error))
    }
}

impl Args for RawOptions {
    fn augment_args(command: Command) -> Command {
        command.args(options())
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for RawOptions {
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

/// Long name of an option that may vary, given by its name or an alias.
pub(super) fn variable_option(name: &str) -> Result<String, String> {
    let options: Vec<Arg> = options()
        .into_iter()
        .filter(|option| option.get_action().takes_values() && !FIXED.contains(&option.get_long().unwrap_or_default()))
        .collect();
    let is_called = |option: &&Arg| {
        option.get_long() == Some(name) || option.get_all_aliases().into_iter().flatten().any(|alias| alias == name)
    };
    let long = |option: &Arg| option.get_long().unwrap_or_default().to_owned();
    match options.iter().find(is_called) {
        Some(option) => Ok(long(option)),
        None => Err(unknown_word("option to vary", name, options.iter().map(long).collect())),
    }
}

/// Options of [`ImageArgs`] without the managed ones.
fn options() -> Vec<Arg> {
    let all = ImageArgs::augment_args(Command::new("render"));
    let is_unmanaged = |option: &&Arg| option.get_long().is_some_and(|name| !MANAGED.contains(&name));
    all.get_arguments().filter(is_unmanaged).cloned().collect()
}

/// Message of the parser without its references to help pages.
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
        options: RawOptions,
    }

    fn typed(words: &[&str]) -> RawOptions {
        Program::try_parse_from(["program"].iter().chain(words)).expect("valid").options
    }

    #[test]
    fn typed_options_are_kept_and_extended() {
        let options = typed(&["--size", "8x4", "--depth=3", "--full-plan"]);
        let image = options.with(&[("sampler", "halton")]).expect("valid");
        assert_eq!((image.size, image.max_depth, image.full_plan), (Some([8, 4]), Some(3), true));
        assert_eq!((image.sampler, image.spp), (Some(SamplerKind::Halton), None));
        assert_eq!(typed(&[]).with(&[]).expect("valid").max_depth, None);
    }

    #[test]
    fn bad_values_are_reported_with_the_nearest_valid_one() {
        let error = typed(&[]).with(&[("sampler", "jitered")]).expect_err("no sampler");
        assert!(error.starts_with("invalid value 'jitered' for '--sampler") && error.contains("'jittered'"), "{error}");
        assert!(!error.contains('\n'), "{error}");
        let options = typed(&["--sampler", "sobol"]);
        assert!(options.contains("sampler") && !options.contains("sam"));
        let error = options.with(&[("sampler", "halton")]).expect_err("given twice");
        assert!(error.contains("cannot be used multiple times"), "{error}");
    }

    #[test]
    fn only_options_that_make_a_method_vary() {
        for name in ["sampler", "integrator", "accel", "build-quality", "simd", "precision", "max-depth"] {
            assert_eq!(variable_option(name).as_deref(), Ok(name));
        }
        assert_eq!(variable_option("depth").as_deref(), Ok("max-depth"));
        for name in MANAGED.iter().chain(&FIXED) {
            assert!(variable_option(name).is_err(), "{name}");
        }
        Program::command().debug_assert();
        assert!(Program::try_parse_from(["program", "--spp", "4"]).is_err());
    }
}
