//! Methods of an experiment: all combinations of the varied values.

use rt_camera::SamplerKind;
use rt_render::{PlanOptions, RenderPlan};
use rt_scene_io::Scene;
use serde::Serialize;

use crate::args::{ConvergeArgs, ImageArgs, Variation};
use crate::error::{CliError, usage};
use crate::input::Input;
use crate::settings;

/// Limit of the readable plot.
const MAX_METHODS: usize = 64;

#[derive(Debug)]
pub(super) struct Method {
    pub(super) name: MethodName,
    /// Scene with all options applied.
    pub(super) scene: Scene,
    pub(super) options: PlanOptions,
}

#[derive(Clone, Debug, Serialize)]
pub(super) struct MethodName {
    pub(super) label: String,
    /// Varied options and values, in the order of the command line.
    pub(super) choices: Vec<(String, String)>,
    pub(super) integrator: &'static str,
    pub(super) sampler: &'static str,
    pub(super) accel: &'static str,
    pub(super) depth: u32,
}

/// Values of a method, and the options of its image.
pub(super) struct Choices<'a> {
    values: Vec<(&'a str, &'a str)>,
    image: ImageArgs,
}

/// Parses the options of all methods.
pub(super) fn parse(args: &ConvergeArgs) -> Result<Vec<Choices<'_>>, CliError> {
    if let Some(Variation { key, .. }) = args.vary.iter().find(|vary| args.fixed.contains(&vary.key)) {
        return usage(format!("--vary {key} conflicts with --{key}; remove one of them"));
    }
    let keys: Vec<&str> = args.vary.iter().map(|vary| vary.key.as_str()).collect();
    if let Some(twice) = keys.iter().enumerate().find(|(index, key)| keys[..*index].contains(key)) {
        return usage(format!("--vary {} is given twice; list all values at once, such as {0}=A,B,C", twice.1));
    }
    let count = args.vary.iter().try_fold(1usize, |count, vary| count.checked_mul(vary.values.len()));
    if count.is_none_or(|count| count > MAX_METHODS) {
        return usage(format!("--vary has more than {MAX_METHODS} combinations; vary fewer values"));
    }
    let parsed = combinations(&args.vary).into_iter().map(|values| match args.fixed.with(&values) {
        Ok(image) => Ok(Choices { values, image }),
        Err(message) => usage(format!("--vary: {message}")),
    });
    parsed.collect()
}

/// Resolves all methods, and checks that each can be rendered.
pub(super) fn resolve(args: &ConvergeArgs, choices: &[Choices<'_>], input: &Input) -> Result<Vec<Method>, CliError> {
    choices.iter().map(|choices| Method::new(args, input, choices)).collect()
}

/// Cartesian product; the last key varies fastest.
fn combinations(vary: &[Variation]) -> Vec<Vec<(&str, &str)>> {
    vary.iter().fold(vec![Vec::new()], |combinations, Variation { key, values }| {
        let extended = combinations.iter().flat_map(|combination| {
            values.iter().map(move |value| [combination.as_slice(), &[(key.as_str(), value.as_str())]].concat())
        });
        extended.collect()
    })
}

impl Method {
    fn new(args: &ConvergeArgs, input: &Input, Choices { values, image }: &Choices<'_>) -> Result<Self, CliError> {
        let Input { scene, environment, options: loaded, .. } = input;
        let (development, memory) = (Some(&args.development), loaded.memory.limit());
        let (mut scene, options) = settings::resolve(scene.clone(), image, development, environment.as_ref(), memory)?;
        let settings = &mut scene.settings;
        settings.spp = args.spp.0[0];
        // The spread comes from the seeds; passes would weaken the sample pattern.
        settings.passes.get_or_insert(1);
        let [integrator, sampler] = [settings.integrator.name(), settings.pattern.name()];
        let choices: Vec<_> = values.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
        let label = if choices.is_empty() { format!("{integrator}, {sampler}") } else { label(&choices) };
        let (accel, depth) = (settings.accel.name(), settings.depth);
        let name = MethodName { label, choices, integrator, sampler, accel, depth };
        RenderPlan::compile(&scene, &options).map_err(|error| CliError::plan(&args.input.scene, error))?;
        Ok(Self { name, scene, options })
    }

    pub(super) fn with_sampler(&self, pattern: SamplerKind) -> Self {
        let mut scene = self.scene.clone();
        scene.settings.pattern = pattern;
        let name = MethodName { sampler: pattern.name(), ..self.name.clone() };
        Self { name, scene, options: self.options }
    }

    /// Width and height in pixels.
    pub(super) fn size(&self) -> [u32; 2] {
        let film = &self.scene.film;
        self.options.crop.map_or([film.width, film.height], |crop| [crop.width, crop.height])
    }

    /// Samples of an image.
    pub(super) fn samples(&self, spp: u32) -> u64 {
        let [width, height] = self.size();
        u64::from(width) * u64::from(height) * u64::from(self.samples_per_pixel(spp))
    }

    /// `spp`, rounded up to what the sampler supports in each pass.
    pub(super) fn samples_per_pixel(&self, spp: u32) -> u32 {
        let settings = &self.scene.settings;
        let passes = settings.passes.unwrap_or(1).max(1);
        settings.pattern.round_up(spp.div_ceil(passes)).saturating_mul(passes)
    }
}

/// Varied values; numbers with their keys.
fn label(choices: &[(String, String)]) -> String {
    let part = |(key, value): &(String, String)| match value.parse::<f64>() {
        Ok(_) => format!("{key} {value}"),
        Err(_) => value.clone(),
    };
    choices.iter().map(part).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vary(key: &str, values: &[&str]) -> Variation {
        Variation { key: key.to_owned(), values: values.iter().map(|&value| value.to_owned()).collect() }
    }

    #[test]
    fn all_values_are_combined_with_all_others() {
        let vary = [vary("a", &["1", "2"]), vary("b", &["x", "y", "z"])];
        let combined = combinations(&vary);
        let text: Vec<String> = combined.iter().map(|pairs| pairs.iter().map(|pair| pair.1).collect()).collect();
        assert_eq!(text, ["1x", "1y", "1z", "2x", "2y", "2z"]);
        assert_eq!(combinations(&[]), [[]]);
    }

    #[test]
    fn numbers_are_named_by_their_keys() {
        let choice = |key: &str, value: &str| (key.to_owned(), value.to_owned());
        assert_eq!(label(&[choice("sampler", "sobol"), choice("depth", "2")]), "sobol, depth 2");
    }
}
