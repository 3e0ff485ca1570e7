//! Command-line options, as typed.

mod aov;
mod checkpoint;
mod compare;
mod converge;
mod default_command;
mod frames;
mod image;
mod input;
mod memory;
mod merge;
mod raw_options;
mod stop;
mod values;

#[cfg(feature = "view")]
use std::net::IpAddr;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum, ValueHint};
use rt_image::ImageFormat;

pub(crate) use aov::{Aov, AovArg, AovContent, LayerList};
pub(crate) use checkpoint::CheckpointArgs;
pub(crate) use compare::{CompareArgs, HeatMapOf, Metric};
pub(crate) use converge::{ConvergeArgs, ReferenceKind, Variation};
pub(crate) use default_command::parse;
pub(crate) use frames::{FrameChoice, Frames, FramesArgs};
pub(crate) use image::{AdaptiveChoice, DevelopmentArgs, ImageArgs, ViewArgs};
pub(crate) use input::InputArgs;
pub(crate) use memory::{Amount, MemoryArgs};
pub(crate) use merge::MergeArgs;
pub(crate) use stop::StopArgs;
#[cfg(feature = "view")]
pub(crate) use values::TONE_CURVES;
pub(crate) use values::{BackgroundChoice, CheckpointInterval, tone_name, tone_of_name};

/// Name of an enum value on the command line.
pub(crate) fn name_of(value: impl ValueEnum) -> String {
    value.to_possible_value().map(|value| value.get_name().to_owned()).unwrap_or_default()
}

#[derive(Debug, Parser)]
#[command(
    name = "rt-cli",
    bin_name = "rt-cli",
    version,
    about = "A ray tracer: renders scenes (.ron, .json) and models (.gltf, .glb, .obj, .nff, .pbrt, .ply, .stl) to images",
    long_about = "A ray tracer: renders scenes (.ron, .json) and models (.gltf, .glb, .obj, .nff, .pbrt, .ply, .stl) to images.\n\n\
                  `rt-cli SCENE` is short for `rt-cli render SCENE` and takes the same options. Without any argument, a built-in scene is \
                  rendered to still_life.png; with options, a scene must be named. `rt-cli help COMMAND` is the same as `rt-cli COMMAND --help`.\n\n\
                  The file name `-` means standard input for a scene or image and standard output for an image or text. Reports then go to standard error.",
    after_help = "Exit codes: 0 success, 1 compared images differ, 2 wrong usage, 3 bad input, 4 output not writable, or the port of `view` in use, 5 image written but damaged or, with --strict, with bad samples, black or empty, 130 interrupted.",
    override_usage = "rt-cli SCENE [OPTIONS]\n       rt-cli COMMAND ...\n       rt-cli [--limits]",
    disable_help_subcommand = true,
    args_conflicts_with_subcommands = true
)]
pub(crate) struct Cli {
    /// Print every limit on input, and the option that changes it
    #[arg(long)]
    pub(crate) limits: bool,

    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene or model to an image
    Render(Box<RenderArgs>),
    /// View a scene in the browser: move the camera, pick objects, watch the error fall
    #[cfg(feature = "view")]
    View(Box<BrowserArgs>),
    /// Print the render plan: used and left-out features with reasons, predicted memory
    Explain(ExplainArgs),
    /// Check the numerical health of a scene: sizes, transforms, meshes, glass, precision
    Check(CheckArgs),
    /// Convert a scene or model to a scene file (.ron, .json)
    Convert(ConvertArgs),
    /// Tone-map a linear image: exposure, tone curve, gamma
    Develop(DevelopArgs),
    /// Merge the shards of an image rendered with --shard
    #[command(long_about = merge::MERGE_HELP)]
    Merge(MergeArgs),
    /// Measure the difference from a reference image: errors, PSNR, SSIM, FLIP, heat map
    #[command(long_about = compare::COMPARE_HELP)]
    Compare(CompareArgs),
    /// Measure error against run time for several methods: table, plot, HTML page
    #[command(long_about = converge::CONVERGE_HELP)]
    Converge(ConvergeArgs),
    /// Print the JSON Schema of scene files, for editors
    Schema {
        /// Print the reference page in Markdown instead
        #[arg(long)]
        markdown: bool,
    },
    /// Print shell completions
    Completions {
        /// Name of the shell
        shell: clap_complete::Shell,
    },
    /// Print the manual, or write one page per command
    Man {
        /// Write the pages to this existing directory
        #[arg(short, long, value_name = "DIR", value_hint = ValueHint::DirPath)]
        output: Option<PathBuf>,
    },
}

