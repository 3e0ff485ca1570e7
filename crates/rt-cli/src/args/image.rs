//! Options of the image. Each overrides the scene file.

use std::path::PathBuf;

use clap::{Arg, Args, ValueEnum, ValueHint};
use rt_camera::SamplerKind;
use rt_image::ToneCurve;
use rt_math::DVec3;
use rt_render::{Crop, Precision, Quality, SimdLevel};
use rt_scene_io::{Accel, Integrator, LightSampling};

use super::values::{self, BackgroundChoice, named};

/// Help of `--spp` for commands with stop rules.
pub(super) const SPP_HELP_WITH_STOP_RULES: &str = "\
Set the samples per pixel [default: as in the scene]

With --time or --target-error, it is the maximum: by default 4096 with --target-error, and 1048576 with --time alone. Without them, the \
number is rounded up to passes of equal size that the sampler supports.";

#[derive(Clone, Debug, Args)]
pub(crate) struct ImageArgs {
    /// Set width and height in pixels [default: as in the scene]
    #[arg(long, value_name = "WxH", value_parser = values::size, allow_hyphen_values = true, help_heading = "Camera and scene")]
    pub(crate) size: Option<[u32; 2]>,

    /// Set the samples per pixel [default: as in the scene]
    ///
    /// The number is rounded up to passes of equal size that the sampler supports.
    #[arg(long, value_name = "N", value_parser = values::whole(1..=1_u32 << 31), allow_negative_numbers = true, help_heading = "Sampling")]
    pub(crate) spp: Option<u32>,

    /// Split the samples into N independent passes to estimate the error [default: 1; for stochastic integrators 2 or 4, unless that doubles the samples]
    #[arg(long, value_name = "N", value_parser = values::whole(1..=1_u32 << 16), allow_negative_numbers = true, help_heading = "Sampling")]
    pub(crate) passes: Option<u32>,

    /// Take fewer samples in pixels without object or shadow edges (whitted only) [default: as in the scene]
    ///
    /// `object-space` detects edges by intersecting the frustum of each pixel with the scene.
    #[arg(long, value_name = "NAME", value_enum, help_heading = "Sampling")]
    pub(crate) adaptive: Option<AdaptiveChoice>,

    /// Take at least this many samples per pixel with --adaptive [default: a quarter of --spp]
    #[arg(long, alias = "least", value_name = "N", value_parser = values::whole(1..=1_u32 << 31), allow_negative_numbers = true, help_heading = "Sampling")]
    pub(crate) min_spp: Option<u32>,

    /// Limit the bounces after the first hit; 0 shows emission and direct light only [default: as in the scene]
    #[arg(long, alias = "depth", value_name = "N", value_parser = values::whole(0..=10_000_u32), allow_negative_numbers = true, help_heading = "Sampling")]
    pub(crate) max_depth: Option<u32>,

    /// Set the seed of the random numbers [default: as in the scene]
    #[arg(long, value_name = "N", value_parser = values::whole(0..=u64::MAX), allow_negative_numbers = true, help_heading = "Sampling")]
    pub(crate) seed: Option<u64>,

    /// Clamp each contribution of indirect light to this radiance: fewer fireflies, but biased [default: as in the scene]
    ///
    /// Light is indirect after two or more surface interactions. A contribution whose largest component exceeds N is scaled down to
    /// N. Direct light, and the light paths of `path-caustics`, are not clamped. The statistics report the lost light.
    #[arg(long, value_name = "N", value_parser = values::positive, allow_negative_numbers = true, help_heading = "Sampling")]
    pub(crate) clamp: Option<f64>,

    /// Choose the integrator: a light transport algorithm, or a debug view of geometry or cost [default: as in the scene]
    #[arg(long, value_name = "NAME", value_parser = named(&Integrator::ALL, Integrator::name), help_heading = "Rendering")]
    pub(crate) integrator: Option<Integrator>,

    /// Choose the sample pattern of pixels [default: as in the scene]
    #[arg(long, value_name = "NAME", value_parser = named(&SamplerKind::ALL, SamplerKind::name), help_heading = "Rendering")]
    pub(crate) sampler: Option<SamplerKind>,

    /// Choose the sampling of area lights: uniform, by power, or by a light tree [default: as in the scene]
    #[arg(long, value_name = "NAME", value_parser = named(&LightSampling::ALL, LightSampling::name), help_heading = "Rendering")]
    pub(crate) light_sampling: Option<LightSampling>,

    /// Choose the acceleration structure; does not change the image [default: as in the scene]
    #[arg(long, value_name = "NAME", value_parser = named(&Accel::ALL, Accel::name), help_heading = "Rendering")]
    pub(crate) accel: Option<Accel>,

    /// Choose the SIMD instructions of accelerators and shading; does not change the image [default: best available]
    ///
    /// Without the feature `all-simd` of the program, trees use AVX2 instead of AVX-512.
    #[arg(long, value_name = "NAME", value_parser = values::simd(), help_heading = "Rendering")]
    pub(crate) simd: Option<SimdLevel>,

