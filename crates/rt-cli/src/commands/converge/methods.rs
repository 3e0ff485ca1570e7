//! The methods that are compared: all combinations of the values that vary.

use rt_camera::SamplerKind;
use rt_render::{PlanOptions, RenderPlan};
use rt_scene_io::{LoadOptions, Scene};
use serde::Serialize;

use crate::args::{ConvergeArgs, Variation};
use crate::error::Failure;
use crate::overrides;

/// More than this no plot tells apart.
const MOST_METHODS: usize = 64;

/// A way to render the scene.
#[derive(Debug)]
pub(super) struct Method {
    pub(super) name: MethodName,
    /// With all options laid over it.
    pub(super) scene: Scene,
    pub(super) options: PlanOptions,
}

/// What tells a method from the others, and what it is.
#[derive(Clone, Debug, Serialize)]
pub(super) struct MethodName {
    /// Unique.
    pub(super) label: String,
    /// The values that vary, in the order of the command line.
    pub(super) choices: Vec<(String, String)>,
    pub(super) integrator: &'static str,
    pub(super) sampler: &'static str,
    pub(super) accel: &'static str,
    pub(super) depth: u32,
}

/// All methods that the arguments ask for, each found fit to be rendered.
pub(super) fn resolve(args: &ConvergeArgs, loaded: &LoadOptions, scene: &Scene) -> Result<Vec<Method>, Failure> {
    let keys: Vec<&str> = args.vary.iter().map(|vary| vary.key.as_str()).collect();
    if let Some(twice) = keys.iter().enumerate().find(|(index, key)| keys[..*index].contains(key)) {
        let message = format!("--vary {} is there twice; list all values in one, as {0}=A,B,C", twice.1);
        return Err(Failure::Usage(message));
    }
    let count = args.vary.iter().try_fold(1usize, |count, vary| count.checked_mul(vary.values.len()));
    if count.is_none_or(|count| count > MOST_METHODS) {
        return Err(Failure::Usage(format!("--vary asks for more than {MOST_METHODS} combinations")));
    }
    combinations(&args.vary).iter().map(|choices| Method::new(args, loaded, scene, choices)).collect()
}

/// The cartesian product, the last key running fastest.
fn combinations(vary: &[Variation]) -> Vec<Vec<(&str, &str)>> {
    vary.iter().fold(vec![Vec::new()], |combinations, Variation { key, values }| {
        let extended = combinations.iter().flat_map(|combination| {
            values.iter().map(move |value| [combination.as_slice(), &[(key.as_str(), value.as_str())]].concat())
        });
        extended.collect()
    })
}

impl Method {
    fn new(
        args: &ConvergeArgs,
        loaded: &LoadOptions,
        scene: &Scene,
        choices: &[(&str, &str)],
    ) -> Result<Self, Failure> {
        let picture = args.fixed.with(choices).map_err(|message| Failure::Usage(format!("--vary: {message}")))?;
        let mut scene = scene.clone();
        let options = overrides::apply(&picture, loaded, &mut scene)?;
        overrides::apply_development(&args.development, &mut scene.film.development);
        let settings = &mut scene.settings;
        settings.spp = args.spp.0[0];
        // The seeds tell the spread, so that there is no need of passes that cost some of what the pattern gains.
        settings.passes.get_or_insert(1);
        let [integrator, sampler] = [settings.integrator.name(), settings.pattern.name()];
        let choices: Vec<_> = choices.iter().map(|(key, value)| ((*key).to_owned(), (*value).to_owned())).collect();
        let label = if choices.is_empty() { format!("{integrator}, {sampler}") } else { label(&choices) };
        let (accel, depth) = (settings.accel.name(), settings.depth);
        let name = MethodName { label, choices, integrator, sampler, accel, depth };
        RenderPlan::compile(&scene, &options).map_err(|error| Failure::plan(&args.input.scene, error))?;
        Ok(Self { name, scene, options })
    }

    /// The same method with another sampler.
    pub(super) fn with_sampler(&self, pattern: SamplerKind) -> Self {
        let mut scene = self.scene.clone();
        scene.settings.pattern = pattern;
        let name = MethodName { sampler: pattern.name(), ..self.name.clone() };
        Self { name, scene, options: self.options }
    }

    /// Width and height of the picture in pixels.
    pub(super) fn size(&self) -> [u32; 2] {
        let film = &self.scene.film;
        self.options.crop.map_or([film.width, film.height], |crop| [crop.width, crop.height])
    }

    /// Samples of a picture with `spp` samples per pixel, about: the plan may round them up further.
    pub(super) fn samples(&self, spp: u32) -> u64 {
        let [width, height] = self.size();
        u64::from(width) * u64::from(height) * u64::from(self.scene.settings.pattern.round_up(spp))
    }
}

/// The values that vary; with their keys where they are numbers, which say nothing by themselves.
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
