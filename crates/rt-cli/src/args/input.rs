//! Options of the input: scene or model, and how it is read.

use std::path::PathBuf;

use clap::{Args, ValueHint};
use rt_scene_io::{InMemoryFile, StudioLights};

use super::frames::TimingArgs;
use super::memory::{self, MemoryArgs};
use super::values;

#[derive(Clone, Debug, Args)]
pub(crate) struct InputArgs {
    /// Scene (.ron, .json) or model (.gltf, .glb, .obj, .nff, .pbrt, .ply, .stl), or - for standard input
    ///
    /// For -, paths in the scene are relative to the current directory, and output names begin with `stdin`.
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) scene: PathBuf,

    /// Set the format of standard input [default: detected for .ron, .json, .gltf, .glb, .ply]
    #[arg(long, value_name = "FORMAT", value_parser = crate::stdin::FORMATS)]
    pub(crate) input_format: Option<String>,

    /// Content of standard input.
    #[arg(skip)]
    pub(crate) piped: Option<InMemoryFile>,

    /// Only read assets below this directory [default: the scene's directory]
    #[arg(long, alias = "root", value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) asset_root: Option<PathBuf>,

    /// Add a ground plane under a model; has no effect on scene files
    #[arg(long)]
    pub(crate) ground: bool,

    /// Add studio lights: auto (only to unlit scenes), none, or studio (always)
    ///
    /// Studio lights are a key light, a fill light, ambient light and a background. A scene is lit if it has a light, an emissive
    /// material or an environment image. Emission by a texture counts if it is brighter than 1 somewhere. A background other than black counts as a light if the integrator samples it.
    #[arg(long, value_name = "NAME", value_parser = values::named(&StudioLights::ALL, StudioLights::name), default_value = "auto")]
    pub(crate) lights: StudioLights,

    /// Evaluate animations of the scene and of glTF models at this time in seconds
    ///
    /// By default, models are in their rest pose, and scene files at time 0. Before the first key and after the last key, the pose is
    /// constant.
    #[arg(long, value_name = "SECONDS", value_parser = values::finite, allow_negative_numbers = true, group = "time_of_animation")]
    pub(crate) at_time: Option<f64>,

    #[command(flatten)]
    pub(crate) timing: TimingArgs,

    /// Choose the animation of models by name or index, or `all`, for --at-time [default: first]
    #[arg(long, value_name = "NAME|INDEX", requires = "time_of_animation")]
    pub(crate) animation: Option<String>,

    /// Choose the material variant of glTF models by name
    #[arg(long, value_name = "NAME")]
    pub(crate) variant: Option<String>,

    #[command(flatten)]
    pub(crate) memory: MemoryArgs,

    /// Refuse input files larger than this, such as 2GiB [default: 1GiB]
    #[arg(long, value_name = "BYTES", value_parser = memory::bytes, allow_hyphen_values = true, help_heading = "Limits")]
    pub(crate) max_file_size: Option<u64>,
}
