//! Cornell box against a reference: error, time, and efficiency 1 / (MSE · seconds), compared with other renderers.

use std::{
    path::{Path, PathBuf},
    time::Duration,
};

use rt_image::{Image, read_image};

use super::common::print;
use crate::{
    error::TaskError,
    renderer::{Renderer, Usage},
    workspace::Workspace,
};

mod peers;
mod reference;
mod table;

use peers::PEERS;
use reference::{Errors, ReferenceImage};
use table::{CornellResult, CornellResults};

const SCENE: &str = "scenes/lecture/cornell.ron";

#[derive(Debug, clap::Args)]
pub(super) struct CornellOptions {
    /// Linear reference image of the scene, of the same size and almost free of noise.
    reference: PathBuf,
    /// Subtract this RMSE of the reference image from the errors.
    #[arg(long, default_value_t = 0.000_361)]
    noise: f64,
    /// Measure at these samples per pixel.
    #[arg(long, value_delimiter = ',', default_value = "16,64,256,1024")]
    spp: Vec<u32>,
    /// Repeat each render with this many seeds.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    seeds: u32,
    /// Choose the sampler.
    #[arg(long, default_value = "sobol")]
    sampler: String,
    /// Split the samples into this many independent passes.
    #[arg(long, default_value_t = 1)]
    passes: u32,
}

/// Measures and prints.
pub(super) fn run(workspace: &Workspace, options: &CornellOptions) -> Result<(), TaskError> {
    let reference = ReferenceImage::new(read(&options.reference)?, options.noise);
    let path = workspace.build_release_renderer()?;
    let folder = workspace.fresh_folder("bench-cornell")?;
    let renderer = Renderer::new(path, Duration::MAX);
    let scene = workspace.root.join(SCENE);
    let mut figures = Vec::new();
    for threads in [Some(1), None] {
        for &spp in &options.spp {
            figures.push(figure((&renderer, &folder), &scene, &reference, options, (threads, spp))?);
        }
    }
    let results = CornellResults {
        processor: crate::processor::processor(),
        sampler: options.sampler.clone(),
        passes: options.passes,
        seeds: options.seeds,
        figures,
        peers: PEERS,
        peers_source: peers::SOURCE,
    };
    print(&results, &results)
}

/// Radiance in single precision, so that no error is that of the file.
const IMAGE: &str = "picture.pfm";

/// Renders with all seeds.
fn figure(
    (renderer, folder): (&Renderer, &Path),
    scene: &Path,
    reference: &ReferenceImage,
    options: &CornellOptions,
    (threads, spp): (Option<u32>, u32),
) -> Result<CornellResult, TaskError> {
    let scene = scene.to_string_lossy();
    let run = |seed: u32| {
        let [spp, seed, passes] = [spp, seed, options.passes].map(|number| number.to_string());
        let mut args = vec!["render", &scene, "-o", IMAGE, "--quiet", "--spp", &spp, "--seed", &seed];
        args.extend(["--sampler", &options.sampler, "--passes", &passes]);
        let threads = threads.map(|threads| threads.to_string());
        args.extend(threads.iter().flat_map(|threads| ["--threads", threads]));
        let used = renderer.measure(folder, &args)?;
        let errors = reference.measure(&read(&folder.join(IMAGE))?);
        let other_size =
            || TaskError::Other(format!("{}: the size differs from that of {SCENE}", options.reference.display()));
        Ok((used, errors.ok_or_else(other_size)?))
    };
    let runs = (1..=options.seeds).map(run).collect::<Result<Vec<(Usage, Errors)>, TaskError>>()?;
    let mean = |of: fn(&(Usage, Errors)) -> f64| runs.iter().map(of).sum::<f64>() / runs.len() as f64;
    let (mse, cpu_seconds) = (mean(|(_, errors)| errors.mse), mean(|(used, _)| used.cpu_seconds));
    Ok(CornellResult {
        threads,
        spp,
        cpu_seconds,
        wall_seconds: mean(|(used, _)| used.wall_seconds),
        rmse: mse.sqrt(),
        relative_mse: mean(|(_, errors)| errors.relative_mse),
        mean_ratio: mean(|(_, errors)| errors.mean_ratio),
        efficiency: 1.0 / (mse * cpu_seconds),
    })
}

fn read(path: &Path) -> Result<Image, TaskError> {
    read_image(path).map_err(TaskError::other)
}
