//! What the user may type.

mod compare;
mod converge;
mod frames;
mod keep;
mod memory;
mod merge;
mod picture;
mod startup;
mod stop;
mod typed;
mod values;

#[cfg(feature = "view")]
use std::net::IpAddr;
use std::path::PathBuf;

use clap::{Args, Parser, Subcommand, ValueEnum, ValueHint};
use rt_image::ImageFormat;
use rt_scene_io::{InMemoryFile, LoadErrorKind, StudioLights};

pub(crate) use compare::{CompareArgs, HeatMapOf, Metric};
pub(crate) use converge::{Against, ConvergeArgs, Variation};
pub(crate) use frames::{FrameChoice, Frames, FramesArgs, PaceArgs};
pub(crate) use keep::{Every, KeepArgs};
pub(crate) use memory::{Amount, MemoryArgs};
pub(crate) use merge::MergeArgs;
pub(crate) use picture::{AdaptiveChoice, BackgroundChoice, DevelopmentArgs, PictureArgs, ViewArgs};
pub(crate) use startup::with_default_command;
pub(crate) use stop::{Aov, AovArg, StopArgs};
#[cfg(feature = "view")]
pub(crate) use values::TONE_CURVES;
pub(crate) use values::{tone_name, tone_of_name};

/// The commands, and what needs no command.
#[derive(Debug, Parser)]
#[command(
    name = "rt-cli",
    bin_name = "rt-cli",
    version,
    about = "A ray tracer: renders scenes (.ron, .json) and models (.gltf, .glb, .obj, .nff, .pbrt, .ply, .stl) to pictures",
    long_about = "A ray tracer: renders scenes (.ron, .json) and models (.gltf, .glb, .obj, .nff, .pbrt, .ply, .stl) to pictures.\n\n\
                  `rt-cli SCENE` is short for `rt-cli render SCENE`, with the same options. Without any argument, it renders a built-in \
                  showcase to showcase.png.\n\n\
                  The name `-` stands for standard input where a scene or an image is read, and for standard output where a file is \
                  written; reports then go to standard error.",
    after_help = "Exit codes: 0 done, 1 compared images differ, 2 wrong usage, 3 bad input, 4 output could not be written, 5 finished but damaged, 130 interrupted (the picture so far is saved).",
    disable_help_subcommand = true,
    args_conflicts_with_subcommands = true
)]
pub(crate) struct Cli {
    /// Print every limit on what is read, and which option changes it
    #[arg(long)]
    pub(crate) limits: bool,

    /// What to do.
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
}

/// The commands.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Render a scene or model to a picture
    Render(Box<RenderArgs>),
    /// View a scene in the browser: move the camera, pick objects, watch the error fall
    #[cfg(feature = "view")]
    View(Box<BrowserArgs>),
    /// Show what a render would use, what it would leave out and why, and its memory
    Explain(ExplainArgs),
    /// Report on the numerical health of a scene: sizes, transforms, meshes, glass, precision
    Check(CheckArgs),
    /// Turn a scene or model into a scene file to edit
    Convert(ConvertArgs),
    /// Turn an image of linear light into a picture: exposure, tone curve, gamma
    Develop(DevelopArgs),
    /// Join the parts of a picture that machines have rendered
    #[command(long_about = merge::MERGE_HELP)]
    Merge(MergeArgs),
    /// Measure how much an image differs from a reference: errors, PSNR, SSIM, FLIP, heat map
    #[command(long_about = compare::COMPARE_HELP)]
    Compare(CompareArgs),
    /// Measure the error of methods against their run time: table, plot, page
    #[command(long_about = converge::CONVERGE_HELP)]
    Converge(ConvergeArgs),
    /// Print the JSON Schema of scene files, for editors
    Schema {
        /// Print the reference page of scene files, in Markdown, instead
        #[arg(long)]
        markdown: bool,
    },
    /// Print completions for a shell
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Print the manual, or write it to a folder, one page a command
    Man {
        /// Folder to write the pages to; it must exist
        #[arg(short, long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
        output: Option<PathBuf>,
    },
}

/// Arguments of `render`.
#[derive(Clone, Debug, Args)]
pub(crate) struct RenderArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,

    /// Picture to write: .png, .jpg, .exr, .hdr or .pfm, or - for standard output; with --shard, a .part file
    ///
    /// By default the scene's name with .png, or .I-of-N.part, in the current folder. An older file is replaced when the new one is
    /// complete, and survives any failure. Standard output gets a .png unless --output-format says otherwise, and no checkpoint is
    /// kept of it unless --checkpoint says where.
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) output: Option<PathBuf>,

    /// Format of the picture, whatever its name says; by default told by the ending of the name, and png for `-`
    #[arg(long, value_name = "NAME", value_parser = values::image_format())]
    pub(crate) output_format: Option<ImageFormat>,

    #[command(flatten)]
    pub(crate) frames: FramesArgs,

    #[command(flatten)]
    pub(crate) picture: PictureArgs,

    #[command(flatten)]
    pub(crate) stop: StopArgs,

    #[command(flatten)]
    pub(crate) development: DevelopmentArgs,

    /// Write what is known of each pixel beside its radiance: `variance` or `samples`, to any format
    #[arg(long, value_name = "NAME=FILE", value_parser = values::aov, long_help = stop::AOV_HELP)]
    pub(crate) aov: Vec<AovArg>,

    #[command(flatten)]
    pub(crate) keep: KeepArgs,

    #[command(flatten)]
    pub(crate) run: RunArgs,
}

