//! Whole images, as users get them: the release binary as a process of its own, from start to written image.

use std::{
    path::{Path, PathBuf},
    process::Command,
    time::Duration,
};

use rt_accel::AcceleratorKind;

use super::common::{accelerator, print};
use crate::{
    error::TaskError,
    renderer::{Renderer, Usage},
    statistics,
    timings::Spread,
    workspace::{Workspace, output_of, sorted_entries},
};

pub(super) mod convert;
mod exchange_scene;
mod peers;
mod table;

use exchange_scene::Outline;
use table::{RenderResult, RenderResults};

/// A run that takes longer than this has gone wrong.
const TIMEOUT: Duration = Duration::from_secs(600);

#[derive(Debug, clap::Args)]
pub(super) struct RenderOptions {
    /// Render the scene descriptions `*.json` of this directory.
    #[arg(long, value_name = "DIR")]
    folder: PathBuf,
    /// Render only these scenes.
    #[arg(long, value_delimiter = ',')]
    scene: Vec<String>,
    /// Measure each scene this often, after a run that counts rays.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    reps: u32,
    /// Set the number of threads of the renderer.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: u16,
    /// Choose the accelerator [default: chosen by the renderer].
    #[arg(long, value_parser = accelerator())]
    accel: Option<AcceleratorKind>,
}

/// Measures and prints.
pub(super) fn run(workspace: &Workspace, options: &RenderOptions) -> Result<(), TaskError> {
    let program = workspace.build_release_renderer()?;
    let folder = workspace.fresh_folder("bench-render")?;
    let renderer = Renderer::new(program, TIMEOUT);
    let min_bytes = renderer.measure(&folder, &["--version"])?.bytes;
    let mut figures = RenderResults { min_bytes, peers: peers::SOURCE, ..RenderResults::default() };
    for path in descriptions(options)? {
        figures.scenes.push(scene(&renderer, &folder, &path, options)?);
    }
    if figures.scenes.is_empty() {
        let folder = options.folder.display();
        return Err(TaskError::Other(format!("{folder}: contains no selected scene")));
    }
    print(&figures, &figures)
}

/// Selected descriptions of the folder.
fn descriptions(options: &RenderOptions) -> Result<Vec<PathBuf>, TaskError> {
    let wanted = |path: &Path| {
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        path.extension().is_some_and(|extension| extension == "json")
            && (options.scene.is_empty() || options.scene.iter().any(|scene| *scene == name))
    };
    let mut paths = sorted_entries(&options.folder)?;
    paths.retain(|path| wanted(path));
    Ok(paths)
}

fn scene(
    renderer: &Renderer,
    folder: &Path,
    description: &Path,
    options: &RenderOptions,
) -> Result<RenderResult, TaskError> {
    let outline: Outline = exchange_scene::read(description)?;
    let name = outline.name.clone();
    let path = folder.join(format!("{name}.json"));
    convert_elsewhere(description, &path)?;
    let rays = statistics::measure(renderer, folder, &path, &accel(options))?;
    let image = format!("{name}.png");
    let (scene, threads) = (path.to_string_lossy(), options.threads.to_string());
    let runs = |image: &str, more: &[&str]| {
        let common = ["render", &scene, "-o", image, "--quiet", "--threads", &threads];
        let args = [&common, accel(options).as_slice(), more].concat();
        (0..options.reps).map(|_| renderer.measure(folder, &args)).collect::<Result<Vec<_>, _>>()
    };
    let whole = runs(&image, &[])?;
    let small = runs("small.png", &["--size", "8x8", "--spp", "1"])?;
    let spread = |runs: &[Usage], of: fn(&Usage) -> f64| Spread::of(runs.iter().map(of).collect());
    Ok(RenderResult {
        size: (outline.w, outline.h),
        spp: outline.spp,
        threads: options.threads,
        primary_rays: rays.rays.primary.rays,
        shadow_rays: rays.shadow_rays(),
        all_rays: rays.rays.total.rays,
        cpu_seconds: spread(&whole, |usage| usage.cpu_seconds),
        wall_seconds: spread(&whole, |usage| usage.wall_seconds),
        peak_bytes: whole.iter().map(|usage| usage.bytes).max().unwrap_or_default(),
        small_wall_seconds: spread(&small, |usage| usage.wall_seconds),
        fastest_peer: peers::fastest(&name),
        image: folder.join(&image),
        scene: name,
    })
}

/// Converts the description in another process: memory that this process has ever held would count for each process
/// that it starts.
fn convert_elsewhere(description: &Path, scene: &Path) -> Result<(), TaskError> {
    let program = std::env::current_exe().map_err(TaskError::other)?;
    let mut command = Command::new(program);
    output_of(command.args(["bench", "convert"]).arg(description).arg(scene)).map(|_| ())
}

fn accel(options: &RenderOptions) -> Vec<&'static str> {
    options.accel.map_or_else(Vec::new, |kind| vec!["--accel", kind.name()])
}
