//! Options that decide what the picture looks like. Each overrides what the scene says.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use rt_camera::SamplerKind;
use rt_image::ToneCurve;
use rt_math::{DVec3, Rgb};
use rt_render::{Crop, Quality, SimdLevel};
use rt_scene_io::{Accel, Integrator, LightSampling};

use super::values::{self, choice};

/// How much to render, how, and what of it.
#[derive(Clone, Debug, Args)]
pub(crate) struct PictureArgs {
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", value_parser = values::size, help_heading = "How much")]
    pub(crate) size: Option<[u32; 2]>,

    /// Samples per pixel, rounded up to what the sampler needs; with --time or --target-error, the most that a pixel takes (4096 by default with --target-error)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 31), help_heading = "How much")]
    pub(crate) spp: Option<u32>,

    /// Independent passes that the samples are split into, by which the error is told; 1 by default, or 4 for integrators that choose directions at random
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 16), help_heading = "How much")]
    pub(crate) passes: Option<u32>,

    /// Take fewer samples of pixels in which no edge of an object or of a shadow can be, with `whitted`; `object-space` looks into the pyramid of each
    #[arg(long, value_name = "NAME", value_parser = choice(AdaptiveChoice::ALL, AdaptiveChoice::name), help_heading = "How much")]
    pub(crate) adaptive: Option<AdaptiveChoice>,

    /// Samples of pixels without edges, rounded up to what the sampler needs; a quarter of all by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 31), help_heading = "How much")]
    pub(crate) least: Option<u32>,

    /// Bounces after the first hit; 0 for emission and direct light alone
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(..=10_000), help_heading = "How much")]
    pub(crate) depth: Option<u32>,

    /// Seed of all random numbers
    #[arg(long, value_name = "N", help_heading = "How much")]
    pub(crate) seed: Option<u64>,

    /// Bound contributions of indirect light to a sample, in units of radiance: fewer fireflies, and a biased picture [default: none]
    ///
    /// Light is indirect if two or more surfaces have scattered it on its way to the camera. A contribution whose largest component
    /// exceeds N is scaled down so that it equals N. Direct light, and light paths of `caustics`, are not bounded. The picture
    /// is too dark by what is lost, which the statistics tell.
    #[arg(long, value_name = "N", value_parser = values::positive, allow_negative_numbers = true, help_heading = "How much")]
    pub(crate) clamp: Option<f64>,

    /// How light is computed: by classical ray tracing, with soft shadows, along all its paths; or a view of geometry or cost
    #[arg(long, value_name = "NAME", value_parser = choice(Integrator::ALL, Integrator::name), help_heading = "How")]
    pub(crate) integrator: Option<Integrator>,

    /// Where in the pixel the samples fall
    #[arg(long, value_name = "NAME", value_parser = choice(SamplerKind::ALL, SamplerKind::name), help_heading = "How")]
    pub(crate) sampler: Option<SamplerKind>,

    /// How one of many lights with extent is chosen
    #[arg(long, value_name = "NAME", value_parser = choice(LightSampling::ALL, LightSampling::name), help_heading = "How")]
    pub(crate) light_sampling: Option<LightSampling>,

    /// Acceleration structure. Any gives the same picture
    #[arg(long, value_name = "NAME", value_parser = choice(Accel::ALL, Accel::name), help_heading = "How")]
    pub(crate) accel: Option<Accel>,

    /// Instructions for the structures `wide` and `linear`; the best that the processor has by default. Any give the same picture
    #[arg(long, value_name = "NAME", value_parser = values::simd(), help_heading = "How")]
    pub(crate) simd: Option<SimdLevel>,

    /// How much time the structure `wide` may take to be built; medium by default. Any gives the same picture
    #[arg(long, value_name = "NAME", value_parser = values::quality(), help_heading = "How")]
    pub(crate) quality: Option<Quality>,

    /// Leave nothing out of the plan. The picture is the same
    #[arg(long, hide = true)]
    pub(crate) full_plan: bool,

    #[command(flatten)]
    pub(crate) view: ViewArgs,

    /// Render this part of the image only, in pixels from its upper left corner
    #[arg(long, value_name = "X,Y,W,H", value_parser = values::crop, help_heading = "What")]
    pub(crate) crop: Option<Crop>,

    /// What lies behind everything: #RRGGBB, linear R,G,B, black, white, or transparent; with --env, what is seen in place of its image
    #[arg(long, value_name = "COLOUR", value_parser = values::background, help_heading = "What")]
    pub(crate) background: Option<BackgroundChoice>,

    /// An image around the scene (.exr, .hdr, .png, .jpg, or - for standard input), which lights it: by `path`, unless another integrator is given
    ///
    /// With --background, camera rays that leave the scene see that in its place; mirrors and glass still show the image.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "What")]
    pub(crate) env: Option<PathBuf>,
}

/// Which camera, and where it stands.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "What")]
pub(crate) struct ViewArgs {
    /// Camera of the scene to use; by default its first
    #[arg(long, value_name = "NAME")]
    pub(crate) camera: Option<String>,

    /// Move the camera here; without --look-at it keeps its direction
    #[arg(long, value_name = "X,Y,Z", value_parser = values::point, allow_hyphen_values = true)]
    pub(crate) look_from: Option<DVec3>,

    /// Turn the camera to this point
    #[arg(long, value_name = "X,Y,Z", value_parser = values::point, allow_hyphen_values = true)]
    pub(crate) look_at: Option<DVec3>,

    /// Direction that is up in the image, where the camera is moved or turned; 0,1,0 by default
    #[arg(long, value_name = "X,Y,Z", value_parser = values::point, allow_hyphen_values = true)]
    pub(crate) up: Option<DVec3>,

    /// Field of view in degrees, along the side of the image that the camera's own spans
    #[arg(long, value_name = "DEG", value_parser = values::field_of_view)]
    pub(crate) fov: Option<f64>,
}

/// How light becomes bytes.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Developing")]
pub(crate) struct DevelopmentArgs {
    /// Exposure in stops: 1 doubles the brightness, -1 halves it
    #[arg(long, value_name = "EV", value_parser = values::exposure, allow_negative_numbers = true)]
    pub(crate) exposure: Option<f64>,

    /// Curve that brings bright light into the range of the display
    #[arg(long, value_name = "NAME", value_parser = choice(values::TONE_CURVES, values::tone_name))]
    pub(crate) tone: Option<ToneCurve>,

    /// Dither the colours of .png and .jpg, so that gradients show no bands; `none` rounds to the nearest byte [default: on, or as the scene says]
    #[arg(long, value_name = "NAME", value_parser = values::dither())]
    pub(crate) dither: Option<bool>,
}

/// How samples are shared out among pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum AdaptiveChoice {
    /// Evenly.
    Off,
    /// By what lies in the pyramid of each.
    ObjectSpace,
}

impl AdaptiveChoice {
    const ALL: [Self; 2] = [Self::Off, Self::ObjectSpace];

    /// The name that users type.
    const fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::ObjectSpace => "object-space",
        }
    }
}

/// What lies behind everything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum BackgroundChoice {
    /// This radiance.
    Colour(Rgb),
    /// Nothing: the picture has an alpha channel.
    Transparent,
}