/// Arguments of `view`.
#[cfg(feature = "view")]
#[derive(Debug, Args)]
pub(crate) struct BrowserArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,

    #[command(flatten)]
    pub(crate) picture: PictureArgs,

    #[command(flatten)]
    pub(crate) development: DevelopmentArgs,

    /// Number of threads; by default one for each processor
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024), help_heading = "Running")]
    pub(crate) threads: Option<u16>,

    /// Serve the page at this port; 0 for any free one
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Server")]
    pub(crate) port: u16,

    /// Listen on this address; all but loopback addresses open the view to the network
    ///
    /// Whoever knows the printed address, token included, sees the scene and steers the render, and the connection is not
    /// encrypted. From another machine, a forwarded port is safer: `ssh -t -L 8080:localhost:8080 HOST` and `--port 8080`.
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1", help_heading = "Server")]
    pub(crate) bind: IpAddr,

    /// Print the address, and do not open it in the browser
    #[arg(long, help_heading = "Server")]
    pub(crate) no_open: bool,
}

/// Arguments of `explain`.
#[derive(Debug, Args)]
pub(crate) struct ExplainArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,

    #[command(flatten)]
    pub(crate) picture: PictureArgs,

    /// Take warnings for errors (exit code 3)
    #[arg(long)]
    pub(crate) strict: bool,
}

/// Arguments of `check`.
#[derive(Debug, Args)]
pub(crate) struct CheckArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,

    /// How to print the report
    #[arg(long, value_enum, default_value_t = ReportFormat::Text, long_help = CHECK_FORMAT_HELP)]
    pub(crate) format: ReportFormat,

    /// Exit with code 3 if there is a warning or an error
    #[arg(long)]
    pub(crate) strict: bool,
}

/// How a report is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ReportFormat {
    Text,
    Json,
}

const CHECK_FORMAT_HELP: &str = "\
How to print the report

In JSON, `measures` holds what was measured of the scene as a whole, lengths in world units. `findings` lists what was \
found, the severest first: its `severity` (error, warning, info), its `kind` (a name that stays the same between \
versions), the `object`, measured `values` by name (null for infinite), a `message`, and `advice`. Of many findings of \
one kind, the first are listed, and `more` holds the count of the others. `errors`, `warnings` and `notes` count all.";

/// Arguments of `convert`.
#[derive(Debug, Args)]
pub(crate) struct ConvertArgs {
    #[command(flatten)]
    pub(crate) input: InputArgs,

    /// Scene file to write: .ron or .json, or - for standard output
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) output: PathBuf,

    /// Format of the scene file, whatever its name says; by default told by the ending of the name, and ron for `-`
    #[arg(long, value_name = "NAME", value_parser = ["ron", "json"])]
    pub(crate) output_format: Option<String>,

    /// Take warnings for errors (exit code 3), and write no file
    #[arg(long)]
    pub(crate) strict: bool,
}

/// Arguments of `develop`.
#[derive(Debug, Args)]
pub(crate) struct DevelopArgs {
    /// Image of linear light: .exr, .hdr or .pfm, or - for standard input
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) image: PathBuf,

    /// Picture to write: .png or .jpg, or - for standard output
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) output: PathBuf,

    /// Format of the picture, whatever its name says; by default told by the ending of the name, and png for `-`
    #[arg(long, value_name = "NAME", value_parser = values::image_format())]
    pub(crate) output_format: Option<ImageFormat>,

    #[command(flatten)]
    pub(crate) development: DevelopmentArgs,

    /// Encode with this exponent rather than the sRGB curve; 1 stores linear light
    #[arg(long, value_name = "GAMMA", value_parser = values::gamma)]
    pub(crate) gamma: Option<f64>,

    #[command(flatten)]
    pub(crate) memory: MemoryArgs,
}

/// What is read.
#[derive(Clone, Debug, Args)]
pub(crate) struct InputArgs {
    /// Scene (.ron, .json) or model (.gltf, .glb, .obj, .nff, .pbrt, .ply, .stl), or - for standard input
    ///
    /// What comes from standard input refers to files in the current folder, and goes by the name of `stdin`.
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,

    /// Format of what `-` reads; by default told by the content of .ron, .json, .gltf, .glb and .ply
    #[arg(long, value_name = "NAME", value_parser = crate::stdin::FORMATS)]
    pub(crate) input_format: Option<String>,

