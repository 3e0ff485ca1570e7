//! How to render, in the file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Accel, Integrator};

/// Method, samples and other settings of the render. The command line overrides them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Method by which light is computed. By default `whitted`, and `path` for scenes that have lights with extent, an image around
    /// them, or physical materials. Without `lights`, models of physical materials and emissive objects count as well.
    ///
    /// Default: `whitted` or `path`, as the scene needs. Example: `integrator: path`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub integrator: Option<Integrator>,
    /// Pattern of the samples in a pixel.
    pub sampler: Sampler,
    /// Samples per pixel; some samplers round it up.
    ///
    /// Unit: samples.
    pub spp: u64,
    /// Independent passes that the samples are split into, by which the error is estimated.
    ///
    /// Unit: passes. Default: chosen by the integrator. Example: `passes: 4`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub passes: Option<u64>,
    /// Distribution of samples among pixels.
    ///
    /// Default: the same for all pixels. Example: `adaptive: object_space(least: 4)`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adaptive: Option<Adaptive>,
    /// Bounces after the first hit: 0 for direct light alone.
    ///
    /// Unit: bounces.
    pub depth: u64,
    /// Rays that contribute less than this to the pixel are not followed.
    ///
    /// Unit: share of the pixel.
    pub min_contribution: f64,
    /// Acceleration structure.
    pub accel: Accel,
    /// Seed of all random numbers.
    ///
    /// Unit: none.
    pub seed: u64,
    /// Choice of one of many lights with extent.
    pub light_sampling: LightSampling,
    /// Bounces before Russian roulette may end a path.
    ///
    /// Unit: bounces.
    pub roulette_from: u64,
    /// Bound on each contribution of indirect light to a sample; brighter ones are scaled down to it.
    ///
    /// It takes away fireflies and some light: the image is biased. For `path`, `distributed` and `caustics`.
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
            depth: 5,
            min_contribution: 0.0,
            accel: Accel::Auto,
            seed: 0,
            light_sampling: LightSampling::Tree,
            roulette_from: 3,
            clamp: None,
            occlusion_distance: None,
        }
    }
}

/// Distribution of samples among pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Adaptive {
    /// Few samples where no edge of an object or of a shadow can be in the pixel, and all of them elsewhere; for `whitted`.
    ObjectSpace {
        /// Samples of a pixel without edges.
        ///
        /// Unit: samples. Default: a quarter of `spp`. Example: `least: 4`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        least: Option<u64>,
    },
}

/// Choice of one of many lights with extent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LightSampling {
    /// Each as often as any other.
    Uniform,
    /// In proportion to power.
    Power,
    /// By a tree that knows how near lights are and where they shine.
    Tree,
}

/// Sample pattern.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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
    /// Sobol' points shared out among neighbouring pixels, for few samples.
    BlueNoise,
}