#[derive(Clone, Debug, Args)]
#[command(mut_arg("animation", |arg| {
    arg.help("Choose the animation of models by name or index, or `all`, for --at-time or --frames [default: first]")
}))]
#[command(mut_arg("fps", |arg| arg.help("Set the frames per second, for --frames and --shutter")))]
#[command(mut_arg("spp", |arg| arg.long_help(image::SPP_HELP_WITH_STOP_RULES)))]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,

    /// Write the image to this file: .png, .jpg, .exr, .hdr, .pfm, or - [default: SCENE.png]
    ///
    /// With --shard, a .part file is written [default: SCENE.I-of-N.part]. An older file is replaced only when the new one is
    /// complete. For -, the format is PNG unless --output-format is given, and no checkpoint is written unless --checkpoint is given.
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath, help_heading = "Output")]
    pub(crate) output: Option<PathBuf>,

    /// Set the image format [default: by file extension, png for -]
    #[arg(long, value_name = "FORMAT", value_parser = values::image_format(), help_heading = "Output")]
    pub(crate) output_format: Option<ImageFormat>,

    #[command(flatten)]
    pub(crate) frames: FramesArgs,

    #[command(flatten)]
    pub(crate) image: ImageArgs,

    #[command(flatten)]
    pub(crate) stop: StopArgs,

    #[command(flatten)]
    pub(crate) development: DevelopmentArgs,

    /// Write layers: depth,normal,albedo=FILE.exr, or one of stderr=FILE and samples=FILE in any format
    #[arg(long, value_name = "LIST=FILE", value_parser = aov::aov, long_help = aov::AOV_HELP, help_heading = "Output")]
    pub(crate) aov: Vec<AovArg>,

    #[command(flatten)]
    pub(crate) checkpoint: CheckpointArgs,

    #[command(flatten)]
    pub(crate) run: RunArgs,
}

#[cfg(feature = "view")]
const VIEW_SPP_HELP: &str = "Stop at this number of samples per pixel [default: as in the scene]";

/// Arguments of `view`, which refuses the hidden ones.
#[cfg(feature = "view")]
#[derive(Debug, Args)]
#[command(mut_arg("crop", |arg| arg.hide(true)), mut_arg("passes", |arg| arg.hide(true)))]
#[command(mut_arg("adaptive", |arg| arg.hide(true)), mut_arg("min_spp", |arg| arg.hide(true)))]
#[command(mut_arg("spp", |arg| arg.help(VIEW_SPP_HELP).long_help(VIEW_SPP_HELP)))]
pub(crate) struct BrowserArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,

    #[command(flatten)]
    pub(crate) image: ImageArgs,

    #[command(flatten)]
    pub(crate) development: DevelopmentArgs,

    /// Set the number of threads [default: one per processor]
    #[arg(long, value_name = "N", value_parser = values::whole(1..=1024_u16), allow_negative_numbers = true, help_heading = "Running")]
    pub(crate) threads: Option<u16>,

    /// Serve the page at this port; 0 chooses a free port
    #[arg(long, value_name = "N", value_parser = values::whole(0..=u16::MAX), allow_negative_numbers = true, default_value = "0", help_heading = "Server")]
    pub(crate) port: u16,

    /// Listen on this address; any other than a loopback address opens the view to the network
    ///
    /// Anyone with the printed address, which includes a token, has access to the scene and the render. The connection is not
    /// encrypted. To view from another machine, forward a port: `ssh -t -L 8080:localhost:8080 HOST` and `--port 8080`.
    #[arg(long, value_name = "ADDRESS", value_parser = values::address, default_value = "127.0.0.1", help_heading = "Server")]
    pub(crate) bind: IpAddr,

    /// Print the address without opening the browser
    #[arg(long, help_heading = "Server")]
    pub(crate) no_open: bool,
}

#[derive(Debug, Args)]
pub(crate) struct ExplainArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,

    #[command(flatten)]
    pub(crate) image: ImageArgs,

    /// Treat warnings as errors (exit code 3)
    #[arg(long, help_heading = "Running")]
    pub(crate) strict: bool,
}

#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,

    /// Set the report format
    #[arg(long, value_enum, default_value_t = ReportFormat::Text, long_help = CHECK_FORMAT_HELP)]
    pub(crate) format: ReportFormat,

    /// Exit with code 3 if there are errors or warnings
    #[arg(long)]
    pub(crate) strict: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ReportFormat {
    Text,
    Json,
}

const CHECK_FORMAT_HELP: &str = "\
Set the report format

