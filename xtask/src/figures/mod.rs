//! `figures`: the pictures in the guide of rt-accel, rendered by the real binary, and the plot in the README.
//!
//! Each accelerator has two images: its nodes over a still life of a few spheres, and the cost of rays on the
//! sphereflake. An HTML fragment holds both with their bytes: they are part of the crate and shown without a network.

use std::{fs, path::Path, time::Duration};

use base64::{Engine, engine::general_purpose::STANDARD};
use rt_accel::AcceleratorKind;

use crate::{error::TaskError, renderer::Renderer, scenes, workspace::Workspace};

mod compact;
mod cornell;
mod scene_file;
mod still_life;
mod wires;

const TIMEOUT: Duration = Duration::from_secs(300);
/// Most bytes of a picture.
const LARGEST: usize = 25_000;
/// Spheres of the scene for costs.
const BALLS: usize = 820;

/// Options of `figures`.
#[derive(Debug, clap::Args)]
pub(crate) struct FiguresOptions {
    #[arg(value_enum, default_value = "guide")]
    what: What,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum What {
    /// The pictures in the guide of rt-accel.
    Guide,
    /// Error against run time on the Cornell box, which takes minutes: measure it on a machine that does nothing else.
    Cornell,
}

/// Renders figures and replaces the old ones.
pub(crate) fn run(workspace: &Workspace, options: &FiguresOptions) -> Result<(), TaskError> {
    match options.what {
        What::Guide => guide(workspace),
        What::Cornell => cornell::run(workspace),
    }
}

fn guide(workspace: &Workspace) -> Result<(), TaskError> {
    let renderer = Renderer::new(workspace.build_renderer()?, TIMEOUT);
    let folder = workspace.fresh_folder("figures")?;
    let balls = scenes::balls(BALLS)?;
    let costly = folder.join("balls.ron");
    fs::write(&costly, scene_file::of_balls(&balls)).map_err(TaskError::file(&costly))?;
    for kind in AcceleratorKind::ALL {
        let name = kind.name();
        let scene = folder.join(format!("{name}.ron"));
        fs::write(&scene, scene_file::of_wires(&still_life::wires(*kind)?)).map_err(TaskError::file(&scene))?;
        let parts = picture(&renderer, &folder, &scene, &format!("{name}.png"), &[])?;
        let costs = ["--integrator", "cost", "--accel", name];
        let costs = picture(&renderer, &folder, &costly, &format!("{name}-cost.png"), &costs)?;
        let page = workspace.root.join(format!("crates/rt-accel/src/guide/figures/{name}.html"));
        fs::write(&page, fragment(name, &parts, &costs)).map_err(TaskError::file(&page))?;
        println!("{name}: {} and {} bytes", parts.len(), costs.len());
    }
    Ok(())
}

/// Renders a scene to a small PNG file and returns its bytes.
fn picture(
    renderer: &Renderer,
    folder: &Path,
    scene: &Path,
    name: &str,
    options: &[&str],
) -> Result<Vec<u8>, TaskError> {
    renderer.render(folder, scene, name, options.iter().copied())?.succeeded().map_err(TaskError::Other)?;
    let path = folder.join(name);
    let picture = image::open(&path).map_err(|source| TaskError::Picture { path: path.clone(), source })?;
    let bytes = compact::png(&picture.to_rgb8()).map_err(|source| TaskError::Picture { path: path.clone(), source })?;
    fs::write(&path, &bytes).map_err(TaskError::file(&path))?;
    if bytes.len() > LARGEST {
        return Err(TaskError::Other(format!("{}: {} bytes are too many", path.display(), bytes.len())));
    }
    Ok(bytes)
}

fn fragment(name: &str, parts: &[u8], costs: &[u8]) -> String {
    let image = |what: &str, bytes: &[u8]| {
        let data = STANDARD.encode(bytes);
        format!(
            "<img alt=\"{what}\" title=\"{what}\" width=\"320\" height=\"240\" src=\"data:image/png;base64,{data}\">\n"
        )
    };
    let [parts, costs] =
        [image(&format!("What {name} is made of"), parts), image(&format!("What a ray costs in {name}"), costs)];
    format!("<p>\n{parts}{costs}</p>\n")
}