    /// Choose the numbers of shading: `f32` for common shapes and materials and else `f64`, or everything in `f64`
    #[arg(long, value_name = "NAME", value_parser = named(Precision::ALL, Precision::name), default_value = "f32", help_heading = "Rendering")]
    pub(crate) precision: Precision,

    /// Choose the build quality of `bvh8`; does not change the image
    #[arg(long, alias = "quality", value_name = "NAME", value_parser = named(Quality::ALL, Quality::name), default_value = "medium", help_heading = "Rendering")]
    pub(crate) build_quality: Quality,

    /// Keep unused features in the plan; does not change the image
    #[arg(long, hide = true)]
    pub(crate) full_plan: bool,

    #[command(flatten)]
    pub(crate) view: ViewArgs,

    /// Render only this rectangle of the image, in pixels from its upper left corner
    #[arg(long, value_name = "X,Y,W,H", value_parser = values::crop, allow_hyphen_values = true, help_heading = "Camera and scene")]
    pub(crate) crop: Option<Crop>,

    /// Set the background: #RRGGBB, #RGB, linear GRAY or R,G,B, black, white, or transparent [default: as in the scene]
    ///
    /// With --env, camera rays that hit nothing show this background, and the environment image lights the scene.
    #[arg(long, value_name = "COLOR", value_parser = values::background, allow_hyphen_values = true, help_heading = "Camera and scene")]
    pub(crate) background: Option<BackgroundChoice>,

    /// Light the scene with this environment image: .exr, .hdr, .png, .jpg, or -
    ///
    /// Instead of `whitted`, `path` renders the scene unless --integrator is given. With --background, camera rays that hit nothing show
    /// that instead of the image; mirrors and glass still show the image.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Camera and scene")]
    pub(crate) env: Option<PathBuf>,
}

#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Camera and scene")]
pub(crate) struct ViewArgs {
    /// Choose the camera by name [default: first]
    #[arg(long, value_name = "NAME")]
    pub(crate) camera: Option<String>,

    /// Move the camera to this point; without --look-at, it keeps its direction
    #[arg(long, value_name = "X,Y,Z", value_parser = values::point, allow_hyphen_values = true)]
    pub(crate) look_from: Option<DVec3>,

    /// Turn the camera to this point
    #[arg(long, value_name = "X,Y,Z", value_parser = values::point, allow_hyphen_values = true)]
    pub(crate) look_at: Option<DVec3>,

    /// Set the up direction of a moved or rotated camera [default: 0,1,0]
    #[arg(long, value_name = "X,Y,Z", value_parser = values::point, allow_hyphen_values = true)]
    pub(crate) up: Option<DVec3>,

    /// Set the field of view in degrees, along the `fov_axis` of the camera [default: as in the scene]
    #[arg(long, value_name = "DEG", value_parser = values::field_of_view, allow_negative_numbers = true)]
    pub(crate) fov: Option<f64>,
}

/// Conversion of radiance to bytes.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Tone mapping")]
pub(crate) struct DevelopmentArgs {
    /// Set the exposure in stops: 1 doubles the brightness, -1 halves it [default: as in the scene, or 0]
    #[arg(long, value_name = "EV", value_parser = values::exposure, allow_negative_numbers = true)]
    pub(crate) exposure: Option<f64>,

    /// Choose the tone curve from radiance to display values [default: as in the scene, or clamp]
    #[arg(long, value_name = "NAME", value_parser = named(&values::TONE_CURVES, values::tone_name))]
    pub(crate) tone: Option<ToneCurve>,

    /// Dither .png and .jpg to avoid banding; off rounds to the nearest byte [default: as in the scene, or on]
    #[arg(long, value_name = "NAME", value_parser = values::dither())]
    pub(crate) dither: Option<bool>,
}

impl DevelopmentArgs {
    /// Removes the defaults of a scene from the help of an argument, for commands that read an image.
    pub(super) fn without_scene(argument: Arg) -> Arg {
        with_default(argument, |default| default.to_owned())
    }

    /// Names the shard whose defaults `merge` takes.
    pub(super) fn of_shards(argument: Arg) -> Arg {
        with_default(argument, |_| "as in shard 1".to_owned())
    }
}

/// Replaces the default of a scene in the help of an argument, given the default without a scene.
fn with_default(argument: Arg, default: impl Fn(&str) -> String) -> Arg {
    const OF_SCENE: &str = "[default: as in the scene, or ";
    let help = argument.get_help().map(ToString::to_string).unwrap_or_default();
    let parts = help.split_once(OF_SCENE).and_then(|(before, rest)| Some((before, rest.split_once(']')?)));
    match parts {
        Some((before, (old, after))) => argument.help(format!("{before}[default: {}]{after}", default(old))),
        None => argument,
    }
}

/// Distribution of samples over the pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum AdaptiveChoice {
    Off,
    ObjectSpace,
}
