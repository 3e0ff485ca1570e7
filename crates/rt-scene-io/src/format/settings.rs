//! Render settings in the file.

use serde::{Deserialize, Serialize};

use crate::{Accel, Integrator};

/// Method, samples and other settings of the render. The command line overrides them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Method by which light is computed. The default is `path` for scene files with an area light, an environment image, or a
    /// material other than `phong`, else `whitted`. If the field `lights` is absent, physically based materials of models and
    /// emissive objects select `path` as well.
    ///
    /// Default: `whitted` or `path`, as the scene needs. Example: `integrator: path`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub integrator: Option<Integrator>,
    /// Pattern of the samples in a pixel.
    pub sampler: Sampler,
    /// Samples per pixel, rounded up to passes of equal size that the sampler supports.
    ///
    /// Unit: samples.
    pub spp: u64,
    /// Independent passes, whose differences estimate the error.
    ///
    /// Unit: passes. Default: chosen by the integrator. Example: `passes: 4`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub passes: Option<u64>,
    /// Distribution of samples among pixels.
    ///
    /// Default: the same for all pixels. Example: `adaptive: object_space(min_spp: 4)`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adaptive: Option<Adaptive>,
    /// Bounces after the first hit: 0 for direct light only.
    ///
    /// Unit: bounces.
    #[serde(alias = "depth")]
    pub max_depth: u64,
    /// Under `whitted`, rays that contribute less than this to the pixel are not followed.
    ///
    /// Unit: fraction of the pixel.
    pub min_contribution: f64,
    /// Acceleration structure.
    pub accel: Accel,
    /// Seed of all random numbers.
    ///
    /// Unit: none.
    pub seed: u64,
    /// Selection of one of many area lights.
    pub light_sampling: LightSampling,
    /// Bounces before Russian roulette may end a path.
    ///
    /// Unit: bounces.
    #[serde(alias = "roulette_from")]
    pub rr_start_depth: u64,
    /// Bound on each contribution of indirect light to a sample; brighter ones are scaled down to it.
    ///
    /// It removes fireflies and some light: the image is biased. For `path`, `distributed` and `path_caustics`.
    /// Unit: radiance. Default: no bound. Example: `clamp: 10`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clamp: Option<f64>,
    /// Distance up to which surfaces occlude a point, for `ambient_occlusion`.
    ///
    /// Unit: units of the scene. Default: all distances. Example: `occlusion_distance: 2.5`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub occlusion_distance: Option<f64>,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            integrator: None,
            sampler: Sampler::Sobol,
            spp: 16,
            passes: None,
            adaptive: None,
            max_depth: 5,
            min_contribution: 0.0,
            accel: Accel::Auto,
            seed: 0,
            light_sampling: LightSampling::Tree,
            rr_start_depth: 3,
            clamp: None,
            occlusion_distance: None,
        }
    }
}

/// Distribution of samples among pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Adaptive {
    /// Few samples where no edge of an object or of a shadow can be in the pixel, and all of them elsewhere; for `whitted`.
    ObjectSpace {
        /// Samples of a pixel without edges.
        ///
        /// Unit: samples. Default: a quarter of `spp`. Example: `min_spp: 4`.
        #[serde(default, skip_serializing_if = "Option::is_none", alias = "least")]
        min_spp: Option<u64>,
    },
}

/// Selection of one of many area lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum LightSampling {
    /// Each as often as any other.
    Uniform,
    /// In proportion to power.
    Power,
    /// By a light tree, which bounds position and emission.
    Tree,
}

/// Sample pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Sampler {
    /// All samples in the middle of the pixel.
    #[serde(alias = "center")]
    Centre,
    /// A regular grid.
    Grid,
    /// Independent random points.
    Random,
    /// One random point in each cell of a grid.
    Jittered,
    /// One point in the middle quarter of each cell: less noise, but biased.
    HalfJittered,
    /// Jittered in cells, rows and columns.
    MultiJittered,
    /// Sobol' points, scrambled.
    Sobol,
    /// Halton points, scrambled, in any number.
    Halton,
    /// Sobol' points distributed among neighbouring pixels, for few samples.
    BlueNoise,
}