In JSON, `measures` holds measurements of the whole scene, with lengths in world units. `findings` lists the findings, most severe \
first: `severity` (error, warning, note), `kind` (a name that is stable across versions), `object`, measured `values` by name \
(null for infinite), `message` and `advice`. The first findings of each kind are listed; `more` counts the others. `errors`, \
`warnings` and `notes` count all findings.";

#[derive(Debug, Args)]
#[command(
    mut_arg("at_time", |arg| arg.hide(true)),
    mut_arg("fps", |arg| arg.hide(true)),
    mut_arg("shutter", |arg| arg.hide(true)),
    mut_arg("animation", |arg| arg.hide(true)),
    mut_arg("variant", |arg| arg.hide(true))
)]
pub(crate) struct ConvertArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,

    /// Write the scene to this file: .ron, .json, or -
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) output: PathBuf,

    /// Set the format of the scene file [default: by file extension, ron for -]
    #[arg(long, value_name = "FORMAT", value_parser = ["ron", "json"])]
    pub(crate) output_format: Option<String>,

    /// Treat warnings as errors (exit code 3), and write no file
    #[arg(long)]
    pub(crate) strict: bool,

    /// Print errors only
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

#[derive(Debug, Args)]
#[command(mut_args(DevelopmentArgs::without_scene))]
pub(crate) struct DevelopArgs {
    /// Image: .exr, .hdr, .pfm, .png, .jpg, or - for standard input
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) image: PathBuf,

    /// Write the image to this file: .png, .jpg, or -
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) output: PathBuf,

    /// Set the image format [default: by file extension, png for -]
    #[arg(long, value_name = "FORMAT", value_parser = values::display_format())]
    pub(crate) output_format: Option<ImageFormat>,

    #[command(flatten)]
    pub(crate) development: DevelopmentArgs,

    /// Encode with the exponent 1 / GAMMA instead of the sRGB curve; 1 stores linear values
    #[arg(long, value_name = "GAMMA", value_parser = values::gamma, allow_negative_numbers = true)]
    pub(crate) gamma: Option<f64>,

    /// Print errors only
    #[arg(short, long)]
    pub(crate) quiet: bool,

    #[command(flatten)]
    pub(crate) memory: MemoryArgs,
}

/// Options without influence on the image.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Running")]
pub(crate) struct RunArgs {
    /// Set the number of threads [default: one per processor]
    #[arg(long, value_name = "N", value_parser = values::whole(1..=1024_u16), allow_negative_numbers = true)]
    pub(crate) threads: Option<u16>,

    /// Write statistics in JSON to this file or to -, and count the cost per ray
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, long_help = STATS_HELP)]
    pub(crate) stats: Option<PathBuf>,

    /// Show the image in the viewer tev while it renders
    ///
    /// tev must be running. If the connection is lost, the render continues.
    #[cfg(feature = "display")]
    #[arg(long, value_name = "HOST:PORT")]
    pub(crate) display_server: Option<String>,

    /// Exit with code 3 on warnings, and with 5 if samples are bad, or the image is black or shows no object
    #[arg(long)]
    pub(crate) strict: bool,

    /// Print errors only
    #[arg(short, long)]
    pub(crate) quiet: bool,

    /// Print all statistics: rays by kind, times, memory, left-out features
    #[arg(short, long, conflicts_with = "quiet")]
    pub(crate) verbose: bool,
}

impl RunArgs {
    /// Address of the viewer tev.
    pub(crate) fn display_server(&self) -> Option<&str> {
        #[cfg(feature = "display")]
        return self.display_server.as_deref();
        #[cfg(not(feature = "display"))]
        None
    }
}

const STATS_HELP: &str = "\
Write statistics in JSON to this file or to -, and count the cost per ray

`rays` has an entry for each kind of ray and for their `total`: traced `rays`, visited nodes, primitive tests and hits. \
`camera_hits` counts camera samples that hit a surface. `primary_rays_skipped` counts camera rays that were skipped because \
their part of the view is empty. `pixel_samples` are the samples per pixel; `simple_pixels` took fewer because they show no edge \
(--adaptive). `stopped` is the stop rule that ended the render (samples, time, target-error). `unconverged_pixels` counts pixels that missed --target-error \
(null without --target-error-pixels). `clamping` is the effect of --clamp (null without it). `saturated_pixels` counts pixels in which the \
light of caustics was cut off at a radiance of 2^41, summed over passes. `estimated_error` is null after a single \
pass. `shading` counts the work of materials, and the SIMD `lanes` that shaded, with those in use. `seconds` are wall-clock times. \
Counts are the same in every run, those of lanes on processors of the same kind; `seconds`, `mega_rays_per_second` and \
`peak_memory_bytes` (null where unknown) are not.";