    /// What came from standard input.
    #[arg(skip)]
    pub(crate) piped: Option<InMemoryFile>,

    /// Folder that all files must lie below which the scene refers to; by default that of the scene
    #[arg(long, value_name = "FOLDER", value_hint = ValueHint::DirPath)]
    pub(crate) root: Option<PathBuf>,

    /// Put a ground under a bare model
    #[arg(long)]
    pub(crate) ground: bool,

    /// Add studio lights: `auto` to scenes without a light of any kind, `none` never, `studio` always [default: auto]
    ///
    /// Studio lights are a key light, a fill light, ambient light and a backdrop. Lights of any kind are lights of the file,
    /// emissive materials, an image around the scene and, where it lights the scene, a background that is not black.
    #[arg(long, value_name = "NAME", value_parser = values::choice(StudioLights::ALL, StudioLights::name))]
    pub(crate) lights: Option<StudioLights>,

    /// Pose the scene and its models (.gltf, .glb) as their animations have them at this moment, in seconds
    ///
    /// Without it, a model rests as its nodes say, and what a scene file animates is as at 0. Before the first and after the
    /// last key, that key holds.
    #[arg(long, value_name = "SECONDS", value_parser = values::finite, allow_negative_numbers = true)]
    pub(crate) at_time: Option<f64>,

    #[command(flatten)]
    pub(crate) pace: PaceArgs,

    /// The animation of models for --at-time: its name, its index from 0 on, or `all`; by default the first
    #[arg(long, value_name = "NAME|INDEX")]
    pub(crate) animation: Option<String>,

    /// Show models (.gltf, .glb) in this variant of their materials
    #[arg(long, value_name = "NAME")]
    pub(crate) variant: Option<String>,

    /// Most memory to take, as 512M, 4GiB or 75%; what is predicted to need more is refused
    ///
    /// By default 75 % of what the machine has, or of what the control group allows; no limit where neither can be told.
    /// Percentages are of the same. K, M, G and T are powers of 1000, Ki, Mi, Gi and Ti of 1024.
    #[arg(long, value_name = "BYTES", value_parser = memory::amount, help_heading = "Limits")]
    pub(crate) memory: Option<Amount>,

    /// Largest file to read, as 2GiB; 1GiB by default
    #[arg(long, value_name = "BYTES", value_parser = memory::bytes, help_heading = "Limits")]
    pub(crate) max_file_size: Option<u64>,
}

/// What changes nothing in the picture.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Running")]
pub(crate) struct RunArgs {
    /// Number of threads; by default one for each processor. Any number gives the same picture
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(crate) threads: Option<u16>,

    /// Write statistics to a JSON file, or to standard output (-), and count what each ray costs
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath, long_help = STATS_HELP)]
    pub(crate) stats: Option<PathBuf>,

    /// Show the picture in the image viewer tev as it grows
    ///
    /// The viewer must be there before; if it is lost, the render goes on.
    #[cfg(feature = "display")]
    #[arg(long, value_name = "HOST:PORT")]
    pub(crate) display_server: Option<String>,

    /// Take warnings for errors (exit code 3), and bad samples too (exit code 5)
    #[arg(long)]
    pub(crate) strict: bool,

    /// Print nothing but errors
    #[arg(short, long)]
    pub(crate) quiet: bool,

    /// Print all statistics: rays by kind, times, memory, what was left out
    #[arg(short, long, conflicts_with = "quiet")]
    pub(crate) verbose: bool,
}

impl RunArgs {
    /// Where the viewer is that shows the picture as it grows.
    pub(crate) fn display_server(&self) -> Option<&str> {
        #[cfg(feature = "display")]
        return self.display_server.as_deref();
        #[cfg(not(feature = "display"))]
        None
    }
}

const STATS_HELP: &str = "\
Write statistics to a JSON file, or to standard output (-), and count what each ray costs

`rays` has an entry for each kind of ray and for their `total`: how many were traced (`rays`), and how many nodes, \
primitive tests and hits that took. `camera_hits` are samples that met a surface. `primary_rays_spared` are camera rays that were \
not traced, as there is nothing in their part of the view; `pixel_samples` are the samples that pixels are made of, \
`simple_pixels` took fewer as they show no edge (--adaptive), \
`stopped` is what ended the render (samples, time, target-error), `unconverged_pixels` have not reached --target-error (null without \
--target-error-pixels), `clamping` is what --clamp has taken away (null without it), and \
`estimated_error` is null where there was but one pass; `shading` counts the work of materials, `seconds` are wall-clock times. Counts \
are the same in every run; `seconds`, `mega_rays_per_second` and `peak_memory_bytes` (null where the system does not \
say) are not.";

/// What is wrong with a word that should be one of those known, and which of them is nearest.
fn unknown_word(kind: &'static str, found: &str, known: Vec<String>) -> String {
    LoadErrorKind::UnknownWord { kind, found: found.to_owned(), known }.to_string()
}
